"""Values given on the command line as ``dotted.key=value``, put into a document."""

from __future__ import annotations

import copy
import dataclasses
import re
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias, TypeVar

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
from missions.files.yaml import Document, Marks, plain_data
from missions.files.yaml_nodes import NOT_YAML, compose

__all__ = ["Overrides", "with_overrides"]

T = TypeVar("T")

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
