"""Electric power of a propulsion over its load and the voltage of the bus, as a small table.

Along a day the thrust power varies (turbulence, thermals) and so does the voltage, while airspeed
and air stay those of the flight. The exact chain is evaluated at Chebyshev points of both, and a
polynomial passes through them: motor, controller and wiring are smooth in both, and a propeller of
blade elements nearly so.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from sizing.smooth import Value
from solar.types import BoolArray, FloatArray

# Points along the load where it spans little or much of itself, and along the voltage.
_FEW, _MANY, _MUCH, _VOLTS = 5, 9, 1.5, 4
# Relative power that is no dependence on the voltage: rounding of the chain.
_CONSTANT = 1e-9
# Of level flight's: power where the chain has none, which no aircraft flies on.
_BEYOND = 1e6

# Power of loads, relative to level flight's, at voltages; each with axes of its own in front.
PowerOf = Callable[[FloatArray, FloatArray], Value]


@dataclass(frozen=True)
class PartLoad:
    """Electric power over load and bus voltage, relative to that of level flight.

    Level flight's is that of the worse of both ends of the voltage, by which a design is rated.

    ``coefficients``: of powers of the two places between -1 and 1, load first, then voltage, then
    the designs. ``loads``, ``volts``: centre and half width of the thrust power over that of level
    flight [-], of the designs' shape, and of the voltage [V].
    """

    coefficients: FloatArray
    loads: tuple[FloatArray, FloatArray]
    volts: tuple[float, float]

    @classmethod
    def of(
        cls,
        power_w: PowerOf,
        level_w: FloatArray,
        loads: tuple[FloatArray, FloatArray],
        volts: tuple[float, float],
    ) -> PartLoad:
        """Table of a chain between least and greatest loads [-] and voltages [V]."""
        centre = (loads[0] + loads[1]) / 2.0, (volts[0] + volts[1]) / 2.0
        half = (loads[1] - loads[0]) / 2.0, (volts[1] - volts[0]) / 2.0
        wide = np.any(half[0] > 0.0)
        much = np.any(loads[1] > _MUCH * loads[0])
        of_load = _points((_MANY if much else _FEW) if wide else 1)
        of_volts = _points(_VOLTS if half[1] > 0.0 else 1)
        batch = (1,) * np.ndim(level_w)
        given = of_load.reshape(-1, 1, *batch), of_volts.reshape(-1, *batch)
        power = power_w(centre[0] + half[0] * given[0], centre[1] + half[1] * given[1])
        shape = (len(of_load), len(of_volts), *np.shape(level_w))
        known = np.isfinite(level_w) & np.all(np.isfinite(power), axis=(0, 1))
        ratio = np.where(known, power, 1.0) / np.where(known, level_w, 1.0)
        ratio = np.where(known, ratio, np.where(np.isfinite(level_w), _BEYOND, 1.0))
        found: FloatArray = np.broadcast_to(ratio, shape)
        for axis, points in enumerate((of_load, of_volts)):
            system = np.vander(points, increasing=True)
            moved = np.moveaxis(found, axis, 0).reshape(len(points), -1)
            solved = np.asarray(np.linalg.solve(system, moved), float)
            rest = shape[:axis] + shape[axis + 1 :]
            found = np.moveaxis(solved.reshape(len(points), *rest), 0, axis)
        return cls(found, (centre[0], half[0]), (centre[1], half[1]))

    @property
    def beyond(self) -> BoolArray:
        """Whether the chain has no power somewhere in the table, of the designs' shape."""
        return np.asarray(self.coefficients[0, 0] >= _BEYOND)

    @property
    def follows_voltage(self) -> bool:
        """Whether the voltage makes any difference."""
        return bool(np.any(np.abs(self.coefficients[:, 1:]) > _CONSTANT))

    def between(self) -> tuple[FloatArray, FloatArray]:
        """Loads [-] and voltages [V] half-way between the nodes; the only one where there is one.

        Of a table of one design.
        """
        middles = []
        for count in self.coefficients.shape[:2]:
            nodes = _points(count)
            middles.append((nodes[1:] + nodes[:-1]) / 2.0 if count > 1 else nodes)
        load, volts = middles
        return self.loads[0] + self.loads[1] * load, self.volts[0] + self.volts[1] * volts

    def spread(self, axes: int) -> PartLoad:
        """Table with so many more axes behind those of the designs."""

        def wider(values: FloatArray) -> FloatArray:
            return np.reshape(values, np.shape(values) + (1,) * axes)

        some = tuple(wider(np.asarray(one)) if np.ndim(one) else one for one in self.loads)
        return replace(self, coefficients=wider(self.coefficients), loads=(some[0], some[1]))

    def at(self, load: ArrayLike, bus_v: ArrayLike | None = None) -> FloatArray:
        """Power over that of level flight [-].

        ``load``: thrust power over that of level flight [-]. ``bus_v``: without it the end of the
        voltage that takes more.
        """
        if bus_v is None:
            low, high = (self.volts[0] + end * self.volts[1] for end in (-1.0, 1.0))
            return np.maximum(self.at(load, low), self.at(load, high))
        x = _from_centre(load, *self.loads)
        y = _from_centre(bus_v, *self.volts)
        return _horner([_horner(list(row), y) for row in self.coefficients], x)


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
    found = coefficients[-1]
    for one in reversed(coefficients[:-1]):
        found = one + found * place
    return np.asarray(found)
