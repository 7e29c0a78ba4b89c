"""Longest flights with climbs: from a launch with a full battery, day by day, each the best it can.

Before dawn there is no use in height that is left: from one morning's equal power to the next the
program leaves as much charge as any schedule does, and a flight is a row of such days. So the
charge of a dawn tells that of the next one, and how long a flight is from any launch by night.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from sizing.day.balance import PowerBalance
from sizing.day.battery import Store
from sizing.day.flight import MAXIMUM_DAYS, Course, Endurance, longest_flight
from sizing.day.heights import FlightLevels
from sizing.day.march import ChargingDay
from sizing.day.metrics import equal_power
from sizing.program.schedule import FORM, LOWEST_M, Climbs, Window, best_heights, flown_along
from solar.types import FloatArray, IntArray

_CHARGES = 9  # of a dawn, of which the next one is known; linear between
_LAUNCHES = 601  # by night
_ROUNDING = 1e-9  # of the battery: a load that lacks less is met
_SAME_LOSS = 1e-4  # of the battery: days that lose the same are alike


class Part(NamedTuple):
    """Part of a flight, and when it ends with an empty battery; NaN where it does not.

    ``left_wh``: charge at its end, less what lacks until then.
    """

    clock_h: FloatArray
    solar_w: FloatArray
    load_w: FloatArray
    energy_wh: FloatArray
    height_m: FloatArray
    empty_h: float
    left_wh: float

    @property
    def flies_until_h(self) -> float:
        """When it ends; infinite where it does not."""
        return np.inf if np.isnan(self.empty_h) else self.empty_h


@dataclass(frozen=True)
class ClimbFlights:
    """Flights with climbs of elements in the light of their repeated day."""

    time_h: FloatArray
    levels: FlightLevels
    store: Store

    @cached_property
    def floor(self) -> Climbs:
        """Level flight at the lowest altitude."""
        none = np.zeros((len(self.levels.scenario), len(self.time_h)))
        return flown_along(self.time_h, self.levels, self.store, none)

    @cached_property
    def dawn_h(self) -> tuple[FloatArray, FloatArray]:
        """Morning's and evening's equal power at the lowest altitude, NaN where there is none."""
        equal = equal_power(self.time_h, self.floor.solar_w.T, self.levels.nominal_load_w)
        return equal.morning_h, equal.evening_h

    def part(self, i: int, window: Window) -> Part:
        """One part of the flight of an element: the longer of the program's and level flight.

        Without a surplus, and in a few steps, there is nothing to climb with.
        """
        level = self._flown(i, window, np.zeros(len(self.time_h)))
        able = len(level.clock_h) > FORM.intervals and self.levels.flies[i]
        able &= self.levels.reach_m[i] > LOWEST_M
        if not (able and (level.solar_w > level.load_w).any()):
            return level
        height_m, _ = best_heights(self.time_h, self.levels, self.store, self.floor, i, window)
        climbing = self._flown(i, window, height_m)
        return max(level, climbing, key=lambda part: (part.flies_until_h, part.left_wh))

    def _flown(self, i: int, window: Window, height_m: FloatArray) -> Part:
        element = slice(i, i + 1)
        powers = self.levels.select(element).powers_along(self.time_h, height_m[np.newaxis])
        day, store = window.day(self.time_h, *powers), self.store.select(element)
        charging = ChargingDay.of(PowerBalance.of(day.time_h, (day.solar_w - day.load_w).T))
        begin_wh = np.array([window.begin_wh])
        run = charging.run(store, begin_wh)
        empty_h = float(run.empty_h(_ROUNDING)[0])
        charge = run.energy_at_nodes_wh()[:, 0]
        left_wh = float(run.midnight_wh[0] + np.minimum(run.drained_wh, 0.0).sum())
        height = np.interp(day.time_h % 24.0, self.time_h, height_m)
        return Part(day.time_h, day.solar_w[0], day.load_w[0], charge, height, empty_h, left_wh)

    def parts(self, i: int, launch_h: float) -> list[tuple[float, Part]]:
        """Parts of a flight of an element until its battery is empty, and when they begin [h].

        Days that lose the same are skipped; without an end where a day gives back what it takes.
        """
        dawn_h, full_wh = float(self.dawn_h[0][i]), float(self.store.battery_energy_wh[i])
        dawn_h = 0.0 if np.isnan(dawn_h) else dawn_h
        first_h = (dawn_h - launch_h) % 24.0 or 24.0
        window, days_h, lost_wh = Window(launch_h, launch_h + first_h, full_wh), 0.0, np.nan
        parts: list[tuple[float, Part]] = []
        while True:
            part = self.part(i, window)
            parts.append((days_h, part))
            days_h += window.end_h - dawn_h if len(parts) == 1 else 24.0
            if not np.isnan(part.empty_h) or days_h > 24.0 * MAXIMUM_DAYS:
                return parts
            loss_wh = window.begin_wh - part.left_wh
            begin_wh = part.left_wh
            if len(parts) > 1 and loss_wh <= _SAME_LOSS * full_wh:
                return parts
            if len(parts) > 2 and abs(loss_wh - lost_wh) < _SAME_LOSS * full_wh:
                lowest_wh = min(part.energy_wh)
                skipped = max(np.floor(lowest_wh / loss_wh) - 1.0, 0.0)
                begin_wh, days_h = begin_wh - skipped * loss_wh, days_h + 24.0 * skipped
            lost_wh = loss_wh
            window = Window(dawn_h, dawn_h + 24.0, begin_wh)

    def hours(self, cells: IntArray, launch_h: FloatArray) -> FloatArray:
        """Flight time of elements from launches with a full battery [h]."""
        flights_h = np.full(len(cells), np.inf)
        for number, (i, at_h) in enumerate(zip(cells.tolist(), launch_h.tolist(), strict=True)):
            days_h, last = self.parts(i, at_h)[-1]
            if not np.isnan(last.empty_h):
                flights_h[number] = days_h + last.empty_h - at_h
        return np.where(flights_h > 24.0 * MAXIMUM_DAYS, np.inf, flights_h)

    def longest(self) -> Endurance:
        """Longest flight of every element over all launches by night, and in level flight."""
        floor = self.floor
        level = longest_flight(self.time_h, floor.solar_w, floor.load_w, self.store)
        hours, launch_h = level.endurance_h.copy(), level.launch_h.copy()
        climbs = np.isfinite(hours) & ~np.isnan(self.dawn_h[0]) & self.levels.flies
        for i in np.flatnonzero(climbs & (self.levels.reach_m > 0.0)).tolist():
            tries_h = np.array([self._best_launch(i), self.dawn_h[0][i], launch_h[i]])
            flown_h = self.hours(np.full(len(tries_h), i), tries_h)
            best = int(np.argmax(flown_h))
            if flown_h[best] > hours[i]:
                hours[i], launch_h[i] = flown_h[best], tries_h[best] % 24.0
        return Endurance(hours, launch_h)

    def _best_launch(self, i: int) -> float:
        """Launch of the longest flight from the evening's to the morning's equal power [h]."""
        dawn_h, dusk_h = (float(hours[i]) for hours in self.dawn_h)
        full_wh, floor = float(self.store.battery_energy_wh[i]), self.floor
        out_of = float(
            np.broadcast_to(self.store.discharge_efficiency, self.store.battery_energy_wh.shape)[i]
        )
        charges = np.linspace(0.0, full_wh, _CHARGES)
        windows = [Window(dawn_h, dawn_h + 24.0, float(charge_wh)) for charge_wh in charges]
        left_wh = np.array([self.part(i, window).left_wh for window in windows])
        before_h = np.linspace(0.0, (dawn_h - dusk_h) % 24.0, _LAUNCHES)
        net_w = floor.load_w[i] - floor.solar_w[i]
        lacking_w = np.interp((dawn_h - before_h) % 24.0, self.time_h, np.maximum(net_w, 0.0))
        steps = np.diff(before_h) * (lacking_w[1:] + lacking_w[:-1]) / 2.0
        charge = full_wh - np.concatenate([[0.0], np.cumsum(steps)]) / out_of
        # At the floor, before the first dawn: what lacks then is hours of the nominal load.
        nominal_h = out_of / float(self.levels.nominal_load_w[i])
        hours = before_h.copy()
        for _ in range(MAXIMUM_DAYS):
            flies = charge >= 0.0
            if not flies.any():
                break
            charge = np.where(flies, np.interp(charge, charges, left_wh), charge)
            hours = np.where(flies, hours + 24.0, hours)
        hours += np.minimum(charge, 0.0) * nominal_h
        return float(dawn_h - before_h[int(np.argmax(hours))]) % 24.0

    def course(self, i: int, launch_h: float, hours: float) -> Course:
        """Flight of one element, as :meth:`sizing.performance.Performance.course` returns it."""
        full_wh, end_h = float(self.store.battery_energy_wh[i]), launch_h + hours
        columns: list[tuple[FloatArray, ...]] = []
        for days_h, part in self.parts(i, launch_h):
            clock_h = days_h + part.clock_h
            rest = slice(1 if columns else 0, None)
            rows = (clock_h, part.solar_w, part.load_w, part.energy_wh / full_wh, part.height_m)
            columns.append(tuple(row[rest] for row in rows))
        time_h, *values = (np.concatenate(column) for column in zip(*columns, strict=True))
        inside = (time_h > launch_h) & (time_h < end_h)
        clock_h = np.concatenate([[launch_h], time_h[inside], [end_h]])
        solar, load, charge, height_m = (np.interp(clock_h, time_h, column) for column in values)
        # It has come down.
        landed = clock_h >= days_h + part.flies_until_h
        charge[np.logical_or.accumulate(landed | (charge <= 0.0))] = 0.0
        return Course(clock_h, solar, load, charge, self.levels.altitude_m[0] + height_m)
