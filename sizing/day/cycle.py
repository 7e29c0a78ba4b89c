"""Days that repeat themselves, and flights from a launch to a landing, measured alike."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from sizing.day.balance import Cells, blocks
from sizing.day.battery import Store
from sizing.day.march import ChargingDay, DayRun
from sizing.day.metrics import Cycle, joined, measured
from sizing.roots import bracketed_root
from solar.types import FloatArray, IntArray

# Elements of a batch simulated at once: a day of each array stays near the processor.
CELLS_AT_ONCE = 2048
_FLIGHTS_AT_ONCE = 128  # each may add two nodes to the time axis of all
# Of the battery's energy: change of the stored energy over a day that counts as none.
_SETTLED = 1e-11


def simulate_cycle(
    time_h: ArrayLike,
    solar_power_w: ArrayLike,
    load_w: ArrayLike,
    store: Store,
    *,
    nominal_load_w: ArrayLike | None = None,
    keep_trajectory: bool = True,
    climbs: bool = False,
    window_h: tuple[FloatArray, FloatArray] | None = None,
) -> Cycle:
    """Simulate a batch of days that repeat themselves, or of flights that land, and measure them.

    The result of an element does not depend on the others, to the last digit.

    Parameters
    ----------
    time_h : array_like, shape (time,)
        Nodes over one day, 0 to 24 [h], both ends included; over several days of flights.
    solar_power_w : array_like, shape (..., time)
        Electric power of the modules [W].
    load_w : array_like
        Power that the aircraft draws [W], broadcasting with ``solar_power_w``.
    store : Store
        Batteries; ``battery_energy_wh`` broadcasts with the batch ``...``.
    nominal_load_w : array_like, shape (...), optional
        Load that defines equal power and excess time [W]; the smallest load of the day if omitted.
    keep_trajectory : bool
        Keep the stored energy over time; without it ``energy_wh`` is NaN at a single instant.
    climbs : bool
        Whether the load has climbs, see :func:`sizing.day.metrics.measured`.
    window_h : tuple of ndarray, optional
        Launch with a full battery and landing [h], which broadcast with the batch, of flights; by
        default a day is repeated until it ends as it began.

    Returns
    -------
    Cycle
        Arrays of shape ``...``; ``energy_wh`` has a last axis of ``time``.
    """
    cells, batch = Cells.of(time_h, solar_power_w, load_w, store, nominal_load_w)
    if window_h is not None:
        launch_h, land_h = (np.broadcast_to(hour, batch) for hour in window_h)
        return _flights(cells, (launch_h, land_h), keep_trajectory).reshaped(batch)
    # In blocks; elements that do not settle at once come last, together.
    parts, late, highest_wh = [], [], []
    for part in blocks(len(cells.nominal_w), CELLS_AT_ONCE):
        block = cells.select(part)
        run, unsettled = first_repetition(ChargingDay.of(block.balance), block.store)
        parts.append(measured(block, run, keep_trajectory, climbs))
        late.append(part.start + unsettled)
        highest_wh.append(np.maximum(run.start_wh, run.end_wh)[unsettled])
    if not len(places := np.concatenate(late)):
        return joined(parts).reshaped(batch)
    block = cells.select(places)
    day = ChargingDay.of(block.balance)
    run = day.run(block.store, repeated_wh(day, block.store, np.concatenate(highest_wh)))
    parts.append(measured(block, run, keep_trajectory, climbs))
    index = np.arange(len(cells.nominal_w))
    index[places] = len(index) + np.arange(len(places))
    return joined(parts).mapped(lambda values: values[index]).reshaped(batch)


def _flights(cells: Cells, window_h: tuple[FloatArray, FloatArray], keep_trajectory: bool) -> Cycle:
    """March a batch from launch with a full battery to landing, and measure it.

    The energy of the nodes before the launch is that of the launch, after the landing that of it.
    """
    count, parts = len(cells.nominal_w), []
    launch_h, land_h = (np.ravel(hour) for hour in window_h)
    for part in blocks(count, _FLIGHTS_AT_ONCE):
        flight = cells.select(part).between(launch_h[part], land_h[part])
        full_wh = np.asarray(flight.store.battery_energy_wh, float)
        run = ChargingDay.of(flight.balance).run(flight.store, full_wh)
        cycle = measured(flight, run, keep_trajectory)
        kept = np.searchsorted(flight.time_h, cells.time_h) if keep_trajectory else slice(None)
        parts.append(replace(cycle, time_h=cells.time_h, energy_wh=cycle.energy_wh[:, kept]))
    return joined(parts)


def first_repetition(day: ChargingDay, store: Store) -> tuple[DayRun, IntArray]:
    """Return the run of a day that nearly always ends as it began, and the elements that do not.

    The energy after a cycle never falls, and rises by at most as much, when that before it rises
    (a fuller battery is charged no faster), so there is one fixed point, and repeating the cycle
    from an empty battery leads to it. A cycle whose deficit exceeds all that could be stored
    passes through an empty battery, and from there one day leads to the fixed point: it is marched
    from a battery that holds at nightfall all that could be stored. Any other cycle is marched from
    a full battery at nightfall; most fill it again within the day. The few that are left are
    searched for by :func:`repeated_wh`.

    Start and end agree to 1e-11 of the battery's energy.
    """
    full = store.battery_energy_wh
    storable = store.charge_efficiency * day.total_surplus_wh
    loses = storable * store.discharge_efficiency < day.cumulative_deficit_wh[-1]
    at_nightfall_wh = np.where(loses, np.minimum(storable, full), full)
    settled_wh = np.maximum(day.nightfall_deficit_wh, 0.0)
    run = day.run(store, np.maximum(day.midnight_wh(store, at_nightfall_wh, settled_wh), 0.0))
    return run, np.flatnonzero(np.abs(run.end_wh - run.start_wh) > _SETTLED * full)


def repeated_wh(day: ChargingDay, store: Store, highest_wh: FloatArray) -> FloatArray:
    """Return the energy with which a day starts and ends, between zero and ``highest_wh`` [Wh]."""

    def gain(energy_wh: FloatArray) -> FloatArray:
        return day.end_wh(store, energy_wh) - energy_wh

    empty_wh = np.zeros_like(highest_wh)
    root = bracketed_root(gain, empty_wh, highest_wh, _SETTLED)
    # By rounding a day may gain, or lose, at both ends.
    return np.where(np.isnan(root), np.where(gain(empty_wh) > 0.0, highest_wh, empty_wh), root)
