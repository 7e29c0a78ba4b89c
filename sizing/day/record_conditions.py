"""Days of a weather record as an aircraft has them: light on its modules, load, battery."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from missions.air import ZERO_CELSIUS_K
from missions.files.errors import file_error
from missions.mission import Mission, Scenarios
from missions.weather.light import NODE_STEP_S, DayAxis, RecordedLight, light_at_altitude
from missions.weather.record import Weather
from sizing.aircraft import Aircraft
from sizing.day.battery import Store
from sizing.day.light import UNCORRECTED_CAM, SolarModel, power_at_instants
from sizing.day.load import load_shape, power_in_air_w
from sizing.day.module_power import clear_daylight
from sizing.design import Design
from sizing.smooth import Value
from solar.clearsky import Irradiance
from solar.sun import declination, sun_times
from solar.types import FloatArray


@dataclass(frozen=True)
class WeatherDays:
    """Days of a record for every design of an aircraft.

    ``aircraft``, ``mission``, ``solar``: technology; altitude, air and turbulence at the record's
    site; solar power model. ``weather``, ``light``: record, and the light along it at the mission's
    altitude.
    """

    aircraft: Aircraft
    mission: Mission
    weather: Weather
    solar: SolarModel
    light: RecordedLight
    axis: DayAxis

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
        return cls(aircraft, mission, weather, solar, light, axis)

    @cached_property
    def ambient_c(self) -> FloatArray:
        """Return the temperature of the air along the record, its own if it has one [C]."""
        known_c, assumed_c = self.light.temperature_c, float(self.mission.air_state().temperature_c)
        return np.full(self.light.time_s.shape, assumed_c) if known_c is None else known_c

    @cached_property
    def mean_air_c(self) -> FloatArray:
        """Return the mean temperature of the air of each day [C]."""
        return np.asarray(np.mean(self.ambient_c[self.axis.nodes], axis=1))

    @property
    def wind_m_per_s(self) -> FloatArray | None:
        """Return the wind of each day's month as an airspeed in the mission's air [m/s].

        None unless the mission holds its place. With the wind ``v`` in air of the density ``rho``
        the lift coefficient is that at ``v (rho / rho_0)^0.5`` in the mission's, and the power that
        at this airspeed times ``(rho_0 / rho)^0.5``, which
        :func:`~sizing.day.load.power_in_air_w` has.
        """
        mission, axis = self.mission, self.axis
        if not mission.holds_station:
            return None
        latitude_deg = np.full(len(axis), mission.latitudes()[0])
        wind = mission.scenario_winds_m_per_s(Scenarios(latitude_deg, axis.day_of_year))
        assumed_k = float(mission.air_state().temperature_k)
        return np.asarray(wind / np.sqrt((self.mean_air_c + ZERO_CELSIUS_K) / assumed_k))

    def specific_power_w_per_m2(self, sky: Irradiance) -> FloatArray:
        """Return the solar power per module area under a sky along the record, ``(day, node)``.

        Modules are as much warmer than the air as on the mission.
        """
        mission, days, hours = self.mission, self.light.day_of_year, self.light.time_solar_h
        light = clear_daylight(mission, mission.latitudes()[0], days, hours)
        light = light._replace(irradiance=sky, clearness=1.0)
        warmer_k = mission.module_temperature_c() - float(mission.air_state().temperature_c)
        air = self.ambient_c, self.ambient_c + warmer_k
        power = power_at_instants(self.aircraft, mission, self.solar, light, *air)
        return np.asarray(power[self.axis.nodes])

    def load_w(self, design: Design) -> FloatArray:
        """Return the load of a design along the record, with the efficiency of the moment [W]."""
        mission, air_c, every_day = self.mission, self.ambient_c, np.zeros((len(self.axis), 1))
        air = air_c[self.axis.nodes], (float(np.min(air_c)), float(np.max(air_c)))
        shape, wind = load_of_days(mission, self.axis), self.wind_m_per_s
        load_w = power_in_air_w(self.aircraft, mission, design, shape, *air, wind)
        # The mission's air has a heater of its own.
        heater_w, there_w = self._of_battery(self.aircraft.battery.heater_w)
        more_w = (heater_w - there_w).reshape(-1, 1) + every_day
        return load_w + (float(design.constant_power_w) + more_w)

    def store(self, battery_energy_wh: float) -> Store:
        """Return the battery of each day, from its full energy in the mission's air [Wh]."""
        capacity, there = self._of_battery(self.aircraft.battery.capacity_fraction)
        ratio = np.asarray(capacity / there * np.ones(len(self.axis)))
        return Store.of(self.aircraft.battery, battery_energy_wh * ratio)

    def _of_battery(
        self, quantity: Callable[[Value, float], Value]
    ) -> tuple[FloatArray, FloatArray]:
        """Return a quantity of the battery in the air of each day, and in that of the mission."""
        assumed_c = self.mission.air_state().temperature_c
        days, there = (
            np.asarray(quantity(air_c, self.mission.altitude_m))
            for air_c in (self.mean_air_c, assumed_c)
        )
        return days, there


def load_of_days(mission: Mission, axis: DayAxis) -> FloatArray:
    """Return the thrust power over that of level flight in the air of the node, ``(day, node)``."""
    times = sun_times(mission.latitudes()[0], declination(axis.day_of_year + 0.5))
    clock_h = axis.time_h + axis.midnight_h[:, np.newaxis]
    shape = load_shape(mission, clock_h, times.sunrise_h, times.sunset_h)
    return np.broadcast_to(shape, clock_h.shape)
