"""Sizing: the best wingspan, battery mass and module area for a mission, or why there is none.

A sizing says where its search starts (:mod:`sizing.optimisation.loop`), tries the branches that a
midnight sun opens, and where there is no design it finds out why.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, lru_cache
from operator import attrgetter

from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.design import DesignVariables, variables_of
from sizing.limits import meets_requirements
from sizing.optimisation.energy_constraints import growing_lit_sets, lowest_power
from sizing.optimisation.infeasibility import (
    least_mission,
    least_unlifted,
    promising_designs,
    short_of_largest_excess,
    violations,
)
from sizing.optimisation.loop import (
    PENALTY,
    Accepted,
    Search,
    Simulated,
    run,
    spare_sun,
    telling_scenarios,
)
from sizing.optimisation.problem import SizingProblems
from sizing.optimisation.result import (
    RELATIVE_TOLERANCE,
    ProblemInstance,
    SizingResult,
    SizingStatus,
    Solution,
    active_constraints,
    limiting_rows,
    merit_of,
)
from sizing.optimisation.solver import ProgramSolver
from sizing.optimisation.solver_options import Effort
from sizing.parameters import with_parameter
from sizing.performance import Performance
from sizing.program.objectives import Objective
from sizing.sunlight import UNCORRECTED_CAM, SolarDay, SolarModel, solar_day

# Scenarios that a program starts with; others join when the simulator finds them worse.
_FIRST_BLOCKS = 3
_MARGIN_COST = 0.003  # of the objective, relative
_PLAIN = 30.0  # cost of what is missed that no gain of any objective repays
_NEXT_TO_NOTHING = 1e-3  # of a payload [kg, W]
_RESTARTS = 3
_LESS_MARGIN = 1.0 / 30.0
# Part of its mass that no design of a coarse grid lifts: those between its points gain less.
_HOPELESS = 1.0


def size_aircraft(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective = Objective.max_excess_time,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    required_excess_time_h: float | None = None,
    day: SolarDay | None = None,
    problems: SizingProblems | None = None,
    start: DesignVariables | None = None,
    explain: bool = True,
    enough_h: float = math.inf,
) -> SizingResult:
    """Find the best design of a parametric aircraft for a mission.

    ``aircraft``: technology, bounds of the design variables, and a first guess (its own design
    point). ``objective``: of one design; for a range of days or latitudes see
    :func:`sizing.program.ranges.widest_range`. ``required_excess_time_h``: of every
    scenario, instead of the mission's own [h]. ``day``: specific power of the scenarios where it is
    known already. ``problems``: programs of this very aircraft, from an earlier sizing: nothing is
    built again. ``start``: first guess, for instance the optimum of a similar mission. ``explain``:
    whether to find out why a search fails. If not, it ends as ``not_converged``: faster, for
    searches in which failures are many and their reasons idle. ``enough_h``: excess time that will
    do [h]: the search takes shortcuts, and ends at the first design that has it.
    """
    solver, required = _solver_of(
        *(aircraft, mission, objective, solar, required_excess_time_h, day, problems, start)
    )
    return _sized(solver, objective, required, start, explain=explain, enough_h=enough_h)


def unjudged_optimum(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel,
    *,
    required_excess_time_h: float | None = None,
) -> Solution | None:
    """Optimum of the program that a sizing begins with; None where it has none.

    The simulator may find it wanting, and other scenarios worse: it is near the sizing's own.
    """
    solver, required = _solver_of(aircraft, mission, objective, solar, required_excess_time_h)
    return _Sizing(solver, objective, required).first_solution()


def _solver_of(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel,
    required_h: float | None,
    day: SolarDay | None = None,
    problems: SizingProblems | None = None,
    start: DesignVariables | None = None,
) -> tuple[ProgramSolver, float]:
    """Solver of an aircraft's programs for a mission, and the excess time required [h].

    The flow that cools the modules is that of the first guess with the payload of ``start``.
    """
    problems = checked_problems(aircraft, objective, problems)
    required = mission.required_excess_time_h if required_h is None else required_h
    sunlit = day
    if sunlit is None:
        carrying = mission
        if start is not None and start.payload_mass_kg is not None:
            payload_kg = float(start.payload_mass_kg)
            _, carrying = with_parameter(aircraft, mission, "mission.payload.mass_kg", payload_kg)
        sunlit = solar_day(aircraft, carrying, solar)
    return ProgramSolver(problems, mission, solar, sunlit, by_model=day is None), required


def size_branch(
    solver: ProgramSolver,
    objective: Objective,
    required_h: float,
    start: DesignVariables,
    sunlit: Sequence[int],
) -> SizingResult:
    """Best design of the branch in which some scenarios are always lit."""
    return _Sizing(solver, objective, required_h, start, explain=False, sunlit=sunlit).run()


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

    def branch(sunlit: list[int]) -> _Sizing:
        return _Sizing(*given, explain=False, enough_h=enough_h, sunlit=sunlit)

    results: list[SizingResult] = []
    if len(lit_sets[-1]) == count:
        results.append(branch(lit_sets.pop()).run())
        # No excess time is longer than an unlimited one.
        if best_excess and results[0].feasible:
            return results[0]
    by_battery = one = branch([])
    results.append(without_lit := one.run())
    place = one.next_of(lit_sets, -1)
    while place is not None and place < len(lit_sets) and results[-1].merit < enough_h:
        one = branch(lit_sets[place])
        results.append(one.run())
        place = one.next_of(lit_sets, place)
    best = max(results, key=attrgetter("merit"))
    if not best.feasible:
        return by_battery.explained() if explain else without_lit
    return replace(best, solver=solver.work)


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
        sunlit: Sequence[int] = (),
    ) -> None:
        self.explain, self.enough_h, self.sunlit = explain, enough_h, list(sunlit)
        self.solver, self.aircraft, self.day = solver, solver.aircraft, solver.day
        self.objective, self.required_h = objective, required_h
        # That of another sizing may hold arrays.
        self.start = (variables_of(self.aircraft) if start is None else start).mapped(float)
        self.restarts = 0
        self.last: Solution | None = None
        self.missed: Solution | None = None
        self.largest: Accepted | None = None  # design of largest excess time, if it is enough

    def run(self) -> SizingResult:
        self.search = self._begun()
        # With a penalty the program says soonest that nothing meets all requirements.
        solution = self._solve([self.start], self.search.instance.penalised(PENALTY))
        nearly = self.solver.nearly
        if nearly is not None and self.rough:
            solution = self._all_but_met(nearly)
            if solution is None:
                return self._failure(self.first)
        if solution is None:
            solution = self._solve([self.start])
        elif solution.missed():
            self.missed = solution
            if self.explain:
                return self.explained()
            plain = solution.cost_of_missing() > _PLAIN
            solution = None if plain else self._met_after_all(solution)
        return self._failure(self.first) if solution is None else self._settled(solution)

    def first_solution(self) -> Solution | None:
        """Optimum of the first program, which no simulation has judged."""
        self.search = self._begun()
        return self._solve([self.start])

    def _begun(self) -> Search:
        count = len(self.day.scenarios)
        first = self._first_scenarios(min(_FIRST_BLOCKS, count))
        return Search(self._instance(), self.required_h, first, self._solve_again, count=count)

    @property
    def rough(self) -> bool:
        """Whether a design will do that is good enough: one at a kink need not be the best."""
        return math.isfinite(self.enough_h)

    @cached_property
    def first(self) -> Performance:
        """What the simulator finds for the design that the search starts from."""
        return _start_flown(self.solver, self.start, coarse=self.rough)

    def explained(self) -> SizingResult:
        """Why a run has found no design; or the design, after all."""
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
        } - set(self.sunlit)
        places = range(place + 1, len(lit_sets))
        return next((i for i in places if not limiting.isdisjoint(lit_sets[i])), None)

    def _instance(self) -> ProblemInstance:
        instance = ProblemInstance.of(self.objective, self.required_h)
        everywhere = len(self.sunlit) == len(self.day.scenarios)
        return instance.always_lit(self.sunlit, all_of_them=everywhere)

    def _first_scenarios(self, count: int) -> list[int]:
        """Scenarios to begin with; of those that must be always lit, the one with the least sun."""
        if count == len(self.day.scenarios):
            return list(range(count))
        if not self.sunlit:
            return telling_scenarios(self.first, count)
        telling = telling_scenarios(self.first, len(self.day.scenarios))
        others = [i for i in telling if i not in self.sunlit]
        return list(dict.fromkeys([*others[:1], self.sunlit[-1], *others, *telling]))[:count]

    def _solve(
        self,
        starts: Sequence[DesignVariables],
        instance: ProblemInstance | None = None,
        *,
        effort: Effort = "quick",
        previous: Solution | None = None,
    ) -> Solution | None:
        search = self.search
        solution = self.solver.solve(
            search.instance if instance is None else instance,
            search.filled(),
            starts,
            efforts=(effort,),
            previous=previous,
        )
        self.last = solution or self.last
        return solution

    def _solve_again(self, search: Search) -> Solution | None:
        """Solution from the last one's design, or from that of largest excess time."""
        assert search.previous is not None
        starts = [search.previous.design]
        starts += [] if self.largest is None else [self.largest.solution.design]
        # With climbs there are several optima: the program is held to the one that it has chosen.
        previous = search.previous if search.previous.climbs else None
        solution = None
        if previous is not None and search.afresh:
            previous = replace(previous, rival=-math.inf)  # in another light another may be better
        else:
            solution = self._solve(starts, previous=previous)
        if solution is not None:
            return solution
        if self.rough or previous is not None:
            # With a penalty interior points may end at a kink.
            soft = self._solve(starts, search.instance.penalised(PENALTY), previous=previous)
            soft = soft or self.solver.nearly
            if soft is not None and not soft.missed():
                return soft
        return None if self.rough else self._solve(starts, effort="steady")

    def _met_after_all(self, solution: Solution) -> Solution | None:
        """Solution where the penalty was too low to keep a requirement from being missed."""
        instance = self.search.instance.least_missed()
        least = self._solve([solution.design], instance, previous=solution)
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

    def _simulated(self, solution: Solution) -> Simulated:
        """What the simulator finds for one solution."""
        perf = self.solver.performance(solution.design)
        sound = bool(meets_requirements(self.aircraft, self.solver.mission, perf.design))
        excess_h = self.solver.least_excess_h(perf, self.required_h)
        merit = float(merit_of(self.objective, perf))
        spare = spare_sun(perf, solution.instance.sunlit)
        sun = self.solver.flown_sun(perf, solution)
        climbed = None if perf.levels is None else dict(enumerate(perf.climbed().tolist()))
        return Simulated(excess_h, perf.worst_scenario(), merit, sound, perf, spare, sun, climbed)

    def _settled(self, solution: Solution) -> SizingResult:
        """Best design that the simulator accepts, from a first solution on."""
        self.search.previous, self.search.solution = None, solution
        self._run()
        best = None if self.search.best is None else self.search.best.solution
        costs = best is not None and best.cost(0.0, best.instance.margin) > _MARGIN_COST
        if best is not None and costs and not (best.climbs and self.search.knows_margin):
            margin = best.instance.margin * _LESS_MARGIN
            self.search.instance = replace(best.instance, margin=margin)
            self.search.previous, self.search.solution = best, None
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
        ends = {"rel_tol": RELATIVE_TOLERANCE, "abs_tol": _NEXT_TO_NOTHING}
        return all(math.isclose(own[name], short[name], **ends) for name in own)

    # --- verdicts ----------------------------------------------------------------------------

    def _failure(self, nearest: Performance) -> SizingResult:
        if not self.explain:
            return self._given_up(nearest)

        def grid() -> list[DesignVariables]:
            if self.rough:
                return [self.start if self.last is None else self.last.design]
            return [one.design for one in promising_designs(self.solver)] or [
                variables_of(self.aircraft)
            ]

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
        if mission is own.mission:
            solver.unreached = own.unreached
        largest = self._largest_excess(solver)
        own.work += solver.work
        short = short_of_largest_excess(self.aircraft, largest, self.required_h)
        if short is not None:
            return self._as_asked(short)
        assert largest.simulated is not None
        assert largest.optimum is not None
        if self.objective is Objective.max_excess_time:
            return self._as_asked(largest)
        self.sunlit = sorted(largest.optimum.instance.sunlit)
        self.search.instance = self._instance()
        # Its own time step judges it: no finer one takes back what the largest excess time allows.
        simulated = self._simulated(largest.optimum)
        self.largest = Accepted(largest.optimum, simulated._replace(excess_time_h=largest.merit))
        self.search.begin_below(self.largest)
        nearest = largest.simulated.design.variables.mapped(float)
        return self._restarted([nearest, *starts()], largest.simulated)

    def _largest_excess(self, solver: ProgramSolver) -> SizingResult:
        """Sizing for the largest excess time; too short a one is held against other designs.

        Those are the search's last one and a grid.
        """
        largest = _sized(solver, Objective.max_excess_time, 0.0, explain=True)
        if not largest.feasible or largest.merit >= self.required_h:
            return largest
        others = [
            (one.excess_time_h, one.design)
            for one in promising_designs(solver)[:1]
            if one.missed == 0.0
        ]
        if self.last is not None:
            flown = solver.performance(self.last.design)
            others.append((float(flown.cycle.excess_time_h.min()), self.last.design))
        for excess_h, start in others:
            if excess_h > largest.merit:
                again = _sized(solver, Objective.max_excess_time, 0.0, start, explain=False)
                largest = max(largest, again, key=attrgetter("merit"))
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
        grid = [] if self.rough or self.restarts else promising_designs(self.solver)
        flying = [one.design for one in grid if one.excess_time_h > 0.0]
        solution = self._solve(flying) if flying else None
        if solution is not None:
            self.restarts += 1
            return self._settled(solution)
        active = active_constraints(least, self.day)
        return self._infeasible(missed, nearest.performance, active)

    def _without_least_missed(self, starts: list[DesignVariables]) -> SizingResult:
        """Verdict where the solver cannot tell what is missed: a coarse grid may show it."""
        nearest = self.solver.performance(starts[0])
        unlifted = least_unlifted(self.aircraft, self.solver.mission)
        if unlifted <= _HOPELESS:
            return self._restarted(starts, nearest)
        return self._infeasible({"mass_budget": unlifted}, nearest)

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
        return replace(self._result(), nearest=nearest)

    def _infeasible(
        self, missed: Mapping[str, float], nearest: Performance, active: tuple[str, ...] = ()
    ) -> SizingResult:
        found = violations(self.aircraft, missed, nearest, self.required_h, active)
        return self._result(active).without_design(SizingStatus.infeasible, nearest, *found)

    def _optimal(self, solution: Solution, simulated: Simulated) -> SizingResult:
        assert simulated.performance is not None
        active = active_constraints(solution, self.day)
        return replace(self._result(active), optimum=solution).with_design(simulated.performance)

    def _result(self, active: tuple[str, ...] = ()) -> SizingResult:
        return SizingResult(
            status=SizingStatus.not_converged,
            objective=self.objective,
            required_excess_time_h=self.required_h,
            active_constraints=active,
            solver=self.solver.work,
        )

    def _as_asked(self, result: SizingResult) -> SizingResult:
        """Sizing for another objective as the verdict on this one."""
        return replace(
            result,
            objective=self.objective,
            required_excess_time_h=self.required_h,
            solver=self.solver.work,
        )
