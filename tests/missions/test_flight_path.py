"""Loiter paths in wind: the wind triangle, coordinated turns and limits."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError
from scipy.integrate import quad

from missions.air import GRAVITY_M_PER_S2
from missions.flight_path import (
    Circle,
    FlightPath,
    Level,
    Orbit,
    Racetrack,
    StraightLegs,
    Wind,
    largest_wind_m_per_s,
    orbit,
)
from solar.geometry import direction_cosines

TAN_60 = np.sqrt(3.0)
EASTERLY = Wind(speed_m_per_s=4.0, from_deg=90.0)
CALM = Wind(speed_m_per_s=0.0, from_deg=0.0)


PLAIN = {"airspeed_m_per_s": 10.0, "heading_deg": 40.0}


def circle(direction="clockwise", **changes):
    values = {"radius_m": 60.0, "airspeed_m_per_s": 10.0, **changes}
    return Circle(direction=direction, **values)


def racetrack(direction="clockwise", **changes):
    values = {"leg_length_m": 250.0, "turn_radius_m": 60.0, **PLAIN, **changes}
    return Racetrack(direction=direction, **values)


def legs(**changes):
    return StraightLegs(**(PLAIN | changes))


def wind_ned(wind):
    towards = np.radians(wind.from_deg + 180.0)
    return wind.speed_m_per_s * np.array([np.cos(towards), np.sin(towards)])


def headings(lap):
    """Unit vectors of the heading, north and east on the last axis."""
    return np.stack([np.cos(lap.yaw_rad), np.sin(lap.yaw_rad)], axis=-1)


def positions(lap):
    return np.stack([lap.north_m, lap.east_m], axis=-1)


def ground_velocities(lap):
    """Central differences of the positions, all round the closed orbit."""
    step = lap.duration_s / len(lap.time_s)
    place = positions(lap)
    return (np.roll(place, -1, axis=0) - np.roll(place, 1, axis=0)) / (2.0 * step)


def undisturbed(lap):
    """Samples between two others on the same leg or turn, and the largest angle between such."""
    banked = lap.roll_rad != 0.0
    step = np.abs(np.angle(np.exp(1j * (np.roll(lap.yaw_rad, -1) - lap.yaw_rad))))
    to_next = (banked == np.roll(banked, -1)) & (step < 0.5)  # straight legs turn round at once
    return to_next & np.roll(to_next, 1), float(np.max(step[to_next]))


@st.composite
def winds(draw, airspeed=10.0, share=0.8):
    """Wind up to a share of the airspeed, from anywhere."""
    return Wind(
        speed_m_per_s=airspeed * draw(st.floats(0.0, share)), from_deg=draw(st.floats(0.0, 360.0))
    )


@st.composite
def circles(draw, share=0.8):
    """Circle of one direction and a wind, with a bank up to the limit."""
    speed = draw(st.floats(5.0, 40.0))
    wind = draw(winds(speed, share))
    least = (speed + wind.speed_m_per_s) ** 2 / (GRAVITY_M_PER_S2 * TAN_60)
    radius = least * draw(st.floats(1.000001, 100.0))
    way = draw(st.sampled_from(["clockwise", "counterclockwise"]))
    return circle(way, radius_m=radius, airspeed_m_per_s=speed), wind


@st.composite
def paths(draw):
    """Any moving path with a wind that it allows."""
    ring, wind = draw(circles())
    common = {"airspeed_m_per_s": ring.airspeed_m_per_s, "heading_deg": draw(st.floats(0.0, 360.0))}
    length = ring.radius_m * draw(st.floats(0.1, 5.0))
    every = [
        ring,
        racetrack(ring.direction, turn_radius_m=ring.radius_m, leg_length_m=length, **common),
        legs(leg_length_m=length, **common),
    ]
    return draw(st.sampled_from(every)), wind


@given(circles(share=0.999))
def test_ground_track_is_the_circle(case):
    path, wind = case
    lap = orbit(path, wind)
    # Rounding.
    assert np.hypot(lap.north_m, lap.east_m) == pytest.approx(np.full(72, path.radius_m), rel=1e-14)


@given(circles())
def test_time_agrees_with_quadrature(case):
    path, wind = case
    towards = np.radians(wind.from_deg + 180.0)

    def slowness(turned):
        # Positive root of |V_g t - w| = V for V_g, from the companion matrix.
        along = wind.speed_m_per_s * np.cos(turned)
        squares = wind.speed_m_per_s**2 - path.airspeed_m_per_s**2
        return path.radius_m / float(np.max(np.roots([1.0, -2.0 * along, squares])))

    lap = orbit(path, wind, samples=7)
    side = 1.0 if path.direction == "clockwise" else -1.0
    course = np.arctan2(side * lap.north_m, -side * lap.east_m)  # from the place on the circle
    turned = np.mod(side * (course - towards), 2.0 * np.pi)
    # The quadrature is asked for 1e-11; the rest is rounding of the angle from the position.
    whole = 2.0 * quad(slowness, 0.0, np.pi, epsabs=0.0, epsrel=1e-11)[0]
    assert lap.duration_s == pytest.approx(whole, rel=1e-9)
    for time, angle in zip(lap.time_s, turned, strict=True):
        expected = quad(slowness, 0.0, float(angle), epsabs=0.0, epsrel=1e-11)[0]
        assert time == pytest.approx(expected, rel=1e-9)


@given(circles())
def test_bank_turns_the_yaw(case):
    path, wind = case
    lap = orbit(path, wind, samples=7200)
    step = lap.duration_s / 7200
    yaw = np.unwrap(lap.yaw_rad)
    rate = (yaw[2:] - yaw[:-2]) / (2.0 * step)
    expected = GRAVITY_M_PER_S2 * np.tan(lap.roll_rad[1:-1]) / path.airspeed_m_per_s
    # Second-order differences, relative to the greatest rate: the yaw turns by up to 0.005 rad in
    # a step, whose square over 6 is 4e-6; the rate bends faster than the yaw where it changes.
    assert np.max(np.abs(rate - expected)) < 1e-4 * np.max(np.abs(expected))


@pytest.mark.parametrize("wind_share", [0.99, 0.9999, 1.0 - 1e-9])
def test_circle_in_wind_of_almost_the_airspeed(wind_share):
    wind = Wind(speed_m_per_s=10.0 * wind_share, from_deg=20.0)
    lap = orbit(circle(), wind, samples=72)
    assert np.all(lap.ground_speed_m_per_s > 0.0)
    # From downwind once round, forwards all the way.
    course = np.unwrap(np.arctan2(lap.north_m, -lap.east_m))
    assert np.all(np.diff(course) > 0.0)
    assert course[-1] - course[0] < 2.0 * np.pi
    # Nearly all the time goes into flying upwind: w / V on average, where the downwind part of the
    # orbit, with the heading off by up to 2, is shorter than a step of time.
    upwind = -wind_ned(wind) / wind.speed_m_per_s
    assert lap.weights @ headings(lap) @ upwind == pytest.approx(wind_share, abs=2.0 / 72)


@given(paths())
def test_airspeed_is_held(case):
    path, wind = case
    lap = orbit(path, wind, samples=7200)
    ground = ground_velocities(lap)
    air = ground - wind_ned(wind)
    away, turn_step = undisturbed(lap)
    assert np.mean(away) > 0.99
    # Second-order differences: an error of (step of time)^2 / 6 times the third derivative of the
    # position, which is below 3 V_g^3 / R^2 here, hence below half the square of the angle turned
    # in a step. Straight legs leave rounding.
    accuracy = (turn_step**2 + 1e-9) * np.max(lap.ground_speed_m_per_s)
    assert np.max(np.abs(np.linalg.norm(air, axis=1) - path.airspeed_m_per_s)[away]) < accuracy
    assert np.max(np.abs(air - path.airspeed_m_per_s * headings(lap))[away]) < accuracy
    ground_speed = np.linalg.norm(ground, axis=1)
    assert np.max(np.abs(ground_speed - lap.ground_speed_m_per_s)[away]) < accuracy


@pytest.mark.parametrize("make", [circle, racetrack])
def test_both_directions_follow_each_other(make):
    both = orbit(make("both", pitch_deg=3.0), EASTERLY)
    laps = [orbit(make(way, pitch_deg=3.0), EASTERLY) for way in ("clockwise", "counterclockwise")]
    # A racetrack turns through the same courses either way; the order of the sums differs.
    assert laps[0].duration_s == pytest.approx(laps[1].duration_s, rel=1e-13)
    assert both.duration_s == laps[0].duration_s
    for field in dataclasses.fields(Orbit):
        if field.name not in ("duration_s", "weights"):
            joined = np.concatenate([getattr(lap, field.name) for lap in laps])
            assert np.array_equal(getattr(both, field.name), joined), field.name
    assert both.weights == pytest.approx(np.full(144, 1.0 / 144.0))
    assert circle().direction == "clockwise"
    assert Circle(radius_m=60.0, airspeed_m_per_s=10.0).direction == "both"


@given(paths(), st.integers(1, 100))
def test_orbit_is_well_formed(case, samples):
    path, wind = case
    lap = orbit(path, wind, samples=samples)
    for field in dataclasses.fields(Orbit):
        values = getattr(lap, field.name)
        assert np.all(np.isfinite(values))
        assert field.name == "duration_s" or values.shape == (samples,)
    assert lap.weights == pytest.approx(np.full(samples, 1.0 / samples))
    assert np.sum(lap.weights) == pytest.approx(1.0)
    steps = np.diff(lap.time_s, prepend=-lap.time_s[0])
    assert steps == pytest.approx(np.full(samples, lap.duration_s / samples))
    assert np.all((lap.yaw_rad >= 0.0) & (lap.yaw_rad <= 2.0 * np.pi))
    assert np.all(np.abs(np.degrees(lap.roll_rad)) <= 60.0)
    slowest = path.airspeed_m_per_s - wind.speed_m_per_s
    # Rounding.
    assert np.all(lap.ground_speed_m_per_s >= slowest * (1.0 - 1e-12))


@pytest.mark.parametrize(("direction", "side"), [("clockwise", 1.0), ("counterclockwise", -1.0)])
def test_racetrack_lies_on_its_stadium(direction, side):
    lap = orbit(racetrack(direction), EASTERLY, samples=500)
    towards = np.radians(40.0)
    ahead = positions(lap) @ [np.cos(towards), np.sin(towards)]
    right = positions(lap) @ [-np.sin(towards), np.cos(towards)]
    beyond = np.maximum(np.abs(ahead) - 125.0, 0.0)
    # Rounding.
    assert np.hypot(beyond, right) == pytest.approx(np.full(500, 60.0), rel=1e-12)
    straight = np.abs(ahead) < 125.0
    assert np.all(lap.roll_rad[straight] == 0.0)
    assert np.all(side * lap.roll_rad[~straight] > 0.0)
    jumps = np.linalg.norm(positions(lap) - np.roll(positions(lap), 1, axis=0), axis=1)
    # No step is longer than the fastest ground speed allows.
    assert np.max(jumps) <= 14.0 * lap.duration_s / 500
    # The first leg leads along the heading, on the left of a clockwise racetrack.
    assert right[0] == pytest.approx(-60.0 * side)
    assert ahead[1] > ahead[0]


def test_straight_legs_along_the_wind():
    lap = orbit(legs(heading_deg=90.0, leg_length_m=840.0), EASTERLY, samples=1000)
    # Upwind at 10 - 4 m/s, downwind at 10 + 4 m/s, without crab angle.
    assert lap.duration_s == pytest.approx(840.0 / 6.0 + 840.0 / 14.0)
    upwind = lap.ground_speed_m_per_s < 10.0
    assert np.sum(lap.weights[upwind]) == pytest.approx(0.7, abs=1e-3)
    assert lap.yaw_rad[upwind] == pytest.approx(np.full(upwind.sum(), np.pi / 2.0))
    assert lap.yaw_rad[~upwind] == pytest.approx(np.full((~upwind).sum(), 1.5 * np.pi))
    assert np.all(lap.roll_rad == 0.0)


def test_level_aircraft_is_horizontal_in_any_wind():
    lap = orbit(Level(), Wind(speed_m_per_s=50.0, from_deg=10.0))
    assert lap.weights.tolist() == [1.0]
    matrix = direction_cosines(lap.roll_rad, lap.pitch_rad, lap.yaw_rad)
    assert np.array_equal(matrix, np.eye(3)[None])
    assert largest_wind_m_per_s(Level()) == np.inf


@pytest.mark.parametrize(
    ("path", "wind", "message"),
    [
        *(
            (path, speed, f"wind of {speed:g} m/s .* airspeed of 10 m/s.* below {limit} m/s")
            for path, limit in (
                (circle(), 10),
                (circle("both"), 10),
                (racetrack(), 10),
                (legs(), 10),
            )
            for speed in (10.0, 12.5)
        ),
        # (10 + 3)^2 / (g 7) is the tangent of 67.9 degrees; (10 + 3)^2 / (g tan 60) is 9.95 m.
        (circle(radius_m=7.0), 3.0, "7 m radius at 10 m/s in a wind of 3 m/s needs 67.9 deg of ba"),
        (circle(radius_m=7.0), 3.0, r"at least 10\.0 m"),
        (racetrack(turn_radius_m=7.0), 3.0, r"at least 10\.0 m"),
    ],
)
def test_winds_in_which_no_path_is_flown_are_refused(path, wind, message):
    with pytest.raises(ValueError, match=message):
        orbit(path, Wind(speed_m_per_s=wind, from_deg=0.0))
    with pytest.raises(ValueError, match=r"samples must be at least 1 \(got 0\)"):
        orbit(path, CALM, samples=0)


@pytest.mark.parametrize("path", [circle(), circle(radius_m=8.0), racetrack(), legs()])
def test_largest_wind_is_the_limit(path):
    limit = largest_wind_m_per_s(path)
    orbit(path, Wind(speed_m_per_s=limit * 0.999, from_deg=77.0))
    with pytest.raises(ValueError, match=r"must stay below|radius must be at least"):
        orbit(path, Wind(speed_m_per_s=limit * 1.001, from_deg=77.0))


@pytest.mark.parametrize(
    "make", [lambda r: circle(radius_m=r), lambda r: racetrack(turn_radius_m=r)]
)
def test_turn_too_tight_even_in_calm_air_is_refused(make):
    # 10^2 / (g tan 60) is 5.89 m.
    with pytest.raises(ValidationError, match=r"at least 5\.9 m: at 10 m/s .* \(got 5\)"):
        make(5.0)
    make(5.9)


CIRCLE = {"kind": "circle", "radius_m": 60.0, "airspeed_m_per_s": 10.0}
LEGS = {"kind": "straight_legs", "heading_deg": 360.0, "airspeed_m_per_s": 10.0}
RACETRACK = LEGS | {"kind": "racetrack", "leg_length_m": 100.0, "turn_radius_m": 60.0}


@pytest.mark.parametrize(
    ("values", "expected"),
    [(CIRCLE, Circle), (RACETRACK, Racetrack), (LEGS, StraightLegs), ({"kind": "level"}, Level)],
)
def test_kind_selects_the_path(values, expected):
    assert type(TypeAdapter[Any](FlightPath).validate_python(values)) is expected


@pytest.mark.parametrize("path", [circle(), racetrack(), legs()])
def test_a_path_is_flown_level_unless_its_pitch_is_given(path):
    assert orbit(path, CALM).pitch_rad == pytest.approx(0.0, abs=1e-15)
    pitched = path.model_copy(update={"pitch_deg": 4.0})
    assert orbit(pitched, CALM).pitch_rad == pytest.approx(np.radians(4.0), rel=1e-12)
