"""Every command tells once what lies outside the range of a model, and nothing where all is in."""

import pytest
from builders import AS2, SKY_SAILOR, aircraft, mission
from figure_checks import heading

import studies
from sizing.day.light import SolarModel
from sizing.day.replay import calendar_run
from sizing.results.analysis import analyse
from sizing.validity.extrapolations import replay_extrapolations
from studies.ceiling import perpetual_ceiling, plot_ceiling
from studies.maps.plots import plot_map
from studies.output.cycle_plots import plot_cycle
from studies.output.gridded import extrapolations_of
from studies.sweeps.plots import plot_sweep

HEAD = "outside the range of a model:"
WIND = ("--set", "mission.wind_m_per_s=50", "--set", "mission.flight_path=null")
TWO = ("--models", "CDM,CAM", "--corrections", "none")
CELLS = ("--latitudes", "40:50:10", "--days", "150:200:50")


@pytest.mark.long
@pytest.mark.parametrize(
    ("command", "count"),
    [
        (("analyse", "atlantiksolar-as2", *WIND), ""),
        (("map", "atlantiksolar-as2", *CELLS, *WIND), " (worst; 4 of 4 cells)"),
        (("ceiling", "atlantiksolar-as2", "--step", "5000", *WIND), " (worst; 3 of 3 altitudes)"),
        (("sweep", "atlantiksolar-as2", "--vary", "battery_mass_kg=2,3", *WIND), "2 of 2 points)"),
        (("compare", "atlantiksolar-as2", *TWO, *WIND), " (worst; 2 of 2 cases)"),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else "",
)
def test_commands_tell_of_the_wind_once(run, command, count):
    told = run(*command, "-v").good()
    text = " ".join(told.out.split())
    assert text.count(HEAD) == 1
    assert text.count("range of flight that holds its place in the wind, from 50 m/s") == 1
    assert count in text
    found = run(*command, "--json").json()["extrapolations"]
    assert "wind" in [one["model"] for one in found]
    calm = tuple(word for word in command if word not in WIND)
    if command[0] != "ceiling":  # up there the clear sky ends
        assert HEAD not in run(*calm, "-v").out
        assert run(*calm, "--json").json()["extrapolations"] == []


@pytest.mark.long
def test_sizings_tell_of_their_designs(run):
    asked = ("atlantiksolar-design", "--set", "design_space.wingspan_m={minimum: 9, maximum: 12}")
    one = run("size", *asked, "--mission", "rafz-july", "--out", "sized", "-v").out
    assert one.count(HEAD) == one.count("outside the range of rib wing, 3 to 8 m") == 1
    cells = " ".join(run("map", *asked, *CELLS, "--resize", "min_mass", "-v").out.split())
    assert "wingspan 9 m (worst; 4 of 4 cells): outside the range of rib wing, 3 to 8 m" in cells
    swept = run("sweep", *asked, "--vary", "power.avionics_w=4,6", "--resize", "min_mass", "--json")
    record = swept.json()
    outside = [e["quantity"] for e in record["extrapolations"]]
    assert outside == ["wingspan_m", "structure_mass_ratio"]
    assert all(p["extrapolations"].startswith("rib_wing: wingspan_m 9") for p in record["points"])
    again = run("analyse", "sized", "-v")
    assert again.out.count("outside the range of rib wing, 3 to 8 m") == 1


def test_a_map_tells_of_the_cells_with_too_fast_a_charge():
    small = aircraft("sky-sailor", "battery.mass_kg=0.3")
    data = studies.feasibility_map(small, mission(), latitudes=[-60.0, 45.0], days=[172])
    found = {one.quantity: one for one in extrapolations_of(data)}
    one = found["charge_rate_per_h"]
    assert (one.count, one.of) == (1, 2)
    assert one.value == pytest.approx(float(data["charge_rate"].max()))
    inside = studies.feasibility_map(SKY_SAILOR, mission(), latitudes=[45.0], days=[172])
    assert "extrapolations" not in inside.attrs


def test_figures_name_what_is_outside_in_a_line_of_their_title():
    where, line = mission(wind_m_per_s=50.0), "extrapolated: airspeed"
    ceiling = perpetual_ceiling(AS2, where, highest_m=2000.0, step_m=1000.0)
    figures = [
        plot_cycle(analyse(AS2, where)),
        plot_map(studies.feasibility_map(AS2, where, latitudes=[40.0, 50.0], days=[150, 200])),
        plot_sweep(studies.sweep(AS2, where, {"battery_mass_kg": [2.0, 3.0]})),
        plot_ceiling(ceiling),
    ]
    for figure in figures:
        assert heading(figure).splitlines()[-1].endswith(f" · {line}")
    assert line not in heading(plot_cycle(analyse(AS2, mission())))


def test_a_replayed_flight_tells_of_its_own_days():
    launch = {"date": "07-15", "time_local": "10:00", "utc_offset_h": 2.0, "duration_h": 24.0}
    where = mission(longitude_deg=8.5, latitude_deg=20.0, launch=launch)
    run, corrected = calendar_run(AS2, where), SolarModel("CAM", "report")
    assert replay_extrapolations(AS2, where, SolarModel(), run) == ()
    (outside,) = replay_extrapolations(AS2, where, corrected, run)
    assert outside.quantity == "noon_elevation_deg"
