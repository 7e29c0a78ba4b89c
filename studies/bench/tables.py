"""CSV files of bench tests: columns, templates, and reading with every mistake by its line."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from missions.files.errors import (
    InputError,
    Problem,
    did_you_mean,
    file_error,
    printable,
    shown,
)
from missions.files.texts import read_plain_file
from solar.types import FloatArray

_MOST_PROBLEMS, _MOST_BYTES = 10, 5_000_000


class Quantity(NamedTuple):
    """Column of a test: its name, what it is, and the least and the largest value."""

    name: str
    meaning: str
    lowest: float
    highest: float
    optional: bool = False


@dataclass(frozen=True)
class Layout:
    """Columns of a kind of test, and rows of an example."""

    name: str
    title: str
    columns: tuple[Quantity, ...]
    example: tuple[tuple[float, ...], ...]

    def template(self) -> str:
        """Text of a CSV file to fill in."""
        lines = [f"# {self.title}"]
        for one in self.columns:
            optional = ", optional" if one.optional else ""
            lines.append(
                f"# {one.name}: {one.meaning}, {one.lowest:g} to {one.highest:g}{optional}"
            )
        lines.append("# The rows are an example: replace them by your own.")
        lines.append(",".join(one.name for one in self.columns))
        lines += [",".join(f"{value:g}" for value in row) for row in self.example]
        return "\n".join(lines) + "\n"


@dataclass(frozen=True)
class BenchTable:
    """Rows of a test: columns by name, and the line of each row."""

    source: str
    layout: Layout
    values: Mapping[str, FloatArray]
    lines: tuple[int, ...]

    def __getitem__(self, name: str) -> FloatArray:
        """Column by its name."""
        return self.values[name]

    def refused(self, message: str) -> InputError:
        """Error of the whole test."""
        return file_error(self.source, message)


def read_bench(path: str, layouts: Mapping[str, Layout]) -> BenchTable:
    """Read the CSV file of a test; its columns say which kind it is."""
    source = printable(path)
    try:
        text = read_plain_file(path, most_bytes=_MOST_BYTES).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise file_error(source, f"is not UTF-8 text (byte {error.start})") from None
    numbered = [
        (number, line)
        for number, line in enumerate(io.StringIO(text), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not numbered:
        raise file_error(source, "is empty; allowed: a header with the names of the columns")
    rows = [next(csv.reader([line])) for _, line in numbered]
    header, lines = (
        [name.strip().lower() for name in rows[0]],
        [number for number, _ in numbered[1:]],
    )
    layout = _layout(source, numbered[0][0], header, layouts)
    if not lines:
        raise file_error(source, "has no rows below its header")
    problems: list[Problem] = []
    values: dict[str, list[float]] = {name: [] for name in header}
    for number, row in zip(lines, rows[1:], strict=True):
        if len(row) != len(header):
            message = f"has {len(row)} values (allowed: {len(header)}, one for each column)"
            problems.append(Problem(source, number, None, "", message))
            continue
        for name, cell in zip(header, row, strict=True):
            found = _value(cell, next(one for one in layout.columns if one.name == name))
            if isinstance(found, str):
                problems.append(Problem(source, number, None, name, found))
            else:
                values[name].append(found)
    if problems:
        raise InputError(problems[:_MOST_PROBLEMS])
    arrays = {name: np.array(column) for name, column in values.items()}
    return BenchTable(source, layout, arrays, tuple(lines))


def _layout(source: str, line: int, header: list[str], layouts: Mapping[str, Layout]) -> Layout:
    """Kind of test with most of these columns; it must have all that are not optional."""
    layout = max(layouts.values(), key=lambda one: len({c.name for c in one.columns} & {*header}))
    allowed = [one.name for one in layout.columns]
    problems: list[Problem] = []
    if not {*header} & {*allowed}:
        known = ", ".join(layouts)
        message = f"are the columns of no test; allowed: those of bench --template ({known})"
        first = shown(",".join(header))
        raise InputError([Problem(source, line, None, first, f"{message}, commas between them")])
    for name in header:
        if name not in allowed:
            known = ", ".join(allowed)
            hint = did_you_mean(name, allowed)
            message = f"is no column of {layout.name}{hint} (allowed: {known})"
            problems.append(Problem(source, line, None, name or "column", message))
        elif header.count(name) > 1:
            problems.append(Problem(source, line, None, name, "there is more than one such column"))
    missing = [one.name for one in layout.columns if not one.optional and one.name not in header]
    for name in () if problems else missing:  # one of another name is likely it
        problems.append(Problem(source, line, None, name, f"{layout.name} needs this column"))
    if problems:
        raise InputError(list(dict.fromkeys(problems)))
    return layout


def _value(cell: str, column: Quantity) -> float | str:
    """Number of a cell, or what is wrong with it."""
    allowed = f"a number from {column.lowest:g} to {column.highest:g}"
    try:
        value = float(cell)
    except ValueError:
        return f"must be {allowed} (got {shown(cell.strip())})"
    if not math.isfinite(value) or not column.lowest <= value <= column.highest:
        return f"must be {allowed} (got {value:g})"
    return value
