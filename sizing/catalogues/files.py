"""Reading the shipped catalogues, and users' own entries."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from functools import cache
from importlib import resources
from types import MappingProxyType
from typing import Literal, TypeVar

from missions.files.errors import file_error, printable, shortened
from missions.files.texts import read_text
from missions.files.validation import validate
from missions.files.yaml import Document, parse_yaml
from sizing.catalogues.entries import BatteryEntry, CellEntry, Entry, MotorEntry, PropellerEntry

Kind = Literal["cells", "batteries", "motors", "propellers"]

KINDS: Mapping[Kind, type[Entry]] = MappingProxyType(
    {
        "cells": CellEntry,
        "batteries": BatteryEntry,
        "motors": MotorEntry,
        "propellers": PropellerEntry,
    }
)
_SUFFIXES = (".yaml", ".yml")
# Names that a message lists: spelled alike, or having what was asked for in their name or label.
_ALIKE, _HAVING = 3, 10

E = TypeVar("E", bound=Entry)


def is_entry_path(name: str) -> bool:
    """Whether a name is the path of a user's own entry and not a name of the catalogue."""
    return name.lower().endswith(_SUFFIXES)


@cache
def _documents(kind: Kind) -> Mapping[str, Document]:
    """Data of every shipped entry by its name."""
    file = resources.files("sizing").joinpath("data", "catalogues", f"{kind}.yaml")
    whole = parse_yaml(file.read_text(encoding="utf-8"), f"{kind}.yaml")
    return {name: Document(f"{kind}.yaml {name}", data) for name, data in whole.data.items()}


@cache
def _shipped(kind: Kind, name: str) -> Entry:
    return validate(_documents(kind)[name], KINDS[kind])


def entries(kind: Kind) -> dict[str, Entry]:
    """All entries of a shipped catalogue by their names, in the order of its file."""
    return {name: _shipped(kind, name) for name in _documents(kind)}


def entry_names(kind: Kind) -> list[str]:
    """Names of all entries of a shipped catalogue."""
    return list(_documents(kind))


def entry(kind: Kind, name: str) -> Entry:
    """Entry of the shipped catalogue, or a user's own by the path of its file.

    ``name``: name of an entry, or path of a YAML file.
    """
    if is_entry_path(name):
        return validate(parse_yaml(read_text(name), printable(name)), KINDS[kind])
    names = list(_documents(kind))
    if name in names:
        return _shipped(kind, name)
    meant = f"; did you mean {', '.join(_near(kind, name))}?" if _near(kind, name) else ""
    elsewhere = [other for other in KINDS if name in _documents(other)]
    meant = f"; it is one of the {elsewhere[0]}" if elsewhere else meant
    shown = printable(shortened(name))
    raise file_error(
        "", f"the catalogue of {kind} has no {shown!r}{meant} (solar-uav list --{kind} has all)"
    )


def _near(kind: Kind, name: str) -> list[str]:
    """Names that have this one in their name or label, such as a format; else those alike."""
    part = _letters(name)
    having = [
        entry
        for entry, document in _documents(kind).items()
        if len(part) > 1 and (part in _letters(entry) or part in _letters(document.data["label"]))
    ]
    alike = get_close_matches(name.lower(), _documents(kind), n=_ALIKE, cutoff=0.5)
    return having[:_HAVING] or alike


def _letters(text: str) -> str:
    return "".join(filter(str.isalnum, text.lower()))
