"""Flights from launches with a full battery until it is empty, over a day that repeats itself.

All flights are marched from midnight to midnight as one batch, until each is empty or a day gives
back what it takes.

The longest flight is that of the best launch. A launch by surplus is never the best one: the
battery stays full, so the same flight may begin when the surplus begins. Launches are therefore
tried while the load exceeds the sun. Flight time jumps where one more night is just survived and is
smooth elsewhere: a coarse search, refined around the best launch, finds the longest flight to
within seconds. One more launch is tried where the day's surplus begins: with next to no battery
that alone flies through the day.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import ceil
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from sizing.day.balance import Cells, PowerBalance, blocks, interval_reaching
from sizing.day.battery import Store
from sizing.day.march import ChargingDay
from solar.sun import HOURS_PER_DAY
from solar.types import FloatArray, IntArray

MAXIMUM_DAYS = 366
_DAYS_THAT_FILL = 3  # flights whose battery is full on one of the first days become equal
_AT_ONCE = 16384  # flights marched together, so that their day stays near the processor
_PERPETUAL, _ALIKE = 1e-11, 1e-9  # of the battery: loss of a day, and difference of two losses
# Of the coarse search's launches the best is refined so often, to such a part of their distance.
_LAUNCHES, _REFINEMENTS, _CLOSER = 60, 5, 4
# Flights as long as each other [h]: far above rounding, far below what the search resolves.
_EQUAL_H = 1e-6


@dataclass(frozen=True)
class Endurance:
    """Longest flight [h] and the solar time of its launch [h, 0 to 24]; arrays of the batch."""

    endurance_h: FloatArray
    launch_h: FloatArray


class Course(NamedTuple):
    """Flight from its launch: power [W], state of charge and altitude over solar time [h]."""

    clock_h: FloatArray
    solar_power_w: FloatArray
    load_w: FloatArray
    state_of_charge: FloatArray
    altitude_m: FloatArray


@dataclass(frozen=True)
class Launches:
    """Flights of a batch of repeated days and batteries, any number of launches for each."""

    batch: Cells
    altitude_m: float = 0.0

    @classmethod
    def of(
        cls,
        time_h: ArrayLike,
        solar_power_w: ArrayLike,
        load_w: ArrayLike,
        store: Store,
        *,
        altitude_m: float = 0.0,
    ) -> Launches:
        """Return flights at an altitude, the batch laid out flat; arguments as of a cycle."""
        return cls(Cells.of(time_h, solar_power_w, load_w, store, 0.0)[0], altitude_m)

    @property
    def store(self) -> Store:
        """Return the batteries."""
        return self.batch.store

    @cached_property
    def day(self) -> ChargingDay:
        """Return the day of every element."""
        return ChargingDay.of(self.batch.balance)

    def hours(self, cells: IntArray, launch_h: FloatArray) -> FloatArray:
        """Return the flight time of elements from launches with a full battery [h].

        ``cells``: element of each launch. ``launch_h``: hours after the start of its day [h].
        Infinite beyond 366 days.
        """
        result = np.empty(len(cells))
        for part in blocks(len(cells), _AT_ONCE):
            result[part] = self._hours(cells[part], launch_h[part])
        return np.where(result > MAXIMUM_DAYS * HOURS_PER_DAY, np.inf, result)

    def _hours(self, cells: IntArray, launch_h: FloatArray) -> FloatArray:
        """March flights from midnight to midnight until each is empty, or loses nothing."""
        full_wh = np.asarray(self.store.battery_energy_wh[cells], float)
        flights, end_h = np.arange(len(cells)), np.full(len(cells), np.inf)
        like, settled_wh = flights.copy(), self.day.deficit_until_wh(launch_h, cells)
        # Stored energy, loss of the day before, and days that are over.
        state = np.stack([full_wh, np.full(len(cells), np.nan), np.zeros(len(cells))])
        for number in range(MAXIMUM_DAYS + 1):
            if not len(flights):
                break
            if 0 < number < _DAYS_THAT_FILL:
                keys = cells[flights] + 1j * state[0]
                _, first, same = np.unique(keys, return_index=True, return_inverse=True)
                like[flights] = flights[first[same]]
                flights, state = flights[first], state[:, first]
            full, (energy_wh, lost_wh, days) = full_wh[flights], state
            settled = np.zeros(len(flights)) if number else settled_wh
            begin = self.store, energy_wh, settled
            empty_h, midnight_wh, lowest_wh = self.day.flights(cells[flights], *begin)
            empty = ~np.isnan(empty_h)
            end_h[flights[empty]] = (HOURS_PER_DAY * days + empty_h)[empty]
            # A day that gives back what it takes is perpetual flight; that of the launch is none.
            loss_wh = energy_wh - midnight_wh
            goes_on = ~empty & ((number == 0) | (loss_wh > _PERPETUAL * full))
            # Whole days that lose the same energy are skipped.
            alike = goes_on & (loss_wh > _ALIKE * full)
            alike &= np.abs(loss_wh - lost_wh) <= _ALIKE * full
            skipped = np.floor(lowest_wh / np.where(alike, loss_wh, 1.0)) - 1.0
            skipped = np.where(alike, np.clip(skipped, 0.0, MAXIMUM_DAYS), 0.0)
            known_wh = loss_wh if number else lost_wh  # the day of the launch says nothing
            after = midnight_wh - skipped * loss_wh, known_wh, days + 1.0 + skipped
            flights, state = flights[goes_on], np.stack(after)[:, goes_on]
        return np.asarray(end_h[like[like]] - launch_h)

    def course(self, i: int, launch_h: float, hours: float) -> Course:
        """Return the flight of an element, launched with a full battery."""
        end_h, batch = launch_h + hours, self.batch.select(slice(i, i + 1))
        days = [batch.time_h + HOURS_PER_DAY * day for day in range(ceil(end_h / HOURS_PER_DAY))]
        clock_h = np.unique(np.concatenate([[launch_h, end_h], *days]))
        clock_h = clock_h[(clock_h >= launch_h) & (clock_h <= end_h)]
        solar, load = (
            np.interp(clock_h % HOURS_PER_DAY, batch.time_h, power_w[:, 0])
            for power_w in (batch.solar_w, batch.load_w)
        )
        full_wh = np.asarray(batch.store.battery_energy_wh, float)
        day = ChargingDay.of(PowerBalance.of(clock_h, (solar - load)[:, np.newaxis]))
        charge = day.run(batch.store, full_wh).energy_at_nodes_wh()[:, 0] / full_wh
        charge[np.logical_or.accumulate(charge <= 0.0)] = 0.0  # landed
        return Course(clock_h, solar, load, charge, np.full_like(clock_h, self.altitude_m))

    @cached_property
    def dark_h(self) -> FloatArray:
        """Return the hours of deficit between midnight and every node, by which launches go [h]."""
        return self.day.balance.cumulative_deficit_h()

    def longest(self) -> Endurance:
        """Return the longest flight of every element over all launches."""
        cells = np.arange(self.dark_h.shape[1])
        spacing_h = self.dark_h[-1] / _LAUNCHES
        tries_h = np.arange(_LAUNCHES)[:, np.newaxis] * spacing_h
        hours = self._hours_from(tries_h, cells)
        middle = _best_of_day(hours)
        # A flight begun earlier by a spacing is longer by a spacing at the most, unless it jumps:
        # the longest may be around the best try, and around those just after a jump.
        finite = np.where(np.isinf(hours), 1e9, hours)
        promising = finite > np.roll(finite, 1, axis=0) + spacing_h
        promising &= (finite + spacing_h > finite.max(axis=0)) & ~np.isinf(hours)
        promising[middle, cells] = True
        rank, cell = np.nonzero(promising)
        best_h, best_launch_h = self._refined(
            cell, tries_h[rank, cell], hours[rank, cell], spacing_h[cell]
        )
        longest, launch_h = np.full((2, len(cells)), -np.inf)
        np.maximum.at(longest, cell, best_h)
        # The last of equal cells stays: one of its longest flights, from the best try if it is one.
        order = np.lexsort((rank == middle[cell], best_h >= longest[cell] - _EQUAL_H))
        longest[cell[order]], launch_h[cell[order]] = best_h[order], best_launch_h[order]
        # The level of the surplus is where it ends; a moment less of deficit is where it begins.
        net_w = self.day.balance.net_w
        sunniest = self.dark_h[np.argmax(net_w, axis=0), cells]
        level_h = np.maximum(np.nextafter(sunniest, -np.inf), 0.0)
        hours = self._hours_from(level_h, cells)
        longer = hours > longest + _EQUAL_H
        launch_h = np.where(longer, self._launch_h(level_h, cells), launch_h)
        return Endurance(np.where(longer, hours, longest), launch_h)

    def _launch_h(self, level_h: FloatArray, cells: IntArray) -> FloatArray:
        """Return the solar time at which the hours of deficit since midnight reach levels [h]."""
        number = interval_reaching(self.dark_h, level_h, cells)
        interval = self.day.balance.interval(number, cells)
        begin, length = interval.deficit_h()
        along = np.clip(level_h - self.dark_h[number, cells], 0.0, length)
        return np.asarray(interval.start_h + begin + along)

    def _hours_from(self, level_h: FloatArray, cells: IntArray) -> FloatArray:
        """Return the flight time from launches [h]."""
        # Launches of an element side by side: many of them become equal.
        cells = np.broadcast_to(cells, level_h.shape)
        launch = self._launch_h(level_h, cells).T.reshape(-1)
        hours = self.hours(cells.T.reshape(-1), launch)
        return hours.reshape(level_h.shape[::-1]).T

    def _refined(
        self, cells: IntArray, level_h: FloatArray, hours: FloatArray, spacing_h: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the longest flight around one launch of each element, and its launch [h]."""
        shares = np.concatenate([np.arange(1 - _CLOSER, 0), np.arange(1, _CLOSER)]) / _CLOSER
        dark_h, every = np.maximum(self.dark_h[-1][cells], 1e-9), np.arange(len(cells))
        for _ in range(_REFINEMENTS):
            tries_h = (level_h + shares[:, np.newaxis] * spacing_h) % dark_h
            tried = self._hours_from(tries_h, cells)
            pick = np.argmax(tried >= tried.max(axis=0) - _EQUAL_H, axis=0)
            better = tried[pick, every] > hours + _EQUAL_H
            hours = np.where(better, tried[pick, every], hours)
            level_h = np.where(better, tries_h[pick, every], level_h)
            spacing_h = spacing_h / _CLOSER
        return hours, self._launch_h(level_h, cells) % HOURS_PER_DAY


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
    longest = Launches.of(time_h, solar_power_w, load_w, store).longest()
    shape = np.broadcast_shapes(np.shape(solar_power_w), np.shape(load_w))[:-1]
    return Endurance(longest.endurance_h.reshape(shape), longest.launch_h.reshape(shape))
