"""A flight through a weather record: the days as they came, the charge carried over.

Not the repeated day: every day has its own light and temperature, and a day begins with what the
day before has left in the battery. An empty battery ends a flight; the run goes on from empty, so
that every day of the record is judged by what came before it. A battery whose capacity depends on
its temperature has each day that of the day's mean air, and keeps its state of charge over night.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from missions.air import ZERO_CELSIUS_K, air_at
from missions.files.errors import file_error
from missions.mission import Mission, Scenarios
from missions.weather.light import NODE_STEP_S, RecordedLight, light_at_altitude
from missions.weather.record import SECONDS_PER_HOUR, Weather, day_of_year, run_lengths
from sizing.aircraft import Aircraft
from sizing.design import Design, bus_voltage_v
from sizing.energy.battery import Store
from sizing.energy.carried_days import CarriedDays, carried_over, dawns_of, flight_hours
from sizing.energy.power_balance import PowerBalance
from sizing.held_station import flight_against_wind, power_against_wind_w
from sizing.mass_budget import ImpossibleDesignError, design_of
from sizing.propulsion.part_load import PartLoad, load_range
from sizing.sunlight import UNCORRECTED_CAM, SolarModel
from sizing.sunlight_at_instants import Lit, power_in_light
from sizing.varying_load import (
    Flight,
    by_own_charge,
    flight_of,
    load_shape,
    part_load_of,
    part_load_over,
)
from solar.clearsky import Irradiance
from solar.sun import HOURS_PER_DAY, declination, sun_times
from solar.types import BoolArray, FloatArray, IntArray

_NO_FLIGHT_W = 1e12  # load of a design that cannot carry itself, or be as fast as the wind
# A record that begins this near to midnight begins a day.
_NEAR_MIDNIGHT_H = 3.0


@dataclass(frozen=True)
class DayAxis:
    """Days of a record, from one local solar midnight to the next, and their nodes.

    ``nodes``: places in the record; a day's last node is the next day's first. ``time_h``: hours
    since the day's first node [h]. ``midnight_h``: solar time of each day's first node, about 0
    [h]. ``date``: date of each day in the calendar of the place. ``day_of_year``: that of the date,
    1 to 365; 29 February counts as 28 February. ``time_s``: universal time of each day's first node
    [s since 1970-01-01].
    """

    nodes: IntArray
    time_h: FloatArray
    midnight_h: FloatArray
    date: NDArray[np.datetime64]
    day_of_year: IntArray
    time_s: FloatArray

    def __len__(self) -> int:
        return len(self.nodes)

    @property
    def year(self) -> IntArray:
        """Calendar year of each day."""
        return self.date.astype("datetime64[Y]").astype(int) + 1970

    @property
    def month(self) -> IntArray:
        """Month of each day, 1 to 12."""
        return self.date.astype("datetime64[M]").astype(int) % 12 + 1

    @classmethod
    def of(cls, light: RecordedLight) -> DayAxis:
        """Cut a record into days; hours before the first and after the last are left out."""
        per_day = round(HOURS_PER_DAY / light.step_h)
        begin_h = float(light.time_solar_h[0])
        to_midnight_h = (HOURS_PER_DAY - begin_h) % HOURS_PER_DAY
        near = min(begin_h, to_midnight_h) <= _NEAR_MIDNIGHT_H
        skip = 0 if near else round(to_midnight_h / light.step_h)
        count = (len(light.time_s) - skip) // per_day
        if count < 1:
            raise ValueError("is shorter than a day from one solar midnight to the next")
        first = skip + per_day * np.arange(count)
        nodes = np.minimum(first[:, np.newaxis] + np.arange(per_day + 1), len(light.time_s) - 1)
        clock_h = light.time_solar_h[first]
        midnight_h = np.where(clock_h > 12.0, clock_h - HOURS_PER_DAY, clock_h)
        # Dates are those of the place at its noon, not of Greenwich.
        noon_h = HOURS_PER_DAY / 2.0 - midnight_h + light.site.calendar_offset_h
        date = (light.time_s[first] + SECONDS_PER_HOUR * noon_h).astype("datetime64[s]")
        date = date.astype("datetime64[D]")
        return cls(
            nodes=nodes,
            time_h=np.asarray(np.arange(per_day + 1) * light.step_h, float),
            midnight_h=midnight_h,
            date=date,
            day_of_year=day_of_year(date.astype("datetime64[s]").astype(float)).astype(int),
            time_s=light.time_s[first],
        )


@dataclass(frozen=True)
class LoadInAir:
    """Electric power of a design in air that changes its temperature, relative to its own.

    ``level_w``: propulsion power of level flight in the mission's air [W], of every day where each
    has an airspeed of its own. ``part_load``: power over it at some temperatures,
    ``temperatures_k``, between which a parabola passes.
    """

    level_w: FloatArray
    part_load: PartLoad
    temperatures_k: FloatArray

    @classmethod
    def of(
        cls,
        aircraft: Aircraft,
        mission: Mission,
        design: Design,
        air_c: ArrayLike,
        wind_m_per_s: FloatArray | None = None,
    ) -> LoadInAir | None:
        """Power between the ends of temperatures [C]; None for constant efficiencies.

        At the pressure of an altitude airspeed and drag times airspeed go with the square root of
        the absolute temperature. ``wind_m_per_s``: of each day, where the mission holds its place;
        power is then over that of the day's airspeed. Raises :class:`ImpossibleDesignError` where
        the propeller's data end before the greatest load of level flight; a day whose wind is too
        strong has no power instead.
        """
        if aircraft.propulsion_by_parts is None:
            return None
        if wind_m_per_s is None:
            part_load_of(aircraft, mission, design)  # which says what its own air is too much for
        own, flight = flight_of(aircraft, mission, design)
        level_w: FloatArray = np.asarray(design.propulsion_power_w)
        day: IntArray | None = None
        if wind_m_per_s is not None:
            # Days of equal wind, and of less than the airspeed, are one flight.
            each = np.maximum(wind_m_per_s, np.asarray(design.airspeed_m_per_s, float))
            some, day = np.unique(each, return_inverse=True)
            level_w, thrust_w, speed = flight_against_wind(aircraft, mission, design, some)
            flight = Flight.where(np.isfinite(level_w), thrust_w, speed, flight.air)
        least_c, most_c = float(np.min(air_c)), float(np.max(air_c))
        warm_k = ZERO_CELSIUS_K + np.linspace(least_c, most_c, 3 if most_c > least_c else 1)
        # Temperatures first, then the days.
        of_each = warm_k.reshape(-1, *(1,) * level_w.ndim)
        faster = np.sqrt(of_each / flight.air.temperature_k)
        there = Flight(
            np.asarray(flight.thrust_w * faster),
            flight.airspeed_m_per_s * faster,
            air_at(of_each, flight.air.pressure_pa),
        )
        turbulence = mission.turbulence
        loads = load_range(turbulence.all_day, turbulence.thermal)
        wide = np.broadcast_to(level_w, there.thrust_w.shape)
        part = part_load_over(own, there, wide, loads, bus_voltage_v(aircraft))
        if wind_m_per_s is None and np.any(part.beyond):
            raise ImpossibleDesignError(
                f"the propulsion of {aircraft.name} cannot do {float(loads[1]):.3g} times the "
                f"power of level flight in air of {least_c:.0f} to {most_c:.0f} C"
            )
        if day is None:
            return cls(level_w, part, warm_k)
        part = replace(part, coefficients=part.coefficients[..., day])
        return cls(level_w[day], part, warm_k)

    def at(self, load: FloatArray, air_c: FloatArray, bus_v: FloatArray) -> FloatArray:
        """Power over that of level flight in the mission's air [-]; arguments broadcast."""
        wide = np.broadcast_arrays(load, air_c, bus_v)
        axes = wide[0].ndim - (self.part_load.coefficients.ndim - 3)  # less that of the days
        powers = self.part_load.spread(axes).at(wide[0], wide[2])
        known_k, warm_k = self.temperatures_k, wide[1] + ZERO_CELSIUS_K
        total = np.zeros(wide[0].shape)
        for k, one in enumerate(powers):
            apart = [(warm_k - other) / (known_k[k] - other) for other in np.delete(known_k, k)]
            total += math.prod(apart, start=one)
        return total


@dataclass(frozen=True)
class WeatherDays:
    """What the days of a record are to every design of an aircraft.

    ``aircraft``, ``mission``, ``solar``: technology; altitude, air and turbulence at the record's
    site; solar power model. ``light``: along the record. ``ambient_c``, ``module_c``: temperature
    of the air and of the modules along the record [C]. ``propulsion_ratio``: propulsion power over
    that of level flight in the mission's air [-]. ``wind_m_per_s``: of each day as the airspeed of
    the same lift coefficient in the mission's air [m/s]; None unless the mission holds its place.
    ``more_heater_w``: heater of the battery beyond that of the mission's air [W].
    ``capacity_ratio``: capacity of the battery over that in the mission's air [-].
    """

    aircraft: Aircraft
    mission: Mission
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
            *(aircraft, mission, solar, light, axis, ambient_c, module_c),
            propulsion_ratio=_propulsion_ratio(mission, axis, air_c),
            wind_m_per_s=_wind_m_per_s(mission, axis, air_c),
            more_heater_w=_more_heater_w(aircraft, mission, air_c),
            capacity_ratio=_capacity_of_days(aircraft, mission, air_c),
        )

    def specific_power_w_per_m2(self, sky: Irradiance) -> FloatArray:
        """Solar power per module area under a sky along the record [W/m2], ``(day, node)``."""
        light = self.light
        sunlit = Lit(
            *(light.day_of_year, light.time_solar_h, light.cos_zenith, sky),
            *(self.ambient_c, self.module_c),
        )
        power = power_in_light(self.aircraft, self.mission, self.solar, sunlit)
        return np.asarray(power[self.axis.nodes])

    def flown(self, design: Design, sky: Irradiance, parts: LoadInAir | None) -> WeatherRun:
        """Run of a design under a sky along the record, with the efficiency of the moment."""
        store = self.store(design.battery_energy_wh)
        solar_w = self.aircraft.modules.area_m2 * self.specific_power_w_per_m2(sky)
        other_w = float(design.constant_power_w) + self.more_heater_w
        if parts is None:
            load = self.level_w(design)[0][:, np.newaxis] * self.propulsion_ratio + other_w
            return _march_record(self.axis, solar_w, load, store)
        profile, air_c = _profile(self.mission, self.axis), self.ambient_c[self.axis.nodes]
        level_w = np.atleast_1d(parts.level_w)[:, np.newaxis]
        level_w = np.where(np.isfinite(level_w), level_w, _NO_FLIGHT_W)

        def load_w(bus_v: FloatArray) -> FloatArray:
            return np.asarray(level_w * parts.at(profile, air_c, bus_v) + other_w)

        def fly(load_w: FloatArray) -> tuple[WeatherRun, FloatArray]:
            run = _march_record(self.axis, solar_w, load_w, store)
            return run, run.state_of_charge()

        return by_own_charge(load_w, fly, self.aircraft.battery)

    def level_w(self, design: Design) -> FloatArray:
        """Propulsion power of designs in level flight in the mission's air [W], ``(design, day)``.

        A single day for all, unless the mission holds its place: then as fast as each day's wind.
        """
        power_w = np.atleast_1d(np.asarray(design.propulsion_power_w, float))[:, np.newaxis]
        if self.wind_m_per_s is not None:
            each = design.mapped(lambda one: np.atleast_1d(np.asarray(one))[:, np.newaxis])
            power_w = power_against_wind_w(self.aircraft, self.mission, each, self.wind_m_per_s)
        return np.where(np.isfinite(power_w), power_w, _NO_FLIGHT_W)

    def store(self, battery_energy_wh: float) -> Store:
        """Battery of each day, of an energy at full charge in the mission's air [Wh]."""
        return Store.of(self.aircraft.battery, battery_energy_wh * self.capacity_ratio)


@dataclass(frozen=True)
class WeatherRun:
    """Run of an aircraft through one kind of light of a record.

    ``axis``: days of the record. ``solar_power_w``, ``load_w``: power at the nodes [W].
    ``carried``: batteries of all days. ``dawn_h``: when, from midnight to noon, the charge is
    least, hours after the day's first node [h] (:func:`~sizing.energy.carried_days.dawns_of`).
    ``closes``: whether a day, begun at dawn with the charge carried over, reaches the next dawn (of
    the last day: the end of the record) without an empty battery. ``dawn_state_of_charge``: state
    of charge at dawn [-]. ``endurance_h``: flight time of a launch with a full battery at each dawn
    [h]; where ``outlasts``, up to the end of the record. ``outlasts``: whether that flight outlasts
    the record.
    """

    axis: DayAxis
    solar_power_w: FloatArray
    load_w: FloatArray
    carried: CarriedDays
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
        energy = self.carried.energy_wh()[:, 0, :]
        return np.asarray(energy.T / self.carried.store.battery_energy_wh[:, np.newaxis])


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

    @property
    def module_temperature_c(self) -> FloatArray:
        """Temperature of the modules at the nodes of each day [C]; FM has its own."""
        _, module = _temperatures_c(self.mission, self.light)
        return np.asarray(module[self.recorded.axis.nodes])


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
    skies = (days.light.recorded, days.light.clear)
    recorded, clear = (days.flown(design, sky, parts) for sky in skies)
    return WeatherPerformance(weather, mission, design, solar, days.light, recorded, clear)


def _march_record(
    axis: DayAxis, solar_w: FloatArray, load_w: FloatArray, store: Store
) -> WeatherRun:
    energy_wh = store.battery_energy_wh
    balance = PowerBalance.of(axis.time_h, solar_w, load_w)
    carried = carried_over(balance, store, energy_wh[:1], len(axis))
    dawns = dawns_of(balance, carried.day, store, HOURS_PER_DAY / 2.0 - axis.midnight_h)
    hours, outlasts = flight_hours(carried, dawns.hour, energy_wh, dawns.deficit_wh)
    return WeatherRun(
        axis=axis,
        solar_power_w=solar_w,
        load_w=load_w,
        carried=carried,
        dawn_h=dawns.hour,
        closes=carried.closes(dawns),
        dawn_state_of_charge=carried.energy_at_wh(dawns.hour) / energy_wh,
        endurance_h=hours,
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
