"""Points of a trade study that are sized, with the varied design variables fixed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel
from sizing.design_space import DesignSpace, Range
from sizing.mass_budget import ImpossibleDesignError
from sizing.parameters import all_replaced
from sizing.program.objectives import Objective, SizingStatus
from sizing.program.size import size_aircraft
from sizing.validity.extrapolations import as_text, extrapolations
from solar.types import FloatArray
from studies.quantities import DESIGN_COLUMNS, LOAD, PAYLOAD_MASS, REACHED
from studies.sweeps.axes import DESIGN_KEYS, design_variable
from studies.sweeps.points import SweepConfiguration, columns_of, valid_groups


def with_fixed_variables(aircraft: Aircraft, variables: Mapping[str, float]) -> Aircraft:
    """Return an aircraft with design variables, by short names, fixed at values.

    Their bounds coincide, which makes the solver drop them from the problem.
    """
    space: dict[str, Any] = {
        name: Range.model_construct(minimum=value, maximum=value)
        for name, value in variables.items()
        if name != "aspect_ratio"
    }
    if "aspect_ratio" in variables:
        space["aspect_ratio"] = None  # fixed at the airframe's
    design_space: DesignSpace = aircraft.design_space.model_copy(update=space)
    values = {DESIGN_KEYS[name]: value for name, value in variables.items()}
    return all_replaced(aircraft, values).model_copy(update={"design_space": design_space})


def size_points(configuration: SweepConfiguration, cells: FloatArray) -> dict[str, Any]:
    """Size points with the varied design variables fixed; arguments as ``simulate_points``."""
    assert configuration.objective is not None
    rows: dict[int, dict[str, Any]] = {}
    for numbers, aircraft, mission in valid_groups(configuration, cells, rows, SizingStatus):
        for number in numbers:
            names = map(design_variable, configuration.keys)
            values = zip(names, cells[number].tolist(), strict=True)
            fixed = {name: value for name, value in values if name is not None}
            sized = with_fixed_variables(aircraft, fixed)
            try:
                rows[number] = _sizing_row(
                    sized, mission, configuration.objective, configuration.solar, of=aircraft
                )
            except ImpossibleDesignError as error:
                rows[number] = {"status": SizingStatus.infeasible, "message": str(error)}
    return columns_of(configuration, rows)


def _sizing_row(
    aircraft: Aircraft, mission: Mission, objective: Objective, solar: SolarModel, *, of: Aircraft
) -> dict[str, Any]:
    """Size a point of a trade study; ``of``: aircraft without the point's fixed variables."""
    result = size_aircraft(aircraft, mission, objective, solar)
    row: dict[str, Any] = {"status": result.status, PAYLOAD_MASS.variable: mission.payload.mass_kg}
    if result.status is SizingStatus.not_converged:
        return row | {"message": f"the solver did not converge ({result.solver.message})"}
    if result.violations:
        worst = max(result.violations, key=lambda v: v.shortfall)
        row |= {"shortfall": worst.shortfall, "violated_requirement": worst.requirement}
        row |= {"message": "; ".join(v.text for v in result.violations)}
    if result.simulated is None or result.design is None:
        return row
    simulated, scenario = result.simulated, result.simulated.worst_scenario()
    row |= {q.variable: q.of(result.design) for q in DESIGN_COLUMNS}
    row |= {q.variable: float(q.of(simulated)[scenario]) for q in (*REACHED, LOAD)}
    return row | {"extrapolations": as_text(extrapolations(of, simulated))}
