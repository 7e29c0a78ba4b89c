"""The report in a browser: it asks for nothing, fits any window, can be read by all, and prints."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from browser_pages import DESKTOP, PHONE, accessibility_problems, sheets, too_wide
from builders import AS2, DESIGN, shipped_mission

import sizing
from studies.report import make_report

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.fixture(scope="module")
def reports(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Reports of a measured aircraft, and of a sizing with sensitivities."""
    folder = tmp_path_factory.mktemp("reports")
    mission = shipped_mission("rafz-july")
    study = sizing.size(DESIGN, mission, "min_wingspan", with_sensitivities=True)
    pages = {
        "measured": make_report(AS2, mission),
        "sized": make_report(study.sized_aircraft(), study.sized_mission(), sizing=study),
    }
    for name, page in pages.items():
        (folder / name).with_suffix(".html").write_text(str(page), encoding="utf-8")
    return {name: (folder / name).with_suffix(".html") for name in pages}


@pytest.mark.parametrize("name", ["measured", "sized"])
@pytest.mark.parametrize(
    ("size", "dark"),
    [(DESKTOP, False), (PHONE, True)],
    ids=["desktop, light", "phone, dark"],
)
def test_any_window_in_light_and_dark(
    open_page: Any, reports: dict[str, Path], name: str, size: tuple[int, int], dark: bool
) -> None:
    page = open_page(reports[name], size=size, dark=dark)
    assert too_wide(page) == []
    assert accessibility_problems(page) == []


@pytest.mark.parametrize("name", ["measured", "sized"])
def test_printed_sheets_are_full_and_light(
    open_page: Any, reports: dict[str, Path], name: str
) -> None:
    """Printed from a dark screen, too: nobody prints on black paper."""
    page = open_page(reports[name], dark=True)
    printed = sheets(page.pdf(format="A4"))
    assert 3 <= len(printed) <= 20
    for number, sheet in enumerate(printed, 1):
        assert len(sheet.text.split()) > 20, f"sheet {number} is nearly empty"
        assert 0.005 < sheet.ink < 0.5, f"sheet {number}"


def test_every_heading_is_printed(open_page: Any, reports: dict[str, Path]) -> None:
    page = open_page(reports["sized"])
    headings = page.locator("h2").all_inner_texts()
    text = " ".join(" ".join(sheet.text.split()) for sheet in sheets(page.pdf(format="A4")))
    assert [h for h in headings if h not in text] == []


def test_pdf_of_the_command_is_full_too(reports: dict[str, Path]) -> None:
    """By WeasyPrint, which knows no script and other rules of breaking pages."""
    pytest.importorskip("weasyprint", exc_type=OSError, reason="WeasyPrint lacks Pango")
    from studies.report.pdf import to_pdf

    printed = sheets(to_pdf(reports["sized"].read_text(encoding="utf-8")))
    assert 3 <= len(printed) <= 20
    for number, sheet in enumerate(printed, 1):
        assert len(sheet.text.split()) > 20, f"sheet {number} is nearly empty"
        assert 0.005 < sheet.ink < 0.5, f"sheet {number}"
