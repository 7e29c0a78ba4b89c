"""Net power over the time axis and its exact integrals over every interval.

Solar power and load are piecewise linear between the nodes of the time axis; surplus and deficit
of every interval are integrated exactly, a change of sign inside an interval included. The axis is
a day, the days of a record or a calendar; the batch is designs, scenarios or days. It is laid out
for the march: time first, then one axis of elements.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from sizing.day.battery import Store
from solar.types import BoolArray, FloatArray, IntArray

_LEAST = 1e-300  # keeps zero over zero at zero


def positive_part_wh(left_w: FloatArray, right_w: FloatArray, hours: ArrayLike) -> FloatArray:
    """Return the integral of the positive part of a power that is linear over an interval [Wh].

    One expression for all four combinations of signs: with ``a, b`` the positive parts at the
    ends, ``(a + b)^2 / (2 (|left| + |right|))`` per hour. Arguments broadcast.
    """
    positive = np.maximum(left_w, 0.0) + np.maximum(right_w, 0.0)
    total = np.abs(left_w) + np.abs(right_w)
    mean_w = positive * positive / np.maximum(2.0 * total, _LEAST)
    return np.asarray(mean_w * np.asarray(hours, float))


def crossing_fraction(left: FloatArray, right: FloatArray) -> FloatArray:
    """Return where a linear function is zero, as a fraction of the interval [-].

    ``left / (left - right)`` of its values at the ends, the nearer end where signs are equal.
    """
    fall = left - right
    return np.clip(left / np.where(fall == 0.0, 1.0, fall), 0.0, 1.0)


def ramp_fraction(left: FloatArray, right: FloatArray, share: FloatArray) -> FloatArray:
    """Return where the integral of a linear, non-negative power reaches a share of the whole [-].

    Powers are those at the ends of the interval [W]; returns a fraction of it.
    """
    total = left + right
    goal = np.clip(share, 0.0, 1.0) * total / 2.0
    # left s + (right - left) s^2 / 2 = goal, solved without cancellation.
    root = np.sqrt(np.maximum(left * left + 2.0 * (right - left) * goal, 0.0))
    return np.clip(2.0 * goal / np.maximum(left + root, 1e-300), 0.0, 1.0)


class Interval(NamedTuple):
    """Intervals of the time axis, each of one element of the batch.

    An interval has up to three phases: an early deficit, a surplus, a late deficit; at most one
    deficit is not zero.
    """

    start_h: FloatArray
    hours: FloatArray
    left_w: FloatArray
    right_w: FloatArray
    surplus_wh: FloatArray
    deficit_wh: FloatArray

    def surplus_h(self) -> tuple[FloatArray, FloatArray]:
        """Return begin and end of the surplus, in hours after the interval's start."""
        crossing = self.hours * crossing_fraction(self.left_w, self.right_w)
        begin = np.where(self.left_w < 0.0, crossing, 0.0)
        return begin, np.where(self.right_w < 0.0, crossing, self.hours)

    def deficit_h(self) -> tuple[FloatArray, FloatArray]:
        """Return begin and length of the deficit [h]."""
        surplus_begin, surplus_end = self.surplus_h()
        early = self.left_w < 0.0
        length = np.where(early, surplus_begin, self.hours - surplus_end)
        whole = early & (self.right_w < 0.0)
        return np.where(early, 0.0, surplus_end), np.where(whole, self.hours, length)

    def deficit_parts_h(self, unserved_wh: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the hours from the start until a battery is empty, and of deficit from then.

        ``unserved_wh``: end of the deficit, which the battery cannot meet [Wh]; of all of it where
        it is the whole.
        """
        served = 1.0 - unserved_wh / np.maximum(self.deficit_wh, _LEAST)
        left_w, right_w = np.maximum(-self.left_w, 0.0), np.maximum(-self.right_w, 0.0)
        share = ramp_fraction(left_w, right_w, served)
        begin, length = self.deficit_h()
        return np.asarray(begin + length * share), np.asarray(length * (1.0 - share))


@dataclass(frozen=True)
class PowerBalance:
    """Net power along a time axis and its exact integrals per interval, ``(time, element)``."""

    time_h: FloatArray
    net_w: FloatArray
    surplus_wh: FloatArray
    deficit_wh: FloatArray

    @classmethod
    def of(cls, time_h: FloatArray, net_w: FloatArray) -> PowerBalance:
        """Return the balance of solar power less load at the nodes of time, its first axis."""
        time, net = np.asarray(time_h, float), np.ascontiguousarray(net_w, float)
        hours = np.diff(time)
        if np.any(hours <= 0.0):
            raise ValueError("time_h must increase strictly")
        if len(net) != len(time):
            raise ValueError(f"the time axis of the power has length {len(net)}, not {len(time)}")
        gain_wh = net[:-1] + net[1:]
        gain_wh *= hours[:, np.newaxis] / 2.0
        surplus = np.maximum(gain_wh, 0.0)
        deficit = np.subtract(surplus, gain_wh, out=gain_wh)  # in place: memory takes the time
        below = net < 0.0
        row, cell = np.divmod(np.flatnonzero(below[:-1] != below[1:]), net.shape[1])
        left, right = net[row, cell], net[row + 1, cell]  # of intervals in which the sign changes
        surplus[row, cell] = positive_part_wh(left, right, hours[row])
        deficit[row, cell] = positive_part_wh(-left, -right, hours[row])
        return cls(time_h=time, net_w=net, surplus_wh=surplus, deficit_wh=deficit)

    def interval(self, number: IntArray, cells: IntArray) -> Interval:
        """Return intervals by number, each of one element."""
        return Interval(
            self.time_h[number],
            self.time_h[number + 1] - self.time_h[number],
            self.net_w[number, cells],
            self.net_w[number + 1, cells],
            self.surplus_wh[number, cells],
            self.deficit_wh[number, cells],
        )

    def cumulative_deficit_h(self) -> FloatArray:
        """Return the length of all deficits until every node [h], ``(time, element)``."""
        has_deficit = self.deficit_wh > 0.0
        mixed = np.flatnonzero(has_deficit & (self.surplus_wh > 0.0))
        row, cell = np.divmod(mixed, has_deficit.shape[1])
        of_mixed = self.interval(row, cell).deficit_h()[1]
        ends = np.searchsorted(row, np.arange(len(has_deficit) + 1))
        sums = np.zeros((len(has_deficit) + 1, has_deficit.shape[1]))
        for k, hours in enumerate(np.diff(self.time_h)):
            lengths = np.multiply(has_deficit[k], hours, out=sums[k + 1])
            here = slice(ends[k], ends[k + 1])
            lengths[cell[here]] = of_mixed[here]
            lengths += sums[k]
        return sums


def blocks(count: int, size: int) -> Iterator[slice]:
    """Return slices of a batch, so short that intermediate results stay near the processor.

    The last may reach beyond the batch; an empty batch is one empty block.
    """
    for start in range(0, max(count, 1), size):
        yield slice(start, start + size)


def sum_over_time(values: FloatArray) -> FloatArray:
    """Return the sum over the first axis of a two-dimensional array, in the order of time.

    NumPy adds up many contiguous columns row by row but a lone column pairwise; a running sum
    makes the last digit of an element independent of how many others are computed with it.
    """
    values = np.ascontiguousarray(values)
    if values.shape[1] == 1 and len(values):
        return np.asarray(np.cumsum(values, axis=0)[-1])
    return np.asarray(np.add.reduce(values, axis=0))


def running_sum(values: FloatArray) -> FloatArray:
    """Return sums over the first axis from the start to every node, a row more than ``values``."""
    sums = np.zeros((len(values) + 1, *values.shape[1:]))
    for k in range(len(values)):
        np.add(sums[k], values[k], out=sums[k + 1])
    return sums


def interval_reaching(sums: FloatArray, level: FloatArray, cells: IntArray) -> IntArray:
    """Return the intervals in which running sums reach levels, each in its column, by bisection.

    ``sums``: shape ``(node, column)``; they do not fall from node to node. ``cells``: the column of
    each level. An interval has the number of the last node, the final one excepted, whose sum is at
    most the level; 0 if there is none.
    """
    low = np.zeros(level.shape, np.intp)
    high = np.full(level.shape, len(sums) - 1)
    for _ in range(len(sums).bit_length()):
        middle = (low + high) // 2
        reached = sums[middle, cells] <= level
        low, high = np.where(reached, middle, low), np.where(reached, high, middle)
    return low


@dataclass(frozen=True)
class Cells:
    """Powers [W] and batteries of a one-dimensional batch; time is the first axis.

    ``in_flight``: which intervals are; None for all of them.
    """

    time_h: FloatArray
    solar_w: FloatArray
    load_w: FloatArray
    nominal_w: FloatArray
    store: Store
    in_flight: BoolArray | None = None

    @classmethod
    def of(
        cls,
        time_h: ArrayLike,
        solar_power_w: ArrayLike,
        load_w: ArrayLike,
        store: Store,
        nominal_load_w: ArrayLike | None,
    ) -> tuple[Cells, tuple[int, ...]]:
        """Return a batch laid out flat, time first and then one axis of elements, and its shape.

        ``time_h``, ``solar_power_w``, ``load_w``, ``store``, ``nominal_load_w``: as for
        :func:`sizing.day.cycle.simulate_cycle`. Returns shape of the batch.
        """
        time = np.asarray(time_h, float)
        solar, load = np.broadcast_arrays(
            np.asarray(solar_power_w, float), np.asarray(load_w, float)
        )
        nominal = (
            np.min(load, axis=-1) if nominal_load_w is None else np.asarray(nominal_load_w, float)
        )
        batch = np.broadcast_shapes(solar.shape[:-1], nominal.shape, store.battery_energy_wh.shape)
        solar, load = (
            np.moveaxis(np.broadcast_to(power_w, (*batch, len(time))), -1, 0).reshape(len(time), -1)
            for power_w in (solar, load)
        )
        flat_nominal = np.broadcast_to(nominal, batch).reshape(-1)
        return cls(time, solar, load, flat_nominal, store.flat(batch)), batch

    def select(self, cells: IntArray | slice) -> Cells:
        """Return a part of the batch."""
        return Cells(
            self.time_h,
            self.solar_w[:, cells],
            self.load_w[:, cells],
            self.nominal_w[cells],
            self.store.select(cells),
        )

    @cached_property
    def balance(self) -> PowerBalance:
        """Return surplus and deficit of every interval."""
        balance = PowerBalance.of(self.time_h, self.solar_w - self.load_w)
        parts = self.of_flight(balance.surplus_wh), self.of_flight(balance.deficit_wh)
        return replace(balance, surplus_wh=parts[0], deficit_wh=parts[1])

    def of_flight(self, values: FloatArray) -> FloatArray:
        """Return values of intervals, zero where an element is not in flight."""
        return values if self.in_flight is None else np.where(self.in_flight, values, 0.0)

    def between(self, launch_h: FloatArray, land_h: FloatArray) -> Cells:
        """Return the batch in flight from launches to landings, which become nodes."""
        time = np.unique(np.concatenate([self.time_h, launch_h, land_h]))
        before = np.clip(np.searchsorted(self.time_h, time, "right") - 1, 0, len(self.time_h) - 2)
        share = (time - self.time_h[before]) / np.diff(self.time_h)[before]
        solar, load = (
            power[before] + share[:, np.newaxis] * (power[before + 1] - power[before])
            for power in (self.solar_w, self.load_w)
        )
        in_flight = (time[:-1, np.newaxis] >= launch_h) & (time[1:, np.newaxis] <= land_h)
        return Cells(time, solar, load, self.nominal_w, self.store, in_flight)
