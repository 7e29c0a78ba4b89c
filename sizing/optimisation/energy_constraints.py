"""Energy constraints of one scenario: the night's deficit and what the day returns, as symbols.

Time runs over nodes between the last dark instant before sunrise and the first one after sunset of
each scenario. Step and darkness are parameters like the sun, so that the function serves any day.
The integrals of surplus and deficit are exact for power that is linear between nodes, as the
simulator's are; the sun's curvature between nodes costs less than 0.01 h of excess time.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import Design, FlightConditions
from sizing.energy.battery import ChargeLimit, NoChargeLimit, RuleChargeLimit, TableChargeLimit
from sizing.held_station import flown_faster
from sizing.smooth import Value, smooth_maximum
from sizing.sunlight import SolarDay
from sizing.varying_load import thermal_shape
from solar.types import BoolArray, FloatArray

# 10 min apart on a day of 16 h.
NODES = 97
SUN_PARAMETERS = 2 * NODES + 3
# From the floor of climbs to the ceiling, evenly spaced, without the floor.
LEVELS_ALOFT = 4
# Coefficients of the spline through floor and levels.
SPLINE = LEVELS_ALOFT + 2
_SAME_POWER = 1e-6  # relative
# Keeps an interval without any charge from dividing by zero [state of charge].
_NOTHING = 1e-12
# Extra thrust power by thermals for which a program's straight line is exact: the power bends from
# it by a few thousandths between none and half of level flight's.
_THERMAL = 0.25
# Width in which the airspeed bends from the own to that of the wind, relative. Optima just as fast
# as the wind are common, and at a kink none was found.
_OF_WIND = 1e-3


class _Taken(NamedTuple):
    """What the charger takes over an interval, and its rate at both ends [1/h]."""

    charge: Any
    first_rate: Any
    last_rate: Any


class NodeBalance(NamedTuple):
    """Solar power less load at the nodes [W], what is lacking [Wh], step and darkness [h]."""

    net_w: Any
    deficit_wh: Any
    step_h: Any
    dark_h: Any


Charger = Callable[[Any, Any], _Taken]


def sun_parameters(day: SolarDay, mission: Mission, sunlit: Collection[int] = ()) -> FloatArray:
    """Sun, thermals, step and darkness of every scenario.

    ``sunlit``: scenarios in which the sun must carry the nominal load at all times. Returns
    specific power [W/m2] and extra propulsion power [-] at the nodes, on missions with climbs the
    light aloft, step between nodes [h], hours without light, and the specific power that must
    carry the nominal load: the lowest one of the day in the scenarios of ``sunlit``, else 0 [W/m2].
    """
    thermal = mission.turbulence.thermal * thermal_shape(day.time_h, day.sunrise_h, day.sunset_h)
    thermal = np.broadcast_to(thermal, day.specific_power_w_per_m2.shape)
    active = (day.specific_power_w_per_m2 > 0.0) | (thermal > 0.0)
    suns = np.stack(
        [
            _one_scenario(day, *rows)
            for rows in zip(range(len(thermal)), thermal, active, strict=True)
        ]
    )
    some = list(sunlit)
    suns[some, -1] = lowest_power(day)[some]
    return suns


def lowest_power(day: SolarDay) -> FloatArray:
    """Lowest specific power of the day, 0 where there is a night [W/m2], shape ``(scenario,)``."""
    return np.asarray(day.specific_power_w_per_m2.min(axis=-1))


def growing_lit_sets(lowest_w_per_m2: FloatArray) -> list[list[int]]:
    """Sets of scenarios in which the sun may carry the load at all times, each one in the next.

    The load in calm air is the same in all scenarios. Whatever design is always lit in one of them
    therefore is so in those with a higher lowest power: no other sets need be looked at.

    ``lowest_w_per_m2``: lowest specific power of the day, 0 where there is a night [W/m2]. Returns
    indices of the scenarios, that with the most power first; empty where all have a night.
    """
    order = [int(i) for i in np.argsort(-lowest_w_per_m2, kind="stable")]
    power = lowest_w_per_m2[order]
    ends = [
        n
        for n, value in enumerate(power, start=1)
        if value > 0.0 and (n == len(power) or power[n] < value * (1.0 - _SAME_POWER))
    ]
    return [order[:n] for n in ends]


def _one_scenario(day: SolarDay, number: int, thermal: FloatArray, active: BoolArray) -> FloatArray:
    """Parameters of one scenario: light, thermals, light aloft if any, step, darkness."""
    time_h = day.time_h
    sunlit = np.flatnonzero(active)
    first = max(int(sunlit[0]) - 1, 0) if len(sunlit) else 0
    last = min(int(sunlit[-1]) + 1, len(time_h) - 1) if len(sunlit) else len(time_h) - 1
    begin_h, lit_h = time_h[first], float(time_h[last] - time_h[first])
    light = day.specific_power_w_per_m2[number]
    if active.all():
        # Without a night the day begins where the sun carries least: in thermals that may be noon.
        begin_h = time_h[np.argmin(light / (1.0 + thermal))]
    nodes = begin_h + np.linspace(0.0, lit_h, NODES)
    rows = [light, thermal]
    if day.aloft_w_per_m2 is not None:
        rows += list(_spline_of_light(day.aloft_w_per_m2[:, number]))
    found = [np.interp(nodes, time_h, row, period=24.0) for row in rows]
    return np.concatenate([*found, [lit_h / (NODES - 1), 24.0 - lit_h, 0.0]])


def _spline_of_light(light: FloatArray) -> FloatArray:
    """Coefficients of the spline through light aloft, after the first: that at the floor.

    ``light``: at evenly spaced levels, the first of them the floor, and linear between them.
    """
    own = np.linspace(0.0, len(light) - 1.0, LEVELS_ALOFT + 1)
    below = np.minimum(own.astype(int), len(light) - 2)
    upper = (own - below)[:, np.newaxis]
    found = (1.0 - upper) * light[below] + upper * light[below + 1]
    return np.asarray(spline_coefficients() @ found)[1:]


def light_of_days(suns: FloatArray, heights: FloatArray) -> FloatArray:
    """Sum of a day's light at the floor and at a share of the height, of every scenario.

    ``suns``: their parameters.
    """
    rows = np.delete(suns[:, :-3].reshape(len(suns), -1, NODES).sum(axis=-1), 1, axis=1)
    basis = np.hstack([np.asarray(ca.DM(spline_basis(h))) for h in heights.tolist()])
    aloft = np.sum(rows * basis[: rows.shape[1]].T, axis=1)
    return np.stack([rows[:, 0], aloft])


@lru_cache(maxsize=1)
def spline_coefficients() -> FloatArray:
    """Matrix from values at floor and levels to coefficients of a natural cubic spline.

    Those are of 1, of the share of the way to the ceiling, and of the cubes of its positive parts
    beyond the floor and each level but the last (truncated power basis: de Boor, C. 1978, A
    Practical Guide to Splines, ch. VIII).
    """
    places = np.linspace(0.0, 1.0, LEVELS_ALOFT + 1)
    knots = places[:-1]
    cubes = np.maximum(places[:, np.newaxis] - knots, 0.0) ** 3
    through = np.column_stack([np.ones_like(places), places, cubes])
    straight = np.concatenate([[0.0, 0.0], 1.0 - knots])  # at the ceiling; at the floor all are
    return np.asarray(np.linalg.inv(np.vstack([through, straight]))[:, :-1])


def spline_basis(share: Any) -> Any:
    """Functions that the coefficients of a spline belong to, of a symbol."""
    places = np.linspace(0.0, 1.0, LEVELS_ALOFT + 1)[:-1]
    return ca.vertcat(1.0, share, *(ca.fmax(share - place, 0.0) ** 3 for place in places))


@lru_cache(maxsize=32)
def cycle_function(charge_limit: ChargeLimit) -> ca.Function:
    """Deficit of the night and state of charge after the day, relative to the capacity.

    Every scenario shares it, and every aircraft whose battery is charged alike, so that its
    derivatives are built once. Arguments: module area [m2], capacity [Wh], nominal load and
    propulsion power [W], state of charge at dawn, efficiencies of charge and discharge, and the sun
    as :func:`sun_parameters` gives it.
    """
    area, capacity_wh = ca.SX.sym("area"), ca.SX.sym("capacity")
    nominal_w, propulsion_w = ca.SX.sym("nominal"), ca.SX.sym("propulsion")
    dawn_soc, sun = ca.SX.sym("dawn"), ca.SX.sym("sun", SUN_PARAMETERS)
    efficiencies = ca.SX.sym("efficiencies", 2)
    balance = node_balance(area, nominal_w, propulsion_w, sun)
    deficit = balance.deficit_wh / (efficiencies[1] * capacity_wh)
    rate = efficiencies[0] * balance.net_w / capacity_wh
    charged = charge_path(charge_limit, dawn_soc, rate, balance.step_h)[-1]
    return ca.Function(
        "cycle",
        [area, capacity_wh, nominal_w, propulsion_w, dawn_soc, efficiencies, sun],
        [deficit, charged],
        # Efficiencies and sun are data: they need no derivatives. The whole Jacobian takes three
        # fifths of the time of its five columns one by one.
        {"is_diff_in": [True] * 5 + [False] * 2, "never_inline": True, "jac_penalty": 0},
    )


def node_balance(area: Any, nominal_w: Any, propulsion_w: Any, sun: Any) -> NodeBalance:
    """Power of a scenario's nodes, and the energy that the sun lacks over the day."""
    step_h, dark_h = sun[2 * NODES], sun[2 * NODES + 1]
    net = area * sun[:NODES] - nominal_w - propulsion_w * sun[NODES : 2 * NODES]
    lacking = mean_positive(-net[:-1], -net[1:])
    deficit_wh = ca.sum1(lacking) * step_h + dark_h * nominal_w
    return NodeBalance(net, deficit_wh, step_h, dark_h)


def smooth_loads_w(
    aircraft: Aircraft, design: Design, conditions: FlightConditions
) -> tuple[Value, Value]:
    """Nominal load, and more of it per extra thrust power over that of level flight [W].

    Of numbers, arrays or symbols. The efficiency of parts is that of the turbulence of all hours at
    the voltage of a half charged battery; in thermals the load is a straight line from there.
    """
    steady = 1.0 + conditions.turbulence
    found = powers_of_loads_w(aircraft, design, conditions, (steady, steady + _THERMAL))
    if found is None:
        return design.load_in_turbulence_w(conditions.turbulence), design.propulsion_power_w
    calm_w, rough_w = found
    return calm_w + design.constant_power_w, (rough_w - calm_w) / _THERMAL


def powers_of_loads_w(
    aircraft: Aircraft, design: Design, conditions: FlightConditions, loads: Sequence[Value]
) -> list[Value] | None:
    """Electric power of thrust powers over that of level flight, with a half charged battery [W].

    Of numbers, arrays or symbols; None for constant efficiencies.
    """
    if (propulsion := aircraft.propulsion_by_parts) is None:
        return None
    thrust_w = design.thrust_power_w
    own = propulsion.sized(*design.variables.of_propulsion)
    bus_v = aircraft.battery.nominal_voltage_v
    speed, air = design.airspeed_m_per_s, conditions.air
    return [own.bus_power_w(thrust_w * load, speed, air, bus_v) for load in loads]


def flown_as_fast(
    aircraft: Aircraft, conditions: FlightConditions, design: Design, wind_m_per_s: Any
) -> Design:
    """Design of symbols as fast as the wind, or at its own airspeed if that is faster."""
    ratio = smooth_maximum(wind_m_per_s / design.airspeed_m_per_s, 1.0, _OF_WIND)
    return flown_faster(aircraft, conditions, design, ratio)


def mean_positive(left: Any, right: Any) -> Any:
    """Mean positive part of what is linear over an interval, as in :mod:`sizing.energy.march`."""
    positive = ca.fmax(left, 0.0) + ca.fmax(right, 0.0)
    total = ca.fabs(left) + ca.fabs(right)
    return positive * positive / (2.0 * total + 1e-9)


def charge_path(limit: ChargeLimit, dawn_soc: Any, rate: Any, step_h: Any) -> list[Any]:
    """State of charge at the nodes that a day's surplus leads to, beyond 1 where the sun allows it.

    ``rate`` is what the sun offers at the nodes [1/h], negative where it does not carry the load.
    """
    gains = mean_positive(rate[:-1], rate[1:]) * step_h
    path = [dawn_soc]
    if isinstance(limit, NoChargeLimit):
        return path + ca.vertsplit(dawn_soc + ca.cumsum(gains))
    step = charge_step_function(limit)
    for k in range(NODES - 1):
        path.append(step(path[-1], gains[k], rate[k], rate[k + 1], step_h))
    return path


def charge_step_function(limit: ChargeLimit) -> ca.Function:
    """State of charge after an interval, beyond 1 where the sun allows it.

    Arguments: state of charge at its start, gain that the sun offers, rates of that at both ends
    [1/h], and hours.
    """
    if isinstance(limit, NoChargeLimit):
        soc, gain, rest = ca.SX.sym("soc"), ca.SX.sym("gain"), ca.SX.sym("rest", 3)
        return ca.Function("charge", [soc, gain, *ca.vertsplit(rest)], [soc + gain])
    return _charge_step(_by_rule(limit) if isinstance(limit, RuleChargeLimit) else _by_table(limit))


def _charge_step(charger: Charger) -> ca.Function:
    """Charge over one interval: at each instant what the sun gives or the charger takes, the less.

    With both linear in time, sun above charger for an area ``above`` and below it for ``below``,
    the charge is the sun's gain less ``above``, and also the charger's less ``below``. The two
    differ where a rate is not quite linear. Weighted so that the sun alone decides where it is
    always below, the charger where it is, and nothing has a kink in between.
    """
    soc, gain, hours = ca.SX.sym("soc"), ca.SX.sym("gain"), ca.SX.sym("hours")
    left, right = ca.SX.sym("left"), ca.SX.sym("right")
    taken = charger(soc, hours)
    above = mean_positive(left - taken.first_rate, right - taken.last_rate) * hours
    below = mean_positive(taken.first_rate - left, taken.last_rate - right) * hours
    by_sun, by_charger = gain - above, taken.charge - below
    charge = (below * by_sun + above * by_charger) / (above + below + _NOTHING)
    return ca.Function("charge", [soc, gain, left, right, hours], [soc + charge])


def _by_rule(limit: RuleChargeLimit) -> Charger:
    """Follow the constant-current rule and its exponential taper, in closed form."""
    rate, start = limit.c_rate_per_h, limit.taper_start
    decay = float(-np.log(limit.relative_rate_at_full) / (1.0 - start))
    if decay == 0.0:  # no taper: the constant rate all the way
        return lambda soc, hours: _Taken(rate * hours, rate, rate)
    knee_h = start / rate

    def charger(soc: Any, hours: Any) -> _Taken:
        slowed = ca.exp(decay * ca.fmax(soc - start, 0.0))
        clock = ca.fmin(soc, start) / rate + (slowed - 1.0) / (decay * rate) + hours
        slowed_at_end = 1.0 + decay * rate * ca.fmax(clock - knee_h, 0.0)
        end = rate * ca.fmin(clock, knee_h) + ca.log(slowed_at_end) / decay
        return _Taken(end - soc, rate / slowed, rate / slowed_at_end)

    return charger


def _by_table(limit: TableChargeLimit) -> Charger:
    """Follow a measured charge limit: midpoint rule on the piecewise linear rate."""
    soc_knots = np.asarray(limit.state_of_charge)
    rates = np.asarray(limit.current_a) * limit.voltage_v / limit.pack_energy_wh

    def rate(soc: Any) -> Any:
        result = rates[0]
        for i in range(len(rates) - 1):
            slope = (rates[i + 1] - rates[i]) / (soc_knots[i + 1] - soc_knots[i])
            run = ca.fmin(ca.fmax(soc - soc_knots[i], 0.0), soc_knots[i + 1] - soc_knots[i])
            result = result + slope * run
        return result

    def charger(soc: Any, hours: Any) -> _Taken:
        # Three sub-steps: the measured rates fall by half within two percent of charge.
        end = soc
        for _ in range(3):
            step_h = hours / 3.0
            middle = end + step_h / 2.0 * rate(end)
            end = end + step_h * rate(middle)
        return _Taken(end - soc, rate(soc), rate(end))

    return charger
