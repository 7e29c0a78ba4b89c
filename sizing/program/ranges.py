"""The longest season, or the widest band of latitudes, in which one design flies perpetually.

A design covers a run of days or latitudes if its worst scenario there has the required excess time.
From the easiest member on a run grows by the neighbour that its best design finds easier, bisected:
the longest that has a design; then by one member at either end or a little beside it. Where the
excess time has several peaks a run grows around each.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.design import DesignVariables, variables_of
from sizing.performance import performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult
from sizing.program.size import size_aircraft
from sizing.sunlight import UNCORRECTED_CAM, SolarDay, SolarModel, solar_day
from solar.types import FloatArray

DAYS = np.arange(1, 366)
LATITUDES_DEG = np.arange(-90.0, 90.5, 1.0)
_SHIFTS = (0, -1, 1, -2, 2, -3)  # of a run that is longer by one
_SAMPLES = 30  # members that are sized on their own where the easiest of a design has none


@dataclass(frozen=True)
class WidestRange:
    """Outcome of the search for the widest range.

    ``sizing``: design with the largest worst excess time in that range; infeasible where no design
    flies perpetually on the easiest day or at the easiest latitude. ``first``, ``last``: ends of
    the range: days of year (``last`` before ``first`` across the year's end) or latitudes [deg].
    ``members``: every day, or latitude in steps of 1 degree, in the range.
    """

    sizing: SizingResult
    first: float | None
    last: float | None
    members: FloatArray

    @property
    def extent(self) -> float:
        """Number of days, or width of the band [deg]."""
        if self.first is None or self.last is None:
            return 0.0
        season = self.sizing.objective is Objective.longest_season
        return float(len(self.members)) if season else self.last - self.first


@dataclass
class _Growth:
    """Grows runs of members; a run is its first member and its length, past the year's end."""

    aircraft: Aircraft
    mission: Mission
    solar: SolarModel
    required_h: float
    season: bool
    day: SolarDay
    count: int
    start: DesignVariables
    failed: list[set[int]] = field(default_factory=list)

    def members(self, first: int, length: int) -> list[int]:
        return [i % self.count for i in range(first, first + length)]

    def size(self, run: list[int], *, most: bool = False, explain: bool = False) -> SizingResult:
        """Design for a run: any that is enough, or the one of the largest excess time."""
        each = len(self.day.scenarios) // self.count
        places = np.asarray(run)[:, np.newaxis] * each + np.arange(each)
        result = size_aircraft(
            *(self.aircraft, self.mission, Objective.max_excess_time, self.solar),
            required_excess_time_h=self.required_h if explain else 0.0,
            day=self.day.at(places.ravel()),
            start=self.start,
            explain=explain,
            stop_at_merit=np.inf if most else self.required_h,
        )
        if result.design is not None:
            self.start = result.design.variables
        return result

    def covering(self, run: list[int]) -> SizingResult | None:
        """Design for a run; none where it is not enough."""
        if any(some <= set(run) for some in self.failed):
            return None
        result = self.size(run)
        if result.merit >= self.required_h:
            return result
        self.failed.append(set(run))
        return None

    def excess_h(self, variables: DesignVariables) -> FloatArray:
        """Worst excess time of a design at every member."""
        asked = (self.aircraft, self.mission, variables, self.solar)
        cycle = performance_of_designs(*asked, day=self.day).cycle
        return np.asarray(cycle.excess_time_h.reshape(self.count, -1).min(axis=-1))

    def nested(self, hours: FloatArray, first: int, length: int) -> list[int]:
        """First members of ever longer runs, each with the easier neighbour of the one before."""
        firsts = [first]
        while length < self.count:
            ends = first - 1, first + length
            inside = [self.season or 0 <= end < self.count for end in ends]
            left, right = (hours[end % self.count] for end in ends)
            first -= inside[0] and (not inside[1] or left >= right)
            length += 1
            firsts.append(first)
        return firsts

    def grown(self, centre: int) -> tuple[int, int]:
        """Longest run around a member: first one and length, which is 0 where it has no design."""
        first, length, best = centre, 1, self.covering([centre])
        if best is None:
            return centre, 0
        while length < self.count:
            assert best is not None
            assert best.design is not None
            firsts = self.nested(self.excess_h(best.design.variables), first, length)
            low, high, step = 0, len(firsts), 1 if length > 1 else len(firsts)
            while high - low > 1:  # a run that has grown before will hardly grow by much
                middle, step = min((low + high) // 2, low + step), 2 * step
                found = self.covering(self.members(firsts[middle], length + middle))
                low, high, best = (low, middle, best) if found is None else (middle, high, found)
            if low:
                first, length = firsts[low], length + low
                continue
            longer = [first + shift for shift in _SHIFTS]
            longer = [i for i in longer if self.season or 0 <= i < self.count - length]
            runs = ((i, self.covering(self.members(i, length + 1))) for i in longer)
            first, best = next((one for one in runs if one[1] is not None), (first, None))
            if best is None:
                break
            length += 1
        return first, length

    def peaks(self, hours: FloatArray) -> list[int]:
        """Members that are easier than both neighbours, the easiest first."""
        before, behind = np.roll(hours, 1), np.roll(hours, -1)
        if not self.season:
            before[0] = behind[-1] = -np.inf
        at = np.flatnonzero((hours > before) & (hours >= behind))
        return [int(i) for i in at[np.argsort(-hours[at], kind="stable")]]


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
    own, count = variables_of(aircraft), len(members)
    it = _Growth(aircraft, mission, solar, required_h, season, day, count, own)
    hours = it.excess_h(own)
    sun = day.specific_power_w_per_m2.sum(axis=-1).reshape(count, -1).min(axis=-1)
    easiest = int(np.lexsort((sun, hours))[-1])
    first, length = it.grown(easiest)
    some = it.peaks(it.excess_h(it.start)) if length else list(range(0, count, count // _SAMPLES))
    for centre in some:
        if centre not in it.members(first, length):
            first, length = max((first, length), it.grown(centre), key=lambda run: run[1])
    run = it.members(first, length)
    result = it.size(run or [easiest], most=True, explain=not run)
    result = replace(result, objective=objective, required_excess_time_h=required_h, optimum=None)
    if not run:
        return WidestRange(result, None, None, np.empty(0))
    covered = members[run]
    ends = float(covered[0]), float(covered[-1])
    extent = float(length) if season else ends[1] - ends[0]
    return WidestRange(replace(result, objective_value=extent), *ends, covered)
