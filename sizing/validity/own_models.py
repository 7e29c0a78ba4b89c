"""What functions of a user's own must give, at a design."""

from __future__ import annotations

import math

import numpy as np

from missions.mission import Mission
from sizing.aerodynamics.parabolic import OwnDragPolar
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.design import Design, variables_of
from sizing.mass_budget import closed_design, parametric_design
from sizing.structures.models import OwnStructure

# Of what a battery and a payload weigh, where no mass closes: a design to ask own models about.
_USUAL_MASS = 3.0


def check_own_models(aircraft: Aircraft, mission: Mission, design: Design | None = None) -> None:
    """Refuse functions of the user's own that give what cannot be, at a design.

    ``design``: by default that of the aircraft's file. Raises a ValueError that names the function.
    """
    if isinstance(aircraft.airframe, MeasuredAirframe):
        return
    structure, polar = aircraft.airframe.structure, aircraft.airframe.aerodynamics
    propulsion = aircraft.airframe.propulsion
    own = {
        "register_structure": structure.name if isinstance(structure, OwnStructure) else None,
        "register_drag": polar.name if isinstance(polar, OwnDragPolar) else None,
        "register_propulsion_mass": getattr(propulsion, "mass_model", None),
        "register_propulsion_efficiency": getattr(propulsion, "efficiency_model", None),
    }
    if not any(own.values()):
        return
    if design is None:
        variables = variables_of(aircraft)
        mass_kg = float(closed_design(aircraft, mission, variables).total_mass_kg)
        if not np.isfinite(mass_kg):
            mass_kg = _USUAL_MASS * (aircraft.battery.mass_kg + mission.payload.mass_kg)
        design = parametric_design(aircraft, mission, variables, mass_kg)
    assert design.chain is not None
    efficiency = float(design.chain.efficiency)
    drag_w = design.thrust_power_w if efficiency else math.inf
    found = {
        "register_structure": (design.masses.structure, math.inf, "kg"),
        "register_drag": (drag_w, math.inf, "W of drag times airspeed"),
        "register_propulsion_mass": (design.masses.propulsion, math.inf, "kg"),
        "register_propulsion_efficiency": (efficiency, 1.0, "of the whole chain"),
    }
    for register, name in own.items():
        value, most, unit = found[register]
        if name is not None and not 0.0 < float(value) <= most:
            at_most = "" if math.isinf(most) else f" and at most {most:g}"
            raise ValueError(
                f"the function {name!r} of sizing.{register} gives {float(value):.4g} {unit} at "
                f"{float(design.variables.wingspan_m):.4g} m of span and a total mass of "
                f"{float(design.total_mass_kg):.4g} kg: it must be above 0{at_most}"
            )
