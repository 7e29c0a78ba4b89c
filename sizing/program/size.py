"""Sizing of an aircraft: the best design for a mission, or what stands in the way of any.

The program takes the sun from the flow of the aircraft's first guess, where that cools the modules;
how the simulator knows it from that for other designs (:mod:`sizing.day.module_power`) is exact at
three flows. The optimum is flown in its own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.day.light import UNCORRECTED_CAM, SolarDay, SolarModel, solar_day
from sizing.day.load import Load
from sizing.design import NO_FLIGHT_W, DesignVariables
from sizing.mass_budget import ImpossibleDesignError, closed_design, operating_trouble
from sizing.parameters import with_parameter
from sizing.performance import performance_of_designs
from sizing.program.climbing import Profile
from sizing.program.corrections import Scenario
from sizing.program.objectives import Objective, refuse_range
from sizing.program.reasons import least_mission, limits_of, missed_by, violations
from sizing.program.result import SizingResult, SizingStatus, SolverReport
from sizing.program.search import Search
from sizing.program.task import SizingTask, Values

_LIFT = "airframe.aerodynamics.lift_coefficient"
_NEGLIGIBLE_H = 0.003  # of excess time: the steps of the simulator make half as much


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
    """Find the best design of a parametric aircraft for a mission, or why there is none.

    ``required_excess_time_h``: of every scenario, instead of the mission's own. ``day``: light in
    the scenarios, where it is known already. ``start``: first guess, for instance the optimum of a
    similar mission. ``explain``: whether to find out why a search fails, and to make sure that it
    had to. ``stop_at_merit``: objective, the larger the better, at which
    the search may end. ``bounds``: of variables, in their unit, instead of those of the design
    space; equal ones hold.
    """
    if not isinstance(aircraft.airframe, ParametricAirframe):
        raise TypeError(f"{aircraft.name} is a measured aircraft: it has no mass budget to size")
    refuse_range(objective, "use widest_range")
    required_h = mission.required_excess_time_h
    if required_excess_time_h is not None:
        required_h = required_excess_time_h
    light = solar_day(aircraft, mission, solar) if day is None else day
    task = SizingTask(aircraft, mission, objective, solar, light, required_h, bounds=bounds or {})
    first = None if start is None else task.first_values(start)
    search = best_search(task, first, stop_at_merit)
    if explain and search.best is None and aircraft.propulsion.is_limited:
        _check_parts(best_search(replace(task, beyond_limits=True), first))
    result = _explained(search) if explain and search.best is None else _result(search)
    if result.design is not None:
        _check_held(task, result.design.variables)
    return result


def best_search(
    task: SizingTask,
    first: Values | None = None,
    stop_at_merit: float = math.inf,
    profiles: Mapping[int, Profile] | None = None,
) -> Search:
    """Return the better of the searches for a task: by the battery, and by a sun that never sets.

    ``first``: values to start from, with climbs along ``profiles`` by scenario.
    """

    def run(branch: SizingTask) -> Search:
        known = {n: Scenario(profile=profile) for n, profile in (profiles or {}).items()}
        return Search(branch, first, stop_at_merit, known).run()

    searches = []
    if task.has_continuous_sun:
        searches.append(run(replace(task, continuous=True)))
    unlimited = searches and searches[0].best and np.isinf(searches[0].best.excess_h).all()
    if not (task.maximises_excess and unlimited):
        searches.append(run(task))
    best = max(searches, key=lambda search: search.merit)
    kept = searches[-1] if best.best is None else best
    kept.report = sum((search.report for search in searches), SolverReport())
    return kept


def _check_held(task: SizingTask, variables: DesignVariables) -> None:
    """Refuse parts that cannot hold the wind: a search knows them near the design's airspeed."""
    if not (task.aircraft.propulsion.is_limited and task.winds_m_per_s.any()):
        return
    design = closed_design(task.aircraft, task.mission, variables.mapped(float)).over_scenarios()
    load = Load.of(task.aircraft, task.mission, design, task.day.scenarios)
    if np.any(load.without_thermals(task.mission) > NO_FLIGHT_W / 2.0):
        wind, mission = np.max(task.winds_m_per_s), task.mission
        raise ImpossibleDesignError(
            f"the propulsion of {task.aircraft.name} cannot hold the wind of {wind:.3g} m/s on "
            f"{mission.name} at {mission.altitude_m:g} m, though its rated power would: give it "
            "other parts, or ask for less wind"
        )


def _check_parts(search: Search) -> None:
    """Refuse parts that cannot do the level flight of a design that suffices without their limits.

    ``search``: beyond the limits of the parts.
    """
    task, judged = search.task, search.outcome
    if judged is None or (search.best is None and judged.flies):
        return
    design = task.design_variables(judged.values)
    if reason := operating_trouble(task.aircraft, task.mission, design):
        raise ImpossibleDesignError(reason)


def _result(search: Search) -> SizingResult:
    """Return the outcome of a search."""
    task, best, solution = search.task, search.best, search.solution
    result = SizingResult(
        status=search.status,
        objective=task.objective,
        required_excess_time_h=task.required_h,
        active_constraints=() if solution is None else tuple(it.name for it in limits_of(solution)),
        solver=search.report,
    )
    if best is None:
        nearest = None if search.nearest is None else search.nearest.flight
        return replace(result, nearest=nearest)
    return replace(result.with_design(best.flight), optimum=solution)


def _explained(search: Search) -> SizingResult:
    """Return why a search has no design, or the design after all.

    A required excess time is held against the largest one that any design has: the same program,
    with the required time free.
    """
    task, report, source = search.task, search.report, search
    if task.required_h > 0.0:
        mission = least_mission(task.aircraft, task.mission, task.objective)
        easiest = replace(
            task, mission=mission, objective=Objective.max_excess_time, required_h=0.0
        )
        first = None if search.nearest is None else search.nearest.values
        largest = best_search(easiest, first)
        report += largest.report
        if largest.best is not None and task.is_enough(largest.best.excess_h):
            # With no more payload than that design has, so that it is one of this task as well.
            again = best_search(task, largest.best.values, profiles=largest.best.profiles)
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
    violation_h = task.required_h - float(np.min(nearest.cycle.excess_time_h))
    if task.required_h > 0.0 and violation_h > 0.0 and math.isfinite(violation_h):
        missed["excess_time"] = violation_h
    missing = violations(task, nearest, missed)
    return result.without_design(nearest, *missing)


def sized_in_own_flow(
    aircraft: Aircraft, mission: Mission, objective: Objective, solar: SolarModel, **options: Any
) -> tuple[Aircraft, SizingResult]:
    """Size an aircraft, whose first guess becomes the design where the flow cools its modules.

    The result is simulated with that aircraft's own sun. Where the known one was off by more than
    next to nothing, or the design is not enough after all, the sizing is repeated from there.
    ``options``: as for :func:`size_aircraft`.
    """
    result = size_aircraft(aircraft, mission, objective, solar, **options)
    perf = result.simulated or result.nearest
    if perf is None or perf.day.cooling is None or not np.isfinite(perf.design.total_mass_kg):
        return aircraft, result
    variables = perf.design.variables.mapped(float)
    # Its design point is that of the design, as far as its file has numbers for it.
    span_m, aspect_ratio = variables.wingspan_m, variables.aspect_ratio
    guessed = aircraft.with_airframe(wingspan_m=span_m, aspect_ratio=aspect_ratio)
    if variables.lift_coefficient is not None:
        guessed, _ = with_parameter(guessed, mission, _LIFT, variables.lift_coefficient)
    if aircraft.battery.pack is None:
        guessed, _ = with_parameter(guessed, mission, "battery.mass_kg", variables.battery_mass_kg)
    if aircraft.modules.layout is None:
        guessed, _ = with_parameter(guessed, mission, "modules.area_m2", variables.module_area_m2)
    if not result.feasible:
        return guessed, result
    in_own_flow = performance_of_designs(guessed, mission, variables, solar)
    least_h, known_h = (float(np.min(it.cycle.excess_time_h)) for it in (in_own_flow, perf))
    sufficient = least_h > 0.0 and least_h >= result.required_excess_time_h
    if sufficient and (least_h == known_h or abs(least_h - known_h) < _NEGLIGIBLE_H):
        return guessed, result.with_design(in_own_flow)
    again = size_aircraft(guessed, mission, objective, solar, **options | {"start": variables})
    if sufficient and again.merit <= result.merit:
        return guessed, result.with_design(in_own_flow)
    return guessed, again
