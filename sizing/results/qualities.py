"""The same requirement as teams of another quality of building would meet it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel
from sizing.design import Design
from sizing.mass_budget import ImpossibleDesignError
from sizing.parameters import all_replaced
from sizing.program.objectives import Objective
from sizing.program.own_flow import sized_in_own_flow
from sizing.program.result import SizingResult
from sizing.structures.build import build_qualities
from sizing.structures.models import UserStructure


@dataclass(frozen=True)
class BuiltDesign:
    """Best design of a class of building; ``of_file``: whether the file has that class."""

    build: str
    factor: float
    of_file: bool
    design: Design | None
    objective_value: float | None


def designs_by_build(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel,
    result: SizingResult,
    *,
    required_excess_time_h: float | None,
) -> tuple[BuiltDesign, ...]:
    """Best design of every class of building; ``result``: that of the aircraft's file.

    A calibration without ``build`` may be that of one's own aircraft: the classes have that of
    AtlantikSolar. A structure of the user's own has no classes.
    """
    structure = aircraft.parametric.structure
    if isinstance(structure, UserStructure):
        return ()
    fitted: dict[str, Any] = {}
    if structure.build is None and structure.atlantiksolar_calibration is not None:
        fitted["calibration"] = structure.atlantiksolar_calibration
    found = []
    for name, quality in build_qualities().items():
        changed = all_replaced(structure, fitted | {"build": name})
        of_file = bool(changed.mass_factor == structure.mass_factor)
        one: SizingResult | None = result
        if not of_file:
            given = (aircraft.with_airframe(structure=changed), mission, objective, solar)
            one = _sized(*given, result, required_excess_time_h)
        design, value = (None, None) if one is None else (one.design, one.objective_value)
        found.append(BuiltDesign(name, quality.factor, of_file, design, value))
    return tuple(found)


def _sized(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel,
    near: SizingResult,
    required_h: float | None,
) -> SizingResult | None:
    """Sizing that starts from another one; None where its propulsion flies no design."""
    near_design = None if near.design is None else near.design.variables
    try:
        return sized_in_own_flow(
            *(aircraft, mission, objective, solar),
            start=near_design,
            required_excess_time_h=required_h,
        )[1]
    except ImpossibleDesignError:
        return None
