"""Sizing: the best wingspan, battery mass and module area for a mission, or why there is none."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.cycle import Status
from sizing.design import Design, DesignVariables, Masses, closed_design, variables_of
from sizing.energy_balance import FloatArray
from sizing.objectives import Objective
from sizing.performance import (
    DEFAULT_STEP_H,
    UNCORRECTED_CAM,
    Performance,
    SolarDay,
    SolarModel,
    performance_of_designs,
    solar_day,
)
from sizing.sizing_problem import Effort, SizingProblem, build_problem, design_rows

# A requirement missed by less than this (relative) is met: the solver's own tolerance is 1e-8.
_SLACK_TOLERANCE = 1e-5
_ACTIVE_MULTIPLIER = 1e-5
# Scenarios that a program starts with; others join when the simulator finds them worse.
_FIRST_SLOTS = 3
_ROUNDS = 12
# The program is asked for a little more than required, as its coarser time step may flatter a
# design, and asked again for less where that was too much [h].
_GOAL_CUSHION_H = 0.008
_WASTE_H = 0.02
_FIRST_MARGIN = 1e-3
_RESCUES = 3
_ELASTIC_EFFORTS: tuple[Effort, ...] = ("steady", "patient")
_GRID_POINTS = 9
_GRID_STEP_H = 0.5


@dataclass(frozen=True)
class Violation:
    """A requirement that no design within its bounds can meet.

    ``shortfall`` is relative to the limit; for the energy requirements to the battery's capacity,
    for the excess time in hours.
    """

    requirement: str
    shortfall: float
    text: str


@dataclass(frozen=True)
class SolverReport:
    """What the solver did: iterations and time over all starts and rounds."""

    iterations: int
    time_s: float
    build_time_s: float
    solves: int
    message: str


@dataclass(frozen=True)
class Optimum:
    """Solver's answer at an optimum: point, prices of the constraints, and what it was asked.

    ``filled`` are the scenarios in the slots of the program; see
    :class:`sizing.sizing_problem.SizingProblem`.
    """

    x: FloatArray
    constraint_prices: FloatArray
    filled: tuple[int, ...]
    goal_h: float
    margin: float


@dataclass(frozen=True)
class SizingResult:
    """Outcome of a sizing: an optimum, or the requirements that cannot be met.

    ``status`` is ``optimal``, ``infeasible`` or ``not_converged``. Design, simulated performance
    and objective value (the simulator's number) exist for an optimum alone. ``nearest`` is the
    simulated design that comes closest where none is feasible, and ``active_constraints`` then name
    what holds it back.
    """

    status: str
    objective: Objective
    required_excess_time_h: float
    objective_value: float | None
    design: Design | None
    simulated: Performance | None
    nearest: Performance | None
    active_constraints: tuple[str, ...]
    violations: tuple[Violation, ...]
    solver: SolverReport
    optimum: Optimum | None = None

    @property
    def feasible(self) -> bool:
        """Whether an optimum was found."""
        return self.status == "optimal"


def size_aircraft(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective = Objective.max_excess_time,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    required_excess_time_h: float | None = None,
    day: SolarDay | None = None,
    step_h: float = DEFAULT_STEP_H,
) -> SizingResult:
    """Find the best design of a parametric aircraft for a mission.

    Parameters
    ----------
    aircraft : Aircraft
        Technology, bounds of the design variables, and a first guess (its own design point).
    mission : Mission
        Latitudes, dates, air, payload and wind.
    objective : Objective
        ``max_excess_time`` of the worst scenario, or ``min_wingspan`` / ``min_mass`` with a
        required excess time in every scenario.
    solar : SolarModel
        Solar power model and its correction.
    required_excess_time_h : float, optional
        Overrides the mission's own [h]. For ``max_excess_time`` it is a bound from below.
    day : SolarDay, optional
        Specific power of the scenarios where it is known already.
    step_h : float
        Time step of the simulator [h].

    Returns
    -------
    SizingResult

    Raises
    ------
    TypeError
        For a measured aircraft.
    """
    if isinstance(aircraft.airframe, MeasuredAirframe):
        raise TypeError(f"{aircraft.name} is a measured aircraft: it has no mass budget to size")
    required = mission.required_excess_time_h
    required = required if required_excess_time_h is None else required_excess_time_h
    lit = solar_day(aircraft, mission, solar, step_h=step_h) if day is None else day
    return _Search(aircraft, mission, solar, lit, objective, required).run()


class _Search:
    """One sizing: its starts, its growing set of scenarios, and the verdict."""

    def __init__(
        self,
        aircraft: Aircraft,
        mission: Mission,
        solar: SolarModel,
        day: SolarDay,
        objective: Objective,
        required_h: float,
    ) -> None:
        self.aircraft, self.mission, self.solar, self.day = aircraft, mission, solar, day
        self.objective, self.required_h = objective, required_h
        cushion_h = 0.0 if objective is Objective.max_excess_time else _GOAL_CUSHION_H
        self.goal_h, self.margin = required_h + cushion_h, _FIRST_MARGIN
        self.iterations, self.solve_s, self.build_s, self.solves = 0, 0.0, 0.0, 0
        self.message = ""
        self.rescues = 0
        self.best: SizingResult | None = None
        self.held: tuple[str, ...] = ()
        self.chosen: list[int] = []
        self.problem = self._build(min(_FIRST_SLOTS, len(day.scenarios)))

    def run(self) -> SizingResult:
        first = self._simulate(variables_of(self.aircraft))
        self.chosen = _telling_scenarios(first, self.problem.slots)
        starts = [variables_of(self.aircraft)]
        answer = self._solve_from(starts)
        if answer is None:
            starts = self._grid_starts()
            return self._explain_failure(starts)
        return self._agree_with_simulator(answer)

    def _agree_with_simulator(self, answer: dict[str, Any]) -> SizingResult:
        """Add scenarios and shift the program's goal until the simulator confirms its optimum.

        A program that claims a little more or less than the simulator finds has still found the
        right design; what counts is the simulator's number. Of all designs that the simulator
        accepted on the way, the best is the answer.
        """
        for _ in range(_ROUNDS):
            simulated = self._simulate(self._variables(answer))
            worst = simulated.worst_scenario()
            found = float(simulated.cycle.excess_time_h[worst])
            accepted = found > 0.0 and found >= self.required_h
            if accepted:
                self._keep(answer, simulated)
            if worst in self.chosen and accepted and not self._wasteful(found):
                break
            self._tighten(worst, found)
            retried = self._solve_from([self._variables(answer)])
            if retried is None:
                break
            answer = retried
        if self.best is not None:
            return self.best
        return self._explain_failure(self._grid_starts())

    def _keep(self, answer: dict[str, Any], simulated: Performance) -> None:
        """Remember the best design that the simulator accepts."""
        result = self._optimal(answer, simulated)
        sign = 1.0 if self.objective is Objective.max_excess_time else -1.0
        if self.best is None or sign * _value(result) > sign * _value(self.best):
            self.best = result

    def _wasteful(self, found_h: float) -> bool:
        """Whether a design of least size has more excess time than it was asked for."""
        if self.objective is Objective.max_excess_time:
            return False
        return self.goal_h > 0.0 and found_h - self.required_h > _WASTE_H

    def _tighten(self, worst: int, found_h: float) -> None:
        if worst not in self.chosen:
            self.chosen.append(worst)
            if len(self.chosen) > self.problem.slots:
                self.problem = self._build(min(2 * self.problem.slots, len(self.day.scenarios)))
        elif found_h <= 0.0:
            # The battery runs empty over many days: the day must return more.
            self.margin *= 3.0
            self.goal_h += _GOAL_CUSHION_H
        else:
            self.goal_h = max(self.goal_h + self.required_h - found_h + _GOAL_CUSHION_H, 0.0)

    # --- solving -----------------------------------------------------------------------------

    def _build(self, slots: int, effort: Effort = "quick") -> SizingProblem:
        begun = time.perf_counter()
        problem = build_problem(
            self.aircraft,
            self.mission,
            self.day,
            self.objective,
            slots,
            effort=effort,
        )
        self.build_s += time.perf_counter() - begun
        return problem

    def _solve_from(
        self, starts: list[DesignVariables], *, elastic: bool = False
    ) -> dict[str, Any] | None:
        """First start that converges."""
        for variables in starts:
            answer = self._solve(self._start(variables), elastic=elastic)
            if answer is not None:
                return answer
        return None

    def _solve(self, start: FloatArray, *, elastic: bool) -> dict[str, Any] | None:
        problem = self.problem
        lower, upper = self._variable_bounds(elastic)
        upper_rows = np.full(len(problem.constraints), np.inf)
        upper_rows[0] = 0.0  # the mass budget is an equation
        parameters = problem.parameters(
            self._filled(), elastic=elastic, goal_h=self.goal_h, margin=self.margin
        )
        begun = time.perf_counter()
        answer = problem.solver(
            x0=np.clip(start, lower, upper),
            p=parameters,
            lbx=lower,
            ubx=upper,
            lbg=0.0,
            ubg=upper_rows,
        )
        self.solve_s += time.perf_counter() - begun
        stats = problem.solver.stats()
        self.iterations += int(stats["iter_count"])
        self.solves += 1
        self.message = str(stats["return_status"])
        return {k: np.asarray(v).ravel() for k, v in answer.items()} if stats["success"] else None

    def _filled(self) -> list[int]:
        """Scenarios in the program's slots; spare slots repeat them."""
        return [self.chosen[i % len(self.chosen)] for i in range(self.problem.slots)]

    def _variable_bounds(self, elastic: bool) -> tuple[FloatArray, FloatArray]:
        problem = self.problem
        slacks = len(problem.slack_names)
        lower: list[ArrayLike] = [
            np.log([r.minimum for r in problem.bounds]),
            np.zeros(problem.slots),
            [self.goal_h],
            np.zeros(slacks),
        ]
        upper: list[ArrayLike] = [
            np.log([r.maximum for r in problem.bounds]),
            np.ones(problem.slots),
            [self.goal_h if elastic else 1e4],
            np.full(slacks, np.inf if elastic else 0.0),
        ]
        return np.hstack(lower), np.hstack(upper)

    def _start(self, variables: DesignVariables) -> FloatArray:
        problem = self.problem
        closed = closed_design(self.aircraft, self.mission, variables)
        mass = float(closed.total_mass_kg)
        guess = {
            "wingspan_m": variables.wingspan_m,
            "battery_mass_kg": variables.battery_mass_kg,
            "module_area_m2": max(variables.module_area_m2, 1e-3),
            "total_mass_kg": mass if np.isfinite(mass) else 3.0 * variables.battery_mass_kg,
            "aspect_ratio": variables.aspect_ratio,
        }
        logs = np.log([float(guess[name]) for name in problem.variable_names])
        return np.concatenate(
            (
                logs,
                np.full(problem.slots, 0.2),
                [self.required_h + 1.0],
                np.full(len(problem.slack_names), 0.1),
            )
        )

    def _grid_starts(self) -> list[DesignVariables]:
        """Most promising designs of a coarse grid over the design space, best first."""
        axes = [
            np.geomspace(r.minimum, r.maximum, _GRID_POINTS)
            for name, r in zip(self.problem.variable_names, self.problem.bounds, strict=True)
            if name in ("wingspan_m", "battery_mass_kg", "module_area_m2")
        ]
        span, battery, area = (v.ravel() for v in np.meshgrid(*axes, indexing="ij"))
        aspect = self.problem.fixed_aspect_ratio or self.aircraft.airframe.aspect_ratio
        airframe = self.aircraft.airframe
        coverage = getattr(airframe, "maximum_module_coverage", 1.0)
        fits = area <= coverage * span**2 / aspect
        variables = DesignVariables(
            span[fits], np.full(int(fits.sum()), aspect), battery[fits], area[fits]
        )
        if not np.any(fits):
            return [variables_of(self.aircraft)]
        coarse = solar_day(
            self.aircraft,
            self.mission,
            self.solar,
            scenarios=self.day.scenarios,
            step_h=_GRID_STEP_H,
        )
        found = performance_of_designs(
            self.aircraft, self.mission, variables, self.solar, day=coarse
        )
        merit = np.min(found.cycle.excess_time_h, axis=-1)
        best = np.argsort(-merit, kind="stable")[:3]
        return [DesignVariables(*(float(v[i]) for v in variables)) for i in best]

    # --- verdicts ----------------------------------------------------------------------------

    def _variables(self, answer: dict[str, Any]) -> DesignVariables:
        problem = self.problem
        free = np.exp(answer["x"][: len(problem.variable_names)])
        # The solver may step over a bound by its tolerance.
        clipped = [
            float(np.clip(v, r.minimum, r.maximum))
            for v, r in zip(free, problem.bounds, strict=True)
        ]
        values = dict(zip(problem.variable_names, clipped, strict=True))
        return DesignVariables(
            wingspan_m=values["wingspan_m"],
            aspect_ratio=values.get("aspect_ratio", problem.fixed_aspect_ratio),
            battery_mass_kg=values["battery_mass_kg"],
            module_area_m2=values["module_area_m2"],
        )

    def _simulate(self, variables: DesignVariables) -> Performance:
        return performance_of_designs(
            self.aircraft, self.mission, variables, self.solar, day=self.day
        )

    def _optimal(self, answer: dict[str, Any], simulated: Performance) -> SizingResult:
        value = {
            Objective.max_excess_time: float(np.min(simulated.cycle.excess_time_h)),
            Objective.min_wingspan: float(simulated.design.variables.wingspan_m),
            Objective.min_mass: float(simulated.design.total_mass_kg),
        }[self.objective]
        return SizingResult(
            status="optimal",
            objective=self.objective,
            required_excess_time_h=self.required_h,
            objective_value=value,
            design=_plain(simulated.design),
            simulated=simulated,
            nearest=None,
            active_constraints=self._active(answer),
            violations=(),
            solver=self._report(),
            optimum=Optimum(
                x=answer["x"],
                constraint_prices=answer["lam_g"],
                filled=tuple(self._filled()),
                goal_h=self.goal_h,
                margin=self.margin,
            ),
        )

    def _active(self, answer: dict[str, Any]) -> tuple[str, ...]:
        problem = self.problem
        active = []
        for price, constraint in zip(np.abs(answer["lam_g"]), problem.constraints, strict=True):
            if price <= _ACTIVE_MULTIPLIER or constraint.name == "mass_budget":
                continue
            label = constraint.name
            if constraint.slot is not None:
                scenario = self.chosen[constraint.slot % len(self.chosen)]
                label += f" ({self.day.scenarios.label(scenario)})"
            active.append(label)
        for price, name in zip(answer["lam_x"], problem.variable_names, strict=False):
            if abs(price) > _ACTIVE_MULTIPLIER:
                active.append(f"{name} at its {'maximum' if price > 0 else 'minimum'}")
        return tuple(dict.fromkeys(active))

    def _explain_failure(self, starts: list[DesignVariables]) -> SizingResult:
        """Say which requirements are missed, and by how much.

        A required excess time is held against the largest one that any design has. Where no design
        flies perpetually at all, or none is required to do more, the elastic program tells what is
        missing. Where either finds that nothing is, its design starts the sizing again.
        """
        if self.required_h > 0.0:
            return self._explain_by_largest_excess(starts)
        return self._explain_by_slack(starts)

    def _explain_by_largest_excess(self, starts: list[DesignVariables]) -> SizingResult:
        best = _Search(
            self.aircraft,
            self.mission,
            self.solar,
            self.day,
            Objective.max_excess_time,
            0.0,
        )
        largest = best.run()
        self.iterations += best.iterations
        self.solve_s += best.solve_s
        self.build_s += best.build_s
        self.solves += best.solves
        self.message = best.message
        if largest.simulated is None:
            return self._no_perpetual_flight(largest)
        reached_h = float(np.min(largest.simulated.cycle.excess_time_h))
        if reached_h < self.required_h:
            shortfall_h = self.required_h - reached_h
            text = self._words("excess_time", shortfall_h, largest.simulated)
            missed = Violation("excess_time", shortfall_h, text)
            self.held = largest.active_constraints
            return self._failed("infeasible", (missed,), largest.simulated)
        if self.objective is Objective.max_excess_time:
            return replace(largest, required_excess_time_h=self.required_h, solver=self._report())
        # The cushion must not ask for more than there is.
        self.goal_h = min(self.goal_h, max(reached_h - _GOAL_CUSHION_H / 4.0, 0.0))
        answer = self._solve_from([variables_of_design(largest.simulated.design), *starts])
        return self._given_up(largest.simulated) if answer is None else self._last(answer)

    def _no_perpetual_flight(self, largest: SizingResult) -> SizingResult:
        """No design that meets all else flies perpetually, let alone for the required time."""
        missed = [v for v in largest.violations if v.requirement != "excess_time"]
        nearest = largest.nearest
        if nearest is not None:
            worst_h = float(np.min(nearest.cycle.excess_time_h))
            shortfall_h = self.required_h - worst_h
            # The nearest design may fly long enough and miss another requirement.
            if shortfall_h > 0.0:
                text = self._words("excess_time", shortfall_h, nearest)
                missed.append(Violation("excess_time", shortfall_h, text))
        self.held = largest.active_constraints
        return self._failed(largest.status, tuple(missed), nearest)

    def _explain_by_slack(self, starts: list[DesignVariables]) -> SizingResult:
        elastic = None
        for effort in _ELASTIC_EFFORTS:
            self.problem = self._build(self.problem.slots, effort)
            elastic = self._solve_from(starts, elastic=True)
            if elastic is not None:
                break
        if elastic is None:
            answer = self._solve_from(starts)
            nearest = self._simulate(starts[0])
            return self._given_up(nearest) if answer is None else self._last(answer)
        slack = elastic["x"][-len(self.problem.slack_names) :]
        nearest = self._simulate(self._variables(elastic))
        if np.max(slack) <= _SLACK_TOLERANCE or self._accepts(nearest):
            answer = self._solve_from([self._variables(elastic), *starts])
            return self._given_up(nearest) if answer is None else self._last(answer)
        self.held = self._active(elastic)
        violations = tuple(
            Violation(name, float(value), self._words(name, float(value), nearest))
            for name, value in zip(self.problem.slack_names, slack, strict=True)
            if value > _SLACK_TOLERANCE
        )
        return self._failed("infeasible", violations, nearest)

    def _accepts(self, perf: Performance) -> bool:
        """Whether a closed design meets every requirement, also those on the aircraft itself."""
        worst_h = float(np.min(perf.cycle.excess_time_h))
        heaviest = self.aircraft.design_space.maximum_total_mass_kg or np.inf
        rows = design_rows(self.aircraft, self.mission, perf.design)
        flyable = float(perf.design.total_mass_kg) <= heaviest and all(
            float(value) >= -_SLACK_TOLERANCE for name, value in rows if name != "mass_budget"
        )
        return flyable and worst_h > 0.0 and worst_h >= self.required_h

    def _given_up(self, nearest: Performance) -> SizingResult:
        return self._failed("not_converged", (), nearest)

    def _last(self, answer: dict[str, Any]) -> SizingResult:
        self.rescues += 1
        if self.rescues > _RESCUES:
            return self._given_up(self._simulate(self._variables(answer)))
        return self._agree_with_simulator(answer)

    def _words(self, name: str, shortfall: float, nearest: Performance) -> str:
        worst = nearest.worst_scenario()
        where = self.day.scenarios.label(worst)
        excess = float(nearest.cycle.excess_time_h[worst])
        percent = f"{100.0 * shortfall:.0f} %" if shortfall > 0.1 else f"{100.0 * shortfall:.2g} %"
        short = f"at {where}: short by {percent} of its capacity"
        return {
            "mass_budget": f"no design carries its own mass: {percent} of it cannot be lifted",
            "module_coverage": f"the modules need {percent} more wing area than there is",
            "airspeed_above_wind": (
                f"airspeed stays {percent} below the wind of {self.mission.wind_m_per_s:g} m/s"
            ),
            "wing_loading": f"the wing loading exceeds its limit by {percent}",
            "battery_capacity": f"the battery cannot carry the night {short}",
            "energy_balance": f"the day does not recharge the battery {short}",
            "excess_time": (
                f"an excess time of {self.required_h:g} h is out of reach at {where}: the nearest "
                f"design has {excess:.2f} h"
            ),
        }[name]

    def _failed(
        self, status: str, violations: tuple[Violation, ...], nearest: Performance | None
    ) -> SizingResult:
        return SizingResult(
            status=status,
            objective=self.objective,
            required_excess_time_h=self.required_h,
            objective_value=None,
            design=None,
            simulated=None,
            nearest=nearest,
            active_constraints=self.held,
            violations=violations,
            solver=self._report(),
        )

    def _report(self) -> SolverReport:
        return SolverReport(self.iterations, self.solve_s, self.build_s, self.solves, self.message)


def _value(result: SizingResult) -> float:
    assert result.objective_value is not None  # kept results are optima
    return result.objective_value


def variables_of_design(design: Design) -> DesignVariables:
    """Design variables of a single design, as floats."""
    return DesignVariables(*(float(v) for v in design.variables))


def _telling_scenarios(first: Performance, count: int) -> list[int]:
    """Scenarios likely to drive the sizing: least excess time, and least sun for their load."""
    cycle = first.cycle
    short_of_sun = int(np.argmin(cycle.account.solar_wh / cycle.account.load_wh))
    by_excess = np.argsort(cycle.excess_time_h, kind="stable").tolist()
    dark = [i for i in by_excess if cycle.status[i] != Status.always_lit] or by_excess
    return list(dict.fromkeys([dark[0], short_of_sun, *dark, *by_excess]))[:count]


def _plain(design: Design) -> Design:
    """Turn a design of zero-dimensional arrays into one of floats."""
    return Design(
        variables=DesignVariables(*(float(v) for v in design.variables)),
        total_mass_kg=float(design.total_mass_kg),
        masses=Masses(*(float(m) for m in design.masses)),
        battery_energy_wh=float(design.battery_energy_wh),
        propulsion_power_w=float(design.propulsion_power_w),
        constant_power_w=float(design.constant_power_w),
        airspeed_m_per_s=float(design.airspeed_m_per_s),
    )
