"""What a solar power model says of an aircraft, in numbers and words, and what it would build."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from missions.dates import date_code
from sizing.day.launch import Endurance
from sizing.day.light import SolarDay, SolarModel
from sizing.day.metrics import FLOWN, Cycle, Status
from sizing.design import Design
from sizing.performance import Performance
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult, SizingStatus, objective_value
from studies.maps.season import Season

# Excess time that is missing by less than is printed is not missing [h].
_MET_H = 0.005
# Nights from which on a flight ends by what is lost from day to day.
_MANY_NIGHTS = 10


@dataclass(frozen=True)
class Prediction:
    """What a model says of an aircraft in its worst scenario on a mission.

    ``scenario``, ``latitude_deg``, ``day_of_year``: the worst scenario: its label, latitude [deg]
    and day. ``several_scenarios``: whether the mission has others. ``status``: how the cycle of the
    worst scenario ends. ``excess_time_h``, ``excess_time_low_h``, ``excess_time_high_h``: excess
    time [h], infinite where it is unlimited, and the same with the solar power one RMS error of the
    model lower and higher. ``minimum_state_of_charge``: of the cycle [-]. ``charge_margin_h``,
    ``endurance_h``: charge margin, and endurance from the best launch [h]; infinite where
    unlimited. ``nights``: nights that the longest flight survives. ``polar_day``, ``enough_sun``:
    whether the sun does not set, and whether solar power rises above the load at any time.
    ``solar_energy_wh``, ``mean_solar_energy_wh``: solar energy of a day: of the worst scenario, and
    the mean of all [Wh]. ``maximum_altitude_m``: highest altitude in the worst scenario of a flight
    with climbs, whose longest flight is that in level flight [m].
    """

    scenario: str
    latitude_deg: float
    day_of_year: int
    several_scenarios: bool
    status: Status
    excess_time_h: float
    excess_time_low_h: float
    excess_time_high_h: float
    minimum_state_of_charge: float
    charge_margin_h: float
    endurance_h: float
    nights: int
    polar_day: bool
    enough_sun: bool
    solar_energy_wh: float
    mean_solar_energy_wh: float
    maximum_altitude_m: float | None = None

    @property
    def perpetual(self) -> bool:
        """Whether the flight is perpetual, or lands, in every scenario."""
        return self.status in FLOWN

    @property
    def endurance_cell(self) -> float | str:
        """Endurance as tables write it."""
        return np.inf if self.perpetual else duration(self.endurance_h, " d")

    def outcome(self, required_excess_time_h: float = 0.0) -> str:
        """What becomes of the aircraft in its worst scenario, as a clause without its subject."""
        at, excess_h = self.scenario, self.excess_time_h
        if self.status is Status.always_lit:
            return "flies perpetually, as solar power always exceeds the load"
        if self.status is Status.lands:
            return f"lands with {excess_h:.1f} h to spare at {at}"
        if self.status is not Status.perpetual:
            return f"flies {duration(self.endurance_h)} at {at}: {self._reason()}"
        if excess_h < required_excess_time_h - _MET_H:
            return (
                f"flies perpetually, but with {excess_h:.2f} h of excess time at {at} instead of "
                f"the required {required_excess_time_h:g} h"
            )
        where = " in every scenario" if self.several_scenarios else ""
        return f"flies perpetually{where}, with {excess_h:.1f} h of excess time at {at}"

    def _reason(self) -> str:
        """Why the flight ends."""
        if self.status is Status.never_lit:
            return "there is no solar power"
        if not self.enough_sun:
            return "solar power never reaches the load"
        if self.polar_day:
            return "the sun does not set, but the battery does not last through its low hours"
        if self.nights >= _MANY_NIGHTS or not np.isfinite(self.endurance_h):
            return "the days return slightly less than the nights take"
        if self.nights == 0:
            return "its battery does not last the night"
        nights = "1 night" if self.nights == 1 else f"{self.nights} nights"
        return f"its battery lasts {nights}"


@dataclass(frozen=True)
class Built:
    """Design that a model led to, and what the reference says of it (none without a design)."""

    sizing: SizingResult
    judged: Prediction | None

    def value(self, objective: Objective) -> float | None:
        """Quantity of the objective, none without a design; infinite excess time is possible."""
        design, simulated = self.sizing.design, self.sizing.simulated
        if design is None or simulated is None:
            return None
        return float(objective_value(objective, simulated))

    def result(self, objective: Objective) -> str:
        """What the sizing arrived at, in words."""
        value = self.value(objective)
        if self.judged is None or value is None:
            return "no design" if self.sizing.status is SizingStatus.infeasible else "no result"
        if not np.isfinite(value):
            return "an unlimited excess time"
        noun, form = _RESULTS[objective]
        return f"{noun} of {value:{form}} {objective.unit}"

    @property
    def design(self) -> Design | None:
        """Design of the sizing."""
        return self.sizing.design

    @property
    def promised_excess_time_h(self) -> float | None:
        """Excess time by the model that it was sized with [h]."""
        return self.value(Objective.max_excess_time)

    @property
    def violated_requirements(self) -> tuple[str, ...]:
        """What no design meets, in words."""
        return tuple(one.text for one in self.sizing.violations)


_RESULTS = {
    Objective.min_wingspan: ("a span", ".2f"),
    Objective.min_mass: ("a mass", ".2f"),
    Objective.max_payload_mass: ("a payload", ".2f"),
    Objective.max_payload_power: ("a payload", ".1f"),
    Objective.max_excess_time: ("an excess time", ".1f"),
}


@dataclass(frozen=True)
class Case:
    """One model with one correction.

    ``season`` holds the days on which all latitudes of the mission are flown perpetually,
    ``seasons`` those of each latitude.
    """

    solar: SolarModel
    prediction: Prediction
    season: Season
    seasons: tuple[Season, ...]
    built: Built | None


def season_record(season: Season) -> dict[str, Any]:
    """Days of perpetual flight in the year, JSON-ready."""
    return {
        "days": season.days,
        "window_days": season.window_days,
        "first": None if season.first is None else date_code(season.first),
        "last": None if season.last is None else date_code(season.last),
    }


def predict(
    simulate: Callable[[SolarDay], Performance], days: Mapping[SolarModel, SolarDay]
) -> list[Prediction]:
    """Judge an aircraft by its worst scenario under the sun of each model.

    ``simulate``: performance of the aircraft under the sun of some scenarios; all models are
    simulated together. ``days``: sun of the same scenarios by each model.
    """
    count, suns = len(days), list(days.values())
    flown = simulate(SolarDay.joined(suns))
    cycle, highest_m = flown.cycle, flown.maximum_altitude_m
    worst = np.argmin(cycle.excess_time_h.reshape(count, -1), axis=-1)
    places = worst + np.arange(count) * (len(cycle.excess_time_h) // count)
    alone = [sun.at([place]) for sun, place in zip(suns, worst, strict=True)]
    margins = simulate(
        SolarDay.joined(
            [
                one.scaled(1.0 + sign * solar.rms_relative)
                for sign in (-1.0, 1.0)
                for solar, one in zip(days, alone, strict=True)
            ]
        )
    )
    low, high = margins.cycle.excess_time_h.reshape(2, count)
    flights: list[Endurance | None] = [None] * count
    limited = np.flatnonzero(~cycle.perpetual[places]).tolist()
    if limited:
        longest = simulate(SolarDay.joined([alone[number] for number in limited])).endurances()
        for number, flight in zip(limited, longest, strict=True):
            flights[number] = flight
    solar_wh = np.asarray(cycle.energy_budget.solar_wh)
    return [
        _prediction(
            suns[number],
            cycle,
            (int(worst[number]), int(places[number])),
            excess_h=(float(low[number]), float(high[number])),
            flight=flights[number],
            mean_solar_wh=float(mean_wh),
            highest_m=None if highest_m is None else float(highest_m[places[number]]),
        )
        for number, mean_wh in enumerate(solar_wh.reshape(count, -1).mean(axis=-1))
    ]


def _prediction(
    day: SolarDay,
    cycle: Cycle,
    at: tuple[int, int],
    *,
    excess_h: tuple[float, float],
    flight: Endurance | None,
    mean_solar_wh: float,
    highest_m: float | None,
) -> Prediction:
    """Prediction of one model.

    ``at``: the worst scenario among those of ``day``, and in ``cycle``. ``excess_h``: its excess
    time with one RMS error less and more sun. ``flight``: the longest, where it is limited.
    """
    worst, place = at
    morning_h = float(cycle.equal_power_morning_h[place])
    endurance_h = np.inf if flight is None else float(flight.endurance_h)
    launch_h = 0.0 if flight is None else float(flight.launch_h)
    return Prediction(
        scenario=day.scenarios.label(worst),
        latitude_deg=float(day.scenarios.latitude_deg[worst]),
        day_of_year=int(day.scenarios.day_of_year[worst]),
        several_scenarios=len(day.scenarios) > 1,
        status=Status(int(cycle.status[place])),
        excess_time_h=float(cycle.excess_time_h[place]),
        excess_time_low_h=excess_h[0],
        excess_time_high_h=excess_h[1],
        minimum_state_of_charge=float(cycle.minimum_state_of_charge[place]),
        charge_margin_h=float(cycle.charge_margin_h[place]),
        endurance_h=endurance_h,
        nights=nights_survived(launch_h, endurance_h, morning_h),
        polar_day=float(day.sunset_h[worst] - day.sunrise_h[worst]) >= 24.0,
        enough_sun=bool(np.isfinite(morning_h)),
        solar_energy_wh=float(cycle.energy_budget.solar_wh[place]),
        mean_solar_energy_wh=mean_solar_wh,
        maximum_altitude_m=highest_m,
    )


def nights_survived(launch_h: float, endurance_h: float, morning_h: float) -> int:
    """Nights within a flight, each flown from midnight or before to the morning's equal power.

    ``launch_h``, ``morning_h``: solar times [h]; the flight starts on the day from 0 to 24 h.
    Without a morning of equal power (NaN) no night ends. ``endurance_h``: length of the flight [h];
    of an unlimited one no nights are counted.
    """
    if not np.all(np.isfinite([endurance_h, morning_h])):
        return 0
    return max(0, int((launch_h + endurance_h - morning_h) // 24.0))


def duration(hours: float, day: str = " days") -> str:
    """Length of a flight: hours up to three days, then days with two significant digits."""
    if not np.isfinite(hours):
        return "more than a year"
    return f"{hours:.1f} h" if hours < 72.0 else f"{float(f'{hours / 24.0:.1e}'):g}{day}"
