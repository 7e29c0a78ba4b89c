"""Outcome of a sizing."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from sizing.design import Design, Masses
from sizing.optimisation.objectives import Objective
from sizing.optimisation.objectives import SizingStatus as SizingStatus
from sizing.optimisation.own_terms import OwnObjective
from sizing.optimisation.solver import Solution, SolverReport
from sizing.optimisation.variables import RELATIVE_STEP, Constraint
from sizing.performance import Performance
from sizing.sunlight import SolarDay
from solar.types import FloatArray

# A design that is better than an optimum by less than this is within what the time steps and
# tolerances allow; relative, and for excess times in hours.
RELATIVE_TOLERANCE = 0.005
ABSOLUTE_TOLERANCE_H = 0.01
# A requirement limits an optimum if its multiplier is at least this fraction of the largest one:
# easing it by one per cent then gains a thousandth of what easing the hardest one does. The
# interior-point method leaves multipliers on requirements that are merely close, its barrier over
# the distance: below 0.0007 of the largest in 60 random sizings. Those that limit were above 0.01.
LIMITING_FRACTION = 1e-3


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
    optimum: Solution | None = None

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

    def without_design(
        self, status: SizingStatus, nearest: Performance | None, *violations: Violation
    ) -> SizingResult:
        """The same without a design.

        Parameters
        ----------
        status : SizingStatus
            How it ends.
        nearest : Performance or None
            Design that comes closest, simulated.
        *violations : Violation
            What that one misses.

        Returns
        -------
        SizingResult
        """
        return replace(
            self,
            status=status,
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
    """Objective of simulated designs.

    ``perf``: of one design, or of a batch; the scenarios are the last axis. Returns of the shape of
    the batch, in the objective's unit.
    """
    if objective.of_range:
        raise ValueError(f"{objective.value} is no number of a single simulation")
    worst = np.min(perf.cycle.excess_time_h, axis=-1)
    value: Any
    if isinstance(objective, OwnObjective):
        value = objective.of_flight(perf)
    else:
        value = objective.value_of(perf.design) if objective.of_design else worst
    if value is None:  # the payload is not a variable: the mission's
        value = perf.mission.payload.power_w
    return np.array(np.broadcast_to(np.asarray(value, float), worst.shape))


def merit_of(objective: Objective, perf: Performance) -> FloatArray:
    """Objective of simulated designs as :func:`objective_value` has it, the larger the better."""
    value = objective_value(objective, perf)
    return value if objective.maximised else -value


def limiting_rows(solution: Solution) -> list[Constraint]:
    """Requirements of the program that hold a solution back."""
    least = _least_multiplier(solution)
    multipliers = np.abs(solution.constraint_multipliers)
    rows = zip(multipliers, solution.constraints, strict=True)
    return [row for multiplier, row in rows if multiplier > least and not row.equation]


def _least_multiplier(solution: Solution) -> float:
    """Multiplier above which a requirement or a bound limits."""
    inequality = [not row.equation for row in solution.constraints]
    rows = np.abs(solution.constraint_multipliers)[inequality]
    bounds = np.abs(list(solution.free_bound_multipliers().values()))
    return LIMITING_FRACTION * float(np.max(np.concatenate((rows, bounds))))


def active_constraints(solution: Solution, day: SolarDay) -> tuple[str, ...]:
    """Names of the requirements and bounds that hold a solution back.

    Those come first whose easing gains most: by one per cent, or by an hour of excess time.
    """
    active: dict[str, float] = {}
    least = _least_multiplier(solution)
    for row, multiplier in zip(solution.constraints, solution.constraint_multipliers, strict=True):
        if row.equation or abs(multiplier) <= least:
            continue
        label = row.name
        if row.block is not None:
            scenario = solution.scenarios[row.block]
            if label == "excess_time" and scenario in solution.instance.sunlit:
                label = "always_lit"
            label += f" ({day.scenarios.label(scenario)})"
        active[label] = active.get(label, 0.0) + abs(multiplier) * row.step
    for scenario, multiplier in solution.ceiling_multipliers().items():
        if multiplier > least:
            active[f"climb_ceiling ({day.scenarios.label(scenario)})"] = multiplier * RELATIVE_STEP
    for name, multiplier in solution.free_bound_multipliers().items():
        if abs(multiplier) > least:
            label = f"{name} at its {'maximum' if multiplier > 0 else 'minimum'}"
            active[label] = abs(multiplier) * RELATIVE_STEP
    return tuple(sorted(active, key=lambda label: -active[label]))


def plain_design(design: Design) -> Design:
    """Turn a design of zero-dimensional arrays into one of floats."""
    numbers = {
        name: float(value)
        for name, value in design._asdict().items()
        if name not in ("variables", "masses", "chain")
    }
    masses = Masses(*(float(mass) for mass in design.masses))
    variables = design.variables.mapped(float)
    return Design(variables=variables, masses=masses, chain=design.chain, **numbers)
