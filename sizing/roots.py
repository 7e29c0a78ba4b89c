"""Roots of many functions at once, each in its own bracket, and bisection of a condition.

``scipy.optimize.elementwise`` finds the same roots, but its import takes longer than a sizing.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from solar.types import FloatArray, IntArray

_MAXIMUM_ROUNDS = 100  # bisection to rounding takes 53
_SECANT_ROUNDS = 8  # before the false position, which needs a bracket
_CLOSE = 4.0 * np.finfo(float).eps  # rounding of a root


def bisect(
    insufficient: float,
    sufficient: float,
    suffices: Callable[[float], bool],
    tolerance: Callable[[float], float],
    *,
    most: float = math.inf,
) -> float:
    """Return a sufficient value within a tolerance of an insufficient one.

    If no sufficient value is known (infinity), steps of 1 that double search it up to ``most``;
    infinite if there is none.
    """
    step = 1.0
    while math.isinf(sufficient) and insufficient < most:
        value, step = min(insufficient + step, most), 2.0 * step
        if suffices(value):
            sufficient = value
        else:
            insufficient = value
    while math.isfinite(sufficient) and abs(sufficient - insufficient) > tolerance(sufficient):
        middle = (insufficient + sufficient) / 2.0
        if suffices(middle):
            sufficient = middle
        else:
            insufficient = middle
    return sufficient


def bracketed_root(
    value: Callable[[FloatArray], FloatArray],
    lower: FloatArray,
    upper: FloatArray,
    relative_tolerance: float = _CLOSE,
) -> FloatArray:
    """Return the roots of many functions, each between two ends with values of opposite signs.

    Chandrupatla, T. R. (1997), A new hybrid quadratic/bisection algorithm for finding the zero of
    a nonlinear function without using derivatives, Advances in Engineering Software 28, 145-149: a
    parabola through the last three points where it is monotonic between them, else the middle.
    The functions do not influence each other. ``value`` takes a trial for every function; the final
    bracket is at most ``relative_tolerance`` of its end with the smaller value, which is the root.
    NaN where both ends' values have the same sign.
    """
    here, other = lower, upper
    f_here, f_other = value(here), value(other)
    root = np.where(np.abs(f_here) < np.abs(f_other), here, other)
    exact = (f_here == 0.0) | (f_other == 0.0)
    searched = ~exact & (np.sign(f_here) != np.sign(f_other))
    root = np.where(exact | searched, root, np.nan)
    share = np.full(np.shape(root), 0.5)
    with np.errstate(divide="ignore", invalid="ignore"):
        for _ in range(_MAXIMUM_ROUNDS):
            if not searched.any():
                break
            trial = np.where(searched, here + share * (other - here), root)
            f_trial = value(trial)
            same = np.sign(f_trial) == np.sign(f_here)
            third, f_third = np.where(same, here, other), np.where(same, f_here, f_other)
            other, f_other = np.where(same, other, here), np.where(same, f_other, f_here)
            here, f_here = trial, f_trial
            nearest = np.where(np.abs(f_here) < np.abs(f_other), here, other)
            root = np.where(searched, nearest, root)
            width, close = np.abs(other - here), relative_tolerance * np.abs(nearest)
            searched &= (width >= close) & (f_here != 0.0)
            place = (here - other) / (third - other)
            rise = (f_here - f_other) / (f_third - f_other)
            smooth = (1.0 - np.sqrt(1.0 - place) < rise) & (rise < np.sqrt(place))
            parabola = f_here / (f_here - f_other) * f_third / (f_third - f_other) - (
                (third - here) / (other - here) * f_here / (f_third - f_here)
            ) * f_other / (f_other - f_third)
            least = 0.5 * close / width
            share = np.clip(np.where(smooth, parabola, 0.5), least, 1.0 - least)
    return root


class FallingRoots:
    """Search for the roots of many functions, positive at ``lower`` and negative at ``upper``.

    As long as some are ``open``, :meth:`take` their values at ``trial``. The functions must not
    fall faster than their argument rises: the value at either end then leads to a nearer one.
    Secants at first, to the nearer end where they leave the bracket, then the Illinois variant of
    the false position. A function leaves the search when its value or its bracket is within
    ``limit``, or after 100 rounds; what the others do has no influence on it. A function whose
    value at the lower end is not above the limit has its ``root`` there.

    ``lower_value``, ``upper_value``: at the ends. ``open``: indices of the functions that are
    searched.
    """

    def __init__(
        self,
        lower: FloatArray,
        upper: FloatArray,
        lower_value: FloatArray,
        upper_value: FloatArray,
        limit: FloatArray,
    ) -> None:
        rising = lower_value > limit
        self.root, self.open = np.where(rising, upper, lower), np.flatnonzero(rising)
        self._limit, self._rounds = limit, 0
        # The nearest points between which the values so far put the root.
        least, most = lower + lower_value, np.maximum(upper + np.minimum(upper_value, 0.0), lower)
        bracket, side = (lower, upper, lower_value, upper_value), np.zeros(len(upper))
        rows = (least, most, *bracket, side, upper, upper_value, most)
        self._brackets = np.stack(rows)[:, self.open]

    @property
    def trial(self) -> FloatArray:
        """Return the next point of every open function."""
        return np.asarray(self._brackets[-1])

    def take(self, value: FloatArray) -> None:
        """Narrow the brackets by the values of the open functions at ``trial``.

        The value at an end kept twice is halved in the false position (Illinois).
        """
        least, most, lower, upper, lower_value, upper_value, *before, trial = self._brackets
        side_before, latest, latest_value = before
        self.root[self.open] = trial
        rises = value > 0.0
        side = np.where(rises, 1.0, -1.0)
        again = side == side_before
        lower_value = np.where(again & ~rises, lower_value / 2.0, lower_value)
        upper_value = np.where(again & rises, upper_value / 2.0, upper_value)
        lower_value, upper_value = (
            np.where(rises, value, lower_value),
            np.where(rises, upper_value, value),
        )
        lower, upper = np.where(rises, trial, lower), np.where(rises, upper, trial)
        least = np.where(rises, np.maximum(least, trial + value), least)
        most = np.where(rises, most, np.minimum(most, trial + value))
        if self._rounds < _SECANT_ROUNDS:
            following = _zero(latest, trial, latest_value, value)
        else:
            following = _zero(lower, upper, lower_value, upper_value)
        following = np.clip(following, least, np.maximum(least, most))
        bracket = (lower, upper, lower_value, upper_value)
        self._rounds += 1
        near = self._limit[self.open]
        goes_on = (np.abs(value) > near) & (upper - lower > near)
        goes_on &= self._rounds < _MAXIMUM_ROUNDS
        rows = (least, most, *bracket, side, trial, value, following)
        self.open, self._brackets = self.open[goes_on], np.stack(rows)[:, goes_on]


def _zero(a: FloatArray, b: FloatArray, value_a: FloatArray, value_b: FloatArray) -> FloatArray:
    """Return the zero of the straight line through two points; far below where they are level."""
    level = value_a == value_b
    slope = np.where(level, -1.0, value_b - value_a)
    return np.where(level, -np.inf, a - value_a * (b - a) / slope)


# Largest slope of the budget for secant steps: beyond, near the largest design that closes, a long
# step might pass the lightest solution.
_STEEPEST = 0.8


class LightestMass:
    """Search for the lightest masses that equal the mass budgets for them.

    While designs are ``open``, :meth:`take` the budgets of their ``assumed_kg``. Plain steps to the
    budget climb from below to the lightest solution. For a budget convex in the assumed mass, as
    nearly all are, a step along the secant of the last two is longer and does not pass the solution
    either. Other or steep budgets take plain steps.

    ``start_kg``: masses below all solutions, such as that of a part [kg]. ``relative_tolerance``:
    largest relative change of the mass in the last iteration [-]. ``mass_kg`` is infinite without a
    solution. ``open``: indices of the designs that have not converged.
    """

    def __init__(self, start_kg: FloatArray, relative_tolerance: float = 1e-13) -> None:
        self.mass_kg = np.array(start_kg, float)
        self.open: IntArray = np.arange(self.mass_kg.size)
        self._tolerance, self._rounds_left = relative_tolerance, 2000
        self._before = np.full((3, self.mass_kg.size), np.nan)  # mass, budget, slope

    @property
    def assumed_kg(self) -> FloatArray:
        """Return the masses of open designs to compute the budgets of [kg]."""
        return self.mass_kg[self.open]

    def take(self, budget_kg: FloatArray) -> None:
        """Step by the budgets of the open designs [kg]."""
        assumed, (before, budget_before, slope_before) = (
            self.assumed_kg,
            self._before[:, self.open],
        )
        budget = np.where(np.isfinite(budget_kg) & (budget_kg < 1e9), budget_kg, np.inf)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            still = np.abs(budget - assumed) <= self._tolerance * assumed
            slope = (budget - budget_before) / (assumed - before)
            convex = slope >= slope_before
            # Plain steps without two valid secants.
            feasible = convex & (slope > 0.0) & (slope <= _STEEPEST) & (budget > assumed)
            longer = np.where(feasible, 1.0 / (1.0 - slope), 1.0)
            settled = still | np.isinf(budget)
            step = np.where(settled, budget, assumed + longer * (budget - assumed))
        self._before[:, self.open] = assumed, budget, slope
        self.mass_kg[self.open] = step
        self.open = self.open[~settled]
        self._rounds_left -= 1
        if not self._rounds_left:
            self.mass_kg[self.open], self.open = np.inf, self.open[:0]
