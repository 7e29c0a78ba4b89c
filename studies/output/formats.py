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
    """Table as CSV without its index."""
    return str(table.to_csv(index=False)).encode()
