"""Bringing the program and the simulator into agreement.

The program knows a few scenarios on coarse nodes; the simulator judges all of them on fine ones.
Scenarios join the program and its goal is shifted until the simulator confirms the optimum. A
program that claims a little more or less than the simulator finds has still found the right design;
what counts is the simulator's number. Of all designs that the simulator accepted on the way, the
best is the answer.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from sizing.design import DesignVariables
from sizing.energy.cycle import Status
from sizing.limits import meets_requirements
from sizing.optimisation.problem import Effort
from sizing.optimisation.solver import Answer, ProgramSolver, Question
from sizing.performance import Performance

# Scenarios that a program starts with; others join when the simulator finds them worse.
FIRST_SLOTS = 3
_ROUNDS = 12
# The program is asked for a little more than required, and asked again for less where that was too
# much [h]. Its time step flatters a design by up to 0.003 h, the simulator's by another 0.002.
GOAL_CUSHION_H = 0.006
WASTE_H = 0.012
# Price of a missed requirement: far above what one is worth, so that none is missed for a gain.
_PENALTY = 300.0
_UNCHANGED = 1e-6  # relative difference of designs, between solver tolerance and any use
_ROW_TOLERANCE = 1e-5  # relative; the solver meets its rows to about 1e-8


class Agreed(NamedTuple):
    """A design that the simulator accepts: the program's answer and the simulation."""

    answer: Answer
    simulated: Performance
    merit: float


class Agreement:
    """One question put to the program until the simulator agrees.

    Parameters
    ----------
    solver : ProgramSolver
        The program, the mission and its sun.
    question : Question
        What is asked; its goal carries a cushion for all but the largest excess time.
    required_h : float
        Excess time that the simulator must find in every scenario [h].
    simulate : callable
        Performance of an answer in all scenarios.
    merit : callable
        Merit of a simulated answer, the larger the better.
    """

    def __init__(
        self,
        solver: ProgramSolver,
        question: Question,
        required_h: float,
        simulate: Callable[[Answer], Performance],
        merit: Callable[[Answer, Performance], float],
    ) -> None:
        self.solver, self.question, self.required_h = solver, question, required_h
        self.simulate, self.merit = simulate, merit
        self.slots = min(FIRST_SLOTS, len(solver.day.scenarios))
        self.chosen: list[int] = []
        self.best: Agreed | None = None
        self.cushion_h = GOAL_CUSHION_H

    def ask(
        self,
        starts: Sequence[DesignVariables],
        *,
        effort: Effort = "quick",
        question: Question | None = None,
    ) -> Answer | None:
        """Answer of the program alone, to another question if one is given."""
        asked = question or self.question
        return self.solver.ask(asked, self._filled(), starts, effort=effort)

    def ask_softly(
        self,
        start: DesignVariables,
        *,
        previous: Answer | None = None,
        efforts: Sequence[Effort] = ("quick", "steady"),
        question: Question | None = None,
    ) -> Answer | None:
        """Answer of the program where missing a requirement has a high price.

        It says nearly as fast that nothing meets all of them as what does best. A question that is
        elastic asks for the least miss alone.
        """
        asked = question or self.question
        penalty = None if asked.elastic else _PENALTY
        return self.solver.ask_softly(
            asked,
            self._filled(),
            penalty,
            held={},
            start=start,
            previous=previous,
            efforts=efforts,
        )

    def _filled(self) -> list[int]:
        """Scenarios in the slots; spare ones repeat them."""
        return [self.chosen[i % len(self.chosen)] for i in range(self.slots)]

    def settle(self, answer: Answer) -> Agreed | None:
        """Best design that the simulator accepts, from a first answer on."""
        before: Answer | None = None
        for _ in range(_ROUNDS):
            simulated = self.simulate(answer)
            worst = simulated.worst_scenario()
            found_h = float(simulated.cycle.excess_time_h[worst])
            accepted = self.accepts(simulated)
            if accepted:
                self._keep(answer, simulated)
            wasteful = self._wasteful(found_h) and not _same(before, answer)
            if worst in self.chosen and accepted and not wasteful:
                break
            self._tighten(worst, found_h)
            retried = self.ask([answer.variables])
            if retried is None:
                break
            before, answer = answer, retried
        return self.best

    def accepts(self, perf: Performance) -> bool:
        """Whether a closed design has enough excess time everywhere and keeps its requirements."""
        worst_h = float(np.min(perf.cycle.excess_time_h))
        if not (worst_h > 0.0 and worst_h >= self.required_h):
            return False
        if "total_mass_kg" in self.question.bounds:  # the limit on it is what is asked for
            return True
        met = meets_requirements(
            self.solver.aircraft, perf.design, self.solver.conditions, tolerance=_ROW_TOLERANCE
        )
        return bool(np.all(met))

    def _keep(self, answer: Answer, simulated: Performance) -> None:
        merit = self.merit(answer, simulated)
        if self.best is None or merit > self.best.merit:
            self.best = Agreed(answer, simulated, merit)

    def _wasteful(self, found_h: float) -> bool:
        """Whether a design has more excess time than it was asked for, where that costs."""
        if self.question.best_excess:
            return False
        return self.question.goal_h > 0.0 and found_h - self.required_h > WASTE_H

    def _tighten(self, worst: int, found_h: float) -> None:
        question = self.question
        if worst not in self.chosen:
            self.chosen.append(worst)
            if len(self.chosen) > self.slots:
                self.slots = min(2 * self.slots, len(self.solver.day.scenarios))
        else:
            goal_h, margin = shifted(
                question.goal_h,
                question.margin,
                required_h=self.required_h,
                found_h=found_h,
                cushion_h=self.cushion_h,
            )
            self.question = replace(question, goal_h=goal_h, margin=margin)


def shifted(
    goal_h: float, margin: float, *, required_h: float, found_h: float, cushion_h: float
) -> tuple[float, float]:
    """Goal and margin for the next program, where the simulator found another excess time."""
    if found_h <= 0.0:
        # The battery runs empty over many days: the day must return more.
        return goal_h + cushion_h, 3.0 * margin
    return max(goal_h + required_h - found_h + cushion_h, 0.0), margin


def _same(before: Answer | None, answer: Answer) -> bool:
    """Whether another goal made no difference: another requirement decides."""
    if before is None:
        return False
    then, now = (list(one.variables.chosen().values()) for one in (before, answer))
    return bool(np.allclose(then, now, rtol=_UNCHANGED, atol=0.0))


def telling_scenarios(perf: Performance, count: int) -> list[int]:
    """Scenarios likely to drive the sizing: least excess time, and least sun for their load."""
    cycle = perf.cycle
    short_of_sun = int(np.argmin(cycle.energy_budget.solar_wh / cycle.energy_budget.load_wh))
    by_excess = np.argsort(cycle.excess_time_h, kind="stable").tolist()
    dark = [i for i in by_excess if cycle.status[i] != Status.always_lit] or by_excess
    return list(dict.fromkeys([dark[0], short_of_sun, *dark, *by_excess]))[:count]
