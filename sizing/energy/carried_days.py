"""Days that follow each other, each with its own light, the charge carried over from day to day.

The energy at a day's end rises with that at its start, by at most as much. All days are therefore
marched at once from an empty and from a full battery: where both end alike, the day's end is known
whatever came before. The few days that are left are marched one after the other. Nothing is
approximated but what :mod:`sizing.energy.march` approximates.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sizing.energy.battery import Store
from sizing.energy.march import ChargingDay, DayRun, hour_of_deficit
from sizing.energy.power_balance import PowerBalance
from solar.types import BoolArray, FloatArray, IntArray

# Of the battery's energy: ends of a day from different starts that count as the same.
_SAME = 1e-12
_SHORT = 1e-12  # state of charge below zero that counts as an empty battery


@dataclass(frozen=True)
class CarriedDays:
    """Run of batteries over consecutive days.

    Attributes
    ----------
    balance : PowerBalance
        Surplus and deficit, elements ``day + days * aircraft``.
    day : ChargingDay
        The same reduced to its surpluses.
    store : Store
        Batteries of the elements.
    days : int
        Number of days.
    run : DayRun
        What became of the batteries on each day.
    """

    balance: PowerBalance
    day: ChargingDay
    store: Store
    days: int
    run: DayRun

    def energy_wh(self) -> FloatArray:
        """Stored energy at the nodes [Wh], shape ``(node, aircraft, day)``."""
        energy = self.run.energy_at_nodes_wh()
        return energy.reshape(len(energy), -1, self.days)

    def runs_empty(self) -> tuple[BoolArray, BoolArray]:
        """Whether each day's battery runs empty before its first surplus, and after it.

        Of shape ``(element,)`` each. Where no surplus comes, all of the day is after it.
        """
        run = self.run
        least = -_SHORT * self.store.battery_energy_wh
        short = run.drained_wh < least
        surplus = np.isfinite(self.day.deficit_before_surplus_wh)
        first = surplus & (np.cumsum(surplus, axis=0) == 1)
        before = np.any(short & first, axis=0)
        after = np.any(short & surplus & ~first, axis=0) | (run.midnight_wh < least)
        return before, after

    def unserved_level_wh(self) -> FloatArray:
        """Cumulative deficit at which each day's battery first ran empty [Wh]; NaN if it did not.

        Of shape ``(element,)``; what lies beyond it cannot be met before the next surplus.
        """
        run, eta = self.run, self.store.discharge_efficiency
        least = -_SHORT * self.store.battery_energy_wh
        level = np.full(len(least), np.nan)
        # From the last surplus back: the first emptiness of the day stays.
        late = run.midnight_wh < least
        level[late] = (self.day.cumulative_deficit_wh[-1] + eta * run.midnight_wh)[late]
        for drained, before in zip(
            run.drained_wh[::-1], self.day.deficit_before_surplus_wh[::-1], strict=True
        ):
            short = drained < least
            level[short] = (before + eta * drained)[short]
        return level

    def hour_at_level(self, level_wh: FloatArray, cells: IntArray) -> FloatArray:
        """Hours after the start of their day at which the deficit reaches levels [h].

        Parameters
        ----------
        level_wh : ndarray
            Cumulative deficits [Wh].
        cells : ndarray of int
            Element of each.

        Returns
        -------
        ndarray
            Of the shape of ``level_wh`` [h].
        """
        return hour_of_deficit(self.balance, self.day.cumulative_deficit_wh, level_wh, cells)

    def energy_at_wh(self, hour: FloatArray) -> FloatArray:
        """Stored energy at an hour of each day [Wh], straight lines between the nodes."""
        return self._at(self.run.energy_at_nodes_wh(), hour)

    def deficit_until_wh(self, hour: FloatArray) -> FloatArray:
        """Cumulative deficit at an hour of each day [Wh], straight lines between the nodes."""
        return self._at(self.day.cumulative_deficit_wh, hour)

    def _at(self, values: FloatArray, hour: FloatArray) -> FloatArray:
        """Value at the nodes, taken at an hour of each day."""
        time = self.balance.time_h
        number = np.clip(np.searchsorted(time, hour, side="right") - 1, 0, len(time) - 2)
        cells = np.arange(len(hour))
        share = np.clip((hour - time[number]) / (time[number + 1] - time[number]), 0.0, 1.0)
        low, high = values[number, cells], values[number + 1, cells]
        return np.asarray(low + share * (high - low))


def carried_over(
    balance: PowerBalance, store: Store, start_wh: FloatArray, days: int
) -> CarriedDays:
    """March batteries through consecutive days.

    Parameters
    ----------
    balance : PowerBalance
        A day of nodes each, batch of one dimension: ``day + days * aircraft``. A day's last node is
        the first of the next.
    store : Store
        Batteries of the elements.
    start_wh : ndarray, shape (aircraft,)
        Stored energy at the start of the first day [Wh].
    days : int
        Number of days.

    Returns
    -------
    CarriedDays
    """
    day = ChargingDay.of(balance)
    brief = day.without_nodes()
    full = store.battery_energy_wh
    shape = (-1, days)
    energy = np.zeros(full.shape).reshape(shape)
    energy[:, 0] = start_wh
    from_empty = brief.end_wh(store, np.zeros(full.shape)).reshape(shape)
    from_full = brief.end_wh(store, np.array(full)).reshape(shape)
    alike = from_full - from_empty <= _SAME * full.reshape(shape)
    # Ends that do not depend on the start are the starts of the next days.
    known = np.zeros(alike.shape, bool)
    known[:, 0] = True
    known[:, 1:] = alike[:, :-1]
    energy[:, 1:] = np.where(alike[:, :-1], from_full[:, :-1] * _next_over_own(full, days), 0.0)
    _march_open_days(brief, store, energy, known)
    return CarriedDays(balance, day, store, days, day.run(store, energy.reshape(-1)))


def _march_open_days(
    day: ChargingDay, store: Store, energy_wh: FloatArray, known: BoolArray
) -> None:
    """March the days whose end is not known yet, in place, always those that may be marched."""
    days = known.shape[1]
    capacity = _next_over_own(store.battery_energy_wh, days)
    while not known.all():
        ready = known[:, :-1] & ~known[:, 1:]
        craft, number = np.nonzero(ready)
        cells = craft * days + number
        end = day.select(cells).end_wh(store.select(cells), energy_wh[craft, number])
        energy_wh[craft, number + 1] = end * capacity[craft, number]
        known[craft, number + 1] = True


def _next_over_own(full_wh: FloatArray, days: int) -> FloatArray:
    """Energy at full charge of the next day's battery over that of each day's own [-].

    A battery that is colder the next day keeps its state of charge, not its energy. Shape
    ``(aircraft, days - 1)``.
    """
    full = full_wh.reshape(-1, days)
    return np.asarray(full[:, 1:] / full[:, :-1])


def flight_hours(
    carried: CarriedDays, launch_h: FloatArray, launch_wh: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Flight times of launches, one on each day, until the battery is empty.

    Parameters
    ----------
    carried : CarriedDays
        Days of a single aircraft.
    launch_h : ndarray, shape (day,)
        Launch after the start of each day [h].
    launch_wh : ndarray, shape (day,)
        Stored energy at the launch [Wh].

    Returns
    -------
    hours : ndarray, shape (day,)
        Flight time [h]; of a flight that lasts until the record's end, up to there.
    outlasts : ndarray of bool, shape (day,)
        Whether the battery was never empty until the record's end.
    """
    day, store, days = carried.day, carried.store, carried.days
    brief = day.without_nodes()
    launched = np.arange(days)
    settled = carried.deficit_until_wh(launch_h)
    hours, outlasts = np.full(days, np.nan), np.zeros(days, bool)
    flying, energy, now = launched.copy(), np.array(launch_wh, float), launched.copy()
    eta = store.discharge_efficiency
    capacity = _next_over_own(store.battery_energy_wh, days)[0]
    follower = np.full(days, -1)
    seen: dict[tuple[int, float], int] = {}
    while len(flying):
        some, its_store = brief.select(now), store.select(now)
        least = -_SHORT * its_store.battery_energy_wh
        level = np.full(len(now), np.nan)
        for step in some.charge(its_store, energy, settled):
            short = (step.drained_wh < least) & np.isnan(level)
            level[short] = (step.settled_deficit_wh + eta * step.drained_wh)[short]
            energy, settled = step.after_charge_wh, step.settled_deficit_wh
        midnight = some.midnight_wh(its_store, energy, settled)
        late = (midnight < least) & np.isnan(level)
        level[late] = (some.cumulative_deficit_wh[-1] + eta * midnight)[late]
        ended = ~np.isnan(level)
        at = flying[ended]
        end_h = carried.hour_at_level(level[ended], now[ended])
        hours[at] = (now[ended] - at) * 24.0 + end_h - launch_h[at]
        last = ~ended & (now == days - 1)
        hours[flying[last]] = (days - flying[last]) * 24.0 - launch_h[flying[last]]
        outlasts[flying[last]] = True
        goes_on = ~ended & ~last
        flying, now = flying[goes_on], now[goes_on] + 1
        energy = np.maximum(midnight[goes_on], 0.0) * capacity[now - 1]
        settled = np.zeros(len(now))
        # Flights that have become equal share the rest of their way.
        keep = np.ones(len(flying), bool)
        for i, key in enumerate(zip(now.tolist(), energy.tolist(), strict=True)):
            if key in seen:
                follower[flying[i]], keep[i] = seen[key], False
            else:
                seen[key] = int(flying[i])
        flying, now, energy, settled = flying[keep], now[keep], energy[keep], settled[keep]
    _follow(hours, outlasts, follower, launch_h)
    return hours, outlasts


def _follow(
    hours: FloatArray, outlasts: BoolArray, follower: IntArray, launch_h: FloatArray
) -> None:
    """Give flights that became equal to another one its end, in place."""
    for i in range(len(hours) - 1, -1, -1):
        leader = i
        while follower[leader] >= 0:
            leader = int(follower[leader])
        if leader != i:
            end_h = leader * 24.0 + launch_h[leader] + hours[leader]
            hours[i] = end_h - i * 24.0 - launch_h[i]
            outlasts[i] = outlasts[leader]
