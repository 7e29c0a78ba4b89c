"""Narrow caps, webs with a core, wires, landing gear along the span, and masses along it."""

from math import cos, pi, radians, sin, tan

import casadi as ca
import numpy as np
import pytest
from builders import DESIGN, mission
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq

from sizing.aircraft import Aircraft
from sizing.balance.in_design import structure_inputs
from sizing.design import FlightConditions, variables_of
from sizing.mass_budget import closed_design
from sizing.structures.assessment import assess
from sizing.structures.loads import Station, StructureInputs, stations
from sizing.structures.rib_wing import RibWingStructure
from sizing.structures.stiffening import Bracing, WebCore

WIRE = {"attachment_span_fraction": 0.4, "angle_deg": 15.0}
# Zephyr's size, in level flight at 18 km.
INPUTS = StructureInputs(25.0, 22.0, 75.0, 30.0, 21.0, 0.12)
CALM = {"cruise_gust_m_per_s": 0.0, "dive_gust_m_per_s": 0.0}


def rib_wing(**keys):
    return RibWingStructure.model_validate({"model": "rib_wing", **keys})


@pytest.mark.parametrize("gear", [0.3, 2.0 / 3.0])
def test_landing_gear_along_the_span_carries_the_mass_evenly(gear):
    for station in map(Station._make, zip(*stations(gear), strict=True)):
        x = station.fraction

        def net(y):
            return 1.0 - (1.0 / gear if y < gear else 0.0)

        shear = quad(net, x, 1.0, points=[gear])[0]
        moment = quad(lambda y, x=x: net(y) * (y - x), x, 1.0, points=[gear])[0]
        assert station.landed_shear == pytest.approx(shear, abs=1e-9)
        assert station.landed_moment == pytest.approx(moment, abs=1e-9)
    # Held at the root, as without a key.
    assert np.array_equal(stations().landed_moment, stations().mass_moment)


@pytest.mark.parametrize("wire", [0.2, 0.6])
def test_a_wire_leaves_no_moment_at_the_root_and_changes_nothing_outboard(wire):
    lift_at_root = 4.0 / (3.0 * pi)  # of an ellipse
    for station in map(Station._make, zip(*stations(0.0, wire), strict=True)):
        x = station.fraction
        # The wire pulls down at its attachment with what balances the moment at the root.
        pull = lift_at_root / wire
        taken = pull * max(0.0, wire - x)
        assert station.wire * lift_at_root == pytest.approx(taken, abs=1e-12)


def test_narrow_caps_are_sized_by_strength_and_buckle_as_they_fail():
    wide, narrow = rib_wing(), rib_wing(narrow_caps=True)
    assert narrow.breakdown(INPUTS).spar_caps < 0.5 * wide.breakdown(INPUTS).spar_caps
    assert "buckling" not in assess(narrow, INPUTS).spar_caps
    section_m2 = 1e-4
    width = narrow.narrow_cap_width_m(section_m2)
    thickness = section_m2 / width
    # Long orthotropic plate between two webs, by its stiffnesses.
    nu12, e1, e2, g12 = 0.3, 73e9, 8e9, 4e9
    d11, d22 = (e * thickness**3 / (12.0 * (1.0 - nu12**2 * e2 / e1)) for e in (e1, e2))
    d66 = g12 * thickness**3 / 12.0
    stress = 2.0 * pi**2 / width**2 / thickness * (np.sqrt(d11 * d22) + nu12 * d22 + 2.0 * d66)
    assert stress == pytest.approx(368e6, rel=1e-9)


@settings(max_examples=40)
@given(flow=st.floats(1e3, 2e5), facings=st.floats(1e-4, 3e-3), depth=st.floats(0.02, 0.5))
def test_a_core_is_as_thick_as_the_web_needs_not_to_buckle(flow, facings, depth):
    core = WebCore(minimum_thickness_m=1e-9, bond_kg_per_m2=0.0)

    def strength(thickness):
        """Shear flow at which two facings on a core buckle, bending and shear in series."""
        bending = 45e9 * facings / 2.0 * 2.0 * (thickness / 2.0) ** 2 / (1.0 - 0.09)
        plate = 5.35 * pi**2 * bending / depth**2
        return 1.0 / (1.0 / plate + 1.0 / (19e6 * thickness))

    thickness = brentq(lambda t: strength(t) - flow, 1e-7, 10.0, xtol=1e-15)
    assert core.kg_per_m2(flow, facings, depth, 45e9) == pytest.approx(52.0 * thickness, rel=1e-4)


def test_wires_carry_by_statics_what_they_take_off_the_wing():
    wire = Bracing.model_validate(WIRE)
    half_span, moment = 17.0, 3000.0
    wires = wire.wires(moment, 0.0, half_span)
    distance = 0.4 * half_span
    tension = moment / (distance * sin(radians(15.0)))
    length = distance / cos(radians(15.0))
    section = tension / 2.0e9
    assert wires.mass_kg == pytest.approx(2.0 * 7850.0 * section * length)
    # Two wires of that diameter across the air.
    diameter = (4.0 * section / pi) ** 0.5
    assert wires.drag_area_m2 == pytest.approx(2.0 * 1.1 * diameter * length)
    pressed = wire.compression_n(moment, half_span)
    assert pressed == pytest.approx(tension * cos(radians(15.0)))
    assert pressed * tan(radians(15.0)) * distance == pytest.approx(moment)
    both = wire.model_copy(update={"landing_wires": True}).wires(moment, moment, half_span)
    assert both.mass_kg == pytest.approx(2.0 * wires.mass_kg)


def test_wires_press_the_spar_inboard_of_their_ends_alone():
    place = stations(wire=0.4)
    pressed = []
    for angle_deg in (15.0, 45.0):
        model = rib_wing(bracing=WIRE | {"angle_deg": angle_deg})
        wing = model.wing(INPUTS)
        pressed.append(model.cap_forces(wing, place).up)
    # By statics: the half-wing's moment about its root is held by the pull of the wire.
    root_nm = 9.80665 / 2.0 * 12.5 * (75.0 * 4.0 / (3.0 * pi) - wing.relief_kg / 2.0)
    along_n = root_nm / (0.4 * 12.5) * (1.0 / tan(radians(15.0)) - 1.0)
    of_a_cap = np.where(place.fraction < 0.4, along_n / 2.0, 0.0)
    # The smooth absolute of the moment is above it by (0.02 of the lift's)^2.
    expected = 1.5 * wing.factor_up * of_a_cap
    assert pressed[0] - pressed[1] == pytest.approx(expected, rel=5e-3, abs=1e-6)


@pytest.mark.parametrize("landing_wires", [True, False])
def test_wires_on_both_sides_bear_loads_of_either_sign_alike(landing_wires):
    bracing = WIRE | {"landing_wires": landing_wires}
    model = rib_wing(bracing=bracing, manoeuvre_load_factor=3.0, negative_load_ratio=1.0, **CALM)
    wing = model.wing(INPUTS)
    forces = model.cap_forces(wing, stations(wire=0.4))
    # Blends of smooth maxima.
    alike = forces.down == pytest.approx(forces.up, rel=0.01)
    assert alike == landing_wires


def test_wires_lighten_a_spar_and_add_their_own_mass_to_the_joints():
    keys = {"narrow_caps": True, "web_core": {}}
    inputs = INPUTS._replace(span_load_kg=0.0, total_mass_kg=110.0)
    free, braced = rib_wing(**keys), rib_wing(**keys, bracing=WIRE)
    # The pressure of the wire takes part of what it saves.
    assert braced.breakdown(inputs).spar_caps < 0.8 * free.breakdown(inputs).spar_caps
    wires = braced.wires(braced.wing(inputs))
    parts = braced.breakdown(inputs)
    rest = sum(parts) - parts.joints
    assert parts.joints == pytest.approx(0.15 * rest + wires.mass_kg)


def test_the_load_factor_of_manoeuvres_of_the_file_counts():
    model = rib_wing(manoeuvre_load_factor=3.1, **CALM)
    assert model.wing(INPUTS).factor_up == pytest.approx(3.1, rel=0.01)
    assert model.wing(INPUTS).factor_down == pytest.approx(0.4 * 3.1, rel=0.01)
    assessment = assess(model, INPUTS)
    assert (assessment.load_case, assessment.negative_load_case) == ("manoeuvre", "manoeuvre")


def test_gear_along_the_span_and_no_boom_lighten_a_flying_wing():
    keys = CALM | {"narrow_caps": True, "web_core": {}, "manoeuvre_load_factor": 2.0}
    loaded = INPUTS._replace(span_load_kg=60.0)
    usual, spread = rib_wing(**keys), rib_wing(**keys, landing_gear_span_fraction=0.6667)
    assert spread.breakdown(loaded).spar_caps < 0.7 * usual.breakdown(loaded).spar_caps
    assert abs(assess(spread, loaded).tip_deflection_landing) < abs(
        assess(usual, loaded).tip_deflection_landing
    )
    flying = rib_wing(**keys, booms=0).breakdown(loaded)
    assert flying.boom == 0.0
    assert flying.tails == 0.0


@pytest.mark.parametrize(
    "keys",
    [
        {"narrow_caps": True, "web_core": {}},
        {"bracing": WIRE},
        {"bracing": WIRE | {"landing_wires": True}, "landing_gear_span_fraction": 0.5},
        {"booms": 0, "manoeuvre_load_factor": 2.0},
    ],
    ids=str,
)
def test_symbols_give_the_same_mass_with_finite_derivatives(keys):
    model = rib_wing(**keys)
    names = ("wingspan_m", "aspect_ratio", "total_mass_kg")
    symbols = [ca.MX.sym(name) for name in names]
    mass = model.mass_kg(INPUTS._replace(**dict(zip(names, symbols, strict=True))))
    gradient = ca.gradient(mass, ca.vertcat(*symbols))
    curvature = ca.jacobian(gradient, ca.vertcat(*symbols))
    function = ca.Function("mass", symbols, [mass, gradient, curvature])
    for span, ratio, kg in ((3.0, 13.0, 2.4), (25.0, 22.0, 75.0), (75.0, 31.0, 930.0)):
        value, first, second = function(span, ratio, kg)
        inputs = INPUTS._replace(wingspan_m=span, aspect_ratio=ratio, total_mass_kg=kg)
        assert float(value) == pytest.approx(float(model.mass_kg(inputs)), rel=1e-9)
        assert np.all(np.isfinite(np.array(first)))
        assert np.all(np.isfinite(np.array(second)))


def of_airframe(base=DESIGN, **changes):
    data = base.model_dump(exclude_unset=True)
    data["airframe"] |= changes
    return Aircraft.model_validate(data)


def large(**keys):
    return {"model": "rib_wing", "calibration": 1.188, "narrow_caps": True, "web_core": {}} | keys


def test_masses_along_the_span_relieve_the_spar():
    base = {"wingspan_m": 12.0, "avionics_mass_kg": 6.0, "structure": large()}

    def structure_kg(**changes):
        aircraft = of_airframe(**base, **changes)
        return float(closed_design(aircraft, mission(), variables_of(aircraft)).masses.structure)

    plain = structure_kg()
    assert structure_kg(distributed_propulsion_fraction=1.0) < plain
    assert structure_kg(distributed_systems_fraction=1.0) < plain


def test_wires_cost_the_power_of_their_drag():
    """The same power as of an aircraft whose parasitic drag has that of the wires."""
    dragging = of_airframe(wingspan_m=12.0, structure=large(bracing=WIRE))
    design = closed_design(dragging, mission(), variables_of(dragging))
    sized = structure_of(dragging, design)
    wires = sized[0].wires(sized[0].wing(sized[1]))
    area_m2 = 12.0**2 / 18.5
    polar = DESIGN.model_dump()["airframe"]["aerodynamics"]
    polar["parasitic_drag_coefficient"] += float(wires.drag_area_m2) / area_m2
    slick = of_airframe(
        wingspan_m=12.0,
        structure=large(bracing=WIRE | {"drag_coefficient": 0.0}),
        aerodynamics=polar,
    )
    same = closed_design(slick, mission(), variables_of(slick))
    assert float(wires.drag_area_m2) > 0.0
    assert design.propulsion_power_w == pytest.approx(same.propulsion_power_w, rel=1e-6)


def structure_of(aircraft, design):
    conditions = FlightConditions.of(mission(), aircraft)
    model = aircraft.airframe.structure
    assert isinstance(model, RibWingStructure)
    return model, structure_inputs(
        aircraft, design.variables, conditions, design.total_mass_kg, design.airspeed_m_per_s, 0.0
    )
