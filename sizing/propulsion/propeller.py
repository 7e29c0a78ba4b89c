"""Coefficients of thrust and power of propellers, and propellers given as tables.

Everywhere ``J = V / (n D)``, ``C_T = T / (rho n^2 D^4)`` and ``C_P = P / (rho n^3 D^5)``, with the
speed of rotation ``n`` in revolutions per second, so that the efficiency is ``J C_T / C_P``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from missions.air import Air
from solar.types import FloatArray

Indices = slice | int | NDArray[np.integer[Any]]

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

    def at(self, indices: Indices) -> PropellerTable:
        """Return this propeller, the same at all points."""
        return self
