"""Structural mass of the airframe: wing, tails and fuselage without systems.

The formulas use arithmetic alone, for floats, arrays and symbolic expressions.
"""

from __future__ import annotations

from functools import cache
from typing import Annotated, ClassVar, Literal, TypeAlias

from pydantic import AfterValidator, Field

from sizing.smooth import Value
from sizing.structures.build import BuiltStructure
from sizing.structures.loads import StructureInputs, root_bending_moment_nm
from sizing.structures.rib_wing import RIB_WING_CALIBRATION, RibWingStructure
from sizing.structures.stiffening import WebCore, WingTorsion
from sizing.user_models import user_function
from solar.schema import Fraction, NonNegativeReal, PositiveReal, Real, Text

# Fitted to the structure of AtlantikSolar.
SPAR_CALIBRATION = 1.109


class SparStructure(BuiltStructure):
    """Spar caps sized by root bending, shell and tails by area; simpler than ``rib_wing``.

    * Limit load factor ``n = 2.1 + 10900/(m + 4536)`` (m in kg), the form of CS 23.337 in SI units.
    * Root bending moment from an elliptic lift distribution, relieved by the mass spread along the
      span (battery and modules): ``n g b (2 m / (3 pi) - m_span / 4) / 2``,
      never less than ``minimum_moment_fraction`` of the unrelieved one (handling and landing).
    * Spar caps at their allowable compression stress with a safety factor, a fraction of the
      section's depth apart; cap area falls from root to tip so that the caps weigh
      ``cap_volume_factor`` of two full-length root caps. Shear web, resin joints and minimum
      gauges are in the linear mass.
    * Shell (ribs, skins, edges) by wing area and tail area; tail areas follow from the volume
      ratios at a fuselage of ``fuselage_chords`` chords, the boom from its length.

    ``calibration`` multiplies the whole mass, and is fitted to AtlantikSolar. The
    areal and linear masses are assumptions for built-up wings of 3 to 8 m span, not measurements.
    Sources of the form and of the material data: CS-23; unidirectional carbon fibre, 368 MPa in
    compression; tail volume ratios of AtlantikSolar.
    """

    atlantiksolar_calibration: ClassVar[float | None] = SPAR_CALIBRATION

    model: Literal["spar"] = "spar"
    calibration: PositiveReal = 1.0
    shell_kg_per_m2: PositiveReal = 0.45
    tail_shell_kg_per_m2: PositiveReal = 0.35
    boom_kg_per_m: PositiveReal = 0.12
    spar_web_kg_per_m: NonNegativeReal = 0.03
    thickness_ratio: Annotated[float, Field(gt=0.02, lt=0.3)] = 0.125
    spar_depth_fraction: Fraction = 0.9
    cap_volume_factor: Fraction = 0.45
    allowable_stress_pa: PositiveReal = 368e6
    spar_density_kg_per_m3: PositiveReal = 1600.0
    safety_factor: PositiveReal = 1.5
    minimum_moment_fraction: Fraction = 0.25
    fuselage_chords: PositiveReal = 4.0
    horizontal_tail_ratio: PositiveReal = 0.35
    vertical_tail_ratio: PositiveReal = 0.045

    def mass_kg(self, inputs: StructureInputs) -> Value:
        """Return the structural mass [kg]; airspeed and air are not used."""
        chord_m, area_m2 = inputs.chord_m, inputs.wing_area_m2
        tail_ratio = (self.horizontal_tail_ratio + self.vertical_tail_ratio) / self.fuselage_chords
        shell_kg = area_m2 * (self.shell_kg_per_m2 + tail_ratio * self.tail_shell_kg_per_m2)
        boom_kg = self.boom_kg_per_m * self.fuselage_chords * chord_m
        web_kg = self.spar_web_kg_per_m * inputs.wingspan_m
        moment = root_bending_moment_nm(
            inputs.wingspan_m,
            inputs.total_mass_kg,
            inputs.span_load_kg,
            self.minimum_moment_fraction,
        )
        depth_m = self.spar_depth_fraction * self.thickness_ratio * chord_m
        cap_area_m2 = self.safety_factor * moment / (depth_m * self.allowable_stress_pa)
        volume_m3 = 2.0 * cap_area_m2 * inputs.wingspan_m * self.cap_volume_factor
        caps_kg = self.spar_density_kg_per_m3 * volume_m3
        return self.mass_factor * (shell_kg + boom_kg + web_kg + caps_kg)


class _PowerLaw(BuiltStructure):
    """Airframe mass as a power law, ``m = k b^x AR^y``."""

    coefficient_kg: PositiveReal
    span_exponent: Real
    aspect_ratio_exponent: Real

    def mass_kg(self, inputs: StructureInputs) -> Value:
        """Return the structural mass [kg]; masses and flight are not used."""
        return (
            self.mass_factor
            * self.coefficient_kg
            * inputs.wingspan_m**self.span_exponent
            * inputs.aspect_ratio**self.aspect_ratio_exponent
        )


class PowerLawStructure(_PowerLaw):
    """Airframe mass as a power law of wingspan and aspect ratio.

    ``m = coefficient_kg b^span_exponent AR^aspect_ratio_exponent``. The defaults are the airframe
    law of Sky-Sailor, fitted to the best 5 % of sailplanes in a statistic: Noth, A. (2008), Design
    of Solar Powered Airplanes for Continuous Flight, ETH Zurich: weight 0.44 S^1.55 AR^1.30 =
    0.44 b^3.1 AR^-0.25 in newton. Masses are far too high above 4 m of span.
    """

    model: Literal["power_law"] = "power_law"
    coefficient_kg: PositiveReal = 0.44 / 9.81
    span_exponent: Real = 3.1
    aspect_ratio_exponent: Real = -0.25


class AllPowerLawStructure(_PowerLaw):
    """Power law of all 415 sailplanes of the same statistic.

    Noth (2008): weight 5.58 S^1.59 AR^0.71 = 5.58 b^3.18 AR^-0.88 in newton. Far too heavy for
    solar aircraft; for comparison.
    """

    model: Literal["power_law_all"]
    coefficient_kg: PositiveReal = 5.58 / 9.81
    span_exponent: Real = 3.18
    aspect_ratio_exponent: Real = -0.88


class UserStructure(BuiltStructure):
    """User-defined model, by its name: see :func:`sizing.register_structure`.

    ``build`` multiplies its mass, where the file has it.
    """

    model: Literal["own"]
    name: Annotated[Text, AfterValidator(lambda name: user_function("structure", name) and name)]

    def mass_kg(self, inputs: StructureInputs) -> Value:
        """Return the structural mass [kg]."""
        return self.mass_factor * user_function("structure", self.name)(inputs)


StructureModel: TypeAlias = (
    PowerLawStructure | AllPowerLawStructure | SparStructure | RibWingStructure | UserStructure
)
Structure = Annotated[StructureModel, Field(discriminator="model")]


@cache
def reference_rib_wing() -> RibWingStructure:
    """Return the rib wing with the keys checked from 3 to 75 m, see docs/structure.md."""
    return RibWingStructure(
        model="rib_wing",
        calibration=RIB_WING_CALIBRATION,
        gusts_fall_with_altitude=True,
        narrow_caps=True,
        web_core=WebCore(),
        torsion=WingTorsion(cloth_shear_modulus_pa=33e9, cloth_density_kg_per_m3=1600.0),
    )


def other_model(structure: object) -> RibWingStructure | SparStructure | None:
    """Return another model for a second opinion on a structure's mass; None for other kinds."""
    if isinstance(structure, RibWingStructure):
        return SparStructure(calibration=SPAR_CALIBRATION)
    return reference_rib_wing() if isinstance(structure, SparStructure) else None
