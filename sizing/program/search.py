"""The loop around the program: simulate, linearise, solve, until both agree.

The program has a few scenarios, in the light and under the load of the last design; the simulator
judges every design in all of them. Scenarios that turn out worse than those in the program join it,
and the excess time that the program requires is shifted by what the simulator finds otherwise. What
counts is the simulator's number: of all designs that it accepts the best is the optimum.
"""

from __future__ import annotations

import math
import time
from collections.abc import Generator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from sizing.design import NO_FLIGHT_W, variables_of
from sizing.mass_budget import closed_design
from sizing.performance import Performance, fly
from sizing.program.climbing import Profile, simulate
from sizing.program.corrections import (
    CUSHION_H,
    Linearisation,
    Scenario,
    linearised,
    neighbours,
    unserved,
)
from sizing.program.result import SizingStatus, SolverReport
from sizing.program.solve import LACKING, ActiveSet, Solution, solve
from sizing.program.start import most_promising
from sizing.program.task import SizingTask, Values
from sizing.program.transcription import FIRST_MARGIN
from sizing.program.variables import TOTAL_MASS
from solar.types import FloatArray, IntArray

MOST_BLOCKS = 3  # scenarios in the program: those that hold a design back are few
_MOST_ROUNDS = 12  # a search that has not ended by then goes to and fro
# Of the objective: a search ends where no more is left to gain. With climbs, whose best heights are
# known to half a per cent, rounds go to and fro by less than the latter.
_TOLERANCE, _OF_CLIMBS = 3e-4, 2e-3
_NEAR = 0.15  # relative change of a design within which its linearisation holds
# Logarithm of a size over which derivatives hold, of propulsion parts from the first round on; half
# of a step that turns back.
_REACH = 0.5
_LEAST_REACH = 1e-3


class Flights(NamedTuple):
    """What a search asks of the simulator: flights of a design and its neighbours.

    ``best_in``: instead the design alone in some scenarios, along its best heights.
    """

    values: Values
    best_in: IntArray | None = None


@dataclass(frozen=True)
class JudgedDesign:
    """A design that the simulator has judged.

    ``perf``: of the design and its neighbours, with climbs at the heights ``profiles`` of the
    program. ``best_climbs``: whether some of those are insufficient, and the best were looked for.
    ``excess_h``: of every scenario. ``merit``: objective, the larger the better.
    """

    task: SizingTask
    values: dict[str, float]
    perf: Performance
    excess_h: FloatArray
    merit: float
    accepted: bool
    solution: Solution | None
    profiles: Mapping[int, Profile]
    best_climbs: bool

    @property
    def worst(self) -> int:
        """Scenario of the least excess time."""
        return int(np.argmin(self.excess_h))

    @cached_property
    def flight(self) -> Performance:
        """Flight of the design without its neighbours.

        Where it was accepted for its best climbs along these, but in scenarios for which heights of
        the program are enough, and those that are found best are not.
        """
        task, proposed = self.task, self.perf.of_designs(0)
        if not (self.accepted and self.best_climbs):
            return proposed
        best = fly(task.simulated_aircraft, task.mission, task.solar, proposed.design, task.day)
        short = ~task.is_enough(best.cycle.excess_time_h[:, np.newaxis])
        return best.replaced_in(short, proposed) if short.any() else best

    @property
    def best_profiles(self) -> dict[int, Profile]:
        """Heights of the flight, by scenario; none of level flight."""
        task, altitude_m = self.task, self.flight.altitude_m
        if altitude_m is None or task.climb_height_m == 0.0:
            return {}
        share = (altitude_m - task.mission.altitude_m) / task.climb_height_m
        return {number: Profile(task.day.time_h, row) for number, row in enumerate(share)}

    @property
    def flies(self) -> bool:
        """Whether the design carries its own mass."""
        mass_kg = float(np.asarray(self.perf.design.total_mass_kg)[0])
        load_w = np.ravel(np.asarray(self.perf.nominal_load_w))[0]
        return math.isfinite(mass_kg) and bool(load_w < NO_FLIGHT_W / 2.0)


@dataclass
class Search:
    """One search for the optimum of a task, and its outcome.

    ``first``: values to start from; those of the most promising design of a grid where there are
    none. ``scenarios``: what is known of those that are or were in the program. ``warm``: solution
    for a similar task, whose multipliers the first program starts from. ``active_set``: solver that
    is tried first. ``in_the_dark``: whether the nearest design is looked for where there is no sun.
    """

    task: SizingTask
    first: Values | None = None
    stop_at_merit: float = math.inf
    scenarios: dict[int, Scenario] = field(default_factory=dict)
    warm: Solution | None = None
    active_set: ActiveSet | None = None
    in_the_dark: bool = False
    best: JudgedDesign | None = None
    nearest: JudgedDesign | None = None
    status: SizingStatus = SizingStatus.not_converged
    report: SolverReport = field(default_factory=SolverReport)
    _blocks: list[int] = field(default_factory=list)
    _rounds_without_gain: int = 0
    _rounds_unmended: int = 0
    _violation: float = math.inf

    def run(self) -> Search:
        """Search until program and simulator agree."""
        rounds = self.rounds()
        needed: Flights | None = next(rounds)
        while needed is not None:
            perf = self._simulated(needed)
            try:
                needed = rounds.send(perf)
            except StopIteration:
                needed = None
        return self

    def _simulated(self, needed: Flights) -> Performance:
        task, values = self.task, needed.values
        if needed.best_in is None:
            return simulate(task, neighbours(task, values), self.profiles)
        design = closed_design(task.simulated_aircraft, task.mission, task.stacked([values]))
        day = task.day.at(needed.best_in)
        return fly(task.simulated_aircraft, task.mission, task.solar, design, day)

    def rounds(self) -> Generator[Flights, Performance, None]:
        """Search, yielding every design whose flights are needed."""
        task, solution, judged, reach = self.task, self.warm, None, math.inf
        if self.first is None:
            values = task.first_values(most_promising(task))
        else:
            values = task.within_bounds(task.held | dict(self.first))
        # Of climbs the heights are chosen anew, and turn back as they like.
        level = task.mission.climb is None
        for number in range(_MOST_ROUNDS):
            judged = yield from self._flying(values, solution if number else None, judged)
            if self._ends(judged) or number == _MOST_ROUNDS - 1:
                break
            self._learn_from(judged)
            point = linearised(task, judged.values, judged.perf, self._known)
            last = judged.solution
            if last is not None and last.linearisation.known.keys() != self._known.keys():
                last, reach = None, math.inf  # steps in other scenarios tell nothing of these
            if number > 1 or point.parts is not None:
                reach = min(reach, _REACH)
            if level and last and not judged.accepted and last.violation <= LACKING:
                # It promised more than its flight holds.
                reach = max(min(reach, last.stride / 2.0), _LEAST_REACH)
            solution = self._solved(replace(point, reach=reach), judged, solution)
            reach = solution.linearisation.reach
            if level and last is not None and float(solution.step @ last.step) < 0.0:
                reach = max(min(reach, solution.stride) / 2.0, _LEAST_REACH)
            elif solution.is_limited:  # and goes on
                reach *= 2.0
            values = solution.values
        if self.best is not None:
            self.status = SizingStatus.optimal

    @property
    def profiles(self) -> dict[int, Profile]:
        """Heights along which designs are simulated, by scenario."""
        known = self.scenarios.items()
        return {n: it.profile for n, it in known if it.profile is not None}

    @property
    def outcome(self) -> JudgedDesign | None:
        """Best design, or the nearest where there is none."""
        return self.nearest if self.best is None else self.best

    @property
    def merit(self) -> float:
        """Objective, the larger the better; minus infinity without a design."""
        return -math.inf if self.best is None else self.best.merit

    @property
    def solution(self) -> Solution | None:
        """Solution of the best design, else of the nearest; of a start the first one from it."""
        best = None if self.best is None else self.best.solution
        return best or (None if self.nearest is None else self.nearest.solution)

    @property
    def _tolerance(self) -> float:
        """Part of the objective that a round must gain."""
        return _TOLERANCE if self.task.mission.climb is None else _OF_CLIMBS

    @property
    def _known(self) -> dict[int, Scenario]:
        """Scenarios in the program, in the order of its blocks."""
        return {number: self.scenarios[number] for number in self._blocks}

    def _solved(
        self, point: Linearisation, judged: JudgedDesign, before: Solution | None
    ) -> Solution:
        """Solve the program around a design; where that fails, once more with limited steps.

        The heights of the solution become those of its scenarios.
        """
        task, begun_s = self.task, time.perf_counter()
        worst_h, excess_h = float(judged.excess_h.min()), self.task.goal_h
        if task.maximises_excess and math.isfinite(worst_h):
            excess_h = max(excess_h, worst_h)
        solve_at = partial(
            solve, task, excess_h=excess_h, before=before, active_set=self.active_set
        )
        solutions = [solve_at(point)]
        if not solutions[0].converged and point.reach > _REACH:
            solutions.append(solve_at(replace(point, reach=_REACH)))
        self.report += SolverReport(
            iterations=sum(solution.iterations for solution in solutions),
            time_s=time.perf_counter() - begun_s,
            solves=len(solutions),
            message=solutions[-1].message,
        )
        for scenario, profile in zip(self._known.values(), solutions[-1].profiles, strict=True):
            scenario.profile = profile
        return solutions[-1]

    def _flying(
        self, values: dict[str, float], solution: Solution | None, last: JudgedDesign | None
    ) -> Generator[Flights, Performance, JudgedDesign]:
        """Judge a design; where it does not fly one nearer to the last, or the file's own."""
        judged, step = (yield from self._judged(values, solution)), 1.0
        if last is None and not judged.flies:
            values = self.task.first_values(variables_of(self.task.aircraft))
            return (yield from self._judged(values, solution))
        while last is not None and not judged.flies:  # the last one does
            step /= 2.0
            between = {n: v + step * (values[n] - v) for n, v in last.values.items()}
            judged = yield from self._judged(between, solution)
        return judged

    def _judged(
        self, values: dict[str, float], solution: Solution | None
    ) -> Generator[Flights, Performance, JudgedDesign]:
        """Judge a design by its flight."""
        task, perf = self.task, (yield Flights(values))
        excess_h = np.array(np.asarray(perf.cycle.excess_time_h, float)[0])
        mass_kg = float(np.asarray(perf.design.total_mass_kg)[0])
        if math.isfinite(mass_kg):
            values = {**values, TOTAL_MASS: mass_kg}
        promising = bool(self.profiles) if solution is None else solution.violation <= LACKING
        short = np.flatnonzero(~task.is_enough(excess_h[:, np.newaxis]))
        best_climbs = promising and task.mission.climb is not None and len(short) > 0
        if best_climbs:
            # Heights of the program are no more than a proposal: the best for the design count.
            best = yield Flights(values, short)
            excess_h[short] = np.maximum(excess_h[short], np.ravel(best.cycle.excess_time_h))
        judged = JudgedDesign(
            task=task,
            values=values,
            perf=perf,
            excess_h=excess_h,
            merit=task.merit(perf, float(excess_h.min())),
            accepted=bool(task.is_enough(excess_h) and task.meets(perf)[0]),
            solution=solution,
            profiles=self.profiles,
            best_climbs=best_climbs,
        )
        if judged.accepted:
            gain = judged.merit - self.merit
            if self.best is not None:
                # Of two infinite excess times it is no number.
                least = self._tolerance * max(abs(self.merit), 1e-3)
                self._rounds_without_gain += not gain >= least
            if gain > 0.0:
                self.best = judged
        if solution is not None or self.nearest is None:
            self.nearest = judged
        return judged

    def _ends(self, judged: JudgedDesign) -> bool:
        """Return whether nothing better is to be expected."""
        solution, task = judged.solution, self.task
        if not judged.flies or (task.has_polar_night and not self.in_the_dark):
            self.status = SizingStatus.infeasible
            return True
        if judged.accepted and judged.merit >= self.stop_at_merit:
            return True
        if solution is None:
            return False
        near = solution.largest_change < _NEAR
        if solution.violation > LACKING:
            if solution.is_limited:  # a longer step may mend it
                return False
            # Corrections that mend a violation at least halve it; and none mends more than what a
            # linearisation leaves out over a step.
            self._rounds_unmended += solution.violation > self._violation / 2.0
            self._violation = min(self._violation, solution.violation)
            known = near or self._rounds_unmended > 0
            hopeless = known and solution.violation > _NEAR**2
            if hopeless or self._rounds_unmended >= 2:
                self.status = SizingStatus.infeasible
                return True
            return False
        if not judged.accepted:
            return False
        excess_h = float(judged.excess_h.min()) - task.required_h
        # An infinite one is the sun's, and no battery gains by less of it.
        to_gain = excess_h * solution.cost_of_hour() if math.isfinite(excess_h) else 0.0
        to_gain += max(scenario.margin for scenario in self._known.values()) - FIRST_MARGIN
        if task.window_h is not None:
            on_way_h = _least_left_h(judged.perf, judged.worst)
            to_gain += on_way_h * solution.cost_of_hour(on_way=True)
        settled = task.continuous or (not task.maximises_excess and to_gain < self._tolerance)
        if near and not solution.is_limited and judged.worst in self._blocks and settled:
            return True
        return self._rounds_without_gain >= 2

    def _learn_from(self, judged: JudgedDesign) -> None:
        """Correct what the program requires, and exchange its scenarios."""
        if judged.solution is not None:
            for block, number in enumerate(self._blocks):
                self._correct(judged, judged.solution, block, number)
        if not self._blocks:
            order = np.argsort(judged.excess_h, kind="stable")
            self._blocks = [int(n) for n in order[:MOST_BLOCKS]]
        elif judged.worst not in self._blocks:
            easiest = max(self._blocks, key=lambda number: float(judged.excess_h[number]))
            self._blocks[self._blocks.index(easiest)] = judged.worst
            self.scenarios[easiest] = Scenario(profile=self.scenarios[easiest].profile)
        for number in self._blocks:
            self.scenarios.setdefault(number, Scenario())

    def _correct(self, judged: JudgedDesign, solution: Solution, block: int, number: int) -> None:
        """Correct what the last solution promised of a scenario, and its flight does not hold."""
        scenario, simulated_h = self.scenarios[number], float(judged.excess_h[number])
        scenario.begin = solution.first_soc(block)
        if scenario.profile is None:
            return
        # Heights are other ones in every program, and none of them quite those of the best flight.
        if float(np.asarray(judged.perf.cycle.excess_time_h)[0, number]) > 0.0:
            scenario.margin = max(FIRST_MARGIN, scenario.margin / 2.0)
            if not self.task.continuous and math.isfinite(simulated_h):
                scenario.bias_h += solution.planned_h(block) - simulated_h + CUSHION_H
        elif solution.violation <= LACKING and solution.largest_change <= _NEAR:
            # A day that does not close shows how much it lacks.
            scenario.margin += FIRST_MARGIN + unserved(self.task, judged.perf, number)


def _least_left_h(perf: Performance, number: int) -> float:
    """Return how long the least charge of a flight that lands would last [h]."""
    nominal_w = np.broadcast_to(perf.nominal_load_w, perf.cycle.status.shape)[0, number]
    full_wh = np.ravel(perf.store.battery_energy_wh)[0]
    least_wh = perf.cycle.minimum_state_of_charge[0, number] * full_wh
    return float(least_wh * perf.store.discharge_efficiency / nominal_w)
