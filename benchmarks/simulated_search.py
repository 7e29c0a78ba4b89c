"""Search for the best design by simulation alone: no program, no derivatives, no start but chance.

Differential evolution over the same variables and bounds as the optimiser (Storn and Price 1997,
"Differential Evolution", J. Global Optimization 11), whole generations simulated at once. Designs
are compared by the rules of Deb (2000), "An efficient constraint handling method for genetic
algorithms", section 3: feasible before infeasible, then by objective, or by how much is missed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from benchmarks.wild_problems import WildProblem
from missions.mission import Scenarios
from sizing.day.light import DEFAULT_STEP_H, SolarDay, solar_day
from sizing.design import DesignVariables, variables_of
from sizing.limits import design_requirements, meets_requirements
from sizing.performance import Performance, performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.ranges import DAYS, LATITUDES_DEG
from sizing.program.result import objective_value
from solar.types import BoolArray, FloatArray

# Next to where the battery runs empty the excess time jumps; steps of a minute do not always
# tell on which side a design is.
FINE_STEP_H = 10.0 / 3600.0
FINE_ALLOWANCE_H = 0.02  # of excess time, between the usual steps and the fine ones
_COARSE_STEP_H, _FINE_RANGE_STEP_H = 0.25, 1.0 / 60.0
_FINE_CLIMB_STEP_H = 1.0 / 60.0
_HEAVIEST_PAYLOAD_KG, _MOST_PAYLOAD_W = 500.0, 2e4
# What an infeasible design misses without being able to carry itself: worse than any other.
_CANNOT_FLY = 100.0
_SPREADS = (0.1, 0.02, 0.003)


class Axis(NamedTuple):
    """A free variable: its bounds, and the constant added before the logarithm is taken."""

    name: str
    low: float
    high: float
    offset: float = 0.0

    def value(self, share: FloatArray) -> FloatArray:
        """Value at a share of the logarithmic range."""
        ends = np.log(self.low + self.offset), np.log(self.high + self.offset)
        raw = np.exp(ends[0] + share * (ends[1] - ends[0])) - self.offset
        return np.asarray(np.clip(raw, self.low, self.high))

    def share(self, value: float) -> float:
        """Share of the logarithmic range at which the value lies."""
        low, high, here = np.log(np.array([self.low, self.high, value]) + self.offset)
        return float(np.clip((here - low) / (high - low), 0.0, 1.0))

    @property
    def width(self) -> float:
        """Logarithmic width of the range."""
        return float(np.log((self.high + self.offset) / (self.low + self.offset)))


@dataclass(frozen=True)
class Effort:
    """How long the search is: designs drawn at first, then the population and its generations."""

    drawn: int = 600
    population: int = 48
    generations: int = 60
    polishing: int = 40


_RANGE_EFFORT = Effort(drawn=60, population=20, generations=25, polishing=6)
_CLIMB_EFFORT = Effort(drawn=300, population=32, generations=40, polishing=40)


class Found(NamedTuple):
    """Best design of a search: what it misses (0: feasible), its cost, and its variables.

    ``cost_by_chance`` is that of the population that began at random, with coarse steps; NaN where
    it has no feasible design.
    """

    missed: float
    cost: float
    variables: DesignVariables
    cost_by_chance: float

    @property
    def feasible(self) -> bool:
        """Whether the design meets every requirement."""
        return self.missed == 0.0


class Judge:
    """Simulator as the judge of designs of a problem; cost is the objective to be minimised."""

    def __init__(self, problem: WildProblem) -> None:
        self.problem = problem
        self.axes = axes_of(problem)
        self.days: dict[float, SolarDay] = {}
        self.simulated, self.overstated_h = 0, 0.0

    def variables(self, shares: FloatArray) -> DesignVariables:
        """Designs at shares of the logarithmic ranges, one design a row."""
        own = variables_of(self.problem.aircraft).chosen()
        fixed = {name: np.full(len(shares), value) for name, value in own.items()}
        free = {axis.name: axis.value(shares[:, i]) for i, axis in enumerate(self.axes)}
        return DesignVariables(**(fixed | free))

    def shares(self, variables: DesignVariables) -> FloatArray:
        """Shares of a single design; payloads that it does not choose are none."""
        chosen = variables.chosen()
        return np.array([axis.share(float(chosen.get(axis.name, 0.0))) for axis in self.axes])

    def performance(self, variables: DesignVariables, step_h: float) -> Performance:
        """Simulate designs with a time step."""
        p = self.problem
        if step_h not in self.days:
            self.days[step_h] = solar_day(
                p.aircraft, p.mission, p.solar, scenarios=self._scenarios(step_h), step_h=step_h
            )
        self.simulated += np.size(variables.wingspan_m)
        return performance_of_designs(
            p.aircraft, p.mission, variables, p.solar, day=self.days[step_h]
        )

    def _scenarios(self, step_h: float) -> Scenarios | None:
        """Scenarios to be simulated with a time step; None for the mission's own."""
        del step_h  # the same with every step
        return None

    def excess_h(self, perf: Performance) -> FloatArray:
        """Excess time that a design must have [h]."""
        return np.asarray(np.min(perf.cycle.excess_time_h, axis=-1))

    def learn_overstated(self, shares: FloatArray) -> None:
        """Ask of the usual steps what they overstate near a design, for one that fine steps keep.

        With climbs both differ by more than the optimum's tolerance, and the product asks both.
        """
        usual, fine = (
            float(self.excess_h(self.performance(self.variables(shares), step_h))[0])
            for step_h in (DEFAULT_STEP_H, self.fine_step_h)
        )
        if 0.0 < usual - fine < FINE_ALLOWANCE_H:
            self.overstated_h = usual - fine

    def value(self, perf: Performance, allowance_h: float = 0.0) -> FloatArray:
        """Objective of designs, NaN where a requirement is missed, as the optimiser counts it.

        Parameters
        ----------
        perf : Performance
            Of a batch of designs.
        allowance_h : float
            By how much the required excess time may be missed [h].

        Returns
        -------
        ndarray
            One value a design.
        """
        excess_h = self.excess_h(perf)
        kept = (excess_h > 0.0) & (excess_h >= self.problem.required_h - allowance_h)
        kept = kept & meets_requirements(self.problem.aircraft, perf.design)
        return np.where(kept, self.objective(perf), np.nan)

    def confirms(self, shares: FloatArray) -> BoolArray:
        """Whether designs stay feasible with fine steps, a few at a time."""
        several = np.array_split(shares, -(-len(shares) // 8))
        perfs = (self.performance(self.variables(some), self.fine_step_h) for some in several)
        return np.concatenate([~np.isnan(self.value(perf, self.allowance_h)) for perf in perfs])

    @property
    def allowance_h(self) -> float:
        """By how much fine steps may fall short of the required excess time [h]."""
        asked = self.problem.mission.climb is not None and not self.problem.objective.of_range
        return 0.0 if asked else FINE_ALLOWANCE_H

    @property
    def fine_step_h(self) -> float:
        """Time step that confirms a design [h]; days with climbs are marched, which takes long."""
        return FINE_STEP_H if self.problem.mission.climb is None else _FINE_CLIMB_STEP_H

    def objective(self, perf: Performance) -> FloatArray:
        """Objective of designs whether or not they are feasible."""
        return objective_value(self.problem.objective, perf)

    def judged(self, shares: FloatArray, step_h: float) -> tuple[FloatArray, FloatArray]:
        """What designs miss, 0 where they are feasible, and their cost."""
        perf = self.performance(self.variables(shares), step_h)
        value = self.value(perf, -self.overstated_h)
        cost = -value if self.problem.objective.maximised else value
        return np.where(np.isnan(value), self._missed(perf), 0.0), cost

    def _missed(self, perf: Performance) -> FloatArray:
        excess_h = self.excess_h(perf) - self.overstated_h
        short_h = np.maximum(self.problem.required_h - excess_h, 0.0) + (excess_h <= 0.0)
        missed = short_h / 24.0
        with np.errstate(invalid="ignore", over="ignore"):
            for row in design_requirements(self.problem.aircraft, perf.design):
                if row.name != "mass_budget":
                    missed = missed + np.maximum(-np.asarray(row.value), 0.0)
            heaviest = self.problem.aircraft.design_space.maximum_total_mass_kg or np.inf
            missed = missed + np.maximum(perf.design.total_mass_kg / heaviest - 1.0, 0.0)
        flies = np.isfinite(perf.design.total_mass_kg)
        return np.where(flies & np.isfinite(missed), np.maximum(missed, 1e-12), _CANNOT_FLY)


class RangeJudge(Judge):
    """Judge of the designs of the longest season or the widest band of latitudes.

    The value is the number of days, or of degrees, that follow each other; its fraction tells how
    near the next one is. With the coarse step only every fifth member is looked at.
    """

    def _scenarios(self, step_h: float) -> Scenarios:
        every = 5 if step_h == _COARSE_STEP_H else 1
        mission = self.problem.mission
        if self.season:
            days, latitudes = DAYS[::every], np.asarray(mission.latitudes(), float)
            return Scenarios(np.tile(latitudes, len(days)), np.repeat(days, len(latitudes)))
        dates = np.asarray(mission.dates.days(), int)
        members = LATITUDES_DEG[::every]
        return Scenarios(np.repeat(members, len(dates)), np.tile(dates, len(members)))

    @property
    def fine_step_h(self) -> float:
        """Time step that confirms a design [h]: of hundreds of scenarios, a coarser one."""
        return _FINE_RANGE_STEP_H

    @property
    def season(self) -> bool:
        """Whether the range is one of days."""
        return self.problem.objective is Objective.longest_season

    def _members(self, perf: Performance) -> FloatArray:
        """Worst excess time at every member of the range, the last axis."""
        mission = self.problem.mission
        each = len(mission.latitudes() if self.season else mission.dates.days())
        excess_h = perf.cycle.excess_time_h
        return np.asarray(excess_h.reshape(*excess_h.shape[:-1], -1, each).min(axis=-1))

    def excess_h(self, perf: Performance) -> FloatArray:
        """Excess time of the easiest member [h]: a range needs one."""
        return np.asarray(self._members(perf).max(axis=-1))

    def objective(self, perf: Performance) -> FloatArray:
        """Length of the longest run of members, days or degrees, and how near the next one is."""
        excess_h = self._members(perf)
        runs = [self._longest_run(row) for row in excess_h.reshape(-1, excess_h.shape[-1])]
        return np.array(runs).reshape(excess_h.shape[:-1])

    def _longest_run(self, excess_h: FloatArray) -> float:
        held = (excess_h > 0.0) & (excess_h >= self.problem.required_h)
        count = len(held)
        unit = round((len(DAYS) if self.season else len(LATITUDES_DEG)) / count)
        if held.all() or not held.any():
            return float(count * unit if held.all() else 0.0)
        turn = int(np.argmin(held)) if self.season else 0  # begin where the run is broken
        row, excess_h = np.roll(held, -turn), np.roll(excess_h, -turn)
        edges = np.flatnonzero(np.diff(np.concatenate(([0], row, [0]))))
        starts, ends = edges[::2], edges[1::2]
        longest = int(np.argmax(ends - starts))
        first, last = int(starts[longest]) - 1, int(ends[longest])
        beside = [excess_h[i % count] for i in (first, last) if self.season or 0 <= i < count]
        short_h = self.problem.required_h - max(beside, default=-np.inf)
        near = 1.0 / (1.0 + max(short_h, 0.0))
        # A band of n latitudes is n - 1 degrees wide.
        return float((last - first - 1) * unit - (not self.season) + 0.99 * near)


def judge_of(problem: WildProblem) -> Judge:
    """Judge for the objective of a problem."""
    return RangeJudge(problem) if problem.objective.of_range else Judge(problem)


def axes_of(problem: WildProblem) -> list[Axis]:
    """Variables that the optimiser may choose for a problem, with their bounds."""
    space = problem.aircraft.design_space
    ranges = {
        "wingspan_m": space.wingspan_m,
        "battery_mass_kg": space.battery_mass_kg,
        "module_area_m2": space.module_area_m2,
        "aspect_ratio": space.aspect_ratio,
        "lift_coefficient": space.lift_coefficient,
    }
    axes = [Axis(name, r.minimum, r.maximum) for name, r in ranges.items() if r is not None]
    if problem.objective is Objective.max_payload_mass:
        axes.append(Axis("payload_mass_kg", 0.0, _HEAVIEST_PAYLOAD_KG, 0.05))
    if problem.objective is Objective.max_payload_power:
        axes.append(Axis("payload_power_w", 0.0, _MOST_PAYLOAD_W, 1.0))
    return axes


def search(
    judge: Judge, seed: int, known: DesignVariables | None = None, effort: Effort | None = None
) -> Found:
    """Best design by simulation alone.

    Parameters
    ----------
    judge : Judge
        Simulator of the problem.
    seed : int
        Of all that is random.
    known : DesignVariables, optional
        Around this design there is a second population, besides the random one.
    effort : Effort, optional
        Length of the search.

    Returns
    -------
    Found
        Judged with the usual time step.
    """
    how = effort or _usual_effort(judge)
    rng = np.random.default_rng(seed)
    drawn = _latin_hypercube(rng, how.drawn, len(judge.axes))
    population = _Population(judge, rng, drawn, _COARSE_STEP_H).best(how.population)
    population.evolve(how.generations)
    elite = population.best(how.population // 2)
    centre = elite.shares[0] if known is None else judge.shares(known)
    around = _around(judge, rng, centre, how.population)
    last = _Population(judge, rng, np.vstack([elite.shares, around]), DEFAULT_STEP_H)
    last = last.best(how.population)
    last.evolve(how.polishing)
    if judge.allowance_h == 0.0:
        judge.learn_overstated(last.best(1).shares)
        around = _around(judge, rng, centre, how.population)
        last = _Population(judge, rng, np.vstack([last.shares, around]), DEFAULT_STEP_H)
        last = last.best(how.population)
        last.evolve(how.polishing)
    winner = last.confirmed()
    variables = judge.variables(winner.shares).mapped(lambda v: float(np.asarray(v)[0]))
    by_chance = float(elite.cost[0])
    return Found(float(winner.missed[0]), float(winner.cost[0]), variables, by_chance)


def _usual_effort(judge: Judge) -> Effort:
    """Length of a search: days with climbs take ten times as long to simulate."""
    if isinstance(judge, RangeJudge):
        return _RANGE_EFFORT
    return Effort() if judge.problem.mission.climb is None else _CLIMB_EFFORT


class _Population:
    """Designs and what the simulator says of them."""

    def __init__(
        self,
        judge: Judge,
        rng: np.random.Generator,
        shares: FloatArray,
        step_h: float,
        known: tuple[FloatArray, FloatArray] | None = None,
    ) -> None:
        self.judge, self.rng, self.shares, self.step_h = judge, rng, shares, step_h
        self.missed, self.cost = judge.judged(shares, step_h) if known is None else known

    def best(self, count: int) -> _Population:
        """Best designs, the best one first."""
        order = np.lexsort((self.cost, self.missed))[:count]
        said = self.missed[order], self.cost[order]
        return _Population(self.judge, self.rng, self.shares[order], self.step_h, said)

    def confirmed(self) -> _Population:
        """Best design of those that stay feasible with fine steps; the best one if none does."""
        first = self.best(1)
        if first.missed[0] > 0.0 or self.judge.confirms(first.shares)[0]:
            return first
        feasible = self.best(int(np.sum(self.missed == 0.0)))
        fine = np.flatnonzero(self.judge.confirms(feasible.shares))
        place = fine[:1] if fine.size else np.array([0])
        said = feasible.missed[place], feasible.cost[place]
        return _Population(self.judge, self.rng, feasible.shares[place], self.step_h, said)

    def evolve(self, generations: int) -> None:
        """Differential evolution, current to one of the best third, binomial crossover."""
        rng, (count, width) = self.rng, self.shares.shape
        for _ in range(generations):
            order = np.lexsort((self.cost, self.missed))
            guide = self.shares[order[rng.integers(0, max(count // 3, 2), count)]]
            one, other = self.shares[rng.integers(0, count, (2, count))]
            factor = rng.uniform(0.3, 0.9, (count, 1))
            trial = self.shares + factor * (guide - self.shares + one - other)
            kept = rng.random((count, width)) > 0.9
            kept[np.arange(count), rng.integers(0, width, count)] = False
            trial = np.where(kept, self.shares, trial)
            # Beyond a bound: on it half the time, since optima often are, else half-way to it.
            bound = np.where(rng.random((count, width)) < 0.5, 1.0, 0.5)
            low = np.where(trial < 0.0, self.shares * (1.0 - bound), trial)
            trial = np.where(trial > 1.0, self.shares + bound * (1.0 - self.shares), low)
            missed, cost = self.judge.judged(trial, self.step_h)
            tied = missed == self.missed
            better = (missed < self.missed) | (tied & ~(cost > self.cost))
            self.shares = np.where(better[:, np.newaxis], trial, self.shares)
            self.missed = np.where(better, missed, self.missed)
            self.cost = np.where(better, cost, self.cost)


def _latin_hypercube(rng: np.random.Generator, count: int, width: int) -> FloatArray:
    """Shares that are spread evenly along every axis."""
    cells = np.stack([rng.permutation(count) for _ in range(width)], axis=-1)
    return np.asarray((cells + rng.random((count, width))) / count)


def _around(judge: Judge, rng: np.random.Generator, centre: FloatArray, count: int) -> FloatArray:
    """Designs around one, far and near; the first one is the design itself."""
    widths = np.array([axis.width for axis in judge.axes])
    spread = np.resize(_SPREADS, count)[:, np.newaxis] / widths
    shares = centre + spread * rng.standard_normal((count, len(centre)))
    shares[0] = centre
    return np.asarray(np.clip(shares, 0.0, 1.0))
