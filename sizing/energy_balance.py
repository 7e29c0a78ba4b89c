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
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sizing.battery import Battery, ChargeClock

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


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

    def select(self, mask: BoolArray) -> Store:
        """Store of a part of a one-dimensional batch."""
        return Store(
            self.energy_max_wh[mask],
            self.charge_efficiency,
            self.discharge_efficiency,
            self.clock,
        )

    def charged(
        self, energy_wh: FloatArray, surplus_wh: FloatArray, hours: ArrayLike
    ) -> FloatArray:
        """Stored energy after charging from a surplus for some hours [Wh]."""
        if not np.any(surplus_wh):
            return energy_wh
        target = np.minimum(energy_wh + self.charge_efficiency * surplus_wh, self.energy_max_wh)
        if self.clock is None:
            return target
        soc = np.minimum(energy_wh / self.energy_max_wh, 1.0)
        limited = self.clock.after(soc, hours) * self.energy_max_wh
        # A round trip through the clock's table must not lose the last digits of a full battery.
        return np.maximum(np.minimum(target, limited), energy_wh)


# Cycles marched before the remaining cells are bracketed, and rounds of that at most.
_PLAIN_CYCLES = 3
_MAXIMUM_ROUNDS = 100


def positive_part_wh(left_w: FloatArray, right_w: FloatArray, hours: ArrayLike) -> FloatArray:
    """Integral of the positive part of a power that is linear over an interval [Wh].

    One expression for all four combinations of signs: with ``a, b`` the positive parts at the
    ends, ``(a + b)^2 / (2 (|left| + |right|))`` per hour.
    """
    positive = np.maximum(left_w, 0.0) + np.maximum(right_w, 0.0)
    total = np.abs(left_w) + np.abs(right_w)
    return np.asarray(positive * positive / np.maximum(2.0 * total, 1e-300) * hours)


def crossing_fraction(left: FloatArray, right: FloatArray) -> FloatArray:
    """Where a linear function from ``left`` to ``right`` is zero, as a fraction of the interval."""
    drop = left - right
    safe = np.where(drop == 0.0, 1.0, drop)
    return np.clip(left / safe, 0.0, 1.0)


def ramp_fraction(left: FloatArray, right: FloatArray, share: FloatArray) -> FloatArray:
    """Where the integral of a linear, non-negative power reaches a share of its interval's whole.

    ``left`` and ``right`` are the power at the ends; the result is a fraction of the interval.
    """
    total = left + right
    goal = np.clip(share, 0.0, 1.0) * total / 2.0
    # left s + (right - left) s^2 / 2 = goal, solved without cancellation.
    root = np.sqrt(np.maximum(left * left + 2.0 * (right - left) * goal, 0.0))
    return np.clip(2.0 * goal / np.maximum(left + root, 1e-300), 0.0, 1.0)


class Interval(NamedTuple):
    """Flows of one interval of the time axis, per element of the batch.

    An interval has up to three phases: an early deficit, a surplus, a late deficit; at most one
    deficit is not zero.
    """

    number: int
    start_h: float
    hours: float | FloatArray
    left_w: FloatArray
    right_w: FloatArray
    surplus_wh: FloatArray
    early_deficit_wh: FloatArray
    late_deficit_wh: FloatArray


class Step(NamedTuple):
    """Stored energy at the start, before and after charging and at the end of an interval."""

    interval: Interval
    start_wh: FloatArray
    before_charge_wh: FloatArray
    after_charge_wh: FloatArray
    end_wh: FloatArray
    unserved_wh: FloatArray


@dataclass(frozen=True)
class PowerBalance:
    """Net power on a time axis and its exact integrals per interval; time is the first axis."""

    time_h: FloatArray
    net_w: FloatArray
    surplus_wh: FloatArray
    early_deficit_wh: FloatArray
    late_deficit_wh: FloatArray

    @classmethod
    def of(cls, time_h: FloatArray, solar_power_w: FloatArray, load_w: FloatArray) -> PowerBalance:
        """Balance of solar power and load, arrays of shape ``(..., time)``.

        Raises
        ------
        ValueError
            If time does not increase or the last axis is not the time.
        """
        hours = np.diff(time_h)
        if np.any(hours <= 0.0):
            raise ValueError("time_h must increase strictly")
        net = np.asarray(solar_power_w, float) - np.asarray(load_w, float)
        if net.shape[-1] != len(time_h):
            raise ValueError(f"the last axis has length {net.shape[-1]}, time has {len(time_h)}")
        net = np.ascontiguousarray(np.moveaxis(net, -1, 0))
        column = hours.reshape((-1,) + (1,) * (net.ndim - 1))
        deficit = positive_part_wh(-net[:-1], -net[1:], column)
        early = np.where(net[:-1] < 0.0, deficit, 0.0)
        return cls(
            time_h=np.asarray(time_h, float),
            net_w=net,
            surplus_wh=positive_part_wh(net[:-1], net[1:], column),
            early_deficit_wh=early,
            late_deficit_wh=deficit - early,
        )

    @property
    def deficit_wh(self) -> FloatArray:
        """Deficit of every interval [Wh], time first."""
        return self.early_deficit_wh + self.late_deficit_wh

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Shape of the batch."""
        return self.net_w.shape[1:]

    def select(self, mask: BoolArray) -> PowerBalance:
        """Balance of a part of a one-dimensional batch."""
        return PowerBalance(
            self.time_h,
            self.net_w[:, mask],
            self.surplus_wh[:, mask],
            self.early_deficit_wh[:, mask],
            self.late_deficit_wh[:, mask],
        )

    def intervals(self) -> Iterator[Interval]:
        """Walk the time axis interval by interval."""
        hours = np.diff(self.time_h)
        for k in range(len(hours)):
            yield Interval(
                number=k,
                start_h=float(self.time_h[k]),
                hours=float(hours[k]),
                left_w=self.net_w[k],
                right_w=self.net_w[k + 1],
                surplus_wh=self.surplus_wh[k],
                early_deficit_wh=self.early_deficit_wh[k],
                late_deficit_wh=self.late_deficit_wh[k],
            )


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


def surplus_phase_h(interval: Interval) -> tuple[FloatArray, FloatArray]:
    """Begin and end of the surplus within an interval, in hours after its start."""
    crossing = interval.hours * crossing_fraction(interval.left_w, interval.right_w)
    begin = np.where(interval.left_w < 0.0, crossing, 0.0)
    end = np.where(interval.right_w < 0.0, crossing, interval.hours)
    return begin, end


def empty_after_h(step: Step) -> FloatArray:
    """Hours after an interval's start at which the battery runs empty.

    Meaningful only where the step leaves a part of the load unserved.
    """
    begin, length = _deficit_phase_h(step.interval)
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
    _, length = _deficit_phase_h(step.interval)
    hours = length * (1.0 - _served_fraction(step))
    return np.where(step.unserved_wh > 0.0, hours, 0.0)


def _deficit_phase_h(interval: Interval) -> tuple[FloatArray, FloatArray]:
    """Begin and length of the deficit within an interval [h]."""
    surplus_begin, surplus_end = surplus_phase_h(interval)
    early = interval.left_w < 0.0
    whole = early & (interval.right_w < 0.0)
    begin = np.where(early, 0.0, surplus_end)
    length = np.where(early, surplus_begin, interval.hours - surplus_end)
    return begin, np.where(whole, interval.hours, length)


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


def final_energy_wh(balance: PowerBalance, store: Store, energy_wh: FloatArray) -> FloatArray:
    """Stored energy at the end of the time axis [Wh]."""
    for step in march(balance, store, energy_wh):
        energy_wh = step.end_wh
    return energy_wh


def periodic_energy_wh(
    balance: PowerBalance, store: Store, *, relative_tolerance: float = 1e-11
) -> FloatArray:
    """Stored energy at the start of a cycle that repeats itself [Wh].

    The energy after a cycle never falls, and rises by at most as much, when that before it rises
    (a fuller battery is charged no faster), so there is one fixed point, and repeating the cycle
    from an empty battery leads to it. It is found by bracketing instead (Illinois variant of the
    false position), which does not need many cycles where a cycle's gain is small.
    """
    shape = balance.batch_shape
    energy_max = np.broadcast_to(store.energy_max_wh, shape)
    flat = PowerBalance(
        balance.time_h,
        balance.net_w.reshape(len(balance.time_h), -1),
        balance.surplus_wh.reshape(len(balance.time_h) - 1, -1),
        balance.early_deficit_wh.reshape(len(balance.time_h) - 1, -1),
        balance.late_deficit_wh.reshape(len(balance.time_h) - 1, -1),
    )
    flat_store = Store(
        energy_max.reshape(-1).copy(),
        store.charge_efficiency,
        store.discharge_efficiency,
        store.clock,
    )
    return _fixed_point(flat, flat_store, relative_tolerance).reshape(shape)


def _fixed_point(balance: PowerBalance, store: Store, tolerance: float) -> FloatArray:
    # A few cycles from full settle all cells whose battery is filled or emptied every day.
    result = final_energy_wh(balance, store, store.energy_max_wh).copy()
    open_cells = np.ones(result.shape, bool)
    for _ in range(_PLAIN_CYCLES):
        part, part_store = balance.select(open_cells), store.select(open_cells)
        found = final_energy_wh(part, part_store, result[open_cells])
        settled = np.abs(found - result[open_cells]) <= tolerance * part_store.energy_max_wh
        result[open_cells] = found
        open_cells[open_cells] = ~settled
        if not np.any(open_cells):
            return result
    part, part_store = balance.select(open_cells), store.select(open_cells)
    result[open_cells] = _bracketed(part, part_store, result[open_cells], tolerance)
    return result


def _bracketed(
    balance: PowerBalance, store: Store, upper: FloatArray, tolerance: float
) -> FloatArray:
    """Root of the cycle's gain on ``[0, upper]``, where it is positive at 0 and negative above."""
    lower = np.zeros_like(upper)
    lower_gain = final_energy_wh(balance, store, lower)
    rising = lower_gain > tolerance * store.energy_max_wh
    result = np.where(rising, upper, lower)
    work = _Bracket(
        place=np.arange(len(upper)),
        lower=lower,
        upper=upper,
        lower_gain=lower_gain,
        upper_gain=final_energy_wh(balance, store, upper) - upper,
        side=np.zeros(len(upper)),
    ).select(rising)
    for _ in range(_MAXIMUM_ROUNDS):
        if not len(work.place):
            break
        mask = np.zeros(upper.shape, bool)
        mask[work.place] = True
        limit = tolerance * store.energy_max_wh[work.place]
        trial = work.trial()
        gain = final_energy_wh(balance.select(mask), store.select(mask), trial) - trial
        result[work.place] = trial
        work = work.narrowed(trial, gain)
        work = work.select((np.abs(gain) > limit) & (work.upper - work.lower > limit))
    return result


@dataclass(frozen=True)
class _Bracket:
    """Brackets of the cells that are still searched; ``place`` is their index in the batch."""

    place: NDArray[np.intp]
    lower: FloatArray
    upper: FloatArray
    lower_gain: FloatArray
    upper_gain: FloatArray
    side: FloatArray

    def select(self, mask: BoolArray) -> _Bracket:
        """Brackets of a part of the cells."""
        return _Bracket(
            self.place[mask],
            self.lower[mask],
            self.upper[mask],
            self.lower_gain[mask],
            self.upper_gain[mask],
            self.side[mask],
        )

    def trial(self) -> FloatArray:
        """Zero of the straight line through both ends."""
        slope = np.where(
            self.upper_gain == self.lower_gain, -1.0, self.upper_gain - self.lower_gain
        )
        point = self.lower - self.lower_gain * (self.upper - self.lower) / slope
        return np.clip(point, self.lower, self.upper)

    def narrowed(self, trial: FloatArray, gain: FloatArray) -> _Bracket:
        """Bracket with one end moved; an end kept twice counts half (Illinois)."""
        rises = gain > 0.0
        side = np.where(rises, 1.0, -1.0)
        again = side == self.side
        kept_lower = np.where(again & ~rises, self.lower_gain / 2.0, self.lower_gain)
        kept_upper = np.where(again & rises, self.upper_gain / 2.0, self.upper_gain)
        return _Bracket(
            self.place,
            np.where(rises, trial, self.lower),
            np.where(rises, self.upper, trial),
            np.where(rises, gain, kept_lower),
            np.where(rises, kept_upper, gain),
            side,
        )
