"""Reports as PDF, by WeasyPrint."""

from __future__ import annotations

import importlib.util
import re
from importlib import resources

__all__ = ["MISSING", "has_weasyprint", "to_pdf"]

MISSING = "a PDF needs WeasyPrint: pip install weasyprint (the extra 'report')"
_VARIABLE = re.compile(r"var\(--([a-z]+)\)")
_DRAWING = re.compile(r'<svg class="drawing [^>]*>')
_DEFINED = re.compile(r"--([a-z]+):\s*([^;]+);")


def has_weasyprint() -> bool:
    """Whether the optional package is installed; it is not imported."""
    return importlib.util.find_spec("weasyprint") is not None


def to_pdf(page: str) -> bytes:
    """Print a report.

    Parameters
    ----------
    page : str
        As :func:`studies.make_report` makes it.

    Returns
    -------
    bytes
        A4, with an outline.

    Raises
    ------
    ImportError
        Without WeasyPrint, which the extra ``report`` brings.
    """
    if not has_weasyprint():
        raise ImportError(MISSING)
    from weasyprint import HTML

    # Drawings within a page know neither its variables nor its style sheet: the colours of the
    # light page stand for the former, and the drawings' part of the latter goes into each of them.
    colours = dict(_DEFINED.findall(page[: page.index("@media screen")]))
    style = resources.files("studies.report").joinpath("templates", "drawing.css")
    looks = f"<style>{style.read_text(encoding='utf-8')}</style>"
    page = _DRAWING.sub(lambda match: match[0] + looks, page)
    plain = _VARIABLE.sub(lambda match: colours.get(match[1], match[0]), page)
    printed: bytes = HTML(string=plain).write_pdf()
    return printed
