"""Clock, heading and unit of power of a log, estimated before anything is blamed on the aircraft.

Measured power is fitted by ``level`` times the modelled power at another clock and another heading:
robust least squares (Tukey's biweight, so that clouds and limited charging do not count) from the
best of a coarse search over all time zones. ``docs/verify.md`` has the equations.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np

from missions.logs.table import EulerAngles, FlightLog
from missions.mission import Mission
from sizing.aircraft import Aircraft
from solar.geometry import ModuleGeometry
from solar.types import BoolArray, FloatArray, IntArray
from studies.flight_logs.alignment.robust_fit import Fit, biweight_cost, fitted
from studies.flight_logs.alignment.shifted_power import ShiftedPower

Unit = Literal["W", "kW", "mW"]

# What is told: errors above both these and so many standard deviations.
LEAST_TIME_S, LEAST_HEADING_DEG, SIGMAS = 120.0, 3.0, 3.0
# What is no number: standard deviations above these.
UNKNOWN_TIME_S, UNKNOWN_HEADING_DEG = 1800.0, 10.0
# Nor is anything known where the power scatters by more than this share of its peak: clouds.
MOST_SCATTER = 0.1
# Levels, measured over modelled, of a clear day and a model that is about right.
LEVELS = (0.5, 1.6)
# An offset must explain at least this share of the scatter that is left without it.
LEAST_GAIN = 0.1
# Assumption: bias of the attitude that small autopilots estimate [rad].
ATTITUDE_BIAS_RAD = np.radians(0.5)
# Drift of the model's level over a flight, standard deviation. In the report's three windows of one
# morning FM is off by +5, -1 and -3 %, and CAM, which does not know how wind tilts the wing, by 7 %
# on average, with the other sign in the afternoon.
FM_DRIFT, CAM_DRIFT = 0.02, 0.1

HALF_HOUR_S = 1800.0
_ZONES_H, _STEP_H = 14.0, 0.5
# Samples of the search, of the fits that choose, and of the last fit.
_COARSE, _MIDDLE, _FINE = 240, 600, 3000
_HEADINGS = 12
_CANDIDATES = 5
_ALIKE = 1.1  # scatter of fits that are equally good
_GOOD_FIT = 0.05  # scatter over peak power of a start that needs no search
_UNITS: dict[Unit, float] = {"W": 1.0, "kW": 1e3, "mW": 1e-3}


class Offset(NamedTuple):
    """An estimated error of the log and its standard deviation."""

    value: float
    sigma: float

    def exceeds(self, least: float) -> bool:
        """Whether the error is larger than allowed and than chance makes it."""
        return abs(self.value) > max(least, SIGMAS * self.sigma)


@dataclass(frozen=True)
class Alignment:
    """What the power says of clock, heading and unit of a log.

    ``power_unit``: unit that the power is in. ``level``: measured over modelled power at the best
    fit; None if nothing could be fitted. ``clock_ahead_s``: how far the clock is ahead of universal
    time [s]; None if the power does not tell. ``heading_ahead_deg``: how far the logged heading is
    clockwise of the true one [deg]; None if the power does not tell. ``clock_wrong``,
    ``heading_wrong``: whether that is an error of the log. ``notes``: why something is not known.
    """

    power_unit: Unit = "W"
    level: float | None = None
    clock_ahead_s: Offset | None = None
    heading_ahead_deg: Offset | None = None
    clock_wrong: bool = False
    heading_wrong: bool = False
    notes: tuple[str, ...] = ()

    @property
    def clock_correction_s(self) -> float:
        """What is taken off the times [s]: a whole number of half hours where that is as likely.

        Clocks are wrong by a time zone more often than by anything near one.
        """
        if self.clock_ahead_s is None or not self.clock_wrong:
            return 0.0
        value, sigma = self.clock_ahead_s
        zone = HALF_HOUR_S * round(value / HALF_HOUR_S)
        return zone if zone and abs(value - zone) <= max(LEAST_TIME_S, 2.0 * sigma) else value

    @property
    def wrong(self) -> bool:
        """Whether anything in the log is wrong."""
        return self.clock_wrong or self.heading_wrong or self.power_unit != "W"

    def corrected(self, log: FlightLog) -> FlightLog:
        """Log without the errors that were found."""
        changes: dict[str, Any] = {}
        if self.power_unit != "W":
            changes["solar_power_w"] = _UNITS[self.power_unit] * log.solar_power_w
        if ahead := self.clock_correction_s:
            changes["time_s"] = log.time_s - ahead
            changes["gaps"] = tuple(
                gap._replace(start_s=gap.start_s - ahead, end_s=gap.end_s - ahead)
                for gap in log.gaps
            )
        if self.heading_wrong and self.heading_ahead_deg is not None and log.attitude is not None:
            yaw = log.attitude.yaw_rad - np.radians(self.heading_ahead_deg.value)
            roll, pitch, _ = log.attitude
            changes["attitude"] = EulerAngles(roll, pitch, yaw)
        return replace(log, **changes)


def align(
    log: FlightLog, aircraft: Aircraft, mission: Mission, geometry: ModuleGeometry | None = None
) -> Alignment:
    """Estimate how far clock and heading of a log are off, and the unit of its power.

    ``geometry``: module surfaces, where the log has the attitude; without, the heading is not
    known.
    """
    measured = log.solar_power_w
    peak = _peak(measured)
    if len(log) < 20 or peak <= 0.0:
        return Alignment(notes=("clock and heading are not checked: too little power",))
    rng = np.random.default_rng(0)  # a stride could fall in step with the orbits
    bright = np.flatnonzero(measured > 0.01 * peak)

    def some(places: IntArray, most: int) -> _Part:
        index = _some(places, most, rng)
        model = ShiftedPower.of(log, aircraft, mission, geometry, index)
        return _Part(model, measured[index])

    every = np.arange(len(log))
    start = _start(some(bright, _MIDDLE), some(every, _COARSE))
    fine = some(bright, _FINE)
    best = None if start is None else fine.fits([(start.ahead_s, start.turned_rad)])
    if not best:
        return Alignment(notes=("clock and heading are not checked: no clock fits the power",))
    return _meaning_of_fit(fine.model, fine.measured, best[0])


class _Part(NamedTuple):
    """Some samples of a log: models of their power, and what was measured [W]."""

    model: ShiftedPower
    measured: FloatArray

    def fits(self, starts: list[tuple[float, float]]) -> list[Fit]:
        """Fits from some clocks [s] and headings [rad] to a level that may be."""
        offsets = []
        for start in starts:
            fit = None
            if self.model.knows_heading:
                fit = fitted(self.model, self.measured, *start, heading=True)
            if fit is None:  # a level wing has no derivative by the heading
                fit = fitted(self.model, self.measured, *start, heading=False)
            offsets.append(fit)
        plausible = (fit for fit in offsets if fit is not None)
        return [f for f in plausible if LEVELS[0] < f.level / _unit(f.level)[1] < LEVELS[1]]


def _some(places: IntArray, most: int, rng: np.random.Generator) -> IntArray:
    """At most so many places, spread evenly but not regularly."""
    if len(places) <= most:
        return places
    edges = np.linspace(0, len(places), most + 1)
    within = edges[:-1] + rng.random(most) * np.diff(edges)
    return np.asarray(places[np.unique(within.astype(int))], int)


def _start(part: _Part, coarse: _Part) -> Fit | None:
    """Fit from the log as it is if that is good, else from the best of all zones and headings."""
    own = part.fits([(0.0, turn) for turn in _headings(coarse, 0.0)])
    peak = _peak(part.measured)
    near = [f for f in own if f.scale_w < _GOOD_FIT * peak and abs(f.ahead_s) < 3600.0 * _STEP_H]
    if near:
        return min(near, key=lambda fit: fit.scale_w)
    every = own + part.fits(_coarse_starts(coarse))
    least = min((fit.scale_w for fit in every), default=0.0)
    # A day sooner or later the sun is nearly the same: the nearest of those that fit alike.
    alike = [fit for fit in every if fit.scale_w <= _ALIKE * least]
    best = min(alike, key=lambda fit: abs(fit.ahead_s), default=None)
    if best is None or not best.heading:
        return best
    turns = best.turned_rad + np.radians([-30.0, -15.0, 15.0, 30.0])
    return min([best, *part.fits([(best.ahead_s, t) for t in turns])], key=lambda f: f.scale_w)


def _unit(level: float) -> tuple[Unit, float]:
    """Unit of a power that is so many times the modelled one, and its inverse."""
    for unit, factor in _UNITS.items():
        if 0.1 < level * factor < 10.0:
            return unit, 1.0 / factor
    return "W", 1.0


def _headings(coarse: _Part, ahead_s: float) -> list[float]:
    """Headings of the least misfits on a coarse grid [rad]."""
    if not coarse.model.knows_heading:
        return [0.0]
    turns = 2.0 * np.pi * np.arange(2 * _HEADINGS) / (2 * _HEADINGS)
    costs = [_misfit(coarse.measured, one) for one in coarse.model.power_w(ahead_s, turns)]
    return [float(turns[i]) for i in np.argsort(costs)[:4]]


def _coarse_starts(coarse: _Part) -> list[tuple[float, float]]:
    """Clock [s] and heading [rad] of the least misfits on a grid over all time zones."""
    model, measured = coarse
    count = _HEADINGS if model.knows_heading else 1
    turns = 2.0 * np.pi * np.arange(count) / count
    shifts = 3600.0 * np.arange(-_ZONES_H, _ZONES_H + 0.5 * _STEP_H, _STEP_H)
    costs = np.array([[_misfit(measured, w) for w in model.power_w(s, turns)] for s in shifts])
    best = costs.min(axis=1)
    padded = np.concatenate(([np.inf], best, [np.inf]))
    lowest = np.flatnonzero((best <= padded[:-2]) & (best <= padded[2:]))
    lowest = lowest[np.argsort(best[lowest])][:_CANDIDATES]
    return [(float(shifts[i]), float(turns[j])) for i in lowest for j in np.argsort(costs[i])[:2]]


def _misfit(measured: FloatArray, modelled: FloatArray) -> float:
    """Mean of the differences, none counted for more than a tenth of the peak, at the best level.

    The level is within what a model may be off by, in one of the units.
    """
    peak = _peak(measured)
    bright = modelled > 0.25 * max(float(modelled.max()), 1e-9)
    if not bright.any():
        return float(np.minimum(np.abs(measured) / peak, 0.1).mean())
    ratio = np.sort(measured[bright] / modelled[bright])
    costs = []
    for share in (0.5, 0.75):  # the upper one where half of the power is limited
        level = float(ratio[int(share * (len(ratio) - 1))])
        unit = _unit(level)[1] if level > 0.0 else 1.0
        level = min(max(level, LEVELS[0] * unit), LEVELS[1] * unit)
        costs.append(float(np.minimum(np.abs(measured - level * modelled) / peak, 0.1).mean()))
    return min(costs)


def _peak(power: FloatArray) -> float:
    """Power that two in a hundred samples exceed: spikes do not count."""
    return float(np.sort(power)[int(0.98 * (len(power) - 1))])


def _meaning_of_fit(model: ShiftedPower, measured: FloatArray, best: Fit) -> Alignment:
    """What the best fit means: which numbers are known, which are errors of the log."""
    unit, scale = _unit(best.level)
    if best.scale_w > MOST_SCATTER * _peak(measured):
        text = "clock and heading are not checked: the power scatters too much (clouds?)"
        return Alignment(power_unit=unit, level=best.level / scale, notes=(text,))
    covariance = best.covariance + _systematic(model, best)
    notes: list[str] = []
    heading = _heading(best, covariance, model, measured, notes)
    if best.heading and heading is None:
        # What the power does not tell must not be fitted: it would widen the clock's error.
        again = fitted(model, measured, best.ahead_s, 0.0, heading=False)
        best = best if again is None else again
        covariance = best.covariance + _systematic(model, best)
    sigma_s = float(np.sqrt(covariance[1, 1]))
    clock: Offset | None = Offset(best.ahead_s, sigma_s)
    if not sigma_s < UNKNOWN_TIME_S:
        notes.append("clock not checked: the power does not tell the time of this flight")
        clock = None
    clock_wrong = clock is not None and clock.exceeds(LEAST_TIME_S)
    heading_wrong = heading is not None and heading.exceeds(LEAST_HEADING_DEG)
    if clock_wrong or heading_wrong:
        as_logged = _levelled(measured, model.power_w(0.0, 0.0))
        plain = biweight_cost(measured, as_logged, best.scale_w)
        if not best.cost < (1.0 - LEAST_GAIN) * plain:
            clock_wrong = heading_wrong = False
    return Alignment(
        power_unit=unit,
        level=best.level / scale,
        clock_ahead_s=clock,
        heading_ahead_deg=heading,
        clock_wrong=clock_wrong,
        heading_wrong=heading_wrong,
        notes=tuple(notes),
    )


def _heading(
    best: Fit, covariance: FloatArray, model: ShiftedPower, measured: FloatArray, notes: list[str]
) -> Offset | None:
    """Error of the heading [deg], none if the power does not tell it."""
    if not best.heading:
        level = "does not depend on it (level wing)"
        why = level if model.knows_heading else "is computed without attitude"
        notes.append(f"heading not checked: the power {why}")
        return None
    sigma = float(np.degrees(np.sqrt(covariance[2, 2])))
    value = (np.degrees(best.turned_rad) + 180.0) % 360.0 - 180.0
    if not sigma < UNKNOWN_HEADING_DEG or _twofold(best, model, measured):
        notes.append(
            "heading not checked: the power hardly depends on it (level wing or symmetric modules)"
        )
        return None
    return Offset(float(value), sigma)


def _twofold(best: Fit, model: ShiftedPower, measured: FloatArray) -> bool:
    """Whether a quite different heading fits as well."""
    turns = best.turned_rad + 2.0 * np.pi * np.arange(1, _HEADINGS) / _HEADINGS
    least = best.cost * (1.0 + 9.0 / max(best.independent, 10.0))
    costs = [
        biweight_cost(measured, best.level * model.power_w(best.ahead_s, turn), best.scale_w)
        for turn in turns
        if np.cos(turn - best.turned_rad) < np.cos(np.radians(3.0 * UNKNOWN_HEADING_DEG))
    ]
    return min(costs) < least


def _levelled(measured: FloatArray, modelled: FloatArray) -> FloatArray:
    """Model at the level of least squares, twice, with what is far off left out."""
    used: BoolArray = np.ones(len(measured), bool)
    level = 1.0
    for _ in range(10):
        level = float((measured * modelled)[used].sum() / max((modelled[used] ** 2).sum(), 1e-9))
        apart = np.abs(measured - level * modelled)
        used = apart <= 3.0 * np.median(apart) + 1e-9
    return level * modelled


def _systematic(model: ShiftedPower, best: Fit) -> FloatArray:
    """Covariance that small errors of model and attitude put on the result.

    Each makes a small change of the modelled power, and the fit answers to it as to any change.
    """
    power = best.modelled_w
    hours = (model.time_s - model.time_s.mean()) / max(float(model.time_s.std()), 1.0)
    drift = FM_DRIFT if model.knows_heading else CAM_DRIFT
    changes = [drift * power * hours]
    if model.knows_heading:
        shifted = (best.ahead_s, best.turned_rad)
        for roll, pitch in ((ATTITUDE_BIAS_RAD, 0.0), (0.0, ATTITUDE_BIAS_RAD)):
            tilted = best.level * model.tilted(roll, pitch).power_w(*shifted)
            changes.append(tilted - power)
    total = np.zeros((3, 3))
    for change in changes:
        answer = best.answer(change)
        total += np.outer(answer, answer)
    return total
