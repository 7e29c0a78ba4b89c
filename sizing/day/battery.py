"""Batteries of a batch for a march, and their charge limit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from sizing.battery.battery import (
    Battery,
    ChargeLimit,
    NoChargeLimit,
    TableChargeLimit,
    charge_rate_per_h,
    constant_up_to,
)
from solar.types import BoolArray, FloatArray, IntArray

# Fine enough that integrating 1/rate over it by the trapezoidal rule errs by less than 1e-6 h.
_TABLE_POINTS = 4001
_UNLIMITED_PER_H = 1e12


@dataclass(frozen=True)
class ChargeClock:
    """State of charge over time by the charge limit alone.

    ``hours[i]`` is the time the limit needs from empty to ``state_of_charge[i]``. Because the
    limit depends on nothing but the state of charge, following it for a while is a shift along
    this clock: exact for any step length. Up to ``constant_up_to`` the rate is constant and no
    table is needed: so it is for a battery that is not limited, at a rate beyond any power.
    """

    state_of_charge: FloatArray
    hours: FloatArray
    constant_up_to: float
    constant_rate_per_h: float
    limit: ChargeLimit

    @classmethod
    def of(cls, limit: ChargeLimit) -> ChargeClock:
        """Return the clock of a limit."""
        if isinstance(limit, NoChargeLimit):
            return cls(np.array([0.0, 1.0]), np.zeros(2), 1.0, _UNLIMITED_PER_H, limit)
        soc = np.linspace(0.0, 1.0, _TABLE_POINTS)
        if isinstance(limit, TableChargeLimit):
            soc = np.array(sorted({*soc.tolist(), *limit.state_of_charge}))
        slowness = 1.0 / charge_rate_per_h(limit, soc)
        hours = np.concatenate(
            ([0.0], np.cumsum(np.diff(soc) * (slowness[1:] + slowness[:-1]) / 2.0))
        )
        rate = float(charge_rate_per_h(limit, 0.0))
        return cls(soc, hours, constant_up_to(limit), rate, limit)

    def after(self, state_of_charge: FloatArray, duration_h: ArrayLike) -> FloatArray:
        """Return the state of charge after following the limit for a duration, at most 1 [-]."""
        start_h = np.interp(state_of_charge, self.state_of_charge, self.hours)
        end_h = np.asarray(start_h + np.asarray(duration_h, float))
        return np.asarray(np.interp(end_h, self.hours, self.state_of_charge))

    def hours_to_full(self, state_of_charge: FloatArray) -> FloatArray:
        """Return the hours that the limit alone needs to full charge."""
        return np.asarray(
            self.hours[-1] - np.interp(state_of_charge, self.state_of_charge, self.hours)
        )


@dataclass(frozen=True)
class Store:
    """Batteries of a batch that differ in size alone.

    ``charge_efficiency``, ``discharge_efficiency``: stored over surplus, and delivered over drawn
    energy [-]. ``clock``: the charge limit.
    """

    battery_energy_wh: FloatArray
    charge_efficiency: float | FloatArray
    discharge_efficiency: float | FloatArray
    clock: ChargeClock

    @classmethod
    def of(cls, battery: Battery, battery_energy_wh: ArrayLike | None = None) -> Store:
        """Return the store of a battery, or of a batch that differs from it in size alone.

        ``battery_energy_wh``: at full charge, of every element; that of the battery by default.
        """
        energy = battery.battery_energy_wh if battery_energy_wh is None else battery_energy_wh
        return cls(
            battery_energy_wh=np.asarray(energy, float),
            charge_efficiency=battery.mean_charge_efficiency,
            discharge_efficiency=battery.mean_discharge_efficiency,
            clock=ChargeClock.of(battery.charge_limit),
        )

    def flat(self, shape: tuple[int, ...]) -> Store:
        """Return the store of every element of a batch of a shape, as a batch of one dimension."""
        return self._with(lambda values: np.broadcast_to(values, shape).reshape(-1))

    def select(self, cells: IntArray | BoolArray | slice) -> Store:
        """Return the store of a part of a one-dimensional batch."""
        return self._with(lambda values: values[cells])

    def _with(self, pick: Callable[[FloatArray], FloatArray]) -> Store:
        """Return the store of picked elements; an efficiency that all share stays a number."""
        full_wh = self.battery_energy_wh
        charge, discharge = (
            pick(np.broadcast_to(value, full_wh.shape)) if np.ndim(value) else value
            for value in (self.charge_efficiency, self.discharge_efficiency)
        )
        return Store(pick(full_wh), charge, discharge, self.clock)

    def charged(
        self, energy_wh: FloatArray, surplus_wh: FloatArray, hours: ArrayLike
    ) -> FloatArray:
        """Return the stored energy after charging from a surplus, at most that of full charge [Wh].

        ``energy_wh``: stored at the start. ``surplus_wh``: over all ``hours``.
        """
        target = np.minimum(energy_wh + self.charge_efficiency * surplus_wh, self.battery_energy_wh)
        if not np.count_nonzero(target > energy_wh):
            return np.asarray(target)
        # While the limit is constant it adds a constant power; beyond, the clock gives the time.
        allowed = energy_wh + self._constant_limit_w * np.asarray(hours, float)
        charged = np.asarray(np.minimum(target, allowed))
        tapered = charged > np.maximum(energy_wh, self._constant_up_to_wh)
        at = tapered.reshape(-1).nonzero()[0]
        if len(at):
            full, start, goal, duration = (
                _pick(v, tapered, at) for v in (self.battery_energy_wh, energy_wh, target, hours)
            )
            limited = self.clock.after(start / full, duration) * full
            # A round trip through the clock's table must not lose the last digits of a full one.
            charged.reshape(-1)[at] = np.maximum(np.minimum(goal, limited), start)
        return charged

    @cached_property
    def _constant_limit_w(self) -> FloatArray:
        """Return the charge limit of an empty battery in stored power [W]."""
        return self.battery_energy_wh * self.clock.constant_rate_per_h

    @cached_property
    def _constant_up_to_wh(self) -> FloatArray:
        """Return the energy up to which the charge limit is constant [Wh]."""
        return self.battery_energy_wh * self.clock.constant_up_to


def _pick(values: ArrayLike, like: BoolArray, at: IntArray) -> FloatArray:
    """Return values of an array, in the shape of another, at flat places."""
    array = np.asarray(values, float)
    if array.ndim == like.ndim == 1 and len(array) == len(like):
        return array.take(at)
    if array.ndim and array.shape != like.shape:
        array = np.broadcast_to(array, like.shape)
    return array.reshape(-1).take(at) if array.ndim else array
