"""Published flights of solar aircraft: what is known of each, and what the simulator makes of it.

A flight has facts with their sources, quantities that were published, and inputs whose published or
assumed range says how well they are known (:mod:`studies.validation.flights.inputs`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from missions.library import load_mission
from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.design import design_of
from sizing.library import load_aircraft
from sizing.performance import performance, perpetual_days
from sizing.replay import CalendarRun, calendar_run
from sizing.results.tables import Column, Table
from sizing.sunlight import UNCORRECTED_CAM, SolarModel
from solar.names import ATTITUDE_MODELS

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


def _minimum_charge_of_day(trial: Trial) -> float:
    return 100.0 * float(_cycle(trial).minimum_state_of_charge[0])


def _excess_time_h(trial: Trial) -> float:
    return float(_cycle(trial).excess_time_h[0])


def _charge_margin_h(trial: Trial) -> float:
    return float(_cycle(trial).charge_margin_h[0])


def _cycle(trial: Trial) -> Any:
    return performance(trial.aircraft, trial.mission, trial.solar).cycle


def _minimum_charge_of_flight(trial: Trial) -> float:
    return 100.0 * trial.replay().minimum_state_of_charge


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


def _largest_solar_power_w(trial: Trial) -> float:
    return float(trial.replay().solar_power_w.max())


def _flown_h(trial: Trial) -> float:
    run = trial.replay()
    end_h = run.clock_h[-1] if run.empty_clock_h is None else run.empty_clock_h
    return float(end_h - run.clock_h[0])


def _season_days(trial: Trial) -> float:
    latitude = trial.mission.latitudes()[0]
    return float(len(perpetual_days(trial.aircraft, trial.mission, latitude, trial.solar)))


BLOG_28H = "AtlantikSolar project (atlantiksolar.ethz.ch), 28 h flight"
NEWS_81H = "drohnen.de, July 2015, after the project's report"
PAPER_81H = "Oettershagen et al., Journal of Field Robotics 34 (2017), 1352"
PAPERS = "papers on AtlantikSolar, 2015 to 2017"
REPORT = "Oettershagen, High-Fidelity Solar Power Income Modeling (2017)"
ETH_LIFE = "ETH Life, 23 June 2008"
SKY_SAILOR_PAGE = "sky-sailor.ethz.ch"
SOLONG_PRESS = "AC Propulsion, press release of 3 June 2005"
SOLONG_EERE = "EERE Network News, 29 June 2005"
SOLONG_ENGINEER = "The Engineer, July 2005"
SOLONG_AVIATION_WEEK = "military.com, 29 June 2005, after Aviation Week"

_AS2_BATTERY = Fact("battery", "732 Wh; 705 Wh in another paper", PAPERS)

FLIGHT_81H = Flight(
    name="AtlantikSolar AS-2, 81 h flight, July 2015",
    aircraft="atlantiksolar-as2",
    mission="rafz-july",
    facts=(
        Fact("place", "Rafz, 47.6 N 8.53 E", PAPER_81H),
        Fact("time", "14 July 2015 9:32 to 17 July 18:56 (CEST)", NEWS_81H),
        Fact("distance", "2338 km over ground, 8.0 m/s on average", PAPER_81H),
        Fact("load", "35 to 46 W on average in calm air, such as at night", NEWS_81H),
        Fact("level flight", "35.8 W of propulsion, 6.0 W of avionics", PAPERS),
        _AS2_BATTERY,
        Fact("wind, temperature", "not found; 31.3 C used", ""),
    ),
    quantities=(
        Quantity("excess time", "h", 6.8, 0.6, _excess_time_h),
        Quantity("minimum state of charge", "%", 39.0, 3.0, _minimum_charge_of_day),
        Quantity("charge margin", "h", 6.2, 0.5, _charge_margin_h),
    ),
)

FLIGHT_81H_CLOCK = Flight(
    name="AtlantikSolar AS-2, 81 h flight by the clock",
    aircraft="atlantiksolar-as2",
    mission="rafz-81h",
    facts=(
        Fact("full charge", "about 13:05", NEWS_81H),
        Fact("largest solar power", "about 260 W", NEWS_81H),
    ),
    quantities=(
        Quantity(
            "full charge on the second day (CEST)",
            "h",
            13.0 + 5.0 / 60.0,
            40.0 / 60.0,
            _full_charge_on_day(1),
        ),
        Quantity("largest solar power", "W", 260.0, 13.0, _largest_solar_power_w),
    ),
)

FLIGHT_28H = Flight(
    name="AtlantikSolar AS-2, 28 h flight, 30 June 2015",
    aircraft="atlantiksolar-as2",
    mission="rafz-28h",
    facts=(
        Fact("place", "Rafz, 47.6 N 8.53 E", BLOG_28H),
        Fact("time", "30 June 2015 11:14 to 1 July 15:35 (CEST)", BLOG_28H),
        Fact("charge at launch", "57 %; 57.7 % in a paper", BLOG_28H),
        Fact("load", "43 W on average at night, at 8.4 m/s", BLOG_28H),
        Fact("wind", "up to 5 m/s at night; strong thermals by day", BLOG_28H),
        Fact("temperature", "air 27 C, modules 37 C at 9.5 h solar time", REPORT),
        _AS2_BATTERY,
    ),
    quantities=(
        Quantity("minimum state of charge", "%", 35.0, 6.0, _minimum_charge_of_flight),
        Quantity(
            "full charge on the first day (CEST)",
            "h",
            14.0 + 8.0 / 60.0,
            40.0 / 60.0,
            _full_charge_on_day(0),
        ),
        Quantity("state of charge after 24 h", "%", 84.0, 6.0, _charge_after_a_day, True),
    ),
)

FLIGHT_27H = Flight(
    name="Sky-Sailor, 27 h flight, 20 June 2008",
    aircraft="sky-sailor-2008",
    mission="niederwil-27h",
    facts=(
        Fact("place", "Niederwil near Cham, 200 to 400 m above ground", ETH_LIFE),
        Fact("time", "20 June 2008 12:33 (CEST), more than 27 h", ETH_LIFE),
        Fact("distance", "874.4 km, 9.0 m/s on average", SKY_SAILOR_PAGE),
        Fact("load", "16 W in level flight", SKY_SAILOR_PAGE),
        Fact("wind", "rather windy at night; no thermals or height used", ETH_LIFE),
        Fact("battery", "1 kg, 40 % of the mass; 1.06 kg of 240 Wh/kg", f"{ETH_LIFE}; Noth (2008)"),
        Fact("charge", "full in the afternoon, and at the landing", ETH_LIFE),
        Fact("temperature", "not found; 20 C assumed", ""),
    ),
    quantities=(
        Quantity("minimum state of charge", "%", 5.8, 6.0, _minimum_charge_of_flight, True),
    ),
)

FLIGHT_48H = Flight(
    name="SoLong, 48 h flight, 1 June 2005",
    aircraft="solong",
    mission="desert-center-48h",
    facts=(
        Fact("place", "Desert Center, California, 33.75 N 115.32 W", SOLONG_PRESS),
        Fact("time", "1 June 2005 16:08 to 3 June 16:24 (PDT)", SOLONG_PRESS),
        Fact("end", "its pilots were tired; the battery was not low", SOLONG_AVIATION_WEEK),
        Fact("load", "95 W in level flight", SOLONG_EERE),
        Fact("modules", "225 W from 76 cells", SOLONG_EERE),
        Fact("battery", "220 Wh/kg, 44 % of 28.2 lb; over 95 % a cycle", SOLONG_ENGINEER),
        Fact("thermals", "earlier flights of over 24 h used them (Noth)", "FAZ, June 2008"),
        Fact("wind, temperature", "not found; 30 C assumed", ""),
    ),
    quantities=(Quantity("time flown", "h", 48.27, 0.5, _flown_h, True),),
)

SEASON = Flight(
    name="AtlantikSolar AS-2, season at 47.6 N",
    aircraft="atlantiksolar-as2",
    mission="rafz-july",
    facts=(Fact("season", "a 6-month window around 21 June", PAPER_81H),),
    quantities=(Quantity("days of perpetual flight", "days", 182.5, 38.0, _season_days),),
)

FLIGHTS = (FLIGHT_81H, FLIGHT_81H_CLOCK, FLIGHT_28H, FLIGHT_27H, FLIGHT_48H)
WITH_SEASON = (*FLIGHTS, SEASON)


def facts_table() -> Table:
    """What is published about every flight, and where."""
    columns = tuple(map(Column, ("flight", "what", "published", "source")))
    rows = tuple((f.name, x.name, x.text, x.source) for f in WITH_SEASON for x in f.facts)
    return Table("published flights", columns, rows)


def facts_of(flight: Flight) -> Table:
    """What is published about one flight."""
    columns = tuple(map(Column, ("what", "published", "source")))
    rows = tuple((fact.name, fact.text, fact.source) for fact in flight.facts)
    return Table(f"{flight.name}: what is published", columns, rows)
