"""Electric power of a propulsion over its load, as a small table.

Along a day the thrust power varies (turbulence, thermals) at constant airspeed, air and bus
voltage. The exact chain is evaluated at Chebyshev points of the load and interpolated by a
polynomial: motor, controller and wiring are smooth in the load, a propeller of blade elements
nearly so.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial.polynomial import polyval
from numpy.typing import ArrayLike

from sizing.smooth import Value
from solar.types import BoolArray, FloatArray

# Numbers of points for a narrow and a wide range of loads, and the ratio of loads that is wide.
_FEW_POINTS, _MANY_POINTS, _WIDE_RANGE = 5, 9, 1.5
# Prohibitive power relative to level flight, for loads outside the propeller's data.
_PROHIBITIVE = 1e6


@dataclass(frozen=True)
class PartLoad:
    """Electric power over load, both relative to level flight.

    The reference is the power at the worse of the voltages of the empty and the full battery, by
    which a design is rated.

    ``coefficients`` of the polynomial in the load scaled to -1 to 1, of shape (degree + 1,
    *designs). ``loads``: centre and half width of the range of loads [-], of the designs' shape.
    """

    coefficients: FloatArray
    loads: tuple[FloatArray, FloatArray]

    @classmethod
    def of(
        cls,
        power_w: Callable[[FloatArray], Value],
        level_w: FloatArray,
        loads: tuple[FloatArray, FloatArray],
    ) -> PartLoad:
        """Return the table of a chain between least and greatest loads [-]."""
        centre, half = (loads[0] + loads[1]) / 2.0, (loads[1] - loads[0]) / 2.0
        much = np.any(loads[1] > _WIDE_RANGE * loads[0])
        count = _MANY_POINTS if much else _FEW_POINTS
        points = -np.cos(np.pi * np.arange(count) / (count - 1))
        if not np.any(half > 0.0):
            points = np.zeros(1)
        power = power_w(centre + half * points.reshape(-1, *(1,) * np.ndim(level_w)))
        known = np.isfinite(level_w) & np.all(np.isfinite(power), axis=0)
        ratio = np.where(known, power, 1.0) / np.where(known, level_w, 1.0)
        ratio = np.where(known, ratio, np.where(np.isfinite(level_w), _PROHIBITIVE, 1.0))
        shape = (len(points), *np.shape(level_w))
        inverse = np.linalg.inv(np.vander(points, increasing=True))
        # Summed in order, so that a design's last bit does not depend on its batch.
        values = zip(inverse.T, np.broadcast_to(ratio, shape), strict=True)
        coefficients = sum(
            weights.reshape(-1, *(1,) * value.ndim) * value for weights, value in values
        )
        return cls(np.asarray(coefficients), (centre, half))

    @property
    def beyond(self) -> BoolArray:
        """True where the chain has no power at some load of the table, of the designs' shape."""
        return np.asarray(self.coefficients[0] >= _PROHIBITIVE)

    def spread(self, axes: int) -> PartLoad:
        """Return the table with axes added behind the axes of designs."""

        def wider(values: FloatArray) -> FloatArray:
            return np.reshape(values, np.shape(values) + (1,) * axes)

        loads = tuple(wider(np.asarray(load)) if np.ndim(load) else load for load in self.loads)
        return replace(self, coefficients=wider(self.coefficients), loads=(loads[0], loads[1]))

    def at(self, load: ArrayLike) -> FloatArray:
        """Return electric power over its reference [-] at thrust powers over level flight [-]."""
        centre, half = self.loads
        place = (np.asarray(load, float) - centre) / np.where(half > 0.0, half, 1.0)
        return np.asarray(polyval(place, self.coefficients, tensor=False))


# Electric power of a constant efficiency.
PROPORTIONAL = PartLoad(np.array([0.0, 1.0]), (np.zeros(()), np.ones(())))


def load_range(all_day: ArrayLike, thermal: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return least and greatest relative thrust power in turbulence and thermals [-]."""
    least = 1.0 + np.asarray(all_day, float)
    return least, least + np.asarray(thermal, float)
