"""Endurance: the longest flight over all launch times that starts full and ends empty.

One day of the year repeats; a flight is marched from its launch until the battery cannot meet the
load. Flight time jumps where one more night is just survived and is smooth elsewhere: a coarse
search over the launch time, refined twice around the best one, finds the longest flight to within
seconds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from sizing.energy_balance import (
    FloatArray,
    Interval,
    PowerBalance,
    Store,
    advance,
    empty_after_h,
    positive_part_wh,
)

HOURS_PER_DAY = 24.0
MAXIMUM_DAYS = 366.0
_LAUNCHES = 61
_REFINEMENTS = 2


@dataclass(frozen=True)
class Endurance:
    """Longest flight [h] and the solar time of its launch [h, 0 to 24]; arrays of the batch."""

    endurance_h: FloatArray
    launch_h: FloatArray


def longest_flight(
    time_h: ArrayLike, solar_power_w: ArrayLike, load_w: ArrayLike, store: Store
) -> Endurance:
    """Longest flights of a batch that starts with full batteries.

    Parameters
    ----------
    time_h, solar_power_w, load_w, store
        One day as in :func:`sizing.cycle.simulate_cycle`, batch of one dimension or none.

    Returns
    -------
    Endurance
        Infinite where the flight outlasts 366 days, as a perpetual one does.
    """
    balance = PowerBalance.of(np.asarray(time_h, float), *_arrays(solar_power_w, load_w))
    centre: FloatArray = np.full(balance.batch_shape, HOURS_PER_DAY / 2.0)
    reach = HOURS_PER_DAY / 2.0
    for _ in range(1 + _REFINEMENTS):
        offsets = np.linspace(-reach, reach, _LAUNCHES).reshape((-1,) + (1,) * centre.ndim)
        launch = (centre + offsets) % HOURS_PER_DAY
        hours = flight_time_h(balance, store, launch)
        pick = np.argmax(hours, axis=0)[np.newaxis]
        centre = np.take_along_axis(launch, pick, axis=0)[0]
        endurance = np.take_along_axis(hours, pick, axis=0)[0]
        reach = 2.0 * reach / (_LAUNCHES - 1)
    return Endurance(endurance, centre)


def flight_time_h(balance: PowerBalance, store: Store, launch_h: FloatArray) -> FloatArray:
    """Flight time [h] until the battery is empty, from launches with a full battery.

    ``launch_h`` is the solar time of the launches on the first day, launches on the first axis and
    the batch on the others.
    """
    energy = np.broadcast_to(store.energy_max_wh, launch_h.shape)
    full = energy
    end_h = np.full(launch_h.shape, np.nan)
    skipped_h = np.zeros(launch_h.shape)
    losses = np.full(launch_h.shape, np.nan)
    endless = np.zeros(launch_h.shape, bool)
    day = 0
    while np.any(np.isnan(end_h) & ~endless) and day <= MAXIMUM_DAYS:
        start, lowest = energy, energy
        for plain in balance.intervals():
            interval = _after_launch(plain, launch_h) if day == 0 else plain
            step = advance(store, interval, energy)
            emptied = np.isnan(end_h) & (step.unserved_wh > 1e-12 * full)
            if np.any(emptied):
                begun_h = plain.start_h + plain.hours - interval.hours
                instant = day * HOURS_PER_DAY + begun_h + empty_after_h(step)
                end_h = np.where(emptied, instant, end_h)
            energy = step.end_wh
            lowest = np.minimum(lowest, np.minimum(step.before_charge_wh, energy))
        loss = start - energy
        days = _days_alike(day, loss, losses, lowest, full)
        energy, skipped_h = energy - days * loss, skipped_h + days * HOURS_PER_DAY
        # From the second day on, a day that gives back what it takes repeats for ever.
        endless = (day >= 2) & np.isnan(end_h) & (loss <= 1e-11 * full)
        losses, day = loss, day + 1
    flown = end_h + skipped_h - launch_h
    return np.where(np.isnan(flown) | (flown > MAXIMUM_DAYS * HOURS_PER_DAY), np.inf, flown)


def _days_alike(
    day: int, loss: FloatArray, previous: FloatArray, lowest: FloatArray, full: FloatArray
) -> FloatArray:
    """How many whole days to skip where every day loses the same energy."""
    alike = (day >= 2) & (np.abs(loss - previous) <= 1e-9 * full) & (loss > 1e-9 * full)
    days = np.floor(lowest / np.where(alike, loss, 1.0)) - 1.0
    return np.where(alike, np.clip(days, 0.0, MAXIMUM_DAYS), 0.0)


def _after_launch(interval: Interval, launch_h: FloatArray) -> Interval:
    """Part of an interval that lies after the launches; empty where it is over before."""
    fraction = np.clip((launch_h - interval.start_h) / interval.hours, 0.0, 1.0)
    hours = interval.hours * (1.0 - fraction)
    left = interval.left_w + (interval.right_w - interval.left_w) * fraction
    deficit = positive_part_wh(-left, -interval.right_w, hours)
    early = np.where(left < 0.0, deficit, 0.0)
    return interval._replace(
        hours=hours,
        left_w=left,
        surplus_wh=positive_part_wh(left, interval.right_w, hours),
        early_deficit_wh=early,
        late_deficit_wh=deficit - early,
    )


def _arrays(solar_power_w: ArrayLike, load_w: ArrayLike) -> tuple[FloatArray, FloatArray]:
    return np.asarray(solar_power_w, float), np.asarray(load_w, float)
