"""The longest season, or the widest band of latitudes, in which one design flies perpetually.

A design covers a run of days or latitudes if its worst scenario there has the required excess time.
From the easiest member on a run grows by the neighbour that its design finds easier, bisected: the
longest that has a design; then by one member at either end or a little beside it. Where the excess
time has several peaks a run grows around each.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import dataclass, field, replace

import numpy as np

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.day.light import UNCORRECTED_CAM, SolarModel, solar_day
from sizing.design import variables_of
from sizing.performance import performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult
from sizing.program.size import size_aircraft
from solar.types import FloatArray, IntArray

DAYS = np.arange(1, 366)
LATITUDES_DEG = np.arange(-90.0, 90.5, 1.0)
_SHIFTS = sorted(range(-5, 5), key=abs)  # of a run that is longer by one
_SAMPLES = 30  # members that are sized on their own where the easiest of a design has none

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
    count, start = len(members), variables_of(aircraft)

    def places(run: Run) -> IntArray:
        return np.arange(run[0], sum(run)) % count

    def sized(run: Run, stop_at_h: float = math.inf, explain: bool = False) -> SizingResult:
        nonlocal start
        at = places(run)[:, np.newaxis] * len(others) + np.arange(len(others))
        result = size_aircraft(
            aircraft,
            mission,
            Objective.max_excess_time,
            solar,
            required_excess_time_h=required_h if explain else 0.0,
            day=day.at(at.ravel()),
            start=start,
            explain=explain,
            stop_at_merit=stop_at_h,
        )
        if result.design is not None:
            start = result.design.variables
        return result

    def covered(run: Run) -> bool:
        return sized(run, required_h).merit >= required_h

    def excess_h() -> FloatArray:
        """Return the last design's worst excess time at every member, and beyond a band's ends."""
        cycle = performance_of_designs(aircraft, mission, start, solar, day=day).cycle
        hours = cycle.excess_time_h.reshape(count, -1).min(axis=-1)
        # Nothing is as hard as what lies beyond the ends.
        return np.append(np.nan_to_num(hours, posinf=np.inf), [] if season else -np.inf)

    def grown(centre: int) -> Run:
        """Return the longest run around a member that has a design."""
        hours, runs = excess_h(), [(centre, 1)]
        while len(runs) < count:
            first, length = runs[-1]
            left, right = hours[first - 1], hours[(first + length) % len(hours)]
            runs.append(((first - int(left >= right)) % count, length + 1))
        run = runs[bisect_left(runs, True, lo=1, key=lambda longer: not covered(longer)) - 1]
        while run[1] < count:
            longer = [(run[0] + shift, run[1] + 1) for shift in _SHIFTS]
            inside = (it for it in longer if season or 0 <= it[0] <= count - it[1])
            if (longest := next(filter(covered, inside), None)) is None:
                break
            run = longest
        return run

    sun = day.specific_power_w_per_m2.sum(axis=-1).reshape(count, -1).min(axis=-1)
    centre = int(np.lexsort((sun, excess_h()[:count]))[-1])
    if not covered((centre, 1)):
        centre = max(
            range(0, count, count // _SAMPLES), key=lambda member: sized((member, 1)).merit
        )
    if not covered((centre, 1)):
        failed = sized((centre, 1), explain=True)
        return WidestRange(replace(failed, objective=objective, optimum=None))
    run, hours = grown(centre), excess_h()
    for peak in np.flatnonzero((hours > np.roll(hours, 1)) & (hours >= np.roll(hours, -1))):
        if peak not in places(run) and covered((int(peak), 1)):
            run = max(run, grown(int(peak)), key=lambda it: it[1])
    kept = members[places(run)]
    extent = float(run[1] if season else kept[-1] - kept[0])
    result = replace(
        sized(run),
        objective=objective,
        objective_value=extent,
        required_excess_time_h=required_h,
        optimum=None,
    )
    return WidestRange(result, float(kept[0]), float(kept[-1]), kept, extent)
