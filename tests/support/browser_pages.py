"""Pages in headless Chromium, for tests marked ``browser``: open one, judge it, print it.

A page that a test opened must neither report an error on its console nor ask another host for
anything; the test fails at its end if it did. Chromium cannot reach other hosts at all.

Without Chromium or Playwright the tests are skipped, unless ``SOLAR_UAV_TEST_BROWSER=1`` states
that both must be there.
"""

import importlib.util
import json
import os
import re
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import NamedTuple
from urllib.parse import urlsplit

import pytest
from source_tree import make_benchmarks_importable

make_benchmarks_importable()
from benchmarks.pages import headless  # noqa: E402 - only now it can be found

DESKTOP = (1400, 900)
PHONE = (390, 844)
INLINE_SCHEMES = ("data", "blob", "about")
TIMEOUT_MS = 15_000
# Elements that reach beyond the window's right edge, with text that flows out of them.
_TOO_WIDE = """() => {
    const limit = document.documentElement.clientWidth;
    if (document.scrollingElement.scrollWidth <= limit) return [];
    const edge = e => {
        const box = e.getBoundingClientRect();
        return box.left + Math.max(box.width, e.scrollWidth);
    };
    return [...document.body.querySelectorAll('*')]
        .filter(e => edge(e) > limit + 1)
        .map(e => `${e.tagName.toLowerCase()}${e.id ? '#' + e.id : ''}.` +
                  `${e.className.baseVal ?? e.className} to ${Math.round(edge(e))} px`);
}"""
# Children of boxes that reach beyond the box they stand in, below or to the right.
_SPILLED = """selector => [...document.querySelectorAll(selector)].flatMap(box => {
    const edge = box.getBoundingClientRect();
    return [...box.children].filter(child => {
        const own = child.getBoundingClientRect();
        const placed = getComputedStyle(child).position === 'absolute' || own.height === 0;
        return !placed && (own.bottom > edge.bottom + 0.5 || own.right > edge.right + 0.5);
    }).map(child => `${box.className}: ${child.id || child.className || child.tagName}`);
})"""
_SETTLE = "() => new Promise(done => setTimeout(done, 30))"


def missing():
    """What tests with a browser lack here, None if nothing."""
    if importlib.util.find_spec("playwright") is None:
        return 'Playwright is not installed: pip install ".[browser]"'
    if headless.chromium_path() is None:
        return f"none of {', '.join(headless.NAMES)} is on the path"
    return None


def pytest_collection_modifyitems(items):
    """Skip the tests marked ``browser`` where there is none."""
    reason = missing()
    if reason is None:
        return
    if os.environ.get("SOLAR_UAV_TEST_BROWSER") == "1":
        raise pytest.UsageError(f"SOLAR_UAV_TEST_BROWSER=1, but {reason}")
    for item in items:
        if item.get_closest_marker("browser") is not None:
            item.add_marker(pytest.mark.skip(reason=reason))


@dataclass
class Watch:
    """What a page did that it must not do."""

    home: str
    expected: str | None
    problems: list[str] = field(default_factory=list)

    def follow(self, page):
        """Note what goes wrong on a page from now on."""
        page.on("console", self._console)
        page.on("pageerror", lambda error: self._note(f"uncaught: {error}"))
        page.on("request", self._request)

    def _note(self, problem):
        if self.expected is None or re.search(self.expected, problem) is None:
            self.problems.append(problem)

    def _console(self, message):
        if message.type in ("error", "warning"):
            self._note(f"console {message.type}: {message.text}")

    def _request(self, request):
        home, asked = urlsplit(self.home), urlsplit(request.url)
        if asked.scheme in INLINE_SCHEMES or request.url.startswith(self.home):
            return
        if asked.scheme == "file" or (asked.scheme, asked.netloc) != (home.scheme, home.netloc):
            self._note(f"request outside of the page: {request.url}")


@pytest.fixture(scope="module")
def chromium():
    """One browser for a file of tests; no longer, as its event loop is in the way of others."""
    with headless.chromium() as browser:
        yield browser


@pytest.fixture
def open_page(chromium):
    """Open pages, each with settings and storage of its own, and judge them at the end.

    The call is ``open_page(url, size=PHONE, dark=True, expected="400", waiting=True)``: window
    [px], colour scheme, pattern of errors that belong to the test, and whether the page's content
    security policy is lifted, which Playwright's ``wait_for_function`` needs. A page may read the
    files of a ``folder`` if one is given.
    """
    opened = []

    def call(
        url, *, size=DESKTOP, dark=False, expected=None, waiting=False, folder=None, **settings
    ):
        address = url.resolve().as_uri() if isinstance(url, Path) else url
        context = chromium.new_context(
            viewport={"width": size[0], "height": size[1]},
            color_scheme="dark" if dark else "light",
            bypass_csp=waiting,
            **settings,
        )
        context.set_default_timeout(TIMEOUT_MS)
        page = context.new_page()
        watch = Watch(folder.as_uri() if folder else address, expected)
        opened.append((context, watch))
        watch.follow(page)
        page.goto(address)
        return page

    yield call
    problems = []
    for context, watch in opened:
        # A page that is still at work reports until now.
        for page in context.pages:
            with suppress(Exception):
                page.evaluate(_SETTLE)
        context.close()
        problems += watch.problems
    assert not problems, "\n".join(problems)


def too_wide(page):
    """Elements for which the whole page scrolls sideways."""
    return page.evaluate(_TOO_WIDE)


def spilled(page, boxes):
    """Parts that hang out of their box, for boxes that a CSS selector names and nothing scrolls."""
    return page.evaluate(_SPILLED, boxes)


@cache
def _axe_script():
    folder = importlib.util.find_spec("axe_playwright_python")
    assert folder.origin is not None
    return (Path(folder.origin).parent / "axe.min.js").read_text(encoding="utf-8")


def accessibility_problems(page, *ignored):
    """What axe-core finds against WCAG 2.1 A and AA and good practice, a line an element and rule.

    Rules that a test leaves out are named, with the reason beside the call.
    """
    page.evaluate(_axe_script())
    rules = json.dumps({name: {"enabled": False} for name in ignored})
    # Style sheets are not fetched again, which pages from a folder may not do.
    result = page.evaluate(f"() => axe.run(document, {{rules: {rules}, preload: false}})")
    return [
        f"{violation['id']}: {violation['help']}: {node['html'][:200]} "
        f"({'; '.join(check['message'] for check in node['any'] + node['all'] + node['none'])})"
        for violation in result["violations"]
        for node in violation["nodes"]
    ]


class Sheet(NamedTuple):
    """A page of a PDF: its text, and the share of it that bears ink."""

    text: str
    ink: float


def sheets(pdf):
    """Pages of a PDF as they would be printed."""
    from pypdfium2 import PdfDocument

    document = PdfDocument(pdf)
    found = []
    for page in document:
        dots = page.render(scale=0.5).to_numpy()
        found.append(Sheet(page.get_textpage().get_text_range(), float((dots < 230).mean())))
    document.close()
    return found
