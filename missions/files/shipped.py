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

# Packages whose folder ``library`` holds the files, and the ends of their names.
_FILES: dict[Kind | Literal["record"], tuple[str, str]] = {
    "aircraft": ("sizing", ".yaml"),
    "mission": ("missions", ".yaml"),
    "record": ("missions", ".csv.gz"),
}


def shipped_names(kind: Kind | Literal["record"]) -> list[str]:
    """Return the names of the shipped aircraft, missions or weather records, sorted."""
    package, end = _FILES[kind]
    names = (file.name for file in resources.files(package).joinpath("library").iterdir())
    return sorted(name.removesuffix(end) for name in names if name.endswith(end))


def shipped_file(kind: Kind | Literal["record"], name: str) -> Traversable:
    """Return a shipped file."""
    package, end = _FILES[kind]
    return resources.files(package).joinpath("library", f"{name}{end}")


def record_description(name: str) -> str:
    """Return the description in the head of a shipped weather record."""
    described = (line.partition("# description:") for line in shipped_text(name).split("\n", 20))
    return next((words.strip() for before, key, words in described if key and not before), "")


def find_document(kind: Kind, name_or_path: str) -> Document:
    """Read an aircraft or mission by path or shipped name; a file precedes a shipped name."""
    name = name_or_path
    if not name.strip() or not name.isprintable() or len(name) > 1000:
        shown = ascii(name if len(name) <= 40 else name[:40] + "...")
        raise file_error(kind, f"is neither the name nor the file of one (got {shown})")
    names = shipped_names(kind)
    if name in names and not Path(name).is_file():
        text = shipped_file(kind, name).read_text(encoding="utf-8")
        return parse_yaml(text, f"{name} (shipped)")
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
    shipped = {name: kind for kind in _FILES for name in shipped_names(kind)}
    if name not in shipped:
        message = "no shipped aircraft, mission or weather record of that name"
        raise file_error(name, f"{message} (shipped: {', '.join(shipped)})")
    content = shipped_file(shipped[name], name).read_bytes()
    content = gzip.decompress(content) if shipped[name] == "record" else content
    return content.decode("utf-8").replace("\r\n", "\n")
