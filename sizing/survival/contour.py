"""The edge of what closes enough days, in income and storage, and the best place along it."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from solar.types import FloatArray, IntArray

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
    low, high = (np.full(len(storage), float(end)) for end in ends)
    enough = count(high, storage) >= needed
    some = np.flatnonzero(enough)
    parts = np.linspace(0.0, 1.0, at_once + 2)[1:, np.newaxis]
    cells = np.arange(len(some))
    for _ in range(math.ceil(_HALVINGS / math.log2(at_once + 1)) if len(some) else 0):
        tried = low[some] + parts * (high[some] - low[some])
        met = np.ones(tried.shape, bool)
        inner = tried[:-1]
        found = count(inner.reshape(-1), np.tile(storage[some], at_once))
        met[:-1] = found.reshape(inner.shape) >= needed
        first = np.argmax(met, axis=0)
        low[some], high[some] = np.vstack([low[some], tried])[first, cells], tried[first, cells]
    return np.where(enough, high, np.nan)


def least_step(
    count: Count, direction: FloatArray, ends: tuple[float, float], needed: int, *, rounds: int = 4
) -> float:
    """Least step in income and storage with which enough days close.

    ``count``: days that close, of logarithms of income and storage. ``rounds``: how often the
    distance of the ends is cut into eight. NaN where even the largest is not enough.
    """
    low, high = ends
    if count(*np.atleast_2d(direction * high).T)[0] < needed:
        return float("nan")
    for _ in range(rounds):
        steps = np.linspace(low, high, 9)[1:]
        met = count(steps * direction[0], steps * direction[1]) >= needed
        first = int(np.argmax(met))
        low, high = (low if first == 0 else float(steps[first - 1])), float(steps[first])
    return high


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
