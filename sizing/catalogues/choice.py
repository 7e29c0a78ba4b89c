"""The shipped catalogues and users' own entries; records that name an entry take values from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from importlib import resources
from types import MappingProxyType
from typing import Any, ClassVar, Literal, Self, TypeVar

from pydantic import ModelWrapValidatorHandler, model_validator

from missions.files.errors import InputError, file_error, printable, shortened
from missions.files.texts import read_text
from missions.files.validation import validate
from missions.files.yaml import ENTRY_KEYS, Document, parse_yaml
from sizing.catalogues.entries import (
    BatteryEntry,
    CellEntry,
    Entry,
    MotorEntry,
    MpptEntry,
    PropellerEntry,
)
from solar.schema import Record, wrong_value

Kind = Literal["cells", "batteries", "motors", "propellers", "mppts"]

KINDS: Mapping[Kind, type[Entry]] = MappingProxyType(
    {
        "cells": CellEntry,
        "batteries": BatteryEntry,
        "motors": MotorEntry,
        "propellers": PropellerEntry,
        "mppts": MpptEntry,
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


@dataclass(frozen=True)
class Taken:
    """A value that a catalogue gave.

    ``key``: in the aircraft's file. ``value``: in the key's unit; the kind and the numbers of a
    charge limit. ``entry``, ``label``: name of the entry, or path of its file, and the product in
    words. ``source``: data sheet, paper or report.
    """

    key: str
    value: Any
    entry: str
    label: str
    source: str

    @property
    def text(self) -> str:
        """Value as people read it, and as it may stand in the file."""
        if isinstance(self.value, Mapping):
            inside = (f"{key}: {_spelled(one)}" for key, one in self.value.items())
            return f"{{{', '.join(inside)}}}"
        return _spelled(self.value)


def _spelled(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


# Numbers of an entry that a parameter follows from, the first that it has, where it is none of them
# itself.
_FOLLOWS_FROM = {
    "specific_energy_wh_per_kg": ("mass_kg", "typical_mass_kg"),
    "charge_limit": ("maximum_charge_current_a",),
    "motor_efficiency": ("resistance_ohm",),
    "mppt_efficiency": ("efficiency",),
    "mppt_mass_kg_per_w": ("mass_kg",),
}


class OfCatalogue(Record):
    """Record with keys that name entries of catalogues."""

    _entries: ClassVar[Mapping[str, Kind]]

    @model_validator(mode="wrap")
    @classmethod
    def _from_catalogue(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Validate the data of a record, with what the entry gives that it names.

        What the data have wins. What the entry gave does not count as given: a copy of the record
        with another entry takes the values of that one.
        """
        new: dict[str, Any] = {}
        for key, kind in cls._entries.items():
            name = data.get(key) if isinstance(data, Mapping) else None
            if isinstance(name, str | int) and not isinstance(name, bool):
                parameters = found_entry(key, kind, str(name)).parameters(data)
                new |= {one: value for one, value in parameters.items() if one not in data}
        if not new:
            return handler(data)
        record = handler({**data, **new})
        record.__pydantic_fields_set__.difference_update(new)
        return record


def found_entry(key: str, kind: Kind, name: str) -> Entry:
    """Entry that a key of a record names; what is wrong with it becomes an error of validation."""
    try:
        return entry(kind, name)
    except InputError as error:
        if not is_entry_path(name):
            raise wrong_value(key, error.problems[0].message) from error
        # Places in that file; the validation of the aircraft's puts them in.
        count = len(error.problems)
        why = f"that file has {'a mistake' if count == 1 else f'{count} mistakes'}"
        raise wrong_value(key, why, problems=error.problems) from error
    except OSError as error:
        raise wrong_value(key, f"cannot read {name!r}: {error.strerror}") from error


def known_entry(kind: Kind, data: Mapping[str, Any], key: str) -> Any:
    """Entry that data name; None without a name, or with one that the validation refuses."""
    name = data.get(key)
    try:
        return entry(kind, name) if isinstance(name, str) else None
    except (InputError, OSError):
        return None


def taken(record: OfCatalogue, prefix: str) -> list[Taken]:
    """Values of a record that are those of the entries it names.

    ``prefix``: what stands before the record's keys in the aircraft's file, with the dot. Returns
    without those that something else has replaced since.
    """
    given = {field: getattr(record, field) for field in record.model_fields_set}
    found = []
    for key, kind in record._entries.items():
        name = getattr(record, key)
        if name is None:
            continue
        one = entry(kind, name)
        for field, value in one.parameters(given).items():
            now = getattr(record, field)
            now = now.model_dump(exclude_unset=True) if isinstance(now, Record) else now
            if now == value and field not in given:
                candidates = (field, *_FOLLOWS_FROM.get(field, ()))
                number = next((key_of for key_of in candidates if key_of in one.numbers()), field)
                found.append(Taken(prefix + field, value, name, one.label, one.source_of(number)))
    return found


def named_twice(data: Any, key: str, kind: Kind) -> dict[str, str]:
    """Keys of a record's data that the entry it names gives as well, with the mistake of each."""
    data = data if isinstance(data, Mapping) else {}
    known = known_entry(kind, data, key)
    # A motor at its operating point needs no voltage of its own, which an efficiency would.
    beside = any(one in data for one in ENTRY_KEYS[key])
    given = known.parameters(data) if known is not None and beside else {}
    return {
        one: f"give one of {key} and {one}: {printable(shortened(data[key]))} of the catalogue has "
        "a value of its own for it"
        for one in given
        if one in data
    }


def own_entries(record: Record, key: str) -> dict[str, str]:
    """Text of a user's own entry by its path, if the record names one.

    Empty for an entry of the shipped catalogue.
    """
    name = getattr(record, key)
    return {name: read_text(name)} if name is not None and is_entry_path(name) else {}
