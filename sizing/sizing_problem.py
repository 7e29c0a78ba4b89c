"""The sizing problem as a small nonlinear program.

Variables are wingspan, battery mass, module area, total mass (and the aspect ratio on request), the
state of charge at dawn of every scenario, and the worst excess time. The sun enters as specific
power per module area, which no design variable changes, so that a whole day of a scenario is a
parameter vector. Energy over the day is integrated exactly as the simulator does it
(:func:`sizing.energy_balance.positive_part_wh` is the same expression):

* the night's deficit must fit into the battery, ``soc_dawn + deficit <= 1``;
* the day's surplus must bring it back, ``soc_dawn + deficit <= soc after charging from soc_dawn``,
  with the charge limit followed step by step.

Both together say that the cycle repeats itself with at least ``soc_dawn``, and the excess time is
the energy at dawn over the load. Slack variables, held at zero in the sizing itself, turn the same
program into the question by how much the requirements are missed.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import casadi as ca
import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft, ParametricAirframe, Range
from sizing.battery import RuleChargeLimit, TableChargeLimit
from sizing.design import Design, DesignVariables, parametric_design, thermal_shape
from sizing.energy_balance import FloatArray
from sizing.performance import SolarDay

# The charge limit is followed in steps of about this length; surplus is integrated exactly.
_CHARGE_STEP_H = 0.25
# Half-width of the smooth minimum of solar-limited and charger-limited charging [state of charge].
_BLEND = 1e-5


class Objective(StrEnum):
    """What the optimiser is asked for."""

    max_excess_time = "max_excess_time"
    min_wingspan = "min_wingspan"
    min_mass = "min_mass"


@dataclass(frozen=True)
class Constraint:
    """A named requirement ``value >= 0`` of the program, scaled to order one."""

    name: str
    scenario: int | None = None


@dataclass(frozen=True)
class SizingProblem:
    """A built program; see the module's docstring.

    Attributes
    ----------
    solver : casadi.Function
        IPOPT on the program, silent.
    variable_names : tuple of str
        Design variables that are free, in the order of the decision vector.
    constraints : tuple of Constraint
        In the order of the constraint vector.
    """

    solver: ca.Function
    objective: Objective
    variable_names: tuple[str, ...]
    bounds: tuple[Range, ...]
    constraints: tuple[Constraint, ...]
    scenario_count: int
    parameters: FloatArray
    fixed_aspect_ratio: float | None

    @property
    def slack_names(self) -> tuple[str, ...]:
        """Requirements that the elastic program may miss, in the order of the slacks."""
        named = (c.name for c in self.constraints)
        return tuple(dict.fromkeys(named))


def build_problem(
    aircraft: Aircraft,
    mission: Mission,
    day: SolarDay,
    objective: Objective,
    required_excess_time_h: float,
) -> SizingProblem:
    """Build the program of an aircraft, a mission and an objective.

    Raises
    ------
    TypeError
        For a measured aircraft.
    """
    airframe = aircraft.airframe
    if not isinstance(airframe, ParametricAirframe):
        raise TypeError(f"{aircraft.name} is a measured aircraft: it has no mass budget to size")
    names, bounds = _free_variables(aircraft)
    count = len(day.scenarios)
    logs = ca.SX.sym("log_design", len(names))
    dawn_soc = ca.SX.sym("dawn_state_of_charge", count)
    worst_h = ca.SX.sym("worst_excess_time_h")
    values = {name: ca.exp(logs[i]) for i, name in enumerate(names)}
    variables = DesignVariables(
        wingspan_m=values["wingspan_m"],
        aspect_ratio=values.get("aspect_ratio", airframe.aspect_ratio),
        battery_mass_kg=values["battery_mass_kg"],
        module_area_m2=values["module_area_m2"],
    )
    design = parametric_design(aircraft, mission, variables, values["total_mass_kg"])
    lit = [_LitScenario.of(day, mission, i) for i in range(count)]
    power = [ca.SX.sym(f"specific_power_{i}", len(s.time_h)) for i, s in enumerate(lit)]

    rows: list[tuple[Constraint, Any]] = [
        (Constraint(name), value) for name, value in _design_rows(aircraft, mission, design)
    ]
    for i, scenario in enumerate(lit):
        cycle = _scenario_rows(aircraft, mission, design, scenario, power[i], dawn_soc[i])
        excess_h = cycle.pop("excess_time")
        rows.extend((Constraint(name, i), value) for name, value in cycle.items())
        goal = worst_h if objective is Objective.max_excess_time else required_excess_time_h
        # In tenths of the day so that all rows are of order one.
        rows.append((Constraint("excess_time", i), (excess_h - goal) / 2.4))
    constraints = tuple(constraint for constraint, _ in rows)
    slack_names = tuple(dict.fromkeys(c.name for c in constraints))
    slack = ca.SX.sym("slack", len(slack_names))
    relaxed = [value + slack[slack_names.index(c.name)] for c, value in rows]
    relaxed[0] = rows[0][1] + slack[0]
    elastic = ca.SX.sym("elastic")
    cost = {
        Objective.max_excess_time: -worst_h / 24.0,
        Objective.min_wingspan: logs[names.index("wingspan_m")],
        Objective.min_mass: logs[names.index("total_mass_kg")],
    }[objective]
    # The dawn states of scenarios that do not bind are otherwise undetermined.
    tie_break = -1e-7 * ca.sum1(dawn_soc)
    program = {
        "x": ca.vertcat(logs, dawn_soc, worst_h, slack),
        "p": ca.vertcat(elastic, *power),
        "f": (1.0 - elastic) * (cost + tie_break) + elastic * ca.sum1(slack),
        "g": ca.vertcat(*relaxed),
    }
    parameters = np.concatenate(
        [day.specific_power_w_per_m2[i, s.nodes] for i, s in enumerate(lit)]
    )
    return SizingProblem(
        solver=ca.nlpsol("sizing", "ipopt", program, _IPOPT_OPTIONS),
        objective=objective,
        variable_names=names,
        bounds=bounds,
        constraints=constraints,
        scenario_count=count,
        parameters=parameters,
        fixed_aspect_ratio=None if "aspect_ratio" in names else airframe.aspect_ratio,
    )


_IPOPT_OPTIONS = {
    "print_time": False,
    "error_on_fail": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.max_iter": 200,
    "ipopt.tol": 1e-8,
    "ipopt.acceptable_tol": 1e-6,
    "ipopt.acceptable_iter": 8,
    "ipopt.mu_strategy": "adaptive",
}


def _free_variables(aircraft: Aircraft) -> tuple[tuple[str, ...], tuple[Range, ...]]:
    space = aircraft.design_space
    heaviest = space.maximum_total_mass_kg or 40.0 * space.battery_mass_kg.maximum
    chosen = {
        "wingspan_m": space.wingspan_m,
        "battery_mass_kg": space.battery_mass_kg,
        "module_area_m2": space.module_area_m2,
        "total_mass_kg": Range(minimum=space.battery_mass_kg.minimum, maximum=heaviest),
    }
    if space.aspect_ratio is not None:
        chosen["aspect_ratio"] = space.aspect_ratio
    return tuple(chosen), tuple(chosen.values())


def _design_rows(
    aircraft: Aircraft, mission: Mission, design: Design
) -> list[tuple[str, Any]]:
    """Requirements on the design itself; the mass budget, an equation, comes first."""
    airframe, space = aircraft.airframe, aircraft.design_space
    assert isinstance(airframe, ParametricAirframe)
    covered = airframe.maximum_module_coverage * design.wing_area_m2
    rows = [
        ("mass_budget", 1.0 - design.masses.total_kg / design.total_mass_kg),
        ("module_coverage", 1.0 - design.variables.module_area_m2 / covered),
    ]
    if mission.wind_m_per_s > 0.0:
        rows.append(("airspeed_above_wind", design.airspeed_m_per_s / mission.wind_m_per_s - 1.0))
    if space.maximum_wing_loading_kg_per_m2 is not None:
        loading = design.total_mass_kg / design.wing_area_m2
        rows.append(("wing_loading", 1.0 - loading / space.maximum_wing_loading_kg_per_m2))
    return rows


@dataclass(frozen=True)
class _LitScenario:
    """The part of a scenario's day in which there is sun or thermal turbulence."""

    nodes: slice
    time_h: FloatArray
    thermal: FloatArray
    dark_h: float

    @classmethod
    def of(cls, day: SolarDay, mission: Mission, index: int) -> _LitScenario:
        shape = thermal_shape(day.time_h, day.sunrise_h[index], day.sunset_h[index])
        thermal = mission.turbulence.thermal * shape
        active = np.flatnonzero((day.specific_power_w_per_m2[index] > 0.0) | (thermal > 0.0))
        first = max(int(active[0]) - 1, 0) if len(active) else 0
        last = min(int(active[-1]) + 1, len(day.time_h) - 1) if len(active) else 1
        nodes = slice(first, last + 1)
        time_h = day.time_h[nodes]
        return cls(nodes, time_h, thermal[nodes], 24.0 - float(time_h[-1] - time_h[0]))


def _scenario_rows(
    aircraft: Aircraft,
    mission: Mission,
    design: Design,
    scenario: _LitScenario,
    power: Any,
    dawn_soc: Any,
) -> dict[str, Any]:
    """Requirements of one scenario's cycle, and its excess time [h]."""
    nominal_w = design.nominal_load_w(mission)
    net = (
        design.variables.module_area_m2 * power
        - nominal_w
        - design.propulsion_power_w * scenario.thermal
    )
    hours = np.diff(scenario.time_h)
    battery = aircraft.battery
    energy_wh = design.battery_energy_wh
    deficit_wh = ca.sum1(_positive_part_wh(-net, hours)) + scenario.dark_h * nominal_w
    deficit = deficit_wh / (battery.discharge_efficiency * energy_wh)
    gains = battery.charge_efficiency * _positive_part_wh(net, hours) / energy_wh
    charged = _charged(aircraft, dawn_soc, gains, hours)
    return {
        "battery_capacity": 1.0 - dawn_soc - deficit,
        "energy_balance": charged - dawn_soc - deficit,
        "excess_time": dawn_soc * energy_wh * battery.discharge_efficiency / nominal_w,
    }


def _positive_part_wh(net: Any, hours: FloatArray) -> Any:
    """Symbolic twin of :func:`sizing.energy_balance.positive_part_wh` over all intervals."""
    left, right = net[:-1], net[1:]
    positive = ca.fmax(left, 0.0) + ca.fmax(right, 0.0)
    total = ca.fabs(left) + ca.fabs(right)
    return positive * positive / (2.0 * total + 1e-9) * hours


def _charged(aircraft: Aircraft, dawn_soc: Any, gains: Any, hours: FloatArray) -> Any:
    """State of charge that a day's surplus leads to, beyond 1 where the sun would allow it."""
    limit = aircraft.battery.charge_limit
    if isinstance(limit, RuleChargeLimit):
        after = _rule_clock(limit)
    elif isinstance(limit, TableChargeLimit):
        after = _table_clock(limit)
    else:
        return dawn_soc + ca.sum1(gains)
    soc = dawn_soc
    group = max(1, round(_CHARGE_STEP_H / float(hours[0])))
    for start in range(0, len(hours), group):
        block = slice(start, min(start + group, len(hours)))
        by_sun = soc + ca.sum1(gains[block])
        by_charger = after(soc, float(np.sum(hours[block])))
        gap = by_sun - by_charger
        soc = (by_sun + by_charger - ca.sqrt(gap * gap + _BLEND * _BLEND)) / 2.0
    return soc


def _rule_clock(limit: RuleChargeLimit) -> Any:
    """Follow the constant-current rule and its exponential taper, in closed form."""
    rate, start = limit.c_rate_per_h, limit.taper_start
    decay = float(-np.log(limit.relative_rate_at_full) / (1.0 - start))
    knee_h = start / rate

    def after(soc: Any, hours: float) -> Any:
        clock = ca.fmin(soc, start) / rate
        clock = clock + (ca.exp(decay * ca.fmax(soc - start, 0.0)) - 1.0) / (decay * rate)
        clock = clock + hours
        taper = ca.log(1.0 + decay * rate * ca.fmax(clock - knee_h, 0.0)) / decay
        return rate * ca.fmin(clock, knee_h) + taper

    return after


def _table_clock(limit: TableChargeLimit) -> Any:
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

    def after(soc: Any, hours: float) -> Any:
        # Three sub-steps: the measured rates fall by half within two percent of charge.
        for _ in range(3):
            step_h = hours / 3.0
            middle = soc + step_h / 2.0 * rate(soc)
            soc = soc + step_h * rate(middle)
        return soc

    return after
