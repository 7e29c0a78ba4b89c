"""Structural mass of a rib wing with a box spar of carbon fibre, part by part.

The spar is sized station by station along the span for the larger of manoeuvre and gust, upwards
and downwards, and for landing; every wall has a minimum gauge. Everything is arithmetic and every
maximum is smooth (:mod:`sizing.smooth`), so that floats, arrays and symbols pass alike and an
optimiser finds no kink. Equations and sources: docs/structure.md.
"""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field, Strict

from missions.air import GRAVITY_M_PER_S2
from sizing.smooth import Value, smooth_absolute, smooth_maximum, smooth_minimum
from sizing.structures.loads import (
    SEA_LEVEL_DENSITY_KG_PER_M3,
    StructureInputs,
    gust_load_increment,
    limit_load_factor,
)
from solar.schema import Fraction, NonNegativeReal, PositiveReal, Record, UnitInterval

# Points of the Gauss-Legendre rule along the half-span; see docs/structure.md for its error.
STATION_COUNT = 6
# Perimeter over chord of a cambered section, both sides, and area over thickness times chord.
_PERIMETER = 2.04
_SECTION_AREA = 0.68
# The section tapers to the trailing edge from its thickest place at 30 % of the chord.
_TAPER_LENGTH = 0.7
# Buckling of a long flat plate in shear, simply supported: 5.35 (Timoshenko & Gere, Theory of
# Elastic Stability, section 9.7).
_SHEAR_PLATE = 5.35
# A thin tube in bending buckles at 0.6 E t/R in theory. Half of that is used: imperfections leave
# 0.79 to 0.66 of it for a radius of 30 to 100 wall thicknesses (NASA SP-8007).
_TUBE_KNOCKDOWN = 0.3


class StructureParts(NamedTuple):
    """Masses of the structure's parts [kg], calibration included; they add up to the structure."""

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
    """Limit load factors [-], all counted positive: pull-up or up-gust, and their opposites."""

    up: Value
    down: Value


class Station(NamedTuple):
    """Unit moments and shear at a fraction of the half-span, and its weight in an integral.

    ``lift_*`` belong to an elliptic lift of one half-wing, ``mass_*`` to a mass spread evenly; per
    unit of half-wing load, and of half-span for the moments.
    """

    fraction: Value
    weight: Value
    lift_moment: Value
    mass_moment: Value
    lift_shear: Value
    mass_shear: Value


def stations(count: int) -> tuple[Station, ...]:
    """Stations of a Gauss-Legendre rule from root (0) to tip (1)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return tuple(_station(float(x), float(w)) for x, w in zip(nodes, weights / 2.0, strict=True))


def _station(node: float, weight: float) -> Station:
    """Station at a node of the rule, which goes from -1 to 1."""
    x = (node + 1.0) / 2.0
    circle = (1.0 - x * x) ** 0.5
    outboard = (float(np.arccos(x)) - x * circle) / 2.0  # area of the ellipse outboard of x
    return Station(
        fraction=x,
        weight=weight,
        lift_moment=(circle**3 / 3.0 - x * outboard) * 4.0 / pi,
        mass_moment=(1.0 - x) ** 2 / 2.0,
        lift_shear=outboard * 4.0 / pi,
        mass_shear=1.0 - x,
    )


_COLUMNS = Station(*np.array(stations(STATION_COUNT)).T)


def _along_the_span(*values: Value) -> tuple[Station, Callable[[Value], Value]]:
    """All stations at once in the arithmetic of some values, and the integral over them.

    Stations are the first axis of arrays and the rows of symbols.
    """
    if all(isinstance(value, (int, float, np.number, np.ndarray)) for value in values):
        shape = (-1, *(1 for _ in range(max(np.ndim(value) for value in values))))
        arrays = Station(*(column.reshape(shape) for column in _COLUMNS))
        return arrays, lambda integrand: np.tensordot(_COLUMNS.weight, integrand, 1)
    import casadi as ca

    rows = Station(*(ca.DM(column) for column in _COLUMNS))
    return rows, lambda integrand: ca.dot(rows.weight, integrand)


class _Wing(NamedTuple):
    """What the parts are sized from."""

    wingspan_m: Value
    chord_m: Value
    wing_area_m2: Value
    total_mass_kg: Value
    relief_kg: Value
    factors: LoadFactors


class _Forces(NamedTuple):
    """Ultimate forces at a station [N]: cap force bending up and down, and shear."""

    up: Value
    down: Value
    shear: Value


class RibWingStructure(Record):
    """Rib wing with a carbon-fibre box spar, tails on a tube, a pod.

    ``calibration`` multiplies everything: it is the one factor that fits a built aircraft. Strength
    and moduli are published material data; areal masses, gauges and proportions are assumptions
    for light built-up wings. docs/structure.md names source or assumption key by key.
    """

    model: Literal["rib_wing"]
    calibration: PositiveReal = 1.0
    # Loads.
    safety_factor: PositiveReal = 1.5
    cruise_gust_m_per_s: NonNegativeReal = 15.25
    dive_gust_m_per_s: NonNegativeReal = 7.6
    dive_speed_ratio: Annotated[float, Strict(), Field(ge=1.0, le=10.0)] = 1.5
    negative_load_ratio: UnitInterval = 0.4
    landing_load_factor: NonNegativeReal = 2.0
    # Spar.
    thickness_ratio: Annotated[float, Strict(), Field(gt=0.02, lt=0.3)] = 0.125
    spar_depth_fraction: Fraction = 0.9
    cap_width_fraction: Fraction = 0.06
    minimum_cap_thickness_m: PositiveReal = 0.25e-3
    minimum_web_thickness_m: PositiveReal = 0.2e-3
    maximum_tip_deflection: Fraction | None = None
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
    boom_diameter_chords: PositiveReal = 0.1
    minimum_boom_thickness_m: PositiveReal = 0.5e-3
    pod_wetted_area_ratio: NonNegativeReal = 0.08
    pod_kg_per_m2: NonNegativeReal = 0.4
    joint_fraction: NonNegativeReal = 0.15

    def mass_kg(self, inputs: StructureInputs) -> Value:
        """Structural mass [kg]."""
        return self.breakdown(inputs).total_kg

    def breakdown(self, inputs: StructureInputs) -> StructureParts:
        """Masses of the parts."""
        chord_m = inputs.wingspan_m / inputs.aspect_ratio
        area_m2 = inputs.wingspan_m * chord_m
        relative_density = inputs.density_kg_per_m3 / SEA_LEVEL_DENSITY_KG_PER_M3
        equivalent_airspeed = inputs.airspeed_m_per_s * relative_density**0.5
        sheet_m = smooth_maximum(
            self.minimum_sheet_thickness_m, self.sheet_thickness_ratio * chord_m
        )
        covering = _PERIMETER * area_m2 * self.covering_kg_per_m2
        ribs = self._ribs_kg(area_m2, sheet_m)
        edges = self._edges_kg(area_m2, chord_m, sheet_m)
        # The wing's own shell relieves the spar; the spar itself is left out, on the safe side.
        spread = inputs.span_load_kg + covering + ribs + edges
        wing = _Wing(
            wingspan_m=inputs.wingspan_m,
            chord_m=chord_m,
            wing_area_m2=area_m2,
            total_mass_kg=inputs.total_mass_kg,
            # No more than the aircraft weighs: an assumed mass may be below that of its own wing.
            relief_kg=smooth_minimum(spread, inputs.total_mass_kg),
            factors=self.load_factors(
                total_mass_kg=inputs.total_mass_kg,
                wing_area_m2=area_m2,
                aspect_ratio=inputs.aspect_ratio,
                equivalent_airspeed_m_per_s=equivalent_airspeed,
                density_kg_per_m3=inputs.density_kg_per_m3,
            ),
        )
        caps, web = self._spar_kg(wing)
        tail_ratio = (self.horizontal_tail_ratio + self.vertical_tail_ratio) / self.fuselage_chords
        parts = (
            caps,
            web,
            covering,
            ribs,
            edges,
            tail_ratio * area_m2 * self.tail_kg_per_m2,
            self._boom_kg(area_m2, chord_m, equivalent_airspeed),
            self.pod_wetted_area_ratio * area_m2 * self.pod_kg_per_m2,
        )
        joints = self.joint_fraction * sum(parts[1:], parts[0])
        return StructureParts(*(self.calibration * part for part in (*parts, joints)))

    def load_factors(
        self,
        *,
        total_mass_kg: Value,
        wing_area_m2: Value,
        aspect_ratio: Value,
        equivalent_airspeed_m_per_s: Value,
        density_kg_per_m3: Value,
    ) -> LoadFactors:
        """Limit load factors: the larger of manoeuvre and gust, upwards and downwards.

        Gust times airspeed is larger either at cruise or at dive speed, whatever the design.

        Parameters
        ----------
        total_mass_kg, wing_area_m2, aspect_ratio
            Mass [kg], wing area [m2] and aspect ratio [-].
        equivalent_airspeed_m_per_s
            Equivalent airspeed of level flight, taken as cruise [m/s].
        density_kg_per_m3
            Of the air [kg/m3].

        Returns
        -------
        LoadFactors
            ``max(n, 1 + dn)`` up and ``max(r n, dn - 1)`` down, with the manoeuvre factor n, the
            gust's increment dn and the ``negative_load_ratio`` r; smooth maxima [-].
        """
        gust = max(self.cruise_gust_m_per_s, self.dive_gust_m_per_s * self.dive_speed_ratio)
        increment = gust_load_increment(
            gust * equivalent_airspeed_m_per_s,
            total_mass_kg=total_mass_kg,
            wing_area_m2=wing_area_m2,
            aspect_ratio=aspect_ratio,
            density_kg_per_m3=density_kg_per_m3,
        )
        pull_up = limit_load_factor(total_mass_kg)
        return LoadFactors(
            up=smooth_maximum(pull_up, 1.0 + increment),
            down=smooth_maximum(1.0 + self.negative_load_ratio * pull_up, increment) - 1.0,
        )

    @property
    def cap_buckling_pa(self) -> float:
        """Stress [Pa] at which a cap as thick as wide would buckle; it falls with (t/w)^2.

        Long orthotropic plate, simply supported at both webs:
        ``2 pi^2/(w^2 t) [sqrt(D11 D22) + D12 + 2 D66]`` (Jones, Mechanics of Composite Materials,
        section 5.4).
        """
        ratio = self.transverse_modulus_pa / self.modulus_pa
        coupling = 1.0 - self.poisson_ratio**2 * ratio
        along, across = self.modulus_pa / coupling, self.transverse_modulus_pa / coupling
        stiffness = float((along * across) ** 0.5) + self.poisson_ratio * across
        return 2.0 * pi**2 / 12.0 * (stiffness + 2.0 * self.shear_modulus_pa)

    @property
    def web_buckling_pa(self) -> float:
        """Shear stress [Pa] at which a web as thick as high would buckle; falls with (t/h)^2."""
        return _SHEAR_PLATE * pi**2 / (12.0 * (1.0 - 0.3**2)) * self.laminate_modulus_pa

    def _spar_kg(self, wing: _Wing) -> tuple[Value, Value]:
        """Caps and webs, integrated over both half-spans."""
        depth_m = self.spar_depth_fraction * self.thickness_ratio * wing.chord_m
        station, integral = _along_the_span(
            wing.wingspan_m, wing.chord_m, wing.total_mass_kg, wing.relief_kg, *wing.factors
        )
        forces = self._forces(wing, station, depth_m)
        caps_m2 = self._cap_area_m2(wing, forces.up, forces.down, depth_m)
        caps_m2 = caps_m2 + self._cap_area_m2(wing, forces.down, forces.up, depth_m)
        cap_m2 = integral(caps_m2)
        web_m = integral(self._web_thickness_m(forces.shear, depth_m))
        span_m = wing.wingspan_m
        caps_kg = self.cap_density_kg_per_m3 * span_m * cap_m2
        web_kg = self.laminate_density_kg_per_m3 * span_m * 2.0 * depth_m * web_m
        return caps_kg, web_kg

    def _forces(self, wing: _Wing, station: Station, depth_m: Value) -> _Forces:
        """Ultimate cap forces and shear; lift less the inertia of what the wing carries."""
        up, down = wing.factors
        half_n = self.safety_factor * GRAVITY_M_PER_S2 / 2.0
        arm = half_n * (wing.wingspan_m / 2.0) / depth_m
        lifted = wing.total_mass_kg * station.lift_moment
        carried = wing.relief_kg * station.mass_moment
        net = lifted - carried
        size = smooth_absolute(net, lifted)
        # Where the wing carries more than it lifts, an up-load bends it downwards.
        outwards, inwards = (size + net) / 2.0, (size - net) / 2.0
        net_shear = wing.total_mass_kg * station.lift_shear - wing.relief_kg * station.mass_shear
        shear = up * smooth_absolute(net_shear, wing.total_mass_kg * station.lift_shear)
        landing = self.landing_load_factor * wing.relief_kg
        return _Forces(
            up=arm * (up * outwards + down * inwards),
            down=arm
            * smooth_maximum(down * outwards + up * inwards, landing * station.mass_moment),
            shear=half_n * smooth_maximum(shear, landing * station.mass_shear),
        )

    def _cap_area_m2(
        self, wing: _Wing, compression_n: Value, tension_n: Value, depth_m: Value
    ) -> Value:
        """Section of a cap that crushes, buckles and tears no earlier than at ultimate load."""
        width_m = self.cap_width_fraction * wing.chord_m
        crushing = compression_n / self.compressive_strength_pa
        buckling = (compression_n * width_m**4 / self.cap_buckling_pa) ** (1.0 / 3.0)
        tearing = tension_n / self.tensile_strength_pa
        gauge = width_m * self.minimum_cap_thickness_m
        strong = smooth_maximum(smooth_maximum(crushing, buckling), tearing)
        needed = smooth_maximum(strong, gauge)
        if self.maximum_tip_deflection is None:
            return needed
        # Strains of at most 2 f h/b make a curvature of at most 4 f/b, which bends the tip by no
        # more than f half-spans.
        allowed = self.maximum_tip_deflection * 2.0 * depth_m / wing.wingspan_m
        limit_n = smooth_maximum(compression_n, tension_n) / self.safety_factor
        return smooth_maximum(needed, limit_n / (self.modulus_pa * allowed))

    def _web_thickness_m(self, shear_n: Value, depth_m: Value) -> Value:
        """Thickness of each of the two webs: strength, buckling in shear, gauge."""
        strength = shear_n / (2.0 * depth_m * self.laminate_shear_strength_pa)
        buckling = (shear_n * depth_m / (2.0 * self.web_buckling_pa)) ** (1.0 / 3.0)
        return smooth_maximum(smooth_maximum(strength, buckling), self.minimum_web_thickness_m)

    def _ribs_kg(self, area_m2: Value, sheet_m: Value) -> Value:
        section = self.rib_solidity * _SECTION_AREA * self.thickness_ratio
        return self.sheet_density_kg_per_m3 * section * sheet_m * area_m2 / self.rib_spacing_chords

    def _edges_kg(self, area_m2: Value, chord_m: Value, sheet_m: Value) -> Value:
        """Nose sheeted on both sides, and a solid wedge as trailing edge."""
        nose_m = _PERIMETER * self.nose_chord_fraction * sheet_m
        wedge = self.trailing_edge_chord_fraction**2 * self.thickness_ratio / (2.0 * _TAPER_LENGTH)
        return self.sheet_density_kg_per_m3 * area_m2 * (nose_m + wedge * chord_m)

    def _boom_kg(self, area_m2: Value, chord_m: Value, equivalent_airspeed: Value) -> Value:
        """Tube that carries the tail's largest lift at dive speed, no thinner than the gauge."""
        length_m = self.fuselage_chords * chord_m
        diameter_m = self.boom_diameter_chords * chord_m
        dive = self.dive_speed_ratio * equivalent_airspeed
        tail_m2 = self.horizontal_tail_ratio / self.fuselage_chords * area_m2
        tail_n = self.tail_lift_coefficient * 0.5 * SEA_LEVEL_DENSITY_KG_PER_M3 * dive**2 * tail_m2
        moment = self.safety_factor * tail_n * length_m
        strength = 4.0 * moment / (pi * diameter_m**2 * self.laminate_strength_pa)
        critical = _TUBE_KNOCKDOWN * 2.0 * self.laminate_modulus_pa / diameter_m
        buckling = (4.0 * moment / (pi * diameter_m**2 * critical)) ** 0.5
        wall = smooth_maximum(smooth_maximum(strength, buckling), self.minimum_boom_thickness_m)
        return self.laminate_density_kg_per_m3 * pi * diameter_m * wall * length_m
