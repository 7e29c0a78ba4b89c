"""Cross-check of an optimum: whether a search by simulation finds any better design.

The optimum is simulated again with a fine time step, and four searches look for a better design,
all judged by the simulator alone: a grid over the whole design space, random neighbours of the
optimum, sizings from other starting designs, and under a midnight sun those with other scenarios
always lit. A search is no proof.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import DesignVariables, variables_of
from sizing.limits import ROW_TOLERANCE, meets_requirements
from sizing.optimisation.energy_constraints import growing_lit_sets, lowest_power
from sizing.optimisation.problem import SizingProblems
from sizing.optimisation.result import (
    ABSOLUTE_TOLERANCE_H,
    RELATIVE_TOLERANCE,
    SizingResult,
    objective_value,
)
from sizing.optimisation.search import size_aircraft, size_branch
from sizing.optimisation.solver import ProgramSolver
from sizing.performance import Performance, performance_of_designs
from sizing.program.objectives import Objective
from sizing.sunlight import FINE_STEP_H, UNCORRECTED_CAM, SolarDay, SolarModel, solar_day
from solar.types import FloatArray

_GRID_STEP_H = 0.25
# Points per axis of the grid, by the number of its axes: some 2000 to 3000 designs.
_GRID_POINTS = {3: 13, 4: 7, 5: 5, 6: 4}
_FINALISTS = 8
_NEIGHBOURS = 400
_BRANCHES = 6  # that are tried at most, besides that by battery alone
_SPREADS = (0.03, 0.004)
_STARTS = ((0.2, 0.2, 0.3), (0.8, 0.6, 0.6), (0.5, 0.8, 0.8))


@dataclass(frozen=True)
class CrossCheck:
    """Outcome of the cross-check.

    ``cross_checked``: nothing found is better by more than the tolerance, and the fine step agrees.
    ``objective_value``: of the optimum, by the simulator. ``fine_step_value``: the same with a time
    step of one minute. ``best_found``: best objective of all searches and the optimum.
    ``advantage``: by how much that is better, in the objective's unit; zero where nothing is.
    ``found_by``: ``optimum``, ``grid``, ``neighbours``, ``other starts`` or ``other branches``.
    ``designs_tried``: designs that the simulator judged.
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
    judge = _Judge(aircraft, mission, solar, result)
    own = float(judge.value(result.simulated))
    fine = float(judge.value(judge.performance(result.design.variables, judge.fine_day)))
    bests = {
        "optimum": own,
        "grid": judge.best_of_grid(),
        "neighbours": judge.best_of(_neighbours(aircraft, result, seed)),
        "other starts": judge.best_of_starts(),
        "other branches": judge.best_of_branches(),
    }
    found_by, best = max(bests.items(), key=lambda item: float(judge.merit(item[1])))
    # Equal first: the excess time is infinite where the battery is never needed.
    advantage = 0.0 if best == own else float(judge.merit(best) - judge.merit(own))
    tolerance = judge.tolerance(own, result.simulated)
    confirmed = fine == own or abs(fine - own) <= tolerance
    return CrossCheck(
        cross_checked=bool(advantage <= tolerance and confirmed),
        objective_value=own,
        fine_step_value=fine,
        best_found=best,
        advantage=advantage,
        found_by=found_by if advantage > 0.0 else "optimum",
        designs_tried=judge.tried,
    )


class _Judge:
    """Objective of designs by the simulator; NaN for designs that miss a requirement."""

    def __init__(
        self, aircraft: Aircraft, mission: Mission, solar: SolarModel, result: SizingResult
    ) -> None:
        self.aircraft, self.mission, self.solar = aircraft, mission, solar
        self.objective, self.required_h = result.objective, result.required_excess_time_h
        assert result.simulated is not None
        assert result.design is not None
        self.optimum = result.design.variables
        self.day = result.simulated.day
        self.fine_day = solar_day(aircraft, mission, solar, step_h=FINE_STEP_H)
        self.tried = 0

    def merit(self, values: ArrayLike) -> FloatArray:
        """The larger the better; minus infinity for designs that miss a requirement."""
        signed = np.asarray(values) if self.objective.maximised else -np.asarray(values)
        return np.where(np.isnan(signed), -np.inf, signed)

    def tolerance(self, value: float, perf: Performance) -> float:
        # A payload is what is left of a mass, or of a load, that is known to a tolerance itself.
        least = {
            Objective.max_excess_time: ABSOLUTE_TOLERANCE_H,
            Objective.max_payload_mass: ROW_TOLERANCE * float(perf.design.total_mass_kg),
            Objective.max_payload_power: ROW_TOLERANCE * float(np.max(perf.nominal_load_w)),
        }
        return max(RELATIVE_TOLERANCE * abs(value), least.get(self.objective, 0.0))

    def performance(self, variables: DesignVariables, day: SolarDay) -> Performance:
        return performance_of_designs(self.aircraft, self.mission, variables, self.solar, day=day)

    def value(self, perf: Performance) -> FloatArray:
        self.tried += int(np.size(perf.design.total_mass_kg))
        worst = np.min(perf.cycle.excess_time_h, axis=-1)
        kept = (worst > 0.0) & (worst >= self.required_h)
        kept = kept & meets_requirements(self.aircraft, self.mission, perf.design)
        return np.where(kept, objective_value(self.objective, perf), np.nan)

    def best_of(self, variables: DesignVariables) -> float:
        """Best of a batch whose fine step confirms that it keeps the requirements."""
        finalists = self._finalists(variables, self.day)
        if np.size(finalists.wingspan_m) == 0:
            return float("nan")
        values, confirmed = (
            self.value(self.performance(finalists, day)) for day in (self.day, self.fine_day)
        )
        values = np.where(np.isnan(confirmed), np.nan, values)
        return float(values[np.argmax(self.merit(values))]) if values.size else float("nan")

    def _finalists(self, variables: DesignVariables, day: SolarDay) -> DesignVariables:
        """The few best of a batch with the time step of a day."""
        merits = self.merit(self.value(self.performance(variables, day)))
        order = np.argsort(-merits, kind="stable")[:_FINALISTS]
        order = order[merits[order] > -np.inf]
        return variables.mapped(lambda v: np.asarray(v)[order])

    def best_of_grid(self) -> float:
        """Best of a grid, screened with a coarse time step; the finalists with the usual one."""
        variables = design_grid(self.aircraft, self.objective, self.optimum)
        coarse = solar_day(
            self.aircraft,
            self.mission,
            self.solar,
            scenarios=self.day.scenarios,
            step_h=_GRID_STEP_H,
        )
        return self.best_of(self._finalists(variables, coarse))

    def best_of_starts(self) -> float:
        """Best of sizings that start elsewhere in the design space."""
        problems = SizingProblems(self.aircraft)
        flights = (
            size_aircraft(
                self.aircraft,
                self.mission,
                self.objective,
                self.solar,
                required_excess_time_h=self.required_h,
                problems=problems,
                start=_elsewhere(self.aircraft, fractions),
            ).simulated
            for fractions in _STARTS
        )
        return self._best_of_sized([one for one in flights if one is not None])

    def best_of_branches(self) -> float:
        """Best of sizings with other scenarios always lit, under a midnight sun."""
        solver = ProgramSolver(
            *(SizingProblems(self.aircraft), self.mission, self.solar, self.day), by_model=True
        )
        request = (self.objective, self.required_h, self.optimum)
        flights = (
            size_branch(solver, *request, sunlit).simulated for sunlit in _some_branches(self.day)
        )
        return self._best_of_sized([one for one in flights if one is not None])

    def _best_of_sized(self, flights: Sequence[Performance]) -> float:
        """Best of a few optima."""
        if not flights:
            return float("nan")
        chosen = [one.design.variables.chosen() for one in flights]
        names = chosen[0]
        return self.best_of(
            DesignVariables(**{n: np.array([float(one[n]) for one in chosen]) for n in names})
        )


def _some_branches(day: SolarDay) -> list[list[int]]:
    """Sets of scenarios that may be always lit, none first; empty where each has a night."""
    sets = growing_lit_sets(lowest_power(day))
    some = sorted({round(i) for i in np.linspace(0, len(sets) - 1, _BRANCHES)}) if sets else []
    return [*([[]] if sets else []), *(list(sets[i]) for i in some)]


def _free_axes(
    aircraft: Aircraft, objective: Objective, optimum: DesignVariables
) -> dict[str, tuple[float, float]]:
    """Bounds of every variable that the optimiser could choose; of payload around the optimum."""
    space = aircraft.design_space
    ranges = {
        "wingspan_m": space.wingspan_m,
        "battery_mass_kg": space.battery_mass_kg,
        "module_area_m2": space.module_area_m2,
        "aspect_ratio": space.aspect_ratio,
        "lift_coefficient": space.lift_coefficient,
    }
    axes = {name: (r.minimum, r.maximum) for name, r in ranges.items() if r is not None}
    if objective.variable in ("payload_mass_kg", "payload_power_w"):
        value = float(optimum.chosen()[objective.variable])
        if value > 0.0:
            axes[objective.variable] = (0.5 * value, 1.5 * value)
    return axes


def design_grid(
    aircraft: Aircraft, objective: Objective, optimum: DesignVariables
) -> DesignVariables:
    """Designs on a grid over all variables that are free, evenly spaced in their logarithm.

    ``objective``: a payload that is maximised is free, around its optimum.
    """
    bounds = _free_axes(aircraft, objective, optimum)
    points = _GRID_POINTS[len(bounds)]
    axes = [np.geomspace(*ends, points) for ends in bounds.values()]
    mesh = [v.ravel() for v in np.meshgrid(*axes, indexing="ij")]
    fixed = {name: np.full(mesh[0].size, value) for name, value in optimum.chosen().items()}
    return DesignVariables(**(fixed | dict(zip(bounds, mesh, strict=True))))


def _neighbours(aircraft: Aircraft, result: SizingResult, seed: int) -> DesignVariables:
    """Random designs around the optimum, near and nearer, within the bounds."""
    assert result.design is not None
    rng = np.random.default_rng(seed)
    centre = result.design.variables
    requested = aircraft.design_space.requested_ranges().items()
    bounds = {name: (one.minimum, one.maximum) for name, one in requested}
    bounds |= _free_axes(aircraft, result.objective, centre)
    spread = np.repeat(_SPREADS, _NEIGHBOURS // len(_SPREADS))
    moved = {}
    for name, value in centre.chosen().items():
        moved[name] = np.full(len(spread), value)
        if name in bounds:
            factor = np.exp(spread * rng.standard_normal(len(spread)))
            moved[name] = np.clip(value * factor, *bounds[name])
    return DesignVariables(**moved)


def _elsewhere(aircraft: Aircraft, fractions: tuple[float, float, float]) -> DesignVariables:
    """Design elsewhere in the design space, at fractions of its logarithmic ranges."""
    space = aircraft.design_space
    span, battery, area = (
        float(r.minimum * (r.maximum / r.minimum) ** share)
        for r, share in zip(
            (space.wingspan_m, space.battery_mass_kg, space.module_area_m2), fractions, strict=True
        )
    )
    return variables_of(aircraft)._replace(
        wingspan_m=span, battery_mass_kg=battery, module_area_m2=area
    )
