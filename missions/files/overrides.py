"""Values that replace others: on the command line ``dotted.key=value``, in Python by dotted key."""

from __future__ import annotations

import copy
import dataclasses
import typing
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

from pydantic import BaseModel

from missions.files.errors import (
    OVERRIDE,
    InputError,
    KeyPath,
    Problem,
    dotted,
    file_error,
    printable,
    shortened,
    shown,
)
from missions.files.validation import validate
from missions.files.yaml import ENTRY_KEYS, Document, Place, parse_value, set_absolute_paths

R = TypeVar("R", bound=BaseModel)

# By dotted key, or texts ``dotted.key=value`` whose values follow the rules of the files.
Overrides: TypeAlias = Mapping[str, Any] | Sequence[str]


def with_overrides(document: Document, overrides: Overrides, *, prefix: str = "") -> Document:
    """Return a new document with values replaced or added.

    Files that a value names by a relative path are looked for in the working folder. An entry of a
    catalogue that an override names replaces what the file says itself of the keys that such an
    entry may give; what another override says of them stays.

    ``overrides``: values by their dotted key, or texts ``dotted.key=value``, applied in order. The
    value in a text follows the rules of the files (a scalar, or a list or mapping in brackets);
    items of lists are named by their index from 0. ``prefix``: what the user wrote before each key,
    for the problems that name it. Returns with the data changed, and its places without those of
    what was replaced.
    """
    result = dataclasses.replace(document, data=copy.deepcopy(document.data))
    problems: list[Problem] = []
    if isinstance(overrides, str | bytes) or not isinstance(overrides, Iterable):
        raise TypeError(f"overrides are a mapping or a list of texts (got {overrides!r})")
    values = overrides if isinstance(overrides, Mapping) else None
    overrides = list(overrides)
    for override in overrides:
        if not isinstance(override, str):
            raise TypeError(
                f"overrides are texts, such as 'a.b=2.5', or have such keys (got {override!r})"
            )
    keys = {override.partition("=")[0].strip() for override in overrides}
    for override in overrides:
        key, equals, text = override.partition("=") if values is None else (override, "=", "")
        parts = key.strip().split(".")
        named = bool(equals) and all(part.strip() for part in parts)
        name = prefix + (dotted(parts) if named else shortened(printable(override.strip())))
        try:
            if not named:
                raise file_error(name, "write an override as KEY=VALUE, for example a.b=2.5")
            if not key.isprintable():
                raise file_error(name, "the key holds a character that is not allowed")
            value = parse_value(text) if values is None else copy.deepcopy(values[override])
            around = {parts[-1]: value}
            set_absolute_paths(around, Path.cwd())
            path, made = _set_value(result.data, parts, around[parts[-1]])
            others = {p: place for p, place in result.places.items() if p[: len(path)] != path}
            named_places = dict.fromkeys([*made, path], Place(override=name))
            result = dataclasses.replace(result, places=others | named_places)
            _drop_replaced(result.data, parts, value, keep=keys)
        except InputError as error:
            message = "; ".join(problem.message for problem in error.problems)
            problems.append(Problem(OVERRIDE + name, None, None, name, message))
    if problems:
        raise InputError(problems)
    return result


def _drop_replaced(data: Any, parts: Sequence[str], value: Any, *, keep: Collection[str]) -> None:
    """Drop keys that a catalogue's entry replaces, in place, except those to keep."""
    if value is None or isinstance(value, dict | list) or parts[-1] not in ENTRY_KEYS:
        return
    holder = data
    for part in parts[:-1]:
        holder = holder.get(part) if isinstance(holder, dict) else None
    if not isinstance(holder, dict):
        return
    for key in ENTRY_KEYS[parts[-1]]:
        dotted_key = ".".join([*parts[:-1], key])
        if not any(kept == dotted_key or kept.startswith(f"{dotted_key}.") for kept in keep):
            holder.pop(key, None)


def with_values(record: R, values: Mapping[str, Any]) -> R:
    """Return a checked copy of a record with some values replaced.

    Unlike ``model_copy``, which takes whatever it is given, every validator of the record and of
    the records inside it that change is run.

    Parameters
    ----------
    record : Record
        Aircraft, mission or a part of one; it is not changed.
    values : mapping
        New values by their dotted key as in a file, ``{"payload.mass_kg": 0.5}``: records, or
        plain data. Items of tuples are named by their index from 0.

    Returns
    -------
    Record
        Of the same class.

    Raises
    ------
    InputError
        If a key is unknown or the record would not be valid; its source is the record's class.
    """
    source = type(record).__name__
    data = _as_data(record)
    problems: list[Problem] = []
    for key, value in values.items():
        try:
            _set_value(data, key.split("."), value)
            _drop_replaced(data, key.split("."), value, keep=values)
        except InputError as error:
            problems.extend(Problem(source, None, None, key, p.message) for p in error.problems)
    if problems:
        raise InputError(problems)
    return validate(Document(source, data), type(record))


def _set_value(holder: Any, parts: Sequence[str], value: Any) -> tuple[KeyPath, list[KeyPath]]:
    """Put a value into nested data; return its path and the paths of mappings made to hold it."""
    path: KeyPath = ()
    made: list[KeyPath] = []
    for part in parts[:-1]:
        key = _key_or_index(holder, path, part)
        path = (*path, key)
        inner = holder.get(key) if isinstance(holder, dict) else holder[key]
        if inner is None:
            made.append(path)
        if isinstance(inner, BaseModel):
            inner = _as_data(inner)
        new = {} if inner is None else list(inner) if isinstance(inner, tuple) else copy.copy(inner)
        holder[key] = new
        holder = new
    key = _key_or_index(holder, path, parts[-1])
    holder[key] = value
    return (*path, key), made


def _as_data(record: BaseModel) -> dict[str, Any]:
    """Return the keys of a record as in a file; the records inside it stay records."""
    return {
        info.alias or name: getattr(record, name)
        for name, info in type(record).model_fields.items()
        # Only what was given in a file, and what tells one kind of record from another.
        if not info.exclude
        and (
            name in record.model_fields_set or typing.get_origin(info.annotation) is typing.Literal
        )
    }


def _key_or_index(holder: Any, path: KeyPath, part: str) -> str | int:
    """Return the key or index that a part of a dotted key stands for."""
    if isinstance(holder, dict):
        return part
    if not isinstance(holder, list):
        message = f"{dotted(path)} is the single value {shown(holder)} and has no keys"
    elif part.isascii() and part.isdecimal() and len(part) < 7 and int(part) < len(holder):
        return int(part)
    else:
        allowed = f"an index from 0 to {len(holder) - 1}" if holder else "no index: it is empty"
        message = f"{dotted(path)} is a list and takes {allowed} (got {shown(part)})"
    raise file_error("", message)
