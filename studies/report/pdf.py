"""Reports as PDF, by WeasyPrint."""

from __future__ import annotations

import importlib.util
import re
from importlib import resources

MISSING = "a PDF needs WeasyPrint: pip install weasyprint (the extra 'report')"
_VARIABLE = re.compile(r"var\(--([a-z]+)\)")
# Where a page may name a colour: a style sheet or an attribute, never the text of a file, in which
# quotes and angle brackets are escaped.
_STYLED = re.compile(r'<style>.*?</style>| style="[^"]*"', re.S)
_DEFINED = re.compile(r"--([a-z]+):\s*([^;]+);")


def has_weasyprint() -> bool:
    """Return whether the optional package is installed; it is not imported."""
    return importlib.util.find_spec("weasyprint") is not None


def to_pdf(page: str) -> bytes:
    """Print a report.

    Returns a4, with an outline.
    """
    if not has_weasyprint():
        raise ImportError(MISSING)
    from weasyprint import HTML

    printed: bytes = HTML(string=with_plain_colours(page)).write_pdf()
    return printed


def with_plain_colours(page: str) -> str:
    """Return a page in the colours of paper; the words of its files remain."""
    # Drawings within a page do not know its variables: the light page's colours stand for them.
    sheet = resources.files("studies.report").joinpath("templates", "report.css")
    light, _, _ = sheet.read_text(encoding="utf-8").partition("@media screen")
    colours = dict(_DEFINED.findall(light))

    def coloured(styled: re.Match[str]) -> str:
        return _VARIABLE.sub(lambda match: colours.get(match[1], match[0]), styled[0])

    return _STYLED.sub(coloured, page)
