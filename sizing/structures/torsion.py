"""Torsional stiffness for flutter, divergence and twist of a wing of constant chord.

The wing is uniform and clamped at the root, at the dynamic pressure of dive speed or at the limit
load. Arithmetic alone, for floats, arrays and symbols.
"""

from __future__ import annotations

from math import pi, radians
from typing import Annotated, NamedTuple

from pydantic import Field, Strict

from sizing.smooth import Value
from solar.schema import NonNegativeReal, PositiveReal, Record

# Largest torsional flexibility F of a wing: F V_D^2 = 200 with V_D in mph and F, the integral of
# twist per torque times chord squared along the aileron, in ft2/lbf (Rosenbaum & Vollmecke,
# Simplified Flutter Prevention Criteria for Personal Type Aircraft, CAA Airframe and Equipment
# Engineering Report 45, 1955; FAR 23.629 (d) accepts it). Here F times dynamic pressure, SI.
FLUTTER_LIMIT = 0.5 * 1.225 * 200.0 * (0.3048**2 / 4.4482216) * 0.44704**2


class Twisting(NamedTuple):
    """Geometry and loads that twist a wing.

    ``lift_slope`` of the wing [1/rad]; dynamic pressure at dive speed, and lift over wing area at
    the limit load [Pa].
    """

    chord_m: Value
    half_span_m: Value
    lift_slope: Value
    dive_pressure_pa: Value
    limit_loading_pa: Value


class WingTorsion(Record):
    """Requirements on the torsional stiffness of a wing, and materials of its cells.

    The nose's cell, closed by the spar, and the spar's box carry the torsion. docs/structure.md
    names source or assumption key by key.
    """

    aileron_start_fraction: Annotated[float, Strict(), Field(ge=0.0, le=0.95)] = 0.5
    speed_margin: Annotated[float, Strict(), Field(ge=1.0, le=5.0)] = 1.2
    elastic_axis_offset_chords: NonNegativeReal = 0.1
    pitching_moment_coefficient: NonNegativeReal = 0.1
    maximum_twist_deg: Annotated[float, Strict(), Field(gt=0.1, le=45.0)] = 15.0
    sheet_shear_modulus_pa: PositiveReal = 0.17e9
    cloth_shear_modulus_pa: PositiveReal = 10.4e9
    cloth_density_kg_per_m3: PositiveReal = 1900.0

    def needed_nm2(self, wing: Twisting) -> dict[str, Value]:
        """Return the torsional stiffness GJ that each criterion requires [N m2].

        ``flutter``: the flexibility of Report 45, with twist ``s/GJ`` at s from the root for a unit
        torque outboard of it, is ``c^2 l^2 (1 - x^2)/(2 GJ)`` over ailerons from the fraction x of
        the half-span l to the tip.

        ``divergence``: a uniform wing diverges at the dynamic pressure ``pi^2 GJ/(4 l^2 c e a)``
        (Bisplinghoff, Ashley & Halfman, Aeroelasticity, section 8-3; Megson, Aircraft Structures,
        equation 29.11), at ``speed_margin`` times dive speed (FAR 23.629 (c): 1.2).

        ``twist_in_dive`` and ``twist_at_limit_load``: an even torque per length m twists the tip by
        ``m l^2/(2 GJ)``; m is ``C_m q c^2``, or the lift times its distance from the elastic axis.
        """
        square = (wing.chord_m * wing.half_span_m) ** 2
        pressure = wing.dive_pressure_pa
        offset = self.elastic_axis_offset_chords
        twist = 2.0 * radians(1.0) * self.maximum_twist_deg
        aileron = (1.0 - self.aileron_start_fraction**2) / 2.0
        diverging = 4.0 / pi**2 * self.speed_margin**2 * offset
        return {
            "flutter": aileron / FLUTTER_LIMIT * pressure * square,
            "divergence": diverging * wing.lift_slope * pressure * square,
            "twist_in_dive": self.pitching_moment_coefficient / twist * pressure * square,
            "twist_at_limit_load": offset / twist * wing.limit_loading_pa * square,
        }


def closed_cell_nm2(area_m2: Value, flexibility: Value) -> Value:
    """Return Bredt's torsional stiffness GJ of a thin-walled cell, ``4 A^2/sum(s/(G t))`` [N m2].

    ``flexibility`` is the sum over the walls, ``s/(G t)`` [m/N].
    """
    return 4.0 * area_m2 * area_m2 / flexibility


class NoseCell(NamedTuple):
    """Cell of the sheeted nose, closed by the spar: enclosed area [m2] and its perimeter [m]."""

    area_m2: Value
    perimeter_m: Value

    def stiffness_nm2(self, wall_n_per_m: Value) -> Value:
        """Return the torsional stiffness [N m2] of walls of equal shear stiffness G t [N/m]."""
        return closed_cell_nm2(self.area_m2, self.perimeter_m / wall_n_per_m)

    def wall_n_per_m(self, stiffness_nm2: Value) -> Value:
        """Return the shear stiffness G t of equal walls [N/m] for a torsional stiffness [N m2]."""
        return stiffness_nm2 * self.perimeter_m / (4.0 * self.area_m2 * self.area_m2)
