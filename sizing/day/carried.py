"""Days that follow each other, each with its own light, the charge carried over from day to day.

A day is an element of the batch: all are marched at once, each from a full battery, and those again
that the day before leaves with another charge than they were begun with, until there are none. A
battery that was full or empty on a day remembers nothing of the days before, so that this ends
soon; nothing is approximated but what :mod:`sizing.day.march` approximates.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sizing.day.balance import crossing_fraction, running_sum
from sizing.day.battery import Store
from sizing.day.march import SHORT, ChargingDay, DayRun
from solar.types import BoolArray, FloatArray


class Dawns(NamedTuple):
    """When the charge of each night is least: where a day begins; arrays of the days.

    ``hour``: hours after the start of the day [h]. ``deficit_wh``: cumulative deficit from the
    start of the day until then [Wh].
    """

    hour: FloatArray
    deficit_wh: FloatArray


def dawns_of(day: ChargingDay, store: Store, noon_h: FloatArray | float) -> Dawns:
    """Dawns: when, from midnight to the last node before noon, the charge is least.

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


@dataclass(frozen=True)
class CarriedDays:
    """Run of a battery over consecutive days, and whether each lasts from dawn to dawn."""

    run: DayRun

    def runs_empty(self, dawns: Dawns) -> tuple[BoolArray, BoolArray]:
        """Whether each day's battery is empty before its dawn, and after it.

        Both are true where it is empty before dawn and stays so.
        """
        run, day, eta = self.run, self.run.day, self.run.store.discharge_efficiency
        least = -SHORT * run.store.battery_energy_wh
        # What is not served is the end of a deficit: from the level at which the battery is empty
        # up to that at which the next surplus, or the day's end, comes.
        ends = np.vstack([day.deficit_before_surplus_wh, day.cumulative_deficit_wh[-1:]])
        drained_wh = np.vstack([run.drained_wh, run.midnight_wh])
        short, begins = drained_wh < least, ends + eta * drained_wh
        before = np.any(short & (begins < dawns.deficit_wh), axis=0)
        return before, np.any(short & (ends > dawns.deficit_wh), axis=0)

    def closes(self, dawns: Dawns) -> BoolArray:
        """Whether each day's battery lasts from its dawn to the next day's, the last to its end."""
        before, after = self.runs_empty(dawns)
        return np.asarray(~(after | np.append(before[1:], False)))

    def energy_at_wh(self, hour: FloatArray) -> FloatArray:
        """Stored energy at an hour of each day [Wh], straight lines between the nodes."""
        time, values = self.run.day.balance.time_h, self.run.energy_at_nodes_wh()
        number = np.clip(np.searchsorted(time, hour, side="right") - 1, 0, len(time) - 2)
        cells = np.arange(len(hour))
        share = np.clip((hour - time[number]) / (time[number + 1] - time[number]), 0.0, 1.0)
        low, high = values[number, cells], values[number + 1, cells]
        return np.asarray(low + share * (high - low))


def carried_over(day: ChargingDay, store: Store, start_wh: float) -> CarriedDays:
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
        found = end[:-1] * (full[1:] / full[:-1])
        others = 1 + np.flatnonzero(found != start[1:])
        start[1:] = found
    return CarriedDays(day.run(store, start))
