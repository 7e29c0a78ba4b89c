"""Stations along the half-span, and the integral over them."""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from typing import NamedTuple

import numpy as np

from sizing.smooth import Value

# Points of the Gauss-Legendre rule along the half-span; see docs/structure.md for its error.
STATION_COUNT = 6


class Station(NamedTuple):
    """Unit moments and shear at a fraction of the half-span, and its weight in an integral.

    ``lift_*`` belong to an elliptic lift of one half-wing, ``mass_*`` to a mass spread evenly; per
    unit of half-wing load, and of half-span for the moments.
    """

    fraction: Value
    weight: Value
    lift_moment: Value
    mass_moment: Value
    lift_shear: Value
    mass_shear: Value


def stations(count: int) -> tuple[Station, ...]:
    """Stations of a Gauss-Legendre rule from root (0) to tip (1)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return tuple(_station(float(x), float(w)) for x, w in zip(nodes, weights / 2.0, strict=True))


def _station(node: float, weight: float) -> Station:
    """Station at a node of the rule, which goes from -1 to 1."""
    x = (node + 1.0) / 2.0
    circle = (1.0 - x * x) ** 0.5
    outboard = (float(np.arccos(x)) - x * circle) / 2.0  # area of the ellipse outboard of x
    return Station(
        fraction=x,
        weight=weight,
        lift_moment=(circle**3 / 3.0 - x * outboard) * 4.0 / pi,
        mass_moment=(1.0 - x) ** 2 / 2.0,
        lift_shear=outboard * 4.0 / pi,
        mass_shear=1.0 - x,
    )


_COLUMNS = Station(*np.array(stations(STATION_COUNT)).T)


def along_the_span(*values: Value) -> tuple[Station, Callable[[Value], Value]]:
    """All stations at once in the arithmetic of some values, and the integral over them.

    Stations are the first axis of arrays and the rows of symbols.
    """
    if all(isinstance(value, (int, float, np.number, np.ndarray)) for value in values):
        shape = (-1, *(1 for _ in range(max(np.ndim(value) for value in values))))
        arrays = Station(*(column.reshape(shape) for column in _COLUMNS))
        return arrays, lambda integrand: np.tensordot(_COLUMNS.weight, integrand, 1)
    import casadi as ca

    rows = Station(*(ca.DM(column) for column in _COLUMNS))
    return rows, lambda integrand: ca.dot(rows.weight, integrand)
