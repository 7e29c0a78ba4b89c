"""Endurance: the longest flight over all launch times that starts full and ends empty.

One day of the year repeats. A launch by surplus is never the best one: the battery stays full, so
the same flight may begin when the surplus begins. Launches are therefore tried while the load
exceeds the sun. Flight time jumps where one more night is just survived and is smooth elsewhere: a
coarse search, refined around the best launch, finds the longest flight to within seconds. One more
launch is tried where the day's surplus begins: with next to no battery that alone flies through the
day.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from sizing.day.balance import interval_reaching
from sizing.day.battery import Store
from sizing.day.flight import Launches
from solar.sun import HOURS_PER_DAY
from solar.types import FloatArray, IntArray

# Of the coarse search's launches the best is refined so often, to such a part of their distance.
_LAUNCHES, _REFINEMENTS, _CLOSER = 60, 5, 4
# Flights as long as each other [h]: far above rounding, far below what the search resolves.
_EQUAL_H = 1e-6


@dataclass(frozen=True)
class Endurance:
    """Longest flight [h] and the solar time of its launch [h, 0 to 24]; arrays of the batch."""

    endurance_h: FloatArray
    launch_h: FloatArray


def longest_flight(
    time_h: ArrayLike, solar_power_w: ArrayLike, load_w: ArrayLike, store: Store
) -> Endurance:
    """Find the longest flights of a batch that starts with full batteries.

    Parameters
    ----------
    time_h, solar_power_w, load_w, store
        One day as in :func:`sizing.day.cycle.simulate_cycle`.

    Returns
    -------
    Endurance
        Infinite where the flight outlasts 366 days, as a perpetual one does.
    """
    flights = Launches.of(time_h, solar_power_w, load_w, store)
    hours, launch_h = _Search(flights, flights.day.balance.cumulative_deficit_h()).longest()
    shape = np.broadcast_shapes(np.shape(solar_power_w), np.shape(load_w))[:-1]
    return Endurance(hours.reshape(shape), launch_h.reshape(shape))


@dataclass(frozen=True)
class _Search:
    """Launches by the hours of deficit between midnight and them, at the nodes ``dark_h`` [h]."""

    flights: Launches
    dark_h: FloatArray

    def launch_h(self, level_h: FloatArray, cells: IntArray) -> FloatArray:
        """Return the solar time at which the hours of deficit since midnight reach levels [h]."""
        number = interval_reaching(self.dark_h, level_h, cells)
        interval = self.flights.day.balance.interval(number, cells)
        begin, length = interval.deficit_h()
        along = np.clip(level_h - self.dark_h[number, cells], 0.0, length)
        return np.asarray(interval.start_h + begin + along)

    def hours(self, level_h: FloatArray, cells: IntArray) -> FloatArray:
        """Return the flight time from launches [h]."""
        # Launches of an element side by side: many of them become equal.
        cells = np.broadcast_to(cells, level_h.shape)
        launch = self.launch_h(level_h, cells).T.reshape(-1)
        hours = self.flights.hours(cells.T.reshape(-1), launch)
        return hours.reshape(level_h.shape[::-1]).T

    def longest(self) -> tuple[FloatArray, FloatArray]:
        """Return the longest flight of every element over all launches, and its launch [h]."""
        cells = np.arange(self.dark_h.shape[1])
        spacing_h = self.dark_h[-1] / _LAUNCHES
        tries_h = np.arange(_LAUNCHES)[:, np.newaxis] * spacing_h
        hours = self.hours(tries_h, cells)
        middle = _best_of_day(hours)
        # A flight begun earlier by a spacing is longer by a spacing at the most, unless it jumps:
        # the longest may be around the best try, and around those just after a jump.
        finite = np.where(np.isinf(hours), 1e9, hours)
        promising = finite > np.roll(finite, 1, axis=0) + spacing_h
        promising &= (finite + spacing_h > finite.max(axis=0)) & ~np.isinf(hours)
        promising[middle, cells] = True
        rank, cell = np.nonzero(promising)
        best_h, best_launch_h = self.refined(
            cell, tries_h[rank, cell], hours[rank, cell], spacing_h[cell]
        )
        longest, launch_h = np.full((2, len(cells)), -np.inf)
        np.maximum.at(longest, cell, best_h)
        # The last of equal cells stays: one of its longest flights, from the best try if it is one.
        order = np.lexsort((rank == middle[cell], best_h >= longest[cell] - _EQUAL_H))
        longest[cell[order]], launch_h[cell[order]] = best_h[order], best_launch_h[order]
        # The level of the surplus is where it ends; a moment less of deficit is where it begins.
        net_w = self.flights.day.balance.net_w
        sunniest = self.dark_h[np.argmax(net_w, axis=0), cells]
        level_h = np.maximum(np.nextafter(sunniest, -np.inf), 0.0)
        hours = self.hours(level_h, cells)
        longer = hours > longest + _EQUAL_H
        launch_h = np.where(longer, self.launch_h(level_h, cells), launch_h)
        return np.where(longer, hours, longest), launch_h

    def refined(
        self, cells: IntArray, level_h: FloatArray, hours: FloatArray, spacing_h: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the longest flight around one launch of each element, and its launch [h]."""
        shares = np.concatenate([np.arange(1 - _CLOSER, 0), np.arange(1, _CLOSER)]) / _CLOSER
        dark_h, every = np.maximum(self.dark_h[-1][cells], 1e-9), np.arange(len(cells))
        for _ in range(_REFINEMENTS):
            tries_h = (level_h + shares[:, np.newaxis] * spacing_h) % dark_h
            tried = self.hours(tries_h, cells)
            pick = np.argmax(tried >= tried.max(axis=0) - _EQUAL_H, axis=0)
            better = tried[pick, every] > hours + _EQUAL_H
            hours = np.where(better, tried[pick, every], hours)
            level_h = np.where(better, tries_h[pick, every], level_h)
            spacing_h = spacing_h / _CLOSER
        return hours, self.launch_h(level_h, cells) % HOURS_PER_DAY


def _best_of_day(hours: FloatArray) -> IntArray:
    """Return the try of the longest flight; of equal ones, that amid the most of them.

    Flights that begin and end in the dark are equally long over hours, as they end later by what
    they begin later. Rounding would choose among them, or the one just after a jump would be
    chosen, although a flight begun a minute earlier is a day shorter.
    """
    equal = hours >= hours.max(axis=0) - _EQUAL_H
    for _ in range(len(hours) // 2):
        inner = equal & np.roll(equal, 1, axis=0) & np.roll(equal, -1, axis=0)
        has_inner = inner.any(axis=0)
        if not has_inner.any():
            break
        equal = np.where(has_inner, inner, equal)
    return np.asarray(np.argmax(equal, axis=0))
