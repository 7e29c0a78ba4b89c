"""Shipped catalogues and user-defined entries, and records that take values from an entry."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from types import MappingProxyType
from typing import Any, ClassVar, Literal, TypeVar

from missions.files.errors import InputError, did_you_mean, file_error, printable, shortened
from missions.files.texts import read_text
from missions.files.validation import validate, wrong_file
from missions.files.yaml import Document, parse_yaml
from sizing.catalogues.entries import (
    BatteryEntry,
    CellEntry,
    Entry,
    MotorEntry,
    MpptEntry,
    PropellerEntry,
)
from solar.schema import CompletedRecord, Record, spell, wrong_value

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
# Number of names in a message: of similar spelling, or with the requested text in name or label.
_ALIKE, _HAVING = 3, 10

E = TypeVar("E", bound=Entry)


def is_entry_path(name: str) -> bool:
    """Return whether a name is the path of a user-defined entry rather than a catalogue's name."""
    return name.lower().endswith(_SUFFIXES)


@cache
def documents(kind: Kind) -> Mapping[str, Document]:
    """Return the data of every shipped entry by its name."""
    file = resources.files("sizing").joinpath("data", "catalogues", f"{kind}.yaml")
    whole = parse_yaml(file.read_text(encoding="utf-8"), f"{kind}.yaml")
    return {name: Document(f"{kind}.yaml {name}", data) for name, data in whole.data.items()}


@cache
def _shipped(kind: Kind, name: str) -> Entry:
    return validate(documents(kind)[name], KINDS[kind])


def entries(kind: Kind) -> dict[str, Entry]:
    """Return the entries of a shipped catalogue by their names, in the order of its file."""
    return {name: _shipped(kind, name) for name in documents(kind)}


def entry(kind: Kind, name: str) -> Entry:
    """Return the entry of a name in the shipped catalogue, or of the path of a YAML file."""
    if is_entry_path(name):
        return validate(parse_yaml(read_text(name), printable(name)), KINDS[kind])
    known = documents(kind)
    if name in known:
        return _shipped(kind, name)
    # Names with this text in name or label, else names of similar spelling.
    part = _letters(name)
    having = [
        entry
        for entry, document in known.items()
        if len(part) > 1 and (part in _letters(entry) or part in _letters(document.data["label"]))
    ]
    meant = f"; did you mean {', '.join(having[:_HAVING])}?"
    meant = meant if having else did_you_mean(name.lower(), known, _ALIKE, cutoff=0.5)
    elsewhere = [other for other in KINDS if name in documents(other)]
    meant = f"; it is one of the {elsewhere[0]}" if elsewhere else meant
    shown = printable(shortened(name))
    raise file_error(
        "", f"the catalogue of {kind} has no {shown!r}{meant} (solar-uav list --{kind} has all)"
    )


def _letters(text: str) -> str:
    return "".join(filter(str.isalnum, text.lower()))


def _spelled(value: Any) -> str:
    return spell(value) if isinstance(value, float) else str(value)


@dataclass(frozen=True)
class CatalogueValue:
    """Value taken from a catalogue.

    ``key``: key in the aircraft's file. ``value``: in the key's unit; kind and numbers of a charge
    limit. ``entry``, ``label``: name of the entry or path of its file, and name of the product.
    ``source``: data sheet, paper or report.
    """

    key: str
    value: Any
    entry: str
    label: str
    source: str

    @property
    def text(self) -> str:
        """Value in words, as it may stand in the file."""
        if isinstance(self.value, Mapping):
            inside = (f"{key}: {_spelled(number)}" for key, number in self.value.items())
            return f"{{{', '.join(inside)}}}"
        return _spelled(self.value)


# Numbers of an entry from which a parameter follows; the first available has its source.
_FOLLOWS_FROM = {
    "specific_energy_wh_per_kg": ("mass_kg", "typical_mass_kg"),
    "charge_limit": ("maximum_charge_current_a",),
    "motor_efficiency": ("resistance_ohm",),
    "mppt_efficiency": ("efficiency",),
    "mppt_mass_kg_per_w": ("mass_kg",),
}


class CatalogueRecord(CompletedRecord):
    """Record with keys that name entries of catalogues, whose values it takes."""

    _entries: ClassVar[Mapping[str, Kind]]

    @classmethod
    def completed(cls, data: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return data with the values of the named entries."""
        new: dict[str, Any] = {}
        for key, kind in cls._entries.items():
            name = data.get(key)
            if isinstance(name, str | int) and not isinstance(name, bool):
                new |= entry_of_key(key, kind, str(name)).parameters(data)
        return new | dict(data)


def entry_of_key(key: str, kind: Kind, name: str) -> Entry:
    """Return the entry named by a key of a record; its mistakes become errors of validation."""
    try:
        return entry(kind, name)
    except InputError as error:
        if not is_entry_path(name):
            raise wrong_value(key, error.problems[0].message) from error
        raise wrong_file(key, error) from error


def known_entry(kind: Kind, data: Mapping[str, Any], key: str) -> Any:
    """Return the entry named in data; None without a name, or with an invalid one."""
    name = data.get(key)
    try:
        return entry(kind, name) if isinstance(name, str) else None
    except InputError:
        return None


def catalogue_values(record: CatalogueRecord, prefix: str) -> list[CatalogueValue]:
    """Return the values of a record taken from its entries, unless replaced since.

    ``prefix`` is that of the record's keys in the aircraft's file, with the dot.
    """
    fields = {field: getattr(record, field) for field in record.model_fields_set}
    values = []
    for key, kind in record._entries.items():
        name = getattr(record, key)
        if name is None:
            continue
        product = entry(kind, name)
        for field, value in product.parameters(fields).items():
            now = getattr(record, field)
            now = now.model_dump(exclude_unset=True) if isinstance(now, Record) else now
            if now == value and field not in fields:
                candidates = (field, *_FOLLOWS_FROM.get(field, ()))
                number = next((n for n in candidates if n in product.numbers()), field)
                source = product.source_of(number)
                values.append(CatalogueValue(prefix + field, value, name, product.label, source))
    return values


def user_entries(record: Record, key: str) -> dict[str, str]:
    """Return the text of a user-defined entry by its path; empty for shipped entries."""
    name = getattr(record, key)
    return {name: read_text(name)} if name is not None and is_entry_path(name) else {}
