"""Flight logs from files: CSV in the format of ``docs/verify.md``, and PX4 ULog by its suffix."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from missions.files.errors import InputError, Problem, file_error, printable, shortened
from missions.files.validation import unknown_key
from missions.logs.px4_ulog import read_ulog
from missions.logs.table import (
    ATTITUDE,
    COLUMNS,
    EPOCH,
    REQUIRED,
    TIME,
    FlightLog,
    first_few,
    log_from_table,
)


def read_flight_log(path: str | os.PathLike[str]) -> FlightLog:
    """Read a log: PX4 ULog by the suffix ``.ulg``, CSV otherwise.

    Raises
    ------
    InputError
        If the file cannot be read or anything in it is wrong.
    """
    if Path(path).suffix.lower() == ".ulg":
        return read_ulog(path)
    return read_csv(path)


def read_csv(path: str | os.PathLike[str]) -> FlightLog:
    """Read a log in the CSV format of ``docs/verify.md``.

    Raises
    ------
    InputError
        With the line of every mistake.
    """
    import pandas as pd

    source = os.fspath(path)
    lines, numbers = _text_lines(source)
    header = _header(lines[0], source) if lines else []
    if not header:
        raise file_error(source, f"is empty; allowed: a header of {', '.join(COLUMNS)}")
    notes = _check_header(header, numbers[0], source)
    if len(lines) == 1:
        raise file_error(source, "has a header but no rows")
    _check_widths(lines, numbers, len(header), source)
    known = [name for name in header if name in COLUMNS]
    try:
        table = pd.read_csv(
            io.StringIO("\n".join(lines[1:])),
            header=None,
            names=header,
            usecols=known,
            index_col=False,
            skipinitialspace=True,
            low_memory=False,
        )
    except (pd.errors.ParserError, ValueError) as error:
        raise file_error(source, f"is not a CSV table: {printable(str(error))}") from None
    return log_from_table(table, source, np.asarray(numbers[1:]), notes)


def _text_lines(source: str) -> tuple[list[str], list[int]]:
    """Lines that are not blank, and their numbers counted from 1."""
    try:
        text = Path(source).read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise file_error(source, f"is not UTF-8 text (byte {error.start})") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise file_error(source, f"cannot be read: {str(reason).lower()}") from None
    # Only line breaks: str.splitlines would also break at other control characters.
    every = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    kept = [(line, number) for number, line in enumerate(every, start=1) if line.strip()]
    return [line for line, _ in kept], [number for _, number in kept]


def _header(line: str, source: str) -> list[str]:
    if "\0" in line:
        raise file_error(source, "is not a CSV table: it holds null characters")
    return [name.strip() for name in next(csv.reader([line]))]


def _check_header(header: Sequence[str], line: int, source: str) -> tuple[str, ...]:
    """Refuse missing, doubled and misspelt columns; return a note on those that are ignored."""
    problems = [
        Problem(source, line, None, name, "column appears more than once")
        for name in dict.fromkeys(header)
        if name and header.count(name) > 1
    ]
    ignored = []
    for name in header:
        if name in COLUMNS:
            continue
        absent = [column for column in COLUMNS if column not in header]
        message = unknown_key(name, absent).replace("unknown key", "unknown column")
        if "did you mean" in message:
            problems.append(Problem(source, line, None, shortened(printable(name)), message))
        else:
            ignored.append(shortened(printable(name)) or "(unnamed)")
    problems += _missing_columns(header, line, source)
    if problems:
        raise InputError(problems)
    return (f"columns not used: {', '.join(ignored)}",) if ignored else ()


def _missing_columns(header: Sequence[str], line: int, source: str) -> list[Problem]:
    missing = [name for name in REQUIRED if name not in header]
    angles = [name for name in ATTITUDE if name in header]
    if angles:
        missing += [name for name in ATTITUDE if name not in header]
    problems = [Problem(source, line, None, name, "required column is missing") for name in missing]
    times = [name for name in (TIME, EPOCH) if name in header]
    if not times:
        message = f"required column is missing; allowed: {TIME} or {EPOCH}"
        problems.append(Problem(source, line, None, TIME, message))
    elif len(times) == 2:
        problems.append(Problem(source, line, None, EPOCH, f"give {TIME} or {EPOCH}, not both"))
    if missing and len(header) == 1 and (";" in header[0] or "\t" in header[0]):
        return [Problem(source, line, None, "", "columns must be separated by commas")]
    return problems


def _check_widths(lines: Sequence[str], numbers: Sequence[int], expected: int, source: str) -> None:
    """Refuse rows with more or fewer fields than the header."""
    wrong = [
        (number, len(next(csv.reader([line]))) if '"' in line else line.count(",") + 1)
        for line, number in zip(lines[1:], numbers[1:], strict=True)
        if line.count(",") + 1 != expected
    ]
    wrong = [(number, width) for number, width in wrong if width != expected]
    if wrong:
        raise InputError(
            Problem(source, number, None, "", f"has {width} fields, the header {expected}{rest}")
            for (number, width), rest in first_few(wrong)
        )
