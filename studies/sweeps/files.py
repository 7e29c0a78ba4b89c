"""Trade studies as files: NetCDF, CSV, Parquet and Excel, the whole configuration inside each."""

from __future__ import annotations

from pathlib import PurePath
from typing import TYPE_CHECKING, Any

from missions.files.writing import to_json
from studies.output.formats import TABLE_FORMATS, csv_bytes, table_bytes, workbook_bytes

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

__all__ = ["FORMATS", "table_format", "to_bytes"]

FORMATS = ("nc", *TABLE_FORMATS)


def table_format(path: str) -> str | None:
    """Format of a file name, none if it is not one that can be written."""
    suffix = PurePath(path).suffix.lstrip(".").lower()
    return suffix if suffix in FORMATS else None


def to_bytes(data: xr.Dataset, file_format: str) -> bytes:
    """Content of a file.

    A CSV file has the configuration as JSON in its first line, behind ``#``; a Parquet file in the
    table's attributes; a workbook in a sheet of its own.
    """
    if file_format == "nc":
        from studies.output.gridded import to_netcdf_bytes

        return to_netcdf_bytes(data)
    from studies.sweeps.study import to_table

    table = to_table(data)
    if file_format == "csv":
        return f"# {to_json(table.attrs)}\n".encode() + csv_bytes(table)
    if file_format == "xlsx":
        return workbook_bytes({"points": table, "configuration": _configuration(table.attrs)})
    return table_bytes(table, f"table.{file_format}")


def _configuration(attrs: dict[Any, Any]) -> pd.DataFrame:
    """Whole configuration as keys and values."""
    import pandas as pd

    texts = [value if isinstance(value, str) else to_json(value) for value in attrs.values()]
    return pd.DataFrame({"key": [str(key) for key in attrs], "value": texts})
