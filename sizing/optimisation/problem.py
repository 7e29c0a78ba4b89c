"""The sizing problem as a small nonlinear program.

Variables are wingspan, battery mass, module area and total mass, on request aspect ratio, lift
coefficient and payload, the state of charge at dawn of every scenario, and the worst excess time.
The sun enters as specific power per module area, which no design variable changes, so that a whole
day of a scenario is a parameter vector, and so do air, wind and payload: a program belongs to an
aircraft and is built once for any mission and objective.

Energy over the day is integrated exactly as the simulator does it;
:mod:`sizing.optimisation.energy_constraints`:

* the night's deficit must fit into the battery, ``soc_dawn + deficit <= 1``;
* the day's surplus must bring it back, ``soc_dawn + deficit <= soc after charging from soc_dawn``,
  with the charge limit followed step by step.

Both together say that the cycle repeats itself with at least ``soc_dawn``, and the excess time is
the energy at dawn over the load. Every cost is a weighted sum of variables. Slack variables, held
at zero in the sizing itself, turn the same program into the question by how much the requirements
are missed; technology variables, held too, into the question which value would meet them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

import casadi as ca
import numpy as np

from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.design import DesignVariables, FlightConditions, parametric_design
from sizing.limits import Requirement, design_requirements
from sizing.optimisation.energy_constraints import SUN_PARAMETERS, cycle_function
from sizing.parameters import parameter_value, replaced
from solar.types import FloatArray

Effort = Literal["quick", "steady", "patient", "next"]

_IPOPT_EFFORTS: dict[Effort, dict[str, Any]] = {
    "quick": {
        "ipopt.hessian_approximation": "limited-memory",
        "ipopt.mu_strategy": "monotone",
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

_COMMON_OPTIONS = {
    "print_time": False,
    "show_eval_warnings": False,
    "error_on_fail": False,
    # Prices of parameters are found only where they are asked for; sizing.optimisation.sensitivity.
    "calc_lam_p": False,
    "no_nlp_grad": True,
}

_IPOPT_OPTIONS = _COMMON_OPTIONS | {
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.tol": 1e-8,
    "ipopt.acceptable_tol": 1e-6,
    "ipopt.acceptable_iter": 8,
}

# Sequential quadratic programming, for the next one of a row of similar problems.
_SQP_OPTIONS: dict[str, Any] = _COMMON_OPTIONS | {
    "print_header": False,
    "print_iteration": False,
    "print_status": False,
    "qpsol": "qrqp",
    "qpsol_options": {
        "print_iter": False,
        "print_header": False,
        "print_info": False,
        "error_on_fail": False,
        # Where the active set has not settled by then it cycles, up to the default of 1000.
        "max_iter": 100,
    },
    "hessian_approximation": "limited-memory",
    "max_iter": 80,
    "tol_du": 1e-6,
    "tol_pr": 1e-7,
}

WORST_EXCESS = "worst_excess_time_h"
MAXIMUM_EXCESS_H = 1e4

# Technology that the program can free, to find the value that would make a mission feasible.
TECHNOLOGY = (
    "battery.specific_energy_wh_per_kg",
    "modules.efficiency_stc",
    "airframe.structure.calibration",
    "airframe.structure.coefficient_kg",
    "airframe.propulsion.propeller_efficiency",
    "power.avionics_w",
)
SOLAR_TECHNOLOGY = "modules.efficiency_stc"

# Payload counts in these units so that all variables are of order one.
LINEAR_SCALES = {"payload_mass_kg": 1.0, "payload_power_w": 10.0}


class Variable(NamedTuple):
    """A variable of the program: its logarithm, or the value over a scale."""

    name: str
    minimum: float
    maximum: float
    scale: float | None = None

    def to_program(self, value: float) -> float:
        """Value in the program."""
        return math.log(value) if self.scale is None else value / self.scale

    def from_program(self, x: Any) -> Any:
        """Value in its unit; number or symbol."""
        return ca.exp(x) if self.scale is None else x * self.scale


class Constraint(NamedTuple):
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
    aircraft : Aircraft
        Whose technology is in the formulas.
    variables : tuple of Variable
        Design, payload and technology variables: the first part of the decision vector.
    constraints : tuple of Constraint
        In the order of the constraint vector.
    slots : int
        Scenarios in the program.
    symbols : dict
        Decision vector ``x``, parameters ``p``, cost ``f`` and constraints ``g``.
    """

    aircraft: Aircraft
    variables: tuple[Variable, ...]
    constraints: tuple[Constraint, ...]
    slots: int
    symbols: dict[str, Any]
    _solvers: dict[Effort, ca.Function] = field(default_factory=dict)

    def solver(self, effort: Effort = "quick") -> ca.Function:
        """Solver of the program, silent; built at the first call.

        The sizing itself makes do with a ``quick`` quasi-Newton Hessian: for a handful of variables
        it needs few more iterations than exact second derivatives of the charge recursion, and each
        costs a third. The elastic program, whose slacks reach far, now and then wants exact ones:
        ``steady`` lowers the barrier in steps, ``patient`` adaptively, longer. ``next`` is
        sequential quadratic programming, which starts well from the answer to a similar question,
        as interior points do not.
        """
        if effort not in self._solvers:
            if effort == "next":
                solver = ca.nlpsol("sizing", "sqpmethod", self.symbols, _SQP_OPTIONS)
            else:
                options: dict[str, Any] = _IPOPT_OPTIONS | _IPOPT_EFFORTS[effort]
                solver = ca.nlpsol("sizing", "ipopt", self.symbols, options)
            self._solvers[effort] = solver
        return self._solvers[effort]

    @property
    def slack_names(self) -> tuple[str, ...]:
        """Requirements that the elastic program may miss, in the order of the slacks."""
        return tuple(dict.fromkeys(c.name for c in self.constraints))

    @property
    def variable_names(self) -> tuple[str, ...]:
        """Names of the variables, in the order of the decision vector."""
        return tuple(v.name for v in self.variables)

    @property
    def technology(self) -> tuple[str, ...]:
        """Variables that are technology, each relative to the aircraft's own value."""
        return _technology_of(self.variables)

    def places(self) -> dict[str, slice]:
        """Where the parts of the decision vector are."""
        design, dawn = len(self.variables), self.slots
        return {
            "variables": slice(0, design),
            "dawn": slice(design, design + dawn),
            WORST_EXCESS: slice(design + dawn, design + dawn + 1),
            "slack": slice(design + dawn + 1, design + dawn + 1 + len(self.slack_names)),
        }

    def weights(self, of: Mapping[str, float]) -> FloatArray:
        """Cost per unit of the decision vector, from names of variables or of slacks."""
        places = self.places()
        weights = np.zeros(places["slack"].stop)
        for name, weight in of.items():
            if name == WORST_EXCESS:
                weights[places[WORST_EXCESS]] = weight
            elif name in self.slack_names:
                weights[places["slack"].start + self.slack_names.index(name)] = weight
            else:
                weights[self.variable_names.index(name)] = weight
        return weights

    def parameters(
        self,
        weights: FloatArray,
        conditions: FlightConditions,
        suns: FloatArray,
        *,
        margin: float,
    ) -> FloatArray:
        """Parameter vector, with one row of ``suns`` in every slot."""
        return np.concatenate((weights, [margin], conditions, suns.ravel()))

    def design_variables(
        self, x: FloatArray, bounds: Mapping[str, tuple[float, float]]
    ) -> DesignVariables:
        """Design in a decision vector, within its bounds: the solver may step over by a hair.

        ``bounds`` replace those of the variables.
        """
        values = {"aspect_ratio": self.aircraft.airframe.aspect_ratio}
        for i, v in enumerate(self.variables):
            ends = bounds.get(v.name, (v.minimum, v.maximum))
            values[v.name] = float(np.clip(float(v.from_program(x[i])), *ends))
        return DesignVariables(
            **{name: values[name] for name in DesignVariables._fields if name in values}
        )


def build_problem(aircraft: Aircraft, slots: int) -> SizingProblem:
    """Build the program of an aircraft.

    Raises
    ------
    TypeError
        For a measured aircraft.
    """
    if not isinstance(aircraft.airframe, ParametricAirframe):
        raise TypeError(f"{aircraft.name} is a measured aircraft: it has no mass budget to size")
    variables = _variables(aircraft)
    design, requirements = _design_function(aircraft, variables)
    free = ca.MX.sym("design", len(variables))
    dawn_soc = ca.MX.sym("dawn_state_of_charge", slots)
    worst_h = ca.MX.sym(WORST_EXCESS)
    margin = ca.MX.sym("recharge_margin")
    conditions = ca.MX.sym("conditions", len(FlightConditions._fields))
    sun = ca.MX.sym("sun", SUN_PARAMETERS, slots)

    lit_area, capacity_wh, nominal_w, propulsion_w, values = design(free, conditions)
    rows = [(Constraint(one.name), values[k]) for k, one in enumerate(requirements)]
    cycle = cycle_function(aircraft.battery)
    usable_h = capacity_wh * aircraft.battery.discharge_efficiency / nominal_w
    for i in range(slots):
        deficit, charged = cycle(
            lit_area, capacity_wh, nominal_w, propulsion_w, dawn_soc[i], sun[:, i]
        )
        # The margin asks for slightly more charge than the night takes. At equality the cycle
        # stands on an edge: a day that returns any less lets the battery run empty over many days.
        recharged = charged - dawn_soc[i] - (1.0 + margin) * deficit
        # The excess time counts in tenths of the day so that all rows are of order one.
        rows += [
            (Constraint("battery_capacity", i), 1.0 - dawn_soc[i] - deficit),
            (Constraint("energy_balance", i), recharged),
            (Constraint("excess_time", i), (dawn_soc[i] * usable_h - worst_h) / 2.4),
        ]
    constraints = tuple(constraint for constraint, _ in rows)
    slack_names = tuple(dict.fromkeys(c.name for c in constraints))
    slack = ca.MX.sym("slack", len(slack_names))
    x = ca.vertcat(free, dawn_soc, worst_h, slack)
    weights = ca.MX.sym("weights", x.shape[0])
    # The dawn states of scenarios that do not bind are otherwise undetermined.
    tie_break = -1e-7 * ca.sum1(dawn_soc)
    symbols = {
        "x": x,
        "p": ca.vertcat(weights, margin, conditions, ca.vec(sun)),
        "f": ca.dot(weights, x) + tie_break,
        "g": ca.vertcat(*(value + slack[slack_names.index(c.name)] for c, value in rows)),
    }
    return SizingProblem(aircraft, variables, constraints, slots, symbols)


def _variables(aircraft: Aircraft) -> tuple[Variable, ...]:
    """Every variable that an objective or a question may free, with the widest bounds it has."""
    airframe, space = aircraft.airframe, aircraft.design_space
    assert isinstance(airframe, ParametricAirframe)
    heaviest = space.maximum_total_mass_kg or 40.0 * space.battery_mass_kg.maximum
    ranges = {
        "wingspan_m": (space.wingspan_m.minimum, space.wingspan_m.maximum),
        "battery_mass_kg": (space.battery_mass_kg.minimum, space.battery_mass_kg.maximum),
        "module_area_m2": (space.module_area_m2.minimum, space.module_area_m2.maximum),
        "total_mass_kg": (space.battery_mass_kg.minimum, heaviest),
    }
    found = [Variable(name, *ends) for name, ends in ranges.items()]
    if space.aspect_ratio is not None:
        ratio = space.aspect_ratio
        found.append(Variable("aspect_ratio", ratio.minimum, ratio.maximum))
    if space.lift_coefficient is not None:
        lift = space.lift_coefficient
        found.append(Variable("lift_coefficient", lift.minimum, lift.maximum))
    for name, scale in LINEAR_SCALES.items():
        # No aircraft carries more than it weighs; power is bounded by its energy.
        found.append(Variable(name, 0.0, heaviest if scale == 1.0 else 1e6, scale))
    for key in technology_keys(aircraft):
        found.append(Variable(key, 1e-3, 1e3))
    return tuple(found)


def technology_keys(aircraft: Aircraft) -> tuple[str, ...]:
    """Keys of the technology that the program of this aircraft can free."""
    values = {key: parameter_value(aircraft, None, key) for key in TECHNOLOGY}
    return tuple(key for key, value in values.items() if value)


def _technology_of(variables: Sequence[Variable]) -> tuple[str, ...]:
    return tuple(v.name for v in variables if v.name in TECHNOLOGY)


def _design_function(
    aircraft: Aircraft, variables: Sequence[Variable]
) -> tuple[ca.Function, list[Requirement]]:
    """Lit area, capacity, loads and requirements of a design, as a function of the variables.

    The lit area is the module area times the relative efficiency of the cells: power per area is a
    parameter, and proportional to their efficiency.
    """
    x = ca.SX.sym("x", len(variables))
    symbols = ca.SX.sym("conditions", len(FlightConditions._fields))
    values = {v.name: v.from_program(x[i]) for i, v in enumerate(variables)}
    technology = aircraft
    for key in _technology_of(variables):
        base = parameter_value(aircraft, None, key)
        technology = replaced(technology, key.split("."), base * values[key])
    chosen = DesignVariables(
        wingspan_m=values["wingspan_m"],
        aspect_ratio=values.get("aspect_ratio", aircraft.airframe.aspect_ratio),
        battery_mass_kg=values["battery_mass_kg"],
        module_area_m2=values["module_area_m2"],
        lift_coefficient=values.get("lift_coefficient"),
        payload_mass_kg=values["payload_mass_kg"],
        payload_power_w=values["payload_power_w"],
    )
    conditions = FlightConditions(*(symbols[i] for i in range(symbols.shape[0])))
    conditions = conditions.with_payload_of(chosen)
    design = parametric_design(technology, conditions, chosen, values["total_mass_kg"])
    requirements = design_requirements(technology, design, conditions)
    function = ca.Function(
        "design",
        [x, symbols],
        [
            design.variables.module_area_m2 * values[SOLAR_TECHNOLOGY],
            design.battery_energy_wh,
            design.load_in_turbulence_w(conditions.turbulence),
            design.propulsion_power_w,
            ca.vertcat(*(one.value for one in requirements)),
        ],
    )
    return function, requirements


class SizingProblems:
    """Programs of one aircraft by their number of slots, built when they are first asked for."""

    def __init__(self, aircraft: Aircraft) -> None:
        self.aircraft = aircraft
        self._built: dict[int, SizingProblem] = {}

    def of(self, slots: int) -> SizingProblem:
        """Program with this number of slots."""
        if slots not in self._built:
            self._built[slots] = build_problem(self.aircraft, slots)
        return self._built[slots]
