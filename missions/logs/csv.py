"""Flight logs from text tables, and from files of autopilots by their suffix."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

import numpy as np
import pandas as pd

from missions.files.errors import (
    InputError,
    Problem,
    did_you_mean,
    in_file,
    printable,
    refused,
    shortened,
)
from missions.files.validation import alike_key
from missions.logs.autopilots import read_dataflash, read_ulog
from missions.logs.clock import times_from_numbers, times_from_text
from missions.logs.columns import ColumnMap, Recipe, Recipes, recipes_for
from missions.logs.delimited import Text, read_text
from missions.logs.table import COLUMNS, REQUIRED, Check, FlightLog, checked_log, numbers
from missions.logs.units import (
    ATTITUDE,
    EPOCH,
    MPPT,
    QUANTITIES,
    TIME,
    in_radians,
    recognised,
    surely_radians,
)
from missions.units import SPELLED

_RADIANS = "roll, pitch and yaw read as radians: the yaw turns within 2 pi and none exceeds it"


def read_flight_log(path: str | os.PathLike[str], columns: ColumnMap | None = None) -> FlightLog:
    """Read a log: PX4 ULog (``.ulg``), DataFlash of ArduPilot (``.bin``), else a text table.

    Parameters
    ----------
    path : path
        The file.
    columns : ColumnMap, optional
        Quantities of the columns; guessed for quantities that it does not name.

    Returns
    -------
    FlightLog

    Raises
    ------
    InputError
        If the file cannot be read or anything in it is wrong.
    """
    readers = {".ulg": read_ulog, ".bin": read_dataflash}
    with in_file(os.fspath(path)):
        return readers.get(Path(path).suffix.lower(), read_csv)(path, columns)


def read_csv(path: str | os.PathLike[str], columns: ColumnMap | None = None) -> FlightLog:
    """Read a log from a text table such as ``docs/verify.md`` describes."""
    source = os.fspath(path)
    layout = columns or ColumnMap()
    text = read_text(source, layout)
    recipes = recipes_for(text.header, layout)
    matched = recipes.by_quantity
    used = {name for recipe in matched.values() for name in recipe.columns}
    # Dates in a column, times of day in another.
    free = [name for name in text.header if name not in used.union(layout.ignore)]
    date = next((name for name in free if name.lower() in ("date", "date_utc")), None)
    notes = [*text.notes, *_check_header(text, recipes, date)]
    for name in layout.ignore:
        if name not in text.header and name not in QUANTITIES:
            alike = did_you_mean(name, [*text.header, *QUANTITIES])
            notes.append(f"nothing is called {shortened(printable(name))}, to ignore it{alike}")
    frame = text.frame([name for name in text.header if name in used or name == date])
    check = Check(source, np.asarray(text.numbers))
    made = [_read_time(text, layout, frame, date, matched["time"], check)]
    for quantity, recipe in matched.items():
        if quantity != "time":
            made += _read_quantity(frame, recipe, check)
            parts = (" * ".join(factor.column for factor in term) for term in recipe.terms)
            check.labels[quantity] = " + ".join(parts) or quantity
    check.done()
    table = pd.DataFrame({str(column.name): column for column in made})
    attitude = [matched[name] for name in ATTITUDE if name in matched]
    if len(attitude) == len(ATTITUDE) and all(
        r.value is None and r.unit in (None, "deg") for r in attitude
    ):
        named = all(r.unit is None and not r.plain for r in attitude)
        with suppress(ValueError):  # said with its line where the table is checked
            angles = [np.asarray(table[name], float) for name in ATTITUDE]
            if (in_radians if named else surely_radians)(*angles):
                for name, values in zip(ATTITUDE, angles, strict=True):
                    table[name] = np.degrees(values)
                check.notes.append(_RADIANS)
    guessed = [recipe.text() for recipe in matched.values() if recipe.guessed]
    if guessed:
        check.notes.insert(0, f"guessed: {', '.join(guessed)}")
    check.notes += notes
    return checked_log(table, check, layout.exclude, layout.timezone)


def _check_header(text: Text, recipes: Recipes, date: str | None) -> list[str]:
    """Refuse missing, doubled and misspelt columns; return notes on unused columns."""
    header, line = text.header, text.line
    problems = [Problem("", line, None, "", message) for message in recipes.problems]

    def complain(name: str, message: str) -> None:
        problems.append(Problem("", line, None, shortened(printable(name)), message))

    for name in dict.fromkeys(
        name for recipe in recipes.by_quantity.values() for name in recipe.columns
    ):
        if header.count(name) > 1:
            complain(name, "column appears more than once: which one is meant?")
    absent = [name for name in COLUMNS if name not in (*recipes.by_quantity, *header)]
    ignored = []
    for name in recipes.unused:
        if name == date:
            continue
        meant = alike_key(name, absent)
        shown = shortened(printable(name)) or "(unnamed)"
        ignored.append(f"{shown} (did you mean '{meant}'?)" if meant else shown)
    missing = [name for name in REQUIRED if name not in recipes.by_quantity]
    if any(name in recipes.by_quantity for name in ATTITUDE):
        missing += [name for name in ATTITUDE if name not in recipes.by_quantity]
    for name in missing:
        alike = alike_key(name, recipes.unused)
        hint = f"; is it '{alike}'?" if alike else ""
        complain(name, f"required column is missing{hint}")
    if "time" not in recipes.by_quantity:
        complain(TIME, f"required column is missing; allowed: {TIME} or {EPOCH}")
    elif TIME in header and EPOCH in header and TIME in recipes.by_quantity["time"].columns:
        complain(EPOCH, f"give {TIME} or {EPOCH}, not both")
    if any(name in REQUIRED for name in missing) or "time" not in recipes.by_quantity:
        names = ", ".join(shortened(printable(name)) for name in header[:20])
        complain("", f"has the columns {names}; say with --columns or --column what they are")
    if problems:
        raise InputError(problems)
    return [f"columns not used: {', '.join(ignored)}"] if ignored else []


def _read_time(
    text: Text,
    layout: ColumnMap,
    frame: pd.DataFrame,
    date: str | None,
    recipe: Recipe,
    check: Check,
) -> pd.Series:
    """Read the column of time: text in the form of the log format, or seconds since 1970."""
    if recipe.value is not None or not recipe.single:
        raise refused("columns.time: needs the name of one column")
    name = recipe.columns[0]
    column = frame[name]
    check.labels |= dict.fromkeys((TIME, EPOCH), shortened(printable(name)))
    as_numbers = pd.to_numeric(column, errors="coerce").notna().sum() > 0.5 * column.notna().sum()
    if as_numbers and date is None and recipe.form is None:
        values = numbers(column, check)
        unit = "s" if name == EPOCH else recipe.unit
        try:
            time_s, note = times_from_numbers(values, unit, layout.start, printable(name))
        except ValueError as error:
            problem = Problem("", text.line, None, printable(name), str(error))
            raise InputError([problem]) from None
        check.notes += [note] if note else []
        return pd.Series(time_s, name=EPOCH)
    written = column.astype("string")
    if layout.start is not None:
        check.notes.append("the given start is not used: the log has times of its own")
    if date is not None:
        written = frame[date].astype("string").str.strip() + " " + written.str.strip()
        check.notes.append(f"{printable(date)} and {printable(name)} read as date and time")
    if recipe.form is None:
        return written.rename(TIME)
    time_s, wrong_rows, _ = times_from_text(written, layout.timezone, recipe.form)
    for wrong in wrong_rows.values():
        why = f"is not of the form {recipe.form!r} or its zone"
        check.complain(written.rename(TIME), wrong, why)
    return pd.Series(time_s, name=EPOCH)


def _read_quantity(frame: pd.DataFrame, recipe: Recipe, check: Check) -> list[pd.Series]:
    """Read a quantity in the unit of the log format, and the power of each of several MPPTs."""
    quantity = recipe.quantity
    if recipe.value is not None:
        return [pd.Series(np.full(len(frame), recipe.value), name=quantity)]
    if recipe.plain:
        return [frame[quantity]]
    parts = {name: numbers(frame[name], check) for name in recipe.columns}
    unit = None
    if recipe.single and recipe.unit is None:
        dimension = QUANTITIES[quantity].dimension
        unit = recognised(quantity, dimension, next(iter(parts.values())))
        if unit is not None:
            name = printable(recipe.columns[0])
            check.notes.append(f"{name} read as {SPELLED[unit]}: so its size says")
    every = recipe.values(parts.__getitem__, unit)
    check.labels |= {name: name.removeprefix(MPPT) for name in every}
    return [pd.Series(values, name=name) for name, values in every.items()]
