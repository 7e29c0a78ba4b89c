"""Published flights of solar aircraft: what is known of each, and what the simulator makes of it.

A flight has facts with their sources, quantities that were published, and inputs whose published or
assumed range says how well they are known (:mod:`benchmarks.validation.flight_inputs`). All that is
data is in ``flights.yaml`` beside this module.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
import yaml

from missions.library import load_mission
from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.day.light import UNCORRECTED_CAM, SolarModel
from sizing.day.replay import CalendarRun, calendar_run
from sizing.library import load_aircraft
from sizing.mass_budget import design_of
from sizing.performance import performance, perpetual_days
from solar.names import ATTITUDE_MODELS
from studies.render.tables import Column, Table

_STEP_H = 1.0 / 30.0


@dataclass(frozen=True)
class Trial:
    """What is flown to compute a published number.

    ``aircraft``, ``mission``: what flies, and where. ``solar``: solar power model. ``full_charge``:
    state of charge that counts as full [-].
    """

    aircraft: Aircraft
    mission: Mission
    solar: SolarModel = UNCORRECTED_CAM
    full_charge: float = 1.0

    @property
    def load_w(self) -> float:
        """Load in level flight at night [W]."""
        return float(design_of(self.aircraft, self.mission).nominal_load_w(self.mission))

    def with_aircraft(self, **parts: Any) -> Trial:
        """Trial with keys of an aircraft's part changed, ``battery={"mass_kg": 2.0}``."""
        update = {
            name: getattr(self.aircraft, name).model_copy(update=keys)
            for name, keys in parts.items()
        }
        return replace(self, aircraft=self.aircraft.model_copy(update=update))

    def with_mission(self, **keys: Any) -> Trial:
        """Trial with keys of the mission changed; not validated, so that they may go too far."""
        return replace(self, mission=self.mission.model_copy(update=keys))

    def with_load(self, load_w: float) -> Trial:
        """Trial of an aircraft that needs more or less power for level flight [W]."""
        airframe = self.aircraft.airframe
        assert isinstance(airframe, MeasuredAirframe)
        constant_w = float(design_of(self.aircraft, self.mission).constant_power_w)
        level = airframe.level_flight
        power_w = level.electric_power_w * (load_w - constant_w) / (self.load_w - constant_w)
        changed = level.model_copy(update={"electric_power_w": power_w})
        return self.with_aircraft(airframe={"level_flight": changed})

    def replay(self, days: int | None = None) -> CalendarRun:
        """Flight by the clock, or its first local days; attitude models get wider steps."""
        mission, launch = self.mission, self.mission.launch
        if days is not None and launch is not None:
            duration_h = min(launch.duration_h, 24.0 * days - launch.clock_h)
            cut = launch.model_copy(update={"duration_h": duration_h})
            mission = mission.model_copy(update={"launch": cut})
        step_h = 8.0 * _STEP_H if self.solar.model in ATTITUDE_MODELS else _STEP_H
        return calendar_run(self.aircraft, mission, self.solar, step_h=step_h)


@dataclass(frozen=True)
class Quantity:
    """A published number of a flight.

    ``allowed`` is the largest accepted difference. A ``known_miss`` is larger than that today, and
    the documentation says so.
    """

    name: str
    unit: str
    published: float
    allowed: float
    compute: Callable[[Trial], float]
    known_miss: bool = False


@dataclass(frozen=True)
class Fact:
    """What is published about a flight, and where."""

    name: str
    text: str
    source: str


@dataclass(frozen=True)
class Flight:
    """A published flight.

    ``aircraft``, ``mission``: names of the shipped files that it is computed with.
    """

    name: str
    aircraft: str
    mission: str
    facts: tuple[Fact, ...]
    quantities: tuple[Quantity, ...]

    def trial(self) -> Trial:
        """Flight as the shipped files describe it."""
        return Trial(load_aircraft(self.aircraft), load_mission(self.mission))

    def quantity(self, name: str) -> Quantity:
        """Published number of that name."""
        return next(q for q in self.quantities if q.name == name)


def _cycle(trial: Trial) -> Any:
    return performance(trial.aircraft, trial.mission, trial.solar).cycle


def _charge_after_a_day(trial: Trial) -> float:
    run = trial.replay()
    return 100.0 * float(np.interp(run.clock_h[0] + 24.0, run.clock_h, run.state_of_charge))


def _full_charge_on_day(day: int) -> Callable[[Trial], float]:
    """Local clock at which the battery is full on a day of the flight; 24 where it is not [h]."""

    def clock_h(trial: Trial) -> float:
        run = trial.replay(day + 1)
        clock, charge = run.clock_h - 24.0 * day, run.state_of_charge
        if trial.full_charge >= 1.0:
            return next((h - 24.0 * day for h in run.full_charge_clock_h if h >= 24.0 * day), 24.0)
        # Full comes after the night's least charge.
        begin = int(np.argmin(np.where((clock >= 0.0) & (clock < 12.0), charge, 2.0)))
        reached = begin + int(np.argmax(charge[begin:] >= trial.full_charge))
        if charge[reached] < trial.full_charge:
            return 24.0
        before = slice(reached - 1, reached + 1)
        return float(np.interp(trial.full_charge, charge[before], clock[before]))

    return clock_h


def _flown_h(trial: Trial) -> float:
    run = trial.replay()
    end_h = run.clock_h[-1] if run.empty_clock_h is None else run.empty_clock_h
    return float(end_h - run.clock_h[0])


def _season_days(trial: Trial) -> float:
    latitude = trial.mission.latitudes()[0]
    return float(len(perpetual_days(trial.aircraft, trial.mission, latitude, trial.solar)))


COMPUTED: dict[str, Callable[[Trial], float]] = {
    "minimum_charge_of_day": lambda t: 100.0 * float(_cycle(t).minimum_state_of_charge[0]),
    "excess_time": lambda t: float(_cycle(t).excess_time_h[0]),
    "charge_margin": lambda t: float(_cycle(t).charge_margin_h[0]),
    "minimum_charge_of_flight": lambda t: 100.0 * t.replay().minimum_state_of_charge,
    "charge_after_a_day": _charge_after_a_day,
    "full_charge_on_the_first_day": _full_charge_on_day(0),
    "full_charge_on_the_second_day": _full_charge_on_day(1),
    "largest_solar_power": lambda t: float(t.replay().solar_power_w.max()),
    "flown": _flown_h,
    "season_days": _season_days,
}


@cache
def data() -> dict[str, Any]:
    """Facts, published numbers and ranges of inputs as their file gives them."""
    text = resources.files(__package__).joinpath("flights.yaml").read_text(encoding="utf-8")
    read: dict[str, Any] = yaml.safe_load(text)
    return read


def _hours_written(value: float | str) -> float:
    """Hours, written as such or as ``hours:minutes``."""
    if isinstance(value, str):
        hours, minutes = value.split(":")
        return float(hours) + float(minutes) / 60.0
    return value


def _published_quantity(name: str, row: dict[str, Any]) -> Quantity:
    return Quantity(
        name,
        row["unit"],
        _hours_written(row["published"]),
        _hours_written(row["allowed"]),
        COMPUTED[row["compute"]],
        row.get("known_miss", False),
    )


def _flight(row: dict[str, Any]) -> Flight:
    facts = tuple(Fact(name, **fact) for name, fact in row["facts"].items())
    quantities = tuple(_published_quantity(*item) for item in row["quantities"].items())
    return Flight(row["name"], row["aircraft"], row["mission"], facts, quantities)


FLIGHTS = {key: _flight(row) for key, row in data()["flights"].items()}


def facts_table() -> Table:
    """What is published about every flight, and where."""
    columns = tuple(map(Column, ("flight", "what", "published", "source")))
    rows = tuple((f.name, x.name, x.text, x.source) for f in FLIGHTS.values() for x in f.facts)
    return Table("published flights", columns, rows)
