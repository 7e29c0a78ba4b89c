"""A flight through a weather record: the days as they came, the charge carried over.

Every day has its light and temperature, and begins with the charge that the day before has left.
An empty battery ends a flight; the run goes on from empty, so that every day of the record is
judged by what came before it. A battery whose capacity depends on its temperature has each day that
of the day's mean air, and keeps its state of charge over night.

A day is an element of the batch: all are marched at once, each from a full battery, and those again
that the day before leaves with another charge than they were begun with, until there are none. A
battery that was full or empty on a day remembers nothing of the days before, so that this ends
soon; nothing is approximated but what :mod:`sizing.day.march` approximates.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from missions.mission import Mission
from missions.weather.light import NODE_STEP_S, DayAxis
from missions.weather.record import Weather, longest_run
from sizing.aircraft import Aircraft
from sizing.day.balance import PowerBalance, crossing_fraction, running_sum
from sizing.day.battery import Store
from sizing.day.light import UNCORRECTED_CAM, SolarModel
from sizing.day.march import ChargingDay, DayRun
from sizing.day.record_conditions import WeatherDays
from sizing.design import Design
from sizing.mass_budget import design_of
from solar.clearsky import Irradiance
from solar.sun import HOURS_PER_DAY
from solar.types import BoolArray, FloatArray


@dataclass(frozen=True)
class WeatherRun:
    """Charge of an aircraft through a record, in its light or under a clear sky.

    ``axis``: days of the record. ``solar_power_w``, ``load_w``: power at the nodes [W].
    ``store``: batteries of all days; ``energy_wh``: in them at the nodes [Wh]. ``dawn_h``: when,
    from midnight to noon, the charge is least, hours after the day's first node [h]
    (:func:`dawns_of`). ``closes``: whether a day, begun at dawn with
    what is carried over, reaches the next dawn (of the last day: the end of the record) without an
    empty battery. ``dawn_state_of_charge``: state of charge at dawn [-]. ``endurance_h``: flight
    time of a launch with a full battery at each dawn [h]; where ``outlasts``, up to the end of the
    record. ``outlasts``: whether that flight outlasts the record.
    """

    axis: DayAxis
    solar_power_w: FloatArray
    load_w: FloatArray
    store: Store
    energy_wh: FloatArray
    dawn_h: FloatArray
    closes: BoolArray
    dawn_state_of_charge: FloatArray
    endurance_h: FloatArray
    outlasts: BoolArray

    @property
    def longest_run_days(self) -> int:
        """Return the largest number of consecutive days that close."""
        return longest_run(self.closes)

    def state_of_charge(self) -> FloatArray:
        """Return the state of charge at the nodes [-], ``(day, node)``."""
        return np.asarray(self.energy_wh / self.store.battery_energy_wh[:, np.newaxis])


@dataclass(frozen=True)
class WeatherPerformance:
    """An aircraft in the light of a weather record, and under a clear sky in the same air."""

    days: WeatherDays
    design: Design
    recorded: WeatherRun
    clear: WeatherRun


def weather_performance(
    aircraft: Aircraft,
    mission: Mission,
    weather: Weather,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    step_s: float = NODE_STEP_S,
) -> WeatherPerformance:
    """Simulate an aircraft through a weather record, from a full battery at its beginning.

    ``mission``: at the record's site (:func:`missions.weather.files.mission_at_site`): altitude,
    air, turbulence, payload, margins. Its clearness plays no part: the clouds are the record's.
    """
    days = WeatherDays.of(aircraft, mission, weather, solar, step_s=step_s)
    design = design_of(aircraft, mission)
    load_w = days.load_w(design)
    recorded, clear = (
        weather_run(days, design, load_w, sky) for sky in (days.light.recorded, days.light.clear)
    )
    return WeatherPerformance(days, design, recorded, clear)


def weather_run(
    record: WeatherDays, design: Design, load_w: FloatArray, sky: Irradiance
) -> WeatherRun:
    """Simulate a design through a record under a sky, that of the record or a clear one."""
    axis, store = record.axis, record.store(design.battery_energy_wh)
    solar_w = record.aircraft.modules.area_m2 * record.specific_power_w_per_m2(sky)
    energy_wh, days = store.battery_energy_wh, np.arange(len(axis))
    day = ChargingDay.of(PowerBalance.of(axis.time_h, (solar_w - load_w).T))
    run = carried_over(day, store, energy_wh[0])
    dawns = dawns_of(day, store, HOURS_PER_DAY / 2.0 - axis.midnight_h)
    hours = flight_hours(day, store, run, dawns.hour)
    outlasts = np.isinf(hours)
    to_the_end_h = (len(axis) - days) * HOURS_PER_DAY - dawns.hour
    return WeatherRun(
        axis=axis,
        solar_power_w=solar_w,
        load_w=load_w,
        store=store,
        energy_wh=run.energy_at_nodes_wh().T,
        dawn_h=dawns.hour,
        closes=days_that_close(run, dawns),
        dawn_state_of_charge=run.energy_at_wh(dawns.hour) / energy_wh,
        endurance_h=np.where(outlasts, to_the_end_h, hours),
        outlasts=outlasts,
    )


class Dawns(NamedTuple):
    """Where days begin: hours, and the cumulative deficit, from the start of the day [h, Wh]."""

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


def flight_hours(day: ChargingDay, store: Store, run: DayRun, launch_h: FloatArray) -> FloatArray:
    """Return the flight time of launches with a full battery on every day [h].

    ``run``: charge that is carried over: a flight that begins a day with as much ends with it.
    ``launch_h``: hours after the start of each day. Infinite where the days end before the flight.
    """
    days, full_wh = np.arange(len(launch_h)), store.battery_energy_wh
    # First on a day or later, of the run that is carried over.
    known_h = day.flights(days, store, run.start_wh, np.zeros(len(days)))[0] + HOURS_PER_DAY * days
    known_h = np.minimum.accumulate(np.nan_to_num(known_h, nan=np.inf)[::-1])[::-1]
    end_h, flights, today = np.full(len(days), np.inf), days, days
    energy_wh, settled_wh = np.array(full_wh), day.deficit_until_wh(launch_h, days)
    while len(flights):
        empty_h, midnight_wh, _ = day.flights(today, store, energy_wh, settled_wh)
        empty = ~np.isnan(empty_h)
        end_h[flights[empty]] = (HOURS_PER_DAY * today + empty_h)[empty]
        goes_on = ~empty & (today + 1 < len(days))
        flights, today = flights[goes_on], today[goes_on] + 1
        energy_wh = midnight_wh[goes_on] * (full_wh[today] / full_wh[today - 1])
        joins = energy_wh == run.start_wh[today]
        end_h[flights[joins]] = known_h[today[joins]]
        flights, today, energy_wh = flights[~joins], today[~joins], energy_wh[~joins]
        settled_wh = np.zeros(len(flights))
    return np.asarray(end_h - HOURS_PER_DAY * days - launch_h)
