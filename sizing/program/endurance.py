"""The longest flight that any design makes: a window from launch to landing, bisected over hours.

Where no design flies perpetually the best one flies for so long and no longer. A window closes if
the program finds a design that lands at its end; of those the one with most left at the landing
then shows, by its own longest flight, when it should be launched, and how much longer that flies.
"""

from __future__ import annotations

import math
from dataclasses import replace

from missions.mission import Mission
from missions.mission.flight import Flight
from sizing.aircraft import Aircraft
from sizing.day.light import UNCORRECTED_CAM, SolarDay, SolarModel, solar_day
from sizing.design import DesignVariables
from sizing.performance import performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult, SizingStatus, SolverReport
from sizing.program.search import Search
from sizing.program.task import SizingTask
from sizing.roots import bisect

LONGEST_H = 24.0 * 30  # what a flight may have
_EXACT_H = 0.02  # the launch counts in minutes


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
    best: DesignVariables | None = None
    longest_h, launch_h, report = 0.0, 12.0, SolverReport()

    def search_in(there: Mission, light: SolarDay) -> bool:
        """Search for the design of most excess time, keep it if its flight is longer."""
        nonlocal best, longest_h, launch_h, report
        first = None if best is None else task.first_values(best)
        search = Search(replace(task, mission=there, day=light), first).run()
        report += search.report
        if (judged := search.outcome) is None:
            return False
        variables = task.design_variables(judged.values)
        perf = performance_of_designs(aircraft, repeated, variables, solar, day=day)
        at = int(perf.endurance_h.argmin())
        hours = float(perf.endurance_h[at]) - required_h
        if task.meets(judged.values, perf) and hours > longest_h:
            longest_h, best = hours, variables
            if not perf.cycle.perpetual[at]:
                launch_h = float(perf.endurances.launch_h[at])
        return search.best is not None

    def window(hours: float) -> Mission:
        """Return the mission of a flight of that length from the launch of the longest.

        A launch counts in minutes: the next full one, as a later launch never has less charge.
        """
        minutes = math.ceil(launch_h * 60.0) % (24 * 60)
        launch = f"{minutes // 60:02d}:{minutes % 60:02d}"
        flight = Flight(launch=launch, hours=hours, reserve_h=required_h)
        update = {"flight": flight, "required_excess_time_h": required_h}
        return repeated.model_copy(update=update)

    def too_long(hours: float) -> bool:
        """Return whether no design flies so long."""
        there = window(hours)
        return hours > longest_h and not search_in(there, day.over_days(there.days_of_light))

    search_in(repeated, day)
    if best is not None and longest_h < LONGEST_H:
        bisect(longest_h, math.inf, too_long, lambda _: _EXACT_H, most=LONGEST_H)
    result = SizingResult(
        status=SizingStatus.infeasible,
        objective=Objective.max_endurance,
        required_excess_time_h=required_h,
        solver=report,
    )
    if best is None:
        return result
    if longest_h >= LONGEST_H:
        perf = performance_of_designs(aircraft, repeated, best, solar, day=day)
        return replace(result.with_design(perf), objective_value=math.inf)
    # Seconds less, as it is launched on the minute.
    there = window(math.floor((longest_h - _EXACT_H) / _EXACT_H) * _EXACT_H)
    perf = performance_of_designs(aircraft, there, best, solar)
    return replace(result.with_design(perf), objective_value=longest_h)
