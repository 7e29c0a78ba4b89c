"""Search for the best design that closes a share of a season's days.

The constraint "so many days of the record close" is a staircase that no gradient sees. Simulated
batches of designs with other income and storage find its edge. On the other side, the program's
designs for one repeated day with any factors are the best ones of all places on that plane. The
search walks along the edge to where the program's objective is best, and has every design that
counts flown through the record.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.design import Design
from sizing.margins.search import Count, MarginSearch, Trial, fitted, least_income, least_step
from sizing.margins.season_flights import Powers, SeasonFlights
from sizing.optimisation.objectives import Objective
from sizing.optimisation.problem import SizingProblems
from sizing.sunlight import SolarModel, solar_day
from solar.types import FloatArray, IntArray

# The program's day: one with a night of about twelve hours at any site. Which one does not matter,
# as factors on income and storage are free. Where a place is held, it has the season's strongest
# wind.
_EQUINOX, _HIGHEST_LATITUDE_DEG = 80, 45.0
_DAY_STEP_H = 0.5
# Logarithms of factors on income and storage.
_FIRST = ((0.0, 0.0), (0.7, 0.4), (1.5, 0.8))  # any design at all, with more and more light
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


class SeasonSearch(MarginSearch):
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
        steps: Steps,
    ) -> None:
        latitude = mission.latitudes()[0]
        latitude = min(max(latitude, -_HIGHEST_LATITUDE_DEG), _HIGHEST_LATITUDE_DEG)
        where = Scenarios(np.array([latitude]), np.array([_EQUINOX]))
        day = solar_day(aircraft, mission, solar, scenarios=where, step_h=_DAY_STEP_H)
        winds = flights.days.wind_m_per_s
        if winds is not None:
            season = flights.kept[flights.counted]
            strongest = flights.days.axis.day_of_year[season[[np.argmax(winds[season])]]]
            day = replace(day, scenarios=Scenarios(np.array(mission.latitudes()[:1]), strongest))
        super().__init__(aircraft, mission, objective, solar, day, problems)
        self.flights, self.coarse, self.steps = flights, coarse, steps

    def reached(self, design: Design) -> float:
        """Days of the season that close."""
        return int(self.flights.that_close(Powers.of(design, self.flights.days))[0])

    def _cost(self, one: Trial) -> float:
        """Logarithm of what is to be small, or the negative of what is to be large."""
        return -one.merit if self.objective.maximised else math.log(-one.merit)

    # --- along the edge ----------------------------------------------------------------------

    def best(self, needed: int) -> Trial | None:
        """Best design with enough days that close; None where none is found."""
        with self.steps.of(1 + len(_WIDTHS)):
            return self._cheapest(needed)

    def _cheapest(self, needed: int) -> Trial | None:
        tries = (self.trial(factors) for factors in _FIRST)
        first = next((one for one in tries if one is not None), None)
        if first is None:
            return None
        self._along_the_edge(first, needed)
        if self.best_of_tried(needed) is None:
            self.most_days(first, needed)
        here = self.best_of_tried(needed)
        if here is None:
            return None
        for width in _WIDTHS:
            self.steps.next()
            for _ in range(_REPEATS):
                before = here
                self._improve(before, needed, width)
                here = self.best_of_tried(needed) or before
                if self._cost(before) - self._cost(here) < _GAIN * max(abs(self._cost(here)), 1.0):
                    break
        return here

    def counts(self, one: Trial, flights: SeasonFlights | None = None) -> Count:
        """Days that close with other income and storage than a trial's.

        ``flights``: by default those on coarse nodes, less what these find otherwise of the
        trial itself. Returns days, of logarithms of factors on income and storage.
        """
        flown = self.coarse if flights is None else flights
        own = Powers.of(one.design, flown.days)

        def count(income: FloatArray, storage: FloatArray) -> IntArray:
            return flown.that_close(own.scaled(np.exp(income), np.exp(storage)))

        if flights is not None:
            return count
        otherwise = int(count(np.zeros(1), np.zeros(1))[0]) - int(one.reached)
        return lambda income, storage: count(income, storage) - otherwise

    def _edge(
        self, here: Trial, storages: FloatArray, ends: tuple[float, float], needed: int
    ) -> FloatArray:
        """Least incomes beside a trial's storages, logarithms of its own."""
        values = len(storages) * self.coarse.specific_w_per_m2.size
        at_once = min(max(_VALUES_AT_ONCE // values, 1), 7)
        return least_income(self.counts(here), storages, ends, needed, at_once=at_once)

    def _along_the_edge(self, first: Trial, needed: int) -> None:
        """Try places all along the edge of what closes enough days."""
        incomes = self._edge(first, _STORAGES, _INCOMES, needed)
        start = first.variables
        for step in np.stack([incomes, _STORAGES], axis=-1)[np.isfinite(incomes)]:
            one = self.trial(first.factors - step, start=start)
            if one is not None:
                self._tuned(one, needed)

    def _improve(self, here: Trial, needed: int, width: float) -> None:
        """Go to the best place along a stretch of the edge."""
        for step in min(width / 2.0, _SLOPE_STEP) * np.eye(2):
            self.trial(here.factors + step, start=here.variables)
        near = [
            one
            for one in self.found
            if np.all(np.abs(self._on_plane(one) - self._on_plane(here)) < 1.0)
        ]
        cost = fitted(
            np.array([self._on_plane(one) for one in near]),
            np.array([self._cost(one) for one in near]),
            next(i for i, one in enumerate(near) if one is here),
        )
        storages = np.linspace(-width, width, _EDGE_POINTS)
        incomes = self._edge(here, storages, (-3.0 * width, 3.0 * width), needed)
        edge = np.stack([incomes, storages], axis=-1)[np.isfinite(incomes)]
        if not len(edge):
            return
        step = edge[np.argmin(cost(self._on_plane(here) + edge))]
        for _ in range(_BACK):
            one = self.trial(here.factors - step, start=here.variables)
            if one is not None:
                self._tuned(one, needed)
                return
            step = step / 2.0

    def _tuned(self, one: Trial, needed: int) -> None:
        """Move a trial onto the edge: income and storage alike."""
        for _ in range(_TUNINGS):
            step = least_step(self.counts(one, self.flights), (-0.1, 0.1), needed)
            step = 0.1 if math.isnan(step) else step
            if one.reached >= needed and step > -_TUNED:
                return
            other = self.trial(one.factors - step, start=one.variables)
            if other is None or np.allclose(self._on_plane(other), self._on_plane(one), atol=1e-6):
                return
            one = other

    def most_days(self, first: Trial, needed: int) -> None:
        """Try the designs of most income and storage that there are, until enough days close."""
        for angle in _ANGLES:
            direction = np.array([math.cos(angle), math.sin(angle)])
            least, most, start = 0.0, _FURTHEST, first.variables
            while most - least > _NEXT_TO_FURTHEST:
                middle = (least + most) / 2.0
                steps = first.factors - middle * direction
                one = self.trial(steps, Objective.max_excess_time, start)
                if one is None:
                    most = middle
                    continue
                least, start = middle, one.variables
                if one.reached >= needed:
                    self._tuned(one, needed)
                    return

    def _on_plane(self, one: Trial) -> FloatArray:
        """Logarithms of a design's income and storage, shape ``(2,)``."""
        return np.asarray(Powers.of(one.design, self.flights.days).place[:, 0])
