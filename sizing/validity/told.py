"""What is told of a single design, of many results, and of the cells of maps and trade studies."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from missions.mission import Scenarios
from sizing.aircraft import Aircraft
from sizing.parameters import parameter
from sizing.performance import Performance
from sizing.validity.checks import flight_checks
from sizing.validity.ranges import (
    EXPERIENCE,
    Check,
    Extrapolation,
    Range,
    experience,
    extrapolation,
    ranges,
)


def extrapolations(aircraft: Aircraft, perf: Performance) -> tuple[Extrapolation, ...]:
    """What a single design takes from outside the range of a model, each quantity once.

    Returns in the order of the catalogue.
    """
    return told(flight_checks(aircraft, perf), perf.day.scenarios)


def told(
    checks: Iterable[Check], scenarios: Scenarios | None = None, *, of: int = 0, what: str = ""
) -> tuple[Extrapolation, ...]:
    """What is outside, each quantity of a model once with its worst value.

    ``checks``: without a shape, or of the scenarios or cells. ``scenarios``: to name those
    concerned, where they are not all. Returns in the order of the catalogue.
    """
    found = []
    for check in checks:
        outside, distance = check.outside, check.distance
        if not np.any(outside):
            continue
        place = np.unravel_index(np.argmax(distance), distance.shape)
        worst = check.found(tuple(map(int, place)))
        if of:
            count = int(np.sum(outside)) if outside.shape else of
            worst = replace(worst, count=count, of=of, what=what)
        elif scenarios is not None and outside.shape and not np.all(outside):
            names = tuple(scenarios.label(int(place)) for place in np.flatnonzero(outside))
            worst = replace(worst, scenarios=names)
        found.append(worst)
    return _in_order(found)


def worst_of(
    outside: Iterable[Extrapolation], *, of: int = 0, what: str = ""
) -> tuple[Extrapolation, ...]:
    """Each quantity of a model once, with its worst value.

    ``of``, ``what``: of how many of what it is told, if it is not of one design.
    """
    groups: dict[tuple[str, str], list[Extrapolation]] = {}
    for one in outside:
        groups.setdefault((one.quantity, one.model), []).append(one)
    worst = ((max(group, key=lambda one: one.distance), len(group)) for group in groups.values())
    return _in_order(
        replace(one, count=count, of=of, what=what) if of else one for one, count in worst
    )


def _in_order(outside: Iterable[Extrapolation]) -> tuple[Extrapolation, ...]:
    order = {place: number for number, place in enumerate(ranges())}
    last = len(order)  # parameters outside of experience, in the order in which they are checked
    return tuple(sorted(outside, key=lambda one: order.get((one.quantity, one.model), last)))


def together(several: Sequence[Sequence[Extrapolation]], what: str) -> tuple[Extrapolation, ...]:
    """What many results tell, each quantity once with its worst value and how many tell it."""
    return worst_of((one for result in several for one in result), of=len(several), what=what)


# ---- Cells, as a column of text


def cell_texts(checks: Iterable[Check], count: int) -> list[str]:
    """What each design of a batch takes from outside, as lines that :func:`from_text` reads.

    ``checks``: without a shape, or of the designs, with or without an axis of scenarios behind.
    Returns ``model: quantity value not low to high``, joined by semicolons, with the value of the
    worst scenario; empty where all is inside.
    """
    lines: list[list[str]] = [[] for _ in range(count)]
    for check in checks:
        if not np.any(check.outside):
            continue
        every = check if check.outside.shape else check.over((count,))
        distance = every.distance.reshape(count, -1)
        shape = every.outside.shape[1:]
        for number in np.flatnonzero(np.any(distance > 0.0, axis=1)):
            scenario = np.unravel_index(np.argmax(distance[number]), shape)
            lines[number].append(_line(every.found((int(number), *map(int, scenario)))))
    return ["; ".join(line) for line in lines]


def as_text(outside: Iterable[Extrapolation]) -> str:
    """Line of what is told of a single design; see :func:`cell_texts`."""
    return "; ".join(map(_line, outside))


def _line(one: Extrapolation) -> str:
    low = -math.inf if one.minimum is None else one.minimum
    high = math.inf if one.maximum is None else one.maximum
    return f"{one.model}: {one.quantity} {one.value:.6g} not {low:.6g} to {high:.6g}"


_LINE = re.compile(r"(\w+): ([\w.]+) (\S+) not (\S+) to (\S+)")


def from_text(text: str) -> tuple[Extrapolation, ...]:
    """What a line of :func:`cell_texts` tells."""
    outside = []
    for part in text.split("; ") if text else ():
        match = _LINE.fullmatch(part)
        if match is None:
            raise ValueError(f"names no model: {part[:80]!r}")
        model, quantity, *numbers = match.groups()
        value, low, high = map(float, numbers)
        outside.append(extrapolation(_range_of(quantity, model), value, low, high))
    return tuple(outside)


def _range_of(quantity: str, model: str) -> Range:
    """Range of a model, or of the experience with a technology parameter."""
    if model != EXPERIENCE:
        return ranges()[quantity, model]
    return experience(parameter(quantity))
