"""Wires from the fuselage to the wing: what they carry, weigh and drag."""

from __future__ import annotations

from math import cos, pi, radians, sin, tan
from typing import Annotated, NamedTuple

from pydantic import Field, Strict

from sizing.smooth import Value
from solar.schema import Flag, NonNegativeReal, PositiveReal, Record


class Wires(NamedTuple):
    """Wires of both wings: mass [kg] and drag area [m2]."""

    mass_kg: Value
    drag_area_m2: Value


class Bracing(Record):
    """A wire to each wing, or one from below and one from above.

    The wire's force leaves the wing no moment at its root, as of a wing hinged there. It presses
    the spar inboard together. docs/structure.md names source or assumption key by key.
    """

    attachment_span_fraction: Annotated[float, Strict(), Field(ge=0.1, le=0.9)]
    angle_deg: Annotated[float, Strict(), Field(ge=5.0, le=60.0)]
    landing_wires: Flag = False
    strength_pa: PositiveReal = 2.0e9
    density_kg_per_m3: PositiveReal = 7850.0
    drag_coefficient: NonNegativeReal = 1.1

    def compression_n(self, root_moment_nm: Value, half_span_m: Value) -> Value:
        """Force along the spar inboard of the wire [N], for a moment that it takes at the root."""
        lift_n = root_moment_nm / (self.attachment_span_fraction * half_span_m)
        return lift_n / tan(radians(self.angle_deg))

    def wires(self, up_nm: Value, down_nm: Value, half_span_m: Value) -> Wires:
        """Wires for the ultimate moments that they take at the root, upwards and downwards.

        ``T = M/(y sin(angle))`` at the distance y of the attachment, of wires ``y/cos(angle)`` long
        whose diameter faces the air over all of their length.
        """
        distance_m = self.attachment_span_fraction * half_span_m
        angle = radians(self.angle_deg)
        length_m = distance_m / cos(angle)
        mass_kg: Value = 0.0
        drag_m2: Value = 0.0
        for moment in (up_nm, down_nm) if self.landing_wires else (up_nm,):
            section_m2 = moment / (distance_m * sin(angle)) / self.strength_pa
            mass_kg = mass_kg + 2.0 * self.density_kg_per_m3 * section_m2 * length_m
            diameter_m = (4.0 / pi * section_m2) ** 0.5
            drag_m2 = drag_m2 + 2.0 * self.drag_coefficient * diameter_m * length_m
        return Wires(mass_kg, drag_m2)
