"""Outcome of a sizing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sizing.design import Design
from sizing.optimisation.objectives import Objective
from sizing.optimisation.problem import Constraint
from sizing.performance import Performance
from solar.types import FloatArray


@dataclass(frozen=True)
class Violation:
    """A requirement that no design within its bounds can meet.

    ``shortfall`` is relative to the limit; for the energy requirements to the battery's capacity,
    for the excess time in hours.
    """

    requirement: str
    shortfall: float
    text: str


@dataclass(frozen=True)
class SolverReport:
    """What the solver did: iterations and time over all starts and rounds."""

    iterations: int
    time_s: float
    build_time_s: float
    solves: int
    message: str


@dataclass(frozen=True)
class Optimum:
    """Solver's answer at an optimum: point, prices of the constraints, and what it was asked.

    ``filled`` are the scenarios in the slots of the program, ``weights`` its cost; see
    :class:`sizing.optimisation.problem.SizingProblem`. ``bound_prices`` are those of the variables
    that
    were free. Where ``needs_no_battery``, the program had the lowest sun of the day all day long.
    """

    x: FloatArray
    constraints: tuple[Constraint, ...]
    constraint_prices: FloatArray
    bound_prices: dict[str, float]
    filled: tuple[int, ...]
    weights: FloatArray
    margin: float
    needs_no_battery: bool = False


@dataclass(frozen=True)
class SizingResult:
    """Outcome of a sizing: an optimum, or the requirements that cannot be met.

    ``status`` is ``optimal``, ``infeasible`` or ``not_converged``. Design, simulated performance
    and objective value (the simulator's number) exist for an optimum alone. ``nearest`` is the
    simulated design that comes closest where none is feasible, and ``active_constraints`` then name
    what holds it back.
    """

    status: str
    objective: Objective
    required_excess_time_h: float
    objective_value: float | None
    design: Design | None
    simulated: Performance | None
    nearest: Performance | None
    active_constraints: tuple[str, ...]
    violations: tuple[Violation, ...]
    solver: SolverReport
    optimum: Optimum | None = None

    @property
    def feasible(self) -> bool:
        """Whether an optimum was found."""
        return self.status == "optimal"


def objective_value(objective: Objective, perf: Performance) -> FloatArray:
    """Objective of simulated designs, of the shape of their batch.

    Raises
    ------
    ValueError
        For an objective that is a range of days or latitudes.
    """
    worst = np.min(perf.cycle.excess_time_h, axis=-1)
    design = perf.design
    values = {
        Objective.max_excess_time: worst,
        Objective.min_wingspan: design.variables.wingspan_m,
        Objective.min_mass: design.total_mass_kg,
        Objective.max_payload_mass: design.masses.payload,
        Objective.max_payload_power: design.variables.payload_power_w,
    }
    if objective not in values:
        raise ValueError(f"{objective.value} is no number of a single simulation")
    value = values[objective]
    if value is None:  # the payload is not a variable: the mission's
        value = perf.mission.payload.power_w
    return np.array(np.broadcast_to(np.asarray(value, float), worst.shape))
