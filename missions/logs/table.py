"""Flight logs: read, and checked before anything is computed from them.

Nothing is repaired: impossible values are left out with a note, and so are rows that then lack a
required value; gaps split the log and are never interpolated over. A required column with mostly
impossible values is an error that names its lines. Rows out of order are sorted, and columns logged
at different times are joined by the nearest value; notes say so. Angles are degrees in files and
radians in :class:`FlightLog`.
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
from missions.logs.plausible import Kind, LeftOut, codes, leave_out_held, left_out, without_spans
from missions.logs.units import ATTITUDE, EPOCH, MPPT, QUANTITIES, TIME, quantity_of
from solar.schema import Allowed, spell
from solar.types import BoolArray, FloatArray, IntArray

REQUIRED = ("latitude_deg", "longitude_deg", "altitude_m", "solar_power_w")
OPTIONAL = (
    "ambient_temperature_c",
    "mppt_voltage_v",
    "load_w",
    "state_of_charge",
    "battery_power_w",
)
COLUMNS = (TIME, EPOCH, *REQUIRED, *ATTITUDE, *OPTIONAL)

# A step longer than this many median steps is a gap: a logger that skips a few samples is not.
GAP_STEPS = 5.0
MAXIMUM_DROPPED = 0.5
_SHOWN_PROBLEMS = 3
_YEAR_S = 365.25 * 86400.0  # no flight is as long

# A sample of a channel logged at other times is valid for times no further from it than this [s].
_AGES = {**dict.fromkeys(ATTITUDE, 0.5), **dict.fromkeys(REQUIRED[:3], 2.0)}
_OTHER_AGE_S = 5.0


def sampled(series: pd.Series, time_s: FloatArray, quantity: str = "") -> FloatArray:
    """Return the nearest sample at each time, NaN if it is too far away.

    ``series``: quantity in the unit of the log format over time since boot [s]; of a time of NaN a
    constant.
    """
    logged_s = series.index.to_numpy(float)
    if not len(logged_s):
        return np.full(len(time_s), np.nan)
    after = np.minimum(np.searchsorted(logged_s, time_s), len(logged_s) - 1)
    before = np.maximum(after - 1, 0)
    earlier = np.abs(time_s - logged_s[before]) <= np.abs(logged_s[after] - time_s)
    nearest = np.where(earlier, before, after)
    far = np.abs(logged_s[nearest] - time_s) > _AGES.get(quantity, _OTHER_AGE_S)
    return np.where(far, np.nan, series.to_numpy(float)[nearest])


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
    battery_power_w : ndarray or None
        Power into the battery, negative where it is discharged.
    rows_read, rows_dropped : int
        Rows of the file, and those left out because a required value was missing.
    gaps : tuple of Gap
        Stretches without samples.
    notes : tuple of str
        What the reader of the results should know.
    left_out : tuple of LeftOut
        Values that cannot be, and rows that were excluded.
    mppt_power_w : mapping
        Power behind each MPPT [W] by its name, where ``solar_power_w`` is their sum.
    """

    source: str
    time_s: FloatArray
    latitude_deg: FloatArray
    longitude_deg: FloatArray
    altitude_m: FloatArray
    solar_power_w: FloatArray
    attitude: EulerAngles | None = None
    ambient_temperature_c: FloatArray | None = None
    mppt_voltage_v: FloatArray | None = None
    load_w: FloatArray | None = None
    state_of_charge: FloatArray | None = None
    battery_power_w: FloatArray | None = None
    rows_read: int = 0
    rows_dropped: int = 0
    gaps: tuple[Gap, ...] = ()
    notes: tuple[str, ...] = ()
    left_out: tuple[LeftOut, ...] = ()
    mppt_power_w: Mapping[str, FloatArray] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.time_s)

    @property
    def step_s(self) -> float:
        """Median step of time [s]."""
        return float(np.median(np.diff(self.time_s)))

    def segment(self) -> IntArray:
        """Return the number of each sample's uninterrupted stretch."""
        ends = np.array([gap.end_s for gap in self.gaps])
        return np.searchsorted(ends, self.time_s, side="right").astype(int)


def first_few(items: Sequence[Any]) -> list[tuple[Any, str]]:
    """Return the first items, the last with the number of items not shown."""
    more = len(items) - _SHOWN_PROBLEMS
    tails = [""] * (_SHOWN_PROBLEMS - 1) + [f" (and {more} more rows)" if more > 0 else ""]
    return list(zip(items, tails, strict=False))


def log_from_table(
    table: pd.DataFrame, source: str, notes: Iterable[str] = (), exclude: Sequence[Span] = ()
) -> FlightLog:
    """Make a log of a table in the CSV format, without excluded times of day."""
    check = Check(source, np.arange(2, len(table) + 2))
    check.notes += notes
    return checked_log(table, check, exclude)


def checked_log(
    table: pd.DataFrame, check: Check, exclude: Sequence[Span], zone: datetime.tzinfo | None = None
) -> FlightLog:
    """Check a table and make a log of it; ``zone``: time zone of spans and naive times."""
    if TIME in table:
        time_s, wrong_rows, notes = times_from_text(table[TIME], zone)
        check.notes += notes
        for why, wrong in wrong_rows.items():
            check.without(time_s, wrong, table[TIME], "no_number", why)
        time_s = _drop_impossible_times(time_s, table[TIME], check)
    else:
        time_s = numbers(table[EPOCH], check, "time")
    names = [name for name in (*REQUIRED, *ATTITUDE, *OPTIONAL) if name in table]
    names += _mppt_columns(table)
    values = {name: numbers(table[name], check, quantity_of(name)) for name in names}
    # Receivers without a fix give 0, 0, where the flight was elsewhere.
    distance = np.abs(values["latitude_deg"]) + np.abs(values["longitude_deg"])
    others = distance[distance > 0.0]
    nowhere = (distance == 0.0) & bool(len(others) and np.median(others) > 1.0)
    for name in ("latitude_deg", "longitude_deg"):
        values[name] = check.without(values[name], nowhere, table[name], "code")
    check.done()
    left = [left_out(*doubt[:3], time_s, doubt[3]) for doubt in check.doubts]
    rows = pd.DataFrame(values, index=pd.Index(time_s, name=TIME))
    empty = [n for n in ATTITUDE if n not in rows or rows[n].isna().all()]
    if empty:
        rows = rows.drop(columns=list(ATTITUDE), errors="ignore")
        if len(empty) < len(ATTITUDE):
            check.notes.append(f"the attitude is not used: {', '.join(empty)} not logged")
    back = int(np.count_nonzero(np.diff(rows.index.dropna()) < 0.0))
    if back:
        rows = rows.sort_index(kind="stable")
        often = "once" if back == 1 else f"{back} times"
        check.notes.append(f"time goes back {often}: the rows are sorted")
    # Of rows with the same time and all quantities the first.
    twice = rows[list(REQUIRED)].notna().all(axis=1).to_numpy(bool) & rows.index.notna()
    twice[twice] = rows.index[twice].duplicated()
    if count := int(twice.sum()):
        have = "1 row has" if count == 1 else f"{count} rows have"
        check.notes.append(f"{have} the time of another: the first one is used")
    rows = without_spans(rows.loc[~twice], exclude, zone, left)
    _leave_out_sums(rows)
    left += leave_out_held(rows, check.labels)
    _leave_out_sums(rows)
    check.notes += [omission.sentence() for omission in left]
    return _assemble_log(check, _join_at_power_times(rows, check.notes), tuple(left))


def _mppt_columns(table: pd.DataFrame) -> list[str]:
    """Return the columns with the power of one of several MPPTs."""
    return [name for name in map(str, table) if name.startswith(MPPT)]


def _leave_out_sums(rows: pd.DataFrame) -> None:
    """Leave out the solar power where the power of an MPPT is unknown."""
    unknown = rows[_mppt_columns(rows)].isna().any(axis=1).to_numpy(bool)
    rows.loc[unknown, "solar_power_w"] = np.nan


def _required_columns(rows: pd.DataFrame) -> list[str]:
    """Return the columns whose values a row must have."""
    return [name for name in (*REQUIRED, *ATTITUDE) if name in rows]


def _join_at_power_times(rows: pd.DataFrame, notes: list[str]) -> pd.DataFrame:
    """Join columns logged at different times, at the times of the solar power."""
    lacking = rows[_required_columns(rows)].isna().any(axis=1).to_numpy(bool)
    power = rows["solar_power_w"].notna().to_numpy(bool) & rows.index.notna()
    if lacking.mean() <= MAXIMUM_DROPPED or 2 * (lacking & power).sum() <= power.sum():
        return rows
    known, at_s = rows[rows.index.notna()], rows.index[power].unique()
    together = {}
    for name in rows:
        together[name] = sampled(known[name].dropna(), at_s.to_numpy(float), str(name))
    ages = sorted({_AGES.get(str(name), _OTHER_AGE_S) for name in rows})
    notes.append(
        "columns are written at times of their own: for each value of the solar power the nearest "
        f"one of the others is used, {', '.join(map(spell, ages))} s away at most"
    )
    return pd.DataFrame(together, index=at_s)


@dataclass
class Check:
    """Table being read: mistakes, notes, and ``doubts`` (column, kind, rows, example)."""

    source: str
    lines: IntArray
    labels: dict[str, str] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    doubts: list[tuple[str, Kind, BoolArray, str]] = field(default_factory=list)

    def complain(self, column: pd.Series, wrong: NDArray[Any], message: str) -> None:
        """Record the first few rows in which a column is wrong."""
        label = self.label(column)
        for row, rest in first_few(np.flatnonzero(wrong).tolist()):
            text = f"{message} (got {_cell(column.iloc[row])}){rest}"
            self.problems.append(Problem(self.source, int(self.lines[row]), None, label, text))

    def label(self, column: pd.Series) -> str:
        """Return the column's name in the file."""
        return self.labels.get(str(column.name), str(column.name))

    def without(
        self, values: FloatArray, wrong: BoolArray, column: pd.Series, kind: Kind, message: str = ""
    ) -> FloatArray:
        """Replace wrong values by NaN; refuse a required column with mostly wrong values."""
        if not wrong.any():
            return values
        known = column.notna().to_numpy(bool)
        if message and wrong.sum() > MAXIMUM_DROPPED * known.sum():
            if column.name not in OPTIONAL:
                self.complain(column, wrong, message)
                return np.where(wrong, np.nan, values)
            wrong = known  # the rest is right by chance
        row = int(np.argmax(wrong))
        value = spell(values[row]) if np.isfinite(values[row]) else _cell(column.iloc[row])
        example = f"{value} in line {self.lines[row]}"
        if kind == "outside":
            example += f", {message}"
        self.doubts.append((self.label(column), kind, wrong, example))
        return np.where(wrong, np.nan, values)

    def done(self) -> None:
        """Raise all recorded mistakes."""
        if self.problems:
            raise InputError(self.problems)


def _drop_impossible_times(time_s: FloatArray, column: pd.Series, check: Check) -> FloatArray:
    """Replace times that no flight has by NaN: before clocks are set, or a year away."""
    limits = QUANTITIES["time"]
    wrong = (time_s < limits.low) | (time_s > limits.high)
    time_s = check.without(time_s, wrong, column, "outside", "must be from 1950 to 2049")
    if not np.isfinite(time_s).any():
        return time_s
    far = np.abs(time_s - np.nanmedian(time_s)) > _YEAR_S
    return check.without(time_s, far, column, "outside", "a year or more from the others")


def numbers(column: pd.Series, check: Check, quantity: str | None = None) -> FloatArray:
    """Convert a column to numbers, NaN where empty or impossible for the quantity."""
    if pd.api.types.is_bool_dtype(column):
        column = column.astype("string")
    values = np.asarray(pd.to_numeric(column, errors="coerce").to_numpy(float, na_value=np.nan))
    wrong = np.isnan(values) & column.notna().to_numpy(bool)
    values = check.without(values, wrong, column, "no_number", "must be a number")
    values = check.without(values, np.isinf(values), column, "no_number", "must be finite")
    if quantity is None:
        return values
    if quantity == "time":
        return _drop_impossible_times(values, column, check)
    dimension, low, high = QUANTITIES[quantity][:3]
    hint = "; it is a share, not a percentage" if quantity == "state_of_charge" else ""
    message = f"must be {Allowed(low, high)}{hint}"
    values = check.without(values, (values < low) | (values > high), column, "outside", message)
    marked = codes(dimension, values)
    return check.without(values, marked, column, "code")


def _cell(value: object) -> str:
    return shown(value.item() if isinstance(value, np.generic) else value)


def _assemble_log(check: Check, rows: pd.DataFrame, left: tuple[LeftOut, ...]) -> FlightLog:
    """Make the log of the rows that lack nothing required."""
    lacking = rows[_required_columns(rows)].isna()
    lacking.insert(0, TIME, rows.index.isna())
    drop = lacking.any(axis=1)
    total, dropped = len(rows), int(drop.sum())
    why = "".join(f"; {omission.sentence()}" for omission in left)
    if dropped > MAXIMUM_DROPPED * total:
        counts = ", ".join(f"{name} in {lacks}" for name, lacks in lacking.sum().items() if lacks)
        message = f"{dropped} of {total} rows lack a required value ({counts})"
        most = f"at most {round(100 * MAXIMUM_DROPPED)} %"
        raise file_error(check.source, f"{message}; allowed: {most}{why}")
    if total - dropped < 2:
        raise file_error(check.source, f"has fewer than two complete rows{why}")
    if dropped:
        check.notes.append(f"{dropped} of {total} rows left out: a required value is missing")
    rows = rows[~drop]
    values = {str(name): column.to_numpy(float) for name, column in rows.items()}
    time_s = rows.index.to_numpy(float)
    step = np.diff(time_s)
    after = np.flatnonzero(step > GAP_STEPS * np.median(step))
    gaps = tuple(Gap(float(time_s[i]), float(time_s[i + 1])) for i in after)
    if gaps:
        longest = round(max(gap.duration_s for gap in gaps), 1)
        plural = "gap splits" if len(gaps) == 1 else "gaps split"
        check.notes.append(f"{len(gaps)} {plural} the log, the longest of {longest} s")
    attitude = None
    if "roll_deg" in values:
        angles = [values[name] for name in ATTITUDE]
        if np.ptp(angles[2]) > 3.0 and np.abs(angles).max() <= 2 * np.pi:
            check.notes.append(
                "no angle of the attitude exceeds 2 pi: are these radians? degrees are read"
            )
        attitude = EulerAngles(*map(np.radians, angles))
    logged = rows.dropna(axis=1, how="all")
    optional: dict[str, Any] = {name: values[name] for name in OPTIONAL if name in logged}
    return FlightLog(
        source=check.source,
        time_s=time_s,
        attitude=attitude,
        rows_read=total,
        rows_dropped=dropped,
        gaps=gaps,
        notes=tuple(check.notes),
        left_out=left,
        mppt_power_w={n.removeprefix(MPPT): values[n] for n in _mppt_columns(rows)},
        **{name: values[name] for name in REQUIRED},
        **optional,
    )
