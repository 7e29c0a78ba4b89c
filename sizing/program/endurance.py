"""The longest flight that any design makes: a window from launch to landing, bisected over hours.

Where no design flies perpetually the best one flies for so long and no longer. A window closes if
the program finds a design that lands at its end; of those the one with most left at the landing
then shows, by its own longest flight, when it should be launched, and how much longer that flies.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from missions.mission import Flight, Mission
from sizing.aircraft import Aircraft
from sizing.design import DesignVariables
from sizing.performance import Performance, performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult, SizingStatus, SolverReport
from sizing.program.size import Search
from sizing.program.task import SizingTask
from sizing.sunlight import UNCORRECTED_CAM, SolarDay, SolarModel, solar_day

LONGEST_H = 24.0 * 30  # what a flight may have
_FIRST_STEP_H = 1.0
_EXACT_H = 0.02  # the launch counts in minutes


@dataclass
class _Longest:
    """The longest flight so far, without its reserve, and the search for a longer one."""

    task: SizingTask
    hours: float = 0.0
    launch_h: float = 12.0
    best: DesignVariables | None = None
    report: SolverReport = field(default_factory=SolverReport)

    def tried(self, mission: Mission, day: SolarDay) -> bool:
        """Search for the design with most excess time, and keep it if its flight is longer."""
        task = self.task.with_values(mission=mission, day=day)
        search = Search(task, self.best).run()
        self.report += search.report
        found = search.best or search.nearest
        if found is None:
            return False
        flown = self.flown(variables := task.design_variables(found.values))
        hours = flown.endurance_h
        at = int(hours.argmin())
        longest_h = float(hours[at]) - self.task.required_h
        if task.meets(found.values, flown) and longest_h > self.hours:
            launch = flown.endurances()[at]
            self.hours, self.best = longest_h, variables
            self.launch_h = self.launch_h if launch is None else float(launch.launch_h)
        return search.best is not None

    def window(self, hours: float) -> Mission:
        """Mission of a flight for some hours from the launch of the longest."""
        minutes = round(self.launch_h * 60.0) % (24 * 60)
        launch = f"{minutes // 60:02d}:{minutes % 60:02d}"
        required_h = self.task.required_h
        flight = Flight(launch=launch, hours=hours, reserve_h=required_h)
        update = {"flight": flight, "required_excess_time_h": required_h}
        return self.task.mission.model_copy(update=update)

    def closes(self, hours: float) -> bool:
        """Whether there is a design that makes that flight."""
        mission = self.window(hours)
        return self.tried(mission, self.task.day.over_days(mission.days_of_light))

    def flown(self, variables: DesignVariables) -> Performance:
        """Repeated day of a design."""
        task = self.task
        given = (task.aircraft, task.mission, variables, task.solar)
        return performance_of_designs(*given, day=task.day)


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
    found = _Longest(task)
    found.tried(repeated, day)
    step_h, too_long_h = _FIRST_STEP_H, math.inf
    while found.best is not None and found.hours < LONGEST_H:
        if math.isfinite(too_long_h):
            step_h = (too_long_h - found.hours) / 2.0
        if step_h < _EXACT_H:
            break
        hours = min(found.hours + step_h, LONGEST_H)
        if found.closes(hours):
            found.hours, step_h = max(found.hours, hours), 2.0 * step_h
        else:
            too_long_h = hours
    result = SizingResult(
        status=SizingStatus.infeasible,
        objective=Objective.max_endurance,
        required_excess_time_h=required_h,
        solver=found.report,
    )
    if found.best is None:
        return result
    flown = found.flown(found.best)
    if found.hours >= LONGEST_H:
        return replace(result.with_design(flown), objective_value=math.inf)
    # Seconds less, as it is launched on the minute.
    mission = found.window(math.floor((found.hours - _EXACT_H) / _EXACT_H) * _EXACT_H)
    flown = performance_of_designs(aircraft, mission, found.best, solar)
    return replace(result.with_design(flown), objective_value=found.hours)
