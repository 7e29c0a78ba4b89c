"""Mistakes in files and options: messages and exit codes of the command line."""

import os
import re

import pytest
from command_line import BIRD, FIELD, edited, files

AS2, DESIGN = "atlantiksolar-as2", "atlantiksolar-design"


# ---- wrong files ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        # unknown, missing and duplicate keys
        ("  mass_kg: 2.918", "  mass_kgs: 2.918", ":15:3: battery.mass_kgs: unknown key; did you mean 'mass_kg'?"),  # noqa: E501
        ("power:\n", "colour: red\npower:\n", ":23:1: colour: unknown key; allowed keys: format_version, name, description, airframe, modules, battery, power, design_space"),  # noqa: E501
        ("kind: measured", "kind: masured", ":3:9: airframe.kind: must be one of 'measured', 'parametric' (got 'masured')"),  # noqa: E501
        # wrong types
        ("avionics_w: 6.0", "avionics_w: six", ":24:15: power.avionics_w: must be a number (got 'six')"),  # noqa: E501
        ("name: bird", "name: 12", ":1:7: name: must be text (got 12); put it in quotes"),
        # wrong numbers
        ("avionics_w: 6.0", "avionics_w: -6", ":24:15: power.avionics_w: must be at least 0 (got -6)"),  # noqa: E501
        ("efficiency_stc: 0.237", "efficiency_stc: 23.7", ":13:19: modules.efficiency_stc: must be at most 1 (got 23.7)"),  # noqa: E501
        ("area_m2: 1.35", "area_m2: 13.5", ":12:12: modules.area_m2: must not exceed the wing area of 1.73 m², wingspan squared over aspect_ratio or wingspan times chord_m (got 13.5)"),  # noqa: E501
        ("[10, 5, 1]", "[10, 5]", "battery.charge_limit: state_of_charge and current_a must have the same length"),  # noqa: E501
        ("[0.8, 0.9, 1.0]", "[0.9, 0.8, 1.0]", "battery.charge_limit: state_of_charge must increase strictly"),  # noqa: E501
        # what YAML allows and a description must not hold
        ("name: bird", "name: !!python/object/apply:os.getcwd []", ":1:7: explicit tags (!!python/object/apply:os.getcwd) are not allowed"),  # noqa: E501
        ("  avionics_w", "\tavionics_w", ":24:1: is not valid YAML"),
    ],
)  # fmt: skip
def test_wrong_aircraft(run, tmp_path, old, new, said):
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
        ("on: 07-15", "on: 15.07.", "dates.on: must be a date MM-DD, for instance 07-15"),
        ("on: 07-15", "on: 715", "dates.on: must be a date MM-DD, for instance 07-15 (got 715)"),
        ("dates:\n  on: 07-15", "dates: {}", ":4:1: dates: empty date range: give"),
        ("on: 07-15", "from: 07-15", ":4:1: dates: empty date range: give"),
        ("on: 07-15", "on: 07-15\n  to: 07-20", ":4:1: dates: give either"),
        ("on: 07-15", "from: 07-15\n  to: 08-01\n  count: 0", ":7:10: dates.count: must be at least 1 (got 0)"),  # noqa: E501
        ("on: 07-15", "from: 07-15\n  to: 08-01\n  count: 366", ":7:10: dates.count: must be at most 365 (got 366)"),  # noqa: E501
        ("latitude_deg: 47.6", "latitude_deg: 95", ":2:15: latitude_deg: must be at most 90"),
        ("latitude_deg: 47.6", "latitude_deg: {from_deg: 45, to_deg: 95}", ":2:38: latitude_deg.to_deg: must be at most 90 (got 95)"),  # noqa: E501
        ("latitude_deg: 47.6", "latitude_deg: {from_deg: 45, to_deg: 45}", "latitude_deg: from_deg and to_deg must differ"),  # noqa: E501
        ("latitude_deg: 47.6", "latitude_deg: {from_deg: 45, to_deg: 50}", "latitude_deg: a launch needs a single latitude"),  # noqa: E501
        ("latitude_deg: 47.6", "latitude_deg: -80", ":2:15: latitude_deg: polar night: the sun never rises at 80° S, 15 Jul"),  # noqa: E501
        ("longitude_deg: 8.5\n", "", "launch: a launch by clock time needs longitude_deg"),
        ("clearness: 1.0", "clearness: 0", ":9:12: clearness: must be greater than 0 (got 0)"),
        ("thermal: 0.0", "thermal: 6", ":11:12: turbulence.thermal: must be at most 5 (got 6)"),
        ("altitude_m: 500", "altitude_m: 1e6", ":6:13: altitude_m: must be at most 32000"),
        ("clearness: 1.0", "clearness: 1.0\nwind_m_per_s: -1", "wind_m_per_s: must be at least 0"),
        ("  ambient_temperature_c: 20.0", "  ambient_temperature_c: 20.0\n  temperature_offset_k: 1", ":7:1: air: give temperature_offset_k or ambient_temperature_c, not both"),  # noqa: E501
        ("time_local: 09:30", "time_local: 25:00", ":14:15: launch.time_local: must be a time HH:MM"),  # noqa: E501
        ("duration_h: 30", "duration_h: 9000", "launch.duration_h: must be at most 8784 (got 9000)"),  # noqa: E501
    ],
)  # fmt: skip
def test_wrong_mission(run, tmp_path, old, new, said):
    (tmp_path / "field.yaml").write_text(edited(FIELD, old, new))
    outcome = run("size", DESIGN, "--mission", "field.yaml")
    assert (outcome.code, outcome.out) == (2, "")
    assert any(line.startswith("field.yaml:") and said in line for line in outcome.err.split("\n"))


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "the file is empty; it must hold a mapping (key: value)"),
        (b"- a\n", ":1:1: the top level must be a mapping (key: value), not a list"),
        (b"name: caf\xe9\n", ":1:10: is not UTF-8 text (byte 0xe9)"),
    ],
)
def test_what_is_no_description(run, tmp_path, content, said):
    (tmp_path / "odd.yaml").write_bytes(content)
    for arguments in (("analyse", "odd.yaml"), ("validate", "odd.yaml")):
        outcome = run(*arguments)
        assert (outcome.code, outcome.out) == (2, "")
        assert outcome.err.startswith("odd.yaml:")
        assert said in outcome.err
        assert outcome.err.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("analyse", "missing.yaml"), "missing.yaml: there is no such file"),
        (("analyse", "atlantiksolar-as3"), f"did you mean '{AS2}'?"),
        (("analyse", "rafz-july"), "no shipped aircraft of that name: 'rafz-july' is one of the m"),
        (("analyse", AS2, "-m", AS2), "no shipped mission of that name"),
        (("analyse", "."), ".: is a folder without run.json"),
        (("size", DESIGN, "-m", "."), ".: is a folder, not a file"),
        (("validate", "missing.yaml"), "missing.yaml: no such file"),
        (("size", AS2, "-m", "rafz-july"), "airframe.kind: a measured aircraft cannot be sized"),
    ],
)
def test_what_cannot_be_found_or_used(run, arguments, said):
    outcome = run(*arguments)
    assert (outcome.code, outcome.out) == (2, "")
    assert said in outcome.err
    assert outcome.err.count("\n") == 1


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (
            "analyse field.yaml",
            "field.yaml: is a mission, not an aircraft: missions are given with",
        ),
        (f"analyse {AS2} -m bird.yaml", "bird.yaml: is an aircraft, not a mission: AIRCRAFT comes"),
        ("analyse field.yaml -m bird.yaml", "field.yaml: is a mission, and bird.yaml is an aircra"),
        (f"verify flight.csv {AS2}", f"Error: the aircraft comes first: verify {AS2} flight.csv"),
        ("verify flight.ULG bird.yaml", "Error: the aircraft comes first: verify bird.yaml flight"),
    ],
)
def test_files_in_each_others_place_are_named_in_one_line(run, tmp_path, call, said):
    (tmp_path / "bird.yaml").write_text(BIRD)
    (tmp_path / "field.yaml").write_text(FIELD)
    (tmp_path / "flight.csv").write_text("time_s\n")
    outcome = run(*call.split())
    assert (outcome.code, outcome.out) == (2, "")
    lines = outcome.err.splitlines()
    assert lines[-1].startswith(said)
    assert [line for line in lines[:-1] if line] == [] or lines[0].startswith("Usage: ")


def test_a_short_file_is_told_what_it_lacks(run, tmp_path):
    (tmp_path / "bird.yaml").write_text("name: bird\n")
    assert "bird.yaml:1:1: airframe: required key is missing" in run("analyse", "bird.yaml").err
    outcome = run("analyse", AS2, "-m", "bird.yaml")
    assert "bird.yaml:1:1: latitude_deg: required key is missing" in outcome.err


def test_all_problems_of_both_files_are_reported_together(run, tmp_path):
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
        ("colour=red", "--set colour: unknown key; allowed keys: format_version, name"),
        ("battery.mass_kg=abc", "--set battery.mass_kg: must be a number (got 'abc')"),
        ("battery.mass_kg.x=1", "battery.mass_kg is the single value 2.918 and has no keys"),
        ("battery.charge_limit.current_a.99=1", "takes an index from 0 to 12 (got '99')"),
        ("wingspan=3", "--set wingspan: unknown key; did you mean 'wingspan_m'?"),
        ("airframe.wingspan_m=1e300", "--set airframe.wingspan_m: must be at most"),
        ('name="a\\e[31mb"', "must not hold control characters"),
        ("mission.payload.mass_kg=1e300", "--set mission.payload.mass_kg: must be at most"),
        ("mission.latitude_deg=95", "--set mission.latitude_deg: must be at most 90"),
        ("mission.dates.on=02-29", "dates.on: month 02 has days 01 to 28 (got '02-29')"),
        (
            "mission.colour=red",
            "colour: unknown key; allowed keys: format_version, name, description, latitude_deg",
        ),
    ],
)
def test_wrong_overrides(run, override, said):
    outcome = run("analyse", AS2, "--set", override)
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith("--set ")
    assert said in outcome.err
    assert outcome.err.count("\n") == 1


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--latitude", "95"], "'--latitude': must be from -90 to 90 (got 95)"),
        (["--latitude", "95S"], "'--latitude': must be from -90 to 90 (got 95S)"),
        (["--latitude", "nan"], "'--latitude': must be from -90 to 90 (got nan)"),
        (["--latitude", "north"], "'--latitude': 'north' is not a number"),
        (["--mass", "4kg"], "must be a number of kilograms, written without a unit (got 4kg)"),
        (["--date", "02-29"], "'--date': month 02 has days 01 to 28 (got '02-29')"),
        (["--date", ""], "'--date': must be a date MM-DD"),
        (["--day-of-year", "0"], "'--day-of-year': 0 is not in the range 1<=x<=365"),
        (["--day-of-year", "366"], "'--day-of-year': 366 is not in the range 1<=x<=365"),
        (["--date", "07-01", "--day-of-year", "3"], "give --day-of-year or --date, not both"),
        (["--model", "XYZ"], "'--model': 'XYZ' is not one of"),
        (["--correction", "XYZ"], "'--correction': 'XYZ' is not one of"),
        (["--plot", "a.gif"], "'a.gif' must end in .png, .svg, .pdf"),
        (["--plot", "a"], "'a' must end in .png, .svg, .pdf"),
        (["--colour"], "--colour"),
        (["extra"], "unexpected extra argument (extra)"),
    ],
)
def test_wrong_options(run, tmp_path, options, said):
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
        (["--certify"], "--cross-check"),  # its old name
        (["--reliability", "1.5"], "1.5 is not in the range"),
        (["--reliability", "1"], "1.0 is not in the range 0.0<x<1.0"),
        (["--reliability", "0.9", "--sensitivities"], "know of no --reliability"),
        (["--out", ""], "--out"),
    ],
)
def test_wrong_options_of_sizing(run, options, said):
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
        ("--table", "folder.csv", "cannot write folder.csv: it is a folder"),
    ],
)
def test_files_that_cannot_be_written(run, tmp_path, option, name, said):
    (tmp_path / "file").write_text("old")
    for folder in ("folder.png", "folder.csv"):
        (tmp_path / folder).mkdir()
    outcome = run("analyse", AS2, option, name)
    assert outcome.code == 1
    assert said in outcome.err
    assert outcome.err.count("\n") == 1
    assert files(tmp_path) == {"file", "folder.png", "folder.csv"}
    assert (tmp_path / "file").read_text() == "old"


# ---- Messages that fit a screen


LONG = 100_000 * "x"


@pytest.mark.parametrize(
    "arguments",
    [
        ["analyse", "atlantiksolar-design", "--set", f"name={LONG}"],
        ["analyse", "atlantiksolar-design", "--set", f"battery.mass_kg={LONG}"],
        ["analyse", "atlantiksolar-design", "--set", f"{LONG}=1"],
        ["analyse", LONG],
        ["sweep", "atlantiksolar-design", "--vary", f"{LONG}=1:2:1"],
        ["sweep", "atlantiksolar-design", "--vary", f"battery_mass_kg={LONG}"],
        ["map", "atlantiksolar-design", "--latitudes", LONG],
    ],
)
def test_echoed_values_are_cut(run, arguments):
    outcome = run(*arguments)
    assert (outcome.code, outcome.out) == (2, "")
    assert len(outcome.err) < 2000


def test_of_many_mistakes_the_first_are_told(run, tmp_path):
    file = tmp_path / "many.yaml"
    file.write_text("name: x\n" + "".join(f"key{i}: {i}\n" for i in range(3000)))
    outcome = run("analyse", str(file))
    assert outcome.code == 2
    lines = outcome.err.splitlines()
    assert len(lines) == 31
    assert lines[-1].startswith("... and 29")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs a pipe with a name")
@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("p.yaml", "analyse p.yaml"),
        ("p.yaml", "size atlantiksolar-design -m p.yaml"),
        *[(f"p.{kind}", f"verify {AS2} p.{kind}") for kind in ("ulg", "bin", "xlsx")],
        *[(f"p.{kind}", f"analyse {AS2} --weather p.{kind}") for kind in ("nc", "epw")],
        *[
            (f"p.{kind}", f"analyse {AS2} --set mission.wind={{percentile:\n90,file:\n{{}}}}")
            for kind in ("nc", "csv")
        ],
        (
            "p.csv",
            "analyse atlantiksolar-design --set airframe.aerodynamics={model:\nwing_polar,airfoil:"
            "\n{},design_aspect_ratio:\n18.5,design_reynolds:\n2e5}",
        ),
    ],
)
def test_a_pipe_in_place_of_a_file_is_refused(run, name, arguments, tmp_path):
    os.mkfifo(name)
    words = [word.replace("{}", str(tmp_path / name)) for word in arguments.split(" ")]
    outcome = run(*words)
    assert outcome.code == 2
    assert re.search(rf"{name}:? cannot be read: is not a plain file", outcome.err)
