"""Tests of trade studies: points agree with single analyses and sizings, and files tell it all."""

import io
import json
import re
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
import yaml
from figure_checks import heading
from refusals import refusals

from missions.files.errors import InputError
from missions.flight_path import Circle
from missions.library import load_mission
from sizing.day.light import SolarModel
from sizing.day.metrics import Status
from sizing.library import load_aircraft
from sizing.mass_budget import design_of
from sizing.performance import performance
from sizing.program.objectives import Objective
from sizing.program.size import size_aircraft
from studies.output.gridded import SizingStatus, to_table
from studies.render.tables import Table
from studies.sweeps import plots as sweep_plots
from studies.sweeps.axes import Axis, axis_label, axis_names, parse_axis, points, unit_of
from studies.sweeps.points import SweepConfiguration, simulate_points, with_fixed_variables
from studies.sweeps.results import SweepResult, pareto_front
from studies.sweeps.study import prepare, sweep

AS2 = load_aircraft("atlantiksolar-as2")
DESIGN = load_aircraft("atlantiksolar-design")
JULY = load_mission("rafz-july")
SUMMER = load_mission("central-europe-summer")
WATTS = "power.avionics_w"


def study(aircraft, mission, *texts, **options):
    axes = [parse_axis(text) for text in texts]
    solar = SolarModel(options.pop("model", "CAM"))
    return prepare(aircraft, mission, axes, solar, **options).computed().to_xarray()


@pytest.mark.parametrize(
    ("text", "key", "values"),
    [
        ("wingspan_m=2:3:0.5", "airframe.wingspan_m", (2.0, 2.5, 3.0)),
        ("aircraft.battery.mass_kg=1,4,2", "battery.mass_kg", (1.0, 4.0, 2.0)),
        ("mission.clearness=0.1:0.5:0.1", "mission.clearness", (0.1, 0.2, 0.3, 0.4, 0.5)),
        ("mission.latitude_deg=-10:10:20", "mission.latitude_deg", (-10.0, 10.0)),
        ("power.avionics_w = 6", "power.avionics_w", (6.0,)),
    ],
)
def test_axes_are_read(text, key, values):
    axis = parse_axis(text)
    assert (axis.key, axis.values, axis.is_range) == (key, values, False)


def test_names_and_units_of_axes():
    keys = ["battery.mass_kg", "mission.payload.mass_kg", "mission.latitude_deg"]
    keys.append("power.avionics_w")
    names = axis_names([Axis(key, (1.0,)) for key in keys])
    assert names == ["battery_mass_kg", "payload_mass_kg", "latitude_deg", "power_avionics_w"]
    labels = [axis_label(key) for key in (*keys, "mission.flight_path.radius_m")]
    expected = "battery mass, payload mass, latitude, avionics power, flight path radius"
    assert ", ".join(labels) == expected
    for key, unit in (
        ("airframe.structure.modulus_pa", "Pa"),
        ("battery.specific_energy_wh_per_kg", "W h kg-1"),
        ("mission.wind_m_per_s", "m s-1"),
        ("mission.clearness", "1"),
    ):
        assert unit_of(key) == unit


@pytest.mark.parametrize("sample", ["lhs", "sobol"])
def test_draws_repeat_with_their_seed(sample):
    axes = [parse_axis("wingspan_m=2:10"), parse_axis("battery_mass_kg=1,3")]
    first, again, other = (points(axes, sample, samples=50, seed=seed)[0] for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)
    assert (first >= [2.0, 1.0]).all()
    assert (first <= [10.0, 3.0]).all()
    if sample == "lhs":  # one in every slice
        for column in ((first - [2.0, 1.0]) / [8.0, 2.0]).T:
            assert sorted(np.floor(50 * column).astype(int)) == list(range(50))


def test_grid_points_are_those_of_single_analyses():
    energy = "battery.specific_energy_wh_per_kg"
    texts = "battery_mass_kg=2,4", "mission.clearness=0.7,1", f"{energy}=200,260"
    data = study(DESIGN, SUMMER, *texts)
    axes = ("battery_mass_kg", "clearness", "specific_energy_wh_per_kg")
    assert dict(data.sizes) == dict.fromkeys(axes, 2)
    for mass, clearness, wh_per_kg in product((2, 4), (0.7, 1), (200, 260)):
        keys = {"battery.mass_kg": mass, energy: wh_per_kg}
        craft = load_aircraft("atlantiksolar-design", keys)
        mission = load_mission("central-europe-summer", [f"clearness={clearness}"])
        perf = performance(craft, mission)
        worst = perf.worst_scenario()
        cell = data.sel(dict(zip(axes, (mass, clearness, wh_per_kg), strict=True)))
        # The mass is closed to 1e-13, the cycle to 1e-11 of the battery.
        excess_h, mass_kg = perf.cycle.excess_time_h[worst], design_of(craft, mission).total_mass_kg
        assert float(cell["excess_time"]) == pytest.approx(excess_h, rel=1e-7, abs=1e-8)
        assert float(cell["total_mass"]) == pytest.approx(mass_kg, rel=1e-10)
        assert int(cell["status"]) == int(perf.cycle.status[worst])
        assert float(cell["worst_latitude"]) == perf.day.scenarios.latitude_deg[worst]


def test_measured_aircraft_is_taken_as_it_is_where_its_file_allows_it():
    data = study(AS2, JULY, "battery_mass_kg=2,3", "module_area_m2=1.3,1.9")
    for mass in (2.0, 3.0):
        keys = {"battery.mass_kg": mass, "modules.area_m2": 1.3}
        excess = performance(load_aircraft("atlantiksolar-as2", keys), JULY).cycle.excess_time_h[0]
        cell = data["excess_time"].sel(battery_mass_kg=mass, module_area_m2=1.3).item()
        assert cell == pytest.approx(excess, rel=1e-9)
    assert data["status"].values.tolist()[1] == [Status.perpetual, Status.invalid]
    assert "modules.area_m2: must not exceed the wing area" in str(data["message"].values[1, 1])


def test_modules_cover_a_varied_wing_unless_told_otherwise():
    coverage = 0.85  # of the aircraft file
    data = study(DESIGN, JULY, "wingspan_m=4,8")
    np.testing.assert_allclose(
        data["module_area"], coverage * data["wingspan_m"] ** 2 / 18.5, rtol=1e-12
    )
    assert data.attrs["modules_cover_the_wing"] == 1
    kept = study(DESIGN, JULY, "wingspan_m=4,8", cover=False)
    np.testing.assert_array_equal(kept["module_area"], 1.35)
    varied = study(DESIGN, JULY, "wingspan_m=8", "module_area_m2=1,2")
    np.testing.assert_array_equal(varied["module_area"].values.ravel(), [1.0, 2.0])


def test_what_cannot_be_built_is_infeasible_and_says_why():
    small = study(DESIGN, JULY, "wingspan_m=4,8", cover=False)
    assert small["status"].values.tolist() == [Status.infeasible, Status.perpetual]
    needed = 1.35 / (0.85 * 16.0 / 18.5) - 1.0
    assert f"{100 * needed:.3g} % more wing area" in str(small["message"].values[0])
    assert np.isnan(small["excess_time"].values[0])
    heavy = study(DESIGN, JULY, "airframe.structure.calibration=1,1000", "wingspan_m=8")
    assert "carry its own mass" in str(heavy["message"].values[1, 0])
    windy = study(DESIGN, JULY, "mission.wind_m_per_s=0,15", "battery_mass_kg=3")
    assert "below the wind" in str(windy["message"].values[1, 0])
    told = [
        str(data["violated_requirement"].values.ravel()[i])
        for data, i in ((small, 0), (small, 1), (heavy, 1), (windy, 1))
    ]
    assert told == ["module_coverage", "", "mass_budget", "airspeed_above_wind"]


def test_figure_and_table_tell_the_reason_of_each_point():
    varied = "mission.wind_m_per_s=0,15", "module_area_m2=1,2"
    data = study(DESIGN, JULY, *varied)
    (legend,) = sweep_plots.plot_sweep(data).legends
    words = {text.get_text() for text in legend.get_texts()}
    assert words == {"modules: too large", "wind: above the airspeed"}
    table = next(block for block in SweepResult(data).summary().blocks if isinstance(block, Table))
    assert table.columns[-1].name == "why"
    assert {row[-1] for row in table.rows} == {"", *words}
    line = sweep_plots.plot_sweep(study(DESIGN, JULY, varied[1]))
    (legend,) = (axes.get_legend() for axes in line.axes[:1])
    assert [text.get_text() for text in legend.get_texts()] == ["modules: too large"]
    with pytest.raises(ValueError, match=r"nothing to draw .2 points: modules: too large"):
        sweep_plots.plot_sweep(study(DESIGN, JULY, "module_area_m2=1.9,2"))
    # What is maximised is a column.
    data = study(DESIGN, JULY, "wingspan_m=5,6", resize="max_payload_mass")
    table = next(block for block in SweepResult(data).summary().blocks if isinstance(block, Table))
    column = [column.name for column in table.columns].index("payload_mass")
    assert [row[column] for row in table.rows] == sorted(data["payload_mass"].values)[::-1]


def test_a_path_that_the_wind_forbids_is_infeasible():
    data = study(DESIGN, SUMMER, "mission.wind_m_per_s=2,30", "battery_mass_kg=3", model="FM")
    good, bad = data["status"].values.ravel()
    assert good <= Status.perpetual
    assert bad == Status.infeasible
    assert "flight path: " in str(data["message"].values[1, 0])


def test_a_value_that_is_right_with_another_key_alone_is_varied():
    # The file's highest lift coefficient is 1.4.
    lift, highest = "airframe.aerodynamics.lift_coefficient", "maximum_lift_coefficient"
    texts = f"{lift}=1,1.5", f"airframe.aerodynamics.{highest}=1.4,1.6"
    data = study(DESIGN, JULY, *texts)
    status = data["status"].sel(lift_coefficient=1.5)
    assert int(status.sel(maximum_lift_coefficient=1.4)) == Status.invalid
    assert int(status.sel(maximum_lift_coefficient=1.6)) == Status.perpetual
    for alone in ({"sample": "one-at-a-time"}, {}):
        with pytest.raises(
            InputError, match=r"lift_coefficient: .* must be above lift_coefficient 1.5"
        ):
            study(DESIGN, JULY, *(texts if alone else texts[:1]), **alone)


def test_one_at_a_time_starts_from_the_files():
    texts = "power.avionics_w=4,8", "mission.clearness=0.8:1"
    table = to_table(study(DESIGN, JULY, *texts, sample="one-at-a-time"))
    assert table["varied"].tolist() == ["", *["power_avionics_w"] * 2, *["clearness"] * 2]
    base = performance(DESIGN, JULY).cycle.excess_time_h[0]
    assert table["excess_time"].iloc[0] == pytest.approx(base, rel=1e-7)
    assert table["excess_time"].iloc[4] == pytest.approx(base, rel=1e-7)  # a clearness of 1
    low, high = table["excess_time"].iloc[1:3]
    assert low > base > high


def test_held_variables_keep_their_values_and_others_are_sized():
    data = study(DESIGN, JULY, "wingspan_m=2.5,6", "aspect_ratio=15", resize="max_excess_time")
    status = data["status"].values.ravel().tolist()
    assert status == [SizingStatus.infeasible, SizingStatus.optimal]
    assert float(data["wingspan"][1, 0]) == pytest.approx(6.0, rel=1e-12)
    assert float(data["shortfall"][0, 0]) > 0.0
    assert "short by" in str(data["message"][0, 0].item())
    whole = with_fixed_variables(DESIGN, {"wingspan_m": 6.0, "aspect_ratio": 15.0})
    same = size_aircraft(whole, JULY, Objective.max_excess_time)
    # Two searches for one optimum end within what they call the same, 0.02 % a round.
    assert float(data["excess_time"][1, 0]) == pytest.approx(same.objective_value, rel=1e-3)


@pytest.mark.parametrize(
    ("by", "call", "words"), refusals(Path(__file__).with_name("refusals.txt"))
)
def test_mistakes_are_named_before_the_work(by, call, words):
    options = yaml.safe_load(call)
    vary, plane = options.pop("vary"), AS2 if options.pop("measured", False) else DESIGN
    if by == "texts" and "resize" in options:
        options["resize"] = Objective(options["resize"])
    function, *rest = (study, SUMMER, *vary) if by == "texts" else (sweep, JULY, vary)
    with pytest.raises(ValueError, match=re.escape(words)):
        function(plane, *rest, **options)


def test_front_is_that_of_comparing_all_pairs():
    rng = np.random.default_rng(5)
    # Few distinct values make ties; some points have none.
    x, y = rng.integers(0, 12, (2, 300)).astype(float)
    x[:20] = np.nan
    beaten = ((x <= x[:, None]) & (y <= y[:, None]) & ((x < x[:, None]) | (y < y[:, None]))).any(1)
    np.testing.assert_array_equal(pareto_front(x, y), ~beaten & np.isfinite(x))


@pytest.mark.long
@pytest.mark.parametrize(
    ("texts", "options"),
    [
        (["wingspan_m=3:6:1"], {}),
        (["wingspan_m=3:6:1", "battery_mass_kg=1:4:1"], {"cover": False}),
        (["wingspan_m=3:6:1", "battery_mass_kg=2,3", "aspect_ratio=15,20"], {}),
        (["wingspan_m=3:6", "battery_mass_kg=1:4"], {"sample": "sobol", "samples": 8}),
        (["power.avionics_w=2,9", "battery_mass_kg=1:4"], {"sample": "one-at-a-time"}),
        (["wingspan_m=2.5,6", "battery_mass_kg=1,3"], {"resize": Objective.max_excess_time}),
    ],
)
def test_every_study_has_a_chart_with_units(texts, options):
    data = study(DESIGN, JULY, *texts, **options)
    figure = sweep_plots.plot_sweep(data)
    words = [text for axes in figure.axes for text in (axes.get_xlabel(), axes.get_ylabel())]
    assert any("[h]" in text for text in words)
    words += [text.get_text() for axes in figure.axes for text in axes.get_xticklabels()]
    words.append(heading(figure))
    assert not any("_" in text for text in words)  # labels, never keys
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png")
    assert buffer.getvalue().startswith(b"\x89PNG")


def test_points_without_a_design_are_not_drawn_over():
    data = study(DESIGN, JULY, "wingspan_m=3:8:0.5", "battery_mass_kg=1:5:0.5", cover=False)
    colours = sweep_plots.plot_sweep(data).axes[0].collections[0].get_array()
    drawn = ~np.ma.getmaskarray(colours).reshape(9, 11)
    np.testing.assert_array_equal(drawn, (data["status"] == Status.perpetual).values.T)


def test_command_writes_files_that_hold_everything(run, tmp_path):
    vary = ["--vary", "wingspan_m=4:6:1", "--vary", "battery_mass_kg=2,3"]
    answer = run("sweep", "atlantiksolar-design", *vary, "--out", "s.nc", "--plot", "s.png").good()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["s.nc", "s.png"]
    data = xr.open_dataset(tmp_path / "s.nc", engine="h5netcdf")
    assert data["excess_time"].dims == ("wingspan_m", "battery_mass_kg")
    assert data["wingspan_m"].attrs == {"units": "m", "long_name": "airframe.wingspan_m"}
    assert json.loads(data.attrs["aircraft"])["name"] == "atlantiksolar-design"
    assert json.loads(data.attrs["vary"])["battery.mass_kg"] == [2.0, 3.0]
    assert data.attrs["source"].startswith("solar-uav ")
    assert data["status"].attrs["flag_meanings"].split()[1:3] == ["limited", "perpetual"]
    answer = run("sweep", "atlantiksolar-design", *vary, "--out", "s.csv", "--json").good()
    table = pd.read_csv(tmp_path / "s.csv", comment="#")
    record = answer.json()
    assert table["excess_time"].tolist() == data["excess_time"].values.ravel().tolist()
    assert [p["excess_time"] for p in record["points"]] == table["excess_time"].tolist()
    assert record["status"] == table["status"].value_counts().to_dict()
    with (tmp_path / "s.csv").open() as file:
        assert json.loads(file.readline().removeprefix("# ")) == {
            k: v.item() if isinstance(v, np.generic) else v for k, v in data.attrs.items()
        }


def test_command_draws_a_front(run, tmp_path):
    vary = ["--vary", "battery_mass_kg=2:4:0.5", "--plot", "s.png"]
    run("sweep", "atlantiksolar-design", *vary, "--pareto", "total_mass", "excess_time").good()
    assert (tmp_path / "s.png").exists()
    (tmp_path / "s.png").unlink()
    answer = run("sweep", "atlantiksolar-design", *vary, "--pareto", "mass", "excess_time")
    assert answer.code == 2
    # The varied key comes first; texts and flags are no axes of a chart.
    assert "'mass' is not one of battery_mass_kg, wingspan" in answer.err
    assert "message" not in answer.err
    assert "perpetual" not in answer.err  # refused before a point is flown
    assert not (tmp_path / "s.png").exists()


@pytest.mark.extra
def test_parquet_holds_table_and_configuration(run, tmp_path):
    pytest.importorskip("pyarrow")
    vary = ["--vary", "battery_mass_kg=2,3", "--out", "s.parquet"]
    run("sweep", "atlantiksolar-design", *vary).good()
    table = pd.read_parquet(tmp_path / "s.parquet")
    assert table["battery_mass_kg"].tolist() == [2.0, 3.0]
    assert json.loads(table.attrs["mission"])["name"] == "rafz-july"


def _failing(configuration, cells):
    if any(cell[0] == 3.0 for cell in cells):
        raise FloatingPointError("not today")
    return simulate_points(configuration, cells)


@pytest.mark.long
def test_a_sweep_with_failed_points_says_so_and_ends_with_an_error(run, tmp_path, monkeypatch):
    monkeypatch.setattr("studies.sweeps.study.simulate_points", _failing)
    vary = ["--vary", "battery_mass_kg=2,3,4", "--workers", "1"]
    answer = run("sweep", DESIGN.name, *vary, "--out", "s.nc", "--plot", "s.png", "--json")
    assert answer.code == 1
    first, *_, last = answer.err.splitlines()
    for line in (first, last):
        assert "1 of 3 points failed; the first: FloatingPointError: not today" in line
    assert answer.json()["status"]["failed"] == 1
    data = xr.load_dataset(tmp_path / "s.nc", engine="h5netcdf")
    assert data["status"].values.tolist()[1] == Status.failed
    assert data.attrs["failed_cells"] == "battery_mass_kg 3: FloatingPointError: not today"
    assert "not today" in str(data["message"].values[1])
    figure = sweep_plots.plot_sweep(data)
    assert "1 of 3 points failed" in heading(figure)
    assert [t.get_text() for t in figure.axes[0].get_legend().get_texts()] == [
        "could not be computed"
    ]
    table = run("sweep", "atlantiksolar-design", *vary)
    assert table.code == 1
    assert "1 failed" in " ".join(table.out.split())


def test_contours_hatch_failed_points(monkeypatch):
    monkeypatch.setattr("studies.sweeps.study.simulate_points", _failing)
    vary = {"battery_mass_kg": [2, 3, 4], "power.avionics_w": [4, 6]}
    with pytest.warns(RuntimeWarning, match="2 of 6 points failed"):
        data = sweep(DESIGN, JULY, vary)
    (legend,) = sweep_plots.plot_sweep(data).legends
    assert "could not be computed" in [text.get_text() for text in legend.get_texts()]


@pytest.mark.parametrize("name", ["atlantiksolar-as2", "atlantiksolar-design", "sky-sailor"])
def test_a_point_without_changes_is_what_was_given(name):
    path = Circle(radius_m=100.0, airspeed_m_per_s=9.0)  # its kind is a default
    circling = JULY.model_copy(update={"flight_path": path})
    aircraft = load_aircraft(name)
    for mission in (JULY, SUMMER, load_mission("rafz-loiter"), circling):
        tables = aircraft.texts_read
        made = SweepConfiguration(aircraft, mission, (WATTS,), SolarModel(), None, tables)
        assert made.files({}) == (aircraft, mission)
        assert made.files({WATTS: aircraft.power.avionics_w}) == (aircraft, mission)


def test_steps_that_do_not_meet_their_end_are_told(run):
    answer = run("sweep", "atlantiksolar-design", "--vary", "battery_mass_kg=2:4:0.7", "--json")
    assert answer.code == 0
    assert "--vary battery_mass_kg=2:4:0.7 stops at 3.4, the last step before 4" in answer.err
    answer = run("sweep", "atlantiksolar-design", "--vary", "battery_mass_kg=0.1:0.4:0.1", "--json")
    assert answer.err == ""
