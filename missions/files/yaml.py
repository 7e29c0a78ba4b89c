"""YAML files as plain data that remembers the line and column of each key and value."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from missions.files.errors import InputError, KeyPath, Problem, file_error, printable, shown
from missions.files.yaml_nodes import MAX_BYTES, TOO_LARGE, Mark, Node, compose, place_of

__all__ = ["Document", "Marks", "parse_yaml", "plain_data", "read_yaml"]


@dataclass(frozen=True)
class Marks:
    """Places of a document, (line, column) counted from 1.

    Parameters
    ----------
    keys : mapping
        Place of each key, by the path of the key.
    values : mapping
        Place of each value, by its path; the empty path is the whole document.
    """

    keys: Mapping[KeyPath, Mark] = field(default_factory=dict)
    values: Mapping[KeyPath, Mark] = field(default_factory=dict)


@dataclass(frozen=True)
class Document:
    """Plain data of one file and the places it came from.

    Parameters
    ----------
    source : str
        File name used in messages.
    data : dict
        Content of the file after overrides.
    marks : Marks
        Places of keys and values.
    overridden : mapping
        Paths set by an override and the dotted key the user wrote.
    """

    source: str
    data: dict[str, Any]
    marks: Marks = field(default_factory=Marks)
    overridden: Mapping[KeyPath, str] = field(default_factory=dict)


def read_yaml(path: str | os.PathLike[str]) -> Document:
    """Read a YAML file of at most 1 MB of UTF-8 text.

    Raises
    ------
    InputError
        If the file cannot be read or is not a plain YAML mapping.
    """
    source = printable(os.fspath(path))
    try:
        with Path(path).open("rb") as file:
            raw = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        raise file_error(source, _reading_trouble(error)) from error
    if len(raw) > MAX_BYTES:
        raise file_error(source, TOO_LARGE)
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError as error:
        place = place_of(raw[: error.start].decode("utf-8"), error.start)
        message = f"is not UTF-8 text (byte 0x{raw[error.start]:02x})"
        raise InputError([Problem(source, *place, "", message)]) from error
    return parse_yaml(text, source)


def parse_yaml(text: str, source: str) -> Document:
    """Parse YAML text, one mapping; ``source`` is the file name used in messages.

    Raises
    ------
    InputError
        If the text is not a plain YAML mapping.
    """
    root = compose(text, source)
    if root is None or root.empty:
        raise file_error(source, "the file is empty; it must hold a mapping (key: value)")
    data, marks = plain_data(root)
    if not isinstance(data, dict):
        kind = "a list" if isinstance(data, list) else f"the single value {shown(data)}"
        message = f"the top level must be a mapping (key: value), not {kind}"
        raise InputError([Problem(source, *root.mark, "", message)])
    return Document(source, data, marks)


def plain_data(root: Node) -> tuple[Any, Marks]:
    """Return the data of a tree, a fresh copy for each alias, and its places."""
    keys: dict[KeyPath, Mark] = {}
    values: dict[KeyPath, Mark] = {}

    def plain(node: Node, path: KeyPath) -> Any:
        values[path] = node.mark
        if isinstance(node.value, list):
            return [plain(item, (*path, index)) for index, item in enumerate(node.value)]
        if not isinstance(node.value, dict):
            return node.value
        keys.update({(*path, key): mark for key, (mark, _) in node.value.items()})
        return {key: plain(child, (*path, key)) for key, (_, child) in node.value.items()}

    return plain(root, ()), Marks(keys, values)


def _reading_trouble(error: OSError | ValueError) -> str:
    if isinstance(error, FileNotFoundError):
        return "no such file"
    if isinstance(error, IsADirectoryError):
        return "is a folder, not a file"
    if isinstance(error, OSError) and error.strerror:
        return f"cannot be read: {error.strerror.lower()}"
    return "is not a valid file name"
