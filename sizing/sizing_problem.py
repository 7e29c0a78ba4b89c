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

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import casadi as ca
import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft, ParametricAirframe, Range
from sizing.battery import RuleChargeLimit, TableChargeLimit
from sizing.design import Design, DesignVariables, parametric_design, thermal_shape
from sizing.energy_balance import FloatArray
from sizing.objectives import Objective
from sizing.performance import SolarDay

# Nodes of the program. Coarser than the simulator's: the integrals of surplus and deficit are exact
# for power that is linear between nodes; the sun's curvature costs less than 0.01 h of excess time.
_STEP_H = 1.0 / 6.0
# Half-width of the smooth minimum of solar-limited and charger-limited charging [state of charge].
_BLEND = 1e-5


Effort = Literal["quick", "steady", "patient"]

_EFFORTS: dict[Effort, dict[str, Any]] = {
    "quick": {
        "ipopt.hessian_approximation": "limited-memory",
        "ipopt.mu_strategy": "adaptive",
        "ipopt.max_iter": 120,
    },
    "steady": {
        "ipopt.hessian_approximation": "exact",
        "ipopt.mu_strategy": "monotone",
        "ipopt.max_iter": 300,
    },
    "patient": {
        "ipopt.hessian_approximation": "exact",
        "ipopt.mu_strategy": "adaptive",
        "ipopt.max_iter": 600,
    },
}


@dataclass(frozen=True)
class Constraint:
    """A named requirement ``value >= 0`` of the program, scaled to order one."""

    name: str
    slot: int | None = None


@dataclass(frozen=True)
class SizingProblem:
    """A built program; see the module's docstring.

    A program has a number of *slots*, each filled with one scenario by its parameters, so that the
    scenarios in it can be exchanged without building it anew.

    Attributes
    ----------
    solver : casadi.Function
        IPOPT on the program, silent.
    variable_names : tuple of str
        Design variables that are free, in the order of the decision vector.
    bounds : tuple of Range
        Their bounds.
    constraints : tuple of Constraint
        In the order of the constraint vector.
    slots : int
        Scenarios in the program.
    axis : ScenarioAxis
        Time nodes and the sun of every scenario that may fill a slot.
    fixed_aspect_ratio : float or None
        Where the aspect ratio is not free.
    """

    solver: ca.Function
    objective: Objective
    variable_names: tuple[str, ...]
    bounds: tuple[Range, ...]
    constraints: tuple[Constraint, ...]
    slots: int
    axis: ScenarioAxis
    fixed_aspect_ratio: float | None

    @property
    def slack_names(self) -> tuple[str, ...]:
        """Requirements that the elastic program may miss, in the order of the slacks."""
        return tuple(dict.fromkeys(c.name for c in self.constraints))

    def parameters(
        self, scenarios: list[int], *, elastic: bool, goal_h: float, margin: float
    ) -> FloatArray:
        """Parameter vector with the slots filled by the scenarios of the given indices."""
        return self.axis.parameters(scenarios, elastic=elastic, goal_h=goal_h, margin=margin)


def build_problem(
    aircraft: Aircraft,
    mission: Mission,
    day: SolarDay,
    objective: Objective,
    slots: int,
    *,
    effort: Effort = "quick",
) -> SizingProblem:
    """Build the program of an aircraft, a mission and an objective.

    The sizing itself makes do with a ``quick`` quasi-Newton Hessian: for a handful of variables it
    needs few more iterations than exact second derivatives of the charge recursion, and each costs
    a third. The elastic program, whose slacks reach far, wants exact ones: ``steady`` lowers the
    barrier in steps, ``patient`` adaptively with more iterations.

    Raises
    ------
    TypeError
        For a measured aircraft.
    """
    program = build_program(aircraft, mission, day, objective, slots)
    options: dict[str, Any] = _IPOPT_OPTIONS | _EFFORTS[effort]
    symbols = {"x": program.x, "p": program.p, "f": program.f, "g": program.g}
    names = program.variable_names
    return SizingProblem(
        solver=ca.nlpsol("sizing", "ipopt", symbols, options),
        objective=objective,
        variable_names=names,
        bounds=program.bounds,
        constraints=program.constraints,
        slots=slots,
        axis=program.axis,
        fixed_aspect_ratio=None if "aspect_ratio" in names else aircraft.airframe.aspect_ratio,
    )


@dataclass(frozen=True)
class Program:
    """Symbols of the program: variables, parameters, cost and constraints ``g >= 0``."""

    x: Any
    p: Any
    f: Any
    g: Any
    variable_names: tuple[str, ...]
    bounds: tuple[Range, ...]
    constraints: tuple[Constraint, ...]
    axis: ScenarioAxis


def build_program(
    aircraft: Aircraft, mission: Mission, day: SolarDay, objective: Objective, slots: int
) -> Program:
    """Write the program down, without a solver; see :func:`build_problem`."""
    names, bounds = _free_variables(aircraft)
    logs = ca.MX.sym("log_design", len(names))
    dawn_soc = ca.MX.sym("dawn_state_of_charge", slots)
    worst_h = ca.MX.sym("worst_excess_time_h")
    elastic, margin = ca.MX.sym("elastic"), ca.MX.sym("recharge_margin")
    goal_h = ca.MX.sym("required_excess_time_h")
    values = {name: ca.exp(logs[i]) for i, name in enumerate(names)}
    design = _symbolic_design(aircraft, mission, values)
    axis = ScenarioAxis.of(day, mission)
    sun = ca.MX.sym("sun", 2 * len(axis.time_h), slots)

    goal = worst_h if objective is Objective.max_excess_time else goal_h
    rows = [(Constraint(name), value) for name, value in design_rows(aircraft, mission, design)]
    rows += _energy_rows(aircraft, mission, design, axis, sun, dawn_soc, goal, margin)
    constraints = tuple(constraint for constraint, _ in rows)
    slack_names = tuple(dict.fromkeys(c.name for c in constraints))
    slack = ca.MX.sym("slack", len(slack_names))
    weights = ca.DM([_SLACK_WEIGHTS.get(name, 100.0) for name in slack_names])
    cost = {
        Objective.max_excess_time: -worst_h / 24.0,
        Objective.min_wingspan: logs[names.index("wingspan_m")],
        Objective.min_mass: logs[names.index("total_mass_kg")],
    }[objective]
    # The dawn states of scenarios that do not bind are otherwise undetermined.
    tie_break = -1e-7 * ca.sum1(dawn_soc)
    return Program(
        x=ca.vertcat(logs, dawn_soc, worst_h, slack),
        p=ca.vertcat(elastic, margin, goal_h, ca.vec(sun)),
        f=(1.0 - elastic) * (cost + tie_break) + elastic * ca.dot(weights, slack),
        g=ca.vertcat(*(value + slack[slack_names.index(c.name)] for c, value in rows)),
        variable_names=names,
        bounds=bounds,
        constraints=constraints,
        axis=axis,
    )


def _symbolic_design(aircraft: Aircraft, mission: Mission, values: dict[str, Any]) -> Design:
    variables = DesignVariables(
        wingspan_m=values["wingspan_m"],
        aspect_ratio=values.get("aspect_ratio", aircraft.airframe.aspect_ratio),
        battery_mass_kg=values["battery_mass_kg"],
        module_area_m2=values["module_area_m2"],
    )
    return parametric_design(aircraft, mission, variables, values["total_mass_kg"])


def _energy_rows(
    aircraft: Aircraft,
    mission: Mission,
    design: Design,
    axis: ScenarioAxis,
    sun: Any,
    dawn_soc: Any,
    goal_h: Any,
    margin: Any,
) -> list[tuple[Constraint, Any]]:
    """Requirements of every slot's cycle, and its excess time.

    The margin asks for slightly more charge than the night takes. At equality the cycle stands on
    an edge: a day that returns any less lets the battery run empty over many days, however full it
    was.
    """
    energy = _energy_function(aircraft, axis)
    nominal_w = design.nominal_load_w(mission)
    usable_h = design.battery_energy_wh * aircraft.battery.discharge_efficiency / nominal_w
    nodes = len(axis.time_h)
    rows: list[tuple[Constraint, Any]] = []
    for i in range(dawn_soc.shape[0]):
        deficit, charged = energy(
            design.variables.module_area_m2,
            design.battery_energy_wh,
            nominal_w,
            design.propulsion_power_w,
            dawn_soc[i],
            sun[:nodes, i],
            sun[nodes:, i],
        )
        recharged = charged - dawn_soc[i] - (1.0 + margin) * deficit
        # The excess time counts in tenths of the day so that all rows are of order one.
        rows += [
            (Constraint("battery_capacity", i), 1.0 - dawn_soc[i] - deficit),
            (Constraint("energy_balance", i), recharged),
            (Constraint("excess_time", i), (dawn_soc[i] * usable_h - goal_h) / 2.4),
        ]
    return rows


# Which requirement an infeasible sizing may miss first: the excess time, then the energy over the
# cycle, and only as a last resort what makes the design an aircraft at all.
_SLACK_WEIGHTS = {"excess_time": 1.0, "energy_balance": 10.0, "battery_capacity": 10.0}

_IPOPT_OPTIONS = {
    "print_time": False,
    "show_eval_warnings": False,
    "error_on_fail": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.tol": 1e-8,
    "ipopt.acceptable_tol": 1e-6,
    "ipopt.acceptable_iter": 8,
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


def design_rows(aircraft: Aircraft, mission: Mission, design: Design) -> list[tuple[str, Any]]:
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
class ScenarioAxis:
    """Time nodes of the program: the part of the day with sun or thermals in any scenario."""

    time_h: FloatArray
    specific_power: FloatArray
    thermal: FloatArray
    dark_h: float

    @classmethod
    def of(cls, day: SolarDay, mission: Mission) -> ScenarioAxis:
        """Axis that covers every scenario of a day."""
        count = round(24.0 / _STEP_H)
        time_h = np.linspace(0.0, 24.0, count + 1)
        power = np.stack(
            [np.interp(time_h, day.time_h, row) for row in day.specific_power_w_per_m2]
        )
        thermal = mission.turbulence.thermal * thermal_shape(time_h, day.sunrise_h, day.sunset_h)
        active = np.flatnonzero(np.any((power > 0.0) | (thermal > 0.0), axis=0))
        first = max(int(active[0]) - 1, 0) if len(active) else 0
        last = min(int(active[-1]) + 1, count) if len(active) else 1
        nodes = slice(first, last + 1)
        lit_h = float(time_h[last] - time_h[first])
        return cls(time_h[nodes], power[:, nodes], thermal[:, nodes], 24.0 - lit_h)

    def parameters(
        self, scenarios: Sequence[int], *, elastic: bool, goal_h: float, margin: float
    ) -> FloatArray:
        """Parameter vector of a program whose slots hold the scenarios of these indices."""
        sun = [np.concatenate((self.specific_power[i], self.thermal[i])) for i in scenarios]
        return np.concatenate(([float(elastic), margin, goal_h], *sun))


def _energy_function(aircraft: Aircraft, axis: ScenarioAxis) -> ca.Function:
    """One scenario's deficit and the state of charge its surplus leads to, as a function.

    Every scenario shares it, so that its derivatives are built once.
    """
    area, energy_wh = ca.SX.sym("area"), ca.SX.sym("energy")
    nominal_w, propulsion_w = ca.SX.sym("nominal"), ca.SX.sym("propulsion")
    dawn_soc = ca.SX.sym("dawn_soc")
    power = ca.SX.sym("power", len(axis.time_h))
    thermal = ca.SX.sym("thermal", len(axis.time_h))
    hours = np.diff(axis.time_h)
    net = area * power - nominal_w - propulsion_w * thermal
    battery = aircraft.battery
    deficit_wh = ca.sum1(_positive_part_wh(-net, hours)) + axis.dark_h * nominal_w
    deficit = deficit_wh / (battery.discharge_efficiency * energy_wh)
    gains = battery.charge_efficiency * _positive_part_wh(net, hours) / energy_wh
    charged = _charged(aircraft, dawn_soc, gains, hours)
    return ca.Function(
        "energy",
        [area, energy_wh, nominal_w, propulsion_w, dawn_soc, power, thermal],
        [deficit, charged],
    )


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
    for k, step_h in enumerate(hours):
        by_sun = soc + gains[k]
        by_charger = after(soc, float(step_h))
        gap = by_sun - by_charger
        soc = (by_sun + by_charger - ca.sqrt(gap * gap + _BLEND * _BLEND)) / 2.0
    return soc


def _rule_clock(limit: RuleChargeLimit) -> Any:
    """Follow the constant-current rule and its exponential taper, in closed form."""
    rate, start = limit.c_rate_per_h, limit.taper_start
    decay = float(-np.log(limit.relative_rate_at_full) / (1.0 - start))
    if decay == 0.0:  # no taper: the constant rate all the way
        return lambda soc, hours: soc + rate * hours
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
