"""Attack on an optimum, to find out whether any other design beats it in the simulator.

The optimum is simulated again with a fine time step, and three attacks look for a better design,
all judged by the simulator alone: a grid over the whole design space, random neighbours of the
optimum, and sizings from other starting designs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import DesignVariables, FlightConditions
from sizing.limits import meets_requirements
from sizing.optimisation.objectives import Objective
from sizing.optimisation.result import SizingResult, objective_value
from sizing.optimisation.search import size_aircraft
from sizing.performance import Performance, performance_of_designs
from sizing.sunlight import UNCORRECTED_CAM, SolarModel, solar_day
from solar.types import FloatArray

# An attack that wins by less than this is within what the time steps and tolerances allow.
RELATIVE_TOLERANCE = 0.005
ABSOLUTE_TOLERANCE_H = 0.01
_PAYLOAD_TOLERANCE = 0.001  # of the total mass or load
_FINE_STEP_H = 1.0 / 60.0
_GRID_STEP_H = 0.25
# Points per axis of the grid, by the number of its axes: some 2000 to 3000 designs.
_GRID_POINTS = {3: 13, 4: 7, 5: 5, 6: 4}
_FINALISTS = 8
_NEIGHBOURS = 400
_SPREADS = (0.03, 0.004)
_STARTS = ((0.2, 0.2, 0.3), (0.8, 0.6, 0.6), (0.5, 0.8, 0.8))
# The solver meets its constraints to about 1e-8.
_ROW_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Certificate:
    """Outcome of the attack.

    Attributes
    ----------
    certified : bool
        Nothing found is better by more than the tolerance, and the fine step agrees.
    objective_value : float
        Of the optimum, by the simulator.
    fine_step_value : float
        The same with a time step of one minute.
    best_found : float
        Best objective of all attacks and the optimum.
    advantage : float
        By how much that is better, in the objective's unit; zero where nothing is.
    found_by : str
        ``optimum``, ``grid``, ``neighbours`` or ``other starts``.
    designs_tried : int
        Designs that the simulator judged.
    """

    certified: bool
    objective_value: float
    fine_step_value: float
    best_found: float
    advantage: float
    found_by: str
    designs_tried: int


def certify(
    aircraft: Aircraft,
    mission: Mission,
    result: SizingResult,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    seed: int = 0,
) -> Certificate:
    """Attack an optimum.

    Parameters
    ----------
    aircraft, mission, solar
        What :func:`sizing.optimisation.search.size_aircraft` was asked.
    result : SizingResult
        Its answer.
    seed : int
        Of the random neighbours.

    Raises
    ------
    ValueError
        If the result is no optimum.
    """
    if result.design is None or result.simulated is None:
        raise ValueError(f"the sizing is {result.status}: only an optimum can be certified")
    judge = _Judge(aircraft, mission, solar, result)
    own = float(judge.value(result.simulated))
    fine_day = solar_day(aircraft, mission, solar, step_h=_FINE_STEP_H)
    fine = float(
        judge.value(
            performance_of_designs(aircraft, mission, result.design.variables, solar, day=fine_day)
        )
    )
    attacks = {
        "grid": judge.best_of_grid(),
        "neighbours": judge.best_of(_neighbours(aircraft, result, seed)),
        "other starts": judge.best_of_starts(),
    }
    found: list[tuple[str, float]] = [("optimum", own), *attacks.items()]
    found_by, best = max(found, key=lambda item: judge.merit(item[1]))
    # Equal first: the excess time is infinite where the battery is never needed.
    advantage = 0.0 if best == own else judge.merit(best) - judge.merit(own)
    tolerance = judge.tolerance(own, result.simulated)
    confirmed = fine == own or abs(fine - own) <= tolerance
    return Certificate(
        certified=bool(advantage <= tolerance and confirmed),
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
        self.tried = 0

    def merit(self, value: Any) -> float:
        """The larger the better; minus infinity for a design that misses a requirement."""
        if np.isnan(value):
            return -np.inf
        return float(value if self.objective.maximised else -value)

    def tolerance(self, value: float, perf: Performance) -> float:
        relative = RELATIVE_TOLERANCE * abs(value)
        # A payload is what is left of a mass, or of a load, that may be many times larger.
        least = {
            Objective.max_excess_time: ABSOLUTE_TOLERANCE_H,
            Objective.max_payload_mass: _PAYLOAD_TOLERANCE * float(perf.design.total_mass_kg),
            Objective.max_payload_power: _PAYLOAD_TOLERANCE * float(np.max(perf.nominal_load_w)),
        }
        return max(relative, least.get(self.objective, 0.0))

    def value(self, perf: Performance) -> FloatArray:
        self.tried += int(np.size(perf.design.total_mass_kg))
        worst = np.min(perf.cycle.excess_time_h, axis=-1)
        kept = (worst > 0.0) & (worst >= self.required_h)
        kept = kept & meets_requirements(
            self.aircraft,
            perf.design,
            FlightConditions.of(self.mission),
            tolerance=_ROW_TOLERANCE,
        )
        return np.where(kept, objective_value(self.objective, perf), np.nan)

    def best_of(self, variables: DesignVariables) -> float:
        if np.size(variables.wingspan_m) == 0:
            return float("nan")
        values = self.value(
            performance_of_designs(self.aircraft, self.mission, variables, self.solar, day=self.day)
        )
        return _best(values, self.merit)

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
        values = self.value(
            performance_of_designs(self.aircraft, self.mission, variables, self.solar, day=coarse)
        )
        merits = np.array([self.merit(v) for v in values])
        order = np.argsort(-merits, kind="stable")[:_FINALISTS]
        order = order[merits[order] > -np.inf]
        return self.best_of(variables.mapped(lambda v: np.asarray(v)[order]))

    def best_of_starts(self) -> float:
        values = []
        for fractions in _STARTS:
            started = _started_elsewhere(self.aircraft, fractions)
            found = size_aircraft(
                started,
                self.mission,
                self.objective,
                self.solar,
                required_excess_time_h=self.required_h,
                day=self.day,
            )
            if found.simulated is not None:
                values.append(self.value(found.simulated)[()])
        return _best(np.array(values), self.merit)


def _best(values: FloatArray, merit: Any) -> float:
    sound = values[~np.isnan(values)] if values.size else values
    return float(max(sound, key=merit)) if sound.size else float("nan")


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
    """Designs on a grid over all variables that are free, evenly spaced in their logarithm."""
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
    bounds = _free_axes(aircraft, result.objective, centre)
    spread = np.repeat(_SPREADS, _NEIGHBOURS // len(_SPREADS))
    moved = {}
    for name, value in centre.chosen().items():
        moved[name] = np.full(len(spread), value)
        if name in bounds:
            factor = np.exp(spread * rng.standard_normal(len(spread)))
            moved[name] = np.clip(value * factor, *bounds[name])
    return DesignVariables(**moved)


def _started_elsewhere(aircraft: Aircraft, fractions: tuple[float, float, float]) -> Aircraft:
    """Aircraft whose own design point lies elsewhere in its design space."""
    space = aircraft.design_space
    span, battery, area = (
        float(r.minimum * (r.maximum / r.minimum) ** share)
        for r, share in zip(
            (space.wingspan_m, space.battery_mass_kg, space.module_area_m2), fractions, strict=True
        )
    )
    return aircraft.model_copy(
        update={
            "airframe": aircraft.airframe.model_copy(update={"wingspan_m": span}),
            "battery": aircraft.battery.model_copy(update={"mass_kg": battery}),
            "modules": aircraft.modules.model_copy(update={"area_m2": area}),
        }
    )
