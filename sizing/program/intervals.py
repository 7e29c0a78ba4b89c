"""Intervals of a day in the sizing program, with mean light and load over them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sizing.day.balance import PowerBalance, positive_part_wh
from sizing.day.battery import Store
from sizing.day.march import ChargingDay
from sizing.program.transcription import Form, lagrange
from solar.types import BoolArray, FloatArray, IntArray

# Weights in the length of an interval, where steps within a quarter of an hour of those in which
# the battery holds back count as 1: little bends the charge by light, and nothing by night; heights
# bend all day.
_CLIMBING = 0.2
_FAR = 0.03
_DARK = 1e-3
_ROUNDING = 1e-9  # of a state of charge


class Day(NamedTuple):
    """Powers of a scenario over a day that begins at its sunrise, or from launch to landing.

    The batch first, time last. ``first``: node of the time axis that it begins at.
    """

    time_h: FloatArray
    solar_w: FloatArray
    load_w: FloatArray
    first: int
    lands: bool = False

    @classmethod
    def of(
        cls, time_h: FloatArray, solar_w: FloatArray, load_w: FloatArray, first: int | None = None
    ) -> Day:
        """Return the same day, begun at sunrise; without a night where the sun is lowest.

        ``first``: step that it begins with instead.
        """
        steps = len(time_h) - 1
        bright = (solar_w[0, :-1] > 0.0) | (solar_w[0, 1:] > 0.0)
        if first is None:
            first = int(np.argmin(solar_w[0, :-1]))
            if bright.any() and not bright.all():
                first = int(np.flatnonzero(bright & ~np.roll(bright, 1))[0])
        at = (first + np.arange(steps + 1)) % steps
        hours = np.diff(time_h)[at[:-1]]
        clock = time_h[first] + np.concatenate([[0.0], np.cumsum(hours)])
        return cls(clock, solar_w[:, at], load_w[:, at], first)

    @classmethod
    def between(
        cls,
        ends_h: FloatArray,
        time_h: FloatArray,
        solar_w: FloatArray,
        load_w: FloatArray,
        *,
        least_steps: int = 1,
    ) -> Day:
        """Return the flight from a launch to a landing; steps of a short one are divided evenly."""
        inside = time_h[(time_h > ends_h[0]) & (time_h < ends_h[1])]
        clock = np.concatenate([ends_h[:1], inside, ends_h[1:]])
        steps = len(clock) - 1
        if steps < least_steps:
            parts = math.ceil(least_steps / steps)
            places = np.arange(parts * steps + 1) / parts
            clock = np.interp(places, np.arange(steps + 1), clock)
        solar, load = (
            np.stack([np.interp(clock, time_h, row) for row in power])
            for power in (solar_w, load_w)
        )
        return cls(clock, solar, load, 0, lands=True)

    def stored_wh(self, into: float, out_of: float) -> FloatArray:
        """Return what every step puts into a battery that takes all, or takes from it [Wh]."""
        net_w, hours = self.solar_w - self.load_w, np.diff(self.time_h)
        surplus = positive_part_wh(net_w[:, :-1], net_w[:, 1:], hours)
        return into * surplus - positive_part_wh(-net_w[:, :-1], -net_w[:, 1:], hours) / out_of

    def path(self, store: Store, soc: float) -> FloatArray:
        """Return the state of charge of the batch's first over the day, from its begin on."""
        full = np.asarray(store.battery_energy_wh, float).reshape(1)
        balance = PowerBalance.of(self.time_h, (self.solar_w[:1] - self.load_w[:1]).T)
        run = ChargingDay.of(balance).run(store, soc * full)
        return np.asarray(run.energy_at_nodes_wh()[:, 0] / full[0])


def deficit_wh(day: Day, until: int | None = None) -> float:
    """Return what the load of the first of a batch takes beyond the light, to a step [Wh]."""
    net_w, hours = (day.load_w - day.solar_w)[0], np.diff(day.time_h)
    return float(positive_part_wh(net_w[:-1], net_w[1:], hours)[:until].sum())


def equal_power_step(day: Day, nominal_w: float) -> int:
    """Return the first step of a day at which the sun carries the nominal load; 0 if none."""
    carried = day.solar_w[0] >= nominal_w
    return int(np.argmax(carried)) if carried.any() and not carried.all() else 0


def nodes_of(
    day: Day,
    path: FloatArray,
    stored_wh: FloatArray,
    full_wh: float,
    nominal_w: float,
    form: Form,
    close: BoolArray | bool = False,
) -> IntArray:
    """Return the ends of the intervals on the time axis of a day.

    They lie where light begins and ends, where power is equal, and around the steps in which the
    battery begins and ceases to hold back; the rest halve the longest interval of light, again and
    again, of climbs those of night as well. They are close near these, and in some steps.
    ``stored_wh``: what every step puts into a battery that takes all.
    """
    steps = len(day.time_h) - 1
    net, solar = day.solar_w[0] - day.load_w[0], day.solar_w[0]
    light = (solar[:-1] > 0.0) | (solar[1:] > 0.0)
    edges = np.flatnonzero(light[1:] != light[:-1]) + 1
    turns = np.flatnonzero((net[:-1] > 0.0) != (net[1:] > 0.0))
    turns = turns + (np.abs(net[turns + 1]) < np.abs(net[turns]))
    held = (stored_wh > 0.0) & (full_wh * np.diff(path) < 0.999 * stored_wh)
    changes = np.flatnonzero(held[1:] != held[:-1]) + 1
    # In the step itself the battery holds back for a part.
    changes = np.concatenate([changes, changes + np.where(held[changes], 1, -1)])
    nodes = {0, steps, equal_power_step(day, nominal_w)}
    for steps_there in (edges, turns, changes):
        if len(nodes) + len(steps_there) <= form.intervals:
            nodes |= set(steps_there.tolist())
    ends = sorted(nodes)
    half_an_hour = min(round(0.5 / float(np.diff(day.time_h).max())) + 1, steps)
    near = (np.convolve(held, np.ones(half_an_hour), "same") > 0.0) | close
    elsewhere = _CLIMBING if form.climbs else np.where(light, _FAR, _DARK)
    weight = np.where(near, 1.0, elsewhere) if light.any() else np.ones(steps)
    length = np.concatenate([[0.0], np.cumsum(weight)])
    while len(ends) < form.intervals + 1:
        spans = np.where(np.diff(ends) > 1, np.diff(length[ends]), -1.0)
        i = int(np.argmax(spans))
        ends.insert(i + 1, (ends[i] + ends[i + 1]) // 2)
    return np.asarray(ends)


class DayMeans(NamedTuple):
    """Light and load over the intervals; arrays with the intervals last.

    ``light_w``: mean power of the modules. ``load_w``: mean load with which the lesser of what is
    charged and drawn from the mean powers is what the flight charges and draws in the interval.
    """

    hours: FloatArray
    light_w: FloatArray
    load_w: FloatArray


def mean_light_w(day: Day, nodes: IntArray) -> FloatArray:
    """Return the mean power of the modules over the intervals of a day [W]."""
    light_wh = (day.solar_w[:, :-1] + day.solar_w[:, 1:]) / 2.0 * np.diff(day.time_h)
    return np.asarray(np.add.reduceat(light_wh, nodes[:-1], axis=-1) / np.diff(day.time_h[nodes]))


class CutDay(NamedTuple):
    """A simulated day that is cut into the intervals of a program.

    Arrays of the nodes, of a batch's first: ``nodes`` on the time axis, ``clock_h`` solar time,
    ``soc`` state of charge, ``share`` height over the way to the ceiling, ``reserve`` whether the
    excess time must be left, ``least_wh`` charge that must be left, as it is lower beside the node.
    ``means``: over the intervals, of the whole batch.
    """

    nodes: IntArray
    clock_h: FloatArray
    soc: FloatArray
    share: FloatArray
    reserve: BoolArray
    least_wh: FloatArray
    means: DayMeans

    @classmethod
    def of(
        cls,
        day: Day,
        path: FloatArray,
        store: Store,
        nominal_w: float,
        form: Form,
        share: FloatArray,
        nodes: IntArray | None = None,
    ) -> CutDay:
        """Cut a day at the nodes that suit it, or at those that are known.

        ``path``, ``share``: state of charge and height along it. ``store``: battery of the first.
        """
        into, out_of = efficiencies(store)
        stored_wh = day.stored_wh(into, out_of)
        if nodes is None:
            # A glide bends as the light does, and is short where nothing feeds it.
            light_w = day.solar_w[0, :-1]
            dim = (light_w > 0.0) & (light_w < nominal_w)
            close = ((np.diff(share) < 0.0) | dim) & form.climbs
            full_wh = float(store.battery_energy_wh[0])
            nodes = nodes_of(day, path, stored_wh[0], full_wh, nominal_w, form, close)
        reserve = np.zeros(len(nodes), bool)
        if day.lands:
            reserve[-1] = True
        else:  # up to equal power
            reserve[: 2 + np.argmin(np.abs(nodes - equal_power_step(day, nominal_w)))] = True
        gain_wh = np.add.reduceat(stored_wh, nodes[:-1], axis=-1)
        light_w, hours = mean_light_w(day, nodes), np.diff(day.time_h[nodes])
        net_w = np.where(gain_wh > 0.0, gain_wh / into, gain_wh * out_of) / hours
        return cls(
            nodes,
            day.time_h[nodes],
            path[nodes],
            share[nodes],
            reserve,
            dips_wh(stored_wh[0], nodes),
            DayMeans(hours, light_w, light_w - net_w),
        )


def efficiencies(store: Store) -> tuple[float, float]:
    """Return the charge and the discharge efficiency of batteries that share them."""
    values = store.charge_efficiency, store.discharge_efficiency
    into, out_of = (float(np.ravel(value)[0]) for value in values)
    return into, out_of


def dips_wh(stored_wh: FloatArray, nodes: IntArray) -> FloatArray:
    """Return by how much the charge of a flight is lower beside each node than there.

    Where the sun begins to carry a flight, or a climb begins, it is least within an interval.
    """
    charge = np.concatenate([[0.0], np.cumsum(stored_wh)])
    least = np.minimum.reduceat(charge, nodes[:-1])
    dips = np.maximum(np.minimum(charge[nodes[:-1]], charge[nodes[1:]]) - least, 0.0)
    return np.asarray(np.maximum(np.append(dips, 0.0), np.append(0.0, dips)))


class Held(NamedTuple):
    """How a battery holds back what a flight charges; arrays with the intervals last.

    ``limit_h``: hours for which the charge limit charges, less than those of the interval where
    that is in part. ``turned_away_w``: power that is not taken, where the power charges for most of
    it. ``most``: highest state of charge at the nodes: below 1 where a full battery gives some back
    before the node.
    """

    limit_h: FloatArray
    turned_away_w: FloatArray
    most: FloatArray

    @classmethod
    def nowhere(cls, hours: FloatArray) -> Held:
        """Return that of a battery that takes all it is given."""
        return cls(hours, np.zeros(len(hours)), np.ones(len(hours) + 1))


def held_back(store: Store, soc: FloatArray, means: DayMeans) -> Held:
    """Return how a battery holds back what the batch's first charges.

    ``soc``: its state of charge at the nodes. With this the rows of the program hold for its
    flight as equations, and the nearest of power, limit and capacity tells how they change.
    """
    hours = means.hours
    full_wh, gained = store.battery_energy_wh[0], np.diff(soc)
    into, out_of = efficiencies(store)
    surplus_w = (means.light_w - means.load_w)[0]
    by_power = np.where(surplus_w > 0.0, into * surplus_w, surplus_w / out_of) * hours / full_wh
    limited = store.clock.after(soc[:-1], hours)
    most = np.minimum(by_power, limited - soc[:-1])
    in_part = (gained < most - _ROUNDING) & (soc[1:] < 1.0 - _ROUNDING)
    is_full = in_part & (limited > 1.0 - _ROUNDING)
    of_power = in_part & ~is_full & ((most == by_power) | (gained <= 0.0))
    of_limit = in_part & ~is_full & ~of_power
    power_w = full_wh * np.where(gained > 0.0, gained / into, gained * out_of) / hours
    return Held(
        np.where(of_limit, -np.diff(store.clock.hours_to_full(soc)), hours),
        np.where(of_power, surplus_w - power_w, 0.0),
        np.append(1.0, np.where(is_full, soc[1:], 1.0)),
    )


def light_at_heights(
    at_heights: Day, nodes: IntArray, share: FloatArray, light: FloatArray
) -> FloatArray:
    """Return the light at all heights of a program over the intervals, ``(height, interval)``.

    ``at_heights``: powers there. ``light``: of the flight, ``share`` of the way at the nodes, with
    which it agrees.
    """
    known = mean_light_w(at_heights, nodes)
    weights = np.stack(lagrange((share[1:] + share[:-1]) / 2.0, len(known)))
    mean = np.sum(weights * known, axis=0)
    bright = mean > 0.0
    return np.asarray(known * np.where(bright, light / np.where(bright, mean, 1.0), 1.0))
