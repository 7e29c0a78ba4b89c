"""Cross-check of an optimum: whether the simulator finds any better design.

A grid over the design space and random neighbours of the optimum are simulated, and the best of
them with a fine time step as well. A search is no proof.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import DesignVariables
from sizing.limits import ROW_TOLERANCE, meets_requirements
from sizing.performance import performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.result import (
    ABSOLUTE_TOLERANCE_H,
    RELATIVE_TOLERANCE,
    SizingResult,
    objective_value,
)
from sizing.program.start import grid_of
from sizing.sunlight import FINE_STEP_H, UNCORRECTED_CAM, SolarDay, SolarModel, solar_day
from solar.types import FloatArray

_SPREADS = np.repeat([0.03, 0.004], 200)  # of the neighbours, relative
_FINALISTS = 8


@dataclass(frozen=True)
class CrossCheck:
    """Outcome of the cross-check.

    ``cross_checked``: nothing found is better by more than the tolerance, and the fine step agrees.
    ``objective_value``: of the optimum, by the simulator. ``fine_step_value``: the same with a time
    step of one minute. ``best_found``: best objective of all designs and the optimum.
    ``advantage``: by how much that is better, in the objective's unit; zero where nothing is.
    ``found_by``: ``optimum``, ``grid`` or ``neighbours``. ``designs_tried``: that were simulated.
    """

    cross_checked: bool
    objective_value: float
    fine_step_value: float
    best_found: float
    advantage: float
    found_by: str
    designs_tried: int


def cross_check(
    aircraft: Aircraft,
    mission: Mission,
    result: SizingResult,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    seed: int = 0,
) -> CrossCheck:
    """Look for a design that is better than an optimum."""
    if result.design is None or result.simulated is None:
        raise ValueError(
            f"the sizing is {result.status.name}: only an optimum can be cross-checked"
        )
    objective, optimum, day = result.objective, result.design.variables, result.simulated.day
    fine_day = solar_day(aircraft, mission, solar, step_h=FINE_STEP_H)
    sign = 1.0 if objective.maximised else -1.0

    def value(variables: DesignVariables, light: SolarDay) -> FloatArray:
        """Objective; NaN for designs that miss a requirement, by more than the time step allows."""
        perf = performance_of_designs(aircraft, mission, variables, solar, day=light)
        worst_h = np.min(perf.cycle.excess_time_h, axis=-1)
        least_h = result.required_excess_time_h - ABSOLUTE_TOLERANCE_H * (light is fine_day)
        kept = (worst_h > 0.0) & (worst_h >= least_h)
        kept = kept & meets_requirements(aircraft, mission, perf.design)
        return np.where(kept, objective_value(objective, perf), np.nan)

    own, fine = float(value(optimum, day)), float(value(optimum, fine_day))
    tried, on_grid = _candidates(aircraft, result, np.random.default_rng(seed))
    merits = sign * value(tried, day)
    best = np.argsort(np.where(np.isnan(merits), np.inf, -merits), kind="stable")[:_FINALISTS]
    confirmed = ~np.isnan(value(tried.mapped(lambda v: np.asarray(v)[best]), fine_day))
    merit = -np.inf if np.isnan(own) else sign * own
    better = [i for i in best[confirmed] if merit < merits[i]]
    # Equal first: the excess time is infinite where the battery is never needed.
    found = sign * float(merits[better[0]]) if better else own
    advantage = float(merits[better[0]] - merit) if better else 0.0
    # A payload is what is left of a mass, or of a load, that is known to a tolerance itself.
    tolerance = max(
        RELATIVE_TOLERANCE * abs(own),
        {
            Objective.max_excess_time: ABSOLUTE_TOLERANCE_H,
            Objective.max_payload_mass: ROW_TOLERANCE * float(result.design.total_mass_kg),
            Objective.max_payload_power: ROW_TOLERANCE
            * float(np.max(result.simulated.nominal_load_w)),
        }.get(objective, 0.0),
    )
    return CrossCheck(
        cross_checked=advantage <= tolerance and (fine == own or abs(fine - own) <= tolerance),
        objective_value=own,
        fine_step_value=fine,
        best_found=found,
        advantage=advantage,
        found_by=("grid" if better[0] < on_grid else "neighbours") if better else "optimum",
        designs_tried=len(merits),
    )


def _candidates(
    aircraft: Aircraft, result: SizingResult, rng: np.random.Generator
) -> tuple[DesignVariables, int]:
    """Designs of a grid and around the optimum within its bounds; how many the grid has."""
    assert result.design is not None
    space, grid = aircraft.design_space, grid_of(aircraft).chosen()
    free = space.requested_ranges() | {
        name: getattr(space, name) for name in ("wingspan_m", "battery_mass_kg", "module_area_m2")
    }
    bounds = {name: (one.minimum, one.maximum) for name, one in free.items()}
    if result.objective.variable.startswith("payload"):
        bounds[result.objective.variable] = (0.0, np.inf)
    count, designs = np.size(grid["wingspan_m"]), {}
    for name, value in result.design.variables.mapped(float).chosen().items():
        random = value * np.exp(_SPREADS * rng.standard_normal(len(_SPREADS)))
        around = np.clip(random, *bounds.get(name, (value, value)))
        designs[name] = np.append(np.broadcast_to(np.asarray(grid.get(name, value)), count), around)
    return DesignVariables(**designs), int(count)
