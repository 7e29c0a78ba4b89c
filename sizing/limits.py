"""Limits on a design: quantities that may be bounded, and requirements besides energy.

The formulas use arithmetic alone, for floats, arrays and symbolic expressions.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sizing.aircraft import Aircraft
from sizing.design import Design
from sizing.design_space import PROPULSION_VARIABLES, LimitedQuantity
from sizing.parameters import label, unit
from sizing.smooth import Value
from solar.schema import spell

MASS_BUDGET = "mass_budget"  # an equation, which closed designs meet
# Relative tolerance of requirements, above the solver's of about 1e-8.
ROW_TOLERANCE = 1e-5


# Quantities that may be bounded; their units and labels are in the catalogue of parameters.
QUANTITIES: dict[LimitedQuantity, Callable[[Design], Value]] = {
    "total_mass_kg": lambda it: it.total_mass_kg,
    "structure_mass_kg": lambda it: it.masses.structure,
    "battery_energy_wh": lambda it: it.battery_energy_wh,
    "battery_fraction": lambda it: it.masses.battery / it.total_mass_kg,
    "payload_fraction": lambda it: it.masses.payload / it.total_mass_kg,
    "wing_area_m2": lambda it: it.wing_area_m2,
    "chord_m": lambda it: it.chord_m,
    "module_coverage": lambda it: it.variables.module_area_m2 / it.wing_area_m2,
    "wing_loading_kg_per_m2": lambda it: it.total_mass_kg / it.wing_area_m2,
    "airspeed_m_per_s": lambda it: it.airspeed_m_per_s,
    "stall_speed_m_per_s": lambda it: it.airspeed_m_per_s / it.stall_margin,
    "stall_margin": lambda it: it.stall_margin,
    "lift_coefficient": lambda it: it.lift_coefficient,
    "reynolds_number": lambda it: it.reynolds_number,
    "propulsion_power_w": lambda it: it.propulsion_power_w,
    "rated_power_w": lambda it: it.rated_power_w,
    "load_w": lambda it: it.load_w,
    "climb_rate_m_per_s": lambda it: it.climb_rate_m_per_s,
    "cruise_discharge_rate_per_h": lambda it: it.load_w / it.battery_energy_wh,
    "climb_discharge_rate_per_h": lambda it: (
        (it.rated_power_w + it.constant_power_w) / it.battery_energy_wh
    ),
}


class Requirement(NamedTuple):
    """Requirement on a design, met where ``value >= 0``, relative to its limit."""

    name: str
    value: Value
    text: str


# Relative margin of the limits of the propulsion's parts, above the solver's tolerance.
_CUSHION = 1e-4
_OF_PROPULSION = {
    "bus_voltage": "the empty battery's voltage falls short of the motor's need by {missed}",
    "tip_mach": "the propeller's tips exceed their Mach number by {missed}",
    "motor_current": "the motor's current exceeds its maximum by {missed}",
    "motor_power": "the motor's power exceeds its maximum by {missed}",
}


def _propulsion_margins(aircraft: Aircraft, design: Design) -> dict[str, Value]:
    """Return the relative margins to limits of a propulsion's parts.

    They are empty where limits make operating points infeasible, or there is nothing to choose.
    """
    parts = aircraft.propulsion_by_parts
    free = aircraft.design_space.requested_ranges().keys() & set(PROPULSION_VARIABLES)
    if parts is None or parts.is_limited or not (parts.is_exact or free):
        return {}
    sized = parts.sized(*design.variables.of_propulsion)
    speed_m_per_s, air = design.airspeed_m_per_s, design.conditions.air
    shaft = sized.shaft(design.thrust_power_w, speed_m_per_s, air)
    empty_v = aircraft.battery.bus_voltage_v(np.zeros(()))
    used = sized.shares_of_limits(shaft, speed_m_per_s, air, empty_v)
    return {name: 1.0 - (1.0 + _CUSHION) * share for name, share in used.items()}


def design_requirements(aircraft: Aircraft, design: Design) -> list[Requirement]:
    """Return the requirements on a design; the first is the mass budget, an equation.

    Their texts describe a violation; ``{missed}`` stands for its size.
    """
    covered = aircraft.parametric.maximum_module_coverage * design.wing_area_m2
    rows = [
        Requirement(
            MASS_BUDGET,
            1.0 - design.masses.total_kg / design.total_mass_kg,
            "no design carries its own mass: {missed} of it cannot be lifted",
        ),
        Requirement(
            "module_coverage",
            1.0 - design.variables.module_area_m2 / covered,
            "the modules need {missed} more wing area than maximum_module_coverage allows them",
        ),
        # Relative to the airspeed, as the wind may be 0.
        Requirement(
            "airspeed_above_wind",
            1.0 - design.conditions.wind_m_per_s / design.airspeed_m_per_s,
            "airspeed stays {missed} below the wind",
        ),
    ]
    for name, limit in aircraft.design_space.limit_rows().items():
        is_minimum, ratio = limit.end == "minimum", QUANTITIES[limit.quantity](design) / limit.value
        unit_of_limit = "" if unit(limit.quantity) == "1" else f" {unit(limit.quantity)}"
        violation = "falls short of its minimum" if is_minimum else "exceeds its maximum"
        bound = f"{spell(limit.value)}{unit_of_limit}"
        text = f"{label(limit.quantity)} {violation} {bound} by {{missed}}"
        rows.append(Requirement(name, ratio - 1.0 if is_minimum else 1.0 - ratio, text))
    margins = _propulsion_margins(aircraft, design)
    rows += [Requirement(name, margin, _OF_PROPULSION[name]) for name, margin in margins.items()]
    return [*rows, *aircraft.design_space.user_requirements(design)]


def meets_requirements(aircraft: Aircraft, design: Design) -> NDArray[np.bool_]:
    """Return whether closed designs meet all requirements, of the designs' shape."""
    heaviest = aircraft.design_space.maximum_total_mass_kg or np.inf
    mass = np.asarray(design.total_mass_kg)
    met = np.isfinite(mass) & (mass <= heaviest * (1.0 + ROW_TOLERANCE))
    with np.errstate(invalid="ignore"):
        for row in design_requirements(aircraft, design):
            if row.name != MASS_BUDGET:  # closed
                met = met & (np.asarray(row.value) >= -ROW_TOLERANCE)
    return np.asarray(met)
