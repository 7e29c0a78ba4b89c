"""Cross-check of an optimum: whether the simulator finds any better design.

A grid over the design space and random neighbours of the optimum are simulated, and the best of
them with a fine time step as well. A search is no proof.
"""

from __future__ import annotations

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
    objective, flown = result.objective, result.simulated
    fine_day = solar_day(aircraft, mission, solar, step_h=FINE_STEP_H)

    def merit(variables: DesignVariables, light: SolarDay) -> FloatArray:
        """Merit; NaN for designs that miss a requirement, by more than the time step allows."""
        perf = performance_of_designs(aircraft, mission, variables, solar, day=light)
        worst_h = np.min(perf.cycle.excess_time_h, axis=-1)
        least_h = result.required_excess_time_h - ABSOLUTE_TOLERANCE_H * (light is fine_day)
        kept = (worst_h > 0.0) & (worst_h >= least_h)
        kept = kept & meets_requirements(aircraft, perf.design)
        return np.where(kept, merit_of(objective, perf), np.nan)

    optimum, grid = result.design.variables, grid_of(aircraft).chosen()
    bounds = {v.name: (v.minimum, v.maximum) for v in chosen_variables(aircraft)}
    rng, on_grid, designs = np.random.default_rng(seed), np.size(grid["wingspan_m"]), {}
    for name, value in optimum.mapped(float).chosen().items():
        around = value * np.exp(_SPREADS * rng.standard_normal(len(_SPREADS)))
        around = np.clip(around, *bounds.get(name, (value, value)))
        designs[name] = np.append(np.zeros(on_grid) + np.asarray(grid.get(name, value)), around)
    tried = DesignVariables(**designs)
    own, fine, merits = merit(optimum, flown.day), merit(optimum, fine_day), merit(tried, flown.day)
    finalists = np.argsort(-merits, kind="stable")[:_FINALISTS]  # NaN last
    confirmed = ~np.isnan(merit(tried.mapped(lambda v: np.asarray(v)[finalists]), fine_day))
    least = -np.inf if np.isnan(own) else own
    better = [i for i in finalists[confirmed] if merits[i] > least]
    # Not by a difference: the excess time is infinite where the battery is never needed.
    best, advantage = (merits[better[0]], merits[better[0]] - least) if better else (own, 0.0)
    # A payload is what is left of a mass, or of a load, that is known to a tolerance itself.
    tolerances = {
        Objective.max_excess_time: ABSOLUTE_TOLERANCE_H,
        Objective.max_payload_mass: ROW_TOLERANCE * result.design.total_mass_kg,
        Objective.max_payload_power: ROW_TOLERANCE * np.max(flown.nominal_load_w),
    }
    tolerance = max(RELATIVE_TOLERANCE * abs(own), tolerances.get(objective, 0.0))
    sign = 1.0 if objective.maximised else -1.0
    return CrossCheck(
        cross_checked=bool(
            advantage <= tolerance and (fine == own or abs(fine - own) <= tolerance)
        ),
        objective_value=sign * float(own),
        fine_step_value=sign * float(fine),
        best_found=sign * float(best),
        advantage=float(advantage),
        found_by=("grid" if better[0] < on_grid else "neighbours") if better else "optimum",
        designs_tried=len(merits),
    )
