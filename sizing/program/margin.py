"""Sizing with a margin on sun and battery that is no larger than a judge asks for.

A margin is one number, which stands for a factor on the sun's energy and one on the battery's. The
program finds the best design with these factors; the judge flies it without them (sizing and
judging by turns: Du, X., Chen, W. 2004, J. Mech. Des. 126:225).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import NamedTuple

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarDay, SolarModel, solar_day
from sizing.design_space import LimitedQuantity
from sizing.parameters import MISSION_PREFIX, all_replaced, with_parameter
from sizing.performance import performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult, SolverReport
from sizing.program.size import size_aircraft

# Limits on the battery, by the power of the factor on it with which they grow.
_OF_BATTERY: dict[LimitedQuantity, float] = {
    "battery_energy_wh": 1.0,
    "cruise_discharge_rate_per_h": -1.0,
    "climb_discharge_rate_per_h": -1.0,
}


class Trial(NamedTuple):
    """A design that was sized with a margin, and what it reaches without: a share, or days."""

    result: SizingResult
    reached: float


def best_of(trials: Sequence[Trial], needed: float) -> Trial:
    """Return the trial of most merit of those that reach enough; else the one that reaches most."""

    def rank(trial: Trial) -> tuple[bool, float]:
        enough = trial.reached >= needed
        return enough, trial.result.merit if enough else trial.reached

    return max(trials, key=rank)


def least_margin(
    tried_with: Callable[[float], Trial | None],
    surplus: Callable[[float], float],
    ends: tuple[float, float],
    tolerance: float,
    shortfall: float = 1.0,
) -> list[Trial]:
    """Return the trials on the way to the least margin that is enough.

    ``tried_with``: the trial of a margin, None where it is too large for any design. ``surplus``:
    what is reached over what is needed, best in the unit of the margin. ``ends``: a margin that is
    not enough, by ``shortfall``, and the largest that is tried. ``tolerance``: of the margin, or of
    an accepted surplus.
    """
    from scipy.optimize import brentq  # takes longer to import than a sizing

    tried = list[Trial]()

    @cache
    def excess(margin: float) -> float:
        if margin == ends[0]:
            return -shortfall
        if (trial := tried_with(margin)) is None:
            return abs(margin)
        tried.append(trial)
        more = surplus(trial.reached)
        return 0.0 if 0.0 <= more <= tolerance else more

    # Far beyond what is enough a sizing may find a design that is good for nothing.
    short = ends[0]
    for part in (0.25, 0.5, 1.0):
        margin = ends[0] + part * (ends[1] - ends[0])
        if excess(margin) > 0.0:
            brentq(excess, short, margin, xtol=tolerance / 2.0)
        if excess(margin) >= 0.0:
            break
        short = margin
    return tried


@dataclass
class MarginCase:
    """An aircraft and a mission that are sized with margins on sun and battery.

    ``solver``: what all sizings took.
    """

    aircraft: Aircraft
    mission: Mission
    objective: Objective
    solar: SolarModel
    solver: SolverReport = field(default_factory=SolverReport)

    @cached_property
    def day(self) -> SolarDay:
        """Light without a margin."""
        return solar_day(self.aircraft, self.mission, self.solar)

    @cached_property
    def plain(self) -> SizingResult:
        """Sizing without a margin."""
        result = size_aircraft(self.aircraft, self.mission, self.objective, self.solar)
        self.solver += result.solver
        return result

    def sized(self, income: float, storage: float) -> SizingResult:
        """Return the best design with factors on sun and battery, simulated without them."""
        margins = self.mission.uncertainty_margins
        # Limits know nothing of the factor, which is no margin of a file: it may exceed 1.
        limits = {
            f"design_space.{row.key}": row.value * storage ** _OF_BATTERY[row.quantity]
            for row in self.aircraft.design_space.limit_rows().values()
            if row.quantity in _OF_BATTERY
        }
        limited = all_replaced(self.aircraft, limits)
        capacity = f"{MISSION_PREFIX}uncertainty_margins.battery_capacity"
        result = size_aircraft(
            *with_parameter(limited, self.mission, capacity, storage * margins.battery_capacity),
            self.objective,
            self.solar,
            day=self.day.scaled(income),
            start=None if self.plain.design is None else self.plain.design.variables,
            explain=False,
        )
        self.solver += result.solver
        if result.design is None:
            return result
        variables = result.design.variables
        case = self.aircraft, self.mission, variables, self.solar
        return result.with_design(performance_of_designs(*case, day=self.day))
