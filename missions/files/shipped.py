"""Finding an aircraft or a mission by the name of a shipped file or by a path."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from importlib import resources
from pathlib import Path
from typing import Literal

from missions.files.errors import InputError, Problem
from missions.files.yaml import Document, parse_yaml, read_yaml

Kind = Literal["aircraft", "mission"]

# Packages whose folder ``library`` holds the files.
_PACKAGES: dict[Kind, str] = {"aircraft": "sizing", "mission": "missions"}


def shipped_names(kind: Kind) -> list[str]:
    """Names of the shipped aircraft or missions, sorted."""
    folder = resources.files(_PACKAGES[kind]).joinpath("library")
    return sorted(
        f.name.removesuffix(".yaml") for f in folder.iterdir() if f.name.endswith(".yaml")
    )


def find_document(kind: Kind, name_or_path: str) -> Document:
    """Read an aircraft or mission by path, or by the name of a shipped one.

    Raises
    ------
    InputError
        If there is neither such a file nor a shipped one of that name.
    """
    if not name_or_path.strip() or not name_or_path.isprintable() or len(name_or_path) > 1000:
        raise InputError([_not_a_name(kind, name_or_path)])
    names = shipped_names(kind)
    if name_or_path in names and not Path(name_or_path).is_file():
        return parse_yaml(_text(kind, name_or_path), f"{name_or_path} (shipped)")
    if not Path(name_or_path).exists():
        raise InputError([_unknown(kind, name_or_path, names)])
    return read_yaml(name_or_path)


def shipped_text(name: str) -> str:
    """Text of a shipped aircraft's or mission's file.

    Raises
    ------
    InputError
        If none of that name is shipped.
    """
    for kind in _PACKAGES:
        if name in shipped_names(kind):
            return _text(kind, name)
    shipped = ", ".join(name for kind in _PACKAGES for name in shipped_names(kind))
    message = f"no shipped aircraft or mission of that name (shipped: {shipped})"
    raise InputError([Problem(source=name, line=None, column=None, key="", message=message)])


def document_kind(document: Document) -> Kind:
    """Whether a document describes an aircraft or a mission, judged by its keys."""
    keys = set(document.data)
    aircraft = len(keys & {"airframe", "battery", "modules", "power", "design_space"})
    mission = len(keys & {"latitude_deg", "dates", "altitude_m", "air", "payload", "launch"})
    return "aircraft" if aircraft >= mission else "mission"


def _text(kind: Kind, name: str) -> str:
    source = resources.files(_PACKAGES[kind]).joinpath("library", f"{name}.yaml")
    return source.read_text(encoding="utf-8")


def _not_a_name(kind: Kind, name: str) -> Problem:
    shown = ascii(name if len(name) <= 40 else name[:40] + "...")
    message = f"is neither the name nor the file of one (got {shown})"
    return Problem(source=kind, line=None, column=None, key="", message=message)


def _unknown(kind: Kind, name: str, names: Sequence[str]) -> Problem:
    other: Kind = "mission" if kind == "aircraft" else "aircraft"
    close = get_close_matches(name, names, n=1)
    hint = f"; did you mean {close[0]!r}?" if close else ""
    if name in shipped_names(other):
        hint = f": {name!r} is one of the {other if other == 'aircraft' else 'missions'}"
    message = (
        f"there is no such file and no shipped {kind} of that name{hint} "
        f"(shipped: {', '.join(names)})"
    )
    return Problem(source=name, line=None, column=None, key="", message=message)
