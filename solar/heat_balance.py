"""Temperature of solar modules in thin air, by a balance of heat.

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

from solar.clearsky import Irradiance, global_horizontal
from solar.modules import STC_TEMPERATURE_C, SolarCell
from solar.types import FloatArray

STEFAN_BOLTZMANN = 5.670374e-8  # [W/(m2 K4)]
ZERO_CELSIUS_K = 273.15

# Means over the earth of long-wave radiation at the surface and at the top of the atmosphere
# [W/m2], and of the light that is reflected (102 of 341 W/m2): Trenberth, Fasullo & Kiehl (2009),
# Earth's global energy budget, Bull. Amer. Meteor. Soc. 90, 311-324, figure 1.
_UP_AT_SURFACE, _UP_AT_TOP, _DOWN_AT_SURFACE = 396.0, 239.0, 333.0
EARTH_ALBEDO = 0.30

# Newton's rule doubles the digits each time and begins within 100 K.
_ROUNDS = 8
_TOLERANCE_K = 1e-9


class Surroundings(NamedTuple):
    """What heats and cools modules besides the light on them; numbers or arrays.

    ``ambient_c``: temperature of the air [C]. ``convection``: of one face [W/(m2 K)].
    ``relative_pressure``: pressure over that at sea level [-]. ``albedo``: of the earth below [-].
    ``share``: how much of the balance counts [-]; with 0 the modules have the temperature of the
    air, or that of the model's own rule.
    """

    ambient_c: ArrayLike
    convection: ArrayLike
    relative_pressure: ArrayLike
    albedo: float = EARTH_ALBEDO
    share: float = 1.0


def long_wave_w_per_m2(relative_pressure: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Long-wave radiation from above and from below [W/m2].

    Between the means at the surface and at the top of the atmosphere, linear in the pressure
    (assumption): a grey atmosphere absorbs and emits by its mass.
    """
    p = np.asarray(relative_pressure, float)
    return _DOWN_AT_SURFACE * p, _UP_AT_TOP + (_UP_AT_SURFACE - _UP_AT_TOP) * p


def balanced_temperature_c(
    light_w_per_m2: ArrayLike,
    electric_at_25_c: ArrayLike,
    level_light: Irradiance,
    cos_zenith: ArrayLike,
    cell: SolarCell,
    surroundings: Surroundings,
) -> FloatArray:
    """Temperature at which modules lose as much heat as the light brings.

    Parameters
    ----------
    light_w_per_m2 : array_like
        Light on the modules [W/m2].
    electric_at_25_c : array_like
        Electric power per area of the modules before the MPPT if they had 25 C [W/m2].
    level_light : Irradiance
        Direct normal and diffuse horizontal light [W/m2]; the earth reflects it.
    cos_zenith : array_like
        Cosine of the sun's zenith angle [-].
    cell : SolarCell
        With what its record says of heat.
    surroundings : Surroundings
        Air and radiation; ``share`` plays no part.

    Returns
    -------
    ndarray
        Temperature [C], broadcast shape of the arguments.
    """
    thermal, around = cell.thermal, surroundings
    faces = 1.0 + thermal.underside_share
    down, up = long_wave_w_per_m2(around.relative_pressure)
    air_k = np.asarray(around.ambient_c, float) + ZERO_CELSIUS_K
    reflected = around.albedo * global_horizontal(level_light, cos_zenith)
    electric = np.asarray(electric_at_25_c, float)
    convected = np.asarray(around.convection, float) * faces
    brought = (
        thermal.absorptance * np.asarray(light_w_per_m2, float)
        + thermal.underside_share * thermal.underside_absorptance * reflected
        + thermal.emissivity * (down + thermal.underside_share * up)
        + convected * air_k
    )
    radiating = thermal.emissivity * faces * STEFAN_BOLTZMANN
    reference_k, per_k = STC_TEMPERATURE_C + ZERO_CELSIUS_K, cell.temperature_coefficient_per_k
    kelvin = air_k + np.zeros(np.shape(brought - electric))
    for _ in range(_ROUNDS):
        power = electric * (1.0 - per_k * (kelvin - reference_k))
        cubed = radiating * kelvin**3
        step = (brought - power - cubed * kelvin - convected * kelvin) / (
            4.0 * cubed + convected - electric * per_k
        )
        kelvin = kelvin + step
        if np.max(np.abs(step), initial=0.0) <= _TOLERANCE_K:
            break
    return np.asarray(kelvin - ZERO_CELSIUS_K)
