"""Keys of a rib wing; docs/structure.md names source or assumption key by key."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, Strict, model_validator

from sizing.structures.bracing import Bracing
from sizing.structures.torsion import WingTorsion
from sizing.structures.web_core import WebCore
from solar.schema import (
    Flag,
    Fraction,
    NonNegativeReal,
    PositiveReal,
    Record,
    UnitInterval,
    wrong_value,
)

# Where the limits of the tip's deflection and slope hold: at 1 g, or at the limit load in flight.
DeflectionCase = Literal["level_flight", "limit_load"]


class RibWingKeys(Record):
    """What a file says of a rib wing."""

    model: Literal["rib_wing"]
    calibration: PositiveReal = 1.0
    # Loads.
    safety_factor: PositiveReal = 1.5
    cruise_gust_m_per_s: NonNegativeReal = 15.25
    dive_gust_m_per_s: NonNegativeReal = 7.6
    gusts_fall_with_altitude: Flag = False
    dive_speed_ratio: Annotated[float, Strict(), Field(ge=1.0, le=10.0)] = 1.5
    manoeuvre_load_factor: Annotated[float, Strict(), Field(ge=1.0, le=10.0)] | None = None
    negative_load_ratio: UnitInterval = 0.4
    landing_load_factor: NonNegativeReal = 2.0
    landing_gear_span_fraction: Annotated[float, Strict(), Field(ge=0.0, le=0.95)] = 0.0
    # Spar.
    thickness_ratio: Annotated[float, Strict(), Field(gt=0.02, lt=0.3)] = 0.125
    spar_depth_fraction: Fraction = 0.9
    cap_width_fraction: Fraction = 0.06
    minimum_cap_thickness_m: PositiveReal = 0.25e-3
    minimum_web_thickness_m: PositiveReal = 0.2e-3
    # Caps no wider than buckling allows; otherwise as wide as the box.
    narrow_caps: Flag = False
    # Webs with a core against buckling, and wires that carry the wing; none: without.
    web_core: WebCore | None = None
    bracing: Bracing | None = None
    # Stiffness in bending; none: strength alone.
    maximum_tip_deflection: Fraction | None = None
    maximum_tip_slope_deg: Annotated[float, Strict(), Field(gt=0.1, le=45.0)] | None = None
    deflection_load_case: DeflectionCase = "level_flight"
    maximum_landing_deflection: Fraction | None = None
    # Torsion; none: the wing is not held against it.
    torsion: WingTorsion | None = None
    # Battery that the spar's box holds; none: any mass fits.
    spar_battery_density_kg_per_m3: PositiveReal | None = None
    # Unidirectional carbon fibre of the caps.
    tensile_strength_pa: PositiveReal = 914e6
    compressive_strength_pa: PositiveReal = 368e6
    modulus_pa: PositiveReal = 73e9
    transverse_modulus_pa: PositiveReal = 8e9
    shear_modulus_pa: PositiveReal = 4e9
    poisson_ratio: Annotated[float, Strict(), Field(ge=0.0, lt=0.5)] = 0.3
    cap_density_kg_per_m3: PositiveReal = 1600.0
    # Quasi-isotropic carbon laminate of webs and boom.
    laminate_modulus_pa: PositiveReal = 45e9
    laminate_strength_pa: PositiveReal = 300e6
    laminate_shear_strength_pa: PositiveReal = 150e6
    laminate_density_kg_per_m3: PositiveReal = 1550.0
    # Ribs, covering and edges.
    covering_kg_per_m2: NonNegativeReal = 0.05
    sheet_density_kg_per_m3: PositiveReal = 150.0
    sheet_thickness_ratio: PositiveReal = 0.0015
    minimum_sheet_thickness_m: PositiveReal = 1.5e-3
    rib_spacing_chords: PositiveReal = 0.2
    rib_solidity: Fraction = 0.6
    nose_chord_fraction: Fraction = 0.25
    trailing_edge_chord_fraction: Fraction = 0.05
    # Tails, boom, pod, joints.
    fuselage_chords: PositiveReal = 4.0
    horizontal_tail_ratio: PositiveReal = 0.35
    vertical_tail_ratio: PositiveReal = 0.045
    tail_kg_per_m2: NonNegativeReal = 0.35
    tail_lift_coefficient: PositiveReal = 1.0
    booms: Annotated[int, Strict(), Field(ge=0, le=2)] = 1
    boom_diameter_chords: PositiveReal = 0.1
    minimum_boom_thickness_m: PositiveReal = 0.5e-3
    pod_wetted_area_ratio: NonNegativeReal = 0.08
    pod_kg_per_m2: NonNegativeReal = 0.4
    pod_battery_mount_fraction: NonNegativeReal = 0.0
    joint_fraction: NonNegativeReal = 0.15

    @model_validator(mode="after")
    def _check_room(self) -> RibWingKeys:
        key = "spar_battery_density_kg_per_m3"
        if self.narrow_caps and getattr(self, key) is not None:
            raise wrong_value(key, "leave it out: a spar with narrow_caps has no room for cells")
        return self
