"""Longest flights with battery and potential-energy storage.

A flight is launched at the lowest altitude with a full battery; it climbs and glides as
:mod:`sizing.altitude.climb_cycle` says, and ends where the battery cannot give what is lacking. It
is marched from node to node of the day's axis. Which launches are tried, and how the best is
found, :mod:`sizing.energy.endurance` says: a launch by surplus is still never the best, since the
same flight may begin when the surplus begins, and is higher by then.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import ClassVar

import numpy as np

from sizing.altitude.climb_chain import Place
from sizing.altitude.climb_levels import FlightLevels
from sizing.altitude.climb_march import March, Strategy, at_nodes
from sizing.altitude.climb_run import Moves, Power, Stored
from sizing.energy.battery import Store
from sizing.energy.endurance import HOURS_PER_DAY, Course, Flights, FlownDay, Flying
from sizing.energy.power_balance import ramp_fraction
from solar.types import BoolArray, FloatArray, IntArray

_SHORT = 1e-12  # of the battery's energy: what lacks of a load that is met but for rounding


@dataclass(frozen=True)
class ClimbFlights(Flights):
    """Flights with climbs; before the launch lie steps of the day.

    ``balance`` is that of level flight at the lowest altitude.
    """

    march: March
    deficit_wh: FloatArray

    # A march takes nearly as long for one flight as for a hundred: few rounds, many tries in each.
    launches: ClassVar[int] = 24
    refinements: ClassVar[int] = 3
    closer: ClassVar[int] = 8
    at_once: ClassVar[int] = 512

    @classmethod
    def of(
        cls, time_h: FloatArray, levels: FlightLevels, store: Store, strategy: Strategy
    ) -> ClimbFlights:
        """Flights of elements in the light of their repeated day."""
        return cls.over(March(time_h, levels, store, strategy, 1))

    @classmethod
    def over(cls, march: March) -> ClimbFlights:
        """Flights on the days of a march from node to node."""
        balance, zero = march.floor_balance(), np.zeros((1, march.count))
        deficit_wh = np.concatenate([zero, np.cumsum(balance.deficit_wh, axis=0)])
        return cls(balance, march.store, march, deficit_wh)

    def launched(self, cells: IntArray, launch_h: FloatArray) -> Flying:
        """Aircraft on the first day, in the state of the node at which their march begins.

        A launch by a deficit begins at the node before it, with as much beyond a full battery as
        the deficit until the launch takes; after a surplus at the node behind it. By a surplus it
        begins at the nearest node.
        """
        time, net_w = self.balance.time_h, self.balance.net_w
        number = np.clip(np.searchsorted(time, launch_h, side="right") - 1, 0, len(time) - 2)
        full, eta = (
            np.broadcast_to(one, self.store.battery_energy_wh.shape)[cells]
            for one in (self.store.battery_energy_wh, self.store.discharge_efficiency)
        )
        until = self.deficit_until_wh(self.deficit_wh, launch_h, cells)
        before = until - self.deficit_wh[number, cells]
        after = self.deficit_wh[number + 1, cells] - until
        early, late = net_w[number, cells] < 0.0, before > 0.0
        energy = np.where(early, full + before / eta, full)
        energy = np.where(~early & late, np.maximum(full - after / eta, 0.0), energy)
        nearest = launch_h - time[number] > (time[number + 1] - time[number]) / 2.0
        behind = ~early & (late | nearest)
        return Flying.of(cells, energy, (number + behind).astype(float))

    def flown_day(self, flying: Flying) -> FlownDay:
        """One more day of flights."""
        return flown_day(self.march.select(flying.cell), flying)

    def course(self, cell: int, launch_h: float, hours: float) -> Course:
        """Flight of one element, as :meth:`sizing.performance.Performance.flight` returns it."""
        cells, end_h = np.array([cell]), launch_h + hours
        march, flying = self.march.select(cells), self.launched(cells, np.array([launch_h]))
        stored = Stored(flying.energy_wh, flying.potential_wh)
        first: IntArray | None = flying.before_launch.astype(int)
        parts = []
        for day in range(ceil(end_h / HOURS_PER_DAY)):
            run = march.empty_run()
            stored = march.end_of_day(stored, run, first)
            load = run.motor_wh / march.hours + march.levels.constant_power_w
            columns = (
                at_nodes(run.power.solar_w)[0],
                np.append(load[:, 0], load[-1, 0]),
                run.energy_wh[:, 0] / march.store.battery_energy_wh[0],
                march.levels.altitude_at(run.potential_wh.T)[0],
            )
            parts.append((march.node_h + HOURS_PER_DAY * day, *columns))
            first = None
        time_h, *values = (np.concatenate(one) for one in zip(*parts, strict=True))
        inside = (time_h > launch_h) & (time_h < end_h)
        clock_h = np.unique(np.concatenate([[launch_h], time_h[inside], [end_h]]))
        solar, load_w, charge, altitude_m = (np.interp(clock_h, time_h, one) for one in values)
        charge = np.minimum(charge, 1.0)
        charge[0] = 1.0  # at the node before it is more
        charge[np.logical_or.accumulate(charge <= 0.0)] = 0.0  # it has come down
        return Course(clock_h, solar, load_w, charge, altitude_m)


def flown_day(march: March, flying: Flying) -> FlownDay:
    """One more day of flights, each an element of a march from node to node."""
    first = flying.before_launch.astype(int)
    watch = _Watch(march, first)
    stored = Stored(flying.energy_wh, flying.potential_wh)
    end = march.end_of_day(stored, watch, first if first.any() else None)
    return FlownDay(watch.end_h, *end, np.minimum(watch.lowest_wh, end.battery_wh))


class _Watch:
    """Where flights of a day end, and the least energy of their batteries [Wh]."""

    def __init__(self, march: March, first: IntArray) -> None:
        self.march, self.first = march, first
        self.least_wh = _SHORT * march.store.battery_energy_wh
        self.end_h = np.full(march.count, np.nan)
        self.lowest_wh = np.full(march.count, np.inf)

    def keep(self, number: int, moves: Moves, power: Power | None, place: Place | None) -> None:
        """See what a step lacks."""
        flies = self.first <= number
        for drawn in (moves.first, moves.second):
            if drawn is None:
                continue
            lowest = np.minimum(self.lowest_wh, drawn.end.battery_wh)
            self.lowest_wh = np.where(flies, lowest, self.lowest_wh)
            self._ends(
                flies & (drawn.unserved_wh > self.least_wh), number, drawn.unserved_wh, power
            )

    def discharge(
        self, steps: slice, stored: Stored, used_wh: FloatArray, eta: float | FloatArray
    ) -> None:
        """See what steps on the battery alone lack."""
        left_wh = stored.battery_wh - used_wh
        self.lowest_wh = np.minimum(self.lowest_wh, np.maximum(left_wh[-1], 0.0))
        short = left_wh < -self.least_wh
        if not short[-1].any():
            return
        number = steps.start + np.argmax(short, axis=0)
        for step in np.unique(number[short[-1]]):
            lacking = -left_wh[step - steps.start] * eta
            self._ends(short[-1] & (number == step), int(step), lacking, None)

    def _ends(
        self, which: BoolArray, number: int, lacking: FloatArray, power: Power | None
    ) -> None:
        """Flights of which a step lacks some energy end within it."""
        which = which & np.isnan(self.end_h)
        if not which.any():
            return
        march = self.march
        if power is None:
            power = Power(*(one[number] for one in march.at_floor))
        constant, hours = march.levels.constant_power_w, float(march.hours[number, 0])
        left, right = power.motor_w + constant - power.solar_w
        share = 1.0 - lacking / np.maximum(power.deficit_wh, 1e-300)
        served = ramp_fraction(np.maximum(left, 0.0), np.maximum(right, 0.0), share)
        begin = np.where(power.early > 0.0, 0.0, power.sunlit_h)
        end = march.node_h[number] + begin + (hours - power.sunlit_h) * served
        self.end_h = np.where(which, end, self.end_h)
