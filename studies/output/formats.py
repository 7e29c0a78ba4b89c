"""Tables and figures as the bytes of a file."""

from __future__ import annotations

import importlib.util
import io
from collections.abc import Mapping, Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

IMAGE_FORMATS = ("png", "svg", "pdf")
TABLE_FORMATS = ("csv", "parquet", "xlsx")
GRID_FORMATS = ("nc", *TABLE_FORMATS)
PLAIN_TABLE = "csv"  # of a table whose file has no ending
# Libraries that are not installed with the package, and the extra that brings each.
_WRITERS = {"parquet": ("Parquet", "pyarrow", "parquet"), "xlsx": ("Excel", "xlsxwriter", "excel")}
# Excel's own limits: rows of a sheet, and characters of its name and those that it may not have.
_MOST_ROWS = 1_048_575
_LONGEST_SHEET, _NOT_IN_SHEETS = 31, "[]:*?/\\"


def format_of(path: str, allowed: Sequence[str], without_ending: str = "") -> str | None:
    """Return the format that a file name asks for; None if it is none of those allowed.

    ``without_ending``: that of a name without an ending, such as ``/dev/stdout``.
    """
    ending = PurePath(path).suffix.lstrip(".").lower() or without_ending
    return ending if ending in allowed else None


def wrong_ending(path: str, allowed: Sequence[str]) -> str:
    """Return what is wrong with the name of a file in none of the formats allowed."""
    return f"{path!r} must end in {', '.join(f'.{name}' for name in allowed)}"


def missing_writer(file_format: str | None) -> str | None:
    """Return what to install for a format; None where nothing is missing."""
    if file_format not in _WRITERS:
        return None
    name, library, extra = _WRITERS[file_format]
    if importlib.util.find_spec(library) is not None:
        return None
    return f"{name} needs {library}: pip install {library} (the extra '{extra}')"


def table_bytes(table: pd.DataFrame, path: str, *, title: str = "table") -> bytes:
    """Return a table in the format that the name of its file requests."""
    file_format = format_of(path, TABLE_FORMATS, PLAIN_TABLE)
    if file_format == "xlsx":
        return workbook_bytes({title: table})
    if file_format != "parquet":
        return csv_bytes(table)
    buffer = io.BytesIO()
    table.to_parquet(buffer, index=False, engine="pyarrow")
    return buffer.getvalue()


def workbook_bytes(tables: Mapping[str, pd.DataFrame]) -> bytes:
    """Return tables as the sheets of an Excel workbook; text stays text."""
    import pandas as pd

    from missions.files.writing import OutputError  # help texts import this module alone

    for name, table in tables.items():
        if len(table) > _MOST_ROWS:
            message = f"{name}: {len(table)} rows; a sheet of Excel holds {_MOST_ROWS}: write CSV"
            raise OutputError(message)
    buffer = io.BytesIO()
    plain = {"strings_to_formulas": False, "strings_to_urls": False, "in_memory": True}
    with pd.ExcelWriter(buffer, engine="xlsxwriter", engine_kwargs={"options": plain}) as writer:
        for name, table in tables.items():
            sheet = "".join(c for c in name if c not in _NOT_IN_SHEETS)[:_LONGEST_SHEET] or "table"
            table.to_excel(writer, sheet_name=sheet, index=False, inf_rep="unlimited")
            writer.sheets[sheet].freeze_panes(1, 0)
            writer.sheets[sheet].autofit()
    return buffer.getvalue()


def csv_bytes(table: pd.DataFrame) -> bytes:
    """Return a table as CSV without its index.

    Text that a spreadsheet would take for a formula gets a quote before it, as OWASP advises
    against CSV injection; numbers stay numbers.
    """
    formula = ("=", "+", "-", "@", "\t", "\r")
    safe = table.copy()
    for name in safe.select_dtypes(exclude=["number", "bool"]).columns:
        safe[name] = [
            f"'{value}" if isinstance(value, str) and value.startswith(formula) else value
            for value in safe[name]
        ]
    return str(safe.to_csv(index=False)).encode()
