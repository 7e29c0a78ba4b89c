"""Sizing with a margin on sun and battery that is no larger than a judge asks for.

A margin is one number, which stands for a factor on the sun's energy and one on the battery's. The
program finds the best design with these factors; the judge flies it without them (sizing and
judging by turns: Du, X., Chen, W. 2004, J. Mech. Des. 126:225).
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarDay, SolarModel, solar_day
from sizing.design_space import LimitedQuantity
from sizing.parameters import MISSION_PREFIX, all_replaced, with_parameter
from sizing.performance import performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult, SizingStatus, SolverReport, Violation
from sizing.program.size import size_aircraft

# Limits on the battery, by the power of the factor on it with which they grow.
_OF_BATTERY: dict[LimitedQuantity, float] = {
    "battery_energy_wh": 1.0,
    "cruise_discharge_rate_per_h": -1.0,
    "climb_discharge_rate_per_h": -1.0,
}
Factors = Callable[[float], tuple[float, float]]


class Trial(NamedTuple):
    """A design that was sized with a margin, and its judgement without the margin.

    ``reached``: share of draws, or number of days, that it flies. ``surplus``: by how much that is
    more than required, in the unit of the margin; infinite where no more is known than whether it
    is.
    """

    result: SizingResult
    reached: float
    surplus: float

    def outcome(self, requirement: str, missed: float, text: str) -> SizingResult:
        """Return the design where it suffices; else none, and by how much the nearest fails."""
        if self.surplus >= 0.0:
            return self.result
        violation, nearest = Violation(requirement, missed, text), self.result.simulated
        return self.result.without_design(SizingStatus.infeasible, nearest, violation)


def best_of(trials: Iterable[Trial]) -> Trial | None:
    """Return the trial of most merit among sufficient ones; else the one that reaches most."""
    trials = list(trials)
    sufficient = [trial for trial in trials if trial.surplus >= 0.0]
    if sufficient:
        return max(sufficient, key=lambda trial: trial.result.merit)
    return max(trials, key=lambda trial: trial.reached, default=None)


@dataclass
class MarginSearch(ABC):
    """Sizings of an aircraft with margins on sun and battery, and what their judge finds."""

    aircraft: Aircraft
    mission: Mission
    objective: Objective
    solar: SolarModel

    @abstractmethod
    def judge(self, result: SizingResult) -> Trial:
        """Try a design without the margin."""

    @cached_property
    def day(self) -> SolarDay:
        """Light without a margin."""
        return solar_day(self.aircraft, self.mission, self.solar)

    @cached_property
    def plain(self) -> SizingResult:
        """Sizing without a margin."""
        return size_aircraft(self.aircraft, self.mission, self.objective, self.solar)

    def sized(self, income: float, storage: float) -> SizingResult:
        """Return the best design with factors on sun and battery, simulated without them."""
        margins = self.mission.uncertainty_margins
        # Limits know nothing of the factor, which is no margin of a file: it may exceed 1.
        limits = {
            f"design_space.{row.key}": row.value * storage ** _OF_BATTERY[row.quantity]
            for row in self.aircraft.design_space.limit_rows().values()
            if row.quantity in _OF_BATTERY
        }
        limited = all_replaced(self.aircraft, limits)
        capacity = f"{MISSION_PREFIX}uncertainty_margins.battery_capacity"
        result = size_aircraft(
            *with_parameter(limited, self.mission, capacity, storage * margins.battery_capacity),
            self.objective,
            self.solar,
            day=self.day.scaled(income),
            start=None if self.plain.design is None else self.plain.design.variables,
            explain=False,
        )
        if result.design is None:
            return result
        perf = performance_of_designs(
            self.aircraft, self.mission, result.design.variables, self.solar, day=self.day
        )
        return result.with_design(perf)

    def least(
        self,
        factors: Factors,
        ends: tuple[float, float],
        step: float,
        tolerance: float,
        below: float = -math.inf,
    ) -> Trial | None:
        """Find the design of the least margin that its judge accepts; else the one of most reach.

        ``factors``: those of a margin on sun and battery. ``ends``: a margin that is not enough,
        with the surplus ``below``, and the largest that is tried. ``step``: to the first one; it
        doubles until one is enough. ``tolerance``: of the margin, or of an accepted surplus.
        """
        short, enough, work = ends[0], math.inf, SolverReport()
        points, tried = [(short, -math.inf), (short, below)], list[Trial]()
        while (short < ends[1]) if math.isinf(enough) else (enough - short > tolerance):
            margin, farthest = (short + enough) / 2.0, enough
            if math.isinf(enough):
                margin = farthest = min(short + step, ends[1])
                step *= 2.0
            # A secant to where next to none is left, where it leads to between what is known.
            (a, of_a), (b, of_b) = points[-2:]
            if math.isfinite(of_b - of_a) and of_a != of_b:
                secant = b + (tolerance / 2.0 - of_b) * (b - a) / (of_b - of_a)
                margin = secant if short < secant < farthest else margin
            result, surplus = self.sized(*factors(margin)), math.inf
            work += result.solver
            if result.design is not None:  # else the margin is too large
                tried.append(self.judge(result))
                surplus = tried[-1].surplus
            if 0.0 <= surplus <= tolerance:
                break
            points.append((margin, surplus))
            short, enough = (margin, enough) if surplus < 0.0 else (short, margin)
        best = best_of(tried)
        return best and best._replace(result=replace(best.result, solver=work))
