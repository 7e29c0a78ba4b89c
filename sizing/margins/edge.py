"""The edge of what is enough, in income and storage, and the cost along it."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from solar.types import BoolArray, FloatArray, IntArray

_HALVINGS = 9
# Weight of the squared curvature beside the misfit of a point.
_RIDGE = 1e-4

Count = Callable[[FloatArray, FloatArray], IntArray]


def least_income(
    count: Count, storage: FloatArray, ends: tuple[float, float], needed: int, *, at_once: int = 1
) -> FloatArray:
    """Least income with which enough days close, for some storages.

    More of either never closes fewer days, but for a day or two whose dawns move.

    ``count``: days that close, of logarithms of income and storage. ``at_once``: incomes of a
    storage that are tried at the same time, at least 1. Returns logarithms of the incomes, to a
    five-hundredth of the distance of the ends; NaN where even the largest is not enough.
    """

    def enough(income: FloatArray, columns: IntArray) -> BoolArray:
        counts = count(income.reshape(-1), np.tile(storage[columns], len(income)))
        return np.asarray(counts.reshape(income.shape) >= needed)

    rounds = math.ceil(_HALVINGS / math.log2(at_once + 1))
    return _least_enough(enough, len(storage), ends, at_once=at_once, rounds=rounds)


def least_step(count: Count, ends: tuple[float, float], needed: int) -> float:
    """Least step in income and storage alike with which enough days close.

    Returns to a four-thousandth of the distance of the ends; NaN where even the largest is not
    enough.
    """

    def enough(steps: FloatArray, _: IntArray) -> BoolArray:
        alike = steps.reshape(-1)
        return np.asarray(count(alike, alike).reshape(steps.shape) >= needed)

    return float(_least_enough(enough, 1, ends, at_once=7, rounds=4)[0])


def _least_enough(
    enough: Callable[[FloatArray, IntArray], BoolArray],
    columns: int,
    ends: tuple[float, float],
    *,
    at_once: int,
    rounds: int,
) -> FloatArray:
    """Least value of each column that is enough, between two ends; NaN where there is none.

    ``enough``: of values of some columns, shape ``(tried, column)``. Each round cuts what is left
    into ``at_once + 1`` parts.
    """
    low, high = (np.full(columns, float(end)) for end in ends)
    met = enough(high[np.newaxis], np.arange(columns))[0]
    some = np.flatnonzero(met)
    parts = np.linspace(0.0, 1.0, at_once + 2)[1:, np.newaxis]
    for _ in range(rounds if len(some) else 0):
        tried = low[some] + parts * (high[some] - low[some])
        sufficient = np.vstack([enough(tried[:-1], some), np.ones((1, len(some)), bool)])
        first, cells = np.argmax(sufficient, axis=0), np.arange(len(some))
        low[some], high[some] = np.vstack([low[some], tried])[first, cells], tried[first, cells]
    return np.where(met, high, np.nan)


def fitted(places: FloatArray, costs: FloatArray, here: int) -> Callable[[FloatArray], FloatArray]:
    """Cost as a quadratic function of the place, through one point and near to the others.

    Returns costs of places of shape ``(..., 2)``.
    """
    steps = places - places[here]
    weight = 1.0 / (0.02 + np.hypot(*steps.T))
    rows = weight[:, np.newaxis] * _powers(steps)
    free = np.sqrt(_RIDGE) * np.diag([0.1, 0.1, 1.0, 1.0, 1.0])
    goal = np.concatenate([weight * (costs - costs[here]), np.zeros(5)])
    slopes = np.linalg.lstsq(np.vstack([rows, free]), goal, rcond=None)[0]

    def cost(at: FloatArray) -> FloatArray:
        return np.asarray(costs[here] + _powers(at - places[here]) @ slopes)

    return cost


def _powers(steps: FloatArray) -> FloatArray:
    x, y = steps[..., 0], steps[..., 1]
    return np.stack([x, y, x * x, x * y, y * y], axis=-1)
