"""Clear-sky irradiance with monthly coefficients (ASHRAE type) at any altitude.

``DNI = A exp(-B m p/p0)`` and ``DHI = C DNI`` with the air mass ``m`` and the pressure ratio
``p/p0``, after Markus & Morris (1980), Buildings, Climate and Energy. A, B and C are tabulated
in the middle of each month and interpolated linearly, periodically over the year.

A and C were fitted on the ground. High up, where hardly any air is left to scatter the light, they
give too little direct and far too much diffuse light: between 9 and 12 km they pass smoothly into
the light under air without water and dust (:func:`thin_air_irradiance`). Up to 9 km they hold
alone; the diffuse light is never more than what the direct beam has lost on its way
(:func:`clear_sky`), a bound that takes effect above some 8 km.

Any function with the arguments and the result of :func:`clear_sky` can take its place; see
:func:`register_clear_sky`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from solar.sun import DAYS_PER_YEAR, day_angle
from solar.types import FloatArray

# Apparent extraterrestrial irradiance [W/m2], optical depth [-], diffuse ratio [-], Jan..Dec.
# Source: Markus & Morris (1980), ASHRAE type; the set used in the design of AtlantikSolar.
# (Other prints of the ASHRAE table have 0.063 as the C of November.)
MONTHLY_A = np.array(
    [1230.0, 1214.0, 1185.0, 1135.0, 1103.0, 1088.0, 1085.0, 1107.0, 1151.0, 1192.0, 1220.0, 1233.0]
)
MONTHLY_B = np.array(
    [0.142, 0.144, 0.156, 0.180, 0.196, 0.205, 0.207, 0.201, 0.177, 0.160, 0.149, 0.142]
)
MONTHLY_C = np.array(
    [0.058, 0.060, 0.071, 0.097, 0.121, 0.134, 0.136, 0.122, 0.092, 0.073, 0.057, 0.057]
)

_DAYS_IN_MONTH = np.array([31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31], float)
# Day of year 1.0 is the very start of 1 January, so mid-January is day 16.5.
MID_MONTH_DAY = 1.0 + np.cumsum(_DAYS_IN_MONTH) - _DAYS_IN_MONTH / 2.0

_SCALE_HEIGHT_M = 44308.0
_PRESSURE_EXPONENT = 5.257
# Above the tropopause the standard atmosphere is isothermal, at 216.65 K (ISO 2533:1975):
# pressure falls by e over R T / g = 287.05287 x 216.65 / 9.80665 m.
_TROPOPAUSE_M = 11000.0
_STRATOSPHERE_SCALE_M = 6341.62

# Total solar irradiance at the mean distance: Kopp, G. and Lean, J. L. (2011), A new, lower value
# of total solar irradiance, Geophys. Res. Lett. 38, L01706.
SOLAR_CONSTANT_W_PER_M2 = 1361.0

# Where the coefficients of the ground begin to fade, and where thin air has taken over. Assumption:
# the published sums of light are at low altitude and stay as they are; above the tropopause there
# is next to no water and dust.
GROUND_SKY_UP_TO_M = 9000.0
THIN_AIR_FROM_M = 12000.0
# Thickness of all ozone at standard pressure and temperature [cm], a mean over the earth: 300
# Dobson units, the value that Bird & Hulstrom's programs assume as well.
OZONE_CM = 0.3


class Irradiance(NamedTuple):
    """Direct normal and diffuse horizontal irradiance [W/m2]."""

    dni: FloatArray
    dhi: FloatArray


class Coefficients(NamedTuple):
    """A [W/m2], B [-] and C [-] of the clear sky, and the light outside the atmosphere [W/m2]."""

    a: FloatArray
    b: FloatArray
    c: FloatArray
    extraterrestrial: FloatArray


def monthly_coefficient(day_of_year: ArrayLike, monthly: ArrayLike) -> FloatArray:
    """Interpolate twelve mid-month values, January first, linearly and periodic over the year."""
    return np.asarray(
        np.interp(
            np.asarray(day_of_year, float), MID_MONTH_DAY, np.asarray(monthly), period=DAYS_PER_YEAR
        )
    )


def coefficients(day_of_year: ArrayLike, latitude_deg: ArrayLike) -> Coefficients:
    """Return A [W/m2], B [-] and C [-] for a day and a hemisphere, and the day's light [W/m2].

    B and C describe the season's water vapour and dust, so south of the equator they are shifted
    by half a year; A follows the distance to the sun and does not depend on the hemisphere. The
    arguments broadcast.
    """
    day = np.asarray(day_of_year, float)
    southern = np.asarray(latitude_deg, float) < 0.0
    season_day = day + np.where(southern, DAYS_PER_YEAR / 2.0, 0.0)
    a = monthly_coefficient(np.broadcast_to(day, np.shape(season_day)), MONTHLY_A)
    return Coefficients(
        a,
        monthly_coefficient(season_day, MONTHLY_B),
        monthly_coefficient(season_day, MONTHLY_C),
        np.broadcast_to(extraterrestrial_irradiance(day), np.shape(season_day)),
    )


def air_mass(cos_zenith: ArrayLike) -> FloatArray:
    """Return the relative optical air mass [-], 35 at and below the horizon.

    Source: Rodgers et al. (1978) / ASHRAE form ``m = 35 / sqrt(1224 cos^2 z + 1)``.
    """
    c = np.maximum(np.asarray(cos_zenith, float), 0.0)
    return np.asarray(35.0 / np.sqrt(1224.0 * c * c + 1.0))


def pressure_ratio(altitude_m: ArrayLike) -> FloatArray:
    """Return the pressure at altitude over pressure at sea level [-].

    Up to the tropopause at 11 km by the formula of the clear-sky model, above it falling
    exponentially as in the isothermal stratosphere: 0.4 % below the standard atmosphere at 11 km,
    1.1 % at 20 km and 7 % at 32 km. (The formula alone would be 22 % low at 20 km.)
    """
    h = np.asarray(altitude_m, float)
    below = np.maximum(1.0 - np.minimum(h, _TROPOPAUSE_M) / _SCALE_HEIGHT_M, 0.0)
    above_m = np.maximum(h - _TROPOPAUSE_M, 0.0)
    return np.asarray(below**_PRESSURE_EXPONENT * np.exp(-above_m / _STRATOSPHERE_SCALE_M))


_GROUND_SKY_DOWN_TO_RATIO = float(pressure_ratio(GROUND_SKY_UP_TO_M))
_THIN_AIR_BELOW_RATIO = float(pressure_ratio(THIN_AIR_FROM_M))


def extraterrestrial_irradiance(day_of_year: ArrayLike) -> FloatArray:
    """Return the irradiance normal to the beam outside the atmosphere [W/m2].

    Source: Spencer, J. W. (1971), Fourier series representation of the position of the sun,
    Search 2 (5), 172: the squared ratio of mean to actual distance.
    """
    angle = day_angle(day_of_year)
    ratio = (
        1.000110
        + 0.034221 * np.cos(angle)
        + 0.001280 * np.sin(angle)
        + 0.000719 * np.cos(2.0 * angle)
        + 0.000077 * np.sin(2.0 * angle)
    )
    return np.asarray(SOLAR_CONSTANT_W_PER_M2 * ratio)


def clear_sky(
    day_of_year: ArrayLike,
    latitude_deg: ArrayLike,
    cos_zenith: ArrayLike,
    altitude_m: ArrayLike = 0.0,
) -> Irradiance:
    """Compute direct normal and diffuse horizontal irradiance under a clear sky.

    A horizontal surface never gets more light than the sun sends to it from outside the
    atmosphere: ``DHI <= (E0 - DNI) cos z``. From 9 km up the sky of the ground passes into that of
    thin air, which it is from 12 km on.

    Parameters
    ----------
    day_of_year : array_like
        Fractional day of year.
    latitude_deg : array_like
        Latitude [deg]; only its sign matters (the season of B and C).
    cos_zenith : array_like
        Cosine of the zenith angle; where it is not positive both results are zero.
    altitude_m : array_like
        Altitude above mean sea level [m].

    Returns
    -------
    Irradiance
        ``dni`` and ``dhi`` [W/m2] with the broadcast shape of the arguments.
    """
    sky = coefficients(day_of_year, latitude_deg)
    return irradiance_under(sky, cos_zenith, pressure_ratio(altitude_m))


def irradiance_under(
    sky: Coefficients, cos_zenith: ArrayLike, relative_pressure: ArrayLike
) -> Irradiance:
    """Compute the irradiance [W/m2] for a sky's coefficients, at a pressure over sea level's [-].

    The arguments broadcast; zero with the sun below the horizon.
    """
    cos_z = np.asarray(cos_zenith, float)
    pressure = np.asarray(relative_pressure, float)
    optical_path = sky.b * pressure * air_mass(cos_z)
    dni = np.where(cos_z > 0.0, sky.a * np.exp(-optical_path), 0.0)
    lost = (sky.extraterrestrial - dni) * np.maximum(cos_z, 0.0)
    dhi = np.minimum(sky.c * dni, lost)
    if np.all(pressure >= _GROUND_SKY_DOWN_TO_RATIO):
        return Irradiance(dni, dhi)
    thin = thin_air_irradiance(sky.extraterrestrial, cos_z, pressure)
    # 0 up to 9 km, 1 from 12 km on, without a kink between.
    span = _GROUND_SKY_DOWN_TO_RATIO - _THIN_AIR_BELOW_RATIO
    way = np.clip((_GROUND_SKY_DOWN_TO_RATIO - pressure) / span, 0.0, 1.0)
    share = way * way * (3.0 - 2.0 * way)
    ground = 1.0 - share
    return Irradiance(ground * dni + share * thin.dni, ground * dhi + share * thin.dhi)


def thin_air_irradiance(
    extraterrestrial_w_per_m2: ArrayLike, cos_zenith: ArrayLike, relative_pressure: ArrayLike
) -> Irradiance:
    """Compute the irradiance [W/m2] under air without water and dust, as above the tropopause.

    The direct light passes Rayleigh scattering, the whole ozone layer, which lies mostly above the
    aircraft, and absorption by carbon dioxide and oxygen; half of the scattered light comes down.
    Light outside 0.3 to 3 um, 3.4 % of all, is not counted: no silicon cell uses it. The arguments
    broadcast; ``relative_pressure`` counts as at most its value at 9 km. Zero with the sun below
    the horizon.

    Source: Bird, R. E. and Hulstrom, R. L. (1981), A simplified clear sky model for direct and
    diffuse insolation on horizontal surfaces, SERI/TR-642-761, with no water vapour, aerosol or
    light from the ground, and with the air mass of :func:`air_mass`.
    """
    cos_z = np.maximum(np.asarray(cos_zenith, float), 0.0)
    sun = np.where(cos_z > 0.0, np.asarray(extraterrestrial_w_per_m2, float), 0.0)
    mass = air_mass(cos_z)
    # The formula of Rayleigh scattering turns at an air mass of some 16; at 9 km it is below 11.
    relative = np.minimum(np.asarray(relative_pressure, float), _GROUND_SKY_DOWN_TO_RATIO)
    air = mass * relative
    ozone = OZONE_CM * mass
    rayleigh = np.exp(-0.0903 * air**0.84 * (1.0 + air - air**1.01))
    through_ozone = (
        1.0
        - 0.1611 * ozone * (1.0 + 139.48 * ozone) ** -0.3035
        - 0.002715 * ozone / (1.0 + 0.044 * ozone + 0.0003 * ozone**2)
    )
    transmitted = sun * through_ozone * np.exp(-0.0127 * air**0.26)
    scattered_down = 0.79 * 0.5 * (1.0 - rayleigh) / (1.0 - mass + mass**1.02)
    return Irradiance(0.9662 * transmitted * rayleigh, transmitted * cos_z * scattered_down)


def global_horizontal(irradiance: Irradiance, cos_zenith: ArrayLike) -> FloatArray:
    """Return the global horizontal irradiance, ``DNI cos z + DHI`` [W/m2].

    Source: Duffie & Beckman, Solar Engineering of Thermal Processes.
    """
    projected = irradiance.dni * np.maximum(np.asarray(cos_zenith, float), 0.0)
    return np.asarray(projected + irradiance.dhi)


ClearSky: TypeAlias = Callable[[ArrayLike, ArrayLike, ArrayLike, ArrayLike], Irradiance]
"""Irradiance of day of year, latitude [deg], cosine of the zenith angle and altitude [m].

As :func:`clear_sky`: the arguments broadcast, and both results are zero with the sun below the
horizon.
"""

CLEAR_SKIES: dict[str, ClearSky] = {"ashrae": clear_sky}


def register_clear_sky(name: str, sky: ClearSky) -> None:
    """Register a user-defined clear sky by a name, for a mission's ``clear_sky``.

    The name holds in this process alone: others, such as the workers of a long map, must register
    the sky themselves.

    Parameters
    ----------
    name : str
        A name that is not taken.
    sky : ClearSky
        From day of year, latitude [deg], cosine of the zenith angle and altitude [m] to irradiance.

    Raises
    ------
    ValueError
        If the name is taken.
    """
    if name in CLEAR_SKIES:
        raise ValueError(f"there is a clear sky {name} already")
    CLEAR_SKIES[name] = sky


def named_clear_sky(name: str) -> ClearSky:
    """Return the clear sky of a name; ValueError if there is none."""
    if name not in CLEAR_SKIES:
        raise ValueError(f"unknown clear sky {name!r}; choose from {', '.join(CLEAR_SKIES)}")
    return CLEAR_SKIES[name]
