"""Robust fit of measured power by modelled power at another level, clock and heading."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solar.types import FloatArray
from studies.flight_logs.alignment.shifted_power import ShiftedPower

# Tukey's biweight with 95 % of the efficiency of least squares on normal residuals: Holland, P. W.,
# Welsch, R. E. (1977), Communications in Statistics A6(9), 813-827.
_TUNING = 4.685
_SIGMA_OF_MAD = 1.4826
_ITERATIONS = 25
_TIME_STEP_S, _TURN_STEP_RAD = 30.0, np.radians(1.0)
_LARGEST_STEP = np.array([0.5, 1800.0, 0.5])
_BLOCK_S, _LEAST_BLOCKS = 1200.0, 8
_SCALE_FLOOR = 2e-3  # of the peak: below, the model's tables and rounding decide


@dataclass(frozen=True)
class Fit:
    """Best level, clock and heading, with what the errors are computed from.

    ``level``, ``ahead_s``, ``turned_rad``: measured over modelled power, clock ahead of universal
    time, logged heading clockwise of the true one. ``heading``: whether the heading was fitted.
    ``scale_w``, ``cost``: robust standard deviation of the residuals [W], and their mean biweight
    loss. ``independent``: how many independent residuals the samples are worth. ``covariance``: of
    log level, clock [s] and heading [rad], shape (3, 3).
    """

    level: float
    ahead_s: float
    turned_rad: float
    heading: bool
    scale_w: float
    cost: float
    independent: float
    modelled_w: FloatArray
    covariance: FloatArray
    _gain: FloatArray

    def answer(self, change_w: FloatArray) -> FloatArray:
        """Change of log level, clock [s] and heading [rad] by one of the measured power [W]."""
        return self._gain @ change_w


def biweight_cost(measured: FloatArray, modelled: FloatArray, scale_w: float) -> float:
    """Mean of Tukey's biweight loss, from 0 to 1.

    ``scale_w``: standard deviation of residuals that are no outliers [W].
    """
    u = np.minimum(np.abs(measured - modelled) / (_TUNING * scale_w), 1.0)
    return float(np.mean(1.0 - (1.0 - u**2) ** 3))


def fitted(
    model: ShiftedPower,
    measured: FloatArray,
    ahead_s: float,
    turned_rad: float,
    *,
    heading: bool,
) -> Fit | None:
    """Fit level, clock and heading by iteratively reweighted least squares.

    ``scipy.optimize.least_squares`` takes as many evaluations of the model, but holds the scale of
    the residuals, so that the rounds here would stay around it.

    ``measured``: measured power of the samples [W], in any unit. ``ahead_s``, ``turned_rad``:
    start: how far the clock is ahead [s], the heading clockwise [rad]. None if no light falls at
    that clock, or the power does not tell the clock.
    """
    count = 3 if heading else 2
    theta = np.array([0.0, ahead_s, turned_rad])
    power = model.power_w(ahead_s, turned_rad)
    bright = power > 0.25 * power.max(initial=0.0)
    level = float(np.quantile(measured[bright] / power[bright], 0.6)) if bright.any() else 0.0
    if not level > 0.0:
        return None
    theta[0] = np.log(level)
    least = _SCALE_FLOOR * float(np.quantile(measured, 0.98))
    for _ in range(_ITERATIONS):
        jacobian, power = _derivatives(model, theta, count)
        residual = measured - power
        scale = max(_SIGMA_OF_MAD * float(np.median(np.abs(residual))), least)
        weight = np.maximum(1.0 - (residual / (_TUNING * scale)) ** 2, 0.0) ** 2
        weighted = jacobian * weight[:, np.newaxis]
        normal = weighted.T @ jacobian
        damping = 1e-9 * np.diag(np.diag(normal)) + 1e-12 * np.eye(count)
        try:
            step = np.linalg.solve(normal + damping, weighted.T @ residual)
        except np.linalg.LinAlgError:
            return None
        if not np.all(np.isfinite(step)):
            return None
        step = np.clip(step, -_LARGEST_STEP[:count], _LARGEST_STEP[:count])
        theta[:count] += step
        if abs(step[1]) < 0.5 and (count == 2 or abs(step[2]) < 1e-4):
            break
    return _finished(model, measured, theta, count, least)


def _derivatives(
    model: ShiftedPower, theta: FloatArray, count: int
) -> tuple[FloatArray, FloatArray]:
    """Derivatives of the fitted power by log level, clock and heading, and that power [W]."""
    level, ahead, turned = np.exp(theta[0]), float(theta[1]), float(theta[2])
    if count == 3:
        turns = turned + _TURN_STEP_RAD * np.array([0.0, -1.0, 1.0])
        power, before, after = level * model.power_w(ahead, turns)
        columns = [(after - before) / (2.0 * _TURN_STEP_RAD)]
    else:
        power, columns = level * model.power_w(ahead, turned), []
    sooner, later = (level * model.power_w(ahead + s * _TIME_STEP_S, turned) for s in (-1.0, 1.0))
    clock = (later - sooner) / (2.0 * _TIME_STEP_S)
    return np.stack([power, clock, *columns], axis=1), power


def _finished(
    model: ShiftedPower, measured: FloatArray, theta: FloatArray, count: int, least: float
) -> Fit | None:
    """Errors of the fit from its curvature, and from residuals that are alike over minutes.

    Sandwich of Huber, P. J. (1967), Proc. 5th Berkeley Symposium 1, 221-233, over blocks of time as
    of Liang, K.-Y., Zeger, S. L. (1986), Biometrika 73(1), 13-22.
    """
    jacobian, power = _derivatives(model, theta, count)
    residual = measured - power
    scale = max(_SIGMA_OF_MAD * float(np.median(np.abs(residual))), least)
    u2 = np.minimum((residual / (_TUNING * scale)) ** 2, 1.0)
    influence = residual * (1.0 - u2) ** 2
    slope = (1.0 - u2) * (1.0 - 5.0 * u2)
    bread = (jacobian * slope[:, np.newaxis]).T @ jacobian
    try:
        inverse = np.linalg.inv(bread)
    except np.linalg.LinAlgError:
        return None
    scores = jacobian * influence[:, np.newaxis]
    block = _blocks(model.time_s)
    groups = int(block.max()) + 1
    sums = np.stack(
        [np.bincount(block, scores[:, i], minlength=groups) for i in range(count)], axis=1
    )
    factor = groups / max(groups - count, 1)
    clustered = factor * inverse @ (sums.T @ sums) @ inverse.T
    plain = inverse @ (scores.T @ scores) @ inverse.T
    # Never less than independent residuals would give: few blocks scatter by themselves.
    larger = np.maximum(np.sqrt(np.diag(clustered)), np.sqrt(np.diag(plain)))
    own = np.sqrt(np.maximum(np.diag(clustered), 1e-300))
    covariance = np.zeros((3, 3))
    covariance[:count, :count] = clustered * np.outer(larger / own, larger / own)
    gain = np.zeros((3, len(measured)))
    gain[:count] = inverse @ (jacobian * slope[:, np.newaxis]).T
    worth = float(np.diag(plain)[1] / max(larger[1] ** 2, 1e-300))
    fitted_level = float(np.exp(theta[0]))
    if not (np.all(np.isfinite(covariance)) and np.all(np.diag(covariance)[:count] > 0.0)):
        return None
    return Fit(
        level=fitted_level,
        ahead_s=float(theta[1]),
        turned_rad=float(theta[2]),
        heading=count == 3,
        scale_w=scale,
        cost=biweight_cost(measured, power, scale),
        independent=len(measured) * worth,
        modelled_w=power,
        covariance=covariance,
        _gain=gain,
    )


def _blocks(time_s: FloatArray) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Number of the block of time of each sample: 20 minutes, less in a short log."""
    span = float(time_s[-1] - time_s[0])
    length = min(_BLOCK_S, max(span / _LEAST_BLOCKS, 1.0))
    number = np.floor((time_s - time_s[0]) / length).astype(np.int64)
    return np.asarray(np.unique(number, return_inverse=True)[1], np.int64)
