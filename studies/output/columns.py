"""Gridded results: many sizings as columns, and columns as variables with units, flags, attributes.

Maps and trade studies share what is here.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from enum import IntEnum
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.design import parametric_design
from sizing.optimisation import cells as cell_sizing
from sizing.optimisation.cells import CellSizings
from sizing.optimisation.objectives import Objective
from sizing.optimisation.problem import SizingProblems
from sizing.optimisation.result import SizingResult, SizingStatus
from sizing.sunlight import SolarModel, solar_day
from sizing.validity.checks import (
    charge_rate_check,
    charge_rate_is_open,
    correction_check,
    design_checks,
    path_check,
)
from sizing.validity.ranges import Extrapolation
from sizing.validity.told import cell_texts, from_text, together
from solar._version import __version__
from solar.names import RESIZE_NAMES

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "BLANKS",
    "DESCRIBED",
    "HATCHES",
    "SIZED",
    "SizingStatus",
    "attributes",
    "extrapolation_attribute",
    "extrapolations_of",
    "failed_cells",
    "failed_count",
    "resize_objective",
    "size_cells",
    "sizing_row",
    "status_names",
    "to_netcdf_bytes",
    "told_of_cells",
    "variables",
]


# There is a design.
SIZED = tuple(status for status in SizingStatus if status.sized)

# Status without a result -> how figures hatch it.
HATCHES = {
    "infeasible": "///",
    "invalid": "\\\\\\",
    "not_converged": "xx",
    "failed": "..",
    "never_lit": "++",
}

_NAN = np.float64("nan")

# What stands where a sizing failed; every other number is NaN unless the sizing is optimal.
BLANKS: dict[str, Any] = {
    "status": np.int8(SizingStatus.failed),
    "wingspan": _NAN,
    "aspect_ratio": _NAN,
    "battery_mass": _NAN,
    "module_area": _NAN,
    "payload_mass": _NAN,
    "payload_power": _NAN,
    "total_mass": _NAN,
    "excess_time": _NAN,
    "charge_margin": _NAN,
    "minimum_state_of_charge": _NAN,
    "power": _NAN,
    "shortfall": _NAN,
    "violated_requirement": np.str_(""),
    "message": np.str_(""),
    "extrapolations": np.str_(""),
}

# Variable -> unit, long name.
DESCRIBED: dict[str, tuple[str, str]] = {
    "wingspan": ("m", "wingspan"),
    "aspect_ratio": ("1", "aspect ratio"),
    "battery_mass": ("kg", "battery mass"),
    "module_area": ("m2", "area of the solar modules"),
    "payload_mass": ("kg", "payload mass"),
    "payload_power": ("W", "power of the payload"),
    "total_mass": ("kg", "total mass"),
    "excess_time": ("h", "excess time of the worst scenario"),
    "charge_margin": ("h", "charge margin of the worst scenario"),
    "minimum_state_of_charge": ("1", "minimum state of charge of the worst scenario"),
    "power": ("W", "nominal load"),
    "shortfall": (
        "1",
        "by how much the violated requirement is missed: relative to its limit, for "
        "battery_capacity and energy_balance to the battery's capacity, for excess_time in hours",
    ),
    "violated_requirement": ("1", "requirement that no design meets"),
    "message": ("1", "why there is no design"),
    "extrapolations": ("1", "what lies outside the range of a model"),
    "status": ("1", "how it ends"),
}


def resize_objective(name: str | Objective) -> Objective:
    """Objective that every cell of a map and every point of a trade study can have.

    Raises
    ------
    ValueError
        If the name is none of them.
    """
    if name not in RESIZE_NAMES:
        raise ValueError(f"unknown objective {str(name)!r}; allowed: {', '.join(RESIZE_NAMES)}")
    return Objective(name)


def sizing_row(result: SizingResult) -> dict[str, Any]:
    """What a sizing has to say; what it has not is missing, see :data:`BLANKS`."""
    row: dict[str, Any] = {"status": result.status}
    if result.status is SizingStatus.not_converged:
        return row | {"message": f"the solver did not converge ({result.solver.message})"}
    if result.violations:
        worst = max(result.violations, key=lambda v: v.shortfall)
        row |= {"shortfall": worst.shortfall, "violated_requirement": worst.requirement}
        row |= {"message": "; ".join(v.text for v in result.violations)}
    if result.simulated is None or result.design is None:
        return row
    design, perf = result.design, result.simulated
    worst_scenario = perf.worst_scenario()
    return row | {
        "wingspan": design.variables.wingspan_m,
        "aspect_ratio": design.variables.aspect_ratio,
        "battery_mass": design.variables.battery_mass_kg,
        "module_area": design.variables.module_area_m2,
        "payload_mass": design.masses.payload,
        "payload_power": design.variables.payload_power_w,
        "total_mass": design.total_mass_kg,
        "excess_time": float(perf.cycle.excess_time_h[worst_scenario]),
        "charge_margin": float(perf.cycle.charge_margin_h[worst_scenario]),
        "minimum_state_of_charge": float(perf.cycle.minimum_state_of_charge[worst_scenario]),
        "power": float(perf.nominal_load_w.ravel()[0]),
    }


def size_cells(
    aircraft: Aircraft,
    mission: Mission,
    cells: Sequence[tuple[float, ...]],
    objective: Objective,
    solar: SolarModel,
) -> dict[str, Any]:
    """Best design of an aircraft in every cell of latitude [deg] and day of year, as columns.

    A cell is the mission with the cell's latitude and day instead of its own.

    Parameters
    ----------
    aircraft : Aircraft
        What is sized.
    mission : Mission
        In which air and with which load.
    cells : sequence of (float, float)
        Latitude [deg] and day of year.
    objective : Objective
        What is as large or as small as possible.
    solar : SolarModel
        Model and correction.

    Returns
    -------
    dict
        Values of all cells by the names of :data:`DESCRIBED`, in its units.
    """
    scenarios = Scenarios(
        np.array([float(cell[0]) for cell in cells]), np.array([int(cell[1]) for cell in cells])
    )
    problems = _programs(aircraft)
    found = cell_sizing.size_cells(
        problems.aircraft, mission, scenarios, objective, solar, problems=problems
    )
    columns = _columns(found)
    columns["extrapolations"] = _extrapolations(aircraft, mission, scenarios, solar, found)
    for index in np.flatnonzero(scenarios.in_polar_night()):
        for name, blank in BLANKS.items():
            columns[name][index] = _POLAR_NIGHT.get(name, blank)
    return columns


@lru_cache(maxsize=1)
def _programs(aircraft: Aircraft) -> SizingProblems:
    """Programs of an aircraft, kept for the next chunk of the same map in this process."""
    return SizingProblems(aircraft)


def _columns(found: CellSizings) -> dict[str, Any]:
    chosen = found.variables
    return {
        "status": found.status.astype(np.int8),
        "wingspan": chosen.wingspan_m,
        "aspect_ratio": chosen.aspect_ratio,
        "battery_mass": chosen.battery_mass_kg,
        "module_area": chosen.module_area_m2,
        "payload_mass": chosen.payload_mass_kg,
        "payload_power": chosen.payload_power_w,
        "total_mass": found.total_mass_kg,
        "excess_time": found.excess_time_h,
        "charge_margin": found.charge_margin_h,
        "minimum_state_of_charge": found.minimum_state_of_charge,
        "power": found.load_w,
        "shortfall": found.shortfall,
        "violated_requirement": found.requirement.tolist(),
        "message": [_message(SizingStatus(one)) for one in found.status],
    }


def _extrapolations(
    aircraft: Aircraft,
    mission: Mission,
    scenarios: Scenarios,
    solar: SolarModel,
    found: CellSizings,
) -> list[str]:
    """What the design of every cell takes from outside the range of a model."""
    sized = np.isin(found.status, SIZED)
    design = parametric_design(aircraft, mission, found.variables, found.total_mass_kg)
    checks = [
        *design_checks(aircraft, mission, design),
        *path_check(mission, solar, design),
        *correction_check(scenarios, solar, mission),
    ]
    if charge_rate_is_open(aircraft):
        day = solar_day(aircraft, mission, solar, scenarios=scenarios)
        peak_w = np.max(day.specific_power_w_per_m2, axis=-1) * found.variables.module_area_m2
        checks += charge_rate_check(aircraft, mission, design, peak_w)
    texts = cell_texts(checks, len(scenarios))
    return [text if there else "" for text, there in zip(texts, sized, strict=True)]


def _message(status: SizingStatus) -> str:
    return {
        SizingStatus.infeasible: "no design meets every requirement",
        SizingStatus.not_converged: "the solver did not converge",
    }.get(status, "")


# There is nothing to solve without any sun; the whole of the day's energy is missing.
_POLAR_NIGHT: dict[str, Any] = {
    "status": SizingStatus.infeasible,
    "violated_requirement": "sun",
    "message": "polar night: the sun never rises",
}


# ---- Columns as datasets


def variables(
    dims: tuple[str, ...],
    columns: Mapping[str, Any],
    described: Mapping[str, tuple[str, str]],
    flags: type[IntEnum],
) -> dict[str, Any]:
    """Variables of a dataset, with CF attributes.

    Parameters
    ----------
    dims : tuple of str
        Dimensions of all columns.
    columns : mapping of ndarray
        Values by name; what is not described is left out.
    described : mapping
        Unit and long name of every variable.
    flags : type of IntEnum
        What the variable ``status`` may be.

    Returns
    -------
    dict
        Dimensions, values and attributes by name, as :class:`xarray.Dataset` takes them.
    """
    found: dict[str, Any] = {}
    for name, (unit, text) in described.items():
        if name in columns and name != "status":
            found[name] = (dims, columns[name], {"units": unit, "long_name": text})
    meanings = {
        "long_name": described["status"][1],
        "flag_values": np.array([flag.value for flag in flags], np.int8),
        "flag_meanings": " ".join(flag.name for flag in flags),
    }
    return found | {"status": (dims, columns["status"], meanings)}


def attributes(
    title: str, aircraft: Aircraft, mission: Mission, solar: SolarModel
) -> dict[str, Any]:
    """Attributes of a dataset: everything that it was computed from.

    Parameters
    ----------
    title : str
        What was computed.
    aircraft : Aircraft
        Kept as JSON.
    mission : Mission
        Kept as JSON.
    solar : SolarModel
        Model and correction.

    Returns
    -------
    dict
        Texts by name, those of CF among them.
    """
    return {
        "Conventions": "CF-1.11",
        "title": title,
        "source": f"solar-uav {__version__}",
        "solar_model": solar.model,
        "correction": solar.correction,
        "aircraft": aircraft.model_dump_json(),
        "mission": mission.model_dump_json(),
    }


def failed_cells(
    cells: Sequence[tuple[float, ...]], failures: Mapping[int, str], names: Sequence[str]
) -> dict[str, str]:
    """Attribute that says which cells failed, and why; none where none did.

    Parameters
    ----------
    cells : sequence of tuple of float
        All cells.
    failures : mapping
        Reasons by the number of the cell.
    names : sequence of str
        What the numbers of a cell are.

    Returns
    -------
    dict
        The attribute ``failed_cells``, one line for each cell, or nothing.
    """
    if not failures:
        return {}
    lines = [
        ", ".join(f"{name} {value:g}" for name, value in zip(names, cells[i], strict=True))
        + f": {text}"
        for i, text in sorted(failures.items())
    ]
    return {"failed_cells": "\n".join(lines)}


def extrapolation_attribute(found: Sequence[Extrapolation]) -> dict[str, str]:
    """Attribute that tells what lies outside the range of a model; none where nothing does."""
    if not found:
        return {}
    return {"extrapolations": json.dumps([one.to_dict() for one in found])}


def extrapolations_of(data: xr.Dataset) -> tuple[Extrapolation, ...]:
    """What lies outside the range of a model in a map or a trade study, each quantity once."""
    records = json.loads(data.attrs.get("extrapolations", "[]"))
    return tuple(map(Extrapolation.from_dict, records))


def told_of_cells(
    columns: Mapping[str, Any], described: Sequence[int], what: str
) -> tuple[Extrapolation, ...]:
    """What the cells or points of a study tell, each quantity once with its worst value.

    Parameters
    ----------
    columns : mapping of ndarray
        With the status and the text of every cell.
    described : sequence of int
        Statuses of the cells that have a result.
    what : str
        What they are, in the plural.

    Returns
    -------
    tuple of Extrapolation
    """
    known = np.isin(columns["status"], described)
    texts = np.asarray(columns["extrapolations"])[known]
    return together([from_text(str(text)) for text in texts.ravel()], what)


def status_names(data: xr.Dataset) -> dict[int, str]:
    """Name of every flag of a dataset's status."""
    flags = data["status"].attrs
    return dict(zip(map(int, flags["flag_values"]), flags["flag_meanings"].split(), strict=True))


def failed_count(data: xr.Dataset) -> int:
    """Number of cells that could not be computed."""
    return int((data["status"] == SizingStatus.failed).sum())  # the same in every status


def to_netcdf_bytes(data: xr.Dataset) -> bytes:
    """NetCDF-4 file of a dataset, made in memory: HDF5 crashes where a disk is full."""
    return bytes(data.to_netcdf(engine="h5netcdf"))
