"""The report in a browser: it asks for nothing, fits any window, can be read by all, and prints."""

from pathlib import Path
from typing import Any

import pytest
from browser_pages import DESKTOP, PHONE, Sheet, accessibility_problems, sheets, too_wide
from builders import DESIGN, shipped_mission

import sizing
from studies import make_report

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Report of a sizing with sensitivities; test_page_in_browser.py has those of aircraft."""
    study = sizing.size(
        DESIGN, shipped_mission("rafz-july"), "min_wingspan", with_sensitivities=True
    )
    page = make_report(study.sized_aircraft(), study.sized_mission(), sizing=study)
    path = tmp_path_factory.mktemp("reports") / "sized.html"
    path.write_text(page, encoding="utf-8")
    return path


def check_sheets(printed: list[Sheet]) -> None:
    """Sheets hold text, and are white paper."""
    assert 3 <= len(printed) <= 20
    for number, sheet in enumerate(printed, 1):
        assert len(sheet.text.split()) > 20, f"sheet {number} is nearly empty"
        assert 0.005 < sheet.ink < 0.5, f"sheet {number}"


@pytest.mark.parametrize(
    ("size", "dark"), [(DESKTOP, False), (PHONE, True)], ids=["desktop, light", "phone, dark"]
)
def test_any_window_in_light_and_dark(
    open_page: Any, report: Path, size: tuple[int, int], dark: bool
) -> None:
    page = open_page(report, size=size, dark=dark)
    assert too_wide(page) == []
    assert accessibility_problems(page) == []


def test_printed_from_a_dark_screen_it_is_full_and_light(open_page: Any, report: Path) -> None:
    check_sheets(sheets(open_page(report, dark=True).pdf(format="A4")))


def test_every_heading_is_printed(open_page: Any, report: Path) -> None:
    page = open_page(report)
    headings = page.locator("h2").all_inner_texts()
    text = " ".join(" ".join(sheet.text.split()) for sheet in sheets(page.pdf(format="A4")))
    assert [h for h in headings if h not in text] == []


def test_inputs_are_one_sheet_at_the_end(open_page: Any, report: Path) -> None:
    printed = sheets(open_page(report).pdf(format="A4"))
    *others, last = (" ".join(sheet.text.split()) for sheet in printed)
    for words in ("format_version: 1", "mission rafz-july", "pitch_deg: 0.0"):
        assert words in last
        assert not any(words in text for text in others)


def test_pdf_of_the_command_is_full_too(report: Path) -> None:
    """By WeasyPrint, which knows no script and other rules of breaking pages."""
    pytest.importorskip("weasyprint", exc_type=OSError, reason="WeasyPrint lacks Pango")
    from studies.report.pdf import to_pdf

    check_sheets(sheets(to_pdf(report.read_text(encoding="utf-8"))))
