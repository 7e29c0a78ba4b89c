"""Keys of a rib wing, of its wires and of its web cores, with its parts and loads.

docs/structure.md names source or assumption key by key.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, pi, radians, sin, tan
from typing import Annotated, ClassVar, Literal, NamedTuple

from pydantic import Field, Strict, model_validator

from sizing.smooth import Value, smooth_maximum
from sizing.structures.build import BuiltStructure
from sizing.structures.torsion import WingTorsion
from solar.schema import (
    Flag,
    Fraction,
    NonNegativeReal,
    PositiveReal,
    Record,
    UnitInterval,
    wrong_value,
)


class StructureParts(NamedTuple):
    """Masses of the structure's parts, with calibration and build factor [kg]."""

    spar_caps: Value
    spar_web: Value
    covering: Value
    ribs: Value
    edges: Value
    tails: Value
    boom: Value
    pod: Value
    joints: Value

    @property
    def total_kg(self) -> Value:
        """Mass of the structure [kg]."""
        return sum(self[1:], self[0])


class LoadFactors(NamedTuple):
    """Limit load factors, both positive: pull-up or up-gust, push-over or down-gust [-]."""

    up: Value
    down: Value


class Wing(NamedTuple):
    """Geometry, masses and load factors of the wing, for the sizing of its parts.

    ``sheet_m`` is the minimum gauge; ``nose_sheet_m`` is equivalent in mass to the stiffened nose.
    """

    wingspan_m: Value
    chord_m: Value
    wing_area_m2: Value
    depth_m: Value
    equivalent_airspeed_m_per_s: Value
    total_mass_kg: Value
    relief_kg: Value
    pod_battery_kg: Value
    factors: LoadFactors
    sheet_m: Value
    nose_sheet_m: Value


class CapForces(NamedTuple):
    """Ultimate cap forces at a station [N], by load case.

    ``up`` and ``down`` bend the wing up and down at the limit load factors, ``landing`` bends it
    down; ``level`` is the force in level flight, without the safety factor.
    """

    up: Value
    down: Value
    landing: Value
    level: Value


# Buckling of a long plate in shear, simply supported (Timoshenko & Gere, section 9.7).
SHEAR_PLATE = 5.35


class WebCore(Record):
    """Foam between two facings, each with half of the web's laminate.

    The facings carry the shear, the core prevents their buckling. docs/structure.md names source or
    assumption key by key.
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
    docs/structure.md names source or assumption key by key.
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


# Load case of the limits of tip deflection and slope: 1 g, or limit load in flight.
DeflectionCase = Literal["level_flight", "limit_load"]


# Fits the structure of AtlantikSolar, 1.35 kg at 5.65 m.
RIB_WING_CALIBRATION = 1.188


class RibWingKeys(BuiltStructure):
    """Keys of a rib wing in an aircraft's file."""

    atlantiksolar_calibration: ClassVar[float | None] = RIB_WING_CALIBRATION
    _in_place_of: ClassVar[Mapping[str, str]] = {"boom_thickness_m": "boom_kg_per_m"}

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
    # Core of the webs against buckling, and wires to the wing, if any.
    web_core: WebCore | None = None
    bracing: Bracing | None = None
    # Limits of bending, if any.
    maximum_tip_deflection: Fraction | None = None
    maximum_tip_slope_deg: Annotated[float, Strict(), Field(gt=0.1, le=45.0)] | None = None
    deflection_load_case: DeflectionCase = "level_flight"
    maximum_landing_deflection: Fraction | None = None
    # Requirements on torsional stiffness, if any.
    torsion: WingTorsion | None = None
    # Battery mass per volume of the spar's box; None: any mass fits.
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
    # Solid foam core in place of ribs and trailing edge, if any; not multiplied by the mass factor.
    core_density_kg_per_m3: PositiveReal | None = None
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
    # Bought tubes, by one of these: not multiplied by the mass factor.
    boom_kg_per_m: PositiveReal | None = None
    boom_thickness_m: PositiveReal | None = None
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
