"""Days of a weather record as an aircraft has them: light on its modules, load, battery."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from missions.air import ZERO_CELSIUS_K
from missions.files.errors import file_error
from missions.mission import Mission, Scenarios
from missions.weather.days import DayAxis
from missions.weather.light import NODE_STEP_S, RecordedLight, light_at_altitude
from missions.weather.record import Weather
from sizing.aircraft import Aircraft
from sizing.day.battery import Store
from sizing.day.light import UNCORRECTED_CAM, SolarModel, power_at_instants
from sizing.day.load import load_shape, power_in_air_w
from sizing.day.module_power import clear_daylight
from sizing.design import Design
from solar.clearsky import Irradiance
from solar.sun import declination, sun_times
from solar.types import FloatArray


@dataclass(frozen=True)
class WeatherDays:
    """Days of a record for every design of an aircraft.

    ``aircraft``, ``mission``, ``solar``: technology; altitude, air and turbulence at the record's
    site; solar power model. ``weather``, ``light``: record, and the light along it at the mission's
    altitude. ``ambient_c``, ``module_c``: temperature of the air, the record's if it has one, and
    of the modules along the record [C]. ``wind_m_per_s``: of each day as the airspeed of the same
    lift coefficient in the mission's air [m/s]; None unless the mission holds its place.
    ``more_heater_w``: heater of the battery beyond that of the mission's air [W], ``(day, 1)``.
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
        altitude_m, battery = mission.altitude_m, aircraft.battery
        light = light_at_altitude(weather, altitude_m, step_s=step_s)
        try:
            axis = DayAxis.of(light)
        except ValueError as error:
            raise file_error(weather.source, str(error)) from error
        ambient_c, module_c = temperatures_c(mission, light)
        mean_c = np.mean(ambient_c[axis.nodes], axis=1)
        assumed_c = mission.air_state().temperature_c
        more_w = battery.heater_w(mean_c, altitude_m) - battery.heater_w(assumed_c, altitude_m)
        capacity = battery.capacity_fraction(mean_c, altitude_m)
        return cls(
            aircraft=aircraft,
            mission=mission,
            weather=weather,
            solar=solar,
            light=light,
            axis=axis,
            ambient_c=ambient_c,
            module_c=module_c,
            wind_m_per_s=_wind_m_per_s(mission, axis, mean_c) if mission.holds_station else None,
            more_heater_w=(more_w + np.zeros(len(axis)))[:, np.newaxis],
            capacity_ratio=np.asarray(
                capacity / battery.capacity_fraction(assumed_c, altitude_m) * np.ones(len(axis))
            ),
        )

    def specific_power_w_per_m2(self, sky: Irradiance) -> FloatArray:
        """Return the solar power per module area under a sky along the record, ``(day, node)``."""
        mission, days, hours = self.mission, self.light.day_of_year, self.light.time_solar_h
        light = clear_daylight(mission, mission.latitudes()[0], days, hours)
        light, air = light._replace(irradiance=sky), (self.ambient_c, self.module_c)
        power = power_at_instants(self.aircraft, mission, self.solar, light, *air)
        return np.asarray(power[self.axis.nodes])

    def load_w(self, design: Design) -> FloatArray:
        """Return the load of a design along the record, with the efficiency of the moment [W]."""
        range_c = float(np.min(self.ambient_c)), float(np.max(self.ambient_c))
        air_c, wind = self.ambient_c[self.axis.nodes], self.wind_m_per_s
        shape = load_of_days(self.mission, self.axis)
        load_w = power_in_air_w(self.aircraft, self.mission, design, shape, air_c, range_c, wind)
        return load_w + (float(design.constant_power_w) + self.more_heater_w)

    def store(self, battery_energy_wh: float) -> Store:
        """Return the battery of each day, from its full energy in the mission's air [Wh]."""
        return Store.of(self.aircraft.battery, battery_energy_wh * self.capacity_ratio)


def temperatures_c(mission: Mission, light: RecordedLight) -> tuple[FloatArray, FloatArray]:
    """Return the temperature of the air, the record's if it has one, and of the modules [C].

    Modules are as much warmer as on the mission.
    """
    assumed_c, ambient_c = float(mission.air_state().temperature_c), light.temperature_c
    if ambient_c is None:
        ambient_c = np.full(light.time_s.shape, assumed_c)
    return ambient_c, ambient_c + (mission.module_temperature_c() - assumed_c)


def load_of_days(mission: Mission, axis: DayAxis) -> FloatArray:
    """Return the thrust power over that of level flight in the air of the node, ``(day, node)``."""
    times = sun_times(mission.latitudes()[0], declination(axis.day_of_year + 0.5))
    clock_h = axis.time_h + axis.midnight_h[:, np.newaxis]
    shape = load_shape(mission, clock_h, times.sunrise_h, times.sunset_h)
    return np.broadcast_to(shape, clock_h.shape)


def _wind_m_per_s(mission: Mission, axis: DayAxis, mean_air_c: FloatArray) -> FloatArray:
    """Return the wind of each day's month as an airspeed in the mission's air [m/s].

    With the wind ``v`` in air of the density ``rho`` the lift coefficient is that at
    ``v (rho / rho_0)^0.5`` in the mission's, and the power that at this airspeed times
    ``(rho_0 / rho)^0.5``, which :func:`~sizing.day.load.power_in_air_w` has.
    """
    latitude_deg = np.full(len(axis), mission.latitudes()[0])
    wind = mission.scenario_winds_m_per_s(Scenarios(latitude_deg, axis.day_of_year))
    assumed_k = float(mission.air_state().temperature_k)
    return np.asarray(wind / np.sqrt((mean_air_c + ZERO_CELSIUS_K) / assumed_k))
