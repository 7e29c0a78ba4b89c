"""Stations along the half-span, and the integral over them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import pi
from typing import NamedTuple

import numpy as np

from sizing.smooth import Value

# Points of the Gauss-Legendre rule along the half-span; see docs/structure.md for its error.
STATION_COUNT = 6


class Station(NamedTuple):
    """Unit moments and shear at a fraction of the half-span, and its weight in an integral.

    ``lift_*`` belong to an elliptic lift of one half-wing, ``mass_*`` to a mass spread evenly,
    ``landed_*`` to that mass less the ground's reaction; per unit of half-wing load, and of
    half-span for the moments. ``braced_*`` have what a wire takes off, which is ``inboard`` 1.
    """

    fraction: Value
    weight: Value
    lift_moment: Value
    mass_moment: Value
    lift_shear: Value
    mass_shear: Value
    landed_moment: Value
    landed_shear: Value
    braced_lift_moment: Value
    braced_mass_moment: Value
    braced_landed_moment: Value
    inboard: Value


def stations(count: int, gear: float = 0.0, wire: float | None = None) -> tuple[Station, ...]:
    """Stations of a Gauss-Legendre rule from root (0) to tip (1).

    ``gear``: fraction of the half-span over which the landing gear stands; ``wire``: where a wire
    is attached, none without.
    """
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return tuple(
        _station((float(x) + 1.0) / 2.0, float(w), gear, wire)
        for x, w in zip(nodes, weights / 2.0, strict=True)
    )


def _station(x: float, weight: float, gear: float, wire: float | None) -> Station:
    """Station at a fraction of the half-span."""
    lift, mass, landed = _moments(x, gear)
    # A wire takes the whole moment at the root, and less the nearer the station is to it.
    share = 0.0 if wire is None else max(0.0, 1.0 - x / wire)
    at_root = _moments(0.0, gear)
    outboard = _outboard(x)
    return Station(
        fraction=x,
        weight=weight,
        lift_moment=lift,
        mass_moment=mass,
        lift_shear=outboard * 4.0 / pi,
        mass_shear=1.0 - x,
        landed_moment=landed,
        landed_shear=(1.0 - x) - (max(0.0, 1.0 - x / gear) if gear else 0.0),
        braced_lift_moment=lift - share * at_root[0],
        braced_mass_moment=mass - share * at_root[1],
        braced_landed_moment=landed - share * at_root[2],
        inboard=float(share > 0.0),
    )


def _outboard(x: float) -> float:
    """Area of the quarter circle outboard of x."""
    return float((np.arccos(x) - x * (1.0 - x * x) ** 0.5) / 2.0)


def _moments(x: float, gear: float) -> tuple[float, float, float]:
    """Moments of an elliptic lift, of an even mass, and of that mass on its landing gear."""
    lift = ((1.0 - x * x) ** 1.5 / 3.0 - x * _outboard(x)) * 4.0 / pi
    mass = (1.0 - x) ** 2 / 2.0
    # The ground carries the mass evenly over the landing gear.
    ground = max(0.0, gear - x) ** 2 / (2.0 * gear) if gear else 0.0
    return lift, mass, mass - ground


@cache
def _columns(gear: float, wire: float | None) -> Station:
    """All stations, each quantity in one array."""
    return Station(*np.array(stations(STATION_COUNT, gear, wire)).T)


def along_the_span(
    *values: Value, gear: float = 0.0, wire: float | None = None
) -> tuple[Station, Callable[[Value], Value]]:
    """All stations at once in the arithmetic of some values, and the integral over them.

    Stations are the first axis of arrays and the rows of symbols. ``gear`` and ``wire`` as in
    :func:`stations`.
    """
    columns = _columns(gear, wire)
    if all(isinstance(value, (int, float, np.number, np.ndarray)) for value in values):
        shape = (-1, *(1 for _ in range(max(np.ndim(value) for value in values))))
        arrays = Station(*(column.reshape(shape) for column in columns))
        return arrays, lambda integrand: np.tensordot(columns.weight, integrand, 1)
    import casadi as ca

    rows = Station(*(ca.DM(column) for column in columns))
    return rows, lambda integrand: ca.dot(rows.weight, integrand)
