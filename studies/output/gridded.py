"""Results on a grid as plain arrays with their units, and as files with the whole configuration.

What commands hold where they need no more: xarray takes two thirds of a second to import, with the
pandas that it brings. Functions that read a result by ``data[name].to_numpy()``, ``.attrs`` and
``in`` take either.
"""

from __future__ import annotations

import io
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from missions.files.writing import to_json
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel
from sizing.day.metrics import SUFFICIENT
from sizing.parameters import label
from sizing.program.objectives import RESIZE_NAMES, Objective, SizingStatus
from sizing.results.result import data_frame
from sizing.validity.extrapolations import from_text, merge_extrapolations
from sizing.validity.ranges import Extrapolation
from solar._version import __version__
from solar.versions import FORMAT_VERSION
from studies.output.formats import csv_bytes, table_bytes, workbook_bytes
from studies.quantities import DESIGN_COLUMNS, REACHED, described
from studies.render.words import requirements
from studies.serialise import serialise

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


class Labelled(NamedTuple):
    """Values with their dimensions and attributes, in the order in which xarray takes them."""

    dims: tuple[str, ...]
    values: NDArray[Any]
    attrs: Mapping[str, Any]

    def to_numpy(self) -> NDArray[Any]:
        """Return the values."""
        return self.values


@dataclass(frozen=True)
class Gridded:
    """Variables and coordinates by name, and attributes of them all."""

    variables: Mapping[str, Labelled]
    coordinates: Mapping[str, Labelled]
    attrs: Mapping[str, Any]

    def __getitem__(self, name: str) -> Labelled:
        """Return a variable or a coordinate."""
        return self.variables[name] if name in self.variables else self.coordinates[name]

    def __contains__(self, name: str) -> bool:
        """Tell whether there is such a variable or coordinate."""
        return name in self.variables or name in self.coordinates

    def to_xarray(self) -> xr.Dataset:
        """Return the same as a dataset."""
        import xarray as xr

        return xr.Dataset(dict(self.variables), dict(self.coordinates), dict(self.attrs))


# A type of annotations alone: xarray is not imported for it.
OnGrid: TypeAlias = "Gridded | xr.Dataset"


def to_netcdf_bytes(data: OnGrid) -> bytes:
    """Return a result as NetCDF-4, made in memory: HDF5 crashes where a disk is full.

    The file is the same whether xarray writes it or not.
    """
    if not isinstance(data, Gridded):
        return bytes(data.to_netcdf(engine="h5netcdf"))
    import h5netcdf
    import h5py

    buffer, columns = io.BytesIO(), {**data.variables, **data.coordinates}
    with h5netcdf.File(buffer, "w") as file:
        file.attrs.update(data.attrs)
        for column in columns.values():
            for dim, size in zip(column.dims, column.values.shape, strict=True):
                if dim not in file.dimensions:
                    file.dimensions[dim] = size
        for name, (dims, values, attrs) in columns.items():
            text, number = values.dtype.kind == "U", values.dtype.kind == "f"
            kind = h5py.string_dtype() if text else values.dtype
            fill = np.nan if number else None
            variable = file.create_variable(name, dims, dtype=kind, fillvalue=fill)
            variable.attrs.update(attrs)
            variable[...] = values.astype(object) if text else values
    return buffer.getvalue()


def status_names(data: OnGrid) -> dict[int, str]:
    """Name of every flag of a dataset's status."""
    flags = data["status"].attrs
    return dict(zip(map(int, flags["flag_values"]), flags["flag_meanings"].split(), strict=True))


def to_bytes(data: OnGrid, file_format: str | None, cells: str) -> bytes:
    """Return a file in one of :data:`studies.output.formats.GRID_FORMATS`, by default NetCDF.

    A CSV file has the configuration as JSON in its first line, behind ``#``; a Parquet file in the
    table's attributes; a workbook in a sheet of its own, beside that of the ``cells``.
    """
    if file_format in ("nc", None):
        return to_netcdf_bytes(data)
    table = to_table(data)
    if file_format == "csv":
        return f"# {to_json(table.attrs)}\n".encode() + csv_bytes(table)
    if file_format == "xlsx":
        texts = [v if isinstance(v, str) else to_json(v) for v in table.attrs.values()]
        configuration = data_frame({"key": [str(key) for key in table.attrs], "value": texts})
        return workbook_bytes({cells: table, "configuration": configuration})
    return table_bytes(table, f"table.{file_format}")


def to_table(data: OnGrid) -> pd.DataFrame:
    """Return a row for each cell of a map or point of a trade study.

    Parameters
    ----------
    data : xarray.Dataset
        What :func:`studies.feasibility_map`, :func:`studies.resized_map` or :func:`studies.sweep`
        returned.

    Returns
    -------
    pandas.DataFrame
        Coordinates, ``status`` in words, then the other variables in the units of the data; the
        data's attributes are those of the table.
    """
    names = status_names(data)
    dataset = data.to_xarray() if isinstance(data, Gridded) else data
    table = dataset.to_dataframe().reset_index()
    table["status"] = [names[int(value)] for value in table["status"]]
    first = [str(name) for name in dataset.coords if name in table.columns]
    rest = [name for name in table.columns if name not in (*first, "status", "sample")]
    table = table[[*first, "status", *rest]]
    table.attrs = {str(key): value for key, value in data.attrs.items()}
    return table


# ---- Columns as variables with units, flags and attributes, of fixed and of sized aircraft

CLIMB = "climb"  # attribute of results with climbs, in words
# There is a design.
SIZED = tuple(status for status in SizingStatus if status.sized)
TOO_WINDY = "flight_path"  # requirement that a cell misses whose wind is too strong for the path

# Status without a result, which figures hatch.
WITHOUT_RESULT = ("infeasible", "invalid", "not_converged", "failed", "never_lit")

# Why a cell has no result.
_REASONS = {
    "invalid": "no valid design",
    "not_converged": "solver did not converge",
    "failed": "could not be computed",
    "never_lit": "polar night",
}
# Variable -> unit, long name.
DESCRIBED: dict[str, tuple[str, str]] = {
    **{quantity.variable: quantity.described for quantity in DESIGN_COLUMNS},
    **{
        quantity.variable: (quantity.unit or "1", f"{quantity.label} of the worst scenario")
        for quantity in REACHED
    },
    **described("power_out_w shortfall violated_requirement message extrapolations status"),
}


def requirement_label(name: str) -> str:
    """Return a requirement that is not met in words.

    ``name``: as a sizing calls it, for instance ``energy_balance`` or ``wing_loading_maximum``.
    """
    if reason := requirements().get(name, {}).get("reason"):
        return reason
    quantity, _, end = name.rpartition("_")
    if end in ("minimum", "maximum"):
        return f"limit: {label(quantity)}"
    return name.replace("_", " ") or "no design"


def reasons_without_result(data: OnGrid) -> NDArray[Any]:
    """Return why each cell has no result, in words; empty where it has one."""
    names, status = status_names(data), data["status"].to_numpy()
    reasons = np.full(status.shape, "", dtype=object)
    for value, name in names.items():
        if name in WITHOUT_RESULT:
            # Of a map of a fixed aircraft nothing else is infeasible.
            reasons[status == value] = _REASONS.get(name, requirement_label(TOO_WINDY))
    if "violated_requirement" in data:
        infeasible = np.isin(status, [v for v, name in names.items() if name == "infeasible"])
        missed = data["violated_requirement"].to_numpy()
        reasons[infeasible] = [requirement_label(str(name)) for name in missed[infeasible]]
    return reasons


def resize_objective(name: str | Objective) -> Objective:
    """Return an objective that cells of maps and points of trade studies can have."""
    if name not in RESIZE_NAMES:
        raise ValueError(f"unknown objective {str(name)!r}; allowed: {', '.join(RESIZE_NAMES)}")
    return Objective(name)


def variables(
    dims: tuple[str, ...],
    columns: Mapping[str, Any],
    described: Mapping[str, tuple[str, str]],
    flags: Iterable[IntEnum],
) -> dict[str, Labelled]:
    """Return the variables of a dataset, with CF attributes.

    ``columns``: values by name; what is not described is left out. Returns by name;
    :class:`xarray.Dataset` takes them as well.
    """
    labelled = {
        name: Labelled(dims, columns[name], {"units": unit, "long_name": text})
        for name, (unit, text) in described.items()
        if name in columns and name != "status"
    }
    if "status" not in columns:
        return labelled
    meanings = {
        "long_name": described["status"][1],
        "flag_values": np.array([flag.value for flag in flags], np.int8),
        "flag_meanings": " ".join(flag.name for flag in flags),
    }
    return labelled | {"status": Labelled(dims, columns["status"], meanings)}


def attributes(
    title: str, aircraft: Aircraft, mission: Mission, solar: SolarModel
) -> dict[str, Any]:
    """Return the attributes of a dataset: everything that it was computed from.

    Returns texts by name, those of CF among them; an empty one is left out.
    """
    texts = {
        "Conventions": "CF-1.11",
        "title": title,
        "source": f"solar-uav {__version__}",
        "format_version": FORMAT_VERSION,
        "solar_model": solar.model,
        "correction": solar.correction,
        "aircraft": aircraft.model_dump_json(),
        "mission": mission.model_dump_json(),
        CLIMB: mission.climb_label,
    }
    return {name: text for name, text in texts.items() if text != ""}


def flown_caption(data: OnGrid) -> str:
    """Return the model and correction of a map or a trade study, and its climbs."""
    label = SolarModel(data.attrs["solar_model"], data.attrs["correction"]).label
    return "; ".join(filter(None, (label, data.attrs.get(CLIMB, ""))))


def extrapolation_attribute(extrapolations: Sequence[Extrapolation]) -> dict[str, str]:
    """Return the attribute of what is extrapolated; none where nothing is."""
    if not extrapolations:
        return {}
    return {"extrapolations": to_json(serialise(extrapolations))}


def extrapolations_of(data: OnGrid) -> tuple[Extrapolation, ...]:
    """Return what is extrapolated in a map or a trade study, each quantity once."""
    records = json.loads(data.attrs.get("extrapolations", "[]"))
    return tuple(map(Extrapolation.from_dict, records))


def told_of_cells(
    columns: Mapping[str, Any], described: Sequence[int], what: str
) -> tuple[Extrapolation, ...]:
    """Return what is extrapolated in cells or points, with its worst values.

    ``columns``: with the status and the text of every cell.
    """
    known = np.isin(columns["status"], described)
    texts = np.asarray(columns["extrapolations"])[known]
    return merge_extrapolations([from_text(str(text)) for text in texts.ravel()], what)


def shown_places(values: Sequence[float], most: int) -> list[int]:
    """Return the indices of values that a table of so many rows shows, round ones first."""
    every = list(range(len(values)))
    if len(every) <= most:
        return every
    at_round = ([i for i in every if values[i] % step == 0.0] for step in (1, 2, 5, 10, 15, 30))
    few = (indices for indices in at_round if 0 < len(indices) <= most)
    return next(few, every[:: math.ceil(len(every) / most)])


def feasible(data: OnGrid) -> NDArray[np.bool_]:
    """Mark the cells or points that fly perpetually, or to a landing, or that were sized."""
    good = SIZED if data.attrs.get("objective") else SUFFICIENT
    return np.isin(data["status"].to_numpy(), good)
