"""The examples and the documentation do what they say."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from studies import doc_tables

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
PYTHON_API = ROOT / "docs" / "python-api.md"
SOLAR = ROOT / "docs" / "solar.md"
VALIDATION = ROOT / "docs" / "validation.md"

# Far above the seconds that they take, so that a busy machine does not fail the test.
TIMEOUT_S = 120


# Studies that draw a figure into a file if they are given one.
DRAWING = [
    ("compare_models.py", r"Sized with uncorrected CDM .* \(sized with corrected FM: a span of "),
    ("season_map.py", r"as built: share .*\n   0 N: 100 %\n"),
    (
        "corrected_against_uncorrected.py",
        r"55 N, 15 Jul\n  uncorrected CDM: \d\.\d\d m, comes down",
    ),
    ("battery_outlook.py", r"23 September, 500 Wh/kg: \d\.\d\d m"),
    ("design_chart.py", r"aspect ratio 18\.5\n  3 m: no battery .*\n  4 m: at most \d\.\d\d h"),
    ("payload_against_latitude.py", r" 2\.0 kg  ( +\d\.\d\d m){10}"),
    (
        "resized_map.py",
        r" -70 N: .*; else missed: .*sun\n(.*\n)+   0 N: 27 of 27 days have a design, \d\.\d\d to",
    ),
]


def run_python(*arguments: str, folder: Path) -> str:
    """Run this interpreter in a folder away from any source and return what it prints."""
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        encoding="utf-8",
        timeout=TIMEOUT_S,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def python_blocks(page: Path) -> list[str]:
    return re.findall(r"^```python\n(.*?)^```$", page.read_text(encoding="utf-8"), re.M | re.S)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("analyse_atlantiksolar.py", r"CAM, correction none  : excess time \d+\.\d\d h"),
        ("climb_and_ceiling.py", r"up to \d+ m, .*\n.* stores \d+\.\d Wh, .* adds \d+\.\d\d h"),
        ("size_an_aircraft.py", r"margin of 4 h: optimal\n  wingspan \d+\.\d\d m"),
    ],
)
def test_example_runs_and_prints_its_result(name: str, expected: str, tmp_path: Path) -> None:
    printed = run_python(str(EXAMPLES / name), folder=tmp_path)
    assert re.search(expected, printed), printed
    assert not list(tmp_path.iterdir()), "an example leaves files behind"


@pytest.mark.parametrize(("name", "expected"), DRAWING)
def test_study_prints_its_result_and_draws(name: str, expected: str, tmp_path: Path) -> None:
    printed = run_python(str(EXAMPLES / name), "figure.png", folder=tmp_path)
    assert re.search(expected, printed), printed
    assert [path.name for path in tmp_path.iterdir()] == ["figure.png"]
    assert (tmp_path / "figure.png").read_bytes().startswith(b"\x89PNG")


def test_every_example_is_tested() -> None:
    drawing = [name for name, _ in DRAWING]
    assert sorted(path.name for path in EXAMPLES.glob("*.py")) == sorted(
        ["analyse_atlantiksolar.py", "climb_and_ceiling.py", "size_an_aircraft.py", *drawing]
    )


@pytest.mark.parametrize("number", range(len(python_blocks(PYTHON_API))))
def test_python_block_of_the_documentation_runs(number: int, tmp_path: Path) -> None:
    printed = run_python("-c", python_blocks(PYTHON_API)[number], folder=tmp_path)
    assert printed.strip(), "the block prints nothing"


def test_own_sky_and_curve_are_used(tmp_path: Path) -> None:
    (block,) = python_blocks(SOLAR)
    printed = run_python("-c", block, folder=tmp_path)
    assert re.fullmatch(r"excess time \d\.\d\d h\n\d{4} Wh/m2\n", printed), printed


def test_python_page_has_blocks() -> None:
    assert len(python_blocks(PYTHON_API)) >= 5


@pytest.mark.parametrize("name", doc_tables.TABLES)
def test_table_of_the_documentation_is_up_to_date(name: str) -> None:
    page_name, make = doc_tables.TABLES[name]
    page = (VALIDATION.parent / page_name).read_text(encoding="utf-8")
    assert doc_tables.with_table(page, name, make()) == page, (
        f"docs/{page_name} is stale: run `python -m studies.doc_tables`"
    )


def test_page_without_its_markers_is_refused() -> None:
    with pytest.raises(ValueError, match="one pair of markers"):
        doc_tables.with_table("no markers here", "published", "table")


def test_the_folder_of_the_pages_must_be_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert doc_tables.main([str(tmp_path)]) == 1
    assert capsys.readouterr().err == (
        f"{tmp_path} has no validation.md: start this in a clone of the project, or name the "
        "folder of the pages\n"
    )


def test_a_missing_package_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def needs_pvlib() -> str:
        raise ImportError("No module named 'pvlib'")

    (tmp_path / "a.md").write_text("<!-- clear -->\n<!-- /clear -->\n")
    monkeypatch.setattr(doc_tables, "TABLES", {"clear": ("a.md", needs_pvlib)})
    assert doc_tables.main([str(tmp_path)]) == 1
    assert "No module named 'pvlib': install the extra 'test'" in capsys.readouterr().err
