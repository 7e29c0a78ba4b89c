"""Sizing: the best wingspan, battery mass and module area for a mission, or why there is none."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.design import Design, DesignVariables, Masses, variables_of
from sizing.limits import design_requirements
from sizing.optimisation.agreement import GOAL_CUSHION_H, Agreed, Agreement, telling_scenarios
from sizing.optimisation.energy_constraints import lowest_sun_parameters, never_dark
from sizing.optimisation.objectives import Objective, without_battery
from sizing.optimisation.problem import TECHNOLOGY, Effort, SizingProblems
from sizing.optimisation.result import (
    Optimum,
    SizingResult,
    SolverReport,
    Violation,
    objective_value,
)
from sizing.optimisation.solver import Answer, ProgramSolver, Question
from sizing.parameters import with_parameter
from sizing.performance import Performance, performance_of_designs
from sizing.sunlight import DEFAULT_STEP_H, UNCORRECTED_CAM, SolarDay, SolarModel, solar_day
from solar.types import FloatArray

__all__ = ["SizingResult", "SolverReport", "Violation", "size_aircraft"]

_ACTIVE_MULTIPLIER = 1e-5
_RESCUES = 3
_ELASTIC_EFFORTS: tuple[Effort, ...] = ("quick", "steady", "patient")
_GRID_POINTS = 9
_GRID_STEP_H = 0.5


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
) -> SizingResult:
    """Find the best design of a parametric aircraft for a mission.

    Parameters
    ----------
    aircraft : Aircraft
        Technology, bounds of the design variables, and a first guess (its own design point).
    mission : Mission
        Latitudes, dates, air, payload and wind.
    objective : Objective
        ``max_excess_time`` of the worst scenario, or another one with a required excess time in
        every scenario. For the objectives that are a range of days or latitudes see
        :func:`sizing.optimisation.coverage.widest_range`.
    solar : SolarModel
        Solar power model and its correction.
    required_excess_time_h : float, optional
        Overrides the mission's own [h]. For ``max_excess_time`` it is a bound from below.
    day : SolarDay, optional
        Specific power of the scenarios where it is known already.
    step_h : float
        Time step of the simulator [h].
    problems : SizingProblems, optional
        Programs of this very aircraft, from an earlier sizing: nothing is built again.
    start : DesignVariables, optional
        First guess, for instance the optimum of a similar mission.
    explain : bool
        Whether to find out why a search fails. If not, it ends as ``not_converged``: faster, for
        searches in which failures are many and their reasons idle.

    Returns
    -------
    SizingResult

    Raises
    ------
    TypeError
        For a measured aircraft.
    ValueError
        For an objective that is a range, or programs of another aircraft.
    """
    if isinstance(aircraft.airframe, MeasuredAirframe):
        raise TypeError(f"{aircraft.name} is a measured aircraft: it has no mass budget to size")
    if objective.of_range:
        raise ValueError(f"{objective.value} is a range: use widest_range")
    if problems is not None and problems.aircraft is not aircraft:
        raise ValueError("the programs belong to another aircraft")
    required = mission.required_excess_time_h
    required = required if required_excess_time_h is None else required_excess_time_h
    lit = solar_day(aircraft, mission, solar, step_h=step_h) if day is None else day
    problems = problems or SizingProblems(aircraft)
    endless = None
    if never_dark(lit).all() and (required > 0.0 or objective is Objective.max_excess_time):
        without = ProgramSolver(problems, mission, lit)
        without.suns = lowest_sun_parameters(lit, mission)
        search = _Search(without, solar, objective, required, start, explain=False, battery=False)
        endless = search.run()
        if endless.feasible and objective is Objective.max_excess_time:
            return endless
    solver = ProgramSolver(problems, mission, lit)
    if endless is None or not endless.feasible:
        return _Search(solver, solar, objective, required, start, explain).run()
    return _better(_Search(solver, solar, objective, required, start, explain=False).run(), endless)


def _better(one: SizingResult, other: SizingResult) -> SizingResult:
    """Better of two results of the same question, of which the second is an optimum."""
    if one.objective_value is None or other.objective_value is None:
        return other
    gain = one.objective_value - other.objective_value
    return one if (gain > 0.0) is one.objective.maximised else other


class _Search:
    """One sizing: its starts, its growing set of scenarios, and the verdict."""

    def __init__(
        self,
        solver: ProgramSolver,
        solar: SolarModel,
        objective: Objective,
        required_h: float,
        start: DesignVariables | None = None,
        explain: bool = True,
        battery: bool = True,
    ) -> None:
        self.explain, self.battery = explain, battery
        self.solver, self.solar = solver, solar
        self.aircraft, self.mission, self.day = solver.aircraft, solver.mission, solver.day
        self.objective, self.required_h = objective, required_h
        self.start = variables_of(self.aircraft) if start is None else start
        cushion_h = 0.0 if objective is Objective.max_excess_time else GOAL_CUSHION_H
        question = Question.of(objective, required_h + cushion_h)
        if not battery:
            question = Question.of(without_battery(objective), 0.0)
        self.agreement = Agreement(
            solver,
            question,
            required_h,
            self._simulate,
            self._merit,
        )
        self.rescues = 0
        self.held: tuple[str, ...] = ()

    def run(self) -> SizingResult:
        first = self._simulate_design(self.start)
        self.agreement.chosen = telling_scenarios(first, self.agreement.slots)
        answer = self.agreement.ask_softly(self.start, efforts=("quick",))
        if answer is None:
            answer = self.agreement.ask([self.start])
            return self._failure(first) if answer is None else self._settled(answer)
        if answer.missed() and self.explain:
            return self._explain_failure([answer.variables])
        if answer.missed():
            answer = self._met_after_all(answer)
        return self._given_up(first) if answer is None else self._settled(answer)

    def _met_after_all(self, answer: Answer) -> Answer | None:
        """Answer where the price of a miss was too low to keep it from being paid."""
        agreement = self.agreement
        least = agreement.ask_softly(
            answer.variables,
            previous=answer,
            efforts=("quick",),
            question=agreement.question.elastically(),
        )
        if least is not None and least.missed():
            return None
        return agreement.ask([answer.variables if least is None else least.variables])

    def _settled(self, answer: Answer) -> SizingResult:
        agreed = self.agreement.settle(answer)
        if agreed is None:
            return self._failure(self._simulate(answer))
        return self._optimal(agreed)

    def _failure(self, nearest: Performance) -> SizingResult:
        return (
            self._explain_failure(self._grid_starts()) if self.explain else self._given_up(nearest)
        )

    def _grid_starts(self) -> list[DesignVariables]:
        """Most promising designs of a coarse grid over the design space, best first."""
        space = self.aircraft.design_space
        axes = [
            np.geomspace(r.minimum, r.maximum, _GRID_POINTS)
            for r in (space.wingspan_m, space.battery_mass_kg, space.module_area_m2)
        ]
        span, battery, area = (v.ravel() for v in np.meshgrid(*axes, indexing="ij"))
        airframe = self.aircraft.airframe
        aspect = airframe.aspect_ratio
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
        return [variables.mapped(partial(_item, int(i))) for i in best]

    # --- verdicts ----------------------------------------------------------------------------

    def _simulate(self, answer: Answer) -> Performance:
        return self._simulate_design(answer.variables)

    def _simulate_design(self, variables: DesignVariables) -> Performance:
        return performance_of_designs(
            self.aircraft, self.mission, variables, self.solar, day=self.day
        )

    def _merit(self, answer: Answer, perf: Performance) -> float:
        value = float(objective_value(self.objective, perf))
        return value if self.objective.maximised else -value

    def _optimal(self, agreed: Agreed) -> SizingResult:
        answer, simulated = agreed.answer, agreed.simulated
        return SizingResult(
            status="optimal",
            objective=self.objective,
            required_excess_time_h=self.required_h,
            objective_value=float(objective_value(self.objective, simulated)),
            design=plain_design(simulated.design),
            simulated=simulated,
            nearest=None,
            active_constraints=self._active(answer),
            violations=(),
            solver=self.solver.report(),
            optimum=Optimum(
                x=answer.x,
                constraints=answer.problem.constraints,
                constraint_prices=answer.constraint_prices,
                bound_prices=_free_bound_prices(answer),
                filled=answer.filled,
                weights=answer.weights,
                margin=answer.question.margin,
                needs_no_battery=not self.battery,
            ),
        )

    def _active(self, answer: Answer) -> tuple[str, ...]:
        problem = answer.problem
        active = []
        prices = np.abs(answer.constraint_prices)
        for price, constraint in zip(prices, problem.constraints, strict=True):
            if price <= _ACTIVE_MULTIPLIER or constraint.name == "mass_budget":
                continue
            label = constraint.name
            if constraint.slot is not None:
                label += f" ({self.day.scenarios.label(answer.filled[constraint.slot])})"
            active.append(label)
        for name, price in _free_bound_prices(answer).items():
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
        solver = ProgramSolver(self.solver.problems, self._least_mission(), self.day)
        largest = _Search(solver, self.solar, Objective.max_excess_time, 0.0).run()
        self.solver.add(solver)
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
            return replace(
                largest, required_excess_time_h=self.required_h, solver=self.solver.report()
            )
        # The cushion must not ask for more than there is.
        agreement = self.agreement
        agreement.cushion_h = min(agreement.cushion_h, (reached_h - self.required_h) / 4.0)
        goal_h = self.required_h + agreement.cushion_h
        agreement.question = replace(agreement.question, goal_h=goal_h)
        nearest = largest.simulated.design.variables.mapped(float)
        answer = self.agreement.ask([nearest, *starts])
        return self._given_up(largest.simulated) if answer is None else self._last(answer)

    def _least_mission(self) -> Mission:
        """Mission without the payload that is asked for: the easiest one."""
        if self.objective is Objective.max_payload_mass:
            return with_parameter(self.aircraft, self.mission, "mission.payload.mass_kg", 0.0)[1]
        if self.objective is Objective.max_payload_power:
            return with_parameter(self.aircraft, self.mission, "mission.payload.power_w", 0.0)[1]
        return self.mission

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
        agreement = self.agreement
        elastic = self._least_missed(starts)
        if elastic is None:
            answer = agreement.ask(starts)
            nearest = self._simulate_design(starts[0])
            return self._given_up(nearest) if answer is None else self._last(answer)
        missed = elastic.missed()
        nearest = self._simulate(elastic)
        if not missed or agreement.accepts(nearest):
            answer = agreement.ask([elastic.variables, *starts])
            return self._given_up(nearest) if answer is None else self._last(answer)
        self.held = self._active(elastic)
        violations = tuple(
            Violation(name, value, self._words(name, value, nearest))
            for name, value in missed.items()
        )
        return self._failed("infeasible", violations, nearest)

    def _least_missed(self, starts: list[DesignVariables]) -> Answer | None:
        question = self.agreement.question.elastically()
        for effort in _ELASTIC_EFFORTS:
            elastic = self.agreement.ask(starts, effort=effort, question=question)
            if elastic is not None:
                return elastic
        return None

    def _given_up(self, nearest: Performance) -> SizingResult:
        return self._failed("not_converged", (), nearest)

    def _last(self, answer: Answer) -> SizingResult:
        self.rescues += 1
        if self.rescues > _RESCUES:
            return self._given_up(self._simulate(answer))
        return self._settled(answer)

    def _words(self, name: str, shortfall: float, nearest: Performance) -> str:
        worst = nearest.worst_scenario()
        where = self.day.scenarios.label(worst)
        excess = float(nearest.cycle.excess_time_h[worst])
        percent = f"{100.0 * shortfall:.0f} %" if shortfall > 0.1 else f"{100.0 * shortfall:.2g} %"
        short = f"at {where}: short by {percent} of its capacity"
        texts = {
            one.name: one.text.format(missed=percent)
            for one in design_requirements(self.aircraft, nearest.design, self.solver.conditions)
        }
        texts |= {
            "battery_capacity": f"the battery cannot carry the night {short}",
            "energy_balance": f"the day does not recharge the battery {short}",
            "excess_time": (
                f"an excess time of {self.required_h:g} h is out of reach at {where}: the nearest "
                f"design has {excess:.2f} h"
            ),
        }
        return texts[name]

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
            solver=self.solver.report(),
        )


def _free_bound_prices(answer: Answer) -> dict[str, float]:
    """Prices of the bounds of all variables that are not held at a value."""
    held = {*TECHNOLOGY, "payload_mass_kg", "payload_power_w"} - set(answer.question.freed)
    names = answer.problem.variable_names
    prices = zip(names, answer.bound_prices.tolist(), strict=False)
    return {name: price for name, price in prices if name not in held}


def _item(index: int, values: FloatArray) -> float:
    return float(values[index])


def plain_design(design: Design) -> Design:
    """Turn a design of zero-dimensional arrays into one of floats."""
    return Design(
        variables=design.variables.mapped(float),
        total_mass_kg=float(design.total_mass_kg),
        masses=Masses(*(float(m) for m in design.masses)),
        battery_energy_wh=float(design.battery_energy_wh),
        propulsion_power_w=float(design.propulsion_power_w),
        constant_power_w=float(design.constant_power_w),
        airspeed_m_per_s=float(design.airspeed_m_per_s),
    )
