"""Structure that a spar dominates: its mass follows the bending moment at the root."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from sizing.smooth import Value
from sizing.structures.loads import StructureInputs, root_bending_moment_nm
from solar.schema import Fraction, NonNegativeReal, PositiveReal, Record


class SparStructure(Record):
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

    ``calibration`` multiplies everything: it is the one factor that fits the built aircraft. The
    areal and linear masses are assumptions for built-up wings of 3 to 8 m span, not measurements.
    Sources of the form and of the material data: CS-23; unidirectional carbon fibre, 368 MPa in
    compression; tail volume ratios of AtlantikSolar.
    """

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
        """Structural mass [kg]; airspeed and air play no part."""
        chord_m = inputs.wingspan_m / inputs.aspect_ratio
        area_m2 = inputs.wingspan_m * chord_m
        tail_ratio = (self.horizontal_tail_ratio + self.vertical_tail_ratio) / self.fuselage_chords
        shell_kg = area_m2 * (self.shell_kg_per_m2 + tail_ratio * self.tail_shell_kg_per_m2)
        boom_kg = self.boom_kg_per_m * self.fuselage_chords * chord_m
        web_kg = self.spar_web_kg_per_m * inputs.wingspan_m
        caps_kg = self._spar_caps_kg(inputs, chord_m)
        return self.calibration * (shell_kg + boom_kg + web_kg + caps_kg)

    def _spar_caps_kg(self, inputs: StructureInputs, chord_m: Value) -> Value:
        moment = root_bending_moment_nm(
            inputs.wingspan_m,
            inputs.total_mass_kg,
            inputs.span_load_kg,
            self.minimum_moment_fraction,
        )
        depth_m = self.spar_depth_fraction * self.thickness_ratio * chord_m
        cap_area_m2 = self.safety_factor * moment / (depth_m * self.allowable_stress_pa)
        volume_m3 = 2.0 * cap_area_m2 * inputs.wingspan_m * self.cap_volume_factor
        return self.spar_density_kg_per_m3 * volume_m3
