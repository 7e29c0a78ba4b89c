"""Days from an empty battery: how long the repeated day takes to settle, and flights of some days.

The metrics of :mod:`sizing.energy.cycle` are those of a day repeated without end. Near the limit of
perpetual flight hardly any energy is gained from day to day, and a battery that was empty at the
morning's equal power takes hundreds of identical days to settle. Seasons do not wait that long:
:func:`days_to_settle` counts them, and :func:`simulate_days` flies a given number of days on which
the date advances.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from sizing.energy.battery import Store
from sizing.energy.cycle import Cycle, dawn_wh, equal_power, measured
from sizing.energy.march import ChargingDay, repeated_day
from sizing.energy.power_balance import Cells
from solar.types import FloatArray

# Of the battery's energy: charge at the morning's equal power that counts as that of the fixed
# point. 10 minutes of a load that empties the battery in 17 h; the solar power is known less well.
SETTLED = 0.01
MAXIMUM_DAYS = 366
# Of the battery's energy: gains of two days that count as the same.
_SAME_GAIN = 1e-11


def days_to_settle(
    time_h: ArrayLike,
    solar_power_w: ArrayLike,
    load_w: ArrayLike,
    store: Store,
    *,
    nominal_load_w: ArrayLike | None = None,
) -> FloatArray:
    """Days that the repeated day needs to settle from an empty battery, at least 1.

    The battery is empty at the morning's equal power, and the same day is flown again and again.
    Counted are the days until the charge at that instant is within 1 % of the battery's energy of
    what it becomes in the end.

    The energy gained on a day never rises with the charge (a fuller battery is charged no faster).
    So the gain of today tells how many days are needed at least; and where the gain before a day
    to come is that of today, all the days in between have gained the same, and are skipped.

    The day is as in :func:`sizing.energy.cycle.simulate_cycle`. Infinite beyond 366 days, and NaN
    where there is no equal power in the morning.
    """
    cells, batch = Cells.of(time_h, solar_power_w, load_w, store, nominal_load_w)
    equal = equal_power(cells.time_h, cells.above_nominal_w())
    days = np.where(np.isnan(equal.morning_h), np.nan, np.inf)
    left = np.flatnonzero(~np.isnan(equal.morning_h))
    if len(left):
        days[left] = _counted(cells.select(left))
    return days.reshape(batch)


def _counted(cells: Cells) -> FloatArray:
    """Days to settle of a batch with equal power in the morning of every element."""
    count = len(cells.nominal_w)
    days, places = np.full(count, np.inf), np.arange(count)
    number, stride = np.ones(count), np.ones(count)
    equal = equal_power(cells.time_h, cells.above_nominal_w())
    day = ChargingDay.of(cells.balance)
    target = dawn_wh(cells.balance, repeated_day(day, cells.store), equal)
    energy = _evening_of_the_launch(cells)
    while True:
        run = day.run(cells.store, energy)
        dawn = dawn_wh(cells.balance, run, equal)
        missing = target - dawn - SETTLED * cells.store.battery_energy_wh
        settled = missing <= 0.0
        days[places[settled]] = number[settled]
        gain = np.maximum(run.end_wh - energy, 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            at_least = np.where(settled, 0.0, np.ceil(missing / gain))
        kept = np.flatnonzero(~settled & (number + at_least <= MAXIMUM_DAYS))
        if not len(kept):
            return days
        if len(kept) < len(places):
            cells, places, target = cells.select(kept), places[kept], target[kept]
            day = ChargingDay.of(cells.balance)
            equal = equal_power(cells.time_h, cells.above_nominal_w())
            number, stride, energy, gain, at_least = (
                v[kept] for v in (number, stride, energy, gain, at_least)
            )
        skipped = np.minimum(stride, at_least) - 1.0
        before = energy + skipped * gain
        after = day.end_wh(cells.store, before)
        same = after - before >= gain - _SAME_GAIN * cells.store.battery_energy_wh
        forward = same | (skipped == 0.0)
        number = np.where(forward, number + skipped + 1.0, number)
        energy = np.where(forward, after, energy)
        stride = np.where(same, 2.0 * stride, np.maximum(np.floor(stride / 4.0), 1.0))


def _evening_of_the_launch(cells: Cells) -> FloatArray:
    """Energy at midnight after a day on which the battery was empty at equal power [Wh]."""
    equal = equal_power(cells.time_h, cells.above_nominal_w())
    balance = cells.balance
    flown = np.arange(len(cells.time_h) - 1)[:, np.newaxis] >= equal.morning_index
    day = ChargingDay.of(replace(balance, surplus_wh=np.where(flown, balance.surplus_wh, 0.0)))
    return day.end_wh(cells.store, np.zeros(len(cells.nominal_w)))


def simulate_days(
    time_h: ArrayLike,
    solar_power_w: Sequence[ArrayLike],
    load_w: Sequence[ArrayLike],
    store: Store,
    *,
    nominal_load_w: ArrayLike | None = None,
    keep_trajectory: bool = True,
) -> Cycle:
    """Fly some days on which the date advances, from an empty battery.

    The flight begins at the first day's equal power in the morning with an empty battery. What is
    measured is the last day, from midnight to midnight, as :func:`simulate_cycle` measures the
    repeated day: its excess time is that of the charge at its morning's equal power. It need not
    end with the energy it began with: the difference is the ``stored_wh`` of the energy budget.

    ``solar_power_w``, ``load_w``: of each date, of which the last is measured; the rest as for
    :func:`simulate_cycle`. ``keep_trajectory``: of the last day.
    """
    if len(solar_power_w) < 2:
        raise ValueError(f"at least two dates are needed (got {len(solar_power_w)})")
    energy: FloatArray | None = None
    *before, last = zip(solar_power_w, load_w, strict=True)
    for solar, load in before:
        cells, _ = Cells.of(time_h, solar, load, store, nominal_load_w)
        energy = (
            _evening_of_the_launch(cells)
            if energy is None
            else ChargingDay.of(cells.balance).end_wh(cells.store, energy)
        )
    assert energy is not None
    cells, batch = Cells.of(time_h, *last, store, nominal_load_w)
    run = ChargingDay.of(cells.balance).run(cells.store, energy)
    return measured(cells, run, keep_trajectory).reshaped(batch)
