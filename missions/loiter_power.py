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


def mean_power_on_path(
    model: ModelName,
    latitude_deg: float,
    day_of_year: ArrayLike,
    time_solar_h: ArrayLike,
    *,
    geometry: ModuleGeometry,
    cell: SolarCell,
    path: FlightPath,
    wind: Wind,
    ambient_temperature_c: ArrayLike,
    module_temperature_c: ArrayLike,
    altitude_m: float = 0.0,
    clearness: float = 1.0,
    shading: Shading | None = None,
    samples: int = ORBIT_SAMPLES,
    sky: ClearSky = clear_sky,
    irradiance: Irradiance | None = None,
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
    geometry, cell
        Module surfaces and efficiencies.
    path, wind
        Flight path and the wind it is flown in.
    ambient_temperature_c, module_temperature_c : array_like
        Temperature of the air (FM) and of the modules (VM), one for all times or one each [C].
    altitude_m, clearness : float
        Altitude [m] and factor on the clear-sky irradiance.
    shading : Shading, optional
        Tail and losses by its shadows, for FM.
    samples : int
        Attitudes per turning direction.
    sky : ClearSky
        Clear-sky model.
    irradiance : Irradiance, optional
        Direct normal and diffuse horizontal light of each time [W/m2], in place of the clear sky.

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
    flown = orbit(path, wind, samples=samples)
    result = np.zeros(time_h.shape)
    for start in range(0, len(time_h), _BLOCK):
        block = slice(start, start + _BLOCK)
        seen = _sky(latitude_deg, day[block], time_h[block], altitude_m, clearness, flown, sky)
        if irradiance is not None:
            given = (part[block][seen.lit, np.newaxis] for part in irradiance)
            seen = seen._replace(light=Irradiance(*given))
        if model == "VM":
            power = verification_model(
                seen.light,
                seen.sun,
                seen.to_ned,
                geometry,
                cell,
                module_c[block][seen.lit, np.newaxis],
            )
        else:
            power = full_model(
                seen.light,
                seen.sun,
                seen.to_ned,
                geometry,
                cell,
                ambient_c[block][seen.lit, np.newaxis],
                shading=shading,
            ).specific_power_w_per_m2
        result[block][seen.lit] = power @ flown.weights
    return result


def module_power_on_path(
    latitude_deg: float,
    day_of_year: ArrayLike,
    time_solar_h: ArrayLike,
    *,
    geometry: ModuleGeometry,
    cell: SolarCell,
    path: FlightPath,
    wind: Wind,
    ambient_temperature_c: float,
    altitude_m: float = 0.0,
    clearness: float = 1.0,
    shading: Shading | None = None,
    samples: int = ORBIT_SAMPLES,
    sky: ClearSky = clear_sky,
) -> tuple[BoolArray, Orbit, ModulePower]:
    """Full Model with its component efficiencies at every attitude of the path.

    Parameters
    ----------
    latitude_deg, day_of_year, time_solar_h, geometry, cell, path, wind, ambient_temperature_c
        As in :func:`mean_power_on_path`.
    altitude_m, clearness, shading, samples, sky
        As in :func:`mean_power_on_path`.

    Returns
    -------
    lit : ndarray of bool, shape (time,)
        Times with the sun above the horizon; the power covers these alone.
    orbit : Orbit
        Attitudes and their weights.
    power : ModulePower
        Arrays of shape ``(lit time, attitude)``, by surface with one more axis.
    """
    flown = orbit(path, wind, samples=samples)
    time_h = np.asarray(time_solar_h, float)
    day = np.broadcast_to(np.asarray(day_of_year, float), time_h.shape)
    seen = _sky(latitude_deg, day, time_h, altitude_m, clearness, flown, sky)
    power = full_model(
        seen.light, seen.sun, seen.to_ned, geometry, cell, ambient_temperature_c, shading=shading
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
    altitude_m: float,
    clearness: float,
    flown: Orbit,
    clear_sky_model: ClearSky,
) -> _Sky:
    sun_declination, hour = declination(day), hour_angle(time_h)
    cosine = cos_zenith(latitude_deg, sun_declination, hour)
    lit = cosine > 0.0
    sun = sun_vector_ned(latitude_deg, sun_declination[lit], hour[lit])[:, np.newaxis, :]
    clear = clear_sky_model(day[lit], latitude_deg, cosine[lit], altitude_m)
    light = Irradiance(*(clearness * part[:, np.newaxis] for part in clear))
    to_ned = direction_cosines(flown.roll_rad, flown.pitch_rad, flown.yaw_rad)
    return _Sky(lit, sun, light, to_ned)
