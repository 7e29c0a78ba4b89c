"""The built site in a browser, opened as files: formulas, search, pictures, no other server."""

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
    "energy-balance.html",
    "structure.html",
    "cli.html",
    "gallery/index.html",
    "gallery/season_map.html",
    "notebooks/first_design.html",
    "api/generated/sizing.Analysis.html",
)


@pytest.fixture(params=[DESKTOP, PHONE], ids=["desktop", "phone"])
def opened(request, open_page):
    """Open a page that may read the files of the site, and nothing else."""
    site = f"{SITE.resolve().as_uri()}/"
    return lambda name: open_page(site + name, size=request.param, folder=SITE.resolve())


@pytest.mark.parametrize("name", PAGES)
def test_page_is_whole(opened, name):
    page = opened(name)
    if page.locator(".math").count():
        page.locator("mjx-container svg").first.wait_for()
        assert page.locator("mjx-merror, [data-mjx-error]").count() == 0
    pictures = "[...document.images].filter(i => i.complete && !i.naturalWidth).map(i => i.src)"
    assert page.evaluate(pictures) == []
    assert too_wide(page) == []


@pytest.mark.parametrize("name", ["structure.html", "gallery/index.html", "api/sizing.html"])
def test_page_is_accessible(opened, name):
    page = opened(name)
    page.evaluate("() => window.MathJax?.startup?.promise")
    assert accessibility_problems(page) == []


def test_search_finds_pages(opened):
    page = opened("search.html?q=excess+time")
    page.get_by_text("Search finished").wait_for()
    results = page.locator("#search-results ul.search li a")
    results.filter(has_text="Nomenclature").first.wait_for()
    results.filter(has_text="Energy balance").first.click()
    assert page.locator("h1").first.inner_text().startswith("Energy balance")


@pytest.mark.parametrize(
    ("query", "page_title", "at_most"),
    [("which battery", "Which battery?", 1), ("clouds", "Weather", 10)],
)
def test_search_ranks_the_page_that_answers(opened, query, page_title, at_most):
    page = opened(f"search.html?q={query.replace(' ', '+')}")
    page.get_by_text("Search finished").wait_for()
    titles = page.locator("#search-results ul.search li > a").all_inner_texts()
    assert any(title.startswith(page_title) for title in titles[:at_most]), titles
