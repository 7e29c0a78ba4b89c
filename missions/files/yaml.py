"""YAML files as plain data with line and column of each key and value.

The subset of YAML 1.2 that is read has no tags, no merge keys, no octal numbers, and only text
for keys; an unquoted date, time, ``yes`` or ``on`` is text. Limits keep hostile files harmless.

ruamel.yaml keeps places too. It takes 20 ms for a shipped file instead of 2, and 35 ms to import;
limits, keys and scalars would be checked here all the same.
"""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import yaml

from missions.files.errors import (
    InputError,
    KeyPath,
    Problem,
    dotted,
    file_error,
    printable,
    shortened,
    shown,
)
from missions.files.texts import read_plain_file

Mark: TypeAlias = tuple[int, int]

# Keys whose text is a name or, as its end shows, the path of a file or a folder, in any record, and
# the keys of that record which the named entry gives. Records that have such keys add them.
ENTRY_KEYS: dict[str, tuple[str, ...]] = {}
PATH_SUFFIXES = (".csv", ".txt", ".pol", ".plr", ".dat", ".yaml", ".yml", "/")

_MAX_BYTES = 1_000_000
_MAX_DEPTH = 40
_MAX_EVENTS = 50_000
_MAX_ALIASES = 50
_MAX_VALUES = 60_000

_TOO_DEEP = f"nested too deeply (at most {_MAX_DEPTH} levels)"
_NOT_YAML = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")

# Unquoted scalars that are no text. Python refuses to convert integers of thousands of digits; as
# floats they are infinite.
_RESOLVERS = {
    "null": "~|null|Null|NULL|",
    "bool": "true|True|TRUE|false|False|FALSE",
    "int": r"[-+]?(?:0|[1-9][0-9]{0,3999})",
    "float": r"[-+]?(?:(?:0|[1-9][0-9]*)(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
    r"|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)",
}
_SPECIAL_FLOATS = re.compile(r"\.(?=[in])", re.IGNORECASE)
_VALUES: dict[str, Callable[[str], bool | int | float | None]] = {
    "null": lambda _: None,
    "bool": lambda text: text.lower() == "true",
    "int": int,
    "float": lambda text: float(_SPECIAL_FLOATS.sub("", text)),
}


def add_resolvers(kind: Any) -> Any:
    """Add this format's unquoted scalars to a loader or dumper, and return it."""
    for tag, expression in _RESOLVERS.items():
        kind.add_implicit_resolver(tag, re.compile(rf"(?:{expression})\Z"), None)
    return kind


def _loader(base: Any) -> Any:
    """Return a subclass of a loader that resolves scalars by this format's rules alone."""
    return add_resolvers(type("Loader", (base,), {"yaml_implicit_resolvers": {}}))


_PythonLoader = _loader(yaml.SafeLoader)
_Loader = _loader(yaml.CSafeLoader) if hasattr(yaml, "CSafeLoader") else _PythonLoader


class Place(NamedTuple):
    """Line and column of a key and its value, from 1; or the dotted key that an override set."""

    key: Mark | None = None
    value: Mark | None = None
    override: str = ""


@dataclass(frozen=True)
class Document:
    """Plain data of a file, and the places of its keys and values by path, empty of the whole."""

    source: str
    data: dict[str, Any]
    places: Mapping[KeyPath, Place] = field(default_factory=dict)


def read_yaml(path: str | os.PathLike[str]) -> Document:
    """Read a YAML file of at most 1 MB of UTF-8 text.

    Files that it names by a relative path are looked for in its own folder: the data hold their
    absolute paths.
    """
    source = printable(os.fspath(path))
    raw = read_plain_file(path, most_bytes=_MAX_BYTES)
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError as error:
        place = _place_of(raw[: error.start].decode("utf-8"), error.start)
        message = f"is not UTF-8 text (byte 0x{raw[error.start]:02x})"
        raise InputError([Problem(source, *place, "", message)]) from error
    document = parse_yaml(text, source)
    set_absolute_paths(document.data, Path(path).parent)
    return document


def parse_yaml(text: str, source: str) -> Document:
    """Parse YAML text that holds one mapping; return its data and their places."""
    root = _compose(text, source)
    if root is None:
        raise file_error(source, "the file is empty; it must hold a mapping (key: value)")
    read = _Reader(root, source)
    if not isinstance(read.data, dict):
        kind = "a list" if isinstance(read.data, list) else f"the single value {shown(read.data)}"
        message = f"the top level must be a mapping (key: value), not {kind}"
        raise InputError([Problem(source, *_place_in_file(root), "", message)])
    return Document(source, read.data, read.places)


def parse_value(text: str) -> Any:
    """Parse a value on one line: a scalar, or a list or mapping in brackets."""
    try:
        root = _compose(text.strip(), "")
        value = None if root is None else _Reader(root, "").data
    except InputError as error:
        message = "; ".join(problem.message for problem in error.problems)
        raise file_error("", f"the value {message}") from error
    if root is None:
        raise file_error("", "no value after the = sign (write null for no value)")
    if not isinstance(root, yaml.ScalarNode) and not root.flow_style:
        message = "write one value, or a list in brackets such as [1, 2]; quote text with colons"
        raise file_error("", message)
    return value


def set_absolute_paths(data: Any, folder: Path) -> None:
    """Make relative paths in plain data absolute, in place.

    Text under one of `ENTRY_KEYS` that ends in one of `PATH_SUFFIXES` is a path.
    """
    for key, value in data.items() if isinstance(data, dict) else enumerate(data):
        if key in ENTRY_KEYS and isinstance(value, list):
            data[key] = [_absolute(text, folder) for text in value]
        elif isinstance(value, dict | list):
            set_absolute_paths(value, folder)
        elif key in ENTRY_KEYS:
            data[key] = _absolute(value, folder)


def _absolute(value: Any, folder: Path) -> Any:
    """Return the absolute path of a text that is one, else the value."""
    if not isinstance(value, str) or not value.lower().endswith(PATH_SUFFIXES):
        return value
    path = os.path.abspath(folder / value)  # noqa: PTH100 - resolve() follows links
    return f"{path}/" if value.endswith("/") else path


def _compose(text: str, source: str) -> Any:
    """Return the root node of the only document, None if empty."""
    if len(text.encode("utf-8", "replace")) > _MAX_BYTES:
        raise file_error(source, f"is larger than {_MAX_BYTES // 1_000_000} MB")
    text = text.removeprefix("\ufeff")
    if odd := _NOT_YAML.search(text):
        message = f"character U+{ord(odd.group()):04X} is not allowed"
        raise InputError([Problem(source, *_place_of(text, odd.start()), "", message)])
    try:
        # Checked first: the composer of libyaml recurses in C and would crash on deep nesting.
        _check_limits(text, source, _Loader)
        root: Any = yaml.compose(text, Loader=_Loader)
    except yaml.YAMLError as error:
        raise _syntax_error(error, text, source) from error
    empty = isinstance(root, yaml.ScalarNode) and not (root.value or root.style)
    return None if empty else root


def _check_limits(text: str, source: str, loader: Any) -> None:
    """Refuse explicit tags and exceeded limits."""
    depth = documents = aliases = 0
    for count, event in enumerate(yaml.parse(text, Loader=loader)):
        documents += isinstance(event, yaml.DocumentStartEvent)
        aliases += isinstance(event, yaml.AliasEvent)
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if tag := getattr(event, "tag", None):
            tag = shortened(printable(tag.replace("tag:yaml.org,2002:", "!!")))
            message = f"explicit tags ({tag}) are not allowed"
        elif documents > 1:
            message = "only one document (---) is allowed per file"
        elif depth > _MAX_DEPTH:
            message = _TOO_DEEP
        elif count >= _MAX_EVENTS:
            message = "too many values in one file"
        elif aliases > _MAX_ALIASES:
            message = f"too many aliases (at most {_MAX_ALIASES})"
        else:
            continue
        raise InputError([Problem(source, *_place_in_file(event), "", message)])


def _syntax_error(error: yaml.YAMLError, text: str, source: str) -> InputError:
    """Return a syntax error, or refuse too deep nesting before it."""
    start = getattr(error, "context_mark", None)
    mark = getattr(error, "problem_mark", None)
    # libyaml reads up to 1024 characters ahead of its events, and as in PyYAML 6.0.4 refuses 1000
    # open brackets there by itself; the parser in Python has no such limit.
    before = text[: mark.index] if mark else ""
    opened, closed = (sum(map(before.count, pair)) for pair in ("[{", "]}"))
    if opened - closed > _MAX_DEPTH:
        with contextlib.suppress(yaml.YAMLError):
            _check_limits(before, source, _PythonLoader)
    mark = mark or start
    what = [getattr(error, name, None) for name in ("context", "problem")]
    words = " ".join(" ".join(part for part in what if part).split()) or "unreadable"
    line, column = (mark.line + 1, mark.column + 1) if mark else (None, None)
    if start and start.line + 1 != line:
        words += f" (it starts at line {start.line + 1})"
    if mark and text[mark.index : mark.index + 1] == "\t":
        words += "; indent with spaces, not tabs"
    return InputError([Problem(source, line, column, "", f"is not valid YAML: {words}")])


def _place_of(text: str, offset: int) -> Mark:
    """Return line and column of an offset, counted from 1."""
    before = text[:offset]
    return before.count("\n") + 1, len(before) - before.rfind("\n")


def _place_in_file(item: Any) -> Mark:
    return item.start_mark.line + 1, item.start_mark.column + 1


class _Reader:
    """Converter of nodes to plain data, a copy for each alias, with places and problems."""

    def __init__(self, root: Any, source: str) -> None:
        self.places: dict[KeyPath, Place] = {}
        self._problems: list[Problem] = []
        self._source = source
        self._count = 0
        self.data = self._plain(root, (), ())
        if self._problems:
            raise InputError(self._problems)

    def _note(self, node: Any, path: KeyPath, message: str) -> None:
        self._problems.append(Problem(self._source, *_place_in_file(node), dotted(path), message))

    def _plain(
        self, node: Any, path: KeyPath, around: tuple[Any, ...], key_mark: Mark | None = None
    ) -> Any:
        """Return the data of a node; ``around``: the nodes that contain it."""
        self._count += 1
        self.places[path] = Place(key_mark, _place_in_file(node))
        if isinstance(node, yaml.ScalarNode):
            return _VALUES.get(node.tag, str)(node.value)
        for holds, message in (
            (node in around, "an alias refers to a value that contains it"),
            (len(around) >= _MAX_DEPTH, _TOO_DEEP),
            (self._count > _MAX_VALUES, "too many values after the expansion of aliases"),
        ):
            if holds:
                self._note(node, path, message)
                raise InputError(self._problems)
        around = (*around, node)
        if isinstance(node, yaml.SequenceNode):
            return [self._plain(item, (*path, i), around) for i, item in enumerate(node.value)]
        data: dict[str, Any] = {}
        for key_node, value_node in node.value:
            key, mark = self._key(key_node, path), _place_in_file(key_node)
            below = path if key is None else (*path, key)
            if key in data:
                line, _ = self.places[below].key or mark
                self._note(key_node, below, f"duplicate key (first at line {line})")
            value = self._plain(value_node, below, around, mark)
            if key is not None:
                data[key] = value
        return data

    def _key(self, node: Any, path: KeyPath) -> str | None:
        """Return the text of a key; None, with a problem noted, if not plain text."""
        if isinstance(node, yaml.CollectionNode):
            kind = "a list" if isinstance(node, yaml.SequenceNode) else "a mapping"
            message = f"a key must be text (got {kind})"
        elif node.tag in _VALUES:
            value = shown(_VALUES[node.tag](node.value))
            message = f"a key must be text (got {value}); put it in quotes"
        elif node.value == "<<" and not node.style:
            message = "merge keys (<<) are not allowed; write the keys out"
        else:
            return str(node.value)
        self._note(node, path, message)
        return None
