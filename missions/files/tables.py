"""Tables of numbers in text files: keys in comment lines, names of columns, rows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from missions.files.errors import Problem, shown
from solar.schema import Allowed, refusal
from solar.types import FloatArray


class TextTable(NamedTuple):
    """Table with the lines of its parts, counted from 1; names and keys are in lower case.

    ``header``, ``lines``: values and lines of comments ``# key: value``. ``line``: that of the
    names, None without. ``separator``: of the fields, a comma, or None for blanks.
    """

    header: dict[str, str]
    lines: dict[str, int]
    line: int | None
    names: list[str]
    separator: str | None
    rows: list[tuple[int, str]]


def text_table(text: str) -> TextTable:
    """Split a text into comments, names and rows."""
    lines = [(number, line.strip()) for number, line in enumerate(text.split("\n"), start=1)]
    header, places = {}, {}
    for number, line in lines:
        key, colon, value = line.lstrip("# \t").partition(":")
        if line.startswith("#") and colon:
            name = key.strip().lower()
            header[name], places[name] = value.strip(), number
    content = [(number, line) for number, line in lines if line and not line.startswith("#")]
    at, first = content[0] if content else (None, "")
    separator = "," if "," in first else None
    names = [name.strip().lower() for name in first.split(separator)]
    return TextTable(header, places, at, names, separator, content[1:])


def number_rows(
    table: TextTable, allowed: Mapping[str, Allowed], source: str
) -> tuple[FloatArray, list[int], list[Problem]]:
    """Return the rows of allowed numbers with their lines, and the problems of all others."""
    ranges = [allowed[name] for name in table.names]
    lines = [row for _, row in table.rows]
    if not lines:
        return np.empty((0, len(ranges))), [], []
    try:  # fast; other text is read again row by row, to name the places
        every = np.loadtxt(lines, delimiter=table.separator, ndmin=2, comments=None)
    except ValueError:
        every = np.empty((0, 0))
    if every.shape == (len(table.rows), len(ranges)) and all(
        held.holds(column).all() for held, column in zip(ranges, every.T, strict=True)
    ):
        return every, [line for line, _ in table.rows], []
    values, places, problems = [], [], []
    for line, row in table.rows:
        parts = row.split(table.separator)
        numbers = list(map(number_of, parts))
        odd = [
            i for i, (held, x) in enumerate(zip(ranges, numbers, strict=False)) if not held.holds(x)
        ]
        if len(parts) != len(ranges):
            text = f"has {len(parts)} values, but the table names {len(ranges)} columns"
            problems.append(Problem(source, line, None, "", text))
        elif odd:
            text = refusal(
                f"must be a number {ranges[odd[0]]}".rstrip(), shown(parts[odd[0]].strip())
            )
            problems.append(Problem(source, line, None, table.names[odd[0]], text))
        else:
            values.append(numbers)
            places.append(line)
    return np.array(values).reshape(-1, len(ranges)), places, problems


def number_of(text: str) -> float:
    """Return the number of a text; NaN if it is none or not finite."""
    try:
        value = float(text)
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan
