"""Folders of results: complete, and good for the next command."""

import hashlib
import json
import re
from importlib import resources

import pytest
from command_line import FIELD, files

pytestmark = pytest.mark.slow

DESIGN = "atlantiksolar-design"
COMMON = {"aircraft.yaml", "mission.yaml", "run.json", "results.json"}


def contents(folder):
    return tuple(json.loads((folder / name).read_text()) for name in ("run.json", "results.json"))


@pytest.mark.parametrize(
    "options",
    [
        (),
        ("--required-excess-time", "3"),
        ("--objective", "max_payload_mass", "--required-excess-time", "1"),
        ("--objective", "max_payload_power", "--required-excess-time", "1"),
        ("--model", "FM", "--objective", "min_wingspan"),
        ("--model", "CDM", "--correction", "report", "--set", "mission.clearness=0.9"),
        ("--set", "mission.payload.mass_kg=0.4", "--set", "power.avionics_w=8"),
        ("--set", "mission.uncertainty_margins.solar_model_sigmas=1"),
    ],
    ids=" ".join,
)
def test_the_folder_of_a_sizing_gives_the_excess_time_of_the_sizing(run, tmp_path, options):
    asked = ("size", DESIGN, "-m", "rafz-july", *options, "--out", "a/design", "--json")
    sized = run(*asked).good().json()
    folder = tmp_path / "a" / "design"
    assert contents(folder)[1] == sized
    assert run("validate", "a/design/aircraft.yaml", "a/design/mission.yaml").code == 0
    flown = run("analyse", "a/design", "--json").json()
    simulated = sized["simulated"]
    # The mass is closed anew for the file: the tolerance is that of the closure.
    assert flown["excess_time_h"] == pytest.approx(simulated["excess_time_h"], abs=1e-3)
    assert flown["total_mass_kg"] == pytest.approx(simulated["total_mass_kg"], rel=1e-6)
    for key in ("model", "correction"):
        assert flown[key] == simulated[key]
    assert flown["mission"] == "rafz-july"
    assert flown["mission_is_default"] is False


@pytest.mark.parametrize("objective", ["longest_season", "widest_latitude_band"])
def test_the_folder_of_a_range_gives_its_worst_scenario(run, objective):
    asked = ("--objective", objective, "--required-excess-time", "2", "--out", "wide", "--json")
    sized = run("size", DESIGN, "-m", "rafz-28h", *asked).json()
    flown = run("analyse", "wide", "--json").json()
    assert len(flown["scenarios"]) > 10
    assert flown["excess_time_h"] == pytest.approx(sized["simulated"]["excess_time_h"], abs=1e-3)


def test_options_come_before_what_the_folder_says(run):
    run("size", DESIGN, "-m", "rafz-july", "--model", "CDM", "--out", "design")
    other = run("analyse", "design", "--model", "CAM", "-m", "central-europe-summer", "--json")
    record = other.json()
    assert (record["model"], record["mission"]) == ("CAM", "central-europe-summer")
    moved = run("analyse", "design", "--date", "12-21", "--json").json()
    assert (moved["model"], moved["day_of_year"]) == ("CDM", 355)
    assert run("size", "design", "--json").json()["mission"] == "rafz-july"


def test_the_record_of_a_run(run, tmp_path):
    (tmp_path / "field.yaml").write_text(FIELD)
    run("size", DESIGN, "-m", "field.yaml", "--set", "mission.clearness=0.95", "--out", "design")
    record, _ = contents(tmp_path / "design")
    assert record["command"] == (
        f"solar-uav size {DESIGN} -m field.yaml --set mission.clearness=0.95 --out design"
    )
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\+00:00", record["date_utc"])
    shipped = resources.files("sizing").joinpath("library", f"{DESIGN}.yaml").read_bytes()
    assert record["inputs"] == {
        "aircraft": {
            "source": f"{DESIGN} (shipped)",
            "sha256": hashlib.sha256(shipped).hexdigest(),
        },
        "mission": {"source": "field.yaml", "sha256": hashlib.sha256(FIELD.encode()).hexdigest()},
    }
    assert record.keys() >= {"version", "python", "libraries", "model", "correction"}
    assert record["libraries"].keys() >= {"numpy", "casadi"}
    assert "clearness: 0.95" in (tmp_path / "design" / "mission.yaml").read_text()


def test_files_of_ones_own_go_with_the_folder(run, tmp_path, monkeypatch):
    polar = resources.files("sizing").joinpath("data", "polars", "sd7037.csv").read_text()
    cell = "label: mine\nsource: measured by us\nefficiency_stc: 0.21\n"
    (tmp_path / "mine.csv").write_text(polar)
    (tmp_path / "cell.yaml").write_text(cell)
    aerodynamics = (
        "airframe.aerodynamics={model: wing_polar, airfoil: mine.csv, design_aspect_ratio: 18.5, "
        "design_reynolds: 200000}"
    )
    chosen = ("--set", "modules.cell=cell.yaml", "--set", "battery.cell=samsung-35e")
    asked = ("size", DESIGN, "-m", "rafz-july", "--set", aerodynamics, *chosen)
    sized = run(*asked, "--out", "design", "--json").good()
    taken = {one["key"]: one for one in sized.json()["from_catalogues"]}
    assert taken["modules.efficiency_stc"]["source"] == "measured by us"
    (tmp_path / "mine.csv").unlink()
    (tmp_path / "cell.yaml").unlink()
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    flown = run("analyse", "../design", "--json").json()
    excess_h = sized.json()["simulated"]["excess_time_h"]
    assert flown["excess_time_h"] == pytest.approx(excess_h, abs=1e-3)
    assert flown["from_catalogues"][0]["value"] == 0.21
    assert (tmp_path / "design" / "cell.yaml").read_text() == cell
    inputs = contents(tmp_path / "design")[0]["inputs"]
    assert inputs["airfoil"] == {
        "source": str(tmp_path / "mine.csv"),
        "sha256": hashlib.sha256(polar.encode()).hexdigest(),
    }
    assert inputs["cell"]["sha256"] == hashlib.sha256(cell.encode()).hexdigest()


@pytest.mark.parametrize(
    ("arguments", "own"),
    [
        (("compare", "sky-sailor", "--no-design"), {"comparison.csv", "comparison.png"}),
        (("reproduce-report",), {"report.md", "report.png"}),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else "",
)
def test_every_folder_is_complete(run, tmp_path, arguments, own):
    outcome = run(*arguments, "--out", "results", "--json").good()
    assert files(tmp_path / "results") == COMMON | own
    assert contents(tmp_path / "results")[1] == outcome.json()
    flown = run("analyse", "results", "--json").json()
    assert all(flown[key] == outcome.json()[key] for key in ("aircraft", "mission"))


DAMAGED = ["", "[]", "{}", '{"model": "XYZ", "correction": "none"}', "[" * 200_000, "9" * 9000]


@pytest.mark.parametrize(
    ("record", "said"),
    [
        (None, "r: is a folder without run.json; allowed: a folder that --out wrote, or a file\n"),
        *[(text, "r/run.json: is not the record of a run of solar-uav\n") for text in DAMAGED],
        (" " * 11_000_000, "is larger than 10 MB"),
    ],
    ids=range(len(DAMAGED) + 2),
)
def test_a_folder_without_the_record_of_a_run_is_refused(run, tmp_path, record, said):
    (tmp_path / "r").mkdir()
    if record is not None:
        (tmp_path / "r" / "run.json").write_text(record)
    outcome = run("analyse", "r")
    assert (outcome.code, outcome.out) == (2, "")
    assert said in outcome.err


def test_what_an_earlier_run_wrote_does_not_stay_beside_another_aircraft(run, tmp_path):
    size = ("size", "-m", "rafz-july", "--required-excess-time", "2", "--out", "both")
    (tmp_path / "both").mkdir()
    for name in ("notes.txt", "masses.csv"):
        (tmp_path / "both" / name).write_text("mine")
    assert run(*size, "sky-sailor", "--sensitivities").code == 0
    assert (tmp_path / "both" / "sensitivities.csv").exists()
    assert (tmp_path / "both" / "masses.csv").read_text() != "mine"
    assert run(*size, "atlantiksolar-design").code == 0
    names = {path.name for path in (tmp_path / "both").iterdir()}
    record = json.loads((tmp_path / "both" / "run.json").read_text())
    assert names == {*record["files"], "notes.txt"}
    assert "sensitivities.csv" not in names


def test_a_folder_of_a_newer_version_is_refused_with_the_line(run, tmp_path):
    assert run("size", "sky-sailor", "-m", "rafz-july", "--out", "sized").code == 0
    record, results = contents(tmp_path / "sized")
    assert record["format_version"] == results["format_version"] == 1
    for name in ("aircraft.yaml", "mission.yaml"):
        lines = (tmp_path / "sized" / name).read_text(encoding="utf-8").splitlines()
        assert lines[1] == "format_version: 1"
    del record["model"]
    path = tmp_path / "sized" / "run.json"
    path.write_text(json.dumps(record | {"format_version": 2}, indent=2), encoding="utf-8")
    outcome = run("analyse", "sized")
    assert (outcome.code, outcome.out) == (2, "")
    assert re.match(r"\S*run\.json:\d+: format_version: must be at most 1 \(got 2\)", outcome.err)


def test_a_folder_from_elsewhere_reaches_no_file_outside_of_it(run, tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    folder = tmp_path / "r"
    assert run("size", DESIGN, "-m", "rafz-july", "--out", "r").code == 0
    record = json.loads((folder / "run.json").read_text())
    (folder / "kept").mkdir()
    outside = ["..\\kept", "C:kept", "\\\\host\\kept", "sub\\kept"]  # names of files here alone
    for name in outside:
        (folder / name).write_text("mine")
    odd = ["../mine.txt", str(tmp_path / "mine.txt"), "kept", "..", "a\0b", "\x1b", "old.csv"]
    for names in ([*odd[:-1], 7], odd):
        record["files"] = [*outside, *names]
        (folder / "run.json").write_text(json.dumps(record))
        (folder / "old.csv").write_text("of an earlier run")
        (folder / "results.json").unlink()
        (folder / "results.json").symlink_to(tmp_path / "mine.txt")
        assert run("size", DESIGN, "-m", "rafz-july", "--out", "r").code == 0
    assert (tmp_path / "mine.txt").read_text() == "mine"
    assert (folder / "kept").is_dir()
    assert all((folder / name).exists() for name in outside)
    assert not (folder / "old.csv").exists()
