"""What a sizing has chosen on request, as data of an aircraft's file."""

from __future__ import annotations

from typing import Any

from sizing.aircraft import Aircraft
from sizing.catalogues.entries import PARTS_OF_PROPELLER
from sizing.design import Design


def put_parts_in(data: dict[str, Any], aircraft: Aircraft, design: Design) -> None:
    """Put the chosen lift, propeller and gear into an aircraft's file as data, in place."""
    variables = design.variables
    if variables.lift_coefficient is not None:
        data["airframe"]["aerodynamics"]["lift_coefficient"] = float(variables.lift_coefficient)
    if all(one is None for one in variables.of_propulsion):
        return
    propulsion = aircraft.propulsion_by_parts
    assert propulsion is not None
    places = (("propeller", "diameter_m"), ("propeller", "pitch_m"), ("gear", "ratio"))
    parts = data["airframe"]["propulsion"]
    for (part, key), value in zip(places, variables.of_propulsion, strict=False):
        if value is not None:
            parts.setdefault(part, {})[key] = float(value)
    if variables.motor_speed_constant_rpm_per_v is not None:
        # A product of the catalogue has its own winding.
        wound = propulsion.own_motor.rewound(float(variables.motor_speed_constant_rpm_per_v))
        parts["motor"] = wound.model_dump(exclude_none=True)
    sized = any(one is not None for one in variables.of_propulsion[:2])
    mass_kg = propulsion.sized(*variables.mapped(float).of_propulsion).propeller.mass_kg
    if sized and mass_kg is not None:
        parts["propeller"]["mass_kg"] = float(mass_kg)
    # No longer the product that the file names.
    if sized and parts["propeller"].pop("product", None) is not None:
        for key in PARTS_OF_PROPELLER:
            parts["propeller"].setdefault(key, getattr(propulsion.propeller, key))
