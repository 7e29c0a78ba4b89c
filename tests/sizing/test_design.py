"""Mass closure, calibration against AtlantikSolar, and one physics in three arithmetics."""

import casadi as ca
import numpy as np
import pytest
from builders import AS2, DESIGN, SKY_SAILOR, aircraft, mission
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from missions.air import standard_air
from sizing.day.load import Load, thermal_shape
from sizing.day.metrics import Status
from sizing.design import DesignVariables, variables_of
from sizing.mass_budget import (
    ImpossibleDesignError,
    closed_design,
    constant_power_w,
    design_of,
    measured_design,
    parametric_design,
    with_total_mass,
)
from sizing.performance import performance_of_designs

AT_1_10 = mission(
    altitude_m=brentq(lambda height: float(standard_air(height).density_kg_per_m3) - 1.10, 0, 1e4)
)

spans = st.floats(2.0, 12.0)
aspects = st.floats(8.0, 30.0)
batteries = st.floats(0.2, 25.0)
shares = st.floats(0.05, 0.85)


def variables(span, aspect, battery, share):
    return DesignVariables(span, aspect, battery, share * span**2 / aspect)


def test_designs_at_their_files_points_are_the_built_aircraft():
    design = design_of(DESIGN, AT_1_10)
    # Published: 6.92 kg, which the file's remainder is fitted to; the last digit is 0.07 %, and
    # the fit was made in air of a slightly different viscosity.
    assert design.total_mass_kg == pytest.approx(6.92, rel=2e-3)
    # Published range of the structure's mass.
    assert 1.30 <= design.masses.structure <= 1.40
    # Measured to three digits; the profile drag is fitted to four: 1 % also covers the mass.
    assert design.propulsion_power_w == pytest.approx(35.8, rel=0.01)
    # Speed of least sink measured at 8.4 m/s; a lift coefficient of 1.0 is said to give 8.5.
    assert design.airspeed_m_per_s == pytest.approx(8.4, rel=0.02)
    assert design.battery_energy_wh == pytest.approx(732.0, abs=0.5)
    # 0.0011 kg/W at 180 W.
    assert design.masses.propulsion == pytest.approx(0.198, rel=0.01)
    assert design.constant_power_w == 6.0
    # Sky-Sailor was built with 2.44 kg, 1.06 kg of it battery. The method's airframe law is a
    # statistical fit that its author found good to some ten percent for his own aircraft.
    built = design_of(SKY_SAILOR, mission(altitude_m=500.0))
    assert built.total_mass_kg == pytest.approx(2.44, rel=0.10)
    # 2 W and 4.5 W behind a supply of 65 %.
    assert constant_power_w(SKY_SAILOR, 4.5) == pytest.approx(6.5 / 0.65, rel=1e-12)


@settings(max_examples=80, deadline=None)
@given(span=spans, aspect=aspects, battery=batteries, share=shares)
def test_mass_budget_adds_up(span, aspect, battery, share):
    for plane in (DESIGN, SKY_SAILOR):
        design = closed_design(plane, AT_1_10, variables(span, aspect, battery, share))
        total = float(design.total_mass_kg)
        assume(np.isfinite(total))
        # The iteration ends at 1e-13 relative; its last step is multiplied by 1/(1 - slope).
        assert float(design.masses.total_kg) == pytest.approx(total, rel=1e-10)
        assert float(sum(design.masses)) == pytest.approx(total, rel=1e-10)
        again = parametric_design(plane, AT_1_10, design.variables, total)
        assert float(again.masses.total_kg) == pytest.approx(total, rel=1e-10)
        assert all(float(m) >= 0.0 for m in design.masses)


@settings(max_examples=30, deadline=None)
@given(span=spans, aspect=aspects, battery=batteries, share=shares)
def test_closed_mass_is_the_lightest_solution(span, aspect, battery, share):
    chosen = variables(span, aspect, battery, share)
    total = float(closed_design(DESIGN, AT_1_10, chosen).total_mass_kg)
    assume(np.isfinite(total))
    assumed = np.linspace(battery, total * (1.0 - 1e-6), 200)
    arrays = DesignVariables(*(np.full(200, v) for v in chosen[:4]))
    budget = np.asarray(parametric_design(DESIGN, AT_1_10, arrays, assumed).masses.total_kg)
    # Every lighter assumed mass is less than what it entails.
    assert np.all(budget > assumed)


@pytest.mark.parametrize("plane", [DESIGN, SKY_SAILOR], ids=["spar", "power law"])
def test_symbols_equal_numbers(plane):
    x = ca.SX.sym("x", 5)

    def row(design):
        masses = list(design.masses)
        names = ("propulsion_power_w", "constant_power_w", "airspeed_m_per_s", "wing_area_m2")
        return [*masses, *(getattr(design, n) for n in (*names, "battery_energy_wh"))]

    symbolic = parametric_design(plane, AT_1_10, DesignVariables(*(x[i] for i in range(4))), x[4])
    function = ca.Function("f", [x], [ca.vertcat(*row(symbolic))])
    rng = np.random.default_rng(2)
    for _ in range(20):
        point = rng.uniform((2.0, 8.0, 0.2, 0.1, 1.0), (12.0, 30.0, 20.0, 4.0, 60.0))
        numeric = parametric_design(plane, AT_1_10, DesignVariables(*point[:4]), point[4])
        # One formula: rounding of powers.
        np.testing.assert_allclose(
            np.asarray(function(point)).ravel(), np.asarray(row(numeric), float), rtol=1e-12
        )


def test_aircraft_that_cannot_carry_itself_is_infinitely_heavy():
    loaded = mission(payload={"mass_kg": 500.0})
    # Small span, large aspect ratio, large battery and payload: the spar has no depth.
    chosen = DesignVariables(np.array([0.5, 5.65]), 40.0, np.array([25.0, 2.9]), 0.005)
    design = closed_design(DESIGN, loaded, chosen)
    assert np.isinf(design.total_mass_kg[0])
    flights = performance_of_designs(DESIGN, loaded, chosen)
    # 24 hours of the day: rounding of the sum over intervals.
    assert flights.cycle.excess_time_h[0, 0] == pytest.approx(-24.0, abs=1e-9)
    assert flights.cycle.status[0, 0] == Status.limited
    assert not np.isnan(flights.cycle.excess_time_h).any()


def test_near_the_limit_of_what_carries_itself_a_mass_is_right_or_infinite():
    payloads = np.linspace(0.0, 60.0, 121)
    totals = []
    for payload in payloads:
        loaded = mission(payload={"mass_kg": float(payload)})
        design = closed_design(DESIGN, loaded, DesignVariables(3.0, 30.0, 2.0, 0.2))
        total = float(design.total_mass_kg)
        totals.append(total)
        if np.isfinite(total):
            # The closure's promise.
            assert float(design.masses.total_kg) == pytest.approx(total, rel=1e-10)
    finite = np.isfinite(totals)
    # Heavier payloads never carry themselves where a lighter one does not.
    assert np.all(np.diff(finite.astype(int)) <= 0)
    assert np.all(np.diff(np.asarray(totals)[finite]) > 0.0)


@settings(max_examples=40)
@given(payload=st.floats(0.0, 5.0), altitude=st.floats(0.0, 15_000.0))
def test_measured_power_scales_with_mass_and_density(payload, altitude):
    payload_mission = mission(altitude_m=altitude, payload={"mass_kg": payload})
    design = measured_design(AS2, payload_mission)
    density = float(payload_mission.air_state().density_kg_per_m3)
    mass = 6.92 + payload
    # The law itself: rounding.
    assert design.total_mass_kg == pytest.approx(mass, rel=1e-12)
    power_w = 35.8 * (mass / 6.92) ** 1.5 * (density / 1.10) ** -0.5
    assert design.propulsion_power_w == pytest.approx(power_w, rel=1e-12)
    # At equal lift coefficient v^2 goes with m/rho.
    speed = 8.4 * np.sqrt(mass / 6.92 / (density / 1.10))
    assert design.airspeed_m_per_s == pytest.approx(speed, rel=1e-12)
    assert sum(design.masses) == pytest.approx(mass, rel=1e-12)


def test_measured_aircraft_without_airspeed_has_none_and_no_mass_budget_to_size():
    plane = aircraft("atlantiksolar-as2", "airframe.level_flight.airspeed_m_per_s=null")
    assert design_of(plane, AT_1_10).airspeed_m_per_s is None
    with pytest.raises(TypeError, match="measured aircraft"):
        parametric_design(AS2, AT_1_10, variables_of(AS2), 6.92)


@pytest.mark.parametrize("plane", [AS2, DESIGN, SKY_SAILOR], ids=lambda plane: plane.name)
def test_a_known_total_mass_is_met_and_the_rest_is_other_mass(plane):
    laden = mission(payload={"mass_kg": 0.3})
    heavier = 1.1 * float(design_of(plane, laden).total_mass_kg)
    design = design_of(with_total_mass(plane, laden, heavier), laden)
    assert design.total_mass_kg == pytest.approx(heavier, rel=1e-9)
    assert design.masses.total_kg == pytest.approx(heavier, rel=1e-9)
    assert design.masses.battery == plane.battery.mass_kg
    # Structure and motor carry the weight.
    assert design.propulsion_power_w > design_of(plane, laden).propulsion_power_w
    with pytest.raises(ImpossibleDesignError, match=r"more than the total mass of 0\.5 kg"):
        with_total_mass(plane, laden, 0.5)


def test_load_of_a_day_by_hand():
    rough = mission(turbulence={"all_day": 0.2, "thermal": 0.5})
    design = design_of(AS2, AT_1_10)
    load, hours = Load.of(AS2, rough, design), np.array([2.0, 6.0, 9.0, 12.0, 18.0])
    load_w = load.along(rough, hours, 6.0, 18.0)
    # 35.8 W with 20 %, and half of 50 % half-way up the morning; plus 6 W.
    expected = 35.8 * np.array([1.2, 1.2, 1.45, 1.7, 1.2]) + 6.0
    np.testing.assert_allclose(load_w, expected, rtol=1e-9)
    for nominal_w in (design.nominal_load_w(rough), load.without_thermals(rough)):
        assert nominal_w == pytest.approx(35.8 * 1.2 + 6.0, rel=1e-9)


@given(rise=st.floats(0.0, 11.9), time=st.floats(0.0, 24.0))
def test_thermals_are_a_triangle_over_the_lit_day(rise, time):
    shape = float(thermal_shape(np.asarray([time]), rise, 24.0 - rise)[0])
    assert 0.0 <= shape <= 1.0
    if time <= rise or time >= 24.0 - rise:
        # Nothing at night; rounding at sunrise and sunset.
        assert shape == pytest.approx(0.0, abs=1e-6)
    mirrored = float(thermal_shape(np.asarray([24.0 - time]), rise, 24.0 - rise)[0])
    assert mirrored == pytest.approx(shape, abs=1e-6)
    # In the polar night sunrise and sunset are both 12 h: no thermals, not even on noon.
    assert not np.any(thermal_shape(np.asarray([time, 12.0]), 12.0, 12.0))


def test_air_and_age_reach_the_capacity_and_the_heater_the_load():
    aged = aircraft(
        "atlantiksolar-as2",
        "battery.temperature={held_c: 10, heat_loss_w_per_k: 0.4}",
        "battery.ageing={seasons_flown: 1}",
    )
    cold = mission(
        air={"ambient_temperature_c": -5.0}, uncertainty_margins={"battery_capacity": 0.9}
    )
    plain, changed = design_of(AS2, cold), design_of(aged, cold)
    left = 0.88 * aged.battery.ageing.capacity_fraction()
    assert changed.battery_energy_wh == pytest.approx(left * plain.battery_energy_wh, rel=1e-12)
    assert changed.constant_power_w == pytest.approx(plain.constant_power_w + 0.4 * 15.0, rel=1e-12)
