"""Solar power averaged over a loiter path: VM and FM where only a flight path is known.

For each position of the sun the power is averaged over the attitudes of one orbit.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

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
# Times computed at once: a few megabytes of intermediate arrays.
_BLOCK = 512


class PathModules(NamedTuple):
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

    ``latitude_deg``: constant on a path. ``day_of_year``: fractional, scalar or shape ``(time,)``;
    noon, ``day + 0.5``, for a repeated day. ``time_solar_h``: local solar time, shape ``(time,)``.
    ``sky``: clear-sky model, at ``altitude_m`` and times ``clearness``. ``irradiance``: light in
    place of the clear sky, shape ``(time,)``. ``albedo``: share of light reflected from below [-].
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
    modules: PathModules,
    daylight: Daylight,
    *,
    ambient_temperature_c: ArrayLike,
    module_temperature_c: ArrayLike,
    surroundings: Surroundings | None = None,
) -> FloatArray:
    """Compute the specific power of VM or FM, averaged over the path [W/m2].

    Parameters
    ----------
    model : {"VM", "FM"}
        Solar power model.
    modules : PathModules
        Modules, path and wind.
    daylight : Daylight
        Sun and light.
    ambient_temperature_c, module_temperature_c : array_like
        Temperature of the air (FM) and of the modules (VM) [C], scalar or shape ``(time,)``.
    surroundings : Surroundings, optional
        Air and radiation of the modules' heat balance, in place of ``module_temperature_c``.

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
    model_temperature_c = module_temperature_c if model == "VM" else ambient_temperature_c
    attitudes = _orbit(modules.path, modules.wind, modules.samples)
    time_h = np.asarray(daylight.time_solar_h, float)
    temperature_c, air_c = (
        np.broadcast_to(np.asarray(temperature, float), time_h.shape)
        for temperature in (model_temperature_c, ambient_temperature_c)
    )
    result = np.zeros(time_h.shape)
    for start in range(0, len(time_h), _BLOCK):
        block = slice(start, start + _BLOCK)
        up, seen = _seen(daylight, block, attitudes)
        module_c = temperature_c[block][up, np.newaxis]
        around = surroundings
        if around is not None:
            around = around._replace(ambient_c=air_c[block][up, np.newaxis])
        others: dict[str, Any] = {"surroundings": around, "albedo": daylight.albedo}
        if model == "VM":
            power = verification_model(*seen, modules.geometry, modules.cell, module_c, **others)
        else:
            others["shading"] = modules.shading
            full = full_model(*seen, modules.geometry, modules.cell, module_c, **others)
            power = full.specific_power_w_per_m2
        result[block][up] = power @ attitudes.weights
    return result


def module_power_on_path(
    modules: PathModules,
    daylight: Daylight,
    *,
    ambient_temperature_c: float,
    surroundings: Surroundings | None = None,
) -> tuple[BoolArray, Orbit, ModulePower]:
    """Compute the Full Model with its component efficiencies at every attitude of the path.

    Arguments as of :func:`mean_power_on_path`. Returns a flag per time with the sun above the
    horizon; the attitudes with their weights; and the power at the flagged times, shape
    ``(time, attitude)``, by surface with one more axis.
    """
    attitudes = _orbit(modules.path, modules.wind, modules.samples)
    above_horizon, seen = _seen(daylight, slice(None), attitudes)
    power = full_model(
        *seen,
        modules.geometry,
        modules.cell,
        ambient_temperature_c,
        shading=modules.shading,
        surroundings=surroundings,
        albedo=daylight.albedo,
    )
    return above_horizon, attitudes, power


@lru_cache(maxsize=16)
def _orbit(path: FlightPath, wind: Wind, samples: int) -> Orbit:
    """Return the attitudes along a path, computed once for all days."""
    return orbit(path, wind, samples=samples)


def _seen(
    daylight: Daylight, block: slice, attitudes: Orbit
) -> tuple[BoolArray, tuple[Irradiance, FloatArray, FloatArray]]:
    """Return flags of times with the sun up; light, sun and attitudes (second axis) at these."""
    time_h = np.asarray(daylight.time_solar_h, float)
    day = np.broadcast_to(np.asarray(daylight.day_of_year, float), time_h.shape)[block]
    latitude_deg, sun_declination = daylight.latitude_deg, declination(day)
    hour = hour_angle(time_h[block])
    cosine = cos_zenith(latitude_deg, sun_declination, hour)
    above_horizon = cosine > 0.0
    day, cosine, hour = day[above_horizon], cosine[above_horizon], hour[above_horizon]
    sun = sun_vector_ned(latitude_deg, sun_declination[above_horizon], hour)[:, np.newaxis, :]
    if daylight.irradiance is None:
        clear = daylight.sky(day, latitude_deg, cosine, daylight.altitude_m)
        lit = [daylight.clearness * part for part in clear]
    else:
        lit = [part[block][above_horizon] for part in daylight.irradiance]
    light = Irradiance(*(part[:, np.newaxis] for part in lit))
    to_ned = direction_cosines(attitudes.roll_rad, attitudes.pitch_rad, attitudes.yaw_rad)
    return above_horizon, (light, sun, to_ned)
