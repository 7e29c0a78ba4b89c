"""Sizing: the best wingspan, battery mass and module area for a mission, or why there is none.

The program knows a few scenarios on coarse nodes; the simulator judges all of them on fine ones. A
search solves the program, simulates the design that it finds, shifts the program's goal by what the
simulator finds otherwise, and solves again; scenarios that turn out worse than those in the program
join it. What counts is the simulator's number: of all designs that it accepts on the way, the best
is the optimum.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.design import DesignVariables, variables_of
from sizing.energy.cycle import Status
from sizing.limits import meets_requirements
from sizing.optimisation.energy_constraints import growing_lit_sets, lowest_power
from sizing.optimisation.infeasibility import (
    Promising,
    Verdict,
    least_mission,
    least_unlifted,
    promising_designs,
    short_of_largest_excess,
    violations,
)
from sizing.optimisation.objectives import Objective
from sizing.optimisation.problem import WORST_EXCESS, Effort, SizingProblems
from sizing.optimisation.result import (
    RELATIVE_TOLERANCE,
    SizingResult,
    SizingStatus,
    active_constraints,
    limiting_rows,
    objective_value,
    plain_design,
)
from sizing.optimisation.solver import (
    GOAL_CUSHION_H,
    ProblemInstance,
    ProgramSolver,
    Solution,
)
from sizing.performance import Performance
from sizing.sunlight import DEFAULT_STEP_H, UNCORRECTED_CAM, SolarDay, SolarModel, solar_day

__all__ = ["Search", "SizingResult", "run", "size_aircraft"]

# Scenarios that a program starts with; others join when the simulator finds them worse.
_FIRST_BLOCKS = 3
_ROUNDS = 12
_WASTE_H = 0.012  # excess time beyond the required one that another goal is to save
_WASTE = 1e-3  # the same in what it costs of the objective, relative
_MARGIN_COST = 0.003  # of the objective, relative
# Cost of a missed requirement: far above any multiplier, so that none is missed for a gain.
PENALTY = 300.0
_PLAIN = 30.0  # cost of what is missed that no gain of any objective repays
_NEXT_TO_NOTHING = 1e-3  # of a payload [kg, W]
_SAME_GOAL_H = 1e-6  # goals that the solver cannot tell apart
_UNCHANGED = 1e-6  # relative difference of designs, between solver tolerance and any use
_LEAST_SHARE = 0.1  # of the way between two programs: regula falsi must not stand still
_ROW_TOLERANCE = 1e-5  # relative; the solver meets its rows to about 1e-8
_RESTARTS = 3
_LESS_MARGIN = 1.0 / 30.0
# Part of its mass that no design of a coarse grid lifts: those between its points gain less.
_HOPELESS = 1.0
_BRANCHES = 6  # that a cross-check tries at most, besides that by battery alone


# --- the loop --------------------------------------------------------------------------------


class Simulated(NamedTuple):
    """What the simulator finds for one solution.

    The excess time is that of ``worst``, the scenario with the least, confirmed with a fine step;
    ``merit`` is the larger the better, and ``sound`` tells whether the design keeps every
    requirement besides the excess time.
    """

    excess_time_h: float
    worst: int
    merit: float
    sound: bool
    performance: Performance | None = None


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
        return self.solution is not None

    def judge(self, found: Simulated) -> bool:
        """Keep the solution if it is the best one; whether the program is to be solved again."""
        accepted = self.accepts(found)
        if accepted and (self.best is None or found.merit > self.best.found.merit):
            self.best = Accepted(self.current, found)
        if accepted and found.worst in self.scenarios and not self._wasteful(found):
            return False
        if accepted and self.instance.lit and np.isinf(found.excess_time_h):
            return False  # nothing is worse than the others
        if found.worst in self.scenarios:
            bound = _Bound(self.instance.goal_h, self.instance.margin, found.excess_time_h)
            self._short, self._enough = (self._short, bound) if accepted else (bound, self._enough)
        if not accepted:
            self.rejected = self.current.design
            if self.ceiling_h - self.instance.goal_h < _SAME_GOAL_H or self.enclosed():
                return False
        self._tighten(found)
        self.previous, self.solution = self.solution, None
        return True

    def accepts(self, found: Simulated) -> bool:
        """Whether a design has enough excess time everywhere and keeps its requirements."""
        if not (found.excess_time_h > 0.0 and found.excess_time_h >= self.required_h):
            return False
        # A limit on the total mass may be what is to be moved.
        return found.sound or "total_mass_kg" in self.instance.bounds

    def _wasteful(self, found: Simulated) -> bool:
        """Whether a design has more excess time than needed, and another goal may change that."""
        if self.instance.best_excess or (self.instance.goal_h <= 0.0 and self._short is None):
            return False
        surplus_h = found.excess_time_h - self.required_h
        if self._unchanged() or self.enclosed():
            return False
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
        goal_h = self.ceiling_h - to_spare_h + self.cushion_h
        self.instance = replace(self.instance, goal_h=goal_h, margin=margin)

    def enclosed(self) -> bool:
        """Whether what lies between a rejected program and an accepted one is worth nothing.

        The excess time may leap there: a day that returns a little less lets the battery run empty.
        """
        last = self.solution or self.previous
        if self._short is None or self._enough is None or last is None:
            return False
        hours = abs(self._enough.goal_h - self._short.goal_h)
        margin = abs(self._enough.margin - self._short.margin)
        return last.cost(hours, margin) < _WASTE / 4.0

    def _unchanged(self) -> bool:
        """Whether the last goal made no difference: another requirement decides."""
        if self.previous is None:
            return False
        then, now = (list(one.design.chosen().values()) for one in (self.previous, self.current))
        return bool(np.allclose(then, now, rtol=_UNCHANGED, atol=0.0))

    def _tighten(self, found: Simulated) -> None:
        """Let the worst scenario join, or shift the goal if it is there already."""
        if found.worst not in self.scenarios:
            self.scenarios.append(found.worst)
            if len(self.scenarios) > self.blocks:
                self.blocks = min(2 * self.blocks, self.count)
            self._short = self._enough = None
            return
        goal_h, margin = self.instance.goal_h, self.instance.margin
        if self._short is not None and self._enough is not None:
            goal_h, margin = self._between(self._short, self._enough)
        elif found.excess_time_h <= 0.0:
            # The battery runs empty over many days: the day must return more.
            goal_h, margin = goal_h + self.cushion_h, 3.0 * margin
        else:
            shifted_h = goal_h + self.required_h - found.excess_time_h + self.cushion_h
            if shifted_h > self.ceiling_h:
                shifted_h = (goal_h + self.ceiling_h) / 2.0
            goal_h = max(shifted_h, 0.0)
        self.instance = replace(self.instance, goal_h=goal_h, margin=margin)

    def _between(self, short: _Bound, enough: _Bound) -> tuple[float, float]:
        """Goal and margin between those that are too low and those that waste, by regula falsi."""
        aim_h = self.required_h + self.cushion_h - short.excess_time_h
        share = aim_h / (enough.excess_time_h - short.excess_time_h)
        share = min(max(share, _LEAST_SHARE), 1.0 - _LEAST_SHARE)
        goal_h = short.goal_h + share * (enough.goal_h - short.goal_h)
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
        judged = zip(searches, simulate(searches), strict=True)
        searches = [search for search, found in judged if search.judge(found)]


def telling_scenarios(perf: Performance, count: int) -> list[int]:
    """Scenarios likely to drive the sizing: least excess time, and least sun for their load.

    Returns indices, the most telling one first.
    """
    cycle = perf.cycle
    short_of_sun = int(np.argmin(cycle.energy_budget.solar_wh / cycle.energy_budget.load_wh))
    by_excess = np.argsort(cycle.excess_time_h, kind="stable").tolist()
    dark = [i for i in by_excess if cycle.status[i] != Status.always_lit] or by_excess
    return list(dict.fromkeys([dark[0], short_of_sun, *dark, *by_excess]))[:count]


def simulated(
    solver: ProgramSolver, perf: Performance, merit: float, required_h: float
) -> Simulated:
    """What the simulator finds for one design."""
    worst = perf.worst_scenario()
    met = meets_requirements(
        solver.aircraft, perf.design, solver.conditions, tolerance=_ROW_TOLERANCE
    )
    excess_h = solver.least_excess_h(perf, required_h)
    return Simulated(excess_h, worst, merit, bool(np.all(met)), perf)


# --- one sizing ------------------------------------------------------------------------------


def size_aircraft(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective = Objective.max_excess_time,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    required_excess_time_h: float | None = None,
    day: SolarDay | None = None,
    step_h: float = DEFAULT_STEP_H,
    problems: SizingProblems | None = None,
    start: DesignVariables | None = None,
    explain: bool = True,
    enough_h: float = math.inf,
) -> SizingResult:
    """Find the best design of a parametric aircraft for a mission.

    ``aircraft``: technology, bounds of the design variables, and a first guess (its own design
    point). ``objective``: ``max_excess_time`` of the worst scenario, or another one with a required
    excess time in every scenario. For the objectives that are a range of days or latitudes see
    :func:`sizing.optimisation.coverage.widest_range`. ``required_excess_time_h``: overrides the
    mission's own [h]. For ``max_excess_time`` it is a bound from below. ``day``: specific power of
    the scenarios where it is known already. ``problems``: programs of this very aircraft, from an
    earlier sizing: nothing is built again. ``start``: first guess, for instance the optimum of a
    similar mission. ``explain``: whether to find out why a search fails. If not, it ends as
    ``not_converged``: faster, for searches in which failures are many and their reasons idle.
    ``enough_h``: excess time that will do [h]: the search takes shortcuts, and ends at the first
    design that has it.
    """
    problems = checked_problems(aircraft, objective, problems)
    required = mission.required_excess_time_h
    required = required if required_excess_time_h is None else required_excess_time_h
    lit = solar_day(aircraft, mission, solar, step_h=step_h) if day is None else day
    solver = ProgramSolver(problems, mission, solar, lit, by_model=day is None)
    return _sized(solver, objective, required, start, explain=explain, enough_h=enough_h)


def size_branches(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    required_excess_time_h: float,
    day: SolarDay,
    start: DesignVariables,
) -> list[Performance]:
    """Simulate the best design of every branch under a midnight sun: no shortcuts, one by one.

    Returns of the branches that have a design; empty where every scenario has a night.
    """
    solver = ProgramSolver(SizingProblems(aircraft), mission, solar, day, by_model=True)
    sets = growing_lit_sets(lowest_power(day))
    some = sorted({round(i) for i in np.linspace(0, len(sets) - 1, _BRANCHES)}) if sets else []
    found = [
        _Sizing(solver, objective, required_excess_time_h, start, explain=False, lit=lit).run()
        for lit in [*([[]] if sets else []), *(sets[i] for i in some)]
    ]
    return [one.simulated for one in found if one.simulated is not None]


def checked_problems(
    aircraft: Aircraft, objective: Objective, problems: SizingProblems | None
) -> SizingProblems:
    """Programs of an aircraft that can be sized for an objective, built anew if none are given."""
    if isinstance(aircraft.airframe, MeasuredAirframe):
        raise TypeError(f"{aircraft.name} is a measured aircraft: it has no mass budget to size")
    if objective.of_range:
        raise ValueError(f"{objective.value} is a range of days or latitudes: use widest_range")
    if problems is not None and problems.aircraft is not aircraft:
        raise ValueError("the programs belong to another aircraft")
    return problems or SizingProblems(aircraft)


def _sized(
    solver: ProgramSolver,
    objective: Objective,
    required_h: float,
    start: DesignVariables | None = None,
    *,
    explain: bool,
    enough_h: float = math.inf,
) -> SizingResult:
    """Best design over the branches of the problem, or why there is none.

    Under a midnight sun a requirement of excess time can be met in two ways: by the battery, or by
    a sun that carries the load at all times. Which scenarios are met in which way makes a branch;
    of a set of branches each of which has one more always lit scenario than the one before, only
    those are tried in which a scenario joins whose required excess time holds the last one back.
    """
    given = (solver, objective, required_h, start)
    count = len(solver.day.scenarios)
    best_excess = objective is Objective.max_excess_time
    lit_sets = growing_lit_sets(lowest_power(solver.day)) if required_h > 0.0 or best_excess else []
    if not lit_sets:
        return _Sizing(*given, explain=explain, enough_h=enough_h).run()

    def branch(lit: list[int]) -> _Sizing:
        return _Sizing(*given, explain=False, enough_h=enough_h, lit=lit)

    found: list[SizingResult] = []
    if len(lit_sets[-1]) == count:
        found.append(branch(lit_sets.pop()).run())
        # No excess time is longer than an unlimited one.
        if best_excess and found[0].feasible:
            return found[0]
    by_battery = one = branch([])
    found.append(without_lit := one.run())
    place = one.next_of(lit_sets, -1)
    while place is not None and place < len(lit_sets) and _merit(found[-1]) < enough_h:
        one = branch(lit_sets[place])
        found.append(one.run())
        place = one.next_of(lit_sets, place)
    best = max(found, key=_merit)
    if not best.feasible:
        return by_battery.explained() if explain else without_lit
    return replace(best, solver=solver.report())


def _merit(result: SizingResult) -> float:
    """Objective, the larger the better."""
    if result.objective_value is None:
        return -np.inf
    return result.objective_value if result.objective.maximised else -result.objective_value


@lru_cache(maxsize=1)
def _promising(solver: ProgramSolver) -> list[Promising]:
    """Designs of a coarse grid that come nearest, kept: a verdict may ask for them again."""
    return promising_designs(solver.aircraft, solver.mission, solver.solar, solver.day)


@lru_cache(maxsize=1)
def _start_flown(solver: ProgramSolver, variables: DesignVariables, *, coarse: bool) -> Performance:
    """Simulated design, kept: the branches of a problem start from the same."""
    return solver.performance(variables, coarse=coarse)


class _Sizing:
    """One sizing: where it starts, its search, and the verdict."""

    def __init__(
        self,
        solver: ProgramSolver,
        objective: Objective,
        required_h: float,
        start: DesignVariables | None = None,
        *,
        explain: bool = True,
        enough_h: float = math.inf,
        lit: Sequence[int] = (),
    ) -> None:
        self.explain, self.enough_h, self.lit = explain, enough_h, list(lit)
        self.solver, self.aircraft, self.day = solver, solver.aircraft, solver.day
        self.objective, self.required_h = objective, required_h
        self.start = variables_of(self.aircraft) if start is None else start
        self.restarts = 0
        self.last: Solution | None = None
        self.missed: Solution | None = None
        self.largest: Accepted | None = None  # design of largest excess time, if it is enough

    def run(self) -> SizingResult:
        count = len(self.day.scenarios)
        self.search = Search(
            self._instance(),
            self.required_h,
            self._first_scenarios(min(_FIRST_BLOCKS, count)),
            self._solve_again,
            count=count,
        )
        # With a penalty the program says soonest that nothing meets all requirements.
        solution = self._solve([self.start], self.search.instance.penalised(PENALTY))
        nearly = self.solver.nearly
        if nearly is not None and self.rough:
            solution = self._all_but_met(nearly)
            if solution is None:
                return self._failure(self.first)
        if solution is None:
            solution = self._solve([self.start])
            return self._failure(self.first) if solution is None else self._settled(solution)
        if solution.missed():
            self.missed = missed = solution
            if self.explain:
                return self._explained(lambda: [missed.design])
            plain = missed.cost_of_missing() > _PLAIN
            solution = None if plain else self._met_after_all(solution)
        return self._given_up(self.first) if solution is None else self._settled(solution)

    @property
    def rough(self) -> bool:
        """Whether a design will do that is good enough: one at a kink need not be the best."""
        return math.isfinite(self.enough_h)

    @cached_property
    def first(self) -> Performance:
        """What the simulator finds for the design that the search starts from."""
        return _start_flown(self.solver, self.start, coarse=self.rough)

    def explained(self) -> SizingResult:
        """Why a run without explanation has found no design; or the design, after all."""
        self.explain = True
        if self.missed is None:
            return self._failure(self.first)
        missed = self.missed
        return self._explained(lambda: [missed.design])

    def next_of(self, lit_sets: Sequence[Sequence[int]], place: int) -> int | None:
        """First set of always lit scenarios in which a required excess time falls that limits.

        The next one where there is no solution, none where no other scenario holds back.
        """
        solution = self.search.best.solution if self.search.best is not None else self.last
        if solution is None:
            return place + 1
        limiting = {
            solution.scenarios[row.block]
            for row in limiting_rows(solution)
            if row.name == "excess_time" and row.block is not None
        } - set(self.lit)
        places = range(place + 1, len(lit_sets))
        return next((i for i in places if not limiting.isdisjoint(lit_sets[i])), None)

    # --- the program -------------------------------------------------------------------------

    def _instance(self) -> ProblemInstance:
        instance = ProblemInstance.of(self.objective, self.required_h)
        everywhere = len(self.lit) == len(self.day.scenarios)
        return instance.always_lit(self.lit, all_of_them=everywhere)

    def _first_scenarios(self, count: int) -> list[int]:
        """Scenarios to begin with; of those that must be always lit, the one with the least sun."""
        if count == len(self.day.scenarios):
            return list(range(count))
        if not self.lit:
            return telling_scenarios(self.first, count)
        telling = telling_scenarios(self.first, len(self.day.scenarios))
        others = [i for i in telling if i not in self.lit]
        return list(dict.fromkeys([*others[:1], self.lit[-1], *others, *telling]))[:count]

    def _solve(
        self,
        starts: Sequence[DesignVariables],
        instance: ProblemInstance | None = None,
        *,
        effort: Effort = "quick",
        previous: Solution | None = None,
    ) -> Solution | None:
        search = self.search
        found = self.solver.solve(
            search.instance if instance is None else instance,
            search.filled(),
            starts,
            efforts=(effort,),
            previous=previous,
        )
        self.last = found or self.last
        return found

    def _solve_again(self, search: Search) -> Solution | None:
        """Solution from the last one's design, or from that of largest excess time."""
        assert search.previous is not None
        starts = [search.previous.design]
        starts += [] if self.largest is None else [self.largest.solution.design]
        found = self._solve(starts)
        if found is not None or not self.rough:
            return found or self._solve(starts, effort="steady")
        soft = self._solve(starts, search.instance.penalised(PENALTY)) or self.solver.nearly
        return None if soft is None or soft.missed() else soft

    def _met_after_all(self, solution: Solution) -> Solution | None:
        """Solution where the penalty was too low to keep a requirement from being missed."""
        least = self._solve(
            [solution.design], self.search.instance.least_missed(), previous=solution
        )
        if least is not None and least.missed():
            return None
        return self._solve([solution.design if least is None else least.design])

    def _all_but_met(self, nearly: Solution) -> Solution | None:
        """Solution next to one at a kink, if that misses no more than the margin asks for."""
        self.last, missed = nearly, nearly.missed()
        if not missed:
            instance, scenarios = self.search.instance, self.search.filled()
            return self.solver.solve(instance, scenarios, [nearly.design], efforts=()) or nearly
        margin = self.search.instance.margin
        if max(missed.values()) > margin:
            return None
        self.search.instance = replace(self.search.instance, margin=_LESS_MARGIN * margin)
        return self._solve([nearly.design])

    # --- the simulator -----------------------------------------------------------------------

    def _simulated(self, solution: Solution) -> Simulated:
        perf = self.solver.performance(solution.design)
        value = float(objective_value(self.objective, perf))
        merit = value if self.objective.maximised else -value
        return simulated(self.solver, perf, merit, self.required_h)

    def _settled(self, solution: Solution) -> SizingResult:
        """Best design that the simulator accepts, from a first solution on."""
        self.search.previous, self.search.solution = None, solution
        self._run()
        best = self.search.best
        if (
            best is not None
            and best.solution.cost(0.0, best.solution.instance.margin) > _MARGIN_COST
        ):
            less = best.solution.instance.margin * _LESS_MARGIN
            self.search.instance = replace(best.solution.instance, margin=less)
            self.search.previous, self.search.solution = best.solution, None
            self._run()
        if self.search.best is None and self._nothing_between():
            self.search.best = self.largest
        if self.search.best is None:
            nearest = self.first if self.rough else self.solver.performance(solution.design)
            return self._failure(nearest)
        return self._optimal(*self.search.best)

    def _run(self) -> None:
        run([self.search], lambda some: [self._simulated(one.current) for one in some])

    def _nothing_between(self) -> bool:
        """Whether the design of largest excess time is as good as one that falls just short.

        Next to the largest excess time the solver's tolerance moves the design by about its square
        root, and there may be no goal whose design the simulator accepts.
        """
        if self.largest is None or self.search.rejected is None:
            return False
        if self.search.enclosed():
            return True
        own, short = self.largest.solution.design.chosen(), self.search.rejected.chosen()
        return all(
            math.isclose(
                own[name], short[name], rel_tol=RELATIVE_TOLERANCE, abs_tol=_NEXT_TO_NOTHING
            )
            for name in own
        )

    # --- verdicts ----------------------------------------------------------------------------

    def _failure(self, nearest: Performance) -> SizingResult:
        if not self.explain:
            return self._given_up(nearest)

        def grid() -> list[DesignVariables]:
            if self.rough:
                return [self.start if self.last is None else self.last.design]
            return [one.design for one in _promising(self.solver)] or [variables_of(self.aircraft)]

        return self._explained(grid)

    def _explained(self, starts: Callable[[], list[DesignVariables]]) -> SizingResult:
        """Why there is no design; where nothing is found to be missing, the search starts again."""
        if self.required_h > 0.0 or self.objective is not Objective.max_excess_time:
            return self._explained_by_largest_excess(starts)
        return self._explained_by_least_missed(starts())

    def _explained_by_largest_excess(
        self, starts: Callable[[], list[DesignVariables]]
    ) -> SizingResult:
        own = self.solver
        mission = least_mission(own.mission, self.objective)
        solver = ProgramSolver(own.problems, mission, own.solar, own.day, by_model=own.by_model)
        largest = self._largest_excess(solver)
        own.add(solver)
        verdict = short_of_largest_excess(self.aircraft, largest, self.required_h)
        if verdict is not None:
            return self._failed(verdict)
        assert largest.simulated is not None
        assert largest.optimum is not None
        if self.objective is Objective.max_excess_time:
            return replace(
                largest, required_excess_time_h=self.required_h, solver=self.solver.report()
            )
        self.lit = sorted(largest.optimum.instance.lit)
        self.search.instance = self._instance()
        # Its own time step judges it: no finer one takes back what the largest excess time allows.
        assert largest.objective_value is not None
        found = self._simulated(largest.optimum)
        self.largest = Accepted(
            largest.optimum, found._replace(excess_time_h=largest.objective_value)
        )
        self.search.begin_below(self.largest)
        nearest = largest.simulated.design.variables.mapped(float)
        return self._restarted([nearest, *starts()], largest.simulated)

    def _largest_excess(self, solver: ProgramSolver) -> SizingResult:
        """Sizing for the largest excess time; too short a one is held against a grid of designs."""
        largest = _sized(solver, Objective.max_excess_time, 0.0, explain=True)
        reached_h = largest.objective_value
        if reached_h is None or reached_h >= self.required_h:
            return largest
        for one in _promising(solver)[:1]:
            if one.missed == 0.0 and one.excess_time_h > reached_h:
                again = _sized(solver, Objective.max_excess_time, 0.0, one.design, explain=False)
                return max(largest, again, key=_merit)
        return largest

    def _explained_by_least_missed(self, starts: list[DesignVariables]) -> SizingResult:
        instance, least = self.search.instance, self._least_missed(starts)
        if least is None:
            return self._without_least_missed(starts)
        missed, nearest = least.missed(), self._simulated(least)
        assert nearest.performance is not None
        accepted, margin = not missed or self.search.accepts(nearest), instance.margin
        if accepted or (not self.restarts and max(missed.values()) < margin):
            # What the program asks for beyond the simulator may be all that it misses.
            self.search.instance = replace(instance, margin=_LESS_MARGIN * margin)
            again = self._restarted([least.design, *starts], nearest.performance)
            if accepted or again.feasible:
                return again
        grid = [] if self.rough or self.restarts else _promising(self.solver)
        flying = [one.design for one in grid if one.excess_time_h > 0.0]
        solution = self._solve(flying) if flying else None
        if solution is not None:
            self.restarts += 1
            return self._settled(solution)
        verdict = Verdict(
            SizingStatus.infeasible,
            tuple(violations(self.aircraft, missed, nearest.performance, self.required_h)),
            nearest.performance,
            active_constraints(least, self.day),
        )
        return self._failed(verdict)

    def _without_least_missed(self, starts: list[DesignVariables]) -> SizingResult:
        """Verdict where the solver cannot tell what is missed: a coarse grid may show it."""
        nearest = self.solver.performance(starts[0])
        unlifted = least_unlifted(self.aircraft, self.solver.mission)
        if unlifted <= _HOPELESS:
            return self._restarted(starts, nearest)
        missed = violations(self.aircraft, {"mass_budget": unlifted}, nearest, self.required_h)
        return self._failed(Verdict(SizingStatus.infeasible, tuple(missed), nearest))

    def _least_missed(self, starts: list[DesignVariables]) -> Solution | None:
        """Solution that misses as little as possible, or all but that: by a penalty."""
        instance = self.search.instance.least_missed()
        least = self._solve(starts, instance)
        if least is None and self.missed is not None:
            least = self._solve([], instance, previous=self.missed)
        return least or self._solve(starts, instance, effort="steady") or self.missed

    def _restarted(self, starts: list[DesignVariables], nearest: Performance) -> SizingResult:
        solution = self._solve(starts)
        if solution is None:
            return self._given_up(nearest)
        self.restarts += 1
        if self.restarts > _RESTARTS:
            return self._given_up(self.solver.performance(solution.design))
        return self._settled(solution)

    def _given_up(self, nearest: Performance) -> SizingResult:
        return self._failed(Verdict(SizingStatus.not_converged, (), nearest))

    def _failed(self, verdict: Verdict) -> SizingResult:
        return SizingResult(
            status=verdict.status,
            objective=self.objective,
            required_excess_time_h=self.required_h,
            objective_value=None,
            design=None,
            simulated=None,
            nearest=verdict.nearest,
            active_constraints=verdict.active_constraints,
            violations=verdict.violations,
            solver=self.solver.report(),
        )

    def _optimal(self, solution: Solution, found: Simulated) -> SizingResult:
        assert found.performance is not None
        return SizingResult(
            status=SizingStatus.optimal,
            objective=self.objective,
            required_excess_time_h=self.required_h,
            objective_value=float(objective_value(self.objective, found.performance)),
            design=plain_design(found.performance.design),
            simulated=found.performance,
            nearest=None,
            active_constraints=active_constraints(solution, self.day),
            violations=(),
            solver=self.solver.report(),
            optimum=solution,
        )
