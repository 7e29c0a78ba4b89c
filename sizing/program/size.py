"""The loop around the program: simulate, linearise, solve, until both agree.

The program knows a few scenarios, in the light and under the load of the last design; the simulator
judges every design in all of them. Scenarios that turn out worse than those in the program join it,
and the excess time that the program asks for is shifted by what the simulator finds otherwise. What
counts is the simulator's number: of all designs that it accepts the best is the optimum.
"""

from __future__ import annotations

import math
import time
from collections.abc import Generator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.day.light import UNCORRECTED_CAM, SolarDay, SolarModel, solar_day
from sizing.design import NO_FLIGHT_W, DesignVariables, variables_of
from sizing.mass_budget import ImpossibleDesignError, operating_trouble
from sizing.performance import Performance, performance_of_designs
from sizing.program.climbing import Profile, flight
from sizing.program.corrections import (
    Linearisation,
    Scenario,
    linearised,
    neighbours,
    unserved,
)
from sizing.program.objectives import Objective
from sizing.program.reasons import least_mission, missed_by, names_of_limits, violations
from sizing.program.result import SizingResult, SizingStatus, SolverReport
from sizing.program.solve import LACKING, ActiveSet, Solution, solve
from sizing.program.start import most_promising
from sizing.program.task import SizingTask, Values
from sizing.program.transcription import FIRST_MARGIN
from sizing.program.variables import TOTAL_MASS, Role
from solar.types import FloatArray

BLOCKS = 3  # scenarios in the program
_ROUNDS = 12
_CUSHION_H = 5e-4  # of the goal: what the simulator finds varies by less from round to round
_WASTE = 3e-4  # of the objective: more excess time than required may cost this much
_SAME = 2e-4  # of the objective, from one accepted design to the next
_NEAR = 0.15  # relative change of a design within which its linearisation and its nodes hold
_SHORT_H = 0.3  # excess time that better heights than those of the program may add
_HOPELESS, _HOPELESS_ROUNDS = 0.03, (2, 5)  # violation that no correction mends; rounds given
_NIGHT_H = 8.0  # hours over which a lack of power lacks energy, about


@dataclass(frozen=True)
class Judged:
    """A design that the simulator has judged.

    ``excess_h``: of every scenario. ``merit``: objective, the larger the better. ``climbs``: flight
    at the heights that are best for the design, where those of the program fall short.
    """

    values: dict[str, float]
    perf: Performance
    excess_h: FloatArray
    merit: float
    accepted: bool
    solution: Solution | None
    profiles: Mapping[int, Profile] = field(default_factory=dict)
    climbs: Performance | None = None

    @property
    def worst(self) -> int:
        """Scenario of the least excess time."""
        return int(np.argmin(self.excess_h))


@dataclass
class Search:
    """One search for the optimum of a task, and its outcome.

    ``first``: values to start from, instead of a design whose mass is to be found. ``warm``:
    solution for a similar task, whose multipliers the first program starts from. ``row``: solver
    that is tried first. ``profiles``: heights that are flown, by scenario.
    """

    task: SizingTask
    start: DesignVariables | None = None
    stop_at_merit: float = math.inf
    first: Values | None = None
    warm: Solution | None = None
    row: ActiveSet | None = None
    best: Judged | None = None
    nearest: Judged | None = None
    status: SizingStatus = SizingStatus.not_converged
    report: SolverReport = field(default_factory=SolverReport)
    profiles: dict[int, Profile] = field(default_factory=dict)
    _known: dict[int, Scenario] = field(default_factory=dict)
    _settled: int = 0

    def run(self) -> Search:
        """Search until program and simulator agree."""
        rounds = self.rounds()
        values = next(rounds, None)
        while values is not None:
            try:
                values = rounds.send(self.fly(values))
            except StopIteration:
                values = None
        return self

    def fly(self, values: Values) -> Performance:
        """Simulate a design and its neighbours, with climbs at the heights of the program."""
        return flight(self.task, neighbours(self.task, values), self.profiles)

    def rounds(self) -> Generator[Values, Performance, None]:
        """Search, asking for the flight of every design and its neighbours."""
        values, solution, judged = self._first(), self.warm, None
        reach = math.inf
        for done in range(_ROUNDS):
            judged = yield from self._judged(values, solution if done else None, judged)
            if self._ends(judged, done):
                break
            self._take_in(judged)
            point = linearised(self.task, judged.values, judged.perf, self._known)
            if done > 1 or point.parts is not None:
                reach = min(reach, _REACH)
            worst_h = float(judged.excess_h.min())
            goal_h = self.task.goal_h
            excess_h = goal_h if not self.task.maximises_excess else max(goal_h, min(worst_h, 1e3))
            solution, last = self._solve(replace(point, reach=reach), excess_h, solution), solution
            reach = solution.linearisation.reach
            if done > 1 and not _goes_on(solution, last):
                reach /= 2.0
            self._keep_profiles(solution)
            values = solution.values
        if self.best is not None:
            self.status = SizingStatus.optimal

    def _solve(self, point: Linearisation, excess_h: float, before: Solution | None) -> Solution:
        """Solve the program; where that fails, once more with limited steps."""
        begun, blocks = time.perf_counter(), len(self._known)
        solve_at = partial(
            solve, self.task, blocks=blocks, excess_h=excess_h, before=before, row=self.row
        )
        solutions = [solve_at(point)]
        if not solutions[0].converged and point.reach > _REACH:
            solutions.append(solve_at(replace(point, reach=_REACH)))
        self.report += SolverReport(
            iterations=sum(solution.iterations for solution in solutions),
            time_s=time.perf_counter() - begun,
            solves=len(solutions),
            message=solutions[-1].message,
        )
        return solutions[-1]

    def _keep_profiles(self, solution: Solution) -> None:
        """Keep the heights of a solution, for the next flights of its scenarios."""
        for block, (number, scenario) in enumerate(self._known.items()):
            if self.task.mission.climb is not None and scenario.clock_h is not None:
                scenario.profile = Profile(scenario.clock_h, solution.heights(block))
                self.profiles[number] = scenario.profile

    @property
    def outcome(self) -> Judged | None:
        """Best design, or the nearest where there is none."""
        return self.nearest if self.best is None else self.best

    @property
    def merit(self) -> float:
        """Objective, the larger the better; minus infinity without a design."""
        return -math.inf if self.best is None else self.best.merit

    def _first(self) -> dict[str, float]:
        task = self.task
        if self.first is not None:
            return task.within_bounds(task.held | dict(self.first))
        start = most_promising(task) if self.start is None else self.start
        values = task.first_values(start)
        return values | {TOTAL_MASS: _HEAVY * values["battery_mass_kg"]}

    def _judged(
        self, values: dict[str, float], solution: Solution | None, last: Judged | None
    ) -> Generator[Values, Performance, Judged]:
        """Judge a design; where it cannot fly one nearer to the last, or first the file's own."""
        judged = self._judge(values, solution, (yield values))
        if _flies(judged.perf):
            return judged
        if last is None:
            own = self.task.first_values(variables_of(self.task.aircraft))
            own |= {TOTAL_MASS: values[TOTAL_MASS]}
            return self._judge(own, solution, (yield own))
        for part in _NEARER:
            between = {name: one + part * (values[name] - one) for name, one in last.values.items()}
            judged = self._judge(between, solution, (yield between))
            if _flies(judged.perf):
                break
        return judged

    def _judge(
        self,
        values: dict[str, float],
        solution: Solution | None,
        perf: Performance,
    ) -> Judged:
        """Judge a design by its flight."""
        task = self.task
        excess_h = np.array(np.asarray(perf.cycle.excess_time_h, float)[0])
        mass_kg = float(np.asarray(perf.design.total_mass_kg)[0])
        if math.isfinite(mass_kg):
            values = {**values, TOTAL_MASS: mass_kg}
        short = 0.0 < task.required_h - excess_h.min() < _SHORT_H and _flies(perf)
        climbs = None
        if task.mission.climb is not None and solution is not None and short:
            # Heights of the program are no more than a proposal: the best for the design count.
            it, design = task.eased(values), task.design_variables(values)
            climbs = performance_of_designs(it.flown, it.mission, design, it.solar, day=it.day)
            excess_h = np.maximum(excess_h, climbs.cycle.excess_time_h)
        worst_h = float(excess_h.min())
        accepted = worst_h > 0.0 and worst_h >= task.required_h and task.meets(values, perf)
        judged = Judged(
            values,
            perf,
            excess_h,
            float(np.ravel(task.merit(values, perf))[0]),
            accepted,
            solution,
            dict(self.profiles),
            climbs,
        )
        if accepted and (self.best is None or judged.merit > self.best.merit):
            before = -math.inf if self.best is None else self.best.merit
            self._settled += judged.merit - before < _SAME * max(abs(before), 1e-3)
            self.best = judged
        elif accepted:
            self._settled += 1
        if solution is not None or self.nearest is None:
            self.nearest = judged
        return judged

    def _ends(self, judged: Judged, number: int) -> bool:
        """Whether nothing better is to be expected."""
        solution, task = judged.solution, self.task
        if not _flies(judged.perf):
            self.status = SizingStatus.infeasible
            return True
        if judged.accepted and judged.merit >= self.stop_at_merit:
            return True
        if solution is None:
            return False
        if solution.violation > LACKING:
            early, late = _HOPELESS_ROUNDS
            known = number >= early or _moved_by(task, solution) < _NEAR
            if number >= late or (known and solution.violation > _HOPELESS):
                self.status = SizingStatus.infeasible
                return True
            return False
        if not judged.accepted:
            return False
        near = _moved_by(task, solution) < _NEAR
        waste_h = float(judged.excess_h.min()) - task.required_h
        known = near and judged.worst in self._known and not task.maximises_excess
        wasted = waste_h * solution.cost_of_hour()
        if task.window_h is not None:
            wasted += _left_h(judged.perf, judged.worst)[1] * solution.cost_of_hour(on_way=True)
        if known and (task.continuous or wasted < _WASTE):
            return True
        return self._settled >= 2

    @property
    def solution(self) -> Solution | None:
        """Solution of the best design, else of the nearest; of a start the first one from it."""
        best = None if self.best is None else self.best.solution
        return best or (None if self.nearest is None else self.nearest.solution)

    def _take_in(self, judged: Judged) -> None:
        """Correct what the program asks for, and exchange its scenarios."""
        if judged.solution is not None:
            for block, (number, scenario) in enumerate(self._known.items()):
                self._correct(judged, judged.solution, block, number, scenario)
        order = [int(i) for i in np.argsort(judged.excess_h, kind="stable")]
        blocks = min(BLOCKS, self.task.count)
        if not self._known:
            self._known = {number: Scenario() for number in order[:blocks]}
        elif judged.worst not in self._known:
            easiest = max(self._known, key=lambda number: float(judged.excess_h[number]))
            del self._known[easiest]
            self._known[judged.worst] = Scenario(profile=self.profiles.get(judged.worst))

    def _correct(
        self, judged: Judged, solution: Solution, block: int, number: int, scenario: Scenario
    ) -> None:
        """Correct the goal of one scenario by what the simulator finds for the last solution."""
        task, simulated_h = self.task, float(judged.excess_h[number])
        scenario.shift_h = solution.shift_h(block)
        if _moved_by(task, solution) > _NEAR and scenario.profile is None:
            scenario.nodes = None
        if task.window_h is not None:
            simulated_h, way_h = _left_h(judged.perf, number)
            if way_h < 0.0 or solution.excess_multiplier(block, on_way=True) > LACKING:
                scenario.way_h = max(scenario.way_h + _CUSHION_H - way_h, 0.0)
        if task.continuous and simulated_h > 0.0:
            return
        if simulated_h > 0.0 and math.isfinite(simulated_h):
            scenario.margin = max(FIRST_MARGIN, scenario.margin / 2.0)
            reserve_h = solution.reserve_h(block)
            lacking_h = float(solution.lack[block]) * (_NIGHT_H + reserve_h)
            scenario.shift_h += reserve_h - lacking_h - simulated_h + _CUSHION_H
        elif solution.violation <= LACKING and _moved_by(task, solution) < _NEAR:
            scenario.margin += FIRST_MARGIN + unserved(task, judged.perf, number)


def _goes_on(solution: Solution, last: Solution | None) -> bool:
    """Tell whether a step is as long as allowed, and in the direction of the last one."""
    if last is None:
        return False
    as_far = float(np.abs(solution.step).max()) > 0.99 * solution.linearisation.reach
    return as_far and float(solution.step @ last.step) > 0.0


def _left_h(perf: Performance, number: int) -> tuple[float, float]:
    """How long what is left at the landing lasts, and what is left or lacking on the way."""
    cycle, store = perf.cycle, perf.store
    nominal_w = np.broadcast_to(perf.nominal_load_w, cycle.status.shape)[0, number]
    full_wh = np.ravel(store.battery_energy_wh)[0]
    lowest_wh = cycle.minimum_state_of_charge[0, number] * full_wh * store.discharge_efficiency
    lacking_wh = cycle.energy_budget.unserved_wh[0, number]
    landing_wh = cycle.energy_wh[0, number, -1] * store.discharge_efficiency
    return float(landing_wh / nominal_w), float((lowest_wh - lacking_wh) / nominal_w)


# Logarithm of a size over which derivatives hold, of propulsion parts from the first round on; from
# the third on halved by every step that is shorter or turns back, so that rounds end.
_REACH = 0.5
# Parts of a step that leads to where nothing flies.
_NEARER = (0.5, 0.25, 0.1)
_HEAVY = 3.0  # of the battery's mass: total mass of a design whose budget does not close


def _flies(perf: Performance) -> bool:
    """Whether the first design of a batch carries its own mass."""
    mass_kg = float(np.asarray(perf.design.total_mass_kg)[0])
    load_w = np.ravel(np.asarray(perf.nominal_load_w))[0]
    return math.isfinite(mass_kg) and bool(load_w < NO_FLIGHT_W / 2.0)


def _moved_by(task: SizingTask, solution: Solution) -> float:
    """Largest relative change of a size or the mass of a design by a solution.

    A payload is a part of the mass, or of the load.
    """
    before, after = solution.linearisation.values, solution.values
    sizes = [v.name for v in task.variables if v.role is Role.design]
    pairs = [(before[name], after[name]) for name in sizes]
    changes = [abs(math.log(a / b)) for b, a in pairs if a > 0.0 and b > 0.0]
    power_w = after["payload_power_w"] - before["payload_power_w"]
    return max(abs(power_w) / solution.linearisation.load_w, *changes)


def size_aircraft(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective = Objective.max_excess_time,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    required_excess_time_h: float | None = None,
    day: SolarDay | None = None,
    start: DesignVariables | None = None,
    explain: bool = True,
    stop_at_merit: float = math.inf,
    bounds: Mapping[str, tuple[float, float]] | None = None,
) -> SizingResult:
    """Find the best design of a parametric aircraft for a mission, or say why there is none.

    ``required_excess_time_h``: of every scenario, instead of the mission's own. ``day``: light in
    the scenarios, where it is known already. ``start``: first guess, for instance the optimum of a
    similar mission. ``explain``: whether to find out why a search fails, and to make sure that it
    had to. ``stop_at_merit``: objective, the larger the better, that will do. ``bounds``: of
    variables, in their unit, instead of those of the design space; equal ones hold.
    """
    if not isinstance(aircraft.airframe, ParametricAirframe):
        raise TypeError(f"{aircraft.name} is a measured aircraft: it has no mass budget to size")
    if objective.of_range:
        raise ValueError(f"{objective.value} is a range of days or latitudes: use widest_range")
    required_h = mission.required_excess_time_h
    if required_excess_time_h is not None:
        required_h = required_excess_time_h
    light = solar_day(aircraft, mission, solar) if day is None else day
    task = SizingTask(
        *(aircraft, mission, objective, solar, light, required_h), bounds=bounds or {}
    )
    search = searched(task, start, stop_at_merit)
    if explain and search.best is None and aircraft.propulsion_by_parts is not None:
        _check_parts(searched(task.with_values(beyond_limits=True), start))
    result = _explained(search) if explain and search.best is None else _result(search)
    if result.simulated is not None and mission.holds_station:
        _check_held(task, result.simulated)
    return result


def _check_held(task: SizingTask, flown: Performance) -> None:
    """Refuse parts that cannot hold the wind: a search knows them near the own airspeed alone."""
    loads_w = np.asarray(flown.nominal_load_w)
    if task.aircraft.propulsion_by_parts is not None and np.any(loads_w > NO_FLIGHT_W / 2.0):
        wind, mission = np.max(task.winds_m_per_s), task.mission
        raise ImpossibleDesignError(
            f"the propulsion of {task.aircraft.name} cannot hold the wind of {wind:.3g} m/s on "
            f"{mission.name} at {mission.altitude_m:g} m, though its rated power would: give it "
            "other parts, or ask for less wind"
        )


def _check_parts(search: Search) -> None:
    """Refuse parts that cannot do the level flight of a design that is enough without their limits.

    ``search``: beyond the limits of the parts.
    """
    task, judged = search.task, search.best or search.nearest
    if judged is None or (search.best is None and _flies(judged.perf)):
        return
    design = task.design_variables(judged.values)
    if reason := operating_trouble(task.aircraft, task.mission, design):
        raise ImpossibleDesignError(reason)


def searched(
    task: SizingTask, start: DesignVariables | None = None, stop_at_merit: float = math.inf
) -> Search:
    """Outcome of the searches for a task: by the battery, and by a sun that never sets."""
    searches = []
    lowest = task.day.specific_power_w_per_m2.min(axis=-1)
    by_day = task.window_h is None and lowest.min() > 0.0
    if by_day and (task.required_h > 0.0 or task.maximises_excess):
        searches.append(Search(task.with_values(continuous=True), start, stop_at_merit).run())
    unlimited = searches and searches[0].best and np.isinf(searches[0].best.excess_h).all()
    if not (task.maximises_excess and unlimited):
        searches.append(Search(task, start, stop_at_merit).run())
    best = max(searches, key=lambda one: one.merit)
    found = best if best.best is not None else searches[-1]
    found.report = sum((one.report for one in searches), SolverReport())
    return found


def _result(search: Search) -> SizingResult:
    """Outcome of a search."""
    task, best = search.task, search.best
    solution = search.solution
    result = SizingResult(
        status=search.status,
        objective=task.objective,
        required_excess_time_h=task.required_h,
        active_constraints=() if solution is None else names_of_limits(solution),
        solver=search.report,
    )
    if best is None:
        nearest = None if search.nearest is None else _flown(task, search.nearest)
        return replace(result, nearest=nearest)
    return replace(result.with_design(_flown(task, best)), optimum=solution)


def _flown(task: SizingTask, judged: Judged) -> Performance:
    """Flight of a design without its neighbours."""
    if judged.accepted and judged.climbs is not None:
        return judged.climbs
    if task.mission.climb is not None:
        return flight(task, [judged.values], judged.profiles).of_designs(0)
    design = task.design_variables(judged.values)
    return performance_of_designs(task.aircraft, task.mission, design, task.solar, day=task.day)


def _explained(search: Search) -> SizingResult:
    """Why a search has found no design, or the design after all.

    A required excess time is held against the largest one that any design has: the same program,
    with the required time free.
    """
    task, report, source = search.task, search.report, search
    if task.required_h > 0.0:
        mission = least_mission(task.aircraft, task.mission, task.objective)
        easiest = task.with_values(
            mission=mission, objective=Objective.max_excess_time, required_h=0.0
        )
        near = search.nearest
        start = None if near is None else easiest.design_variables(near.values)
        largest = searched(easiest, start)
        report += largest.report
        if largest.best is not None and largest.best.excess_h.min() >= task.required_h:
            # With no more payload than that design has, so that it is one of this task as well.
            enough = largest.best.values
            carried = {name: enough[name] for name in task.free_names if name in enough}
            again = searched(task, easiest.design_variables(enough)._replace(**carried))
            again.report += report
            return _result(again)
        if largest.best is not None or largest.status is SizingStatus.infeasible:
            source = largest
    result = replace(
        _result(source),
        objective=task.objective,
        required_excess_time_h=task.required_h,
        solver=report,
    )
    if result.status is SizingStatus.not_converged:
        return result
    nearest = result.nearest if result.simulated is None else result.simulated
    assert nearest is not None
    missed = {} if result.feasible else missed_by(source.task, source.solution, nearest)
    short_h = task.required_h - float(np.min(nearest.cycle.excess_time_h))
    if task.required_h > 0.0 and short_h > 0.0 and math.isfinite(short_h):
        missed["excess_time"] = short_h
    found = violations(task, nearest, missed)
    return result.without_design(SizingStatus.infeasible, nearest, *found)
