"""Text tables: encoding, separator, decimal sign, and rows as written."""

from __future__ import annotations

import csv
import io
import re
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from pathlib import Path
from typing import Any, BinaryIO

import pandas as pd

from missions.files.errors import InputError, Problem, printable, refused
from missions.files.texts import decoded, read_plain_file
from missions.logs.columns import ColumnMap
from missions.logs.table import MAXIMUM_DROPPED, first_few
from missions.units import SCALES

_SEPARATORS = {"tab": "\t", "comma": ",", "semicolon": ";"}
_NAMES = {"\t": "tabs", ",": "commas", ";": "semicolons", "|": "bars"}
_DECIMAL_COMMA = re.compile(r"\s*[+-]?\d+,\d+(?:[eE][+-]?\d+)?\s*")
# First line that spreadsheets write to name the separator.
_NAMED_SEPARATOR = re.compile(r'"?sep=(.)"?\s*', re.IGNORECASE)
# Signs between thousands: the other decimal sign, or a blank or apostrophe.
_THOUSANDS = {".": (",", "'", " ", "\u00a0", "\u202f"), ",": (".", "'", " ", "\u00a0", "\u202f")}
_CONTROLS = re.compile(r"[\x00-\x08\x0e-\x1f]")
_MOST_BYTES = 100_000_000
# Place of a cell or row in a sheet: r="AB12", r="12". A sheet of 400,000 rows has 25 columns.
_CELL = re.compile(rb"""\br\s{0,9}=\s{0,9}["']([A-Za-z]{0,3})(\d{1,7})["']""")
_LONGEST_CELL = 40
_MOST_CELLS, _MOST_UNPACKED = 10_000_000, 1_000_000_000
_LONGEST_LINE = 100_000  # the module csv takes no field of more than 131072 characters
_IN_UNITS = {*SCALES, "", "iso", "utc", "iso8601"}  # fields of a row that says the units
_LOOKED_AT = 50  # rows that a guess is made from


@dataclass(frozen=True)
class Text:
    """Non-blank lines of a table, their numbers from 1 on, and the form of their numbers."""

    header: list[str]
    line: int
    rows: list[str]
    numbers: list[int]
    form: Mapping[str, Any]
    notes: list[str]

    def frame(self, used: Sequence[str]) -> pd.DataFrame:
        """Return columns of the table as a data frame, numbers where all fields are."""
        if not self.rows:
            raise refused("has a header but no rows")
        # By their places: names of columns that nothing needs may be there twice.
        places = [self.header.index(name) for name in used]
        try:
            table: pd.DataFrame = pd.read_csv(
                io.StringIO("\n".join(self.rows)),
                **self.form,
                header=None,
                usecols=places,
                index_col=False,
                skipinitialspace=True,
                low_memory=False,
            )
        except (pd.errors.ParserError, ValueError) as error:
            raise refused(f"is not a CSV table: {printable(str(error))}") from None
        return table.rename(columns=dict(zip(places, used, strict=True)))


def read_text(source: str, layout: ColumnMap) -> Text:
    """Read a table's text and detect separator, decimal sign and units."""
    if Path(source).suffix.lower() == ".xlsx":
        content, notes = _read_sheet(source)
    else:
        content, encoding = decoded(read_plain_file(source, most_bytes=_MOST_BYTES))
        windows = "the text is not UTF-8: read as that of Windows (code page 1252)"
        notes = [windows] if encoding == "cp1252" else []
        if _CONTROLS.search(content[:_LONGEST_LINE]):
            raise refused("is not a text table: it holds control characters")
    # Only line breaks: str.splitlines would also break at other control characters.
    every = enumerate(content.split("\n"), start=1)
    lines = [(number, line) for number, line in every if line.strip()]
    for number, text in lines:
        if len(text) > _LONGEST_LINE:
            message = f"is longer than {_LONGEST_LINE} characters"
            raise InputError([Problem("", number, None, "", message)])
    named = _NAMED_SEPARATOR.fullmatch(lines[0][1]) if lines else None
    if named is not None:
        del lines[0]
    while lines and lines[0][1].lstrip().startswith("#"):  # remarks above the table
        del lines[0]
    if not lines:
        raise refused("is empty; allowed: a header with the names of the columns")
    line, first = lines[0]
    if first.startswith("FMT,"):
        raise refused("is ArduPilot's log as text: use the .bin that it was made from")
    # Names may hold a comma, hardly ever one of the others.
    guessed = next((sign for sign in "\t;|" if first.count(sign) >= 2), ",")
    separator = named[1] if named else guessed
    if layout.separator is not None:
        separator = _SEPARATORS.get(layout.separator, layout.separator)
    header = [name.strip() for name in next(csv.reader([first], delimiter=separator))]
    kept = _rows_of_width(lines, separator, notes)
    row = kept[0][1].split(separator) if kept else []
    units = [field.strip().strip("[]()").strip() for field in row]
    if all(unit.lower() in _IN_UNITS for unit in units) and any(unit.isalpha() for unit in units):
        del kept[0]
        pairs = zip(header, units, strict=False)
        header = [f"{name} [{unit}]" if unit else name for name, unit in pairs]
        notes.append("units are those of the row below the header")
    numbers, rows = [number for number, _ in kept], [row for _, row in kept]
    # A comma is the decimal sign only where it separates nothing.
    fields = [field for row in rows[:_LOOKED_AT] for field in row.split(separator)]
    comma = separator != "," and any(_DECIMAL_COMMA.fullmatch(field) for field in fields)
    decimal = layout.decimal or ("," if comma else ".")
    if separator != ",":
        sign = "decimal comma" if decimal == "," else "decimal point"
        signs = _NAMES.get(separator, repr(separator))
        notes.insert(0, f"columns are separated by {signs}, numbers have a {sign}")
    thousands = _detect_thousands_sign(rows, separator, decimal)
    if thousands is not None:
        notes.append(f"numbers have {thousands!r} between thousands")
    form = {"sep": separator, "decimal": decimal, "thousands": thousands}
    return Text(header, line, rows, numbers, form, notes)


def _read_sheet(source: str) -> tuple[str, list[str]]:
    """Return the first sheet of an Excel file as text with tabs."""
    content = io.BytesIO(read_plain_file(source, most_bytes=_MOST_BYTES))
    try:
        _check_cells(content)
        sheet = pd.read_excel(content, header=None, dtype=object, engine="calamine")
    except InputError:
        raise
    except ImportError:
        raise refused(
            "reading .xlsx needs the package python-calamine: "
            "pip install 'solar-uav-sizing[excel]', or save it as CSV"
        ) from None
    except Exception as error:  # calamine raises an error of its own for every kind of damage
        raise refused(f"is not an Excel file: {printable(str(error))[:200]}") from None
    text = sheet.to_csv(None, sep="\t", header=False, index=False, lineterminator="\n")
    return text, ["the first sheet is read"]


def _check_cells(content: BinaryIO) -> None:
    """Refuse sheets larger than a log: the reader would fill all between their cells.

    Counts the rectangle around the cells of each part of the file, and its unpacked size.
    """
    with zipfile.ZipFile(content) as book:
        unpacked = 0
        for part in book.namelist():
            last_row = last_column = 1
            rest = b""
            with book.open(part) as xml:
                while block := xml.read(1_000_000):
                    unpacked += len(block)
                    if unpacked > _MOST_UNPACKED:
                        raise refused(f"unpacks to more than {_MOST_UNPACKED // 1_000_000} MB")
                    block = rest + block
                    for letters, row in _CELL.findall(block):
                        last_row = max(last_row, int(row))
                        # A is 1, AA 27.
                        column = reduce(lambda n, letter: 26 * n + (letter & 0x1F), letters, 0)
                        last_column = max(last_column, column)
                    rest = block[-_LONGEST_CELL:]
            if (count := last_row * last_column) > _MOST_CELLS:
                raise refused(
                    f"has cells up to row {last_row} and column {last_column}, {count:,} in all, "
                    f"at most {_MOST_CELLS:,}: delete those far away, or save it as CSV"
                )


def _detect_thousands_sign(rows: Sequence[str], separator: str, decimal: str) -> str | None:
    """Return the sign between thousands if the first rows prove one."""
    parsed = csv.reader(rows[:_LOOKED_AT], delimiter=separator)
    fields = [field.strip() for row in parsed for field in row]
    for sign in _THOUSANDS[decimal]:
        groups, rest = rf"[+-]?\d{{1,3}}(?:{re.escape(sign)}\d{{3}})", re.escape(decimal) + r"\d+"
        # One group alone may be a number with a decimal sign: 1,234.
        sure = rf"{groups}+{rest}|{groups}{{2,}}" if sign in ".," else rf"{groups}+(?:{rest})?"
        if (sign != separator or sign == ",") and any(
            re.fullmatch(sure, field) for field in fields
        ):
            return sign
    return None


def _rows_of_width(
    lines: list[tuple[int, str]], separator: str, notes: list[str]
) -> list[tuple[int, str]]:
    """Keep rows with as many fields as the header; refuse a table where most have not."""

    def width_of(row: str) -> int:
        if '"' in row:
            return len(next(csv.reader([row], delimiter=separator)))
        return row.count(separator) + 1

    expected, *widths = (width_of(line) for _, line in lines)
    rows = list(zip(lines[1:], widths, strict=True))
    odd = [(number, width) for (number, _), width in rows if width != expected]
    if len(odd) > MAXIMUM_DROPPED * len(rows):
        raise InputError(
            Problem("", number, None, "", f"has {width} fields, the header {expected}{rest}")
            for (number, width), rest in first_few(odd)
        )
    if odd:
        count = "1 line is" if len(odd) == 1 else f"{len(odd)} lines are"
        number, width = odd[0]
        notes.append(f"{count} left out: line {number} has {width} fields, the header {expected}")
    return [row for row, width in rows if width == expected]
