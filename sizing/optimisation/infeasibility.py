"""Why there is no design: the requirements that are missed, by how much, and in words.

A required excess time is held against the largest one that any design has. Where no design flies
perpetually at all, or none is required to do more, the program that misses as little as possible
tells what is missing.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import DesignVariables, FlightConditions, parametric_design
from sizing.held_station import POWER_AGAINST_WIND
from sizing.limits import Requirement, design_requirements
from sizing.optimisation.result import SizingResult, SizingStatus, Violation
from sizing.optimisation.solver import ProgramSolver
from sizing.parameters import with_parameter
from sizing.performance import Performance, performance_of_designs
from sizing.program.objectives import Objective
from solar.types import FloatArray

# Points of span, battery and modules each, by the number of other free variables.
_GRID_POINTS = (9, 7, 6)
_GRID_STEP_H = 0.5
_FEW_POINTS = 3
_PROMISING = 3
# Masses that a design might have, as multiples of its payload and battery.
_HEAVIER = np.geomspace(1.0, 100.0, 9)


def least_mission(mission: Mission, objective: Objective) -> Mission:
    """Mission without the payload that is to be as large as possible: the easiest one."""
    if objective.payload_key is None:
        return mission
    return with_parameter(mission, mission, objective.payload_key, 0.0)[1]


def short_of_largest_excess(
    aircraft: Aircraft, largest: SizingResult, required_h: float
) -> SizingResult | None:
    """Verdict where even the largest excess time is too short; None where it is enough."""
    if not largest.feasible and largest.status is not SizingStatus.infeasible:
        return largest
    nearest = largest.nearest if largest.simulated is None else largest.simulated
    # Where no design flies perpetually, what else is missing comes first.
    missed = [v for v in largest.violations if v.requirement != "excess_time"]
    if nearest is not None:
        shortfall_h = required_h - float(np.min(nearest.cycle.excess_time_h))
        if largest.simulated is not None and shortfall_h <= 0.0:
            return None
        # The nearest design may fly long enough and miss another requirement; where none is
        # required, what else is missing says it all.
        if shortfall_h > 0.0 and (required_h > 0.0 or not missed):
            missed += violations(aircraft, {"excess_time": shortfall_h}, nearest, required_h)
    return largest.without_design(SizingStatus.infeasible, nearest, *missed)


def violations(
    aircraft: Aircraft,
    missed: Mapping[str, float],
    nearest: Performance,
    required_h: float,
    active: Sequence[str] = (),
) -> list[Violation]:
    """Missed requirements in words.

    ``missed``: shortfall by name of the requirement: relative, or in hours of excess time.
    ``active``: names of what limits, which have the scenario in which it does.
    """
    worst = nearest.worst_scenario()
    conditions = FlightConditions.of(nearest.mission, aircraft)
    with np.errstate(invalid="ignore"):  # the nearest design may be impossible
        rows = design_requirements(aircraft, nearest.design, conditions)
    parts = [name.removesuffix(")").partition(" (") for name in reversed(active)]
    places = {name: where for name, _, where in parts if where}
    least_h, somewhere = (
        float(nearest.cycle.excess_time_h[worst]),
        nearest.day.scenarios.label(worst),
    )
    found = []
    for name, shortfall in missed.items():
        where = places.get(name, somewhere)
        text = texts_of_requirements(rows, where, required_h, least_h)[name]
        found.append(Violation(name, shortfall, text.format(missed=percent(shortfall))))
    return found


def texts_of_requirements(
    of_design: Iterable[Requirement], where: str, required_h: float, excess_h: float
) -> dict[str, str]:
    """What is wrong where a requirement is missed, by its name; ``{missed}`` is by how much."""
    return {one.name: one.text for one in of_design} | {
        "battery_capacity": f"the battery cannot carry the night at {where}: short by {{missed}} "
        "of its capacity",
        "energy_balance": f"the day does not recharge the battery at {where}: short by {{missed}} "
        "of its capacity",
        POWER_AGAINST_WIND: f"flight as fast as the wind at {where} takes {{missed}} more than the "
        "rated power",
        "excess_time": f"an excess time of {required_h:g} h is out of reach at {where}: the "
        f"nearest design has {excess_h:.2f} h",
    }


def percent(value: float) -> str:
    """Shortfall in words, with two digits where it is small."""
    return f"{100.0 * value:.0f} %" if value > 0.1 else f"{100.0 * value:.2g} %"


class Promising(NamedTuple):
    """A design of a coarse grid, its worst excess time on coarse steps [h], and what it misses.

    ``missed`` is the sum of what limits and requirements on the design itself are missed by,
    relative.
    """

    design: DesignVariables
    excess_time_h: float
    missed: float


@lru_cache(maxsize=1)  # a verdict may ask for them again
def promising_designs(solver: ProgramSolver) -> list[Promising]:
    """Designs of a coarse grid over the design space that come nearest to a feasible one.

    Those that fly perpetually and miss least, of equals those of the largest excess time; after
    them the others by their excess time. Empty where no design of the grid has room for its
    modules.
    """
    aircraft, mission, solar = solver.aircraft, solver.mission, solver.solar
    variables = _grid(aircraft)
    airframe = aircraft.airframe
    coverage = getattr(airframe, "maximum_module_coverage", 1.0)
    fits = variables.module_area_m2 <= coverage * variables.wingspan_m**2 / variables.aspect_ratio
    if not np.any(fits):
        return []
    variables = variables.mapped(lambda v: np.asarray(v)[fits])
    day = solver.day
    steps = round(_GRID_STEP_H / float(day.time_h[1]))
    coarse = day.coarsened(steps) if steps and not (len(day.time_h) - 1) % steps else day
    flight = performance_of_designs(aircraft, mission, variables, solar, day=coarse)
    excess_h = np.min(flight.cycle.excess_time_h, axis=-1)
    missed = _missed_of(aircraft, flight)
    best = np.lexsort((-excess_h, np.where(excess_h > 0.0, missed, np.inf)))[:_PROMISING]
    return [
        Promising(
            variables.mapped(itemgetter(int(i))).mapped(float), float(excess_h[i]), float(missed[i])
        )
        for i in best
    ]


def least_unlifted(aircraft: Aircraft, mission: Mission) -> float:
    """Part of its own mass that no design of the coarse grid can lift, at whatever mass it has.

    Zero or less where a design of the grid can; relative to the mass that is lifted.
    """
    conditions = FlightConditions.of(mission, aircraft)
    designs = _grid(aircraft).mapped(lambda v: np.asarray(v)[:, np.newaxis])
    payload_kg = float(conditions.payload_mass_kg)
    assumed_kg = (payload_kg + np.asarray(designs.battery_mass_kg)) * _HEAVIER
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        budget_kg = parametric_design(aircraft, conditions, designs, assumed_kg).masses.total_kg
        unlifted = np.asarray(budget_kg) / assumed_kg - 1.0
    return float(np.min(unlifted, initial=np.inf, where=np.isfinite(unlifted)))


def _missed_of(aircraft: Aircraft, flight: Performance) -> FloatArray:
    """Sum of what closed designs miss their requirements by, relative."""
    mass_kg = np.asarray(flight.design.total_mass_kg)
    heaviest_kg = aircraft.design_space.maximum_total_mass_kg or np.inf
    conditions = FlightConditions.of(flight.mission, aircraft)
    with np.errstate(invalid="ignore"):
        missed = np.maximum(mass_kg / heaviest_kg - 1.0, 0.0)
        for row in design_requirements(aircraft, flight.design, conditions)[1:]:  # mass is closed
            missed = missed + np.maximum(-np.asarray(row.value), 0.0)
    return np.where(np.isfinite(missed), missed, np.inf)


def _grid(aircraft: Aircraft) -> DesignVariables:
    """Designs on a grid, evenly spaced in their logarithm; a few values of what else is free."""
    space, airframe = aircraft.design_space, aircraft.airframe
    shape, lift = space.aspect_ratio, space.lift_coefficient
    points = _GRID_POINTS[(shape is not None) + (lift is not None)]
    axes = [
        np.geomspace(r.minimum, r.maximum, points)
        for r in (space.wingspan_m, space.battery_mass_kg, space.module_area_m2)
    ]
    axes.append(
        np.array([airframe.aspect_ratio])
        if shape is None
        else np.geomspace(shape.minimum, shape.maximum, _FEW_POINTS)
    )
    if lift is not None:
        axes.append(np.geomspace(lift.minimum, lift.maximum, _FEW_POINTS))
    span, battery, area, aspect, *rest = (v.ravel() for v in np.meshgrid(*axes, indexing="ij"))
    return DesignVariables(span, aspect, battery, area, *rest)
