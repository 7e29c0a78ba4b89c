"""Tests of the command line: results, files, messages and exit codes."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
import pytest

from studies import cli

AS2, DESIGN = "atlantiksolar-as2", "atlantiksolar-design"

ANALYSE_KEYS = {
    "excess_time_h",
    "charge_margin_h",
    "endurance_h",
    "minimum_state_of_charge",
    "status",
    "sunrise_h",
    "sunset_h",
    "equal_power_morning_h",
    "equal_power_evening_h",
    "full_charge_h",
    "power_out_w",
    "solar_energy_wh",
    "model",
    "correction",
    "latitude_deg",
    "day_of_year",
}
SIZE_KEYS = {
    "wingspan_m",
    "battery_mass_kg",
    "module_area_m2",
    "aspect_ratio",
    "total_mass_kg",
    "masses_kg",
    "power_out_w",
    "objective",
    "worst_scenario",
    "active_constraints",
    "status",
    "simulated",
    "solver",
}
SIZED_FILES = {
    "aircraft.yaml",
    "result.json",
    "scenarios.csv",
    "masses.csv",
    "cycle.png",
    "masses.png",
}
COMMANDS = ("analyse", "size", "list", "init", "validate", "published")

BIRD = """\
name: bird
airframe:
  kind: measured
  wingspan_m: 5.65
  aspect_ratio: 18.5
  mass_without_battery_kg: 4.0
  level_flight:
    electric_power_w: 35.8
    mass_kg: 6.92
    density_kg_per_m3: 1.10
modules:
  area_m2: 1.35
  efficiency_stc: 0.237
battery:
  mass_kg: 2.918
  specific_energy_wh_per_kg: 251
  charge_limit:
    kind: table
    state_of_charge: [0.8, 0.9, 1.0]
    current_a: [10, 5, 1]
    voltage_v: 25
    pack_energy_wh: 732
power:
  avionics_w: 6.0
"""

FIELD = """\
name: field
latitude_deg: 47.6
longitude_deg: 8.5
dates:
  on: 07-15
altitude_m: 500
air:
  ambient_temperature_c: 20.0
clearness: 1.0
turbulence:
  thermal: 0.0
launch:
  date: 07-14
  time_local: 09:30
  utc_offset_h: 2
  duration_h: 30
"""


class Outcome(NamedTuple):
    code: int
    out: str
    err: str

    def json(self) -> Any:
        """Standard output as strict JSON: NaN and Infinity are refused."""

        def refuse(constant: str) -> None:
            raise AssertionError(f"{constant} is not JSON")

        return json.loads(self.out, parse_constant=refuse)


Run = Callable[..., Outcome]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Run:
    """Run the command in an empty folder; nothing but an exit may leave it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")

    def call(*arguments: str) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["solar-uav", *arguments])
        capfd.readouterr()
        with pytest.raises(SystemExit) as ended:
            cli.main()
        out, err = capfd.readouterr()
        code = ended.value.code
        assert code is None or isinstance(code, int)
        return Outcome(code or 0, out, err)

    return call


def edited(text: str, old: str, new: str) -> str:
    assert text.count(old) == 1, old
    return text.replace(old, new)


def files(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


# ---- analyse --------------------------------------------------------------------------


def test_analysis_as_json(run: Run) -> None:
    outcome = run("analyse", AS2, "--json")
    assert (outcome.code, outcome.err) == (0, "")
    record = outcome.json()
    assert record.keys() >= ANALYSE_KEYS
    assert record["status"] == "perpetual"
    assert (record["model"], record["correction"]) == ("CAM", "none")
    assert (record["latitude_deg"], record["day_of_year"]) == (47.6, 196)
    assert record["endurance_h"] is None
    assert 5.0 < record["excess_time_h"] < 8.0
    assert 0.3 < record["minimum_state_of_charge"] < 0.45
    assert (
        record["sunrise_h"]
        < record["equal_power_morning_h"]
        < record["full_charge_h"]
        < record["equal_power_evening_h"]
        < record["sunset_h"]
    )
    (scenario,) = record["scenarios"]
    assert {key: record[key] for key in scenario} == scenario


def test_limited_flight_has_an_endurance_and_no_full_charge(run: Run) -> None:
    record = run("analyse", AS2, "--date", "12-21", "--json").json()
    assert record["status"] == "limited"
    assert record["excess_time_h"] < 0.0
    assert record["endurance_h"] > 10.0
    assert record["minimum_state_of_charge"] == 0.0
    assert record["full_charge_h"] is None


def test_midnight_sun_leaves_undefined_numbers_null(run: Run) -> None:
    record = run("analyse", AS2, "--latitude", "85", "--date", "06-21", "--json").json()
    assert record["status"] == "always_lit"
    undefined = ("excess_time_h", "endurance_h", "equal_power_morning_h", "equal_power_evening_h")
    assert [record[key] for key in undefined] == [None] * 4


def test_top_level_is_the_worst_of_many_scenarios(run: Run) -> None:
    record = run("analyse", AS2, "-m", "central-europe-summer", "--json").json()
    assert len(record["scenarios"]) == 9
    assert record["excess_time_h"] == min(s["excess_time_h"] for s in record["scenarios"])


def test_analysis_as_table(run: Run) -> None:
    outcome = run("analyse", AS2, "-m", "central-europe-summer")
    assert (outcome.code, outcome.err) == (0, "")
    for words in ("worst scenario", "perpetual", "excess time", "CAM, correction: none"):
        assert words in outcome.out


def test_place_and_day_can_be_chosen(run: Run) -> None:
    by_date = run("analyse", AS2, "--latitude", "-30.5", "--date", "12-21", "--json").json()
    by_day = run("analyse", AS2, "--latitude", "-30.5", "--day-of-year", "355", "--json").json()
    assert by_date == by_day
    assert (by_day["latitude_deg"], by_day["day_of_year"]) == (-30.5, 355)


def test_model_and_correction_can_be_chosen(run: Run) -> None:
    cdm = run("analyse", AS2, "--model", "CDM", "--json").json()
    corrected = run("analyse", AS2, "--correction", "report", "--json").json()
    plain = run("analyse", AS2, "--json").json()
    assert cdm["solar_energy_wh"] > plain["solar_energy_wh"] > corrected["solar_energy_wh"]
    assert (cdm["model"], corrected["correction"]) == ("CDM", "report")


@pytest.mark.parametrize(
    ("override", "key", "larger"),
    [
        ("power.avionics_w=12", "power_out_w", True),
        ("aircraft.power.avionics_w=12", "power_out_w", True),
        ("battery.mass_kg=2", "total_mass_kg", False),
        ("battery={mass_kg: 2, specific_energy_wh_per_kg: 251}", "total_mass_kg", False),
        ("battery.charge_limit.current_a.12=0.1", "charge_margin_h", False),
        ("mission.clearness=0.7", "solar_energy_wh", False),
        ("mission.payload.power_w=3", "power_out_w", True),
        ("mission.dates={on: 06-21}", "solar_energy_wh", True),
    ],
)
def test_overrides_change_the_result(run: Run, override: str, key: str, larger: bool) -> None:
    before = run("analyse", AS2, "--json").json()
    outcome = run("analyse", AS2, "--set", override, "--json")
    assert (outcome.code, outcome.err) == (0, "")
    assert (outcome.json()[key] > before[key]) is larger


def test_launch_is_replayed_unless_place_or_day_are_moved(run: Run, tmp_path: Path) -> None:
    (tmp_path / "field.yaml").write_text(FIELD)
    flight = run("analyse", AS2, "-m", "field.yaml", "--json").json()["flight"]
    assert flight["launch"] == "07-14 09:30"
    assert flight["duration_h"] == pytest.approx(30.0)
    moved = run("analyse", AS2, "-m", "field.yaml", "--date", "07-16", "--json").json()
    assert "flight" not in moved


def test_trajectory_as_csv(run: Run, tmp_path: Path) -> None:
    assert run("analyse", AS2, "--csv", "cycle.csv").code == 0
    table = pd.read_csv(tmp_path / "cycle.csv")
    columns = "latitude_deg day_of_year time_solar_h solar_power_w load_w energy_wh state_of_charge"
    assert list(table) == columns.split()
    assert (table["time_solar_h"].iloc[0], table["time_solar_h"].iloc[-1]) == (0.0, 24.0)
    assert table["time_solar_h"].is_monotonic_increasing
    assert table["state_of_charge"].between(0.0, 1.0).all()
    assert not table.isna().any(axis=None)


@pytest.mark.parametrize(
    ("name", "signature"),
    [("a.png", b"\x89PNG\r\n\x1a\n"), ("a.PDF", b"%PDF-"), ("a.svg", b"<?xml")],
)
def test_figures(run: Run, tmp_path: Path, name: str, signature: bytes) -> None:
    outcome = run("analyse", AS2, "--plot", name)
    assert (outcome.code, outcome.err) == (0, "")
    assert (tmp_path / name).read_bytes().startswith(signature)
    assert files(tmp_path) == {name}


def test_figure_of_a_replayed_flight(run: Run, tmp_path: Path) -> None:
    (tmp_path / "field.yaml").write_text(FIELD)
    assert run("analyse", AS2, "-m", "field.yaml", "--plot", "flight.png").code == 0
    assert (tmp_path / "flight.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("aircraft", [AS2, DESIGN])
@pytest.mark.parametrize(
    "overrides",
    [
        ["battery.mass_kg=1e-6"],
        ["battery.specific_energy_wh_per_kg=1e9"],
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
def test_extreme_values_end_in_valid_json(run: Run, aircraft: str, overrides: list[str]) -> None:
    options = [part for override in overrides for part in ("--set", override)]
    outcome = run("analyse", aircraft, *options, "--json")
    assert outcome.code in (0, 1)
    assert outcome.err == "" or outcome.code == 1
    if outcome.code == 0:
        assert outcome.json().keys() >= ANALYSE_KEYS


# ---- wrong files ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        # unknown, missing and duplicate keys
        ("  mass_kg: 2.918", "  mass_kgs: 2.918", ":15:3: battery.mass_kgs: unknown key; did you mean 'mass_kg'?"),  # noqa: E501
        ("  mass_kg: 2.918", "  mas_kg: 2.918", ":14:1: battery.mass_kg: required key is missing"),
        ("power:\n", "colour: red\npower:\n", ":23:1: colour: unknown key; allowed keys: name, description, airframe, modules, battery, power, design_space"),  # noqa: E501
        ("  mass_kg: 2.918", "  mass_kg: 2.918\n  mass_kg: 3", ":16:3: battery.mass_kg: duplicate key (first at line 15)"),  # noqa: E501
        ("kind: measured", "kind: masured", ":3:9: airframe.kind: must be one of 'measured', 'parametric' (got 'masured')"),  # noqa: E501
        ("  kind: measured\n", "", ":2:1: airframe.kind: required key is missing; it must be one of 'measured', 'parametric'"),  # noqa: E501
        # wrong types
        ("avionics_w: 6.0", "avionics_w: six", ":24:15: power.avionics_w: must be a number (got 'six')"),  # noqa: E501
        ("avionics_w: 6.0", "avionics_w: 6 W", "(got '6 W'); write the plain number; the unit is in the key"),  # noqa: E501
        ("avionics_w: 6.0", "avionics_w: true", ":24:15: power.avionics_w: must be a number (got true)"),  # noqa: E501
        ("avionics_w: 6.0", "avionics_w:", "power.avionics_w: must be a number (got null)"),
        ("avionics_w: 6.0", "avionics_w: [6]", "power.avionics_w: must be a number (got a list of 1)"),  # noqa: E501
        ("name: bird", "name: 12", ":1:7: name: must be text (got 12); put it in quotes"),
        ("name: bird", 'name: ""', ":1:7: name: must not be empty"),
        # wrong numbers
        ("avionics_w: 6.0", "avionics_w: -6", ":24:15: power.avionics_w: must be at least 0 (got -6)"),  # noqa: E501
        ("avionics_w: 6.0", "avionics_w: .nan", ":24:15: power.avionics_w: must be a finite number (got .nan)"),  # noqa: E501
        ("avionics_w: 6.0", "avionics_w: .inf", ":24:15: power.avionics_w: must be a finite number (got .inf)"),  # noqa: E501
        ("avionics_w: 6.0", "avionics_w: 1e999", "power.avionics_w: must be a finite number"),
        ("avionics_w: 6.0", "avionics_w: " + 5000 * "9", "power.avionics_w: must be a finite number"),  # noqa: E501
        ("  mass_kg: 2.918", "  mass_kg: 0", ":15:12: battery.mass_kg: must be greater than 0 (got 0)"),  # noqa: E501
        ("efficiency_stc: 0.237", "efficiency_stc: 23.7", ":13:19: modules.efficiency_stc: must be at most 1 (got 23.7)"),  # noqa: E501
        ("area_m2: 1.35", "area_m2: 13.5", ":12:12: modules.area_m2: must not exceed the wing area of 1.73 m2 (got 13.5)"),  # noqa: E501
        ("[10, 5, 1]", "[10, 5]", "battery.charge_limit: state_of_charge and current_a must have the same length"),  # noqa: E501
        ("[0.8, 0.9, 1.0]", "[0.9, 0.8, 1.0]", "battery.charge_limit: state_of_charge must increase strictly"),  # noqa: E501
        # what YAML allows and a description must not hold
        ("name: bird", "name: !!python/object/apply:os.getcwd []", ":1:7: name: explicit tags (!!python/object/apply:os.getcwd) are not allowed"),  # noqa: E501
        ("power:\n", "<<: {a: 1}\npower:\n", ":23:1: merge keys (<<) are not allowed"),
        ("name: bird", "? [a]\n: b", "a key must be text (got a list)"),
        ("name: bird", "--- {}\n---\nname: bird", "only one document (---) is allowed per file"),
        ("name: bird", "name: " + 60 * "[" + 60 * "]", "nested too deeply (at most 40 levels)"),
        ("name: bird", "name: [", "is not valid YAML"),
        ("  avionics_w", "\tavionics_w", ":24:1: is not valid YAML"),
        ("name: bird", "name: bi\0rd", ":1:9: character U+0000 is not allowed"),
    ],
)  # fmt: skip
def test_wrong_aircraft(run: Run, tmp_path: Path, old: str, new: str, said: str) -> None:
    (tmp_path / "bird.yaml").write_text(edited(BIRD, old, new))
    outcome = run("analyse", "bird.yaml", "--json")
    assert (outcome.code, outcome.out) == (2, "")
    assert any("bird.yaml" in line and said in line for line in outcome.err.splitlines())
    assert all(line.startswith("bird.yaml") for line in outcome.err.splitlines())


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("on: 07-15", "on: 02-29", ":5:7: dates.on: month 02 has days 01 to 28 (got '02-29')"),
        ("on: 07-15", "on: 13-01", ":5:7: dates.on: the month must be 01 to 12 (got '13-01')"),
        ("on: 07-15", "on: 2015-07-15", "dates.on: must be a date MM-DD, for instance 07-15"),
        ("on: 07-15", "on: 715", "dates.on: must be a date MM-DD, for instance 07-15 (got 715)"),
        ("dates:\n  on: 07-15", "dates: {}", ":4:1: dates: empty date range: give"),
        ("on: 07-15", "from: 07-15", ":4:1: dates: empty date range: give"),
        ("on: 07-15", "on: 07-15\n  to: 07-20", ":4:1: dates: give either"),
        ("on: 07-15", "from: 07-15\n  to: 08-01\n  count: 0", ":7:10: dates.count: must be at least 1 (got 0)"),  # noqa: E501
        ("on: 07-15", "from: 07-15\n  to: 08-01\n  count: 366", ":7:10: dates.count: must be at most 365 (got 366)"),  # noqa: E501
        ("latitude_deg: 47.6", "latitude_deg: 95", ":2:15: latitude_deg: must be at most 90"),
        ("latitude_deg: 47.6", "latitude_deg: .nan", "latitude_deg: must be a finite number"),
        ("latitude_deg: 47.6", "latitude_deg: {from_deg: 45, to_deg: 95}", ":2:38: latitude_deg.to_deg: must be at most 90 (got 95)"),  # noqa: E501
        ("latitude_deg: 47.6", "latitude_deg: {from_deg: 45, to_deg: 45}", "latitude_deg: from_deg and to_deg must differ"),  # noqa: E501
        ("latitude_deg: 47.6", "latitude_deg: {from_deg: 45, to_deg: 50}", "latitude_deg: a launch needs a single latitude"),  # noqa: E501
        ("latitude_deg: 47.6", "latitude_deg: -80", ":2:15: latitude_deg: polar night: the sun never rises at 80 S, 15 Jul"),  # noqa: E501
        ("longitude_deg: 8.5\n", "", "launch: a launch by clock time needs longitude_deg"),
        ("clearness", "cleerness", ":9:1: cleerness: unknown key; did you mean 'clearness'?"),
        ("clearness: 1.0", "clearness: 0", ":9:12: clearness: must be greater than 0 (got 0)"),
        ("thermal: 0.0", "thermal: 6", ":11:12: turbulence.thermal: must be at most 5 (got 6)"),
        ("altitude_m: 500", "altitude_m: 1e6", ":6:13: altitude_m: must be at most 32000"),
        ("clearness: 1.0", "clearness: 1.0\nwind_m_per_s: -1", "wind_m_per_s: must be at least 0"),
        ("  ambient_temperature_c: 20.0", "  ambient_temperature_c: 20.0\n  temperature_offset_k: 1", ":7:1: air: give temperature_offset_k or ambient_temperature_c, not both"),  # noqa: E501
        ("time_local: 09:30", "time_local: 25:00", ":14:15: launch.time_local: must be a time HH:MM"),  # noqa: E501
        ("duration_h: 30", "duration_h: 9000", "launch.duration_h: must be at most 8784 (got 9000)"),  # noqa: E501
    ],
)  # fmt: skip
def test_wrong_mission(run: Run, tmp_path: Path, old: str, new: str, said: str) -> None:
    (tmp_path / "field.yaml").write_text(edited(FIELD, old, new))
    outcome = run("size", DESIGN, "--mission", "field.yaml")
    assert (outcome.code, outcome.out) == (2, "")
    assert any(line.startswith("field.yaml:") and said in line for line in outcome.err.split("\n"))


def test_alias_bomb_is_refused(run: Run, tmp_path: Path) -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join(8 * [f'*a{i - 1}'])}]" for i in range(1, 7)]
    (tmp_path / "bomb.yaml").write_text("\n".join(lines))
    outcome = run("analyse", "bomb.yaml")
    assert outcome.code == 2
    assert re.fullmatch(r"bomb\.yaml:\d+:\d+: .*too many \S*.*\n", outcome.err)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "the file is empty; it must hold a mapping (key: value)"),
        (b"# only a comment\n", "the file is empty"),
        (b"hello\n", ":1:1: the top level must be a mapping"),
        (b"- a\n", ":1:1: the top level must be a mapping (key: value), not a list"),
        (bytes(range(128, 256)), ":1:1: is not UTF-8 text (byte 0x80)"),
        (b"name: caf\xe9\n", ":1:10: is not UTF-8 text (byte 0xe9)"),
        (b"name: x #" + 1_000_001 * b"x", "is too large (at most 1 MB)"),
    ],
)
def test_what_is_no_description(run: Run, tmp_path: Path, content: bytes, said: str) -> None:
    (tmp_path / "odd.yaml").write_bytes(content)
    for arguments in (("analyse", "odd.yaml"), ("validate", "odd.yaml")):
        outcome = run(*arguments)
        assert (outcome.code, outcome.out) == (2, "")
        assert outcome.err.startswith("odd.yaml:")
        assert said in outcome.err
        assert outcome.err.count("\n") == 1


def test_byte_order_mark_and_line_ends_of_windows_are_read(run: Run, tmp_path: Path) -> None:
    (tmp_path / "bird.yaml").write_bytes(("\ufeff" + BIRD.replace("\n", "\r\n")).encode())
    assert run("validate", "bird.yaml").code == 0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("analyse", "missing.yaml"), "missing.yaml: there is no such file"),
        (("analyse", "atlantiksolar-as3"), f"did you mean '{AS2}'?"),
        (("analyse", "rafz-july"), "no shipped aircraft of that name"),
        (("analyse", AS2, "-m", AS2), "no shipped mission of that name"),
        (("analyse", "."), ".: is a folder, not a file"),
        (("size", DESIGN, "-m", "."), ".: is a folder, not a file"),
        (("validate", "missing.yaml"), "missing.yaml: no such file"),
        (("size", AS2, "-m", "rafz-july"), "airframe.kind: a measured aircraft cannot be sized"),
    ],
)
def test_what_cannot_be_found_or_used(run: Run, arguments: tuple[str, ...], said: str) -> None:
    outcome = run(*arguments)
    assert (outcome.code, outcome.out) == (2, "")
    assert said in outcome.err
    assert outcome.err.count("\n") == 1


@pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may read every file"
)
def test_unreadable_file(run: Run, tmp_path: Path) -> None:
    (tmp_path / "bird.yaml").write_text(BIRD)
    (tmp_path / "bird.yaml").chmod(0)
    outcome = run("analyse", "bird.yaml")
    assert outcome == (2, "", "bird.yaml: cannot be read: permission denied\n")


def test_mission_for_aircraft_and_the_reverse(run: Run, tmp_path: Path) -> None:
    (tmp_path / "bird.yaml").write_text(BIRD)
    (tmp_path / "field.yaml").write_text(FIELD)
    outcome = run("analyse", "field.yaml", "-m", "bird.yaml")
    assert (outcome.code, outcome.out) == (2, "")
    assert "field.yaml:1:1: airframe: required key is missing" in outcome.err
    assert "bird.yaml:1:1: latitude_deg: required key is missing" in outcome.err


def test_all_problems_of_both_files_are_reported_together(run: Run, tmp_path: Path) -> None:
    bird = edited(edited(BIRD, "avionics_w: 6.0", "avionics_w: -6"), "area_m2: 1.35", "area_m2: x")
    (tmp_path / "bird.yaml").write_text(bird)
    (tmp_path / "field.yaml").write_text(edited(FIELD, "on: 07-15", "on: 02-30"))
    outcome = run("analyse", "bird.yaml", "-m", "field.yaml", "--json")
    assert (outcome.code, outcome.out) == (2, "")
    assert sorted(line.split(": ")[1] for line in outcome.err.splitlines()) == [
        "dates.on",
        "modules.area_m2",
        "power.avionics_w",
    ]


# ---- wrong options --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("nonsense", "--set nonsense: write an override as KEY=VALUE, for example a.b=2.5"),
        ("", "write an override as KEY=VALUE"),
        ("=1", "write an override as KEY=VALUE"),
        ("battery..mass_kg=1", "write an override as KEY=VALUE"),
        ("colour=red", "--set colour: unknown key; allowed keys: name"),
        ("battery.mas_kg=1", "--set battery.mas_kg: unknown key; did you mean 'mass_kg'?"),
        ("battery.mass_kg=abc", "--set battery.mass_kg: must be a number (got 'abc')"),
        ("battery.mass_kg='3'", "--set battery.mass_kg: must be a number (got '3')"),
        ("battery.mass_kg=", "--set battery.mass_kg: no value after the = sign"),
        ("battery.mass_kg=.nan", "--set battery.mass_kg: must be a finite number"),
        ("battery.mass_kg=0", "--set battery.mass_kg: must be greater than 0 (got 0)"),
        ("battery.mass_kg.x=1", "battery.mass_kg is the single value 2.918 and has no keys"),
        ("battery=1", "--set battery: must be a mapping of keys and values (got 1)"),
        ("battery.mass_kg=[1", "--set battery.mass_kg: "),
        ("battery.charge_limit.current_a.99=1", "takes an index from 0 to 12 (got '99')"),
        ("mission.latitude_deg=95", "latitude_deg: must be at most 90"),
        ("mission.dates.on=02-29", "dates.on: month 02 has days 01 to 28 (got '02-29')"),
        (
            "mission.colour=red",
            "colour: unknown key; allowed keys: name, description, latitude_deg",
        ),
    ],
)
def test_wrong_overrides(run: Run, override: str, said: str) -> None:
    outcome = run("analyse", AS2, "--set", override)
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith("--set ")
    assert said in outcome.err
    assert outcome.err.count("\n") == 1


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--latitude", "95"], "'--latitude': must be from -90 to 90 (got 95)"),
        (["--latitude", "nan"], "'--latitude': must be from -90 to 90 (got nan)"),
        (["--latitude", "north"], "'--latitude': 'north' is not a number"),
        (["--date", "02-29"], "'--date': month 02 has days 01 to 28 (got '02-29')"),
        (["--date", ""], "'--date': must be a date MM-DD"),
        (["--day-of-year", "0"], "'--day-of-year': 0 is not in the range 1<=x<=365"),
        (["--day-of-year", "366"], "'--day-of-year': 366 is not in the range 1<=x<=365"),
        (["--date", "07-01", "--day-of-year", "3"], "give --day-of-year or --date, not both"),
        (["--latitude", "80", "--date", "12-21"], "polar night: the sun never rises at 80 N, 21"),
        (["--model", "XYZ"], "'--model': 'XYZ' is not one of"),
        (["--correction", "XYZ"], "'--correction': 'XYZ' is not one of"),
        (["--plot", "a.gif"], "'a.gif' must end in .png, .svg, .pdf"),
        (["--plot", "a"], "'a' must end in .png, .svg, .pdf"),
        (["--colour"], "--colour"),
        (["extra"], "unexpected extra argument (extra)"),
    ],
)
def test_wrong_options(run: Run, tmp_path: Path, options: list[str], said: str) -> None:
    outcome = run("analyse", AS2, *options)
    assert (outcome.code, outcome.out) == (2, "")
    assert said in outcome.err.splitlines()[-1]
    assert files(tmp_path) == set()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--required-excess-time", "-1"], "is not in the range"),
        (["--required-excess-time", "nan"], "must be a number of hours"),
        (["--required-excess-time", "inf"], "is not in the range"),
        (["--objective", "min_cost"], "'min_cost' is not one of 'max_excess_time'"),
    ],
)
def test_wrong_options_of_sizing(run: Run, options: list[str], said: str) -> None:
    outcome = run("size", DESIGN, "-m", "rafz-july", *options)
    assert (outcome.code, outcome.out) == (2, "")
    assert said in outcome.err.splitlines()[-1]


@pytest.mark.parametrize(
    ("option", "name", "said"),
    [
        ("--plot", "no/a.png", "cannot write no/a.png: its folder does not exist"),
        ("--plot", "file/a.png", "cannot write file/a.png: a part of the path is a file"),
        ("--plot", "folder.png", "cannot write folder.png: it is a folder"),
        ("--csv", "no/a.csv", "cannot write no/a.csv: its folder does not exist"),
        ("--csv", "file/a.csv", "cannot write file/a.csv: a part of the path is a file"),
        ("--csv", "folder.png", "cannot write folder.png: it is a folder"),
    ],
)
def test_files_that_cannot_be_written(
    run: Run, tmp_path: Path, option: str, name: str, said: str
) -> None:
    (tmp_path / "file").write_text("old")
    (tmp_path / "folder.png").mkdir()
    outcome = run("analyse", AS2, option, name)
    assert outcome.code == 1
    assert said in outcome.err
    assert outcome.err.count("\n") == 1
    assert files(tmp_path) == {"file", "folder.png"}
    assert (tmp_path / "file").read_text() == "old"


# ---- size -----------------------------------------------------------------------------


def test_sizing_as_json(run: Run) -> None:
    outcome = run("size", DESIGN, "-m", "rafz-july", "--json")
    assert (outcome.code, outcome.err) == (0, "")
    record = outcome.json()
    assert record.keys() >= SIZE_KEYS
    assert record["status"] == "optimal"
    assert sum(record["masses_kg"].values()) == pytest.approx(record["total_mass_kg"], rel=1e-6)
    assert record["solver"].keys() >= {"iterations", "time_s"}
    assert record["active_constraints"]
    assert record["objective"]["value"] == pytest.approx(
        record["simulated"]["excess_time_h"], abs=0.05
    )


@pytest.mark.parametrize(
    ("objective", "key"), [("min_wingspan", "wingspan_m"), ("min_mass", "total_mass_kg")]
)
def test_objectives(run: Run, objective: str, key: str) -> None:
    options = ("--required-excess-time", "3", "--objective", objective, "--json")
    record = run("size", DESIGN, "-m", "rafz-july", *options).json()
    assert record["objective"]["value"] == pytest.approx(record[key])
    assert record["simulated"]["excess_time_h"] == pytest.approx(3.0, abs=0.1)


def test_overrides_change_the_sizing(run: Run) -> None:
    common = ("size", DESIGN, "-m", "rafz-july", "--json")
    before = run(*common).json()
    denser = run(*common, "--set", "battery.specific_energy_wh_per_kg=400").json()
    loaded = run(*common, "--set", "mission.payload.mass_kg=1").json()
    assert denser["objective"]["value"] > before["objective"]["value"]
    assert loaded["objective"]["value"] < before["objective"]["value"]
    assert loaded["masses_kg"]["payload"] == 1.0


@pytest.fixture
def sized(run: Run, tmp_path: Path) -> tuple[Outcome, Path]:
    folder = tmp_path / "new" / "design"
    return run("size", DESIGN, "-m", "rafz-july", "--json", "--out", str(folder)), folder


def test_sized_aircraft_flies_as_the_sizing_says(sized: tuple[Outcome, Path], run: Run) -> None:
    outcome, folder = sized
    assert (outcome.code, outcome.err) == (0, "")
    assert files(folder) == SIZED_FILES
    assert files(folder.parent) == {"design"}
    record = outcome.json()
    assert json.loads((folder / "result.json").read_text()) == record
    aircraft = str(folder / "aircraft.yaml")
    assert run("validate", aircraft).code == 0
    flown = run("analyse", aircraft, "-m", "rafz-july", "--json").json()
    assert flown["total_mass_kg"] == pytest.approx(record["total_mass_kg"], rel=1e-6)
    assert flown["excess_time_h"] == pytest.approx(record["simulated"]["excess_time_h"], abs=1e-3)
    assert run("size", aircraft, "-m", "rafz-july", "--json").json()["wingspan_m"] == (
        pytest.approx(record["wingspan_m"], rel=1e-3)
    )


def test_tables_and_figures_of_a_sizing(sized: tuple[Outcome, Path]) -> None:
    outcome, folder = sized
    masses = pd.read_csv(folder / "masses.csv")
    assert list(masses) == ["item", "mass_kg"]
    assert masses["mass_kg"].sum() == pytest.approx(outcome.json()["total_mass_kg"], rel=1e-6)
    scenarios = pd.read_csv(folder / "scenarios.csv")
    assert {"latitude_deg", "day_of_year", "excess_time_h"} <= set(scenarios)
    assert scenarios["excess_time_h"].min() == pytest.approx(
        outcome.json()["simulated"]["excess_time_h"], rel=1e-9
    )
    for figure in ("cycle.png", "masses.png"):
        assert (folder / figure).read_bytes().startswith(b"\x89PNG\r\n\x1a\n")


def test_excess_time_without_end_is_null_and_told_in_words(run: Run, tmp_path: Path) -> None:
    # At the pole in June the sun stays at 23 degrees: the battery is never needed.
    place = ("--set", "mission.latitude_deg=90", "--set", "mission.dates={on: 06-21}")
    asked = ("size", DESIGN, "-m", "rafz-july", *place, "--sensitivities", "--certify")
    outcome = run(*asked, "--json", "--out", "pole")
    assert (outcome.code, outcome.err) == (0, "")
    record = outcome.json()
    assert record["status"] == "optimal"
    assert record["objective"]["value"] is None
    assert record["sensitivities"] == []
    assert record["certificate"]["certified"]
    assert record["certificate"]["advantage"] == 0.0
    assert files(tmp_path / "pole") == SIZED_FILES
    text = run(*asked)
    assert (text.code, text.err) == (0, "")
    assert "no end" in text.out
    assert re.search(r"\b(inf|nan)\b", text.out) is None


def test_wing_covered_whole_is_written_and_read_again(run: Run) -> None:
    whole = ("--set", "airframe.maximum_module_coverage=1")
    asked = ("size", DESIGN, "-m", "rafz-july", "--objective", "min_wingspan", *whole)
    outcome = run(*asked, "--out", "whole")
    assert (outcome.code, outcome.err) == (0, "")
    again = run("analyse", "whole/aircraft.yaml", "-m", "rafz-july")
    assert (again.code, again.err) == (0, "")


@pytest.mark.parametrize("objective", ["max_payload_mass", "max_payload_power"])
def test_worth_of_payload_is_drawn(run: Run, tmp_path: Path, objective: str) -> None:
    asked = ("size", DESIGN, "-m", "rafz-july", "--objective", objective, "--sensitivities")
    outcome = run(*asked, "--out", "carrier")
    assert (outcome.code, outcome.err) == (0, "")
    picture = tmp_path / "carrier" / "sensitivities.png"
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_existing_folder_keeps_other_files(run: Run, tmp_path: Path) -> None:
    folder = tmp_path / "design"
    folder.mkdir()
    (folder / "notes.txt").write_text("mine")
    (folder / "masses.csv").write_text("old")
    outcome = run("size", DESIGN, "-m", "rafz-july", "--out", "design")
    assert (outcome.code, outcome.err) == (0, "")
    assert "written to design" in outcome.out
    assert files(folder) == SIZED_FILES | {"notes.txt"}
    assert (folder / "masses.csv").read_text() != "old"


@pytest.mark.parametrize("name", ["file", "file/design"])
def test_folder_that_cannot_be_written(run: Run, tmp_path: Path, name: str) -> None:
    (tmp_path / "file").write_text("old")
    outcome = run("size", DESIGN, "-m", "rafz-july", "--out", name)
    assert outcome.code == 1
    assert f"cannot write to {name}: " in outcome.err
    assert outcome.err.count("\n") == 1
    assert files(tmp_path) == {"file"}


@pytest.mark.parametrize(
    ("override", "requirement"),
    [
        ("mission.payload.mass_kg=1e6", "mass_budget"),
        ("modules.efficiency_stc=0.01", "energy_balance"),
        ("design_space.maximum_wing_loading_kg_per_m2=0.001", "wing_loading_kg_per_m2_maximum"),
    ],
)
def test_infeasible_sizing_says_why_and_writes_nothing(
    run: Run, tmp_path: Path, override: str, requirement: str
) -> None:
    options = ("--out", "design", "--set", override, "--json")
    outcome = run("size", DESIGN, "-m", "rafz-july", *options)
    assert (outcome.code, outcome.err) == (1, "")
    assert files(tmp_path) == set()
    record = outcome.json()
    assert record.keys() >= SIZE_KEYS
    assert record["status"] == "infeasible"
    assert record["wingspan_m"] is None
    assert requirement in [v["requirement"] for v in record["violated_requirements"]]


def test_infeasible_sizing_as_text(run: Run) -> None:
    outcome = run("size", DESIGN, "-m", "rafz-july", "--set", "mission.payload.mass_kg=1e6")
    assert (outcome.code, outcome.err) == (1, "")
    assert "infeasible" in outcome.out
    assert "  mass_budget: " in outcome.out


def test_excess_time_out_of_reach_is_explained(run: Run) -> None:
    outcome = run("size", DESIGN, "-m", "rafz-july", "--required-excess-time", "500")
    assert outcome.code == 1
    assert "excess_time: " in outcome.out


# ---- the other commands ---------------------------------------------------------------


def test_starters_validate_analyse_and_size(run: Run, tmp_path: Path) -> None:
    outcome = run("init", "heron")
    assert (outcome.code, outcome.err) == (0, "")
    assert files(tmp_path) == {"heron.yaml", "heron-mission.yaml"}
    outcome = run("validate", "heron.yaml", "heron-mission.yaml")
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out == "heron.yaml: valid aircraft\nheron-mission.yaml: valid mission\n"
    mission = ("-m", "heron-mission.yaml", "--json")
    assert run("analyse", "heron.yaml", *mission).json()["aircraft"] == "heron"
    record = run("size", "heron.yaml", *mission).json()
    assert record["status"] == "optimal"
    assert record["simulated"]["excess_time_h"] >= 3.0


def test_starters_overwrite_nothing(run: Run, tmp_path: Path) -> None:
    (tmp_path / "heron-mission.yaml").write_text("mine")
    outcome = run("init", "heron")
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err == "heron-mission.yaml: exists already and is not overwritten\n"
    assert files(tmp_path) == {"heron-mission.yaml"}


@pytest.mark.parametrize("name", ["", "../heron", "a b", ".heron", 65 * "a"])
def test_names_that_are_no_file_names(run: Run, tmp_path: Path, name: str) -> None:
    outcome = run("init", name)
    assert (outcome.code, outcome.out) == (2, "")
    assert "a name has letters, digits, '-', '_' and '.', at most 64 of them" in outcome.err
    assert files(tmp_path) == set()


def test_validation_reports_every_file(run: Run, tmp_path: Path) -> None:
    (tmp_path / "bird.yaml").write_text(BIRD)
    (tmp_path / "field.yaml").write_text(edited(FIELD, "on: 07-15", "on: 02-30"))
    (tmp_path / "broken.yaml").write_text("a: [")
    (tmp_path / "heavy.yaml").write_text(
        edited(edited(BIRD, "  mass_kg: 2.918", "  mass_kg: -1"), "avionics_w: 6.0", "avionics: 6")
    )
    outcome = run("validate", "broken.yaml", "heavy.yaml", "bird.yaml", "field.yaml", "none.yaml")
    assert outcome.code == 2
    assert outcome.out == "bird.yaml: valid aircraft\n"
    places = [line.split(": ")[0] for line in outcome.err.splitlines()]
    assert {re.sub(r":.*", "", place) for place in places} == {
        "broken.yaml",
        "heavy.yaml",
        "field.yaml",
        "none.yaml",
    }
    assert "heavy.yaml:15:12: battery.mass_kg: must be greater than 0 (got -1)" in outcome.err
    assert "heavy.yaml:24:3: power.avionics: unknown key; did you mean 'avionics_w'?" in outcome.err


def test_list(run: Run) -> None:
    outcome = run("list")
    assert (outcome.code, outcome.err) == (0, "")
    shipped = run("list", "--json").json()
    assert shipped.keys() == {"aircraft", "mission"}
    assert {AS2, DESIGN, "sky-sailor"} <= shipped["aircraft"].keys()
    assert {"rafz-july", "rafz-81h", "central-europe-summer"} <= shipped["mission"].keys()
    for descriptions in shipped.values():
        for name, description in descriptions.items():
            assert description
            assert name in outcome.out


def test_every_shipped_aircraft_flies_every_shipped_mission(run: Run) -> None:
    shipped = run("list", "--json").json()
    for aircraft in shipped["aircraft"]:
        for mission in shipped["mission"]:
            outcome = run("analyse", aircraft, "-m", mission, "--json")
            assert (outcome.code, outcome.err) == (0, "")
            assert outcome.json().keys() >= ANALYSE_KEYS


def test_published_numbers_are_met(run: Run, tmp_path: Path) -> None:
    outcome = run("published", "--json", "--markdown", "table.md")
    assert (outcome.code, outcome.err) == (0, "")
    rows = outcome.json()
    assert len(rows) >= 10
    assert all(row["met"] for row in rows)
    table = (tmp_path / "table.md").read_text(encoding="utf-8").splitlines()
    assert len(table) == len(rows) + 2
    assert all(line.startswith("| ") for line in table[2:])


def test_version_and_helps(run: Run) -> None:
    assert re.fullmatch(r"solar-uav, version \S+\n", run("--version").out)
    outcome = run("--help")
    assert outcome.code == 0
    for command in COMMANDS:
        assert f"  {command} " in outcome.out
        for flag in ("--help", "-h"):
            page = run(command, flag)
            assert (page.code, page.err) == (0, "")
            assert re.match(rf"Usage: .*solar-uav {command} ", page.out)


@pytest.mark.parametrize("command", ["analyse", "size", "init", "validate"])
def test_missing_arguments(run: Run, command: str) -> None:
    outcome = run(command)
    assert (outcome.code, outcome.out) == (2, "")
    assert "Missing argument" in outcome.err


# ---- what does not hold yet -----------------------------------------------------------


@pytest.mark.parametrize("command", [("analyse", AS2), ("size", DESIGN, "-m", "rafz-july")])
def test_brackets_in_a_name(run: Run, command: tuple[str, ...]) -> None:
    outcome = run(*command, "--set", "name='[/]a[red]'")
    assert (outcome.code, outcome.err) == (0, "")
    assert "[/]a[red]" in outcome.out


def test_dollars_in_a_name(run: Run) -> None:
    outcome = run("analyse", AS2, "--set", "name='$x^{2$'", "--plot", "a.png")
    assert (outcome.code, outcome.err) == (0, "")


def test_constant_charge_rate_can_be_sized(run: Run) -> None:
    constant = "battery.charge_limit={kind: rule, taper_start: 0, relative_rate_at_full: 1}"
    outcome = run("size", DESIGN, "-m", "rafz-july", "--set", constant, "--json")
    assert (outcome.code, outcome.err) == (0, "")


@pytest.mark.parametrize(
    "override",
    [
        "mission.required_excess_time_h=1e5",
        "design_space.maximum_total_mass_kg=1e-3",
        "battery.discharge_efficiency=1e-300",
    ],
)
def test_hopeless_sizing_ends_quietly(run: Run, override: str) -> None:
    outcome = run("size", DESIGN, "-m", "rafz-july", "--set", override, "--json")
    assert outcome.code in (1, 2)
    assert "WARNING" not in outcome.err
    assert "RuntimeWarning" not in outcome.err


@pytest.mark.parametrize("override", ["mission.payload.mass_kg=1e300", "airframe.wingspan_m=1e300"])
def test_huge_numbers_end_in_a_message(run: Run, override: str) -> None:
    assert run("analyse", AS2, "--set", override, "--json").code in (0, 1, 2)


@pytest.mark.parametrize("override", ["mission.latitude_deg=95", "mission.latitude_deg=-80"])
def test_overrides_of_the_mission_are_named_as_written(run: Run, override: str) -> None:
    outcome = run("analyse", AS2, "--set", override)
    assert outcome.code == 2
    assert outcome.err.startswith("--set mission.latitude_deg: ")


def test_no_file_is_written_if_one_cannot_be(run: Run, tmp_path: Path) -> None:
    assert run("analyse", AS2, "--csv", "a.csv", "--plot", "no/a.png").code == 1
    assert files(tmp_path) == set()


def test_folder_of_results_is_written_whole_or_not_at_all(run: Run, tmp_path: Path) -> None:
    (tmp_path / "design" / "masses.csv").mkdir(parents=True)
    assert run("size", DESIGN, "-m", "rafz-july", "--out", "design").code == 1
    assert files(tmp_path / "design") == {"masses.csv"}


@pytest.mark.parametrize("name", ["12", "1e5", "null", "true"])
def test_starters_of_any_name_are_valid(run: Run, name: str) -> None:
    assert run("init", name).code == 0
    assert run("validate", f"{name}.yaml", f"{name}-mission.yaml").code == 0


@pytest.mark.parametrize("name", ["", "a\nb", 5000 * "a"])
def test_odd_names_of_aircraft(run: Run, name: str) -> None:
    outcome = run("analyse", name)
    assert outcome.code == 2
    assert outcome.err.count("\n") == 1
    assert not outcome.err.startswith(":")
    assert len(outcome.err) < 1000


def test_terminal_without_unicode(tmp_path: Path) -> None:
    variables = {"PYTHONIOENCODING": "ascii", "COLUMNS": "30"}
    done = process("analyse", AS2, "-m", "central-europe-summer", cwd=tmp_path, variables=variables)
    assert (done.returncode, done.stderr) == (0, "")


# ---- as a process ---------------------------------------------------------------------


def process(*arguments: str, **options: Any) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "studies.cli", *arguments],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        env=environment(**options.pop("variables", {})),
        **options,
    )


def environment(**variables: str) -> dict[str, str]:
    """Environment in which the same packages are found from any folder."""
    root = str(Path(cli.__file__).parents[1])
    return {**os.environ, "PYTHONPATH": root, **variables}


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys\n"
        "from studies.cli import main\n"
        "sys.argv = ['solar-uav', *sys.argv[1:]]\n"
        "try:\n"
        "    main()\n"
        "finally:\n"
        "    print(*sorted({name.partition('.')[0] for name in sys.modules}), file=sys.stderr)\n"
    )
    heavy = {"numpy", "casadi", "pandas", "matplotlib", "xarray", "scipy", "pydantic", "rich"}
    for arguments in (["--help"], ["size", "--help"]):
        done = subprocess.run(
            [sys.executable, "-c", code, *arguments],
            capture_output=True,
            text=True,
            timeout=60,
            check=True,
            env=environment(),
        )
        assert "Usage: solar-uav" in done.stdout
        assert not heavy & set(done.stderr.split())


def test_no_home_and_a_poor_terminal(tmp_path: Path) -> None:
    variables = {
        "LC_ALL": "C",
        "PYTHONIOENCODING": "ascii",
        "COLUMNS": "30",
        "HOME": "/nonexistent",
    }
    done = process("analyse", AS2, cwd=tmp_path, variables=variables)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.isascii()
    assert "excess time" in done.stdout


def test_mistake_ends_without_a_traceback(tmp_path: Path) -> None:
    (tmp_path / "bird.yaml").write_text(edited(BIRD, "avionics_w: 6.0", "avionics_w: -6"))
    done = process("analyse", "bird.yaml", cwd=tmp_path)
    said = "bird.yaml:24:15: power.avionics_w: must be at least 0 (got -6)\n"
    assert (done.returncode, done.stdout, done.stderr) == (2, "", said)


@pytest.mark.skipif(sys.platform == "win32", reason="pipes and signals of POSIX")
def test_closed_pipe_ends_quietly(tmp_path: Path) -> None:
    with subprocess.Popen(
        [sys.executable, "-m", "studies.cli", "list"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=tmp_path,
        env=environment(),
    ) as running:
        assert running.stdout is not None
        assert running.stderr is not None
        running.stdout.close()
        said = running.stderr.read()
    assert b"Traceback" not in said
    assert b"Exception" not in said


@pytest.mark.skipif(sys.platform == "win32", reason="pipes and signals of POSIX")
def test_interrupted_sizing_leaves_nothing_behind(tmp_path: Path) -> None:
    code = (
        "import os, signal, sys\n"
        "from sizing import optimiser\n"
        "from studies.cli import main\n"
        "optimiser.size_aircraft = lambda *a, **k: os.kill(os.getpid(), signal.SIGINT)\n"
        f"sys.argv = ['solar-uav', 'size', '{DESIGN}', '-m', 'rafz-july', '--out', 'design']\n"
        "main()\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        cwd=tmp_path,
        env=environment(),
    )
    assert done.returncode in (1, 130, -signal.SIGINT)
    assert "Traceback" not in done.stderr
    assert files(tmp_path) == set()
