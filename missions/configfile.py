"""Strict reader of aircraft and mission files that points at the line of every mistake.

A file is read in three steps: the text is parsed into plain data and the place of each key
(`read_yaml`, `parse_yaml`), values given on the command line replace or add keys
(`with_overrides`), and a pydantic model checks the result (`validate`). `load` does all three.
Every mistake of the user ends as an `InputError`, whose problems name file, line and column.
"""

from __future__ import annotations

import copy
import dataclasses
import difflib
import os
import re
import stat
import types
import typing
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import yaml
from pydantic import BaseModel, RootModel, Tag, ValidationError
from pydantic_core import ErrorDetails

__all__ = [
    "Document",
    "InputError",
    "Marks",
    "OutputError",
    "Problem",
    "load",
    "located_error",
    "parse_yaml",
    "read_yaml",
    "to_yaml",
    "validate",
    "with_overrides",
    "write_bytes_atomically",
    "write_text_atomically",
]

KeyPath: TypeAlias = tuple[str | int, ...]
Mark: TypeAlias = tuple[int, int]
Scalar: TypeAlias = bool | int | float | str | None
M = TypeVar("M", bound=BaseModel)

MAX_BYTES = 1_000_000
MAX_DEPTH = 40
MAX_EVENTS = 50_000
MAX_ALIASES = 50
MAX_NODES = 50_000

_SHOWN_LENGTH = 40
_SET = "--set "


# --------------------------------------------------------------------------------------
# Problems
# --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Problem:
    """One mistake of the user and its place.

    Parameters
    ----------
    source : str
        File name, or ``--set KEY`` for a value given on the command line.
    line, column : int or None
        Place in the file, counted from 1; None when the problem has no line.
    key : str
        Dotted path of the key, empty when the problem concerns the whole file.
    message : str
        What is wrong and what is allowed.
    """

    source: str
    line: int | None
    column: int | None
    key: str
    message: str

    def __str__(self) -> str:
        """Return the problem as one line of text."""
        parts = [self.source]
        if self.line is not None:
            parts[0] += f":{self.line}"
            if self.column is not None:
                parts[0] += f":{self.column}"
        if self.key and self.source != _SET + self.key:
            parts.append(self.key)
        return ": ".join([*parts, self.message])


class InputError(ValueError):
    """A user's mistake in a file or an override.

    Parameters
    ----------
    problems : iterable of Problem
        All problems found; kept sorted by line in the attribute ``problems``.
    """

    problems: tuple[Problem, ...]

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = tuple(sorted(problems, key=_order))
        super().__init__(self.problems)

    def __str__(self) -> str:
        """Return one problem per line."""
        return "\n".join(str(problem) for problem in self.problems)


class OutputError(OSError):
    """A file could not be written; the text says which one and why."""


def _order(problem: Problem) -> tuple[float, float]:
    """Sort by place; problems of overrides have no line and come last."""
    if problem.line is None:
        return (float("inf"), 0) if problem.source.startswith(_SET) else (0, 0)
    return (problem.line, problem.column or 0)


def _printable(text: str) -> str:
    """Escape what would break a one-line message (line breaks, lone surrogates)."""
    return text if text.isprintable() else text.encode("unicode_escape").decode("ascii")


def _shortened(text: str) -> str:
    return text if len(text) <= _SHOWN_LENGTH else text[: _SHOWN_LENGTH - 3] + "..."


def _dotted(path: Iterable[str | int]) -> str:
    return ".".join(_shortened(_printable(str(part))) for part in path)


def _shown(value: object) -> str:
    """Spell a value the way it stands in the file, shortened."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return _shown_float(value)
    if isinstance(value, Mapping):
        return "a mapping"
    if isinstance(value, list | tuple):
        return f"a list of {len(value)}"
    return _shortened(repr(value))


def _shown_float(value: float) -> str:
    special = {"inf": ".inf", "-inf": "-.inf", "nan": ".nan"}
    text = float.__repr__(value)
    return special.get(text, text)


# --------------------------------------------------------------------------------------
# Documents
# --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Marks:
    """Places of a document, counted from 1.

    Parameters
    ----------
    keys : mapping
        (line, column) of each key, by the path of the key.
    values : mapping
        (line, column) of each value, by its path; the empty path is the whole document.
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
    """Read a YAML file.

    Parameters
    ----------
    path : path-like
        File of at most 1 MB of UTF-8 text.

    Returns
    -------
    Document
        Data and places.

    Raises
    ------
    InputError
        If the file cannot be read or is not a plain YAML mapping.
    """
    source = _printable(os.fspath(path))
    try:
        with Path(path).open("rb") as file:
            raw = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        raise _file_error(source, _reading_trouble(error)) from error
    if len(raw) > MAX_BYTES:
        raise _file_error(source, _TOO_LARGE)
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError as error:
        line, column = _place(raw[: error.start].decode("utf-8"), error.start)
        message = f"is not UTF-8 text (byte 0x{raw[error.start]:02x})"
        raise InputError([Problem(source, line, column, "", message)]) from error
    return parse_yaml(text, source)


def parse_yaml(text: str, source: str) -> Document:
    """Parse YAML text.

    Parameters
    ----------
    text : str
        One YAML document, a mapping at its top level.
    source : str
        File name used in messages.

    Returns
    -------
    Document
        Data and places.

    Raises
    ------
    InputError
        If the text is not a plain YAML mapping.
    """
    root = _compose(text, source)
    if root is None or (root.value is None and root.empty):
        raise _file_error(source, "the file is empty; it must hold a mapping (key: value)")
    if not isinstance(root.value, dict):
        message = f"the top level must be a mapping (key: value), not {_kind(root.value)}"
        raise InputError([Problem(source, *root.mark, "", message)])
    keys: dict[KeyPath, Mark] = {}
    values: dict[KeyPath, Mark] = {}
    data = _plain(root, (), keys, values)
    return Document(source, data, Marks(keys, values))


_TOO_LARGE = f"is too large (at most {MAX_BYTES // 1_000_000} MB)"


def _file_error(source: str, message: str) -> InputError:
    return InputError([Problem(source, None, None, "", message)])


def _reading_trouble(error: OSError | ValueError) -> str:
    if isinstance(error, FileNotFoundError):
        return "no such file"
    if isinstance(error, IsADirectoryError):
        return "is a folder, not a file"
    if isinstance(error, PermissionError):
        return "cannot be read: permission denied"
    if isinstance(error, OSError) and error.strerror:
        return f"cannot be read: {error.strerror.lower()}"
    return "is not a valid file name"


def _kind(value: object) -> str:
    return "a list" if isinstance(value, list) else f"the single value {_shown(value)}"


def _place(text: str, offset: int) -> Mark:
    """Return line and column of an offset, counted from 1."""
    before = text[:offset]
    return before.count("\n") + 1, len(before) - (before.rfind("\n") + 1) + 1


# --------------------------------------------------------------------------------------
# From text to nodes
# --------------------------------------------------------------------------------------

# Only events are taken from the parser: the composer of libyaml recurses in C and crashes the
# process on deep nesting, and it gives no place for aliases.
_Parser: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

_NOT_YAML = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")

_CONSTANTS: dict[str, Scalar] = {
    **dict.fromkeys(["", "~", "null", "Null", "NULL"], None),
    **dict.fromkeys(["true", "True", "TRUE"], True),
    **dict.fromkeys(["false", "False", "FALSE"], False),
}
_INTEGER = re.compile(r"[-+]?(?:0|[1-9][0-9]*)")
_FLOAT = re.compile(r"[-+]?(?:(?:0|[1-9][0-9]*)(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)")


@dataclass(frozen=True)
class _Node:
    """Value with its place; `size` and `height` count after the expansion of aliases."""

    value: Scalar | list[_Node] | dict[str, tuple[Mark, _Node]]
    mark: Mark
    size: int = 1
    height: int = 0
    empty: bool = False
    block: bool = False


def _resolved(text: str) -> Scalar:
    """Return the value of an unquoted scalar by the rules of YAML 1.2, without octals."""
    if text in _CONSTANTS:
        return _CONSTANTS[text]
    # Python refuses to convert integers of thousands of digits; as floats they are infinite.
    if _INTEGER.fullmatch(text) and len(text) < 4000:
        return int(text)
    if _FLOAT.fullmatch(text):
        return float(text)
    if _NOT_FINITE.fullmatch(text):
        return float(text.replace(".", "", 1))
    return text


def _mark(event: Any) -> Mark:
    return event.start_mark.line + 1, event.start_mark.column + 1


def _compose(text: str, source: str) -> _Node | None:
    """Return the root node of the only document of the text, None when there is none."""
    if len(text) > MAX_BYTES or len(text.encode("utf-8", "replace")) > MAX_BYTES:
        raise _file_error(source, _TOO_LARGE)
    text = text.removeprefix("\ufeff")
    if odd := _NOT_YAML.search(text):
        message = f"character U+{ord(odd.group()):04X} is not allowed"
        raise InputError([Problem(source, *_place(text, odd.start()), "", message)])
    composer = _Composer(text, source)
    root = composer.root()
    if composer.problems:
        raise InputError(composer.problems)
    return root


class _Composer:
    """Builds the tree of one document from parser events, within fixed limits."""

    def __init__(self, text: str, source: str) -> None:
        self.problems: list[Problem] = []
        self._source = source
        self._text = text
        self._events = self._guarded()
        # The value None marks an anchor whose collection is still open.
        self._anchors: dict[str, _Node | None] = {}

    def root(self) -> _Node | None:
        node = None
        documents = 0
        for event in self._events:
            if isinstance(event, yaml.DocumentStartEvent):
                documents += 1
                if documents > 1:
                    self._refuse(_mark(event), (), "only one document (---) is allowed per file")
                node = self._node(next(self._events), (), 0)
        return node

    def _refuse(self, mark: Mark, path: KeyPath, message: str) -> typing.NoReturn:
        raise InputError([*self.problems, self._problem(mark, path, message)])

    def _problem(self, mark: Mark, path: KeyPath, message: str) -> Problem:
        return Problem(self._source, *mark, _dotted(path), message)

    def _guarded(self) -> Iterator[Any]:
        """Yield events; syntax errors and too many events or aliases end as InputError."""
        aliases = 0
        try:
            for count, event in enumerate(yaml.parse(self._text, Loader=_Parser)):
                aliases += isinstance(event, yaml.AliasEvent)
                if count >= MAX_EVENTS:
                    self._refuse(_mark(event), (), "too many values in one file")
                if aliases > MAX_ALIASES:
                    self._refuse(_mark(event), (), f"too many aliases (at most {MAX_ALIASES})")
                yield event
        except yaml.YAMLError as error:
            raise self._syntax_error(error) from error

    def _syntax_error(self, error: yaml.YAMLError) -> InputError:
        start = getattr(error, "context_mark", None)
        mark = getattr(error, "problem_mark", None) or start
        what = [getattr(error, name, None) for name in ("context", "problem")]
        text = " ".join(" ".join(part for part in what if part).split()) or "unreadable"
        line, column = (mark.line + 1, mark.column + 1) if mark else (None, None)
        if start and start.line + 1 != line:
            text += f" (it starts at line {start.line + 1})"
        if mark and self._text[mark.index : mark.index + 1] == "\t":
            text += "; indent with spaces, not tabs"
        return InputError([Problem(self._source, line, column, "", f"is not valid YAML: {text}")])

    def _node(self, event: Any, path: KeyPath, depth: int) -> _Node:
        mark = _mark(event)
        if isinstance(event, yaml.AliasEvent):
            return self._aliased(event, path, depth)
        if event.tag is not None:
            tag = event.tag.replace("tag:yaml.org,2002:", "!!")
            message = f"explicit tags ({_shortened(_printable(tag))}) are not allowed"
            self.problems.append(self._problem(mark, path, message))
        if event.anchor is not None:
            if event.anchor in self._anchors:
                self._refuse(mark, path, f"anchor &{event.anchor} is defined twice")
            self._anchors[event.anchor] = None
        node = self._content(event, mark, path, depth)
        if node.size > MAX_NODES:
            self._refuse(mark, path, "too many values after the expansion of aliases")
        if event.anchor is not None:
            self._anchors[event.anchor] = node
        return node

    def _content(self, event: Any, mark: Mark, path: KeyPath, depth: int) -> _Node:
        if isinstance(event, yaml.ScalarEvent):
            plain = not event.style
            value = _resolved(event.value) if plain else event.value
            return _Node(value, mark, empty=plain and not event.value)
        if depth >= MAX_DEPTH:
            self._refuse(mark, (), f"nested too deeply (at most {MAX_DEPTH} levels)")
        if isinstance(event, yaml.SequenceStartEvent):
            return self._sequence(event, mark, path, depth + 1)
        return self._mapping(event, mark, path, depth + 1)

    def _aliased(self, event: Any, path: KeyPath, depth: int) -> _Node:
        mark = _mark(event)
        if event.anchor not in self._anchors:
            self._refuse(mark, path, f"alias *{event.anchor} has no anchor before it")
        node = self._anchors[event.anchor]
        if node is None:
            self._refuse(mark, path, f"alias *{event.anchor} refers to a value that contains it")
        if depth + node.height > MAX_DEPTH:
            self._refuse(mark, (), f"nested too deeply (at most {MAX_DEPTH} levels)")
        return dataclasses.replace(node, mark=mark)

    def _sequence(self, start: Any, mark: Mark, path: KeyPath, depth: int) -> _Node:
        items: list[_Node] = []
        for event in self._events:
            if isinstance(event, yaml.SequenceEndEvent):
                break
            items.append(self._node(event, (*path, len(items)), depth))
        return _collection(items, items, mark, start)

    def _mapping(self, start: Any, mark: Mark, path: KeyPath, depth: int) -> _Node:
        entries: dict[str, tuple[Mark, _Node]] = {}
        for event in self._events:
            if isinstance(event, yaml.MappingEndEvent):
                break
            key_mark = _mark(event)
            key = self._key(event, path, depth)
            below = path if key is None else (*path, key)
            value = self._node(next(self._events), below, depth)
            if key is None:
                continue
            if key in entries:
                message = f"duplicate key (first at line {entries[key][0][0]})"
                self.problems.append(self._problem(key_mark, below, message))
            else:
                entries[key] = (key_mark, value)
        return _collection(entries, [node for _, node in entries.values()], mark, start)

    def _key(self, event: Any, path: KeyPath, depth: int) -> str | None:
        """Return the text of a key; None, with a problem noted, when it is not plain text."""
        node = self._node(event, path, depth)
        if not isinstance(event, yaml.ScalarEvent):
            shown = "an alias" if isinstance(event, yaml.AliasEvent) else _shown_node(node)
            message = f"a key must be text (got {shown})"
        elif not isinstance(node.value, str):
            message = f"a key must be text (got {_shown(node.value)}); put it in quotes"
        elif node.value == "<<" and not event.style:
            message = "merge keys (<<) are not allowed; write the keys out"
        else:
            return node.value
        self.problems.append(self._problem(_mark(event), path, message))
        return None


def _shown_node(node: _Node) -> str:
    return "a list" if isinstance(node.value, list) else "a mapping"


def _collection(
    value: list[_Node] | dict[str, tuple[Mark, _Node]],
    children: Sequence[_Node],
    mark: Mark,
    start: Any,
) -> _Node:
    size = 1 + sum(child.size for child in children)
    height = 1 + max((child.height for child in children), default=0)
    return _Node(value, mark, size, height, block=not start.flow_style)


def _plain(
    node: _Node, path: KeyPath, keys: dict[KeyPath, Mark], values: dict[KeyPath, Mark]
) -> Any:
    """Return plain data, a fresh copy for each alias, and note the places on the way."""
    values[path] = node.mark
    if isinstance(node.value, list):
        return [_plain(item, (*path, at), keys, values) for at, item in enumerate(node.value)]
    if not isinstance(node.value, dict):
        return node.value
    data = {}
    for key, (mark, child) in node.value.items():
        keys[(*path, key)] = mark
        data[key] = _plain(child, (*path, key), keys, values)
    return data


# --------------------------------------------------------------------------------------
# Overrides
# --------------------------------------------------------------------------------------


def with_overrides(document: Document, overrides: Sequence[str]) -> Document:
    """Return the document with values replaced or added.

    Parameters
    ----------
    document : Document
        The document; it is not changed.
    overrides : sequence of str
        Texts ``dotted.key=value``, applied in order. The value follows the rules of the files
        (a scalar, or a list or mapping in brackets); items of lists are named by their index
        from 0.

    Returns
    -------
    Document
        A new document.

    Raises
    ------
    InputError
        If an override is not readable or leads through a value that has no keys.
    """
    if not overrides:
        return document
    result = Document(
        document.source,
        copy.deepcopy(document.data),
        Marks(dict(document.marks.keys), dict(document.marks.values)),
        dict(document.overridden),
    )
    problems: list[Problem] = []
    for text in overrides:
        try:
            result = _with_override(result, text)
        except InputError as error:
            problems.extend(error.problems)
    if problems:
        raise InputError(problems)
    return result


def _with_override(document: Document, text: str) -> Document:
    key, equals, value_text = text.partition("=")
    key = key.strip()
    parts = key.split(".")
    shown = _dotted(parts)
    if not equals or not all(part.strip() for part in parts):
        shown = _shortened(_printable(text))
        raise _override_error(shown, "write an override as KEY=VALUE, for example a.b=2.5")
    if _NOT_YAML.search(key):
        raise _override_error(shown, "the key holds a character that is not allowed")
    value = _override_value(shown, value_text)
    path, made = _set(document, parts, value, shown)
    marks = Marks(_without(document.marks.keys, path), _without(document.marks.values, path))
    overridden: dict[KeyPath, str] = dict(_without(document.overridden, path))
    overridden.update(dict.fromkeys([*made, path], shown))
    return dataclasses.replace(document, marks=marks, overridden=overridden)


_V = TypeVar("_V")


def _without(places: Mapping[KeyPath, _V], path: KeyPath) -> dict[KeyPath, _V]:
    return {key: value for key, value in places.items() if key[: len(path)] != path}


def _override_error(shown: str, message: str) -> InputError:
    return InputError([Problem(_SET + shown, None, None, shown, message)])


def _override_value(shown: str, text: str) -> Any:
    try:
        node = _compose(text.strip(), "")
    except InputError as error:
        message = "; ".join(problem.message for problem in error.problems)
        raise _override_error(shown, f"the value {message}") from error
    if node is None or node.empty:
        raise _override_error(shown, "no value after the = sign (write null for no value)")
    if node.block:
        raise _override_error(
            shown, "write one value, or a list in brackets such as [1, 2]; quote text with colons"
        )
    return _plain(node, (), {}, {})


def _set(
    document: Document, parts: Sequence[str], value: Any, shown: str
) -> tuple[KeyPath, list[KeyPath]]:
    """Put the value into the data of the document.

    Return its path and the paths of the mappings made only to hold it.
    """
    holder: Any = document.data
    path: KeyPath = ()
    made: list[KeyPath] = []
    for part in parts[:-1]:
        key = _step(holder, path, part, shown)
        path = (*path, key)
        if isinstance(holder, dict) and holder.get(part) is None:
            holder[part] = {}
            made.append(path)
        holder = holder[key]
    key = _step(holder, path, parts[-1], shown)
    holder[key] = value
    return (*path, key), made


def _step(holder: Any, path: KeyPath, part: str, shown: str) -> str | int:
    """Return the key or index that `part` means in `holder`."""
    if isinstance(holder, dict):
        return part
    if not isinstance(holder, list):
        raise _override_error(
            shown, f"{_dotted(path)} is the single value {_shown(holder)} and has no keys"
        )
    allowed = f"an index from 0 to {len(holder) - 1}" if holder else "no index: it is empty"
    if not re.fullmatch(r"[0-9]{1,6}", part) or int(part) >= len(holder):
        raise _override_error(
            shown, f"{_dotted(path)} is a list and takes {allowed} (got {_shown(part)})"
        )
    return int(part)


# --------------------------------------------------------------------------------------
# Validation
# --------------------------------------------------------------------------------------


def load(path: str | os.PathLike[str], model: type[M], overrides: Sequence[str] = ()) -> M:
    """Read a file, apply overrides and validate the result.

    Parameters
    ----------
    path : path-like
        YAML file.
    model : type of pydantic model
        Description of the file.
    overrides : sequence of str
        Texts ``dotted.key=value``.

    Returns
    -------
    model instance
        The validated content.

    Raises
    ------
    InputError
        If anything is wrong with the file or an override.
    """
    return validate(with_overrides(read_yaml(path), overrides), model)


def validate(document: Document, model: type[M]) -> M:
    """Validate a document.

    Parameters
    ----------
    document : Document
        Data and places.
    model : type of pydantic model
        Description of the data.

    Returns
    -------
    model instance
        The validated content.

    Raises
    ------
    InputError
        With every problem of the document, each at its place.
    """
    try:
        return model.model_validate(document.data)
    except ValidationError as error:
        details = error.errors(include_url=False)
    raise InputError(_problems(document, model, details))


def located_error(document: Document, path: Sequence[str | int], message: str) -> InputError:
    """Return an error that points at a key of a document.

    Parameters
    ----------
    document : Document
        Data and places.
    path : sequence of str and int
        Keys and list indices from the top level; what does not exist is located at the
        nearest mapping around it.
    message : str
        What is wrong with the value.

    Returns
    -------
    InputError
        To be raised by the caller.
    """
    return InputError([_located(document, tuple(path), message)])


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


def _problems(
    document: Document, model: type[BaseModel], details: Iterable[ErrorDetails]
) -> list[Problem]:
    complaints = [_complaint(document.data, model, detail) for detail in details]
    return [
        _located(document, one.path, one.message + one.suffix, at_key=one.at_key)
        for one in _merged(complaints)
    ]


def _merged(complaints: Sequence[_Complaint]) -> list[_Complaint]:
    """Join what the choices of a union say about the same value."""
    # The choice that found fault with the content of a value is the one that was meant.
    read = {one.path[:end] for one in complaints if one.in_union for end in range(len(one.path))}
    read |= {one.path for one in complaints if one.in_union and one.firm}
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


def _located(document: Document, path: KeyPath, message: str, *, at_key: bool = False) -> Problem:
    """Return a problem at the longest part of the path that has a place."""
    key = _dotted(path)
    for end in range(len(path), -1, -1):
        prefix = path[:end]
        if prefix in document.overridden:
            return Problem(_SET + document.overridden[prefix], None, None, key, message)
        # A block mapping starts on the line below its key; its key says better what is meant.
        whole = at_key or isinstance(_value_at(document.data, prefix), dict | list)
        keys, values = document.marks.keys.get(prefix), document.marks.values.get(prefix)
        if mark := (keys or values) if whole else (values or keys):
            return Problem(document.source, *mark, key, message)
    return Problem(document.source, None, None, key, message)


def _has(holder: object, part: str | int) -> bool:
    if isinstance(holder, dict):
        return part in holder
    return isinstance(holder, list) and isinstance(part, int) and 0 <= part < len(holder)


def _value_at(data: Any, path: KeyPath) -> Any:
    for part in path:
        if not _has(data, part):
            return None
        data = data[part]
    return data


# ---- from the location of pydantic to a path in the document ----


@dataclass(frozen=True)
class _Place:
    """Path in the document, and the types that may describe the value there."""

    path: KeyPath
    kinds: tuple[Any, ...]
    in_union: bool = False


def _follow(data: Any, model: type[BaseModel], loc: KeyPath) -> _Place:
    """Drop the names of union choices from a pydantic location.

    The types are followed rather than the data alone, because the name of a choice may also
    be a key of the document.
    """
    path: KeyPath = ()
    kinds: tuple[Any, ...] = (model,)
    in_union = False
    for part in loc:
        choices = [choice for kind in kinds for choice in _choices(kind)]
        if len(choices) > len(kinds):
            kinds, in_union = _chosen(choices, str(part)), True
            continue
        children = tuple(child for kind in choices for child in _children(kind, part))
        if children or _has(_value_at(data, path), part):
            path, kinds = (*path, part), children
    return _Place(path, kinds, in_union)


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
    if not (isinstance(bare, type) and issubclass(bare, BaseModel)):
        return False
    literals = (
        str(value)
        for info in bare.model_fields.values()
        if typing.get_origin(info.annotation) is typing.Literal
        for value in typing.get_args(info.annotation)
    )
    # A model with validators is labelled "function-after[check(), Name]".
    return label in literals or re.search(rf"\b{re.escape(bare.__name__)}\b", label) is not None


def _children(kind: Any, part: str | int) -> list[Any]:
    """Return the type of one key or item; empty when it is not known."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
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


# ---- from the words of pydantic to plain words ----

_A_NUMBER = "must be a number"
_A_WHOLE_NUMBER = "must be a whole number"
_A_LIST = "must be a list"
_A_MAPPING = "must be a mapping of keys and values"
_A_DATE = "must be a date such as 2015-06-21"
_A_TIME = "must be a time such as 12:30"
_A_MOMENT = "must be a date and time such as 2015-06-21T12:30:00Z"
_TRUE_OR_FALSE = "must be true or false"

_WORDS = {
    "greater_than": "must be greater than {gt}",
    "greater_than_equal": "must be at least {ge}",
    "less_than": "must be less than {lt}",
    "less_than_equal": "must be at most {le}",
    "multiple_of": "must be a multiple of {multiple_of}",
    "finite_number": "must be a finite number",
    "float_type": _A_NUMBER,
    "float_parsing": _A_NUMBER,
    "int_type": _A_WHOLE_NUMBER,
    "int_parsing": _A_WHOLE_NUMBER,
    "int_parsing_size": _A_WHOLE_NUMBER,
    "int_from_float": _A_WHOLE_NUMBER,
    "bool_type": _TRUE_OR_FALSE,
    "bool_parsing": _TRUE_OR_FALSE,
    "string_type": "must be text",
    "string_too_short": "must have at least {min_length} characters",
    "string_too_long": "must have at most {max_length} characters",
    "string_pattern_mismatch": "must match the pattern {pattern}",
    "literal_error": "must be {expected}",
    "enum": "must be {expected}",
    "none_required": "must be null",
    "list_type": _A_LIST,
    "tuple_type": _A_LIST,
    "set_type": _A_LIST,
    "frozen_set_type": _A_LIST,
    "iterable_type": _A_LIST,
    "too_short": "must have at least {min_length} items",
    "too_long": "must have at most {max_length} items",
    "dict_type": _A_MAPPING,
    "mapping_type": _A_MAPPING,
    "model_type": _A_MAPPING,
    "model_attributes_type": _A_MAPPING,
    "dataclass_type": _A_MAPPING,
    "date_type": _A_DATE,
    "date_parsing": _A_DATE,
    "date_from_datetime_parsing": _A_DATE,
    "date_from_datetime_inexact": _A_DATE,
    "time_type": _A_TIME,
    "time_parsing": _A_TIME,
    "datetime_type": _A_MOMENT,
    "datetime_parsing": _A_MOMENT,
    "datetime_from_date_parsing": _A_MOMENT,
}


def _complaint(data: Any, model: type[BaseModel], detail: ErrorDetails) -> _Complaint:
    loc = detail["loc"]
    place = _follow(data, model, loc)
    kind = detail["type"]
    context = detail.get("ctx", {})
    if kind == "extra_forbidden":
        around = _follow(data, model, loc[:-1])
        message = _unknown_key(str(loc[-1]), around.kinds)
        path = (*around.path, loc[-1])
        return _Complaint(path, message, in_union=around.in_union, firm=True, at_key=True)
    if kind == "missing":
        return _missing(_follow(data, model, loc[:-1]).path, loc[-1], in_union=place.in_union)
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        return _untagged(data, place, context)
    if kind in ("value_error", "assertion_error"):
        message = _one_line(str(context.get("error") or detail["msg"]))
        return _Complaint(place.path, message, in_union=place.in_union, firm=True)
    if isinstance(context.get("key"), str):
        path = _relative(data, place.path, context["key"])
        return _Complaint(path, _one_line(detail["msg"]), in_union=place.in_union, firm=True)
    value = detail["input"]
    suffix = f" (got {_shown(value)})" + _hint(kind, value)
    if kind not in _WORDS:
        suffix = ""
    message = _translated(kind, context, detail["msg"], value)
    at_key = bool(loc) and loc[-1] == "[key]"
    return _Complaint(place.path, message, suffix, in_union=place.in_union, at_key=at_key)


def _missing(parent: KeyPath, part: str | int, *, in_union: bool) -> _Complaint:
    if isinstance(part, int):
        return _Complaint(parent, f"the list is too short: item {part + 1} is missing")
    return _Complaint((*parent, part), "required key is missing", in_union=in_union)


def _untagged(data: Any, place: _Place, context: Mapping[str, Any]) -> _Complaint:
    """Say which kinds a discriminated union knows."""
    key = str(context.get("discriminator", "")).strip("'")
    kinds = [choice for kind in place.kinds for choice in _choices(kind)]
    tags = dict.fromkeys(
        str(value)
        for kind in map(_bare, kinds)
        if isinstance(kind, type) and issubclass(kind, BaseModel)
        for name, hint in _fields(kind)
        if name == key
        for value in typing.get_args(hint)
    )
    allowed = ", ".join(f"'{tag}'" for tag in tags) or str(context.get("expected_tags", ""))
    path = (*place.path, key)
    value = _value_at(data, path)
    if value is None:
        said = f"required key is missing; it must be one of {allowed}" if allowed else ""
        return _Complaint(path, said or "required key is missing")
    return _Complaint(path, f"must be one of {allowed} (got {_shown(value)})")


def _relative(data: Any, path: KeyPath, key: str) -> KeyPath:
    """Return the path of a dotted key seen from a model."""
    for part in key.split("."):
        in_list = isinstance(_value_at(data, path), list) and part.isdecimal()
        path = (*path, int(part) if in_list else part)
    return path


def _one_line(text: str) -> str:
    return " ".join(text.splitlines())


def _translated(kind: str, context: Mapping[str, Any], original: str, value: object) -> str:
    if kind == "float_type" and isinstance(value, int) and not isinstance(value, bool):
        return _WORDS["finite_number"]
    if context.get("min_length") == 1:
        return "must not be empty"
    limits = {name: _limit(limit) for name, limit in context.items()}
    try:
        text = _WORDS[kind].format(**limits)
    except KeyError:
        return re.sub(r"^[A-Z]\w* should ", "must ", _one_line(original))
    return re.sub(r" 1 (item|character)s$", r" 1 \1", text)


def _limit(value: object) -> str:
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    return str(value)


def _hint(kind: str, value: object) -> str:
    numeric = kind.startswith(("float_", "int_"))
    if numeric and isinstance(value, str) and re.match(r"\s*[-+]?\.?[0-9]", value):
        return "; write the plain number; the unit is in the key"
    if kind == "string_type" and isinstance(value, bool | int | float):
        return "; put it in quotes"
    return ""


# ---- unknown keys ----

_UNIT = re.compile(
    r"[mk]?g|t|lbs?|oz|grams|[mckd]?m[23]?|ft2?|in|inch|n?mi|met(?:er|re)s|l"
    r"|m?s|sec|min|h|hr|d|(?:second|minute|hour|day)s?|[km]?wh?|[km]?j|[mk]?v|m?ah?|n|nm|kn"
    r"|[hkmg]?pa|m?bar|psi|deg|degrees?|rad|c|k|f|deg[ckf]|kelvin|celsius|k?hz|rpm"
    r"|pct|percent|fraction|ratio|per|mps|km?h|kmh|kph|mph|kts?|knots"
)


def _unknown_key(key: str, kinds: Iterable[Any]) -> str:
    models = [
        kind
        for outer in kinds
        for kind in map(_bare, _choices(outer))
        if isinstance(kind, type) and issubclass(kind, BaseModel)
    ]
    allowed = list(dict.fromkeys(name for model in models for name, _ in _fields(model)))
    if meant := _closest(key, allowed):
        return f"unknown key; did you mean '{meant}'?"
    return f"unknown key; allowed keys: {', '.join(allowed)}" if allowed else "unknown key"


def _closest(key: str, allowed: Sequence[str]) -> str | None:
    """Return the allowed key most like `key`; the same quantity in another unit comes first."""
    wanted = key.lower()
    same = [name for name in allowed if _quantity(name) == _quantity(wanted)]
    for names, cutoff in ((same, 0.0), (allowed, 0.6)):
        by_lower = {name.lower(): name for name in names}
        if found := difflib.get_close_matches(wanted, by_lower, n=1, cutoff=cutoff):
            return by_lower[found[0]]
    return None


def _quantity(key: str) -> str:
    """Return a key without its unit: `energy_wh_per_kg` gives `energy`."""
    words = key.lower().split("_")
    while len(words) > 1 and _UNIT.fullmatch(words[-1]):
        words.pop()
    return "_".join(words)


# --------------------------------------------------------------------------------------
# Writing
# --------------------------------------------------------------------------------------

_BARE_TEXT = re.compile(r"[A-Za-z_](?:[A-Za-z0-9_./+ -]*[A-Za-z0-9_./+-])?")
# Readers of YAML 1.1 take these for booleans.
_AMBIGUOUS = re.compile(r"y|n|yes|no|on|off|true|false|null", re.IGNORECASE)
_ESCAPES = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\t": "\\t", "\r": "\\r"}
_ESCAPED = re.compile('[\\\\"\x00-\x1f\x7f-\xa0\u2028\u2029\ufeff\ufffe\uffff]')


def to_yaml(data: Mapping[str, Any]) -> str:
    """Write plain data as block style YAML that `parse_yaml` reads back equal.

    Parameters
    ----------
    data : mapping
        Nested mappings with text keys, lists, tuples, text, numbers, booleans and None;
        the order of keys is kept.

    Returns
    -------
    str
        The text, ending with a line break.

    Raises
    ------
    TypeError
        If a key is not text or a value is of another type.
    ValueError
        If a text holds a lone surrogate or a key is too long for YAML.
    """
    return "\n".join(_lines(data)) + "\n"


def _lines(value: Mapping[str, Any] | Sequence[Any]) -> list[str]:
    """Return the lines of a collection, without indentation."""
    if not value:
        return ["{}" if isinstance(value, Mapping) else "[]"]
    if isinstance(value, Mapping):
        return [line for key, item in value.items() for line in _entry(_key_text(key), item)]
    return [line for item in value for line in _item(item)]


def _is_collection(value: object) -> bool:
    return isinstance(value, Mapping | list | tuple)


def _entry(key: str, value: Any) -> list[str]:
    if _is_collection(value) and value:
        return [f"{key}:", *(f"  {line}" for line in _lines(value))]
    return [f"{key}: {_inline(value)}"]


def _item(value: Any) -> list[str]:
    if _is_collection(value) and value:
        first, *rest = _lines(value)
        return [f"- {first}", *(f"  {line}" for line in rest)]
    return [f"- {_inline(value)}"]


def _inline(value: Any) -> str:
    """Return a scalar or an empty collection."""
    if _is_collection(value):
        return _lines(value)[0]
    if value is None or isinstance(value, bool):
        return _shown(value)
    if isinstance(value, int):
        return int.__repr__(value)
    if isinstance(value, float):
        return _shown_float(value)
    if isinstance(value, str):
        return _text(str.__str__(value))
    raise TypeError(f"cannot write a value of type {type(value).__name__} as YAML")


def _key_text(key: object) -> str:
    if not isinstance(key, str):
        raise TypeError(f"a key must be text, not {type(key).__name__}")
    text = _text(str.__str__(key))
    if len(text) > 1000:
        raise ValueError(f"the key {_shortened(key)} is too long for YAML")
    return text


def _text(text: str) -> str:
    if _BARE_TEXT.fullmatch(text) and not _AMBIGUOUS.fullmatch(text):
        return text
    text.encode("utf-8")  # a lone surrogate has no spelling in YAML
    return '"' + _ESCAPED.sub(_escape, text) + '"'


def _escape(match: re.Match[str]) -> str:
    return _ESCAPES.get(match.group()) or f"\\u{ord(match.group()):04x}"


def write_text_atomically(path: str | os.PathLike[str], text: str) -> None:
    """Write a UTF-8 text file completely or not at all.

    Parameters
    ----------
    path : path-like
        File to create or replace.
    text : str
        Its content; line breaks are written as they are.

    Raises
    ------
    OutputError
        If the file cannot be written; an existing file is then unchanged.
    """
    write_bytes_atomically(path, text.encode("utf-8"))


def write_bytes_atomically(path: str | os.PathLike[str], data: bytes) -> None:
    """Write a file completely or not at all.

    Parameters
    ----------
    path : path-like
        File to create or replace.
    data : bytes
        Its content.

    Raises
    ------
    OutputError
        If the file cannot be written; an existing file is then unchanged.
    """
    try:
        _write(Path(path), data)
    except (OSError, ValueError) as error:
        name = _printable(os.fspath(path))
        raise OutputError(f"cannot write {name}: {_writing_trouble(error)}") from error


def _write(path: Path, data: bytes) -> None:
    mode = path.stat().st_mode if path.exists() else None
    if mode is not None and stat.S_ISDIR(mode):
        raise IsADirectoryError
    if mode is not None and not stat.S_ISREG(mode):
        # A device or a pipe must be written to, never replaced by a file.
        path.write_bytes(data)
        return
    # Through a symbolic link the file it names is replaced, not the link.
    target = Path(os.path.realpath(path))
    scratch = target.parent / f".{os.urandom(8).hex()}.tmp"
    # Created by hand, for the permissions of an ordinary new file rather than a private one.
    descriptor = os.open(scratch, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
    try:
        with open(descriptor, "wb") as file:  # noqa: PTH123 - a descriptor has no path
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        if mode is not None:
            scratch.chmod(stat.S_IMODE(mode))
        scratch.replace(target)
    except BaseException:
        scratch.unlink(missing_ok=True)
        raise


def _writing_trouble(error: OSError | ValueError) -> str:
    if isinstance(error, FileNotFoundError):
        return "its folder does not exist"
    if isinstance(error, NotADirectoryError):
        return "a part of the path is a file, not a folder"
    if isinstance(error, IsADirectoryError):
        return "it is a folder"
    if isinstance(error, PermissionError):
        return "permission denied"
    if isinstance(error, OSError):
        return (error.strerror or str(error)).lower()
    return "not a valid file name"
