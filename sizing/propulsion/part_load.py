"""Electric power of a propulsion over its load, as a small table.

Along a day the thrust power varies (turbulence, thermals), while airspeed, air and the voltage of
the bus stay those of the flight. The exact chain is evaluated at Chebyshev points of the load, and
a polynomial passes through them: motor, controller and wiring are smooth in it, and a propeller of
blade elements nearly so.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from sizing.smooth import Value
from solar.types import BoolArray, FloatArray

# Points along the load where it spans little or much of itself.
_FEW, _MANY, _MUCH = 5, 9, 1.5
# Of level flight's: power where the chain has none, which no aircraft flies on.
_BEYOND = 1e6


@dataclass(frozen=True)
class PartLoad:
    """Electric power over load, relative to that of level flight.

    Level flight's is that of the worse of the voltages of an empty and of a full battery, by which
    a design is rated.

    ``coefficients``: of powers of the place between -1 and 1, then the designs. ``loads``: centre
    and half width of the thrust power over that of level flight [-], of the designs' shape.
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
        """Table of a chain between least and greatest loads [-], each with an axis in front."""
        centre, half = (loads[0] + loads[1]) / 2.0, (loads[1] - loads[0]) / 2.0
        much = np.any(loads[1] > _MUCH * loads[0])
        points = _points((_MANY if much else _FEW) if np.any(half > 0.0) else 1)
        power = power_w(centre + half * points.reshape(-1, *(1,) * np.ndim(level_w)))
        known = np.isfinite(level_w) & np.all(np.isfinite(power), axis=0)
        ratio = np.where(known, power, 1.0) / np.where(known, level_w, 1.0)
        ratio = np.where(known, ratio, np.where(np.isfinite(level_w), _BEYOND, 1.0))
        shape = (len(points), *np.shape(level_w))
        inverse = np.linalg.inv(np.vander(points, increasing=True))
        # One after the other, so that a design does not depend on its batch to the last bit.
        values = zip(inverse.T, np.broadcast_to(ratio, shape), strict=True)
        found = sum(weights.reshape(-1, *(1,) * one.ndim) * one for weights, one in values)
        return cls(np.asarray(found), (centre, half))

    @property
    def beyond(self) -> BoolArray:
        """Whether the chain has no power somewhere in the table, of the designs' shape."""
        return np.asarray(self.coefficients[0] >= _BEYOND)

    def between(self) -> FloatArray:
        """Loads half-way between the nodes [-]; the only one where there is one.

        Of a table of one design.
        """
        nodes = _points(len(self.coefficients))
        places = (nodes[1:] + nodes[:-1]) / 2.0 if len(nodes) > 1 else nodes
        return np.asarray(self.loads[0] + self.loads[1] * places)

    def spread(self, axes: int) -> PartLoad:
        """Table with so many more axes behind those of the designs."""

        def wider(values: FloatArray) -> FloatArray:
            return np.reshape(values, np.shape(values) + (1,) * axes)

        some = tuple(wider(np.asarray(one)) if np.ndim(one) else one for one in self.loads)
        return replace(self, coefficients=wider(self.coefficients), loads=(some[0], some[1]))

    def at(self, load: ArrayLike) -> FloatArray:
        """Power over that of level flight, of thrust power over that of level flight [-]."""
        return _horner(list(self.coefficients), _from_centre(load, *self.loads))


class Proportional:
    """Electric power of a constant efficiency: it goes with the load."""

    beyond = False

    def spread(self, axes: int) -> Proportional:
        """Itself, for any number of axes."""
        return self

    def at(self, load: ArrayLike) -> FloatArray:
        """Power over that of level flight, of thrust power over that of level flight [-]."""
        return np.asarray(load, float)


PROPORTIONAL = Proportional()
AnyPartLoad = PartLoad | Proportional


def load_range(all_day: ArrayLike, thermal: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Least and greatest thrust power over that of level flight in turbulence and thermals [-]."""
    least = 1.0 + np.asarray(all_day, float)
    return least, least + np.asarray(thermal, float)


def _points(count: int) -> FloatArray:
    """Chebyshev points between -1 and 1 with both ends; one is in the middle."""
    return (
        np.asarray(-np.cos(np.pi * np.arange(count) / max(count - 1, 1)))
        if count > 1
        else (np.zeros(1))
    )


def _from_centre(
    value: ArrayLike, centre: FloatArray | float, half: FloatArray | float
) -> FloatArray:
    """Place between -1 and 1; held at the ends, where it can only be by rounding."""
    width = np.where(np.asarray(half) > 0.0, half, 1.0)
    return np.clip((np.asarray(value, float) - centre) / width, -1.0, 1.0)


def _horner(coefficients: list[FloatArray], place: FloatArray) -> FloatArray:
    """Polynomial of rising powers."""
    found = coefficients[-1] + 0.0 * place
    for one in reversed(coefficients[:-1]):
        found = one + found * place
    return np.asarray(found)
