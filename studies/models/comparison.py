"""Solar power models side by side: what each predicts, and what each would have built.

Every model with every correction predicts the same aircraft on the same mission. A parametric
aircraft is also sized with each of them, and each of the designs is judged by the best knowledge
there is: the corrected Full Model on the mission's flight path.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.design import DesignVariables
from sizing.energy.cycle import Status
from sizing.optimisation.objectives import Objective
from sizing.optimisation.search import SizingResult, size_aircraft
from sizing.performance import Performance, performance, performance_of_designs
from sizing.sunlight import SolarDay, SolarModel, Sunlight
from studies.maps.season import Flags, Season, perpetual_flags, season_of
from studies.models.solar_models import (
    attitude_is_known,
    combinations,
    reference_model,
)

if TYPE_CHECKING:
    pass

Progress = Callable[[int, int], None]
Simulate = Callable[[SolarDay], Performance]


@dataclass(frozen=True)
class Prediction:
    """What a model says of an aircraft in its worst scenario on a mission.

    Times [h], energies of a day [Wh]. ``excess_time_h`` and ``endurance_h`` are infinite where
    there is no end; low and high are the excess time with the solar power one RMS error of the
    model lower and higher. ``nights`` counts the nights that the longest flight survives;
    ``enough_sun`` tells whether solar power rises above the load at any time of the day.
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

    @property
    def perpetual(self) -> bool:
        """Whether the aircraft flies for ever in every scenario."""
        return self.status in (Status.perpetual, Status.always_lit)


@dataclass(frozen=True)
class Built:
    """Design that a model led to, and what the reference says of it (none without a design)."""

    sizing: SizingResult
    judged: Prediction | None


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


@dataclass(frozen=True)
class Comparison:
    """All cases, and the reference that they are judged by."""

    aircraft: Aircraft
    mission: Mission
    objective: Objective
    required_excess_time_h: float
    reference: Case
    cases: tuple[Case, ...]
    notes: tuple[str, ...] = ()


def compare(
    aircraft: Aircraft,
    mission: Mission,
    models: Sequence[SolarModel] | None = None,
    *,
    objective: Objective = Objective.min_wingspan,
    required_excess_time_h: float | None = None,
    designs: bool = True,
    progress: Progress | None = None,
) -> Comparison:
    """Compare solar power models on an aircraft and a mission.

    Parameters
    ----------
    aircraft, mission
        What flies, and where; VM, FM and the loiter correction need module surfaces on the one
        and a flight path on the other.
    models : sequence of SolarModel, optional
        Models with their corrections; by default all that can be computed.
    objective, required_excess_time_h
        What a parametric aircraft is sized for; the mission's own required time by default [h].
    designs : bool
        Whether a parametric aircraft is sized with every model.
    progress : callable, optional
        Called with the steps done and the steps in all.

    Raises
    ------
    ValueError
        If a model lacks the surfaces or the path.
    ImpossibleDesignError
        If a parametric aircraft cannot carry its own mass.
    """
    attitude = attitude_is_known(aircraft, mission)
    wanted = combinations(attitude=attitude) if models is None else list(models)
    reference = reference_model(aircraft, mission)
    every = list(dict.fromkeys([*wanted, reference]))
    sized = designs and isinstance(aircraft.airframe, ParametricAirframe)
    required = mission.required_excess_time_h
    required = required if required_excess_time_h is None else required_excess_time_h
    latitudes = mission.latitudes()
    steps = _Steps(len(latitudes) + len(every) * (2 if sized else 1), progress)

    sun = Sunlight(aircraft, mission)
    flags = []
    for latitude in latitudes:
        flags.append(perpetual_flags(aircraft, mission, latitude, every))
        steps.advance()
    cases = {}
    for solar in every:
        found = predict(partial(_as_given, aircraft, mission, solar), sun.day(solar))
        steps.advance()
        built = None
        if sized:
            built = _build(aircraft, mission, objective, solar, required, sun, reference)
            steps.advance()
        days = [of_latitude[solar] for of_latitude in flags]
        cases[solar] = Case(solar, found, *_seasons(days, latitudes), built)
    return Comparison(
        aircraft=aircraft,
        mission=mission,
        objective=objective,
        required_excess_time_h=required,
        reference=cases[reference],
        cases=tuple(cases[solar] for solar in wanted),
        notes=_notes(aircraft, mission, reference, sized=sized),
    )


class _Steps:
    """Counts the steps of a comparison for whoever watches."""

    def __init__(self, total: int, progress: Progress | None) -> None:
        self.done, self.total, self.progress = 0, total, progress

    def advance(self) -> None:
        self.done += 1
        if self.progress is not None:
            self.progress(self.done, self.total)


def _as_given(
    aircraft: Aircraft, mission: Mission, solar: SolarModel, day: SolarDay
) -> Performance:
    return performance(aircraft, mission, solar, day=day)


def _of_design(
    aircraft: Aircraft,
    mission: Mission,
    variables: DesignVariables,
    solar: SolarModel,
    day: SolarDay,
) -> Performance:
    return performance_of_designs(aircraft, mission, variables, solar, day=day)


def _build(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel,
    required_h: float,
    sun: Sunlight,
    reference: SolarModel,
) -> Built:
    """Size with a model, and judge the design by the reference."""
    result = size_aircraft(
        aircraft,
        mission,
        objective,
        solar,
        required_excess_time_h=required_h,
        day=sun.day(solar),
    )
    if result.design is None:
        return Built(result, None)
    simulate = partial(_of_design, aircraft, mission, result.design.variables, reference)
    return Built(result, predict(simulate, sun.day(reference)))


def _seasons(days: list[Flags], latitudes: list[float]) -> tuple[Season, tuple[Season, ...]]:
    each = tuple(season_of(d, lat) for d, lat in zip(days, latitudes, strict=True))
    together = np.logical_and.reduce(days)
    return season_of(together, float(np.mean(latitudes))), each


def _notes(
    aircraft: Aircraft, mission: Mission, reference: SolarModel, *, sized: bool
) -> tuple[str, ...]:
    notes = []
    lacking = [
        text
        for text, given in (
            (f"modules.geometry of {aircraft.name}", aircraft.modules.geometry),
            (f"flight_path of {mission.name}", mission.flight_path),
        )
        if given is None
    ]
    if lacking:
        notes.append(
            f"VM, FM and the loiter correction need {' and '.join(lacking)}; without, corrected "
            f"{reference.model} is the reference"
        )
    elif sized:
        notes.append(
            "the reference flies the path of the mission at its airspeed, whatever the design's own"
        )
    return tuple(notes)


def predict(simulate: Simulate, day: SolarDay) -> Prediction:
    """Judge an aircraft by its worst scenario.

    Parameters
    ----------
    simulate : callable
        Performance of the aircraft under the sun of some scenarios.
    day : SolarDay
        Sun in all scenarios of the mission.
    """
    perf = simulate(day)
    worst = perf.worst_scenario()
    alone, cycle, rms = day.at([worst]), perf.cycle, perf.solar.rms_relative
    band = simulate(SolarDay.joined([alone.scaled(1.0 - rms), alone.scaled(1.0 + rms)]))
    low, high = band.cycle.excess_time_h
    flight = None if cycle.perpetual[worst] else simulate(alone).endurances()[0]
    morning_h = float(cycle.equal_power_morning_h[worst])
    endurance_h = np.inf if flight is None else float(flight.endurance_h)
    launch_h = 0.0 if flight is None else float(flight.launch_h)
    income_wh = np.asarray(cycle.energy_budget.solar_wh)
    return Prediction(
        scenario=day.scenarios.label(worst),
        latitude_deg=float(day.scenarios.latitude_deg[worst]),
        day_of_year=int(day.scenarios.day_of_year[worst]),
        several_scenarios=len(day.scenarios) > 1,
        status=Status(int(cycle.status[worst])),
        excess_time_h=float(cycle.excess_time_h[worst]),
        excess_time_low_h=float(low),
        excess_time_high_h=float(high),
        minimum_state_of_charge=float(cycle.minimum_state_of_charge[worst]),
        charge_margin_h=float(cycle.charge_margin_h[worst]),
        endurance_h=endurance_h,
        nights=nights_survived(launch_h, endurance_h, morning_h),
        polar_day=float(alone.sunset_h[0] - alone.sunrise_h[0]) >= 24.0,
        enough_sun=bool(np.isfinite(morning_h)),
        solar_energy_wh=float(income_wh[worst]),
        mean_solar_energy_wh=float(income_wh.mean()),
    )


def nights_survived(launch_h: float, endurance_h: float, morning_h: float) -> int:
    """Nights within a flight, each flown from midnight or before to the morning's equal power.

    Parameters
    ----------
    launch_h, morning_h : float
        Solar times [h]; the flight starts on the day from 0 to 24 h. Without a morning of equal
        power (NaN) no night ends.
    endurance_h : float
        Length of the flight [h]; of an endless one no nights are counted.
    """
    if not np.all(np.isfinite([endurance_h, morning_h])):
        return 0
    return max(0, int((launch_h + endurance_h - morning_h) // 24.0))
