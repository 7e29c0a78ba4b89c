"""The types of a pydantic model followed along the location of one of its errors.

A location holds keys and list indices, but also names of union choices, which are no part of
the path in a file. The types are followed rather than the data alone, because the name of a
choice may also be a key of the file.
"""

from __future__ import annotations

import re
import types
import typing
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeGuard

from pydantic import BaseModel, RootModel, Tag

from missions.files.errors import KeyPath

__all__ = ["Place", "follow", "value_at"]


@dataclass(frozen=True)
class Place:
    """Path in the document, and the types that may describe the value there."""

    path: KeyPath
    kinds: tuple[Any, ...]
    in_union: bool = False

    def keys(self) -> dict[str, list[Any]]:
        """Return the keys that a mapping may have here, with their types."""
        result: dict[str, list[Any]] = {}
        for model in _models_of(self.kinds):
            for key, hint in _fields(model):
                result.setdefault(key, []).append(hint)
        return result


def follow(data: Any, model: type[BaseModel], loc: KeyPath) -> Place:
    """Return the place of a pydantic location, without the names of union choices."""
    path: KeyPath = ()
    kinds: tuple[Any, ...] = (model,)
    in_union = False
    for part in loc:
        choices = [choice for kind in kinds for choice in _choices(kind)]
        if len(choices) > len(kinds):
            kinds, in_union = _chosen(choices, str(part)), True
            continue
        children = tuple(child for kind in choices for child in _children(kind, part))
        if children or _has(value_at(data, path), part):
            path, kinds = (*path, part), children
    return Place(path, kinds, in_union)


def value_at(data: Any, path: KeyPath) -> Any:
    """Return the value at a path, None where there is none."""
    for part in path:
        if not _has(data, part):
            return None
        data = data[part]
    return data


def _has(holder: object, part: str | int) -> bool:
    if isinstance(holder, dict):
        return part in holder
    return isinstance(holder, list) and isinstance(part, int) and 0 <= part < len(holder)


def _models_of(kinds: Iterable[Any]) -> list[type[BaseModel]]:
    """Return the models among the types and the choices of unions."""
    bare = (_bare(choice) for kind in kinds for choice in _choices(kind))
    return [kind for kind in bare if _is_model(kind)]


def _is_model(kind: Any) -> TypeGuard[type[BaseModel]]:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def _bare(kind: Any) -> Any:
    """Strip what does not add to a location: annotations, new types, root models."""
    while True:
        if typing.get_origin(kind) is typing.Annotated:
            kind = typing.get_args(kind)[0]
        elif isinstance(kind, typing.NewType):
            kind = kind.__supertype__
        elif isinstance(kind, type) and issubclass(kind, RootModel):
            kind = kind.model_fields["root"].annotation
        else:
            return kind


def _choices(kind: Any) -> list[Any]:
    """Return the choices of a union, without null; any other type is its only choice."""
    bare = _bare(kind)
    if typing.get_origin(bare) not in (typing.Union, types.UnionType):
        return [bare]
    choices = [choice for choice in typing.get_args(bare) if choice is not type(None)]
    return choices if len(choices) > 1 else _choices(choices[0])


def _chosen(choices: Sequence[Any], label: str) -> tuple[Any, ...]:
    """Return the choices that a label of pydantic names; all of them if that is unclear."""
    named = tuple(choice for choice in choices if _is_named(choice, label))
    return named or tuple(choices)


def _is_named(choice: Any, label: str) -> bool:
    metadata = getattr(choice, "__metadata__", ())
    if any(isinstance(item, Tag) and item.tag == label for item in metadata):
        return True
    bare = _bare(choice)
    if not _is_model(bare):
        return False
    literals = (
        str(value)
        for _, hint in _fields(bare)
        if typing.get_origin(hint) is typing.Literal
        for value in typing.get_args(hint)
    )
    # A model with validators is labelled "function-after[check(), Name]".
    return label in literals or re.search(rf"\b{re.escape(bare.__name__)}\b", label) is not None


def _children(kind: Any, part: str | int) -> list[Any]:
    """Return the type of one key or item; empty when it is not known."""
    if _is_model(kind):
        return [hint for name, hint in _fields(kind) if name == part]
    arguments = [a for a in typing.get_args(kind) if a is not Ellipsis]
    origin = typing.get_origin(kind)
    if not (isinstance(origin, type) and arguments):
        return []
    if issubclass(origin, Mapping):
        return arguments[1:]
    if not isinstance(part, int):
        return []
    fixed = issubclass(origin, tuple) and Ellipsis not in typing.get_args(kind)
    return arguments[part : part + 1] if fixed else arguments[:1]


def _fields(model: type[BaseModel]) -> list[tuple[str, Any]]:
    """Return the keys of a model as they stand in a file, with their types."""
    return [
        (info.validation_alias if isinstance(info.validation_alias, str) else name, info.annotation)
        for name, info in model.model_fields.items()
    ]
