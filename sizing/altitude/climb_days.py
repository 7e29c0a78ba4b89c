"""Days that follow each other with climbs: battery and height carried over from day to day.

All days are marched at once, first from a full battery at the lowest altitude, then each from where
the day before has ended, and again those whose beginning has changed by that. Most days forget
their beginning, since the battery fills up or runs empty, so that few are left after a few rounds.
Where these do not become fewer by half, as next to each other they wait for each other, only the
first ones of each row of them are marched. What is found is the march of one day after the other.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from sizing.altitude.climb_chain import Place
from sizing.altitude.climb_day import ROUNDS, SETTLED_VOLTS
from sizing.altitude.climb_endurance import ClimbFlights, flown_day
from sizing.altitude.climb_march import March, at_nodes
from sizing.altitude.climb_run import Moves, Power, Stored
from sizing.energy.carried_days import Launches, closing_days, dawns_of, next_over_own
from sizing.energy.endurance import FlownDay, Flying
from sizing.energy.march import ChargingDay
from sizing.energy.power_balance import blocks
from solar.types import BoolArray, FloatArray, IntArray

_AT_ONCE = 2048  # so that the arrays of the days stay near the processor
# Of the battery's energy: beginnings of a day that count as the same, and what lacks of a load that
# is met but for rounding.
_SAME, _SHORT = 1e-10, 1e-9


class Carried(NamedTuple):
    """What the days begin with, and what becomes of them; of every element.

    ``start``: at the beginning of the day. ``dawn_h``: when the battery of level flight at the
    lowest altitude would be least, hours after the beginning [h]. ``closes``: whether a day, begun
    at dawn with what is carried over, reaches the next dawn without an empty battery.
    """

    start: Stored
    dawn_h: FloatArray
    closes: BoolArray


class Courses(NamedTuple):
    """At the nodes of the days, ``(element, node)``.

    Energy in the battery and of height [Wh], power of the modules and of all loads [W].
    """

    energy_wh: FloatArray
    potential_wh: FloatArray
    solar_power_w: FloatArray
    load_w: FloatArray


@dataclass(frozen=True)
class ClimbingDays:
    """Days of aircraft, the first from a full battery at the lowest altitude.

    ``march``: from node to node of each day, elements ``day + days * aircraft``. ``days``: of each
    aircraft. ``noon_h``: from the start of each day to its noon [h], shape ``(element,)``.
    """

    march: March
    days: int
    noon_h: FloatArray

    def with_own_voltages(self) -> ClimbingDays:
        """Same days with the voltages of their own charge, where the propulsion follows them."""
        days, chain = self, self.march.levels.chain
        for _ in range(ROUNDS if chain is not None and chain.follows_voltage else 0):
            assert chain is not None
            march = days.march
            assert march.bus_v is not None
            bus_v = chain.voltage_of(days.courses().energy_wh.T / march.store.battery_energy_wh)
            if np.all(np.abs(bus_v - march.bus_v) <= SETTLED_VOLTS * bus_v):
                break
            days = replace(days, march=march.at_voltages(bus_v, march.nominal_w))
        return days

    def courses(self) -> Courses:
        """All days step by step."""
        parts = []
        for cells in _blocks(np.arange(self.march.count)):
            march = self.march.select(cells)
            run = march.empty_run()
            march.end_of_day(_of(self.carried.start, cells), run)
            solar_w = at_nodes(run.power.solar_w)
            load_w = run.motor_wh / march.hours + march.levels.constant_power_w
            nodes = (
                run.energy_wh.T,
                run.potential_wh.T,
                solar_w,
                np.concatenate([load_w, load_w[-1:]]).T,
            )
            parts.append(nodes)
        return Courses(*map(np.concatenate, zip(*parts, strict=True)))

    @cached_property
    def carried(self) -> Carried:
        """What is carried over, and what becomes of the days."""
        full = self.march.store.battery_energy_wh
        start, end = (Stored(full.copy(), np.zeros(full.shape)) for _ in range(2))
        dawn_h, before, after = np.full(full.shape, np.nan), *np.zeros((2, full.size), bool)
        turn, count = np.ones(full.shape, bool), 2 * int(full.size)
        while turn.any():
            for cells in _blocks(np.flatnonzero(turn)):
                march = self.march.select(cells)
                if np.isnan(dawn_h[cells[0]]):
                    dawn_h[cells] = _dawn_h(march, self.noon_h[cells])
                watch = _Watch(march, dawn_h[cells])
                for whole, part in zip(
                    (*end, before, after),
                    (*march.end_of_day(_of(start, cells), watch), watch.before, watch.after),
                    strict=True,
                ):
                    whole[cells] = part
            begins = self._next_day(end)
            apart = [np.abs(a - b) > _SAME * full for a, b in zip(begins, start, strict=True)]
            turn = np.logical_or(*apart)
            if 2 * np.count_nonzero(turn) > count:
                turn = turn & ~self._after(turn)
            count = int(np.count_nonzero(turn))
            for own, one in zip(start, begins, strict=True):
                own[turn] = one[turn]
        return Carried(start, dawn_h, closing_days(before, after, self.days))

    def _next_day(self, end: Stored) -> Stored:
        """What days begin with by the ends of those before: charge, not energy, and height."""
        full = self.march.store.battery_energy_wh
        energy, potential = (one.reshape(-1, self.days) for one in end)
        kept_wh = energy[:, :-1] * next_over_own(full, self.days)
        first = full.reshape(-1, self.days)[:, :1]
        return Stored(
            np.hstack([first, kept_wh]).reshape(-1),
            np.hstack([np.zeros(first.shape), potential[:, :-1]]).reshape(-1),
        )

    def _after(self, some: BoolArray) -> BoolArray:
        """Days after some of the days."""
        of_days = some.reshape(-1, self.days)
        return np.pad(of_days[:, :-1], ((0, 0), (1, 0))).reshape(-1)

    def flight_hours(self, launch_h: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Flight times of launches with a full battery, one on each day of a single aircraft.

        ``launch_h``: launch after the start of each day [h]. Returns flight times until the battery
        is empty, or up to the end of the last day [h], and whether it is never empty until then.
        """
        full = self.march.store.battery_energy_wh
        capacity = np.append(next_over_own(full, self.days)[0], 1.0)
        launches = Launches(launch_h)
        day = _joined(self._launched(cells, launch_h[cells]) for cells in _blocks(launches.now))
        while True:
            now, stored = launches.now, (day.midnight_wh * capacity[launches.now], day.potential_wh)
            # Flights marched beside different others differ by rounding.
            places = launches.next_day(day.end_h, *(np.round(one / full[0], 9) for one in stored))
            if not len(places):
                return launches.result()
            none = np.zeros(len(places))
            energy, potential = (one[places] for one in stored)
            flying = Flying(now[places] + 1, energy, potential, none, none, none)
            day = _joined(
                flown_day(self.march.select(flying.cell[some]), flying.select(some))
                for some in _blocks(np.arange(len(places)))
            )

    def _launched(self, cells: IntArray, launch_h: FloatArray) -> FlownDay:
        """First day of flights, each launched on its own."""
        flights = ClimbFlights.over(self.march.select(cells))
        return flights.flown_day(flights.launched(np.arange(len(cells)), launch_h))


class _Watch:
    """Whether days lack energy before and after their dawn."""

    def __init__(self, march: March, dawn_h: FloatArray) -> None:
        self.early = march.node_h[:-1, np.newaxis] < dawn_h
        self.least_wh = _SHORT * march.store.battery_energy_wh
        self.before, self.after = np.zeros((2, march.count), bool)

    def keep(self, number: int, moves: Moves, power: Power | None, place: Place | None) -> None:
        """See what a step lacks."""
        for drawn in (moves.first, moves.second):
            if drawn is not None:
                self._lacks(drawn.unserved_wh[np.newaxis], slice(number, number + 1))

    def discharge(
        self, steps: slice, stored: Stored, used_wh: FloatArray, eta: float | FloatArray
    ) -> None:
        """See what steps on the battery alone lack."""
        self._lacks(used_wh - stored.battery_wh, steps)

    def _lacks(self, lacking_wh: FloatArray, steps: slice) -> None:
        short = lacking_wh > self.least_wh
        if short[-1].any():
            early = self.early[steps]
            self.before |= np.any(short & early, axis=0)
            self.after |= np.any(short & ~early, axis=0)


def _dawn_h(march: March, noon_h: FloatArray) -> FloatArray:
    """Dawns of level flight at the lowest altitude."""
    balance = march.floor_balance()
    return dawns_of(balance, ChargingDay.of(balance), march.store, noon_h).hour


def _of(stored: Stored, cells: IntArray) -> Stored:
    return Stored(*(one[cells] for one in stored))


def _blocks(cells: IntArray) -> Iterator[IntArray]:
    return (cells[some] for some in blocks(len(cells), _AT_ONCE))


def _joined(parts: Iterator[FlownDay]) -> FlownDay:
    return FlownDay(*map(np.concatenate, zip(*parts, strict=True)))
