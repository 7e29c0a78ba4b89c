"""Sizing: the best wingspan, battery mass and module area for a mission, or why there is none."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft, Range
from sizing.design import Design, DesignVariables, Masses, closed_design, variables_of
from sizing.energy_balance import FloatArray
from sizing.performance import (
    DEFAULT_STEP_H,
    Performance,
    SolarDay,
    SolarModel,
    performance_of_designs,
    solar_day,
)
from sizing.sizing_problem import Objective, SizingProblem, build_problem

# A requirement missed by less than this (relative) is met: the solver's own tolerance is 1e-8.
_SLACK_TOLERANCE = 1e-5
_ACTIVE_MULTIPLIER = 1e-6


@dataclass(frozen=True)
class Violation:
    """A requirement that no design within its bounds can meet.

    ``shortfall`` is relative: of the load's energy for the energy requirements, of the limit for
    the others.
    """

    requirement: str
    shortfall: float
    text: str


@dataclass(frozen=True)
class SolverReport:
    """What the solver did."""

    iterations: int
    time_s: float
    build_time_s: float
    starts: int
    message: str


@dataclass(frozen=True)
class SizingResult:
    """Outcome of a sizing: an optimum, or the requirements that cannot be met.

    ``status`` is ``optimal``, ``infeasible`` or ``not_converged``; the design, its simulated
    performance and the objective exist for an optimum alone. ``nearest`` is the simulated design
    that comes closest where none is feasible.
    """

    status: str
    objective: Objective
    objective_value: float | None
    design: Design | None
    simulated: Performance | None
    nearest: Performance | None
    active_constraints: tuple[str, ...]
    violations: tuple[Violation, ...]
    solver: SolverReport

    @property
    def feasible(self) -> bool:
        """Whether an optimum was found."""
        return self.status == "optimal"


def size_aircraft(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective = Objective.max_excess_time,
    solar: SolarModel = SolarModel(),
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

    Returns
    -------
    SizingResult

    Raises
    ------
    TypeError
        For a measured aircraft.
    """
    required = mission.required_excess_time_h
    required = required if required_excess_time_h is None else required_excess_time_h
    lit = solar_day(aircraft, mission, solar, step_h=step_h) if day is None else day
    begun = time.perf_counter()
    problem = build_problem(aircraft, mission, lit, objective, required)
    build_s = time.perf_counter() - begun
    return _Search(aircraft, mission, solar, lit, problem, required, build_s).run()


class _Search:
    """One sizing: starts, fallbacks and the verdict."""

    def __init__(
        self,
        aircraft: Aircraft,
        mission: Mission,
        solar: SolarModel,
        day: SolarDay,
        problem: SizingProblem,
        required_h: float,
        build_s: float,
    ) -> None:
        self.aircraft, self.mission, self.solar, self.day = aircraft, mission, solar, day
        self.problem, self.required_h, self.build_s = problem, required_h, build_s
        self.iterations, self.solve_s, self.starts, self.message = 0, 0.0, 0, ""

    def run(self) -> SizingResult:
        start = self._start(variables_of(self.aircraft))
        answer = self._solve(start, elastic=False)
        if answer is None:
            elastic = self._solve(start, elastic=True)
            for scattered in self._scattered_starts() if elastic is None else ():
                elastic = self._solve(scattered, elastic=True)
                if elastic is not None:
                    break
            if elastic is None:
                return self._failed("not_converged", (), None)
            slack = self._slack(elastic)
            if np.max(slack) > _SLACK_TOLERANCE:
                return self._infeasible(elastic, slack)
            for retry in (elastic["x"], *self._scattered_starts()):
                answer = self._solve(np.asarray(retry).ravel(), elastic=False)
                if answer is not None:
                    break
        if answer is None:
            return self._failed("not_converged", (), None)
        return self._optimal(answer)

    # --- solving -----------------------------------------------------------------------------

    def _solve(self, start: FloatArray, *, elastic: bool) -> dict[str, Any] | None:
        problem = self.problem
        lower, upper = self._variable_bounds(elastic)
        rows = len(problem.constraints)
        upper_rows = np.full(rows, np.inf)
        upper_rows[0] = 0.0  # the mass budget is an equation
        begun = time.perf_counter()
        answer = problem.solver(
            x0=np.clip(start, lower, upper),
            p=np.concatenate(([float(elastic)], problem.parameters)),
            lbx=lower,
            ubx=upper,
            lbg=np.zeros(rows),
            ubg=upper_rows,
        )
        self.solve_s += time.perf_counter() - begun
        stats = problem.solver.stats()
        self.iterations += int(stats["iter_count"])
        self.starts += 1
        self.message = str(stats["return_status"])
        return dict(answer) if stats["success"] else None

    def _variable_bounds(self, elastic: bool) -> tuple[FloatArray, FloatArray]:
        problem = self.problem
        count, slacks = problem.scenario_count, len(problem.slack_names)
        lower = np.concatenate(
            (
                np.log([r.minimum for r in problem.bounds]),
                np.zeros(count),
                [self.required_h],
                np.zeros(slacks),
            )
        )
        upper = np.concatenate(
            (
                np.log([r.maximum for r in problem.bounds]),
                np.ones(count),
                [1e4],
                np.full(slacks, np.inf if elastic else 0.0),
            )
        )
        return lower, upper

    def _start(self, variables: DesignVariables) -> FloatArray:
        problem = self.problem
        closed = closed_design(self.aircraft, self.mission, variables)
        mass = float(closed.total_mass_kg)
        if not np.isfinite(mass):
            mass = 3.0 * float(variables.battery_mass_kg)
        guess = {
            "wingspan_m": float(variables.wingspan_m),
            "battery_mass_kg": float(variables.battery_mass_kg),
            "module_area_m2": max(float(variables.module_area_m2), 1e-3),
            "total_mass_kg": mass,
            "aspect_ratio": float(variables.aspect_ratio),
        }
        logs = np.log([guess[name] for name in problem.variable_names])
        return np.concatenate(
            (
                logs,
                np.full(problem.scenario_count, 0.2),
                [self.required_h + 1.0],
                np.full(len(problem.slack_names), 0.1),
            )
        )

    def _scattered_starts(self) -> list[FloatArray]:
        """Starts spread over the design space, at fixed fractions of its logarithmic extent."""
        starts = []
        for span, battery, area in ((0.3, 0.3, 0.4), (0.6, 0.5, 0.7), (0.5, 0.7, 0.6)):
            fractions = {"wingspan_m": span, "battery_mass_kg": battery, "module_area_m2": area}
            values = {
                name: _between(bounds, fractions.get(name, 0.5))
                for name, bounds in zip(
                    self.problem.variable_names, self.problem.bounds, strict=True
                )
            }
            starts.append(
                self._start(
                    DesignVariables(
                        wingspan_m=values["wingspan_m"],
                        aspect_ratio=values.get("aspect_ratio", self.problem.fixed_aspect_ratio),
                        battery_mass_kg=values["battery_mass_kg"],
                        module_area_m2=values["module_area_m2"],
                    )
                )
            )
        return starts

    # --- verdicts ----------------------------------------------------------------------------

    def _variables(self, answer: dict[str, Any]) -> DesignVariables:
        problem = self.problem
        logs = np.asarray(answer["x"]).ravel()[: len(problem.variable_names)]
        values = dict(zip(problem.variable_names, np.exp(logs), strict=True))
        return DesignVariables(
            wingspan_m=float(values["wingspan_m"]),
            aspect_ratio=float(values.get("aspect_ratio", problem.fixed_aspect_ratio)),
            battery_mass_kg=float(values["battery_mass_kg"]),
            module_area_m2=float(values["module_area_m2"]),
        )

    def _slack(self, answer: dict[str, Any]) -> FloatArray:
        count = len(self.problem.slack_names)
        return np.asarray(answer["x"]).ravel()[-count:]

    def _simulate(self, answer: dict[str, Any]) -> Performance:
        return performance_of_designs(
            self.aircraft, self.mission, self._variables(answer), self.solar, day=self.day
        )

    def _optimal(self, answer: dict[str, Any]) -> SizingResult:
        simulated = self._simulate(answer)
        design = simulated.design
        value = {
            Objective.max_excess_time: float(
                np.asarray(answer["x"]).ravel()[
                    len(self.problem.variable_names) + self.problem.scenario_count
                ]
            ),
            Objective.min_wingspan: float(design.variables.wingspan_m),
            Objective.min_mass: float(design.total_mass_kg),
        }[self.problem.objective]
        return SizingResult(
            status="optimal",
            objective=self.problem.objective,
            objective_value=value,
            design=_plain(design),
            simulated=simulated,
            nearest=None,
            active_constraints=self._active(answer),
            violations=(),
            solver=self._report(),
        )

    def _active(self, answer: dict[str, Any]) -> tuple[str, ...]:
        problem = self.problem
        prices = np.abs(np.asarray(answer["lam_g"]).ravel())
        active = []
        for price, constraint in zip(prices, problem.constraints, strict=True):
            if price <= _ACTIVE_MULTIPLIER or constraint.name == "mass_budget":
                continue
            where = constraint.scenario
            suffix = "" if where is None else f" ({self.day.scenarios.label(where)})"
            active.append(constraint.name + suffix)
        bound_prices = np.asarray(answer["lam_x"]).ravel()
        for price, name in zip(bound_prices, problem.variable_names, strict=False):
            if abs(price) > _ACTIVE_MULTIPLIER:
                active.append(f"{name} at its {'maximum' if price > 0 else 'minimum'}")
        return tuple(active)

    def _infeasible(self, answer: dict[str, Any], slack: FloatArray) -> SizingResult:
        nearest = self._simulate(answer)
        violations = tuple(
            Violation(name, float(value), self._explain(name, float(value), nearest))
            for name, value in zip(self.problem.slack_names, slack, strict=True)
            if value > _SLACK_TOLERANCE
        )
        return self._failed("infeasible", violations, nearest)

    def _explain(self, name: str, shortfall: float, nearest: Performance) -> str:
        worst = nearest.worst_scenario()
        where = self.day.scenarios.label(worst)
        excess = float(nearest.cycle.excess_time_h[worst])
        percent = f"{100.0 * shortfall:.2g} %"
        return {
            "mass_budget": f"no design carries its own mass: {percent} of the mass is missing",
            "module_coverage": f"the modules need {percent} more wing area than there is",
            "airspeed_above_wind": (
                f"airspeed stays {percent} below the wind of {self.mission.wind_m_per_s:g} m/s"
            ),
            "wing_loading": f"the wing loading exceeds its limit by {percent}",
            "battery_capacity": (
                f"the battery cannot carry the night at {where}: short by {percent} of its capacity"
            ),
            "energy_balance": (
                f"the day does not recharge the battery at {where}: short by {percent} of its "
                "capacity"
            ),
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
            objective=self.problem.objective,
            objective_value=None,
            design=None,
            simulated=None,
            nearest=nearest,
            active_constraints=(),
            violations=violations,
            solver=self._report(),
        )

    def _report(self) -> SolverReport:
        return SolverReport(
            self.iterations, self.solve_s, self.build_s, self.starts, self.message
        )


def _between(bounds: Range, fraction: float) -> float:
    return float(bounds.minimum * (bounds.maximum / bounds.minimum) ** fraction)


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
