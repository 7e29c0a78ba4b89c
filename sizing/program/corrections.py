"""What the simulator finds for a design and its neighbours, as data of the program.

A model of low fidelity is corrected by one of high fidelity until both agree (Alexandrov, Lewis,
Gumbert, Green and Newman 2001, J. Aircraft 38:1093): the program has the light and the load along
the day as the simulated flight of its last design has them, with their first derivatives by the
design from a batch of neighbours. Whatever the simulator knows of a design is in them: thermals,
the flow that cools the modules, the operating point of the propulsion.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sizing.energy.battery import Store
from sizing.energy.march import ChargingDay
from sizing.energy.power_balance import PowerBalance
from sizing.program.transcription import INTERVALS
from solar.types import FloatArray, IntArray

STEP = 1e-3  # of a neighbour, in the program's variable


class Day(NamedTuple):
    """Powers of a scenario over a day that begins at its sunrise; the batch first, time last."""

    time_h: FloatArray
    solar_w: FloatArray
    load_w: FloatArray

    @classmethod
    def of(cls, time_h: FloatArray, solar_w: FloatArray, load_w: FloatArray) -> Day:
        """The same day, begun at sunrise; without a night where the sun is lowest."""
        steps = len(time_h) - 1
        lit = (solar_w[0, :-1] > 0.0) | (solar_w[0, 1:] > 0.0)
        first = int(np.argmin(solar_w[0, :-1]))
        if lit.any() and not lit.all():
            first = int(np.flatnonzero(lit & ~np.roll(lit, 1))[0])
        at = (first + np.arange(steps + 1)) % steps
        hours = np.diff(time_h)[at[:-1]]
        clock = time_h[first] + np.concatenate([[0.0], np.cumsum(hours)])
        return cls(clock, solar_w[:, at], load_w[:, at])

    def path(self, store: Store, soc: float) -> FloatArray:
        """State of charge of the first of the batch over the day, from one at its begin."""
        full = np.asarray(store.battery_energy_wh, float).reshape(1)
        balance = PowerBalance.of(self.time_h, self.solar_w[:1], self.load_w[:1])
        run = ChargingDay.of(balance).run(store, soc * full)
        return run.energy_at_nodes_wh()[:, 0] / full[0]


def equal_power_step(day: Day, nominal_w: float) -> int:
    """Step of a day at which the sun carries the nominal load for the first time; 0 if never."""
    carried = day.solar_w[0] >= nominal_w
    return int(np.argmax(carried)) if carried.any() and not carried.all() else 0


def nodes_of(
    day: Day, path: FloatArray, into: float, full_wh: float, nominal_w: float
) -> IntArray:
    """Ends of the intervals on the time axis of a day.

    They lie where light begins and ends, where power is equal, and where the charge limit begins
    to hold back; the rest halve the longest interval of light, again and again.
    """
    steps = len(day.time_h) - 1
    net, solar = day.solar_w[0] - day.load_w[0], day.solar_w[0]
    light = (solar[:-1] > 0.0) | (solar[1:] > 0.0)
    turns = np.flatnonzero((net[:-1] > 0.0) != (net[1:] > 0.0))
    turns = turns + (np.abs(net[turns + 1]) < np.abs(net[turns]))
    surplus = into * _positive_part(net[:-1], net[1:]) * np.diff(day.time_h)
    held = (surplus > 0.0) & (full_wh * np.diff(path) < 0.999 * surplus)
    throttled = np.flatnonzero(held[1:] != held[:-1]) + 1
    edges = np.flatnonzero(light[1:] != light[:-1]) + 1
    nodes = {0, steps, equal_power_step(day, nominal_w)}
    for some in (edges, turns, throttled):
        if len(nodes) + len(some) <= INTERVALS // 2:
            nodes |= {int(one) for one in some}
    ends = sorted(nodes)
    near = np.convolve(held, np.ones(13), "same") > 0.0  # within half an hour
    weight = np.where(light, np.where(near, 1.0, 0.2), 1e-3) if light.any() else np.ones(steps)
    length = np.concatenate([[0.0], np.cumsum(weight)])
    while len(ends) < INTERVALS + 1:
        spans = np.where(np.diff(ends) > 1, np.diff(length[ends]), -1.0)
        i = int(np.argmax(spans))
        ends.insert(i + 1, (ends[i] + ends[i + 1]) // 2)
    return np.asarray(ends)


def _positive_part(left: FloatArray, right: FloatArray) -> FloatArray:
    """Mean positive part of what is linear over a step."""
    up = np.maximum(left, 0.0) + np.maximum(right, 0.0)
    both = np.abs(left) + np.abs(right)
    return up * up / np.where(both > 0.0, 2.0 * both, 1.0)


class DayMeans(NamedTuple):
    """Light and load over the intervals; arrays with the intervals last.

    ``light_w``: mean power of the modules. ``load_w``: mean load with which the lesser of what is
    charged and drawn from the mean powers is what the flight charges and draws in the interval.
    """

    hours: FloatArray
    light_w: FloatArray
    load_w: FloatArray


def day_means(
    day: Day, nodes: IntArray, path: FloatArray, full_wh: float, into: float, out_of: float
) -> DayMeans:
    """Means over intervals.

    Where the charge limit holds back a part of an interval, or a full battery, what is stored is
    that of the ``path``; where it does so all the time the program's own row says it.
    """
    h = np.diff(day.time_h)
    net, solar = day.solar_w - day.load_w, day.solar_w
    surplus = _positive_part(net[:, :-1], net[:, 1:])
    deficit = _positive_part(-net[:, :-1], -net[:, 1:])
    stored = (into * surplus - deficit / out_of) * h
    light = (solar[:, :-1] + solar[:, 1:]) / 2.0 * h
    gain, sun = (np.add.reduceat(values, nodes[:-1], axis=-1) for values in (stored, light))
    hours = np.diff(day.time_h[nodes])
    equal = np.where(gain > 0.0, gain / into, gain * out_of)
    return DayMeans(hours, sun / hours, (sun - equal) / hours)
