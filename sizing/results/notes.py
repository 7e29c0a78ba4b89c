"""What results tell of the ranges of their models, and of where values of the file come from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sizing.results.records import hours
from sizing.results.tables import Line
from sizing.validity.ranges import Extrapolation

HEADING = "outside the range of a model:"
# Of what is assumed instead of a model, by the model: whose excess time a note has.
_OTHERWISE = {"module_temperature": "modules as cold as the air", "battery": "unheated battery"}


def extrapolation_blocks(extrapolations: Sequence[Extrapolation]) -> list[Any]:
    """Blocks of a summary, a line for each quantity; none where nothing is outside."""
    if not extrapolations:
        return []
    head, *lines = extrapolation_lines(extrapolations)
    return [Line(head, "warning"), *lines]


def extrapolation_lines(extrapolations: Sequence[Extrapolation]) -> list[str]:
    """Lines below a table; none where nothing is outside."""
    return [HEADING, *(f"  {one.text}" for one in extrapolations)] if extrapolations else []


def extrapolation_records(extrapolations: Sequence[Extrapolation]) -> list[dict[str, Any]]:
    """List of the key ``extrapolations``, JSON-ready."""
    return [one.to_dict() for one in extrapolations]


def extrapolation_caption(extrapolations: Sequence[Extrapolation]) -> str:
    """Line of a figure's caption; empty where nothing is outside."""
    if not extrapolations:
        return ""
    names = dict.fromkeys(
        one.label
        if one.excess_time_h is None
        else f"{one.holder} ({_OTHERWISE[one.model]}: excess time {hours(one.excess_time_h)})"
        for one in extrapolations
    )
    return f"extrapolated: {', '.join(names)}"
