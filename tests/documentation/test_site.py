"""The built site in a browser, opened as files: formulas, search, pictures, no other server."""

from collections.abc import Iterator
from typing import Any

import pytest
from browser_pages import DESKTOP, PHONE, accessibility_problems, too_wide
from documented import DOCS

SITE = DOCS / "_build" / "html"
pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(not SITE.is_dir(), reason="`make docs` builds the site"),
]
PAGES = (
    "index.html",
    "get-started.html",
    "energy-balance.html",
    "structure.html",
    "validity.html",
    "nomenclature.html",
    "cli.html",
    "gallery/index.html",
    "gallery/season_map.html",
    "notebooks/first_design.html",
    "api/sizing.html",
    "api/generated/sizing.Analysis.html",
)


@pytest.fixture
def problems() -> list[str]:
    """What a page did that it must not do."""
    return []


@pytest.fixture(params=[DESKTOP, PHONE], ids=["desktop", "phone"])
def page(request: pytest.FixtureRequest, chromium: Any, problems: list[str]) -> Iterator[Any]:
    """A page that may read the files of the site, and nothing else."""
    width, height = request.param
    context = chromium.new_context(viewport={"width": width, "height": height})
    page = context.new_page()
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("console", lambda message: _note(message, problems))
    page.on("request", lambda request: _ask(request, problems))
    yield page
    context.close()
    assert not problems


def _note(message: Any, problems: list[str]) -> None:
    if message.type in ("error", "warning"):
        problems.append(message.text)


def _ask(request: Any, problems: list[str]) -> None:
    if not request.url.startswith((SITE.as_uri(), "data:", "blob:")):
        problems.append(f"asks for {request.url}")


@pytest.mark.parametrize("name", PAGES)
def test_page_is_whole(page: Any, name: str) -> None:
    page.goto((SITE / name).as_uri())
    if page.locator(".math").count():
        page.locator("mjx-container svg").first.wait_for()
        assert page.locator("mjx-merror, [data-mjx-error]").count() == 0
    pictures = "[...document.images].filter(i => i.complete && !i.naturalWidth).map(i => i.src)"
    assert page.evaluate(pictures) == []
    assert too_wide(page) == []


@pytest.mark.parametrize("name", ["structure.html", "gallery/index.html", "api/sizing.html"])
def test_page_is_accessible(page: Any, problems: list[str], name: str) -> None:
    page.goto((SITE / name).as_uri())
    page.evaluate("() => window.MathJax?.startup?.promise")
    assert problems == []
    assert accessibility_problems(page) == []
    # The judge itself asks for style sheets, which a page in a file may not read.
    problems.clear()


def test_search_finds_pages(page: Any) -> None:
    page.goto((SITE / "search.html").as_uri() + "?q=excess+time")
    page.get_by_text("Search finished").wait_for()
    results = page.locator("#search-results ul.search li a")
    results.filter(has_text="Nomenclature").first.wait_for()
    results.filter(has_text="Energy balance").first.click()
    assert page.locator("h1").first.inner_text().startswith("Energy balance")
