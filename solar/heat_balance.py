"""Temperature of solar modules in flight, by a balance of heat.

Light that is absorbed, less the electric power, leaves by radiation and by convection from both
faces of the wing::

    a G + u a_u A H - P(T) = e (1 + u) s T^4 - e (L_down + u L_up) + h (1 + u) (T - T_air)

``G`` light on the modules, ``H`` light on a level surface, ``A`` albedo of the earth below, ``u``
share of the lower face, ``a`` and ``a_u`` absorptance of light, ``e`` emissivity, ``h`` convection,
``L`` long-wave radiation from above and below. Steady state; conduction along the wing is left out.

Source: Incropera, DeWitt, Bergman, Lavine, Fundamentals of Heat and Mass Transfer, 6th edition,
sections 1.3 and 1.5.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from solar.modules import SolarCell
from solar.types import FloatArray

STEFAN_BOLTZMANN = 5.670374e-8  # [W/(m2 K4)]
ZERO_CELSIUS_K = 273.15

# Means over the earth of long-wave radiation at the surface and at the top of the atmosphere
# [W/m2], and of the light that is reflected (102 of 341 W/m2): Trenberth, Fasullo & Kiehl (2009),
# Earth's global energy budget, Bull. Amer. Meteor. Soc. 90, 311-324, figure 1.
_UP_AT_SURFACE, _UP_AT_TOP, _DOWN_AT_SURFACE = 396.0, 239.0, 333.0
EARTH_ALBEDO = 0.30

_ROUNDS = 2
_COMMON_LIGHT = 400.0  # [W/m2]


class Surroundings(NamedTuple):
    """Air and radiation around the modules; numbers or arrays.

    ``ambient_c``: temperature of the air [C]. ``convection``: of one face [W/(m2 K)].
    ``relative_pressure``: pressure over that at sea level [-]. ``albedo``: of the earth below [-].
    """

    ambient_c: ArrayLike
    convection: ArrayLike
    relative_pressure: ArrayLike
    albedo: float = EARTH_ALBEDO


def long_wave_w_per_m2(relative_pressure: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return the long-wave radiation from above and from below [W/m2].

    Between the means at the surface and at the top of the atmosphere, linear in the pressure
    (assumption): a grey atmosphere absorbs and emits by its mass.
    """
    p = np.asarray(relative_pressure, float)
    return _DOWN_AT_SURFACE * p, _UP_AT_TOP + (_UP_AT_SURFACE - _UP_AT_TOP) * p


def balanced_temperature_c(
    light_w_per_m2: ArrayLike,
    level_light_w_per_m2: ArrayLike,
    electric_at_25_c: ArrayLike,
    cell: SolarCell,
    surroundings: Surroundings,
) -> FloatArray:
    """Return the module temperature at which the heat balance closes [C]; arguments broadcast.

    The earth reflects the light on a level surface. ``electric_at_25_c``: electric power of modules
    at 25 C, before the MPPT [W/m2].
    """
    thermal, around = cell.thermal, surroundings
    share, per_k = thermal.underside_share, cell.temperature_coefficient_per_k
    radiating = thermal.emissivity * (1.0 + share) * STEFAN_BOLTZMANN
    convected = np.asarray(around.convection, float) * (1.0 + share)
    air_c = np.asarray(around.ambient_c, float)
    air_k = air_c + ZERO_CELSIUS_K
    # Temperature in common light; the radiation is a polynomial of the difference from it.
    warmer_k = (
        thermal.absorptance * _COMMON_LIGHT / (convected + 4.0 * radiating * air_k * air_k**2)
    )
    kelvin = air_k + warmer_k
    square = kelvin**2  # NumPy's higher powers take many times as long as products
    down, up = long_wave_w_per_m2(around.relative_pressure)
    unlit = thermal.emissivity * (down + share * up) - radiating * square**2 - convected * warmer_k
    electric = np.asarray(electric_at_25_c, float)
    reflected = share * thermal.underside_absorptance * around.albedo
    second, third, fourth = (radiating * c for c in (6.0 * square, 4.0 * kelvin, 1.0))
    # Excess of heat at that temperature, and its derivative.
    left = thermal.absorptance * np.asarray(light_w_per_m2, float) + unlit
    left = left + reflected * np.asarray(level_light_w_per_m2, float)
    left = left - cell.temperature_efficiency(air_c + warmer_k) * electric
    root = (convected + 4.0 * radiating * square * kelvin) - per_k * electric
    # The root of the parabola that stays finite without bend.
    change = np.maximum(root * root + (4.0 * second) * left, 0.0)
    change = 2.0 * left / (root + np.sqrt(change))
    # And steps of Newton's rule, each point by itself.
    for _ in range(_ROUNDS):
        slope = ((4.0 * fourth * change + 3.0 * third) * change + 2.0 * second) * change + root
        excess = (((fourth * change + third) * change + second) * change + root) * change - left
        change = change - excess / slope
    return np.asarray(change + (air_c + warmer_k))
