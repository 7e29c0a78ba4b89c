"""Night's floor and ceiling of a flight with climbs, chosen together with the aircraft.

Air, wind and light of an altitude come from tables and models with kinks, so that altitudes are no
symbols of the program: a search around whole sizings chooses them. From the best of a coarse grid
it steps along one altitude at a time, and halves its steps where none is better (compass search:
Kolda, T. G., Lewis, R. M. and Torczon, V. 2003, Optimization by Direct Search, SIAM Review 45 (3)).
Every value is an optimum that the simulator accepts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import DesignVariables
from sizing.mass_budget import ImpossibleDesignError
from sizing.optimisation.coverage import widest_range
from sizing.optimisation.propulsion import sized_in_own_flow, sized_smoothly
from sizing.optimisation.result import SizingResult
from sizing.program.objectives import Objective
from sizing.sunlight import SolarModel

_FLOORS, _CEILINGS = 5, 3  # of the grid
_FINEST_M, _ROUND_M = 20.0, 10.0  # last step; altitudes are multiples, but for the ends of a range
_BETTER = 1e-4  # relative; sizings differ by as much as that for no reason
_SAME = 5e-4  # what a ceiling that no day reaches may cost

Altitudes = tuple[float, float]  # floor and ceiling [m]


def with_best_altitudes(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel,
    *,
    required_excess_time_h: float | None = None,
) -> Mission:
    """Mission between the best altitudes of its ``climb.design_space``; itself without any.

    Where no altitudes have a design they are those of the largest excess time, for the reasons.
    """
    if mission.climb is None or not mission.climb.design_space.ranges():
        return mission
    search = _AltitudeSearch(aircraft, mission, objective, solar, required_excess_time_h)
    best = search.best()
    if best is None and objective is not Objective.max_excess_time and not objective.of_range:
        easiest = _AltitudeSearch(aircraft, mission, Objective.max_excess_time, solar, 0.0)
        best = easiest.best(refined=False)
    return mission if best is None else mission.flown_between(*best)


@dataclass
class _AltitudeSearch:
    """Search for the altitudes whose sizing has the best objective."""

    aircraft: Aircraft
    mission: Mission
    objective: Objective
    solar: SolarModel
    required_h: float | None
    known: dict[Altitudes, SizingResult | None] = field(default_factory=dict)
    start: DesignVariables | None = None

    def best(self, *, refined: bool = True) -> Altitudes | None:
        """Floor and ceiling of the best sizing; None where there is no design."""
        floors, ceilings = self._outermost()
        grid = [
            (floor_m, ceiling_m)
            for floor_m in np.linspace(*floors, _FLOORS if floors[1] > floors[0] else 1)
            for ceiling_m in np.linspace(*ceilings, _CEILINGS if ceilings[1] > ceilings[0] else 1)
        ]
        assert self.mission.climb is not None
        own = self._within((self.mission.altitude_m, self.mission.climb.ceiling_m))
        at = max([own, *map(self._within, grid)], key=self._merit)
        if math.isinf(self._merit(at)):
            # Minus infinity is no design; nothing is better than an unlimited excess time.
            return at if self._merit(at) > 0.0 else None
        return self._as_high_as_it_flies(self._refined(at)) if refined else at

    def _refined(self, at: Altitudes) -> Altitudes:
        """Best altitudes around some, by a compass search."""
        steps = [
            (ends[1] - ends[0]) / (count - 1) / 2.0
            for ends, count in zip(self._outermost(), (_FLOORS, _CEILINGS), strict=True)
        ]
        while max(steps) >= _FINEST_M:
            places = [self._within((at[0] + up * steps[0], at[1])) for up in (-1.0, 1.0)]
            places += [self._within((at[0], at[1] + up * steps[1])) for up in (-1.0, 1.0)]
            best = max((place for place in places if place != at), key=self._merit, default=at)
            if self._merit(best) > self._merit(at) + _BETTER * abs(self._merit(at)):
                at = best
            else:
                steps = [step / 2.0 for step in steps]
        return at

    def _as_high_as_it_flies(self, at: Altitudes) -> Altitudes:
        """The same with the lowest ceiling that no day reaches, where it costs nothing."""
        found = self.known[at]
        flown = None if found is None else found.simulated
        if flown is None or flown.maximum_altitude_m is None:
            return at
        reached_m = _ROUND_M * math.ceil(float(np.max(flown.maximum_altitude_m)) / _ROUND_M)
        lower = self._within((at[0], min(reached_m, at[1])))
        kept = self._merit(lower) >= self._merit(at) - _SAME * abs(self._merit(at))
        return lower if kept else at

    def _outermost(self) -> tuple[Altitudes, Altitudes]:
        """Least and greatest floor, and ceiling."""
        climb = self.mission.climb
        assert climb is not None
        floors, ceilings = climb.design_space.minimum_altitude_m, climb.design_space.ceiling_m
        own_m = self.mission.altitude_m
        return (
            (own_m, own_m) if floors is None else (floors.minimum, floors.maximum),
            (climb.ceiling_m, climb.ceiling_m)
            if ceilings is None
            else (ceilings.minimum, ceilings.maximum),
        )

    def _within(self, at: Altitudes) -> Altitudes:
        """Altitudes moved into their ranges and, between their ends, to multiples."""
        floors, ceilings = self._outermost()
        floor_m = _moved(at[0], floors[0], min(floors[1], ceilings[1]))
        return floor_m, _moved(at[1], max(ceilings[0], floor_m), ceilings[1])

    def _merit(self, at: Altitudes) -> float:
        if at not in self.known:
            self.known[at] = self._sizing_between(self.mission.flown_between(*at))
            better = max(self.known, key=self._merit_known)
            found = self.known[better]
            if found is not None and found.design is not None:
                self.start = found.design.variables
        return self._merit_known(at)

    def _merit_known(self, at: Altitudes) -> float:
        found = self.known[at]
        return -math.inf if found is None else found.merit

    def _sizing_between(self, mission: Mission) -> SizingResult | None:
        """Sizing between some altitudes; None where the propulsion cannot fly there."""
        given = (mission, self.objective, self.solar)
        options: dict[str, Any] = {"required_excess_time_h": self.required_h}
        try:
            aircraft, start, settled = sized_smoothly(self.aircraft, *given, **options)
            if self.objective.of_range:
                return widest_range(aircraft, *given, **options).sizing
            options |= {"start": self.start or start, "explain": False}
            guessed, result = sized_in_own_flow(aircraft, *given, settled=settled, **options)
            if settled is None:
                self.aircraft = guessed  # the flow of an optimum is near those of the others
            return result
        except ImpossibleDesignError:
            return None


def _moved(at_m: float, lowest_m: float, highest_m: float) -> float:
    return min(max(_ROUND_M * round(at_m / _ROUND_M), lowest_m), highest_m)
