"""Days that follow each other with climbs: battery and height carried over from day to day.

All days are marched at once, first from a full battery at the lowest altitude, then each from where
the day before has ended, and again those whose beginning has changed by that. Most days forget
their beginning, since the battery fills up or runs empty, so that few are left after a few rounds.
Where these do not become fewer by half, as next to each other they wait for each other, only the
first ones of each row of them are marched. What is found is the march of one day after the other.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sizing.altitude.climb_day import ROUNDS, SETTLED_VOLTS, at_times
from sizing.altitude.climb_endurance import ClimbFlights, flown_day
from sizing.altitude.climb_march import March, at_nodes
from sizing.altitude.climb_run import DayRun, Stored
from sizing.energy.carried_days import Launches, closing_days, dawns_of, next_over_own
from sizing.energy.endurance import FlownDay, Flying
from sizing.energy.march import ChargingDay
from sizing.energy.power_balance import blocks
from solar.types import BoolArray, FloatArray, IntArray

_AT_ONCE = 512  # so that the arrays of the days stay near the processor
# Of the battery's energy: beginnings of a day that count as the same, and what lacks of a load that
# is met but for rounding.
_SAME, _SHORT = 1e-10, 1e-9


class Flown(NamedTuple):
    """What became of the days.

    ``dawn_h``: when the battery of level flight at the lowest altitude would be least, hours after
    the day's start [h]; ``dawn_wh``: energy in the battery then [Wh]. ``closes``: whether a day,
    begun at dawn with what is carried over, reaches the next dawn without an empty battery. At the
    nodes of the days, ``(element, node)``: energy in the battery and of height [Wh], and power of
    the modules and of all loads [W].
    """

    dawn_h: FloatArray
    dawn_wh: FloatArray
    closes: BoolArray
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

    def flown(self) -> tuple[ClimbingDays, Flown]:
        """Days as they are flown, and the same with the voltages of their own charge."""
        done, chain, now = self._flown(), self.march.levels.chain, self
        if chain is None or not chain.follows_voltage:
            return now, done
        for _ in range(ROUNDS):
            charge = done.energy_wh.T / now.march.store.battery_energy_wh
            bus_v = chain.voltage_of(charge)
            assert now.march.bus_v is not None
            if np.all(np.abs(bus_v - now.march.bus_v) <= SETTLED_VOLTS * bus_v):
                break
            march = now.march.at_voltages(bus_v, now.march.nominal_w)
            now = ClimbingDays(march, self.days, self.noon_h)
            done = now._flown()
        return now, done

    def _flown(self) -> Flown:
        start, store = self._starts(), self.march.store
        parts = []
        for cells in _blocks(np.arange(self.march.count)):
            march, run = self._run(cells, start)
            balance, own = march.floor_balance(), store.select(cells)
            noon_h = self.noon_h[cells]
            dawn_h = dawns_of(balance, ChargingDay.of(balance), own, noon_h).hour
            short = run.unserved > _SHORT * own.battery_energy_wh
            early = march.node_h[:-1, np.newaxis] < dawn_h
            load_w = run.motor_wh / march.hours + march.levels.constant_power_w
            parts.append(
                (
                    *(dawn_h, at_times(march.node_h, run.energy_wh, dawn_h)),
                    *(np.any(short & early, axis=0), np.any(short & ~early, axis=0)),
                    *(run.energy_wh.T, run.potential_wh.T),
                    at_nodes(run.power.solar_left_w, run.power.solar_right_w),
                    at_nodes(load_w, load_w),
                )
            )
        dawn_h, dawn_wh, before, after, *courses = map(np.concatenate, zip(*parts, strict=True))
        return Flown(dawn_h, dawn_wh, closing_days(before, after, self.days), *courses)

    def _run(self, cells: IntArray, start: Stored) -> tuple[March, DayRun]:
        """Some of the days from what each begins with, step by step."""
        march = self.march.select(cells)
        run = march.empty_run()
        march.end_of_day(Stored(*(one[cells] for one in start)), run)
        return march, run

    def _starts(self) -> Stored:
        """What every day begins with."""
        full = self.march.store.battery_energy_wh
        start = Stored(full.copy(), np.zeros(full.shape))
        end = Stored(full.copy(), np.zeros(full.shape))
        turn, count = np.ones(full.shape, bool), 2 * int(full.size)
        while turn.any():
            for cells in _blocks(np.flatnonzero(turn)):
                begun = Stored(*(one[cells] for one in start))
                found = self.march.select(cells).end_of_day(begun)
                for whole, part in zip(end, found, strict=True):
                    whole[cells] = part
            begins = self._next_day(end)
            apart = [np.abs(a - b) > _SAME * full for a, b in zip(begins, start, strict=True)]
            turn = np.logical_or(*apart)
            if 2 * np.count_nonzero(turn) > count:
                turn = turn & ~self._after(turn)
            count = int(np.count_nonzero(turn))
            for own, one in zip(start, begins, strict=True):
                own[turn] = one[turn]
        return start

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


def _blocks(cells: IntArray) -> Iterator[IntArray]:
    return (cells[some] for some in blocks(len(cells), _AT_ONCE))


def _joined(parts: Iterator[FlownDay]) -> FlownDay:
    return FlownDay(*map(np.concatenate, zip(*parts, strict=True)))
