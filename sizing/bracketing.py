"""Roots of many falling functions at once, each bracketed and narrowed on its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sizing.power_balance import BoolArray, FloatArray, IntArray

_MAXIMUM_ROUNDS = 100


def falling_root(
    gain: Callable[[IntArray, FloatArray], FloatArray],
    lower: FloatArray,
    upper: FloatArray,
    limit: FloatArray,
) -> FloatArray:
    """Where each of many functions, positive at ``lower`` and negative at ``upper``, is zero.

    Illinois variant of the false position. An element leaves the search when its value or its
    bracket is within the limit; what the others do has no influence on it.

    Parameters
    ----------
    gain : callable
        Takes the indices of the elements still searched and a trial point for each, and returns
        the values there.
    lower, upper : ndarray
        Ends of the brackets. An element whose value at the lower end is not above the limit has
        its root there.
    limit : ndarray
        Tolerance of value and bracket.
    """
    every = np.arange(len(upper))
    lower_gain = gain(every, lower)
    rising = lower_gain > limit
    result = np.where(rising, upper, lower)
    work = _Brackets(every, lower, upper, lower_gain, gain(every, upper), np.zeros(len(upper)))
    work = work.select(rising)
    for _ in range(_MAXIMUM_ROUNDS):
        if not len(work.place):
            break
        trial = work.trial()
        value = gain(work.place, trial)
        result[work.place] = trial
        work = work.narrowed(trial, value)
        near = limit[work.place]
        work = work.select((np.abs(value) > near) & (work.upper - work.lower > near))
    return result


@dataclass(frozen=True)
class _Brackets:
    """Brackets of the elements that are still searched; ``place`` is their index in the batch."""

    place: IntArray
    lower: FloatArray
    upper: FloatArray
    lower_gain: FloatArray
    upper_gain: FloatArray
    side: FloatArray

    def select(self, mask: BoolArray) -> _Brackets:
        """Brackets of a part of the elements."""
        return _Brackets(
            self.place[mask],
            self.lower[mask],
            self.upper[mask],
            self.lower_gain[mask],
            self.upper_gain[mask],
            self.side[mask],
        )

    def trial(self) -> FloatArray:
        """Zero of the straight line through both ends."""
        slope = np.where(
            self.upper_gain == self.lower_gain, -1.0, self.upper_gain - self.lower_gain
        )
        point = self.lower - self.lower_gain * (self.upper - self.lower) / slope
        return np.clip(point, self.lower, self.upper)

    def narrowed(self, trial: FloatArray, gain: FloatArray) -> _Brackets:
        """Bracket with one end moved; an end kept twice counts half (Illinois)."""
        rises = gain > 0.0
        side = np.where(rises, 1.0, -1.0)
        again = side == self.side
        kept_lower = np.where(again & ~rises, self.lower_gain / 2.0, self.lower_gain)
        kept_upper = np.where(again & rises, self.upper_gain / 2.0, self.upper_gain)
        return _Brackets(
            self.place,
            np.where(rises, trial, self.lower),
            np.where(rises, self.upper, trial),
            np.where(rises, gain, kept_lower),
            np.where(rises, kept_upper, gain),
            side,
        )
