"""What climbing does for a sizing: the optimum's day, and the optimum of level flight beside it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from missions.mission import Mission
from sizing.altitude.climb_cycle import ClimbPerformance
from sizing.optimisation.objectives import Objective
from sizing.optimisation.result import SizingResult
from sizing.results import quantities as q
from sizing.results.records import climb_record, finite, hours, relative_change
from sizing.results.tables import MISSING, Line


def climbs_record(climbs: ClimbPerformance, mission: Mission) -> dict[str, Any]:
    """Climbs of the optimum in its scenario of the least excess time, JSON-ready."""
    return climb_record(climbs, mission, 0) | {"dawn_altitude_m": finite(_dawn_altitude_m(climbs))}


def level_record(level: SizingResult) -> dict[str, Any]:
    """Optimum of level flight at the night's floor, JSON-ready."""
    design = level.design
    record = {
        "status": level.status.name,
        "objective_value": None if level.objective_value is None else finite(level.objective_value),
    }
    return record | {
        one.name: None if design is None else finite(one.of(design))
        for one in (*q.CHOSEN, q.TOTAL_MASS)
    }


def climb_lines(
    mission: Mission,
    result: SizingResult,
    climbs: ClimbPerformance | None,
    level: SizingResult | None,
) -> list[Any]:
    """What the optimum's day looks like, and what it would be without climbs."""
    if climbs is None or result.design is None:
        return []
    assert mission.climb is not None
    flown, floor_m = climbs.climb, mission.altitude_m
    highest_m, gliding_h = float(flown.maximum_altitude_m[0]), float(flown.gliding_h[0])
    reached = "its ceiling of " if highest_m > mission.climb.ceiling_m - 1.0 else ""
    text = f"stays at {floor_m:.0f} m: no surplus, or no power, is left to climb with"
    if highest_m > floor_m + 1.0:
        text = (
            f"climbs by day from {floor_m:.0f} m to {reached}{highest_m:.0f} m, which stores "
            f"{float(flown.maximum_potential_energy_wh[0]):.1f} Wh; glides {hours(gliding_h)} in "
            f"the evening; at dawn at {_dawn_altitude_m(climbs):.0f} m"
        )
    lines: list[Any] = [text]
    if level is not None:
        lines.append(Line(_without(mission, result, level)))
    return lines


def _without(mission: Mission, result: SizingResult, level: SizingResult) -> str:
    """The optimum of level flight, and how much larger it is."""
    where = f"in level flight at {mission.altitude_m:.0f} m"
    if level.design is None or result.design is None:
        return f"{where} no design was found ({level.status.label})"
    shown = [q.CHOSEN[0], q.TOTAL_MASS]
    parts = [
        f"{one.label} {one.fact(one.of(level.design))[1]} "
        f"({_change(one.of(result.design), one.of(level.design))})"
        for one in shown
    ]
    if result.objective.variable not in [one.name for one in shown]:
        assert level.objective_value is not None
        assert result.objective_value is not None
        parts.insert(0, _objective(result.objective, result.objective_value, level))
    return f"{where}: {', '.join(parts)}"


def _objective(objective: Objective, own: float, level: SizingResult) -> str:
    value = level.objective_value
    assert value is not None
    text = "unlimited" if math.isinf(value) else f"{value:.4g} {objective.unit}"
    return f"{objective.label} {text} ({_change(own, value)})"


def _change(own: Any, other: Any) -> str:
    relative = relative_change(float(own), float(other))
    return MISSING if relative is None else f"{100.0 * relative:+.1f} %"


def _dawn_altitude_m(climbs: ClimbPerformance) -> float:
    """Altitude at the morning's equal power, of a sun that always carries the load at midnight."""
    dawn_h = climbs.performance.cycle.equal_power_morning_h[0]
    at_h = 0.0 if np.isnan(dawn_h) else float(dawn_h)
    return float(np.interp(at_h, climbs.climb.time_h, climbs.climb.altitude_m[0]))
