"""What a program is to be solved for, its solution, and the outcome of a sizing."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from sizing.design import DesignVariables
from sizing.limits import ROW_TOLERANCE
from sizing.optimisation.variables import (
    HEIGHT,
    OWN,
    RELATIVE_STEP,
    WORST_EXCESS,
    Constraint,
    Role,
    Variable,
)
from sizing.program.objectives import Objective, SizingStatus
from sizing.program.result import (
    ABSOLUTE_TOLERANCE_H,
    RELATIVE_TOLERANCE,
    SizingResult,
    SolverReport,
    Violation,
    merit_of,
    objective_value,
)
from sizing.sunlight import SolarDay
from solar.types import FloatArray

# A requirement limits an optimum if its multiplier is at least this fraction of the largest one:
# easing it by one per cent then gains a thousandth of what easing the hardest one does. The
# interior-point method leaves multipliers on requirements that are merely close, its barrier over
# the distance: below 0.0007 of the largest in 60 random sizings. Those that limit were above 0.01.
LIMITING_FRACTION = 1e-3

__all__ = [
    "ABSOLUTE_TOLERANCE_H",
    "RELATIVE_TOLERANCE",
    "SizingResult",
    "SizingStatus",
    "SolverReport",
    "Violation",
    "merit_of",
    "objective_value",
]
FIRST_MARGIN = 1e-3  # of the recharge, to begin with
# The goal is a little more than what is required [h]: the program's time step flatters a design by
# up to 0.003 h, the simulator's by another 0.002.
GOAL_CUSHION_H = 0.006
_LEAST_PAYLOAD = 1e-3  # that a relative cost refers to, in the unit of the payload [kg, W]
# What an hour of excess time has a price in.
_SIZES = {name for objective in Objective for name in objective.cost} - {WORST_EXCESS} | {OWN}


@dataclass(frozen=True, eq=False)
class FlownSun:
    """Sun of some scenarios on modules that the flow of a design cools.

    ``rows``: :func:`~sizing.optimisation.energy_constraints.sun_parameters` by scenario. ``off``:
    by how much the light of the program that found the design differs, relative.
    """

    rows: Mapping[int, FloatArray]
    off: float


@dataclass(frozen=True)
class ProblemInstance:
    """What a program is to be solved for.

    ``cost``: weights of the decision vector by name of its variables. ``goal_h``: excess time that
    every scenario must have [h]. ``best_excess``: whether the worst excess time may exceed the
    goal: where it is what is maximised. ``freed``: payload or technology variables that may move;
    all others are held. ``bounds``: bounds of variables, in their unit, that replace their own.
    ``held``: variables held at other values than the aircraft's and the mission's. ``penalty``:
    cost of a missed requirement on top of the other one; infinite where the least miss is all that
    counts; None where every requirement must be met. ``margin``: by how much more charge the day
    must return than the night takes, relative. ``lit``: scenarios in which the sun must carry the
    nominal load at all times. Their excess time is unlimited and meets any requirement.
    ``spare_sun``: by how much more than the program's modules need, relative. ``wind_m_per_s``:
    wind instead of the mission's strongest [m/s]. ``height_errors``: by how much the program's
    climbs end above the simulator's, by scenario, over the energy of the ceiling's height. ``sun``:
    in the flow of a design; in that of the aircraft's own design point by default.
    """

    cost: Mapping[str, float]
    goal_h: float
    best_excess: bool = False
    freed: tuple[str, ...] = ()
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    held: Mapping[str, float] = field(default_factory=dict)
    penalty: float | None = None
    margin: float = FIRST_MARGIN
    sunlit: frozenset[int] = frozenset()
    spare_sun: float = 0.0
    wind_m_per_s: float | None = None
    height_errors: Mapping[int, float] = field(default_factory=dict)
    sun: FlownSun | None = None

    @classmethod
    def of(cls, objective: Objective, required_h: float) -> ProblemInstance:
        """Instance of an objective, with a cushion on the required excess time where that costs."""
        best_excess = objective is Objective.max_excess_time
        return cls(
            cost=objective.cost,
            goal_h=required_h if best_excess else required_h + GOAL_CUSHION_H,
            best_excess=best_excess,
            freed=() if objective.payload_key is None else (objective.variable,),
        )

    def always_lit(self, scenarios: Iterable[int], *, all_of_them: bool) -> ProblemInstance:
        """The same with some scenarios whose sun must carry the load at all times.

        ``all_of_them``: whether the mission has no others: no excess time is then required, and
        that of the lightest of the designs is as unlimited as that of any other.
        """
        sunlit = replace(self, sunlit=frozenset(scenarios))
        if not all_of_them:
            return sunlit
        cost = Objective.min_mass.cost if self.best_excess else self.cost
        return replace(sunlit, cost=cost, goal_h=0.0, best_excess=False)

    def penalised(self, penalty: float) -> ProblemInstance:
        """The same where missing a requirement has a cost.

        The solver says nearly as fast that nothing meets all of them as what does best.
        """
        return replace(self, penalty=penalty)

    def least_missed(self) -> ProblemInstance:
        """By how much the requirements must be missed, whatever the design costs."""
        return replace(self, penalty=math.inf, best_excess=False)


@dataclass(frozen=True)
class Solution:
    """Solution of a program.

    ``x`` is the decision vector of ``variables``, ``weights`` its cost, ``design`` what it says of
    the aircraft; ``scenarios`` are those in the blocks. ``rival``: cost of the second best optimum
    that was found, at other heights of climbs; infinite without one. ``margin_cost``: what a unit
    of margin on the recharge adds to the cost where it takes height from climbs as well.
    """

    instance: ProblemInstance
    variables: tuple[Variable, ...]
    constraints: tuple[Constraint, ...]
    scenarios: tuple[int, ...]
    design: DesignVariables
    x: FloatArray
    weights: FloatArray
    constraint_multipliers: FloatArray
    bound_multipliers: FloatArray
    rival: float = math.inf
    margin_cost: float | None = None

    def value(self, name: str) -> float:
        """Value of a variable, in its unit."""
        place = [v.name for v in self.variables].index(name)
        return float(self.variables[place].from_program(self.x[place]))

    def missed(self) -> dict[str, float]:
        """Requirements that are missed by more than the solver's tolerance, and by how much."""
        names = {slack: c.name for c in self.constraints for slack in c.slacks}
        return {
            names[v.name]: float(slack)
            for slack, v in zip(self.x, self.variables, strict=True)
            if v.role is Role.slack and slack > ROW_TOLERANCE
        }

    def cost_of_missing(self) -> float:
        """What missed requirements add to the cost."""
        slacks = np.array([v.role is Role.slack for v in self.variables])
        return float(self.weights[slacks] @ self.x[slacks])

    def cost(self, excess_time_h: float, margin: float = 0.0) -> float:
        """What some required excess time and margin on the recharge cost, relative.

        Of the objective, if that is a size or a payload; at most, with a battery that the night
        empties.
        """
        by_hour, by_charge = self._cost_of("excess_time"), self._cost_of("energy_balance")
        return excess_time_h * by_hour + margin * by_charge

    def held_back(self) -> dict[int, tuple[float, float]]:
        """Heights of climbs that the surplus holds back, and what a height costs, by scenario."""
        rows = zip(self.constraints, self.constraint_multipliers, strict=True)
        heights = self.heights
        found: dict[int, tuple[float, float]] = {}
        for row, multiplier in rows:
            if row.name == HEIGHT and multiplier != 0.0 and row.block is not None:
                cost = self._relative(abs(float(multiplier)))
                found[self.scenarios[row.block]] = float(heights[row.block]), cost
        return found

    def _cost_of(self, name: str) -> float:
        """Multipliers of the rows of a name over their scale, relative to the objective."""
        rows = zip(self.constraints, self.constraint_multipliers, strict=True)
        cost = sum(abs(m) / row.scale for row, m in rows if row.name == name)
        if name == "energy_balance" and self.margin_cost is not None:
            cost = self.margin_cost
        return self._relative(cost)

    def _relative(self, cost: float) -> float:
        """Cost over that of the objective; 0 where that is an excess time, or technology."""
        if not _SIZES & set(self.instance.cost):
            return 0.0
        # The cost is a logarithm, or a payload over its scale.
        payload = [v for v in self.variables if v.name in self.instance.cost and v.scale]
        whole = sum(
            max(abs(self.value(v.name)), _LEAST_PAYLOAD if v.role is Role.payload else 0.0)
            / (v.scale or 1.0)
            for v in payload
        )
        return float(cost / (whole or 1.0))

    @property
    def heights(self) -> FloatArray:
        """Heights of climbs over that of the ceiling, in the order of the scenarios."""
        pairs = zip(self.x, self.variables, strict=True)
        return np.array([float(x) for x, v in pairs if v.role is Role.height])

    @property
    def climbs(self) -> bool:
        """Whether the aircraft climbs by day."""
        return any(v.role is Role.height for v in self.variables)

    def ceiling_multipliers(self) -> dict[int, float]:
        """Multipliers of the ceiling of climbs by scenario; empty without climbs."""
        found: dict[int, float] = {}
        heights = [
            float(multiplier)
            for v, multiplier in zip(self.variables, self.bound_multipliers, strict=True)
            if v.role is Role.height
        ]
        # Blocks without heights of their own are those of flight at one altitude.
        for scenario, multiplier in zip(self.scenarios, heights, strict=False):
            found[scenario] = found.get(scenario, 0.0) + max(multiplier, 0.0)
        return found

    def free_bound_multipliers(self) -> dict[str, float]:
        """Multipliers of the bounds of all design variables that are not held at a value."""
        return {
            v.name: float(multiplier)
            for v, multiplier in zip(self.variables, self.bound_multipliers, strict=True)
            if v.role is Role.design or v.name in self.instance.freed
        }


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
    held = {v.name for v in solution.variables if v.minimum == v.maximum}
    for name, multiplier in solution.free_bound_multipliers().items():
        if abs(multiplier) > least and name not in held:
            label = f"{name} at its {'maximum' if multiplier > 0 else 'minimum'}"
            active[label] = abs(multiplier) * RELATIVE_STEP
    return tuple(sorted(active, key=lambda label: -active[label]))
