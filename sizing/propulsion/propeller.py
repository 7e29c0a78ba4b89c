"""Coefficients of thrust and power of propellers: as tables, or by diameter, pitch and blades.

Everywhere ``J = V / (n D)``, ``C_T = T / (rho n^2 D^4)`` and ``C_P = P / (rho n^3 D^5)``, with the
speed of rotation ``n`` in revolutions per second, so that the efficiency is ``J C_T / C_P``.

Propellers without a table have blade elements and momentum in the form of Drela's QPROP (Drela, M.
(2006), QPROP Formulation, MIT Aero & Astro): the velocity at a blade station is a function of one
angle, in which the circulation by momentum equals that by the section's lift at one bracketed root.
The method holds at rest, in flight, and where the propeller brakes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from missions.air import Air
from sizing.roots import bracketed_root
from solar.schema import Allowed, refusal
from solar.types import FloatArray

Indices = slice | int | tuple[slice | None, ...] | NDArray[np.integer[Any]]

# Rounding of an advance ratio that lies on the edge of a table.
_EDGE = 1e-9


class Coefficients(NamedTuple):
    """Coefficients of thrust and power [-]; NaN where the propeller's data end."""

    thrust: FloatArray
    power: FloatArray


def tip_mach(
    airspeed_m_per_s: ArrayLike, rotation_per_s: ArrayLike, diameter_m: float, air: Air
) -> FloatArray:
    """Return the Mach number of the blade tips, ``sqrt(V^2 + (pi n D)^2) / sqrt(1.4 R T)`` [-]."""
    tip = np.pi * np.asarray(rotation_per_s, float) * diameter_m
    speed = np.hypot(np.asarray(airspeed_m_per_s, float), tip)
    return np.asarray(speed / air.speed_of_sound_m_per_s)


@dataclass(frozen=True, eq=False)
class SpeedCurve:
    """J, C_T and C_P [-] at one speed of rotation [rpm] (NaN if a table names none), J rising."""

    speed_rpm: float
    advance_ratio: FloatArray
    thrust: FloatArray
    power: FloatArray


@dataclass(frozen=True, eq=False)
class PropellerTable:
    """Propeller by measured or published coefficients.

    Linear in the advance ratio, and between two speeds of rotation in the speed. Nothing is
    extrapolated: outside, the coefficients are NaN.

    Attributes
    ----------
    diameter_m : float
        Diameter [m].
    curves : tuple of SpeedCurve
        By rising speed of rotation.
    source : str
        Files that it was read from.
    any_speed : bool
        Beyond the slowest and the fastest curve these two are used, at any speed of rotation. On
        request only: the Reynolds number changes both coefficients.
    notes : tuple of str
        What was left out of the files.
    """

    diameter_m: float
    curves: tuple[SpeedCurve, ...]
    source: str
    any_speed: bool = False
    notes: tuple[str, ...] = ()
    # Speeds of rotation to try before the search for the one of a thrust: the curves end at
    # different advance ratios, so that many may fall outside the data.
    trials: ClassVar[int] = 97

    def coefficients(
        self, airspeed_m_per_s: ArrayLike, rotation_per_s: ArrayLike, air: Air | None = None
    ) -> Coefficients:
        """Return the coefficients of thrust and power.

        Parameters
        ----------
        airspeed_m_per_s, rotation_per_s : array_like
            True airspeed [m/s] and speed of rotation [1/s].
        air : Air, optional
            Plays no part: the table is of the air that it was measured in.

        Returns
        -------
        Coefficients
            Of the broadcast shape of the arguments; NaN outside the table.
        """
        v, n = np.broadcast_arrays(
            np.asarray(airspeed_m_per_s, float), np.asarray(rotation_per_s, float)
        )
        advance = v / (n * self.diameter_m)
        speeds = np.array([curve.speed_rpm for curve in self.curves])
        if len(speeds) == 1:
            place, weight = np.zeros(v.shape, int), np.zeros(v.shape)
        else:
            rpm = 60.0 * n
            place = np.clip(np.searchsorted(speeds, rpm, side="right") - 1, 0, len(speeds) - 2)
            weight = (rpm - speeds[place]) / (speeds[place + 1] - speeds[place])
            beyond = (weight < -_EDGE) | (weight > 1.0 + _EDGE)
            weight = np.clip(weight, 0.0, 1.0)
            weight = weight if self.any_speed else np.where(beyond, np.nan, weight)
        upper = np.minimum(place + 1, len(speeds) - 1)

        def mean_of(name: str) -> FloatArray:
            """Return the weighted mean of two curves; a curve of weight 0 may end earlier."""
            curves = []
            for curve in self.curves:
                known = curve.advance_ratio
                near = np.where(np.abs(advance - known[0]) < _EDGE, known[0], advance)
                near = np.where(np.abs(near - known[-1]) < _EDGE, known[-1], near)
                values = getattr(curve, name)
                curves.append(np.interp(near, known, values, left=np.nan, right=np.nan))
            low, high = (
                np.take_along_axis(np.array(curves), number[np.newaxis], axis=0)[0]
                for number in (place, upper)
            )
            mean = (1.0 - weight) * low + weight * high
            return np.asarray(np.where(weight == 0.0, low, np.where(weight == 1.0, high, mean)))

        return Coefficients(*map(mean_of, Coefficients._fields))

    def limits(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the ranges of advance ratio [-] and speed of rotation [1/s] of the data."""
        advance = (
            min(float(curve.advance_ratio[0]) for curve in self.curves),
            max(float(curve.advance_ratio[-1]) for curve in self.curves),
        )
        if self.any_speed:
            return advance, (0.0, np.inf)
        return advance, (self.curves[0].speed_rpm / 60.0, self.curves[-1].speed_rpm / 60.0)

    def at(self, indices: Indices, shape: tuple[int, ...] | None = None) -> PropellerTable:
        """Return this propeller, the same at all points.

        Parameters
        ----------
        indices : Indices
            Points in line.
        shape : tuple of int, optional
            Shape of all points.

        Returns
        -------
        PropellerTable
        """
        return self


# ---- Blade elements

# Chord over radius at r/R of 0.15 to 1 in steps of 0.05, as measured: UIUC Propeller Database
# (Brandt & Selig et al.), the mean of APC Thin Electric 9x6, 11x5.5 and 11x8, and of APC Slow Flyer
# 10x4.7 and 10x7.
_STATIONS = np.linspace(0.15, 1.0, 18)
# fmt: off
_CHORDS = {
    "thin_electric": (
        0.131, 0.146, 0.171, 0.188, 0.198, 0.201, 0.200, 0.195, 0.187,
        0.175, 0.162, 0.147, 0.131, 0.115, 0.099, 0.084, 0.062, 0.040,
    ),
    "slow_flyer": (
        0.109, 0.132, 0.156, 0.176, 0.193, 0.206, 0.216, 0.223, 0.226,
        0.225, 0.219, 0.210, 0.197, 0.180, 0.158, 0.132, 0.090, 0.046,
    ),
}
# fmt: on
# Section of a propeller of 6 inches in the example of the QPROP User Guide (Drela, 2007).
_LIFT_AT_ZERO, _LIFT_SLOPE = 0.5, 5.8
_LEAST_LIFT, _GREATEST_LIFT = -0.3, 1.2
_LEAST_DRAG, _LIFT_OF_LEAST_DRAG = 0.028, 0.5
_DRAG_ABOVE, _DRAG_BELOW = 0.050, 0.020
_REYNOLDS, _REYNOLDS_EXPONENT = 70_000.0, -0.7
# The exponent is that of laminar flow with separation bubbles; drag is constant above this range.
_LARGEST_REYNOLDS, _SMALLEST_REYNOLDS = 300_000.0, 2_000.0
# Drag coefficient of a plate across the flow.
_PLATE_DRAG = 2.0

_ANGLE_TOLERANCE = 1e-11  # relative, near rounding
_HUB = 0.1  # over the radius; assumption
_ELEMENTS = 24  # error of thrust and power 0.04 %
# Every propeller of this section brakes above an advance ratio of 1.3 pitch/diameter + 0.3.
_LARGEST_ADVANCE_OVER_PITCH, _ADVANCE_BEYOND_PITCH = 1.3, 0.3


def section_coefficients(
    angle_rad: ArrayLike, reynolds: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return lift and drag coefficients of the blade section.

    ``c_l = 0.5 + 5.8 alpha`` from -0.3 to 1.2, beyond them the limit times the cosine of the
    excess of the angle; ``c_d = (0.028 + k (c_l - 0.5)^2) (Re / 70000)^-0.7``, with k 0.050 above
    and 0.020 below 0.5; beyond the limits of lift, ``2 sin^2`` of the excess is added. Above a
    Reynolds number of 300 000 drag is constant. ``angle_rad``: between chord and flow.
    """
    lift, excess = _lift_and_excess(np.asarray(angle_rad, float))
    off = lift - _LIFT_OF_LEAST_DRAG
    bounded = np.clip(reynolds, _SMALLEST_REYNOLDS, _LARGEST_REYNOLDS)
    factor = (bounded / _REYNOLDS) ** _REYNOLDS_EXPONENT
    drag = (_LEAST_DRAG + np.where(off > 0.0, _DRAG_ABOVE, _DRAG_BELOW) * off**2) * factor
    return np.asarray(lift), np.asarray(drag + _PLATE_DRAG * np.sin(excess) ** 2)


def _lift_and_excess(angle: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the lift coefficient of the blade section, and the angle beyond its limits [rad]."""
    upper = (_GREATEST_LIFT - _LIFT_AT_ZERO) / _LIFT_SLOPE
    lower = (_LEAST_LIFT - _LIFT_AT_ZERO) / _LIFT_SLOPE
    excess = angle - np.clip(angle, lower, upper)
    return (_LIFT_AT_ZERO + _LIFT_SLOPE * (angle - excess)) * np.cos(excess), excess


class _Flow(NamedTuple):
    """Flow at blade stations: velocities [m/s], circulation by momentum [m2/s], angle [rad]."""

    axial: FloatArray
    tangential: FloatArray
    speed: FloatArray
    circulation: FloatArray
    angle: FloatArray


@dataclass(frozen=True)
class BladeElementPropeller:
    """Propeller by its diameter, pitch and number of blades.

    The blades have the chords of a family of model propellers, scaled with the diameter, Drela's
    section, and the twist of the pitch, ``atan(pitch / (2 pi r))``, from a tenth of the radius to
    the tip. Compressibility is not modelled.

    Attributes
    ----------
    diameter_m, pitch_m : float or ndarray
        Diameter and geometric pitch [m]; arrays have the shape of the operating points.
    blades : int
        Number of blades.
    chords : {"thin_electric", "slow_flyer"}
        Family of model propellers whose chords the blades have.

    Raises
    ------
    ValueError
        For a diameter or pitch that is not above 0 and at most 100, fewer than 2 blades or an
        unknown family.
    """

    diameter_m: Any
    pitch_m: Any
    blades: int = 2
    chords: Literal["thin_electric", "slow_flyer"] = "thin_electric"
    # There is no limit of the speed of rotation, and thrust rises with it.
    trials: ClassVar[int] = 9

    def __post_init__(self) -> None:
        """Check diameter, pitch, number of blades and family of chords."""
        for name in ("diameter_m", "pitch_m"):
            Allowed(0.0, 100.0, above=True).check(name, getattr(self, name))
        if self.blades != int(self.blades) or not 2 <= self.blades <= 12:
            raise ValueError(refusal("blades must be a whole number from 2 to 12", self.blades))
        if self.chords not in _CHORDS:
            raise ValueError(refusal(f"chords must be one of {', '.join(_CHORDS)}", self.chords))

    def limits(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the ranges of advance ratio [-] and speed of rotation [1/s] of the model."""
        ratio = self.pitch_m / self.diameter_m
        return (0.0, _LARGEST_ADVANCE_OVER_PITCH * ratio + _ADVANCE_BEYOND_PITCH), (0.0, np.inf)

    def at(self, indices: Indices, shape: tuple[int, ...] | None = None) -> BladeElementPropeller:
        """Return the propellers at indices of a shape's points in line; a single one unchanged.

        Parameters
        ----------
        indices : Indices
            Points in line.
        shape : tuple of int, optional
            Shape of all points; that of the propellers by default.

        Returns
        -------
        BladeElementPropeller
        """
        sizes = np.broadcast_arrays(self.diameter_m, self.pitch_m)
        if not sizes[0].ndim:
            return self
        if shape is not None:
            sizes = tuple(np.broadcast_to(size, shape).ravel() for size in sizes)
        return replace(self, diameter_m=sizes[0][indices], pitch_m=sizes[1][indices])

    @property
    def _diameter_m(self) -> FloatArray:
        """Diameter with an axis for the stations [m]."""
        return np.asarray(self.diameter_m)[..., np.newaxis]

    @cached_property
    def _blade(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Station r/R [-], element width [m], chord [m] and twist [rad], denser at the tip."""
        edges = _HUB + (1.0 - _HUB) * np.sin(np.linspace(0.0, np.pi / 2, _ELEMENTS + 1))
        place = (edges[1:] + edges[:-1]) / 2.0
        radius = self._diameter_m / 2.0
        chord = np.interp(place, _STATIONS, _CHORDS[self.chords]) * radius
        pitch_m = np.asarray(self.pitch_m)[..., np.newaxis]
        twist = np.arctan(pitch_m / (np.pi * self._diameter_m * place))
        return place, np.diff(edges) * radius, chord, twist

    def coefficients(
        self, airspeed_m_per_s: ArrayLike, rotation_per_s: ArrayLike, air: Air
    ) -> Coefficients:
        """Return the coefficients of thrust and power.

        ``dT = B rho W c (c_l W_t - c_d W_a) dr / 2`` and ``dQ = B rho W c (c_l W_a + c_d W_t) r dr
        / 2``, with the velocities at the station at which the circulation of the lift,
        ``W c c_l / 2``, equals that by momentum.

        Parameters
        ----------
        airspeed_m_per_s, rotation_per_s : array_like
            True airspeed, 0 or more [m/s], and speed of rotation, above 0 [1/s].
        air : Air
            Only density and viscosity are used.

        Returns
        -------
        Coefficients
            Of the broadcast shape of the arguments. Thrust is negative where the propeller brakes,
            power where the air turns it.
        """
        inputs = (
            airspeed_m_per_s,
            rotation_per_s,
            air.density_kg_per_m3,
            air.dynamic_viscosity_pa_s,
        )
        v, n, density, viscosity = np.broadcast_arrays(
            *(np.asarray(values, float)[..., np.newaxis] for values in inputs)
        )
        place, width, chord, _ = self._blade
        rotation = np.pi * n * self._diameter_m * place
        flow = self._flow(self._angle(v, rotation), v, rotation)
        lift, drag = section_coefficients(flow.angle, density / viscosity * flow.speed * chord)
        force = 0.5 * self.blades * density * flow.speed * chord * width
        thrust = force * (lift * flow.tangential - drag * flow.axial)
        torque = force * (lift * flow.axial + drag * flow.tangential)
        scale = density[..., 0] * n[..., 0] ** 2 * self.diameter_m**4
        arm = place * self._diameter_m / 2.0
        return Coefficients(
            np.asarray(thrust.sum(-1) / scale),
            np.asarray(2.0 * np.pi * (torque * arm).sum(-1) / (scale * self.diameter_m)),
        )

    def _angle(self, v: FloatArray, rotation: FloatArray) -> FloatArray:
        """Return the angle psi of every station [rad]; airspeed and rotational speed in m/s.

        At the angle of the free flow the circulation by momentum is zero: the root lies above for
        a section that lifts, below for one that brakes.
        """
        chord = self._blade[2]

        def excess(psi: FloatArray) -> FloatArray:
            """Return the circulation by momentum less the circulation by lift [m2/s]."""
            flow = self._flow(psi, v, rotation)
            return np.asarray(
                flow.circulation - 0.5 * flow.speed * chord * _lift_and_excess(flow.angle)[0]
            )

        undisturbed = np.arctan2(v, rotation)
        lifts = excess(undisturbed) < 0.0
        lower = np.where(lifts, undisturbed, -undisturbed + 1e-12)
        upper = np.where(lifts, np.pi / 2, np.maximum(undisturbed, lower + 1e-12))
        return bracketed_root(excess, lower, upper, _ANGLE_TOLERANCE)

    def _flow(self, psi: FloatArray, v: FloatArray, rotation: FloatArray) -> _Flow:
        """Return the flow at an angle psi [rad].

        ``W_a = (V + U sin psi) / 2`` and ``W_t = (Omega r + U cos psi) / 2`` with ``U^2 = V^2 +
        (Omega r)^2``, so that the induced velocity is at right angles to the flow; circulation
        ``4 pi r / B v_t F sqrt(1 + (4 l R / (pi B r))^2)`` with Prandtl's ``F = 2/pi
        acos(exp(-B (1 - r/R) / (2 l)))`` and ``l = (r/R) W_a / W_t``.
        """
        place, _, _, twist = self._blade
        free = np.hypot(v, rotation)
        axial = 0.5 * (v + free * np.sin(psi))
        tangential = 0.5 * (rotation + free * np.cos(psi))
        speed = np.hypot(axial, tangential)
        advance = np.maximum(place * axial / tangential, 1e-9)
        tip = np.minimum(0.5 * self.blades * (1.0 - place) / advance, 700.0)
        loss = 2.0 / np.pi * np.arccos(np.exp(-tip))
        between = np.hypot(1.0, 4.0 * advance / (np.pi * self.blades * place))
        arm = place * self._diameter_m / 2.0
        momentum = 4.0 * np.pi * arm / self.blades * (rotation - tangential) * loss * between
        angle = twist - np.arctan2(axial, tangential)
        return _Flow(axial, tangential, speed, np.asarray(momentum), angle)


Propeller: TypeAlias = PropellerTable | BladeElementPropeller
