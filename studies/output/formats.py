"""Image formats that figures can be written in."""

from __future__ import annotations

from pathlib import PurePath

IMAGE_FORMATS = ("png", "svg", "pdf")


def image_format(path: str) -> str | None:
    """Image format of a file name, none if it is not one that can be drawn."""
    suffix = PurePath(path).suffix.lstrip(".").lower()
    return suffix if suffix in IMAGE_FORMATS else None
