"""Masses of parts that no file gives: regressions over the catalogue, gears by their torque."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from math import exp, pi, sqrt
from typing import NamedTuple

import numpy as np

from sizing.catalogues.choice import entries
from sizing.catalogues.entries import MotorEntry, PropellerEntry
from sizing.propulsion.electric import Motor
from sizing.smooth import Value

# NASA/TM-2009-215680: masses of gearboxes of more than fifty rotorcraft, tiltrotors and turboprops
# over beta = (hp / rpm_out)^0.75 ratio^0.15. Fit of AeroSandbox (MIT licence), made to extrapolate:
# 10^2.00836 lb beta^1.04452. Those gearboxes have beta above 1, model gearboxes about 0.001.
_LB_KG, _HP_W, _RPM = 0.45359237, 745.7, 30.0 / pi
_SLOPE, _INTERCEPT = 1.0445171124733774, 2.0083615496306910
GEAR_EXPONENT = 0.75 * _SLOPE  # of the torque
_GEAR_KG = _LB_KG * 10.0**_INTERCEPT * (1.0 / (_RPM * _HP_W)) ** GEAR_EXPONENT


class MassFit(NamedTuple):
    """Mass of parts over their size, ``coefficient_kg size^exponent``.

    ``scatter`` is the standard deviation of the catalogue's masses about the fit, as a factor;
    ``number`` the number of parts.
    """

    coefficient_kg: float
    exponent: float
    scatter: float
    number: int

    @classmethod
    def of(cls, sizes_and_masses: Iterable[tuple[float, float]]) -> MassFit:
        """Fit sizes and masses by least squares of their logarithms."""
        x, y = np.log(np.array(list(sizes_and_masses))).T
        exponent, intercept = np.polyfit(x, y, 1)
        rest = y - intercept - exponent * x
        scatter = sqrt(float(rest @ rest) / (len(x) - 2))
        return cls(exp(intercept), float(exponent), exp(scatter), len(x))

    def mass_kg(self, size: Value) -> Value:
        """Return the mass of a part of a size [kg]."""
        return self.coefficient_kg * size**self.exponent


def continuous_torque_nm(motor: Motor | MotorEntry) -> float | None:
    """Return the torque at the largest continuous current [N m]; None without that current."""
    if motor.maximum_current_a is None:
        return None
    useful_a = motor.maximum_current_a - motor.no_load_current_a
    return max(useful_a, 0.0) * _RPM / motor.speed_constant_rpm_per_v


@cache
def motor_mass_fit() -> MassFit:
    """Return the fit of the catalogue's motor masses over continuous torque [N m].

    The masses scatter less about this fit than about one over ``K_t / sqrt(R)``.
    """
    known = [
        (continuous_torque_nm(motor), motor.mass_kg)
        for motor in entries("motors").values()
        if isinstance(motor, MotorEntry) and motor.mass_kg is not None
    ]
    return MassFit.of((torque, mass_kg) for torque, mass_kg in known if torque)


@cache
def propeller_mass_fit() -> MassFit:
    """Return the fit of the catalogue's propeller masses over their diameter [m]."""
    return MassFit.of(
        (propeller.diameter_m, propeller.mass_kg)
        for propeller in entries("propellers").values()
        if isinstance(propeller, PropellerEntry) and propeller.mass_kg is not None
    )


def gear_mass_kg(torque_nm: Value, ratio: Value) -> Value:
    """Return the mass of a gearbox [kg] by torque at its slow shaft [N m] and ratio; 0 without."""
    if isinstance(ratio, float | int) and ratio == 1.0:
        return 0.0
    return _GEAR_KG * torque_nm**GEAR_EXPONENT * ratio ** (0.15 * _SLOPE)
