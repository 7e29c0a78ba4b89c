"""Another flight, predicted from fitted parameters: charge from launch to landing.

Of the other log only time, place, attitude, air and the first state of charge are taken. Solar
power and load are modelled, the battery is marched by :mod:`sizing.energy.march`.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from missions.files.errors import file_error
from missions.library import load_mission
from missions.logs.csv import read_flight_log
from missions.logs.table import FlightLog
from missions.mission import Mission
from missions.weather.record import runs_of
from sizing.aircraft import Aircraft
from sizing.energy.battery import Store
from sizing.energy.march import empty_after_h, march
from sizing.energy.power_balance import PowerBalance
from sizing.mass_budget import design_of
from sizing.results.tables import Column, Table
from solar.sun import sun_position
from solar.types import BoolArray, FloatArray
from studies.fitting.channels.bins import BIN_S
from studies.fitting.channels.channel import Flown, Predict
from studies.fitting.channels.flight_errors import FlightError, flight_errors
from studies.fitting.channels.solar import forward_model, solar_model
from studies.fitting.flight import FlightFit
from studies.fitting.parameters import replaced_values
from studies.flight_logs.verification import DEFAULT_MISSION, verify

_STEP_S = 60.0
_FULL = 0.999
_NIGHT_H = 0.5  # longer than twilight before a launch at dawn
_EMPTY = 0.02  # state of charge at the end of a log that counts as a flight to the last


@dataclass(frozen=True)
class Course:
    """Charge of a flight, and when it was empty.

    ``hours``, ``charge``: after the start of the log [h], and state of charge [-].
    ``minimum_charge``: least charge from the start of the first night on [-]. ``empty_h``: hours
    from the start to the empty battery; None where the sun is up before. ``falls_h``, ``lit_h``:
    hours from the last full battery, or the start, to the least charge, and those of them with the
    sun up: what gusts and haze add up over.
    """

    hours: FloatArray
    charge: FloatArray
    minimum_charge: float
    empty_h: float | None
    falls_h: float = 0.0
    lit_h: float = 0.0


@dataclass(frozen=True)
class Prediction:
    """A flight as it was, and as predicted by the values of the file and of the fit."""

    source: str
    measured: Course
    before: Course
    after: Course
    minimum_charge_error: float
    empty_error_h: float | None

    def table(self) -> Table:
        """Least charge and time flown: measured, predicted before and after the fit."""
        columns = (
            Column("quantity"),
            Column("measured", form=".2f"),
            Column("before", form=".2f"),
            Column("after", "fitted", form=".2f"),
            Column("standard_error", "standard error", form=".2f"),
        )
        courses = (self.measured, self.before, self.after)
        least = (*(one.minimum_charge for one in courses), self.minimum_charge_error)
        rows: list[tuple[Any, ...]] = [("minimum charge [%]", *(100.0 * v for v in least))]
        if self.measured.empty_h is not None:
            empty = (one.empty_h for one in courses)
            rows.append(("time to empty [h]", *empty, self.empty_error_h))
        return Table(f"another flight predicted: {self.source}", columns, tuple(rows))

    def to_dict(self) -> dict[str, Any]:
        """Numbers, JSON-ready."""
        courses = {"measured": self.measured, "before": self.before, "after": self.after}
        return {
            "source": self.source,
            "minimum_charge": {name: one.minimum_charge for name, one in courses.items()}
            | {"standard_error": self.minimum_charge_error},
            "empty_h": {name: one.empty_h for name, one in courses.items()}
            | {"standard_error": self.empty_error_h},
        }


def predict_flight(
    fit: FlightFit,
    log: FlightLog | str | os.PathLike[str],
    mission: Mission | None = None,
    *,
    correct: bool | None = True,
) -> Prediction:
    """Predict another flight of an aircraft from what was fitted to one.

    Parameters
    ----------
    fit : FlightFit
        Fitted to a flight.
    log : FlightLog or path
        Another flight, with its state of charge.
    mission : Mission, optional
        As for :func:`studies.fitting.flight.fit_flight`, as is what follows.
    correct : bool or None
        Whether errors of the log's clock, heading and unit are corrected.

    Returns
    -------
    Prediction

    Raises
    ------
    InputError
        If the log cannot be read or has no state of charge.
    """
    log = log if isinstance(log, FlightLog) else read_flight_log(os.fspath(log))
    mission = load_mission(DEFAULT_MISSION) if mission is None else mission
    if log.state_of_charge is None:
        raise file_error(log.source, "has no state_of_charge: there is no charge to predict")
    flown = Flown.of(verify(fit.aircraft, log, mission, correct=correct), mission)
    forecast = _Forecast.of(flown, fit)
    aircraft = fit.fitted_aircraft()
    model = forecast.factor(fit, np.array([one.value for one in fit.model_errors]))
    after = forecast.course(aircraft, model)
    moved = [*_by_fit(fit, forecast), *forecast.by_errors(aircraft, model)]
    charges = [[one.minimum_charge for one in both] for both in moved]
    minimum = _spread(charges, after.minimum_charge)
    design, gusts_wh = design_of(aircraft, flown.mission), _noise_wh(fit, after)
    full_wh = float(design.battery_energy_wh) * float(aircraft.battery.mean_discharge_efficiency)
    load_w = float(design.nominal_load_w(flown.mission))
    empty, hours = None, [[one.empty_h for one in both] for both in moved]
    if after.empty_h is not None and all(None not in both for both in hours):
        empty = float(np.hypot(_spread(hours, after.empty_h), gusts_wh / load_w))
    return Prediction(
        source=log.source,
        measured=_measured(flown.log, forecast.night_h),
        before=forecast.course(fit.aircraft),
        after=after,
        minimum_charge_error=float(
            np.sqrt(minimum**2 + (gusts_wh / full_wh) ** 2 + _gauge(fit) ** 2)
        ),
        empty_error_h=empty,
    )


def _spread(pairs: list[list[Any]], middle: float) -> float:
    """Standard deviation of what independent standard deviations to either side lead to."""
    return float(np.sqrt(np.sum((np.array(pairs, float) - middle) ** 2) / 2.0))


def _by_fit(fit: FlightFit, forecast: _Forecast) -> Iterator[tuple[Course, Course]]:
    """Courses a standard deviation to either side of the fit, in independent directions."""
    parameters = tuple(one.parameter for one in fit.fitted)
    ends = [(one.lowest, one.highest) for one in parameters]
    ends += [(-np.inf, np.inf)] * len(fit.model_errors)
    middle = np.array([*(one.value for one in fit.fitted), *(e.value for e in fit.model_errors)])

    def course(moved: FloatArray) -> Course:
        within = np.clip(moved, *np.array(ends).T)
        values, errors = np.split(within, [len(parameters)])
        aircraft = replaced_values(fit.aircraft, parameters, tuple(values.tolist()))
        return forecast.course(aircraft, forecast.factor(fit, errors))

    variances, directions = np.linalg.eigh(fit.covariance_with_model())
    for step in (directions * np.sqrt(np.maximum(variances, 0.0))).T:
        yield course(middle + step), course(middle - step)


def _noise_wh(fit: FlightFit, course: Course) -> float:
    """Energy that haze and gusts like those of the fitted flight add up to [Wh]."""
    hours = {"solar": course.lit_h, "load": course.falls_h}
    parts = [p.noise(hours[p.channel.name]) for p in fit.estimates if p.channel.name in hours]
    return float(np.sqrt(sum(part**2 for part in parts)))


def _gauge(fit: FlightFit) -> float:
    """Error of the gauge that the fitted flight shows, with which the other is read too [-]."""
    left = [p.solution.residual for p in fit.estimates if p.channel.name == "charge"]
    return float(np.std(left[0])) if left else 0.0


def _measured(log: FlightLog, night_h: float | None) -> Course:
    """Charge as the log has it, in means over some minutes."""
    assert log.state_of_charge is not None  # checked by predict_flight
    known = ~np.isnan(log.state_of_charge)
    hours = (log.time_s[known] - log.time_s[0]) / 3600.0
    charge = log.state_of_charge[known]
    empty = float(hours[-1]) if charge[-1] <= _EMPTY else None
    slot = np.floor(hours * 3600.0 / BIN_S).astype(int)
    _, number, counts = np.unique(slot, return_inverse=True, return_counts=True)
    hours, charge = (np.bincount(number, values) / counts for values in (hours, charge))
    return Course(hours, charge, _least(hours, charge, night_h), empty)


def _least(hours: FloatArray, charge: FloatArray, night_h: float | None) -> float:
    """Least charge from the start of the first night on; of a flight by day, after its peak."""
    later = hours >= night_h if night_h is not None else np.arange(len(charge)) >= charge.argmax()
    return float(charge[later].min(initial=charge[-1]))


@dataclass(frozen=True)
class _Forecast:
    """A log thinned out to a minute, as a flight is predicted from it."""

    flown: Flown
    hours: FloatArray
    start_charge: float
    sunlit: FloatArray
    power: Predict
    ends_dark: bool
    dark: BoolArray
    errors: tuple[FlightError, ...]

    @classmethod
    def of(cls, flown: Flown, fit: FlightFit) -> _Forecast:
        log, lit = flown.log, flown.found.samples.index
        stride = max(1, round(_STEP_S / log.step_s))
        index = lit[::stride]
        assert log.state_of_charge is not None  # checked by predict_flight
        known = log.state_of_charge[~np.isnan(log.state_of_charge)]
        count = max(2, int(np.ceil((log.time_s[-1] - log.time_s[0]) / _STEP_S)) + 1)
        time_s = np.linspace(log.time_s[0], log.time_s[-1], count)
        degrees = (log.latitude_deg, log.longitude_deg)
        place = (np.interp(time_s, log.time_s, one) for one in degrees)
        return cls(
            flown=flown,
            hours=(time_s - log.time_s[0]) / 3600.0,
            start_charge=float(np.median(known[:10])),
            sunlit=(log.time_s[index] - log.time_s[0]) / 3600.0,
            power=solar_model(flown, index),
            ends_dark=bool(lit[-1] < len(log) - 1),
            dark=np.asarray(sun_position(time_s, *place).elevation_rad <= 0.0),
            errors=flight_errors(forward_model(flown, index), fit.light_sigma),
        )

    @property
    def night_h(self) -> float | None:
        """Hours from the start to the first night longer than twilight; None without one."""
        first, after = runs_of(self.dark)
        nights = self.hours[first][self.hours[after - 1] - self.hours[first] > _NIGHT_H]
        return float(nights[0]) if len(nights) else None

    def factor(self, fit: FlightFit, errors: FloatArray) -> FloatArray:
        """Solar power with errors of the aircraft's model over that without."""
        names = [one.known.name for one in fit.model_errors]
        known = dict(zip(names, errors.tolist(), strict=True))
        parts = [known.get(one.name, 0.0) * one.slope for one in self.errors]
        return np.asarray(np.exp(np.sum(parts, axis=0)))

    def by_errors(self, aircraft: Aircraft, model: FloatArray) -> Iterator[tuple[Course, Course]]:
        """Courses with each error of this flight a standard deviation to either side."""
        for one in self.errors:
            if one.flight is not None:
                ends = (model * np.exp(sign * one.sigma * one.slope) for sign in (1.0, -1.0))
                above, below = (self.course(aircraft, end) for end in ends)
                yield above, below

    def course(self, aircraft: Aircraft, factor: FloatArray | float = 1.0) -> Course:
        """Flight of an aircraft with so many times the solar power at each sample."""
        mission = self.flown.mission
        design = design_of(aircraft, mission)
        load_w = float(design.nominal_load_w(mission))
        shone = self.power(aircraft) * factor
        solar_w = np.interp(self.hours, self.sunlit, shone, left=0.0, right=0.0)
        # The sun shines in a gap of the log as well.
        solar_w[self.dark] = 0.0
        store = Store.of(aircraft.battery, design.battery_energy_wh)
        energy = np.asarray(self.start_charge * float(store.battery_energy_wh))
        balance = PowerBalance.of(self.hours, solar_w, np.full(len(self.hours), load_w))
        stored, empty = [float(energy)], None
        for step in march(balance, store, energy):
            stored.append(float(step.end_wh))
            if step.unserved_wh > 1e-9 * store.battery_energy_wh:
                after_h = empty_after_h(step.interval, step.unserved_wh)
                empty = float(step.interval.start_h + after_h)
                break
        if empty is None and self.ends_dark:
            left_wh = stored[-1] * float(store.discharge_efficiency)
            empty = float(self.hours[-1]) + left_wh / load_w
        charge = np.array(stored) / float(store.battery_energy_wh)
        hours = self.hours[: len(charge)]
        lowest = _least(hours, charge, self.night_h)
        last = int(np.flatnonzero(charge == lowest)[-1])
        full = np.flatnonzero(charge[:last] >= _FULL)
        falls = slice(int(full[-1]) if len(full) else 0, last + 1)
        step_h = float(self.hours[1] - self.hours[0])
        lit_h = float(np.count_nonzero(solar_w[falls])) * step_h
        return Course(hours, charge, lowest, empty, (falls.stop - falls.start) * step_h, lit_h)
