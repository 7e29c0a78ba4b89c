"""A flight through a weather record: the days as they came, the charge carried over.

Every day has its light and temperature, and begins with the charge that the day before has left.
An empty battery ends a flight; the run goes on from empty, so that every day of the record is
judged by what came before it. A battery whose capacity depends on its temperature has each day that
of the day's mean air, and keeps its state of charge over night.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from missions.mission import Mission
from missions.weather.days import DayAxis
from missions.weather.light import NODE_STEP_S, RecordedLight
from missions.weather.record import Weather, run_lengths
from sizing.aircraft import Aircraft
from sizing.day.balance import PowerBalance
from sizing.day.battery import Store
from sizing.day.carried import carried_over, dawns_of, days_that_close
from sizing.day.flight import Flights
from sizing.day.light import UNCORRECTED_CAM, SolarModel
from sizing.day.march import ChargingDay
from sizing.day.record_days import WeatherDays, temperatures_c
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
    (:func:`~sizing.day.carried.dawns_of`). ``closes``: whether a day, begun at dawn with
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
        return int(np.max(run_lengths(self.closes), initial=0))

    def state_of_charge(self) -> FloatArray:
        """Return the state of charge at the nodes [-], ``(day, node)``."""
        return np.asarray(self.energy_wh / self.store.battery_energy_wh[:, np.newaxis])


@dataclass(frozen=True)
class WeatherPerformance:
    """An aircraft in a weather record, and under a clear sky in the same air.

    ``mission``: at the record's site and flight altitude. ``recorded``, ``clear``: in the record's
    light, and under the clear sky.
    """

    weather: Weather
    mission: Mission
    design: Design
    solar: SolarModel
    light: RecordedLight
    recorded: WeatherRun
    clear: WeatherRun

    @property
    def air_of_days_c(self) -> FloatArray:
        """Return the mean temperature of the air of each day [C]."""
        ambient, _ = temperatures_c(self.mission, self.light)
        return np.asarray(np.mean(ambient[self.recorded.axis.nodes], axis=1))


def weather_performance(
    aircraft: Aircraft,
    mission: Mission,
    weather: Weather,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    step_s: float = NODE_STEP_S,
) -> WeatherPerformance:
    """Simulate an aircraft through a weather record, from a full battery at its beginning.

    ``mission``: at the record's site (:func:`missions.weather.site.mission_at_site`): altitude,
    air, turbulence, payload, margins. Its clearness plays no part: the clouds are the record's.
    """
    days = WeatherDays.of(aircraft, mission, weather, solar, step_s=step_s)
    design = design_of(aircraft, mission)
    load_w = days.load_w(design)
    recorded, clear = (
        weather_run(days, design, load_w, sky) for sky in (days.light.recorded, days.light.clear)
    )
    return WeatherPerformance(weather, mission, design, solar, days.light, recorded, clear)


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
    hours = Flights(day, store, follow=True).hours(days, dawns.hour)
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
