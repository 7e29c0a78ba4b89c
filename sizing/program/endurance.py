"""The longest flight that any design makes.

Where no design flies perpetually the best one flies for so long and no longer. Of all designs in a
window from launch to landing the one with most left at the landing shows, by its own longest
flight, when it should be launched, and how much longer it flies: that is the next window. Where
nothing is left there is none longer.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

from missions.mission import Mission
from missions.mission.flight import Flight
from sizing.aircraft import Aircraft
from sizing.day.light import UNCORRECTED_CAM, SolarModel, solar_day
from sizing.design import DesignVariables
from sizing.performance import performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult, SizingStatus
from sizing.program.search import Search
from sizing.program.task import SizingTask

LONGEST_H = 24.0 * 30  # what a flight may have
_EXACT_H = 0.02  # the launch counts in minutes


class _Longest(NamedTuple):
    """The longest flight of a design, infinite where it flies perpetually."""

    design: DesignVariables
    hours: float
    launch_h: float


def longest_flight_of_all(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    required_excess_time_h: float | None = None,
) -> SizingResult:
    """Find the design with the longest flight from its best launch.

    What the mission requires as excess time, or as a reserve, must be left at the landing. The
    objective is infinite where a design flies perpetually or for more than 30 days; else the
    simulated mission is that of the flight.
    """
    required_h = mission.required_excess_time_h
    if required_excess_time_h is not None:
        required_h = required_excess_time_h
    # Of a repeated day, in which every launch is possible.
    repeated = mission.model_copy(update={"flight": None})
    day = solar_day(aircraft, repeated, solar)
    task = SizingTask(aircraft, repeated, Objective.max_excess_time, solar, day, required_h)
    search = Search(task, in_the_dark=True).run()
    best, report = None, search.report
    while (longest := _longest_of(task, search)) is not None:
        gained_h = longest.hours - (0.0 if best is None else best.hours)
        best = longest if gained_h > 0.0 else best
        if gained_h < _EXACT_H or longest.hours >= LONGEST_H:
            break
        there = _flight(repeated, longest.hours, longest.launch_h, required_h)
        light = day.over_days(there.days_of_light)
        first = task.first_values(longest.design)
        search = Search(replace(task, mission=there, day=light), first).run()
        report += search.report
    result = SizingResult(
        status=SizingStatus.infeasible,
        objective=Objective.max_endurance,
        required_excess_time_h=required_h,
        solver=report,
    )
    if best is None:
        return result
    if best.hours >= LONGEST_H:
        perf = performance_of_designs(aircraft, repeated, best.design, solar, day=day)
        return replace(result.with_design(perf), objective_value=math.inf)
    # Seconds less, as it is launched on the minute.
    hours = math.floor((best.hours - _EXACT_H) / _EXACT_H) * _EXACT_H
    there = _flight(repeated, hours, best.launch_h, required_h)
    perf = performance_of_designs(aircraft, there, best.design, solar)
    return replace(result.with_design(perf), objective_value=best.hours)


def _longest_of(task: SizingTask, search: Search) -> _Longest | None:
    """Return the longest flight of the outcome of a search, on the repeated days of a task."""
    if (judged := search.outcome) is None:
        return None
    design = task.design_variables(judged.values)
    perf = performance_of_designs(task.aircraft, task.mission, design, task.solar, day=task.day)
    at = int(perf.endurance_h.argmin())
    hours = float(perf.endurance_h[at]) - task.required_h
    if hours <= 0.0 or not task.meets(perf)[0]:
        return None
    perpetual = perf.cycle.perpetual[at]
    return _Longest(design, hours, 0.0 if perpetual else float(perf.endurances.launch_h[at]))


def _flight(repeated: Mission, hours: float, launch_h: float, reserve_h: float) -> Mission:
    """Return the mission of a flight.

    A launch counts in minutes: the next full one, as a later launch never has less charge.
    """
    minutes = math.ceil(launch_h * 60.0) % (24 * 60)
    launch = f"{minutes // 60:02d}:{minutes % 60:02d}"
    flight = Flight(launch=launch, hours=hours, reserve_h=reserve_h)
    update = {"flight": flight, "required_excess_time_h": reserve_h}
    return repeated.model_copy(update=update)
