"""Trade studies as files: NetCDF, CSV and Parquet, the whole configuration inside each."""

from __future__ import annotations

import io
import json
from pathlib import PurePath
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["FORMATS", "table_format", "to_bytes"]

FORMATS = ("nc", "csv", "parquet")


def table_format(path: str) -> str | None:
    """Format of a file name, none if it is not one that can be written."""
    suffix = PurePath(path).suffix.lstrip(".").lower()
    return suffix if suffix in FORMATS else None


def to_bytes(data: xr.Dataset, file_format: str) -> bytes:
    """Content of a file.

    A CSV file has the configuration as JSON in its first line, behind ``#``; a Parquet file in the
    table's attributes.

    Parameters
    ----------
    data : xarray.Dataset
        Trade study.
    file_format : {"nc", "csv", "parquet"}
        NetCDF, or the points as a table.

    Returns
    -------
    bytes

    Raises
    ------
    ImportError
        For Parquet without pyarrow.
    """
    if file_format == "nc":
        from studies.output.columns import to_netcdf_bytes

        return to_netcdf_bytes(data)
    from studies.output.formats import csv_bytes
    from studies.sweeps.study import to_table

    table = to_table(data)
    if file_format == "csv":
        return f"# {json.dumps(table.attrs)}\n".encode() + csv_bytes(table)
    buffer = io.BytesIO()
    table.to_parquet(buffer, index=False, engine="pyarrow")
    return buffer.getvalue()
