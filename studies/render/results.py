"""Results as people read them: blocks of a result at a level, for whatever shows them.

Level 1 is the summary that fits a screen, level 2 has the rest (``-v``, the report); a quantity is
shown from its importance on. :mod:`studies.render.tables` writes blocks as text, Markdown, HTML and
LaTeX.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

from sizing.results.result import Result
from studies.render.tables import SUMMARY, Summary

# Modules that render what the sizing layer computes: each has ``headline`` and ``blocks``, as the
# modules of the results of studies have for theirs.
_MODULES = {
    "Analysis": "studies.render.analysis",
    "SizingStudy": "studies.render.sizing",
    "UncertaintyAnalysis": "studies.render.uncertainty",
    "WeatherAnalysis": "studies.render.weather",
}


def render(result: Result, level: int = SUMMARY) -> Summary:
    """Return the blocks of a result in the order in which they are read."""
    return Summary(tuple(_module_of(result).blocks(result, level)))


def headline(result: Result) -> str:
    """Return a result in one line."""
    return str(_module_of(result).headline(result))


def _module_of(result: Result) -> Any:
    kinds = type(result).__mro__
    names = (_MODULES[kind.__name__] for kind in kinds if kind.__name__ in _MODULES)
    return import_module(next(names, kinds[0].__module__))
