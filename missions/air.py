"""International Standard Atmosphere up to 32 km, and air and wind from a mission's file.

Altitude is geometric altitude above mean sea level. Pressure follows the standard day; on a
hotter or colder day the density changes with the temperature at unchanged pressure, which is how
altimeters and performance charts count.

Source: ISO 2533:1975 / U.S. Standard Atmosphere 1976, layers 0 to 2; viscosity by Sutherland.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, Strict

from solar.schema import Allowed, Record, UnitInterval
from solar.types import FloatArray

TemperatureOffset = Annotated[float, Strict(), Field(ge=-60.0, le=60.0, allow_inf_nan=False)]
Temperature = Annotated[float, Strict(), Field(ge=-100.0, le=100.0, allow_inf_nan=False)]

GRAVITY_M_PER_S2 = 9.80665
GAS_CONSTANT_AIR = 287.05287  # [J/(kg K)]
HEAT_CAPACITY_RATIO = 1.4
ZERO_CELSIUS_K = 273.15
MAXIMUM_ALTITUDE_M = 32000.0
MINIMUM_ALTITUDE_M = -500.0

_HEAT_CAPACITY = 1005.0  # of air at constant pressure [J/(kg K)]: Incropera et al., table A.4
_EARTH_RADIUS_M = 6356766.0
_SEA_LEVEL_TEMPERATURE_K = 288.15
_SEA_LEVEL_PRESSURE_PA = 101325.0
# Base of each layer [m, geopotential] and its temperature gradient [K/m].
_LAYERS = ((0.0, -0.0065), (11000.0, 0.0), (20000.0, 0.001))
_SUTHERLAND_BETA = 1.458e-6  # [kg/(s m K^0.5)]
_SUTHERLAND_K = 110.4


def plain_number(value: Any) -> Any:
    """Convert a number without an axis to a float; return arrays and symbols as they are."""
    single = isinstance(value, np.generic | np.ndarray) and value.ndim == 0
    return float(value) if single else value


class Air(NamedTuple):
    """State of the air: temperature [K], pressure [Pa], density [kg/m3], viscosity [Pa s].

    Floats of a single altitude, else arrays.
    """

    temperature_k: FloatArray
    pressure_pa: FloatArray
    density_kg_per_m3: FloatArray
    dynamic_viscosity_pa_s: FloatArray

    @property
    def temperature_c(self) -> FloatArray:
        """Temperature [C]."""
        return self.temperature_k - ZERO_CELSIUS_K

    @property
    def speed_of_sound_m_per_s(self) -> FloatArray:
        """Speed of sound, ``sqrt(1.4 R T)`` [m/s]; also of a symbol."""
        speed: FloatArray = (HEAT_CAPACITY_RATIO * GAS_CONSTANT_AIR * self.temperature_k) ** 0.5
        return speed


def standard_air(altitude_m: ArrayLike, temperature_offset_k: ArrayLike = 0.0) -> Air:
    """Return the air at a geometric altitude on a standard day with a temperature offset.

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
    Allowed(MINIMUM_ALTITUDE_M, MAXIMUM_ALTITUDE_M).check("altitude_m", z)
    h = _EARTH_RADIUS_M * z / (_EARTH_RADIUS_M + z)  # geopotential
    temperature = np.full_like(h, _SEA_LEVEL_TEMPERATURE_K)
    pressure = np.full_like(h, _SEA_LEVEL_PRESSURE_PA)
    tops = [base for base, _ in _LAYERS[1:]] + [np.inf]
    for (base, gradient), top in zip(_LAYERS, tops, strict=True):
        # Below sea level the lowest layer is extended downwards.
        rise = np.clip(h, -np.inf if base == 0.0 else base, top) - base
        top_temperature = temperature + gradient * rise
        if gradient == 0.0:
            factor = np.exp(-GRAVITY_M_PER_S2 * rise / (GAS_CONSTANT_AIR * temperature))
        else:
            exponent = -GRAVITY_M_PER_S2 / (GAS_CONSTANT_AIR * gradient)
            factor = (top_temperature / temperature) ** exponent
        temperature, pressure = top_temperature, pressure * factor
    return air_at(temperature + np.asarray(temperature_offset_k, float), pressure)


def pressure_altitude_m(pressure_pa: ArrayLike) -> FloatArray:
    """Return the standard atmosphere's altitude of a pressure [m], infinite outside of its table.

    Within 0.1 m: interpolated in the logarithm of the pressure between altitudes 50 m apart.
    """
    heights = np.arange(MINIMUM_ALTITUDE_M, MAXIMUM_ALTITUDE_M + 50.0, 50.0)
    logs = np.log(standard_air(heights).pressure_pa)
    log_pressure = np.log(np.asarray(pressure_pa, float))
    outside = (log_pressure < logs[-1]) | (log_pressure > logs[0] + 1e-12)
    return np.where(outside, np.inf, np.interp(-log_pressure, -logs, heights))


def air_at(temperature_k: ArrayLike, pressure_pa: ArrayLike) -> Air:
    """Return the air of a temperature and a pressure: ideal gas, Sutherland viscosity."""
    t = np.asarray(temperature_k, float)
    p = np.asarray(pressure_pa, float)
    viscosity = _SUTHERLAND_BETA * t**1.5 / (t + _SUTHERLAND_K)
    return Air(*map(plain_number, (t, p, p / (GAS_CONSTANT_AIR * t), viscosity)))


class AirConditions(Record):
    """Air at flight altitude: standard, standard with an offset, or of a set temperature.

    ``albedo``: share of the light that the earth and its clouds send back up; given, it lights
    modules that face down (VM, FM).
    """

    _in_place_of: ClassVar[Mapping[str, str]] = {"ambient_temperature_c": "temperature_offset_k"}

    temperature_offset_k: TemperatureOffset | None = None
    ambient_temperature_c: Temperature | None = None
    module_temperature_c: Temperature | None = None
    albedo: UnitInterval | None = None

    def state(self, altitude_m: float) -> Air:
        """Return the air at the altitude that the temperatures hold for."""
        offset_k = self.temperature_offset_k
        standard = standard_air(altitude_m, 0.0 if offset_k is None else offset_k)
        if self.ambient_temperature_c is None:
            return standard
        return air_at(self.ambient_temperature_c + ZERO_CELSIUS_K, standard.pressure_pa)

    def moved(self, from_m: float, to_m: float) -> AirConditions:
        """Return the same weather at another altitude.

        Air warmer than standard stays so by as many kelvin at every altitude, and modules of a
        given temperature stay as much warmer than the air.
        """
        here = self.state(from_m)
        offset_k = here.temperature_k - standard_air(from_m).temperature_k
        update = {"temperature_offset_k": offset_k, "ambient_temperature_c": None}
        if self.module_temperature_c is not None:
            warmer_k = self.module_temperature_c - here.temperature_c
            update["module_temperature_c"] = standard_air(to_m, offset_k).temperature_c + warmer_k
        return self.model_copy(update=update)


# Batteries of published flights had no heater below the lower altitude; from the upper one on it is
# counted in full. Assumption.
_GROUND_UP_TO_M, _THIN_FROM_M = 3000.0, 4000.0


def thin_air_share(altitude_m: ArrayLike) -> FloatArray:
    """Return the assumed share of a battery's heater: 0 up to 3 km, 1 from 4 km, smooth."""
    way = (np.asarray(altitude_m, float) - _GROUND_UP_TO_M) / (_THIN_FROM_M - _GROUND_UP_TO_M)
    way = np.clip(way, 0.0, 1.0)
    return np.asarray(way * way * (3.0 - 2.0 * way))


def gust_speed_fraction(altitude_m: ArrayLike) -> FloatArray:
    """Return the gust speed over its value up to 6096 m [-], CS 23.333 (c).

    Both gust speeds fall linearly from 20 000 ft to half at 50 000 ft; above they are held.
    """
    fraction: FloatArray = np.interp(np.asarray(altitude_m, float), (6096.0, 15240.0), (1.0, 0.5))
    return fraction


def plate_convection_w_per_m2k(
    air: Air, airspeed_m_per_s: ArrayLike, chord_m: ArrayLike, transition_reynolds: float = 5e5
) -> FloatArray:
    """Return the mean forced convection on one face of a wing, a flat plate.

    ``Nu = 0.664 Re^0.5 Pr^(1/3)`` where the flow is laminar to the trailing edge, and ``(0.037
    Re^0.8 - A) Pr^(1/3)`` beyond, with ``A`` such that both agree at the transition.

    Source: Incropera, DeWitt, Bergman, Lavine, Fundamentals of Heat and Mass Transfer, 6th edition,
    equations 7.30 and 7.38. Conductivity of air: U.S. Standard Atmosphere 1976, equation 53.
    """
    t, viscosity = air.temperature_k, air.dynamic_viscosity_pa_s
    conductivity = 2.64638e-3 * t**1.5 / (t + 245.4 * 10.0 ** (-12.0 / t))
    prandtl = viscosity * _HEAT_CAPACITY / conductivity
    chord = np.asarray(chord_m, float)
    reynolds = air.density_kg_per_m3 * np.asarray(airspeed_m_per_s, float) * chord / viscosity
    laminar = 0.664 * np.sqrt(np.minimum(reynolds, transition_reynolds))
    beyond = 0.037 * (np.maximum(reynolds, transition_reynolds) ** 0.8 - transition_reynolds**0.8)
    return np.asarray((laminar + beyond) * prandtl ** (1.0 / 3.0) * conductivity / chord)
