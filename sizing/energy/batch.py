"""Batch of designs and scenarios, laid out for the march: time first, then one axis of elements."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from sizing.energy.battery import Store
from sizing.energy.march import ChargingDay
from sizing.energy.power_balance import PowerBalance
from solar.types import FloatArray, IntArray


@dataclass(frozen=True)
class Cells:
    """Powers [W] and batteries of a one-dimensional batch; time is the first axis."""

    time_h: FloatArray
    solar_w: FloatArray
    load_w: FloatArray
    nominal_w: FloatArray
    store: Store

    @classmethod
    def of(
        cls,
        time_h: ArrayLike,
        solar_power_w: ArrayLike,
        load_w: ArrayLike,
        store: Store,
        nominal_load_w: ArrayLike | None,
    ) -> tuple[Cells, tuple[int, ...]]:
        """Batch laid out flat, and its shape.

        ``time_h``, ``solar_power_w``, ``load_w``, ``store``, ``nominal_load_w``: as for
        :func:`sizing.energy.cycle.simulate_cycle`. Returns shape of the batch.
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
        return PowerBalance.of(self.time_h, self.solar_w.T, self.load_w.T)

    @property
    def day(self) -> ChargingDay:
        """Day reduced to the intervals in which batteries are charged."""
        return ChargingDay.of(self.balance)

    def above_nominal_w(self) -> FloatArray:
        """Solar power less the nominal load."""
        steady = self.load_w[:1] if self.load_w.strides[0] == 0 else self.load_w
        if np.array_equal(steady, np.broadcast_to(self.nominal_w, steady.shape)):
            return self.balance.net_w
        return self.solar_w - self.nominal_w


def _time_first(values: FloatArray) -> FloatArray:
    """Time on the first axis, the whole batch on a second."""
    return np.moveaxis(values, -1, 0).reshape(values.shape[-1], -1)
