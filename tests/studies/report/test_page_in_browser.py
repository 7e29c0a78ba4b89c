"""A report as its readers see it: wide and narrow, light and dark, by a screen reader, printed."""

from pathlib import Path

import pytest
from browser_pages import DESKTOP, PHONE, OpenPage, accessibility_problems, sheets, too_wide
from builders import AS2, SKY_SAILOR, mission

from sizing.results.sizing import size
from studies import make_report

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Report of a sizing, so that it has all kinds of tables."""
    with pytest.MonkeyPatch.context() as context:
        context.setattr("studies.report.flight.CELLS", (9, 12))
        there = mission(latitude_deg={"from_deg": 45.0, "to_deg": 50.0}, required_excess_time_h=2)
        study = size(SKY_SAILOR, there, with_sensitivities=True)
        page = make_report(study.sized_aircraft(), study.sized_mission(), sizing=study)
    file = tmp_path_factory.mktemp("report") / "report.html"
    file.write_text(page, encoding="utf-8")
    return file


@pytest.mark.parametrize("size", [DESKTOP, PHONE], ids=["desktop", "phone"])
@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_page_fits_and_reads(
    open_page: OpenPage, report: Path, size: tuple[int, int], dark: bool
) -> None:
    page = open_page(report, size=size, dark=dark)
    assert too_wide(page) == []
    assert accessibility_problems(page) == []
    views = page.locator("svg.drawing")
    assert [views.nth(i).is_visible() for i in range(2)] == [size == DESKTOP, size == PHONE]


def test_colours_of_drawings_follow_the_theme(open_page: OpenPage, report: Path) -> None:
    inks = []
    for dark in (False, True):
        page = open_page(report, dark=dark)
        inks.append(
            page.evaluate("() => getComputedStyle(document.querySelector('svg.figure text')).fill")
        )
    assert inks[0] != inks[1]


def test_printed_pages_are_filled_and_numbered(open_page: OpenPage, report: Path) -> None:
    printed = sheets(open_page(report).pdf(prefer_css_page_size=True))
    assert 4 <= len(printed) <= 10
    assert f"1 / {len(printed)}" in printed[0].text
    # Every page but the last bears ink; bars are printed without the browser's being asked to.
    assert all(sheet.ink > 0.01 for sheet in printed[:-1])


def test_report_of_a_built_aircraft_fits(open_page: OpenPage, tmp_path: Path) -> None:
    file = tmp_path / "report.html"
    with pytest.MonkeyPatch.context() as context:
        context.setattr("studies.report.flight.CELLS", (9, 12))
        file.write_text(make_report(AS2, mission()), encoding="utf-8")
    page = open_page(file, size=PHONE)
    assert too_wide(page) == []
