"""What a structure is sized from: wing, masses and flight, load factors and root bending moment.

Load factors have the forms of CS-23 (EASA, formerly FAR 23).

Airworthiness codes for light aeroplanes are not binding for aircraft of this class; they are what
AtlantikSolar was designed with. Airspeeds are equivalent airspeeds: a wing feels the same load at
every altitude for the same equivalent airspeed. Arithmetic only, for floats, arrays and symbols.
"""

from __future__ import annotations

from math import pi
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from missions.air import GRAVITY_M_PER_S2
from sizing.smooth import Value, smooth_absolute
from solar.types import FloatArray

SEA_LEVEL_DENSITY_KG_PER_M3 = 1.225  # [kg/m3], standard day


class StructureInputs(NamedTuple):
    """Wing, masses and flight that a structure is sized from.

    Attributes
    ----------
    wingspan_m, aspect_ratio
        Span [m] and aspect ratio [-] of the wing.
    total_mass_kg
        Take-off mass [kg].
    span_load_kg
        Mass spread evenly along the span, battery and modules, which relieves the spar [kg].
    airspeed_m_per_s, density_kg_per_m3
        True airspeed of level flight [m/s], taken as cruise, and density of the air [kg/m3].
    wing_battery_kg, pod_battery_kg
        Battery within the span load, and the rest of it [kg].
    gust_fraction
        Gust speed at the flight's altitude over that near the ground [-], see
        :func:`gust_speed_fraction`.
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


def gust_speed_fraction(altitude_m: ArrayLike) -> FloatArray:
    """Gust speed at an altitude over that up to 6096 m [-], CS 23.333 (c).

    Both gust speeds fall linearly from 20 000 ft to half at 50 000 ft; above they are held.
    """
    fraction: FloatArray = np.interp(np.asarray(altitude_m, float), (6096.0, 15240.0), (1.0, 0.5))
    return fraction


def limit_load_factor(total_mass_kg: Value) -> Value:
    """Limit load factor [-] of the CS-23 form, ``2.1 + 10900/(m + 4536)`` with m in kg."""
    return 2.1 + 10900.0 / (total_mass_kg + 4536.0)


def lift_curve_slope(aspect_ratio: Value) -> Value:
    """Lift slope of a straight wing [1/rad], ``2 pi AR/(AR + 2)``.

    Prandtl's lifting line with elliptic lift (Anderson, Fundamentals of Aerodynamics, chapter 5).
    """
    return 2.0 * pi * aspect_ratio / (aspect_ratio + 2.0)


def gust_alleviation_factor(mass_ratio: Value) -> Value:
    """Gust alleviation factor of CS 23.341, ``0.88 mu/(5.3 + mu)``."""
    return 0.88 * mass_ratio / (5.3 + mass_ratio)


def gust_mass_ratio(
    *, total_mass_kg: Value, wing_area_m2: Value, aspect_ratio: Value, density_kg_per_m3: Value
) -> Value:
    """Aeroplane mass ratio of CS 23.341, ``2 m/(rho S c a)``, with the mean chord c = b/AR [-].

    Parameters
    ----------
    total_mass_kg, wing_area_m2, aspect_ratio
        Mass [kg], wing area [m2] and aspect ratio [-].
    density_kg_per_m3
        Of the air [kg/m3].

    Returns
    -------
    Value
        Ratio mu, for :func:`gust_alleviation_factor` [-].
    """
    chord_m = (wing_area_m2 / aspect_ratio) ** 0.5
    slope = lift_curve_slope(aspect_ratio)
    return 2.0 * total_mass_kg / (density_kg_per_m3 * wing_area_m2 * chord_m * slope)


def gust_load_increment(
    gust_times_airspeed: Value,
    *,
    total_mass_kg: Value,
    wing_area_m2: Value,
    aspect_ratio: Value,
    density_kg_per_m3: Value,
) -> Value:
    """Load factor that a sharp-edged gust adds or takes away [-], CS 23.341.

    ``dn = K_g rho_0 a U V / (2 W/S)``.

    Parameters
    ----------
    gust_times_airspeed
        Gust velocity U times airspeed V, both equivalent [m2/s2].
    total_mass_kg, wing_area_m2, aspect_ratio
        Mass [kg], wing area [m2] and aspect ratio [-].
    density_kg_per_m3
        Of the air [kg/m3]: it alone sets the mass ratio.

    Returns
    -------
    Value
        Magnitude; the gust load factors are ``1 + dn`` and ``1 - dn`` [-].
    """
    ratio = gust_mass_ratio(
        total_mass_kg=total_mass_kg,
        wing_area_m2=wing_area_m2,
        aspect_ratio=aspect_ratio,
        density_kg_per_m3=density_kg_per_m3,
    )
    pressure = total_mass_kg * GRAVITY_M_PER_S2 / wing_area_m2
    rate = SEA_LEVEL_DENSITY_KG_PER_M3 * lift_curve_slope(aspect_ratio) * gust_times_airspeed
    return gust_alleviation_factor(ratio) * rate / (2.0 * pressure)


def root_bending_moment_nm(
    wingspan_m: Value, total_mass_kg: Value, span_load_kg: Value, minimum_fraction: float
) -> Value:
    """Root bending moment at limit load [N m], relieved by the mass along the span.

    An elliptic lift of one half-wing acts at 4/(3 pi) of the half-span, an even mass at 1/2 of it.
    The larger of the relieved moment and the floor is taken by a smooth maximum, which lies above
    both by at most 2 % of the unrelieved moment.

    Parameters
    ----------
    wingspan_m
        Span [m].
    total_mass_kg, span_load_kg
        Take-off mass, and mass spread evenly along the span [kg].
    minimum_fraction : float
        Floor, as a fraction of the unrelieved moment [-].

    Returns
    -------
    Value
        ``n g b (m/(3 pi) - m_span/8)`` with the limit load factor n, or the floor [N m].
    """
    newton = limit_load_factor(total_mass_kg) * GRAVITY_M_PER_S2
    unrelieved = newton * total_mass_kg * wingspan_m / (3.0 * pi)
    relieved = unrelieved - newton * span_load_kg * wingspan_m / 8.0
    floor = minimum_fraction * unrelieved
    gap = relieved - floor
    return floor + (gap + smooth_absolute(gap, unrelieved, 0.04)) / 2.0
