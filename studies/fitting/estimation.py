"""Least squares of one channel, and how well it tells its parameters apart.

Residuals of a flight are correlated in time: clouds, gusts and gauges last longer than a mean over
some minutes. The standard errors are therefore those of the sandwich estimator (White, H. (1980),
Econometrica 48, 817-838) for as many independent residuals as there are in effect: their number
over the integrated autocorrelation time (Sokal, A. (1997), Monte Carlo Methods in Statistical
Mechanics, section 3). Intervals are Student's with what that number leaves of degrees of freedom.

Parameters that do the same to the measured quantity cannot both be fitted. The collinearity index
is one over the smallest singular value of the Jacobian whose columns have unit length (Brun, R.,
Reichert, P. & Kuensch, H. R. (2001), Water Resources Research 37, 1015-1030); up to about 20 a set
of parameters counts as identifiable (Soetaert, K. & Petzoldt, T. (2010), Journal of Statistical
Software 33(3), section 4).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import norm, t

from sizing.aircraft import Aircraft
from solar.types import FloatArray
from studies.fitting.channels.bins import BIN_S
from studies.fitting.channels.channel import Channel
from studies.fitting.parameters import FitParameter, with_values
from studies.flight_logs.autocorrelation import correlation_time

CONFIDENCE = 0.95
COLLINEAR = 20.0
# A parameter whose whole range of the search moves the model by less than so much of the residuals'
# spread plays no part; rounding moves it by less.
_NO_PART = 1e-9
# Fewer independent residuals say nothing about how large errors are.
_FEWEST_INDEPENDENT = 2.0
_AT_END = 1e-6  # of the range of the search


@dataclass(frozen=True)
class Fitted:
    """A parameter that was fitted.

    ``before``, ``value``: that of the file, and that of the fit. ``standard_error``: of the
    measurement's scatter and of the light's uncertainty together. ``low``, ``high``: ends of the
    confidence interval.
    """

    parameter: FitParameter
    before: float
    value: float
    standard_error: float
    low: float
    high: float

    @property
    def half_width(self) -> float:
        """Half of the confidence interval."""
        return 0.5 * (self.high - self.low)


@dataclass(frozen=True)
class Held:
    """A parameter that stays as the file has it, and why."""

    parameter: FitParameter
    value: float
    reason: str


@dataclass(frozen=True)
class Estimate:
    """Fit of one channel.

    ``covariance``: of the fitted parameters. ``singular_values``: of the Jacobian of the fitted
    parameters with columns of unit length. ``independent``: residuals that are independent in
    effect. ``before``, ``after``: residuals with the file's values and with the fitted ones.
    """

    channel: Channel
    fitted: tuple[Fitted, ...]
    held: tuple[Held, ...]
    covariance: FloatArray
    singular_values: FloatArray
    independent: float
    before: FloatArray
    after: FloatArray

    def noise(self, hours: float) -> float:
        """Standard deviation of the residuals' integral over so many hours.

        Independent residuals add up as their squares do, and each of them lasts as long as the
        correlation does.
        """
        if not 0.0 < self.independent < math.inf:
            return 0.0
        lasts_h = len(self.after) / self.independent * BIN_S / 3600.0
        return math.sqrt(float(np.mean(self.after**2)) * lasts_h * max(hours, 0.0))

    @property
    def collinearity(self) -> float:
        """Collinearity index of the fitted parameters; 1 where they do nothing in common."""
        return 1.0 / float(self.singular_values.min()) if len(self.singular_values) else 1.0

    def correlation(self) -> FloatArray:
        """Correlation of the fitted parameters."""
        root = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(root, root))


@dataclass(frozen=True)
class _Problem:
    """Parameters that are tried on a channel, around the values of an aircraft."""

    channel: Channel
    aircraft: Aircraft
    parameters: tuple[FitParameter, ...]

    def residual(self, values: FloatArray, light: float = 1.0) -> FloatArray:
        aircraft = with_values(self.aircraft, self.parameters, tuple(values.tolist()))
        return self.channel.residual(aircraft, light)

    def start(self) -> FloatArray:
        return np.array([one.value(self.aircraft) for one in self.parameters])

    def jacobian(self, values: FloatArray) -> FloatArray:
        """Derivatives of the model by central differences, shape (bin, parameter)."""
        columns = []
        for place, one in enumerate(self.parameters):
            step = np.zeros(len(values))
            step[place] = 1e-4 * max(abs(values[place]), one.widest(values[place]), 1e-12)
            # One-sided at an end that cannot be crossed.
            up = min(values[place] + step[place], one.highest) - values[place]
            down = values[place] - max(values[place] - step[place], one.lowest)
            unit = np.eye(len(values))[place]
            apart = self.residual(values - down * unit) - self.residual(values + up * unit)
            columns.append(apart / (up + down))
        return np.stack(columns, axis=1)

    def without(self, place: int) -> _Problem:
        rest = tuple(one for i, one in enumerate(self.parameters) if i != place)
        return _Problem(self.channel, self.aircraft, rest)


def estimate(
    channel: Channel,
    aircraft: Aircraft,
    parameters: tuple[FitParameter, ...],
    light_sigma: float = 0.0,
) -> Estimate:
    """Fit parameters to a channel, as many of them as it can tell apart.

    ``aircraft``: start, and the values of what is not fitted. ``parameters``: what is asked for; of
    those that cannot be told apart the later ones are held. ``light_sigma``: standard uncertainty
    of the light of the sky, relative [-]: one factor for the whole flight, which no fit of this
    channel can tell from the modules.
    """
    problem = _Problem(channel, aircraft, parameters)
    held: list[Held] = []
    problem = _told_apart(problem, held)
    while True:
        solution = _solved(problem, light_sigma)
        worst = _undetermined(problem, solution)
        if worst is None:
            break
        place, reason = worst
        held.append(_held(problem, place, reason))
        problem = problem.without(place)
    before = channel.residual(aircraft)
    fitted = tuple(
        Fitted(one, start, value, error, value - half, value + half)
        for one, start, value, error, half in zip(
            *(problem.parameters, problem.start().tolist(), solution.values.tolist()),
            *(solution.standard_error().tolist(), solution.half_width.tolist()),
            strict=True,
        )
    )
    return Estimate(
        *(
            channel,
            fitted,
            tuple(held),
            solution.covariance,
            solution.singular,
            solution.independent,
        ),
        *(before, solution.residual),
    )


def _held(problem: _Problem, place: int, reason: str) -> Held:
    one = problem.parameters[place]
    return Held(one, one.value(problem.aircraft), reason)


# ---- What can be told apart


def _told_apart(problem: _Problem, held: list[Held]) -> _Problem:
    """Problem without parameters that play no part or do the same as those before them."""
    start = problem.start()
    jacobian = problem.jacobian(start)
    spread = float(np.std(problem.residual(start))) or 1.0
    kept: list[int] = []
    for place, one in enumerate(problem.parameters):
        moved = np.abs(jacobian[:, place]).max(initial=0.0) * (one.highest - one.lowest)
        if not moved > _NO_PART * spread:
            held.append(_held(problem, place, f"it plays no part in the {problem.channel.label}"))
            continue
        singular = _singular_values(jacobian[:, [*kept, place]])
        if len(singular) and 1.0 / max(float(singular.min()), 1e-300) > COLLINEAR:
            held.append(_held(problem, place, _alike(problem, jacobian, kept, place)))
            continue
        kept.append(place)
    return _Problem(
        problem.channel, problem.aircraft, tuple(problem.parameters[place] for place in kept)
    )


def _singular_values(jacobian: FloatArray) -> FloatArray:
    """Singular values of a Jacobian with columns of unit length, the largest first."""
    length = np.sqrt(np.sum(jacobian**2, axis=0))
    if not jacobian.shape[1]:
        return np.zeros(0)
    return np.asarray(np.linalg.svd(jacobian / np.maximum(length, 1e-300), compute_uv=False))


def _alike(problem: _Problem, jacobian: FloatArray, kept: list[int], place: int) -> str:
    """Words for a parameter that does what others do."""
    columns = jacobian / np.sqrt(np.sum(jacobian**2, axis=0))
    cosines = columns[:, kept].T @ columns[:, place]
    nearest = kept[int(np.argmax(np.abs(cosines)))]
    index = 1.0 / max(float(_singular_values(jacobian[:, [*kept, place]]).min()), 1e-300)
    ratio = "above 1e6" if index > 1e6 else f"{index:.0f}"
    other = problem.parameters[nearest].name
    if len(kept) > 1:
        other += " and the others"
    return (
        f"the log cannot tell it from {other}: correlation of their effects "
        f"{float(np.max(np.abs(cosines))):.4f}, collinearity index {ratio} (at most {COLLINEAR:g})"
    )


@dataclass(frozen=True)
class _Solution:
    values: FloatArray
    residual: FloatArray
    covariance: FloatArray
    half_width: FloatArray
    singular: FloatArray
    independent: float

    def standard_error(self) -> FloatArray:
        return np.asarray(np.sqrt(np.diag(self.covariance)))


def _undetermined(problem: _Problem, solution: _Solution) -> tuple[int, str] | None:
    """Parameter that the log leaves open most of all, and why; None where there is none."""
    if not problem.parameters:
        return None
    last = len(problem.parameters) - 1
    if solution.independent < _FEWEST_INDEPENDENT:
        return last, (
            f"only {solution.independent:.1f} residuals are independent in effect: "
            "the log is too short, or its errors last too long"
        )
    worst, reason, most = None, "", 1.0
    for place, one in enumerate(problem.parameters):
        value, half = float(solution.values[place]), float(solution.half_width[place])
        margin = _AT_END * (one.highest - one.lowest)
        if not one.lowest + margin < value < one.highest - margin:
            return place, f"the best value is at the end of what is possible, {value:g} {one.unit}"
        open_by = half / one.widest(value)
        if open_by > most:
            worst, most = place, open_by
            reason = f"the interval is as wide as {value:.3g} +- {half:.2g} {one.unit}".rstrip()
    return None if worst is None else (worst, reason)


# ---- Least squares and their errors


def _solved(problem: _Problem, light_sigma: float) -> _Solution:
    channel, count = problem.channel, len(problem.parameters)
    if not count:
        nothing = np.zeros(0)
        residual = channel.residual(problem.aircraft)
        return _Solution(nothing, residual, np.zeros((0, 0)), nothing, nothing, math.inf)
    parameters = problem.parameters
    low = np.array([one.lowest for one in parameters])
    high = np.array([one.highest for one in parameters])
    start = np.clip(problem.start(), low + 1e-9, high * (1.0 - 1e-9))
    scale = [max(one.widest(float(at)), 1e-12) for one, at in zip(parameters, start, strict=True)]
    optimum = least_squares(problem.residual, start, bounds=(low, high), x_scale=scale, xtol=1e-10)
    residual, jacobian = np.asarray(optimum.fun), problem.jacobian(optimum.x)
    inverse = np.linalg.pinv(jacobian.T @ jacobian)
    unknown = count + channel.levels
    correlated = correlation_time(residual, channel.run, unknown)
    independent = len(residual) / correlated
    free = max(independent - unknown, 1.0)
    scores = jacobian * residual[:, np.newaxis]
    # As if each of the independent residuals stood for `correlated` bins, all of them equal.
    sandwich = inverse @ (scores.T @ scores) @ inverse * correlated
    sandwich = sandwich * independent / free
    # A factor on the light is taken for a change of the parameters.
    shifted = problem.residual(optimum.x, 1.0 + 1e-3) - problem.residual(optimum.x, 1.0 - 1e-3)
    moved = inverse @ (jacobian.T @ (shifted / 2e-3)) * light_sigma
    tail = 0.5 + 0.5 * CONFIDENCE
    scatter = t.ppf(tail, free) ** 2 * np.diag(sandwich)
    half_width = np.sqrt(scatter + (norm.ppf(tail) * moved) ** 2)
    return _Solution(
        *(optimum.x, residual, sandwich + np.outer(moved, moved), half_width),
        *(_singular_values(jacobian), independent),
    )
