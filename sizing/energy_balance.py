"""Time marching of the battery over day and night, for a batch of aircraft and scenarios at once.

The energy balance is

``dE/dt = min(eta_charge (P_solar - P_out), P_charge_max(E))`` by surplus,
``dE/dt = (P_solar - P_out) / eta_discharge`` by deficit, and ``0 <= E <= E_max``.

Solar power and load are piecewise linear between the nodes of the time axis; surplus and deficit
of every interval are integrated exactly, a change of sign inside an interval included. The charge
limit depends on the state of charge alone, so following it is exact too
(:class:`~sizing.battery.ChargeClock`); only an interval in which the active limit changes is
approximated, to second order in its length.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from sizing.battery import Battery, ChargeClock
from sizing.bracketing import falling_root
from sizing.power_balance import (
    BoolArray,
    FloatArray,
    IntArray,
    Interval,
    PowerBalance,
    crossing_fraction,
    deficit_phase_h,
    positive_part_wh,
    ramp_fraction,
    running_sum,
    sum_over_time,
    surplus_phase_h,
)

__all__ = [
    "BoolArray",
    "ChargingDay",
    "DayRun",
    "FloatArray",
    "IntArray",
    "Interval",
    "PowerBalance",
    "Step",
    "Store",
    "advance",
    "crossing_fraction",
    "empty_after_h",
    "final_energy_wh",
    "full_after_h",
    "march",
    "periodic_energy_wh",
    "positive_part_wh",
    "ramp_fraction",
    "repeated_day",
    "sum_over_time",
    "surplus_phase_h",
    "unserved_h",
]

# Cycles marched before the remaining cells are bracketed.
_PLAIN_CYCLES = 3


@dataclass(frozen=True)
class Store:
    """What the time marching needs of the batteries; ``energy_max_wh`` is an array of the batch."""

    energy_max_wh: FloatArray
    charge_efficiency: float
    discharge_efficiency: float
    clock: ChargeClock | None

    @classmethod
    def of(cls, battery: Battery, energy_max_wh: ArrayLike | None = None) -> Store:
        """Store of a battery, or of a batch that differs from it in capacity alone."""
        energy = battery.energy_wh if energy_max_wh is None else energy_max_wh
        return cls(
            energy_max_wh=np.asarray(energy, float),
            charge_efficiency=battery.charge_efficiency,
            discharge_efficiency=battery.discharge_efficiency,
            clock=ChargeClock.of(battery.charge_limit),
        )

    def spread(self, shape: tuple[int, ...]) -> Store:
        """Store of every element of a batch."""
        return replace(self, energy_max_wh=np.broadcast_to(self.energy_max_wh, shape))

    def select(self, cells: IntArray | BoolArray | slice) -> Store:
        """Store of a part of a one-dimensional batch."""
        return replace(self, energy_max_wh=self.energy_max_wh[cells])

    def charged(
        self, energy_wh: FloatArray, surplus_wh: FloatArray, hours: ArrayLike
    ) -> FloatArray:
        """Stored energy after charging from a surplus for some hours [Wh]."""
        target = np.minimum(energy_wh + self.charge_efficiency * surplus_wh, self.energy_max_wh)
        if self.clock is None:
            return np.asarray(target)
        # While the limit is constant it adds a constant power; the clock is asked beyond that.
        plateau_wh = self.clock.constant_up_to * self.energy_max_wh
        allowed = self.clock.constant_rate_per_h * self.energy_max_wh * hours
        charged = np.asarray(np.minimum(target, energy_wh + allowed))
        tapered = charged > np.maximum(energy_wh, plateau_wh)
        if np.any(tapered):
            charged[tapered] = self._tapered(self.clock, energy_wh, target, hours, tapered)
        return charged

    def _tapered(
        self,
        clock: ChargeClock,
        energy_wh: FloatArray,
        target_wh: FloatArray,
        hours: ArrayLike,
        mask: BoolArray,
    ) -> FloatArray:
        """Energy after charging where the limit may fall with the state of charge."""
        start, target, full, length = (
            v if np.ndim(v) == 0 else np.broadcast_to(v, mask.shape)[mask]
            for v in (np.asarray(energy_wh), target_wh, self.energy_max_wh, np.asarray(hours))
        )
        soc = np.minimum(start / full, 1.0)
        limited = clock.after(soc, length) * full
        # A round trip through the clock's table must not lose the last digits of a full battery.
        return np.maximum(np.minimum(target, limited), start)


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
    wanted = np.maximum(store.energy_max_wh - step.before_charge_wh, 0.0)
    share = wanted / np.maximum(stored, 1e-300)
    hours = (end - begin) * ramp_fraction(
        np.maximum(interval.left_w, 0.0), np.maximum(interval.right_w, 0.0), share
    )
    if store.clock is not None:
        soc = np.minimum(step.before_charge_wh / store.energy_max_wh, 1.0)
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
    way; ``paid_wh`` is the deficit since midnight that has been taken from the battery.
    """

    drained_wh: FloatArray
    before_charge_wh: FloatArray
    after_charge_wh: FloatArray
    paid_wh: FloatArray


@dataclass(frozen=True)
class ChargingDay:
    """A day reduced to the intervals in which batteries are charged; time is the first axis.

    Between two surpluses a battery only falls, to zero at the most, so the deficits in between are
    taken at once and exactly: nights are a single step. ``cumulative_wh`` is the deficit from
    midnight to every node. ``owed_wh`` is the deficit from midnight to the surplus of the interval,
    minus infinity where an element of the batch has no surplus there: the interval then changes
    nothing, so that what an element becomes does not depend on the others in the batch.
    """

    first: int
    hours: FloatArray
    surplus_wh: FloatArray
    owed_wh: FloatArray
    cumulative_wh: FloatArray

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
            owed_wh=owed,
            cumulative_wh=cumulative,
        )

    def select(self, cells: IntArray) -> ChargingDay:
        """Day of a part of the batch."""
        return replace(
            self,
            surplus_wh=self.surplus_wh[:, cells],
            owed_wh=self.owed_wh[:, cells],
            cumulative_wh=self.cumulative_wh[:, cells],
        )

    def charge(
        self, store: Store, energy_wh: FloatArray, paid_wh: ArrayLike = 0.0
    ) -> Iterator[Charging]:
        """March from midnight over the surpluses of the day."""
        eta = store.discharge_efficiency
        paid = np.asarray(paid_wh, float)
        for hours, surplus, owed in zip(self.hours, self.surplus_wh, self.owed_wh, strict=True):
            drained = energy_wh - np.maximum(owed - paid, 0.0) / eta
            before = np.maximum(drained, 0.0)
            energy_wh = store.charged(before, surplus, hours)
            paid = np.maximum(paid, owed)
            yield Charging(drained, before, energy_wh, paid)

    def midnight_wh(self, store: Store, energy_wh: FloatArray, paid_wh: ArrayLike) -> FloatArray:
        """Energy at the end of the day after the last surplus; below zero if it ran empty."""
        due = self.cumulative_wh[-1] - paid_wh
        return np.asarray(energy_wh - due / store.discharge_efficiency)

    def end_wh(self, store: Store, energy_wh: FloatArray) -> FloatArray:
        """Energy at the end of a day that starts with some energy [Wh]."""
        paid: ArrayLike = 0.0
        for step in self.charge(store, energy_wh):
            energy_wh, paid = step.after_charge_wh, step.paid_wh
        return np.maximum(self.midnight_wh(store, energy_wh, paid), 0.0)

    def run(self, store: Store, energy_wh: FloatArray) -> DayRun:
        """March a day and keep what becomes of the batteries."""
        before, after, paid = (np.empty_like(self.owed_wh) for _ in range(3))
        for k, step in enumerate(self.charge(store, energy_wh)):
            before[k], after[k], paid[k] = step[1:]
        return DayRun(self, store, energy_wh, before, after, paid)


@dataclass(frozen=True)
class DayRun:
    """What became of the batteries on a day: energy around every surplus [Wh]."""

    day: ChargingDay
    store: Store
    start_wh: FloatArray
    before_charge_wh: FloatArray
    after_charge_wh: FloatArray
    paid_wh: FloatArray

    @property
    def end_wh(self) -> FloatArray:
        """Energy at the end of the day [Wh]."""
        energy, paid = self.start_wh, np.zeros_like(self.start_wh)
        if len(self.after_charge_wh):
            energy, paid = self.after_charge_wh[-1], self.paid_wh[-1]
        return np.maximum(self.day.midnight_wh(self.store, energy, paid), 0.0)

    def select(self, cells: IntArray) -> DayRun:
        """Run of a part of the batch."""
        return DayRun(
            self.day.select(cells),
            self.store.select(cells),
            self.start_wh[cells],
            self.before_charge_wh[:, cells],
            self.after_charge_wh[:, cells],
            self.paid_wh[:, cells],
        )

    def restart(self, cells: IntArray, start_wh: FloatArray) -> None:
        """Change the initial energy of elements that are empty before their first surplus."""
        self.start_wh[cells] = start_wh
        waiting = np.maximum.accumulate(self.day.owed_wh[:, cells], axis=0) < 0.0
        for energy in (self.before_charge_wh, self.after_charge_wh):
            energy[:, cells] = np.where(waiting, start_wh, energy[:, cells])

    def replace_cells(self, cells: IntArray, other: DayRun) -> None:
        """Overwrite a part of the batch by another run."""
        self.start_wh[cells] = other.start_wh
        self.before_charge_wh[:, cells] = other.before_charge_wh
        self.after_charge_wh[:, cells] = other.after_charge_wh
        self.paid_wh[:, cells] = other.paid_wh

    def energy_at_nodes_wh(self) -> FloatArray:
        """Energy at every node of the time axis [Wh]."""
        held, paid = np.empty_like(self.day.cumulative_wh), np.zeros_like(self.day.cumulative_wh)
        begin, stop = self.day.first + 1, self.day.first + 1 + len(self.after_charge_wh)
        held[:begin] = self.start_wh
        held[begin:stop], paid[begin:stop] = self.after_charge_wh, self.paid_wh
        held[stop:], paid[stop:] = held[stop - 1], paid[stop - 1]
        return self._after_deficit(held, paid, self.day.cumulative_wh)

    def energy_at_node_wh(self, node: IntArray) -> FloatArray:
        """Energy at one node for every element of the batch [Wh]."""
        cells = np.arange(len(node))
        row = np.minimum(node - self.day.first, len(self.after_charge_wh)) - 1
        held, paid = self.start_wh.copy(), np.zeros_like(self.start_wh)
        some = cells[row >= 0]
        held[some] = self.after_charge_wh[row[some], some]
        paid[some] = self.paid_wh[row[some], some]
        return self._after_deficit(held, paid, self.day.cumulative_wh[node, cells])

    def _after_deficit(
        self, held_wh: FloatArray, paid_wh: FloatArray, cumulative_wh: FloatArray
    ) -> FloatArray:
        due = cumulative_wh - paid_wh
        return np.maximum(held_wh - due / self.store.discharge_efficiency, 0.0)


def final_energy_wh(balance: PowerBalance, store: Store, energy_wh: FloatArray) -> FloatArray:
    """Stored energy at the end of the time axis [Wh]."""
    shape = np.broadcast_shapes(balance.batch_shape, np.shape(energy_wh), store.energy_max_wh.shape)
    start = np.broadcast_to(np.asarray(energy_wh, float), shape)
    day = ChargingDay.of(balance.flat())
    return day.end_wh(_flat(store, shape), start.reshape(-1)).reshape(shape)


def periodic_energy_wh(balance: PowerBalance, store: Store) -> FloatArray:
    """Stored energy at the start of a cycle that repeats itself [Wh]."""
    shape = balance.batch_shape
    run = repeated_day(ChargingDay.of(balance.flat()), _flat(store, shape))
    return run.start_wh.reshape(shape)


def _flat(store: Store, shape: tuple[int, ...]) -> Store:
    return replace(store, energy_max_wh=store.spread(shape).energy_max_wh.reshape(-1))


def repeated_day(
    day: ChargingDay, store: Store, *, relative_tolerance: float = 1e-11
) -> DayRun:
    """Run of a day that ends with the energy it started with.

    The energy after a cycle never falls, and rises by at most as much, when that before it rises
    (a fuller battery is charged no faster), so there is one fixed point, and repeating the cycle
    from an empty battery leads to it. A cycle whose deficit exceeds all that could be stored
    passes through an empty battery, and from there one day leads to the fixed point. Any other
    cycle is marched from a full battery at nightfall; most fill it again within the day. The few
    that are left are marched once more and then bracketed, which does not need many cycles where
    a cycle's gain is small.
    """
    full, eta = store.energy_max_wh, store.discharge_efficiency
    deficit = day.cumulative_wh[-1]
    storable = store.charge_efficiency * sum_over_time(day.surplus_wh) * eta
    last_paid = np.maximum.reduce(day.owed_wh, axis=0, initial=0.0)
    full_at_nightfall = np.maximum(day.midnight_wh(store, full, last_paid), 0.0)
    run = day.run(store, np.where(storable < deficit, 0.0, full_at_nightfall))
    end = run.end_wh
    moved = np.flatnonzero(np.abs(end - run.start_wh) > relative_tolerance * full)
    if len(moved):
        first_owed = np.where(day.owed_wh[:, moved] < 0.0, np.inf, day.owed_wh[:, moved])
        empty_at = eta * np.maximum(run.start_wh[moved], end[moved])
        # From here and from there: empty before the first surplus, and from then on the same.
        alike = np.minimum.reduce(first_owed, axis=0, initial=np.inf) >= empty_at
        run.restart(moved[alike], end[moved[alike]])
        apart = moved[~alike]
        if len(apart):
            part, part_store = day.select(apart), store.select(apart)
            start = _fixed_point(part, part_store, end[apart], relative_tolerance)
            run.replace_cells(apart, part.run(part_store, start))
    return run


def _fixed_point(
    day: ChargingDay, store: Store, energy_wh: FloatArray, tolerance: float
) -> FloatArray:
    """Energy at the start of the repeated day, from an energy that is not below it."""
    result = energy_wh.copy()
    places = np.arange(len(result))
    limit = tolerance * store.energy_max_wh
    for _ in range(_PLAIN_CYCLES):
        found = day.select(places).end_wh(store.select(places), result[places])
        settled = np.abs(found - result[places]) <= limit[places]
        result[places] = found
        places = places[~settled]
        if not len(places):
            return result
    part, part_store = day.select(places), store.select(places)

    def gain(some: IntArray, energy: FloatArray) -> FloatArray:
        return part.select(some).end_wh(part_store.select(some), energy) - energy

    upper = result[places]
    result[places] = falling_root(gain, np.zeros_like(upper), upper, limit[places])
    return result
