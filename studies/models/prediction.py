"""Prediction of a solar power model for an aircraft, in numbers and words, and its design."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from missions.dates import date_code
from sizing.day.light import SolarDay, SolarModel
from sizing.day.metrics import SUFFICIENT, Status
from sizing.performance import Performance
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult, SizingStatus, objective_value
from solar.schema import spell
from studies.maps.season import Season

# Excess time below the required one by less than printed counts as met [h].
_MET_H = 0.005
# Nights from which a flight counts as ended by the losses from day to day.
_MANY_NIGHTS = 10


@dataclass(frozen=True)
class Prediction:
    """Prediction of a model for an aircraft in its worst scenario on a mission.

    ``scenario``, ``latitude_deg``, ``day_of_year``: label, latitude [deg] and day of the worst
    scenario. ``several_scenarios``: the mission has others. ``status``: of the worst scenario's
    cycle. ``excess_time_h``, ``excess_time_low_h``, ``excess_time_high_h``: excess time [h],
    infinite if unlimited, also with solar power one RMS error of the model lower and higher.
    ``minimum_state_of_charge``: of the cycle [-]. ``charge_margin_h``, ``endurance_h``: charge
    margin, and endurance from the best launch [h]; infinite if unlimited. ``nights``: nights within
    the longest flight. ``polar_day``: the sun does not set. ``power_exceeds_load``: at some time.
    ``solar_energy_wh``, ``mean_solar_energy_wh``: daily solar energy in the worst scenario, and the
    mean of all [Wh]. ``maximum_altitude_m``: highest altitude of flights with climbs, in the worst
    scenario [m]; their endurance is in level flight.
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
    power_exceeds_load: bool
    solar_energy_wh: float
    mean_solar_energy_wh: float
    maximum_altitude_m: float | None = None

    @property
    def perpetual(self) -> bool:
        """True for flight that is perpetual, or lands, in every scenario."""
        return self.status in SUFFICIENT

    @property
    def endurance_cell(self) -> float | str:
        """Endurance for tables."""
        return np.inf if self.perpetual else duration(self.endurance_h, " d")

    def outcome(self, required_excess_time_h: float = 0.0) -> str:
        """Return the outcome in the worst scenario, as a clause without its subject."""
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
                f"the required {spell(required_excess_time_h)} h"
            )
        where = " in every scenario" if self.several_scenarios else ""
        return f"flies perpetually{where}, with {excess_h:.1f} h of excess time at {at}"

    def _reason(self) -> str:
        """Return the reason why the flight ends."""
        if self.status is Status.never_lit:
            return "there is no solar power"
        if not self.power_exceeds_load:
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
    """Design sized with a model, and its prediction by the reference (None without a design)."""

    sizing: SizingResult
    judged: Prediction | None

    def value(self, objective: Objective) -> float | None:
        """Return the objective's quantity, None without a design; excess time may be infinite."""
        design, simulated = self.sizing.design, self.sizing.simulated
        if design is None or simulated is None:
            return None
        return float(objective_value(objective, simulated))

    def result(self, objective: Objective) -> str:
        """Return the result of the sizing in words."""
        value = self.value(objective)
        if self.judged is None or value is None:
            return "no design" if self.sizing.status is SizingStatus.infeasible else "no result"
        if not np.isfinite(value):
            return "an unlimited excess time"
        noun, form = _RESULTS[objective]
        return f"{noun} of {value:{form}} {objective.unit}"

    @property
    def promised_excess_time_h(self) -> float | None:
        """Excess time by the model of the sizing [h]."""
        return self.value(Objective.max_excess_time)

    @property
    def violated_requirements(self) -> tuple[str, ...]:
        """Requirements that no design meets, in words."""
        return tuple(violation.text for violation in self.sizing.violations)


_RESULTS = {
    Objective.min_wingspan: ("a span", ".2f"),
    Objective.min_mass: ("a mass", ".2f"),
    Objective.max_payload_mass: ("a payload", ".2f"),
    Objective.max_payload_power: ("a payload", ".1f"),
    Objective.max_excess_time: ("an excess time", ".1f"),
}


@dataclass(frozen=True)
class Case:
    """Results of a model with a correction.

    ``solar_energy_above_reference``: mean solar energy over the reference's, minus 1 [-].
    ``season``: days of perpetual flight at all latitudes of the mission, ``seasons``: at each.
    """

    solar: SolarModel
    prediction: Prediction
    solar_energy_above_reference: float | None
    season: Season
    seasons: Mapping[float, Season]
    built: Built | None

    @property
    def season_record(self) -> dict[str, Any]:
        """Days of perpetual flight in the year, at all latitudes and at each, JSON-ready."""
        each = [{"latitude_deg": lat} | _season(season) for lat, season in self.seasons.items()]
        return _season(self.season) | {"latitudes": each}


def _season(season: Season) -> dict[str, Any]:
    ends = {"first": season.first, "last": season.last}
    dates = {end: None if day is None else date_code(day) for end, day in ends.items()}
    return vars(season) | dates


def predict(simulate: Callable[..., Performance], solar: SolarModel, day: SolarDay) -> Prediction:
    """Predict an aircraft's worst scenario under the sun of a model.

    ``simulate``: function of ``day`` that returns the performance. ``day``: sun of scenarios by the
    model.
    """
    result = simulate(day=day)
    cycle, worst = result.cycle, int(np.argmin(result.cycle.excess_time_h))
    alone = day.at([worst])
    errors = [alone.scaled(1.0 + sign * solar.rms_relative) for sign in (-1.0, 1.0)]
    low_h, high_h = simulate(day=SolarDay.joined(errors)).cycle.excess_time_h.tolist()
    launch_h, endurance_h = 0.0, np.inf
    if not cycle.perpetual[worst]:
        longest = simulate(day=alone).endurances
        launch_h, endurance_h = float(longest.launch_h[0]), float(longest.endurance_h[0])
    morning_h = float(cycle.equal_power_morning_h[worst])
    solar_wh, highest_m = np.asarray(cycle.energy_budget.solar_wh), result.maximum_altitude_m
    return Prediction(
        scenario=day.scenarios.label(worst),
        latitude_deg=float(day.scenarios.latitude_deg[worst]),
        day_of_year=int(day.scenarios.day_of_year[worst]),
        several_scenarios=len(day.scenarios) > 1,
        status=Status(int(cycle.status[worst])),
        excess_time_h=float(cycle.excess_time_h[worst]),
        excess_time_low_h=low_h,
        excess_time_high_h=high_h,
        minimum_state_of_charge=float(cycle.minimum_state_of_charge[worst]),
        charge_margin_h=float(cycle.charge_margin_h[worst]),
        endurance_h=endurance_h,
        nights=nights_survived(launch_h, endurance_h, morning_h),
        polar_day=float(day.sunset_h[worst] - day.sunrise_h[worst]) >= 24.0,
        power_exceeds_load=bool(np.isfinite(morning_h)),
        solar_energy_wh=float(solar_wh[worst]),
        mean_solar_energy_wh=float(solar_wh.mean()),
        maximum_altitude_m=None if highest_m is None else float(highest_m[worst]),
    )


def nights_survived(launch_h: float, endurance_h: float, morning_h: float) -> int:
    """Count the nights of a flight: from midnight or before to the morning's equal power.

    ``launch_h``, ``morning_h``: solar times [h]; launch from 0 to 24 h. Zero without a morning of
    equal power (NaN), and for unlimited ``endurance_h`` [h].
    """
    if not np.all(np.isfinite([endurance_h, morning_h])):
        return 0
    return max(0, int((launch_h + endurance_h - morning_h) // 24.0))


def duration(hours: float, day: str = " days") -> str:
    """Return a flight's length: hours up to three days, then days with two significant digits."""
    if not np.isfinite(hours):
        return "more than a year"
    return f"{hours:.1f} h" if hours < 72.0 else f"{float(f'{hours / 24.0:.1e}'):g}{day}"
