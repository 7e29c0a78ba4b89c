"""Logs of flights: read, and checked before anything is computed from them.

Nothing is repaired: values that cannot be are left out and told, and with them rows that then lack
a required value; gaps split the log and are never interpolated over. A needed column most of which
cannot be is an error that names its lines. Rows out of order are sorted, and columns that are
written at times of their own are put together by the nearest value; both are told. Angles are
degrees in files and radians in :class:`FlightLog`.
"""

from __future__ import annotations

import datetime
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from missions.files.errors import InputError, Problem, file_error, shown
from missions.logs.clock import Span, times_from_text
from missions.logs.nearest import Series, age_s_of, sampled
from missions.logs.plausible import (
    Kind,
    LeftOut,
    codes,
    leave_out_held,
    left_out,
    no_place,
    without_spans,
)
from missions.logs.quantities import ATTITUDE, EPOCH, QUANTITIES, TIME, TRACKER, quantity_of
from solar.types import BoolArray, FloatArray, IntArray

REQUIRED = ("latitude_deg", "longitude_deg", "altitude_m", "solar_power_w")
OPTIONAL = (
    "ambient_temperature_c",
    "mppt_voltage_v",
    "load_w",
    "state_of_charge",
    "airspeed_m_per_s",
    "battery_power_w",
)
COLUMNS = (TIME, EPOCH, *REQUIRED, *ATTITUDE, *OPTIONAL)

# A step longer than this many median steps is a gap: a logger that skips a few samples is not.
GAP_STEPS = 5.0
MAXIMUM_DROPPED = 0.5
_SHOWN_PROBLEMS = 3
_YEAR_S = 365.25 * 86400.0  # no flight is as long

_HINTS = {"state_of_charge": "; it is a share, not a percentage"}


class EulerAngles(NamedTuple):
    """Roll, pitch and yaw of the sequence 3-2-1 [rad]."""

    roll_rad: FloatArray
    pitch_rad: FloatArray
    yaw_rad: FloatArray


class Gap(NamedTuple):
    """Stretch without samples: times of the samples before and after it [s since 1970, UTC]."""

    start_s: float
    end_s: float

    @property
    def duration_s(self) -> float:
        """Length of the gap [s]."""
        return self.end_s - self.start_s


@dataclass(frozen=True)
class FlightLog:
    """Samples of a flight, times strictly increasing; optional quantities are None or hold NaN.

    Attributes
    ----------
    source : str
        File name.
    time_s : ndarray
        Universal time [s since 1970-01-01].
    latitude_deg, longitude_deg, altitude_m : ndarray
        Position; altitude above mean sea level.
    solar_power_w : ndarray
        Power behind the MPPTs [W].
    attitude : EulerAngles or None
        Attitude, none if the log has none.
    ambient_temperature_c, mppt_voltage_v, load_w, state_of_charge : ndarray or None
        What else was logged.
    airspeed_m_per_s, battery_power_w : ndarray or None
        True airspeed; power into the battery, negative where it is discharged.
    rows_read, rows_dropped : int
        Rows of the file, and those left out because a required value was missing.
    gaps : tuple of Gap
        Stretches without samples.
    notes : tuple of str
        What the reader of the results should know.
    left_out : tuple of LeftOut
        Values that cannot be, and rows that were excluded.
    tracker_power_w : mapping
        Power behind each MPPT [W] by its name, where ``solar_power_w`` is their sum.
    """

    source: str
    time_s: FloatArray
    latitude_deg: FloatArray
    longitude_deg: FloatArray
    altitude_m: FloatArray
    solar_power_w: FloatArray
    attitude: EulerAngles | None
    ambient_temperature_c: FloatArray | None
    mppt_voltage_v: FloatArray | None
    load_w: FloatArray | None
    state_of_charge: FloatArray | None
    rows_read: int
    rows_dropped: int
    gaps: tuple[Gap, ...]
    notes: tuple[str, ...]
    airspeed_m_per_s: FloatArray | None = None
    battery_power_w: FloatArray | None = None
    left_out: tuple[LeftOut, ...] = ()
    tracker_power_w: Mapping[str, FloatArray] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.time_s)

    @property
    def step_s(self) -> float:
        """Median step of time [s]."""
        return float(np.median(np.diff(self.time_s)))

    def segment(self) -> IntArray:
        """Number of the uninterrupted stretch that each sample belongs to."""
        ends = np.array([gap.end_s for gap in self.gaps])
        return np.searchsorted(ends, self.time_s, side="right").astype(int)


def first_few(items: Sequence[Any]) -> list[tuple[Any, str]]:
    """First few items, the last of them with the number of those not shown."""
    more = len(items) - _SHOWN_PROBLEMS
    tails = [""] * (_SHOWN_PROBLEMS - 1) + [f" (and {more} more rows)" if more > 0 else ""]
    return list(zip(items, tails, strict=False))


def log_from_table(
    table: pd.DataFrame, source: str, notes: Iterable[str] = (), exclude: Sequence[Span] = ()
) -> FlightLog:
    """Log of a table with the columns of the CSV format, without some times of day."""
    return checked_log(table, Check(source, np.arange(2, len(table) + 2)), list(notes), exclude)


def checked_log(
    table: pd.DataFrame,
    check: Check,
    notes: Sequence[str],
    exclude: Sequence[Span],
    zone: datetime.tzinfo | None = None,
) -> FlightLog:
    """Log of a table that is being read; ``zone``: of spans, and of times without one."""
    remarks = list(notes)
    if TIME in table:
        time_s = _times(table[TIME], zone, check, remarks)
    else:
        time_s = numbers(table[EPOCH], check, "time")
    names = [name for name in (*REQUIRED, *ATTITUDE, *OPTIONAL) if name in table]
    names += [name for name in map(str, table) if name.startswith(TRACKER)]
    values = {name: numbers(table[name], check, quantity_of(name)) for name in names}
    nowhere = no_place(values["latitude_deg"], values["longitude_deg"])
    for name in ("latitude_deg", "longitude_deg"):
        values[name] = check.without(values[name], nowhere, table[name], "code")
    check.done()
    left = [left_out(*doubt[:3], time_s, doubt[3]) for doubt in check.doubts]
    empty = [n for n in ATTITUDE if n not in values or np.isnan(values[n]).all()]
    if empty:
        angles = [values.pop(name, None) for name in ATTITUDE]
        if len(empty) < len(angles):
            remarks.append(f"the attitude is not used: {', '.join(empty)} not logged")
    time_s, values = _in_order(time_s, values, remarks)
    time_s, values = without_spans(time_s, values, exclude, zone, left)
    _leave_out_sums(values)
    left += leave_out_held(time_s, values, check.labels)
    _leave_out_sums(values)
    remarks += [one.told() for one in left]
    time_s, values = _put_together(time_s, values, remarks)
    keep = _complete(time_s, values, check.source, left)
    time_s, values = time_s[keep], {n: v[keep] for n, v in values.items()}
    return _assembled(check.source, time_s, values, int((~keep).sum()), remarks, tuple(left))


def _leave_out_sums(values: dict[str, FloatArray]) -> None:
    """Leave out the solar power where that of one of its MPPTs is not known."""
    for name in values:
        if name.startswith(TRACKER):
            whole = values["solar_power_w"]
            values["solar_power_w"] = np.where(np.isnan(values[name]), np.nan, whole)


def _in_order(
    time_s: FloatArray, values: dict[str, FloatArray], notes: list[str]
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Rows by their time; of those with the same time and all quantities the first."""
    back = int(np.count_nonzero(np.diff(time_s) < 0.0))
    if back:
        order = np.argsort(time_s, kind="stable")
        time_s, values = time_s[order], {n: v[order] for n, v in values.items()}
        times = "once" if back == 1 else f"{back} times"
        notes.append(f"time goes back {times}: the rows are sorted")
    filled = ~np.any([np.isnan(v) for n, v in values.items() if n in REQUIRED], axis=0)
    at = np.flatnonzero(filled)
    twice = at[1:][np.diff(time_s[at]) == 0.0]
    if len(twice):
        keep = np.ones(len(time_s), bool)
        keep[twice] = False
        time_s, values = time_s[keep], {n: v[keep] for n, v in values.items()}
        rows = "1 row has" if len(twice) == 1 else f"{len(twice)} rows have"
        notes.append(f"{rows} the time of another: the first one is used")
    return time_s, values


def _put_together(
    time_s: FloatArray, values: dict[str, FloatArray], notes: list[str]
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Columns that are written at times of their own, at the times of the solar power."""
    needed = [name for name in (*REQUIRED, *ATTITUDE) if name in values]
    lacking = np.any([np.isnan(values[name]) for name in needed], axis=0)
    power = ~np.isnan(values["solar_power_w"]) & np.isfinite(time_s)
    alone = np.count_nonzero(lacking & power)
    if np.count_nonzero(lacking) <= MAXIMUM_DROPPED * len(time_s) or 2 * alone <= power.sum():
        return time_s, values
    at_s, together = time_s[power], {}
    for name, column in values.items():
        known = ~np.isnan(column) & np.isfinite(time_s)
        together[name] = sampled(Series(time_s[known], column[known]), at_s, age_s_of(name))
    ages = sorted({age_s_of(name) for name in values})
    notes.append(
        "columns are written at times of their own: for each value of the solar power the nearest "
        f"one of the others is used, {', '.join(f'{age:g}' for age in ages)} s away at most"
    )
    rises = np.concatenate(([True], np.diff(at_s) > 0.0))
    return at_s[rises], {name: column[rises] for name, column in together.items()}


@dataclass
class Check:
    """What is being read, mistakes so far, and ``doubts``: column, why, rows, one of the values."""

    source: str
    lines: IntArray
    labels: dict[str, str] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    doubts: list[tuple[str, Kind, BoolArray, str]] = field(default_factory=list)

    def complain(self, column: pd.Series, wrong: NDArray[Any], message: str) -> None:
        """Note the first few rows in which a column is wrong."""
        label = self.label(column)
        for row, rest in first_few(np.flatnonzero(wrong).tolist()):
            text = f"{message} (got {_cell(column.iloc[row])}){rest}"
            self.problems.append(Problem(self.source, int(self.lines[row]), None, label, text))

    def label(self, column: pd.Series) -> str:
        """Name of a column in the file."""
        return self.labels.get(str(column.name), str(column.name))

    def without(
        self, values: FloatArray, wrong: BoolArray, column: pd.Series, kind: Kind, message: str = ""
    ) -> FloatArray:
        """Values without those that are wrong; most of a column that is needed may not be."""
        if not wrong.any():
            return values
        given = column.notna().to_numpy(bool)
        if message and wrong.sum() > MAXIMUM_DROPPED * given.sum():
            if column.name not in OPTIONAL:
                self.complain(column, wrong, message)
                return np.where(wrong, np.nan, values)
            wrong = given  # the rest is right by chance
        row = int(np.argmax(wrong))
        value = f"{values[row]:g}" if np.isfinite(values[row]) else _cell(column.iloc[row])
        example = f"{value} in line {self.lines[row]}"
        if kind == "outside":
            example += f", {message}"
        self.doubts.append((self.label(column), kind, wrong, example))
        return np.where(wrong, np.nan, values)

    def done(self) -> None:
        """Raise what was noted."""
        if self.problems:
            raise InputError(self.problems)


def _times(
    column: pd.Series, zone: datetime.tzinfo | None, check: Check, notes: list[str]
) -> FloatArray:
    times = times_from_text(column, zone)
    notes.extend(times.notes)
    messages = {
        "form": "must be ISO 8601 like 2015-07-01T05:30:00Z",
        "zone": "has no time zone; write UTC like 2015-07-01T05:30:00Z or +02:00, or give "
        "--timezone",
        "hour": "does not exist, or comes twice, in this time zone: the clocks were changed",
    }
    for kind, wrong in times.wrong.items():
        check.without(times.time_s, wrong, column, "no_number", messages[kind])
    return _of_flight(times.time_s, column, check)


def _of_flight(time_s: FloatArray, column: pd.Series, check: Check) -> FloatArray:
    """Times without those that no flight has: before clocks are set, and a year from the others."""
    limits = QUANTITIES["time"]
    wrong = (time_s < limits.low) | (time_s > limits.high)
    time_s = check.without(time_s, wrong, column, "outside", "must be from 1950 to 2049")
    if not np.isfinite(time_s).any():
        return time_s
    far = np.abs(time_s - np.nanmedian(time_s)) > _YEAR_S
    return check.without(time_s, far, column, "outside", "a year or more from the others")


def numbers(column: pd.Series, check: Check, quantity: str | None = None) -> FloatArray:
    """Column as numbers, NaN where empty or, for a known quantity, what that cannot be."""
    if pd.api.types.is_bool_dtype(column):
        column = column.astype("string")
    values = np.asarray(pd.to_numeric(column, errors="coerce").to_numpy(float, na_value=np.nan))
    wrong = np.isnan(values) & column.notna().to_numpy(bool)
    values = check.without(values, wrong, column, "no_number", "must be a number")
    values = check.without(values, np.isinf(values), column, "no_number", "must be finite")
    if quantity is None:
        return values
    if quantity == "time":
        return _of_flight(values, column, check)
    dimension, low, high = QUANTITIES[quantity][:3]
    message = f"must be from {low:g} to {high:g}{_HINTS.get(quantity, '')}"
    values = check.without(values, (values < low) | (values > high), column, "outside", message)
    marked = codes(dimension, values)
    return check.without(values, marked, column, "code")


def _cell(value: object) -> str:
    return shown(value.item() if isinstance(value, np.generic) else value)


def _complete(
    time_s: FloatArray, values: dict[str, FloatArray], source: str, left: Sequence[LeftOut]
) -> BoolArray:
    """Rows in which nothing required is missing."""
    required = {TIME: time_s} | {n: values[n] for n in (*REQUIRED, *ATTITUDE) if n in values}
    lacking = {name: np.isnan(v) for name, v in required.items()}
    drop = np.any(list(lacking.values()), axis=0)
    total, dropped = len(time_s), int(drop.sum())
    why = "".join(f"; {one.told()}" for one in left)
    if dropped > MAXIMUM_DROPPED * total:
        counts = ", ".join(
            f"{name} in {lacks.sum()}" for name, lacks in lacking.items() if lacks.any()
        )
        message = f"{dropped} of {total} rows lack a required value ({counts})"
        raise file_error(source, f"{message}; allowed: at most {MAXIMUM_DROPPED:.0%}{why}")
    if total - dropped < 2:
        raise file_error(source, f"has fewer than two complete rows{why}")
    return np.asarray(~drop)


def _assembled(
    source: str,
    time_s: FloatArray,
    values: dict[str, FloatArray],
    dropped: int,
    notes: Iterable[str],
    left: tuple[LeftOut, ...],
) -> FlightLog:
    step = np.diff(time_s)
    after = np.flatnonzero(step > GAP_STEPS * np.median(step))
    gaps = tuple(Gap(float(time_s[i]), float(time_s[i + 1])) for i in after)
    attitude = None
    if "roll_deg" in values:
        attitude = EulerAngles(*(np.radians(values[name]) for name in ATTITUDE))
    known = {name: v for name, v in values.items() if not np.isnan(v).all()}
    optional: dict[str, Any] = {name: known.get(name) for name in OPTIONAL}
    total = len(time_s) + dropped
    remarks = [*notes, *_remarks(values, dropped, total, gaps)]
    return FlightLog(
        source=source,
        time_s=time_s,
        attitude=attitude,
        rows_read=total,
        rows_dropped=dropped,
        gaps=gaps,
        notes=tuple(remarks),
        left_out=left,
        tracker_power_w={
            name.removeprefix(TRACKER): v for name, v in values.items() if name.startswith(TRACKER)
        },
        **{name: values[name] for name in REQUIRED},
        **optional,
    )


def _remarks(
    values: dict[str, FloatArray], dropped: int, total: int, gaps: Sequence[Gap]
) -> list[str]:
    notes = []
    if dropped:
        notes.append(f"{dropped} of {total} rows left out: a required value is missing")
    if gaps:
        longest = max(gap.duration_s for gap in gaps)
        plural = "gap splits" if len(gaps) == 1 else "gaps split"
        notes.append(f"{len(gaps)} {plural} the log, the longest of {longest:.1f} s")
    angles = [values[name] for name in ATTITUDE if name in values]
    if angles and np.ptp(angles[-1]) > 3.0 and all(np.abs(a).max() <= 2 * np.pi for a in angles):
        notes.append("no angle of the attitude exceeds 2 pi: are these radians? degrees are read")
    return notes
