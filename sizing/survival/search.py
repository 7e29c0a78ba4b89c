"""Search for the best design that closes a share of a season's days.

The constraint "so many days of the record close" is a staircase that no gradient sees. It depends
on a design by two numbers alone, or nearly so: income, what the modules collect over the load, and
storage, what the battery holds over the load. Simulated batches of designs with other income and
storage find its edge. On the other side, the program finds the best design for one repeated day
with any factors on income and storage; its designs are the best ones of all places on that plane.
The search walks along the edge to where the program's objective is best, and has every design that
counts flown through the record. As in sequential optimisation and reliability assessment (Du, X.,
Chen, W. (2004), J. Mech. Des. 126, 225-233) optimisation and assessment alternate.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft, LimitedQuantity
from sizing.design import Design, DesignVariables, FlightConditions, closed_design
from sizing.limits import meets_requirements
from sizing.optimisation.infeasibility import least_mission
from sizing.optimisation.objectives import Objective
from sizing.optimisation.problem import SizingProblems
from sizing.optimisation.result import SizingResult
from sizing.optimisation.search import size_aircraft
from sizing.optimisation.solver import SolverReport
from sizing.sunlight import SolarDay, SolarModel, solar_day
from sizing.survival.contour import Count, fitted, least_income, least_step
from sizing.survival.flights import Powers, SeasonFlights
from solar.types import FloatArray, IntArray

# The program's day: one with a night of about twelve hours at any site. Which one does not matter,
# as factors on income and storage are free.
_EQUINOX, _HIGHEST_LATITUDE_DEG = 80, 45.0
_DAY_STEP_H = 0.5
# Logarithms of factors on income and storage.
_FIRST = ((0.0, 0.0), (0.7, 0.4), (1.5, 0.8))  # easier from one to the next
_STORAGES = np.linspace(-1.5, 1.5, 9)
_INCOMES = (-2.0, 3.0)
_WIDTHS = (0.8, 0.3, 0.1, 0.03)  # of the stretch of the edge that is looked at
_EDGE_POINTS = 25
_VALUES_AT_ONCE = 2_000_000  # of the solar power of designs that are flown together
_SLOPE_STEP = 0.06
_REPEATS, _GAIN = 3, 1e-3
_ANGLES = np.radians([0.0, 22.5, 45.0, 67.5, 90.0])  # from more income to more storage
_FURTHEST, _NEXT_TO_FURTHEST = 2.0, 0.01
_BACK = 3
_TUNED = 3e-4  # of income and storage that may be left unused
_TUNINGS = 6
_ALIKE = np.ones(2)
_ROW_TOLERANCE = 1e-5  # of requirements, relative: the solver meets them to about 1e-8
_SCALED_LIMITS: dict[LimitedQuantity, float] = {
    "battery_energy_wh": 1.0,
    "cruise_discharge_rate_per_h": -1.0,
    "climb_discharge_rate_per_h": -1.0,
}


class Steps:
    """Steps of one search after another: how many are done, and how many there are in all."""

    def __init__(self, progress: Callable[[int, int], None] | None) -> None:
        self._progress, self._done, self._total = progress, 0, 0

    @contextmanager
    def of(self, count: int) -> Iterator[None]:
        """Steps of one more search; those that it leaves out are done at its end."""
        self._total += count
        self._tell(self._done)
        yield
        self._tell(self._total)

    def next(self) -> None:
        """Count one step."""
        self._tell(self._done + 1)

    def _tell(self, done: int) -> None:
        self._done = done
        if self._progress is not None:
            self._progress(done, self._total)


class Candidate(NamedTuple):
    """A design that is the best one of its income and storage.

    ``factors`` are the logarithms of what the program was given more of, ``place`` those of the
    design's income and storage, ``cost`` the smaller the better.
    """

    result: SizingResult
    design: Design
    powers: Powers
    factors: FloatArray
    cost: float
    days: int

    @property
    def place(self) -> FloatArray:
        """Logarithms of income and storage, shape ``(2,)``."""
        return np.asarray(self.powers.place[:, 0])

    @property
    def variables(self) -> DesignVariables:
        """Design variables."""
        return self.design.variables


class SurvivalSearch:
    """Search of one aircraft, mission at a record's site, and objective.

    ``flights``, ``coarse``: days of the record: what counts, and on wider nodes to find the edge.
    ``steps``: steps of the search, which are told as they are done.
    """

    def __init__(
        self,
        aircraft: Aircraft,
        mission: Mission,
        objective: Objective,
        solar: SolarModel,
        flights: SeasonFlights,
        coarse: SeasonFlights,
        problems: SizingProblems,
        steps: Steps | None = None,
    ) -> None:
        self.steps = Steps(None) if steps is None else steps
        self.aircraft, self.mission, self.objective = aircraft, mission, objective
        self.solar, self.flights, self.coarse = solar, flights, coarse
        self.problems = problems
        latitude = mission.latitudes()[0]
        latitude = min(max(latitude, -_HIGHEST_LATITUDE_DEG), _HIGHEST_LATITUDE_DEG)
        where = Scenarios(np.array([latitude]), np.array([_EQUINOX]))
        self.day = solar_day(aircraft, mission, solar, scenarios=where, step_h=_DAY_STEP_H)
        self.found: list[Candidate] = []
        self.reports: list[SolverReport] = []
        self.limited = [
            name for name in _SCALED_LIMITS if name in aircraft.design_space.all_limits()
        ]

    # --- the program -------------------------------------------------------------------------

    def candidate(
        self,
        factors: Iterable[float],
        objective: Objective | None = None,
        start: DesignVariables | None = None,
    ) -> Candidate | None:
        """Best design for the program's day with factors on income and storage; None without."""
        steps = np.asarray(list(factors), float)
        wanted = self.objective if objective is None else objective
        mission = self.mission if objective is None else least_mission(self.mission, self.objective)
        mission, day = self.given(steps, mission)
        aircraft = self.with_limits(steps)
        result = size_aircraft(
            *(aircraft, mission, wanted, self.solar),
            required_excess_time_h=0.0,
            day=day,
            problems=self.problems if aircraft is self.aircraft else SizingProblems(aircraft),
            start=start,
            explain=False,
        )
        self.reports.append(result.solver)
        return None if result.design is None else self._flown_through_season(result, steps)

    def given(self, factors: FloatArray, mission: Mission) -> tuple[Mission, SolarDay]:
        """Mission and day of the program with factors on storage and income."""
        own = mission.uncertainty_margins
        # Not a margin of a file: the factor may exceed 1.
        capacity = own.battery_capacity * math.exp(factors[1])
        margins = own.model_copy(update={"battery_capacity": capacity})
        given = mission.model_copy(update={"uncertainty_margins": margins})
        return given, self.day.scaled(math.exp(factors[0]))

    def with_limits(self, factors: FloatArray) -> Aircraft:
        """Aircraft whose limits on the battery hold without the factor on its storage."""
        space, storage = self.aircraft.design_space, math.exp(factors[1])
        for name in self.limited:
            limit = self.aircraft.design_space.all_limits()[name]
            factor = storage ** _SCALED_LIMITS[name]
            if limit.minimum is not None:
                space = space.with_limit(name, "minimum", limit.minimum * factor)
            if limit.maximum is not None:
                space = space.with_limit(name, "maximum", limit.maximum * factor)
        if not self.limited:
            return self.aircraft
        return self.aircraft.model_copy(update={"design_space": space})

    def powers_of(self, variables: DesignVariables) -> Powers:
        """Powers of a design of this aircraft on this mission."""
        return Powers.of(closed_design(self.aircraft, self.mission, variables))

    def _flown_through_season(self, result: SizingResult, factors: FloatArray) -> Candidate:
        """Candidate without the factors, flown through the season."""
        assert result.design is not None
        variables = result.design.variables
        design = closed_design(self.aircraft, self.mission, variables)
        powers = Powers.of(design)
        days = int(self.flights.that_close(powers)[0])
        one = Candidate(result, design, powers, factors, self._cost(design), days)
        if self._sound(design):
            self.found.append(one)
        return one

    def _sound(self, design: Design) -> bool:
        conditions = FlightConditions.of(self.mission, self.aircraft)
        return bool(
            np.all(meets_requirements(self.aircraft, design, conditions, tolerance=_ROW_TOLERANCE))
        )

    def _cost(self, design: Design) -> float:
        """Logarithm of what is to be small, or the negative of what is to be large."""
        found = self.objective.value_of(design)
        value = float(np.asarray(0.0 if found is None else found))
        return -value if self.objective.maximised else math.log(value)

    # --- along the edge ----------------------------------------------------------------------

    def best(self, needed: int) -> Candidate | None:
        """Best design with enough days that close; None where none is found."""
        with self.steps.of(1 + len(_WIDTHS)):
            return self._cheapest(needed)

    def _cheapest(self, needed: int) -> Candidate | None:
        first = self.first()
        if first is None:
            return None
        self._along_the_edge(first, needed)
        if self._closing_candidate(needed) is None:
            self.most_days(first, needed)
        here = self._closing_candidate(needed)
        if here is None:
            return None
        for width in _WIDTHS:
            self.steps.next()
            for _ in range(_REPEATS):
                before = here
                self._improve(before, needed, width)
                here = self._closing_candidate(needed) or before
                if before.cost - here.cost < _GAIN * max(abs(here.cost), 1.0):
                    break
        return here

    def first(self) -> Candidate | None:
        """Any design at all, on the program's day with more and more light."""
        tries = (self.candidate(factors) for factors in _FIRST)
        return next((one for one in tries if one is not None), None)

    def _closing_candidate(self, needed: int) -> Candidate | None:
        good = [one for one in self.found if one.days >= needed]
        return min(good, key=lambda one: one.cost, default=None)

    def counts(self, one: Candidate, flights: SeasonFlights | None = None) -> Count:
        """Days that close with other income and storage than a candidate's.

        ``flights``: by default those on coarse nodes, less what these find otherwise of the
        candidate itself. Returns days, of logarithms of factors on income and storage.
        """

        def count(income: FloatArray, storage: FloatArray) -> IntArray:
            designs = one.powers.scaled(np.exp(income), np.exp(storage))
            return (self.coarse if flights is None else flights).that_close(designs)

        if flights is not None:
            return count
        otherwise = int(count(np.zeros(1), np.zeros(1))[0]) - one.days
        return lambda income, storage: count(income, storage) - otherwise

    def _edge(
        self, here: Candidate, storages: FloatArray, ends: tuple[float, float], needed: int
    ) -> FloatArray:
        """Least incomes beside a candidate's storages, logarithms of its own."""
        values = len(storages) * self.coarse.specific_w_per_m2.size
        at_once = min(max(_VALUES_AT_ONCE // values, 1), 7)
        return least_income(self.counts(here), storages, ends, needed, at_once=at_once)

    def _along_the_edge(self, first: Candidate, needed: int) -> None:
        """Try places all along the edge of what closes enough days."""
        incomes = self._edge(first, _STORAGES, _INCOMES, needed)
        start = first.variables
        for step in np.stack([incomes, _STORAGES], axis=-1)[np.isfinite(incomes)]:
            one = self.candidate(first.factors - step, start=start)
            if one is not None:
                self._tuned(one, needed)

    def _improve(self, here: Candidate, needed: int, width: float) -> None:
        """Go to the best place along a stretch of the edge."""
        for step in min(width / 2.0, _SLOPE_STEP) * np.eye(2):
            self.candidate(here.factors + step, start=here.variables)
        near = [one for one in self.found if np.all(np.abs(one.place - here.place) < 1.0)]
        cost = fitted(
            np.array([one.place for one in near]),
            np.array([one.cost for one in near]),
            next(i for i, one in enumerate(near) if one is here),
        )
        storages = np.linspace(-width, width, _EDGE_POINTS)
        incomes = self._edge(here, storages, (-3.0 * width, 3.0 * width), needed)
        edge = np.stack([incomes, storages], axis=-1)[np.isfinite(incomes)]
        if not len(edge):
            return
        step = edge[np.argmin(cost(here.place + edge))]
        for _ in range(_BACK):
            one = self.candidate(here.factors - step, start=here.variables)
            if one is not None:
                self._tuned(one, needed)
                return
            step = step / 2.0

    def _tuned(self, one: Candidate, needed: int) -> None:
        """Move a candidate onto the edge: income and storage alike."""
        for _ in range(_TUNINGS):
            step = least_step(self.counts(one, self.flights), _ALIKE, (-0.1, 0.1), needed)
            step = 0.1 if math.isnan(step) else step
            if one.days >= needed and step > -_TUNED:
                return
            other = self.candidate(one.factors - step * _ALIKE, start=one.variables)
            if other is None or np.allclose(other.place, one.place, atol=1e-6):
                return
            one = other

    def most_days(self, first: Candidate, needed: int) -> None:
        """Try the designs of most income and storage that there are, until enough days close."""
        for angle in _ANGLES:
            direction = np.array([math.cos(angle), math.sin(angle)])
            least, most, start = 0.0, _FURTHEST, first.variables
            while most - least > _NEXT_TO_FURTHEST:
                middle = (least + most) / 2.0
                steps = first.factors - middle * direction
                one = self.candidate(steps, Objective.max_excess_time, start)
                if one is None:
                    most = middle
                    continue
                least, start = middle, one.variables
                if one.days >= needed:
                    self._tuned(one, needed)
                    return
