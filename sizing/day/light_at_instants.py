"""Solar power at instants: while the date advances, or in the light of a weather record."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from missions.files.errors import file_error
from missions.loiter_power import Daylight, mean_power_on_path
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel, Sunlight
from sizing.day.module_power import flown_modules, own_surroundings, specific_power
from solar.clearsky import Irradiance
from solar.heat_balance import Surroundings
from solar.horizontal_models import HORIZONTAL_MODELS, in_surroundings
from solar.names import ATTITUDE_MODELS
from solar.types import FloatArray


def power_on_calendar(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel,
    day_of_year: FloatArray,
    time_solar_h: FloatArray,
) -> FloatArray:
    """Specific power at a mission's single latitude while the date advances, corrected.

    ``day_of_year``, ``time_solar_h``: fractional day of year and local solar time [h] at each
    instant. Returns electric power per area of module [W/m2].
    """
    _check_one_wind(mission, solar)
    latitude = mission.latitudes()[0]
    around = own_surroundings(aircraft, mission)
    given = (aircraft, mission, solar.model, latitude, day_of_year, time_solar_h, around)
    return _corrected(specific_power(*given), aircraft, mission, solar, day_of_year)


class Lit(NamedTuple):
    """Light and temperatures at instants along a record, all of shape ``(time,)``.

    ``day_of_year``, ``time_solar_h``: fractional day of year and local solar time [h].
    ``cos_zenith``: cosine of the sun's zenith angle [-]. ``irradiance``: direct normal and diffuse
    horizontal light at flight altitude [W/m2]. ``ambient_c``, ``module_c``: temperature of the air
    and, of the models with a constant one, of the modules [C].
    """

    day_of_year: FloatArray
    time_solar_h: FloatArray
    cos_zenith: FloatArray
    irradiance: Irradiance
    ambient_c: FloatArray
    module_c: FloatArray


def power_in_light(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel,
    sunlit: Lit,
    around: Surroundings | None,
) -> FloatArray:
    """Specific power in given light, such as a weather record's, corrected.

    The mission's own clearness plays no part; its margin of the model's error does.

    ``aircraft``, ``mission``, ``solar``: as for :func:`solar_day`; the mission has a single
    latitude. ``around``: what heats and cools the modules; none: as told. Returns electric power
    per area of module [W/m2].
    """
    _check_one_wind(mission, solar)
    if solar.model in ATTITUDE_MODELS:
        power = mean_power_on_path(
            solar.model,
            flown_modules(aircraft, mission, solar.model),
            Daylight(
                mission.latitudes()[0],
                sunlit.day_of_year,
                sunlit.time_solar_h,
                irradiance=sunlit.irradiance,
                albedo=mission.air.albedo or 0.0,
            ),
            ambient_temperature_c=sunlit.ambient_c,
            module_temperature_c=sunlit.module_c,
            surroundings=around,
        )
    else:
        convert = HORIZONTAL_MODELS[solar.model]
        up = sunlit.cos_zenith > 0.0
        if around is not None:
            convert = in_surroundings(convert, around._replace(ambient_c=sunlit.ambient_c[up]))
        power = np.zeros(up.shape)
        some = Irradiance(sunlit.irradiance.dni[up], sunlit.irradiance.dhi[up])
        power[up] = convert(some, sunlit.cos_zenith[up], aircraft.modules, sunlit.module_c[up])
    return _corrected(power, aircraft, mission, solar, sunlit.day_of_year)


def _corrected(
    power: FloatArray,
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel,
    day_of_year: FloatArray,
) -> FloatArray:
    """Power at instants, the loiter ratio that of each instant's day under the clear sky."""
    if solar.correction == "loiter":
        days, place = np.unique(np.floor(day_of_year).astype(int), return_inverse=True)
        scenarios = Scenarios(np.full(len(days), mission.latitudes()[0]), (days - 1) % 365 + 1)
        ratio = Sunlight(aircraft, mission, scenarios).loiter_ratio(solar.model)
        power = power * ratio[place, 0]
    return power * mission.pessimistic_power_factor(solar.model, solar.correction)


def _check_one_wind(mission: Mission, solar: SolarModel) -> None:
    """Refuse winds that change while a path is flown from day to day."""
    if solar.needs_path and mission.wind_statistics is not None:
        message = "needs one wind from day to day: give wind_m_per_s in place of wind"
        raise file_error(mission.name, f"{solar.label} on a flight path {message}")
