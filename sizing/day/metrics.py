"""Metrics of a march: of one day of the year that repeats itself, the cycle, or of a flight.

Definitions (times in solar hours):

* ``equal_power_morning_h``, ``equal_power_evening_h``: first and last instant at which solar power
  equals the nominal load (the load without the extra power of thermals by day).
* ``excess_time_h``: the energy left at the morning's equal power, once the cycle repeats itself,
  would keep the aircraft airborne for so many more hours without any sun. Where the battery runs
  empty, it is minus the hours of the cycle in which the load cannot be met. Infinite where solar
  power never falls below the load.
* ``minimum_state_of_charge``: of the converged cycle; 0 where the battery runs empty.
* ``charge_margin_h``: from the first full charge to the last instant of full charge; 0 where full
  charge is not reached.

A flight from a launch with a full battery to a landing has the same metrics: its excess time is how
long what is left at the landing would last, or minus the hours without enough power.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from enum import IntEnum
from typing import Any, NamedTuple, cast

import numpy as np

from sizing.day.balance import (
    Cells,
    PowerBalance,
    crossing_fraction,
    interval_reaching,
    sum_over_time,
)
from sizing.day.march import DayRun, full_after_h
from solar.sun import HOURS_PER_DAY
from solar.types import BoolArray, FloatArray, IntArray

FULL = 1.0 - 1e-9  # state of charge that counts as full: what the clock's table resolves


class Status(IntEnum):
    """End of a cycle, or the reason for none; values are flags of gridded results.

    ``failed`` stands for an error of the program, ``infeasible`` for an aircraft that cannot fly
    the mission, ``invalid`` for values that no aircraft or mission can have; ``lands`` for a flight
    with enough power from its launch to its landing.
    """

    failed = -1
    limited = 0
    perpetual = 1
    always_lit = 2
    never_lit = 3
    infeasible = 4
    invalid = 5
    lands = 6


# Of a cycle that was computed; of a flight to a landing as well; and those with enough power.
CYCLE_ENDS = (Status.limited, Status.perpetual, Status.always_lit, Status.never_lit)
ENDS = (*CYCLE_ENDS, Status.lands)
SUFFICIENT = (Status.perpetual, Status.always_lit, Status.lands)


@dataclass(frozen=True)
class EnergyBudget:
    """Where the energy of one cycle goes [Wh]; arrays of the batch.

    ``solar + unserved = load + stored + charge_loss + discharge_loss + curtailed``.
    """

    solar_wh: FloatArray
    load_wh: FloatArray
    unserved_wh: FloatArray
    stored_wh: FloatArray
    charge_loss_wh: FloatArray
    discharge_loss_wh: FloatArray
    curtailed_wh: FloatArray


@dataclass(frozen=True)
class Cycle:
    """Metrics of a batch of converged cycles; times are solar hours, undefined ones are NaN."""

    status: IntArray
    excess_time_h: FloatArray
    minimum_state_of_charge: FloatArray
    charge_margin_h: FloatArray
    equal_power_morning_h: FloatArray
    equal_power_evening_h: FloatArray
    full_charge_h: FloatArray
    missing_h: FloatArray
    energy_budget: EnergyBudget
    time_h: FloatArray
    energy_wh: FloatArray

    @property
    def sufficient(self) -> BoolArray:
        """Mark the cycles with enough power: perpetual flight, and flights that land."""
        return np.isin(self.status, SUFFICIENT)

    @property
    def perpetual(self) -> BoolArray:
        """Mark the cycles of perpetual flight."""
        return np.isin(self.status, (Status.perpetual, Status.always_lit))

    def mapped(self, function: Callable[[Any], Any]) -> Cycle:
        """Return the cycle with a function of its arrays, but for the time."""
        return joined([self], lambda parts: function(parts[0]))

    def reshaped(self, batch: tuple[int, ...]) -> Cycle:
        """Return the cycle of a one-dimensional batch in another shape."""
        return self.mapped(lambda values: values.reshape(batch + values.shape[1:]))


def joined(cycles: Sequence[Cycle], join: Callable[[list[Any]], Any] = np.concatenate) -> Cycle:
    """Return a cycle of the arrays of several with one time axis, by default end to end."""

    def of(records: Sequence[Any]) -> Any:
        if not is_dataclass(first := records[0]):
            return join(list(records))
        names = [f.name for f in fields(first) if f.name != "time_h"]
        joint = {name: of([getattr(record, name) for record in records]) for name in names}
        return replace(first, **joint)  # type: ignore[type-var]  # of an instance

    return cast(Cycle, of(cycles))


class EqualPower(NamedTuple):
    """Instants of equal power [h], and the morning's place on the time axis."""

    morning_h: FloatArray
    evening_h: FloatArray
    morning_index: IntArray
    morning_fraction: FloatArray
    always_above: BoolArray


def equal_power(time_h: FloatArray, solar_w: FloatArray, nominal_w: FloatArray) -> EqualPower:
    """Return first rise and last fall of solar power through the nominal load.

    ``solar_w``: at the nodes, ``(time, element)`` [W]. NaN where there is no such instant: the
    power is then always, or never, enough.
    """
    below, columns = solar_w < nominal_w, np.arange(solar_w.shape[1])
    rise, rises = _marked_row(below[:-1] > below[1:])
    fall, falls = _marked_row(below[:-1] < below[1:], last=True)

    def crossing(row: IntArray) -> tuple[FloatArray, FloatArray]:
        left, right = (solar_w[node, columns] - nominal_w for node in (row, row + 1))
        fraction = crossing_fraction(left, right)
        return fraction, time_h[row] + fraction * (time_h[row + 1] - time_h[row])

    (fraction, morning_h), (_, evening_h) = crossing(rise), crossing(fall)
    return EqualPower(
        morning_h=np.where(rises, morning_h, np.nan),
        evening_h=np.where(falls, evening_h, np.nan),
        morning_index=rise,
        morning_fraction=fraction,
        always_above=~(below[0] | rises | falls),
    )


def _marked_row(marks: BoolArray, *, last: bool = False) -> tuple[IntArray, BoolArray]:
    """Return the first or last marked row of every column, 0 without any, and whether one is.

    Fast where marks are rare.
    """
    row, column = np.divmod(np.flatnonzero(marks), marks.shape[1])
    order, result = slice(None, None, 1 if last else -1), np.full(marks.shape[1], -1, np.intp)
    result[column[order]] = row[order]  # of equal columns the last one stays
    return np.maximum(result, 0), result >= 0


def measured(cells: Cells, run: DayRun, keep_trajectory: bool, climbs: bool = False) -> Cycle:
    """Return the metrics of a batch from the run of its day.

    The excess time is above zero for perpetual flight, and infinite where solar power never falls
    below the load; of a flight to a landing it is what is left then. ``climbs``: missing energy
    counts in hours of the nominal load at least, as no empty battery lifts anything.
    """
    balance, store, nominal = run.day.balance, run.store, cells.nominal_w
    lands = cells.in_flight is not None
    day = slice(np.searchsorted(cells.time_h, HOURS_PER_DAY, "right"))
    equal = equal_power(cells.time_h[day], cells.solar_w[day], nominal)
    nodes = run.energy_at_nodes_wh() if keep_trajectory else np.full((1, len(nominal)), np.nan)
    missing_h, unserved = _unserved(run)
    if climbs:
        missing_h = np.maximum(missing_h, unserved / nominal)
    budget = _energy_budget(cells, run, unserved)
    with np.errstate(divide="ignore", invalid="ignore"):
        last_wh = run.end_wh if lands else _dawn_wh(balance, run, equal)
        left_over = last_wh * store.discharge_efficiency
        reserve_h = np.where(nominal > 0.0, left_over / nominal, np.inf)
    if cells.in_flight is not None:  # a day without light has no sunrise to begin a flight
        reserve_h = np.where(cells.in_flight.any(axis=0), reserve_h, 0.0)
    lowest = np.minimum(np.minimum.reduce(run.drained_wh, axis=0, initial=np.inf), run.end_wh)
    first_full, last_full = _full_charge_h(balance, run)
    # A last digit of unserved energy may be left by the fixed point's tolerance.
    runs_empty = unserved > 1e-9 * store.battery_energy_wh
    never = np.isnan(equal.morning_h) & ~equal.always_above & (not lands)
    always = equal.always_above & ~runs_empty & (not lands)
    excess = np.where(runs_empty | never, -missing_h, reserve_h)
    excess = np.where(always, np.inf, excess)
    status = np.where(excess > 0.0, Status.lands if lands else Status.perpetual, Status.limited)
    if not lands:
        status = np.where(always, Status.always_lit, status)
        status = np.where(budget.solar_wh > 0.0, status, Status.never_lit)
    state_of_charge = np.maximum(lowest, 0.0) / store.battery_energy_wh
    return Cycle(
        status=status,
        excess_time_h=excess,
        minimum_state_of_charge=np.where(excess > 0.0, state_of_charge, 0.0),
        charge_margin_h=np.where(np.isnan(first_full), 0.0, last_full - first_full),
        equal_power_morning_h=equal.morning_h,
        equal_power_evening_h=equal.evening_h,
        full_charge_h=first_full,
        missing_h=missing_h,
        energy_budget=budget,
        time_h=cells.time_h,
        energy_wh=nodes.T,
    )


def _dawn_wh(balance: PowerBalance, run: DayRun, equal: EqualPower) -> FloatArray:
    """Return the stored energy at the morning's equal power [Wh].

    That at midnight where there is no such instant.
    """
    index, fraction = equal.morning_index, equal.morning_fraction
    columns = np.arange(len(index))
    left, right = balance.net_w[index, columns], balance.net_w[index + 1, columns]
    hours = balance.time_h[index + 1] - balance.time_h[index]
    middle = left + (right - left) * fraction
    mean_deficit_w = np.maximum(-(left + middle) / 2.0, 0.0)
    drained = mean_deficit_w * fraction * hours / run.store.discharge_efficiency
    return np.maximum(run.energy_at_node_wh(index) - drained, 0.0)


def _unserved(run: DayRun) -> tuple[FloatArray, FloatArray]:
    """Return the hours and the energy [Wh] in which the load is not met.

    A battery that runs empty stays so until the next surplus, or midnight: the energy
    missing by then gives the instant.
    """
    day, balance, count = run.day, run.day.balance, len(run.start_wh)
    row, cells = np.divmod(np.flatnonzero(run.drained_wh < 0.0), count)
    midnight = run.midnight_wh
    dark = np.flatnonzero(midnight < 0.0)
    if not len(cells) and not len(dark):
        return np.zeros(count), np.zeros(count)
    falls_first = balance.net_w[row + day.first, cells] < 0.0
    at_midnight = np.full(len(dark), len(balance.time_h) - 1)
    until = np.concatenate((row + day.first + falls_first, at_midnight))
    below_empty = np.concatenate((run.drained_wh[row, cells], midnight[dark]))
    cells = np.concatenate((cells, dark))
    missing_wh = -np.broadcast_to(run.store.discharge_efficiency, (count,))[cells] * below_empty
    level = np.maximum(day.cumulative_deficit_wh[until, cells] - missing_wh, 0.0)
    number = np.minimum(interval_reaching(day.cumulative_deficit_wh, level, cells), until - 1)
    rest = np.clip(day.cumulative_deficit_wh[number + 1, cells] - level, 0.0, None)
    without_h = balance.interval(number, cells).deficit_parts_h(rest)[1]
    hours = balance.cumulative_deficit_h()
    missing = np.where(rest > 0.0, without_h, 0.0)
    missing = missing + hours[until, cells] - hours[number + 1, cells]
    return (
        np.bincount(cells, missing, minlength=count).astype(float),
        np.bincount(cells, missing_wh, minlength=count).astype(float),
    )


def _full_charge_h(balance: PowerBalance, run: DayRun) -> tuple[FloatArray, FloatArray]:
    """Return first and last instant of full charge by the clock [h], NaN where there is none."""
    full = (run.after_charge_wh >= FULL * run.store.battery_energy_wh) & (run.day.surplus_wh > 0.0)
    if not len(full):
        none = np.full(len(run.start_wh), np.nan)
        return none, none
    begins, ends = full.copy(), full.copy()
    begins[1:] = full[1:] > full[:-1]
    ends[:-1] = full[:-1] > full[1:]
    (begin, begins_once), (end, ends_once) = _marked_row(begins), _marked_row(ends, last=True)
    columns = np.arange(len(begin))
    interval = balance.interval(begin + run.day.first, columns)
    before = np.maximum(run.drained_wh[begin, columns], 0.0)
    first = interval.start_h + full_after_h(interval, run.store, before)
    interval = balance.interval(end + run.day.first, columns)
    last = interval.start_h + interval.surplus_h()[1]
    return np.where(begins_once, first, np.nan), np.where(ends_once, last, np.nan)


def _energy_budget(cells: Cells, run: DayRun, unserved_wh: FloatArray) -> EnergyBudget:
    store = run.store
    before = np.maximum(run.drained_wh, 0.0)
    into_store = sum_over_time(np.subtract(run.after_charge_wh, before, out=before))
    stored = run.end_wh - run.start_wh
    drawn = into_store - stored
    taken = into_store / store.charge_efficiency
    return EnergyBudget(
        solar_wh=_integral_wh(cells, cells.solar_w),
        load_wh=_integral_wh(cells, cells.load_w),
        unserved_wh=unserved_wh,
        stored_wh=stored,
        charge_loss_wh=taken - into_store,
        discharge_loss_wh=drawn * (1.0 - store.discharge_efficiency),
        curtailed_wh=run.day.total_surplus_wh - taken,
    )


def _integral_wh(cells: Cells, power_w: FloatArray) -> FloatArray:
    """Return the integral over the time in flight by the trapezoidal rule."""
    halves = cells.of_flight(np.diff(cells.time_h)[:, np.newaxis] / 2.0)
    weights = np.pad(halves, ((1, 0), (0, 0))) + np.pad(halves, ((0, 1), (0, 0)))
    alike = power_w.strides[1] == 0  # in all elements
    sums = sum_over_time(weights * (power_w[:, :1] if alike else power_w))
    return np.broadcast_to(sums, power_w.shape[1:])
