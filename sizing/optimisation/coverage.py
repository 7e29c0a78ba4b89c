"""The longest season, or the widest band of latitudes, in which one design flies perpetually.

A design covers a range if its worst scenario there has the required excess time; the best
design for a range is the one with the largest worst excess time. Ranges around the easiest day or
latitude are nested by adding, again and again, the easier one of the two neighbours; the largest
that has a feasible design is found by bisection. Which neighbour is easier depends on the design,
but hardly: the order is taken anew from the best design until the range grows no more. Then all
runs one longer are tried that begin within a few members of it. Near the equator the year has two
easy seasons: where there may be several, a range is grown around the easiest member of each.
A run that grows no more is moved along to where its worst excess time is largest, which may leave
room for more. On the way any design with the required excess time will do; at last the best one for
the whole range is told.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.design import DesignVariables, variables_of
from sizing.optimisation.infeasibility import violations
from sizing.optimisation.problem import SizingProblems
from sizing.optimisation.result import SizingResult, SizingStatus, limiting_rows
from sizing.optimisation.search import size_aircraft
from sizing.performance import Performance, performance_of_designs
from sizing.program.objectives import Objective
from sizing.sunlight import UNCORRECTED_CAM, SolarDay, SolarModel, solar_day
from solar.types import BoolArray, FloatArray, IntArray

DAYS = np.arange(1, 366)
LATITUDES_DEG = np.arange(-90.0, 90.5, 1.0)
_SLID = 3  # times that a run is moved along at most
_OTHER_CENTRES = (1, 2, 4, 8, 16, 32)
_SHIFTS = (0, -1, 1, -2, 2, -3)
_SLIDES = (8, 4, 2, 1)
_MOST_H = 1e6  # more than any but an unlimited excess time
_GAIN_H = 1e-4  # less is what the search leaves open
_SAMPLES = 30  # members that are sized on their own in search of other easy seasons
_VALLEY_H = 0.002  # lower by less than that it parts no peaks: what time steps do


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
        if self.sizing.objective is Objective.longest_season:
            return float(len(self.members))
        return self.last - self.first


def widest_range(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    required_excess_time_h: float | None = None,
    problems: SizingProblems | None = None,
) -> WidestRange:
    """Find the design that covers the longest season or the widest band of latitudes.

    ``aircraft``, ``mission``, ``solar``: as for :func:`sizing.optimisation.search.size_aircraft`.
    For ``longest_season`` every day of the year is tried at the latitudes of the mission, for
    ``widest_latitude_band`` every full degree on its dates.
    """
    if not objective.of_range:
        raise ValueError(f"{objective.value} is no range: use size_aircraft")
    required = mission.required_excess_time_h
    required = required if required_excess_time_h is None else required_excess_time_h
    problems = problems or SizingProblems(aircraft)
    return _Growth(aircraft, mission, objective, solar, required, problems).run()


class _Growth:
    """Grows the range around its easiest member."""

    def __init__(
        self,
        aircraft: Aircraft,
        mission: Mission,
        objective: Objective,
        solar: SolarModel,
        required_h: float,
        problems: SizingProblems,
    ) -> None:
        self.aircraft, self.mission, self.solar = aircraft, mission, solar
        self.objective, self.required_h, self.problems = objective, required_h, problems
        self.season = objective is Objective.longest_season
        self.members = DAYS.astype(float) if self.season else LATITUDES_DEG
        self.day = solar_day(aircraft, mission, solar, scenarios=self._scenarios())
        self.each = len(self.day.scenarios) // len(self.members)
        self.start = variables_of(aircraft)
        self.within: set[int] = set()  # members of runs that have a design
        self.apart: list[frozenset[int]] = []  # members that have no design in common
        self.flown: tuple[DesignVariables, FloatArray] | None = None  # excess time at every member
        self.failed: set[frozenset[int]] = set()  # runs of which the solver said nothing

    def _scenarios(self) -> Scenarios:
        """Every member, with all latitudes or dates of the mission: member by member."""
        if self.season:
            latitudes = np.asarray(self.mission.latitudes(), float)
            return Scenarios(
                np.tile(latitudes, len(DAYS)), np.repeat(DAYS, len(latitudes)).astype(int)
            )
        days = np.asarray(self.mission.dates.days(), int)
        return Scenarios(np.repeat(LATITUDES_DEG, len(days)), np.tile(days, len(LATITUDES_DEG)))

    def run(self) -> WidestRange:
        order = self._easiest(self.start)
        centre, best = order[0], self._sized([order[0]], explain=True)
        for place in _OTHER_CENTRES:
            # Where the solver fails, nothing is said about the other members.
            if best.status is not SizingStatus.not_converged or place >= len(order):
                break
            centre, best = order[place], self._sized([order[place]])
        best, held = self._grown(best, centre) if self._enough(best) else (best, [])
        for easiest, result in self._other_centres(best, held):
            if not held and _reached_h(result) > _reached_h(best):
                best = result  # the nearest, if no other is enough either
            if easiest in held or not self._enough(result):
                continue
            result, others = self._grown(result, easiest)
            if len(others) > len(held):
                best, held = result, others
        if not held:
            return WidestRange(self._named(best, None), None, None, np.empty(0))
        return self._result(best, held)

    def _grown(self, best: SizingResult, centre: int) -> tuple[SizingResult, list[int]]:
        """Longest run around a member, from the design for that member alone."""
        held, slides = [centre], 0
        while len(held) < len(self.members):
            nested = self._nested(best, held)
            count, result = self._largest(nested, len(held))
            if result is not None:
                best, held = result, sorted(nested[:count])
                continue
            before = held
            if slides < _SLID:
                slides += 1
                best, held = self._slid(best, held)
            if held == before:
                best, held = self._longer(best, held)
            if held == before:
                break
        return best, held

    def _slid(self, best: SizingResult, held: list[int]) -> tuple[SizingResult, list[int]]:
        """Move a run along, by ever smaller steps, as long as its worst excess time grows."""
        for step in _SLIDES:
            for way in (-step, step):
                moved = False
                while run := self._neighbouring_run(held, way, way):
                    if set(self._limiting(held, best)) <= set(run):
                        break  # what holds the one back holds the other back as well
                    result = self._covering(run)
                    if result is None or _reached_h(result) <= _reached_h(best) + _GAIN_H:
                        break
                    best, held, moved = result, sorted(run), True
                if moved:
                    break
        return best, held

    def _neighbouring_run(self, held: list[int], before: int, behind: int) -> list[int]:
        """Run whose ends lie some members off those of another; empty where there is none."""
        count = len(self.members)
        first, last = self._ends(held)
        run = np.arange(first + before, last + behind + 1)
        if len(run) > count or not (self.season or (run[0] >= 0 and run[-1] < count)):
            return []
        return [int(i) for i in run % count]

    def _other_centres(self, best: SizingResult, held: list[int]) -> list[tuple[int, SizingResult]]:
        """Members around which there may be a longer run, sized for themselves, the easiest first.

        They are looked for where the excess time of the best design so far has more than one peak,
        or where there is no design yet: a few members, each sized for itself, tell.
        """
        count = len(self.members)
        variables = self.start if best.design is None else best.design.variables
        if len(held) == count or (held and len(self._peaks(self._excess_h(variables))) < 2):
            return []
        # What the run holds already needs no sizing, and is no other centre.
        inside = set(held)
        some = [int(i) for i in np.arange(0, count, count // _SAMPLES)]
        sized = [best if i in inside else self._sized([i]) for i in some]
        excess_h = [
            np.inf if i in inside else _reached_h(one) for i, one in zip(some, sized, strict=True)
        ]
        peaks = self._peaks(np.array(excess_h))
        return [(some[i], sized[i]) for i in peaks]

    def _peaks(self, excess_h: FloatArray) -> list[int]:
        """Places of the peaks that are parted from higher ones by a valley."""
        peaks: list[int] = []
        for place in np.argsort(-excess_h, kind="stable"):
            ways = [self._ways_between(int(place), peak, len(excess_h)) for peak in peaks]
            if all(
                excess_h[way].min() < excess_h[place] - _VALLEY_H for both in ways for way in both
            ):
                peaks.append(int(place))
        return peaks

    def _ways_between(self, one: int, other: int, count: int) -> list[IntArray]:
        """Places from one to another, and the other way round through the year's end."""
        first, last = sorted((one, other))
        inside = np.arange(first, last + 1)
        if not self.season:
            return [inside]
        return [inside, np.arange(last, first + count + 1) % count]

    def _longer(self, best: SizingResult, held: list[int]) -> tuple[SizingResult, list[int]]:
        """Grow a run by one member, at either end or a little beside it, if that goes.

        What its design covers beyond that needs no sizing.
        """
        for shift in _SHIFTS:
            run = self._neighbouring_run(held, shift, shift + 1)
            result = self._covering(run) if run else None
            if result is not None:
                nested = self._nested(result, run)
                count = max(self._covered(result, nested), len(run))
                return self._over(result, nested[:count]), sorted(nested[:count])
        return best, held

    def _excess_h(self, variables: DesignVariables) -> FloatArray:
        """Worst excess time of a design at every member."""
        if self.flown is None or self.flown[0] != variables:
            cycle = self._flown_by(variables, self.day).cycle
            each = np.asarray(cycle.excess_time_h.reshape(len(self.members), -1).min(axis=-1))
            self.within.update(int(i) for i in np.flatnonzero(self._enough_h(each)))
            self.flown = variables, each
        return self.flown[1]

    def _flown_by(self, variables: DesignVariables, day: SolarDay) -> Performance:
        return performance_of_designs(self.aircraft, self.mission, variables, self.solar, day=day)

    def _enough_h(self, excess_h: FloatArray) -> BoolArray:
        return (excess_h > 0.0) & (excess_h >= self.required_h)

    def _easiest(self, variables: DesignVariables) -> list[int]:
        """Members, that of the most excess time first; of those without a night, by their sun."""
        excess = self._excess_h(variables)
        power = self.day.specific_power_w_per_m2
        sun = power.sum(axis=-1).reshape(len(self.members), -1).min(axis=-1)
        return [int(i) for i in np.lexsort((sun, excess))[::-1]]

    def _nested(self, best: SizingResult, held: list[int]) -> list[int]:
        """Members in the order in which the best design gives them up, last first."""
        assert best.design is not None
        excess = self._excess_h(best.design.variables)
        count = len(self.members)
        order = list(held)
        low, high = self._ends(held)
        while len(order) < count:
            left, right = low - 1, high + 1
            if self.season:
                left, right = left % count, right % count
            can_left, can_right = left >= 0, right < count
            if can_left and (not can_right or excess[left] >= excess[right]):
                order.append(left)
                low -= 1
            else:
                order.append(right)
                high += 1
        return order

    def _ends(self, held: list[int]) -> tuple[int, int]:
        """First and last index of a run of members, beyond the year's end if need be."""
        if not self.season:
            return min(held), max(held)
        present = np.zeros(len(self.members), bool)
        present[held] = True
        if present.all():
            return 0, len(self.members) - 1
        starts = np.flatnonzero(present & ~np.roll(present, 1))
        first = int(starts[0])
        return first, first + len(held) - 1

    def _largest(self, nested: list[int], held: int) -> tuple[int, SizingResult | None]:
        """Largest number of members that one design covers, above those held already.

        A design for some of them may cover more, which needs no sizing.
        """
        low, high, best = held, len(nested) + 1, None
        step = 1 if held > 1 else len(nested)
        while high - low > 1:
            # A run that has grown before will hardly grow by much.
            middle = min((low + high) // 2, low + step)
            step *= 2
            result = self._covering(nested[:middle])
            if result is None:
                high = middle
                continue
            low = max(middle, min(self._covered(result, nested), high - 1))
            best = result if low == middle else self._over(result, nested[:low])
        return low, best

    def _covered(self, result: SizingResult, nested: list[int]) -> int:
        """How many members, from the first on, a design covers."""
        assert result.design is not None
        enough = self._enough_h(self._excess_h(result.design.variables)[nested])
        return int(np.argmin([*enough, False]))

    def _over(self, result: SizingResult, members: list[int]) -> SizingResult:
        """A design in a run that it covers, though it was sized for a part of it."""
        assert result.design is not None
        excess_h = float(self._excess_h(result.design.variables)[members].min())
        return replace(result, objective_value=excess_h, optimum=None)

    def _covering(self, members: list[int]) -> SizingResult | None:
        """Design for a run of members; None where it is not enough.

        A run has no design if some of its members have none in common. Once the solver has failed
        without a reason the ends of a run, which are the hardest, are sized on their own first.
        Where it fails on a run, the design for an end alone may cover it.
        """
        if self.failed:
            self._try_ends(members)
        if self._ruled_out(members):
            return None
        result = self._sized(members, enough_h=self.required_h)
        self._learn(members, result)
        if self._enough(result):
            return result
        if result.status is not SizingStatus.not_converged:
            return None
        self._try_ends(members)
        for end in () if self._apart(members) else self._ends(members):
            result = self._sized([end % len(self.members)])
            if self._enough(result) and self._covered(result, members) == len(members):
                return self._over(result, members)
        return None

    def _try_ends(self, members: list[int]) -> None:
        """Size the ends of a run on their own, as long as nothing rules it out."""
        for end in self._ends(members):
            alone = [end % len(self.members)]
            known = not self.within.isdisjoint(alone) or self._ruled_out(alone)
            if not (known or self._apart(members)):
                self._learn(alone, self._sized(alone, explain=True, enough_h=self.required_h))

    def _ruled_out(self, members: list[int]) -> bool:
        return frozenset(members) in self.failed or self._apart(members)

    def _apart(self, members: list[int]) -> bool:
        return any(some <= frozenset(members) for some in self.apart)

    def _learn(self, members: list[int], result: SizingResult) -> None:
        """Remember which members have a design in common, or which have none."""
        if self._enough(result):
            self.within.update(members)
        elif result.status is SizingStatus.not_converged:
            self.failed.add(frozenset(members))
        else:
            limiting = self._limiting(members, result)
            if limiting == members or not self._enough(self._sized(limiting)):
                self.apart.append(frozenset(limiting))

    def _limiting(self, members: list[int], result: SizingResult) -> list[int]:
        """Members whose scenarios hold the best design back; all where they are not known."""
        if result.optimum is None:
            return members
        scenarios = result.optimum.scenarios
        places = {
            scenarios[row.block] // self.each
            for row in limiting_rows(result.optimum)
            if row.block is not None
        }
        return [members[place] for place in sorted(places)] or members

    def _sized(
        self, members: list[int], *, explain: bool = False, enough_h: float = np.inf
    ) -> SizingResult:
        result = size_aircraft(
            self.aircraft,
            self.mission,
            Objective.max_excess_time,
            self.solar,
            required_excess_time_h=0.0,
            day=self._day_of(members),
            problems=self.problems,
            start=self.start,
            explain=explain,
            enough_h=enough_h,
        )
        if result.design is not None:
            self.start = result.design.variables
        return result

    def _day_of(self, members: list[int]) -> SolarDay:
        places = np.asarray(members)[:, np.newaxis] * self.each + np.arange(self.each)
        return self.day.at(places.ravel())

    def _enough(self, result: SizingResult) -> bool:
        return result.objective_value is not None and _reached_h(result) >= self.required_h

    def _result(self, best: SizingResult, held: list[int]) -> WidestRange:
        assert best.design is not None
        self.start = variables = best.design.variables
        best = max(self._sized(held, enough_h=_MOST_H), best, key=_reached_h)
        if best.optimum is None:
            best = replace(best, simulated=self._flown_by(variables, self._day_of(held)))
        first, last = self._ends(held)
        members = self.members[np.arange(first, last + 1) % len(self.members)]
        ends = (float(members[0]), float(members[-1]))
        extent = float(len(members)) if self.season else ends[1] - ends[0]
        return WidestRange(self._named(best, extent), *ends, members)

    def _named(self, sizing: SizingResult, extent: float | None) -> SizingResult:
        """Sizing under the name of the objective of the range."""
        named = replace(
            sizing,
            objective=self.objective,
            required_excess_time_h=self.required_h,
            objective_value=extent,
            optimum=None,
        )
        short = sizing.simulated
        if extent is not None or short is None:
            return named
        # It flies, but with less excess time than required.
        missed = {"excess_time": self.required_h - float(np.min(short.cycle.excess_time_h))}
        found = violations(self.aircraft, missed, short, self.required_h)
        return named.without_design(SizingStatus.infeasible, short, *sizing.violations, *found)


def _reached_h(sizing: SizingResult) -> float:
    """Largest worst excess time, minus infinity where there is no design."""
    return -np.inf if sizing.objective_value is None else sizing.objective_value
