"""What results tell of the ranges of their models, and of where values of the file come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from sizing.validity.ranges import Extrapolation
from studies.render.numbers import hours
from studies.render.tables import Line

HEADING = "outside the range of a model:"
# Of what is assumed instead of a model, by the model: whose excess time a note has.
_OTHERWISE = {"module_temperature": "modules as cold as the air", "battery": "unheated battery"}


def extrapolation_blocks(extrapolations: Sequence[Extrapolation], level: int) -> list[Any]:
    """Return the extrapolations in one line at level 1, in a line each at level 2."""
    if not extrapolations:
        return []
    if level > 1:
        return [Line(HEADING, "warning"), *(f"  {row.text}" for row in extrapolations)]
    labels = ", ".join(dict.fromkeys(row.label for row in extrapolations))
    text = labels if len(extrapolations) > 1 else replace(extrapolations[0], worth="").text
    return [Line(f"{HEADING} {text}", "warning")]


def extrapolation_caption(extrapolations: Sequence[Extrapolation]) -> str:
    """Return the extrapolations for a figure's caption; empty where there are none."""
    if not extrapolations:
        return ""
    names = dict.fromkeys(
        row.label
        if row.excess_time_h is None
        else f"{row.holder} ({_OTHERWISE[row.model]}: excess time {hours(row.excess_time_h)})"
        for row in extrapolations
    )
    return f"extrapolated: {', '.join(names)}"
