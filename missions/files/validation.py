"""Check of aircraft and mission files against their models, with the line of every mistake.

A file is read in three steps: the text is parsed into plain data and the place of each key
(`missions.files.yaml`), values given on the command line replace or add keys
(`missions.files.overrides`), and a pydantic model checks the result (`validate`). Every mistake of
the user ends as an `InputError`, whose problems name file, line and column.
"""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from missions.files.errors import OVERRIDE, InputError, KeyPath, Problem, dotted, shown
from missions.files.field_types import Place, follow, value_at
from missions.files.messages import one_line, unknown_key, worded
from missions.files.yaml import Document

__all__ = ["located_error", "validate"]

M = TypeVar("M", bound=BaseModel)


def validate(document: Document, model: type[M]) -> M:
    """Return the content of a document as described by a model.

    Raises
    ------
    InputError
        With every problem of the document, each at its place.
    """
    try:
        return model.model_validate(document.data)
    except ValidationError as error:
        details = error.errors(include_url=False)
    complaints = _merged([_complaint(document.data, model, detail) for detail in details])
    raise InputError(
        _located(document, one.path, one.message + one.suffix, at_key=one.at_key)
        for one in complaints
    )


def located_error(document: Document, path: Sequence[str | int], message: str) -> InputError:
    """Return an error, to be raised by the caller, that points at a key of a document.

    Parameters
    ----------
    document : Document
        Data and places.
    path : sequence of str and int
        Keys and list indices from the top level; what does not exist is located at the
        nearest mapping around it.
    message : str
        What is wrong with the value.
    """
    return InputError([_located(document, tuple(path), message)])


def _located(document: Document, path: KeyPath, message: str, *, at_key: bool = False) -> Problem:
    """Return a problem at the longest part of the path that has a place."""
    key = dotted(path)
    for end in range(len(path), -1, -1):
        prefix = path[:end]
        if prefix in document.overridden:
            return Problem(OVERRIDE + document.overridden[prefix], None, None, key, message)
        # A block mapping starts on the line below its key; its key says better what is meant.
        whole = at_key or isinstance(value_at(document.data, prefix), dict | list)
        keys, values = document.marks.keys.get(prefix), document.marks.values.get(prefix)
        if mark := (keys or values) if whole else (values or keys):
            return Problem(document.source, *mark, key, message)
    return Problem(document.source, None, None, key, message)


@dataclass(frozen=True)
class _Complaint:
    """One pydantic error in terms of the file.

    Choices of a union each complain about the same value; firm complaints, which tell of the
    content of the value and not of its type, are never joined to others.
    """

    path: KeyPath
    message: str
    suffix: str = ""
    in_union: bool = False
    firm: bool = False
    at_key: bool = False


def _merged(complaints: Iterable[_Complaint]) -> list[_Complaint]:
    """Join what the choices of a union say about the same value."""
    of_unions = [one for one in complaints if one.in_union]
    # The choice that found fault with the content of a value is the one that was meant.
    read = {one.path[:end] for one in of_unions for end in range(len(one.path))}
    read |= {one.path for one in of_unions if one.firm}
    result: dict[tuple[KeyPath, str], _Complaint] = {}
    for one in complaints:
        if one.firm or not one.in_union:
            result.setdefault((one.path, one.message), one)
        elif one.path not in read:
            key = (one.path, "")
            result[key] = _joined(result[key], one) if key in result else one
    return list(result.values())


def _joined(first: _Complaint, other: _Complaint) -> _Complaint:
    if other.message in first.message.split(", or "):
        return first
    suffix = max(first.suffix, other.suffix, key=len)
    message = f"{first.message}, or {other.message}"
    return dataclasses.replace(first, message=message, suffix=suffix)


def _complaint(data: Any, model: type[BaseModel], detail: ErrorDetails) -> _Complaint:
    loc = detail["loc"]
    place = follow(data, model, loc)
    kind = detail["type"]
    context = detail.get("ctx", {})
    if kind == "extra_forbidden":
        around = follow(data, model, loc[:-1])
        message = unknown_key(str(loc[-1]), list(around.keys()))
        path = (*around.path, loc[-1])
        return _Complaint(path, message, in_union=around.in_union, firm=True, at_key=True)
    if kind == "missing":
        return _missing(follow(data, model, loc[:-1]).path, loc[-1], in_union=place.in_union)
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        return _untagged(data, place, context)
    if kind in ("value_error", "assertion_error"):
        message = one_line(str(context.get("error") or detail["msg"]))
        return _Complaint(place.path, message, in_union=place.in_union, firm=True)
    if isinstance(context.get("key"), str):
        path = _relative(data, place.path, context["key"])
        return _Complaint(path, one_line(detail["msg"]), in_union=place.in_union, firm=True)
    at_key = loc[-1:] == ("[key]",)
    return _Complaint(place.path, *worded(detail), in_union=place.in_union, at_key=at_key)


def _missing(parent: KeyPath, part: str | int, *, in_union: bool) -> _Complaint:
    if isinstance(part, int):
        return _Complaint(parent, f"the list is too short: item {part + 1} is missing")
    return _Complaint((*parent, part), "required key is missing", in_union=in_union)


def _untagged(data: Any, place: Place, context: Mapping[str, Any]) -> _Complaint:
    """Say which kinds a discriminated union knows."""
    key = str(context.get("discriminator", "")).strip("'")
    tags = [tag for hint in place.keys().get(key, []) for tag in typing.get_args(hint)]
    allowed = ", ".join(f"'{tag}'" for tag in dict.fromkeys(map(str, tags)))
    path = (*place.path, key)
    value = value_at(data, path)
    if value is None:
        return _Complaint(path, f"required key is missing; it must be one of {allowed}")
    return _Complaint(path, f"must be one of {allowed} (got {shown(value)})")


def _relative(data: Any, path: KeyPath, key: str) -> KeyPath:
    """Return the path of a dotted key seen from a model."""
    for part in key.split("."):
        in_list = isinstance(value_at(data, path), list) and part.isdecimal()
        path = (*path, int(part) if in_list else part)
    return path
