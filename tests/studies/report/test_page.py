"""The report in a browser: it asks for nothing, fits any window, can be read by all, and prints."""

import pytest
from browser_pages import DESKTOP, PHONE, accessibility_problems, sheets, too_wide
from builders import AS2, DESIGN, SKY_SAILOR, mission, shipped_mission

from sizing.results.sizing import size
from studies import make_report

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.fixture(scope="module")
def reports(tmp_path_factory):
    """Reports of sizings with all kinds of tables, and of a built aircraft."""
    band = mission(latitude_deg={"from_deg": 45.0, "to_deg": 50.0}, required_excess_time_h=2)
    studies = {
        "sized": size(DESIGN, shipped_mission(), "min_wingspan", with_sensitivities=True),
        "sized for a band": size(SKY_SAILOR, band, with_sensitivities=True),
    }
    with pytest.MonkeyPatch.context() as context:
        context.setattr("studies.report.sections.CELLS", (9, 12))
        pages = {"built": make_report(AS2, mission())} | {
            name: make_report(one.sized_aircraft(), one.sized_mission(), sizing=one)
            for name, one in studies.items()
        }
    folder = tmp_path_factory.mktemp("reports")
    for name, page in pages.items():
        (folder / f"{name}.html").write_text(page, encoding="utf-8")
    return {name: folder / f"{name}.html" for name in pages}


def check_sheets(printed):
    """Sheets hold text, and are white paper."""
    assert 3 <= len(printed) <= 20
    for number, sheet in enumerate(printed, 1):
        assert len(sheet.text.split()) > 20, f"sheet {number} is nearly empty"
        assert 0.005 < sheet.ink < 0.5, f"sheet {number}"


@pytest.mark.parametrize(
    ("size", "dark"), [(DESKTOP, False), (PHONE, True)], ids=["desktop, light", "phone, dark"]
)
@pytest.mark.parametrize("name", ["sized", "sized for a band", "built"])
def test_page_fits_and_reads(open_page, reports, name, size, dark):
    page = open_page(reports[name], size=size, dark=dark)
    assert too_wide(page) == []
    assert accessibility_problems(page) == []
    assert page.locator("svg.figure").first.is_visible()


def test_colours_of_drawings_follow_the_theme(open_page, reports):
    ink = "() => getComputedStyle(document.querySelector('svg.figure text')).fill"
    light, dark = (open_page(reports["sized"], dark=dark).evaluate(ink) for dark in (False, True))
    assert light != dark


def test_printed_from_a_dark_screen_it_is_whole_light_and_numbered(open_page, reports):
    page = open_page(reports["sized"], dark=True)
    headings = page.locator("h2").all_inner_texts()
    check_sheets(printed := sheets(page.pdf(prefer_css_page_size=True)))
    assert f"1 / {len(printed)}" in printed[0].text
    *others, last = (" ".join(sheet.text.split()) for sheet in printed)
    assert [h for h in headings if h not in " ".join([*others, last])] == []
    # Inputs are one sheet at the end.
    for words in ("format_version: 1", "mission rafz-july", "pitch_deg: 0.0"):
        assert words in last
        assert not any(words in text for text in others)


def test_pdf_of_the_command_is_full_too(reports):
    """By WeasyPrint, which knows no script and other rules of breaking pages."""
    pytest.importorskip("weasyprint", exc_type=OSError, reason="WeasyPrint lacks Pango")
    from studies.report.pdf import to_pdf

    check_sheets(sheets(to_pdf(reports["sized"].read_text(encoding="utf-8"))))
