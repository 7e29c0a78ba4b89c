"""Powers and batteries of a batch, laid out for the march: time first, then all elements."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from sizing.day.balance import PowerBalance
from sizing.day.battery import Store
from solar.types import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Cells:
    """Powers [W] and batteries of a one-dimensional batch; time is the first axis.

    ``flown``: which intervals are flown; None for all of them.
    """

    time_h: FloatArray
    solar_w: FloatArray
    load_w: FloatArray
    nominal_w: FloatArray
    store: Store
    flown: BoolArray | None = None

    @classmethod
    def of(
        cls,
        time_h: ArrayLike,
        solar_power_w: ArrayLike,
        load_w: ArrayLike,
        store: Store,
        nominal_load_w: ArrayLike | None,
    ) -> tuple[Cells, tuple[int, ...]]:
        """Batch laid out flat, time first and then one axis of elements, and its shape.

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
        solar, load = (_time_first(np.broadcast_to(v, (*batch, len(time)))) for v in (solar, load))
        flat_nominal = np.broadcast_to(nominal, batch).reshape(-1)
        return cls(time, solar, load, flat_nominal, store.flat(batch)), batch

    def select(self, some: IntArray | slice) -> Cells:
        """Part of the batch."""
        return Cells(
            self.time_h,
            self.solar_w[:, some],
            self.load_w[:, some],
            self.nominal_w[some],
            self.store.select(some),
        )

    @cached_property
    def balance(self) -> PowerBalance:
        """Surplus and deficit of every interval."""
        balance = PowerBalance.of(self.time_h, self.solar_w - self.load_w)
        if self.flown is None:
            return balance
        surplus, deficit = (
            np.where(self.flown, v, 0.0) for v in (balance.surplus_wh, balance.deficit_wh)
        )
        return replace(balance, surplus_wh=surplus, deficit_wh=deficit)

    def flown_between(self, launch_h: FloatArray, land_h: FloatArray) -> Cells:
        """Same batch, each in flight from its launch to its landing, which become nodes."""
        time = np.unique(np.concatenate([self.time_h, launch_h, land_h]))
        before = np.clip(np.searchsorted(self.time_h, time, "right") - 1, 0, len(self.time_h) - 2)
        share = (time - self.time_h[before]) / np.diff(self.time_h)[before]
        solar, load = (
            power[before] + share[:, np.newaxis] * (power[before + 1] - power[before])
            for power in (self.solar_w, self.load_w)
        )
        flown = (time[:-1, np.newaxis] >= launch_h) & (time[1:, np.newaxis] <= land_h)
        return Cells(time, solar, load, self.nominal_w, self.store, flown)

    def above_nominal_w(self) -> FloatArray:
        """Solar power less the nominal load."""
        steady = self.load_w[:1] if self.load_w.strides[0] == 0 else self.load_w
        if np.array_equal(steady, np.broadcast_to(self.nominal_w, steady.shape)):
            return self.balance.net_w
        return self.solar_w - self.nominal_w


def _time_first(values: FloatArray) -> FloatArray:
    """Time on the first axis, the whole batch on a second."""
    return np.moveaxis(values, -1, 0).reshape(values.shape[-1], -1)
