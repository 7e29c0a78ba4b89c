"""What results tell of the ranges of their models, each quantity once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sizing.results.tables import Line
from sizing.validity.ranges import Extrapolation

HEADING = "outside the range of a model:"


def extrapolation_blocks(found: Sequence[Extrapolation]) -> list[Any]:
    """Blocks of a summary, a line for each quantity; none where nothing is outside."""
    if not found:
        return []
    head, *lines = extrapolation_lines(found)
    return [Line(head, "warning"), *lines]


def extrapolation_lines(found: Sequence[Extrapolation]) -> list[str]:
    """Lines below a table; none where nothing is outside."""
    return [HEADING, *(f"  {one.text}" for one in found)] if found else []


def extrapolation_records(found: Sequence[Extrapolation]) -> list[dict[str, Any]]:
    """List of the key ``extrapolations``, JSON-ready."""
    return [one.to_dict() for one in found]


def extrapolation_caption(found: Sequence[Extrapolation]) -> str:
    """Line of a figure's caption; empty where nothing is outside."""
    if not found:
        return ""
    names = dict.fromkeys(one.label for one in found)
    return f"outside model range: {', '.join(names)}"
