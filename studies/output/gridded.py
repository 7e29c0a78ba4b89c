"""Results on a grid as plain arrays with their units, and as files with the whole configuration.

What commands hold where they need no more: xarray takes two thirds of a second to import, with the
pandas that it brings. Functions that read a result by ``data[name].to_numpy()``, ``.attrs`` and
``in`` take either.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from missions.files.writing import to_json
from sizing.results.tables import data_frame
from sizing.validity.extrapolations import from_text
from studies.output.formats import csv_bytes, table_bytes, workbook_bytes

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
        return dataset(self.variables, self.coordinates, self.attrs)


def dataset(variables: Any, coordinates: Any, attrs: Mapping[str, Any]) -> xr.Dataset:
    """Dataset of variables, coordinates and attributes as xarray takes them."""
    import xarray as xr

    return xr.Dataset(dict(variables), dict(coordinates), dict(attrs))


# A type of annotations alone: xarray is not imported for it.
OnGrid: TypeAlias = "Gridded | xr.Dataset"


def to_netcdf_bytes(data: OnGrid) -> bytes:
    """NetCDF-4 file of a result, made in memory: HDF5 crashes where a disk is full.

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


def can_be_result(
    statuses: Iterable[IntEnum], computed: Collection[IntEnum]
) -> Callable[[Mapping[str, Any]], bool]:
    """Check of columns that an earlier run is said to have kept.

    ``computed``: with which of them the excess time is a number. Returns whether columns can be
    what a computation without failures gives.
    """

    def check(columns: Mapping[str, Any]) -> bool:
        known = [one for one in statuses if one.name != "failed"]
        status = np.asarray(columns["status"])
        if not np.isin(status, known).all():
            return False
        if np.isnan(np.asarray(columns["excess_time"])[np.isin(status, list(computed))]).any():
            return False
        for text in np.unique(columns.get("extrapolations", ())):
            from_text(str(text))  # raises for what is none
        return True

    return check


def status_names(data: OnGrid) -> dict[int, str]:
    """Name of every flag of a dataset's status."""
    flags = data["status"].attrs
    return dict(zip(map(int, flags["flag_values"]), flags["flag_meanings"].split(), strict=True))


def to_bytes(data: OnGrid, file_format: str | None, cells: str) -> bytes:
    """Content of a file in one of :data:`studies.output.formats.GRID_FORMATS`; NetCDF for none.

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
    """One row per cell of a map or point of a trade study.

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
