"""Endurance: the longest flight over all launch times that starts full and ends empty.

One day of the year repeats; a flight is marched from its launch until the battery cannot meet the
load. A launch by surplus is never the best one: the battery stays full, so the same flight may
begin when the surplus begins. Launches are therefore tried while the load exceeds the sun. Flight
time jumps where one more night is just survived and is smooth elsewhere: a coarse search, refined
around the best launch, finds the longest flight to within seconds. One more launch is tried where
the day's surplus begins: with next to no battery that alone flies through the day.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from sizing.day.balance import (
    PowerBalance,
    blocks,
    deficit_phase_h,
    interval_reaching,
    positive_part_wh,
)
from sizing.day.battery import Store
from sizing.day.march import ChargingDay, hour_of_deficit
from solar.types import BoolArray, FloatArray, IntArray

HOURS_PER_DAY = 24.0
MAXIMUM_DAYS = 366
# The day of the launch and the next: from then on a flight has midnights like any other.
_DAYS_OF_LAUNCH = 2
_SHORT = 1e-12  # state of charge below zero that counts as an empty battery
# Flights as long as each other [h]: far above rounding, far below what the search resolves.
_EQUAL_H = 1e-6


@dataclass(frozen=True)
class Endurance:
    """Longest flight [h] and the solar time of its launch [h, 0 to 24]; arrays of the batch."""

    endurance_h: FloatArray
    launch_h: FloatArray


@dataclass(frozen=True)
class LimitedFlight:
    """Flights that start full and end with an empty battery, in solar time [h].

    ``launch_h``, ``endurance_h``: launch and length of the longest. ``before_sun_h``: from its end
    until solar power meets the load again; NaN where it never does. ``from_sunrise_h``,
    ``from_noon_h``: length of those launched at sunrise and at noon; NaN without a sunrise.
    """

    launch_h: float
    endurance_h: float
    before_sun_h: float
    from_sunrise_h: float
    from_noon_h: float

    @property
    def empty_h(self) -> float:
        """When the longest flight ends, counted from midnight before its launch."""
        return self.launch_h + self.endurance_h


def longest_flight(
    time_h: ArrayLike, solar_power_w: ArrayLike, load_w: ArrayLike, store: Store
) -> Endurance:
    """Longest flights of a batch that starts with full batteries.

    Parameters
    ----------
    time_h, solar_power_w, load_w, store
        One day as in :func:`sizing.day.cycle.simulate_cycle`, batch of one dimension or none.

    Returns
    -------
    Endurance
        Infinite where the flight outlasts 366 days, as a perpetual one does.
    """
    solar, load = np.asarray(solar_power_w, float), np.asarray(load_w, float)
    balance = PowerBalance.of(np.asarray(time_h, float), solar, load)
    shape = balance.batch_shape
    found = _LevelFlights.of(balance.flat(), store, shape).longest()
    return Endurance(found.endurance_h.reshape(shape), found.launch_h.reshape(shape))


def _best_of_day(hours: FloatArray) -> IntArray:
    """Try of the longest flight; of equal ones, the one with the most of them on both sides.

    Flights that begin and end in the dark are equally long over hours, as they end later by what
    they begin later. Rounding would choose among them, or the one just after a jump would be
    chosen, although a flight begun a minute earlier is a day shorter.
    """
    equal = hours >= hours.max(axis=0) - _EQUAL_H
    for _ in range(len(hours) // 2):
        inner = equal & np.roll(equal, 1, axis=0) & np.roll(equal, -1, axis=0)
        some = inner.any(axis=0)
        if not some.any():
            break
        equal = np.where(some, inner, equal)
    return np.asarray(np.argmax(equal, axis=0))


def _promising(hours: FloatArray, spacing_h: FloatArray, best: IntArray) -> BoolArray:
    """Tries around which the longest flight may be: the best, and those just after a jump.

    A flight begun earlier by a spacing is longer by a spacing at the most, unless it jumps.
    """
    finite = np.where(np.isinf(hours), 1e9, hours)
    after_jump = finite > np.roll(finite, 1, axis=0) + spacing_h
    marks = after_jump & (finite + spacing_h > finite.max(axis=0))
    marks &= ~np.isinf(hours)
    marks[best, np.arange(hours.shape[1])] = True
    return np.asarray(marks)


@dataclass(frozen=True)
class _Search:
    """Launches told by the hours of deficit between midnight and them, in some elements."""

    flights: Flights
    dark_h: FloatArray
    cells: IntArray

    def at(self, cells: IntArray) -> _Search:
        return replace(self, cells=cells)

    def launch_h(self, level_h: FloatArray) -> FloatArray:
        """Solar time at which the hours of deficit since midnight reach some levels [h]."""
        number = interval_reaching(self.dark_h, level_h, self.cells)
        interval = self.flights.balance.interval_of(number, self.cells)
        begin, length = deficit_phase_h(interval)
        along = np.clip(level_h - self.dark_h[number, self.cells], 0.0, length)
        return np.asarray(interval.start_h + begin + along)

    def hours(self, level_h: FloatArray) -> FloatArray:
        """Flight time from launches [h]."""
        # Launches of an element side by side: many of them become equal.
        launch = self.launch_h(level_h).T.reshape(-1)
        hours = self.flights.hours(self.cells.T.reshape(-1), launch)
        return hours.reshape(level_h.shape[::-1]).T

    def refined(self, level_h: FloatArray, hours: FloatArray, spacing_h: FloatArray) -> Endurance:
        """Longest flight around one launch in each element, known to within a spacing."""
        parts = self.flights.closer
        shares = np.concatenate([np.arange(1 - parts, 0), np.arange(1, parts)]) / parts
        cells = np.broadcast_to(self.cells, (len(shares), len(self.cells)))
        closer, every = self.at(cells), np.arange(len(self.cells))
        dark_h = np.maximum(self.dark_h[-1][self.cells], 1e-9)
        for _ in range(self.flights.refinements):
            tries_h = (level_h + shares[:, np.newaxis] * spacing_h) % dark_h
            tried = closer.hours(tries_h)
            pick = np.argmax(tried >= tried.max(axis=0) - _EQUAL_H, axis=0)
            better = tried[pick, every] > hours + _EQUAL_H
            hours = np.where(better, tried[pick, every], hours)
            level_h = np.where(better, tries_h[pick, every], level_h)
            spacing_h = spacing_h / parts
        return Endurance(hours, self.launch_h(level_h) % HOURS_PER_DAY)


def flight_time_h(balance: PowerBalance, store: Store, launch_h: FloatArray) -> FloatArray:
    """Flight time until the battery is empty, from launches with a full battery.

    Parameters
    ----------
    balance : PowerBalance
        One day of the batch ``...``, repeated.
    store : Store
        Batteries.
    launch_h : ndarray, shape (launch, ...)
        Solar time of the launches on the first day [h].

    Returns
    -------
    ndarray, shape (launch, ...)
        Hours of flight, infinite beyond 366 days [h].
    """
    shape = balance.batch_shape
    flights = _LevelFlights.of(balance.flat(), store, shape)
    cells = np.arange(flights.balance.net_w.shape[1]).reshape(shape)
    places = np.broadcast_to(cells, launch_h.shape).reshape(-1)
    return flights.hours(places, launch_h.reshape(-1)).reshape(launch_h.shape)


class Course(NamedTuple):
    """Flight from its launch: power [W], state of charge and altitude over solar time [h]."""

    clock_h: FloatArray
    solar_power_w: FloatArray
    load_w: FloatArray
    state_of_charge: FloatArray
    altitude_m: FloatArray


class Flying(NamedTuple):
    """Aircraft in flight at midnight, and what past days have shown of them.

    ``before_launch``: what of the first day lies before the launch, as the kind of flights counts
    it; 0 on all other days.
    """

    cell: IntArray
    energy_wh: FloatArray
    potential_wh: FloatArray
    before_launch: FloatArray
    loss_wh: FloatArray
    skipped_h: FloatArray

    @classmethod
    def of(cls, cell: IntArray, energy_wh: FloatArray, before_launch: FloatArray) -> Flying:
        """Aircraft at the midnight before their launch, without any height."""
        none = np.zeros(len(cell))
        return cls(cell, energy_wh, none, before_launch, np.full(len(cell), np.nan), none)

    def select(self, some: IntArray | BoolArray) -> Flying:
        """Some of them."""
        return Flying(
            self.cell[some],
            self.energy_wh[some],
            self.potential_wh[some],
            self.before_launch[some],
            self.loss_wh[some],
            self.skipped_h[some],
        )

    def without_duplicates(self) -> tuple[Flying, IntArray]:
        """One of each equal aircraft, and where each is found: what comes is the same for all."""
        order = np.lexsort((self.potential_wh, self.energy_wh, self.cell))
        new = np.ones(len(order), bool)
        new[1:] = False
        for values in (self.cell, self.energy_wh, self.potential_wh):
            sorted_values = values[order]
            new[1:] |= sorted_values[1:] != sorted_values[:-1]
        place = np.empty(len(order), np.intp)
        place[order] = np.cumsum(new) - 1
        return self.select(order[new]), place


class FlownDay(NamedTuple):
    """One more day: hour at which flights ended, NaN where none did, and what is stored [Wh].

    ``lowest_wh``: least energy of the battery over the day.
    """

    end_h: FloatArray
    midnight_wh: FloatArray
    potential_wh: FloatArray
    lowest_wh: FloatArray


@dataclass(frozen=True)
class Flights(ABC):
    """Flights of a batch of days and batteries, any number of launches for each.

    ``balance``: at the altitude of the launch. Of the coarse search's ``launches`` the best is
    refined ``refinements`` times, to a part of the distance of the tries that ``closer`` says.
    ``at_once``: flights marched together, so that their day stays near the processor.
    """

    balance: PowerBalance
    store: Store
    launches: ClassVar[int] = 60
    refinements: ClassVar[int] = 5
    closer: ClassVar[int] = 4
    at_once: ClassVar[int] = 16384

    @abstractmethod
    def launched(self, cells: IntArray, launch_h: FloatArray) -> Flying:
        """Aircraft on the first day, which are full at their launch [h]."""

    @abstractmethod
    def flown_day(self, flying: Flying) -> FlownDay:
        """One more day of theirs."""

    def longest(self) -> Endurance:
        """Longest flight of every element over all launches."""
        dark_h = self.balance.cumulative_deficit_h()
        cells = np.arange(dark_h.shape[1])
        spacing_h = dark_h[-1] / self.launches
        tries_h = np.arange(self.launches)[:, np.newaxis] * spacing_h
        search = _Search(self, dark_h, np.broadcast_to(cells, tries_h.shape))
        hours = search.hours(tries_h)
        middle = _best_of_day(hours)
        rank, cell = np.nonzero(_promising(hours, spacing_h, middle))
        best = search.at(cell).refined(tries_h[rank, cell], hours[rank, cell], spacing_h[cell])
        longest, launch_h = np.full((2, len(cells)), -np.inf)
        np.maximum.at(longest, cell, best.endurance_h)
        # The last of equal cells stays: one of its longest flights, from the best try if it is one.
        order = np.lexsort((rank == middle[cell], best.endurance_h >= longest[cell] - _EQUAL_H))
        longest[cell[order]], launch_h[cell[order]] = best.endurance_h[order], best.launch_h[order]
        # The level of the surplus is where it ends; a moment less of deficit is where it begins.
        sunniest = dark_h[np.argmax(self.balance.net_w, axis=0), cells]
        level_h = np.maximum(np.nextafter(sunniest, -np.inf), 0.0)
        at_surplus = search.at(cells)
        flown_h = at_surplus.hours(level_h)
        longer = flown_h > longest + _EQUAL_H
        launch_h = np.where(longer, at_surplus.launch_h(level_h), launch_h)
        return Endurance(np.where(longer, flown_h, longest), launch_h)

    def hours(self, cells: IntArray, launch_h: FloatArray) -> FloatArray:
        """Flight time [h] in some elements of the batch from launches with a full battery."""
        result = np.empty(len(cells))
        for part in blocks(len(cells), self.at_once):
            result[part] = self._hours(cells[part], launch_h[part])
        return result

    def _hours(self, cells: IntArray, launch_h: FloatArray) -> FloatArray:
        flown = np.full(len(cells), np.inf)
        battery = np.arange(len(cells))  # of every flight, -1 when it is over
        flying = self.launched(cells, launch_h)
        for number in range(MAXIMUM_DAYS + 1):
            if not len(flying.cell):
                break
            day = self.flown_day(flying)
            ended = ~np.isnan(day.end_h)
            end_h = number * HOURS_PER_DAY + flying.skipped_h + np.where(ended, day.end_h, 0.0)
            over = (battery >= 0) & ended[battery]
            flown[over] = end_h[battery[over]] - launch_h[over]
            goes_on = ~ended & ~self._perpetual(number, flying, day)
            place = np.where(goes_on, np.cumsum(goes_on) - 1, -1)
            flying = self._next_day(number, flying, day).select(goes_on)
            if number < _DAYS_OF_LAUNCH:
                flying, duplicate = flying.without_duplicates()
                place[goes_on] = duplicate
            battery = np.where(battery >= 0, place[battery], -1)
        return np.where(flown > MAXIMUM_DAYS * HOURS_PER_DAY, np.inf, flown)

    def deficit_until_wh(
        self, cumulative_wh: FloatArray, clock_h: FloatArray, cells: IntArray
    ) -> FloatArray:
        """Deficit from midnight to an instant of the day [Wh].

        ``cumulative_wh``: that until every node of the day.
        """
        time = self.balance.time_h
        number = np.clip(np.searchsorted(time, clock_h, side="right") - 1, 0, len(time) - 2)
        interval = self.balance.interval_of(number, cells)
        elapsed = np.minimum(clock_h - interval.start_h, interval.hours)
        here = interval.left_w + (interval.right_w - interval.left_w) * elapsed / interval.hours
        return np.asarray(
            cumulative_wh[number, cells] + positive_part_wh(-interval.left_w, -here, elapsed)
        )

    def _perpetual(self, number: int, flying: Flying, day: FlownDay) -> BoolArray:
        """From the second day on, a day that gives back what it takes is perpetual flight."""
        least_wh = 1e-11 * self.store.battery_energy_wh[flying.cell]
        perpetual = flying.energy_wh - day.midnight_wh <= least_wh
        perpetual &= flying.potential_wh - day.potential_wh <= least_wh
        return perpetual & (number >= _DAYS_OF_LAUNCH)

    def _next_day(self, number: int, flying: Flying, day: FlownDay) -> Flying:
        """Flights at the next midnight; whole days that lose the same energy are skipped."""
        full = self.store.battery_energy_wh[flying.cell]
        loss = flying.energy_wh - day.midnight_wh
        alike = (np.abs(loss - flying.loss_wh) <= 1e-9 * full) & (loss > 1e-9 * full)
        alike &= flying.potential_wh == day.potential_wh
        days = np.floor(day.lowest_wh / np.where(alike, loss, 1.0)) - 1.0
        days = np.where(alike, np.clip(days, 0.0, MAXIMUM_DAYS), 0.0)
        return flying._replace(
            energy_wh=day.midnight_wh - days * loss,
            potential_wh=day.potential_wh,
            before_launch=np.zeros(len(full)),
            # The days of the launch are no measure, whatever flights have become equal.
            loss_wh=loss if number >= _DAYS_OF_LAUNCH else np.full(len(loss), np.nan),
            skipped_h=flying.skipped_h + days * HOURS_PER_DAY,
        )


@dataclass(frozen=True)
class _LevelFlights(Flights):
    """Flights at a constant altitude; before the launch lies a deficit [Wh]."""

    day: ChargingDay
    deficit_at_nightfall_wh: FloatArray

    @classmethod
    def of(cls, balance: PowerBalance, store: Store, shape: tuple[int, ...]) -> _LevelFlights:
        day = ChargingDay.of(balance)
        at_nightfall = np.maximum.reduce(day.deficit_before_surplus_wh, axis=0, initial=-np.inf)
        return cls(balance, store.flat(shape), day, at_nightfall)

    def launched(self, cells: IntArray, launch_h: FloatArray) -> Flying:
        # The deficit before the launch takes nothing from a full battery.
        settled = self.deficit_until_wh(self.day.cumulative_deficit_wh, launch_h, cells)
        return Flying.of(cells, self.store.battery_energy_wh[cells], settled)

    def flown_day(self, flying: Flying) -> FlownDay:
        level = np.full(len(flying.cell), np.nan)
        energy, settled = flying.energy_wh.copy(), flying.before_launch.copy()
        lowest = energy.copy()
        # After the last surplus of the day nothing but the deficit is left.
        sunlit = np.flatnonzero(self.deficit_at_nightfall_wh[flying.cell] > settled)
        level[sunlit], energy[sunlit], settled[sunlit], lowest[sunlit] = self._lit_day(
            flying.select(sunlit)
        )
        store = self.store.select(flying.cell)
        cumulative_wh = self.day.cumulative_deficit_wh
        deficit = cumulative_wh[-1][flying.cell]
        midnight = energy - (deficit - settled) / store.discharge_efficiency
        last = (midnight < -_SHORT * store.battery_energy_wh) & np.isnan(level)
        level[last] = (deficit + store.discharge_efficiency * midnight)[last]
        midnight = np.maximum(midnight, 0.0)
        ended, end_h = ~np.isnan(level), np.full(len(level), np.nan)
        end_h[ended] = hour_of_deficit(
            self.balance, cumulative_wh, level[ended], flying.cell[ended]
        )
        lowest = np.maximum(np.minimum(lowest, midnight), 0.0)
        return FlownDay(end_h, midnight, np.zeros(len(level)), lowest)

    def _lit_day(self, flying: Flying) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Deficit at the end of flights, then energy, settled deficit and lowest energy [Wh]."""
        day, store = self.day.without_nodes().select(flying.cell), self.store.select(flying.cell)
        least = -_SHORT * store.battery_energy_wh
        level = np.full(len(flying.cell), np.nan)
        energy, settled, lowest = flying.energy_wh, flying.before_launch, flying.energy_wh
        for step in day.charge(store, energy, settled):
            energy, settled = step.after_charge_wh, step.settled_deficit_wh
            lowest = np.minimum(lowest, step.drained_wh)
            short = step.drained_wh < least
            if short.any():
                first = short & np.isnan(level)
                level[first] = (settled + store.discharge_efficiency * step.drained_wh)[first]
        return level, energy, settled, lowest
