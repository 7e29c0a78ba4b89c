"""Sizings with factors on solar energy and storage, and their designs without the factors.

And the edge of what is enough, in solar energy and storage.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import Design, DesignVariables
from sizing.design_space import LimitedQuantity
from sizing.limits import meets_requirements
from sizing.optimisation.infeasibility import least_mission
from sizing.optimisation.problem import SizingProblems
from sizing.optimisation.search import size_aircraft
from sizing.parameters import MISSION_PREFIX, with_parameter
from sizing.performance import Performance, performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult, SolverReport, merit_of
from sizing.sunlight import SolarDay, SolarModel
from solar.types import BoolArray, FloatArray, IntArray

_HALVINGS = 9
# Weight of the squared curvature beside the misfit of a point.
_RIDGE = 1e-4

Count = Callable[[FloatArray, FloatArray], IntArray]


def least_income(
    count: Count, storage: FloatArray, ends: tuple[float, float], needed: int, *, at_once: int = 1
) -> FloatArray:
    """Least income with which enough days close, for some storages.

    More of either never closes fewer days, but for a day or two whose dawns move.

    ``count``: days that close, of logarithms of income and storage. ``at_once``: incomes of a
    storage that are tried at the same time, at least 1. Returns logarithms of the incomes, to a
    five-hundredth of the distance of the ends; NaN where even the largest is not enough.
    """

    def enough(income: FloatArray, columns: IntArray) -> BoolArray:
        counts = count(income.reshape(-1), np.tile(storage[columns], len(income)))
        return np.asarray(counts.reshape(income.shape) >= needed)

    rounds = math.ceil(_HALVINGS / math.log2(at_once + 1))
    return _least_enough(enough, len(storage), ends, at_once=at_once, rounds=rounds)


def least_step(count: Count, ends: tuple[float, float], needed: int) -> float:
    """Least step in income and storage alike with which enough days close.

    Returns to a four-thousandth of the distance of the ends; NaN where even the largest is not
    enough.
    """

    def enough(steps: FloatArray, _: IntArray) -> BoolArray:
        alike = steps.reshape(-1)
        return np.asarray(count(alike, alike).reshape(steps.shape) >= needed)

    return float(_least_enough(enough, 1, ends, at_once=7, rounds=4)[0])


def _least_enough(
    enough: Callable[[FloatArray, IntArray], BoolArray],
    columns: int,
    ends: tuple[float, float],
    *,
    at_once: int,
    rounds: int,
) -> FloatArray:
    """Least value of each column that is enough, between two ends; NaN where there is none.

    ``enough``: of values of some columns, shape ``(tried, column)``. Each round cuts what is left
    into ``at_once + 1`` parts.
    """
    low, high = (np.full(columns, float(end)) for end in ends)
    met = enough(high[np.newaxis], np.arange(columns))[0]
    some = np.flatnonzero(met)
    parts = np.linspace(0.0, 1.0, at_once + 2)[1:, np.newaxis]
    for _ in range(rounds if len(some) else 0):
        tried = low[some] + parts * (high[some] - low[some])
        sufficient = np.vstack([enough(tried[:-1], some), np.ones((1, len(some)), bool)])
        first, cells = np.argmax(sufficient, axis=0), np.arange(len(some))
        low[some], high[some] = np.vstack([low[some], tried])[first, cells], tried[first, cells]
    return np.where(met, high, np.nan)


def fitted(places: FloatArray, costs: FloatArray, here: int) -> Callable[[FloatArray], FloatArray]:
    """Cost as a quadratic function of the place, through one point and near to the others.

    Returns costs of places of shape ``(..., 2)``.
    """
    steps = places - places[here]
    weight = 1.0 / (0.02 + np.hypot(*steps.T))
    rows = weight[:, np.newaxis] * _powers(steps)
    free = np.sqrt(_RIDGE) * np.diag([0.1, 0.1, 1.0, 1.0, 1.0])
    goal = np.concatenate([weight * (costs - costs[here]), np.zeros(5)])
    slopes = np.linalg.lstsq(np.vstack([rows, free]), goal, rcond=None)[0]

    def cost(at: FloatArray) -> FloatArray:
        return np.asarray(costs[here] + _powers(at - places[here]) @ slopes)

    return cost


def _powers(steps: FloatArray) -> FloatArray:
    x, y = steps[..., 0], steps[..., 1]
    return np.stack([x, y, x * x, x * y, y * y], axis=-1)


# Limits on the battery, by the power of the factor on its storage with which they grow.
_SCALED_LIMITS: dict[LimitedQuantity, float] = {
    "battery_energy_wh": 1.0,
    "cruise_discharge_rate_per_h": -1.0,
    "climb_discharge_rate_per_h": -1.0,
}


class Trial(NamedTuple):
    """A design that was sized with factors, and how it does without them.

    ``factors``: their logarithms, of income and storage. ``merit``: objective, the larger the
    better. ``reached``: share of draws, or number of days, by which the design is judged.
    ``sound``: whether it keeps every requirement on the design itself.
    """

    result: SizingResult
    factors: FloatArray
    performance: Performance
    merit: float
    reached: float
    sound: bool

    @property
    def design(self) -> Design:
        """Design without the factors."""
        return self.performance.design

    @property
    def variables(self) -> DesignVariables:
        """Design variables."""
        return self.design.variables


class MarginSearch(ABC):
    """Search for the factors of the best design that a judge accepts; see the package.

    ``day``: the sun that the program is given factors on. ``problems``: programs of the aircraft.
    """

    def __init__(
        self,
        aircraft: Aircraft,
        mission: Mission,
        objective: Objective,
        solar: SolarModel,
        day: SolarDay,
        problems: SizingProblems,
    ) -> None:
        self.aircraft, self.mission, self.objective = aircraft, mission, objective
        self.solar, self.day, self.problems = solar, day, problems
        self.tried: list[Trial] = []
        self.reports: list[SolverReport] = []
        self.limited = [
            name for name in _SCALED_LIMITS if name in aircraft.design_space.all_limits()
        ]

    @abstractmethod
    def reached(self, design: Design) -> float:
        """What the judge finds for a design."""

    @property
    def found(self) -> list[Trial]:
        """Trials that keep every requirement on the design itself."""
        return [one for one in self.tried if one.sound]

    def best_of_tried(self, enough: float) -> Trial | None:
        """Best design of the trials that reaches enough; None where there is none."""
        good = [one for one in self.found if one.reached >= enough]
        return max(good, key=lambda one: one.merit, default=None)

    def trial(
        self,
        factors: ArrayLike,
        objective: Objective | None = None,
        start: DesignVariables | None = None,
    ) -> Trial | None:
        """Best design with factors on income and storage; None where there is none.

        ``objective``: another one, for which no excess time is required and the least is carried.
        """
        steps = np.asarray(factors, float)
        mission = self.mission if objective is None else least_mission(self.mission, self.objective)
        mission, day = self.given(steps, mission)
        aircraft = self.with_limits(steps)
        result = size_aircraft(
            *(aircraft, mission, objective or self.objective, self.solar),
            required_excess_time_h=None if objective is None else 0.0,
            day=day,
            problems=self.problems if aircraft is self.aircraft else SizingProblems(aircraft),
            start=start,
            explain=False,
        )
        self.reports.append(result.solver)
        return None if result.design is None else self.judged(result, steps)

    def given(self, factors: FloatArray, mission: Mission) -> tuple[Mission, SolarDay]:
        """Mission and day of the program with factors on storage and income."""
        income, storage = map(math.exp, factors)
        # Not a margin of a file: the factor may exceed 1.
        key = f"{MISSION_PREFIX}uncertainty_margins.battery_capacity"
        capacity = storage * mission.uncertainty_margins.battery_capacity
        return with_parameter(mission, mission, key, capacity)[1], self.day.scaled(income)

    def with_limits(self, factors: FloatArray) -> Aircraft:
        """Aircraft whose limits on the battery hold without the factor on its storage."""
        if not self.limited:
            return self.aircraft
        space, storage = self.aircraft.design_space, math.exp(factors[1])
        for name in self.limited:
            limit = self.aircraft.design_space.all_limits()[name]
            factor = storage ** _SCALED_LIMITS[name]
            if limit.minimum is not None:
                space = space.with_limit(name, "minimum", limit.minimum * factor)
            if limit.maximum is not None:
                space = space.with_limit(name, "maximum", limit.maximum * factor)
        return self.aircraft.model_copy(update={"design_space": space})

    def judged(self, result: SizingResult, factors: FloatArray) -> Trial:
        """Trial of a sizing's design, without the factors."""
        assert result.design is not None
        perf = performance_of_designs(
            *(self.aircraft, self.mission, result.design.variables, self.solar), day=self.day
        )
        merit = float(merit_of(self.objective, perf))
        sound = bool(meets_requirements(self.aircraft, self.mission, perf.design))
        one = Trial(result, factors, perf, merit, self.reached(perf.design), sound)
        self.tried.append(one)
        return one

    def as_asked(self, one: Trial, reports: list[SolverReport]) -> SizingResult:
        """Sizing of a trial as that for the objective and the mission that are asked for."""
        return replace(
            one.result,
            objective=self.objective,
            required_excess_time_h=self.mission.required_excess_time_h,
            solver=sum(reports, SolverReport()),
        )
