"""Tables and figures as the bytes of a file."""

from __future__ import annotations

from pathlib import PurePath
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

IMAGE_FORMATS = ("png", "svg", "pdf")


def image_format(path: str) -> str | None:
    """Image format of a file name, none if it is not one that can be drawn."""
    suffix = PurePath(path).suffix.lstrip(".").lower()
    return suffix if suffix in IMAGE_FORMATS else None


def csv_bytes(table: pd.DataFrame) -> bytes:
    """Table as CSV without its index.

    Text that a spreadsheet would take for a formula gets a quote before it, as OWASP advises
    against CSV injection; numbers stay numbers.
    """
    from pandas.api.types import is_numeric_dtype

    safe = table.copy()
    for name in safe.columns[[not is_numeric_dtype(kind) for kind in safe.dtypes]]:
        safe[name] = safe[name].map(_no_formula)
    return str(safe.to_csv(index=False)).encode()


def _no_formula(value: object) -> object:
    text = isinstance(value, str) and value.startswith(("=", "+", "-", "@", "\t", "\r"))
    return f"'{value}" if text else value
