"""Flights from launches with a full battery until it is empty, over days that repeat or follow.

Any number of flights of an element is flown on from midnight to midnight, all at once; those that
have become equal share the rest of their way.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from sizing.day.balance import Cells, blocks
from sizing.day.battery import Store
from sizing.day.march import ChargingDay
from solar.sun import HOURS_PER_DAY
from solar.types import BoolArray, FloatArray, IntArray

MAXIMUM_DAYS = 366
# The day of the launch and the next: from then on a flight has midnights like any other.
_DAYS_OF_LAUNCH = 2
_AT_ONCE = 16384  # flights marched together, so that their day stays near the processor


class Course(NamedTuple):
    """Flight from its launch: power [W], state of charge and altitude over solar time [h]."""

    clock_h: FloatArray
    solar_power_w: FloatArray
    load_w: FloatArray
    state_of_charge: FloatArray
    altitude_m: FloatArray


class Flying(NamedTuple):
    """Flights at a midnight: their number, day of the batch, and what past days have shown.

    ``settled_wh``: deficit before the launch, which takes nothing from a full battery.
    """

    flight: IntArray
    cell: IntArray
    energy_wh: FloatArray
    settled_wh: FloatArray
    loss_wh: FloatArray
    skipped_h: FloatArray

    def select(self, flights: IntArray | BoolArray) -> Flying:
        """Some of them."""
        return Flying._make(values[flights] for values in self)


class _Shared:
    """Flights that have become equal to another one, the leader, which they follow to its end."""

    def __init__(self, number_of_flights: int) -> None:
        self.leader, self.later_h = np.arange(number_of_flights), np.zeros(number_of_flights)
        self._seen = (np.empty(0, int), np.empty(0), np.empty(0, int), np.empty(0, int))

    def without_equals(self, number: int, flying: Flying, keep_seen: bool) -> Flying:
        """One of each that is equal from its ``number``-th midnight on, also to ones of before."""
        age = np.full(len(flying.cell), number)
        now = (flying.cell, flying.energy_wh, flying.flight, age)
        seen = tuple(np.concatenate(values) for values in zip(self._seen, now, strict=True))
        cell, energy_wh, flight, age = seen
        order = np.lexsort((energy_wh, cell))
        new = np.ones(len(order), bool)
        new[1:] = (np.diff(cell[order]) != 0) | (np.diff(energy_wh[order]) != 0.0)
        first = np.empty(len(order), np.intp)
        first[order] = order[np.maximum.accumulate(np.where(new, np.arange(len(order)), 0))]
        follows = np.flatnonzero(first != np.arange(len(order)))
        self.leader[flight[follows]] = flight[first[follows]]
        self.later_h[flight[follows]] = HOURS_PER_DAY * (age[follows] - age[first[follows]])
        if keep_seen:
            cell, energy_wh, flight, age = (np.delete(values, follows) for values in seen)
            self._seen = cell, energy_wh, flight, age
        start = len(order) - len(flying.cell)
        leads = first[start:] == np.arange(start, len(order))
        return flying.select(leads)

    def ends_h(self, ends_h: FloatArray) -> FloatArray:
        """Ends of all flights, from those that were flown to theirs [h]."""
        while np.any(self.leader[self.leader] != self.leader):
            self.later_h = self.later_h + self.later_h[self.leader]
            self.leader = self.leader[self.leader]
        return np.asarray(self.later_h + ends_h[self.leader])


@dataclass(frozen=True)
class Flights:
    """Flights of a batch of days and batteries, any number of launches for each.

    ``follow``: the elements are days that follow each other; by default each repeats itself.
    """

    day: ChargingDay
    store: Store
    follow: bool = False

    @classmethod
    def of(
        cls, time_h: ArrayLike, solar_power_w: ArrayLike, load_w: ArrayLike, store: Store
    ) -> Flights:
        """Flights over repeated days, the batch laid out flat; arguments as of a cycle."""
        cells, _ = Cells.of(time_h, solar_power_w, load_w, store, 0.0)
        return cls(ChargingDay.of(cells.balance), cells.store)

    def hours(self, cells: IntArray, launch_h: FloatArray) -> FloatArray:
        """Flight time of elements from launches with a full battery [h].

        ``cells``: element of each launch. ``launch_h``: hours after the start of its day [h].
        Infinite where the days end before it, or beyond 366 repeated days.
        """
        if self.follow:
            return self._hours(cells, launch_h)
        result = np.empty(len(cells))
        for part in blocks(len(cells), _AT_ONCE):
            result[part] = self._hours(cells[part], launch_h[part])
        return np.where(result > MAXIMUM_DAYS * HOURS_PER_DAY, np.inf, result)

    def _hours(self, cells: IntArray, launch_h: FloatArray) -> FloatArray:
        number_of_flights = len(cells)
        ends_h, shared = np.full(number_of_flights, np.inf), _Shared(number_of_flights)
        none = np.zeros(number_of_flights)
        flying = Flying(
            np.arange(number_of_flights),
            cells,
            np.asarray(self.store.battery_energy_wh[cells], float),
            self.day.deficit_until_wh(launch_h, cells),
            np.full(number_of_flights, np.nan),
            none,
        )
        for number in count(1) if self.follow else range(1, MAXIMUM_DAYS + 2):
            if not len(flying.cell):
                break
            end_h, after = self._day_number(number, flying)
            ended = ~np.isnan(end_h)
            days_h = (number - 1) * HOURS_PER_DAY + flying.skipped_h
            ends_h[flying.flight[ended]] = (days_h + end_h)[ended]
            flying = after
            if self.follow or number <= _DAYS_OF_LAUNCH:
                flying = shared.without_equals(number, flying, self.follow)
        return shared.ends_h(ends_h) - launch_h

    def _day_number(self, number: int, flying: Flying) -> tuple[FloatArray, Flying]:
        """Hour at which flights end on their ``number``-th day, NaN if not; those that go on."""
        cells, energy, settled = flying.cell, flying.energy_wh, flying.settled_wh
        level, midnight = np.full(len(cells), np.nan), energy.copy()
        lowest = energy.copy()
        # After the last surplus of the day nothing but the deficit is left.
        charges = self.day.nightfall_deficit_wh[cells] >= settled
        for rows in (np.flatnonzero(charges), np.flatnonzero(~charges)):
            of = cells[rows]
            begin = (self.store.select(of), energy[rows], settled[rows])
            level[rows], midnight[rows], lowest[rows] = self.day.select(of).flight(*begin)
        ended, end_h = ~np.isnan(level), np.full(len(level), np.nan)
        end_h[ended] = self.day.hour_of_deficit(level[ended], cells[ended])
        loss, full = energy - midnight, self.store.battery_energy_wh
        after = flying._replace(energy_wh=midnight, settled_wh=np.zeros(len(cells)))
        if self.follow:
            goes_on = ~ended & (cells + 1 < len(full))
            following = np.minimum(cells + 1, len(full) - 1)
            # A battery that is colder the next day keeps its state of charge, not its energy.
            after = after._replace(
                cell=following, energy_wh=midnight * (full[following] / full[cells])
            )
            return end_h, after.select(goes_on)
        if number <= _DAYS_OF_LAUNCH:  # no measure, whatever flights have become equal
            return end_h, after.select(~ended)
        # A day that gives back what it takes is perpetual flight.
        goes_on = ~ended & (loss > 1e-11 * full[cells])
        alike = np.abs(loss - flying.loss_wh) <= 1e-9 * full[cells]
        alike &= loss > 1e-9 * full[cells]
        # Whole days that lose the same energy are skipped.
        days = np.floor(lowest / np.where(alike, loss, 1.0)) - 1.0
        days = np.where(alike, np.clip(days, 0.0, MAXIMUM_DAYS), 0.0)
        skipped_h = flying.skipped_h + days * HOURS_PER_DAY
        after = after._replace(energy_wh=midnight - days * loss, loss_wh=loss, skipped_h=skipped_h)
        return end_h, after.select(goes_on)
