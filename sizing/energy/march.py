"""Time marching of the battery over day and night, for a batch of aircraft and scenarios at once.

The energy balance is

``dE/dt = min(eta_charge (P_solar - P_out), P_charge_max(E))`` by surplus,
``dE/dt = (P_solar - P_out) / eta_discharge`` by deficit, and ``0 <= E <= E_max``.

Solar power and load are piecewise linear between the nodes of the time axis; surplus and deficit
of every interval are integrated exactly, a change of sign inside an interval included. The charge
limit depends on the state of charge alone, so following it is exact too
(:class:`~sizing.energy.battery.ChargeClock`); only an interval in which the active limit changes is
approximated, to second order in its length.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from sizing.energy.battery import Battery, ChargeClock
from sizing.energy.bracketing import falling_root
from sizing.energy.power_balance import (
    Interval,
    PowerBalance,
    crossing_fraction,
    deficit_phase_h,
    interval_reaching,
    positive_part_wh,
    ramp_fraction,
    running_sum,
    sum_over_time,
    surplus_phase_h,
)
from solar.types import BoolArray, FloatArray, IntArray

__all__ = [
    "ChargingDay",
    "DayRun",
    "Interval",
    "PowerBalance",
    "Step",
    "Store",
    "advance",
    "crossing_fraction",
    "deficit_phase_h",
    "empty_after_h",
    "final_energy_wh",
    "first_repetition",
    "full_after_h",
    "interval_reaching",
    "march",
    "periodic_energy_wh",
    "positive_part_wh",
    "ramp_fraction",
    "repeated_day",
    "running_sum",
    "sum_over_time",
    "surplus_phase_h",
    "unserved_h",
]


@dataclass(frozen=True)
class Store:
    """What the time marching needs of the batteries; energy at full charge is that of a batch."""

    battery_energy_wh: FloatArray
    charge_efficiency: float
    discharge_efficiency: float
    clock: ChargeClock | None

    @classmethod
    def of(cls, battery: Battery, battery_energy_wh: ArrayLike | None = None) -> Store:
        """Store of a battery, or of a batch that differs from it in capacity alone."""
        energy = battery.battery_energy_wh if battery_energy_wh is None else battery_energy_wh
        return cls(
            battery_energy_wh=np.asarray(energy, float),
            charge_efficiency=battery.charge_efficiency,
            discharge_efficiency=battery.discharge_efficiency,
            clock=ChargeClock.of(battery.charge_limit),
        )

    def spread(self, shape: tuple[int, ...]) -> Store:
        """Store of every element of a batch."""
        return replace(self, battery_energy_wh=np.broadcast_to(self.battery_energy_wh, shape))

    def select(self, cells: IntArray | BoolArray | slice) -> Store:
        """Store of a part of a one-dimensional batch."""
        return replace(self, battery_energy_wh=self.battery_energy_wh[cells])

    def charged(
        self, energy_wh: FloatArray, surplus_wh: FloatArray, hours: ArrayLike
    ) -> FloatArray:
        """Stored energy after charging from a surplus for some hours [Wh]."""
        target = np.minimum(energy_wh + self.charge_efficiency * surplus_wh, self.battery_energy_wh)
        if self.clock is None:
            return np.asarray(target)
        # While the limit is constant it adds a constant power; the clock is asked beyond that.
        allowed = energy_wh + self._constant_limit_w * np.asarray(hours, float)
        charged = np.asarray(np.minimum(target, allowed))
        tapered = charged > np.maximum(energy_wh, self._constant_up_to_wh)
        at = np.flatnonzero(tapered)
        if len(at):
            picked = (
                _pick(v, tapered, at) for v in (self.battery_energy_wh, energy_wh, target, hours)
            )
            charged.reshape(-1)[at] = self._tapered(self.clock, *picked)
        return charged

    @cached_property
    def _constant_limit_w(self) -> FloatArray:
        """Charge limit of an empty battery [W], counted in stored power."""
        return self.battery_energy_wh * (
            np.inf if self.clock is None else self.clock.constant_rate_per_h
        )

    @cached_property
    def _constant_up_to_wh(self) -> FloatArray:
        """Energy up to which the charge limit is constant [Wh]."""
        return self.battery_energy_wh * (1.0 if self.clock is None else self.clock.constant_up_to)

    @staticmethod
    def _tapered(
        clock: ChargeClock,
        full_wh: FloatArray,
        start_wh: FloatArray,
        target_wh: FloatArray,
        hours: FloatArray,
    ) -> FloatArray:
        """Energy after charging where the limit may fall with the state of charge."""
        limited = clock.after(np.minimum(start_wh / full_wh, 1.0), hours) * full_wh
        # A round trip through the clock's table must not lose the last digits of a full battery.
        return np.maximum(np.minimum(target_wh, limited), start_wh)


def _pick(values: ArrayLike, like: BoolArray, at: IntArray) -> FloatArray:
    """Values of an array, seen in the shape of another, at some of its places."""
    array = np.asarray(values, float)
    if array.ndim and array.shape != like.shape:
        array = np.broadcast_to(array, like.shape)
    return array.reshape(-1).take(at) if array.ndim else array


class Step(NamedTuple):
    """Stored energy at the start, before and after charging and at the end of an interval."""

    interval: Interval
    start_wh: FloatArray
    before_charge_wh: FloatArray
    after_charge_wh: FloatArray
    end_wh: FloatArray
    unserved_wh: FloatArray


def advance(store: Store, interval: Interval, energy_wh: FloatArray) -> Step:
    """March the stored energy over one interval."""
    eta = store.discharge_efficiency
    drained = energy_wh - interval.early_deficit_wh / eta
    before = np.maximum(drained, 0.0)
    after = store.charged(before, interval.surplus_wh, interval.hours)
    left_over = after - interval.late_deficit_wh / eta
    end = np.maximum(left_over, 0.0)
    unserved = eta * (before - drained + end - left_over)
    return Step(interval, energy_wh, before, after, end, unserved)


def empty_after_h(step: Step) -> FloatArray:
    """Hours after an interval's start at which the battery runs empty.

    Meaningful only where the step leaves a part of the load unserved.
    """
    begin, length = deficit_phase_h(step.interval)
    return np.asarray(begin + length * _served_fraction(step))


def full_after_h(step: Step, store: Store) -> FloatArray:
    """Hours after an interval's start at which the battery is full.

    Meaningful only where the step ends charging with a full battery.
    """
    interval = step.interval
    begin, end = surplus_phase_h(interval)
    stored = store.charge_efficiency * interval.surplus_wh
    wanted = np.maximum(store.battery_energy_wh - step.before_charge_wh, 0.0)
    share = wanted / np.maximum(stored, 1e-300)
    hours = (end - begin) * ramp_fraction(
        np.maximum(interval.left_w, 0.0), np.maximum(interval.right_w, 0.0), share
    )
    if store.clock is not None:
        soc = np.minimum(step.before_charge_wh / store.battery_energy_wh, 1.0)
        hours = np.maximum(hours, store.clock.hours_to_full(soc))
    return np.minimum(begin + hours, end)


def unserved_h(step: Step) -> FloatArray:
    """Hours of an interval in which the load cannot be met."""
    _, length = deficit_phase_h(step.interval)
    hours = length * (1.0 - _served_fraction(step))
    return np.where(step.unserved_wh > 0.0, hours, 0.0)


def _served_fraction(step: Step) -> FloatArray:
    """Fraction of the deficit's phase after which the battery is empty."""
    interval = step.interval
    deficit = interval.early_deficit_wh + interval.late_deficit_wh
    served = 1.0 - step.unserved_wh / np.maximum(deficit, 1e-300)
    return ramp_fraction(
        np.maximum(-interval.left_w, 0.0), np.maximum(-interval.right_w, 0.0), served
    )


def march(balance: PowerBalance, store: Store, energy_wh: FloatArray) -> Iterator[Step]:
    """March from an initial energy over the whole time axis, yielding every step."""
    for interval in balance.intervals():
        step = advance(store, interval, energy_wh)
        yield step
        energy_wh = step.end_wh


class Charging(NamedTuple):
    """Batteries over the surplus of one interval [Wh].

    ``drained_wh`` is the energy before charging, below zero where the battery ran empty on the
    way; ``settled_deficit_wh`` is the deficit since midnight that has been taken from the battery.
    """

    drained_wh: FloatArray
    before_charge_wh: FloatArray
    after_charge_wh: FloatArray
    settled_deficit_wh: FloatArray


@dataclass(frozen=True)
class ChargingDay:
    """A day reduced to the intervals in which batteries are charged; time is the first axis.

    Between two surpluses a battery only falls, to zero at the most, so the deficits in between are
    taken at once and exactly: nights are a single step. ``cumulative_deficit_wh`` is the deficit
    from midnight to every node. ``deficit_before_surplus_wh`` is the deficit from midnight to the
    surplus of the interval, minus infinity where an element of the batch has no surplus there: the
    interval then changes nothing, so that what an element becomes does not depend on the others in
    the batch.
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
        lit = slice(int(rows[0]), int(rows[-1]) + 1) if len(rows) else slice(0, 0)
        cumulative = running_sum(balance.deficit_wh)
        falls_first = balance.net_w[:-1][lit] < 0.0
        owed = np.where(falls_first, cumulative[1:][lit], cumulative[:-1][lit])
        owed[~charging[lit]] = -np.inf
        return cls(
            first=lit.start,
            hours=np.diff(balance.time_h)[lit],
            surplus_wh=balance.surplus_wh[lit],
            deficit_before_surplus_wh=owed,
            cumulative_deficit_wh=cumulative,
        )

    def select(self, cells: IntArray) -> ChargingDay:
        """Day of a part of the batch."""
        return replace(
            self,
            surplus_wh=self.surplus_wh[:, cells],
            deficit_before_surplus_wh=self.deficit_before_surplus_wh[:, cells],
            cumulative_deficit_wh=self.cumulative_deficit_wh[:, cells],
        )

    def without_nodes(self) -> ChargingDay:
        """Day that knows the deficit at its end alone: enough to march."""
        return replace(self, cumulative_deficit_wh=self.cumulative_deficit_wh[-1:])

    def charge(
        self, store: Store, energy_wh: FloatArray, settled_deficit_wh: ArrayLike = 0.0
    ) -> Iterator[Charging]:
        """March from midnight over the surpluses of the day."""
        eta = store.discharge_efficiency
        paid = np.asarray(settled_deficit_wh, float)
        for hours, surplus, owed in zip(
            self.hours, self.surplus_wh, self.deficit_before_surplus_wh, strict=True
        ):
            drained = energy_wh - np.maximum(owed - paid, 0.0) / eta
            before = np.maximum(drained, 0.0)
            energy_wh = store.charged(before, surplus, hours)
            paid = np.maximum(paid, owed)
            yield Charging(drained, before, energy_wh, paid)

    def midnight_wh(
        self, store: Store, energy_wh: FloatArray, settled_deficit_wh: ArrayLike
    ) -> FloatArray:
        """Energy at the end of the day after the last surplus; below zero if it ran empty."""
        due = self.cumulative_deficit_wh[-1] - settled_deficit_wh
        return np.asarray(energy_wh - due / store.discharge_efficiency)

    def end_wh(self, store: Store, energy_wh: FloatArray) -> FloatArray:
        """Energy at the end of a day that starts with some energy [Wh]."""
        paid: ArrayLike = 0.0
        for step in self.charge(store, energy_wh):
            energy_wh, paid = step.after_charge_wh, step.settled_deficit_wh
        return np.maximum(self.midnight_wh(store, energy_wh, paid), 0.0)

    def run(self, store: Store, energy_wh: FloatArray) -> DayRun:
        """March a day and keep what becomes of the batteries."""
        drained, after, paid = (np.empty_like(self.deficit_before_surplus_wh) for _ in range(3))
        for k, step in enumerate(self.charge(store, energy_wh)):
            drained[k], _, after[k], paid[k] = step
        return DayRun(self, store, energy_wh, drained, after, paid)


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
        energy, paid = self.start_wh, np.zeros_like(self.start_wh)
        if len(self.after_charge_wh):
            energy, paid = self.after_charge_wh[-1], self.settled_deficit_wh[-1]
        return self.day.midnight_wh(self.store, energy, paid)

    @property
    def end_wh(self) -> FloatArray:
        """Energy at the end of the day [Wh]."""
        return np.maximum(self.midnight_wh, 0.0)

    def select(self, cells: IntArray) -> DayRun:
        """Run of a part of the batch."""
        return DayRun(
            self.day.select(cells),
            self.store.select(cells),
            self.start_wh[cells],
            self.drained_wh[:, cells],
            self.after_charge_wh[:, cells],
            self.settled_deficit_wh[:, cells],
        )

    def restart(self, cells: IntArray, start_wh: FloatArray) -> None:
        """Change the initial energy of elements that are empty before their first surplus."""
        waiting = np.maximum.accumulate(self.day.deficit_before_surplus_wh[:, cells], axis=0) < 0.0
        for energy in (self.drained_wh, self.after_charge_wh):
            energy[:, cells] = np.where(waiting, start_wh, energy[:, cells])
        first = waiting.sum(axis=0)
        lit = first < len(waiting)
        more_wh = start_wh - self.start_wh[cells]
        self.drained_wh[first[lit], cells[lit]] += more_wh[lit]
        self.start_wh[cells] = start_wh

    def replace_cells(self, cells: IntArray, other: DayRun) -> None:
        """Overwrite a part of the batch by another run."""
        self.start_wh[cells] = other.start_wh
        self.drained_wh[:, cells] = other.drained_wh
        self.after_charge_wh[:, cells] = other.after_charge_wh
        self.settled_deficit_wh[:, cells] = other.settled_deficit_wh

    def energy_at_nodes_wh(self) -> FloatArray:
        """Energy at every node of the time axis [Wh]."""
        held, paid = (
            np.empty_like(self.day.cumulative_deficit_wh),
            np.zeros_like(self.day.cumulative_deficit_wh),
        )
        begin, stop = self.day.first + 1, self.day.first + 1 + len(self.after_charge_wh)
        held[:begin] = self.start_wh
        held[begin:stop], paid[begin:stop] = self.after_charge_wh, self.settled_deficit_wh
        held[stop:], paid[stop:] = held[stop - 1], paid[stop - 1]
        return self._after_deficit(held, paid, self.day.cumulative_deficit_wh)

    def energy_at_node_wh(self, node: IntArray) -> FloatArray:
        """Energy at one node for every element of the batch [Wh]."""
        cells = np.arange(len(node))
        row = np.minimum(node - self.day.first, len(self.after_charge_wh)) - 1
        held, paid = self.start_wh.copy(), np.zeros_like(self.start_wh)
        some = cells[row >= 0]
        held[some] = self.after_charge_wh[row[some], some]
        paid[some] = self.settled_deficit_wh[row[some], some]
        return self._after_deficit(held, paid, self.day.cumulative_deficit_wh[node, cells])

    def _after_deficit(
        self, held_wh: FloatArray, settled_deficit_wh: FloatArray, cumulative_deficit_wh: FloatArray
    ) -> FloatArray:
        due = cumulative_deficit_wh - settled_deficit_wh
        return np.maximum(held_wh - due / self.store.discharge_efficiency, 0.0)


def final_energy_wh(balance: PowerBalance, store: Store, energy_wh: FloatArray) -> FloatArray:
    """Stored energy at the end of the time axis [Wh]."""
    shape = np.broadcast_shapes(
        balance.batch_shape, np.shape(energy_wh), store.battery_energy_wh.shape
    )
    start = np.broadcast_to(np.asarray(energy_wh, float), shape)
    day = ChargingDay.of(balance.flat())
    return day.end_wh(_flat(store, shape), start.reshape(-1)).reshape(shape)


def periodic_energy_wh(balance: PowerBalance, store: Store) -> FloatArray:
    """Stored energy at the start of a cycle that repeats itself [Wh]."""
    shape = balance.batch_shape
    run = repeated_day(ChargingDay.of(balance.flat()), _flat(store, shape))
    return run.start_wh.reshape(shape)


def _flat(store: Store, shape: tuple[int, ...]) -> Store:
    return replace(store, battery_energy_wh=store.spread(shape).battery_energy_wh.reshape(-1))


# Of the capacity: change of the stored energy over a day that counts as none.
_SETTLED = 1e-11


class Repetition(NamedTuple):
    """Run of a day, and the elements that do not end it with the energy they started with."""

    run: DayRun
    unsettled: IntArray


def repeated_day(day: ChargingDay, store: Store) -> DayRun:
    """Run of a day that ends with the energy it started with.

    The energy after a cycle never falls, and rises by at most as much, when that before it rises
    (a fuller battery is charged no faster), so there is one fixed point, and repeating the cycle
    from an empty battery leads to it. A cycle whose deficit exceeds all that could be stored
    passes through an empty battery, and from there one day leads to the fixed point. Any other
    cycle is marched from a full battery at nightfall; most fill it again within the day. The few
    that are left are searched for, see :func:`sizing.energy.bracketing.falling_root`.
    """
    run, unsettled = first_repetition(day, store)
    if len(unsettled):
        part, part_store = day.select(unsettled), store.select(unsettled)
        upper = np.maximum(run.start_wh, run.end_wh)[unsettled]
        start = _fixed_point(part, part_store, upper)
        run.replace_cells(unsettled, part.run(part_store, start))
    return run


def first_repetition(day: ChargingDay, store: Store) -> Repetition:
    """Run of a day that settles at once in nearly all cases, see :func:`repeated_day`."""
    full, eta = store.battery_energy_wh, store.discharge_efficiency
    storable = store.charge_efficiency * sum_over_time(day.surplus_wh) * eta
    last_paid = np.maximum.reduce(day.deficit_before_surplus_wh, axis=0, initial=0.0)
    full_at_nightfall = np.maximum(day.midnight_wh(store, full, last_paid), 0.0)
    loses = storable < day.cumulative_deficit_wh[-1]
    run = day.run(store, np.where(loses, 0.0, full_at_nightfall))
    end = run.end_wh
    moved = np.flatnonzero(np.abs(end - run.start_wh) > _SETTLED * full)
    owed = np.where(
        day.deficit_before_surplus_wh[:, moved] < 0.0,
        np.inf,
        day.deficit_before_surplus_wh[:, moved],
    )
    first_owed = np.minimum.reduce(owed, axis=0, initial=np.inf)
    # Empty before the first surplus from here and from there, and from then on the same.
    alike = first_owed >= eta * np.maximum(run.start_wh, end)[moved]
    run.restart(moved[alike], end[moved[alike]])
    return Repetition(run, moved[~alike])


def _fixed_point(day: ChargingDay, store: Store, upper_wh: FloatArray) -> FloatArray:
    """Energy at the start of the repeated day, from an energy that is not below it."""

    def gain(some: IntArray, energy: FloatArray) -> FloatArray:
        return day.select(some).end_wh(store.select(some), energy) - energy

    return falling_root(gain, np.zeros_like(upper_wh), upper_wh, _SETTLED * store.battery_energy_wh)
