"""Mistakes in files and options: messages and exit codes of the command line."""

import os
import re
import shlex

import pytest
from command_line import BIRD, FIELD, edited, files
from weather_files import clear_record, write_epw

AS2, DESIGN = "atlantiksolar-as2", "atlantiksolar-design"


def test_all_problems_of_both_files_are_reported_together(run, tmp_path):
    bird = edited(edited(BIRD, "avionics_w: 6.0", "avionics_w: -6"), "area_m2: 1.35", "area_m2: x")
    (tmp_path / "bird.yaml").write_text(bird)
    (tmp_path / "field.yaml").write_text(edited(FIELD, "on: 07-15", "on: 02-30"))
    outcome = run("analyse", "bird.yaml", "-m", "field.yaml", "--json")
    assert (outcome.code, outcome.out) == (2, "")
    keys = ["dates.on", "modules.area_m2", "power.avionics_w"]
    assert sorted(line.split(": ")[1] for line in outcome.err.splitlines()) == keys


# Files that calls name.
FILES = {
    "bird.yaml": BIRD,
    "field.yaml": FIELD,
    "short.yaml": "name: bird\n",
    "empty.yaml": "",
    "list.yaml": "- a\n",
    "latin.yaml": "name: caf\xe9\n",
    "flight.csv": "time_s\n",
    "mp.yaml": "name: mp\n",
    "bare.yaml": "name: bare\nlatitude_deg: 45.0\ndates: {on: 06-21}\n",
    "climb.yaml": "name: climb\nlatitude_deg: 47.6\ndates: {on: 06-21}\naltitude_m: 536\n"
    "climb:\n  ceiling_m: 3536\n",
}
POLAR_NIGHT = "--set mission.latitude_deg=85 --set 'mission.dates={on: 12-21}'"
LAUNCH = "'mission.launch={date: 07-01, time_local: 10:00, duration_h: 20}'"
CLIMB_POWER = "airframe.propulsion.climb_power_ratio"
COLORADO = "--weather colorado-2023"
IN_COLORADO = "--set mission.latitude_deg=40.53 --set mission.altitude_m=2300"
CLIMB = "--set 'mission.climb={{ceiling_m: 3000{}}}'"
CHOSEN = ", design_space: {ceiling_m: {minimum: 1, maximum: 9}}"
WINDS = "--set 'mission.wind={percentile: 95}'"
HOLDING = (
    f"{WINDS} --set mission.altitude_m=12000 --set mission.air={{}} --set mission.dates.on=07-01"
    " --set modules.efficiency_stc=0.3 --set battery.specific_energy_wh_per_kg=400"
    " --set mission.wind.hold_station=true"
)
CEILING = "--set 'mission.climb={ceiling_m: 20000, strategy: surplus}'"
POLAR = "--latitudes 80:90:5 --days 1:365:91"
LAYOUT = (
    "--set 'modules.layout={cell_span_m: 0.125, cell_chord_m: 0.125, bays: [{cells: [22, 22]}]}'"
)
PACK = "--set 'battery.pack={cells_in_series: 6, cell_mass_kg: 0.0486}'"
CELLS = f"--set modules.cell=sunpower-e60 {LAYOUT} {PACK}"
WIDE_CELLS = (
    "{cell_span_m: 0.125, cell_chord_m: 0.4, cell_area_m2: 0.0153436, bays: [{cells: [44]}]}"
)
STRINGS = (
    "{cells_in_series: 44, coldest_c: -20, hottest_c: 70, mpp_voltage_v: 0.63, "
    "open_circuit_voltage_v: 0.73, mpp_current_a: 5.9, "
    "mppt: {minimum_voltage_v: 9, maximum_voltage_v: 16, maximum_current_a: 7}}"
)
WRONG_GRIDS = ["50:40:1", "-95:0:5", "0:10", "a:b:c", "0:10:0", "0:nan:1", "0:9:inf", "0:9:1e-320"]
NO_OBJECTIVES = ("fun", "longest_season")
LETTERS = "a name has letters, digits, '-', '_' and '.', at most 64 of them"
DEVICES = ("CON", "nul.yaml", "Aux", "com1", "LPT9.v2.yml", "prn.2")
# Calls by what they begin with: the rest, and a part of the message.
REFUSALS = {
    "": [
        ("anaylse x", "No such command 'anaylse'; did you mean 'analyse'?"),
        *[(command, "Missing argument") for command in ("analyse", "size", "init", "validate")],
        (f"size {DESIGN}", "Missing option '--mission' / '-m'."),
        ("list --cells --motors", "--cells and --motors: one at a time"),
        ("show nothing", "nothing: no shipped aircraft, mission or weather record of that name"),
        (f"verify flight.csv {AS2}", f"Error: the aircraft comes first: verify {AS2} flight.csv"),
        ("verify flight.ULG bird.yaml", "Error: the aircraft comes first: verify bird.yaml flight"),
        ("validate missing.yaml", "missing.yaml: no such file"),
        *[
            (f"{command} {call}", message)
            for command in ("analyse", "validate")
            for call, message in [
                ("empty.yaml", "empty.yaml: the file is empty; it must hold a mapping (key: value"),
                ("list.yaml", ":1:1: the top level must be a mapping (key: value), not a list"),
                ("latin.yaml", "latin.yaml:1:10: is not UTF-8 text (byte 0xe9)"),
            ]
        ],
        ("schema", "aircraft, mission"),
        ("schema weather", "'weather' is not one of 'aircraft', 'mission'"),
        (f"export {AS2} --out d.doc", "must end in .avl, .vspscript, .py, .tex"),
        (f"export {AS2} --out ''", "needs the name of a file"),
        (f"export {AS2}", "Missing option '--out'"),
    ],
    "init": [
        *[(name, LETTERS) for name in ("''", "../heron", "'a b'", ".heron", 65 * "a")],
        *[(name, "names a device of Windows") for name in DEVICES],
    ],
    "analyse": [
        ("missing.yaml", "missing.yaml: there is no such file"),
        ("atlantiksolar-as3", f"did you mean '{AS2}'?"),
        ("rafz-july", "no shipped aircraft of that name: 'rafz-july' is one of the m"),
        (".", ".: is a folder without run.json"),
        ("field.yaml", "field.yaml: is a mission, not an aircraft: missions are given with"),
        ("field.yaml -m bird.yaml", "field.yaml: is a mission, and bird.yaml is an aircra"),
        ("sky-sailor -m climb.yaml", f"{CLIMB_POWER}: "),
        ("sky-sailor -m climb.yaml", "leaves nothing to climb with"),
        (f"{DESIGN} --mass 3", "more than the total mass of 3 kg"),
        (f"{DESIGN} --mass nan", "must be a number of kilograms"),
        (f"{DESIGN} {HOLDING} {CEILING} --set mission.altitude_m=8000", "9126 to 33043 (got 8000)"),
    ],
    f"analyse {AS2}": [
        (f"-m {AS2}", "no shipped mission of that name"),
        ("-m bird.yaml", "bird.yaml: is an aircraft, not a mission: AIRCRAFT comes"),
        ("-m short.yaml", "short.yaml:1:1: latitude_deg: required key is missing"),
        ("-m mp.yml", "did you mean 'mp.yaml'?"),
        ("--latitude 95", "'--latitude': must be from -90 to 90 (got 95)"),
        ("--latitude nan", "'--latitude': must be from -90 to 90 (got nan)"),
        ("--latitude north", "'--latitude': 'north' is not a number"),
        ("--mass 4kg", "must be a number of kilograms, written without a unit (got 4kg)"),
        ("--date 02-29", "'--date': month 02 has days 01 to 28 (got '02-29')"),
        ("--date 13-01", "'--date': the month must be 01 to 12 (got '13-01')"),
        ("--date ''", "'--date': must be a date MM-DD"),
        ("--day-of-year 0", "'--day-of-year': 0 is not in the range 1<=x<=365"),
        ("--day-of-year 366", "'--day-of-year': 366 is not in the range 1<=x<=365"),
        ("--date 07-01 --day-of-year 3", "give --day-of-year or --date, not both"),
        ("--model XYZ", "'--model': 'XYZ' is not one of"),
        ("--correction XYZ", "'--correction': 'XYZ' is not one of"),
        ("--plot a.gif", "'a.gif' must end in .png, .svg, .pdf"),
        ("--plot a", "'a' must end in .png, .svg, .pdf"),
        ("--colour", "--colour"),
        ("extra", "unexpected extra argument (extra)"),
        ("--weather none.epw", "none.epw: there is no such file"),
        ("--weather colorado", "there is no such file, and none is shipped but colorado-2023"),
        ("--weather=", "'': there is no such file"),
        (f"{COLORADO} --set mission.altitude_m=12000", "a flight through a record is below 12000"),
        (f"-m rafz-july {COLORADO}", "km from the mission rafz-july; allowed: up to 1000 km"),
        (f"--latitude 10 {COLORADO}", "a weather record has its own place"),
        (f"--date 06-21 {COLORADO}", "own days: give --date or --weather"),
        (f"--day-of-year 172 {COLORADO}", "own days: give --day-of-year or --weather"),
        ("--table-years years.csv", "--table-years needs --weather"),
        ("--plot a.png --figure-size 7x4", "'7x4' is no size of a figure; allowed:"),
        ("--plot a.png --figure-size 5x5mm", "must be from 40 to 2500 mm (got 5 mm)"),
        ("--plot a.png --dpi many", "'many' is no number of dots per inch"),
        ("--plot a.png --dpi 1", "must be from 20 to 2400 (got 1)"),
        ("--plot a.png --figure-size 90in --dpi 900", "at most 65535"),
        ("--plot a.png --style pretty", "'pretty' is neither a style nor a file"),
        ("--style paper", "--style is of the figure: give --plot too"),
        ("--no-title", "--no-title is of the figure: give --plot too"),
        ("--weather typical.epw --table-years years.csv", "this is a typical year"),
    ],
    f"analyse {AS2} --set": [
        ("nonsense", "--set nonsense: write an override as KEY=VALUE, for example a.b=2.5"),
        ("airframe.wingspan_m=1e300", "--set airframe.wingspan_m: must be at most"),
        (r"""'name="a\e[31mb"'""", "must not hold control characters"),
        ("mission.climb.ceiling_m=3000 --weather typical.epw", "keep their altitude: leave out cl"),
        ("mission.climb.maximum_altitude_m=3", "the highest altitude is climb.ceiling_m"),
    ],
    f"analyse {AS2} -m climb.yaml --set": [
        ("mission.climb.ceiling_m=100", "mission.climb.ceiling_m: must be at least"),
        ("mission.climb.ceiling_m=40000", "ceiling_m: must be at most 32000"),
        ("mission.climb.strategy=up", "'battery_full' or 'surplus'"),
        ("mission.climb.cieling_m=100", "did you mean 'ceiling_m'"),
        ("airframe.level_flight.propulsion_efficiency=null", "propulsion_efficiency: required key"),
        ("airframe.level_flight.maximum_electric_power_w=20", "must be at least electric_power_w"),
        (f"mission.longitude_deg=8.5 --set {LAUNCH}", "give launch or climb, not both"),
    ],
    f"analyse {DESIGN} --set": [
        ("payload.mass_kg=3", "--set payload.mass_kg: is a key of the mission: write mission."),
        ("clearness=0.8", "--set clearness: is a key of the mission: write mission.clearness"),
        ("airframe.chord_m=-0.2", "airframe.chord_m: must be a number greater than 0 (got -0.2)"),
        ("airframe.chord_m=wide", "airframe.chord_m: must be a number greater than 0 (got 'wide')"),
        ("airframe.chord_m=0.3 --set airframe.wing_area_m2=2", "give one of aspect_ratio,"),
        ("airframe.chord_m=0.1", "must not exceed the wing area of 0.565 m², wingspan squared"),
        ("mass_kg=3", "--set mass_kg: unknown key; a known total mass is --mass of analyse"),
        ("airframe.total_mass_kg=3", "unknown key; a known total mass is --mass of analyse"),
        ("airframe.mean_chord_m=3", "the mean chord is airframe.chord_m, in place of aspect_ratio"),
    ],
    "analyse twin-boom-design --set": [
        ("airframe.tail.arm_chords=-4", "arm_chords: must be greater than 0 (got -4)"),
        ("battery.pack=3", "battery.pack: must be a mapping of keys and values (got 3)"),
        ("battery.voltage.cells_in_series=100001", "must be at most 100000 (got 100001)"),
        ("battery.voltage.cells_in_series=5.5", "must be a whole number (got 5.5)"),
    ],
    "size": [
        (f"{DESIGN} -m .", ".: is a folder, not a file"),
        (f"{AS2} -m rafz-july", "airframe.kind: a measured aircraft cannot be sized"),
        (f"{DESIGN} -m climb.yaml --set {CLIMB_POWER}=1", "a mission with climb needs more"),
    ],
    f"size {DESIGN} -m rafz-july": [
        ("--required-excess-time -1", "is not in the range"),
        ("--required-excess-time nan", "must be a number of hours"),
        ("--required-excess-time inf", "is not in the range"),
        ("--objective min_cost", "'min_cost' is not one of 'max_excess_time'"),
        ("--certify", "--cross-check"),  # its old name
        ("--reliability 1.5", "1.5 is not in the range"),
        ("--reliability 1", "1.0 is not in the range 0.0<x<1.0"),
        ("--reliability 0.9 --sensitivities", "know of no --reliability"),
        ("--out ''", "--out"),
        ("--date '1 Jun' --day-of-year 3", "give --day-of-year or --date"),
        (f"{COLORADO} --survive 0.5 --latitude 40", "has its own place"),
        ("--survive 0.9", "--survive needs --weather as well"),
        (COLORADO, "--weather needs --survive as well"),
        (f"{COLORADO} --survive 1.5", "1.5 is not in the range 0.0<x<=1.0"),
        (f"{COLORADO} --survive 0", "0.0 is not in the range 0.0<x<=1.0"),
        ("--weather none.epw --survive 0.5", "there is no such file"),
        (f"{COLORADO} --survive 0.5 --reliability 0.9", "--reliability is of repeated clear days"),
        (f"{COLORADO} --survive 0.5 --required-excess-time 2", "time is of repeated clear days"),
        (f"{COLORADO} --survive 0.5 --objective longest_season", "longest_season counts days or"),
        (f"{COLORADO} --survive 0.5", "set the mission's latitude_deg"),
        (f"{COLORADO} --survive 0.5 {IN_COLORADO} {CLIMB.format('')}", "keep their altitude"),
        (f"{COLORADO} --survive 0.5 {IN_COLORADO} {CLIMB.format(CHOSEN)}", "not chosen by size"),
        ("--dpi 300", "--dpi is of the figure: give --out too"),
    ],
    f"size {DESIGN} -m central-europe-summer --required-excess-time 3 --whole-cells": [
        (f"{CELLS} --set 'modules.layout={WIDE_CELLS}'", "bays.0.cells: a row of cells of 0.4 m n"),
        (f"{CELLS} --set battery.pack.cells_in_series=7", "must be that of whole cells"),
        (f"{CELLS} --set 'modules.layout.strings={STRINGS}'", "must be from 17 to 19"),
        (f"{CELLS} --set modules.area_m2=2", "modules.area_m2: must be that of the 88 cells"),
        (PACK, "modules.layout: required key is missing: --whole-cells needs it"),
        (f"--set modules.cell=sunpower-e60 {LAYOUT}", "battery.pack: required key is missing"),
        *[
            (f"{CELLS} {option}", "--whole-cells does not go with")
            for option in (
                *("--sensitivities", "--cross-check", "--reliability 0.9"),
                "--objective longest_season",
            )
        ],
    ],
    f"ceiling {AS2}": [
        ("--highest 100", "--highest: must be above the mission's altitude_m of 536"),
        ("--highest nan", "--highest"),
        ("--highest 40000", "--highest"),
        ("--step nan", "--step"),
        ("--step 1", "--step"),
        ("--plot a.txt", "--plot"),
        ("--model FM --set mission.flight_path=null", "needs a flight path"),
        (POLAR_NIGHT, "polar night"),
        ("-m climb.yaml --set mission.climb.ceiling_m=536", "above the night's floor of 536 (got"),
    ],
    f"map {AS2}": [
        *[(f"--latitudes {grid}", "--latitudes") for grid in WRONG_GRIDS],
        ("--latitudes 45N:", "is no number and not first:last:step"),
        ("--latitudes 0:100:10", "must rise within -90 to 90 by a positive step (got 0:100:10)"),
        ("--days 1:3:0.5", "whole numbers"),
        ("--out map.txt", "must end in .nc, .csv"),
        ("--resize min_mass", "airframe.kind: "),
        ("--resize min_mass --endurance", "--endurance"),
        ("--scheduler tcp://a:1 --workers 2", "--workers"),
    ],
    "sweep": [
        (DESIGN, "--vary"),
        (f"{DESIGN} --vary wingspan_m=5:1:1", "must rise"),
        (f"{DESIGN} --vary wingspan=4,5", "--vary wingspan: unknown key; did you mean 'wings"),
        *[
            (f"{DESIGN} --vary wingspan_m=4,5 {options}", message)
            for options, message in [
                ("--out x.xls", ".nc, .csv, .parquet"),
                ("--pareto a b", "'a' is not one of wingspan_m,"),
                ("--sort -a", "'a' is not one of status, wingspan_m,"),
                ("--sort a --pareto a b", "--pareto or --sort"),
                ("--keep-parts", "needs --out or --work"),
                ("--scheduler here", "tcp://HOST:PORT"),
                ("--workers 0", "--workers"),
            ]
        ],
    ],
    f"explore {AS2} --no-browser": [
        ("--port 65536", "65536"),
        ("--port x", "not a valid integer"),
        ("--mission nowhere", "nowhere"),
        ("--set 'mission.climb={ceiling_m: 300}'", "must be at least the mission's altitude_m"),
        ("--set battery.mass_kg=-1", "battery.mass_kg"),
        ("--mission desert-center-48h --model FM", "flight path"),
    ],
    f"report {AS2}": [
        ("", "Missing option '--out'"),
        ("--out report.txt", "must end in .html or .pdf"),
    ],
    f"compare {AS2}": [
        ("--dpi 300", "--dpi is of the figure: give --plot or --out too"),
        ("--models CAM,XM", "'XM' is not one of CDM, CAM, VM, FM"),
        ("--models ''", "'' is not one of CDM, CAM, VM, FM"),
        ("--corrections all", "'all' is not one of none, report, loiter"),
        *[(f"--objective {name}", f"'{name}' is not one of 'max_") for name in NO_OBJECTIVES],
        *[(f"--required-excess-time {hours}", "--required-excess-time") for hours in ("nan", -1)],
        ("--out x --csv y.csv", "give --out, or --table and --plot, not both"),
        ("--table a.png", "'a.png' must end in .csv, .parquet, .xlsx"),
        ("--table ''", "needs the name of a file"),
        ("--plot figure.doc", "must end in .png, .svg, .pdf"),
        ("--models FM -m bare.yaml", "--models FM needs a flight path"),
        ("--set mission.latitude_deg=89 --set 'mission.dates={on: 12-21}'", "polar night"),
    ],
    "compare": [
        ("sky-sailor --models CAM,VM", "modules: --models VM needs the module surfaces"),
        ("sky-sailor --corrections loiter", "--corrections loiter needs the module"),
        ("atlantiksolar-as3", f"did you mean '{AS2}'"),
    ],
    f"verify {AS2} flight.csv": [
        ("--timezone Nowhere/Town", "must be UTC, an offset like +02:00"),
        ("--column power=P", "no such quantity"),
        ("--filter nan", "must be a number of seconds"),
        ("--window 9:8", "must be a:b in solar hours"),
    ],
    "uncertainty": [(f"{AS2} --no-model-error", "has an uncertain input")],
    f"map {DESIGN}": [
        (f"-m climb.yaml --resize min_mass --set {CLIMB_POWER}=1", "allowed: above 1 (got 1)"),
        (f"{HOLDING} {POLAR}", "latitude_deg -88 to 88 (got"),
        (
            f"{HOLDING} --set mission.wind.hold_station=false {POLAR} --resize min_wingspan",
            "to 88 (got 90)",
        ),
    ],
    "station": [
        (AS2, "station needs a parametric aircraft"),
        (DESIGN, "rafz-july: lacks wind: {percentile: ...}"),
        (f"{DESIGN} {HOLDING} --latitudes 80:90:5", "has latitude_deg -88 to 88 (got 90)"),
        (f"{DESIGN} {HOLDING} --altitudes 0:8000:4000", "m 9126 to 33043 (got 0)"),
        (f"{DESIGN} {WINDS}", "has altitude_m 9126 to 33043 (got 536)"),
        (f"{DESIGN} {HOLDING} {CEILING}", "climb: station flies at constant altitude"),
        (f"{DESIGN} -m climb.yaml", "climb.yaml:5:1: climb: station flies at constant altitude"),
        (f"{DESIGN} -m climb.yaml", "winds at several heights have none in common; remove climb"),
    ],
}


@pytest.mark.parametrize(
    ("call", "message"),
    [(f"{begin} {call}", text) for begin, calls in REFUSALS.items() for call, text in calls],
)
def test_wrong_calls(run, tmp_path, call, message):
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="latin-1")
    if "typical.epw" in call:
        record = clear_record(59, first="2001-01-01", interval_s=3600.0)
        write_epw(tmp_path / "typical.epw", record, years={1: 1996, 2: 1988})
    before = files(tmp_path)
    outcome = run(*shlex.split(call))
    assert (outcome.code, outcome.out) == (2, "")
    assert message in " ".join(outcome.err.split())
    # A line for each missing key of a file.
    assert outcome.err.startswith("Usage: ") or outcome.err.count("\n") <= 3
    assert files(tmp_path) == before


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (f"analyse {AS2} --plot no/a.png", "cannot write no/a.png: its folder does not exist"),
        (f"analyse {AS2} --csv no/a.csv", "cannot write no/a.csv: its folder does not exist"),
        (f"map {AS2} --out no/a.nc", "cannot write no/a.nc: its folder does not exist"),
        (f"map {AS2} --plot no/a.png", "cannot write no/a.png: its folder does not exist"),
        (f"report {AS2} --out no/a.html", "cannot write no/a.html: its folder does not exist"),
        (f"analyse {AS2} --plot file/a.png", "cannot write file/a.png: a part of the path is a fi"),
        (f"analyse {AS2} --csv file/a.csv", "cannot write file/a.csv: a part of the path is a fi"),
        (f"analyse {AS2} --plot folder.png", "cannot write folder.png: it is a folder"),
        (f"analyse {AS2} --table folder.csv", "cannot write folder.csv: it is a folder"),
        (f"map {AS2} --out folder.nc", "cannot write folder.nc: it is a folder"),
        (f"map {AS2} --out m.nc --work file", "cannot write to file: file is not a folder"),
        (f"map {AS2} --out m.nc --work /proc/x", "/proc/x: no folder can be made there"),
        (f"compare {AS2} --out file", "file is not a folder"),
        # Before the sizing: nothing of it is shown.
        *[
            (f"size {DESIGN} -m rafz-july --out {folder}", f"cannot write to {folder}: ")
            for folder in ("file", "file/design", "/proc/design")
        ],
    ],
)
def test_files_that_cannot_be_written(run, tmp_path, call, message):
    (tmp_path / "file").write_text("old")
    folders = {"folder.png", "folder.csv", "folder.nc"}
    for folder in folders:
        (tmp_path / folder).mkdir()
    outcome = run(*call.split())
    assert (outcome.code, outcome.out) == (1, "")
    assert message in outcome.err
    assert outcome.err.count("\n") == 1
    assert files(tmp_path) == {"file", *folders}
    assert (tmp_path / "file").read_text() == "old"


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
