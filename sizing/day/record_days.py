"""Days of a weather record: where they begin, their light, what their air is to an aircraft."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missions.air import ZERO_CELSIUS_K
from missions.files.errors import file_error
from missions.mission import Mission, Scenarios
from missions.weather.light import NODE_STEP_S, RecordedLight, light_at_altitude
from missions.weather.record import SECONDS_PER_HOUR, Weather, day_of_year
from sizing.aircraft import Aircraft
from sizing.day.battery import Store
from sizing.day.light import UNCORRECTED_CAM, SolarModel, power_at_instants
from sizing.day.load import load_shape, power_in_air_w
from sizing.day.module_power import clear_daylight
from sizing.design import Design
from solar.clearsky import Irradiance
from solar.sun import HOURS_PER_DAY, declination, sun_times
from solar.types import FloatArray, IntArray

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
class WeatherDays:
    """What the days of a record are to every design of an aircraft.

    ``aircraft``, ``mission``, ``solar``: technology; altitude, air and turbulence at the record's
    site; solar power model. ``weather``, ``light``: record, and the light along it at the mission's
    altitude. ``ambient_c``, ``module_c``: temperature of the air and of the modules along the
    record [C]. ``wind_m_per_s``: of each day as the airspeed of the same lift coefficient in the
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
        ambient_c, module_c = temperatures_c(mission, light)
        air_c = ambient_c[axis.nodes]
        return cls(
            *(aircraft, mission, weather, solar, light, axis, ambient_c, module_c),
            wind_m_per_s=_wind_m_per_s(mission, axis, air_c),
            more_heater_w=_more_heater_w(aircraft, mission, air_c),
            capacity_ratio=_capacity_of_days(aircraft, mission, air_c),
        )

    def specific_power_w_per_m2(self, sky: Irradiance) -> FloatArray:
        """Solar power per module area under a sky along the record [W/m2], ``(day, node)``."""
        mission, days, hours = self.mission, self.light.day_of_year, self.light.time_solar_h
        light = clear_daylight(mission, mission.latitudes()[0], days, hours)
        light, air = light._replace(irradiance=sky), (self.ambient_c, self.module_c)
        power = power_at_instants(self.aircraft, mission, self.solar, light, *air)
        return np.asarray(power[self.axis.nodes])

    def load_w(self, design: Design) -> FloatArray:
        """Load of a design along the record, with the efficiency of the moment [W]."""
        range_c = float(np.min(self.ambient_c)), float(np.max(self.ambient_c))
        air_c, wind = self.ambient_c[self.axis.nodes], self.wind_m_per_s
        shape = load_of_days(self.mission, self.axis)
        load_w = power_in_air_w(self.aircraft, self.mission, design, shape, air_c, range_c, wind)
        return load_w + (float(design.constant_power_w) + self.more_heater_w)

    def store(self, battery_energy_wh: float) -> Store:
        """Battery of each day, of an energy at full charge in the mission's air [Wh]."""
        return Store.of(self.aircraft.battery, battery_energy_wh * self.capacity_ratio)


def temperatures_c(mission: Mission, light: RecordedLight) -> tuple[FloatArray, FloatArray]:
    """Temperature of the air, the record's if it has one, and of modules as much warmer [C]."""
    assumed_c = float(mission.air_state().temperature_c)
    ambient = light.temperature_c
    if ambient is None:
        ambient = np.full(light.time_s.shape, assumed_c)
    return ambient, ambient + (mission.module_temperature_c() - assumed_c)


def load_of_days(mission: Mission, axis: DayAxis) -> FloatArray:
    """Thrust power at the nodes over that of level flight in their air [-], ``(day, node)``."""
    times = sun_times(mission.latitudes()[0], declination(axis.day_of_year + 0.5))
    clock_h = axis.time_h + axis.midnight_h[:, np.newaxis]
    shape = load_shape(mission, clock_h, times.sunrise_h, times.sunset_h)
    return np.broadcast_to(shape, clock_h.shape)


def _wind_m_per_s(mission: Mission, axis: DayAxis, air_c: FloatArray) -> FloatArray | None:
    """Wind of each day's month where the mission holds its place, for the mission's air [m/s].

    With the wind ``v`` in air of the density ``rho`` the lift coefficient is that at
    ``v (rho / rho_0)^0.5`` in the mission's, and the power that at this airspeed times
    ``(rho_0 / rho)^0.5``, which :func:`~sizing.day.load.power_in_air_w` has.
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
