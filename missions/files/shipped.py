"""Aircraft, missions and weather records by the name of a shipped file or by a path."""

from __future__ import annotations

import gzip
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Literal

from missions.files.errors import did_you_mean, file_error
from missions.files.yaml import Document, parse_yaml, read_yaml

Kind = Literal["aircraft", "mission"]

# Packages whose folder ``library`` holds the files.
_PACKAGES: dict[Kind, str] = {"aircraft": "sizing", "mission": "missions"}
_RECORD = ".csv.gz"


def shipped_names(kind: Kind) -> list[str]:
    """Return the names of the shipped aircraft or missions, sorted."""
    folder = resources.files(_PACKAGES[kind]).joinpath("library")
    return sorted(
        f.name.removesuffix(".yaml") for f in folder.iterdir() if f.name.endswith(".yaml")
    )


def shipped_records() -> list[str]:
    """Return the names of the shipped weather records, sorted."""
    folder = resources.files("missions").joinpath("library")
    return sorted(f.name.removesuffix(_RECORD) for f in folder.iterdir() if _RECORD in f.name)


def shipped_record(name: str) -> Traversable:
    """Return the file of a shipped weather record."""
    return resources.files("missions").joinpath("library", f"{name}{_RECORD}")


def record_description(name: str) -> str:
    """Return the description in the head of a shipped weather record."""
    key = "# description:"
    with shipped_record(name).open("rb") as file, gzip.open(file, "rt", encoding="utf-8") as text:
        head = (line for _, line in zip(range(20), text, strict=False))
        return next((line.removeprefix(key).strip() for line in head if line.startswith(key)), "")


def find_document(kind: Kind, name_or_path: str) -> Document:
    """Read an aircraft or mission by path or shipped name; a file precedes a shipped name."""
    name = name_or_path
    if not name.strip() or not name.isprintable() or len(name) > 1000:
        shown = ascii(name if len(name) <= 40 else name[:40] + "...")
        raise file_error(kind, f"is neither the name nor the file of one (got {shown})")
    names = shipped_names(kind)
    if name in names and not Path(name).is_file():
        return parse_yaml(_text(kind, name), f"{name} (shipped)")
    if Path(name).exists():
        return read_yaml(name)
    other: Kind = "mission" if kind == "aircraft" else "aircraft"
    local = [path.name for path in Path().glob("*.y*ml")] if Path(name).parent == Path() else []
    hint = did_you_mean(name, [*local, *names])
    if name in shipped_names(other):
        hint = f": {name!r} is one of the {other if other == 'aircraft' else 'missions'}"
    message = f"there is no such file and no shipped {kind} of that name{hint}"
    raise file_error(name, f"{message} (shipped: {', '.join(names)})")


def shipped_text(name: str) -> str:
    """Return the text of a shipped aircraft's or mission's file, or of a weather record."""
    shipped: dict[str, Kind] = {name: kind for kind in _PACKAGES for name in shipped_names(kind)}
    records = shipped_records()
    if name in records:
        return gzip.decompress(shipped_record(name).read_bytes()).decode("utf-8")
    if name not in shipped:
        message = "no shipped aircraft, mission or weather record of that name"
        raise file_error(name, f"{message} (shipped: {', '.join([*shipped, *records])})")
    return _text(shipped[name], name)


def _text(kind: Kind, name: str) -> str:
    source = resources.files(_PACKAGES[kind]).joinpath("library", f"{name}.yaml")
    return source.read_text(encoding="utf-8")
