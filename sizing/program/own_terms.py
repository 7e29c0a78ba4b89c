"""An objective and constraints of the user's own, from functions of the quantities of a design.

A function is called once, with symbols under the names of :data:`NAMES`; program and simulator
both evaluate the expression that it returns. They travel with the design space, so that whatever
sizes the aircraft again knows them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from types import SimpleNamespace
from typing import Any, ClassVar

import casadi as ca
import numpy as np
from pydantic import Field

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import Design, Masses, variables_of
from sizing.design_space import DesignSpace
from sizing.limits import QUANTITIES, Requirement, design_requirements
from sizing.mass_budget import closed_design, parametric_design
from sizing.parameters import all_replaced
from sizing.performance import Performance
from sizing.program.variables import TOTAL_OVER_BATTERY_MASS, USER_OBJECTIVE
from sizing.smooth import Value

OwnFunction = Callable[[Any], Any]
Quantity = Callable[[Design], Value]

_ENERGY = ("battery_capacity", "energy_balance", "excess_time", "height")  # rows of the cycle

# Quantities of a design that a function may use, by the names that results have.
NAMES: dict[str, Quantity] = {
    "wingspan_m": lambda it: it.variables.wingspan_m,
    "aspect_ratio": lambda it: it.variables.aspect_ratio,
    "module_area_m2": lambda it: it.variables.module_area_m2,
    "payload_power_w": lambda it: it.conditions.payload_power_w,
    "power_out_w": lambda it: it.load_w,
    **{f"{item}_mass_kg": attrgetter(f"masses.{item}") for item in Masses._fields},
    **{str(name): of for name, of in QUANTITIES.items()},
}


def _expression(function: OwnFunction, what: str) -> Any:
    """Return the expression of a function, with a symbol for each quantity."""
    design = SimpleNamespace(**{name: ca.SX.sym(name) for name in NAMES})
    try:
        expression = function(design)
    except AttributeError as error:
        unknown = f"a design has no {error.name}; it has {', '.join(NAMES)}"
        raise ValueError(f"{what}: {unknown if error.obj is design else error}") from error
    except Exception as error:
        raise ValueError(
            f"{what} is called with symbols: arithmetic, NumPy's and CasADi's functions "
            f"(casadi.fmax, casadi.if_else) take them, if, max and float do not ({error})"
        ) from error
    if not isinstance(expression, ca.SX) or not expression.is_scalar() or not ca.symvar(expression):
        shown = " ".join(str(expression).split())[:60]
        raise ValueError(f"{what} must return one number that depends on the design (got {shown})")
    return expression


def _quantity(expression: Any) -> Quantity:
    """Return an expression as a quantity of designs: of numbers, arrays and symbols."""
    symbols = ca.symvar(expression)
    names = [symbol.name() for symbol in symbols]
    function = ca.Function("own", [ca.vertcat(*symbols)], [expression])

    def quantity(it: Design) -> Value:
        values = [NAMES[name](it) for name in names]
        if any(isinstance(value, ca.SX) for value in values):
            return function(ca.vertcat(*values))
        arrays = np.broadcast_arrays(*(np.asarray(value, float) for value in values))
        if arrays[0].size == 0:
            return np.zeros(arrays[0].shape)
        evaluated = function(np.stack([array.ravel() for array in arrays]))
        return np.asarray(evaluated).reshape(arrays[0].shape)

    return quantity


@dataclass(frozen=True, eq=False)
class OwnObjective:
    """What the user makes as small as possible; it answers as an ``Objective`` does.

    ``scale``: of the order of its values.
    """

    value: str
    of: Quantity
    scale: float

    variable: ClassVar[str] = USER_OBJECTIVE
    label: ClassVar[str] = "objective"
    unit: ClassVar[str] = ""
    maximised: ClassVar[bool] = False
    of_range: ClassVar[bool] = False
    payload_key: ClassVar[None] = None

    @property
    def cost(self) -> dict[str, float]:
        """Weights of the program's variables in what it minimises."""
        return {USER_OBJECTIVE: 1.0}

    def of_flight(self, perf: Performance) -> Value:
        """Value of simulated designs."""
        return self.of(perf.design)

    def row(self, it: Design, variable: Value) -> Requirement:
        """Equation that makes a variable of the program the objective."""
        return Requirement(USER_OBJECTIVE, (variable - self.of(it)) / self.scale, "")


class _OwnDesignSpace(DesignSpace):
    """Design space with terms that no file can hold."""

    own_objective: Any = Field(default=None, exclude=True)
    own_constraints: tuple[Any, ...] = Field(default=(), exclude=True)

    __hash__ = DesignSpace.__hash__

    def user_requirements(self, design: Any) -> list[Any]:
        return [constraint(design) for constraint in self.own_constraints]


def with_own_terms(
    aircraft: Aircraft,
    mission: Mission,
    objective: OwnFunction | None,
    constraints: Sequence[OwnFunction],
) -> tuple[Aircraft, OwnObjective | None]:
    """Return an aircraft whose design space has an objective and constraints of the user.

    And the objective; None where there is none.
    """
    # What scales refer to: the aircraft's own design, or where that has no mass one of a guess.
    variables = variables_of(aircraft)
    design = closed_design(aircraft, mission, variables)
    if not np.isfinite(design.total_mass_kg):
        mass_kg = TOTAL_OVER_BATTERY_MASS * variables.battery_mass_kg
        design = parametric_design(aircraft, mission, variables, mass_kg)
    user_objective = None if objective is None else _objective(objective, design)
    rows = tuple(_constraint(function, design) for function in constraints)
    taken = {*_ENERGY, USER_OBJECTIVE, *(row.name for row in design_requirements(aircraft, design))}
    for name in (row(design).name for row in rows):
        if name in taken:
            raise ValueError(f"a constraint needs a name of its own: there is a {name} already")
        taken.add(name)
    space = aircraft.design_space
    fields: dict[str, Any] = {name: getattr(space, name) for name in DesignSpace.model_fields}
    fields |= {"own_objective": user_objective, "own_constraints": rows}
    changed = _OwnDesignSpace.model_construct(set(space.model_fields_set), **fields)
    return all_replaced(aircraft, {"design_space": changed}), user_objective


def _objective(function: OwnFunction, start: Design) -> OwnObjective:
    expression = _expression(function, "the objective")
    if expression.is_op(ca.OP_LE) or expression.is_op(ca.OP_LT) or expression.is_op(ca.OP_EQ):
        raise ValueError("the objective is a comparison: those are constraints")
    quantity = _quantity(expression)
    first = float(quantity(start))
    if not np.isfinite(first):
        raise ValueError(f"the objective is {first} for the design that the search starts from")
    scale = abs(first) or 1.0
    return OwnObjective(_name(function, expression), quantity, scale)


def _constraint(function: OwnFunction, start: Design) -> Callable[[Design], Requirement]:
    """Return the constraint of a comparison, relative to a number or the larger side at first."""
    expression = _expression(function, "a constraint")
    if not (expression.is_op(ca.OP_LE) or expression.is_op(ca.OP_LT)):
        raise ValueError(
            "a constraint must be one comparison by <= or >=, of quantities or numbers"
        )
    small, large = expression.dep(0), expression.dep(1)
    # A number is the limit; of two quantities the larger one.
    sides = small, large
    numbers = [abs(float(side)) for side in sides if not ca.symvar(side)]
    sizes = [abs(float(_quantity(side)(start))) for side in sides if ca.symvar(side)]
    scale = max(numbers, default=0.0) or max(sizes) or 1.0
    name = _name(function, expression).removeprefix("(").removesuffix(")")
    margin, text = _quantity((large - small) / scale), f"{name} is missed by {{missed}}"
    return lambda it: Requirement(name, margin(it), text)


def _name(function: OwnFunction, expression: Any) -> str:
    """Return the name of a function, or of a lambda its expression."""
    name = getattr(function, "__name__", "<lambda>")
    return "".join(str(expression).split()) if name == "<lambda>" else str(name)
