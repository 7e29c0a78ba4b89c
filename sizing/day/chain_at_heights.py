"""Propulsion over load and level, for flights with climbs.

A climb takes several times the thrust power of level flight, a glide less than it, in air that
changes with the level. The exact propeller is evaluated at some loads and levels; motor, controller
and wiring behind it are formulas (:mod:`sizing.propulsion.chain`), at the voltage of a half charged
battery. Logarithms of power over load are tables with cubics between their nodes.

Below a quarter of level flight's thrust power the motor runs at that quarter for a part of the
time: no propeller that turns along costs power.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from missions.air import Air
from sizing.aircraft import Aircraft
from sizing.design import NO_FLIGHT_W, Design
from sizing.propulsion.chain import OperatingPointPropulsion
from sizing.propulsion.operating_point import Shaft
from sizing.smooth import Value
from solar.types import BoolArray, FloatArray, IntArray

# Thrust power over that of level flight: steps of 4^(1/6) from a quarter to eight times.
_LEAST, _RATIO = 0.25, 4.0 ** (1.0 / 6.0)
_LOADS = _LEAST * _RATIO ** np.arange(16)
# How finely the limits are looked for, and levels of the exact propeller.
_FINE, _LEVELS = 241, 6


@dataclass(frozen=True)
class ConstantChain:
    """Propulsion of constant efficiencies at some levels; as :class:`ClimbChain`."""

    level_w: FloatArray
    thrust_w: FloatArray

    @classmethod
    def of(cls, flights: Design, efficiency: Value) -> ConstantChain:
        """Return the chain of designs at some levels, the first axis of their power."""
        power_w = np.asarray(flights.propulsion_power_w)
        level_w = power_w.reshape(len(power_w), -1)
        level_w = np.where(np.isfinite(level_w).all(axis=0), level_w, NO_FLIGHT_W)
        return cls(level_w, level_w * np.broadcast_to(efficiency, power_w.shape[1:]).ravel())

    def power_w(self, level: IntArray, design: IntArray, load: FloatArray) -> FloatArray:
        """Return the electric power at thrust ratios to level flight [W]; all broadcast."""
        return np.asarray(self.level_w[level, design] * load)

    @property
    def most_w(self) -> FloatArray:
        """Return the largest electric power, which is not limited here [W]."""
        return np.full(self.level_w.shape[1], np.inf)


@dataclass(frozen=True)
class ClimbChain:
    """Propulsion of designs in level flight at some levels, and what it does at other loads.

    ``parts``: with an efficiency factor of 1; ``factor``: that of the designs. ``thrust_w``,
    ``airspeed_m_per_s``, ``air``: of level flight, of shape ``(level, design)``. ``bus_v``: voltage
    of a half charged battery [V].
    """

    parts: OperatingPointPropulsion
    factor: FloatArray
    thrust_w: FloatArray
    airspeed_m_per_s: FloatArray
    air: Air
    flies: BoolArray
    bus_v: float

    @classmethod
    def of(
        cls, parts: OperatingPointPropulsion, aircraft: Aircraft, flights: Design, air: Air
    ) -> ClimbChain:
        """Return the chain of designs at some levels, the first axis of their power and air."""
        shape = np.shape(flights.propulsion_power_w)

        def by_design(value: Value, shape: tuple[int, ...] = shape) -> FloatArray:
            return np.broadcast_to(np.asarray(value, float), shape).reshape(shape[0], -1)

        with np.errstate(invalid="ignore"):
            thrust_w = by_design(flights.thrust_power_w)
        speed = by_design(flights.airspeed_m_per_s)
        flies = np.isfinite(thrust_w).all(axis=0) & np.isfinite(speed).all(axis=0)
        one_level = (1, *shape[1:])
        sizes = (
            size if size is None else by_design(size, one_level)[0]
            for size in flights.variables.of_propulsion
        )
        # A single design has numbers: its propeller is searched for as in level flight.
        sizes = (float(size[0]) if size is not None and len(size) == 1 else size for size in sizes)
        return cls(
            parts.model_copy(update={"efficiency_factor": 1.0}).sized(*sizes),
            by_design(parts.efficiency_factor, one_level)[0],
            np.where(flies, thrust_w, 1.0),
            np.where(flies, speed, 1.0),
            Air(*map(by_design, air)),
            np.asarray(flies),
            aircraft.battery.nominal_voltage_v,
        )

    def power_w(self, level: IntArray, design: IntArray, load: FloatArray) -> FloatArray:
        """Return the electric power at thrust ratios to level flight [W]; all broadcast."""
        powers, nodes = self._tables[0].ravel(), len(_LOADS)
        beyond = np.log(np.maximum(load, 1e-300) / _LEAST)
        along = beyond / np.log(_RATIO)
        node, weights = _cubic(along, nodes)
        row = (level * self.thrust_w.shape[1] + design) * nodes
        power = sum(weight * powers[row + node + k] for k, weight in enumerate(weights))
        # Below the table it is proportional to the load.
        return np.asarray(np.exp(np.where(along < 0.0, powers[row] + beyond, power)))

    @property
    def most_w(self) -> FloatArray:
        """Return the electric power at the limits of the parts, at all levels [W]."""
        return np.asarray(self._tables[1].reshape(self.thrust_w.shape).min(axis=0))

    @cached_property
    def _tables(self) -> tuple[FloatArray, FloatArray]:
        """Return the logarithm of the power over loads, and the largest electric power [W].

        Rows are levels, one after the other, of all designs.
        """
        shaft = self._shafts()
        parts, air = self.parts, Air(*(values[np.newaxis] for values in self.air))
        with np.errstate(invalid="ignore", over="ignore"):
            power = np.asarray(parts.bus_power_w(shaft, self.bus_v)) / self.factor
            shares = parts.shares_of_limits(shaft, self.airspeed_m_per_s, air, self.bus_v)
            used = np.max(np.broadcast_arrays(*shares.values(), power)[:-1], axis=0)
            # Where the propeller's data end, or the wiring cannot pass the power, the tables go on,
            # beyond a limit.
            rises = np.diff(power, axis=0, prepend=0.0) > 0.0
            known = np.isfinite(power) & (power > 0.0) & np.isfinite(used) & rises
        power, used = _continued(power, known), np.where(known, used, 2.0)
        log_power, used = np.log(_rows_first(power)), _rows_first(used)
        fine = np.linspace(0.0, len(_LOADS) - 1.0, _FINE)
        over = _between(fine, log_power)
        beyond = _between(fine, used) > 1.0
        within = np.where(beyond.any(axis=-1), np.argmax(beyond, axis=-1) - 1, _FINE - 1)
        most_w = np.exp(np.take_along_axis(over, np.maximum(within, 0)[..., np.newaxis], -1))
        flies = np.tile(self.flies, len(self.thrust_w))
        log_power = np.where(flies[:, np.newaxis], log_power, np.log(NO_FLIGHT_W))
        return log_power, np.where(flies, most_w[..., 0], 0.0)

    def _shafts(self) -> Shaft:
        """Return the shaft of a propeller, ``(load, level, design)``."""
        count = len(self.thrust_w)
        loads, levels = _LOADS[:, np.newaxis, np.newaxis], np.arange(count)
        if self.parts.is_exact and count > _LEVELS:
            levels = np.unique(np.round(np.linspace(0, count - 1, _LEVELS)).astype(int))
        air = Air(*(values[levels] for values in self.air))
        speed, thrust_w = self.airspeed_m_per_s[levels], self.thrust_w[levels]
        shaft = self.parts.shaft(thrust_w * loads, speed, air)
        if len(levels) == count:
            return shaft
        # Rotation over airspeed and power over thrust power follow the Reynolds number slowly.
        # A polynomial through their logarithms at some levels gives them at all.
        nodes, targets = (
            np.vander(2.0 / levels[-1] * place - 1.0, len(levels))
            for place in (levels, np.arange(count))
        )
        weights = np.linalg.solve(nodes.T, targets.T)
        rotation, power = (
            np.exp(np.einsum("lsd,sk->lkd", np.log(ratio), weights))
            for ratio in (shaft.rotation_per_s / speed, shaft.power_w / thrust_w)
        )
        return shaft._replace(
            rotation_per_s=rotation * self.airspeed_m_per_s, power_w=power * self.thrust_w
        )


def _rows_first(values: FloatArray) -> FloatArray:
    """Return values of loads, levels and designs with rows of levels and designs first."""
    return np.moveaxis(values, 0, 2).reshape(-1, len(values))


def _cubic(along: FloatArray, nodes: int) -> tuple[IntArray, tuple[FloatArray, ...]]:
    """Return the first of four even nodes around places, and weights of Lagrange's cubic."""
    place = np.minimum(np.maximum(along, 0.0), nodes - 1.0)
    node = np.minimum(np.maximum(place.astype(int) - 1, 0), nodes - 4)
    t = place - node
    a, b, c = t - 1.0, t - 2.0, t - 3.0
    return node, (-a * b * c / 6.0, t * b * c / 2.0, -t * a * c / 2.0, t * a * b / 6.0)


def _between(along: FloatArray, values: FloatArray) -> FloatArray:
    """Return values at places along their last axis."""
    node, weights = _cubic(along, values.shape[-1])
    return np.asarray(sum(weight * values[..., node + k] for k, weight in enumerate(weights)))


def _continued(values: FloatArray, known: BoolArray) -> FloatArray:
    """Return powers over loads, the first axis; unknown ones go with the load from the next."""
    if known.all():
        return values
    powers = np.where(known, values, 1.0)
    count = len(powers)
    for order, grow in ((range(1, count), _RATIO), (range(count - 2, -1, -1), 1.0 / _RATIO)):
        done = known[order.start - order.step].copy()
        for k in order:
            take = done & ~known[k]
            powers[k] = np.where(take, powers[k - order.step] * grow, powers[k])
            done |= known[k]
    return powers
