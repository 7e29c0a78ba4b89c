"""Tests of stability and trim: vortices, moments and thin airfoils computed another way."""

import math

import numpy as np
import pytest

from sizing.balance.surfaces import (
    Tail,
    control_effectiveness,
    directional_stability,
    downwash_slope,
    elevator_deflection,
    lift_slope,
    neutral_point,
    trim,
    wing_of,
)

WING = wing_of(None, 5.65, 18.5)
TAIL = Tail(arm_m=1.22, horizontal_volume=0.35, vertical_volume=0.02, dynamic_pressure_ratio=0.95)
PLANES = TAIL.planes(WING)


def induced(start, end, at):
    """Velocity of a straight vortex of strength one by the law of Biot and Savart."""
    a, b, along = at - start, at - end, end - start
    cross = np.cross(a, b)
    cosines = np.dot(along, a / np.linalg.norm(a) - b / np.linalg.norm(b))
    return np.asarray(cross / np.dot(cross, cross) * cosines / (4.0 * math.pi))


@pytest.mark.parametrize(("aft_m", "height_m"), [(1.22, 0.0), (1.22, 0.3), (3.0, 0.1), (0.4, 0.2)])
def test_downwash_is_that_of_a_bound_vortex_with_two_tip_vortices(aft_m, height_m):
    half = math.pi / 4.0 * 5.65 / 2.0
    left, right = np.array([0.0, -half, 0.0]), np.array([0.0, half, 0.0])
    far = np.array([1e5, 0.0, 0.0])
    at = np.array([aft_m, 0.0, height_m])
    # Elliptic lift: the circulation in the middle is 2 b V C_L/(pi AR); airspeed one.
    circulation = 2.0 * 5.65 / (math.pi * 18.5) * lift_slope(18.5)
    lines = ((left + far, left), (left, right), (right, right + far))
    down = -circulation * sum(induced(*line, at)[2] for line in lines)
    assert downwash_slope(WING, aft_m, height_m) == pytest.approx(down, rel=1e-6)


def test_the_neutral_point_is_where_lift_makes_no_moment():
    neutral = neutral_point(WING, TAIL, PLANES, body_m3=0.004)
    wing_lift = lift_slope(18.5)
    tail_lift = (
        0.95 * PLANES.horizontal_m2 / WING.area_m2 * lift_slope(5.0) * (1.0 - neutral.downwash)
    )
    tail_at = WING.quarter_m + PLANES.arm_m
    # Nose up: the apparent mass of a slender body, 2 q volume per radian (NACA TR 184).
    body = 2.0 * 0.004 / WING.area_m2
    moment = wing_lift * (neutral.x_m - WING.quarter_m) + tail_lift * (neutral.x_m - tail_at) + body
    assert moment == pytest.approx(0.0, abs=1e-12)
    assert neutral.slope == pytest.approx(wing_lift + tail_lift)


@pytest.mark.parametrize("behind", [-0.02, 0.0, 0.05])
def test_trimmed_forces_and_moments_are_in_balance(behind):
    gravity = WING.quarter_m + behind
    level = trim(
        WING, TAIL, PLANES, lift=1.0, moment=-0.1, gravity_x_m=gravity, span_efficiency=0.9
    )
    tail = 0.95 * PLANES.horizontal_m2 / WING.area_m2 * level.tail_lift
    assert level.wing_lift + tail == pytest.approx(1.0)
    about_gravity = (
        level.wing_lift * behind + tail * (behind - PLANES.arm_m) - 0.1 * WING.aerodynamic_chord_m
    )
    assert about_gravity == pytest.approx(0.0, abs=1e-12)
    # Of two planes without gap no tail load is best (Laitone 1978): the drag is that of the load
    # squared, by the tail's span less by the wing's.
    spans = (5.65 / PLANES.horizontal_span_m) ** 2 / 0.95
    assert level.drag == pytest.approx(tail**2 * (spans - 1.0) / (math.pi * 0.9 * 18.5))
    assert level.drag >= 0.0


def test_effectiveness_of_a_flap_is_that_of_a_thin_airfoil():
    # Angle of zero lift of a camber line by Glauert's integral, with a flap of 30 % turned by one.
    angle = np.linspace(0.0, math.pi, 2_000_001)
    slope = np.where(0.5 * (1.0 - np.cos(angle)) > 0.7, -1.0, 0.0)
    zero_lift = -np.trapezoid(slope * (np.cos(angle) - 1.0), angle) / math.pi
    assert control_effectiveness(0.3) == pytest.approx(0.8 * abs(zero_lift), rel=1e-5)
    assert control_effectiveness(1.0) == 1.0


def test_a_stable_aircraft_flies_slower_with_the_elevator_up():
    neutral = neutral_point(WING, TAIL, PLANES, 0.0)
    for margin, sign in ((0.1, -1.0), (-0.1, 1.0)):
        gravity = neutral.x_m - margin * WING.aerodynamic_chord_m
        level, slow = (
            trim(WING, TAIL, PLANES, lift=lift, moment=-0.1, gravity_x_m=gravity,
                 span_efficiency=0.9)
            for lift in (1.0, 1.2)
        )  # fmt: skip
        deflection = elevator_deflection(TAIL, neutral, level, slow, 0.2)
        # d delta/d C_L = -margin/(eta V_h a_t tau): Etkin and Reid, eq. 2.4,13 at this balance,
        # where the wing's lift follows from the total.
        volume = PLANES.horizontal_m2 * PLANES.arm_m / (WING.area_m2 * WING.aerodynamic_chord_m)
        control = 0.95 * volume * neutral.tail_slope * control_effectiveness(0.3)
        assert deflection == pytest.approx(-0.2 * margin / control)
        assert math.copysign(1.0, deflection) == sign


def test_fins_steady_and_pods_unsteady():
    (plain, rudder), (with_pod, same) = (
        directional_stability(WING, TAIL, PLANES, gravity_x_m=0.1, body_m3=volume)
        for volume in (0.0, 0.01)
    )
    assert plain > with_pod
    assert plain - with_pod == pytest.approx(0.02 / (WING.area_m2 * 5.65))
    assert rudder == same > 0.0
