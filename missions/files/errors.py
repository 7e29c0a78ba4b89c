"""Mistakes of the user with their places, and the spelling of keys and values in messages."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from difflib import get_close_matches
from typing import TypeAlias

KeyPath: TypeAlias = tuple[str | int, ...]

OVERRIDE = "--set "  # begins the source of a problem of a value given on the command line

_SHOWN_LENGTH = 40
_SPECIAL_FLOATS = {"inf": ".inf", "-inf": "-.inf", "nan": ".nan"}


@dataclass(frozen=True)
class Problem:
    """Mistake of the user and its place.

    ``source``: file name, or ``--set KEY`` for a value of the command line. ``line``, ``column``:
    place in the file, counted from 1; None if unknown. ``key``: dotted path of the key, empty for
    the whole file.
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
        # An override that names the key, with or without a prefix, need not name it twice.
        named = self.source.removeprefix(OVERRIDE) if self.source.startswith(OVERRIDE) else ""
        if self.key and named != self.key and not named.endswith("." + self.key):
            parts.append(self.key)
        return ": ".join([*parts, self.message])


def left_out_note(rows: Sequence[Problem]) -> tuple[str, ...]:
    """Return a note on left-out rows with the first of them, empty without."""
    if not rows:
        return ()
    count = "1 row is" if len(rows) == 1 else f"{len(rows)} rows are"
    return (f"{count} left out: {rows[0]}",)


class InputError(ValueError):
    """Mistakes of the user in a file or an override; ``problems`` holds them sorted by line."""

    problems: tuple[Problem, ...]

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = tuple(sorted(problems, key=_order))
        super().__init__(self.problems)

    def __str__(self) -> str:
        """Return one problem per line."""
        return "\n".join(str(problem) for problem in self.problems)


def file_error(source: str, message: str) -> InputError:
    """Return an error that concerns a whole file."""
    return InputError([Problem(source, None, None, "", message)])


def refused(message: str, *, line: int = 0, key: str = "", rows: int = 1) -> InputError:
    """Return an error of a file that :func:`in_file` names, at the first of some rows.

    ``line``: counted from 1, 0 if unknown.
    """
    more = f" (and {rows - 1} more rows)" if rows > 1 else ""
    return InputError([Problem("", int(line) or None, None, key, message + more)])


@contextmanager
def in_file(source: str) -> Iterator[None]:
    """Name the file of mistakes that are raised without one."""
    try:
        yield
    except InputError as error:
        named = [replace(p, source=p.source or source) for p in error.problems]
        raise InputError(named) from error


def _order(problem: Problem) -> tuple[float, float]:
    """Sort by place; problems of overrides have no line and come last."""
    if problem.line is None:
        return (float("inf"), 0) if problem.source.startswith(OVERRIDE) else (0, 0)
    return (problem.line, problem.column or 0)


def printable(text: str) -> str:
    """Escape characters that would break a one-line message or steer a terminal."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def shortened(text: str) -> str:
    """Cut a text to the length that messages show."""
    return text if len(text) <= _SHOWN_LENGTH else text[: _SHOWN_LENGTH - 3] + "..."


def did_you_mean(name: str, allowed: Iterable[str], count: int = 1, cutoff: float = 0.6) -> str:
    """Return the end of a sentence that suggests names spelled alike."""
    alike = get_close_matches(name, list(allowed), n=count, cutoff=cutoff)
    names = ", ".join(alike) if count > 1 else "".join(map(repr, alike))
    return f"; did you mean {names}?" if alike else ""


def dotted(path: Iterable[str | int]) -> str:
    """Spell the path of a key."""
    return ".".join(shortened(printable(str(part))) for part in path)


def shown(value: object) -> str:
    """Spell a value as in a file, shortened."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        text = float.__repr__(value)
        return _SPECIAL_FLOATS.get(text, text)
    if isinstance(value, Mapping):
        return "a mapping"
    if isinstance(value, list | tuple):
        return f"a list of {len(value)}"
    return shortened(repr(value))
