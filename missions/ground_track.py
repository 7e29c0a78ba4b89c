"""Motion over the ground in steady wind at constant airspeed: legs, and coordinated turns.

Courses count from north, clockwise. Sources: Beard & McLain, Small Unmanned Aircraft: Theory and
Practice (2012), section 2.4 (wind triangle) and section 5.2 (coordinated turn); DLMF, section 19.2
(elliptic integrals).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from missions.air import GRAVITY_M_PER_S2
from solar.types import FloatArray


@dataclass(frozen=True)
class Motion:
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


class Track(NamedTuple):
    """Ground track: course [rad], curvature [1/m], position [m]."""

    course: FloatArray
    curvature: FloatArray
    north: FloatArray
    east: FloatArray


@dataclass(frozen=True)
class Leg:
    """Straight line over the ground, shifted to the right of the middle of the path."""

    motion: Motion
    course: float
    length: float
    right: float

    @cached_property
    def ground_speed(self) -> float:
        """Speed over the ground [m/s]."""
        return float(self.motion.ground_speed(np.asarray(self.course)))

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return self.length / self.ground_speed

    def at(self, elapsed: FloatArray) -> Track:
        """Return the track at times since its beginning [s]."""
        ahead = self.ground_speed * elapsed - 0.5 * self.length
        cos, sin = math.cos(self.course), math.sin(self.course)
        return Track(
            course=np.full_like(elapsed, self.course),
            curvature=np.zeros_like(elapsed),
            north=ahead * cos - self.right * sin,
            east=ahead * sin + self.right * cos,
        )


@dataclass(frozen=True)
class Turn:
    """Arc over the ground, to the right for ``side`` 1 and to the left for -1."""

    motion: Motion
    start_course: float
    sweep: float
    radius: float
    side: int
    centre_north: float = 0.0
    centre_east: float = 0.0

    @cached_property
    def table(self) -> tuple[FloatArray, FloatArray]:
        """Angle since downwind [rad], positive in the turning direction, and its time [s]."""
        first = self.side * (self.start_course - self.motion.downwind)
        angle = np.linspace(first, first + self.sweep, 65)
        return angle, self.radius * self.motion.turn_clock(angle)

    @property
    def duration(self) -> float:
        """Duration [s]."""
        _, clock = self.table
        return float(clock[-1] - clock[0])

    def at(self, elapsed: FloatArray) -> Track:
        """Return the track at times since its beginning [s]."""
        course = self.motion.downwind + self.side * self._angle(elapsed)
        return Track(
            course=course,
            curvature=np.full_like(elapsed, self.side / self.radius),
            north=self.centre_north + self.side * self.radius * np.sin(course),
            east=self.centre_east - self.side * self.radius * np.cos(course),
        )

    def _angle(self, elapsed: FloatArray) -> FloatArray:
        """Invert the time of the turn by Newton's method, kept within one cell of the table."""
        angles, clock = self.table
        target = clock[0] + elapsed
        cell = np.clip(np.searchsorted(clock, target, side="right"), 1, len(clock) - 1)
        low, high = angles[cell - 1], angles[cell]
        angle = np.asarray(np.interp(target, clock, angles), float)
        # Nearly always over after four steps; a wind just below the airspeed bends the time so
        # sharply that some steps are bisections.
        for _ in range(60):
            late = self.radius * self.motion.turn_clock(angle) - target
            low, high = np.where(late < 0.0, angle, low), np.where(late > 0.0, angle, high)
            speed = self.motion.ground_speed(self.motion.downwind + angle)
            newton = angle - late * speed / self.radius
            inside = (newton >= low) & (newton <= high)
            previous, angle = angle, np.where(inside, newton, 0.5 * (low + high))
            if np.all(np.abs(angle - previous) < 1e-13):
                break
        return angle
