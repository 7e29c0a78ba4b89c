"""Parts chosen by a sizing, as data of an aircraft's file."""

from __future__ import annotations

from typing import Any

from sizing.aircraft import Aircraft
from sizing.catalogues.choice import catalogue_values
from sizing.catalogues.entries import PARTS_OF_PROPELLER
from sizing.design import Design
from sizing.parameters import parameter


def put_parts_in(data: dict[str, Any], aircraft: Aircraft, design: Design) -> None:
    """Put the chosen lift, propeller and gear into an aircraft's file as data, in place."""
    variables = design.variables
    if variables.lift_coefficient is not None:
        data["airframe"]["aerodynamics"]["lift_coefficient"] = float(variables.lift_coefficient)
    if all(value is None for value in variables.of_propulsion):
        return
    propulsion = aircraft.propulsion_by_parts
    assert propulsion is not None
    places = (("propeller", "diameter_m"), ("propeller", "pitch_m"), ("gear", "ratio"))
    parts = data["airframe"]["propulsion"]
    for (part, key), value in zip(places, variables.of_propulsion, strict=False):
        if value is not None:
            parts.setdefault(part, {})[key] = float(value)
    if variables.motor_speed_constant_rpm_per_v is not None:
        # The rewound motor replaces a product of the catalogue.
        wound = propulsion.motor_constants.rewound(float(variables.motor_speed_constant_rpm_per_v))
        parts["motor"] = wound.model_dump(exclude_none=True)
    sized = any(value is not None for value in variables.of_propulsion[:2])
    mass_kg = propulsion.sized(*variables.mapped(float).of_propulsion).propeller.mass_kg
    if sized and mass_kg is not None:
        parts["propeller"]["mass_kg"] = float(mass_kg)
    # The product in the file has another size.
    if sized and parts["propeller"].pop("product", None) is not None:
        for key in PARTS_OF_PROPELLER:
            parts["propeller"].setdefault(key, getattr(propulsion.propeller, key))


def sized_data(aircraft: Aircraft, design: Design, whole_cells: bool) -> dict[str, Any]:
    """Return the file of an aircraft as data, with an optimum put in.

    Without ``whole_cells`` the cells of the file are left out, but for their technology: they are
    another design's.
    """
    data = aircraft.model_dump(mode="json", exclude_unset=True)
    data["name"] = f"{data['name']}-sized"
    for name in ("wingspan_m", "aspect_ratio", "battery_mass_kg", "module_area_m2"):
        section, key = parameter(name).key.split(".")
        data[section][key] = getattr(design.variables, name)
    put_parts_in(data, aircraft, design)
    if whole_cells:
        return data
    if data["modules"].pop("layout", None) is not None:
        # The mass of the boards by strings may differ from that by rated power.
        data["modules"]["mppt_mass_kg_per_w"] = aircraft.modules.mppt_mass_kg_per_w
        if data["modules"].pop("mppt_board", None) is not None:
            data["modules"]["mppt_efficiency"] = aircraft.modules.mppt_efficiency
    if data["battery"].pop("pack", None) is not None:
        technology = aircraft.battery.model_dump(mode="json")
        entry_keys = {value.key for value in catalogue_values(aircraft.battery, "")}
        for key in ("specific_energy_wh_per_kg", "charge_limit"):
            if key not in entry_keys:
                data["battery"][key] = technology[key]
    return data
