"""Variables and rows of the sizing program, as data.

Variables are wingspan, battery mass, module area and total mass, on request aspect ratio, lift
coefficient and payload, the state of charge at dawn of every scenario, and the worst excess time.
Every entry of the decision vector is a :class:`Variable`, every row a :class:`Constraint`, each
with its name, unit and scale. Nothing else knows where they stand.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import Enum, auto
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.design_space import DesignSpace, LimitedQuantity, LimitEnd, Range
from sizing.parameters import catalogue, is_doubled, parameter_value, unit

TOTAL_MASS = "total_mass_kg"
WORST_EXCESS = "worst_excess_time_h"
# Technology to which the power of the modules is proportional.
SOLAR_TECHNOLOGY = "modules.efficiency_stc"
WIND = "mission.wind_m_per_s"
OWN = "own_objective"  # what the user's own objective is, where there is one
# What is relative is eased by this to tell what that gains.
RELATIVE_STEP = 0.01
EXCESS_SCALE_H = 2.4  # excess time that counts as one in the program: a tenth of the day
HEIGHT = "height"  # of climbs, as potential energy over that of the ceiling


class Role(Enum):
    """What a variable of the program is."""

    design = auto()
    payload = auto()  # held at the mission's value unless it is freed
    technology = auto()  # relative to the aircraft's own value, held there unless it is freed
    limit = auto()  # of the design space, likewise
    objective = auto()  # equal to the user's own, where there is one
    wind = auto()  # held at the mission's value unless it is freed
    dawn_state = auto()
    height = auto()  # reached by day, over that of the ceiling
    worst_excess = auto()
    slack = auto()


class Variable(NamedTuple):
    """A variable of the program: the logarithm of a value, or the value over a scale.

    ``first_guess`` holds where nothing better is known.
    """

    name: str
    unit: str
    minimum: float
    maximum: float
    scale: float | None = None
    role: Role = Role.design
    first_guess: float = 0.1

    def to_program(self, value: float) -> float:
        """Value in the program."""
        return math.log(value) if self.scale is None else value / self.scale

    def from_program(self, x: Any) -> Any:
        """Value in its unit; number or symbol."""
        return ca.exp(x) if self.scale is None else x * self.scale


class Constraint(NamedTuple):
    """A requirement ``value >= 0`` of the program, or ``value = 0``, scaled to order one.

    ``block`` is the scenario block it belongs to, None for the design itself; the row is the
    quantity over ``scale`` in ``unit``: over its limit, over the battery's capacity, or in hours.
    ``firm``: whether it must not be missed for the sake of others, since it can always be met.
    """

    name: str
    block: int | None = None
    unit: str = "1"
    scale: float = 1.0
    equation: bool = False
    firm: bool = False

    @property
    def step(self) -> float:
        """How far the row is eased to tell what that gains: by one per cent, or one unit."""
        return RELATIVE_STEP if self.unit == "1" else 1.0 / self.scale

    @property
    def slacks(self) -> dict[str, float]:
        """Variables by which the requirement may be missed, one for all blocks, with their sign."""
        if self.firm:
            return {}
        return {f"slack.{self.name}": 1.0}


def all_variables(
    chosen: Sequence[Variable],
    blocks: int,
    constraints: Sequence[Constraint],
    *,
    climbs: bool = False,
) -> tuple[Variable, ...]:
    """Variables in the order of the decision vector: design, dawns, excess time, slacks.

    ``climbs``: whether there are heights as well, as potential energy over that of the ceiling.
    """
    dawns = (
        Variable(f"dawn_state_of_charge[{i}]", "1", 0.0, 1.0, 1.0, Role.dawn_state, 0.2)
        for i in range(blocks)
    )
    heights = (
        Variable(f"{HEIGHT}[{i}]", "1", 0.0, 1.0, 1.0, Role.height, 0.2)
        for i in range(blocks if climbs else 0)
    )
    slacks = dict.fromkeys(name for c in constraints for name in c.slacks)
    return (
        *chosen,
        *dawns,
        *heights,
        Variable(WORST_EXCESS, "h", 0.0, math.inf, 1.0, Role.worst_excess),
        *(Variable(name, "1", 0.0, np.inf, 1.0, Role.slack) for name in slacks),
    )


def chosen_variables(aircraft: Aircraft, *, eased: bool) -> tuple[Variable, ...]:
    """Every variable of the design that may be freed, with the widest bounds it has."""
    space = aircraft.design_space
    assert isinstance(aircraft.airframe, ParametricAirframe)
    lightest = space.battery_mass_kg.minimum
    # No bound that nobody has set: mass and payload end where the mass budget or the sun ends them.
    heaviest = space.maximum_total_mass_kg or math.inf
    ranges = {
        "wingspan_m": space.wingspan_m,
        "battery_mass_kg": space.battery_mass_kg,
        "module_area_m2": space.module_area_m2,
        TOTAL_MASS: Range.model_construct(minimum=lightest, maximum=heaviest),
        **space.requested_ranges(),
    }
    variables = (
        Variable(
            *(name, unit(name), ends.minimum, ends.maximum),
            first_guess=min((ends.minimum * ends.maximum) ** 0.5, ends.maximum / 2.0),
        )
        for name, ends in ranges.items()
    )
    always: tuple[Variable, ...] = (
        *variables,
        Variable("payload_mass_kg", "kg", 0.0, math.inf, _payload_scale_kg(space), Role.payload),
        Variable("payload_power_w", "W", 0.0, math.inf, _payload_scale_w(space), Role.payload),
    )
    own = getattr(space, "own_objective", None)
    if own is not None:
        value = Variable(OWN, "1", -math.inf, math.inf, own.scale, Role.objective, own.first)
        always = (*always, value)
    if not eased:
        return always
    return (
        *always,
        *(
            Variable(key, "1", 1e-3, 1e3, role=Role.technology)
            for key, one in catalogue().items()
            if one.kind == "technology"
            and one.relaxable
            and parameter_value(aircraft, None, key)
            and not is_doubled(aircraft, key)
        ),
        *(Variable(name, "1", 1e-3, 1e3, role=Role.limit) for name in limit_rows(aircraft)),
        Variable(WIND, unit(WIND), 0.0, math.inf, 10.0, Role.wind),
    )


def limit_rows(aircraft: Aircraft) -> dict[str, tuple[LimitedQuantity, LimitEnd]]:
    """Limits of the design space, quantity and end, by the names of their rows and variables."""
    ends: tuple[LimitEnd, ...] = ("minimum", "maximum")
    limits = aircraft.design_space.all_limits()
    return {
        f"{quantity}_{end}": (quantity, end)
        for quantity, limit in limits.items()
        for end in ends
        if getattr(limit, end) is not None
    }


def eased_row(value: Any, end: LimitEnd, relative: Any) -> Any:
    """Row of a limit, relative to it, where the limit is multiplied by a factor."""
    if end == "minimum":
        return (value + 1.0) / relative - 1.0
    return 1.0 - (1.0 - value) / relative


def _payload_scale_kg(space: DesignSpace) -> float:
    """Payload mass that counts as one: of the order of the cost's other terms, and the penalty's.

    1 kg for batteries of up to 25 kg, as the shipped designs have; in proportion for larger ones.
    """
    return max(1.0, space.battery_mass_kg.maximum / 25.0)


def _payload_scale_w(space: DesignSpace) -> float:
    """Payload power that counts as one: 10 W for modules of up to 8 m2, else in proportion."""
    return max(10.0, 10.0 * space.module_area_m2.maximum / 8.0)
