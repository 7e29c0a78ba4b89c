"""The examples and the documentation do what they say."""

import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest
from documented import blocks

from benchmarks import doc_tables

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
SOLAR = ROOT / "docs" / "solar.md"
VALIDATION = ROOT / "docs" / "validation.md"

# Far above the minute that the longest takes, so that a busy machine does not fail the test.
TIMEOUT_S = 600


# What a script does for many values does the same for a few.
FEWER = {
    "climb_gain.py": ("np.arange(1, 366, 28)", "np.arange(1, 366, 91)"),
    "span_for_a_season.py": ("SHARES = (0.5, 0.7, 0.8, 0.9, 0.95, 0.99)", "SHARES = (0.5, 0.95)"),
}
COUPLED = "openmdao_component.py"  # needs OpenMDAO
TELLING = [("size_an_aircraft.py", r"of 4 h\n.*: optimal\nwingspan +\d\.\d+ m(.*\n)+on a circle")]
# Studies that draw a figure into a file if they are given one.
DRAWING = [
    ("compare_models.py", r"Sized with uncorrected CDM, .* \(sized with corrected FM: a span of "),
    ("season_map.py", r"as built: share .*\n   0 N: 100 %\n"),
    ("battery_outlook.py", r"23 September, 500 Wh/kg: \d\.\d\d m"),
    ("design_chart.py", r"aspect ratio 18\.5\n  3 m: no battery .*\n  4 m: at most \d\.\d\d h"),
    (
        "twin_boom_propulsion.py",
        r"18\.0 V: at best 0\.\d{3} with (.*\n)+two motors: 6\.\d\d kg.*\none geared motor: ",
    ),
    ("reliable_design.py", r"no margin: 3\.\d\d m, 3\d\.\d %\n(.*\n)+99 %: 4\.\d\d m"),
    (
        "span_for_a_season.py",
        r"for a clear sky: 3\.\d\d m, 3\d\.\d % of the days\n50 %: \d\.\d\d m",
    ),
    ("payload_against_latitude.py", r" 2\.0 kg  ( +\d\.\d\d m){10}"),
    ("climb_gain.py", r"have no design in one of both\n 0 N: 10\.\d to 1\d\.\d % lighter"),
    (
        "resized_map.py",
        r" -70 N: .*; else missed: .*sun\n(.*\n)+   0 N: 27 of 27 days have a design, \d\.\d\d to",
    ),
]


@pytest.fixture
def run_script(tmp_path, monkeypatch, capsys, registries, tmp_path_factory):
    """Run a file as a script, in this process, from an empty folder; return what it prints."""
    monkeypatch.chdir(tmp_path)
    # Other tests start processes; here they would only import everything again.
    monkeypatch.setattr("studies.engine.workers.available_cores", lambda: 1)
    # Rougher probabilities do.
    monkeypatch.setattr("sizing.program.reliability.SEARCH_SAMPLES", 512)
    # So do longer steps through a weather record.
    monkeypatch.setattr("sizing.program.survival.NODE_STEP_S", 1800.0)
    monkeypatch.setattr("sizing.program.reliability.VERIFICATION_SAMPLES", 1000)

    def run(script, *arguments):
        monkeypatch.setattr(sys, "argv", [str(script), *arguments])
        if script.name in FEWER:
            many, few = FEWER[script.name]
            text = script.read_text(encoding="utf-8")
            assert text.count(many) == 1
            script = tmp_path_factory.mktemp("fewer") / script.name
            script.write_text(text.replace(many, few), encoding="utf-8")
        runpy.run_path(str(script), run_name="__main__")
        return capsys.readouterr().out

    return run


@pytest.mark.parametrize(
    ("name", "expected", "drawn"),
    [*((*one, []) for one in TELLING), *((*one, ["figure.png"]) for one in DRAWING)],
    ids=[name for name, _ in (*TELLING, *DRAWING)],
)
def test_example_prints_its_result_and_draws(name, expected, drawn, run_script, tmp_path):
    printed = run_script(EXAMPLES / name, *drawn)
    assert re.search(expected, printed), printed
    assert [path.name for path in tmp_path.iterdir()] == drawn, "an example leaves files behind"
    assert all((tmp_path / one).read_bytes().startswith(b"\x89PNG") for one in drawn)


def test_example_runs_in_a_process_of_its_own(tmp_path):
    # The others run in the process of the tests, which saves each of them its imports.
    command = [sys.executable, str(EXAMPLES / "size_an_aircraft.py")]
    done = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, timeout=TIMEOUT_S, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "on a circle, by FM: excess time" in done.stdout


@pytest.mark.extra
def test_example_that_couples_models_prints_its_result(run_script):
    pytest.importorskip("openmdao.api")
    printed = run_script(EXAMPLES / COUPLED)
    assert re.search(r"battery 2\.\d+ kg, excess time 3\.00 h\n", printed), printed


def test_every_example_is_tested():
    tested = [COUPLED, *(name for name, _ in (*TELLING, *DRAWING))]
    assert sorted(path.name for path in EXAMPLES.glob("*.py")) == sorted(tested)


def test_own_sky_and_curve_are_used(run_script, tmp_path_factory):
    (block,) = [block.text for block in blocks(SOLAR) if block.language == "python"]
    script = tmp_path_factory.mktemp("sky") / "sky.py"
    script.write_text(block, encoding="utf-8")
    printed = run_script(script)
    assert re.fullmatch(r"excess time \d\.\d\d h\n\d{4} Wh/m2\n", printed), printed


@pytest.mark.parametrize("name", doc_tables.TABLES)
def test_table_of_the_documentation_is_up_to_date(name):
    page_name, make = doc_tables.TABLES[name]
    page = (VALIDATION.parent / page_name).read_text(encoding="utf-8")
    assert doc_tables.with_table(page, name, make()) == page, (
        f"docs/{page_name} is stale: run `python -m benchmarks.doc_tables`"
    )
