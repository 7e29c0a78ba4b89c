"""Cells of a map that is sized anew in each: the best design, or the reason without one."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from missions.flight_path import largest_wind_m_per_s
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel, solar_day
from sizing.day.module_power import on_path
from sizing.design import DesignVariables
from sizing.mass_budget import parametric_design
from sizing.performance import Performance, performance_of_designs
from sizing.program import cells as cell_sizing
from sizing.program.objectives import Objective, SizingStatus
from sizing.validity import checks as validity
from sizing.validity.extrapolations import cell_texts
from solar.types import FloatArray
from studies.engine.run import merged
from studies.output.gridded import SIZED, TOO_WINDY
from studies.quantities import DESIGN_COLUMNS, LOAD, REACHED

# Aircraft, mission, model and objective of all cells.
Sized: TypeAlias = tuple[Aircraft, Mission, SolarModel, Objective]


def sized_cells(sized: Sized, cells: FloatArray) -> dict[str, NDArray[Any]]:
    """Size the aircraft in every cell; return columns of :data:`.gridded.DESCRIBED`.

    A cell replaces the mission's latitude [deg] and day of year.
    """
    aircraft, mission, solar, goal = sized
    scenarios = Scenarios.of_cells(cells)
    troubles = solar.path_troubles(aircraft, mission, scenarios)
    windy = np.array([trouble is not None for trouble in troubles], bool)
    if windy.any():
        calm = sized_cells(sized, cells[~windy]) if not windy.all() else {}
        path = on_path(aircraft, mission).flight_path
        assert path is not None
        over_limit = mission.winds_on_path_m_per_s(scenarios) / largest_wind_m_per_s(path)
        return merged(
            ~windy,
            calm,
            {
                "status": np.full(windy.sum(), SizingStatus.infeasible, np.int8),
                "violated_requirement": np.full(windy.sum(), TOO_WINDY),
                "shortfall": over_limit[windy] - 1.0,
                "message": [f"flight path: {text}" for text in troubles if text is not None],
            },
        )
    sizings = cell_sizing.size_cells(aircraft, mission, scenarios, goal, solar)
    variables = sizings.variables
    design = parametric_design(aircraft, mission, variables, sizings.total_mass_kg)
    checks = [
        *validity.design_checks(aircraft, mission, design, solar),
        *validity.correction_check(scenarios, solar, mission),
    ]
    if validity.charge_rate_is_open(aircraft):
        day = solar_day(aircraft, mission, solar, scenarios=scenarios)
        peak_w = np.max(day.specific_power_w_per_m2, axis=-1) * variables.module_area_m2
        checks += validity.charge_rate_check(aircraft, mission, design, peak_w)
    outside = np.array(cell_texts(checks, len(scenarios)))
    known = variables._asdict() | vars(sizings)
    message = np.where(
        sizings.status == SizingStatus.not_converged,
        "the solver did not converge",
        sizings.message.astype(str),
    )
    return {
        "status": sizings.status.astype(np.int8),
        **{quantity.variable: known[quantity.name] for quantity in (*DESIGN_COLUMNS, *REACHED)},
        LOAD.variable: sizings.load_w,
        "shortfall": sizings.shortfall,
        "violated_requirement": sizings.requirement.astype(str),
        "message": message,
        "extrapolations": np.where(np.isin(sizings.status, SIZED), outside, ""),
    }


def sized_flight(sized: Sized, cell: FloatArray) -> Performance | None:
    """Simulate the best design of a single cell, shape ``(1, 2)``; None without a design."""
    aircraft, mission, solar, goal = sized
    scenario = Scenarios.of_cells(cell)
    sizings = cell_sizing.size_cells(aircraft, mission, scenario, goal, solar)
    if sizings.status[0] not in SIZED:
        return None
    values = (None if v is None else np.ravel(v)[0] for v in sizings.variables)
    day = solar_day(aircraft, mission, solar, scenarios=scenario)
    return performance_of_designs(aircraft, mission, DesignVariables(*values), solar, day=day)
