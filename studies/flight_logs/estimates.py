"""Estimates of clock, heading and powers of a log, with intervals and the options to apply them.

``P = factor * P_FM(t - clock, yaw - heading)`` is fitted by :func:`scipy.optimize.least_squares`,
reweighted for Cauchy's loss (Holland, P. W., Welsch, R. E. (1977), Communications in Statistics
A6(9), 813-827). Errors of log and model that look like a clock or a heading are fitted along within
their standard deviations. Intervals are by the sandwich estimator (White, H. (1980), Econometrica
48, 817-838), over sums of ten minutes, weighted by the autocorrelation time of these sums.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, least_squares
from scipy.stats import norm
from scipy.stats import t as student

from missions import air
from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.mass_budget import ImpossibleDesignError, design_of
from sizing.parameters import all_replaced, parameter_value
from solar.schema import spell
from solar.types import FloatArray, IntArray
from studies.flight_logs.forward import Forward, Offsets

CONFIDENCE = 0.95
WIDE = float(norm.ppf(0.5 + 0.5 * CONFIDENCE))  # half-width in standard errors
# Prior standard deviation, and step of the fit; docs/verify.md gives sources.
_UNKNOWNS = {
    "factor": (np.inf, 0.05),
    "clock_s": (np.inf, 60.0),
    "heading": (np.inf, 0.02),
    "roll": (float(np.radians(0.5)), 0.005),
    "pitch": (float(np.radians(0.5)), 0.005),
    "haze": (0.1, 0.05),
    "diffuse": (0.4, 0.1),
    "incidence": (0.05, 0.02),
    "low_light": (0.03, 0.02),
    "drift": (0.02, 0.01),
}
# CAM ignores how wind tilts the wing, which looks like a clock: by 7 min in a log of the report's
# flight, in 2 m/s of easterly wind.
_CAM_CLOCK_S = 420.0
_OF_ATTITUDE = ("heading", "roll", "pitch")
_LEAST_SAMPLES, _SAMPLES, _FEW, _COARSE = 60, 1000, 250, 100
_BLOCK_S = 600.0  # several circles
_CAUCHY = 2.385  # 95 % efficient where residuals are normal (Holland & Welsch 1977)
_LEAST_SCATTER = 2e-3  # of the peak: to which tables and rounding of the model hold
_ROUNDS, _NEAR = 5, 1e-4  # each round goes on from the last one
# Coarse grid of starts: clocks to either side, and turns of the heading.
_MOST_CLOCK_S, _SHIFT_S, _TURNS, _STARTS = 14 * 3600.0, 1800.0, 12, 3
# Autocorrelation that counts as none: where the window of its sum ends.
_LAST_CORRELATION = 0.05
_LONGEST_MEMORY = 0.97  # of a process, from bin to bin
_MOST_LOST = 0.75  # share of that sum which a fit may have taken away; keeps the correction finite


@dataclass(frozen=True)
class Fit:
    """Values of ``names`` and their covariance; ``factor`` is the logarithm of the factor.

    ``level``: logarithm of measured over modelled energy at this clock and heading, and its
    standard error. ``scatter_w``: of the residuals.
    """

    names: tuple[str, ...]
    values: FloatArray
    covariance: FloatArray
    scatter_w: float
    level: tuple[float, float] = (0.0, 0.0)

    def of(self, name: str) -> tuple[float, float]:
        """Return a fitted value and the half-width of its interval."""
        place = self.names.index(name)
        return float(self.values[place]), WIDE * float(np.sqrt(self.covariance[place, place]))

    @property
    def factor(self) -> tuple[float, float, float]:
        """Measured over modelled energy, and the ends of its interval [-]."""
        level, error = self.level
        low, middle, high = np.exp(level + WIDE * error * np.array([-1.0, 0.0, 1.0])).tolist()
        return middle, low, high

    @property
    def correlation(self) -> float | None:
        """Correlation of the errors of clock and heading, None unless both are fitted."""
        if "heading" not in self.names:
            return None
        i, j = self.names.index("clock_s"), self.names.index("heading")
        c = self.covariance
        return float(c[i, j] / np.sqrt(c[i, i] * c[j, j]))

    def applied_w(self, forward: Forward) -> FloatArray:
        """Return the power with the fitted clock, heading and factor alone [W]."""
        moved = np.where(np.isin(self.names, ("clock_s", "heading")), self.values, 0.0)
        return self.factor[0] * _power_w(forward, self.names, moved)

    def expected_w(self, forward: Forward) -> FloatArray:
        """Return the power with all fitted values [W]."""
        return _power_w(forward, self.names, self.values)


def _power_w(forward: Forward, names: tuple[str, ...], values: FloatArray) -> FloatArray:
    """Return the modelled power [W] at values of ``names``."""
    offsets = Offsets(**dict(zip(names[1:], values[1:].tolist(), strict=True)))
    return np.asarray(np.exp(values[0]) * forward.power_w(offsets))


def fit_log(forward: Forward) -> Fit | None:
    """Fit clock, heading and factor to samples of a log; None for too few samples."""
    names = tuple(n for n in _UNKNOWNS if forward.knows_angles or n not in _OF_ATTITUDE)
    if len(forward.index) < _LEAST_SAMPLES or not forward.measured_w.sum() > 0.0:
        return None
    thinned = _thinned(forward, _SAMPLES)
    starts = list(_starts(thinned, turned="heading" in names))
    start = starts[0]
    if len(starts) > 1:  # without the prior errors: these are small
        few = _thinned(thinned, _FEW)
        fits = (_fit(few, names[: len(start)], start, rounds=1) for start in starts)
        start = min(fits, key=lambda fit: fit.scatter_w).values
    fit = _fit(thinned, names, np.append(start, np.zeros(len(names) - len(start))))

    # The other errors shift the fit's factor, which users apply without them.
    def level(values: FloatArray) -> float:
        moved = np.where(np.isin(names, ("clock_s", "heading")), values, 0.0)
        whole, part = (_power_w(thinned, names, v).sum() for v in (values, moved))
        return float(np.log(whole / part))

    steps = 0.1 * np.array([_UNKNOWNS[name][1] for name in names])
    middle = level(fit.values)
    slopes = np.array([level(fit.values + step) - middle for step in np.diag(steps)]) / steps
    return replace(fit, level=(middle, float(np.sqrt(slopes @ fit.covariance @ slopes))))


def _thinned(forward: Forward, most: int) -> Forward:
    """Return at most so many samples, at random in even cells: a stride could match circles."""
    count = len(forward.index)
    if count <= most:
        return forward
    edges = np.linspace(0, count, most + 1)
    within = edges[:-1] + np.random.default_rng(0).random(most) * np.diff(edges)
    return forward.of(forward.index[np.unique(within.astype(int))])


def _starts(forward: Forward, *, turned: bool) -> Iterator[FloatArray]:
    """Yield start values: factor, clock and heading as logged, and better ones of a grid."""
    few = _thinned(forward, _COARSE)
    count, measured = len(few.index), few.measured_w
    turns = 2.0 * np.pi * np.arange(_TURNS if turned else 1) / _TURNS
    every = few.of(np.tile(few.index, len(turns)))
    tried = []
    for shift_s in np.arange(-_MOST_CLOCK_S, _MOST_CLOCK_S + 1.0, _SHIFT_S).tolist():
        offsets = Offsets(clock_s=shift_s, heading=np.repeat(turns, count))
        for turn, power in zip(turns, every.power_w(offsets).reshape(-1, count), strict=True):
            factor = float(measured @ power) / max(float(power @ power), 1e-9)
            misfit = float(np.abs(measured - factor * power).mean())
            angle = float((turn + np.pi) % (2.0 * np.pi) - np.pi)
            tried.append((misfit, max(factor, 1e-9), shift_s, angle))
    as_logged = next(trial for trial in tried if trial[2:] == (0.0, 0.0))
    better = [trial for trial in sorted(tried) if trial[0] < as_logged[0]]
    for _, factor, shift_s, turn in (as_logged, *better[:_STARTS]):
        yield np.array([np.log(factor), shift_s, turn][: 3 if turned else 2])


def _fit(
    forward: Forward, names: tuple[str, ...], values: FloatArray, rounds: int = _ROUNDS
) -> Fit:
    """Fit in rounds: weights from residuals, then values from weights."""
    sigmas, steps = np.array([_UNKNOWNS[name] for name in names]).T
    measured = forward.measured_w

    def residual_w(values: FloatArray) -> FloatArray:
        return measured - _power_w(forward, names, values)

    # Power that two in a hundred samples exceed: spikes do not count.
    peak_w = float(np.quantile(measured, 0.98))
    # Block of ten minutes of each sample, and stretch of each block.
    log, index = forward.log, forward.index
    slot, segment = np.floor(log.time_s[index] / _BLOCK_S).astype(int), log.segment()[index]
    block = np.concatenate(([0], np.cumsum((np.diff(slot) != 0) | (np.diff(segment) != 0))))
    first = np.flatnonzero(np.diff(block, prepend=-1))
    run = np.concatenate(([0], np.cumsum(np.diff(slot[first]) > 1)))
    residual, time = residual_w(values), 10.0
    for _ in range(rounds):
        scatter = 1.4826 * float(np.median(np.abs(residual)))
        scatter = max(scatter, _LEAST_SCATTER * peak_w)
        weight = 1.0 / (1.0 + (residual / (_CAUCHY * scatter)) ** 2)
        root = np.sqrt(weight / time) / scatter

        def rows(scaled: FloatArray, root: FloatArray = root) -> FloatArray:
            left = residual_w(scaled * steps)
            return np.concatenate((root * left, scaled * steps / sigmas))

        best = least_squares(rows, values / steps, method="lm", ftol=_NEAR, xtol=_NEAR)
        values = best.x * steps
        residual = residual_w(values)
        jacobian = best.jac / steps
        inverse = np.linalg.pinv(jacobian.T @ jacobian)
        shares = (jacobian[: len(residual)] * (root * residual)[:, np.newaxis]) @ inverse
        sums = np.stack([np.bincount(block, column) for column in shares.T], axis=1)
        times = [correlation_time(column, run, len(names)) for column in sums.T]
        sandwich = (sums.T @ sums) * np.sqrt(np.outer(times, times))
        # Samples for an independent one.
        squares = np.maximum(np.sum(shares**2, axis=0), 1e-300)
        time = max(float(np.median(np.diag(sandwich) / squares)), 1.0)
        covariance = sandwich + inverse @ np.diag(sigmas**-2.0) @ inverse
    if not forward.knows_angles:
        covariance[1, 1] += _CAM_CLOCK_S**2
    return Fit(names, values, covariance, scatter)


def correlation_time(residual: FloatArray, run: IntArray, unknown: int) -> float:
    """Return the integrated autocorrelation time of residuals, in bins, at least 1.

    Each of ``unknown`` fitted values lowers correlations by about the time over the number of
    residuals (Marriott, F. H. C. & Pope, J. A. (1954), Biometrika 41, 390-402); that is added back.
    At least the time of a first-order process through the correlations of the first two lags. Pairs
    across the ends of a ``run`` do not count.
    """
    count = len(residual)
    raw = _autocorrelation(residual, run)
    if len(raw) < 2:
        return 1.0
    least = _mixed_time(raw, 0.0)
    least = _mixed_time(raw, min(least * unknown / count, 1.0))
    small = np.flatnonzero(raw < _LAST_CORRELATION)
    window = int(small[0]) if len(small) else len(raw)
    lags = np.arange(1, window + 1)
    seen = 1.0 + 2.0 * float(np.sum(raw[:window] * (1.0 - lags / count)))
    # Every correlation within the window is too low by time * unknown / count.
    lost = min(2.0 * window * unknown / count, _MOST_LOST)
    time = min(max(seen, 1.0) / (1.0 - lost), count / 2.0)
    return max(time, min(least, count / 2.0))


def _mixed_time(raw: FloatArray, lost: float) -> float:
    """Return the autocorrelation time of a first-order process, averaged or with white noise.

    Its correlations are ``r_1 rho^(lag - 1)``, their sum ``1 + 2 r_1/(1 - rho)``; ``lost``: part of
    each that the fit removed, which is added back [-].
    """
    first, second = ((float(value) + lost) / (1.0 + lost) for value in raw[:2])
    if first <= 0.0:
        return 1.0
    rho = min(max(second / first, 0.0), _LONGEST_MEMORY)
    return 1.0 + 2.0 * first / (1.0 - rho)


def _autocorrelation(residual: FloatArray, run: IntArray) -> FloatArray:
    """Return the autocorrelation at lags of 1, 2, ... bins, up to a third of all."""
    count = len(residual)
    variance = float(np.mean(residual**2))
    if variance == 0.0 or count < 6:
        return np.zeros(0)
    correlations = []
    for lag in range(1, count // 3):
        same = run[lag:] == run[:-lag]
        if np.count_nonzero(same) < 5:
            break
        correlations.append(float(np.mean((residual[lag:] * residual[:-lag])[same])) / variance)
        # Beyond five below zero there is only noise.
        if len(correlations) > 10 and max(correlations[-5:]) < 0.0:
            break
    return np.array(correlations)


# ---- What users apply

# Half-widths of intervals beyond which a value counts as unknown [min, deg].
_UNKNOWN_MIN, _UNKNOWN_DEG = 120.0, 45.0
_LEVEL_DEG = 3.0  # bank below which circles do not turn the modules through the light
# Factors on power that are due to a unit, not to a sensor or module.
_UNITS = ((1e-3, "kW"), (1e3, "mW"))
_EFFICIENCY, _DRAG = "modules.efficiency_stc", "airframe.aerodynamics"
# Faster climbs need extra power: 11 W for 0.1 m/s at 7 kg; assumption.
_FASTEST_CLIMB_M_PER_S = 0.05
_BIN_S, _SHORTEST_NIGHT_S, _LEAST_BINS = 300.0, 3600.0, 6
LABELS = {
    "clock_offset": ("clock ahead of universal time", "min", "+.1f"),
    "heading_offset": ("heading logged too large", "deg", "+.1f"),
    "solar_factor": ("measured over modelled power", "", ".3f"),
    "level_power": ("power of level flight", "W", ".1f"),
}


class Estimate(NamedTuple):
    """Estimated number with the ends of its interval; None and ``why`` if unknown.

    ``apply``: options that apply it, empty without.
    """

    name: str
    value: float | None
    low: float | None
    high: float | None
    unit: str
    apply: tuple[str, ...]
    why: str

    def texts(self) -> tuple[str, str, str]:
        """Return words, value and interval."""
        label, unit, form = LABELS[self.name]
        if self.value is None:
            return label, "-", "-"
        interval = f"{self.low:{form}} to {self.high:{form}}"
        return label, f"{self.value:{form}} {unit}".strip(), interval


class Applied(NamedTuple):
    """Offsets that were subtracted from the log: minutes, degrees."""

    clock_min: float = 0.0
    heading_deg: float = 0.0


def estimates(
    forward: Forward, daylight: IntArray, fit: Fit | None, applied: Applied
) -> tuple[Estimate, ...]:
    """Estimate clock, heading, factor on solar power, and power of level flight."""
    log = forward.log
    if fit is None:
        why = "too few samples with power count"
        if log.solar_power_w.sum() < 0.0:
            why = "the power is negative: give its column a factor of -1 (--columns)"
        of_fit = [_estimate(name, why=why) for name in list(LABELS)[:3]]
        return (*of_fit, _estimate_level_power(forward, daylight))
    value, wide = (number / 60.0 for number in fit.of("clock_s"))
    option: tuple[str, ...] = ("--clock-offset", f"{applied.clock_min + value:.1f}")
    clock = _estimate("clock_offset", value, value - wide, value + wide, apply=option)
    if wide > _UNKNOWN_MIN:
        hours = (log.time_s[-1] - log.time_s[0]) / 3600.0
        why = f"known to ± {wide:.0f} min only: the power of these {hours:.1f} h does not tell it"
        clock = _estimate("clock_offset", why=why)
    other = next((name for number, name in _UNITS if 0.1 < fit.factor[0] / number < 10.0), None)
    why = f"as if the power was logged in {other}: --column 'solar_power_w=NAME [{other}]'"
    option = ()
    if other is None:
        efficiency = parameter_value(forward.aircraft, None, _EFFICIENCY)
        assert efficiency is not None  # every aircraft has one
        option, why = ("--set", f"{_EFFICIENCY}={spell(fit.factor[0] * efficiency, 4)}"), ""
    factor = _estimate("solar_factor", *fit.factor, apply=option, why=why)
    heading = _estimate_heading(forward, fit, applied)
    return clock, heading, factor, _estimate_level_power(forward, daylight)


def _estimate(name: str, *interval: float, apply: tuple[str, ...] = (), why: str = "") -> Estimate:
    """Make an estimate of a value and the ends of its interval, or of none."""
    value, low, high = interval or (None, None, None)
    return Estimate(name, value, low, high, LABELS[name][1], apply, why)


def _estimate_heading(forward: Forward, fit: Fit, applied: Applied) -> Estimate:
    attitude = forward.log.attitude
    if attitude is None or "heading" not in fit.names:
        lacking = "the log has no attitude" if attitude is None else "no modules.geometry"
        return _estimate("heading_offset", why=lacking)
    value, wide = (float(np.degrees(angle)) for angle in fit.of("heading"))
    if wide > _UNKNOWN_DEG:
        bank = float(np.degrees(np.sqrt(np.mean(attitude.roll_rad**2))))
        why = "the power hardly changes with the heading"
        if bank < _LEVEL_DEG:
            why = f"the wings are level to {bank:.1f} deg, so the heading hardly changes the power"
        return _estimate("heading_offset", why=f"known to ± {wide:.0f} deg only: {why}")
    value = (value + 180.0) % 360.0 - 180.0
    total = (applied.heading_deg + value + 180.0) % 360.0 - 180.0
    option = ("--heading-offset", f"{total:.1f}")
    return _estimate("heading_offset", value, value - wide, value + wide, apply=option)


def _estimate_level_power(forward: Forward, daylight: IntArray) -> Estimate:
    """Estimate the power of level flight [W]: the load without avionics and payload.

    At night if there is one, without thermals and work of the day. Converted to the density of the
    mission's air, with whose square root the power falls.
    """
    log, mission, name = forward.log, forward.mission, "level_power"
    if log.load_w is not None:
        load = log.load_w
    elif log.battery_power_w is not None:
        load = log.solar_power_w - log.battery_power_w
    else:
        return _estimate(name, why="neither load_w nor battery_power_w is logged")
    slot = np.floor((log.time_s - log.time_s[0]) / _BIN_S).astype(int)
    use, night = np.isfinite(load), np.ones(len(log), bool)
    night[daylight] = False
    if np.count_nonzero(use & night) * log.step_s >= _SHORTEST_NIGHT_S:
        use &= night
    # Samples in slots over which the altitude changes no faster than in level flight.
    (mean_m, slots), (mean_s, _) = _means(log.altitude_m, slot), _means(log.time_s, slot)
    if len(slots) > 1:
        slow = np.abs(np.gradient(mean_m, mean_s)) <= _FASTEST_CLIMB_M_PER_S
        use &= slow[np.searchsorted(slots, slot)]
    height_m = np.clip(log.altitude_m[use], air.MINIMUM_ALTITUDE_M, air.MAXIMUM_ALTITUDE_M)
    kelvin = forward.of(np.flatnonzero(use)).ambient_c()[0] + air.ZERO_CELSIUS_K
    density = air.air_at(kelvin, air.standard_air(height_m).pressure_pa).density_kg_per_m3
    mean_density = float(mission.air_state().density_kg_per_m3)
    rising = np.sqrt(mean_density / density) * (1.0 + mission.turbulence.all_day)
    try:
        constant_w = float(design_of(forward.aircraft, mission).constant_power_w)
    except ImpossibleDesignError as error:
        return _estimate(name, why=str(error))
    means, bins = _means((load[use] - constant_w) / rising, slot[use])
    if len(means) < _LEAST_BINS:
        least_min = _LEAST_BINS * _BIN_S / 60
        return _estimate(name, why=f"less than {least_min:.0f} min of level flight with a load")
    mean = float(means.mean())
    run = np.cumsum(np.diff(bins, prepend=bins[0]) > 1).astype(int)
    count = len(means) / correlation_time(means - mean, run, 1)
    freedom = max(count - 1.0, 1.0)
    wide = float(student.ppf(0.5 + 0.5 * CONFIDENCE, freedom) * means.std() / np.sqrt(freedom))
    key = level_power_key(forward.aircraft, mission, mean)
    interval = (mean, mean - wide, mean + wide)
    if isinstance(key, str):
        return _estimate(name, *interval, why=key)
    return _estimate(name, *interval, apply=("--set", f"{key[0]}={spell(key[1], 4)}"))


def _means(values: FloatArray, slot: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the mean of the values in each slot that has some, and these slots."""
    slots, number = np.unique(slot, return_inverse=True)
    return np.bincount(number, values) / np.bincount(number), slots


def level_power_key(
    aircraft: Aircraft, mission: Mission, power_w: float
) -> tuple[str, float] | str:
    """Return a key and its value for a power of level flight, or why there is none."""
    airframe = aircraft.airframe
    if isinstance(airframe, MeasuredAirframe):
        key = "airframe.level_flight.electric_power_w"
    elif airframe.aerodynamics.model == "parabolic":
        key = f"{_DRAG}.profile_drag_coefficient"
    else:
        key = f"{_DRAG}.calibration"
    value = parameter_value(aircraft, None, key)
    if value is None:
        return f"{aircraft.name} has no {key}"

    def apart(factor: float) -> float:
        changed = all_replaced(aircraft, {key: factor * value})
        return float(design_of(changed, mission).propulsion_power_w) - power_w

    try:
        return key, value * float(brentq(apart, 0.1, 10.0, xtol=1e-6))
    except ValueError:  # no sign changes between them
        return f"no {key} from a tenth to ten times that of the file gives it"
