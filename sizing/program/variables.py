"""Variables and rows of the sizing program, as data."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from enum import Enum, auto
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.design_space import Range
from sizing.parameters import unit
from solar.types import FloatArray

TOTAL_MASS = "total_mass_kg"
WORST_EXCESS = "worst_excess_time_h"
USER_OBJECTIVE = "own_objective"  # value of an objective that is a function of the user's
# Of a guess; Sky-Sailor, AtlantikSolar 2 and SoLong have 2.3, 2.4 and 2.3.
TOTAL_OVER_BATTERY_MASS = 2.3


class Role(Enum):
    """What a variable of the program is."""

    design = auto()
    payload = auto()  # held at the mission's value unless it is the objective
    objective = auto()  # equal to the user's own, where there is one


class Variable(NamedTuple):
    """A variable of the program: a value over a scale, or the logarithm of that.

    The scale is the value of the design that the program is built around, but at least ``least``.
    Battery and modules enter masses and energies in proportion: as values they leave the day of a
    program nearly linear. Span and mass have powers: their logarithm has even steps.
    """

    name: str
    unit: str
    minimum: float
    maximum: float
    role: Role = Role.design
    linear: bool = False
    least: float = 1e-9

    def from_program(self, x: Any, scale: Any) -> Any:
        """Value in its unit; number or symbol."""
        return scale * (x if self.linear else ca.exp(x))

    def to_program(self, value: float, scale: float) -> float:
        """Value in the program; of a bound that may be zero or infinite as well."""
        if self.linear:
            return value / scale
        return math.log(value / scale) if value > 0.0 else -math.inf


class Constraint(NamedTuple):
    """A requirement ``value >= 0`` of the program, or ``value = 0``.

    ``block``: scenario block that it belongs to; None for the design itself.
    """

    name: str
    block: int | None = None
    equation: bool = False


def scales_of(variables: Sequence[Variable], values: Mapping[str, float]) -> FloatArray:
    """Scale of every variable around a design."""
    return np.array([max(abs(values[v.name]), v.least) for v in variables])


def chosen_variables(aircraft: Aircraft) -> tuple[Variable, ...]:
    """Every variable of the design that may be free, with the widest bounds it has."""
    space = aircraft.design_space
    assert isinstance(aircraft.airframe, ParametricAirframe)
    # No bound that nobody has set: mass and payload end where the mass budget or the sun ends them.
    heaviest = space.maximum_total_mass_kg or math.inf
    ranges = {
        "wingspan_m": space.wingspan_m,
        "battery_mass_kg": space.battery_mass_kg,
        "module_area_m2": space.module_area_m2,
        TOTAL_MASS: Range.model_construct(minimum=space.battery_mass_kg.minimum, maximum=heaviest),
        **space.requested_ranges(),
    }
    linear = ("battery_mass_kg", "module_area_m2")
    always = [
        Variable(name, unit(name), ends.minimum, ends.maximum, linear=name in linear)
        for name, ends in ranges.items()
    ]
    always += [
        Variable(name, unit(name), 0.0, math.inf, Role.payload, linear=True, least=least)
        for name, least in (
            # 1 kg for batteries of up to 25 kg, 10 W for modules of up to 8 m2; else in proportion
            ("payload_mass_kg", max(1.0, space.battery_mass_kg.maximum / 25.0)),
            ("payload_power_w", max(10.0, 10.0 * space.module_area_m2.maximum / 8.0)),
        )
    ]
    user_objective = getattr(space, "own_objective", None)
    if user_objective is not None:
        ends = -math.inf, math.inf
        always.append(
            Variable(
                USER_OBJECTIVE, "1", *ends, Role.objective, linear=True, least=user_objective.scale
            )
        )
    return tuple(always)
