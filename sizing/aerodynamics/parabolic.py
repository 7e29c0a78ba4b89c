"""Lift and drag of level flight.

The formulas use arithmetic alone, for floats, arrays and symbolic expressions.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator

from missions.air import GRAVITY_M_PER_S2
from sizing.smooth import Value
from sizing.user_models import user_function
from solar.schema import Fraction, LiftCoefficient, NonNegativeReal, PositiveReal, Record, Text


class AtLiftCoefficient(Record):
    """Polar of an aircraft with a constant lift coefficient in level flight."""

    _above: ClassVar[Mapping[str, str]] = {"maximum_lift_coefficient": "lift_coefficient"}

    model: str
    lift_coefficient: LiftCoefficient
    maximum_lift_coefficient: LiftCoefficient

    @property
    def flight_lift_coefficient(self) -> Value:
        """Lift coefficient of level flight [-]."""
        return self.lift_coefficient


class DragPolar(AtLiftCoefficient):
    """Parabolic polar with a profile drag that depends on the Reynolds number of the wing.

    ``C_D = C_Dp (Re / Re_ref)^-n + C_Dpar + C_L^2 / (pi e AR)`` at the lift coefficient of level
    flight. A solar aircraft flies near its least power; for high aspect ratios that optimum lies
    beyond the stall margin, so that the margin sets the lift coefficient.
    """

    model: Literal["parabolic"] = "parabolic"
    profile_drag_coefficient: PositiveReal
    reference_reynolds: PositiveReal
    reynolds_exponent: NonNegativeReal = 0.35
    parasitic_drag_coefficient: NonNegativeReal = 0.006
    span_efficiency: Fraction = 0.9

    def drag_coefficient(self, aspect_ratio: Value, reynolds: Value) -> Value:
        """Return the drag coefficient of the aircraft, by the formula of the class [-]."""
        profile, induced, parasitic = self.parts(aspect_ratio, reynolds)
        return profile + parasitic + induced

    def parts(self, aspect_ratio: Value, reynolds: Value) -> tuple[Value, Value, Value]:
        """Return the coefficients of profile, induced and all other drag [-]."""
        profile = (
            self.profile_drag_coefficient
            * (reynolds / self.reference_reynolds) ** -self.reynolds_exponent
        )
        induced = self.lift_coefficient**2 / (pi * self.span_efficiency * aspect_ratio)
        return profile, induced, self.parasitic_drag_coefficient


class UserDragPolar(AtLiftCoefficient):
    """User-defined drag model, by its name: see :func:`sizing.register_drag`."""

    model: Literal["own"]
    name: Annotated[Text, AfterValidator(lambda name: user_function("drag", name) and name)]

    def drag_coefficient(self, aspect_ratio: Value, reynolds: Value) -> Value:
        """Return the drag coefficient of the aircraft in level flight [-]."""
        return user_function("drag", self.name)(self.lift_coefficient, aspect_ratio, reynolds)


def level_airspeed_m_per_s(
    lift_coefficient: Value, wing_loading_kg_per_m2: Value, density_kg_per_m3: Value
) -> Value:
    """Return the airspeed of level flight [m/s], ``(2 m g / (rho S C_L))^0.5``."""
    weight = 2.0 * GRAVITY_M_PER_S2 * wing_loading_kg_per_m2
    return (weight / (density_kg_per_m3 * lift_coefficient)) ** 0.5
