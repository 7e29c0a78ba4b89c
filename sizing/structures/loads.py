"""Loads of a structure: wing, masses and flight, load factors and bending moments.

Load factors have the forms of CS-23 (EASA, formerly FAR 23).

AtlantikSolar was designed by these airworthiness codes of light aeroplanes, which are not binding
for its class. Airspeeds are equivalent airspeeds, which give the same loads at every altitude.
Arithmetic alone, for floats, arrays and symbols.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import pi
from typing import NamedTuple

import numpy as np

from missions.air import GRAVITY_M_PER_S2
from sizing.smooth import Value, smooth_absolute

SEA_LEVEL_DENSITY_KG_PER_M3 = 1.225  # [kg/m3], standard day


class StructureInputs(NamedTuple):
    """Wing, masses and flight for the sizing of a structure.

    ``span_load_kg``: battery and modules spread evenly along the span, which relieves the spar.
    ``airspeed_m_per_s``: true airspeed of level flight, taken as cruise. ``wing_battery_kg``,
    ``pod_battery_kg``: battery within the span load, and the rest of it. ``gust_fraction``: gust
    speed at altitude over that at the ground [-], :func:`missions.air.gust_speed_fraction`.
    """

    wingspan_m: Value
    aspect_ratio: Value
    total_mass_kg: Value
    span_load_kg: Value
    airspeed_m_per_s: Value
    density_kg_per_m3: Value
    wing_battery_kg: Value = 0.0
    pod_battery_kg: Value = 0.0
    gust_fraction: Value = 1.0

    @property
    def chord_m(self) -> Value:
        """Mean chord [m]."""
        return self.wingspan_m / self.aspect_ratio

    @property
    def wing_area_m2(self) -> Value:
        """Wing area [m2]."""
        return self.wingspan_m * self.chord_m


def limit_load_factor(total_mass_kg: Value) -> Value:
    """Return the limit load factor of CS-23 form, ``2.1 + 10900/(m + 4536)`` with m in kg [-]."""
    return 2.1 + 10900.0 / (total_mass_kg + 4536.0)


def lift_curve_slope(aspect_ratio: Value) -> Value:
    """Return the lift slope of a straight wing, ``2 pi AR/(AR + 2)`` [1/rad].

    Prandtl's lifting line with elliptic lift (Anderson, Fundamentals of Aerodynamics, chapter 5).
    """
    return 2.0 * pi * aspect_ratio / (aspect_ratio + 2.0)


def gust_load_increment(gust_times_airspeed: Value, inputs: StructureInputs) -> Value:
    """Return the magnitude of a sharp-edged gust's load factor increment, CS 23.341 [-].

    ``dn = K_g rho_0 a U V / (2 W/S)`` with gust times airspeed ``U V``, both equivalent [m2/s2],
    the alleviation factor ``K_g = 0.88 mu/(5.3 + mu)`` and the mass ratio ``mu = 2 m/(rho S c a)``,
    ``c = b/AR``, which the air density enters alone.
    """
    area_m2, slope = inputs.wing_area_m2, lift_curve_slope(inputs.aspect_ratio)
    chord_m = (area_m2 / inputs.aspect_ratio) ** 0.5
    ratio = 2.0 * inputs.total_mass_kg / (inputs.density_kg_per_m3 * area_m2 * chord_m * slope)
    pressure = inputs.total_mass_kg * GRAVITY_M_PER_S2 / area_m2
    rate = SEA_LEVEL_DENSITY_KG_PER_M3 * slope * gust_times_airspeed
    return 0.88 * ratio / (5.3 + ratio) * rate / (2.0 * pressure)


def root_bending_moment_nm(
    wingspan_m: Value, total_mass_kg: Value, span_load_kg: Value, minimum_fraction: float
) -> Value:
    """Return the root bending moment at limit load [N m], relieved by the mass along the span.

    ``n g b (m/(3 pi) - m_span/8)`` with the limit load factor n: an elliptic lift of one half-wing
    acts at 4/(3 pi) of the half-span, an even mass at 1/2 of it. The floor is ``minimum_fraction``
    of the unrelieved moment. The smooth maximum of both exceeds them by at most 2 % of the
    unrelieved moment.
    """
    newton = limit_load_factor(total_mass_kg) * GRAVITY_M_PER_S2
    unrelieved = newton * total_mass_kg * wingspan_m / (3.0 * pi)
    relieved = unrelieved - newton * span_load_kg * wingspan_m / 8.0
    floor = minimum_fraction * unrelieved
    gap = relieved - floor
    return floor + (gap + smooth_absolute(gap, unrelieved, 0.04)) / 2.0


# Points of the Gauss-Legendre rule along the half-span; see docs/structure.md for its error.
STATION_COUNT = 6


# Root moments of the same unit lift and mass; the elliptic lift acts at 4/(3 pi) of the half-span.
LIFT_AT_ROOT, MASS_AT_ROOT = 4.0 / (3.0 * pi), 0.5


class Station(NamedTuple):
    """Unit moments and shear at a fraction of the half-span, and its weight in an integral.

    ``lift_*`` belong to an elliptic lift of a half-wing, ``mass_*`` to an evenly spread mass,
    ``landed_*`` to that mass less the ground's reaction; per unit of half-wing load, and of
    half-span for the moments. ``wire``: share of the root's moment that a wire takes; one from
    above relieves ``landed_moment``.
    """

    fraction: Value
    weight: Value
    lift_moment: Value
    mass_moment: Value
    lift_shear: Value
    mass_shear: Value
    landed_moment: Value
    landed_shear: Value
    wire: Value


@cache
def stations(gear: float = 0.0, wire: float | None = None, landing_wires: bool = False) -> Station:
    """Return the stations of a Gauss-Legendre rule from root (0) to tip (1), as arrays.

    ``gear`` is the fraction of the half-span of the landing gear, ``wire`` that of the wire's
    attachment, None without a wire.
    """
    nodes, weights = np.polynomial.legendre.leggauss(STATION_COUNT)
    x = (nodes + 1.0) / 2.0
    # Area of the quarter circle outboard of x.
    outboard = (np.arccos(x) - x * (1.0 - x * x) ** 0.5) / 2.0
    mass = (1.0 - x) ** 2 / 2.0
    # The ground's reaction is even over the landing gear.
    ground = np.maximum(0.0, gear - x) ** 2 / (2.0 * gear) if gear else 0.0
    # A wire carries the whole moment at the root, decreasing linearly to its attachment.
    taken = np.zeros_like(x) if wire is None else np.maximum(0.0, 1.0 - x / wire)
    return Station(
        fraction=x,
        weight=weights / 2.0,
        lift_moment=((1.0 - x * x) ** 1.5 / 3.0 - x * outboard) * 4.0 / pi,
        mass_moment=mass,
        lift_shear=outboard * 4.0 / pi,
        mass_shear=1.0 - x,
        landed_moment=mass - ground - landing_wires * taken * (MASS_AT_ROOT - gear / 2.0),
        landed_shear=(1.0 - x) - (np.maximum(0.0, 1.0 - x / gear) if gear else 0.0),
        wire=taken,
    )


def along_the_span(columns: Station, *values: Value) -> tuple[Station, Callable[[Value], Value]]:
    """Return stations as arrays or symbols, as the values are, and the integral over them.

    Stations are the first axis of arrays and the rows of symbols.
    """
    if all(isinstance(value, (int, float, np.number, np.ndarray)) for value in values):
        shape = (-1, *(1 for _ in range(max(np.ndim(value) for value in values))))
        arrays = Station(*(column.reshape(shape) for column in columns))
        return arrays, lambda integrand: np.tensordot(columns.weight, integrand, 1)
    import casadi as ca

    rows = Station(*(ca.DM(column) for column in columns))
    return rows, lambda integrand: ca.dot(rows.weight, integrand)
