"""Tests of the command line: small commands, odd names, and the command as a process."""

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import click
import pytest
from command_line import BIRD, FIELD, edited, files

from missions.files.shipped import shipped_text
from sizing.library import load_aircraft
from sizing.results.design_result import RECOMMENDED_STALL_MARGIN
from sizing.validity.ranges import ranges
from studies.cli import __main__ as cli

AS2, DESIGN = "atlantiksolar-as2", "atlantiksolar-design"


def test_starters_validate_analyse_and_size(run, tmp_path):
    outcome = run("init", "heron").good()
    assert files(tmp_path) == {"heron.yaml", "heron-mission.yaml"}
    outcome = run("validate", "heron.yaml", "heron-mission.yaml").good()
    assert outcome.out == "heron.yaml: valid aircraft\nheron-mission.yaml: valid mission\n"
    mission = ("-m", "heron-mission.yaml", "--json")
    assert run("analyse", "heron.yaml", *mission).json()["aircraft"] == "heron"
    default = "solar-uav: the default mission is used; the one beside: -m heron-mission.yaml\n"
    assert run("analyse", "heron.yaml").err == default
    # The mission beside an aircraft is the one to size for.
    outcome = run("size", "heron.yaml", "--json")
    assert outcome.err == "solar-uav: flown is the mission beside it, -m heron-mission.yaml\n"
    record = outcome.json()
    assert (record["mission"], record["mission_is_default"]) == ("heron-mission", False)
    assert record["status"] == "optimal"
    assert record["simulated"]["excess_time_h"] >= 3.0


def test_starters_give_names_and_the_same_numbers_in_comments(run, tmp_path):
    run("init", "heron")
    path, mission = tmp_path / "heron.yaml", ("-m", "heron-mission.yaml", "--json")
    record = run("analyse", "heron.yaml", *mission).json()
    # Data sheet of the 50E: 4.9 Ah at 3.6 V in 69 g; nine tenths of the pack are cells.
    given = {one["key"]: one["value"] for one in record["from_catalogues"]}
    assert given["battery.specific_energy_wh_per_kg"] == pytest.approx(0.9 * 4.9 * 3.6 / 0.069)
    text = re.sub(r"^  (cell|cell_mass_fraction|mppt_board):.*\n", "", path.read_text(), flags=re.M)
    for key in given:
        text, count = re.subn(rf"^  # ({key.split('.')[1]}:)", r"  \1", text, flags=re.MULTILINE)
        assert count == 1, key
    path.write_text(text)
    by_numbers = run("analyse", "heron.yaml", *mission).json()
    assert "from_catalogues" not in by_numbers
    # The comments have three digits.
    assert by_numbers["total_mass_kg"] == pytest.approx(record["total_mass_kg"], rel=1e-3)
    energy = record["battery_energy_wh"]
    assert by_numbers["battery_energy_wh"] == pytest.approx(energy, rel=1e-3)


def test_starters_have_parts_of_the_propulsion_in_comments(run, tmp_path):
    run("init", "heron")
    path = tmp_path / "heron.yaml"
    text = re.sub(r"(?s)^  propulsion:.*?(?=^  #)", "", path.read_text(), flags=re.M)
    parts = "propulsion|  kind|  propeller|  gear|  motor|  controller|voltage"
    path.write_text(re.sub(rf"^  # ({parts}):", r"  \1:", text, flags=re.MULTILINE))
    record = run("analyse", "heron.yaml", "-m", "heron-mission.yaml", "--json").json()
    assert record["power_budget"]["efficiencies"]["chain"] == pytest.approx(
        0.9 * 0.82 * 0.96 * 0.75, abs=0.03
    )  # as the constants


def test_starters_keep_off_the_stall_and_look_where_their_models_were_checked(run):
    run("init", "heron")
    space, known = load_aircraft("heron.yaml").design_space, ranges()["wingspan_m", "rib_wing"]
    assert (space.wingspan_m.minimum, space.wingspan_m.maximum) == (known.minimum, known.maximum)
    polar = load_aircraft("heron.yaml").parametric.aerodynamics
    ratio = polar.maximum_lift_coefficient / polar.flight_lift_coefficient
    assert ratio**0.5 >= RECOMMENDED_STALL_MARGIN


def test_starters_overwrite_nothing(run, tmp_path):
    (tmp_path / "heron-mission.yaml").write_text("mine")
    outcome = run("init", "heron")
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err == "heron-mission.yaml: exists already and is not overwritten\n"
    assert files(tmp_path) == {"heron-mission.yaml"}


@pytest.mark.parametrize("name", ["heron.yaml", "heron.YML", "12", "1e5", "null", "true"])
def test_starters_of_any_name_are_valid(run, tmp_path, name):
    outcome, stem = run("init", name), name.partition(".")[0]
    assert outcome.code == 0
    assert outcome.out.splitlines()[-2:] == [
        f"then: solar-uav {verb} {stem}.yaml --mission {stem}-mission.yaml"
        for verb in ("analyse", "size")
    ]
    assert files(tmp_path) == {f"{stem}.yaml", f"{stem}-mission.yaml"}
    assert run("validate", *files(tmp_path)).code == 0


def test_validation_reports_every_file(run, tmp_path):
    (tmp_path / "bird.yaml").write_text(BIRD)
    (tmp_path / "field.yaml").write_text(edited(FIELD, "on: 07-15", "on: 02-30"))
    (tmp_path / "broken.yaml").write_text("a: [")
    (tmp_path / "heavy.yaml").write_text(
        edited(edited(BIRD, "  mass_kg: 2.918", "  mass_kg: -1"), "avionics_w: 6.0", "avionics: 6")
    )
    outcome = run("validate", "broken.yaml", "heavy.yaml", "bird.yaml", "field.yaml", "none.yaml")
    assert outcome.code == 2
    assert outcome.out == "bird.yaml: valid aircraft\n"
    places = {line.split(":")[0] for line in outcome.err.splitlines()}
    assert places == {f"{name}.yaml" for name in ("broken", "heavy", "field", "none")}
    assert "heavy.yaml:15:12: battery.mass_kg: must be greater than 0 (got -1)" in outcome.err
    assert "heavy.yaml:24:3: power.avionics: unknown key; did you mean 'avionics_w'?" in outcome.err


def test_list(run):
    outcome = run("list").good()
    shipped = run("list", "--json").json()
    assert shipped.keys() == {"aircraft", "mission", "weather"}
    assert {AS2, DESIGN, "sky-sailor"} <= shipped["aircraft"].keys()
    assert {"rafz-july", "rafz-81h", "central-europe-summer"} <= shipped["mission"].keys()
    for descriptions in shipped.values():
        for name, description in descriptions.items():
            assert description
            assert name in outcome.out
            assert set(description.split()) <= set(outcome.out.split())


@pytest.mark.parametrize("kind", ["cells", "batteries", "motors"])
def test_list_of_a_catalogue(run, kind):
    outcome = run("list", f"--{kind}").good()
    record = run("list", f"--{kind}", "--json").json()
    for name, one in record.items():
        assert name in outcome.out
        assert one["label"]
        assert one["source"]


def test_show_prints_files_to_start_from(run, tmp_path):
    shipped = run("list", "--json").json()
    for name in (*shipped["aircraft"], *shipped["mission"]):
        outcome = run("show", name).good()
        (tmp_path / f"{name}-copy.yaml").write_text(outcome.out, encoding="utf-8")
        assert run("validate", f"{name}-copy.yaml").code == 0


@pytest.mark.parametrize(
    "command",
    [
        ("analyse", AS2),
        ("size", DESIGN, "-m", "rafz-july"),
        ("map", AS2),
        ("sweep", DESIGN, "--vary", "battery_mass_kg=2,3"),
        ("compare", AS2),
        ("ceiling", AS2),
        ("station", DESIGN),
        ("verify", AS2, "log.csv"),
    ],
    ids=lambda command: command[0],
)
def test_every_command_that_reads_files_takes_overrides(run, command):
    outcome = run(*command, "--set", "power.avionic_w=8", "--set", "mission.clearnes=0.8")
    assert outcome.code == 2
    assert outcome.err.splitlines() == [
        "--set power.avionic_w: unknown key; did you mean 'avionics_w'?",
        "--set mission.clearnes: unknown key; did you mean 'clearness'?",
    ]


@pytest.mark.long
def test_where_nothing_helps_alone_the_map_is_named(run):
    impossible = ("--latitude", "60", "--date", "12-21")
    heavy = ("--set", "battery.specific_energy_wh_per_kg=50")
    outcome = run("size", DESIGN, "-m", "rafz-july", *impossible, *heavy)
    assert outcome.code == 1
    said = " ".join(outcome.out.split())
    assert "no single one makes it feasible of: technology" in said
    assert "solar-uav map --resize min_mass" in said


def test_a_negative_excess_time_is_explained_where_it_stands(run):
    winter = ("--latitude", "50", "--date", "12-21")
    said = "time of the day without enough power"
    assert said in " ".join(run("analyse", AS2, *winter).out.split())
    assert said not in " ".join(run("analyse", AS2).out.split())
    there = ("--set", "mission.latitude_deg=50", "--set", "mission.dates={on: 12-21}")
    sweep = run("sweep", AS2, *there, "--vary", "battery_mass_kg=2,3").out
    assert said in " ".join(sweep.split())
    grid = run("map", AS2, "--latitudes", "60", "--days", "350").out
    assert said in " ".join(grid.split())


def test_places_and_dates_as_they_are_printed(run):
    usual = run("analyse", AS2, "--latitude", "-33.9", "--date", "12-21", "--json").json()
    assert run("analyze", AS2, "--latitude", "33.9 S", "--date", "21 Dec", "--json").json() == usual
    grid = ("--days", "100:200:100", "--json")
    south = run("map", AS2, "--latitudes", "-40:50:45", *grid).out
    assert run("map", AS2, "--latitudes", "40S:50N:45", *grid).out == south
    # A single latitude is a grid of one.
    record = run("map", AS2, "--latitudes", "45N", "--days", "172", "--json").json()
    assert (record["latitude_deg"], record["days"]) == ([45.0], [172])


def test_a_known_total_mass_is_met(run):
    outcome = run("analyse", DESIGN, "--mass", "8", "--json")
    masses = outcome.json()["masses_kg"]
    assert sum(masses.values()) == pytest.approx(8.0, abs=1e-6)
    other = f"airframe.other_mass_kg is {masses['other']:.4g} instead of 0.322"
    assert outcome.err == f"solar-uav: --mass 8: {other}\n"


@pytest.mark.parametrize("aircraft", [AS2, DESIGN])
def test_a_known_total_mass_holds_in_every_study(run, aircraft):
    place = ("--mass", "7", "--latitude", "45", "--date", "06-21", "--json")
    short = run("analyse", aircraft, *place, "--set", "battery.mass_kg=1.5").json()
    remedy = next(r for r in short["relaxations"] if r["parameter"] == "battery.mass_kg")
    heavier = ("--set", f"battery.mass_kg={remedy['value']}")
    enough = run("analyse", aircraft, *place, *heavier).json()
    assert enough["excess_time_h"] == pytest.approx(remedy["excess_time_h"], abs=1e-9)
    assert enough["total_mass_kg"] == pytest.approx(7.0, abs=1e-6)
    # At every point of a trade study as well.
    there = ("--set", "mission.latitude_deg=45", "--set", "mission.dates={on: 06-21}")
    varied = ("--vary", f"battery_mass_kg={remedy['value']},7.5")
    points = run("sweep", aircraft, *there, *varied, "--mass", "7", "--json").json()["points"]
    assert points[0]["excess_time"] == pytest.approx(enough["excess_time_h"], abs=1e-9)
    assert points[1]["status"] == "infeasible"
    assert "total mass of 7 kg" in points[1]["message"]


@pytest.mark.parametrize("chordwise", ["aspect_ratio=12.5", "chord_m=0.4", "wing_area_m2=2.0"])
def test_chord_or_area_stand_for_the_aspect_ratio(run, chordwise):
    wing = ("analyse", DESIGN, "--json", "--set", "airframe.wingspan_m=5", "--set")
    record, expected = (
        run(*wing, f"airframe.{key}").json() for key in (chordwise, "aspect_ratio=12.5")
    )
    assert record["total_mass_kg"] == pytest.approx(expected["total_mass_kg"], rel=1e-12)


def test_version_and_helps(run):
    assert re.fullmatch(r"solar-uav, version \S+\n", run("--version").out)
    for command in cli.cli.list_commands(click.Context(cli.cli)):
        page = run(command, "-h").good()
        assert re.match(rf"Usage: .*solar-uav {command} ", page.out)


@pytest.mark.parametrize("command", [("analyse", AS2), ("size", DESIGN, "-m", "rafz-july")])
def test_brackets_and_dollars_in_a_name(run, command):
    outcome = run(*command, "--set", "name='[/]a[red]'").good()
    assert "[/]a[red]" in outcome.out
    if command[0] == "analyse":
        run(*command, "--set", "name='$x^{2$'", "--plot", "a.png").good()


@pytest.mark.parametrize("name", ["", "a\nb", 5000 * "a"])
def test_odd_names_of_aircraft(run, name):
    outcome = run("analyse", name)
    assert outcome.code == 2
    assert outcome.err.count("\n") == 1
    assert not outcome.err.startswith(":")
    assert len(outcome.err) < 1000


ROOT = str(Path(cli.__file__).parents[2])


def python(*words, cwd=None, **variables):
    """Outcome of Python in a process, in which the same packages are found from any folder."""
    return subprocess.run(
        [sys.executable, *words],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": ROOT, **variables},
    )


def imported(*calls):
    """Output of each call, one after the other in one process, and all modules imported by then."""
    code = (
        "import contextlib, io, json, sys\n"
        "from studies.cli.start import start\n"
        "told = []\n"
        "for arguments in json.loads(sys.argv[1]):\n"
        "    sys.argv = ['solar-uav', *arguments]\n"
        "    out = io.StringIO()\n"
        "    with contextlib.suppress(SystemExit), contextlib.redirect_stdout(out):\n"
        "        start()\n"
        "    told.append([out.getvalue(), [n for n, m in sys.modules.items() if m]])\n"
        "print(json.dumps(told))\n"
    )
    told = python("-c", code, json.dumps(calls)).stdout
    return [(out, set(modules)) for out, modules in json.loads(told)]


HEAVY = {
    *("numpy", "casadi", "pandas", "matplotlib", "xarray", "scipy", "pydantic", "rich"),
    *("h5netcdf", "dask", "distributed", "starlette", "jinja2"),
}


def heavy(modules):
    return HEAVY & {name.partition(".")[0] for name in modules}


def test_help_imports_nothing_heavy():
    commands = cli.cli.list_commands(click.Context(cli.cli))
    for out, modules in imported(("--help",), *((name, "--help") for name in commands)):
        assert "Usage: solar-uav" in out
        assert not heavy(modules)


SMALL = ("--latitudes", "40:50:10", "--days", "100:200:100")


@pytest.mark.long
@pytest.mark.parametrize(
    ("arguments", "needed", "most"),
    [
        (("--help",), "", 170),
        (("list",), "", 220),
        (("analyse", AS2), "numpy pydantic", 560),
        (("size", DESIGN, "-m", "rafz-july"), "numpy pydantic casadi", 900),
        (("map", AS2, *SMALL), "numpy pydantic rich", 610),
        (("map", AS2, *SMALL, "--out", "{folder}/map.nc"), "numpy pydantic rich h5netcdf", 680),
        (("sweep", DESIGN, "--vary", "wingspan_m=4,5"), "numpy pydantic rich xarray pandas", 1150),
    ],
    ids=lambda value: " ".join(value[:1]) if isinstance(value, tuple) else "",
)
def test_command_imports_what_its_result_needs(arguments, needed, most, tmp_path):
    """Matplotlib, pandas, SciPy and xarray take longer than these commands themselves.

    The number of modules stands for the time that a machine under load would not tell; Python and
    libraries of other versions may bring a few more or less.
    """
    ((out, modules),) = imported(tuple(a.format(folder=tmp_path) for a in arguments))
    assert out
    assert heavy(modules) == set(needed.split())
    assert len(modules) <= most


@pytest.mark.long
def test_no_home_and_a_poor_terminal(tmp_path):
    poor = {"LC_ALL": "C", "PYTHONIOENCODING": "ascii", "COLUMNS": "30", "HOME": "/nonexistent"}
    words = ("analyse", AS2, "-m", "central-europe-summer")
    done = python("-m", "studies.cli", *words, cwd=tmp_path, **poor)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.isascii()
    assert "45 N" in done.stdout
    assert "excess time" in done.stdout


def test_mistake_ends_without_a_traceback(tmp_path):
    (tmp_path / "bird.yaml").write_text(edited(BIRD, "avionics_w: 6.0", "avionics_w: -6"))
    done = python("-m", "studies.cli", "analyse", "bird.yaml", cwd=tmp_path)
    said = "bird.yaml:24:15: power.avionics_w: must be at least 0 (got -6)\n"
    assert (done.returncode, done.stdout, done.stderr) == (2, "", said)


@pytest.mark.skipif(sys.platform == "win32", reason="pipes and signals of POSIX")
def test_closed_pipe_ends_quietly(tmp_path):
    with subprocess.Popen(
        [sys.executable, "-m", "studies.cli", "list"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": ROOT},
    ) as running:
        running.stdout.close()
        said = running.stderr.read()
    assert b"Traceback" not in said
    assert b"Exception" not in said


@pytest.fixture
def interruptible():
    """Python leaves an interrupt ignored that a background job of a shell was started with."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


STOPPED = {"SIGINT": "solar-uav: stopped by Ctrl-C", "SIGTERM": "solar-uav: stopped by SIGTERM"}


@pytest.mark.parametrize(
    ("arguments", "module", "function"),
    [
        (("analyse", AS2, "--csv", "a.csv"), "sizing.results.analysis", "analyse"),
        (("size", DESIGN, "-m", "rafz-july", "--out", "a"), "sizing.results.sizing", "size_aircraft"),  # noqa: E501
        (("compare", AS2, "--no-design", "--out", "a"), "studies.models.comparison", "compare"),
        (("ceiling", AS2, "--csv", "a.csv"), "studies.ceiling", "highest_perpetual_altitude"),
        (("reproduce-report", "--out", "a"), "studies.models.report_reproduction", "reproduce"),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else "",
)  # fmt: skip
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
@pytest.mark.usefixtures("interruptible")
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_a_signal_ends_with_one_line(run, tmp_path, monkeypatch, arguments, module, function, name):
    number = getattr(signal, name)
    ours = signal.getsignal(number)

    def act(*arguments, **options):
        assert signal.getsignal(number) is not ours  # else the tests would end
        os.kill(os.getpid(), number)

    monkeypatch.setattr(f"{module}.{function}", act)
    outcome = run(*arguments)
    assert outcome.code == 128 + number
    assert (outcome.out, outcome.err.strip()) == ("", STOPPED[name])
    assert files(tmp_path) == set()
    assert signal.getsignal(number) is ours


@pytest.mark.long
@pytest.mark.parametrize(
    ("act", "code"),
    [("swallow()", 130), ("[swallow(), time.sleep(60)]", 130), ("stubborn()", -signal.SIGINT)],
    ids=["swallowed at the end", "swallowed amid work", "a second one"],
)
@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_a_signal_that_is_swallowed_ends_the_command(tmp_path, act, code):
    program = (
        "import contextlib, os, signal, sys, time\n"
        # Python leaves an interrupt ignored that a background job of a shell was started with.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "from studies.cli.__main__ import main\n"
        "from studies.models import report_reproduction\n"
        "def swallow():\n"
        "    with contextlib.suppress(KeyboardInterrupt):\n"
        "        os.kill(os.getpid(), signal.SIGINT)\n"
        "    return []\n"
        "def stubborn():\n"
        "    try:\n"
        "        os.kill(os.getpid(), signal.SIGINT)\n"
        "    finally:\n"
        "        os.kill(os.getpid(), signal.SIGINT)\n"
        "        time.sleep(30)\n"
        f"report_reproduction.reproduce = lambda *arguments, **options: {act}\n"
        "sys.argv = ['solar-uav', 'reproduce-report']\n"
        "main()\n"
    )
    done = python("-c", program, cwd=tmp_path)
    assert done.returncode == code
    assert "Traceback" not in done.stderr
    if "sleep" in act:
        assert (done.stdout, done.stderr.strip()) == ("", STOPPED["SIGINT"])


def test_a_deprecated_key_is_told_in_one_line(run, tmp_path, monkeypatch):
    text = shipped_text("rafz-july").replace("altitude_m:", "height_m:")
    (tmp_path / "old.yaml").write_text(text, encoding="utf-8")
    names = {"height_m": "altitude_m"}
    monkeypatch.setattr("missions.mission.Mission.deprecated_keys", names, raising=False)
    outcome = run("validate", "old.yaml")
    assert (outcome.code, outcome.out) == (0, "old.yaml: valid mission\n")
    assert outcome.err.startswith("note: old.yaml:9:1: height_m: is called 'altitude_m' now; ")
    assert outcome.err.count("\n") == 1
