"""Structure of a design: masses of its parts, sizing criteria, and a second opinion on its mass."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from sizing.aircraft import Aircraft
from sizing.balance.in_design import structure_with_tail
from sizing.design import Design
from sizing.smooth import Value
from sizing.structures.assessment import StructureAssessment, assess, flight_envelope
from sizing.structures.models import other_model
from sizing.structures.rib_wing import RibWingStructure, StructureParts
from solar.schema import spell


def structure_parts(aircraft: Aircraft, design: Design) -> StructureParts | None:
    """Return the masses of the structure's parts, without the airframe's mass growth [kg].

    None for models of the structure without parts.
    """
    model, inputs = _sized_structure(aircraft, design)
    return model.breakdown(inputs) if isinstance(model, RibWingStructure) else None


def structure_assessment(aircraft: Aircraft, design: Design) -> StructureAssessment | None:
    """Return sizing criteria, deflections and twist of a rib wing; None for other models."""
    model, inputs = _sized_structure(aircraft, design)
    if not isinstance(model, RibWingStructure):
        return None
    tail, remarks = aircraft.modules.tail, []
    excluded = {
        "T-tails": tail is not None and tail.is_t_tail,
        "masses along the wing": inputs.wing_battery_kg > 0.0,
    }
    left_out = " and ".join(name for name, has in excluded.items() if has)
    if model.torsion is not None and left_out:
        remarks.append(f"flutter: not checked, CAA Report 45 does not cover {left_out}")
    chosen = "deflection_load_case" in model.model_fields_set
    if model.maximum_tip_deflection is not None and not chosen:
        remarks.append(
            f"maximum_tip_deflection {spell(model.maximum_tip_deflection)} holds in level flight; "
            "until 1.0 it held at every limit load and in landing (deflection_load_case: "
            "limit_load, maximum_landing_deflection)"
        )
    return replace(
        assess(model, inputs),
        remarks=tuple(remarks),
        flight_envelope=flight_envelope(model, inputs, float(design.maximum_lift_coefficient)),
    )


def structure_masses_by_model(aircraft: Aircraft, design: Design) -> dict[str, Value] | None:
    """Return the structural mass by the file's model and another one, by their names [kg].

    Without mass growth; None where there is no second opinion. The other model has the file's
    calibration and build factor, relative to those of AtlantikSolar.
    """
    structure, inputs = _sized_structure(aircraft, design)
    other = other_model(structure)
    if other is None:
        return None
    factor = structure.mass_factor / structure.atlantiksolar_calibration
    return {structure.model: structure.mass_kg(inputs), other.model: factor * other.mass_kg(inputs)}


def _sized_structure(aircraft: Aircraft, design: Design) -> tuple[Any, Any]:
    """Return the structural model of an aircraft and its inputs; None of both if measured."""
    if (inputs := design.sized_from) is None:
        return None, None
    return structure_with_tail(aircraft.parametric, inputs.wingspan_m, inputs.aspect_ratio), inputs
