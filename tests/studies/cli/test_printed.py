"""What commands print: lines that fit with whole words, and what to do next."""

import sys

import click
import pytest

from studies.cli import __main__ as main

AS2, DESIGN = "atlantiksolar-as2", "atlantiksolar-design"
JULY = ("-m", "rafz-july")
FORMS = [
    ("list",),
    ("analyse", AS2),
    ("analyse", AS2, "-m", "rafz-28h"),
    ("analyse", AS2, "-m", "central-europe-summer"),
    ("size", DESIGN, "-m", "rafz-july", "--sensitivities"),
    ("size", "sky-sailor", "-m", "rafz-july", "--required-excess-time", "30"),
    ("map", AS2, "--latitudes", "0:70:35", "--days", "1:361:180", "--endurance", "--workers", "1"),
    ("sweep", DESIGN, "--vary", "wingspan_m=3,5", "--vary", "aspect_ratio=14,18", "--workers", "1"),
    ("sweep", DESIGN, "--vary", "battery_mass_kg=2,3", "--pareto", "total_mass", "excess_time"),
    ("ceiling", AS2, "--highest", "5000", "--step", "2000"),
    ("uncertainty", DESIGN, "-m", "rafz-july", "--samples", "64"),
    ("compare", AS2, "--models", "CAM", "--corrections", "none"),
    ("reproduce-report",),
]


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMS, ids=" ".join)
def test_lines_fit_and_words_are_whole_at_any_width(run, monkeypatch, form):
    """Words of a broad print stand in the narrow ones as well, none cut and none broken."""
    printed = {}
    for width in (400, 80, 60):
        monkeypatch.setenv("COLUMNS", str(width))
        printed[width] = run(*form).out
        assert max(map(len, printed[width].splitlines())) <= width
        assert "\u2026" not in printed[width]
    broad = {word for word in printed[400].split() if not _varies(word)}
    for width in (80, 60):
        assert not broad - set(printed[width].split())


def _varies(word):
    """Rules, and times of the solver."""
    return set(word) <= {"\u2500"} or word.strip("(),").isdigit()


def test_a_pipe_has_80_columns_whatever_the_terminal(run, monkeypatch):
    monkeypatch.delenv("COLUMNS")
    outcome = run("size", DESIGN, "-m", "rafz-july")
    assert 60 < max(map(len, outcome.out.splitlines())) <= 80
    assert "\x1b" not in outcome.out


@pytest.fixture
def terminal(monkeypatch):
    """Somebody who reads along, as far as the commands can tell."""
    from studies.cli import outputs

    class Screen:
        def isatty(self):
            return True

    class System:
        stdout = stderr = Screen()

    monkeypatch.setattr(outputs, "sys", System)


@pytest.mark.long
@pytest.mark.usefixtures("terminal")
@pytest.mark.parametrize(
    ("form", "step"),
    [
        (("analyse", AS2), f"solar-uav map {AS2} (where and when else)"),
        (("analyse", AS2, "--date", "12-21"), f"solar-uav map {AS2} (where and when it flies"),
        (("analyse", DESIGN, "--set", "power.avionics_w=60"), f"solar-uav size {DESIGN} -m rafz"),
        (("size", DESIGN, *JULY, "--required-excess-time", "30"), "the same with --set "),
        (("size", DESIGN, "-m", "rafz-july"), "the same with --out FOLDER"),
        (("size", DESIGN, "-m", "rafz-july", "--out", "it"), "solar-uav report it --out "),
        (
            ("map", AS2, "--latitudes", "0:70:70", "--days", "1:361:180", "--workers", "1"),
            f"solar-uav report {AS2} --out report.html",
        ),
        (("sweep", DESIGN, "--vary", "wingspan_m=5"), f"solar-uav explore {DESIGN}"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_a_terminal_is_told_what_to_do_next(run, form, step):
    (line,) = [line for line in run(*form).err.splitlines() if "next: " in line]
    assert f"next: {step}" in line
    for verb in [words.split()[0] for words in line.split("solar-uav ")[1:]]:
        assert main.cli.get_command(click.Context(main.cli), verb) is not None


@pytest.mark.usefixtures("terminal")
def test_json_is_followed_by_nothing(run):
    assert run("analyse", AS2, "--json").err == ""


def test_a_pipe_is_told_nothing(run):
    assert not sys.stdout.isatty()
    assert run("analyse", AS2).err == ""
