"""Results on a grid as files: NetCDF, CSV, Parquet and Excel, with the whole configuration."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from missions.files.writing import to_json
from sizing.results.tables import data_frame
from studies.output.columns import status_names
from studies.output.formats import csv_bytes, table_bytes, workbook_bytes
from studies.output.gridded import Gridded, OnGrid, to_netcdf_bytes

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["to_bytes", "to_table"]


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
        return workbook_bytes({cells: table, "configuration": _configuration(table.attrs)})
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


def _configuration(attrs: dict[Any, Any]) -> pd.DataFrame:
    """Whole configuration as keys and values."""
    texts = [value if isinstance(value, str) else to_json(value) for value in attrs.values()]
    return data_frame({"key": [str(key) for key in attrs], "value": texts})
