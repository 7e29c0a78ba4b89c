"""Stiffening of a rib wing: torsion of its cells, cores of its webs, wires to it.

docs/structure.md names source or assumption of their keys, key by key. Arithmetic alone, for
floats, arrays and symbols.
"""

from __future__ import annotations

from math import cos, pi, radians, sin, tan
from typing import Annotated, NamedTuple

from pydantic import Field, Strict

from sizing.smooth import Value, smooth_maximum
from solar.schema import Flag, NonNegativeReal, PositiveReal, Record

# Largest torsional flexibility F of a wing: F V_D^2 = 200 with V_D in mph and F, the integral of
# twist per torque times chord squared along the aileron, in ft2/lbf (Rosenbaum & Vollmecke,
# Simplified Flutter Prevention Criteria for Personal Type Aircraft, CAA Airframe and Equipment
# Engineering Report 45, 1955; FAR 23.629 (d) accepts it). Here F times dynamic pressure, SI.
FLUTTER_LIMIT = 0.5 * 1.225 * 200.0 * (0.3048**2 / 4.4482216) * 0.44704**2


class WingTorsion(Record):
    """Requirements on torsional stiffness for flutter, divergence and twist, and materials.

    The nose's cell, closed by the spar, and the spar's box carry the torsion. The wing is uniform,
    of constant chord, and clamped at the root, at the dynamic pressure of dive speed or at the
    limit load.
    """

    aileron_start_fraction: Annotated[float, Strict(), Field(ge=0.0, le=0.95)] = 0.5
    speed_margin: Annotated[float, Strict(), Field(ge=1.0, le=5.0)] = 1.2
    elastic_axis_offset_chords: NonNegativeReal = 0.1
    pitching_moment_coefficient: NonNegativeReal = 0.1
    maximum_twist_deg: Annotated[float, Strict(), Field(gt=0.1, le=45.0)] = 15.0
    sheet_shear_modulus_pa: PositiveReal = 0.17e9
    cloth_shear_modulus_pa: PositiveReal = 10.4e9
    cloth_density_kg_per_m3: PositiveReal = 1900.0

    def needed_nm2(
        self,
        *,
        chord_m: Value,
        half_span_m: Value,
        lift_slope: Value,
        dive_pressure_pa: Value,
        limit_loading_pa: Value,
    ) -> dict[str, Value]:
        """Return the torsional stiffness GJ that each criterion requires [N m2].

        ``lift_slope`` of the wing [1/rad]; dynamic pressure at dive speed, and lift over wing area
        at the limit load [Pa].

        ``flutter``: the flexibility of Report 45, with twist ``s/GJ`` at s from the root for a unit
        torque outboard of it, is ``c^2 l^2 (1 - x^2)/(2 GJ)`` over ailerons from the fraction x of
        the half-span l to the tip.

        ``divergence``: a uniform wing diverges at the dynamic pressure ``pi^2 GJ/(4 l^2 c e a)``
        (Bisplinghoff, Ashley & Halfman, Aeroelasticity, section 8-3; Megson, Aircraft Structures,
        equation 29.11), at ``speed_margin`` times dive speed (FAR 23.629 (c): 1.2).

        ``twist_in_dive`` and ``twist_at_limit_load``: an even torque per length m twists the tip by
        ``m l^2/(2 GJ)``; m is ``C_m q c^2``, or the lift times its distance from the elastic axis.
        """
        square = (chord_m * half_span_m) ** 2
        offset = self.elastic_axis_offset_chords
        twist = 2.0 * radians(1.0) * self.maximum_twist_deg
        aileron = (1.0 - self.aileron_start_fraction**2) / 2.0
        diverging = 4.0 / pi**2 * self.speed_margin**2 * offset
        return {
            "flutter": aileron / FLUTTER_LIMIT * dive_pressure_pa * square,
            "divergence": diverging * lift_slope * dive_pressure_pa * square,
            "twist_in_dive": self.pitching_moment_coefficient / twist * dive_pressure_pa * square,
            "twist_at_limit_load": offset / twist * limit_loading_pa * square,
        }


def closed_cell_nm2(area_m2: Value, flexibility: Value) -> Value:
    """Return Bredt's torsional stiffness GJ of a thin-walled cell, ``4 A^2/sum(s/(G t))`` [N m2].

    ``flexibility`` is the sum over the walls, ``s/(G t)`` [m/N].
    """
    return 4.0 * area_m2 * area_m2 / flexibility


# Buckling of a long plate in shear, simply supported (Timoshenko & Gere, section 9.7).
SHEAR_PLATE = 5.35


class WebCore(Record):
    """Foam between two facings, each with half of the web's laminate.

    The facings carry the shear, the core prevents their buckling.
    """

    density_kg_per_m3: PositiveReal = 52.0
    shear_modulus_pa: PositiveReal = 19e6
    minimum_thickness_m: PositiveReal = 2e-3
    bond_kg_per_m2: NonNegativeReal = 0.1

    def kg_per_m2(
        self, shear_n_per_m: Value, facings_m: Value, depth_m: Value, modulus_pa: Value
    ) -> Value:
        """Return the mass of core and both bonds over the web's area [kg/m2].

        The plate's bending stiffness is that of its facings, ``D = E t d^2/(4 (1 - nu^2))`` with
        both of them t and the core d thick. With the shear of the core the plate buckles at
        ``1/(1/N_b + 1/(G d))``, ``N_b = 5.35 pi^2 D/h^2`` (Allen, Analysis and Design of Structural
        Sandwich Panels, chapters 2 and 5: the two stiffnesses in series); solved for d, at the
        ultimate shear flow of one web [N/m].
        """
        per_thickness = SHEAR_PLATE * pi**2 * modulus_pa * facings_m / (4.0 * (1.0 - 0.3**2))
        bending_m2 = shear_n_per_m * depth_m * depth_m / per_thickness
        shear_m = shear_n_per_m / self.shear_modulus_pa
        needed_m = (shear_m + (shear_m * shear_m + 4.0 * bending_m2) ** 0.5) / 2.0
        thickness_m = smooth_maximum(needed_m, self.minimum_thickness_m)
        return self.density_kg_per_m3 * thickness_m + 2.0 * self.bond_kg_per_m2


class Wires(NamedTuple):
    """Wires of both wings: mass [kg] and drag area [m2]."""

    mass_kg: Value
    drag_area_m2: Value


class Bracing(Record):
    """Bracing by a wire to each wing from below, and on request from above.

    The wire carries the whole bending moment at the root, and compresses the spar inboard.
    """

    attachment_span_fraction: Annotated[float, Strict(), Field(ge=0.1, le=0.9)]
    angle_deg: Annotated[float, Strict(), Field(ge=5.0, le=60.0)]
    landing_wires: Flag = False
    strength_pa: PositiveReal = 2.0e9
    density_kg_per_m3: PositiveReal = 7850.0
    drag_coefficient: NonNegativeReal = 1.1

    def compression_n(self, root_moment_nm: Value, half_span_m: Value) -> Value:
        """Return the compression of the spar inboard of the wire [N] for its moment at the root."""
        lift_n = root_moment_nm / (self.attachment_span_fraction * half_span_m)
        return lift_n / tan(radians(self.angle_deg))

    def wires(self, up_nm: Value, down_nm: Value, half_span_m: Value) -> Wires:
        """Return the wires for ultimate root moments upwards and downwards [N m].

        ``T = M/(y sin(angle))`` with the distance y of the attachment; wires are ``y/cos(angle)``
        long, and have drag over their whole length.
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
