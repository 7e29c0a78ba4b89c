"""March of batteries along a time axis, for a batch of aircraft, scenarios or days at once.

The energy balance is

``dE/dt = min(eta_charge (P_solar - P_out), P_charge_max(E))`` by surplus,
``dE/dt = (P_solar - P_out) / eta_discharge`` by deficit, and ``0 <= E <= E_max``.

Surplus and deficit are exact (:mod:`sizing.day.balance`), and so is following the charge limit
(:class:`~sizing.day.battery.ChargeClock`); only an interval in which the active limit changes is
approximated, to second order in its length. A climb is a load like any other here.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from sizing.day.balance import (
    Interval,
    PowerBalance,
    interval_reaching,
    positive_part_wh,
    ramp_fraction,
    running_sum,
    sum_over_time,
)
from sizing.day.battery import Store
from solar.types import BoolArray, FloatArray, IntArray

# State of charge below zero that counts as an empty battery.
SHORT = 1e-12


def full_after_h(interval: Interval, store: Store, before_charge_wh: FloatArray) -> FloatArray:
    """Return when the surplus of an interval has filled the battery, after its start [h].

    ``before_charge_wh``: stored before the surplus. At most the end of the surplus.
    """
    begin, end = interval.surplus_h()
    stored = store.charge_efficiency * interval.surplus_wh
    to_full_wh = np.maximum(store.battery_energy_wh - before_charge_wh, 0.0)
    share = to_full_wh / np.maximum(stored, 1e-300)
    left_w, right_w = np.maximum(interval.left_w, 0.0), np.maximum(interval.right_w, 0.0)
    hours = (end - begin) * ramp_fraction(left_w, right_w, share)
    soc = np.minimum(before_charge_wh / store.battery_energy_wh, 1.0)
    return np.minimum(begin + np.maximum(hours, store.clock.hours_to_full(soc)), end)


@dataclass(frozen=True)
class ChargingDay:
    """A time axis reduced to the intervals in which batteries are charged; time is the first axis.

    Between two surpluses a battery only falls, to zero at the most, so the deficits in between are
    taken at once and exactly: nights are a single step. Midnight stands for the first node.

    ``first``: number of the first of these intervals. ``hours``, ``surplus_wh``: their lengths and
    surpluses. ``deficit_before_surplus_wh``: cumulative deficit from midnight to the surplus of the
    interval; minus infinity where an element of the batch has no surplus there: the interval then
    changes nothing, so that what an element becomes does not depend on the others in the batch.
    ``cumulative_deficit_wh``: cumulative deficit from midnight to every node of the time axis.
    """

    balance: PowerBalance
    first: int
    hours: FloatArray
    surplus_wh: FloatArray
    deficit_before_surplus_wh: FloatArray
    cumulative_deficit_wh: FloatArray

    @classmethod
    def of(cls, balance: PowerBalance) -> ChargingDay:
        """Reduce a balance."""
        charging = balance.surplus_wh > 0.0
        daylight = _span(charging)
        cumulative = running_sum(balance.deficit_wh)
        falls_first = balance.net_w[:-1][daylight] < 0.0
        before_surplus = np.where(falls_first, cumulative[1:][daylight], cumulative[:-1][daylight])
        np.copyto(before_surplus, -np.inf, where=~charging[daylight])
        hours = np.diff(balance.time_h)[daylight]
        surplus = balance.surplus_wh[daylight]
        return cls(balance, daylight.start, hours, surplus, before_surplus, cumulative)

    @cached_property
    def total_surplus_wh(self) -> FloatArray:
        """Return the surplus of the day [Wh]."""
        return sum_over_time(self.surplus_wh)

    @cached_property
    def nightfall_deficit_wh(self) -> FloatArray:
        """Return the deficit before the last surplus [Wh], minus infinity without any."""
        before_wh = self.deficit_before_surplus_wh
        return np.asarray(np.maximum.reduce(before_wh, axis=0, initial=-np.inf))

    def select(self, cells: IntArray) -> ChargingDay:
        """Return the day of a part of the batch, with the deficit at its end alone, to march it.

        The first and last intervals in which none of them charges are left out: the energies are
        the same to the last bit.
        """
        daylight = _span(self.surplus_wh[:, cells] > 0.0)
        return replace(
            self,
            first=self.first + daylight.start,
            hours=self.hours[daylight],
            surplus_wh=self.surplus_wh[daylight, cells],
            deficit_before_surplus_wh=self.deficit_before_surplus_wh[daylight, cells],
            cumulative_deficit_wh=self.cumulative_deficit_wh[-1:, cells],
        )

    def charge(
        self, store: Store, energy_wh: FloatArray, settled_deficit_wh: ArrayLike = 0.0
    ) -> Iterator[tuple[FloatArray, FloatArray, FloatArray]]:
        """March from midnight over the surpluses of the day.

        ``energy_wh``: stored at midnight [Wh]. ``settled_deficit_wh``: deficit since midnight that
        this energy has already met [Wh]. Yields for every interval of :attr:`hours` the energy
        before charging, below zero where the battery ran empty on the way, that after it, and the
        deficit since midnight that has been taken from the battery [Wh].
        """
        eta = store.discharge_efficiency
        settled = np.asarray(settled_deficit_wh, float)
        surpluses = zip(self.hours, self.surplus_wh, self.deficit_before_surplus_wh, strict=True)
        for hours, surplus, deficit in surpluses:
            # Between the surpluses of one day there is mostly no deficit: nothing is taken then.
            drained = before = energy_wh
            if (deficit > settled).any():
                drained = energy_wh - np.maximum(deficit - settled, 0.0) / eta
                before = np.maximum(drained, 0.0)
                settled = np.maximum(settled, deficit)
            energy_wh = store.charged(before, surplus, hours)
            yield drained, energy_wh, settled

    def midnight_wh(
        self, store: Store, energy_wh: FloatArray, settled_deficit_wh: ArrayLike
    ) -> FloatArray:
        """Return the energy at the end of the day after the last surplus [Wh].

        Arguments are those after the last surplus. Below zero by what
        is missing from an empty battery.
        """
        rest = self.cumulative_deficit_wh[-1] - settled_deficit_wh
        return np.asarray(energy_wh - rest / store.discharge_efficiency)

    def end_wh(self, store: Store, energy_wh: FloatArray) -> FloatArray:
        """Return the energy at the end of the day [Wh], zero where the battery is empty by then."""
        settled: ArrayLike = 0.0
        for step in self.charge(store, energy_wh):
            _, energy_wh, settled = step
        return np.maximum(self.midnight_wh(store, energy_wh, settled), 0.0)

    def run(self, store: Store, energy_wh: FloatArray) -> DayRun:
        """March, and keep the energy around every surplus."""
        kept = np.empty((3, *self.surplus_wh.shape))
        for k, step in enumerate(self.charge(store, energy_wh)):
            kept[0, k], kept[1, k], kept[2, k] = step
        return DayRun(self, store, energy_wh, *kept)

    def flight(
        self, store: Store, energy_wh: FloatArray, settled_deficit_wh: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """March batteries that may run empty; arguments are those of :meth:`charge`.

        Returns the deficit since midnight at which each is empty for the first time, NaN where it
        is not, and the energy at the end of the day and at the least [Wh].
        """
        eta, least = store.discharge_efficiency, -SHORT * store.battery_energy_wh
        energy, settled, lowest = energy_wh, settled_deficit_wh, energy_wh
        level = np.full(energy.shape, np.nan)

        def note_ends(drained_wh: FloatArray, at_wh: FloatArray) -> None:
            ends = (drained_wh < least) & np.isnan(level)
            if ends.any():
                level[ends] = (at_wh + eta * drained_wh)[ends]

        charges = (self.nightfall_deficit_wh >= settled).any()  # a surplus after the launch
        for step in self.charge(store, energy, settled) if charges else ():
            drained, energy, settled = step
            lowest = np.minimum(lowest, drained)
            note_ends(drained, settled)
        midnight = self.midnight_wh(store, energy, settled)
        note_ends(midnight, self.cumulative_deficit_wh[-1])
        lowest = np.maximum(np.minimum(lowest, midnight), 0.0)
        return level, np.maximum(midnight, 0.0), lowest

    def flights(
        self, cells: IntArray, store: Store, energy_wh: FloatArray, settled_deficit_wh: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """March batteries of some elements of the batch as :meth:`flight` does.

        ``store``: those of all elements. Returns when each is empty for the first time, NaN where
        it is not [h], and the energy at the end of the day and at the least [Wh].
        """
        part, few = self.select(cells), store.select(cells)
        level, midnight_wh, lowest_wh = part.flight(few, energy_wh, settled_deficit_wh)
        empty_h, ends = np.full(level.shape, np.nan), np.flatnonzero(~np.isnan(level))
        empty_h[ends] = self.hour_of_deficit(level[ends], cells[ends])
        return empty_h, midnight_wh, lowest_wh

    def hour_of_deficit(self, level_wh: FloatArray, cells: IntArray) -> FloatArray:
        """Return when the deficit since midnight reaches levels, each of one element [h]."""
        level, cumulative = np.maximum(level_wh, 0.0), self.cumulative_deficit_wh
        number = interval_reaching(cumulative, level, cells)
        interval = self.balance.interval(number, cells)
        rest = np.maximum(cumulative[number + 1, cells] - level, 0.0)
        return np.asarray(interval.start_h + interval.deficit_parts_h(rest)[0])

    def deficit_until_wh(self, clock_h: FloatArray, cells: IntArray) -> FloatArray:
        """Return the deficit from midnight to instants, each of one element [Wh]."""
        time = self.balance.time_h
        number = np.clip(np.searchsorted(time, clock_h, side="right") - 1, 0, len(time) - 2)
        interval = self.balance.interval(number, cells)
        elapsed = np.minimum(clock_h - interval.start_h, interval.hours)
        here = interval.left_w + (interval.right_w - interval.left_w) * elapsed / interval.hours
        since = positive_part_wh(-interval.left_w, -here, elapsed)
        return np.asarray(self.cumulative_deficit_wh[number, cells] + since)


def _span(charging: BoolArray) -> slice:
    """Return the rows from the first to the last in which a battery is charged."""
    rows = np.flatnonzero(charging.any(axis=1))
    return slice(int(rows[0]), int(rows[-1]) + 1) if len(rows) else slice(0, 0)


@dataclass(frozen=True)
class DayRun:
    """Energy of the batteries around every surplus of a day [Wh]."""

    day: ChargingDay
    store: Store
    start_wh: FloatArray
    drained_wh: FloatArray
    after_charge_wh: FloatArray
    settled_deficit_wh: FloatArray

    @property
    def midnight_wh(self) -> FloatArray:
        """Return the energy at the end of the day [Wh], below zero if the battery ran empty."""
        energy, settled = self.start_wh, np.zeros_like(self.start_wh)
        if len(self.after_charge_wh):
            energy, settled = self.after_charge_wh[-1], self.settled_deficit_wh[-1]
        return self.day.midnight_wh(self.store, energy, settled)

    @property
    def end_wh(self) -> FloatArray:
        """Return the energy at the end of the day [Wh]."""
        return np.maximum(self.midnight_wh, 0.0)

    def shortfalls_wh(self, short: float = SHORT) -> tuple[FloatArray, FloatArray]:
        """Return deficits from midnight between which a battery is empty, a row each; NaN if not.

        What is not served is the end of a deficit, up to the next surplus or the end of the day.
        ``short``: state of charge below zero that counts.
        """
        ends = np.vstack([self.settled_deficit_wh, self.day.cumulative_deficit_wh[-1:]])
        energy = np.vstack([self.drained_wh, self.midnight_wh])
        empty = energy < -short * self.store.battery_energy_wh
        begins = np.where(empty, ends + self.store.discharge_efficiency * energy, np.nan)
        return begins, np.where(empty, ends, np.nan)

    def empty_h(self, short: float = SHORT) -> FloatArray:
        """Return when each battery is empty for the first time [h], NaN where it never is."""
        level = np.fmin.reduce(self.shortfalls_wh(short)[0], axis=0)
        hour = self.day.hour_of_deficit(np.nan_to_num(level), np.arange(len(level)))
        return np.where(np.isnan(level), np.nan, hour)

    def energy_at_wh(self, hour: FloatArray) -> FloatArray:
        """Return the stored energy at an hour of each element [Wh], linear between the nodes."""
        time, values = self.day.balance.time_h, self.energy_at_nodes_wh()
        number = np.clip(np.searchsorted(time, hour, side="right") - 1, 0, len(time) - 2)
        cells = np.arange(len(hour))
        share = np.clip((hour - time[number]) / (time[number + 1] - time[number]), 0.0, 1.0)
        low, high = values[number, cells], values[number + 1, cells]
        return np.asarray(low + share * (high - low))

    def energy_at_nodes_wh(self) -> FloatArray:
        """Return the energy at every node of the time axis [Wh]."""
        cumulative = self.day.cumulative_deficit_wh
        held, settled = np.empty_like(cumulative), np.zeros_like(cumulative)
        begin, stop = self.day.first + 1, self.day.first + 1 + len(self.after_charge_wh)
        held[:begin] = self.start_wh
        held[begin:stop], settled[begin:stop] = self.after_charge_wh, self.settled_deficit_wh
        held[stop:], settled[stop:] = held[stop - 1], settled[stop - 1]
        left_wh = held - (cumulative - settled) / self.store.discharge_efficiency
        return np.maximum(left_wh, 0.0)

    def energy_at_node_wh(self, node: IntArray) -> FloatArray:
        """Return the energy at a node of every element of the batch [Wh]."""
        cells = np.arange(len(node))
        row = np.minimum(node - self.day.first, len(self.after_charge_wh)) - 1
        held, settled = self.start_wh.copy(), np.zeros_like(self.start_wh)
        charged = cells[row >= 0]
        held[charged] = self.after_charge_wh[row[charged], charged]
        settled[charged] = self.settled_deficit_wh[row[charged], charged]
        deficit_wh = self.day.cumulative_deficit_wh[node, cells] - settled
        return np.maximum(held - deficit_wh / self.store.discharge_efficiency, 0.0)
