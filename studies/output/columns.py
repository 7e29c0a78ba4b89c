"""Columns of results as variables with units, flags and attributes.

Maps and trade studies share what is here, of fixed and of sized aircraft.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from enum import IntEnum
from typing import Any

import numpy as np

from missions.files.writing import to_json
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.optimisation.objectives import RESIZE_NAMES, Objective, SizingStatus
from sizing.results.quantities import DESIGN_COLUMNS, LOAD, REACHED
from sizing.sunlight import SolarModel
from sizing.validity.extrapolations import from_text, together
from sizing.validity.ranges import Extrapolation
from solar._version import __version__
from solar.versions import FORMAT_VERSION
from studies.output.gridded import Labelled, OnGrid

CLIMB = "climb"  # attribute of results with climbs, in words
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

# What stands where a sizing failed; every other number is NaN unless the sizing is optimal.
BLANKS: dict[str, Any] = {
    "status": np.int8(SizingStatus.failed),
    **{one.variable: np.float64("nan") for one in (*DESIGN_COLUMNS, *REACHED, LOAD)},
    "shortfall": np.float64("nan"),
    "violated_requirement": np.str_(""),
    "message": np.str_(""),
    "extrapolations": np.str_(""),
}

# Variable -> unit, long name.
DESCRIBED: dict[str, tuple[str, str]] = {
    **{one.variable: one.described for one in DESIGN_COLUMNS},
    **{one.variable: (one.unit or "1", f"{one.label} of the worst scenario") for one in REACHED},
    LOAD.variable: LOAD.described,
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
    """Objective that every cell of a map and every point of a trade study can have."""
    if name not in RESIZE_NAMES:
        raise ValueError(f"unknown objective {str(name)!r}; allowed: {', '.join(RESIZE_NAMES)}")
    return Objective(name)


def variables(
    dims: tuple[str, ...],
    columns: Mapping[str, Any],
    described: Mapping[str, tuple[str, str]],
    flags: Iterable[IntEnum],
) -> dict[str, Labelled]:
    """Variables of a dataset, with CF attributes.

    ``columns``: values by name; what is not described is left out. Returns by name;
    :class:`xarray.Dataset` takes them as well.
    """
    labelled: dict[str, Labelled] = {}
    for name, (unit, text) in described.items():
        if name in columns and name != "status":
            labelled[name] = Labelled(dims, columns[name], {"units": unit, "long_name": text})
    meanings = {
        "long_name": described["status"][1],
        "flag_values": np.array([flag.value for flag in flags], np.int8),
        "flag_meanings": " ".join(flag.name for flag in flags),
    }
    return labelled | {"status": Labelled(dims, columns["status"], meanings)}


def attributes(
    title: str, aircraft: Aircraft, mission: Mission, solar: SolarModel
) -> dict[str, Any]:
    """Attributes of a dataset: everything that it was computed from.

    Returns texts by name, those of CF among them.
    """
    return {
        "Conventions": "CF-1.11",
        "title": title,
        "source": f"solar-uav {__version__}",
        "format_version": FORMAT_VERSION,
        "solar_model": solar.model,
        "correction": solar.correction,
        "aircraft": aircraft.model_dump_json(),
        "mission": mission.model_dump_json(),
        **({} if mission.climb is None else {CLIMB: mission.climb_label}),
    }


def flown_caption(data: OnGrid) -> str:
    """Model and correction that a map or a trade study was computed with, and its climbs."""
    label = SolarModel(data.attrs["solar_model"], data.attrs["correction"]).label
    return "; ".join(filter(None, (label, data.attrs.get(CLIMB, ""))))


def extrapolation_attribute(extrapolations: Sequence[Extrapolation]) -> dict[str, str]:
    """Attribute that tells what lies outside the range of a model; none where nothing does."""
    if not extrapolations:
        return {}
    return {"extrapolations": to_json([one.to_dict() for one in extrapolations])}


def extrapolations_of(data: OnGrid) -> tuple[Extrapolation, ...]:
    """What lies outside the range of a model in a map or a trade study, each quantity once."""
    records = json.loads(data.attrs.get("extrapolations", "[]"))
    return tuple(map(Extrapolation.from_dict, records))


def told_of_cells(
    columns: Mapping[str, Any], described: Sequence[int], what: str
) -> tuple[Extrapolation, ...]:
    """What the cells or points of a study tell, each quantity once with its worst value.

    ``columns``: with the status and the text of every cell.
    """
    known = np.isin(columns["status"], described)
    texts = np.asarray(columns["extrapolations"])[known]
    return together([from_text(str(text)) for text in texts.ravel()], what)


def failed_count(data: OnGrid) -> int:
    """Number of cells that could not be computed."""
    failed = data["status"].to_numpy() == SizingStatus.failed
    return int(failed.sum())  # the same in every status
