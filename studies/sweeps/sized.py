"""Points of a trade study that are sized, with what is varied held."""

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
from studies.sweeps.points import SweepConfiguration, columns_of, flyable


def held(aircraft: Aircraft, variables: Mapping[str, float]) -> Aircraft:
    """Aircraft whose design variables of these names cannot be chosen any more.

    Bounds that coincide make the solver take a variable out of the problem.

    ``variables``: values by the short names of design variables, such as ``wingspan_m``. Returns
    with these values, and a design space that leaves no choice of them.
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
    """Size some points, with what is varied held.

    ``cells``: values of the varied keys at each point, in the order of ``configuration.keys`` and
    their units. Returns values of all points, as the configuration describes them.
    """
    assert configuration.objective is not None
    rows: list[dict[str, Any]] = [{} for _ in cells]
    for numbers, aircraft, mission in flyable(configuration, cells, rows, SizingStatus):
        for number in numbers:
            given = zip(
                map(design_variable, configuration.keys), cells[number].tolist(), strict=True
            )
            sized = held(aircraft, {name: value for name, value in given if name is not None})
            sought = configuration.objective, configuration.solar
            try:
                rows[number] = _sizing_row(sized, mission, *sought, of=aircraft)
            except ImpossibleDesignError as error:
                rows[number] = {"status": SizingStatus.infeasible, "message": str(error)}
    return columns_of(configuration, rows)


def _sizing_row(
    aircraft: Aircraft, mission: Mission, objective: Objective, solar: SolarModel, *, of: Aircraft
) -> dict[str, Any]:
    """Best design at a point of a trade study; what it has not is missing.

    ``of``: the aircraft without what the point holds.
    """
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
    flown, scenario = result.simulated, result.simulated.worst_scenario()
    row |= {one.variable: one.of(result.design) for one in DESIGN_COLUMNS}
    row |= {one.variable: float(one.of(flown)[scenario]) for one in (*REACHED, LOAD)}
    return row | {"extrapolations": as_text(extrapolations(of, flown))}
