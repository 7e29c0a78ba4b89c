"""How far a design is from every requirement on it.

Besides what is demanded, two margins that a design office looks at: airspeed over stall speed, and
climb at the highest altitude and with an empty battery.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from missions.air import GRAVITY_M_PER_S2
from missions.mission import Mission
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.design import Design, bus_voltage_v
from sizing.limits import QUANTITIES, DesignInFlight
from sizing.mass_budget import parametric_design
from sizing.parameters import label, unit, unit_text
from sizing.performance import Performance

# Take-off safety speed over stall speed, CS-23.51 and 14 CFR 23.51 (amendment 62).
RECOMMENDED_STALL_MARGIN = 1.2
# Thrusts over that of level flight in which the largest is searched for.
_THRUSTS, _COARSE = np.geomspace(1.0, 30.0, 241), 16


class RequirementMargin(NamedTuple):
    """A requirement: value, limit, and by how much it is met.

    ``margin`` is relative to the limit, in the unit where ``relative`` is false; below 0 where the
    requirement is missed. ``recommended``: nobody demands it.
    """

    name: str
    label: str
    value: float
    limit: float
    unit: str
    margin: float
    relative: bool = True
    recommended: bool = False


def requirement_margins(
    aircraft: Aircraft, performance: Performance, required_h: float
) -> list[RequirementMargin]:
    """Return the margins of a single simulated design.

    ``aircraft``: with the technology of the design. ``required_h``: excess time that is required of
    every scenario [h].
    """
    mission, design, worst = performance.mission, performance.design, performance.worst_scenario()
    excess_h = float(performance.cycle.excess_time_h[worst])
    charge_percent = 100.0 * float(performance.cycle.minimum_state_of_charge[worst])
    at = performance.worst_label
    charge_name, charge_label = "minimum_state_of_charge", f"minimum state of charge, {at}"
    margins = [
        _absolute("excess_time_h", f"excess time, {at}", excess_h, required_h, "h"),
        _absolute(charge_name, charge_label, charge_percent, 0.0, "%"),
    ]
    winds = mission.wind_to_beat_m_per_s(mission.scenario_winds_m_per_s(performance.day.scenarios))
    wind = float(np.max(winds))
    if wind > 0.0 and design.airspeed_m_per_s is not None:
        speed = float(design.airspeed_m_per_s)
        name, text = "airspeed_above_wind", "airspeed above the wind"
        margins.append(_at_least(name, text, speed, wind, "m/s"))
    if isinstance(aircraft.airframe, ParametricAirframe):
        margins += _of_parametric(aircraft, mission, design)
    return margins


def _of_parametric(
    aircraft: Aircraft, mission: Mission, design: Design
) -> Iterator[RequirementMargin]:
    flight = DesignInFlight(aircraft, design)
    covered = float(design.variables.module_area_m2 / design.wing_area_m2)
    most = aircraft.parametric.maximum_module_coverage
    yield _at_most("module_coverage", "modules over wing area", covered, most, "")
    limits = aircraft.design_space.limit_rows()
    for name, limit in limits.items():
        value, of = float(QUANTITIES[limit.quantity](flight)), unit_text(unit(limit.quantity))
        margin = _at_least if limit.end == "minimum" else _at_most
        yield margin(name, label(limit.quantity), value, limit.value, of)
    if not any(limit.quantity == "stall_margin" for limit in limits.values()):
        least = RECOMMENDED_STALL_MARGIN
        margin_of_stall = _at_least(
            "stall_margin", label("stall_margin"), float(flight.stall_margin), least, ""
        )
        yield margin_of_stall._replace(recommended=True)
    yield from _of_propulsion(aircraft, mission, design, float(design.rated_power_w))


def _of_propulsion(
    aircraft: Aircraft, mission: Mission, design: Design, rated_w: float
) -> Iterator[RequirementMargin]:
    """Yield the climb at the highest altitude: at rated power, and with an empty battery.

    Then the limits of parts in level flight with an empty battery.
    """
    highest_m = mission.ceiling_m
    there = mission.at_altitude(highest_m) if highest_m > mission.altitude_m else mission
    mass_kg = float(design.total_mass_kg)
    level = parametric_design(aircraft, there, design.variables, mass_kg)
    assert level.chain is not None
    weight_n = mass_kg * GRAVITY_M_PER_S2
    excess_w = (rated_w - float(level.propulsion_power_w)) * float(level.chain.efficiency)
    at = f"at {highest_m:g} m"
    name, text = "climb_rate_at_highest_altitude_m_per_s", f"climb rate at rated power {at}"
    yield _absolute(name, text, excess_w / weight_n, 0.0, "m/s")._replace(recommended=True)
    if (propulsion := aircraft.propulsion_by_parts) is None:
        return
    thrust_w = float(level.thrust_power_w)
    speed, air = float(level.airspeed_m_per_s), level.conditions.air
    chosen = propulsion.sized(*design.variables.mapped(float).of_propulsion)
    empty_v, _ = bus_voltage_v(aircraft)
    most, thrusts = np.nan, _THRUSTS[::_COARSE]
    for _ in range(2):
        points = chosen.point(thrust_w * thrusts, speed, air, (empty_v, empty_v))
        able = np.flatnonzero(np.asarray(points.reason) == "")
        if not able.size:
            break
        most = float(thrusts[able[-1]])
        # The thrusts up to the next of the coarse ones.
        thrusts = _THRUSTS[(most <= _THRUSTS)][:_COARSE]
    name, text = "climb_rate_with_empty_battery_m_per_s", f"climb rate, empty battery, {at}"
    climb = (most - 1.0) * thrust_w / weight_n
    yield _absolute(name, text, climb, 0.0, "m/s")._replace(recommended=True)
    thrust_w = float(design.thrust_power_w)
    speed, air = float(design.airspeed_m_per_s), design.conditions.air
    point = chosen.point(thrust_w, speed, air, (empty_v, empty_v))
    yield _at_most("duty", "duty of the controller, empty battery", float(point.duty), 1.0, "")
    mach = chosen.maximum_tip_mach
    yield _at_most("tip_mach", "Mach number of the tips", float(point.tip_mach), mach, "")
    current = chosen.motor_constants.maximum_current_a
    if current is not None:
        used = float(point.motor_current_a)
        yield _at_most("motor_current", "current of the motor", used, current, "A")


def _absolute(name: str, text: str, value: float, limit: float, of: str) -> RequirementMargin:
    return RequirementMargin(name, text, value, limit, of, value - limit, relative=False)


def _at_least(name: str, text: str, value: float, limit: float, of: str) -> RequirementMargin:
    return RequirementMargin(name, text, value, limit, of, value / limit - 1.0)


def _at_most(name: str, text: str, value: float, limit: float, of: str) -> RequirementMargin:
    return RequirementMargin(name, text, value, limit, of, 1.0 - value / limit)
