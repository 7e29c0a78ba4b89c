"""From YAML text to a tree of values with their places, within limits against hostile files.

The subset of YAML 1.2 that is read has no tags, no merge keys, no octal numbers, and only text
for keys; an unquoted date, time, ``yes`` or ``on`` is text.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NoReturn, TypeAlias

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

__all__ = ["MAX_BYTES", "NOT_YAML", "TOO_LARGE", "Mark", "Node", "compose", "place_of"]

Mark: TypeAlias = tuple[int, int]
Scalar: TypeAlias = bool | int | float | str | None

MAX_BYTES = 1_000_000
MAX_DEPTH = 40
MAX_EVENTS = 50_000
MAX_ALIASES = 50
MAX_NODES = 50_000

TOO_LARGE = f"is too large (at most {MAX_BYTES // 1_000_000} MB)"
NOT_YAML = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")

# Only events are taken from the parser: the composer of libyaml recurses in C and crashes the
# process on deep nesting, and it gives no place for aliases.
_Parser: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

_CONSTANTS: dict[str, Scalar] = {
    **dict.fromkeys(["", "~", "null", "Null", "NULL"], None),
    **dict.fromkeys(["true", "True", "TRUE"], True),
    **dict.fromkeys(["false", "False", "FALSE"], False),
}
_INTEGER = re.compile(r"[-+]?(?:0|[1-9][0-9]*)")
_FLOAT = re.compile(r"[-+]?(?:(?:0|[1-9][0-9]*)(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)")


@dataclass(frozen=True)
class Node:
    """Value with its place; `size` and `height` count after the expansion of aliases."""

    value: Scalar | list[Node] | dict[str, tuple[Mark, Node]]
    mark: Mark
    size: int = 1
    height: int = 0
    empty: bool = False
    block: bool = False


def compose(text: str, source: str) -> Node | None:
    """Return the root node of the only document of the text, None when there is none.

    Raises
    ------
    InputError
        If the text is not YAML of the subset, or exceeds a limit.
    """
    if len(text.encode("utf-8", "replace")) > MAX_BYTES:
        raise file_error(source, TOO_LARGE)
    text = text.removeprefix("\ufeff")
    if odd := NOT_YAML.search(text):
        message = f"character U+{ord(odd.group()):04X} is not allowed"
        raise InputError([Problem(source, *place_of(text, odd.start()), "", message)])
    composer = _Composer(text, source)
    root = composer.root()
    if composer.problems:
        raise InputError(composer.problems)
    return root


def place_of(text: str, offset: int) -> Mark:
    """Return line and column of an offset, counted from 1."""
    before = text[:offset]
    return before.count("\n") + 1, len(before) - before.rfind("\n")


def _resolved(text: str) -> Scalar:
    """Return the value of an unquoted scalar."""
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


class _Composer:
    """Builds the tree of one document from parser events."""

    def __init__(self, text: str, source: str) -> None:
        self.problems: list[Problem] = []
        self._source = source
        self._text = text
        self._events = self._guarded()
        # The value None marks an anchor whose collection is still open.
        self._anchors: dict[str, Node | None] = {}

    def root(self) -> Node | None:
        node = None
        documents = 0
        for event in self._events:
            if isinstance(event, yaml.DocumentStartEvent):
                documents += 1
                if documents > 1:
                    self._refuse(_mark(event), (), "only one document (---) is allowed per file")
                node = self._node(next(self._events), (), 0)
        return node

    def _note(self, mark: Mark, path: KeyPath, message: str) -> None:
        self.problems.append(Problem(self._source, *mark, dotted(path), message))

    def _refuse(self, mark: Mark, path: KeyPath, message: str) -> NoReturn:
        self._note(mark, path, message)
        raise InputError(self.problems)

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

    def _node(self, event: Any, path: KeyPath, depth: int) -> Node:
        mark = _mark(event)
        if isinstance(event, yaml.AliasEvent):
            return self._aliased(event, path, depth)
        if event.tag is not None:
            tag = event.tag.replace("tag:yaml.org,2002:", "!!")
            self._note(mark, path, f"explicit tags ({shortened(printable(tag))}) are not allowed")
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

    def _aliased(self, event: Any, path: KeyPath, depth: int) -> Node:
        anchor, mark = event.anchor, _mark(event)
        if anchor not in self._anchors:
            self._refuse(mark, path, f"alias *{anchor} has no anchor before it")
        node = self._anchors[anchor]
        if node is None:
            self._refuse(mark, path, f"alias *{anchor} refers to a value that contains it")
        self._check_depth(depth + node.height, mark)
        return dataclasses.replace(node, mark=mark)

    def _check_depth(self, depth: int, mark: Mark) -> None:
        if depth > MAX_DEPTH:
            self._refuse(mark, (), f"nested too deeply (at most {MAX_DEPTH} levels)")

    def _content(self, event: Any, mark: Mark, path: KeyPath, depth: int) -> Node:
        if isinstance(event, yaml.ScalarEvent):
            plain = not event.style
            value = _resolved(event.value) if plain else event.value
            return Node(value, mark, empty=plain and not event.value)
        self._check_depth(depth + 1, mark)
        if isinstance(event, yaml.SequenceStartEvent):
            items = self._items(path, depth + 1)
            return _collection(items, items, mark, event)
        entries = self._entries(path, depth + 1)
        return _collection(entries, [node for _, node in entries.values()], mark, event)

    def _items(self, path: KeyPath, depth: int) -> list[Node]:
        items: list[Node] = []
        while not isinstance(event := next(self._events), yaml.SequenceEndEvent):
            items.append(self._node(event, (*path, len(items)), depth))
        return items

    def _entries(self, path: KeyPath, depth: int) -> dict[str, tuple[Mark, Node]]:
        entries: dict[str, tuple[Mark, Node]] = {}
        while not isinstance(event := next(self._events), yaml.MappingEndEvent):
            mark = _mark(event)
            key = self._key(event, path, depth)
            below = path if key is None else (*path, key)
            value = self._node(next(self._events), below, depth)
            if key in entries:
                self._note(mark, below, f"duplicate key (first at line {entries[key][0][0]})")
            elif key is not None:
                entries[key] = (mark, value)
        return entries

    def _key(self, event: Any, path: KeyPath, depth: int) -> str | None:
        """Return the text of a key; None, with a problem noted, when it is not plain text."""
        value = self._node(event, path, depth).value
        if isinstance(event, yaml.AliasEvent):
            message = "a key must be text (got an alias)"
        elif isinstance(value, list):
            message = "a key must be text (got a list)"
        elif isinstance(value, dict):
            message = "a key must be text (got a mapping)"
        elif not isinstance(value, str):
            message = f"a key must be text (got {shown(value)}); put it in quotes"
        elif value == "<<" and not event.style:
            message = "merge keys (<<) are not allowed; write the keys out"
        else:
            return value
        self._note(_mark(event), path, message)
        return None


def _collection(
    value: list[Node] | dict[str, tuple[Mark, Node]],
    children: Sequence[Node],
    mark: Mark,
    start: Any,
) -> Node:
    size = 1 + sum(child.size for child in children)
    height = 1 + max((child.height for child in children), default=0)
    return Node(value, mark, size, height, block=not start.flow_style)
