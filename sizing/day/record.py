"""A flight through a weather record: the days as they came, the charge carried over.

Not the repeated day: every day has its own light and temperature, and a day begins with what the
day before has left in the battery. An empty battery ends a
flight; the run goes on from empty, so that every day of the record is judged by what came before
it. A battery whose capacity depends on its temperature has each day that of the day's mean air, and
keeps its state of charge over night.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from missions.air import ZERO_CELSIUS_K
from missions.files.errors import file_error
from missions.mission import Mission, Scenarios
from missions.weather.light import NODE_STEP_S, RecordedLight, light_at_altitude
from missions.weather.record import Weather, run_lengths
from sizing.aircraft import Aircraft
from sizing.day.balance import PowerBalance
from sizing.day.battery import Store
from sizing.day.carried import carried_over, dawns_of
from sizing.day.flight import Flights
from sizing.day.light import UNCORRECTED_CAM, SolarModel
from sizing.day.light_at_instants import Lit, power_in_light
from sizing.day.load import load_shape
from sizing.day.march import ChargingDay
from sizing.day.module_power import own_surroundings
from sizing.day.record_days import DayAxis, LoadInAir
from sizing.design import NO_FLIGHT_W, Design
from sizing.held_station import power_against_wind_w
from sizing.mass_budget import design_of
from solar.clearsky import Irradiance
from solar.sun import HOURS_PER_DAY, declination, sun_times
from solar.types import BoolArray, FloatArray


@dataclass(frozen=True)
class WeatherDays:
    """What the days of a record are to every design of an aircraft.

    ``aircraft``, ``mission``, ``solar``: technology; altitude, air and turbulence at the record's
    site; solar power model. ``weather``, ``light``: record, and the light along it at the mission's
    altitude. ``ambient_c``, ``module_c``: temperature of the air and of the modules along the
    record [C]. ``propulsion_ratio``: propulsion power over that of level flight in the mission's
    air [-]. ``wind_m_per_s``: of each day as the airspeed of the same lift coefficient in the
    mission's air [m/s]; None unless the mission holds its place.
    ``more_heater_w``: heater of the battery beyond that of the mission's air [W].
    ``capacity_ratio``: capacity of the battery over that in the mission's air [-].
    """

    aircraft: Aircraft
    mission: Mission
    weather: Weather
    solar: SolarModel
    light: RecordedLight
    axis: DayAxis
    ambient_c: FloatArray
    module_c: FloatArray
    propulsion_ratio: FloatArray
    wind_m_per_s: FloatArray | None
    more_heater_w: FloatArray
    capacity_ratio: FloatArray

    @classmethod
    def of(
        cls,
        aircraft: Aircraft,
        mission: Mission,
        weather: Weather,
        solar: SolarModel = UNCORRECTED_CAM,
        *,
        step_s: float = NODE_STEP_S,
    ) -> WeatherDays:
        """Cut a record into days for an aircraft on a mission at its site."""
        light = light_at_altitude(weather, mission.altitude_m, step_s=step_s)
        try:
            axis = DayAxis.of(light)
        except ValueError as error:
            raise file_error(weather.source, str(error)) from error
        ambient_c, module_c = _temperatures_c(mission, light)
        air_c = ambient_c[axis.nodes]
        return cls(
            *(aircraft, mission, weather, solar, light, axis, ambient_c, module_c),
            propulsion_ratio=_propulsion_ratio(mission, axis, air_c),
            wind_m_per_s=_wind_m_per_s(mission, axis, air_c),
            more_heater_w=_more_heater_w(aircraft, mission, air_c),
            capacity_ratio=_capacity_of_days(aircraft, mission, air_c),
        )

    def specific_power_w_per_m2(self, sky: Irradiance) -> FloatArray:
        """Solar power per module area under a sky along the record [W/m2], ``(day, node)``."""
        light, around = self.light, own_surroundings(self.aircraft, self.mission)
        sunlit = Lit(
            *(light.day_of_year, light.time_solar_h, light.cos_zenith, sky),
            *(self.ambient_c, self.module_c),
        )
        power = power_in_light(self.aircraft, self.mission, self.solar, sunlit, around)
        return np.asarray(power[self.axis.nodes])

    def flown(self, design: Design, parts: LoadInAir | None, *, clear: bool = False) -> WeatherRun:
        """Run of a design along the record, with the efficiency of the moment."""
        store = self.store(design.battery_energy_wh)
        sky = self.light.clear if clear else self.light.recorded
        solar_w = self.aircraft.modules.area_m2 * self.specific_power_w_per_m2(sky)
        other_w = float(design.constant_power_w) + self.more_heater_w
        if parts is None:
            load = self.level_w(design)[0][:, np.newaxis] * self.propulsion_ratio + other_w
            return _march_record(self.axis, solar_w, load, store)
        profile, air_c = _profile(self.mission, self.axis), self.ambient_c[self.axis.nodes]
        level_w = np.atleast_1d(parts.level_w)[:, np.newaxis]
        level_w = np.where(np.isfinite(level_w), level_w, NO_FLIGHT_W)

        load = np.asarray(level_w * parts.at(profile, air_c) + other_w)
        return _march_record(self.axis, solar_w, load, store)

    def level_w(self, design: Design) -> FloatArray:
        """Propulsion power of designs in level flight in the mission's air [W], ``(design, day)``.

        A single day for all, unless the mission holds its place: then as fast as each day's wind.
        """
        power_w = np.atleast_1d(np.asarray(design.propulsion_power_w, float))[:, np.newaxis]
        if self.wind_m_per_s is not None:
            each = design.mapped(lambda one: np.atleast_1d(np.asarray(one))[:, np.newaxis])
            power_w = power_against_wind_w(self.aircraft, self.mission, each, self.wind_m_per_s)
        return np.where(np.isfinite(power_w), power_w, NO_FLIGHT_W)

    def store(self, battery_energy_wh: float) -> Store:
        """Battery of each day, of an energy at full charge in the mission's air [Wh]."""
        return Store.of(self.aircraft.battery, battery_energy_wh * self.capacity_ratio)


@dataclass(frozen=True)
class WeatherRun:
    """Run of an aircraft through one kind of light of a record.

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
        """Most consecutive days that close."""
        return int(np.max(run_lengths(self.closes), initial=0))

    def state_of_charge(self) -> FloatArray:
        """State of charge at the nodes [-], shape ``(day, node)``."""
        return np.asarray(self.energy_wh / self.store.battery_energy_wh[:, np.newaxis])


@dataclass(frozen=True)
class WeatherPerformance:
    """An aircraft in a weather record and, beside it, under a clear sky in the same air.

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
        """Mean temperature of the air of each day, the record's if it has one [C]."""
        ambient, _ = _temperatures_c(self.mission, self.light)
        return np.asarray(np.mean(ambient[self.recorded.axis.nodes], axis=1))


def weather_performance(
    aircraft: Aircraft,
    mission: Mission,
    weather: Weather,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    step_s: float = NODE_STEP_S,
) -> WeatherPerformance:
    """Fly an aircraft through a weather record, from a full battery at its beginning.

    ``mission``: at the record's site (:func:`missions.weather.site.mission_at_site`): altitude,
    air, turbulence, payload, margins. Its clearness plays no part: the clouds are the record's.
    """
    days = WeatherDays.of(aircraft, mission, weather, solar, step_s=step_s)
    design = design_of(aircraft, mission)
    parts = LoadInAir.of(aircraft, mission, design, days.ambient_c, days.wind_m_per_s)
    recorded, clear = (days.flown(design, parts, clear=one) for one in (False, True))
    return WeatherPerformance(weather, mission, design, solar, days.light, recorded, clear)


def _march_record(
    axis: DayAxis, solar_w: FloatArray, load_w: FloatArray, store: Store
) -> WeatherRun:
    energy_wh, days = store.battery_energy_wh, np.arange(len(axis))
    day = ChargingDay.of(PowerBalance.of(axis.time_h, (solar_w - load_w).T))
    carried = carried_over(day, store, energy_wh[0])
    dawns = dawns_of(day, store, HOURS_PER_DAY / 2.0 - axis.midnight_h)
    hours = Flights(day, store, follow=True).hours(days, dawns.hour)
    outlasts = np.isinf(hours)
    to_the_end_h = (len(axis) - days) * HOURS_PER_DAY - dawns.hour
    return WeatherRun(
        axis=axis,
        solar_power_w=solar_w,
        load_w=load_w,
        store=store,
        energy_wh=carried.run.energy_at_nodes_wh().T,
        dawn_h=dawns.hour,
        closes=carried.closes(dawns),
        dawn_state_of_charge=carried.energy_at_wh(dawns.hour) / energy_wh,
        endurance_h=np.where(outlasts, to_the_end_h, hours),
        outlasts=outlasts,
    )


def _temperatures_c(mission: Mission, light: RecordedLight) -> tuple[FloatArray, FloatArray]:
    """Temperature of the air, the record's if it has one, and of modules as much warmer [C]."""
    assumed_c = float(mission.air_state().temperature_c)
    ambient = light.temperature_c
    if ambient is None:
        ambient = np.full(light.time_s.shape, assumed_c)
    return ambient, ambient + (mission.module_temperature_c() - assumed_c)


def _propulsion_ratio(mission: Mission, axis: DayAxis, ambient_c: FloatArray) -> FloatArray:
    """Propulsion power at the nodes over that of level flight [-], shape ``(day, node)``.

    Power of level flight at a lift coefficient goes with ``density^-0.5``; at the pressure of an
    altitude that is the square root of the absolute temperature (Anderson, Aircraft Performance and
    Design, equation 5.56). Turbulence and thermals are the mission's.
    """
    assumed_k = float(mission.air_state().temperature_k)
    return np.asarray(_profile(mission, axis) * np.sqrt((ambient_c + ZERO_CELSIUS_K) / assumed_k))


def _profile(mission: Mission, axis: DayAxis) -> FloatArray:
    """Thrust power at the nodes over that of level flight in their air [-], ``(day, node)``."""
    times = sun_times(mission.latitudes()[0], declination(axis.day_of_year + 0.5))
    clock_h = axis.time_h + axis.midnight_h[:, np.newaxis]
    return load_shape(mission, clock_h, times.sunrise_h, times.sunset_h)


def _wind_m_per_s(mission: Mission, axis: DayAxis, air_c: FloatArray) -> FloatArray | None:
    """Wind of each day's month where the mission holds its place, for the mission's air [m/s].

    With the wind ``v`` in air of the density ``rho`` the lift coefficient is that at
    ``v (rho / rho_0)^0.5`` in the mission's, and the power that at this airspeed times
    ``(rho_0 / rho)^0.5``, which :func:`_propulsion_ratio` has.
    """
    if not mission.holds_station:
        return None
    latitude_deg = np.full(len(axis), mission.latitudes()[0])
    wind = mission.scenario_winds_m_per_s(Scenarios(latitude_deg, axis.day_of_year))
    assumed_k = float(mission.air_state().temperature_k)
    return np.asarray(wind / np.sqrt((np.mean(air_c, axis=1) + ZERO_CELSIUS_K) / assumed_k))


def _more_heater_w(aircraft: Aircraft, mission: Mission, air_c: FloatArray) -> FloatArray:
    """Heater of each day's battery beyond that of the mission's air [W], shape ``(day, 1)``."""
    heater_w, altitude_m = aircraft.battery.heater_w, mission.altitude_m
    mean_c, assumed_c = np.mean(air_c, axis=1, keepdims=True), mission.air_state().temperature_c
    more_w = heater_w(mean_c, altitude_m) - heater_w(assumed_c, altitude_m)
    return np.asarray(more_w + np.zeros(mean_c.shape))


def _capacity_of_days(aircraft: Aircraft, mission: Mission, air_c: FloatArray) -> FloatArray:
    """Capacity at the mean air temperature of each day over that in the mission's air [-]."""
    fraction, altitude_m = aircraft.battery.capacity_fraction, mission.altitude_m
    assumed = fraction(mission.air_state().temperature_c, altitude_m)
    of_days = fraction(np.mean(air_c, axis=1), altitude_m) / assumed
    return np.asarray(of_days * np.ones(len(air_c)))
