"""The judgement of pages itself: each kind of fault is found on a small page that has it."""

from pathlib import Path
from typing import Any

import pytest
from browser_pages import PHONE, Watch, accessibility_problems, sheets, too_wide

pytestmark = pytest.mark.browser

GOOD = """<!doctype html><html lang="en"><head><meta charset="utf-8"><title>Good</title>
<meta name="viewport" content="width=device-width">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src 'unsafe-inline'">
</head><body><main><h1>Good</h1><p>Nothing is wrong with this page.</p></main></body></html>"""


def page_file(folder: Path, old: str = "", new: str = "") -> Path:
    assert old in GOOD
    path = folder / "page.html"
    path.write_text(GOOD.replace(old, new) if old else GOOD, encoding="utf-8")
    return path


def problems_of(chromium: Any, path: Path, expected: str | None = None) -> list[str]:
    """What is noted while a page loads, without the fixture that makes a failure of it."""
    context = chromium.new_context()
    page = context.new_page()
    watch = Watch(path.as_uri(), expected)
    watch.follow(page)
    page.goto(path.as_uri())
    context.close()
    return watch.problems


def test_a_good_page_passes(open_page: Any, tmp_path: Path) -> None:
    page = open_page(page_file(tmp_path), size=PHONE, dark=True)
    assert page.title() == "Good"
    assert page.evaluate("matchMedia('(prefers-color-scheme: dark)').matches")
    assert page.evaluate("innerWidth") == 390
    assert too_wide(page) == []
    assert accessibility_problems(page) == []


@pytest.mark.parametrize(
    ("fault", "noted"),
    [
        ("<script>console.error('broken')</script>", "console error: broken"),
        ("<script>throw new Error('thrown')</script>", "uncaught: thrown"),
        ('<img alt="" src="https://example.invalid/a.png">', "https://example.invalid/a.png"),
        ('<img alt="" src="beside.png">', "beside.png"),
    ],
)
def test_faults_are_noted(chromium: Any, tmp_path: Path, fault: str, noted: str) -> None:
    path = page_file(tmp_path, "</main>", f"{fault}</main>")
    path.write_text(path.read_text().replace("default-src 'none'", "default-src *"))
    problems = problems_of(chromium, path)
    assert any(noted in problem for problem in problems), problems
    assert problems_of(chromium, path, expected=".") == []


def test_what_is_too_wide_is_named(open_page: Any, tmp_path: Path) -> None:
    wide = '<pre id="rows">' + 200 * "x" + "</pre></main>"
    page = open_page(page_file(tmp_path, "</main>", wide), size=PHONE)
    assert any("pre#rows" in element for element in too_wide(page))


@pytest.mark.parametrize(
    ("old", "new", "rule"),
    [
        ("</main>", '<input type="range"></main>', "label"),
        ("</main>", "<h4>Too deep</h4></main>", "heading-order"),
        ("</main>", '<p style="color:#bbb;background:#fff">Faint</p></main>', "color-contrast"),
        (' lang="en"', "", "html-has-lang"),
    ],
)
def test_what_bars_people_is_named(
    open_page: Any, tmp_path: Path, old: str, new: str, rule: str
) -> None:
    path = page_file(tmp_path, old, new)
    path.write_text(path.read_text().replace("default-src 'none'", "default-src * 'unsafe-inline'"))
    found = accessibility_problems(open_page(path))
    assert [problem.split(":")[0] for problem in found] == [rule]
    assert accessibility_problems(open_page(path), rule) == []


def test_sheets_of_a_pdf(open_page: Any, tmp_path: Path) -> None:
    second = '<p style="break-before: page"></p></main>'
    path = page_file(tmp_path, "</main>", second)
    path.write_text(path.read_text().replace("default-src 'none'", "default-src * 'unsafe-inline'"))
    first, empty = sheets(open_page(path).pdf())
    assert "Nothing is wrong" in first.text
    assert first.ink > 0.001
    assert (empty.text.strip(), empty.ink) == ("", 0.0)
