"""Questions to the sizing program: which variables are free, what is minimised, where to start."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import DesignVariables, FlightConditions, closed_design
from sizing.optimisation.energy_constraints import sun_parameters
from sizing.optimisation.objectives import Objective
from sizing.optimisation.problem import (
    MAXIMUM_EXCESS_H,
    WORST_EXCESS,
    Effort,
    SizingProblem,
    SizingProblems,
)
from sizing.optimisation.result import SolverReport
from sizing.sunlight import SolarDay
from solar.types import FloatArray

# A requirement missed by less than this (relative) is met: the solver's own tolerance is 1e-8.
_SLACK_TOLERANCE = 1e-5
FIRST_MARGIN = 1e-3  # of the recharge, to begin with

# Sequential quadratic programming ends where the point is feasible and the prices balance the cost.
# Old prices do so still where a requirement has only become easier, though it no longer binds; a
# little off, they make the program look for its active requirements at least once.
_NOT_QUITE = 0.999

# Which requirement an infeasible sizing may miss first: the excess time, then the energy over the
# cycle, and only as a last resort what makes the design an aircraft at all.
_SLACK_WEIGHTS = {"excess_time": 1.0, "energy_balance": 10.0, "battery_capacity": 10.0}
_OTHER_SLACK_WEIGHT = 100.0

_COSTS: dict[Objective, dict[str, float]] = {
    Objective.max_excess_time: {WORST_EXCESS: -1.0 / 24.0},
    Objective.min_wingspan: {"wingspan_m": 1.0},
    Objective.min_mass: {"total_mass_kg": 1.0},
    Objective.max_payload_mass: {"payload_mass_kg": -1.0},
    Objective.max_payload_power: {"payload_power_w": -1.0},
}


@dataclass(frozen=True)
class Question:
    """What the program is asked.

    Attributes
    ----------
    cost : mapping
        Weights of the decision vector by name of its variables.
    goal_h : float
        Excess time that every scenario must have [h].
    best_excess : bool
        Whether the worst excess time may exceed the goal: where it is what is maximised.
    freed : tuple of str
        Payload or technology variables that may move; all others are held.
    bounds : mapping
        Bounds of variables, in their unit, that replace their own.
    elastic : bool
        Whether requirements may be missed, at a cost that replaces the other one.
    margin : float
        By how much more charge the day must return than the night takes, relative.
    """

    cost: Mapping[str, float]
    goal_h: float
    best_excess: bool = False
    freed: tuple[str, ...] = ()
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    elastic: bool = False
    margin: float = FIRST_MARGIN

    @classmethod
    def of(cls, objective: Objective, goal_h: float) -> Question:
        """Question of an objective."""
        payload = (Objective.max_payload_mass, Objective.max_payload_power)
        return cls(
            cost=_COSTS[objective],
            goal_h=goal_h,
            best_excess=objective is Objective.max_excess_time,
            freed=(objective.variable,) if objective in payload else (),
        )

    def elastically(self) -> Question:
        """By how much the requirements must be missed."""
        return replace(self, elastic=True, best_excess=False)


@dataclass(frozen=True)
class Answer:
    """Solution of the program.

    ``x`` is the decision vector, ``constraint_prices`` and ``bound_prices`` the multipliers,
    ``slack`` the requirements missed by their name, ``filled`` the scenarios in the slots.
    """

    problem: SizingProblem
    question: Question
    x: FloatArray
    weights: FloatArray
    constraint_prices: FloatArray
    bound_prices: FloatArray
    filled: tuple[int, ...]

    @property
    def variables(self) -> DesignVariables:
        """Design that was found."""
        return self.problem.design_variables(self.x, self.question.bounds)

    def value(self, name: str) -> float:
        """Value of a variable, in its unit."""
        index = self.problem.variable_names.index(name)
        return float(self.problem.variables[index].from_program(self.x[index]))

    @property
    def worst_excess_time_h(self) -> float:
        """Least excess time of the scenarios in the slots [h], as the program has it."""
        return float(self.x[self.problem.places()[WORST_EXCESS]][0])

    def slack(self) -> dict[str, float]:
        """By how much each requirement is missed."""
        values = self.x[self.problem.places()["slack"]]
        return dict(zip(self.problem.slack_names, values.tolist(), strict=True))

    def missed(self) -> dict[str, float]:
        """Requirements that are missed by more than the solver's tolerance, and by how much."""
        return {name: slack for name, slack in self.slack().items() if slack > _SLACK_TOLERANCE}


class _Posed(NamedTuple):
    """A question as arguments of a program, all but the start."""

    problem: SizingProblem
    question: Question
    filled: tuple[int, ...]
    weights: FloatArray
    limits: dict[str, Any]

    def within(self, x: FloatArray) -> FloatArray:
        """Point moved into the bounds."""
        return np.clip(x, self.limits["lbx"], self.limits["ubx"])


class ProgramSolver:
    """Asks the program of an aircraft about one mission, and counts the work.

    Parameters
    ----------
    problems : SizingProblems
        Programs of the aircraft.
    mission : Mission
        Conditions of flight.
    day : SolarDay
        Sun in every scenario that may fill a slot.
    """

    def __init__(self, problems: SizingProblems, mission: Mission, day: SolarDay) -> None:
        self.problems, self.mission, self.day = problems, mission, day
        self.conditions = FlightConditions.of(mission)
        self.suns = sun_parameters(day, mission)
        self.iterations, self.solve_s, self.build_s, self.solves = 0, 0.0, 0.0, 0
        self.message = ""

    @property
    def aircraft(self) -> Aircraft:
        """Aircraft that is sized."""
        return self.problems.aircraft

    def ask(
        self,
        question: Question,
        scenarios: Sequence[int],
        starts: Sequence[DesignVariables],
        *,
        effort: Effort = "quick",
    ) -> Answer | None:
        """Answer from the first start that converges; None where none does.

        ``scenarios`` are indices, one for each slot.
        """
        cost = _elastic_cost if question.elastic else lambda _: question.cost
        posed = self._posed(question, scenarios, cost)
        for variables in starts:
            answer = self._solved(posed, effort, self._cold(posed, variables))
            if answer is not None:
                return answer
        return None

    def ask_softly(
        self,
        question: Question,
        scenarios: Sequence[int],
        penalty: float | None,
        *,
        held: Mapping[str, float],
        start: DesignVariables,
        previous: Answer | None = None,
        efforts: Sequence[Effort] = ("quick", "steady"),
    ) -> Answer | None:
        """Answer about some scenarios with requirements that may be missed at a price.

        Parameters
        ----------
        question : Question
            What is asked.
        scenarios : sequence of int
            Indices of the scenarios, one for each slot.
        penalty : float or None
            Price of a missed requirement on top of the question's cost; none where missing as
            little as possible is all that is asked.
        held : mapping
            Variables held at other values than the aircraft's and the mission's.
        start : DesignVariables
            First guess of the interior-point method.
        previous : Answer, optional
            Answer to a similar question, from which sequential quadratic programming starts.
        efforts : sequence of Effort
            What is tried from the first guess, one after the other.
        """
        posed = self._posed(
            question, scenarios, lambda it: _soft_cost(it, question, penalty), held, soft=True
        )
        if previous is not None:
            answer = self._solved(posed, "next", _warm(posed, previous))
            if answer is not None:
                return answer
        cold = self._cold(posed, start)
        for effort in efforts:
            answer = self._solved(posed, effort, cold)
            if answer is not None:
                return answer
        return None

    def _posed(
        self,
        question: Question,
        scenarios: Sequence[int],
        cost: Callable[[SizingProblem], Mapping[str, float]],
        held: Mapping[str, float] | None = None,
        *,
        soft: bool = False,
    ) -> _Posed:
        """Question as arguments of the program with these scenarios in its slots."""
        begun = time.perf_counter()
        problem = self.problems.of(len(scenarios))
        self.build_s += time.perf_counter() - begun
        weights = problem.weights(cost(problem))
        suns = self.suns[list(scenarios)]
        parameters = problem.parameters(weights, self.conditions, suns, margin=question.margin)
        lower, upper = self._bounds(problem, question, held)
        if soft:
            upper[problem.places()["slack"]] = np.inf
        limits = _limits(problem, parameters, lower, upper)
        return _Posed(problem, question, tuple(scenarios), weights, limits)

    def _cold(self, posed: _Posed, variables: DesignVariables) -> dict[str, FloatArray]:
        """Start of the solver from a design."""
        return {"x0": posed.within(self._start(posed.problem, posed.question, variables))}

    def _solved(
        self, posed: _Posed, effort: Effort, start: Mapping[str, FloatArray]
    ) -> Answer | None:
        """Answer of the solver from a start; None where it fails."""
        found = self._solve(posed.problem, effort, posed.limits | dict(start))
        if found is None:
            return None
        return Answer(
            posed.problem, posed.question, found[0], posed.weights, *found[1:], posed.filled
        )

    def _solve(
        self, problem: SizingProblem, effort: Effort, arguments: dict[str, Any]
    ) -> tuple[FloatArray, FloatArray, FloatArray] | None:
        """Point and prices of constraints and bounds; None where the solver fails."""
        begun = time.perf_counter()
        solver = problem.solver(effort)
        self.build_s += time.perf_counter() - begun
        begun = time.perf_counter()
        found: Any = solver(**arguments)
        self.solve_s += time.perf_counter() - begun
        stats = solver.stats()
        self.iterations += int(stats["iter_count"])
        self.solves += 1
        self.message = str(stats["return_status"])
        x, g, b = (np.asarray(found[k]).ravel() for k in ("x", "lam_g", "lam_x"))
        return (x, g, b) if stats["success"] and np.isfinite(x).all() else None

    def add(self, other: ProgramSolver) -> None:
        """Count the work of another solver as well."""
        self.iterations += other.iterations
        self.solve_s += other.solve_s
        self.build_s += other.build_s
        self.solves += other.solves
        self.message = other.message

    def report(self) -> SolverReport:
        """Work so far."""
        return SolverReport(self.iterations, self.solve_s, self.build_s, self.solves, self.message)

    def _bounds(
        self,
        problem: SizingProblem,
        question: Question,
        otherwise_held: Mapping[str, float] | None = None,
    ) -> tuple[FloatArray, FloatArray]:
        places = problem.places()
        lower, upper = np.zeros(places["slack"].stop), np.ones(places["slack"].stop)
        held = self._held_values(problem) | dict(otherwise_held or {})
        for i, variable in enumerate(problem.variables):
            ends = question.bounds.get(variable.name, (variable.minimum, variable.maximum))
            if variable.name in held and variable.name not in question.freed:
                ends = (held[variable.name],) * 2
            lower[i], upper[i] = (variable.to_program(end) for end in ends)
        lower[places[WORST_EXCESS]] = question.goal_h
        upper[places[WORST_EXCESS]] = MAXIMUM_EXCESS_H if question.best_excess else question.goal_h
        upper[places["slack"]] = np.inf if question.elastic else 0.0
        return lower, upper

    def _held_values(self, problem: SizingProblem) -> dict[str, float]:
        """Variables that stay as aircraft and mission have them unless they are freed."""
        payload = self.mission.payload
        technology = dict.fromkeys(problem.technology, 1.0)
        return technology | {"payload_mass_kg": payload.mass_kg, "payload_power_w": payload.power_w}

    def _start(
        self, problem: SizingProblem, question: Question, variables: DesignVariables
    ) -> FloatArray:
        closed = closed_design(self.aircraft, self.mission, variables)
        mass = float(closed.total_mass_kg)
        airframe = self.aircraft.airframe
        guess = self._held_values(problem) | {
            "total_mass_kg": mass if np.isfinite(mass) else 3.0 * variables.battery_mass_kg,
            "lift_coefficient": getattr(
                getattr(airframe, "aerodynamics", None), "flight_lift_coefficient", 1.0
            ),
        }
        guess |= {name: float(value) for name, value in variables.chosen().items()}
        guess["module_area_m2"] = max(guess["module_area_m2"], 1e-3)
        places = problem.places()
        start = np.full(places["slack"].stop, 0.1)
        start[places["variables"]] = [v.to_program(guess[v.name]) for v in problem.variables]
        start[places["dawn"]] = 0.2
        start[places[WORST_EXCESS]] = question.goal_h + 1.0
        return start


def _warm(posed: _Posed, previous: Answer) -> dict[str, FloatArray]:
    """Start of the solver from the point and the prices of an answer."""
    return {
        "x0": posed.within(previous.x),
        "lam_x0": _NOT_QUITE * previous.bound_prices,
        "lam_g0": _NOT_QUITE * previous.constraint_prices,
    }


def _limits(
    problem: SizingProblem, parameters: FloatArray, lower: FloatArray, upper: FloatArray
) -> dict[str, Any]:
    """Arguments of the solver besides the start."""
    upper_rows = np.full(len(problem.constraints), np.inf)
    upper_rows[0] = 0.0  # the mass budget is an equation
    return {"p": parameters, "lbx": lower, "ubx": upper, "lbg": 0.0, "ubg": upper_rows}


def _soft_cost(
    problem: SizingProblem, question: Question, penalty: float | None
) -> dict[str, float]:
    """Cost of a question with a price on what is missed; the price alone without a penalty."""
    prices = _elastic_cost(problem)
    if penalty is None:
        return prices
    # The rows of the energy count in fractions of the battery, those of the excess time in tenths
    # of the day; what makes a design an aircraft at all must not be sold.
    return {name: penalty * price**0.5 for name, price in prices.items()} | dict(question.cost)


def _elastic_cost(problem: SizingProblem) -> dict[str, float]:
    return {name: _SLACK_WEIGHTS.get(name, _OTHER_SLACK_WEIGHT) for name in problem.slack_names}
