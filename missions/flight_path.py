"""Loiter paths in steady wind: the attitude of the aircraft along one closed orbit.

Paths are held over the ground at constant airspeed, by default the design's (:func:`at_airspeed`).
North-East-Down; angles in radians, in degrees in fields that end in ``_deg``. Yaw counts from
north, clockwise; roll is positive with the right wing down. Turns are coordinated, legs level.

Courses over the ground count from north, clockwise. Sources: Beard & McLain, Small Unmanned
Aircraft: Theory and Practice (2012), section 2.4 (wind triangle) and section 5.2 (coordinated
turn); DLMF, section 19.2 (elliptic integrals).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Annotated, Any, Literal, NamedTuple, TypeAlias

import numpy as np
from pydantic import Field, Strict, model_validator

from missions.air import GRAVITY_M_PER_S2
from solar.schema import NonNegativeReal, PositiveReal, Record, spell, wrong_value
from solar.types import FloatArray

MAXIMUM_BANK_DEG = 60.0

Direction: TypeAlias = Literal["clockwise", "counterclockwise", "both"]
Heading = Annotated[float, Strict(), Field(ge=0.0, le=360.0, allow_inf_nan=False)]
Pitch = Annotated[float, Strict(), Field(ge=-45.0, le=45.0, allow_inf_nan=False)]

_TAN_MAXIMUM_BANK = math.tan(math.radians(MAXIMUM_BANK_DEG))
_SIDES: dict[Direction, tuple[int, ...]] = {
    "clockwise": (1,),
    "counterclockwise": (-1,),
    "both": (1, -1),
}


# ---- Descriptions


class Wind(Record):
    """Steady horizontal wind, named by the direction it comes from.

    An easterly wind has ``from_deg`` 90 and blows towards west.
    """

    speed_m_per_s: NonNegativeReal
    from_deg: Heading


class Circle(Record):
    """Circle over the ground.

    ``both`` is the average over one orbit in each direction.
    """

    kind: Literal["circle"] = "circle"
    radius_m: PositiveReal
    airspeed_m_per_s: PositiveReal | None = None
    direction: Direction = "both"
    pitch_deg: Pitch = 0.0

    @model_validator(mode="after")
    def _check_bank(self) -> Circle:
        _check_calm_bank("radius_m", self.radius_m, self.airspeed_m_per_s)
        return self


class Racetrack(Record):
    """Two parallel legs over the ground, joined by half circles.

    ``heading_deg`` is the direction of the first leg over the ground; the second one leads back.
    ``leg_length_m`` is the length of the straight part.
    """

    kind: Literal["racetrack"] = "racetrack"
    leg_length_m: NonNegativeReal
    turn_radius_m: PositiveReal
    heading_deg: Heading
    airspeed_m_per_s: PositiveReal | None = None
    direction: Direction = "both"
    pitch_deg: Pitch = 0.0

    @model_validator(mode="after")
    def _check_bank(self) -> Racetrack:
        _check_calm_bank("turn_radius_m", self.turn_radius_m, self.airspeed_m_per_s)
        return self


class StraightLegs(Record):
    """Leg along ``heading_deg`` over the ground and back, without turns.

    Both legs are equally long, so the one against the wind takes longer. Their length sets
    positions and duration, never the attitude.
    """

    kind: Literal["straight_legs"] = "straight_legs"
    heading_deg: Heading
    airspeed_m_per_s: PositiveReal | None = None
    leg_length_m: PositiveReal = 1000.0
    pitch_deg: Pitch = 0.0


class Level(Record):
    """Horizontal flight without a heading, as CDM and CAM assume."""

    kind: Literal["level"] = "level"


FlightPath = Annotated[Circle | Racetrack | StraightLegs | Level, Field(discriminator="kind")]

_MovingPath: TypeAlias = Circle | Racetrack | StraightLegs


@dataclass(frozen=True)
class Orbit:
    """Attitude and motion along one closed orbit, at the middles of equal steps of time.

    For both turning directions the clockwise orbit comes first, the counterclockwise one follows;
    each counts its own time from zero, and they take equally long. Euler angles of the sequence
    3-2-1, yaw from 0 to 2 pi; position over the ground from the middle of the path. ``weights``:
    share of the time that each sample stands for. ``duration_s``: of one closed orbit.
    """

    time_s: FloatArray
    roll_rad: FloatArray
    pitch_rad: FloatArray
    yaw_rad: FloatArray
    north_m: FloatArray
    east_m: FloatArray
    ground_speed_m_per_s: FloatArray
    weights: FloatArray
    duration_s: float


def orbit(path: FlightPath, wind: Wind, *, samples: int = 72) -> Orbit:
    """Compute the attitude of the aircraft along one closed orbit in steady wind.

    Parameters
    ----------
    path : Circle, Racetrack, StraightLegs or Level
        Path to fly. A level path is a single sample at rest in the origin, heading north, in
        whatever wind.
    wind : Wind
        Wind at the flight altitude.
    samples : int
        Steps of time per orbit, hence twice as many samples for both turning directions. Shares of
        time spent on a straight leg are resolved to one step.

    Returns
    -------
    Orbit
        Samples that stand for equal times.

    Raises
    ------
    ValueError
        If the wind reaches the airspeed, the bank exceeds 60 degrees, or ``samples`` is below 1.

    Notes
    -----
    A circle starts downwind, any other path with its first leg. The body's pitch is constant, and
    the yaw is the heading of the velocity through the air (no sideslip).

    Source: Beard & McLain (2012), sections 2.4 and 5.2.
    """
    if samples < 1:
        raise ValueError(f"samples must be at least 1 (got {samples})")
    if isinstance(path, Level):
        zero = np.zeros(1)
        return Orbit(zero, zero, zero, zero, zero, zero, zero, weights=np.ones(1), duration_s=0.0)
    airspeed = _checked_airspeed_m_per_s(path, wind)
    motion = _Motion(airspeed, wind.speed_m_per_s, math.radians(wind.from_deg) + math.pi)
    sides = (1,) if isinstance(path, StraightLegs) else _SIDES[path.direction]
    pitch = math.radians(path.pitch_deg)
    laps = [_sample_orbit(_segments(path, motion, side), motion, pitch, samples) for side in sides]
    names = [field.name for field in fields(Orbit) if field.name != "duration_s"]
    joined = {name: np.concatenate([getattr(lap, name) for lap in laps]) for name in names}
    joined["weights"] = joined["weights"] / len(laps)
    return Orbit(**joined, duration_s=laps[0].duration_s)


def at_airspeed(path: FlightPath, airspeed_m_per_s: float) -> FlightPath:
    """Return the path at an airspeed [m/s], unless its file sets one."""
    if isinstance(path, Level) or path.airspeed_m_per_s is not None:
        return path
    return path.model_copy(update={"airspeed_m_per_s": airspeed_m_per_s})


def _airspeed_m_per_s(path: _MovingPath) -> float:
    if path.airspeed_m_per_s is None:
        raise ValueError("the flight path has no airspeed_m_per_s, and no design flies it")
    return path.airspeed_m_per_s


def largest_wind_m_per_s(path: FlightPath) -> float:
    """Return the wind speed [m/s], from any direction, that a path can just not be flown in.

    The wind must stay below the airspeed, and the bank, steepest downwind, at most 60 degrees.
    Infinite for a level path.
    """
    if isinstance(path, Level):
        return math.inf
    speed = _airspeed_m_per_s(path)
    if isinstance(path, StraightLegs):
        return speed
    return min(speed, math.sqrt(_radius_m(path) * GRAVITY_M_PER_S2 * _TAN_MAXIMUM_BANK) - speed)


# ---- Limits


def _radius_m(path: Circle | Racetrack) -> float:
    return path.radius_m if isinstance(path, Circle) else path.turn_radius_m


def _least_radius_m(ground_speed: float) -> float:
    """Return the radius [m] at which the bank reaches its limit, flying downwind."""
    return ground_speed**2 / (GRAVITY_M_PER_S2 * _TAN_MAXIMUM_BANK)


def _rounded_up(value: float) -> float:
    return math.ceil(value * 10.0) / 10.0


def _check_calm_bank(key: str, radius: float, airspeed: float | None) -> None:
    if airspeed is None:
        return
    least = _least_radius_m(airspeed)
    if radius < least:
        raise wrong_value(
            key,
            f"must be at least {_rounded_up(least)} m: at {spell(airspeed)} m/s a smaller turn "
            f"needs more than {spell(MAXIMUM_BANK_DEG)} deg of bank",
            got=radius,
        )


def path_trouble(path: FlightPath, wind: Wind) -> str | None:
    """Return the reason why a path cannot be flown in a wind, None if it can."""
    try:
        orbit(path, wind, samples=4)
    except ValueError as error:
        return str(error)
    return None


def _checked_airspeed_m_per_s(path: _MovingPath, wind: Wind) -> float:
    """Return the airspeed of a path; refuse too strong a wind and too tight turns in it."""
    # The mean velocity through the air of any closed orbit is minus the wind, so no path allows
    # more; below the airspeed, every course can be held.
    airspeed = _airspeed_m_per_s(path)
    if wind.speed_m_per_s >= airspeed:
        raise ValueError(
            f"the wind of {spell(wind.speed_m_per_s)} m/s is not below the airspeed of "
            f"{spell(airspeed)} m/s, so the aircraft cannot hold its position; on this "
            f"path the wind must stay below {spell(largest_wind_m_per_s(path), 4)} m/s"
        )
    if isinstance(path, StraightLegs):
        return airspeed
    # Each orbit turns through the downwind course.
    radius, fastest = _radius_m(path), airspeed + wind.speed_m_per_s
    if radius < _least_radius_m(fastest):
        bank = math.degrees(math.atan(fastest**2 / (GRAVITY_M_PER_S2 * radius)))
        raise ValueError(
            f"a turn of {spell(radius)} m radius at {spell(airspeed)} m/s in a wind of "
            f"{spell(wind.speed_m_per_s)} m/s needs {round(bank, 1)} deg of bank, more than "
            f"{spell(MAXIMUM_BANK_DEG)} deg; the radius must be at least "
            f"{_rounded_up(_least_radius_m(fastest))} m"
        )
    return airspeed


# ---- Motion over the ground at constant airspeed: legs, and coordinated turns


@dataclass(frozen=True)
class _Motion:
    """Wind triangle at constant airspeed: motion for a given course over the ground."""

    airspeed: float
    wind: float
    downwind: float  # course [rad]

    @property
    def margin(self) -> float:
        """Airspeed squared minus wind squared [m2/s2], exact also when they are close."""
        return (self.airspeed - self.wind) * (self.airspeed + self.wind)

    def headway(self, course: FloatArray) -> FloatArray:
        """Return the velocity through the air along the course [m/s]."""
        along = self.wind * np.cos(course - self.downwind)
        return np.asarray(np.sqrt(self.margin + along**2))

    def ground_speed(self, course: FloatArray) -> FloatArray:
        """Return the speed over the ground [m/s]."""
        along = self.wind * np.cos(course - self.downwind)
        total = self.headway(course) + np.abs(along)
        # Equal to headway + along in both cases, but free of cancellation against the wind.
        return np.where(along < 0.0, self.margin / total, total)

    def yaw(self, course: FloatArray) -> FloatArray:
        """Return the heading [rad], 0 to 2 pi: the course plus the crab angle into the wind."""
        across = -self.wind * np.sin(course - self.downwind)
        return np.mod(course - np.arcsin(across / self.airspeed), 2.0 * np.pi)

    def roll(self, course: FloatArray, curvature: FloatArray) -> FloatArray:
        """Return the bank of a coordinated turn [rad] for a track's curvature [1/m].

        The velocity through the air turns at ``V_g^2 / (R sqrt(V^2 - w_n^2))``: derivative of the
        heading with respect to the course, ``V_g / sqrt(V^2 - w_n^2)``, times ``V_g / R``.
        """
        yaw_rate = curvature * self.ground_speed(course) ** 2 / self.headway(course)
        return np.asarray(np.arctan(self.airspeed * yaw_rate / GRAVITY_M_PER_S2))

    def turn_clock(self, angle: FloatArray) -> FloatArray:
        """Return the time per radius to turn from downwind by an angle [s/m], odd in it.

        ``1 / V_g = (sqrt(V^2 - w^2 sin^2) - w cos) / (V^2 - w^2)`` integrates to the incomplete
        elliptic integral of the second kind (DLMF 19.2.5).
        """
        elliptic: Any = angle  # of calm air, to the last bit what the integral is then
        if self.wind != 0.0:
            from scipy.special import ellipeinc  # a tenth of a second

            elliptic = ellipeinc(angle, (self.wind / self.airspeed) ** 2)
        return np.asarray(
            (self.airspeed * elliptic - self.wind * np.sin(angle)) / self.margin, float
        )


class _Track(NamedTuple):
    """Ground track: course [rad], curvature [1/m], position [m]."""

    course: FloatArray
    curvature: FloatArray
    north: FloatArray
    east: FloatArray


class _Segment(NamedTuple):
    """Part of a path: its duration [s], and its track at times since its beginning [s]."""

    duration: float
    at: Callable[[FloatArray], _Track]


def _leg(motion: _Motion, course: float, length: float, right: float) -> _Segment:
    """Return a straight line over the ground, shifted to the right of the middle of the path."""
    speed = float(motion.ground_speed(np.asarray(course)))
    cos, sin = math.cos(course), math.sin(course)

    def at(elapsed: FloatArray) -> _Track:
        ahead = speed * elapsed - 0.5 * length
        return _Track(
            course=np.full_like(elapsed, course),
            curvature=np.zeros_like(elapsed),
            north=ahead * cos - right * sin,
            east=ahead * sin + right * cos,
        )

    return _Segment(length / speed, at)


def _turn(
    motion: _Motion,
    start_course: float,
    sweep: float,
    radius: float,
    side: int,
    centre: tuple[float, float] = (0.0, 0.0),
) -> _Segment:
    """Return an arc over the ground, to the right for ``side`` 1 and to the left for -1.

    ``centre``: north and east of the middle of the path [m].
    """
    # Angle since downwind, positive in the turning direction, and its time.
    first = side * (start_course - motion.downwind)
    angles = np.linspace(first, first + sweep, 65)
    clock = radius * motion.turn_clock(angles)

    def at(elapsed: FloatArray) -> _Track:
        """Invert the time of the turn by Newton's method, kept within one cell of the table."""
        target = clock[0] + elapsed
        cell = np.clip(np.searchsorted(clock, target, side="right"), 1, len(clock) - 1)
        low, high = angles[cell - 1], angles[cell]
        angle = np.asarray(np.interp(target, clock, angles), float)
        # Nearly always over after four steps; a wind just below the airspeed bends the time so
        # sharply that some steps are bisections.
        for _ in range(60):
            late = radius * motion.turn_clock(angle) - target
            low, high = np.where(late < 0.0, angle, low), np.where(late > 0.0, angle, high)
            speed = motion.ground_speed(motion.downwind + angle)
            newton = angle - late * speed / radius
            inside = (newton >= low) & (newton <= high)
            previous, angle = angle, np.where(inside, newton, 0.5 * (low + high))
            if np.all(np.abs(angle - previous) < 1e-13):
                break
        course = motion.downwind + side * angle
        return _Track(
            course=course,
            curvature=np.full_like(elapsed, side / radius),
            north=centre[0] + side * radius * np.sin(course),
            east=centre[1] - side * radius * np.cos(course),
        )

    return _Segment(float(clock[-1] - clock[0]), at)


def _segments(path: _MovingPath, motion: _Motion, side: int) -> list[_Segment]:
    if isinstance(path, Circle):
        return [_turn(motion, motion.downwind, 2.0 * math.pi, path.radius_m, side)]
    out = math.radians(path.heading_deg)
    if isinstance(path, StraightLegs):
        return [_leg(motion, course, path.leg_length_m, 0.0) for course in (out, out + math.pi)]
    length, radius, segments = path.leg_length_m, path.turn_radius_m, list[_Segment]()
    for course in (out, out + side * math.pi):  # a leg and the turn at its end, and their mirror
        segments.append(_leg(motion, course, length, -side * radius))
        end = 0.5 * length * math.cos(course), 0.5 * length * math.sin(course)
        segments.append(_turn(motion, course, math.pi, radius, side, end))
    return segments


def _sample_orbit(segments: list[_Segment], motion: _Motion, pitch: float, samples: int) -> Orbit:
    """Sample the closed sequence of segments at the middles of equal steps of time."""
    ends = np.cumsum([segment.duration for segment in segments])
    duration = float(ends[-1])
    time = np.asarray((np.arange(samples) + 0.5) * (duration / samples), float)
    parts = np.split(time, np.searchsorted(time, ends[:-1]))
    starts = np.concatenate(([0.0], ends[:-1]))
    tracks = [s.at(part - t0) for s, part, t0 in zip(segments, parts, starts, strict=True)]
    track = _Track(*map(np.concatenate, zip(*tracks, strict=True)))
    return Orbit(
        time_s=time,
        roll_rad=motion.roll(track.course, track.curvature),
        pitch_rad=np.full(samples, pitch),
        yaw_rad=motion.yaw(track.course),
        north_m=track.north,
        east_m=track.east,
        ground_speed_m_per_s=motion.ground_speed(track.course),
        weights=np.full(samples, 1.0 / samples),
        duration_s=duration,
    )
