"""Validation of aircraft and mission files, with the line of every mistake.

A file is read in three steps: the text is parsed into plain data and the place of each key
(`missions.files.yaml`), values given on the command line replace or add keys
(`missions.files.overrides`), and a pydantic model checks the result (`validate`). Every mistake of
the user ends as an `InputError`, whose problems name file, line and column.

Class variables of a record list its former keys, old to new: ``deprecated_keys`` are read with a
warning, ``explained_keys`` refused with their sentence.
"""

from __future__ import annotations

import copy
import dataclasses
import difflib
import math
import re
import typing
import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails, PydanticCustomError

from missions.files.errors import OVERRIDE, InputError, KeyPath, Problem, dotted, shown
from missions.files.yaml import Document
from solar.schema import wrong_value
from solar.versions import DeprecatedKeyWarning, deprecation

M = TypeVar("M", bound=BaseModel)

# Mistakes of a file that the document names are listed up to this many.
_SHOWN_ELSEWHERE = 20

# Keys that tell one kind of record from another (the discriminators of unions).
_KIND_KEYS = ("kind", "model", "distribution")


def validate(document: Document, model: type[M]) -> M:
    """Return the content of a document as described by a model."""
    try:
        return model.model_validate(document.data)
    except ValidationError as error:
        # A list may be too short only because some of its items are wrong.
        details = [
            detail
            for detail in error.errors(include_url=False)
            if detail["type"] != "too_short"
            or len(detail["input"]) < detail.get("ctx", {}).get("min_length", math.inf)
        ]
    renewed = _rename_deprecated_keys(document, model, details)
    if renewed is not document:
        return validate(renewed, model)
    complaints = _merge_union_complaints(
        [_complaint(document.data, model, detail) for detail in details]
    )
    located = [_locate(document, c.path, c.message + c.suffix, at_key=c.at_key) for c in complaints]
    elsewhere = [p for detail in details for p in detail.get("ctx", {}).get("problems", ())]
    raise InputError([*located, *elsewhere[:_SHOWN_ELSEWHERE]])


def located_error(document: Document, path: Sequence[str | int], message: str) -> InputError:
    """Return an error at a key of a document, or at the nearest mapping around a missing key."""
    return InputError([_locate(document, tuple(path), message)])


def wrong_file(key: str, error: ValueError) -> PydanticCustomError:
    """Return a validator's error at a key whose file is wrong or cannot be read."""
    if not isinstance(error, InputError):
        return wrong_value(key, str(error))
    if (count := len(error.problems)) == 1:
        return wrong_value(key, str(error.problems[0]))
    return wrong_value(key, f"has {count} mistakes", problems=error.problems)


def _locate(document: Document, path: KeyPath, message: str, *, at_key: bool = False) -> Problem:
    """Return a problem at the longest part of the path that has a place."""
    key = dotted(path)
    for end in range(len(path), -1, -1):
        if (place := document.places.get(path[:end])) is None:
            continue
        if place.override:
            return Problem(OVERRIDE + place.override, None, None, key, message)
        # A block mapping starts on the line below its key: point at the key.
        whole = at_key or isinstance(_value_at(document.data, path[:end]), dict | list)
        line, column = (whole and place.key) or place.value or (None, None)
        return Problem(document.source, line, column, key, message)
    return Problem(document.source, None, None, key, message)


@dataclass(frozen=True)
class _Complaint:
    """Pydantic error with the key's path in the file.

    Choices of a union each complain about the same value; firm complaints concern the value's
    content, not its type, and are never joined to others.
    """

    path: KeyPath
    message: str
    suffix: str = ""
    in_union: bool = False
    firm: bool = False
    at_key: bool = False


def _merge_union_complaints(complaints: Iterable[_Complaint]) -> list[_Complaint]:
    """Join the complaints of a union's choices about the same value."""
    of_unions = [complaint for complaint in complaints if complaint.in_union]
    # The choice that found fault with the content of a value is the one that was meant.
    read = {complaint.path[:end] for complaint in of_unions for end in range(len(complaint.path))}
    read |= {complaint.path for complaint in of_unions if complaint.firm}
    result: dict[tuple[KeyPath, str], _Complaint] = {}
    for complaint in complaints:
        if complaint.firm or not complaint.in_union:
            result.setdefault((complaint.path, complaint.message), complaint)
        elif complaint.path not in read:
            first = result.setdefault((complaint.path, ""), complaint)
            if complaint.message not in first.message.split(", or "):
                suffix = max(first.suffix, complaint.suffix, key=len)
                message = f"{first.message}, or {complaint.message}"
                joined = dataclasses.replace(first, message=message, suffix=suffix)
                result[complaint.path, ""] = joined
    return list(result.values())


def _complaint(data: Any, model: type[BaseModel], detail: ErrorDetails) -> _Complaint:
    loc, kind, context = detail["loc"], detail["type"], detail.get("ctx", {})
    path, in_union = _path_of_location(data, loc)
    if kind in ("extra_forbidden", "missing"):
        (path, in_union), last = _path_of_location(data, loc[:-1]), loc[-1]
        if kind == "extra_forbidden":
            models, keys = _models_at(model, loc[:-1]), _value_at(data, path).keys()
            best = max(models, key=lambda candidate: len(_hints(candidate).keys() & keys))
            names = ("deprecated_keys", "explained_keys")
            former = {old: new for n in names for old, new in getattr(best, n, {}).items()}
            message = unknown_key(str(last), list(_hints(best)))
            if (meant := former.get(str(last))) is not None:
                renamed = f"this key is called '{meant}' now"
                message = f"unknown key; {meant}" if " " in meant else renamed
            return _Complaint((*path, last), message, in_union=in_union, firm=True, at_key=True)
        if isinstance(last, int):
            return _Complaint(path, f"the list is too short: item {last + 1} is missing")
        return _Complaint((*path, last), "required key is missing", in_union=in_union)
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        choices = (tag for choice in _models_at(model, loc) for tag in _kinds(choice))
        allowed = f"must be one of {', '.join(dict.fromkeys(map(repr, choices)))}"
        path = (*path, str(context["discriminator"]).strip("'"))
        if (value := _value_at(data, path)) is None:
            return _Complaint(path, f"required key is missing; it {allowed}")
        return _Complaint(path, f"{allowed} (got {shown(value)})")
    if kind in ("value_error", "assertion_error"):
        message = _on_one_line(str(context.get("error") or detail["msg"]))
        return _Complaint(path, message, in_union=in_union, firm=True)
    if isinstance(context.get("key"), str):
        path = (*path, *(int(k) if k.isdecimal() else k for k in context["key"].split(".")))
        return _Complaint(path, _on_one_line(detail["msg"]), in_union=in_union, firm=True)
    return _Complaint(
        path, *_message_and_hint(detail), in_union=in_union, at_key=loc[-1:] == ("[key]",)
    )


def _rename_deprecated_keys(
    document: Document, model: type[BaseModel], details: Iterable[ErrorDetails]
) -> Document:
    """Return a document whose deprecated keys have their new names, with a warning for each."""
    for detail in details:
        if detail["type"] != "extra_forbidden":
            continue
        (path, _), old = _path_of_location(document.data, detail["loc"][:-1]), detail["loc"][-1]
        names = [getattr(choice, "deprecated_keys", {}) for choice in _models_at(model, path)]
        new = next((renamed[old] for renamed in names if old in renamed), None)
        if new is not None and new not in _value_at(document.data, path):
            problem = _locate(document, (*path, old), deprecation(new), at_key=True)
            warnings.warn(str(problem), DeprecatedKeyWarning, stacklevel=3)
            document = _rename_key(document, path, str(old), new)
    return document


def _rename_key(document: Document, holder: KeyPath, old: str, new: str) -> Document:
    """Return a document in which a key has another name, at the same place."""
    data = copy.deepcopy(document.data)
    fields = _value_at(data, holder)
    items = [(new if key == old else key, value) for key, value in fields.items()]
    fields.clear()
    fields.update(items)

    before, after = (*holder, old), (*holder, new)
    end = len(before)
    places = {after + k[end:] if k[:end] == before else k: v for k, v in document.places.items()}
    return dataclasses.replace(document, data=data, places=places)


# ---- pydantic's locations, in the data and in the models ----


def _has(holder: object, part: str | int) -> bool:
    if isinstance(holder, dict):
        return part in holder
    return isinstance(holder, list) and isinstance(part, int) and 0 <= part < len(holder)


def _value_at(data: Any, path: KeyPath) -> Any:
    """Return the value at a path, None where there is none."""
    for part in path:
        if not _has(data, part):
            return None
        data = data[part]
    return data


def _path_of_location(data: Any, loc: KeyPath) -> tuple[KeyPath, bool]:
    """Return the path of a location, and true if it leads through a union.

    A location holds keys, list indices and names of the choices of unions, which are not part of
    the path; the name in a discriminated union is the value of its discriminator.
    """
    path: KeyPath = ()
    in_union = named = False
    for part in loc:
        kinds = [data.get(key) for key in _KIND_KEYS] if isinstance(data, dict) else []
        if (part in kinds and not named) or not _has(data, part):
            in_union = named = True
        else:
            data, path, named = data[part], (*path, part), False
    return path, in_union


def _models_at(model: type[BaseModel], loc: KeyPath) -> list[type[BaseModel]]:
    """Return the models that may describe the value at a location."""
    models: list[type[BaseModel]] = [model]
    for part in loc:
        hints = [hint for model in models for key, hint in _hints(model).items() if key == part]
        inner = [inner_model for hint in hints for inner_model in _models_in(hint)]
        models = inner or [model for model in models if part in _kinds(model)] or models
    return models


def _hints(model: type[BaseModel]) -> dict[str, Any]:
    """Return the keys of a model as they stand in a file, with their types."""
    return {info.alias or name: info.annotation for name, info in model.model_fields.items()}


def _kinds(model: type[BaseModel]) -> list[Any]:
    """Return the values by which a discriminator names this model."""
    return [kind for key in _KIND_KEYS for kind in typing.get_args(_hints(model).get(key))]


def _models_in(kind: Any) -> Iterator[type[BaseModel]]:
    """Yield the models within a type."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        yield kind
    for argument in typing.get_args(kind):
        yield from _models_in(argument)


# ---- the words ----

# Pydantic's words, and their replacements.
_WORDS = [
    (re.compile(expression), words)
    for expression, words in (
        (r"^\w+ should ", "must "),
        (r"greater than or equal to", "at least"),
        (r"less than or equal to", "at most"),
        (r"a valid number", "a number"),
        (r"a valid integer.*", "a whole number"),
        (r"a valid boolean", "true or false"),
        (r"a valid string", "text"),
        (r"a valid (list|tuple)", "a list"),
        (r"a valid dictionary.*", "a mapping of keys and values"),
        (r" after validation.*", ""),
        (r"have at least 1 \w+$", "not be empty"),
    )
]


def _message_and_hint(detail: ErrorDetails) -> tuple[str, str]:
    """Return a message about a wrong value, and the value itself with a hint."""
    kind, value, text = detail["type"], detail["input"], _on_one_line(detail["msg"])
    if " should " not in text:
        return text, ""
    if kind == "float_type" and type(value) is int:
        text = "must be a finite number"  # beyond the largest float
    for expression, words in _WORDS:
        text = expression.sub(words, text)
    if isinstance(value, str):
        text = re.sub(r"(\d) items?$", r"\1 characters", text)
    hint = ""
    if kind == "string_type" and isinstance(value, bool | int | float):
        hint = "; put it in quotes"
    elif kind.startswith(("float_", "int_")) and isinstance(value, str):
        if re.fullmatch(r"\s*[-+]?[0-9]+,[0-9]+\s*", value):
            hint = "; write a point before the decimals, not a comma"
        elif re.match(r"\s*[-+]?\.?[0-9]", value):
            hint = "; write the plain number; the unit is in the key"
    return text, f" (got {shown(value)}){hint}"


def _on_one_line(text: str) -> str:
    return " ".join(text.splitlines())


_UNIT = re.compile(
    r"[mk]?g|t|lbs?|oz|grams|[mckd]?m[23]?|ft2?|in|inch|n?mi|met(?:er|re)s|l"
    r"|m?s|sec|min|h|hr|d|(?:second|minute|hour|day)s?|[km]?wh?|[km]?j|[mk]?v|m?ah?|n|nm|kn"
    r"|[hkmg]?pa|m?bar|psi|deg|degrees?|rad|c|k|f|deg[ckf]|kelvin|celsius|k?hz|rpm"
    r"|pct|percent|fraction|ratio|per|mps|km?h|kmh|kph|mph|kts?|knots"
)


def unknown_key(key: str, allowed: Sequence[str], what: str = "unknown key") -> str:
    """Say that a key does not exist, and suggest another or list what is allowed."""
    if alike := alike_key(key, allowed):
        return f"{what}; did you mean '{alike}'?"
    return f"{what}; allowed keys: {', '.join(allowed)}" if allowed else what


def alike_key(key: str, allowed: Sequence[str]) -> str | None:
    """Return the key that was perhaps meant."""
    lower = key.lower()
    # The same quantity in another unit comes first.
    same = [name for name in allowed if _quantity(name) == _quantity(lower)]
    for names, cutoff in ((same, 0.0), (allowed, 0.6)):
        by_lower = {name.lower(): name for name in names}
        if alike := difflib.get_close_matches(lower, by_lower, n=1, cutoff=cutoff):
            return by_lower[alike[0]]
    return None


def _quantity(key: str) -> str:
    """Return a key without its unit: `energy_wh_per_kg` gives `energy`."""
    words = key.lower().split("_")
    while len(words) > 1 and _UNIT.fullmatch(words[-1]):
        words.pop()
    return "_".join(words)
