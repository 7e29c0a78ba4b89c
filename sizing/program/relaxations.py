"""What would make an infeasible mission feasible: the value of one parameter at a time.

Each relaxation is the same program with one more free variable, which it moves no further than it
must. Sizings confirm the value, which is rounded away from the edge: there is a design with it,
and none with 1 % less of it.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import numpy as np

from missions.mission import Mission, Scenarios
from missions.mission.scenarios import LatitudeRange
from sizing.aircraft import Aircraft
from sizing.day.light import UNCORRECTED_CAM, SolarModel, solar_day
from sizing.design import DesignVariables
from sizing.parameters import catalogue, parameter, parameter_value, with_parameter
from sizing.performance import performance_of_designs
from sizing.program.objectives import Objective, SizingStatus
from sizing.program.reasons import PERCENT, least_mission
from sizing.program.result import SizingResult
from sizing.program.search import Search
from sizing.program.size import best_search, size_aircraft
from sizing.program.task import SizingTask
from sizing.program.variables import TOTAL_MASS, WIND, Role, chosen_variables
from sizing.relaxed_flight import Direction, Relaxation, rounded
from sizing.roots import bisect

# A structure lighter than this fraction of today's is no relaxation; others may fall to the last.
_LEAST_RELATIVE = {
    f"airframe.structure.{key}": 0.5 for key in ("build", "calibration", "coefficient_kg")
}
_LEAST_OTHER = 1e-3
_WIDER = 4.0  # bounds of the design space are moved by no more than this factor
_BISECTED = PERCENT / 10.0  # of the value, which is confirmed to one per cent
_OF_MISSION = dict.fromkeys(("payload_mass_kg", "payload_power_w"))  # payload of a mission
_STEP_DEG, _REACH_DEG = 0.25, 60.0


def relaxations(
    aircraft: Aircraft, mission: Mission, result: SizingResult, solar: SolarModel = UNCORRECTED_CAM
) -> list[Relaxation]:
    """Find what would make an infeasible mission feasible, one parameter at a time.

    Returns smallest relative change first; empty where no single parameter suffices.
    """
    if result.status is not SizingStatus.infeasible or result.nearest is None:
        raise ValueError(
            f"the sizing is {result.status.name}: only an infeasible one has relaxations"
        )
    # What is to be carried as much as possible need not be carried at all.
    search = _Relaxations(
        aircraft, least_mission(aircraft, mission, result.objective), result, solar
    )
    candidates = [search.relaxed(freed) for freed in search.freed()]
    candidates += [search.latitude(), search.required_excess()]
    return sorted((it for it in candidates if it), key=lambda it: it.relative_change)


class _Freed(NamedTuple):
    """A variable of the program that may move between its ends, ``scale`` of it a parameter."""

    name: str
    key: str
    present: float
    ends: tuple[float, float]
    scale: float = 1.0

    @property
    def upwards(self) -> bool:
        return self.scale * self.ends[1] > self.present


class _Relaxations:
    def __init__(
        self, aircraft: Aircraft, mission: Mission, result: SizingResult, solar: SolarModel
    ) -> None:
        assert result.nearest is not None
        self.aircraft, self.mission, self.solar = aircraft, mission, solar
        self.nearest, self.required_h = result.nearest, result.required_excess_time_h
        self.objective = result.objective
        self.others_missed = {v.requirement for v in result.violations} - {"excess_time"}
        # A requirement that is met at the expense of another one stands in the way as well.
        held = {label.partition(" (")[0] for label in result.active_constraints}
        self.in_the_way = self.others_missed | held
        self.start = result.nearest.design.variables.mapped(float)._replace(**_OF_MISSION)

    # --- one parameter in the program ----------------------------------------------------------

    def freed(self) -> Iterator[_Freed]:
        """Technology and payload; bounds that are reached; limits and wind in the way."""
        limits = self.aircraft.design_space.limit_rows()
        for v in chosen_variables(self.aircraft, eased=True):
            key = v.name
            if v.role is Role.limit:
                key = f"design_space.{limits[v.name].key}"
            elif v.role is Role.payload:
                key = parameter(v.name).key
            elif v.role is Role.design:
                bound = "maximum_total_mass_kg" if v.name == TOTAL_MASS else f"{v.name}.maximum"
                key = f"design_space.{bound}"
            present, furthest = parameter_value(self.aircraft, self.mission, key) or 0.0, 1.0
            if v.role is Role.design and key in catalogue() and present:
                always = v.name == Objective.min_wingspan.variable
                if always or f"{v.name} at its maximum" in self.in_the_way:
                    yield _Freed(v.name, key, present, (present, _WIDER * present))
            elif v.role is Role.payload and self.objective.variable != v.name and present:
                yield _Freed(v.name, key, present, (0.0, present))
            elif v.role is Role.limit and v.name in self.in_the_way:
                furthest = v.minimum if limits[v.name].end == "minimum" else v.maximum
            elif v.role is Role.technology and parameter(key).relaxable == "up":
                furthest = max(parameter(key).maximum / present, 1.0)
            elif v.role is Role.technology:
                furthest = _LEAST_RELATIVE.get(key, _LEAST_OTHER)
            if furthest != 1.0:
                ends = min(furthest, 1.0), max(furthest, 1.0)
                yield _Freed(v.name, key, present, ends, scale=present)
        wind = float(self.mission.strongest_wind_m_per_s)
        if "airspeed_above_wind" in self.in_the_way and wind != 0.0:
            yield _Freed(WIND, WIND, wind, (0.0, wind))

    def relaxed(self, freed: _Freed) -> Relaxation | None:
        """Relaxation that moves a variable no further than it must, as sizings confirm it."""
        mission = self.mission.in_wind(freed.present) if freed.name == WIND else self.mission
        task = SizingTask(
            self.aircraft,
            mission,
            Objective.min_mass,
            self.solar,
            self.nearest.day,
            self.required_h,
            bounds={freed.name: freed.ends},
            freed={freed.name: (freed.key, freed.scale)},
            own_cost={freed.name: 1.0 if freed.upwards else -1.0},
        )
        best = best_search(task, task.first_values(self.start)).best
        if best is None and not np.isfinite(self.nearest.design.total_mass_kg):
            # What carries its own mass at no present value may do so at the furthest one.
            first = task.first_values(self.start) | {freed.name: freed.ends[freed.upwards]}
            best = Search(task, first=first).run().best
        if best is None:
            return None
        start = task.design_variables(best.values)._replace(**_OF_MISSION)
        direction: Direction = "at least" if freed.upwards else "at most"
        present, value = freed.present, rounded(freed.scale * best.values[freed.name], direction)

        @cache
        def reached_h(value: float) -> float | None:
            return self._reached_h(*with_parameter(self.aircraft, mission, freed.key, value), start)

        if reached_h(value) is None:
            return None
        step = PERCENT * (value or present)
        less = value + (-step if freed.upwards else step)
        if (less > present) is freed.upwards and reached_h(less) is not None:
            less = bisect(
                present,
                less,
                suffices=lambda value: reached_h(value) is not None,
                tolerance=lambda end: _BISECTED * max(end, PERCENT * present),
            )
            if reached_h(rounded(less, direction)) is not None:
                value = rounded(less, direction)
        limit = self.aircraft.design_space.limit_rows().get(freed.name)
        unit = parameter(freed.key if limit is None else limit.quantity).unit
        return Relaxation(freed.key, unit, present, direction, value, reached_h(value) or 0.0)

    def _reached_h(
        self, aircraft: Aircraft, mission: Mission, start: DesignVariables | None = None
    ) -> float | None:
        """Worst excess time of a sizing of another aircraft or mission; None if not enough."""
        sizing = size_aircraft(
            aircraft,
            mission,
            Objective.max_excess_time,
            self.solar,
            required_excess_time_h=0.0,
            start=start,
            explain=False,
            stop_at_merit=max(self.required_h, 1e-9),
        )
        worst_h = sizing.objective_value
        return worst_h if worst_h is not None and worst_h >= self.required_h else None

    # --- latitude and required time ------------------------------------------------------------

    def required_excess(self) -> Relaxation | None:
        """Largest excess time there is, where more is required."""
        worst_h = float(np.min(self.nearest.cycle.excess_time_h))
        # Missing anything else means that even without a required time no design exists.
        if self.others_missed or not 0.0 < worst_h < self.required_h:
            return None
        value = rounded(worst_h, "at most")
        key = "mission.required_excess_time_h"
        return Relaxation(key, "h", self.required_h, "at most", value, worst_h)

    def latitude(self) -> Relaxation | None:
        """Latitude nearest to the mission's at which a design flies perpetually.

        Of a band the end that holds back is moved.
        """
        key, latitude = "mission.latitude_deg", self.mission.latitude_deg
        if isinstance(latitude, LatitudeRange):
            scenarios = self.nearest.day.scenarios
            worst = float(scenarios.latitude_deg[self.nearest.worst_scenario()])
            present, other, end = latitude.from_deg, latitude.to_deg, "from_deg"
            if abs(worst - other) < abs(worst - present):
                present, other, end = other, present, "to_deg"
            count = round(abs(other - present) / _STEP_DEG) + 1
            places = np.linspace(present, other, count)[1:-1].tolist()
            key = f"{key}.{end}"
        else:
            present, places = latitude, self._easier_latitudes()

        @cache
        def reached_h(place: float) -> float | None:
            to: float | LatitudeRange = place
            if isinstance(latitude, LatitudeRange):
                to = latitude.model_copy(update={end: place})
            moved = self.mission.model_copy(update={"latitude_deg": to})
            return self._reached_h(self.aircraft, moved)

        # From hard to easy: the easiest tells whether there is any.
        if not places or reached_h(places[-1]) is None:
            return None
        value = places[bisect_left(places, True, key=lambda place: reached_h(place) is not None)]
        direction: Direction = "at most" if value < present else "at least"
        return Relaxation(key, "deg", present, direction, value, reached_h(value) or 0.0)

    def _easier_latitudes(self) -> list[float]:
        """Latitudes from the mission's to where the nearest design does best, in steps."""
        reach = np.arange(_STEP_DEG, _REACH_DEG, _STEP_DEG)
        ends = self.mission.wind_latitudes_deg
        sides = [np.clip(self.mission.latitudes()[0] + s * reach, *ends) for s in (-1.0, 1.0)]
        tried = np.stack(sides)[:, 3::20]
        days = np.asarray(self.mission.dates.days(), int)
        scenarios = Scenarios(np.repeat(tried.ravel(), len(days)), np.tile(days, tried.size))
        aircraft, mission = self.aircraft, self.mission
        day = solar_day(aircraft, mission, self.solar, scenarios=scenarios, step_h=0.5)
        perf = performance_of_designs(aircraft, mission, self.start, self.solar, day=day)
        excess = perf.cycle.excess_time_h.reshape(*tried.shape, -1).min(axis=-1)
        side, peak = np.unravel_index(int(np.argmax(excess)), excess.shape)
        places: list[float] = sides[side][: 4 + 20 * int(peak)].tolist()
        return places
