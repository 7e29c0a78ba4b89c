"""Energy constraints of one scenario with climbs by day and glides in the evening, as symbols.

The program's counterpart of :mod:`sizing.altitude.climb_march`: battery and potential energy over
the nodes of the lit day, then over the dark in a few steps. Sunlight and the logarithm of the power
of level flight are cubic splines of the potential energy, through the floor and four levels up to
the ceiling; the simulator's are linear between levels at most 500 m apart.

The days close where the night leaves at least the potential energy that the day begins with, which
is a variable of the program. What splines and longer steps do to an excess time is taken back by
the simulator, which decides (:mod:`sizing.optimisation.loop`): a model of low fidelity, corrected
in its value until it agrees with that of high fidelity at the optimum, as in approximation and
model management (Alexandrov, N. M., Lewis, R. M., Gumbert, C. R., Green, L. L. and Newman, P. A.
2001, Approximation and Model Management in Aerodynamic Optimization with Variable-Fidelity Models,
J. Aircraft 38 (6)); its gradient is that of the same physics.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Literal, NamedTuple

import casadi as ca
import numpy as np

from missions.air import GRAVITY_M_PER_S2, MAXIMUM_ALTITUDE_M
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.altitude.climb_levels import climb_limits
from sizing.design import Design, FlightConditions, parametric_design
from sizing.energy.battery import ChargeLimit
from sizing.optimisation.energy_constraints import (
    LEVELS_ALOFT,
    NODES,
    SPLINE,
    charge_step_function,
    flown_as_fast,
    mean_positive,
    powers_of_loads_w,
    spline_basis,
    spline_coefficients,
)
from sizing.smooth import smooth_minimum
from solar.types import FloatArray

Strategy = Literal["battery_full", "surplus"]

# Besides those of flight at one altitude: light aloft.
CLIMB_SUN_PARAMETERS = (1 + SPLINE) * NODES + 3
# Conditions of each level, and how far above the floor it is [m].
_EACH_LEVEL = len(FlightConditions._fields) + 1
ALOFT_PARAMETERS = LEVELS_ALOFT * _EACH_LEVEL
_DARK_STEPS = 24
# Thrust powers over level flight's by which the efficiency of a propulsion by parts is known.
_LEVEL, _CLIMB, _GLIDE = (1.0,), (2.0,), (0.5, 0.25)
_NOTHING = 1e-9
# Of the battery, about what an interval charges next to full: over this climbs begin. With a
# kink there, at every node another one, optima between two heights are seldom found.
_FILLING = 0.002
# Likewise between the climbs that the surplus allows and those that the rated power does.
_BLEND, _TINY_WH = 0.1, 1e-6
_SIMPSON = np.array([1.0, 4.0, 1.0]) / 6.0


class ClimbValues(NamedTuple):
    """What the potential store needs of a design; symbols.

    Power of level flight in calm air at floor and levels [W], potential energy of the ceiling [Wh],
    efficiency and largest power of the propulsion [W], power of avionics and payload [W], and level
    flight's factor of the turbulence of all hours. Thrust power over electric power beyond level
    flight's in climbs, below it in glides with a part of the power, and with so little that the
    motor runs for a part of the time.
    """

    level_w: Any
    ceiling_wh: Any
    efficiency: Any
    maximum_w: Any
    constant_w: Any
    steady: Any
    climbing: Any
    gliding: Any
    intermittent: Any

    @classmethod
    def of(cls, vector: Any) -> ClimbValues:
        """From a vector of all of them."""
        return cls(vector[: LEVELS_ALOFT + 1], *ca.vertsplit(vector)[LEVELS_ALOFT + 1 :])


_CLIMB_VALUES = LEVELS_ALOFT + len(ClimbValues._fields)


def aloft_parameters(mission: Mission, aircraft: Aircraft) -> FloatArray:
    """Conditions at the levels aloft, and their heights above the floor [m]."""
    levels = _levels_aloft(mission)
    parts = [[*FlightConditions.of(there, aircraft), height_m] for there, height_m in levels]
    return np.concatenate(parts)


def block_winds_m_per_s(mission: Mission, scenarios: Scenarios) -> FloatArray:
    """Winds at the floor of every scenario, and where the place is held at the levels aloft.

    Returns of shape ``(scenario, level)``.
    """
    missions = [mission]
    if mission.holds_station and mission.climb is not None:
        missions += [there for there, _ in _levels_aloft(mission)]
    return np.stack([one.scenario_winds_m_per_s(scenarios) for one in missions], axis=-1)


def _levels_aloft(mission: Mission) -> list[tuple[Mission, float]]:
    """Missions at the levels aloft, and their heights above the floor [m]."""
    assert mission.climb is not None
    # The program divides by the height: a ceiling at the floor is a metre above it.
    highest_m = max(mission.climb.ceiling_m - mission.altitude_m, 1.0)
    heights_m = highest_m * np.arange(1, LEVELS_ALOFT + 1) / LEVELS_ALOFT
    floor_m = mission.altitude_m
    return [(mission.at_altitude(min(floor_m + h, MAXIMUM_ALTITUDE_M)), h) for h in heights_m]


def climb_values(
    aircraft: Aircraft,
    design: Design,
    conditions: FlightConditions,
    aloft: Any,
    winds: Any | None = None,
) -> ClimbValues:
    """What the potential store needs of a design of symbols.

    ``aloft``: as :func:`aloft_parameters` gives it. ``winds``: at the floor and the levels, which
    the flight is as fast as; None leaves each level the airspeed of the lift coefficient.
    """

    def flown(there: FlightConditions, own: Design, level: int) -> Design:
        if winds is None:
            return own
        return flown_as_fast(aircraft, there, own, winds[level])

    limits, floor = climb_limits(aircraft, design), flown(conditions, design, 0)
    floor_w, efficiency = floor.propulsion_power_w, limits.efficiency
    power_w, height_m = [floor_w], 0.0
    for level in range(1, LEVELS_ALOFT + 1):
        of_level = aloft[(level - 1) * _EACH_LEVEL : level * _EACH_LEVEL]
        there = FlightConditions(*(of_level[i] for i in range(_EACH_LEVEL - 1)))
        own = parametric_design(aircraft, there, design.variables, design.total_mass_kg)
        one = flown(there, own, level)
        faster = one.airspeed_m_per_s**2 - floor.airspeed_m_per_s**2
        height_m = of_level[_EACH_LEVEL - 1] + faster / (2.0 * GRAVITY_M_PER_S2)
        loads_w = powers_of_loads_w(aircraft, one, there, _LEVEL)
        power_w.append(one.propulsion_power_w if loads_w is None else loads_w[0])
    gains = [efficiency] * 3
    loads_w = powers_of_loads_w(aircraft, floor, conditions, _LEVEL + _CLIMB + _GLIDE)
    if loads_w is not None:
        thrust_w = floor.thrust_power_w
        floor_w, climb_w, partial_w, least_w = loads_w
        power_w[0], efficiency = floor_w, thrust_w / floor_w
        gains = [
            thrust_w * (_CLIMB[0] - 1.0) / (climb_w - floor_w),
            thrust_w * (1.0 - _GLIDE[0]) / (floor_w - partial_w),
            thrust_w * _GLIDE[1] / least_w,
        ]
    return ClimbValues(
        ca.vertcat(*power_w),
        design.total_mass_kg * GRAVITY_M_PER_S2 * height_m / 3600.0,
        *(efficiency, limits.maximum_power_w),
        *(design.constant_power_w, 1.0 + conditions.turbulence, *gains),
    )


@lru_cache(maxsize=32)
def climbing_cycle_function(
    charge_limit: ChargeLimit, strategy: Strategy, *, by_parts: bool = False
) -> ca.Function:
    """Deficit of the night, state of charge after the day, and potential energy.

    Arguments: module area [m2], capacity [Wh], state of charge at dawn, potential energy from which
    the evening's glide begins over that of the ceiling, :class:`ClimbValues` as a vector,
    efficiencies of charge and discharge, the margin of the recharge, and the sun with the light
    aloft (:func:`sizing.optimisation.energy_constraints.sun_parameters`). Returns deficit and
    charge relative to the capacity, the potential energy that the day's surplus reaches over that
    of the ceiling, and the excess time beyond that of the state of charge at dawn [h].
    ``by_parts``: the efficiency follows the load.

    The day begins with less than the night leaves, by the margin times the deficit. Where the
    aircraft climbs once the battery is full, a battery that fills a little later leaves less time
    to climb, and the night after takes more: next to that edge the days do not repeat themselves.
    """
    area, capacity_wh = ca.SX.sym("area"), ca.SX.sym("capacity")
    dawn_soc, height = ca.SX.sym("dawn"), ca.SX.sym("height")
    vector = ca.SX.sym("climb", _CLIMB_VALUES)
    efficiencies, margin = ca.SX.sym("efficiencies", 2), ca.SX.sym("margin")
    sun = ca.SX.sym("sun", CLIMB_SUN_PARAMETERS)
    kind = _DayByParts if by_parts else _Day
    day = kind(area, capacity_wh, ClimbValues.of(vector), sun, efficiencies[0])
    charge = charge_step_function(charge_limit)
    deficit_wh, beyond_h = day.deficit(height)
    deficit = deficit_wh / (efficiencies[1] * capacity_wh)
    begun = dawn_soc - margin * deficit
    soc, reached = day.climbed(begun, height, charge, always=strategy == "surplus")
    return ca.Function(
        "climbing_cycle",
        [area, capacity_wh, dawn_soc, height, vector, efficiencies, margin, sun],
        [deficit, soc, reached, beyond_h],
        {"is_diff_in": [True] * 5 + [False] * 3, "never_inline": True, "jac_penalty": 0},
    )


class _Balance(NamedTuple):
    """Surplus, deficit and the motor's part of it over an interval [Wh].

    Net power at the ends, and that of level flight in calm air [W].
    """

    surplus_wh: Any
    lacking_wh: Any
    of_motor_wh: Any
    left_w: Any
    right_w: Any
    motor_w: Any


class _Day:
    """Power over the nodes at any share of the ceiling's potential energy."""

    def __init__(
        self, area: Any, capacity_wh: Any, values: ClimbValues, sun: Any, charge_efficiency: Any
    ) -> None:
        self.values, self.rate = values, charge_efficiency / capacity_wh
        # Levels are even in height; in energy, speed puts them off by a few thousandths at most.
        self._log_power = ca.mtimes(ca.DM(spline_coefficients()), ca.log(values.level_w))
        rows = [sun[n * NODES : (n + 1) * NODES] for n in (0, *range(2, SPLINE + 1))]
        self._solar_w = area * ca.horzcat(*rows)
        self.factor = values.steady + sun[NODES : 2 * NODES]
        self.step_h, self.dark_h = sun[-3], sun[-2]
        self.nominal_w = values.level_w[0] * values.steady + values.constant_w
        # Electric energy that the height of the ceiling stands for.
        self.store_wh = values.ceiling_wh / values.efficiency

    def motor_w(self, at: Any) -> Any:
        """Power of level flight in calm air at a share of the height [W]."""
        return self._motor_w(spline_basis(at))

    def _motor_w(self, basis: Any) -> Any:
        return ca.exp(ca.dot(self._log_power, basis))

    def balance(self, k: int, at: Any) -> _Balance:
        """What the sun leaves over and lacks between two nodes, at a share of the height."""
        v, basis = self.values, spline_basis(at)
        motor_w = self._motor_w(basis)
        first, last = (ca.dot(self._solar_w[n, :].T, basis) for n in (k, k + 1))
        left = first - motor_w * self.factor[k] - v.constant_w
        right = last - motor_w * self.factor[k + 1] - v.constant_w
        lacking_wh = mean_positive(-left, -right) * self.step_h
        of_avionics_wh = mean_positive(v.constant_w - first, v.constant_w - last) * self.step_h
        surplus_wh = mean_positive(left, right) * self.step_h
        return _Balance(surplus_wh, lacking_wh, lacking_wh - of_avionics_wh, left, right, motor_w)

    def climbed(
        self, soc: Any, height: Any, charge: ca.Function, *, always: bool
    ) -> tuple[Any, Any]:
        """State of charge and height that the day's surplus leads to, without a ceiling."""
        v, reached, before = self.values, 0.0, 0.0
        for k in range(NODES - 1):
            at = ca.fmin(ca.fmax(1.5 * reached - 0.5 * before, 0.0), height)
            one, before = self.balance(k, at), reached
            rates = (self.rate * one.left_w, self.rate * one.right_w)
            charged = charge(soc, self.rate * one.surplus_wh, *rates, self.step_h)
            stored = _at_most_full(charged) - _at_most_full(soc)
            usable_wh = one.surplus_wh - stored / self.rate
            if not always:
                full = 1.0 - (stored + _NOTHING) / (charged - soc + _NOTHING)
                usable_wh = ca.fmin(usable_wh, full * one.surplus_wh)
            mean_w = one.motor_w * (self.factor[k] + self.factor[k + 1]) / 2.0
            room_wh = ca.fmax(v.maximum_w - mean_w, 0.0) * self.step_h
            wanted_wh = ca.fmax(usable_wh, 0.0) + _TINY_WH
            climb_wh = smooth_minimum(wanted_wh, room_wh + _TINY_WH, _BLEND)
            reached = reached + self.lifted(climb_wh)
            soc = charged
        return soc, reached

    def carried(self, k: int) -> Any:
        """Share of an interval in which the sun at the floor carries the load without thermals."""
        first, last = (self._solar_w[n, 0] - self.nominal_w for n in (k, k + 1))
        above = ca.fmax(first, 0.0) + ca.fmax(last, 0.0)
        return above / (ca.fabs(first) + ca.fabs(last) + _NOTHING)

    def lifted(self, climb_wh: Any) -> Any:
        """Share of the ceiling's height that electric energy lifts by."""
        return climb_wh / self.store_wh

    def glided(self, k: int, one: _Balance, share: Any) -> tuple[Any, Any]:
        """Electric energy that sinking saves from a node on [Wh], and the height after it."""
        del k
        glide_wh = ca.fmin(ca.fmax(one.of_motor_wh, 0.0), share * self.store_wh)
        return glide_wh, share - glide_wh / self.store_wh

    def deficit(self, height: Any) -> tuple[Any, Any]:
        """Energy that the battery gives [Wh], and excess time beyond what it has left [h].

        That is what thermals take from it after the morning's equal power, over the nominal load,
        and glides from the height that is left, with avionics and payload on the battery.

        Glides through the evening, the dark and the morning's twilight, in this order.
        """
        v, share, deficit_wh = self.values, height, 0.0
        for k in range(NODES // 2, NODES - 1):
            one = self.balance(k, share)
            glide_wh, share = self.glided(k, one, share)
            deficit_wh = deficit_wh + one.lacking_wh - glide_wh
        hours = self.dark_h / _DARK_STEPS
        for _ in range(_DARK_STEPS):
            sinks = v.steady * hours / self.store_wh
            at = ca.fmax(share - sinks * self.motor_w(share) / 2.0, 0.0)
            wanted_wh = self.motor_w(at) * v.steady * hours
            glide_wh = ca.fmin(wanted_wh, share * self.store_wh)
            share = share - glide_wh / self.store_wh
            deficit_wh = deficit_wh + wanted_wh + v.constant_w * hours - glide_wh
        late_wh: Any = 0.0
        for k in range(NODES // 2):
            one = self.balance(k, share)
            glide_wh, share = self.glided(k, one, share)
            drawn_wh = one.lacking_wh - glide_wh
            late_wh = late_wh + self.carried(k) * drawn_wh
            deficit_wh = deficit_wh + drawn_wh
        at = (0.0, share / 2.0, share)
        slowness = ca.dot(_SIMPSON, ca.vertcat(*(1.0 / self.motor_w(one) for one in at)))
        glide_h = share * v.ceiling_wh * slowness / (v.efficiency * v.steady)
        of_motor = 1.0 - v.constant_w / self.nominal_w
        return deficit_wh, late_wh / self.nominal_w + of_motor * glide_h


class _DayByParts(_Day):
    """Day of a propulsion whose efficiency follows the load.

    The electric power over the thrust power is two straight lines: from level flight down to a
    quarter of its thrust, and below, where the motor runs for a part of the time.
    """

    def lifted(self, climb_wh: Any) -> Any:
        """As by constants, with the efficiency of climbs."""
        return climb_wh * self.values.climbing / self.values.ceiling_wh

    def glided(self, k: int, one: _Balance, share: Any) -> tuple[Any, Any]:
        """As by constants, with that of the power that is left for the motor."""
        v, factor = self.values, (self.factor[k] + self.factor[k + 1]) / 2.0
        saved_wh, level_wh = ca.fmax(one.of_motor_wh, 0.0), one.motor_w * factor * self.step_h
        off_wh = v.efficiency * level_wh - v.intermittent * ca.fmax(level_wh - saved_wh, 0.0)
        sunk = ca.fmin(v.gliding * saved_wh, off_wh) / v.ceiling_wh
        flown = ca.fmin(share / (sunk + _NOTHING), 1.0)
        return flown * saved_wh, share - flown * sunk


def _at_most_full(charged: Any) -> Any:
    """State of charge of a battery that can hold no more than 1, without a kink there."""
    beyond = charged - 1.0
    return charged - (beyond + ca.sqrt(beyond * beyond + _FILLING * _FILLING)) / 2.0
