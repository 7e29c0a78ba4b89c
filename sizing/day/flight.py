"""Flights from launches with a full battery until it is empty, over days that repeat or follow.

All flights are marched from midnight to midnight as one batch. The charge at midnight decides the
rest of a flight, so that flights of equal charge are marched once: midnights are nodes of a graph,
each with the hours to the next one or to the end.
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
_DAYS_OF_LAUNCH = 2  # and the next: from then on a flight has midnights like any other
_AT_ONCE = 16384  # flights marched together, so that their day stays near the processor
_PERPETUAL, _ALIKE = 1e-11, 1e-9  # of the battery: loss of a day, and difference of two losses


class Midnights(NamedTuple):
    """Flights at the start of a day: element of the batch, stored energy and what it has met [Wh].

    ``settled_wh``: deficit before the launch, which takes nothing from a full battery. ``loss_wh``:
    energy lost on the day before; NaN where it says nothing of the days to come.
    """

    cell: IntArray
    energy_wh: FloatArray
    settled_wh: FloatArray
    loss_wh: FloatArray

    def select(self, flights: IntArray | BoolArray) -> Midnights:
        """Return the midnights of a part of the flights."""
        return Midnights._make(values[flights] for values in self)


@dataclass(frozen=True)
class Launches:
    """Flights of a batch of days and batteries, any number of launches for each.

    ``follow``: the elements are days that follow each other; by default each repeats itself.
    """

    day: ChargingDay
    store: Store
    follow: bool = False

    @classmethod
    def of(
        cls, time_h: ArrayLike, solar_power_w: ArrayLike, load_w: ArrayLike, store: Store
    ) -> Launches:
        """Return flights over repeated days, the batch laid out flat; arguments as of a cycle."""
        cells, _ = Cells.of(time_h, solar_power_w, load_w, store, 0.0)
        return cls(ChargingDay.of(cells.balance), cells.store)

    def hours(self, cells: IntArray, launch_h: FloatArray) -> FloatArray:
        """Return the flight time of elements from launches with a full battery [h].

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
        full_wh = np.asarray(self.store.battery_energy_wh[cells], float)
        settled_wh = self.day.deficit_until_wh(launch_h, cells)
        now = Midnights(cells, full_wh, settled_wh, np.full(len(cells), np.nan))
        # Of every node: hours to the next one, and its number. Node 0 is the end of a flight.
        ahead_h, following, nodes = [np.zeros(1)], [np.zeros(1, np.intp)], 1 + len(cells)
        known, node_of = np.empty(0, complex), np.empty(0, np.intp)
        for number in count(1) if self.follow else range(1, MAXIMUM_DAYS + 2):
            if not len(now.cell):
                break
            hours, after, goes_on = self._march_day(number, now)
            after, next_node = after.select(goes_on), np.zeros(len(hours), np.intp)
            new = np.arange(len(after.cell))
            reached = nodes + new
            if self.follow or number <= _DAYS_OF_LAUNCH:
                # Day and energy as one number, of which the first of equals is marched.
                keys = np.append(known, after.cell + 1j * after.energy_wh)
                _, first, equal = np.unique(keys, return_index=True, return_inverse=True)
                new = np.sort(first[first >= len(known)]) - len(known)
                node_of = np.append(node_of, np.zeros(len(reached), np.intp))
                node_of[len(known) + new] = nodes + np.arange(len(new))
                reached = node_of[first][equal][len(known) :]
                kept = first if self.follow else first[:0]
                known, node_of = keys[kept], node_of[kept]
            next_node[goes_on] = reached
            ahead_h.append(hours)
            following.append(next_node)
            now, nodes = after.select(new), nodes + len(new)
        # Those that are left fly on.
        hours = np.concatenate([*ahead_h, np.full(len(now.cell), np.inf)])
        link = np.concatenate([*following, np.zeros(len(now.cell), np.intp)])
        while link.any():
            hours, link = hours + hours[link], link[link]
        return np.asarray(hours[1 : len(cells) + 1] - launch_h)

    def _march_day(self, number: int, now: Midnights) -> tuple[FloatArray, Midnights, BoolArray]:
        """March flights through their ``number``-th day.

        Returns hours until they end or are marched again, infinite where neither happens; their
        next midnight; and whether they go on from there.
        """
        cells, energy, settled = now.cell, now.energy_wh, now.settled_wh
        level, midnight = np.full(len(cells), np.nan), energy.copy()
        lowest = energy.copy()
        # After the last surplus of the day nothing but the deficit is left.
        charges = self.day.nightfall_deficit_wh[cells] >= settled
        for rows in (np.flatnonzero(charges), np.flatnonzero(~charges)):
            of = cells[rows]
            begin = (self.store.select(of), energy[rows], settled[rows])
            level[rows], midnight[rows], lowest[rows] = self.day.select(of).flight(*begin)
        ended, hours = ~np.isnan(level), np.full(len(level), HOURS_PER_DAY)
        hours[ended] = self.day.hour_of_deficit(level[ended], cells[ended])
        loss, full = energy - midnight, self.store.battery_energy_wh
        after = Midnights(cells, midnight, np.zeros(len(cells)), np.full(len(cells), np.nan))
        if self.follow:
            goes_on = ~ended & (cells + 1 < len(full))
            following = np.minimum(cells + 1, len(full) - 1)
            # A battery that is colder the next day keeps its state of charge, not its energy.
            carried_wh = midnight * (full[following] / full[cells])
            after = after._replace(cell=following, energy_wh=carried_wh)
        elif number <= _DAYS_OF_LAUNCH:  # no measure, whatever flights have become equal
            goes_on = ~ended
        else:
            # A day that gives back what it takes is perpetual flight.
            goes_on = ~ended & (loss > _PERPETUAL * full[cells])
            alike = np.abs(loss - now.loss_wh) <= _ALIKE * full[cells]
            alike &= (loss > _ALIKE * full[cells]) & goes_on
            # Whole days that lose the same energy are skipped.
            days = np.floor(lowest / np.where(alike, loss, 1.0)) - 1.0
            days = np.where(alike, np.clip(days, 0.0, MAXIMUM_DAYS), 0.0)
            hours += days * HOURS_PER_DAY
            after = after._replace(energy_wh=midnight - days * loss, loss_wh=loss)
        return np.where(ended | goes_on, hours, np.inf), after, goes_on
