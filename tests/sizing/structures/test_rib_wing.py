"""The rib wing: loads by another form of the rule, parts by an independent sum, no kinks."""

from typing import NamedTuple

import casadi as ca
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from scipy.integrate import quad

from missions.air import gust_speed_fraction
from sizing.aircraft import Propulsion
from sizing.smooth import BLEND, smooth_absolute, smooth_maximum, smooth_minimum
from sizing.structures.assessment import assess
from sizing.structures.loads import Station, StructureInputs, stations
from sizing.structures.rib_wing import RibWingStructure
from sizing.structures.stiffening import WingTorsion

G = 9.80665
RIB_WING = RibWingStructure(model="rib_wing")
NO_GUSTS = {"cruise_gust_m_per_s": 0.0, "dive_gust_m_per_s": 0.0}

# The design space the model is made for.
spans = st.floats(1.0, 40.0)
aspects = st.floats(5.0, 40.0)
masses = st.floats(0.3, 400.0)
shares = st.floats(0.0, 0.7)
positives = st.floats(1e-3, 1e3)


def airspeed(m, b, ar, *, density=1.1, lift=1.0):
    return (2.0 * m * G / (density * b**2 / ar * lift)) ** 0.5


def inputs(b, ar, m, load=0.0, *, battery=0.0, density=1.1, gusts=1.0):
    """Level flight at a lift coefficient of one, with ``load`` kg along the span."""
    speed = airspeed(m, b, ar, density=density)
    return StructureInputs(
        b, ar, m, load, speed, density, wing_battery_kg=battery, gust_fraction=gusts
    )


def parts(b, ar, m, share=0.5, model=RIB_WING):
    return model.breakdown(inputs(b, ar, m, share * m, battery=0.8 * share * m))


def structure_kg(b, ar, m, share=0.5, **changes):
    return parts(b, ar, m, share, RibWingStructure(model="rib_wing", **changes)).total_kg


@given(first=positives, second=positives, growth=st.floats(1.001, 2.0))
def test_smooth_maximum_is_just_above_and_minimum_just_below_and_both_rise(first, second, growth):
    high, low = smooth_maximum(first, second), smooth_minimum(first, second)
    smaller, larger = sorted((first, second))
    # Rounding of the sum below, the documented overshoot above.
    assert larger * (1.0 - 1e-12) <= high <= larger * (1.0 + BLEND + 1e-12)
    assert smaller / (1.0 + BLEND + 1e-12) <= low <= smaller * (1.0 + 1e-12)
    assert smooth_maximum(first * growth, second) > high
    assert smooth_minimum(first * growth, second) > low
    assert smooth_maximum(3.0 * first, 3.0 * second) == pytest.approx(3.0 * high, rel=1e-12)
    assert smooth_maximum(first, first) == pytest.approx(1.02 * first, rel=1e-12)
    # (1 + sqrt(1 + 0.02^2))/2 = 1 + 0.02^2/4 to the next order.
    assert smooth_maximum(first, 0.0) == pytest.approx(1.0001 * first, rel=1e-7)
    for value in (first, -first):
        assert first <= smooth_absolute(value, second) <= first + BLEND * second * (1.0 + 1e-9)


@pytest.mark.parametrize("place", range(6))
def test_stations_hold_the_moments_of_ellipse_and_even_mass(place):
    station = Station(*(column[place] for column in stations()))
    x = station.fraction
    assert 0.0 < x < 1.0
    ellipse = 4.0 / np.pi
    shear, _ = quad(lambda y: ellipse * (1.0 - y * y) ** 0.5, x, 1.0)
    moment, _ = quad(lambda y: ellipse * (1.0 - y * y) ** 0.5 * (y - x), x, 1.0)
    # Closed forms against quadrature.
    assert station.lift_shear == pytest.approx(shear, rel=1e-7)
    assert station.lift_moment == pytest.approx(moment, rel=1e-7)
    assert station.mass_shear == pytest.approx(1.0 - x, rel=1e-12)
    assert station.mass_moment == pytest.approx((1.0 - x) ** 2 / 2.0, rel=1e-12)


class HardWing(NamedTuple):
    """Mass of the structure [kg]; deflection [m] and slope [rad] of the tip.

    At 1 g, at the upward limit load, and downwards in a landing of 2 g.
    """

    mass_kg: float
    deflections_m: tuple[float, float, float]
    slopes: tuple[float, float, float]


def hard_wing(b, ar, m, share, **limits):
    """Structure by hard maxima at 2000 stations, the loads integrated numerically.

    ``narrow_caps`` and ``web_core`` are those of the model; other ``limits`` hold the strain.
    """
    c, area, rho = b / ar, b * b / ar, 1.1
    v = airspeed(m, b, ar) * (rho / 1.225) ** 0.5
    slope = 2.0 * np.pi * ar / (ar + 2.0)
    mu = 2.0 * m / (rho * area * c * slope)
    gust = 0.88 * mu / (5.3 + mu) * 1.225 * slope * 15.25 * v / (2.0 * m * G / area)
    n_up = max(2.1 + 10900.0 / (m + 4536.0), 1.0 + gust)
    n_down = max(0.4 * (2.1 + 10900.0 / (m + 4536.0)), gust - 1.0)

    sheet = max(1.5e-3, 0.0015 * c)
    covering = 2.04 * area * 0.05
    rib_count = b / (0.2 * c)
    ribs = rib_count * 150.0 * sheet * 0.6 * 0.68 * 0.125 * c * c
    wedge = 0.5 * (0.05 * c) * (0.125 * c * 0.05 / 0.7)
    edges = 150.0 * b * (2.04 * 0.25 * c * sheet + wedge)
    relief = min(share * m + covering + ribs + edges, m)

    y = np.linspace(0.0, b / 2.0, 2001)
    lift = 4.0 * m * G / (np.pi * b) * np.sqrt(np.clip(1.0 - (2.0 * y / b) ** 2, 0.0, None))
    inertia = np.full_like(y, relief * G / b)

    def shear_and_moment(load):
        steps = np.diff(y) * (load[1:] + load[:-1]) / 2.0
        shear = np.append(np.cumsum(steps[::-1])[::-1], 0.0)
        turns = np.diff(y) * (shear[1:] + shear[:-1]) / 2.0
        return shear, np.append(np.cumsum(turns[::-1])[::-1], 0.0)

    shear, moment = shear_and_moment(lift - inertia)
    land_shear, land_moment = (2.0 * each for each in shear_and_moment(inertia))
    height = 0.9 * 0.125 * c
    cases = (n_up * moment, -n_down * moment, -land_moment)
    up = 1.5 * np.max(np.clip(cases, 0.0, None), axis=0) / height
    down = 1.5 * np.max(np.clip([-x for x in cases], 0.0, None), axis=0) / height
    width = 0.06 * c
    nu12, e1, e2, g12 = 0.3, 73e9, 8e9, 4e9
    nu21 = nu12 * e2 / e1
    d = np.array([e1, e2, nu12 * e2, 0.0]) / (12.0 * (1.0 - nu12 * nu21))
    plate = 2.0 * np.pi**2 * (np.sqrt(d[0] * d[1]) + d[2] + 2.0 * g12 / 12.0)
    # What the limits of stiffness hold, each as a strain of both caps.
    level = np.abs(moment) / height
    flight = np.max(np.abs(cases[:2]), axis=0) / height
    held = flight if limits.get("deflection_load_case") == "limit_load" else level
    strains = {
        "maximum_tip_deflection": lambda f: (2.0 * f * height / b, held),
        "maximum_tip_slope_deg": lambda f: (np.radians(f) * height / b, held),
        "maximum_landing_deflection": lambda f: (2.0 * f * height / b, land_moment / height),
    }
    caps, compliance = 0.0, np.zeros_like(y)
    for squeezed, stretched in ((up, down), (down, up)):
        needs = [
            squeezed / 368e6,
            (squeezed * width**4 / plate) ** (1.0 / 3.0)
            if not limits.get("narrow_caps")
            else np.zeros_like(y),
            stretched / 914e6,
            np.full_like(y, 0.25e-3 * width),
        ]
        for key, of in strains.items():
            if key in limits:
                strain, force = of(limits[key])
                needs.append(force / (73e9 * strain))
        area_m2 = np.max(needs, axis=0)
        caps = caps + 1600.0 * 2.0 * np.trapezoid(area_m2, y)
        compliance += 1.0 / height**2 / (73e9 * area_m2)
    q = 1.5 * np.maximum(n_up * np.abs(shear), land_shear)
    web_plate = 5.35 * np.pi**2 * 45e9 / (12.0 * (1.0 - 0.09))
    web = np.max(
        [
            q / (2.0 * height * 150e6),
            (q * height / (2.0 * web_plate)) ** (1.0 / 3.0)
            if "web_core" not in limits
            else np.zeros_like(y),
            np.full_like(y, 0.2e-3),
        ],
        axis=0,
    )
    web_kg_per_m2 = 1550.0 * web
    if "web_core" in limits:
        flow = q / (2.0 * height)
        # 1/N = 1/(k d^2) + 1/(G d) as a quadratic equation of d.
        stiff = 5.35 * np.pi**2 * 45e9 * web / (4.0 * 0.91) / height**2
        shear = flow / 19e6
        core = (shear + np.sqrt(shear**2 + 4.0 * flow / stiff)) / 2.0
        web_kg_per_m2 = web_kg_per_m2 + 52.0 * np.maximum(core, 2e-3) + 0.2
    webs = 2.0 * height * 2.0 * np.trapezoid(web_kg_per_m2, y)

    tails = (0.35 + 0.045) * c * area / (4.0 * c) * 0.35
    tail_n = 0.5 * 1.225 * (1.5 * v) ** 2 * 0.35 * c * area / (4.0 * c)
    boom_moment, diameter = 1.5 * tail_n * 4.0 * c, 0.1 * c
    section = np.pi * diameter**2 / 4.0
    wall = max(
        boom_moment / (section * 300e6),
        (boom_moment / (section * 0.3 * 45e9 * 2.0 / diameter)) ** 0.5,
        0.5e-3,
    )
    boom = 1550.0 * np.pi * diameter * wall * 4.0 * c
    pod = 0.08 * area * 0.4
    mass = 1.15 * (caps + webs + covering + ribs + edges + tails + boom + pod)
    # The tip moves by every bend times its distance from it.
    bends = [compliance * load for load in (moment, n_up * moment, land_moment)]
    return HardWing(
        float(mass),
        tuple(float(np.trapezoid(bend * (b / 2.0 - y), y)) for bend in bends),
        tuple(float(np.trapezoid(bend, y)) for bend in bends),
    )


STIFFNESS = [
    {},
    {"maximum_tip_deflection": 0.02},
    {"maximum_tip_deflection": 0.15, "deflection_load_case": "limit_load"},
    {"maximum_tip_slope_deg": 10.0, "deflection_load_case": "limit_load"},
    {"maximum_landing_deflection": 0.05},
    {"narrow_caps": True, "web_core": {}},
]


@pytest.mark.parametrize("limits", STIFFNESS, ids=str)
@settings(max_examples=60, deadline=None)
@given(span=spans, aspect=aspects, mass=masses, share=shares)
def test_mass_is_that_of_hard_maxima_on_a_fine_grid(limits, span, aspect, mass, share):
    mass_kg = structure_kg(span, aspect, mass, share, **limits)
    hard = hard_wing(span, aspect, mass, share, **limits).mass_kg
    # 3000 random designs were within -0.5 % (six stations instead of 2000) and +1 %; the spar alone
    # could be 2 % above for each maximum whose two sides are equal.
    assert 0.985 * hard <= mass_kg <= 1.04 * hard


@settings(max_examples=40, deadline=None)
@given(span=spans, aspect=aspects, mass=masses, share=shares, density=st.floats(0.1, 1.2))
def test_altitude_changes_the_gust_alone(span, aspect, mass, share, density):
    calm = RibWingStructure(model="rib_wing", cruise_gust_m_per_s=0.0, dive_gust_m_per_s=0.0)
    # Equal lift coefficient is equal equivalent airspeed, so without gusts altitude is no load.
    aloft, below = (
        calm.mass_kg(inputs(span, aspect, mass, share * mass, density=rho))
        for rho in (density, 1.225)
    )
    assert aloft == pytest.approx(below, rel=1e-9)


@settings(max_examples=40, deadline=None)
@given(span=spans, aspect=aspects, mass=masses, share=shares)
def test_parts_add_up_and_calibration_multiplies(span, aspect, mass, share):
    masses = parts(span, aspect, mass, share)
    assert all(part > 0.0 for part in masses)
    assert masses.total_kg == pytest.approx(sum(masses), rel=1e-12)
    doubled = structure_kg(span, aspect, mass, share, calibration=2.0)
    assert doubled == pytest.approx(2.0 * masses.total_kg, rel=1e-12)
    assert masses.joints == pytest.approx(0.15 * (masses.total_kg - masses.joints), rel=1e-9)


STIFF = RibWingStructure(
    model="rib_wing",
    maximum_tip_deflection=0.1,
    maximum_tip_slope_deg=10.0,
    deflection_load_case="limit_load",
    maximum_landing_deflection=0.1,
    torsion=WingTorsion(),
    spar_battery_density_kg_per_m3=2100.0,
    pod_battery_mount_fraction=0.05,
)


def symbolic_log_mass(kind, model=RIB_WING):
    """Logarithm of the mass over the logarithms of span, aspect ratio, mass, and span load."""
    x = kind.sym("x", 4)
    b, ar, m, load = (ca.exp(x[i]) for i in range(4))
    return x, ca.log(model.mass_kg(inputs(b, ar, m, load, battery=0.8 * load)))


def random_designs(count):
    rng = np.random.default_rng(5)
    low, high = np.log([1.0, 5.0, 0.3, 0.01]), np.log([40.0, 40.0, 400.0, 1.0])
    x = rng.uniform(low, high, (count, 4))
    x[:, 3] += x[:, 2]  # the span load is a share of the mass
    return x


@pytest.mark.parametrize("model", [RIB_WING, STIFF], ids=["strong", "stiff"])
def test_arrays_and_symbols_equal_floats(model):
    designs = random_designs(50)
    b, ar, m, load = np.exp(designs).T
    arrays = parts(b, ar, m, load / m, model).total_kg
    floats = [parts(*row[:3], row[3] / row[2], model).total_kg for row in np.exp(designs).tolist()]
    # One formula in three arithmetics: rounding of powers.
    np.testing.assert_allclose(arrays, floats, rtol=1e-12)
    for kind in (ca.SX, ca.MX):
        x, log_mass = symbolic_log_mass(kind, model)
        symbols = ca.Function("f", [x], [ca.exp(log_mass)])
        np.testing.assert_allclose(np.asarray(symbols(designs.T)).ravel(), floats, rtol=1e-11)


@pytest.mark.parametrize(("model", "bound"), [(RIB_WING, 100.0), (STIFF, 150.0)])
def test_no_kinks_in_the_design_space(model, bound):
    x, log_mass = symbolic_log_mass(ca.SX, model)
    hessian, gradient = ca.hessian(log_mass, x)
    derivatives = ca.Function("d", [x], [log_mass, gradient, hessian])
    for design in random_designs(600):
        value, first, second = (np.asarray(v) for v in derivatives(design))
        assert np.all(np.isfinite(value))
        assert np.all(np.isfinite(first))
        assert np.all(np.isfinite(second))
        # Elasticities of a wing: at most those of a spar in span.
        assert np.max(np.abs(first)) < 5.0
        # Where branches whose elasticities differ by e are equal, a smooth maximum turns from one
        # to the other with a second derivative of e^2/(4 blend) = 12.5 e^2 at most. Elasticities
        # differ by up to 4, half of the structure at most turns at once. What the nose lacks in
        # stiffness starts from nothing: there they differ by more. A kink has no bound.
        assert np.max(np.abs(second)) < bound


@pytest.mark.parametrize("span_m", [3.0, 8.0, 25.0])
@pytest.mark.parametrize(
    ("limits", "case"),
    [
        ({"maximum_tip_deflection": 0.01}, 0),
        ({"maximum_tip_deflection": 0.05, "deflection_load_case": "limit_load"}, 1),
        ({"maximum_landing_deflection": 0.04}, 2),
        ({"maximum_tip_slope_deg": 5.0, "deflection_load_case": "limit_load"}, 1),
    ],
)
def test_tip_bends_and_turns_no_more_than_allowed(limits, case, span_m):
    wing = (span_m, 22.0, 0.2 * span_m**2, 0.4)
    free, held = hard_wing(*wing), hard_wing(*wing, **limits)
    # The independent sum shares its sizing rule with the model (see above) and integrates the
    # curvature that follows; without a limit these wings bend further.
    if "maximum_tip_slope_deg" in limits:
        assert free.slopes[case] > np.radians(5.0) >= held.slopes[case] * (1.0 - 1e-6)
    else:
        allowed = next(iter(limits.values())) * span_m / 2.0
        assert free.deflections_m[case] > allowed >= held.deflections_m[case] * (1.0 - 1e-6)
    assert structure_kg(*wing, **limits) > structure_kg(*wing)


def test_gust_speeds_fall_with_altitude_as_the_code_lets_them():
    # CS 23.333 (c): 50 ft/s up to 20 000 ft, 25 ft/s at 50 000 ft, in feet.
    feet = np.array([0.0, 20_000.0, 35_000.0, 50_000.0, 65_000.0])
    # 0.3048 m to the foot against the metres rounded to 6096 and 15 240.
    np.testing.assert_allclose(
        50.0 * gust_speed_fraction(0.3048 * feet), [50.0, 50.0, 37.5, 25.0, 25.0], rtol=1e-9
    )
    falling = RibWingStructure(model="rib_wing", gusts_fall_with_altitude=True)
    flight = inputs(25.0, 22.0, 75.0, 30.0, density=0.116, gusts=0.5)
    halved = RibWingStructure(
        model="rib_wing", cruise_gust_m_per_s=15.25 / 2.0, dive_gust_m_per_s=7.6 / 2.0
    )
    assert falling.mass_kg(flight) == pytest.approx(halved.mass_kg(flight), rel=1e-12)
    assert falling.mass_kg(flight) < RIB_WING.mass_kg(flight)  # which does not look at it


@pytest.mark.parametrize(
    ("changes", "span_m", "share", "case"),
    [
        ({}, 5.65, 0.54, "landing"),
        ({"landing_load_factor": 0.0}, 3.2, 0.1, "an up-gust"),
        ({"landing_load_factor": 0.0, **NO_GUSTS}, 3.2, 0.1, "a pull-up"),
    ],
)
def test_governing_load_case_is_named(changes, span_m, share, case):
    mass_kg = 6.92 * (span_m / 5.65) ** 2
    flight = inputs(span_m, 18.5, mass_kg, share * mass_kg)
    model = RibWingStructure(model="rib_wing", **changes)
    assessment = assess(model, flight)
    assert assessment.spar_caps_case == case
    # The named one does govern: without it the caps are lighter, without another they are not.
    key = {"landing": "landing_load_factor", "an up-gust": "cruise_gust_m_per_s"}.get(case)
    if key is not None:
        eased = model.model_copy(update={key: 0.0})
        assert eased.breakdown(flight).spar_caps < model.breakdown(flight).spar_caps


@settings(max_examples=30, deadline=None)
@given(span=spans, aspect=aspects, mass=masses, share=st.floats(0.0, 0.5))
def test_reported_deflection_is_that_of_the_independent_sum(span, aspect, mass, share):
    assessment = assess(RIB_WING, inputs(span, aspect, mass, share * mass))
    hard = hard_wing(span, aspect, mass, share)
    # Six stations instead of 2000, and sections up to 6 % larger (three smooth maxima).
    half_span = span / 2.0
    level_m, limit_m, landing_m = hard.deflections_m
    assume(limit_m > 0.001 * span)
    assert assessment.tip_deflection_limit * half_span == pytest.approx(limit_m, rel=0.08)
    assert assessment.tip_deflection_1g * half_span == pytest.approx(level_m, rel=0.08)
    assert assessment.tip_deflection_landing * half_span == pytest.approx(landing_m, rel=0.08)
    # A wing that carries half of the mass bends up inside and down outside: near zero of both.
    slope_deg = np.degrees(hard.slopes[1])
    assert assessment.tip_slope_limit_deg == pytest.approx(slope_deg, rel=0.08, abs=0.05)
    assert assessment.tip_deflection_1g * assessment.limit_load_factor == pytest.approx(
        assessment.tip_deflection_limit
    )
    assert sum(assessment.spar_caps.values()) == pytest.approx(1.0)
    assert sum(assessment.spar_web.values()) == pytest.approx(1.0)


def test_battery_that_does_not_fit_the_spar_goes_to_the_pod():
    flight = inputs(3.0, 15.0, 11.0, 7.5, battery=7.5)
    model = RibWingStructure(model="rib_wing", spar_battery_density_kg_per_m3=2100.0)
    assessment = assess(model, flight)
    # The box of 0.06 by 0.9 x 0.125 chords, 3 m long, by hand.
    room_kg = 2100.0 * 0.06 * 0.9 * 0.125 * 0.2**2 * 3.0
    assert assessment.wing_battery_kg == pytest.approx(room_kg, rel=0.02)
    assert assessment.pod_battery_kg == pytest.approx(7.5 - room_kg, rel=0.02)
    held = model.mass_kg(flight._replace(span_load_kg=room_kg, wing_battery_kg=0.0))
    # As if the rest had been meant for the pod; without the rule the spar is relieved of it.
    assert model.mass_kg(flight) == pytest.approx(held, rel=0.005)
    assert model.mass_kg(flight) > 1.05 * RIB_WING.mass_kg(flight)
    mounted = model.model_copy(update={"pod_battery_mount_fraction": 0.05})
    gain = mounted.mass_kg(flight) - model.mass_kg(flight)
    assert gain == pytest.approx(1.15 * 0.05 * assessment.pod_battery_kg, rel=1e-9)


def test_rated_power_by_ratio_and_by_climb_rate():
    by_default, by_ratio = Propulsion(), Propulsion(climb_power_ratio=3.0)
    assert by_default.rated_power_w(40.0, weight_n=68.0) == 200.0
    assert by_ratio.rated_power_w(40.0, weight_n=68.0) == 120.0
    climbing = Propulsion(climb_rate_m_per_s=2.0, motor_efficiency=0.8, propeller_efficiency=0.8)
    efficiency = 0.97 * 0.8 * 0.96 * 0.8
    # Level flight plus the rate of potential energy through the same chain.
    rated_w = 40.0 + 2.0 * 68.0 / efficiency
    assert climbing.rated_power_w(40.0, weight_n=68.0) == pytest.approx(rated_w, rel=1e-12)
    with pytest.raises(ValidationError, match="give this or climb_power_ratio, not both"):
        Propulsion(climb_power_ratio=5.0, climb_rate_m_per_s=2.0)
    with pytest.raises(ValidationError):
        Propulsion(climb_rate_m_per_s=0.0)


def test_cap_of_orthotropic_material_buckles_by_the_inverse_of_its_compliance():
    along, across, shear, poisson = 120e9, 9e9, 5e9, 0.28
    compliance = [[1.0 / along, -poisson / along], [-poisson / along, 1.0 / across]]
    stiffness = np.linalg.inv(compliance) / 12.0  # of a plate of thickness one
    bending = np.sqrt(stiffness[0, 0] * stiffness[1, 1]) + stiffness[0, 1] + 2.0 * shear / 12.0
    cap = RibWingStructure(
        model="rib_wing",
        modulus_pa=along,
        transverse_modulus_pa=across,
        shear_modulus_pa=shear,
        poisson_ratio=poisson,
    )
    # The inverse of a matrix with entries that differ by 13 loses a digit.
    assert cap.cap_buckling_pa == pytest.approx(2.0 * np.pi**2 * bending, rel=1e-11)


def test_tubes_as_bought_weigh_what_they_do_whoever_builds():
    wing = StructureInputs(4.0, 16.0, 5.0, 2.0, 9.0, 1.1)
    length_m, diameter_m = 4.0 * 0.25, 0.1 * 0.25
    for keys, kg in (
        ({"boom_kg_per_m": 0.174}, 0.174 * length_m),
        ({"boom_thickness_m": 1e-3}, 1550.0 * np.pi * diameter_m * 1e-3 * length_m),
    ):
        for factors in ({}, {"calibration": 1.188, "build": "ordinary"}):
            model = RibWingStructure.model_validate({"model": "rib_wing", **keys, **factors})
            assert model.breakdown(wing).boom == pytest.approx(kg)


def test_a_core_of_foam_fills_the_section():
    """SEAWAY-Mini's core: 1.69 kg in 3.848 m and 1.499 m2, as it was weighed."""
    span_m, area_m2 = 3.848, 1.499
    flight = StructureInputs(span_m, span_m**2 / area_m2, 7.07, 1.0, 12.0, 1.2)
    keys = {"model": "rib_wing", "thickness_ratio": 0.093, "build": "ordinary"}  # AG34
    solid = RibWingStructure.model_validate(keys | {"core_density_kg_per_m3": 40.0})
    parts, built_up = solid.breakdown(flight), RibWingStructure.model_validate(keys)
    volume_m3 = 0.68 * 0.093 * (area_m2 / span_m) * area_m2
    assert parts.ribs == pytest.approx(40.0 * volume_m3)
    # Foam on sale has 30 to 45 kg/m3, and its density is not published.
    assert 30.0 < 1.69 / volume_m3 < 50.0
    assert parts.edges < built_up.breakdown(flight).edges
