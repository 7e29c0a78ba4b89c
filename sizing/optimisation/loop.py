"""The loop around the program: solve, simulate, shift the goal, and keep the best design.

The program knows a few scenarios on coarse nodes; the simulator judges all of them on fine ones. A
search solves the program, simulates the design that it finds, shifts the program's goal by what the
simulator finds otherwise, and solves again; scenarios that turn out worse than those in the program
join it. What counts is the simulator's number: of all designs that it accepts on the way, the best
is the optimum.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from sizing.design import DesignVariables
from sizing.energy.cycle import Status
from sizing.optimisation.problem import ALWAYS_LIT_MARGIN
from sizing.optimisation.result import (
    FIRST_MARGIN,
    GOAL_CUSHION_H,
    FlownSun,
    ProblemInstance,
    Solution,
)
from sizing.optimisation.variables import EXCESS_SCALE_H, TOTAL_MASS, WORST_EXCESS
from sizing.performance import Performance

_ROUNDS = 12
_WASTE_H = 0.012  # excess time beyond the required one that another goal is to save
_WASTE = 1e-3  # the same in what it costs of the objective, relative
# Cost of a missed requirement: far above any multiplier, so that none is missed for a gain.
PENALTY = 300.0
_MARGIN_WASTE = 2e-3  # the same of a margin on the recharge that climbs may do with less of
_SAME_GOAL_H = 1e-6  # goals that the solver cannot tell apart
_UNCHANGED = 1e-6  # relative difference of designs, between solver tolerance and any use
_OTHER_DAY, _SAME_HEIGHT = 0.1, 1e-4  # of the ceiling's height
_SAME_LIGHT, _OTHER_LIGHT = 3e-3, 1e-2  # relative; another one may have another best branch
_RELIGHTS = 4
# Of the step from a climb that ends at the ceiling: worth over what is waste, and largest size.
_LOOKS, _LOOKS_AT = 4.0, 0.02
_CORRECTIONS = 6  # of heights: as many rounds are left for the goal
_LARGE_MARGIN = 0.1  # of the recharge: climbs that need more begin a longer night
_LEAST_SHARE = 0.1  # of the way between two programs: regula falsi must not stand still


class Simulated(NamedTuple):
    """What the simulator finds for one solution.

    The excess time is that of ``worst``, the scenario with the least, confirmed with a fine step;
    ``merit`` is the larger the better, and ``sound`` tells whether the design keeps every
    requirement besides the excess time. ``spare_sun``: :func:`spare_sun` of the scenarios that must
    be always lit. ``sun``: in the design's own flow, where that cools the modules. ``climbed``: by
    scenario, :meth:`~sizing.performance.Performance.climbed`.
    """

    excess_time_h: float
    worst: int
    merit: float
    sound: bool
    performance: Performance | None = None
    spare_sun: float = 0.0
    sun: FlownSun | None = None
    climbed: Mapping[int, float] | None = None


class Accepted(NamedTuple):
    """A design that the simulator accepts."""

    solution: Solution
    found: Simulated


class _Bound(NamedTuple):
    """Goal and margin of a program, and the excess time that its design turned out to have."""

    goal_h: float
    margin: float
    excess_time_h: float


class Search:
    """One search for a design that the simulator accepts.

    ``instance``: what the program is to be solved for; its goal carries a cushion for all but the
    largest excess time. ``required_h``: excess time that the simulator must find in every scenario
    [h]. ``scenarios``: scenarios that are in the program from the beginning. ``solve``: solution of
    the search's instance; None where there is none.
    """

    def __init__(
        self,
        instance: ProblemInstance,
        required_h: float,
        scenarios: Sequence[int],
        solve: Callable[[Search], Solution | None],
        *,
        count: int,
    ) -> None:
        self.instance, self.required_h = instance, required_h
        self.scenarios, self.blocks, self.count = list(scenarios), len(scenarios), count
        self.cushion_h = GOAL_CUSHION_H
        self.ceiling_h = math.inf  # goal beyond which the program is known to have no solution
        self._solve = solve
        self.solution: Solution | None = None
        self.previous: Solution | None = None
        self.best: Accepted | None = None
        # Programs of these scenarios whose designs the simulator rejected and accepted last.
        self._short: _Bound | None = None
        self._enough: _Bound | None = None
        # Height errors by scenario with which climbs still ended too low, and at the ceiling; the
        # last one, and by how much climbs were off with it.
        self._errors: dict[int, tuple[float, float, float, float]] = {}
        self._corrections_left = _CORRECTIONS
        # Instance, solution and ceiling of the goal before the first of them.
        self._uncorrected: tuple[ProblemInstance, Solution, float] | None = None
        self._relights_left = _RELIGHTS
        self.afresh = False  # whether the program is another one than the last solution's
        self._longer_night = False  # than any margin on the recharge makes up for
        # Design of the last program whose goal turned out too low: as good as any can be.
        self.rejected: DesignVariables | None = None

    def filled(self) -> list[int]:
        """Scenarios in the blocks; spare ones repeat them."""
        return [self.scenarios[i % len(self.scenarios)] for i in range(self.blocks)]

    @property
    def current(self) -> Solution:
        """Solution to be judged."""
        assert self.solution is not None
        return self.solution

    def solved(self) -> bool:
        """Whether there is a solution to be judged, after solving the program if need be."""
        if self.solution is None:
            self.solution = self._solve(self)
            self.afresh = False
        if self.solution is None and self._uncorrected is not None:
            # The goal takes what the heights are off, as it does where that costs little.
            self._corrections_left, self._short, self._enough = 0, None, None
            self.instance, self.solution, self.ceiling_h = self._uncorrected
            self.previous = self._uncorrected = None
        return self.solution is not None

    def judge(self, simulated: Simulated) -> bool:
        """Keep the solution if it is the best one; whether the program is to be solved again."""
        accepted = self.accepts(simulated)
        if accepted and (self.best is None or simulated.merit > self.best.found.merit):
            self.best = Accepted(self.current, simulated)
        sun = simulated.sun
        if sun is not None and sun.off > _SAME_LIGHT and self._relights_left:
            self._relight(sun)
            return True
        errors = self._height_errors(simulated)
        known = errors is None and simulated.worst in self.scenarios
        if accepted and known and not self._wasteful(simulated):
            return False
        unlimited = np.isinf(simulated.excess_time_h)  # nothing is worse than the others
        if accepted and self.instance.sunlit and unlimited and not self._wastes_sun(simulated):
            return False
        if self.instance.sunlit and (unlimited or simulated.spare_sun < 0.0):
            self.instance = self._relit(simulated.spare_sun)
            self.previous, self.solution = self.solution, None
            return True
        if simulated.worst in self.scenarios:
            bound = _Bound(self.instance.goal_h, self.instance.margin, simulated.excess_time_h)
            self._short, self._enough = (self._short, bound) if accepted else (bound, self._enough)
        if errors is not None:
            if not self.instance.height_errors:
                self._uncorrected = self.instance, self.current, self.ceiling_h
            self.instance = replace(self.instance, height_errors=errors)
            self._corrections_left -= 1
            # Those were of another program.
            self._short, self._enough, self.ceiling_h = None, None, math.inf
            self.previous, self.solution = self.solution, None
            return True
        if not accepted:
            self.rejected = self.current.design
            if self.ceiling_h - self.instance.goal_h < _SAME_GOAL_H or self.enclosed():
                return False
        self._tighten(simulated)
        self.previous, self.solution = self.solution, None
        return True

    def _relight(self, sun: FlownSun) -> None:
        """Solve again with the light of modules that the design's own flow cools."""
        self.instance = replace(self.instance, sun=sun, spare_sun=0.0, height_errors={})
        self._relights_left -= 1
        self.afresh = sun.off > _OTHER_LIGHT
        # Those were of another light.
        self._short, self._enough, self.ceiling_h = None, None, math.inf
        self._errors, self._uncorrected = {}, None
        self.previous, self.solution = self.solution, None

    def _height_errors(self, simulated: Simulated) -> dict[int, float] | None:
        """Height errors of the program as the simulator finds them; None where they cost nothing.

        Where both differ by much they have ended on different days that repeat themselves.
        """
        held_back, climbed = self.current.held_back(), simulated.climbed
        if not held_back or climbed is None:
            return None
        if self._unchanged() or not self._corrections_left:
            return None
        known, worth_it = dict(self.instance.height_errors), False
        for scenario, (height, by_height) in held_back.items():
            last, off = known.get(scenario, 0.0), height - climbed[scenario]
            if abs(off) >= _OTHER_DAY or _LOOKS_AT * by_height < _WASTE:
                continue
            bounds = self._errors.get(scenario, (-math.inf, math.inf, last, 0.0))
            low, high, then, then_off = bounds
            if off > _SAME_HEIGHT:
                low = last
            elif height - off > 1.0 - _SAME_HEIGHT and last > low:
                high = last
            self._errors[scenario] = low, high, last, off
            # A day that ends too low begins the next one with less: what is lacking once it repeats
            # itself is more than the error of a day. At the ceiling nothing tells by how much.
            known[scenario] = last + off
            if off * then_off < 0.0:
                known[scenario] = last + off * (last - then) / (then_off - off)
            if math.isfinite(high) and off > -_SAME_HEIGHT:
                first = min(_LOOKS * _WASTE / by_height, _LOOKS_AT)
                further = high - max(first, 2.0 * (then - last))
                middle = (low + high) / 2.0 if math.isfinite(low) else further
                known[scenario] = middle if (high - middle) * by_height > _WASTE else high
            moved = abs(known[scenario] - last)
            worth_it |= moved * by_height > _WASTE or (last == low and known[scenario] == high)
        return known if worth_it else None

    def _wastes_sun(self, simulated: Simulated) -> bool:
        """Whether a sun that must carry the load has more to spare than next to nothing costs."""
        worth = self.current.cost(simulated.spare_sun * EXCESS_SCALE_H)
        return worth > _WASTE and not self._unchanged()

    def _relit(self, spare_sun: float) -> ProblemInstance:
        """Instance with the sun that must carry the load as the simulator finds it.

        The simulator has the modules cooled by the design's own flow, the program by that of the
        last one; and it has the propulsion's exact chain.
        """
        wanted = (1.0 + self.instance.spare_sun) * (1.0 + ALWAYS_LIT_MARGIN)
        return replace(self.instance, spare_sun=wanted / (1.0 + spare_sun) - 1.0)

    def accepts(self, simulated: Simulated) -> bool:
        """Whether a design has enough excess time everywhere and keeps its requirements."""
        if not (simulated.excess_time_h > 0.0 and simulated.excess_time_h >= self.required_h):
            return False
        # A limit on the total mass may be what is to be moved.
        return simulated.sound or TOTAL_MASS in self.instance.bounds

    def _wasteful(self, simulated: Simulated) -> bool:
        """Whether a design has more excess time than needed, and another goal may change that."""
        if self.instance.best_excess or (self.instance.goal_h <= 0.0 and self._short is None):
            return False
        surplus_h = simulated.excess_time_h - self.required_h
        if self._unchanged() or self.enclosed():
            return False
        if self.current.climbs and self._short is not None:
            # With climbs another margin, in between, may do.
            margin = self.instance.margin - self._short.margin
            if self.current.cost(0.0, margin) > _MARGIN_WASTE:
                return True
        # Next to the largest excess time minutes cost much: what they are worth is known.
        worth = self.current.cost(1.0)
        if surplus_h * worth > _WASTE:
            self.cushion_h = min(self.cushion_h, _WASTE / worth / 4.0)
            return True
        return surplus_h > _WASTE_H

    def begin_below(self, enough: Accepted) -> None:
        """Aim below a design of largest excess time, which is known to be enough.

        The program counts otherwise than the simulator: it wants a margin on the recharge, and its
        steps are longer. Near the largest excess time that decides whether it has any solution.
        """
        optimum, excess_h = enough.solution, enough.found.excess_time_h
        to_spare_h = excess_h - self.required_h
        if math.isinf(to_spare_h):
            return
        self.cushion_h = min(self.cushion_h, to_spare_h / 4.0)
        self.scenarios = list(dict.fromkeys(optimum.scenarios))
        self.blocks = len(optimum.scenarios)
        self.ceiling_h, margin = optimum.value(WORST_EXCESS), optimum.instance.margin
        self._short, self._enough = None, _Bound(self.ceiling_h, margin, excess_h)
        goal_h, sun = self.ceiling_h - to_spare_h + self.cushion_h, optimum.instance.sun
        self.instance = replace(self.instance, goal_h=goal_h, margin=margin, sun=sun)

    @property
    def knows_margin(self) -> bool:
        """Whether a program of these scenarios is known to ask for too little."""
        return self._short is not None

    def enclosed(self) -> bool:
        """Whether what lies between a rejected program and an accepted one is worth nothing.

        The excess time may leap there: a day that returns a little less lets the battery run empty.
        """
        last = self.solution or self.previous
        if self._short is None or self._enough is None or last is None:
            return False
        hours = abs(self._enough.goal_h - self._short.goal_h)
        margin = abs(self._enough.margin - self._short.margin)
        empties = last.climbs and self._short.excess_time_h <= 0.0
        return last.cost(hours, margin) < (_MARGIN_WASTE if empties else _WASTE / 4.0)

    def _unchanged(self) -> bool:
        """Whether the last goal made no difference: another requirement decides."""
        if self.previous is None:
            return False
        then, now = (list(one.design.chosen().values()) for one in (self.previous, self.current))
        return bool(np.allclose(then, now, rtol=_UNCHANGED, atol=0.0))

    def _tighten(self, simulated: Simulated) -> None:
        """Let the worst scenario join, or shift the goal if it is there already."""
        if simulated.worst not in self.scenarios:
            self.scenarios.append(simulated.worst)
            if len(self.scenarios) > self.blocks:
                self.blocks = min(2 * self.blocks, self.count)
            self._short = self._enough = None
            return
        goal_h, margin = self.instance.goal_h, self.instance.margin
        factor, largest = (5.0, _LARGE_MARGIN) if self.current.climbs else (3.0, math.inf)
        if self._short is not None and self._enough is not None:
            goal_h, margin = self._between(self._short, self._enough)
        elif simulated.excess_time_h <= 0.0 and not self._longer_night and margin < largest:
            # The battery runs empty over many days: the day must return more.
            goal_h, margin = goal_h + self.cushion_h, factor * margin
        else:
            if simulated.excess_time_h <= 0.0:  # with climbs the night may take more as well
                margin = 3.0 * (margin if self._longer_night else FIRST_MARGIN)
                self._longer_night = True
                bound = _Bound(goal_h, margin, simulated.excess_time_h)
                self._short = None if self._short is None else bound
            shifted_h = goal_h + self.required_h - simulated.excess_time_h + self.cushion_h
            if shifted_h > self.ceiling_h:
                shifted_h = (goal_h + self.ceiling_h) / 2.0
            goal_h = max(shifted_h, 0.0)
        self.instance = replace(self.instance, goal_h=goal_h, margin=margin)

    def _between(self, short: _Bound, enough: _Bound) -> tuple[float, float]:
        """Goal and margin between those that are too low and those that waste, by regula falsi."""
        aim_h = self.required_h + self.cushion_h
        share = (aim_h - short.excess_time_h) / (enough.excess_time_h - short.excess_time_h)
        if self.current.climbs and short.excess_time_h <= 0.0 < enough.goal_h - short.goal_h:
            # What a battery that runs empty lacks is of another scale: an hour of goal for an hour.
            share = 1.0 - (enough.excess_time_h - aim_h) / (enough.goal_h - short.goal_h)
        share = min(max(share, _LEAST_SHARE), 1.0 - _LEAST_SHARE)
        goal_h = short.goal_h + share * (enough.goal_h - short.goal_h)
        if self.current.climbs and short.excess_time_h <= 0.0:
            share = 0.5  # how much a battery that runs empty lacks does not tell the margin
        return goal_h, short.margin * (enough.margin / short.margin) ** share


def run(
    searches: Sequence[Search],
    simulate: Callable[[Sequence[Search]], Sequence[Simulated]],
    *,
    rounds: int = _ROUNDS,
) -> None:
    """Solve, simulate, shift and keep the best, until the simulator accepts each design.

    ``searches``: they are solved one after the other and simulated together. ``simulate``: what the
    simulator finds for the solutions of some searches.
    """
    for _ in range(rounds):
        searches = [search for search in searches if search.solved()]
        if not searches:
            return
        pairs = zip(searches, simulate(searches), strict=True)
        searches = [search for search, simulated in pairs if search.judge(simulated)]


def spare_sun(perf: Performance, sunlit: Collection[int]) -> float:
    """By how much the lowest sun of some scenarios exceeds the nominal load, relative; 0 of none.

    ``perf``: of one design.
    """
    lowest = perf.solar_power_w.min(axis=-1) / perf.nominal_load_w
    return float(np.min(lowest[list(sunlit)], initial=np.inf)) - 1.0 if sunlit else 0.0


def telling_scenarios(perf: Performance, count: int) -> list[int]:
    """Scenarios likely to drive the sizing: least excess time, and least sun for their load.

    Returns indices, the most telling one first.
    """
    cycle = perf.cycle
    short_of_sun = int(np.argmin(cycle.energy_budget.solar_wh / cycle.energy_budget.load_wh))
    by_excess = np.argsort(cycle.excess_time_h, kind="stable").tolist()
    dark = [i for i in by_excess if cycle.status[i] != Status.always_lit] or by_excess
    return list(dict.fromkeys([dark[0], short_of_sun, *dark, *by_excess]))[:count]
