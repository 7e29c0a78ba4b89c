"""Cross-check of an optimum: whether the simulator finds any better design.

A grid over the design space and random neighbours of the optimum are simulated, and the best of
them with a fine time step as well. A search is no proof.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import FINE_STEP_H, UNCORRECTED_CAM, SolarDay, SolarModel, solar_day
from sizing.design import DesignVariables
from sizing.limits import ROW_TOLERANCE, meets_requirements
from sizing.performance import performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.result import ABSOLUTE_TOLERANCE_H, RELATIVE_TOLERANCE, SizingResult, merit_of
from sizing.program.start import grid_of
from sizing.program.variables import chosen_variables
from solar.types import FloatArray

_SPREADS = (0.03, 0.004)  # of neighbours, relative: beyond and within what a program resolves
_NEIGHBOURS = 400  # of an optimum that is checked alone
_FINALISTS = 8  # designs that are simulated with a fine step as well


@dataclass(frozen=True)
class CrossCheck:
    """Outcome of the cross-check.

    ``cross_checked``: no design is better by more than the tolerance, and the fine step agrees.
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


def random_factors(
    names: Iterable[str], count: int, rng: np.random.Generator
) -> dict[str, FloatArray]:
    """Return factors on variables that make so many random neighbours of a design."""
    spread = np.repeat(_SPREADS, count // len(_SPREADS))
    return {name: np.exp(spread * rng.standard_normal(len(spread))) for name in names}


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
    objective, simulated = result.objective, result.simulated
    fine_day = solar_day(aircraft, mission, solar, step_h=FINE_STEP_H)

    def merit(variables: DesignVariables, light: SolarDay) -> FloatArray:
        """Return the merit, NaN of designs that miss a requirement by more than a step allows."""
        perf = performance_of_designs(aircraft, mission, variables, solar, day=light)
        worst_h = np.min(perf.cycle.excess_time_h, axis=-1)
        least_h = result.required_excess_time_h - ABSOLUTE_TOLERANCE_H * (light is fine_day)
        kept = (worst_h > 0.0) & (worst_h >= least_h)
        kept = kept & meets_requirements(aircraft, perf.design)
        return np.where(kept, merit_of(objective, perf), np.nan)

    optimum, grid = result.design.variables, grid_of(aircraft).chosen()
    bounds = {v.name: (v.minimum, v.maximum) for v in chosen_variables(aircraft)}
    chosen, on_grid, designs = optimum.mapped(float).chosen(), np.size(grid["wingspan_m"]), {}
    factors = random_factors(chosen, _NEIGHBOURS, np.random.default_rng(seed))
    for name, value in chosen.items():
        around = np.clip(value * factors[name], *bounds.get(name, (value, value)))
        designs[name] = np.append(np.zeros(on_grid) + np.asarray(grid.get(name, value)), around)
    tried, day = DesignVariables(**designs), simulated.day
    of_optimum, fine, merits = merit(optimum, day), merit(optimum, fine_day), merit(tried, day)
    finalists = np.argsort(-merits, kind="stable")[:_FINALISTS]  # NaN last
    confirmed = ~np.isnan(merit(tried.mapped(lambda v: np.asarray(v)[finalists]), fine_day))
    least = -np.inf if np.isnan(of_optimum) else of_optimum
    better = [i for i in finalists[confirmed] if merits[i] > least]
    # Not by a difference: the excess time is infinite where the battery is never needed.
    best, advantage = of_optimum, 0.0
    if better:
        best, advantage = merits[better[0]], merits[better[0]] - least
    # A payload is what is left of a mass, or of a load, that is known to a tolerance itself.
    tolerances = {
        Objective.max_excess_time: ABSOLUTE_TOLERANCE_H,
        Objective.max_payload_mass: ROW_TOLERANCE * result.design.total_mass_kg,
        Objective.max_payload_power: ROW_TOLERANCE * np.max(simulated.nominal_load_w),
    }
    tolerance = max(RELATIVE_TOLERANCE * abs(of_optimum), tolerances.get(objective, 0.0))
    sign = 1.0 if objective.maximised else -1.0
    return CrossCheck(
        cross_checked=bool(
            advantage <= tolerance and (fine == of_optimum or abs(fine - of_optimum) <= tolerance)
        ),
        objective_value=sign * float(of_optimum),
        fine_step_value=sign * float(fine),
        best_found=sign * float(best),
        advantage=float(advantage),
        found_by=("grid" if better[0] < on_grid else "neighbours") if better else "optimum",
        designs_tried=len(merits),
    )
