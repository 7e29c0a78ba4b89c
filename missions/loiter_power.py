"""Solar power averaged over a loiter path: VM and FM where only a flight path is known.

The orbit is flown once; for each position of the sun the power is averaged over its attitudes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from missions.flight_path import FlightPath, Orbit, Wind, orbit
from solar.attitude import direction_cosines
from solar.attitude_models import ModulePower, full_model, verification_model
from solar.clearsky import ClearSky, Irradiance, clear_sky
from solar.geometry import ModuleGeometry
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


class ModulesOnPath(NamedTuple):
    """Module surfaces on a flight path, in the wind it is flown in.

    ``shading``: tail and losses by its shadows, for FM. ``samples``: attitudes per turning
    direction.
    """

    geometry: ModuleGeometry
    cell: SolarCell
    path: FlightPath
    wind: Wind
    shading: Shading | None = None
    samples: int = ORBIT_SAMPLES


class LightAbove(NamedTuple):
    """Clear sky at an altitude [m], with a factor on its irradiance.

    ``irradiance``: direct normal and diffuse horizontal light of each time in its place [W/m2].
    """

    altitude_m: float = 0.0
    clearness: float = 1.0
    sky: ClearSky = clear_sky
    irradiance: Irradiance | None = None


def mean_power_on_path(
    model: ModelName,
    latitude_deg: float,
    day_of_year: ArrayLike,
    time_solar_h: ArrayLike,
    modules: ModulesOnPath,
    light: LightAbove,
    *,
    ambient_temperature_c: ArrayLike,
    module_temperature_c: ArrayLike,
) -> FloatArray:
    """Specific power of VM or FM over a day, averaged over the path [W/m2].

    Parameters
    ----------
    model : {"VM", "FM"}
        Solar power model.
    latitude_deg : float
        Latitude [deg].
    day_of_year : array_like
        Fractional day of year at each time; for a repeated day that of its noon, ``day + 0.5``.
    time_solar_h : array_like, shape (time,)
        Local solar time [h].
    modules, light
        What is flown on which path, and in which light.
    ambient_temperature_c, module_temperature_c : array_like
        Temperature of the air (FM) and of the modules (VM), one for all times or one each [C].

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
    time_h = np.asarray(time_solar_h, float)
    day = np.broadcast_to(np.asarray(day_of_year, float), time_h.shape)
    ambient_c, module_c = (
        np.broadcast_to(np.asarray(value, float), time_h.shape)
        for value in (ambient_temperature_c, module_temperature_c)
    )
    flown = orbit(modules.path, modules.wind, samples=modules.samples)
    result = np.zeros(time_h.shape)
    for start in range(0, len(time_h), _BLOCK):
        block = slice(start, start + _BLOCK)
        seen = _sky(latitude_deg, day[block], time_h[block], light, flown)
        if light.irradiance is not None:
            given = (part[block][seen.lit, np.newaxis] for part in light.irradiance)
            seen = seen._replace(light=Irradiance(*given))
        aboard = (seen.light, seen.sun, seen.to_ned, modules.geometry, modules.cell)
        if model == "VM":
            power = verification_model(*aboard, module_c[block][seen.lit, np.newaxis])
        else:
            air_c = ambient_c[block][seen.lit, np.newaxis]
            full = full_model(*aboard, air_c, shading=modules.shading)
            power = full.specific_power_w_per_m2
        result[block][seen.lit] = power @ flown.weights
    return result


def module_power_on_path(
    latitude_deg: float,
    day_of_year: ArrayLike,
    time_solar_h: ArrayLike,
    modules: ModulesOnPath,
    light: LightAbove,
    *,
    ambient_temperature_c: float,
) -> tuple[BoolArray, Orbit, ModulePower]:
    """Full Model with its component efficiencies at every attitude of the path.

    Parameters
    ----------
    latitude_deg, day_of_year, time_solar_h, modules, light, ambient_temperature_c
        As in :func:`mean_power_on_path`, under the clear sky.

    Returns
    -------
    lit : ndarray of bool, shape (time,)
        Times with the sun above the horizon; the power covers these alone.
    orbit : Orbit
        Attitudes and their weights.
    power : ModulePower
        Arrays of shape ``(lit time, attitude)``, by surface with one more axis.
    """
    flown = orbit(modules.path, modules.wind, samples=modules.samples)
    time_h = np.asarray(time_solar_h, float)
    day = np.broadcast_to(np.asarray(day_of_year, float), time_h.shape)
    seen = _sky(latitude_deg, day, time_h, light, flown)
    power = full_model(
        *(seen.light, seen.sun, seen.to_ned, modules.geometry, modules.cell),
        ambient_temperature_c,
        shading=modules.shading,
    )
    return seen.lit, flown, power


class _Sky(NamedTuple):
    """Sun and light at the lit times, ready to meet the attitudes on the second axis."""

    lit: BoolArray
    sun: FloatArray
    light: Irradiance
    to_ned: FloatArray


def _sky(
    latitude_deg: float,
    day: FloatArray,
    time_h: FloatArray,
    above: LightAbove,
    flown: Orbit,
) -> _Sky:
    sun_declination, hour = declination(day), hour_angle(time_h)
    cosine = cos_zenith(latitude_deg, sun_declination, hour)
    lit = cosine > 0.0
    sun = sun_vector_ned(latitude_deg, sun_declination[lit], hour[lit])[:, np.newaxis, :]
    clear = above.sky(day[lit], latitude_deg, cosine[lit], above.altitude_m)
    light = Irradiance(*(above.clearness * part[:, np.newaxis] for part in clear))
    to_ned = direction_cosines(flown.roll_rad, flown.pitch_rad, flown.yaw_rad)
    return _Sky(lit, sun, light, to_ned)
