"""Days that follow each other, each with its own light, the charge carried over from day to day.

The energy at a day's end rises with that at its start, by at most as much. All days are therefore
marched at once from an empty and from a full battery: where both end alike, the day's end is known
whatever came before. The days that are left are marched again from the least and the most that the
day before may end with, and the few that even that leaves open one after the other. Nothing is
approximated but what :mod:`sizing.day.march` approximates.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from sizing.day.balance import PowerBalance, crossing_fraction, running_sum
from sizing.day.battery import Store
from sizing.day.march import ChargingDay, DayRun, hour_of_deficit
from solar.types import BoolArray, FloatArray, IntArray

# Of the battery's energy: ends of a day from different starts that count as the same.
_SAME = 1e-12
_SHORT = 1e-12  # state of charge below zero that counts as an empty battery


class Dawns(NamedTuple):
    """When the charge of each night is least: where a day begins.

    ``hour``: hours after the start of the day [h], shape ``(element,)``. ``deficit_wh``: cumulative
    deficit from the start of the day until then [Wh], shape ``(element,)``.
    """

    hour: FloatArray
    deficit_wh: FloatArray


def dawns_of(
    balance: PowerBalance, day: ChargingDay, store: Store, noon_h: FloatArray | float
) -> Dawns:
    """Dawns: when, from midnight to the last node before noon, the charge is least.

    The charge is that of a battery which is neither full nor empty: surplus times charge
    efficiency less deficit over discharge efficiency, summed up from midnight. A surplus that a
    longer deficit eats up again before noon is no dawn. Under a clear sky it is the morning's equal
    power.

    ``balance``: batch of one dimension, from about midnight to about midnight. ``day``: the same
    reduced to its surpluses. ``store``: batteries of the elements. ``noon_h``: hours from the start
    of the day to noon [h], shape ``(element,)``.
    """
    time, net, deficit = balance.time_h, balance.net_w, balance.deficit_wh
    noon = np.broadcast_to(noon_h, net.shape[1:])
    rows = max(int(np.searchsorted(time, noon.max(), side="right")) - 1, 1)
    gain = store.charge_efficiency * balance.surplus_wh[:rows]
    gain -= deficit[:rows] / store.discharge_efficiency
    charge = running_sum(gain)
    falls = net[:rows] < 0.0
    lowest = charge[:-1] - np.where(falls, deficit[:rows], 0.0) / store.discharge_efficiency
    morning = time[1 : rows + 1, np.newaxis] <= noon
    cells = np.arange(net.shape[1])
    at = np.argmin(np.where(morning, lowest, np.inf), axis=0)
    # Where the last of the morning falls until noon, noon itself is the lowest.
    last = np.sum(morning, axis=0)
    late = charge[last, cells] < lowest[at, cells]
    falling = falls[at, cells]
    crossing = crossing_fraction(net[at, cells], net[at + 1, cells])
    share = np.where(falling, np.where(net[at + 1, cells] < 0.0, 1.0, crossing), 0.0)
    node = np.where(late, last, at)
    hour = time[node] + np.where(late, 0.0, share) * (time[at + 1] - time[at])
    reached = np.where(falling & ~late, node + 1, node)
    return Dawns(hour, day.cumulative_deficit_wh[reached, cells])


@dataclass(frozen=True)
class CarriedDays:
    """Run of batteries over consecutive days.

    ``balance``: surplus and deficit, elements ``day + days * aircraft``. ``day``: the same reduced
    to its surpluses. ``store``: batteries of the elements. ``days``: number of days. ``run``: what
    became of the batteries on each day.
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

    def runs_empty(self, dawns: Dawns) -> tuple[BoolArray, BoolArray]:
        """Whether each day's battery is empty before its dawn, and after it.

        Both are true where it is empty before dawn and stays so.
        """
        run, eta = self.run, self.store.discharge_efficiency
        least = -_SHORT * self.store.battery_energy_wh
        # What is not served is the end of a deficit: from the level at which the battery is empty
        # up to that at which the next surplus, or the day's end, comes.
        ends = self.day.deficit_before_surplus_wh
        short, begins = run.drained_wh < least, ends + eta * run.drained_wh
        before = np.any(short & (begins < dawns.deficit_wh), axis=0)
        after = np.any(short & (ends > dawns.deficit_wh), axis=0)
        late, end = run.midnight_wh < least, self.day.cumulative_deficit_wh[-1]
        before |= late & (end + eta * run.midnight_wh < dawns.deficit_wh)
        after |= late & (end > dawns.deficit_wh)
        return before, after

    def closes(self, dawns: Dawns) -> BoolArray:
        """Whether each day's battery lasts from its dawn to the next day's, the last to its end."""
        return closing_days(*self.runs_empty(dawns), self.days)

    def hour_at_level(self, level_wh: FloatArray, cells: IntArray) -> FloatArray:
        """Hours after the start of their day at which the deficit reaches levels [h]."""
        return hour_of_deficit(self.balance, self.day.cumulative_deficit_wh, level_wh, cells)

    def energy_at_wh(self, hour: FloatArray) -> FloatArray:
        """Stored energy at an hour of each day [Wh], straight lines between the nodes."""
        return self._at_hour(self.run.energy_at_nodes_wh(), hour)

    def deficit_until_wh(self, hour: FloatArray) -> FloatArray:
        """Cumulative deficit at an hour of each day [Wh], straight lines between the nodes."""
        return self._at_hour(self.day.cumulative_deficit_wh, hour)

    def _at_hour(self, values: FloatArray, hour: FloatArray) -> FloatArray:
        """Value at the nodes, taken at an hour of each day."""
        time = self.balance.time_h
        number = np.clip(np.searchsorted(time, hour, side="right") - 1, 0, len(time) - 2)
        cells = np.arange(len(hour))
        share = np.clip((hour - time[number]) / (time[number + 1] - time[number]), 0.0, 1.0)
        low, high = values[number, cells], values[number + 1, cells]
        return np.asarray(low + share * (high - low))


def closing_days(before: BoolArray, after: BoolArray, days: int) -> BoolArray:
    """Whether days close: from dawn to dawn, the last to its end, the battery is never empty.

    ``before``, ``after``: whether it is empty before and after each day's dawn, elements ``day +
    days * aircraft``.
    """
    empty = after.reshape(-1, days).copy()
    empty[:, :-1] |= before.reshape(-1, days)[:, 1:]
    return np.asarray(~empty.reshape(-1))


def carried_over(
    balance: PowerBalance, store: Store, start_wh: FloatArray, days: int
) -> CarriedDays:
    """March batteries through consecutive days.

    ``balance``: a day of nodes each, batch of one dimension: ``day + days * aircraft``. A day's
    last node is the first of the next. ``store``: batteries of the elements. ``start_wh``: stored
    energy at the start of the first day [Wh], shape ``(aircraft,)``. ``days``: number of days.
    """
    day = ChargingDay.of(balance)
    brief = day.without_nodes()
    full = store.battery_energy_wh
    shape = (-1, days)
    low = brief.end_wh(store, np.zeros(full.shape)).reshape(shape)
    high = brief.end_wh(store, np.array(full)).reshape(shape)
    alike = _narrowed(brief, store, start_wh, low, high)
    # Ends that do not depend on the start are the starts of the next days.
    known = np.zeros(alike.shape, bool)
    known[:, 0] = True
    known[:, 1:] = alike[:, :-1]
    energy = np.where(known, _starts(store, start_wh, high), 0.0)
    _march_open_days(brief, store, energy, known)
    return CarriedDays(balance, day, store, days, day.run(store, energy.reshape(-1)))


def _narrowed(
    day: ChargingDay, store: Store, start_wh: FloatArray, low_wh: FloatArray, high_wh: FloatArray
) -> BoolArray:
    """Narrow the ends that days may have, in place; true where but one is left.

    The least and the most that a day may end with are where the next one may begin. As long as that
    settles half of the days that are open, they are marched from there, all at once.
    """
    shape = low_wh.shape
    width = _SAME * store.battery_energy_wh.reshape(shape)
    alike = high_wh - low_wh <= width
    cells = np.flatnonzero(~alike)
    count = 2 * alike.size
    while 0 < len(cells) <= count // 2:
        count = len(cells)
        begins = [_starts(store, start_wh, end).reshape(-1)[cells] for end in (low_wh, high_wh)]
        twice = np.concatenate([cells, cells])
        ends = day.select_lit(twice).end_wh(store.select(twice), np.concatenate(begins))
        low_wh.reshape(-1)[cells], high_wh.reshape(-1)[cells] = ends[:count], ends[count:]
        alike = high_wh - low_wh <= width
        cells = np.flatnonzero(~alike)
    return alike


def _starts(store: Store, start_wh: FloatArray, end_wh: FloatArray) -> FloatArray:
    """Energy at the start of every day from that at the ends of all [Wh]."""
    starts = np.empty(end_wh.shape)
    starts[:, 0] = start_wh
    full = store.battery_energy_wh
    starts[:, 1:] = end_wh[:, :-1] * next_over_own(full, end_wh.shape[1])
    return starts


def _march_open_days(
    day: ChargingDay, store: Store, energy_wh: FloatArray, known: BoolArray
) -> None:
    """March the days whose end is not known yet, in place, always those that may be marched."""
    days = known.shape[1]
    capacity = next_over_own(store.battery_energy_wh, days)
    while not known.all():
        ready = known[:, :-1] & ~known[:, 1:]
        aircraft, number = np.nonzero(ready)
        cells = aircraft * days + number
        end = day.select_lit(cells).end_wh(store.select(cells), energy_wh[aircraft, number])
        energy_wh[aircraft, number + 1] = end * capacity[aircraft, number]
        known[aircraft, number + 1] = True


def next_over_own(full_wh: FloatArray, days: int) -> FloatArray:
    """Energy at full charge of the next day's battery over that of each day's own [-].

    A battery that is colder the next day keeps its state of charge, not its energy. Shape
    ``(aircraft, days - 1)``.
    """
    full = full_wh.reshape(-1, days)
    return np.asarray(full[:, 1:] / full[:, :-1])


def flight_hours(
    carried: CarriedDays,
    launch_h: FloatArray,
    launch_wh: FloatArray,
    settled_deficit_wh: FloatArray | None = None,
) -> tuple[FloatArray, BoolArray]:
    """Flight times of launches, one on each day, until the battery is empty.

    ``carried``: days of a single aircraft. ``launch_h``: launch after the start of each day [h],
    shape ``(day,)``. ``launch_wh``: stored energy at the launch [Wh], shape ``(day,)``.
    ``settled_deficit_wh``: cumulative deficit from the start of the day until the launch [Wh],
    where it is known exactly, as that of :class:`Dawns` is; by default straight lines between the
    nodes, shape ``(day,)``. Returns ``hours``: flight time [h]; of a flight that lasts until the
    record's end, up to there, shape ``(day,)``. Returns ``outlasts``: whether the battery was never
    empty until the record's end, shape ``(day,)``.
    """
    day, store, days = carried.day, carried.store, carried.days
    brief = day.without_nodes()
    settled = settled_deficit_wh
    if settled is None:
        settled = carried.deficit_until_wh(launch_h)
    # A surplus before the launch is nobody's.
    ahead = carried.balance.time_h[brief.first + 1 :][: len(brief.hours), np.newaxis] > launch_h
    flown = replace(brief, surplus_wh=np.where(ahead, brief.surplus_wh, 0.0))
    launches = Launches(launch_h)
    energy = np.array(launch_wh, float)
    eta = store.discharge_efficiency
    capacity = np.append(next_over_own(store.battery_energy_wh, days)[0], 1.0)
    while len(now := launches.now):
        some, its_store = flown.select_lit(now), store.select(now)
        least = -_SHORT * its_store.battery_energy_wh
        level = np.full(len(now), np.nan)
        for step in some.charge(its_store, energy, settled):
            short = (step.drained_wh < least) & np.isnan(level)
            level[short] = (step.settled_deficit_wh + eta * step.drained_wh)[short]
            energy, settled = step.after_charge_wh, step.settled_deficit_wh
        midnight = some.midnight_wh(its_store, energy, settled)
        late = (midnight < least) & np.isnan(level)
        level[late] = (some.cumulative_deficit_wh[-1] + eta * midnight)[late]
        ended, end_h = ~np.isnan(level), np.full(len(now), np.nan)
        end_h[ended] = carried.hour_at_level(level[ended], now[ended])
        energy = np.maximum(midnight, 0.0) * capacity[now]
        energy = energy[launches.next_day(end_h, energy)]
        flown, settled = brief, np.zeros(len(energy))
    return launches.result()


class Launches:
    """Flights launched one on each day, which are flown on day by day, all at once.

    ``launch_h``: launch after the start of each day [h]. ``now``: day of every flight that is to be
    flown next; flights that have become equal share the rest of their way.
    """

    def __init__(self, launch_h: FloatArray) -> None:
        self.launch_h, self.now = launch_h, np.arange(len(launch_h))
        self._flying = self.now.copy()
        self._hours, self._outlasts = np.full(len(self.now), np.nan), np.zeros(len(self.now), bool)
        self._follower = np.full(len(self.now), -1)
        self._seen: dict[tuple[float, ...], int] = {}

    def next_day(self, end_h: FloatArray, *stored: FloatArray) -> IntArray:
        """Go on to the next day.

        ``end_h``: when each flight has ended, hours after the day's start [h]; NaN where it has
        not. ``stored``: what is left at its end, alike for equal flights. Returns places of the
        flights that go on.
        """
        days, flying, now, launch_h = len(self.launch_h), self._flying, self.now, self.launch_h
        ended = ~np.isnan(end_h)
        at = flying[ended]
        self._hours[at] = (now[ended] - at) * 24.0 + end_h[ended] - launch_h[at]
        last = flying[~ended & (now == days - 1)]
        self._hours[last], self._outlasts[last] = (days - last) * 24.0 - launch_h[last], True
        places = np.flatnonzero(~ended & (now < days - 1))
        keep = np.ones(len(places), bool)
        keys = (now[places] + 1, *(one[places] for one in stored))
        for i, key in enumerate(zip(*(one.tolist() for one in keys), strict=True)):
            leader = self._seen.setdefault(key, int(flying[places[i]]))
            if leader != flying[places[i]]:
                self._follower[flying[places[i]]], keep[i] = leader, False
        places = places[keep]
        self._flying, self.now = flying[places], now[places] + 1
        return places

    def result(self) -> tuple[FloatArray, BoolArray]:
        """Flight times [h], and whether they outlast the days: then up to the end of the last."""
        _follow(self._hours, self._outlasts, self._follower, self.launch_h)
        return self._hours, self._outlasts


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
