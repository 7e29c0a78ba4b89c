"""Logs of flights: read, and checked before anything is computed from them.

Nothing is repaired: rows that lack a required value are left out and counted, gaps split the log
and are never interpolated over, everything else that cannot be true is an error that names its
line. Rows out of order are sorted, and columns that are written at times of their own are put
together by the nearest value; both are told. Angles are degrees in files and radians in
:class:`FlightLog`.
"""

from __future__ import annotations

import datetime
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from missions.files.errors import InputError, Problem, file_error, shown
from missions.logs.clock import times_from_text
from missions.logs.nearest import Series, age_s_of, sampled
from solar.types import BoolArray, FloatArray, IntArray

TIME, EPOCH = "time_utc", "time_utc_s"
ATTITUDE = ("roll_deg", "pitch_deg", "yaw_deg")
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

# The almanac behind the sun's position holds from 1950 to 2050.
_EPOCH_RANGE = (-631152000.0, 2524608000.0)
_RANGES: dict[str, tuple[float, float]] = {
    "latitude_deg": (-90.0, 90.0),
    "longitude_deg": (-180.0, 180.0),
    "altitude_m": (-500.0, 32000.0),
    "roll_deg": (-180.0, 180.0),
    "pitch_deg": (-90.0, 90.0),
    "yaw_deg": (-360.0, 360.0),
    "solar_power_w": (-1e3, 1e6),
    "ambient_temperature_c": (-100.0, 100.0),
    "mppt_voltage_v": (0.0, 1e4),
    "load_w": (-1e6, 1e6),
    "state_of_charge": (-0.05, 1.05),
    "airspeed_m_per_s": (-10.0, 300.0),
    "battery_power_w": (-1e6, 1e6),
}
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
    chosen = list(items[:_SHOWN_PROBLEMS])
    more = len(items) - len(chosen)
    tails = ["" for _ in chosen]
    if more:
        tails[-1] = f" (and {more} more rows)"
    return list(zip(chosen, tails, strict=True))


def log_from_table(
    table: pd.DataFrame,
    source: str,
    lines: IntArray | None = None,
    notes: Iterable[str] = (),
    *,
    zone: datetime.tzinfo | None = None,
    labels: Mapping[str, str] | None = None,
) -> FlightLog:
    """Check a table with the columns of the CSV format and make it a log.

    ``lines``: line of each row; without, rows are counted from 2 like those below a header.
    ``zone``: zone of times that are written without one; without, these are errors. ``labels``:
    names of columns in the file, for messages, where they are others. Returns samples in SI units,
    angles in radians.
    """
    at = np.arange(2, len(table) + 2) if lines is None else lines
    check = Check(source, at, dict(labels or {}), [])
    remarks = list(notes)
    if TIME in table:
        time_s = _times(table[TIME], zone, check, remarks)
    else:
        time_s = numbers(table[EPOCH], check, _EPOCH_RANGE)
    values = {
        name: numbers(table[name], check, _RANGES[name])
        for name in (*REQUIRED, *ATTITUDE, *OPTIONAL)
        if name in table
    }
    check.done()
    if all(name in values and np.isnan(values[name]).all() for name in ATTITUDE):
        for name in ATTITUDE:
            del values[name]
    time_s, values = _in_order(time_s, values, remarks)
    time_s, values = _put_together(time_s, values, remarks)
    keep = _complete(time_s, values, source)
    time_s, values = time_s[keep], {n: v[keep] for n, v in values.items()}
    dropped = int(np.count_nonzero(~keep))
    return _assembled(source, time_s, values, dropped, remarks)


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


@dataclass(frozen=True)
class Check:
    """What is being read: file, line of each row, names in the file, mistakes so far."""

    source: str
    lines: IntArray
    labels: dict[str, str]
    problems: list[Problem]

    def complain(self, column: pd.Series, wrong: NDArray[Any], message: str) -> None:
        """Note the first few rows in which a column is wrong."""
        rows = np.flatnonzero(wrong).tolist()
        name = str(column.name)
        label = self.labels.get(name, name)
        self.problems.extend(
            Problem(
                self.source,
                int(self.lines[row]),
                None,
                label,
                f"{message} (got {_cell(column.iloc[row])}){rest}",
            )
            for row, rest in first_few(rows)
        )

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
        check.complain(column, wrong, messages[kind])
    low, high = _EPOCH_RANGE
    outside = (times.time_s < low) | (times.time_s > high)
    check.complain(column, outside, "must be from 1950 to 2049")
    return times.time_s


def numbers(
    column: pd.Series, check: Check, limits: tuple[float, float] | None = None
) -> FloatArray:
    """Column as numbers, NaN where a field is empty."""
    if pd.api.types.is_bool_dtype(column):
        column = column.astype("string")
    numeric = pd.to_numeric(column, errors="coerce").astype(float)
    values = np.asarray(numeric.to_numpy(float, na_value=np.nan), float)
    wrong = np.isnan(values) & column.notna().to_numpy(bool)
    check.complain(column, wrong, "must be a number")
    infinite = np.isinf(values)
    check.complain(column, infinite, "must be a finite number")
    if limits is not None:
        low, high = limits
        outside = ((values < low) | (values > high)) & ~infinite
        message = f"must be from {low:g} to {high:g}{_HINTS.get(str(column.name), '')}"
        check.complain(column, outside, message)
    return values


def _cell(value: object) -> str:
    return shown(value.item() if isinstance(value, np.generic) else value)


def _complete(time_s: FloatArray, values: dict[str, FloatArray], source: str) -> BoolArray:
    """Rows in which nothing required is missing."""
    required = {TIME: time_s} | {n: values[n] for n in (*REQUIRED, *ATTITUDE) if n in values}
    lacking = {name: int(np.count_nonzero(np.isnan(v))) for name, v in required.items()}
    keep = ~np.any([np.isnan(v) for v in required.values()], axis=0)
    total, dropped = len(time_s), int(np.count_nonzero(~keep))
    if dropped > MAXIMUM_DROPPED * total:
        counts = ", ".join(f"{name} in {n}" for name, n in lacking.items() if n)
        raise file_error(
            source,
            f"{dropped} of {total} rows lack a required value ({counts}); "
            f"allowed: at most {MAXIMUM_DROPPED:.0%}",
        )
    if total - dropped < 2:
        raise file_error(source, "has fewer than two complete rows")
    return np.asarray(keep, bool)


def _assembled(
    source: str,
    time_s: FloatArray,
    values: dict[str, FloatArray],
    dropped: int,
    notes: Iterable[str],
) -> FlightLog:
    step = np.diff(time_s)
    after = np.flatnonzero(step > GAP_STEPS * np.median(step))
    gaps = tuple(Gap(float(time_s[i]), float(time_s[i + 1])) for i in after)
    attitude = None
    if "roll_deg" in values:
        attitude = EulerAngles(*(np.radians(values[name]) for name in ATTITUDE))
    optional: dict[str, Any] = dict.fromkeys(OPTIONAL)
    optional |= {n: v for n, v in values.items() if n in OPTIONAL and not np.isnan(v).all()}
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
