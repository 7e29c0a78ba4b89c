"""Solar power averaged over a loiter path: VM and FM where only a flight path is known.

The orbit is flown once; for each position of the sun the power is averaged over its attitudes.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from missions.flight_path import FlightPath, Orbit, Wind, orbit
from solar.attitude_models import ModulePower, full_model, verification_model
from solar.clearsky import ClearSky, Irradiance, clear_sky
from solar.geometry import ModuleGeometry, direction_cosines
from solar.heat_balance import Surroundings
from solar.modules import SolarCell
from solar.names import ATTITUDE_MODELS, ModelName
from solar.shading import Shading
from solar.sun import cos_zenith, declination, hour_angle, sun_vector_ned
from solar.types import BoolArray, FloatArray

# Attitudes per turning direction. The average converges exponentially over a closed orbit; 36 are
# within 1e-4 of the limit (docs/full-model.md).
ORBIT_SAMPLES = 36
# Times handled at once: a few megabytes of intermediate arrays.
_BLOCK = 512


class FlownModules(NamedTuple):
    """Solar modules on a path in the wind.

    ``shading``: tail and losses by its shadows, for FM. ``samples``: attitudes per turning
    direction.
    """

    geometry: ModuleGeometry
    cell: SolarCell
    path: FlightPath
    wind: Wind
    shading: Shading | None = None
    samples: int = ORBIT_SAMPLES


class Daylight(NamedTuple):
    """Sun and light over a day, or along a record.

    ``latitude_deg``: one for all times of a path. ``day_of_year``: fractional, one for all times or
    one each; for a repeated day that of its noon, ``day + 0.5``. ``time_solar_h``: local solar
    time, shape ``(time,)``. ``altitude_m``, ``clearness``, ``sky``: clear-sky model, where it is
    asked, and the factor on it. ``irradiance``: light of each time, in place of the clear sky.
    ``albedo``: share of the light that comes back from below [-].
    """

    latitude_deg: float | FloatArray
    day_of_year: ArrayLike
    time_solar_h: ArrayLike
    altitude_m: float = 0.0
    clearness: float = 1.0
    sky: ClearSky = clear_sky
    irradiance: Irradiance | None = None
    albedo: float = 0.0


def mean_power_on_path(
    model: ModelName,
    modules: FlownModules,
    daylight: Daylight,
    *,
    ambient_temperature_c: ArrayLike,
    module_temperature_c: ArrayLike,
    surroundings: Surroundings | None = None,
) -> FloatArray:
    """Specific power of VM or FM at the times of the daylight, averaged over the path [W/m2].

    Parameters
    ----------
    model : {"VM", "FM"}
        Solar power model.
    modules : FlownModules
        Modules, path and wind.
    daylight : Daylight
        Sun and light.
    ambient_temperature_c, module_temperature_c : array_like
        Temperature of the air (FM) and of the modules (VM), one for all times or one each [C].
    surroundings : Surroundings, optional
        Air and radiation by which the modules find their temperature; the air as for FM.

    Returns
    -------
    ndarray, shape (time,)
        Specific power [W/m2].

    Raises
    ------
    ValueError
        If the model does not know attitudes, or the wind is too strong for the path.
    """
    if model not in ATTITUDE_MODELS:
        raise ValueError(f"model {model} does not depend on the flight path; choose VM or FM")
    given = module_temperature_c if model == "VM" else ambient_temperature_c
    flown = _orbit(modules.path, modules.wind, modules.samples)
    time_h = np.asarray(daylight.time_solar_h, float)
    temperature_c, air_c = (
        np.broadcast_to(np.asarray(one, float), time_h.shape)
        for one in (given, ambient_temperature_c)
    )
    result = np.zeros(time_h.shape)
    for start in range(0, len(time_h), _BLOCK):
        block = slice(start, start + _BLOCK)
        seen = _seen(daylight, block, flown)
        lit_c = temperature_c[block][seen.sunlit, np.newaxis]
        around = surroundings
        if around is not None:
            around = around._replace(ambient_c=air_c[block][seen.sunlit, np.newaxis])
        if model == "VM":
            power = verification_model(
                *(seen.light, seen.sun, seen.to_ned, modules.geometry, modules.cell, lit_c),
                surroundings=around,
                albedo=daylight.albedo,
            )
        else:
            power = _full_model(
                modules, seen, lit_c, around, daylight.albedo
            ).specific_power_w_per_m2
        result[block][seen.sunlit] = power @ flown.weights
    return result


def module_power_on_path(
    modules: FlownModules,
    daylight: Daylight,
    *,
    ambient_temperature_c: float,
    surroundings: Surroundings | None = None,
) -> tuple[BoolArray, Orbit, ModulePower]:
    """Full Model with its component efficiencies at every attitude of the path.

    Takes what :func:`mean_power_on_path` takes. Returns the times with the sun above the horizon,
    which the power covers alone; the attitudes with their weights; and the power, of shape
    ``(lit time, attitude)``, by surface with one more axis.
    """
    flown = _orbit(modules.path, modules.wind, modules.samples)
    seen = _seen(daylight, slice(None), flown)
    power = _full_model(modules, seen, ambient_temperature_c, surroundings, daylight.albedo)
    return seen.sunlit, flown, power


@lru_cache(maxsize=16)
def _orbit(path: FlightPath, wind: Wind, samples: int) -> Orbit:
    """Attitudes of a path, flown once for all days."""
    return orbit(path, wind, samples=samples)


def _full_model(
    modules: FlownModules,
    seen: _Seen,
    ambient_c: ArrayLike,
    surroundings: Surroundings | None = None,
    albedo: float = 0.0,
) -> ModulePower:
    return full_model(
        seen.light,
        seen.sun,
        seen.to_ned,
        modules.geometry,
        modules.cell,
        ambient_c,
        shading=modules.shading,
        surroundings=surroundings,
        albedo=albedo,
    )


class _Seen(NamedTuple):
    """Sun and light at the lit times, ready to meet the attitudes on the second axis."""

    sunlit: BoolArray
    sun: FloatArray
    light: Irradiance
    to_ned: FloatArray


def _seen(daylight: Daylight, block: slice, flown: Orbit) -> _Seen:
    """What the modules see at some of the times."""
    time_h = np.asarray(daylight.time_solar_h, float)
    day = np.broadcast_to(np.asarray(daylight.day_of_year, float), time_h.shape)[block]
    latitude_deg, sun_declination = daylight.latitude_deg, declination(day)
    hour = hour_angle(time_h[block])
    cosine = cos_zenith(latitude_deg, sun_declination, hour)
    sunlit = cosine > 0.0
    sun = sun_vector_ned(latitude_deg, sun_declination[sunlit], hour[sunlit])[:, np.newaxis, :]
    if daylight.irradiance is None:
        clear = daylight.sky(day[sunlit], latitude_deg, cosine[sunlit], daylight.altitude_m)
        light = Irradiance(*(daylight.clearness * part[:, np.newaxis] for part in clear))
    else:
        light = Irradiance(*(part[block][sunlit, np.newaxis] for part in daylight.irradiance))
    to_ned = direction_cosines(flown.roll_rad, flown.pitch_rad, flown.yaw_rad)
    return _Seen(sunlit, sun, light, to_ned)
