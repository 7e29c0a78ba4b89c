"""Values that replace others: on the command line ``dotted.key=value``, in Python by dotted key."""

from __future__ import annotations

import copy
import dataclasses
import re
import typing
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias, TypeVar

from pydantic import BaseModel

from missions.files.errors import (
    OVERRIDE,
    InputError,
    KeyPath,
    Problem,
    dotted,
    printable,
    shortened,
    shown,
)
from missions.files.validation import validate
from missions.files.yaml import Document, Marks, plain_data
from missions.files.yaml_nodes import NOT_YAML, compose

__all__ = ["Overrides", "with_overrides", "with_values"]

T = TypeVar("T")
R = TypeVar("R", bound=BaseModel)

# By dotted key, or texts ``dotted.key=value`` whose values follow the rules of the files.
Overrides: TypeAlias = Mapping[str, Any] | Sequence[str]


def with_overrides(document: Document, overrides: Overrides, *, prefix: str = "") -> Document:
    """Return a new document with values replaced or added.

    Parameters
    ----------
    document : Document
        The document; it is not changed.
    overrides : mapping or sequence of str
        Values by their dotted key, or texts ``dotted.key=value``, applied in order. The value in a
        text follows the rules of the files (a scalar, or a list or mapping in brackets); items of
        lists are named by their index from 0.
    prefix : str
        What the user wrote before each key, for the problems that name it.

    Raises
    ------
    InputError
        If an override is not readable or leads through a value that has no keys.
    """
    result = dataclasses.replace(document, data=copy.deepcopy(document.data))
    problems: list[Problem] = []
    given = overrides.items() if isinstance(overrides, Mapping) else map(_parsed, overrides)
    for key, value in given:
        try:
            result = _with_override(result, key, value, prefix)
        except InputError as error:
            problems.extend(error.problems)
    if problems:
        raise InputError(problems)
    return result


@dataclasses.dataclass(frozen=True)
class _Text:
    """Value of an override as it was written; None where there was no equals sign."""

    text: str | None


def _parsed(override: str) -> tuple[str, _Text]:
    key, equals, value = override.partition("=")
    return (key, _Text(value)) if equals else (override, _Text(None))


def _with_override(document: Document, key: str, given: Any, prefix: str) -> Document:
    """Put one value into the data, in place, and return the document with its new places."""
    key = key.strip()
    parts = key.split(".")
    name = prefix + dotted(parts)
    if given == _Text(None) or not all(part.strip() for part in parts):
        text = f"{key}={given.text}" if isinstance(given, _Text) and given.text else key
        name = prefix + shortened(printable(text))
        raise _error(name, "write an override as KEY=VALUE, for example a.b=2.5")
    if NOT_YAML.search(key):
        raise _error(name, "the key holds a character that is not allowed")
    value = _value(name, given.text or "") if isinstance(given, _Text) else copy.deepcopy(given)
    path, made = _set(document.data, parts, value, name)
    marks = Marks(_without(document.marks.keys, path), _without(document.marks.values, path))
    overridden = _without(document.overridden, path) | dict.fromkeys([*made, path], name)
    return dataclasses.replace(document, marks=marks, overridden=overridden)


def _without(places: Mapping[KeyPath, T], path: KeyPath) -> dict[KeyPath, T]:
    return {key: value for key, value in places.items() if key[: len(path)] != path}


def _error(name: str, message: str) -> InputError:
    return InputError([Problem(OVERRIDE + name, None, None, name, message)])


def _value(name: str, text: str) -> Any:
    try:
        node = compose(text.strip(), "")
    except InputError as error:
        message = "; ".join(problem.message for problem in error.problems)
        raise _error(name, f"the value {message}") from error
    if node is None or node.empty:
        raise _error(name, "no value after the = sign (write null for no value)")
    if node.block:
        raise _error(
            name, "write one value, or a list in brackets such as [1, 2]; quote text with colons"
        )
    return plain_data(node)[0]


def _set(holder: Any, parts: Sequence[str], value: Any, name: str) -> tuple[KeyPath, list[KeyPath]]:
    """Put the value into nested data.

    Return its path and the paths of the mappings made only to hold it.
    """
    path: KeyPath = ()
    made: list[KeyPath] = []
    for part in parts[:-1]:
        key = _step(holder, path, part, name)
        path = (*path, key)
        if isinstance(holder, dict) and holder.get(part) is None:
            holder[part] = {}
            made.append(path)
        holder = holder[key]
    key = _step(holder, path, parts[-1], name)
    holder[key] = value
    return (*path, key), made


def _step(holder: Any, path: KeyPath, part: str, name: str) -> str | int:
    """Return the key or index that `part` means in `holder`."""
    if isinstance(holder, dict):
        return part
    if not isinstance(holder, list):
        raise _error(name, f"{dotted(path)} is the single value {shown(holder)} and has no keys")
    if re.fullmatch(r"[0-9]{1,6}", part) and int(part) < len(holder):
        return int(part)
    allowed = f"an index from 0 to {len(holder) - 1}" if holder else "no index: it is empty"
    raise _error(name, f"{dotted(path)} is a list and takes {allowed} (got {shown(part)})")


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
            _put(data, key.split("."), value)
        except (KeyError, ValueError, IndexError, TypeError):
            problems.append(Problem(source, None, None, key, "leads to no value of this record"))
    if problems:
        raise InputError(problems)
    return validate(Document(source, data), type(record))


def _as_data(record: BaseModel) -> dict[str, Any]:
    """Return the keys of a record as in a file; the records inside it stay records."""
    return {
        info.alias or name: getattr(record, name)
        for name, info in type(record).model_fields.items()
        # Only what was given, and what tells one kind of record from another.
        if name in record.model_fields_set or typing.get_origin(info.annotation) is typing.Literal
    }


def _put(holder: Any, parts: Sequence[str], value: Any) -> None:
    """Replace one value, opening the records on the way to it."""
    first, *rest = parts
    key = int(first) if isinstance(holder, list) else first
    if rest:
        inner = holder.get(key) if isinstance(holder, dict) else holder[key]
        holder[key] = inner = _opened(inner)
        _put(inner, rest, value)
    else:
        holder[key] = value


def _opened(value: Any) -> dict[str, Any] | list[Any]:
    if value is None:
        return {}
    if isinstance(value, BaseModel):
        return _as_data(value)
    if isinstance(value, dict | list | tuple):
        return dict(value) if isinstance(value, dict) else list(value)
    raise TypeError
