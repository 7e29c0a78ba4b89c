"""Roots of many functions at once, bisection of a condition, and masses that equal their budgets.

``scipy.optimize.elementwise`` finds the same roots, but its import takes longer than a sizing.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from solar.types import FloatArray, IntArray

_MAXIMUM_ROUNDS = 100  # bisection to rounding takes 53
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


# Largest slope of the budget for secant steps: beyond, near the largest design that closes, a long
# step might pass the lightest solution.
_STEEPEST = 0.8
_MOST_STEPS = 2000


def lightest_mass(
    budget_kg: Callable[[IntArray, FloatArray], ArrayLike],
    start_kg: ArrayLike,
    relative_tolerance: float = 1e-13,
) -> FloatArray:
    """Return the lightest masses that equal the mass budgets for them; infinite without one [kg].

    Plain steps to the budget climb from below to the lightest solution. For a budget convex in the
    assumed mass, as nearly all are, a step along the secant of the last two is longer and does not
    pass the solution either. Other or steep budgets take plain steps.

    ``budget_kg``: of indices of designs that have not converged, and their assumed masses.
    ``start_kg``: masses below all solutions, such as that of a part. ``relative_tolerance``:
    largest relative change of the mass in the last iteration [-].
    """
    mass_kg = np.array(start_kg, float)
    rows = np.arange(mass_kg.size)
    before = np.full((3, mass_kg.size), np.nan)  # mass, budget, slope
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        for _ in range(_MOST_STEPS):
            if not rows.size:
                return mass_kg
            assumed, (last, last_budget, last_slope) = mass_kg[rows], before[:, rows]
            budget = np.asarray(budget_kg(rows, assumed), float)
            budget = np.where(np.isfinite(budget) & (budget < 1e9), budget, np.inf)
            slope = (budget - last_budget) / (assumed - last)
            # Plain steps without two valid secants.
            convex = (slope >= last_slope) & (slope > 0.0) & (slope <= _STEEPEST)
            longer = np.where(convex & (budget > assumed), 1.0 / (1.0 - slope), 1.0)
            settled = np.abs(budget - assumed) <= relative_tolerance * assumed
            settled |= np.isinf(budget)
            before[:, rows] = assumed, budget, slope
            mass_kg[rows] = np.where(settled, budget, assumed + longer * (budget - assumed))
            rows = rows[~settled]
    mass_kg[rows] = np.inf
    return mass_kg
