"""Mistakes in files and options: messages and exit codes of the command line."""

import os
import re
import shlex
from pathlib import Path

import pytest
from command_line import BIRD, FIELD, edited, files
from refusals import refusals
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


TABLE = Path(__file__).with_name("refusals.txt")


@pytest.mark.parametrize(("begin", "call", "message"), refusals(TABLE))
def test_wrong_calls(run, tmp_path, begin, call, message):
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="latin-1")
    if "typical.epw" in call:
        record = clear_record(59, first="2001-01-01", interval_s=3600.0)
        write_epw(tmp_path / "typical.epw", record, years={1: 1996, 2: 1988})
    before = files(tmp_path)
    outcome = run(*shlex.split(f"{begin} {call}"))
    assert (outcome.code, outcome.out) == (2, "")
    assert message in " ".join(outcome.err.split())
    # A line for each missing key of a file.
    assert outcome.err.startswith("Usage: ") or outcome.err.count("\n") <= 3
    assert files(tmp_path) == before


@pytest.mark.parametrize(("_", "call", "message"), refusals(TABLE.with_name("unwritable.txt")))
def test_files_that_cannot_be_written(run, tmp_path, _, call, message):
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
