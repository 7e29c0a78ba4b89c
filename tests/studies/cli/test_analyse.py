"""Tests of ``solar-uav analyse``: results, tables and files."""

import numpy as np
import pandas as pd
import pytest
from command_line import FIELD

AS2, DESIGN = "atlantiksolar-as2", "atlantiksolar-design"
ANALYSE_KEYS = {
    *("excess_time_h", "charge_margin_h", "endurance_h", "minimum_state_of_charge", "status"),
    *("sunrise_h", "sunset_h", "equal_power_morning_h", "equal_power_evening_h", "full_charge_h"),
    *("power_out_w", "solar_energy_wh", "model", "correction", "latitude_deg", "day_of_year"),
}


def test_analysis_as_json(run):
    record = run("analyse", AS2, "--json").good().json()
    assert record.keys() >= ANALYSE_KEYS
    assert record["status"] == "perpetual"
    assert (record["model"], record["correction"]) == ("CAM", "none")
    assert (record["latitude_deg"], record["day_of_year"]) == (47.6, 196)
    assert record["endurance_h"] is None
    assert 5.0 < record["excess_time_h"] < 8.0
    assert 0.3 < record["minimum_state_of_charge"] < 0.45
    morning, evening = (f"equal_power_{half}_h" for half in ("morning", "evening"))
    times_h = [record[k] for k in ("sunrise_h", morning, "full_charge_h", evening, "sunset_h")]
    assert (np.diff(times_h) > 0.0).all()
    (scenario,) = record["scenarios"]
    assert {key: record[key] for key in scenario} == scenario


def test_undefined_numbers_are_null(run):
    record = run("analyse", AS2, "--date", "12-21", "--json").json()
    assert (record["status"], record["full_charge_h"]) == ("limited", None)
    assert (record["excess_time_h"] < 0.0, record["endurance_h"] > 10.0) == (True, True)
    assert record["minimum_state_of_charge"] == 0.0
    record = run("analyse", AS2, "--latitude", "85", "--date", "06-21", "--json").json()
    assert record["status"] == "always_lit"
    undefined = ("excess_time_h", "endurance_h", "equal_power_morning_h", "equal_power_evening_h")
    assert [record[key] for key in undefined] == [None] * 4


@pytest.mark.long
@pytest.mark.parametrize(
    ("options", "overrides"),
    [
        (("--latitude", "-30.5"), ("mission.latitude_deg=-30.5",)),
        (("--date", "12-21"), ("mission.dates={on: 12-21}",)),
        (("--day-of-year", "355"), ("mission.dates={on: 12-21}",)),
        (
            ("--latitude", "50", "--date", "03-01"),
            ("mission.latitude_deg=50", "mission.dates={on: 03-01}"),
        ),
    ],
)
@pytest.mark.parametrize("mission", ["rafz-july", "central-europe-summer"])
def test_a_mission_is_moved_in_one_way(run, mission, options, overrides):
    by_option = run("analyse", AS2, "-m", mission, *options, "--json").json()
    set_options = [part for override in overrides for part in ("--set", override)]
    assert by_option == run("analyse", AS2, "-m", mission, *set_options, "--json").json()


@pytest.mark.long
@pytest.mark.parametrize(
    "command",
    [
        ("analyse", AS2),
        ("compare", "sky-sailor", "--no-design", "--models", "CAM", "--corrections", "none"),
        ("ceiling", "sky-sailor", "--highest", "1000"),
        ("map", AS2, "--latitudes", "40:45:5", "--days", "100:200:100", "--workers", "1"),
        ("sweep", DESIGN, "--vary", "battery_mass_kg=2,3", "--workers", "1"),
    ],
    ids=lambda command: command[0],
)
def test_every_result_says_whose_it_is(run, command):
    outcome = run(*command).good()
    first, *others = outcome.out.splitlines()
    assert first.startswith(f"{command[1]} on rafz-july (default mission)")
    assert not [line for line in others if command[1] in line and "rafz-july" in line]
    told = run(*command, "-m", "rafz-july", "--json").json()
    assert told == told | {
        "aircraft": command[1],
        "mission": "rafz-july",
        "mission_is_default": False,
    }
    assert run(*command, "--json").json() == {**told, "mission_is_default": True}
    named = run(*command, "-m", "rafz-july")
    assert named.out.startswith(f"{command[1]} on rafz-july")
    assert "default" not in named.out.splitlines()[0]


def test_a_polar_night_among_other_days(run):
    band = "mission.latitude_deg={from_deg: 50, to_deg: 80}"
    days = "mission.dates={from: 12-01, to: 12-31}"
    outcome = run("analyse", AS2, "--set", band, "--set", days, "--json").good()
    assert {s["latitude_deg"] for s in outcome.json()["scenarios"] if not s["sunrise_h"]} == {80.0}


def test_launch_is_replayed_unless_place_or_day_are_moved(run, tmp_path):
    (tmp_path / "field.yaml").write_text(FIELD)
    drawn = run("analyse", AS2, "-m", "field.yaml", "--plot", "flight.png", "--json")
    assert (tmp_path / "flight.png").read_bytes().startswith(b"\x89PNG")
    flight = drawn.json()["flight"]
    assert flight["launch"] == "07-14 09:30"
    assert flight["duration_h"] == pytest.approx(30.0)
    moved = run("analyse", AS2, "-m", "field.yaml", "--date", "07-16", "--json").json()
    assert "flight" not in moved


def test_trajectory_as_csv(run, tmp_path):
    assert run("analyse", AS2, "--csv", "cycle.csv").code == 0
    table = pd.read_csv(tmp_path / "cycle.csv")
    columns = "latitude_deg day_of_year time_solar_h solar_power_w load_w energy_wh state_of_charge"
    assert list(table) == columns.split()
    assert (table["time_solar_h"].iloc[0], table["time_solar_h"].iloc[-1]) == (0.0, 24.0)
    assert table["time_solar_h"].is_monotonic_increasing
    assert table["state_of_charge"].between(0.0, 1.0).all()
    assert not table.isna().any(axis=None)


@pytest.mark.long
@pytest.mark.parametrize("aircraft", [AS2, DESIGN])
@pytest.mark.parametrize(
    "overrides",
    [
        ["battery.mass_kg=1e-6"],
        ["battery.specific_energy_wh_per_kg=6443", "battery.mass_kg=1e5"],
        ["modules.area_m2=0", "power.avionics_w=0"],
        ["modules.area_m2=0", "airframe.wingspan_m=1e-3"],
        ["mission.payload.mass_kg=1e6"],
        ["mission.turbulence={all_day: 5, thermal: 5}"],
        ["mission.altitude_m=32000"],
        ["mission.clearness=1e-3"],
        [
            "battery.charge_limit={kind: table, state_of_charge: [0, 1], current_a: [1, 1], "
            "voltage_v: 25, pack_energy_wh: 732}"
        ],
    ],
)
def test_extreme_values_end_in_valid_json(run, aircraft, overrides):
    options = [part for override in overrides for part in ("--set", override)]
    outcome = run("analyse", aircraft, *options, "--json")
    assert outcome.code in (0, 1)
    assert outcome.err == "" or outcome.code == 1
    if outcome.code == 0:
        assert outcome.json().keys() >= ANALYSE_KEYS


@pytest.mark.long
def test_every_shipped_aircraft_flies_every_shipped_mission(run):
    shipped = run("list", "--json").json()
    for aircraft in shipped["aircraft"]:
        for mission in shipped["mission"]:
            outcome = run("analyse", aircraft, "-m", mission, "--json")
            if outcome.code == 1:  # a power train of low altitudes at 20 km
                assert mission == "stratosphere-mission"
                assert "cannot do level flight" in outcome.err
                continue
            assert (outcome.code, outcome.err) == (0, "")
            assert outcome.json().keys() >= ANALYSE_KEYS
