"""Cross-check of an optimum: whether the simulator finds a better design next to it; no proof."""

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
from sizing.program.variables import chosen_variables
from solar.types import FloatArray

_SPREADS = (0.03, 0.004)  # of neighbours, relative: beyond and within what a program resolves
_NEIGHBOURS = 400  # of an optimum that is checked alone


@dataclass(frozen=True)
class CrossCheck:
    """Outcome of the cross-check, with objectives as the simulator has them.

    ``cross_checked``: no design is better by more than the tolerance, and the optimum has the same
    objective with a fine time step of one minute, ``fine_step_value``. ``advantage``: of the best
    design of all over the optimum, in the objective's unit; zero where none is better.
    """

    cross_checked: bool
    objective_value: float
    fine_step_value: float
    best_found: float
    advantage: float
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
    """Look for a design next to an optimum that is better, by the fine step as well."""
    if result.design is None or result.simulated is None:
        raise ValueError(
            f"the sizing is {result.status.name}: only an optimum can be cross-checked"
        )
    fine_day = solar_day(aircraft, mission, solar, step_h=FINE_STEP_H)

    def merits(variables: DesignVariables, light: SolarDay) -> FloatArray:
        """Return the merits, -inf of designs that miss a requirement by more than a step allows."""
        perf = performance_of_designs(aircraft, mission, variables, solar, day=light)
        worst_h = np.min(perf.cycle.excess_time_h, axis=-1)
        least_h = result.required_excess_time_h - ABSOLUTE_TOLERANCE_H * (light is fine_day)
        kept = (worst_h > 0.0) & (worst_h >= least_h) & meets_requirements(aircraft, perf.design)
        return np.where(kept, merit_of(result.objective, perf), -np.inf)

    bounds = {v.name: (v.minimum, v.maximum) for v in chosen_variables(aircraft)}
    chosen = result.design.variables.mapped(float).chosen()
    factors = random_factors(chosen, _NEIGHBOURS, np.random.default_rng(seed))
    near = {n: np.clip(v * factors[n], *bounds.get(n, (v, v))) for n, v in chosen.items()}
    # The optimum is the first of its neighbours.
    tried = DesignVariables(**{name: np.append(v, near[name]) for name, v in chosen.items()})
    of_designs = merits(tried, result.simulated.day)
    better = np.flatnonzero(of_designs >= of_designs[0])
    fine = merits(tried.mapped(lambda v: np.asarray(v)[better]), fine_day)
    best = float(of_designs[better[fine > -np.inf]].max(initial=of_designs[0]))
    optimum, confirmed = float(of_designs[0]), float(fine[0])
    # Not by a difference: the excess time is infinite where the battery is never needed.
    advantage = best - optimum if best > optimum else 0.0
    # A payload is what is left of a mass, or of a load, that is known to a tolerance itself.
    tolerances = {
        Objective.max_excess_time: ABSOLUTE_TOLERANCE_H,
        Objective.max_payload_mass: ROW_TOLERANCE * result.design.total_mass_kg,
        Objective.max_payload_power: ROW_TOLERANCE * np.max(result.simulated.nominal_load_w),
    }
    tolerance = max(RELATIVE_TOLERANCE * abs(optimum), tolerances.get(result.objective, 0.0))
    same = optimum > -np.inf and (confirmed == optimum or abs(confirmed - optimum) <= tolerance)
    sign = 1.0 if result.objective.maximised else -1.0
    optimum, confirmed, best = (
        sign * merit if merit > -np.inf else np.nan for merit in (optimum, confirmed, best)
    )
    return CrossCheck(
        cross_checked=bool(same and advantage <= tolerance),
        objective_value=optimum,
        fine_step_value=confirmed,
        best_found=best,
        advantage=advantage,
        designs_tried=len(of_designs),
    )
