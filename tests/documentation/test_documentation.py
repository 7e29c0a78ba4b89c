"""Links of the documentation lead somewhere, and nothing is left out of its indices."""

import importlib
import pkgutil
import re
from pathlib import Path
from urllib.parse import unquote

import pytest
from documented import DOCS, PAGES, ROOT, without_code

PACKAGES = ("solar", "missions", "sizing", "studies")


def links(page):
    return re.findall(r"\]\(([^)\s]+)\)", without_code(page))


def anchors(page):
    """Anchors of the headings as GitHub makes them: lower case, hyphens, no punctuation."""
    headings = re.findall(r"^#+ (.+)$", without_code(page), re.M)
    bare = (re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading) for heading in headings)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in bare}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_to_files_and_headings(page):
    for link in links(page):
        if re.match(r"[a-z]+:", link):
            continue
        name, _, anchor = unquote(link).partition("#")
        target = (page.parent / name).resolve() if name else page
        assert target.exists(), f"{page.name}: {link}"
        if anchor:
            assert anchor in anchors(target), f"{page.name}: {link}"


def test_every_page_is_in_the_index():
    index = DOCS / "index.md"
    linked = {(index.parent / link.partition("#")[0]).resolve() for link in links(index)}
    assert {page for page in PAGES if DOCS in page.parents and page != index} <= linked
    assert index in {(ROOT / link.partition("#")[0]).resolve() for link in links(PAGES[0])}


def test_every_example_that_draws_is_in_the_index():
    text = (DOCS / "index.md").read_text(encoding="utf-8")
    for script in (ROOT / "examples").glob("*.py"):
        assert f"`{script.name}`" in text, script.name


def test_every_image_is_shown():
    shown = {(page.parent / link).resolve() for page in PAGES for link in links(page)}
    assert set((DOCS / "images").iterdir()) <= shown


def dotted_names(page):
    """Modules and what is in them, as the text of a page names them."""
    pattern = rf"`((?:{'|'.join(PACKAGES)})(?:\.\w+)+)`"
    names = set(re.findall(pattern, without_code(page)))
    return {name for name in names if not name.endswith((".py", ".yaml", ".csv"))}


@pytest.mark.parametrize(
    ("page", "name"),
    [(page, name) for page in PAGES for name in sorted(dotted_names(page))],
    ids=lambda value: value.name if isinstance(value, Path) else value,
)
def test_what_the_text_names_exists(page, name):
    pkgutil.resolve_name(name)


def test_map_of_the_packages_leaves_nothing_out():
    named = dotted_names(ROOT / "CONTRIBUTING.md")
    for package in PACKAGES:
        for module in pkgutil.iter_modules(importlib.import_module(package).__path__):
            if not module.name.startswith("_"):
                assert f"{package}.{module.name}" in named
