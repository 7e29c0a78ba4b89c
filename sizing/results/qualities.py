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
    """Return the best design of every build quality; ``result``: that of the aircraft's file.

    A calibration without ``build`` may be that of one's own aircraft: the classes have that of
    AtlantikSolar. A structure of the user's own has no classes.
    """
    structure = aircraft.parametric.structure
    if isinstance(structure, UserStructure):
        return ()
    fitted: dict[str, Any] = {}
    if structure.build is None and structure.atlantiksolar_calibration is not None:
        fitted["calibration"] = structure.atlantiksolar_calibration
    designs = []
    for name, quality in build_qualities().items():
        changed = all_replaced(structure, fitted | {"build": name})
        of_file = bool(changed.mass_factor == structure.mass_factor)
        sizing: SizingResult | None = result
        if not of_file:
            start = None if result.design is None else result.design.variables
            built = aircraft.with_airframe(structure=changed)
            try:
                _, sizing = sized_in_own_flow(
                    built,
                    mission,
                    objective,
                    solar,
                    start=start,
                    required_excess_time_h=required_excess_time_h,
                )
            except ImpossibleDesignError:  # its propulsion flies no design
                sizing = None
        design, value = (None, None) if sizing is None else (sizing.design, sizing.objective_value)
        designs.append(BuiltDesign(name, quality.factor, of_file, design, value))
    return tuple(designs)
