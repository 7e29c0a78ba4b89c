"""Metrics of one day of the year repeated for ever: the cycle.

Definitions (times in solar hours):

* ``equal_power_morning_h``, ``equal_power_evening_h``: first and last instant at which solar power
  equals the nominal load (the load without the extra power of thermals by day).
* ``excess_time_h``: the energy left at the morning's equal power, once the cycle repeats itself,
  would keep the aircraft up for so many more hours without any sun. Where the battery runs empty,
  it is minus the hours of the cycle in which the load cannot be met. Infinite where solar power
  never falls below the load.
* ``minimum_state_of_charge``: of the converged cycle; 0 where the battery runs empty.
* ``charge_margin_h``: from the first full charge to the last instant of full charge; 0 where full
  charge is not reached.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sizing.energy_balance import (
    BoolArray,
    FloatArray,
    PowerBalance,
    Step,
    Store,
    crossing_fraction,
    full_after_h,
    march,
    periodic_energy_wh,
    surplus_phase_h,
    unserved_h,
)

IntArray = NDArray[np.intp]

_FULL = 1.0 - 1e-9  # of the capacity: what the clock's table resolves


class Status(IntEnum):
    """How a cycle ends; the values are flags of gridded results."""

    limited = 0
    perpetual = 1
    always_lit = 2
    never_lit = 3


@dataclass(frozen=True)
class EnergyAccount:
    """Where the energy of one cycle goes [Wh]; arrays of the batch.

    ``solar + unserved = load + stored + charge_loss + discharge_loss + curtailed``.
    """

    solar_wh: FloatArray
    load_wh: FloatArray
    unserved_wh: FloatArray
    stored_wh: FloatArray
    charge_loss_wh: FloatArray
    discharge_loss_wh: FloatArray
    curtailed_wh: FloatArray


@dataclass(frozen=True)
class Cycle:
    """Metrics of a batch of converged cycles; times are solar hours, undefined ones are NaN."""

    status: FloatArray
    excess_time_h: FloatArray
    minimum_state_of_charge: FloatArray
    charge_margin_h: FloatArray
    equal_power_morning_h: FloatArray
    equal_power_evening_h: FloatArray
    full_charge_h: FloatArray
    missing_h: FloatArray
    account: EnergyAccount
    time_h: FloatArray
    energy_wh: FloatArray

    @property
    def perpetual(self) -> BoolArray:
        """Mark the cycles that repeat for ever."""
        return np.isin(self.status, (Status.perpetual, Status.always_lit))


@dataclass(frozen=True)
class EqualPower:
    """Instants of equal power and where they lie on the time axis."""

    morning_h: FloatArray
    evening_h: FloatArray
    morning_index: IntArray
    morning_fraction: FloatArray
    always_above: BoolArray
    never_above: BoolArray


def equal_power(time_h: FloatArray, net_w: FloatArray) -> EqualPower:
    """First rise and last fall of the net power through zero; time is the first axis.

    Where there is no such instant the time is NaN: the power is then always, or never, enough.
    """
    left, right = net_w[:-1], net_w[1:]
    rises = (left < 0.0) & (right >= 0.0)
    falls = (left >= 0.0) & (right < 0.0)
    first_rise = np.argmax(rises, axis=0)
    last_fall = len(rises) - 1 - np.argmax(falls[::-1], axis=0)
    rise_fraction = _fraction_at(first_rise, left, right)
    morning = _time_at(time_h, first_rise, rise_fraction)
    evening = _time_at(time_h, last_fall, _fraction_at(last_fall, left, right))
    return EqualPower(
        morning_h=np.where(rises.any(axis=0), morning, np.nan),
        evening_h=np.where(falls.any(axis=0), evening, np.nan),
        morning_index=first_rise,
        morning_fraction=rise_fraction,
        always_above=np.asarray((net_w >= 0.0).all(axis=0)),
        never_above=np.asarray((net_w <= 0.0).all(axis=0)),
    )


def _fraction_at(index: IntArray, left: FloatArray, right: FloatArray) -> FloatArray:
    pick = index[np.newaxis]
    return crossing_fraction(
        np.take_along_axis(left, pick, axis=0)[0], np.take_along_axis(right, pick, axis=0)[0]
    )


def _time_at(time_h: FloatArray, index: IntArray, fraction: FloatArray) -> FloatArray:
    return np.asarray(time_h[index] + fraction * (time_h[index + 1] - time_h[index]))


def simulate_cycle(
    time_h: ArrayLike,
    solar_power_w: ArrayLike,
    load_w: ArrayLike,
    store: Store,
    *,
    nominal_load_w: ArrayLike | None = None,
) -> Cycle:
    """Converge the cycle of a batch and measure it.

    Parameters
    ----------
    time_h : array_like, shape (time,)
        Nodes over one day, 0 to 24 [h], both ends included.
    solar_power_w : array_like, shape (..., time)
        Electric power of the modules [W].
    load_w : array_like
        Power that the aircraft draws [W], broadcasting with ``solar_power_w``.
    store : Store
        Batteries; ``energy_max_wh`` broadcasts with the batch ``...``.
    nominal_load_w : array_like, shape (...), optional
        Load that defines equal power and excess time [W]; the smallest load of the day if omitted.

    Returns
    -------
    Cycle
        Arrays of shape ``...``; ``energy_wh`` has a last axis of ``time``.
    """
    time = np.asarray(time_h, float)
    solar, load = np.broadcast_arrays(np.asarray(solar_power_w, float), np.asarray(load_w, float))
    nominal = np.min(load, axis=-1) if nominal_load_w is None else np.asarray(nominal_load_w, float)
    batch = np.broadcast_shapes(solar.shape[:-1], nominal.shape, np.shape(store.energy_max_wh))
    solar = np.broadcast_to(solar, (*batch, len(time)))
    load = np.broadcast_to(load, (*batch, len(time)))
    nominal = np.broadcast_to(nominal, batch)
    balance = PowerBalance.of(time, solar, load)
    energy_max = np.broadcast_to(store.energy_max_wh, batch)
    full_store = Store(energy_max, store.charge_efficiency, store.discharge_efficiency, store.clock)
    equal = equal_power(time, np.moveaxis(solar - nominal[..., np.newaxis], -1, 0))
    meter = _Meter(balance, full_store, equal)
    for step in march(balance, full_store, periodic_energy_wh(balance, full_store)):
        meter.record(step)
    return meter.cycle(solar, load, nominal)


class _Meter:
    """Collects the metrics while the converged cycle is marched once."""

    def __init__(self, balance: PowerBalance, store: Store, equal: EqualPower) -> None:
        shape = balance.batch_shape
        self.balance, self.store, self.equal = balance, store, equal
        self.energy = np.empty((len(balance.time_h), *shape))
        self.lowest = np.full(shape, np.inf)
        self.dawn = np.zeros(shape)
        self.first_full = np.full(shape, np.nan)
        self.last_full = np.full(shape, np.nan)
        self.missing = np.zeros(shape)
        self.unserved = np.zeros(shape)
        self.into_store = np.zeros(shape)
        self.surplus = np.zeros(shape)

    def record(self, step: Step) -> None:
        k = step.interval.number
        self.energy[k] = step.start_wh
        self.energy[k + 1] = step.end_wh
        self.lowest = np.minimum(self.lowest, np.minimum(step.before_charge_wh, step.end_wh))
        self.into_store = self.into_store + step.after_charge_wh - step.before_charge_wh
        self.surplus = self.surplus + step.interval.surplus_wh
        self._record_dawn(step)
        self._record_full(step)
        self._record_missing(step)

    def _record_dawn(self, step: Step) -> None:
        here = self.equal.morning_index == step.interval.number
        if not np.any(here):
            return
        left, right = step.interval.left_w, step.interval.right_w
        fraction = self.equal.morning_fraction
        middle = left + (right - left) * fraction
        mean_deficit_w = np.maximum(-(left + middle) / 2.0, 0.0)
        drained = mean_deficit_w * fraction * step.interval.hours / self.store.discharge_efficiency
        at_dawn = np.maximum(step.start_wh - drained, 0.0)
        self.dawn = np.where(here, at_dawn, self.dawn)

    def _record_full(self, step: Step) -> None:
        limit = _FULL * self.store.energy_max_wh
        full = (step.after_charge_wh >= limit) & (step.interval.surplus_wh > 0.0)
        if not np.any(full):
            return
        newly = full & np.isnan(self.first_full)
        clock_h = step.interval.start_h
        arrival = clock_h + full_after_h(step, self.store)
        self.first_full = np.where(newly, arrival, self.first_full)
        _, end = surplus_phase_h(step.interval)
        self.last_full = np.where(full, clock_h + end, self.last_full)

    def _record_missing(self, step: Step) -> None:
        if not np.any(step.unserved_wh > 0.0):
            return
        self.missing = self.missing + unserved_h(step)
        self.unserved = self.unserved + step.unserved_wh

    def cycle(self, solar_w: FloatArray, load_w: FloatArray, nominal_w: FloatArray) -> Cycle:
        """Metrics after the whole cycle has been recorded."""
        store, time = self.store, self.balance.time_h
        lit = self.equal.always_above
        # A last digit of unserved energy may be left by the fixed point's tolerance.
        starved = self.unserved > 1e-9 * store.energy_max_wh
        with np.errstate(divide="ignore", invalid="ignore"):
            surplus_h = np.where(
                nominal_w > 0.0, self.dawn * store.discharge_efficiency / nominal_w, np.inf
            )
        dark = np.isnan(self.equal.morning_h) & ~lit
        excess = np.where(starved | dark, -self.missing, surplus_h)
        excess = np.where(lit & ~starved, np.inf, excess)
        status = np.where(excess > 0.0, Status.perpetual, Status.limited)
        status = np.where(lit & ~starved, Status.always_lit, status)
        status = np.where(~np.any(solar_w > 0.0, axis=-1), Status.never_lit, status)
        lowest = self.lowest / store.energy_max_wh
        margin = np.where(np.isnan(self.first_full), 0.0, self.last_full - self.first_full)
        return Cycle(
            status=status,
            excess_time_h=excess,
            minimum_state_of_charge=np.where(excess > 0.0, lowest, 0.0),
            charge_margin_h=margin,
            equal_power_morning_h=self.equal.morning_h,
            equal_power_evening_h=self.equal.evening_h,
            full_charge_h=self.first_full,
            missing_h=self.missing,
            account=self._account(solar_w, load_w),
            time_h=time,
            energy_wh=np.moveaxis(self.energy, 0, -1),
        )

    def _account(self, solar_w: FloatArray, load_w: FloatArray) -> EnergyAccount:
        store, time = self.store, self.balance.time_h
        drawn = self.into_store - (self.energy[-1] - self.energy[0])
        taken = self.into_store / store.charge_efficiency
        return EnergyAccount(
            solar_wh=np.asarray(np.trapezoid(solar_w, time, axis=-1)),
            load_wh=np.asarray(np.trapezoid(load_w, time, axis=-1)),
            unserved_wh=self.unserved,
            stored_wh=self.energy[-1] - self.energy[0],
            charge_loss_wh=taken - self.into_store,
            discharge_loss_wh=drawn * (1.0 - store.discharge_efficiency),
            curtailed_wh=self.surplus - taken,
        )
