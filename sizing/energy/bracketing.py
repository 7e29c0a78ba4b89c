"""Roots of many falling functions at once, each bracketed and narrowed on its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np

from solar.types import BoolArray, FloatArray, IntArray

_MAXIMUM_ROUNDS = 100
_SECANT_ROUNDS = 8


def falling_root(
    gain: Callable[[IntArray, FloatArray], FloatArray],
    lower: FloatArray,
    upper: FloatArray,
    limit: FloatArray,
) -> FloatArray:
    """Where each of many functions, positive at ``lower`` and negative at ``upper``, is zero.

    The functions must not fall faster than their argument rises: the value at either end then
    leads to a nearer one. Secants at first, to the nearer end where they leave the bracket, then
    the Illinois variant of the false position. An element leaves the search when its value or its
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

    Returns
    -------
    ndarray, shape (element,)
        Points within the limit of the zeros, or the last trials after 100 rounds; in the unit of
        ``lower``.
    """
    every = np.arange(len(upper))
    ends = gain(np.tile(every, 2), np.concatenate([lower, upper]))
    lower_gain, upper_gain = np.split(ends, 2)
    rising = lower_gain > limit
    result = np.where(rising, upper, lower)
    latest = np.maximum(upper + np.minimum(upper_gain, 0.0), lower)
    work = _Brackets(
        place=every,
        least=lower + lower_gain,
        most=latest,
        lower=lower,
        upper=upper,
        lower_gain=lower_gain,
        upper_gain=upper_gain,
        side=np.zeros(len(upper)),
        latest=upper,
        latest_gain=upper_gain,
        trial=latest,
    ).select(rising)
    for number in range(_MAXIMUM_ROUNDS):
        if not len(work.place):
            break
        value = gain(work.place, work.trial)
        result[work.place] = work.trial
        near = limit[work.place]
        work = work.narrowed(value, secant=number < _SECANT_ROUNDS)
        work = work.select((np.abs(value) > near) & (work.upper - work.lower > near))
    return result


@dataclass(frozen=True)
class _Brackets:
    """Brackets of the elements that are still searched; ``place`` is their index in the batch.

    ``least``, ``most``: nearest points between which the values so far put the zero.
    """

    place: IntArray
    least: FloatArray
    most: FloatArray
    lower: FloatArray
    upper: FloatArray
    lower_gain: FloatArray
    upper_gain: FloatArray
    side: FloatArray
    latest: FloatArray
    latest_gain: FloatArray
    trial: FloatArray

    def select(self, mask: BoolArray) -> _Brackets:
        """Brackets of a part of the elements."""
        return _Brackets(*(getattr(self, field.name)[mask] for field in fields(self)))

    def narrowed(self, gain: FloatArray, *, secant: bool) -> _Brackets:
        """Bracket with one end moved to the trial, and the next trial.

        An end kept twice counts half in the false position (Illinois).
        """
        trial = self.trial
        rises = gain > 0.0
        side = np.where(rises, 1.0, -1.0)
        again = side == self.side
        lower_gain = np.where(again & ~rises, self.lower_gain / 2.0, self.lower_gain)
        upper_gain = np.where(again & rises, self.upper_gain / 2.0, self.upper_gain)
        lower_gain, upper_gain = (
            np.where(rises, gain, lower_gain),
            np.where(rises, upper_gain, gain),
        )
        lower, upper = np.where(rises, trial, self.lower), np.where(rises, self.upper, trial)
        least = np.where(rises, np.maximum(self.least, trial + gain), self.least)
        most = np.where(rises, self.most, np.minimum(self.most, trial + gain))
        if secant:
            following = _zero(self.latest, trial, self.latest_gain, gain)
        else:
            following = _zero(lower, upper, lower_gain, upper_gain)
        return _Brackets(
            self.place,
            least,
            most,
            lower,
            upper,
            lower_gain,
            upper_gain,
            side,
            trial,
            gain,
            np.clip(following, least, np.maximum(least, most)),
        )


def _zero(a: FloatArray, b: FloatArray, value_a: FloatArray, value_b: FloatArray) -> FloatArray:
    """Zero of the straight line through two points; far below where they are level."""
    level = value_a == value_b
    slope = np.where(level, -1.0, value_b - value_a)
    return np.where(level, -np.inf, a - value_a * (b - a) / slope)
