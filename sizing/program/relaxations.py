"""What would make an infeasible mission feasible: the value of one parameter at a time.

A parameter has values from the present one to the furthest. Sizings tell with which of them there
is a design: the furthest, and if that one suffices the others by bisection. Values are numbers of
three digits at most one per cent apart: there is a design with the value that is told, and none
with 1 % less of it.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import numpy as np

from missions.mission import Mission, Scenarios
from missions.mission.scenarios import LatitudeRange
from sizing.aircraft import Aircraft
from sizing.day.light import UNCORRECTED_CAM, SolarModel, solar_day
from sizing.parameters import build_scales, catalogue, parameter_value, unit, with_parameter
from sizing.performance import Performance, performance_of_designs
from sizing.program.objectives import Objective, SizingStatus
from sizing.program.reasons import least_mission
from sizing.program.result import SizingResult
from sizing.program.size import size_aircraft
from sizing.relaxed_flight import Direction, Relaxation, rounded

_WIND = "mission.wind_m_per_s"
_SPACE = "design_space"
_LATITUDE = "mission.latitude_deg"
# A structure lighter than half of today's is no relaxation.
_HALVED = [f"airframe.structure.{key}" for key in ("build", "calibration", "coefficient_kg")]
_WIDER = 4.0  # bounds of the design space are moved by no more than this factor
_FURTHEST = 1e3  # factor on limits, and the divisor of what may become nothing
_STEP = 0.005  # between two values; numbers of three digits are up to twice as far apart
_STEP_DEG, _REACH_DEG = 0.25, 60.0  # of latitudes


class _Candidate(NamedTuple):
    """A parameter with the values that it may have, the furthest one last."""

    key: str
    unit: str
    present: float
    values: list[float]

    @property
    def direction(self) -> Direction:
        return "at least" if self.values[-1] > self.present else "at most"


def relaxations(
    aircraft: Aircraft, mission: Mission, result: SizingResult, solar: SolarModel = UNCORRECTED_CAM
) -> list[Relaxation]:
    """Find what would make an infeasible mission feasible, one parameter at a time.

    Returns smallest relative change first; empty where no single parameter suffices.
    """
    if result.status is not SizingStatus.infeasible or result.nearest is None:
        raise ValueError(
            f"the sizing is {result.status.name}: only an infeasible one has relaxations"
        )
    # What is to be carried as much as possible need not be carried at all.
    easiest = least_mission(aircraft, mission, result.objective)
    candidates = [
        _Candidate(key, unit(quantity), present, _values(present, furthest))
        for key, quantity, present, furthest in _numbers(aircraft, easiest, result)
    ]
    candidates.append(_latitudes(aircraft, easiest, result.nearest, solar))
    found = [_least_change(it, aircraft, easiest, result, solar) for it in candidates if it.values]
    found.append(_largest_excess_time(result))
    return sorted((it for it in found if it), key=lambda it: it.relative_change)


def _least_change(
    candidate: _Candidate,
    aircraft: Aircraft,
    mission: Mission,
    result: SizingResult,
    solar: SolarModel,
) -> Relaxation | None:
    """Return the first value with which there is a design; None if there is none."""
    key, values, required_h = candidate.key, candidate.values, result.required_excess_time_h
    if key == _WIND:
        mission = mission.in_wind(candidate.present)

    @cache
    def reached_h(value: float) -> float | None:
        """Worst excess time of a sizing with a value; None if that is not enough."""
        sizing = size_aircraft(
            *with_parameter(aircraft, mission, key, value),
            Objective.max_excess_time,
            solar,
            required_excess_time_h=0.0,
            explain=False,
            stop_at_merit=max(required_h, 1e-9),
        )
        worst_h = sizing.objective_value
        return worst_h if worst_h is not None and worst_h >= required_h else None

    if reached_h(values[-1]) is None:
        return None
    value = values[bisect_left(values, True, key=lambda value: reached_h(value) is not None)]
    hours = reached_h(value) or 0.0
    return Relaxation(key, candidate.unit, candidate.present, candidate.direction, value, hours)


def _largest_excess_time(result: SizingResult) -> Relaxation | None:
    """Return the largest excess time there is, where more is required and nothing else missed."""
    assert result.nearest is not None
    required_h = result.required_excess_time_h
    worst_h = float(np.min(result.nearest.cycle.excess_time_h))
    missed = {violation.requirement for violation in result.violations}
    if missed - {"excess_time"} or not 0.0 < worst_h < required_h:
        return None
    key, value = "mission.required_excess_time_h", rounded(worst_h, "at most")
    return Relaxation(key, unit(key), required_h, "at most", value, worst_h)


# ---- Candidates


def _numbers(
    aircraft: Aircraft, mission: Mission, result: SizingResult
) -> Iterator[tuple[str, str, float, float]]:
    """Yield key, quantity, present and furthest value of technology, payload, limits and wind."""
    # A requirement that is met at the expense of another one stands in the way as well.
    in_the_way = {violation.requirement for violation in result.violations}
    in_the_way |= {label.partition(" (")[0] for label in result.active_constraints}
    for key, row in catalogue().items():
        present = parameter_value(aircraft, mission, key)
        if not present or build_scales(aircraft, key):
            continue
        if row.kind == "technology" and row.relaxable == "up":
            yield key, key, present, row.maximum
        elif row.kind == "technology" and row.relaxable == "down":
            yield key, key, present, present / (2.0 if key in _HALVED else _FURTHEST)
        elif row.name in ("payload_mass_kg", "payload_power_w"):
            yield key, key, present, 0.0
        elif row.kind == "bound":
            bound = key.removeprefix(f"{_SPACE}.").removeprefix("maximum_").partition(".")[0]
            always = bound == Objective.min_wingspan.variable
            if always or f"{bound} at its maximum" in in_the_way:
                yield key, key, present, _WIDER * present
    for name, limit in aircraft.design_space.limit_rows().items():
        if name in in_the_way:
            factor = _FURTHEST if limit.end == "maximum" else 1.0 / _FURTHEST
            yield f"{_SPACE}.{limit.key}", limit.quantity, limit.value, factor * limit.value
    if "airspeed_above_wind" in in_the_way:
        yield _WIND, _WIND, float(mission.strongest_wind_m_per_s), 0.0


def _values(present: float, furthest: float) -> list[float]:
    """Return the numbers of three digits from the present value to the furthest."""
    last = furthest or present / _FURTHEST
    direction: Direction = "at least" if last > present else "at most"
    count = math.ceil(abs(math.log(last / present)) / _STEP) + 1
    values = [rounded(v, direction) for v in np.geomspace(present, last, count)[1:].tolist()]
    return [*dict.fromkeys(values), *([] if furthest else [0.0])]


def _latitudes(
    aircraft: Aircraft, mission: Mission, nearest: Performance, solar: SolarModel
) -> _Candidate:
    """Return the latitudes to move to; of a band those of the end that holds back."""
    latitude = mission.latitude_deg
    if not isinstance(latitude, LatitudeRange):
        places = _easier_latitudes(aircraft, mission, nearest, solar)
        return _Candidate(_LATITUDE, "deg", latitude, places)
    worst = float(nearest.day.scenarios.latitude_deg[nearest.worst_scenario()])
    present, other, end = latitude.from_deg, latitude.to_deg, "from_deg"
    if abs(worst - other) < abs(worst - present):
        present, other, end = other, present, "to_deg"
    count = round(abs(other - present) / _STEP_DEG) + 1
    places = np.linspace(present, other, count)[1:-1].tolist()
    return _Candidate(f"{_LATITUDE}.{end}", "deg", present, places)


def _easier_latitudes(
    aircraft: Aircraft, mission: Mission, nearest: Performance, solar: SolarModel
) -> list[float]:
    """Latitudes from the mission's to where the nearest design does best, in steps."""
    reach = np.arange(_STEP_DEG, _REACH_DEG, _STEP_DEG)
    ends = mission.wind_latitudes_deg
    sides = [np.clip(mission.latitudes()[0] + s * reach, *ends) for s in (-1.0, 1.0)]
    tried = np.stack(sides)[:, 3::20]
    days = np.asarray(mission.dates.days(), int)
    scenarios = Scenarios(np.repeat(tried.ravel(), len(days)), np.tile(days, tried.size))
    day = solar_day(aircraft, mission, solar, scenarios=scenarios, step_h=0.5)
    variables = nearest.design.variables.mapped(float)
    perf = performance_of_designs(aircraft, mission, variables, solar, day=day)
    excess = perf.cycle.excess_time_h.reshape(*tried.shape, -1).min(axis=-1)
    side, peak = np.unravel_index(int(np.argmax(excess)), excess.shape)
    places: list[float] = sides[side][: 4 + 20 * int(peak)].tolist()
    return places
