"""Time marching of the battery over day and night, for a batch of aircraft and scenarios at once.

The energy balance is

``dE/dt = min(eta_charge (P_solar - P_out), P_charge_max(E))`` by surplus,
``dE/dt = (P_solar - P_out) / eta_discharge`` by deficit, and ``0 <= E <= E_max``.

Solar power and load are piecewise linear between the nodes of the time axis; surplus and deficit
of every interval are integrated exactly, a change of sign inside an interval included. The charge
limit depends on the state of charge alone, so following it is exact too
(:class:`~sizing.day.battery.ChargeClock`); only an interval in which the active limit changes is
approximated, to second order in its length.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from sizing.day.balance import (
    Interval,
    PowerBalance,
    deficit_phase_h,
    interval_reaching,
    ramp_fraction,
    running_sum,
    sum_over_time,
    surplus_phase_h,
)
from sizing.day.battery import Store
from sizing.roots import falling_root
from solar.types import FloatArray, IntArray

# Of the battery's energy: change of the stored energy over a day that counts as none.
_SETTLED = 1e-11


class Step(NamedTuple):
    """Stored energy at the start, before and after charging and at the end of an interval [Wh]."""

    interval: Interval
    start_wh: FloatArray
    before_charge_wh: FloatArray
    after_charge_wh: FloatArray
    end_wh: FloatArray
    unserved_wh: FloatArray


def advance(store: Store, interval: Interval, energy_wh: FloatArray) -> Step:
    """March the stored energy over one interval.

    ``energy_wh``: stored at its start [Wh]. No energy falls below zero; ``unserved_wh`` is counted
    in energy delivered to the load [Wh].
    """
    eta = store.discharge_efficiency
    drained = energy_wh - interval.early_deficit_wh / eta
    before = np.maximum(drained, 0.0)
    after = store.charged(before, interval.surplus_wh, interval.hours)
    left_over = after - interval.late_deficit_wh / eta
    end = np.maximum(left_over, 0.0)
    unserved = eta * (before - drained + end - left_over)
    return Step(interval, energy_wh, before, after, end, unserved)


def march(balance: PowerBalance, store: Store, energy_wh: FloatArray) -> Iterator[Step]:
    """March over the whole time axis, yielding every step.

    ``energy_wh``: stored at the first node [Wh].
    """
    for interval in balance.intervals():
        step = advance(store, interval, energy_wh)
        yield step
        energy_wh = step.end_wh


def empty_after_h(interval: Interval, unserved_wh: FloatArray) -> FloatArray:
    """Hours after an interval's start at which the battery runs empty.

    ``unserved_wh``: part of the deficit that the battery cannot meet [Wh]; the hours mean something
    only where it is not 0.
    """
    begin, length = deficit_phase_h(interval)
    return np.asarray(begin + length * _served_fraction(interval, unserved_wh))


def hour_of_deficit(
    balance: PowerBalance, cumulative_wh: FloatArray, level_wh: FloatArray, cells: IntArray
) -> FloatArray:
    """Instants at which the deficit since the start of the day reaches some levels.

    ``cumulative_wh``: that of a batch of one dimension, shape ``(node, element)``
    (:attr:`ChargingDay.cumulative_deficit_wh`). ``cells``: element of each level. Returns hours of
    the shape of the levels.
    """
    level = np.maximum(level_wh, 0.0)
    interval = balance.interval_of(interval_reaching(cumulative_wh, level, cells), cells)
    rest = np.maximum(cumulative_wh[interval.number + 1, cells] - level, 0.0)
    return np.asarray(interval.start_h + empty_after_h(interval, rest))


def unserved_h(interval: Interval, unserved_wh: FloatArray) -> FloatArray:
    """Hours of an interval in which the load cannot be met.

    ``unserved_wh``: as for :func:`empty_after_h`; 0 h where all is served.
    """
    _, length = deficit_phase_h(interval)
    hours = length * (1.0 - _served_fraction(interval, unserved_wh))
    return np.where(unserved_wh > 0.0, hours, 0.0)


def _served_fraction(interval: Interval, unserved_wh: FloatArray) -> FloatArray:
    """Fraction of the deficit's phase after which the battery is empty."""
    deficit = interval.early_deficit_wh + interval.late_deficit_wh
    served = 1.0 - unserved_wh / np.maximum(deficit, 1e-300)
    return ramp_fraction(
        np.maximum(-interval.left_w, 0.0), np.maximum(-interval.right_w, 0.0), served
    )


def full_after_h(interval: Interval, store: Store, before_charge_wh: FloatArray) -> FloatArray:
    """Hours after an interval's start at which the battery is full.

    ``before_charge_wh``: stored before the surplus [Wh]. The hours are at most the end of the
    surplus, and mean something only where the surplus fills the battery.
    """
    begin, end = surplus_phase_h(interval)
    stored = store.charge_efficiency * interval.surplus_wh
    wanted = np.maximum(store.battery_energy_wh - before_charge_wh, 0.0)
    share = wanted / np.maximum(stored, 1e-300)
    hours = (end - begin) * ramp_fraction(
        np.maximum(interval.left_w, 0.0), np.maximum(interval.right_w, 0.0), share
    )
    if store.clock is not None:
        soc = np.minimum(before_charge_wh / store.battery_energy_wh, 1.0)
        hours = np.maximum(hours, store.clock.hours_to_full(soc))
    return np.minimum(begin + hours, end)


class Charging(NamedTuple):
    """Batteries over the surplus of one interval [Wh].

    ``drained_wh`` is the energy before charging, below zero where the battery ran empty on the
    way; ``settled_deficit_wh`` is the deficit since midnight that has been taken from the battery.
    """

    drained_wh: FloatArray
    after_charge_wh: FloatArray
    settled_deficit_wh: FloatArray


@dataclass(frozen=True)
class ChargingDay:
    """A day reduced to the intervals in which batteries are charged; time is the first axis.

    Between two surpluses a battery only falls, to zero at the most, so the deficits in between are
    taken at once and exactly: nights are a single step.

    ``first``: number of the first of these intervals. ``hours``, ``surplus_wh``: their lengths and
    surpluses. ``deficit_before_surplus_wh``: cumulative deficit from midnight to the surplus of the
    interval; minus infinity where an element of the batch has no surplus there: the interval then
    changes nothing, so that what an element becomes does not depend on the others in the batch.
    ``cumulative_deficit_wh``: cumulative deficit from midnight to every node of the time axis.
    """

    first: int
    hours: FloatArray
    surplus_wh: FloatArray
    deficit_before_surplus_wh: FloatArray
    cumulative_deficit_wh: FloatArray

    @classmethod
    def of(cls, balance: PowerBalance) -> ChargingDay:
        """Reduce a balance with a batch of one dimension."""
        charging = balance.surplus_wh > 0.0
        rows = np.flatnonzero(charging.any(axis=1))
        sunlit = slice(int(rows[0]), int(rows[-1]) + 1) if len(rows) else slice(0, 0)
        cumulative = running_sum(balance.deficit_wh)
        falls_first = balance.net_w[:-1][sunlit] < 0.0
        before_surplus = np.where(falls_first, cumulative[1:][sunlit], cumulative[:-1][sunlit])
        np.copyto(before_surplus, -np.inf, where=~charging[sunlit])
        return cls(
            first=sunlit.start,
            hours=np.diff(balance.time_h)[sunlit],
            surplus_wh=balance.surplus_wh[sunlit],
            deficit_before_surplus_wh=before_surplus,
            cumulative_deficit_wh=cumulative,
        )

    @cached_property
    def total_surplus_wh(self) -> FloatArray:
        """Surplus of the day [Wh]."""
        return sum_over_time(self.surplus_wh)

    def select(self, cells: IntArray) -> ChargingDay:
        """Day of a part of the batch."""
        return replace(
            self,
            surplus_wh=self.surplus_wh[:, cells],
            deficit_before_surplus_wh=self.deficit_before_surplus_wh[:, cells],
            cumulative_deficit_wh=self.cumulative_deficit_wh[:, cells],
        )

    def select_lit(self, cells: IntArray) -> ChargingDay:
        """As :meth:`select`, without the first and last intervals in which none of them charges.

        What becomes of the batteries is the same to the last bit.
        """
        rows = np.flatnonzero((self.surplus_wh[:, cells] > 0.0).any(axis=1))
        sunlit = slice(int(rows[0]), int(rows[-1]) + 1) if len(rows) else slice(0, 0)
        return replace(
            self,
            first=self.first + sunlit.start,
            hours=self.hours[sunlit],
            surplus_wh=self.surplus_wh[sunlit, cells],
            deficit_before_surplus_wh=self.deficit_before_surplus_wh[sunlit, cells],
            cumulative_deficit_wh=self.cumulative_deficit_wh[:, cells],
        )

    def without_nodes(self) -> ChargingDay:
        """Day that knows the deficit at its end alone: enough to march."""
        return replace(self, cumulative_deficit_wh=self.cumulative_deficit_wh[-1:])

    def charge(
        self, store: Store, energy_wh: FloatArray, settled_deficit_wh: ArrayLike = 0.0
    ) -> Iterator[Charging]:
        """March from midnight over the surpluses of the day.

        ``energy_wh``: stored at midnight [Wh]. ``settled_deficit_wh``: deficit since midnight that
        this energy has already met [Wh]. Yields one per interval of :attr:`hours`.
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
            yield Charging(drained, energy_wh, settled)

    def midnight_wh(
        self, store: Store, energy_wh: FloatArray, settled_deficit_wh: ArrayLike
    ) -> FloatArray:
        """Energy at the end of the day after the last surplus; below zero if it ran empty [Wh].

        Arguments are those after the last surplus. Not clipped, so that the negative part is the
        energy missing from the battery.
        """
        rest = self.cumulative_deficit_wh[-1] - settled_deficit_wh
        return np.asarray(energy_wh - rest / store.discharge_efficiency)

    def end_wh(self, store: Store, energy_wh: FloatArray) -> FloatArray:
        """Energy at the end of the day [Wh].

        Zero where the battery has run empty after the last surplus.
        """
        settled: ArrayLike = 0.0
        for step in self.charge(store, energy_wh):
            energy_wh, settled = step.after_charge_wh, step.settled_deficit_wh
        return np.maximum(self.midnight_wh(store, energy_wh, settled), 0.0)

    def run(self, store: Store, energy_wh: FloatArray) -> DayRun:
        """March and keep what becomes of the batteries."""
        kept = np.empty((3, *self.surplus_wh.shape))
        for k, step in enumerate(self.charge(store, energy_wh)):
            kept[0, k], kept[1, k], kept[2, k] = step
        return DayRun(self, store, energy_wh, *kept)


@dataclass(frozen=True)
class DayRun:
    """What became of the batteries on a day: energy around every surplus [Wh]."""

    day: ChargingDay
    store: Store
    start_wh: FloatArray
    drained_wh: FloatArray
    after_charge_wh: FloatArray
    settled_deficit_wh: FloatArray

    @property
    def midnight_wh(self) -> FloatArray:
        """Energy at the end of the day [Wh], below zero if the battery ran empty."""
        energy, settled = self.start_wh, np.zeros_like(self.start_wh)
        if len(self.after_charge_wh):
            energy, settled = self.after_charge_wh[-1], self.settled_deficit_wh[-1]
        return self.day.midnight_wh(self.store, energy, settled)

    @property
    def end_wh(self) -> FloatArray:
        """Energy at the end of the day [Wh]."""
        return np.maximum(self.midnight_wh, 0.0)

    def restart(self, cells: IntArray, start_wh: FloatArray) -> None:
        """Change the initial energy of elements that are empty before their first surplus."""
        waiting = np.maximum.accumulate(self.day.deficit_before_surplus_wh[:, cells], axis=0) < 0.0
        for energy in (self.drained_wh, self.after_charge_wh):
            energy[:, cells] = np.where(waiting, start_wh, energy[:, cells])
        first = waiting.sum(axis=0)
        sunlit = first < len(waiting)
        more_wh = start_wh - self.start_wh[cells]
        self.drained_wh[first[sunlit], cells[sunlit]] += more_wh[sunlit]
        self.start_wh[cells] = start_wh

    def energy_at_nodes_wh(self) -> FloatArray:
        """Energy at every node of the time axis [Wh]."""
        cumulative = self.day.cumulative_deficit_wh
        held, settled = np.empty_like(cumulative), np.zeros_like(cumulative)
        begin, stop = self.day.first + 1, self.day.first + 1 + len(self.after_charge_wh)
        held[:begin] = self.start_wh
        held[begin:stop], settled[begin:stop] = self.after_charge_wh, self.settled_deficit_wh
        held[stop:], settled[stop:] = held[stop - 1], settled[stop - 1]
        return self._after_deficit(held, cumulative - settled)

    def energy_at_node_wh(self, node: IntArray) -> FloatArray:
        """Energy at one node for every element of the batch [Wh]."""
        cells = np.arange(len(node))
        row = np.minimum(node - self.day.first, len(self.after_charge_wh)) - 1
        held, settled = self.start_wh.copy(), np.zeros_like(self.start_wh)
        some = cells[row >= 0]
        held[some] = self.after_charge_wh[row[some], some]
        settled[some] = self.settled_deficit_wh[row[some], some]
        return self._after_deficit(held, self.day.cumulative_deficit_wh[node, cells] - settled)

    def _after_deficit(self, held_wh: FloatArray, deficit_wh: FloatArray) -> FloatArray:
        return np.maximum(held_wh - deficit_wh / self.store.discharge_efficiency, 0.0)


def repeated_day(day: ChargingDay, store: Store) -> DayRun:
    """Run of a day that ends with the energy it started with.

    The energy after a cycle never falls, and rises by at most as much, when that before it rises
    (a fuller battery is charged no faster), so there is one fixed point, and repeating the cycle
    from an empty battery leads to it. A cycle whose deficit exceeds all that could be stored
    passes through an empty battery, and from there one day leads to the fixed point. Any other
    cycle is marched from a full battery at nightfall; most fill it again within the day. The few
    that are left are searched for, see :func:`sizing.roots.falling_root`.

    Returns start and end that agree to 1e-11 of the battery's energy.
    """
    first = first_repetition(day, store)
    cells = first.unsettled
    if not len(cells):
        return first.run
    start = first.run.start_wh.copy()
    start[cells] = repeated_wh(day.select(cells), store.select(cells), first.highest_wh)
    return day.run(store, start)


def repeated_wh(day: ChargingDay, store: Store, highest_wh: FloatArray) -> FloatArray:
    """Energy with which a day starts and ends, between zero and ``highest_wh`` [Wh]."""
    brief = day.without_nodes()

    def gain(some: IntArray, energy_wh: FloatArray) -> FloatArray:
        return brief.select_lit(some).end_wh(store.select(some), energy_wh) - energy_wh

    limit = _SETTLED * store.battery_energy_wh
    return falling_root(gain, np.zeros_like(highest_wh), highest_wh, limit)


class Repetition(NamedTuple):
    """Run of a day, and the elements that do not end it with the energy they started with."""

    run: DayRun
    unsettled: IntArray

    @property
    def highest_wh(self) -> FloatArray:
        """Energy above which no unsettled element repeats its day [Wh]."""
        return np.maximum(self.run.start_wh, self.run.end_wh)[self.unsettled]


def first_repetition(day: ChargingDay, store: Store) -> Repetition:
    """Run of a day that settles at once in nearly all cases; :func:`repeated_day` tells how."""
    full, eta = store.battery_energy_wh, store.discharge_efficiency
    before_surplus = day.deficit_before_surplus_wh
    storable = store.charge_efficiency * day.total_surplus_wh * eta
    at_nightfall = np.maximum.reduce(before_surplus, axis=0, initial=0.0)
    full_at_nightfall = np.maximum(day.midnight_wh(store, full, at_nightfall), 0.0)
    loses = storable < day.cumulative_deficit_wh[-1]
    run = day.run(store, np.where(loses, 0.0, full_at_nightfall))
    end = run.end_wh
    moved = np.flatnonzero(np.abs(end - run.start_wh) > _SETTLED * full)
    of_moved = before_surplus[:, moved]
    at_first_surplus = np.minimum.reduce(
        np.where(of_moved < 0.0, np.inf, of_moved), axis=0, initial=np.inf
    )
    # Empty before the first surplus from here and from there, and from then on the same.
    alike = at_first_surplus >= (eta * np.maximum(run.start_wh, end))[moved]
    run.restart(moved[alike], end[moved[alike]])
    return Repetition(run, moved[~alike])
