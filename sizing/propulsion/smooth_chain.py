"""A propulsion at its operating point by formulas that a program can differentiate.

The propeller of blade elements is a fitted surface; motor, gear, controller and wiring have their
own formulas. Both take numbers, arrays and symbols.

A propeller of given blades has, whatever its size and air, one speed of rotation and one efficiency
for three numbers: the loading ``T / (rho V^2 D^2)``, the Reynolds number ``rho V D / mu`` and pitch
over diameter. ``ln (n D / V)`` and ``ln (1 / efficiency)`` are Chebyshev polynomials in them.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from math import e
from typing import Literal

import numpy as np
from numpy.polynomial import chebyshev
from pydantic import Field

from missions.air import Air
from sizing.propulsion.blade_elements import BladeElementPropeller
from sizing.propulsion.chain import LINKS, OperatingPointPropulsion, Propulsion
from sizing.propulsion.shafts import inlet, motor_state, power_of_shafts_w
from sizing.smooth import Value, chebyshev_series, smooth_maximum
from solar.schema import Record
from solar.types import FloatArray

# Degrees in loading, Reynolds number and pitch over diameter, of a narrow and a wide range of it.
_NARROW, _DEGREES, _WIDE_DEGREES = 0.35, (9, 4, 3), (9, 4, 5)
# More nodes than degrees; advance ratios over pitch/diameter in which loadings are searched for.
_MORE_NODES = 3
_ADVANCE_OVER_PITCH = np.linspace(0.08, 1.4, 34)
# In half-widths: what is fitted, and where the polynomials' interval ends.
_REACH, _END = 1.15, 1.3
# Exponent that stands for a logarithm, and width of the corner at the interval's ends.
_ROOT, _CORNER = 0.1, 0.1
# Of the powers with an empty and a full battery: rounds the corner where they are equal.
_BLEND = 1e-5
_Coefficients = tuple[tuple[tuple[float, ...], ...], ...]


class PropellerSurface(Record):
    """Rotation and efficiency of a propeller as polynomials.

    ``centre`` and ``half_width`` are of the logarithms of loading, Reynolds number and pitch over
    diameter; farther away the polynomials bend towards a constant, so that no search leaves them.
    """

    centre: tuple[float, float, float]
    half_width: tuple[float, float, float]
    rotation: _Coefficients
    power: _Coefficients

    def rotation_and_power(
        self, loading: Value, reynolds: Value, pitch_ratio: Value
    ) -> tuple[Value, Value]:
        """``n D / V`` and power over thrust power [-]."""
        places = [
            _on_interval(one, centre, half)
            for one, centre, half in zip(
                (loading, reynolds, pitch_ratio), self.centre, self.half_width, strict=True
            )
        ]
        turns, power = (_series(one, places) for one in (self.rotation, self.power))
        return e**turns, e**power


def _on_interval(value: Value, centre: float, half_width: float) -> Value:
    """Place between -1 and 1 of a value, held at the ends of the polynomials' interval.

    The logarithm of the value over that of the centre, in half-widths, in arithmetic alone:
    ``(r^a - r^-a) / (2 a h)``.
    """
    root = (value * e**-centre) ** _ROOT
    t = (root - 1.0 / root) / (2.0 * _ROOT * half_width)
    above, below = ((t + end) ** 2 + _CORNER**2 for end in (_END, -_END))
    return (above**0.5 - below**0.5) / (2.0 * _END)


def _series(coefficients: _Coefficients, places: list[Value]) -> Value:
    """Tensor product of Chebyshev polynomials."""
    first, second, third = places
    planes = [
        chebyshev_series([chebyshev_series(row, third) for row in plane], second)
        for plane in coefficients
    ]
    return chebyshev_series(planes, first)


@lru_cache(maxsize=64)
def fitted_surface(
    blades: int,
    chords: Literal["thin_electric", "slow_flyer"],
    centre: tuple[float, float, float],
    half_width: tuple[float, float, float],
) -> PropellerSurface:
    """Surface of the propellers with these blades, by least squares over blade elements."""
    degrees = _DEGREES if half_width[2] < _NARROW else _WIDE_DEGREES
    loading, reynolds, ratios = (
        np.exp(middle + half * _REACH * np.cos(np.pi * (np.arange(count) + 0.5) / count))
        for middle, half, count in zip(
            centre, half_width, (one + _MORE_NODES for one in degrees), strict=True
        )
    )
    # By slices: at every pitch and Reynolds number over the loading, then over these two. One large
    # system of equations would take longer than everything else.
    ends = list(zip(centre, half_width, strict=True))
    slices = np.array(
        [
            [
                _polynomial(_on_interval(found, *ends[0]), np.log(rows).T, degrees[0])
                for found, *rows in _samples(float(one), blades, chords, loading, reynolds)
            ]
            for one in ratios
        ]
    )
    over_reynolds = _along(slices, 1, _on_interval(reynolds, *ends[1]), degrees[1])
    fitted = np.moveaxis(
        _along(over_reynolds, 0, _on_interval(ratios, *ends[2]), degrees[2]), -1, 0
    )
    fitted = np.swapaxes(fitted, 1, 3)
    turns, cost = (tuple(tuple(map(tuple, plane)) for plane in one.tolist()) for one in fitted)
    return PropellerSurface(centre=centre, half_width=half_width, rotation=turns, power=cost)


def _polynomial(place: FloatArray, values: FloatArray, degree: int) -> FloatArray:
    """Chebyshev coefficients of columns of values."""
    basis = chebyshev.chebvander(place, degree)
    return np.asarray(np.linalg.lstsq(basis, values, rcond=1e-10)[0])


def _along(values: FloatArray, axis: int, place: FloatArray, degree: int) -> FloatArray:
    """Values at places along an axis as Chebyshev coefficients along it."""
    first = np.moveaxis(values, axis, 0)
    found = _polynomial(place, first.reshape(len(first), -1), degree)
    return np.moveaxis(found.reshape(-1, *first.shape[1:]), 0, axis)


def _samples(
    pitch_ratio: float,
    blades: int,
    chords: Literal["thin_electric", "slow_flyer"],
    loading: FloatArray,
    reynolds: FloatArray,
) -> Iterator[tuple[FloatArray, FloatArray, FloatArray]]:
    """Propellers of one pitch near some loadings: these, ``n D / V`` and power over thrust power.

    One for each Reynolds number.
    """
    propeller = BladeElementPropeller(1.0, pitch_ratio, blades, chords)

    def at(advance: FloatArray) -> tuple[FloatArray, FloatArray]:
        one = np.ones_like(advance)
        air = Air(288.15 * one, 101325.0 * one, one, one / reynolds[:, np.newaxis])
        thrust, power = propeller.coefficients(one, 1.0 / advance, air)
        return thrust / advance**2, power / thrust / advance

    coarse = np.tile(_ADVANCE_OVER_PITCH * pitch_ratio, (len(reynolds), 1))
    known, _ = at(coarse)
    advance = np.array(
        [
            np.interp(loading, row[::-1], one[::-1])
            for row, one in zip(np.minimum.accumulate(known, axis=1), coarse, strict=True)
        ]
    )
    for found, cost, ratio in zip(*at(advance), advance, strict=True):
        pulls = found > 0.0
        yield found[pulls], 1.0 / ratio[pulls], cost[pulls]


class SmoothPropulsion(OperatingPointPropulsion):
    """Propulsion of an aircraft's file with the propeller of a surface.

    ``correction``: speed of rotation and power of the exact propeller over those of the surface, at
    one design. No file has these two keys.
    """

    is_exact = False

    surface: PropellerSurface = Field(exclude=True, repr=False)
    correction: tuple[float, float] = Field(default=(1.0, 1.0), exclude=True, repr=False)

    @classmethod
    def of(cls, parts: OperatingPointPropulsion, surface: PropellerSurface) -> SmoothPropulsion:
        """These parts with a surface."""
        fields = {name: getattr(parts, name) for name in OperatingPointPropulsion.model_fields}
        return cls.model_construct(**fields, surface=surface)

    def in_flight(
        self,
        thrust_power_w: Value,
        airspeed_m_per_s: Value,
        air: Air,
        bus_voltage_v: tuple[float, float],
    ) -> Propulsion:
        """Chain at an operating point, of the arguments' type; no limit is checked."""
        rotation, shaft_w, cost = self.propeller_state(thrust_power_w, airspeed_m_per_s, air)
        state = motor_state(self, rotation, shaft_w)
        (empty, empty_w), (full, full_w) = (inlet(self, state, volts) for volts in bus_voltage_v)
        bus_w = smooth_maximum(
            empty_w * bus_voltage_v[0] / empty, full_w * bus_voltage_v[1] / full, _BLEND
        )
        motor_w = state.current_a * state.voltage_v
        # The wiring of the full battery; what the empty one takes more is the controller's.
        wiring = full / bus_voltage_v[1]
        links = {
            "wiring": wiring,
            "controller": motor_w / (bus_w * wiring),
            "motor": shaft_w / self.gear.efficiency / motor_w,
            "gearbox": self.gear.efficiency,
            "propeller": self.efficiency_factor / cost,
        }
        torque = shaft_w / (2.0 * np.pi * rotation)
        level_w = self.propulsors * bus_w / self.efficiency_factor
        return self.with_links({name: links[name] for name in LINKS}, torque, level_w)

    def bus_power_w(
        self, thrust_power_w: Value, airspeed_m_per_s: Value, air: Air, bus_v: Value
    ) -> Value:
        """As of the exact chain, also of symbols."""
        rotation, shaft_w, _ = self.propeller_state(thrust_power_w, airspeed_m_per_s, air)
        return power_of_shafts_w(self, rotation, shaft_w, bus_v)

    def propeller_state(
        self, thrust_power_w: Value, airspeed_m_per_s: Value, air: Air
    ) -> tuple[Value, Value, Value]:
        """Speed of rotation [1/s], power at the shaft [W] and power over thrust power [-]."""
        density, speed = air.density_kg_per_m3, airspeed_m_per_s
        diameter, pitch = self.propeller.diameter_m, self.propeller.pitch_m
        assert diameter is not None
        assert pitch is not None
        thrust_w = thrust_power_w / self.propulsors
        turns, cost = self.surface.rotation_and_power(
            thrust_w / (density * speed**3 * diameter**2),
            density * speed * diameter / air.dynamic_viscosity_pa_s,
            pitch / diameter,
        )
        turns, cost = turns * self.correction[0], cost * self.correction[1]
        return turns * speed / diameter, thrust_w * cost, cost
