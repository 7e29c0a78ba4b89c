"""The longest season, or the widest band of latitudes, in which one design flies perpetually.

A design covers a run of days or latitudes if its worst scenario there has the required excess time.
From the member of most sun on a run grows by the neighbour that its design finds easier, bisected:
the longest that has a design; then by one member at either end or a little beside it. So does a run
from every other member that a still longer one may have.
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.day.light import UNCORRECTED_CAM, SolarDay, SolarModel, solar_day
from sizing.design import DesignVariables, variables_of
from sizing.performance import performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult
from sizing.program.size import size_aircraft
from solar.types import FloatArray, IntArray

DAYS = np.arange(1, 366)
LATITUDES_DEG = np.arange(-90.0, 90.5, 1.0)
_SHIFTS = sorted(range(-5, 5), key=abs)  # of a run that is longer by one
_NARROWEST = 12  # a run of fewer members is found around the one of most sun alone

Run = tuple[int, int]  # first member and length, past the year's end as well


@dataclass(frozen=True)
class WidestRange:
    """Outcome of the search for the widest range.

    ``sizing``: design with the largest worst excess time there; infeasible where none flies on the
    easiest day or at the easiest latitude. ``first``, ``last``: days of year (``last`` before
    ``first`` across the year's end) or latitudes [deg]. ``members``: every day or full degree.
    ``extent``: number of days, or width of the band [deg].
    """

    sizing: SizingResult
    first: float | None = None
    last: float | None = None
    members: FloatArray = field(default_factory=lambda: np.empty(0))
    extent: float = 0.0


def widest_range(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    required_excess_time_h: float | None = None,
) -> WidestRange:
    """Find the design that covers the longest season or the widest band of latitudes.

    ``aircraft``, ``mission``, ``solar``: as for :func:`sizing.program.size.size_aircraft`. For
    ``longest_season`` every day of the year is tried at the latitudes of the mission, for
    ``widest_latitude_band`` every full degree on its dates.
    """
    if not objective.of_range:
        raise ValueError(f"{objective.value} is no range: use size_aircraft")
    required_h = mission.required_excess_time_h
    required_h = required_h if required_excess_time_h is None else required_excess_time_h
    season = objective is Objective.longest_season
    members = DAYS.astype(float) if season else LATITUDES_DEG
    others = np.asarray(mission.latitudes() if season else mission.dates.days(), float)
    each, other = np.repeat(members, len(others)), np.tile(others, len(members))
    latitudes, days = (other, each) if season else (each, other)
    day = solar_day(aircraft, mission, solar, scenarios=Scenarios(latitudes, days.astype(int)))
    case = aircraft, mission, Objective.max_excess_time, solar
    runs = _Runs(case, day, required_h, len(members), season, variables_of(aircraft))
    run = runs.longest()
    if not run[1]:
        failed = runs.sized((run[0], 1), explain=True, required_excess_time_h=required_h)
        return WidestRange(replace(failed, objective=objective, optimum=None))
    kept = members[runs.places(run)]
    extent = float(run[1] if season else kept[-1] - kept[0])
    known: dict[str, Any] = {"objective": objective, "optimum": None}
    known |= {"objective_value": extent, "required_excess_time_h": required_h}
    result = replace(runs.sized(run), **known)
    return WidestRange(result, float(kept[0]), float(kept[-1]), kept, extent)


@dataclass
class _Runs:
    """Runs of so many members, in a year past the last one (``cyclic``), and their last design."""

    case: tuple[Aircraft, Mission, Objective, SolarModel]
    day: SolarDay
    required_h: float
    count: int
    cyclic: bool
    last: DesignVariables

    def places(self, run: Run) -> IntArray:
        """Return the members of a run."""
        return np.arange(run[0], sum(run)) % self.count

    def sized(self, run: Run, **options: Any) -> SizingResult:
        """Return the design of most excess time in a run."""
        scenarios = np.arange(len(self.day.scenarios)).reshape(self.count, -1)
        light = self.day.at(scenarios[self.places(run)].ravel())
        options = {"required_excess_time_h": 0.0, "explain": False} | options
        result = size_aircraft(*self.case, day=light, start=self.last, **options)
        if result.design is not None:
            self.last = result.design.variables
        return result

    def covered(self, run: Run) -> bool:
        """Return whether a design covers a run."""
        inside = run[1] <= self.count and (self.cyclic or 0 <= run[0] <= self.count - run[1])
        return inside and self.sized(run, stop_at_merit=self.required_h).merit >= self.required_h

    def longest(self) -> Run:
        """Return the longest run that has a design; of no length where there is none."""
        sun = self.day.specific_power_w_per_m2.sum(axis=-1).reshape(self.count, -1).min(axis=-1)
        seed = centre = int(np.argmax(sun))
        run = self.grown(centre)
        # Every longer run has one of the members at this distance.
        while (seed := seed + max(run[1] + 1, _NARROWEST)) < centre + self.count:
            run = max(run, self.grown(seed % self.count), key=lambda it: it[1])
        return run

    def grown(self, centre: int) -> Run:
        """Return the longest run around a member that has a design."""
        if not self.covered((centre, 1)):
            return centre, 0
        aircraft, mission, _, solar = self.case
        perf = performance_of_designs(aircraft, mission, self.last, solar, day=self.day)
        hours = perf.cycle.excess_time_h.reshape(self.count, -1).min(axis=-1)
        # Nothing is as hard as what lies beyond the ends of a band.
        hours = np.append(np.nan_to_num(hours, posinf=np.inf), [] if self.cyclic else -np.inf)
        runs = [(centre, 1)]
        while len(runs) < self.count:
            first, length = runs[-1]
            left, right = hours[first - 1], hours[(first + length) % len(hours)]
            runs.append(((first - int(left >= right)) % self.count, length + 1))
        run = runs[bisect_left(runs, True, lo=1, key=lambda longer: not self.covered(longer)) - 1]
        longer: Run | None = run
        while longer is not None:
            run = longer
            beside = ((run[0] + shift, run[1] + 1) for shift in _SHIFTS)
            longer = next(filter(self.covered, beside), None)
        return run
