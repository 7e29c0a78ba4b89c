"""Days that follow each other, each in its light, the charge carried over from day to day.

A day is an element of the batch: all are marched at once, each from a full battery, and those again
that the day before leaves with another charge than they were begun with, until there are none. A
battery that was full or empty on a day remembers nothing of the days before, so that this ends
soon; nothing is approximated but what :mod:`sizing.day.march` approximates.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sizing.day.balance import crossing_fraction, running_sum
from sizing.day.battery import Store
from sizing.day.march import ChargingDay, DayRun
from solar.types import BoolArray, FloatArray


class Dawns(NamedTuple):
    """Instants of the least charge of each night, where a day begins; arrays of the days.

    ``hour``: hours after the start of the day [h]. ``deficit_wh``: cumulative deficit from the
    start of the day until then [Wh].
    """

    hour: FloatArray
    deficit_wh: FloatArray


def dawns_of(day: ChargingDay, store: Store, noon_h: FloatArray | float) -> Dawns:
    """Return when, from midnight to the last node before noon, the charge is least.

    The charge is that of a battery which is neither full nor empty: surplus times charge
    efficiency less deficit over discharge efficiency, summed up from midnight. A surplus that a
    longer deficit eats up again before noon is no dawn. Under a clear sky it is the morning's equal
    power.

    ``noon_h``: hours from the start of each day, about midnight, to its noon [h].
    """
    time, net, deficit = day.balance.time_h, day.balance.net_w, day.balance.deficit_wh
    noon = np.broadcast_to(noon_h, net.shape[1:])
    rows = max(int(np.searchsorted(time, noon.max(), side="right")) - 1, 1)
    gain = store.charge_efficiency * day.balance.surplus_wh[:rows]
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


def runs_empty(run: DayRun, dawns: Dawns) -> tuple[BoolArray, BoolArray]:
    """Return whether each day's battery is empty before its dawn, and after it."""
    begins_wh, ends_wh = run.shortfalls_wh()
    before = np.any(begins_wh < dawns.deficit_wh, axis=0)
    return before, np.any(ends_wh > dawns.deficit_wh, axis=0)


def days_that_close(run: DayRun, dawns: Dawns) -> BoolArray:
    """Return whether each day's battery lasts from its dawn to the next one, or to the end."""
    before, after = runs_empty(run, dawns)
    return np.asarray(~(after | np.append(before[1:], False)))


def carried_over(day: ChargingDay, store: Store, start_wh: float) -> DayRun:
    """March a battery through consecutive days.

    ``day``: the days, of which the last node of one is the first of the next. ``store``: the
    battery on each; one that is colder the next day keeps its state of charge, not its energy.
    ``start_wh``: stored energy at the start of the first day [Wh].
    """
    full = store.battery_energy_wh
    start, end = np.array(full), np.empty(full.shape)
    start[0] = start_wh
    others = np.arange(len(full))
    while len(others):
        end[others] = day.select(others).end_wh(store.select(others), start[others])
        carried = end[:-1] * (full[1:] / full[:-1])
        others = 1 + np.flatnonzero(carried != start[1:])
        start[1:] = carried
    return day.run(store, start)
