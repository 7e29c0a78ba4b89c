"""International Standard Atmosphere up to 32 km with a temperature offset.

Altitude is geometric altitude above mean sea level. Pressure follows the standard day; on a
hotter or colder day the density changes with the temperature at unchanged pressure, which is how
altimeters and performance charts count.

Source: ISO 2533:1975 / U.S. Standard Atmosphere 1976, layers 0 to 2; viscosity by Sutherland.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from solar.types import FloatArray

GRAVITY_M_PER_S2 = 9.80665
GAS_CONSTANT_AIR = 287.05287  # [J/(kg K)]
ZERO_CELSIUS_K = 273.15
MAXIMUM_ALTITUDE_M = 32000.0
MINIMUM_ALTITUDE_M = -500.0

_EARTH_RADIUS_M = 6356766.0
_SEA_LEVEL_TEMPERATURE_K = 288.15
_SEA_LEVEL_PRESSURE_PA = 101325.0
# Base of each layer [m, geopotential] and its temperature gradient [K/m].
_LAYERS = ((0.0, -0.0065), (11000.0, 0.0), (20000.0, 0.001))
_SUTHERLAND_BETA = 1.458e-6  # [kg/(s m K^0.5)]
_SUTHERLAND_K = 110.4


class Air(NamedTuple):
    """State of the air: temperature [K], pressure [Pa], density [kg/m3], viscosity [Pa s]."""

    temperature_k: FloatArray
    pressure_pa: FloatArray
    density_kg_per_m3: FloatArray
    dynamic_viscosity_pa_s: FloatArray

    @property
    def temperature_c(self) -> FloatArray:
        """Temperature [C]."""
        return np.asarray(self.temperature_k - ZERO_CELSIUS_K)


def geopotential_altitude_m(altitude_m: ArrayLike) -> FloatArray:
    """Geopotential altitude [m] of a geometric one."""
    z = np.asarray(altitude_m, float)
    return np.asarray(_EARTH_RADIUS_M * z / (_EARTH_RADIUS_M + z))


def standard_air(altitude_m: ArrayLike, temperature_offset_k: ArrayLike = 0.0) -> Air:
    """Air at a geometric altitude on a standard day, or on one hotter by an offset.

    Parameters
    ----------
    altitude_m : array_like
        Geometric altitude above mean sea level [m], -500 to 32000.
    temperature_offset_k : array_like
        Temperature above standard [K], at all altitudes alike.

    Returns
    -------
    Air
        Temperature, pressure, density and viscosity; broadcast shape of the arguments.

    Raises
    ------
    ValueError
        Outside the altitudes that the model covers.
    """
    z = np.asarray(altitude_m, float)
    if np.any(z < MINIMUM_ALTITUDE_M) or np.any(z > MAXIMUM_ALTITUDE_M) or np.any(np.isnan(z)):
        raise ValueError(
            f"altitude_m must be from {MINIMUM_ALTITUDE_M:g} to {MAXIMUM_ALTITUDE_M:g} (got {z})"
        )
    standard_k, pressure = _standard_temperature_and_pressure(geopotential_altitude_m(z))
    return air_at(standard_k + np.asarray(temperature_offset_k, float), pressure)


def air_at(temperature_k: ArrayLike, pressure_pa: ArrayLike) -> Air:
    """Air of a given temperature [K] and pressure [Pa]: ideal gas, Sutherland viscosity.

    Parameters
    ----------
    temperature_k : array_like
        Temperature [K].
    pressure_pa : array_like
        Pressure [Pa].

    Returns
    -------
    Air
        With density [kg/m3] and dynamic viscosity [Pa s]; broadcast shape of the arguments.
    """
    t = np.asarray(temperature_k, float)
    p = np.asarray(pressure_pa, float)
    return Air(
        temperature_k=t,
        pressure_pa=p,
        density_kg_per_m3=np.asarray(p / (GAS_CONSTANT_AIR * t)),
        dynamic_viscosity_pa_s=np.asarray(_SUTHERLAND_BETA * t**1.5 / (t + _SUTHERLAND_K)),
    )


def _standard_temperature_and_pressure(h: FloatArray) -> tuple[FloatArray, FloatArray]:
    temperature = np.full_like(h, _SEA_LEVEL_TEMPERATURE_K)
    pressure = np.full_like(h, _SEA_LEVEL_PRESSURE_PA)
    tops = [base for base, _ in _LAYERS[1:]] + [np.inf]
    for (base, gradient), top in zip(_LAYERS, tops, strict=True):
        # Below sea level the lowest layer is extended downwards.
        lower = -np.inf if base == 0.0 else base
        rise = np.clip(h, lower, top) - base
        rise = rise if base == 0.0 else np.maximum(rise, 0.0)
        top_temperature = temperature + gradient * rise
        if gradient == 0.0:
            factor = np.exp(-GRAVITY_M_PER_S2 * rise / (GAS_CONSTANT_AIR * temperature))
        else:
            exponent = -GRAVITY_M_PER_S2 / (GAS_CONSTANT_AIR * gradient)
            factor = (top_temperature / temperature) ** exponent
        temperature, pressure = top_temperature, pressure * factor
    return temperature, pressure
