"""The outcome of a sizing."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from sizing.design import Design
from sizing.mass_budget import plain_design
from sizing.performance import Performance
from sizing.program.objectives import Objective
from sizing.program.objectives import SizingStatus as SizingStatus
from sizing.program.own_terms import OwnObjective
from solar.types import FloatArray

# A design that is better than an optimum by less than this is within what the time steps and
# tolerances allow; relative, and for excess times in hours.
RELATIVE_TOLERANCE = 0.005
ABSOLUTE_TOLERANCE_H = 0.01


@dataclass(frozen=True)
class SolverReport:
    """What the solver did: iterations and time over all starts and rounds."""

    iterations: int = 0
    time_s: float = 0.0
    solves: int = 0
    message: str = ""

    def __add__(self, more: SolverReport) -> SolverReport:
        return SolverReport(
            iterations=self.iterations + more.iterations,
            time_s=self.time_s + more.time_s,
            solves=self.solves + more.solves,
            message=more.message or self.message,
        )


@dataclass(frozen=True)
class Violation:
    """A requirement that no design within its bounds can meet.

    ``shortfall`` is relative to the limit; for the energy requirements to the battery's capacity,
    for the excess time in hours.
    """

    requirement: str
    shortfall: float
    text: str


@dataclass(frozen=True, kw_only=True)
class SizingResult:
    """Outcome of a sizing: an optimum, or the requirements that cannot be met.

    ``status`` is ``optimal``, ``infeasible`` or ``not_converged``. Design, simulated performance
    and objective value (the simulator's number) exist for an optimum alone. ``nearest`` is the
    simulated design that comes closest where none is feasible, and ``active_constraints`` then name
    what holds it back. ``optimum`` is the program's solution.
    """

    status: SizingStatus
    objective: Objective
    required_excess_time_h: float
    solver: SolverReport
    objective_value: float | None = None
    design: Design | None = None
    simulated: Performance | None = None
    nearest: Performance | None = None
    active_constraints: tuple[str, ...] = ()
    violations: tuple[Violation, ...] = ()
    optimum: Any = None

    @property
    def merit(self) -> float:
        """Objective, the larger the better; minus infinity without a design."""
        if self.objective_value is None:
            return -math.inf
        return self.objective_value if self.objective.maximised else -self.objective_value

    def with_design(self, perf: Performance) -> SizingResult:
        """The same with a design that the simulator has judged, and its objective."""
        return replace(
            self,
            status=SizingStatus.optimal,
            objective_value=float(objective_value(self.objective, perf)),
            design=plain_design(perf.design),
            simulated=perf,
        )

    def without_design(self, nearest: Performance | None, *violations: Violation) -> SizingResult:
        """Return the same without a design.

        Parameters
        ----------
        nearest : Performance or None
            Flight of the design that comes nearest.
        *violations : Violation
            What that design misses.

        Returns
        -------
        SizingResult
        """
        return replace(
            self,
            status=SizingStatus.infeasible,
            objective_value=None,
            design=None,
            simulated=None,
            nearest=nearest,
            violations=violations,
            optimum=None,
        )

    @property
    def feasible(self) -> bool:
        """Whether an optimum was found."""
        return self.status.sized


def objective_value(objective: Objective | OwnObjective, perf: Performance) -> FloatArray:
    """Objective of simulated designs, in its unit: one for each of a batch."""
    if objective.of_range and objective is not Objective.max_endurance:
        raise ValueError(f"{objective.value} is no number of a single simulation")
    worst = np.min(perf.cycle.excess_time_h, axis=-1)
    value: Any = worst
    if isinstance(objective, OwnObjective):
        value = objective.of_flight(perf)
    elif objective is Objective.min_mass:
        value = perf.design.total_mass_kg
    elif objective is Objective.max_payload_mass:
        value = perf.design.masses.payload
    elif objective.of_design:
        value = getattr(perf.design.variables, objective.variable)
    if value is None:  # the payload is not a variable: the mission's
        value = perf.mission.payload.power_w
    return np.array(np.broadcast_to(np.asarray(value, float), worst.shape))


def merit_of(objective: Objective, perf: Performance) -> FloatArray:
    """Objective of simulated designs as :func:`objective_value` has it, the larger the better."""
    value = objective_value(objective, perf)
    return value if objective.maximised else -value
