"""Another flight, predicted from fitted parameters: charge from launch to landing.

Of the other log only time, place, attitude, air and the first state of charge are taken. Solar
power and load are modelled, the battery is marched by :mod:`sizing.energy.march`.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np

from missions.files.errors import file_error
from missions.library import load_mission
from missions.logs.csv import read_flight_log
from missions.logs.table import FlightLog
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import design_of
from sizing.energy.battery import Store
from sizing.energy.march import empty_after_h, march
from sizing.energy.power_balance import PowerBalance
from sizing.results.tables import Column, Table
from solar.types import FloatArray
from studies.fitting.channels.bins import BIN_S
from studies.fitting.channels.channel import Flown
from studies.fitting.channels.solar import solar_model
from studies.fitting.flight import FlightFit
from studies.flight_logs.verification import DEFAULT_MISSION, verify

_STEP_S = 60.0
_FULL = 0.999
_NIGHT_H = 0.5  # between sunlit samples: longer is a night, shorter a gap of the log
_EMPTY = 0.02  # state of charge at the end of a log that counts as a flight to the last


@dataclass(frozen=True)
class Course:
    """Charge of a flight, and when it was empty.

    ``hours``, ``charge``: after the start of the log [h], and state of charge [-].
    ``minimum_charge``: least charge after the peak of the first 24 hours [-]. ``empty_h``: hours
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
    """A flight as it was and as it is predicted, by the file's values and by the fitted ones.

    The standard errors are those of the fit, and of the other day's light.
    """

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
        rows: list[tuple[Any, ...]] = [
            (
                "minimum charge [%]",
                *(100.0 * one.minimum_charge for one in (self.measured, self.before, self.after)),
                100.0 * self.minimum_charge_error,
            )
        ]
        if self.measured.empty_h is not None:
            empty = (one.empty_h for one in (self.measured, self.before, self.after))
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
    forecast = _Forecast.of(flown)
    aircraft = fit.fitted_aircraft()
    after = forecast.course(aircraft)
    slopes = [forecast.course(aircraft, 1.0 + fit.light_sigma)]
    spread = np.sqrt(np.diag(fit.covariance()))
    for one, error in zip(fit.fitted, spread.tolist(), strict=True):
        moved = one.parameter.applied(aircraft, min(one.value + error, one.parameter.highest))
        slopes.append(forecast.course(moved))
    shares = np.eye(len(slopes))
    if len(spread):
        shares[1:, 1:] = fit.covariance() / np.outer(spread, spread)
    minimum = np.array([one.minimum_charge - after.minimum_charge for one in slopes])
    gusts_wh, full_wh, load_w = _noise_wh(fit, after), *forecast.size(aircraft)
    empty = None
    if after.empty_h is not None and all(one.empty_h is not None for one in slopes):
        apart = np.array([(one.empty_h or 0.0) - after.empty_h for one in slopes])
        empty = float(np.hypot(np.sqrt(apart @ shares @ apart), gusts_wh / load_w))
    return Prediction(
        source=log.source,
        measured=_measured(flown.log),
        before=forecast.course(fit.aircraft),
        after=after,
        minimum_charge_error=float(
            np.sqrt(minimum @ shares @ minimum + (gusts_wh / full_wh) ** 2 + _gauge(fit) ** 2)
        ),
        empty_error_h=empty,
    )


def _noise_wh(fit: FlightFit, course: Course) -> float:
    """Energy that haze and gusts like those of the fitted flight add up to [Wh]."""
    hours = {"solar": course.lit_h, "load": course.falls_h}
    parts = [p.noise(hours[p.channel.name]) for p in fit.estimates if p.channel.name in hours]
    return float(np.sqrt(sum(part**2 for part in parts)))


def _gauge(fit: FlightFit) -> float:
    """Error of the gauge that the fitted flight shows, with which the other is read too [-]."""
    spread = [float(np.std(p.after)) for p in fit.estimates if p.channel.name == "charge"]
    return spread[0] if spread else 0.0


def _measured(log: FlightLog) -> Course:
    """Charge as the log has it, in means over some minutes."""
    assert log.state_of_charge is not None  # checked by predict_flight
    known = ~np.isnan(log.state_of_charge)
    hours = (log.time_s[known] - log.time_s[0]) / 3600.0
    charge = log.state_of_charge[known]
    empty = float(hours[-1]) if charge[-1] <= _EMPTY else None
    slot = np.floor(hours * 3600.0 / BIN_S).astype(int)
    counts = np.maximum(np.bincount(slot), 1)
    hours, charge = (
        np.bincount(slot, v)[np.unique(slot)] / counts[np.unique(slot)] for v in (hours, charge)
    )
    return Course(hours, charge, _night_minimum(hours, charge), empty)


def _night_minimum(hours: FloatArray, charge: FloatArray) -> float:
    """Least charge after the peak of the first 24 hours."""
    first_day = charge[hours <= 24.0]
    return float(charge[int(np.argmax(first_day)) :].min())


@dataclass(frozen=True)
class _Forecast:
    """A log thinned out to a minute, as a flight is predicted from it."""

    flown: Flown
    hours: FloatArray
    start_charge: float
    sunlit: FloatArray
    power: Any
    ends_dark: bool

    @classmethod
    def of(cls, flown: Flown) -> _Forecast:
        log = flown.log
        stride = max(1, round(_STEP_S / log.step_s))
        index = flown.found.samples.index[::stride]
        assert log.state_of_charge is not None  # checked by predict_flight
        known = log.state_of_charge[~np.isnan(log.state_of_charge)]
        count = max(2, int(np.ceil((log.time_s[-1] - log.time_s[0]) / _STEP_S)) + 1)
        return cls(
            flown=flown,
            hours=np.linspace(0.0, (log.time_s[-1] - log.time_s[0]) / 3600.0, count),
            start_charge=float(np.median(known[:10])),
            sunlit=(log.time_s[index] - log.time_s[0]) / 3600.0,
            power=solar_model(flown, index),
            ends_dark=bool(flown.found.samples.index[-1] < len(log) - 1),
        )

    def size(self, aircraft: Aircraft) -> tuple[float, float]:
        """Energy that the battery delivers [Wh], and load of an aircraft [W]."""
        mission, battery = self.flown.mission, aircraft.battery
        design = design_of(aircraft, mission)
        delivered = float(design.battery_energy_wh) * float(battery.mean_discharge_efficiency)
        return delivered, float(design.nominal_load_w(mission))

    def course(self, aircraft: Aircraft, light: float = 1.0) -> Course:
        """Flight of an aircraft under so many times the light."""
        mission = self.flown.mission
        design = design_of(aircraft, mission)
        load_w = float(design.nominal_load_w(mission))
        shone = self.power(aircraft, light)
        solar_w = np.interp(self.hours, self.sunlit, shone, left=0.0, right=0.0)
        # From the last light of an evening to the first of a morning nothing shines.
        behind = np.clip(np.searchsorted(self.sunlit, self.hours) - 1, 0, len(self.sunlit) - 1)
        ahead = np.clip(behind + 1, 0, len(self.sunlit) - 1)
        solar_w[(self.sunlit[ahead] - self.sunlit[behind]) > _NIGHT_H] = 0.0
        store = Store.of(aircraft.battery, design.battery_energy_wh)
        energy = np.asarray(self.start_charge * float(store.battery_energy_wh))
        balance = PowerBalance.of(self.hours, solar_w, np.full(len(self.hours), load_w))
        stored, empty = [float(energy)], None
        for step in march(balance, store, energy):
            stored.append(float(step.end_wh))
            if step.unserved_wh > 1e-9 * store.battery_energy_wh:
                empty = float(
                    step.interval.start_h + empty_after_h(step.interval, step.unserved_wh)
                )
                break
        if empty is None and self.ends_dark:
            left_wh = stored[-1] * float(store.discharge_efficiency)
            empty = float(self.hours[-1]) + left_wh / load_w
        charge = np.array(stored) / float(store.battery_energy_wh)
        hours = self.hours[: len(charge)]
        lowest = _night_minimum(hours, charge)
        last = int(np.flatnonzero(charge == lowest)[-1])
        full = np.flatnonzero(charge[:last] >= _FULL)
        falls = slice(int(full[-1]) if len(full) else 0, last + 1)
        step_h = float(self.hours[1] - self.hours[0])
        lit_h = float(np.count_nonzero(solar_w[falls])) * step_h
        return Course(hours, charge, lowest, empty, (falls.stop - falls.start) * step_h, lit_h)
