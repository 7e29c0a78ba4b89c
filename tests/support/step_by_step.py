"""A battery marched interval by interval: no night is a single step, and no day is skipped."""

from typing import NamedTuple

import numpy as np

from sizing.day.balance import Interval, PowerBalance
from solar.types import FloatArray


class Step(NamedTuple):
    """Stored energy at the start, around charging and at the end of an interval [Wh]."""

    interval: Interval
    start_wh: FloatArray
    before_charge_wh: FloatArray
    after_charge_wh: FloatArray
    end_wh: FloatArray
    unserved_wh: FloatArray

    def empty_after_h(self):
        """Hours after the interval's start at which the battery runs empty, if it does."""
        return self.interval.deficit_parts_h(self.unserved_wh)[0]

    def unserved_h(self):
        """Hours of the interval in which the load cannot be met."""
        hours = self.interval.deficit_parts_h(self.unserved_wh)[1]
        return np.where(self.unserved_wh > 0.0, hours, 0.0)


def advance(store, interval, energy_wh):
    """Early deficit, surplus, late deficit; no energy falls below zero."""
    eta = store.discharge_efficiency
    early_wh = np.where(interval.left_w < 0.0, interval.deficit_wh, 0.0)
    drained = energy_wh - early_wh / eta
    before = np.maximum(drained, 0.0)
    after = store.charged(before, interval.surplus_wh, interval.hours)
    left_over = after - (interval.deficit_wh - early_wh) / eta
    end = np.maximum(left_over, 0.0)
    return Step(interval, energy_wh, before, after, end, eta * (before - drained + end - left_over))


def intervals(balance):
    """Intervals of all elements, one after the other."""
    cells = np.arange(balance.net_w.shape[1])
    for k in range(len(balance.time_h) - 1):
        yield balance.interval(np.full(len(cells), k), cells)


def march(balance, store, energy_wh):
    """March from the first node over the whole time axis."""
    for interval in intervals(balance):
        step = advance(store, interval, energy_wh)
        yield step
        energy_wh = step.end_wh


def balance_of(time_h, solar_w, load_w):
    """Balance of powers whose last axis is the time, the batch laid out flat."""
    net_w = np.asarray(solar_w, float) - np.asarray(load_w, float)
    return PowerBalance.of(time_h, np.moveaxis(net_w, -1, 0).reshape(net_w.shape[-1], -1))
