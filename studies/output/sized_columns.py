"""Many sizings as columns: the best design in every cell of a map, or at a point of a trade study.

Apart from :mod:`studies.output.gridded`, which needs no optimiser.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from missions.flight_path import largest_wind_m_per_s
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel, solar_day
from sizing.day.module_power import on_path, path_troubles
from sizing.design import DesignVariables
from sizing.mass_budget import parametric_design
from sizing.performance import Performance, performance_of_designs
from sizing.program import cells as cell_sizing
from sizing.program.cells import CellSizings
from sizing.program.objectives import Objective, SizingStatus
from sizing.program.size import size_aircraft
from sizing.results.quantities import DESIGN_COLUMNS, LOAD, PAYLOAD_MASS, REACHED
from sizing.validity.checks import (
    charge_rate_check,
    charge_rate_is_open,
    correction_check,
    design_checks,
)
from sizing.validity.extrapolations import as_text, cell_texts, extrapolations
from solar.types import FloatArray
from studies.output.gridded import BLANKS, SIZED, TOO_WINDY


def sizing_row(
    aircraft: Aircraft, mission: Mission, objective: Objective, solar: SolarModel, *, of: Aircraft
) -> dict[str, Any]:
    """Best design at a point of a trade study; what it has not is missing, see :data:`BLANKS`.

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


def sized_cells(
    aircraft: Aircraft,
    mission: Mission,
    cells: Sequence[tuple[float, ...]],
    objective: Objective,
    solar: SolarModel,
) -> dict[str, Any]:
    """Best design of an aircraft in every cell, as columns of :data:`.gridded.DESCRIBED`.

    A cell is the mission with the cell's latitude [deg] and day of year instead of its own.
    """
    scenarios = Scenarios(
        np.array([float(cell[0]) for cell in cells]), np.array([int(cell[1]) for cell in cells])
    )
    troubles = path_troubles(aircraft, mission, scenarios) if solar.needs_path else []
    if any(troubles):
        calm = [cell for cell, trouble in zip(cells, troubles, strict=True) if trouble is None]
        sized = sized_cells(aircraft, mission, calm, objective, solar) if calm else {}
        path = on_path(aircraft, mission).flight_path
        assert path is not None
        winds = mission.winds_on_path_m_per_s(scenarios)
        return _beside_windy_cells(sized, troubles, winds / largest_wind_m_per_s(path))
    sizings = cell_sizing.size_cells(aircraft, mission, scenarios, objective, solar)
    columns = _columns_of(sizings)
    columns["extrapolations"] = _extrapolations_of_cells(
        aircraft, mission, scenarios, solar, sizings
    )
    for index in np.flatnonzero(scenarios.in_polar_night()):
        for name, blank in BLANKS.items():
            columns[name][index] = _POLAR_NIGHT.get(name, blank)
    return columns


def _beside_windy_cells(
    sized: dict[str, Any], troubles: Sequence[str | None], over_limit: FloatArray
) -> dict[str, Any]:
    """Columns of all cells, from those whose wind the flight path can be held in.

    ``over_limit``: wind of each cell over the largest of the path [-].
    """
    able = np.array([trouble is None for trouble in troubles])
    columns: dict[str, Any] = {}
    for name, blank in BLANKS.items():
        columns[name] = np.full(len(able), blank, object if isinstance(blank, str) else None)
        if sized:
            columns[name][able] = sized[name]
    for index in np.flatnonzero(~able).tolist():
        columns["status"][index] = np.int8(SizingStatus.infeasible)
        columns["violated_requirement"][index] = TOO_WINDY
        columns["shortfall"][index] = over_limit[index] - 1.0
        columns["message"][index] = f"flight path: {troubles[index]}"
    return {name: v.tolist() if v.dtype == object else v for name, v in columns.items()}


def sized_flight(
    aircraft: Aircraft,
    mission: Mission,
    cell: tuple[float, int],
    objective: Objective,
    solar: SolarModel,
) -> Performance | None:
    """Fly the best design of a single cell.

    None where there is no design.
    """
    scenario = Scenarios(np.array([cell[0]]), np.array([cell[1]]))
    sizings = cell_sizing.size_cells(aircraft, mission, scenario, objective, solar)
    if sizings.status[0] not in SIZED:
        return None
    values = (None if v is None else np.ravel(v)[0] for v in sizings.variables)
    day = solar_day(aircraft, mission, solar, scenarios=scenario)
    return performance_of_designs(aircraft, mission, DesignVariables(*values), solar, day=day)


def _columns_of(sizings: CellSizings) -> dict[str, Any]:
    known = sizings.variables._asdict() | vars(sizings)
    return {
        "status": sizings.status.astype(np.int8),
        **{one.variable: known[one.name] for one in (*DESIGN_COLUMNS, *REACHED)},
        LOAD.variable: sizings.load_w,
        "shortfall": sizings.shortfall,
        "violated_requirement": sizings.requirement.tolist(),
        "message": [
            "the solver did not converge" if status == SizingStatus.not_converged else text
            for status, text in zip(sizings.status, sizings.message.tolist(), strict=True)
        ],
    }


def _extrapolations_of_cells(
    aircraft: Aircraft,
    mission: Mission,
    scenarios: Scenarios,
    solar: SolarModel,
    sizings: CellSizings,
) -> list[str]:
    """What the design of every cell takes from outside the range of a model."""
    sized = np.isin(sizings.status, SIZED)
    design = parametric_design(aircraft, mission, sizings.variables, sizings.total_mass_kg)
    checks = [
        *design_checks(aircraft, mission, design, solar),
        *correction_check(scenarios, solar, mission),
    ]
    if charge_rate_is_open(aircraft):
        day = solar_day(aircraft, mission, solar, scenarios=scenarios)
        peak_w = np.max(day.specific_power_w_per_m2, axis=-1) * sizings.variables.module_area_m2
        checks += charge_rate_check(aircraft, mission, design, peak_w)
    texts = cell_texts(checks, len(scenarios))
    return [text if there else "" for text, there in zip(texts, sized, strict=True)]


# There is nothing to solve without any sun; the whole of the day's energy is missing.
_POLAR_NIGHT: dict[str, Any] = {
    "status": SizingStatus.infeasible,
    "violated_requirement": "sun",
    "message": "polar night: the sun never rises",
}
