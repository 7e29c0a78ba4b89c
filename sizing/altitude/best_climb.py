"""The best course of climbs and glides over a day, as an optimum instead of a rule.

States are the energy of the battery ``E`` and the potential energy ``W`` of
:mod:`sizing.altitude.climb_cycle`; controls are the motor's power ``P``, the power into the battery
``c`` and out of it ``d``. With the solar power ``S``, the constant load ``C``, the propulsion power
of level flight ``R``, and efficiencies of propulsion ``eta``, charge and discharge:

    dW/dt = eta (P - R(W)),   dE/dt = eta_c c - d / eta_d,   P + C + c - d <= S(t, W)

within the ceiling, the propulsion's largest power, the battery and its charge limit, over a day
that ends as it begins. The least charge of the day becomes as large as it can: with the height
that is left then, ``eta_d E + W / eta`` over the load is the time by which the night may be longer.
Direct transcription by the midpoint rule (Betts 2010, Practical Methods for Optimal Control, ch.
4), solved by IPOPT from the day of the better rule. The motor's power that is found, and that of
this rule, are then flown through the day by the levels' own tables; the better flight is the
result.

The airspeed follows from the aircraft's lift coefficient: without wind every other one at which
level flight takes more power is worse at all times.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.altitude.climb_chain import ClimbChain, Place
from sizing.altitude.climb_cycle import ClimbPerformance, climb_performance
from sizing.altitude.climb_day import ClimbCycle
from sizing.altitude.climb_levels import FlightLevels, flight_levels
from sizing.energy.battery import (
    Battery,
    NoChargeLimit,
    RuleChargeLimit,
    Store,
    charge_rate_per_h,
)
from sizing.energy.battery_voltage import FIRST_CHARGE
from sizing.sunlight import UNCORRECTED_CAM, SolarModel
from solar.types import FloatArray

_STEPS = 288  # of 5 min
_FINE = 5  # steps of the simulation in one
_DEGREE = 5  # of polynomials over the potential energy
_CHARGE_POINTS = 41
# Of the largest power: what the roughness of the motor's power costs, to choose among equals.
_SMOOTHNESS = 1e-4
_MISSING_COST = 20.0  # of energy that nothing provides, over the reserve's


@dataclass(frozen=True)
class BestClimb:
    """A day of the best climbs and glides in one scenario.

    ``time_h``, of shape ``(time,)``, and at it ``altitude_m``, ``state_of_charge``,
    ``motor_power_w`` and ``solar_power_w``. ``excess_time_h``: reserve at the least charge of the
    day over the load [h], negative with what is missing where no course repeats itself, infinite
    where a rule's is. ``by_rule_h``: excess times by the rules ``battery_full`` and ``surplus``
    [h]. ``level_h``: at constant altitude. ``scenario``: its place among the mission's.
    """

    scenario: int
    time_h: FloatArray
    altitude_m: FloatArray
    state_of_charge: FloatArray
    motor_power_w: FloatArray
    solar_power_w: FloatArray
    excess_time_h: float
    by_rule_h: dict[str, float]
    level_h: float

    @property
    def gain_h(self) -> float:
        """Excess time beyond the better of the rules [h]."""
        by_rule_h = max(self.by_rule_h.values())
        return 0.0 if np.isinf(by_rule_h) else self.excess_time_h - by_rule_h

    @property
    def full_h(self) -> float:
        """Solar time at which the battery is first full [h]; NaN where it never is."""
        full = np.flatnonzero(self.state_of_charge >= 1.0 - 1e-3)
        return float(self.time_h[full[0]]) if len(full) else np.nan


def best_climb(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    own: ClimbPerformance | None = None,
    scenario: int | None = None,
) -> BestClimb:
    """Find the course of climbs and glides with the largest reserve in one scenario.

    ``own``: flight by the mission's own rule, where it is known. ``scenario``: its place among the
    mission's; that of the least excess time by that rule without it. Raises ``ValueError`` for a
    mission without ``climb``, and ``ClimbLimitError`` for an aircraft that has no power to climb
    with.
    """
    own = climb_performance(aircraft, mission, solar) if own is None else own
    assert mission.climb is not None
    place = own.performance.worst_scenario() if scenario is None else scenario
    rules = {mission.climb.strategy: own}
    for strategy in ("battery_full", "surplus"):
        if strategy not in rules:
            update = {"climb": mission.climb.model_copy(update={"strategy": strategy})}
            other = mission.model_copy(update=update)
            rules[strategy] = climb_performance(aircraft, other, solar)
    by_rule_h: dict[str, float] = {
        name: float(one.performance.cycle.excess_time_h[place]) for name, one in rules.items()
    }
    better = max(rules.values(), key=lambda one: one.performance.cycle.excess_time_h[place])
    day = own.constant.day.at([place])
    levels = flight_levels(aircraft, mission, own.constant.design, day)
    store = own.constant.store.flat((len(own.constant.day.scenarios),)).select(
        slice(place, place + 1)
    )
    task = _Day(np.asarray(day.time_h), levels, store, aircraft.battery)
    rule = _rule_day(better.climb, place)
    flown = max(map(task.flown, (task.by_rule(rule), task.solved(rule))), key=lambda f: f.left_wh)
    excess_h = flown.left_wh / task.nominal_w
    if np.isinf(max(by_rule_h.values())):
        excess_h = np.inf  # no course of a day without a deficit can do better
    return BestClimb(
        scenario=place,
        time_h=flown.time_h,
        altitude_m=np.interp(flown.potential_wh, task.energies_wh, levels.altitude_m),
        state_of_charge=flown.battery_wh / task.full_wh,
        motor_power_w=flown.motor_w,
        solar_power_w=flown.solar_w,
        excess_time_h=excess_h,
        by_rule_h=by_rule_h,
        level_h=float(own.constant.cycle.excess_time_h[place]),
    )


class _Start(NamedTuple):
    """Day of a rule, from which the program starts: at times [h], energies [Wh] and power [W]."""

    time_h: FloatArray
    battery_wh: FloatArray
    potential_wh: FloatArray
    load_w: FloatArray


def _rule_day(rule: ClimbCycle, scenario: int) -> _Start:
    rows = (rule.energy_wh, rule.potential_energy_wh, rule.load_w)
    return _Start(rule.time_h, *(row[scenario] for row in rows))


class _Flown(NamedTuple):
    """A day as the levels' tables have it; the reserve is that at the least charge."""

    time_h: FloatArray
    potential_wh: FloatArray
    battery_wh: FloatArray
    motor_w: FloatArray
    solar_w: FloatArray
    reserve_wh: float
    missing_wh: float

    @property
    def left_wh(self) -> float:
        """What is left at the least charge of the day; less than nothing is what is missing."""
        return -self.missing_wh if self.missing_wh > 0.0 else self.reserve_wh


class _Day:
    """One scenario of one aircraft: its tables, their polynomials, the program and the flight."""

    def __init__(
        self, time_h: FloatArray, levels: FlightLevels, store: Store, battery: Battery
    ) -> None:
        self.store, self.limit = store, battery.charge_limit
        self.nodes_h = np.linspace(0.0, 24.0, _STEPS + 1)
        self.energies_wh = levels.potential_energy_wh[:, 0]
        self.level_w = levels.propulsion_power_w[:, 0]
        rows = []
        for number, light in enumerate(levels.specific_power_w_per_m2[:, 0]):
            cooled = levels.cooling_factor(number)
            power_w = levels.module_area_m2[0] * (light if cooled is None else light * cooled[0])
            rows.append(np.interp(self.nodes_h, time_h, power_w))
        self.sun_w = np.stack(rows)
        self.factor = np.interp(self.nodes_h, time_h, levels.turbulence_factor[0])
        self.constant_w = float(levels.constant_power_w[0])
        self.eta, self.most_w = float(levels.efficiency[0]), float(levels.maximum_power_w[0])
        self.full_wh = float(store.battery_energy_wh[0])
        self.top_wh = float(levels.highest_wh[0])
        self.charge, self.discharge = (
            float(np.ravel(one)[0]) for one in (store.charge_efficiency, store.discharge_efficiency)
        )
        self.nominal_w = float(levels.nominal_load_w[0])
        self.chain, self.bend = levels.chain, 0.0
        if levels.chain is not None:
            self._take_half_charge(levels, levels.chain)

    def _take_half_charge(self, levels: FlightLevels, chain: ClimbChain) -> None:
        """Propulsion by parts for the program: a parabola through level flight and most power."""
        rows, one = np.arange(len(self.level_w)), np.ones(len(self.level_w))
        volts = chain.places(chain.voltage_of(np.full(len(rows), FIRST_CHARGE)))
        self.level_w = chain.power_w(rows, volts, one)
        floor = chain.power_w(rows[:1], volts.at(slice(0, 1)), levels.nominal_factor[:1])
        self.nominal_w = float(floor[0]) + self.constant_w
        self.eta = float(chain.thrust_w[0, 0]) / float(self.level_w[0])
        most_w = min(self.most_w, float(chain.most_w(rows, volts)[0]))
        ratio = max(most_w / float(self.level_w[0]), 1.1)
        load = chain.load(rows[:1], volts.at(slice(0, 1)), ratio * self.level_w[:1])
        self.bend = (float(load[0]) - ratio) / (ratio * (ratio - 1.0))

    def _flight(
        self, potential: float, battery: float, factor: float
    ) -> tuple[float, Callable[[float], float], float]:
        """Power of level flight [W], what a motor's power beyond it lifts by, and the most [W]."""
        if self.chain is None:
            level_w = float(np.interp(potential, self.energies_wh, self.level_w)) * factor
            return level_w, lambda _: self.eta, self.most_w
        chain, last = self.chain, len(self.energies_wh) - 2
        below = min(max(int(np.searchsorted(self.energies_wh, potential)) - 1, 0), last)
        ends = self.energies_wh[below : below + 2]
        upper = np.array([(potential - ends[0]) / (ends[1] - ends[0])])
        volts = chain.places(chain.voltage_of(np.array([battery / self.full_wh])))
        rows = np.array([[below], [below + 1]])
        weights = np.array([1.0 - upper, upper])
        motor_w = (weights * chain.power_w(rows, volts, np.full((2, 1), factor))).sum(axis=0)
        thrust_w = (weights * chain.thrust_w[rows, 0]).sum(axis=0) * factor
        place = Place(chain, rows[0], rows[1], upper, volts, motor_w, thrust_w)
        most_w = float((weights * chain.most_w(rows, volts)).sum())
        return (
            float(motor_w[0]),
            lambda more_w: float(place.gain(np.array([more_w]))[0]),
            max(min(self.most_w, most_w), float(motor_w[0])),
        )

    def solved(self, rule: _Start) -> FloatArray:
        """Motor power of each step [W], and what is stored at midnight [Wh]: the last two."""
        if self.top_wh <= 0.0:  # nothing to climb: the flight gives the power of level flight
            return np.append(np.zeros(_STEPS), [rule.battery_wh[0], 0.0])
        import casadi as ca  # half a second, for this alone

        step_h, scale = 24.0 / _STEPS, self.most_w
        energy, height = (ca.MX.sym(name, _STEPS + 1) for name in "ew")  # relative to full, top
        motor, into, out, missing = (ca.MX.sym(name, _STEPS) for name in ("p", "c", "d", "m"))
        least = ca.MX.sym("z")
        middle = (height[:-1] + height[1:]) / 2.0
        level_w = self._polynomial(middle, self.level_w[:, np.newaxis]) * self._means(self.factor)
        sun_w = self._polynomial(middle, (self.sun_w[:, :-1] + self.sun_w[:, 1:]) / 2.0)
        gained_wh = step_h * (self.charge * into - out / self.discharge) * scale
        power_w = scale * (motor + missing)
        lifted_wh = step_h * self.eta * (power_w - level_w)
        if self.bend:
            lifted_wh += step_h * self.eta * self.bend * power_w * (power_w / level_w - 1.0)
        reserve = self.discharge * self.full_wh * energy
        worth_wh = 24.0 * self.nominal_w
        rows = [
            energy[1:] - energy[:-1] - gained_wh / self.full_wh,
            height[1:] - height[:-1] - lifted_wh / self.top_wh,
            energy[0] - energy[-1],
            height[0] - height[-1],
            sun_w / scale - motor - self.constant_w / scale - into + out,
            reserve / worth_wh - least,
        ]
        equal = 2 * _STEPS + 2
        mean = (energy[:-1] + energy[1:]) / 2.0
        for rate in self._charge_rates(mean):
            rows.append(rate * self.full_wh / scale - self.charge * into)
        rough = ca.sumsqr(motor[1:] - motor[:-1]) + ca.sumsqr(motor[0] - motor[-1])
        cost = -least + _SMOOTHNESS * (rough + step_h * ca.sum1(into + out) / 24.0)
        cost += _MISSING_COST * step_h * scale / worth_wh * ca.sum1(missing)
        x = ca.vertcat(energy, height, motor, into, out, missing, least)
        solver = ca.nlpsol(
            "best_climb",
            "ipopt",
            {"x": x, "f": cost, "g": ca.vertcat(*rows)},
            {
                "print_time": False,
                "ipopt.print_level": 0,
                "ipopt.sb": "yes",
                "ipopt.max_iter": 500,
                "ipopt.mu_strategy": "adaptive",
                # With its safeguard, and with rows of other scales, IPOPT ends in its restoration.
                "ipopt.adaptive_mu_globalization": "never-monotone-mode",
                "ipopt.nlp_scaling_max_gradient": 1.0,
                "ipopt.tol": 1e-6,
                "ipopt.acceptable_tol": 1e-5,
            },
        )
        count = sum(row.shape[0] for row in rows)
        upper = np.full(count, np.inf)
        upper[:equal] = 0.0
        ends = [1.0] * (2 * _STEPS + 2) + [1.0] * _STEPS + [np.inf] * (3 * _STEPS) + [np.inf]
        lower = np.zeros(x.shape[0])
        lower[-1] = -np.inf
        start = self._decisions(rule, worth_wh)
        found: Any = solver(x0=start, lbx=lower, ubx=np.array(ends), lbg=0.0, ubg=upper)
        values = np.ravel(np.asarray(found["x"]))
        motor_w = scale * values[2 * _STEPS + 2 : 3 * _STEPS + 2]
        stored = values[0] * self.full_wh, values[_STEPS + 1] * self.top_wh
        return np.concatenate([motor_w, stored])

    def _decisions(self, rule: _Start, worth_wh: float) -> FloatArray:
        """Decision vector of a rule's day, a little away from its bounds."""
        energy = np.interp(self.nodes_h, rule.time_h, rule.battery_wh) / self.full_wh
        height = np.interp(self.nodes_h, rule.time_h, rule.potential_wh) / self.top_wh
        stored_w = np.diff(energy) * self.full_wh * _STEPS / 24.0
        into, out = np.maximum(stored_w, 0.0) / self.charge, -np.minimum(stored_w, 0.0)
        motor_w = self.by_rule(rule)[:_STEPS]
        powers = np.concatenate([motor_w, into, out * self.discharge]) / self.most_w
        reserve = self.discharge * self.full_wh * energy
        return np.concatenate(
            [energy, height, powers, np.zeros(_STEPS), [reserve.min() / worth_wh]]
        )

    def by_rule(self, rule: _Start) -> FloatArray:
        """Motor power of a rule in each step [W], and what is stored at midnight [Wh]."""
        middles_h = (self.nodes_h[:-1] + self.nodes_h[1:]) / 2.0
        load_w = np.interp(middles_h, rule.time_h[: len(rule.load_w)], rule.load_w)
        motor_w = np.maximum(load_w - self.constant_w, 0.0)
        return np.append(motor_w, [rule.battery_wh[0], rule.potential_wh[0]])

    def flown(self, course: FloatArray) -> _Flown:
        """Fly the motor power of each step through two days, from what is stored at midnight."""
        motor_w, battery, potential = course[:_STEPS], course[-2], course[-1]
        step_h, half = 24.0 / _STEPS / _FINE, 0.5 / _FINE
        rows: list[tuple[float, float, float, float, float]] = []
        missing_wh = 0.0
        for number in range(2 * _STEPS * _FINE):
            if number == _STEPS * _FINE:
                rows, missing_wh = [], 0.0
            step, part = divmod(number % (_STEPS * _FINE), _FINE)
            share = part / _FINE + half
            factor = self.factor[step] + share * (self.factor[step + 1] - self.factor[step])
            level_w, gain, able_w = self._flight(potential, battery, float(factor))
            sun = self.sun_w[:, step] + share * (self.sun_w[:, step + 1] - self.sun_w[:, step])
            sun_w = float(np.interp(potential, self.energies_wh, sun))
            # At the floor the motor gives what level flight takes, at the ceiling no more.
            eta = gain(min(max(float(motor_w[step]), 0.0), able_w) - level_w)
            least_w = level_w - potential / (eta * step_h)
            most_w = min(level_w + (self.top_wh - potential) / (eta * step_h), able_w)
            power_w = min(max(float(motor_w[step]), least_w, 0.0), most_w)
            rows.append((step * 24.0 / _STEPS + part * step_h, potential, battery, power_w, sun_w))
            potential = potential + eta * step_h * (power_w - level_w)
            net_w = sun_w - power_w - self.constant_w
            if net_w >= 0.0:
                battery = float(
                    np.ravel(
                        self.store.charged(np.array([battery]), np.array([net_w * step_h]), step_h)
                    )[0]
                )
            else:
                wanted = -net_w * step_h / self.discharge
                missing_wh += self.discharge * max(wanted - battery, 0.0)
                battery = max(battery - wanted, 0.0)
        time_h, potential_wh, battery_wh, motor, sun_w = np.array(rows).T
        least = int(np.argmin(battery_wh))
        reserve = self.discharge * battery_wh[least] + potential_wh[least] / self.eta
        return _Flown(time_h, potential_wh, battery_wh, motor, sun_w, float(reserve), missing_wh)

    def _polynomial(self, height: Any, values: FloatArray) -> Any:
        """Polynomial through a table over the potential energy, of every step."""
        place = self.energies_wh / self.top_wh
        some = place < 1.0 + place[1]  # heights far above that are not held play no part
        degree = min(_DEGREE, int(some.sum()) - 1)
        coefficients = np.polynomial.polynomial.polyfit(place[some], values[some], degree)
        total: Any = 0.0
        for row in coefficients[::-1]:
            total = total * height + row
        return total

    def _charge_rates(self, soc: Any) -> list[Any]:
        """Limits of the charge over the state of charge [1/h]; the least of them counts."""
        import casadi as ca

        limit = self.limit
        if isinstance(limit, NoChargeLimit):
            return []
        if isinstance(limit, RuleChargeLimit):
            decay = -np.log(limit.relative_rate_at_full) / (1.0 - limit.taper_start)
            constant = limit.c_rate_per_h
            return [constant + 0.0 * soc, constant * ca.exp(-decay * (soc - limit.taper_start))]
        points = np.linspace(0.0, 1.0, _CHARGE_POINTS)
        table = ca.interpolant("rate", "bspline", [points], charge_rate_per_h(limit, points))
        return [table(soc.T).T]

    @staticmethod
    def _means(values: FloatArray) -> FloatArray:
        return (values[:-1] + values[1:]) / 2.0
