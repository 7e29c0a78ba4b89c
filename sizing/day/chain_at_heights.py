"""Propulsion at the load, level of the moment, for flights with climbs.

A climb takes several times the thrust power of level flight, a glide less than it, in air that
changes with the level. The exact propeller is evaluated at some loads and levels; motor, controller
and wiring behind it are formulas (:mod:`sizing.propulsion.shafts`), at the voltage of a half
charged battery. Logarithms of power over load are tables with cubics between their nodes.

Below a quarter of level flight's thrust power the motor runs at that quarter for a part of the
time: no propeller that turns along costs power.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from missions.air import Air
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import NO_FLIGHT_W, Design, FlightConditions
from sizing.propulsion.chain import OperatingPointPropulsion
from sizing.propulsion.shafts import power_of_shafts_w, shares_of_limits
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
    def of(cls, flown: list[Design], efficiency: Value) -> ConstantChain:
        """Chain of designs at some levels."""
        shape = np.shape(flown[0].propulsion_power_w)
        behind = (1,) * (len(shape) - np.ndim(efficiency) if np.ndim(efficiency) else 0)
        share = np.broadcast_to(np.reshape(efficiency, np.shape(efficiency) + behind), shape)
        powers = [np.broadcast_to(one.propulsion_power_w, shape).ravel() for one in flown]
        level_w = np.where(np.isfinite(powers).all(axis=0), powers, NO_FLIGHT_W)
        return cls(level_w, level_w * share.ravel())

    @property
    def count(self) -> int:
        """Number of designs."""
        return int(self.level_w.shape[1])

    def power_w(self, row: IntArray, load: FloatArray) -> FloatArray:
        """Electric power of thrust powers over that of level flight [W]; both broadcast."""
        return np.asarray(self.level_w.ravel()[row] * load)

    def most_w(self, row: IntArray) -> FloatArray:
        """No limit of its own [W]."""
        return np.full(np.shape(row), np.inf)


@dataclass(frozen=True)
class ClimbChain:
    """Propulsion of designs in level flight at some levels, and what it does at other loads.

    ``parts``: with an efficiency factor of 1, the designs' own in ``factor``. ``thrust_w``,
    ``airspeed_m_per_s``, ``air``: of level flight, of shape ``(level, design)``. ``bus_v``: voltage
    of a half charged battery [V].
    """

    parts: OperatingPointPropulsion
    sizes: tuple[FloatArray | None, ...]
    factor: FloatArray
    thrust_w: FloatArray
    airspeed_m_per_s: FloatArray
    air: Air
    flies: BoolArray
    bus_v: float

    @classmethod
    def of(
        cls,
        parts: OperatingPointPropulsion,
        aircraft: Aircraft,
        missions: list[Mission],
        flown: list[Design],
    ) -> ClimbChain:
        """Chain of designs at the levels of some missions."""
        shape = np.shape(flown[0].propulsion_power_w)
        with np.errstate(invalid="ignore"):
            thrust = [one.thrust_power_w for one in flown]

        def rows(values: list[object]) -> FloatArray:
            each = [np.broadcast_to(np.asarray(one, float), shape).ravel() for one in values]
            return np.stack(each)

        thrust_w, speed = rows(thrust), rows([one.airspeed_m_per_s for one in flown])
        flies = np.isfinite(thrust_w).all(axis=0) & np.isfinite(speed).all(axis=0)
        airs = [FlightConditions.of(one, aircraft).air for one in missions]
        sizes = tuple(
            None if one is None else np.broadcast_to(np.asarray(one, float), shape).ravel()
            for one in flown[0].variables.of_propulsion
        )
        return cls(
            parts.model_copy(update={"efficiency_factor": 1.0}),
            sizes,
            rows([parts.efficiency_factor])[0],
            np.where(flies, thrust_w, 1.0),
            np.where(flies, speed, 1.0),
            Air(*(rows(list(one)) for one in zip(*airs, strict=True))),
            np.asarray(flies),
            aircraft.battery.nominal_voltage_v,
        )

    @property
    def count(self) -> int:
        """Number of designs."""
        return int(self.thrust_w.shape[1])

    def power_w(self, row: IntArray, load: FloatArray) -> FloatArray:
        """Electric power of thrust powers over that of level flight [W]; both broadcast."""
        powers, nodes = self._tables[0].ravel(), len(_LOADS)
        beyond = np.log(np.maximum(load, 1e-300) / _LEAST)
        along = beyond / np.log(_RATIO)
        node, weights = _cubic(along, nodes)
        at = row * nodes
        found = sum(one * powers[at + node + k] for k, one in enumerate(weights))
        # Below the table it is proportional to the load.
        return np.asarray(np.exp(np.where(along < 0.0, powers[at] + beyond, found)))

    def most_w(self, row: IntArray) -> FloatArray:
        """Electric power at the limits of the parts [W]."""
        return np.asarray(self._tables[1][row])

    @cached_property
    def _tables(self) -> tuple[FloatArray, FloatArray]:
        """Logarithm of the power over loads, and most electric power [W].

        Rows are levels, one after the other, of all designs.
        """
        turns, shaft_w = self._propellers()
        parts, air = self._sized_parts(), Air(*(one[np.newaxis] for one in self.air))
        with np.errstate(invalid="ignore", over="ignore"):
            power = np.asarray(power_of_shafts_w(parts, turns, shaft_w, self.bus_v)) / self.factor
            shares = shares_of_limits(parts, turns, shaft_w, self.airspeed_m_per_s, air, self.bus_v)
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

    def _propellers(self) -> tuple[FloatArray, FloatArray]:
        """Speed of rotation [1/s] and power of one shaft [W], ``(load, level, design)``."""
        parts, levels = self._sized_parts(), len(self.thrust_w)
        loads = _LOADS[:, np.newaxis, np.newaxis]
        some = np.arange(levels)
        if parts.is_exact and levels > _LEVELS:
            some = np.unique(np.round(np.linspace(0, levels - 1, _LEVELS)).astype(int))
        air = Air(*(one[some] for one in self.air))
        speed, thrust_w = self.airspeed_m_per_s[some], self.thrust_w[some]
        turns, shaft_w, _ = parts.propeller_state(thrust_w * loads, speed, air)
        if len(some) == levels:
            return np.asarray(turns), np.asarray(shaft_w)
        # Rotation over airspeed and power over thrust power follow the Reynolds number slowly.
        every = np.arange(levels)
        share = np.log(turns / speed), np.log(shaft_w / thrust_w)
        ratios = (np.exp(_through(one, some, every)) for one in share)
        found = next(ratios) * self.airspeed_m_per_s, next(ratios) * self.thrust_w
        return found

    def _sized_parts(self) -> OperatingPointPropulsion:
        """Parts of the designs' own sizes."""
        one = tuple(
            None if size is None else (size if self.count > 1 else float(size[0]))
            for size in self.sizes
        )
        return self.parts.sized(*one)


def _rows_first(values: FloatArray) -> FloatArray:
    """Values of loads, levels and designs with rows of levels and designs first."""
    return np.moveaxis(values, 0, 2).reshape(-1, len(values))


def _cubic(along: FloatArray, nodes: int) -> tuple[IntArray, tuple[FloatArray, ...]]:
    """First of four even nodes around places, and the weights of Lagrange's cubic."""
    place = np.minimum(np.maximum(along, 0.0), nodes - 1.0)
    node = np.minimum(np.maximum(place.astype(int) - 1, 0), nodes - 4)
    t = place - node
    a, b, c = t - 1.0, t - 2.0, t - 3.0
    return node, (-a * b * c / 6.0, t * b * c / 2.0, -t * a * c / 2.0, t * a * b / 6.0)


def _between(along: FloatArray, values: FloatArray) -> FloatArray:
    """Values at places along their last axis."""
    node, weights = _cubic(along, values.shape[-1])
    return np.asarray(sum(one * values[..., node + k] for k, one in enumerate(weights)))


def _through(values: FloatArray, some: IntArray, every: IntArray) -> FloatArray:
    """Values on a second axis at some places, as polynomials at all of them."""
    scale = 2.0 / some[-1]
    known, wanted = (np.vander(scale * one - 1.0, len(some)) for one in (some, every))
    weights = np.linalg.solve(known.T, wanted.T)
    return np.asarray(np.einsum("lsd,sk->lkd", values, weights))


def _continued(values: FloatArray, known: BoolArray) -> FloatArray:
    """Powers along the first axis, loads; unknown ones go on from the next with the load."""
    if known.all():
        return values
    found = np.where(known, values, 1.0)
    count = len(found)
    for order, grow in ((range(1, count), _RATIO), (range(count - 2, -1, -1), 1.0 / _RATIO)):
        done = known[order.start - order.step].copy()
        for k in order:
            take = done & ~known[k]
            found[k] = np.where(take, found[k - order.step] * grow, found[k])
            done |= known[k]
    return found
