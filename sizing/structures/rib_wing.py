"""Structural mass of a rib wing with a box spar of carbon fibre, part by part.

The spar is sized station by station along the span for the larger of manoeuvre and gust, upwards
and downwards, and for landing; every wall has a minimum gauge. All formulas are arithmetic with
smooth maxima (:mod:`sizing.smooth`), for floats, arrays, symbols and optimisers. Equations and
sources: docs/structure.md.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import pi, radians
from typing import Annotated, ClassVar, Literal, NamedTuple

from pydantic import Field, Strict, model_validator

from missions.air import GRAVITY_M_PER_S2
from sizing.smooth import Value, largest, smooth_absolute, smooth_maximum, smooth_minimum
from sizing.structures.build import BuiltStructure
from sizing.structures.loads import (
    LIFT_AT_ROOT,
    MASS_AT_ROOT,
    SEA_LEVEL_DENSITY_KG_PER_M3,
    Station,
    StructureInputs,
    along_the_span,
    gust_load_increment,
    lift_curve_slope,
    limit_load_factor,
    stations,
)
from sizing.structures.stiffening import (
    SHEAR_PLATE,
    Bracing,
    WebCore,
    WingTorsion,
    Wires,
    closed_cell_nm2,
)
from solar.schema import Flag, Fraction, NonNegativeReal, PositiveReal, UnitInterval, wrong_value

# Perimeter over chord of a cambered section, both sides, and area over thickness times chord.
_PERIMETER = 2.04
_SECTION_AREA = 0.68
# Area ahead of a quarter of the chord over thickness ratio and chord squared, of the thickness
# distribution of the NACA four-digit sections (Abbott & von Doenhoff, section 6.4), per fraction of
# the chord. It holds near a quarter.
_NOSE_AREA = 0.77
# The section tapers to the trailing edge from its thickest place at 30 % of the chord.
_TAPER_LENGTH = 0.7
# Half of the theoretical buckling stress 0.6 E t/R of a thin tube in bending: imperfections leave
# 0.79 to 0.66 of it for radii of 30 to 100 wall thicknesses (NASA SP-8007).
_TUBE_KNOCKDOWN = 0.3


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


class Wing(NamedTuple):
    """Geometry, masses and load factors of the wing, for the sizing of its parts.

    ``factor_up``, ``factor_down``: limit load factors of pull-up or up-gust, and of push-over or
    down-gust, both positive [-]. ``sheet_m`` is the minimum gauge. Covering, ribs (or core) and
    edges are the shell.
    """

    wingspan_m: Value
    chord_m: Value
    wing_area_m2: Value
    depth_m: Value
    equivalent_airspeed_m_per_s: Value
    total_mass_kg: Value
    relief_kg: Value
    pod_battery_kg: Value
    factor_up: Value
    factor_down: Value
    sheet_m: Value
    covering_kg: Value = 0.0
    ribs_kg: Value = 0.0
    edges_kg: Value = 0.0


class CapForces(NamedTuple):
    """Ultimate cap forces at a station [N], by load case.

    ``up`` and ``down`` bend the wing up and down at the limit load factors, ``landing`` bends it
    down; ``level`` is the force in level flight, without the safety factor.
    """

    up: Value
    down: Value
    landing: Value
    level: Value


# Load case of the limits of tip deflection and slope: 1 g, or limit load in flight.
DeflectionCase = Literal["level_flight", "limit_load"]


# Fits the structure of AtlantikSolar, 1.35 kg at 5.65 m.
RIB_WING_CALIBRATION = 1.188


class RibWingStructure(BuiltStructure):
    """Rib wing with a carbon-fibre box spar, tails on a tube, a pod.

    ``calibration`` multiplies the whole mass, and is fitted to a built aircraft. Strength and
    moduli are published material data; areal masses, gauges and proportions are assumptions for
    light built-up wings: docs/structure.md names source or assumption key by key.
    """

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
    def _check_room(self) -> RibWingStructure:
        key = "spar_battery_density_kg_per_m3"
        if self.narrow_caps and getattr(self, key) is not None:
            raise wrong_value(key, "leave it out: a spar with narrow_caps has no room for cells")
        return self

    @property
    def is_for_large_wings(self) -> bool:
        """True if neither caps nor webs are sized by buckling, as in wings above 8 m."""
        return self.narrow_caps and self.web_core is not None

    def mass_kg(self, inputs: StructureInputs) -> Value:
        """Return the structural mass [kg]."""
        return self.breakdown(inputs).total_kg

    def breakdown(self, inputs: StructureInputs) -> StructureParts:
        """Return the masses of the parts."""
        wing = self.wing(inputs)
        area_m2, chord_m = wing.wing_area_m2, wing.chord_m
        # Caps and webs, integrated over both half-spans.
        station, integral = self.along_the_span(*wing)
        forces, shear_n = self.cap_forces(wing, station), self.shear_n(wing, station)
        upper_m2, lower_m2 = (largest(needs) for needs in self.cap_needs_m2(wing, forces))
        caps = self.cap_density_kg_per_m3 * wing.wingspan_m * integral(upper_m2 + lower_m2)
        web_m = largest(self.web_needs_m(wing, shear_n))
        web_kg_per_m2 = self.laminate_density_kg_per_m3 * web_m
        if self.web_core is not None:
            flow = shear_n / (2.0 * wing.depth_m)
            web_kg_per_m2 = web_kg_per_m2 + self.web_core.kg_per_m2(
                flow, web_m, wing.depth_m, self.laminate_modulus_pa
            )
        web = wing.wingspan_m * 2.0 * wing.depth_m * integral(web_kg_per_m2)
        tail_ratio = (self.horizontal_tail_ratio + self.vertical_tail_ratio) / self.fuselage_chords
        is_core = self.core_density_kg_per_m3 is not None
        parts = (
            caps,
            web,
            wing.covering_kg,
            wing.ribs_kg / self.mass_factor if is_core else wing.ribs_kg,
            wing.edges_kg,
            (tail_ratio if self.booms else 0.0) * area_m2 * self.tail_kg_per_m2,
            self._boom_kg(area_m2, chord_m, wing.equivalent_airspeed_m_per_s),
            self.pod_wetted_area_ratio * area_m2 * self.pod_kg_per_m2
            + self.pod_battery_mount_fraction * wing.pod_battery_kg,
        )
        joints = self.joint_fraction * sum(parts[1:], parts[0]) + self.wires(wing).mass_kg
        return StructureParts(*(self.mass_factor * part for part in (*parts, joints)))

    def wing(self, inputs: StructureInputs) -> Wing:
        """Return geometry, load factors, shell, and the mass that relieves the spar."""
        chord_m, area_m2 = inputs.chord_m, inputs.wing_area_m2
        relative_density = inputs.density_kg_per_m3 / SEA_LEVEL_DENSITY_KG_PER_M3
        equivalent_airspeed = inputs.airspeed_m_per_s * relative_density**0.5
        sheet_m = smooth_maximum(
            self.minimum_sheet_thickness_m, self.sheet_thickness_ratio * chord_m
        )
        factor_up, factor_down = self.load_factors(inputs, equivalent_airspeed)
        outside_kg: Value = 0.0
        if self.spar_battery_density_kg_per_m3 is not None:
            section = self.cap_width_fraction * self.spar_depth_fraction * self.thickness_ratio
            volume_m3 = section * chord_m * chord_m * inputs.wingspan_m
            room_kg = self.spar_battery_density_kg_per_m3 * volume_m3
            outside_kg = inputs.wing_battery_kg - smooth_minimum(inputs.wing_battery_kg, room_kg)
        wing = Wing(
            wingspan_m=inputs.wingspan_m,
            chord_m=chord_m,
            wing_area_m2=area_m2,
            depth_m=self.spar_depth_fraction * self.thickness_ratio * chord_m,
            equivalent_airspeed_m_per_s=equivalent_airspeed,
            total_mass_kg=inputs.total_mass_kg,
            relief_kg=inputs.span_load_kg - outside_kg,
            pod_battery_kg=inputs.pod_battery_kg + outside_kg,
            factor_up=factor_up,
            factor_down=factor_down,
            sheet_m=sheet_m,
        )
        nose_m = sheet_m
        if self.torsion is not None:
            # Sheet equivalent in mass to a stiff nose of sheet and cloth.
            stiffness = self.torsion.sheet_shear_modulus_pa / self.torsion.cloth_shear_modulus_pa
            density = self.torsion.cloth_density_kg_per_m3 / self.sheet_density_kg_per_m3
            nose_m = sheet_m + self.stiffening_sheet_m(wing) * (stiffness * density)
        nose_m = _PERIMETER * self.nose_chord_fraction * nose_m
        wedge = self.trailing_edge_chord_fraction**2 * self.thickness_ratio / (2.0 * _TAPER_LENGTH)
        section = _SECTION_AREA * self.thickness_ratio
        ribs_kg = self.sheet_density_kg_per_m3 * self.rib_solidity * section * sheet_m * area_m2
        ribs_kg = ribs_kg / self.rib_spacing_chords
        if self.core_density_kg_per_m3 is not None:  # fills the section, trailing edge included
            ribs_kg, wedge = self.core_density_kg_per_m3 * section * chord_m * area_m2, 0.0
        covering_kg = _PERIMETER * area_m2 * self.covering_kg_per_m2
        edges_kg = self.sheet_density_kg_per_m3 * area_m2 * (nose_m + wedge * chord_m)
        # The shell of the wing relieves the spar; the spar's mass is neglected, conservatively.
        spread = wing.relief_kg + covering_kg + ribs_kg + edges_kg
        # At most the total mass: an assumed total may be below the mass of the wing.
        relief_kg = smooth_minimum(spread, inputs.total_mass_kg)
        return wing._replace(
            relief_kg=relief_kg, covering_kg=covering_kg, ribs_kg=ribs_kg, edges_kg=edges_kg
        )

    def torsional_needs_nm2(self, wing: Wing) -> dict[str, Value]:
        """Return the torsional stiffness GJ that each criterion requires [N m2]."""
        assert self.torsion is not None
        dive = self.dive_speed_ratio * wing.equivalent_airspeed_m_per_s
        loading = wing.total_mass_kg * GRAVITY_M_PER_S2 / wing.wing_area_m2
        return self.torsion.needed_nm2(
            chord_m=wing.chord_m,
            half_span_m=wing.wingspan_m / 2.0,
            lift_slope=lift_curve_slope(wing.wingspan_m / wing.chord_m),
            dive_pressure_pa=0.5 * SEA_LEVEL_DENSITY_KG_PER_M3 * dive * dive,
            limit_loading_pa=wing.factor_up * loading,
        )

    def nose_m3(self, chord_m: Value) -> Value:
        """Return the sheeted nose's torsional stiffness GJ over that of its wall, G t [m3].

        The spar closes its cell.
        """
        area_m2 = _NOSE_AREA * self.nose_chord_fraction * self.thickness_ratio * chord_m * chord_m
        skin_m = _PERIMETER * self.nose_chord_fraction * chord_m
        return closed_cell_nm2(area_m2, skin_m + self.thickness_ratio * chord_m)

    def box_torsional_stiffness_nm2(self, wing: Wing) -> Value:
        """Return the torsional stiffness GJ of the spar's box at minimum gauges [N m2]."""
        width_m = self.cap_width_fraction * wing.chord_m
        # Shear modulus of the quasi-isotropic laminate, E/(2 (1 + 0.3)).
        web_n_per_m = self.laminate_modulus_pa / 2.6 * self.minimum_web_thickness_m
        cap_n_per_m = self.shear_modulus_pa * self.minimum_cap_thickness_m
        flexibility = 2.0 * (wing.depth_m / web_n_per_m + width_m / cap_n_per_m)
        return closed_cell_nm2(width_m * wing.depth_m, flexibility)

    def torsional_stiffness_nm2(self, wing: Wing, sheet_m: Value) -> Value:
        """Return the torsional stiffness GJ of the nose, by its sheet, and of the box [N m2]."""
        assert self.torsion is not None
        nose = self.nose_m3(wing.chord_m) * self.torsion.sheet_shear_modulus_pa * sheet_m
        return nose + self.box_torsional_stiffness_nm2(wing)

    def stiffening_sheet_m(self, wing: Wing) -> Value:
        """Return the additional sheet of the nose for the required torsional stiffness [m]."""
        assert self.torsion is not None
        needed = largest(self.torsional_needs_nm2(wing))
        missing = needed - self.torsional_stiffness_nm2(wing, wing.sheet_m)
        missing = (missing + smooth_absolute(missing, needed)) / 2.0
        return missing / self.nose_m3(wing.chord_m) / self.torsion.sheet_shear_modulus_pa

    def load_factors(
        self, inputs: StructureInputs, equivalent_airspeed: Value
    ) -> tuple[Value, Value]:
        """Return limit load factors: the larger of manoeuvre and gust, upwards and downwards [-].

        ``max(n, 1 + dn)`` up and ``max(r n, dn - 1)`` down as smooth maxima, with the manoeuvre
        factor n, the gust's increment dn and the ``negative_load_ratio`` r. The keys alone decide
        whether gust times airspeed is larger at cruise or in a dive.
        """
        gust = max(self.cruise_gust_m_per_s, self.dive_gust_m_per_s * self.dive_speed_ratio)
        gust_fraction = inputs.gust_fraction if self.gusts_fall_with_altitude else 1.0
        increment = gust_load_increment(gust_fraction * gust * equivalent_airspeed, inputs)
        pull_up = self.pull_up(inputs.total_mass_kg)
        return (
            smooth_maximum(pull_up, 1.0 + increment),
            smooth_maximum(1.0 + self.negative_load_ratio * pull_up, increment) - 1.0,
        )

    def pull_up(self, total_mass_kg: Value) -> Value:
        """Return the limit load factor of manoeuvres, by the file or by the mass [-]."""
        chosen = self.manoeuvre_load_factor
        return limit_load_factor(total_mass_kg) if chosen is None else chosen

    @property
    def cap_buckling_pa(self) -> Value:
        """Stress [Pa] at which a cap as thick as wide would buckle; it falls with (t/w)^2.

        Long orthotropic plate, simply supported at both webs:
        ``2 pi^2/(w^2 t) [sqrt(D11 D22) + D12 + 2 D66]`` (Jones, Mechanics of Composite Materials,
        section 5.4).
        """
        ratio = self.transverse_modulus_pa / self.modulus_pa
        coupling = 1.0 - self.poisson_ratio**2 * ratio
        along, across = self.modulus_pa / coupling, self.transverse_modulus_pa / coupling
        stiffness = (along * across) ** 0.5 + self.poisson_ratio * across
        return 2.0 * pi**2 / 12.0 * (stiffness + 2.0 * self.shear_modulus_pa)

    def narrow_cap_width_m(self, section_m2: Value) -> Value:
        """Return the width at which a cap buckles at its compressive strength [m]."""
        slenderness = (self.compressive_strength_pa / self.cap_buckling_pa) ** 0.5
        return (section_m2 / slenderness) ** 0.5

    def along_the_span(self, *values: Value) -> tuple[Station, Callable[[Value], Value]]:
        """Return stations with landing gear and wires of this wing, and the integral over them."""
        gear, wires = self.landing_gear_span_fraction, self.bracing
        wire = None if wires is None else wires.attachment_span_fraction
        landing_wires = wires is not None and wires.landing_wires
        return along_the_span(stations(gear, wire, landing_wires), *values)

    def cap_forces(self, wing: Wing, station: Station) -> CapForces:
        """Return the cap forces of lift less the inertia of the masses in the wing.

        Where mass outweighs lift, an up-load bends the wing downwards. Wires from below relieve it
        of moments upwards, wires from above of moments downwards and in landing.
        """
        up, down = wing.factor_up, wing.factor_down
        level = GRAVITY_M_PER_S2 / 2.0 * (wing.wingspan_m / 2.0) / wing.depth_m
        wires = self.bracing
        below = self._bending(wing, station, station.wire)
        one_way = wires is not None and not wires.landing_wires
        above = self._bending(wing, station, 0.0) if one_way else below
        landed, pressed = station.landed_moment, 0.0
        if wires is not None:
            root_nm, half_span_m = self._root_moment_nm(wing), wing.wingspan_m / 2.0
            pressed = wires.compression_n(root_nm, half_span_m) / 2.0 * (station.wire > 0.0)
        if self.landing_gear_span_fraction or wires is not None:
            landed = smooth_absolute(landed, station.mass_moment)
        ultimate = self.safety_factor * level
        axial = self.safety_factor * up * pressed
        return CapForces(
            up=ultimate * (up * below[0] + down * above[1]) + axial,
            down=ultimate * (down * above[0] + up * below[1]) + axial,
            landing=ultimate * self.landing_load_factor * (wing.relief_kg * landed),
            level=level * (below[0] + below[1]),
        )

    def net_moment(self, wing: Wing, station: Station, wire: Value) -> Value:
        """Return the moment of lift less mass at 1 g, relieved by a wire, over span and gravity."""
        lift = station.lift_moment - wire * LIFT_AT_ROOT
        mass = station.mass_moment - wire * MASS_AT_ROOT
        return wing.total_mass_kg * lift - wing.relief_kg * mass

    def _bending(self, wing: Wing, station: Station, wire: Value) -> tuple[Value, Value]:
        """Return moments at 1 g that bend the wing up and down, per unit of ``level``."""
        net = self.net_moment(wing, station, wire)
        size = smooth_absolute(net, wing.total_mass_kg * station.lift_moment)
        return (size + net) / 2.0, (size - net) / 2.0

    def _root_moment_nm(self, wing: Wing) -> Value:
        """Return the root moment of a half-wing in level flight, without wires [N m]."""
        lifted = wing.total_mass_kg * LIFT_AT_ROOT
        size = smooth_absolute(lifted - wing.relief_kg * MASS_AT_ROOT, lifted)
        return GRAVITY_M_PER_S2 / 2.0 * wing.wingspan_m / 2.0 * size

    def wires(self, wing: Wing) -> Wires:
        """Return the wires of both wings, without mass and drag if there are none."""
        if self.bracing is None:
            return Wires(0.0, 0.0)
        root_nm = self.safety_factor * self._root_moment_nm(wing)
        up, down = (factor * root_nm for factor in (wing.factor_up, wing.factor_down))
        return self.bracing.wires(up, down, wing.wingspan_m / 2.0)

    def shear_n(self, wing: Wing, station: Station) -> Value:
        """Return the ultimate shear at the upward limit load or in landing [N].

        Wires, which reduce the shear inboard, are neglected, conservatively.
        """
        half_n = self.safety_factor * GRAVITY_M_PER_S2 / 2.0
        lifted = wing.total_mass_kg * station.lift_shear
        carried = wing.relief_kg * station.mass_shear
        landed = carried
        if self.landing_gear_span_fraction:
            landed = wing.relief_kg * smooth_absolute(station.landed_shear, station.mass_shear)
        flight = wing.factor_up * smooth_absolute(lifted - carried, lifted)
        return half_n * smooth_maximum(flight, self.landing_load_factor * landed)

    def cap_needs_m2(
        self, wing: Wing, forces: CapForces
    ) -> tuple[dict[str, Value], dict[str, Value]]:
        """Return the sections of upper and lower cap that each criterion requires [m2].

        Loads upwards compress the upper cap and stretch the lower one; loads downwards and landing
        do the opposite. Limits of the deflection bound the strain of both caps.
        """
        stiffness = self._stiffness_needs_m2(wing, forces)
        downwards = smooth_maximum(forces.down, forces.landing)
        upper = self._strength_needs_m2(wing, forces.up, downwards) | stiffness
        return upper, self._strength_needs_m2(wing, downwards, forces.up) | stiffness

    def _strength_needs_m2(
        self, wing: Wing, compression_n: Value, tension_n: Value
    ) -> dict[str, Value]:
        """Return the sections of a cap for strength, buckling and gauge [m2]."""
        width_m = self.cap_width_fraction * wing.chord_m
        needs = {
            "compression": compression_n / self.compressive_strength_pa,
            "buckling": (compression_n * width_m**4 / self.cap_buckling_pa) ** (1.0 / 3.0),
            "tension": tension_n / self.tensile_strength_pa,
            "gauge": width_m * self.minimum_cap_thickness_m,
        }
        # Narrow caps have a width at which they do not buckle before they fail.
        return {k: v for k, v in needs.items() if not (self.narrow_caps and k == "buckling")}

    def _stiffness_needs_m2(self, wing: Wing, forces: CapForces) -> dict[str, Value]:
        """Return the sections of a cap for the limits of deflection and slope [m2].

        A strain of at most ``2 f h/b`` gives a curvature of at most ``4 f/b``, and a tip deflection
        of at most f half-spans; a strain of at most ``theta h/b`` a slope of at most theta.
        """
        flight_n = forces.level
        if self.deflection_load_case == "limit_load":
            flight_n = smooth_maximum(forces.up, forces.down) / self.safety_factor
        strain_per_radian = wing.depth_m / wing.wingspan_m
        limits = {
            "tip_deflection": (self.maximum_tip_deflection, 2.0, flight_n),
            "tip_slope": (self.maximum_tip_slope_deg, radians(1.0), flight_n),
            "landing_deflection": (
                self.maximum_landing_deflection,
                2.0,
                forces.landing / self.safety_factor,
            ),
        }
        return {
            name: force_n / (self.modulus_pa * (limit * factor * strain_per_radian))
            for name, (limit, factor, force_n) in limits.items()
            if limit is not None
        }

    def web_needs_m(self, wing: Wing, shear_n: Value) -> dict[str, Value]:
        """Return the thickness of each web that each criterion requires, of ultimate shear [m]."""
        depth_m = wing.depth_m
        # Stress at which a web as thick as high would buckle; it falls with (t/h)^2.
        buckling_pa = SHEAR_PLATE * pi**2 / (12.0 * (1.0 - 0.3**2)) * self.laminate_modulus_pa
        needs = {
            "shear": shear_n / (2.0 * depth_m * self.laminate_shear_strength_pa),
            "buckling": (shear_n * depth_m / (2.0 * buckling_pa)) ** (1.0 / 3.0),
            "gauge": self.minimum_web_thickness_m,
        }
        # A core prevents buckling of the facings.
        return {k: v for k, v in needs.items() if self.web_core is None or k != "buckling"}

    def _boom_kg(self, area_m2: Value, chord_m: Value, equivalent_airspeed: Value) -> Value:
        """Return the mass of tubes, bought or sized for the largest tail lift in a dive [kg]."""
        if self.booms == 0:
            return 0.0
        length_m = self.fuselage_chords * chord_m
        diameter_m = self.boom_diameter_chords * chord_m
        known = self.boom_kg_per_m
        if self.boom_thickness_m is not None:
            known = self.laminate_density_kg_per_m3 * pi * diameter_m * self.boom_thickness_m
        if known is not None:
            return self.booms * known * length_m / self.mass_factor
        dive = self.dive_speed_ratio * equivalent_airspeed
        tail_m2 = self.horizontal_tail_ratio / self.fuselage_chords * area_m2
        tail_n = self.tail_lift_coefficient * 0.5 * SEA_LEVEL_DENSITY_KG_PER_M3 * dive**2 * tail_m2
        moment = self.safety_factor * tail_n * length_m / self.booms
        strength = 4.0 * moment / (pi * diameter_m**2 * self.laminate_strength_pa)
        critical = _TUBE_KNOCKDOWN * 2.0 * self.laminate_modulus_pa / diameter_m
        buckling = (4.0 * moment / (pi * diameter_m**2 * critical)) ** 0.5
        wall = smooth_maximum(smooth_maximum(strength, buckling), self.minimum_boom_thickness_m)
        return self.booms * (self.laminate_density_kg_per_m3 * pi * diameter_m * wall * length_m)
