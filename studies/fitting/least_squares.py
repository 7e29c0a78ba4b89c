"""Least squares of one channel, with errors of the flights whose spread is known.

Parameters of the aircraft are free; each error of a flight is a residual of its own, over its
standard deviation: a Bayesian linear model (Tarantola, A. (2005), Inverse Problem Theory, SIAM,
section 3.2). A residual of the channel weighs as many times as there are independent ones in
effect: its variance is that of its flight times the integrated autocorrelation time (Sokal, A.
(1997), Monte Carlo Methods in Statistical Mechanics, section 3). The covariance is that of the
sandwich estimator (White, H. (1980), Econometrica 48, 817-838), with the errors as they are known.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import chi2, norm, t

from sizing.aircraft import Aircraft
from solar.types import FloatArray
from studies.fitting.channels.channel import Channel
from studies.fitting.parameters import FitParameter, replaced_values
from studies.flight_logs.autocorrelation import correlation_time

CONFIDENCE = 0.95
# Probability of chi-square below which flights count as different.
UNLIKELY = 0.05
# Of the largest measured value: below, tables and rounding of the model decide.
_LEAST_SCATTER = 2e-3
# Weights follow from the residuals and these from the weights: until they change by less.
_ROUNDS, _SETTLED = 8, 0.02
_KEPT = 20  # models of a long log


@dataclass(frozen=True)
class Problem:
    """Parameters that are tried on a channel, around the values of an aircraft."""

    channel: Channel
    aircraft: Aircraft
    parameters: tuple[FitParameter, ...]

    @cached_property
    def _known(self) -> dict[bytes, FloatArray]:
        return {}

    def predicted(self, values: FloatArray) -> FloatArray:
        """Model without errors of the flights, kept for those who ask again."""
        key = values.tobytes()
        if key not in self._known:
            if len(self._known) >= _KEPT:
                self._known.clear()
            changed = replaced_values(self.aircraft, self.parameters, tuple(values.tolist()))
            self._known[key] = self.channel.predict(changed)
        return self._known[key]

    def residual(self, values: FloatArray, errors: FloatArray | None = None) -> FloatArray:
        """Measured less modelled."""
        return self.channel.apart(self.predicted(values), errors)

    def start(self) -> FloatArray:
        """Values of the aircraft's file."""
        return np.array([one.value(self.aircraft) for one in self.parameters])

    def jacobian(self, values: FloatArray, errors: FloatArray | None = None) -> FloatArray:
        """Derivatives of the model by central differences, shape (bin, parameter)."""
        columns = [np.zeros((len(self.channel.measured), 0))]
        for place, one in enumerate(self.parameters):
            step = 1e-4 * max(abs(values[place]), one.widest(values[place]), 1e-12)
            # One-sided at an end that cannot be crossed.
            up = min(values[place] + step, one.highest) - values[place]
            down = values[place] - max(values[place] - step, one.lowest)
            unit = np.eye(len(values))[place]
            apart = self.residual(values - down * unit, errors)
            apart = apart - self.residual(values + up * unit, errors)
            columns.append(apart[:, np.newaxis] / (up + down))
        return np.concatenate(columns, axis=1)

    def jacobian_of_errors(self, values: FloatArray, errors: FloatArray) -> FloatArray:
        """Derivatives of the model by the errors of the flights, shape (bin, error)."""
        if not self.channel.errors:
            return np.zeros((len(self.channel.measured), 0))
        modelled = self.channel.with_errors(self.predicted(values), errors)
        columns = modelled[:, np.newaxis] * self.channel.slopes
        if self.channel.floating:
            columns = np.apply_along_axis(self.channel.centred, 0, columns)
        return np.asarray(columns)


@dataclass(frozen=True)
class Solution:
    """Best values and their errors.

    ``residual``: with them. ``covariance``: of the parameters, and after them of the errors.
    ``half_width``: of the parameters. ``singular``: values of the parameters' Jacobian with columns
    of unit length. ``independent``: residuals that are so in effect. ``errors``: best values of
    those of the flights. ``flights``: what each says alone, where there are several.
    ``chi_square``, ``freedom``: of the differences between them.
    """

    values: FloatArray
    residual: FloatArray
    covariance: FloatArray
    half_width: FloatArray
    singular: FloatArray
    independent: float
    errors: FloatArray
    flights: tuple[Alone, ...] = ()
    chi_square: float = 0.0
    freedom: int = 0


@dataclass(frozen=True)
class Alone:
    """Values and standard errors by one of several flights, and its share of what all say."""

    values: FloatArray
    errors: FloatArray
    shares: FloatArray


def singular_values(jacobian: FloatArray) -> FloatArray:
    """Singular values of a Jacobian with columns of unit length, the largest first."""
    length = np.sqrt(np.sum(jacobian**2, axis=0))
    if not jacobian.shape[1]:
        return np.zeros(0)
    return np.asarray(np.linalg.svd(jacobian / np.maximum(length, 1e-300), compute_uv=False))


def solved(problem: Problem) -> Solution:
    """Fit the parameters, and the errors of the flights within their spread."""
    channel, count = problem.channel, len(problem.parameters)
    if not count:
        nothing, errors = np.zeros(0), np.zeros(len(channel.errors))
        residual = channel.residual(problem.aircraft)
        known = np.diag([one.sigma**2 for one in channel.errors])
        return Solution(nothing, residual, known, nothing, nothing, math.inf, errors)
    low = np.array([one.lowest for one in problem.parameters])
    high = np.array([one.highest for one in problem.parameters])
    start = np.clip(problem.start(), low + 1e-9, high * (1.0 - 1e-9))
    at = np.concatenate((start, np.zeros(len(channel.errors))))
    fit = _Weighted.first(problem, at)
    for _ in range(_ROUNDS):
        at = fit.minimum(at, low, high)
        before, fit = fit, _Weighted.at(problem, at, fit.weight)
        change = np.abs(np.log(fit.weight / before.weight)).max(initial=0.0)
        if not (channel.errors or len(channel.flights) > 1) or change < _SETTLED:
            break
    return _with_errors(problem, at, fit)


@dataclass(frozen=True)
class _Weighted:
    """Residuals, their derivatives, and what each residual weighs.

    ``times``: autocorrelation time by flight, in bins. ``unknown``: parameters and levels.
    ``apart``: residuals of each flight at its own optimum.
    """

    problem: Problem
    residual: FloatArray
    jacobian: FloatArray
    weight: FloatArray
    apart: FloatArray
    times: tuple[float, ...] = ()
    unknown: int = 0

    @classmethod
    def first(cls, problem: Problem, at: FloatArray) -> _Weighted:
        """All residuals weigh the same, as much as they scatter before the fit."""
        residual, jacobian = _linear(problem, at)
        scatter = max(float(np.std(residual)), _LEAST_SCATTER * _largest(problem.channel), 1e-12)
        return cls(problem, residual, jacobian, np.full(len(residual), scatter**-2), residual)

    @classmethod
    def at(cls, problem: Problem, at: FloatArray, weight: FloatArray) -> _Weighted:
        """Weights that follow from the residuals there."""
        channel = problem.channel
        residual, jacobian = _linear(problem, at)
        inverse = np.linalg.pinv(_normal(jacobian, weight, _prior(problem)))
        new, times, unknown = weight.copy(), [], len(problem.parameters)
        apart = residual.copy()
        for number, flight in zip(channel.numbers, channel.flights, strict=True):
            own, run = jacobian[flight], channel.run[flight]
            if len(channel.flights) > 1:  # less what others want of it
                parts = (own, residual[flight], weight[flight])
                apart[flight] -= own @ _of_flight(problem, at, parts, number)[0]
            mine = apart[flight]
            levels = int(run[-1] - run[0]) + 1 if channel.floating else 0
            unknown += levels
            times.append(correlation_time(mine, run, len(problem.parameters) + levels))
            # Errors that are known beforehand take away a part of a degree of freedom each.
            fitted = levels + float(np.sum(inverse * _normal(own, weight[flight])))
            scatter = math.sqrt(float(mine @ mine) / max(len(mine) - fitted, 1.0))
            scatter = max(scatter, _LEAST_SCATTER * _largest(channel), 1e-12)
            new[flight] = 1.0 / (scatter**2 * times[-1])
        return cls(problem, residual, jacobian, new, apart, tuple(times), unknown)

    def minimum(self, at: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
        """Best values by these weights."""
        problem, root, count = self.problem, np.sqrt(self.weight), len(low)
        sigmas = np.array([one.sigma for one in problem.channel.errors])
        open_ends = np.full(len(sigmas), np.inf)
        widest = zip(problem.parameters, at[:count].tolist(), strict=True)
        scale = np.array([max(one.widest(value), 1e-12) for one, value in widest])

        def residual(x: FloatArray) -> FloatArray:
            return np.concatenate(
                (root * problem.residual(x[:count], x[count:]), x[count:] / sigmas)
            )

        def jacobian(x: FloatArray) -> FloatArray:
            rows = -root[:, np.newaxis] * _linear(problem, x)[1]
            known = np.hstack((np.zeros((len(sigmas), count)), np.diag(1.0 / sigmas)))
            return np.vstack((rows, known))

        bounds = (np.append(low, -open_ends), np.append(high, open_ends))
        inside = np.clip(at, bounds[0] + 1e-12, bounds[1] - 1e-12)
        optimum = least_squares(
            residual, inside, jacobian, bounds, x_scale=np.append(scale, sigmas), xtol=1e-10
        )
        return np.asarray(optimum.x)


def _of_flight(
    problem: Problem, at: FloatArray, fit: tuple[FloatArray, FloatArray, FloatArray], number: int
) -> tuple[FloatArray, FloatArray]:
    """One step to the optimum of one flight, and the covariance of the parameters there.

    ``fit``: its derivatives, residuals and weights. What is wrong with the model of the aircraft on
    all flights, and errors of others, stay. What the flight does not determine has no step.
    """
    jacobian, residual, weight = fit
    count, prior, step = len(problem.parameters), _prior(problem), np.zeros(len(at))
    flights = [number] * count + [one.flight for one in problem.channel.errors]
    mine = np.flatnonzero([one == number for one in flights])
    own = jacobian[:, mine]
    covariance = _inverse(_normal(own, weight, prior[mine]))
    step[mine] = covariance @ (own.T @ (weight * residual) - prior[mine] * at[mine])
    return step, covariance[:count, :count]


def _linear(problem: Problem, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Residuals, and derivatives of the model by parameters and errors."""
    values, errors = np.split(at, [len(problem.parameters)])
    own = problem.jacobian(values, errors)
    whole = np.hstack((own, problem.jacobian_of_errors(values, errors)))
    return problem.residual(values, errors), whole


def _largest(channel: Channel) -> float:
    """Largest measured value; of a channel without errors no scatter is too small."""
    return float(np.abs(channel.measured).max()) if channel.errors else 0.0


def _prior(problem: Problem) -> FloatArray:
    """What is known of parameters (nothing) and errors before: inverse variances."""
    sigmas = [one.sigma for one in problem.channel.errors]
    return np.concatenate((np.zeros(len(problem.parameters)), np.array(sigmas) ** -2.0))


def _normal(
    jacobian: FloatArray, weight: FloatArray, prior: FloatArray | float = 0.0
) -> FloatArray:
    information = jacobian.T @ (weight[:, np.newaxis] * jacobian)
    return np.asarray(information + np.diag(np.broadcast_to(prior, len(information))))


def widening(chi_square: float, freedom: int) -> float:
    """Factor on the errors of flights that differ by more than chance does."""
    if not freedom or float(chi2.sf(chi_square, freedom)) > UNLIKELY:
        return 1.0
    return math.sqrt(chi_square / freedom)


def _with_errors(problem: Problem, at: FloatArray, fit: _Weighted) -> Solution:
    """Covariance and intervals."""
    channel, count, jacobian = problem.channel, len(problem.parameters), fit.jacobian
    flights, prior = channel.flights, _prior(problem)
    inverse = np.linalg.pinv(_normal(jacobian, fit.weight, prior))
    pairs = list(zip(flights, fit.times, strict=True))
    independent = sum((own.stop - own.start) / time for own, time in pairs)
    free = max(independent - fit.unknown, 1.0)
    # As if each of the independent residuals stood for `time` bins, all of them equal.
    scores = fit.weight[:, np.newaxis] * jacobian * fit.apart[:, np.newaxis]
    meat = sum(time * scores[own].T @ scores[own] for own, time in pairs) * independent / free
    scatter, known = inverse @ meat @ inverse, inverse @ np.diag(prior) @ inverse
    alone, chi_square, freedom = _by_flight(problem, at, fit)
    # Flights that differ by more than their errors: Birge, R. T. (1932), Physical Review 40, 207.
    wider = widening(chi_square, freedom)
    scale = np.where(np.arange(len(at)) < count, wider, 1.0)
    tail = 0.5 + 0.5 * CONFIDENCE
    parts = t.ppf(tail, free) ** 2 * np.diag(scatter) + norm.ppf(tail) ** 2 * np.diag(known)
    return Solution(
        values=at[:count],
        residual=fit.residual,
        covariance=(scatter + known) * np.outer(scale, scale),
        half_width=wider * np.sqrt(parts[:count]),
        singular=singular_values(jacobian[:, :count]),
        independent=independent,
        errors=at[count:],
        flights=alone,
        chi_square=chi_square,
        freedom=freedom,
    )


def _by_flight(
    problem: Problem, at: FloatArray, fit: _Weighted
) -> tuple[tuple[Alone, ...], float, int]:
    """What each of several flights says alone, and chi-square of the differences."""
    channel, count = problem.channel, len(problem.parameters)
    if len(channel.flights) < 2:
        return (), 0.0, 0
    found = []
    for number, rows in zip(channel.numbers, channel.flights, strict=True):
        parts = (fit.jacobian[rows], fit.residual[rows], fit.weight[rows])
        step, covariance = _of_flight(problem, at, parts, number)
        found.append((step[:count], covariance, _inverse(covariance)))
    whole = _inverse(np.sum([known for *_, known in found], axis=0))
    alone = tuple(
        Alone(at[:count] + step, np.sqrt(np.diag(covariance)), np.diag(whole @ known))
        for step, covariance, known in found
    )
    ranks = sum(int(np.linalg.matrix_rank(known, hermitian=True)) for *_, known in found)
    return alone, sum(float(step @ known @ step) for step, _, known in found), ranks - count


def _inverse(information: FloatArray) -> FloatArray:
    """Covariance of what a flight determines; nothing of what it does not."""
    return np.asarray(np.linalg.pinv(information, rcond=1e-8, hermitian=True))
