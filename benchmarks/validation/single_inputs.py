"""What single input would explain a difference from a published flight, and how likely that is.

For each miss one input at a time is changed until the simulator gives the published number. Beside
the value that this takes stands the range in which the input is known to lie
(:mod:`benchmarks.validation.flight_inputs`), and the distance of the needed value from the one used
in standard uncertainties. Nothing is changed in what the software computes elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.validation.flight_inputs import INPUTS, MISSES, Input, Miss, Spread
from benchmarks.validation.published_flights import Trial
from studies.render.tables import Column, Table

_SCAN = 6
_HALVINGS = 7
_ENOUGH = 1e-6


@dataclass(frozen=True)
class Needed:
    """Value of a single input that gives the published number.

    ``used``: value that the computation uses. ``needed``: value that gives the published number;
    None where none between the ends of the search does. ``others``: the flight's other quantities
    with that value.
    """

    spread: Spread
    used: float
    needed: float | None
    others: dict[str, float]

    @property
    def sigmas(self) -> float | None:
        """Distance of the needed value from the one used in standard uncertainties."""
        if self.needed is None:
            return None
        return (self.needed - self.used) / self.spread.standard_uncertainty

    @property
    def within(self) -> bool:
        """Whether the needed value lies in the stated range."""
        return self.needed is not None and self.spread.low <= self.needed <= self.spread.high


@dataclass(frozen=True)
class Explanation:
    """A miss, what is computed, and what each input would have to be.

    ``together`` is what is computed with every separate input at that end of its range which is
    better for the published number.
    """

    miss: Miss
    computed: float
    needed: tuple[Needed, ...]
    together: float

    @property
    def title(self) -> str:
        """Flight, quantity, and both numbers."""
        quantity = self.miss.quantity
        return (
            f"{self.miss.flight.name}: {quantity.name}, published {quantity.published:.4g} "
            f"{quantity.unit}, computed {self.computed:.4g}"
        )

    @property
    def note(self) -> str:
        """What all inputs together could do."""
        unit = self.miss.quantity.unit
        return f"all at the end of their ranges nearer to it: {self.together:.4g} {unit}"


def explanations_table(rows: tuple[Explanation, ...]) -> Table:
    """Every input of every miss: ranges and units as text."""
    columns = (
        Column("difference"),
        Column("input"),
        Column("used", form=".4g"),
        Column("needed", form=".4g", missing="none"),
        Column("range", "known range"),
        Column("sigmas", form="+.1f"),
        Column("within"),
        Column("others", "other numbers with it"),
        Column("source", "source of the range"),
    )
    lines = tuple(
        (
            f"{row.title}; {row.note}" if i == 0 else "",
            *(*_short(n), _others(row, n), n.spread.source),
        )
        for row in rows
        for i, n in enumerate(row.needed)
    )
    return Table("single inputs that would explain the differences from flights", columns, lines)


def _short(n: Needed) -> tuple[Any, ...]:
    unit = "" if n.spread.input.unit == "-" else f" [{n.spread.input.unit}]"
    known = f"{n.spread.low:.4g} to {n.spread.high:.4g}"
    return f"{n.spread.input.name}{unit}", n.used, n.needed, known, n.sigmas, n.within


def _others(row: Explanation, n: Needed) -> str:
    flight = row.miss.flight
    texts = (
        f"{name} {value:.3g} ({flight.quantity(name).published:.3g})"
        for name, value in n.others.items()
    )
    return "; ".join(texts)


def explain(misses: tuple[Miss, ...] = MISSES) -> tuple[Explanation, ...]:
    """Find for every miss what each single input would have to be."""
    rows = []
    for miss in misses:
        trial = miss.flight.trial()
        factor = _root(miss, INPUTS["solar_power"], trial)
        needed = tuple(_needed(miss, spread, trial, factor) for spread in miss.spreads)
        computed = miss.quantity.compute(trial)
        rows.append(Explanation(miss, computed, needed, _together(miss, trial, computed)))
    return tuple(rows)


def _together(miss: Miss, trial: Trial, computed: float) -> float:
    """Number with every separate input at the end of its range nearer to the published one."""
    quantity, changed = miss.quantity, trial
    for spread in miss.spreads:
        source = spread.input
        if source.separate:
            low, high = (
                quantity.compute(source.change(trial, end)) for end in (spread.low, spread.high)
            )
            upwards = quantity.published > computed
            changed = source.change(changed, spread.high if (high > low) == upwards else spread.low)
    return quantity.compute(changed)


def _needed(miss: Miss, spread: Spread, trial: Trial, factor: float | None) -> Needed:
    """Value of one input; ``factor`` is what the solar power would have to be multiplied by."""
    source = spread.input
    used = source.read(trial)
    if source is INPUTS["solar_power"] or source.scales_power:
        needed = None if factor is None else factor * used
    else:
        needed = _root(miss, source, trial)
    others: dict[str, float] = {}
    if needed is not None:
        changed = source.change(trial, needed)
        others = {
            q.name: q.compute(changed) for q in miss.flight.quantities if q is not miss.quantity
        }
    return Needed(spread, used, needed, others)


def _root(miss: Miss, source: Input, trial: Trial) -> float | None:
    """Value of an input that gives the published number."""

    def difference(value: float) -> float:
        """Computed less published number; a number that is met counts as too large."""
        computed = miss.quantity.compute(source.change(trial, value))
        return computed - miss.quantity.published + _ENOUGH

    used = source.read(trial)
    return nearest_root(difference, used, source.search(used))


def nearest_root(
    function: Callable[[float], float], start: float, ends: tuple[float, float]
) -> float | None:
    """Place near to a start at which a function changes its sign.

    The function is scanned outwards in even steps, as many to either end, and the first change
    refined, so that the function may have jumps, or be flat. Changes closer together than a step
    may be missed.

    None where the sign is the same everywhere.
    """
    at_start = function(start)
    sides = [np.linspace(start, end, _SCAN + 1).tolist() for end in ends if end != start]
    nearest = dict.fromkeys(range(len(sides)), (start, at_start))
    for step in range(1, _SCAN + 1):
        for i, side in enumerate(sides):
            inner, outer = nearest[i], (side[step], function(side[step]))
            if (outer[1] > 0.0) != (at_start > 0.0):
                return _refined(function, inner, outer)
            nearest[i] = outer
    return None


def _refined(
    function: Callable[[float], float], inner: tuple[float, float], outer: tuple[float, float]
) -> float:
    """Change of sign between two places, each with its value: bisection, then a straight line."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (inner[0] + outer[0])
        value = function(middle)
        if (value > 0.0) == (inner[1] > 0.0):
            inner = (middle, value)
        else:
            outer = (middle, value)
    return inner[0] + (outer[0] - inner[0]) * inner[1] / (inner[1] - outer[1])
