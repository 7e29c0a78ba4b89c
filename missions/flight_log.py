"""Logs of flights: read from CSV or PX4 ULog, and checked before anything is computed from them.

Nothing is repaired: rows that lack a required value are left out and counted, gaps split the log
and are never interpolated over, everything else that cannot be true is an error that names its
line. Angles are degrees in files and radians in :class:`FlightLog`.
"""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from missions.problems import InputError, Problem, file_error, printable, shortened, shown
from missions.wording import unknown_key
from solar.sun import FloatArray

if TYPE_CHECKING:
    import pandas as pd

BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int_]

TIME, EPOCH = "time_utc", "time_utc_s"
ATTITUDE = ("roll_deg", "pitch_deg", "yaw_deg")
REQUIRED = ("latitude_deg", "longitude_deg", "altitude_m", "solar_power_w")
OPTIONAL = ("ambient_temperature_c", "mppt_voltage_v", "load_w", "state_of_charge")
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
        Power behind the power trackers [W].
    attitude : EulerAngles or None
        Attitude, none if the log has none.
    ambient_temperature_c, mppt_voltage_v, load_w, state_of_charge : ndarray or None
        What else was logged.
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


# ---- Text


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
            for (number, width), rest in _first(wrong)
        )


def _first(items: Sequence[Any]) -> list[tuple[Any, str]]:
    """First few items, the last of them with the number of those not shown."""
    chosen = list(items[:_SHOWN_PROBLEMS])
    more = len(items) - len(chosen)
    tails = ["" for _ in chosen]
    if more:
        tails[-1] = f" (and {more} more rows)"
    return list(zip(chosen, tails, strict=True))


# ---- Values


def log_from_table(
    table: pd.DataFrame,
    source: str,
    lines: IntArray | None = None,
    notes: Iterable[str] = (),
) -> FlightLog:
    """Check a table with the columns of the CSV format and make it a log.

    Parameters
    ----------
    table : DataFrame
        Columns as in the CSV format.
    source : str
        File name for messages.
    lines : ndarray of int, optional
        Line of each row; without, rows are counted from 2 like those below a header.
    notes : iterable of str
        Notes to keep with the log.

    Raises
    ------
    InputError
        If anything is wrong.
    """
    at = np.arange(2, len(table) + 2) if lines is None else lines
    problems: list[Problem] = []
    epoch = TIME not in table
    time_s = _times(table[EPOCH if epoch else TIME], epoch, source, at, problems)
    values = {
        name: _numbers(table[name], source, at, problems)
        for name in (*REQUIRED, *ATTITUDE, *OPTIONAL)
        if name in table
    }
    if problems:
        raise InputError(problems)
    if all(name in values and np.isnan(values[name]).all() for name in ATTITUDE):
        for name in ATTITUDE:
            del values[name]
    keep = _complete(time_s, values, source)
    time_s, values, at = time_s[keep], {n: v[keep] for n, v in values.items()}, at[keep]
    _check_order(time_s, at, source)
    dropped = int(np.count_nonzero(~keep))
    return _assembled(source, time_s, values, dropped, notes)


def _times(
    column: pd.Series, epoch: bool, source: str, lines: IntArray, problems: list[Problem]
) -> FloatArray:
    import pandas as pd

    if epoch:
        return _numbers(column, source, lines, problems, _EPOCH_RANGE)
    if pd.api.types.is_numeric_dtype(column) and column.notna().any():
        message = f"must be text like 2015-07-01T05:30:00Z; epoch seconds are the column {EPOCH}"
        problems.append(Problem(source, int(lines[0]), None, TIME, message))
        return np.full(len(column), np.nan)
    text = column.astype("string").str.strip()
    given = column.notna().to_numpy(bool)
    zoned = text.str.fullmatch(r".*\d.*(?:[Zz]|[+-]\d\d(?::?\d\d)?)", na=False).to_numpy(bool)
    # A bare date ends like an offset does.
    zoned &= text.str.contains("T|t| |:", regex=True, na=False).to_numpy(bool)
    parsed = pd.to_datetime(text, format="ISO8601", utc=True, errors="coerce")
    wrong = given & parsed.isna().to_numpy(bool)
    _complain(
        problems, source, lines, TIME, wrong, "must be ISO 8601 like 2015-07-01T05:30:00Z", column
    )
    message = "has no time zone; write UTC like 2015-07-01T05:30:00Z or +02:00"
    _complain(problems, source, lines, TIME, given & ~wrong & ~zoned, message, column)
    seconds = parsed.dt.tz_localize(None).to_numpy("datetime64[us]").astype(np.int64) / 1e6
    time_s = np.where(parsed.notna().to_numpy(bool), seconds, np.nan)
    low, high = _EPOCH_RANGE
    outside = (time_s < low) | (time_s > high)
    _complain(problems, source, lines, TIME, outside, "must be from 1950 to 2049", column)
    return np.asarray(time_s, float)


def _numbers(
    column: pd.Series,
    source: str,
    lines: IntArray,
    problems: list[Problem],
    limits: tuple[float, float] | None = None,
) -> FloatArray:
    """Column as numbers, NaN where a field is empty."""
    import pandas as pd

    name = str(column.name)
    if pd.api.types.is_bool_dtype(column):
        column = column.astype("string")
    numeric = pd.to_numeric(column, errors="coerce").astype(float)
    values = np.asarray(numeric.to_numpy(float, na_value=np.nan), float)
    wrong = np.isnan(values) & column.notna().to_numpy(bool)
    _complain(problems, source, lines, name, wrong, "must be a number", column)
    infinite = np.isinf(values)
    _complain(problems, source, lines, name, infinite, "must be a finite number", column)
    low, high = limits or _RANGES[name]
    outside = ((values < low) | (values > high)) & ~infinite
    message = f"must be from {low:g} to {high:g}{_HINTS.get(name, '')}"
    _complain(problems, source, lines, name, outside, message, column)
    return values


def _complain(
    problems: list[Problem],
    source: str,
    lines: IntArray,
    name: str,
    wrong: NDArray[Any],
    message: str,
    column: pd.Series,
) -> None:
    rows = np.flatnonzero(wrong).tolist()
    problems += [
        Problem(
            source, int(lines[row]), None, name, f"{message} (got {_cell(column.iloc[row])}){rest}"
        )
        for row, rest in _first(rows)
    ]


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


def _check_order(time_s: FloatArray, lines: IntArray, source: str) -> None:
    step = np.diff(time_s)
    wrong = np.flatnonzero(step <= 0.0).tolist()
    if wrong:
        raise InputError(
            Problem(
                source,
                int(lines[i + 1]),
                None,
                TIME,
                f"time must increase: {_backwards(step[i])} line {lines[i]}{rest}",
            )
            for i, rest in _first(wrong)
        )


def _backwards(step_s: float) -> str:
    return "it is the same as on" if step_s == 0.0 else f"it is {-step_s:g} s before that of"


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
    total = len(time_s) + dropped
    told = [*notes, *_remarks(values, dropped, total, gaps)]
    return FlightLog(
        source=source,
        time_s=time_s,
        attitude=attitude,
        rows_read=total,
        rows_dropped=dropped,
        gaps=gaps,
        notes=tuple(told),
        latitude_deg=values["latitude_deg"],
        longitude_deg=values["longitude_deg"],
        altitude_m=values["altitude_m"],
        solar_power_w=values["solar_power_w"],
        ambient_temperature_c=_if_any(values.get("ambient_temperature_c")),
        mppt_voltage_v=_if_any(values.get("mppt_voltage_v")),
        load_w=_if_any(values.get("load_w")),
        state_of_charge=_if_any(values.get("state_of_charge")),
    )


def _if_any(values: FloatArray | None) -> FloatArray | None:
    return None if values is None or np.isnan(values).all() else values


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


# ---- PX4 ULog

# A sample of a topic stands for a time no further from it than this [s].
_ATTITUDE_AGE_S, _POSITION_AGE_S, _BATTERY_AGE_S = 0.5, 2.0, 5.0
_FIX_3D = 3
_POWER_TOPIC = "sensor_mppt"
_POSITION_TOPICS = ("vehicle_gps_position", "sensor_gps")
_POWER_HELP = (
    f"the power is read from a topic {_POWER_TOPIC} with mppt_volt[i] and mppt_amp[i]; "
    "logs that have it elsewhere must be exported to CSV"
)


class _Topic(NamedTuple):
    """Fields of one topic over time since boot [s]."""

    name: str
    time_s: FloatArray
    fields: dict[str, NDArray[Any]]


def read_ulog(path: str | os.PathLike[str]) -> FlightLog:
    """Read a PX4 ULog; needs the package pyulog.

    Power and tracker voltage come from ``sensor_mppt``, whose times are the log's; of the other
    topics the nearest sample is taken, none if that is too old. Boot time becomes universal time by
    the median difference to the time of the satellites.

    Raises
    ------
    InputError
        If the package, the file, a topic or a field is missing, or a value is wrong.
    """
    import pandas as pd

    source = os.fspath(path)
    topics = _ulog_topics(source)
    power = _topic(topics, (_POWER_TOPIC,), source, _POWER_HELP)
    attitude = _topic(topics, ("vehicle_attitude",), source, "needed for the attitude")
    position = _topic(topics, _POSITION_TOPICS, source, "needed for position and universal time")
    time_s = power.time_s
    volts, watts = _tracker(power, source)
    columns = {
        EPOCH: time_s + _boot_s(position, source),
        "solar_power_w": watts,
        "mppt_voltage_v": volts,
    }
    columns |= _sampled(position, time_s, _POSITION_AGE_S, _place(position, source))
    columns |= _sampled(attitude, time_s, _ATTITUDE_AGE_S, _euler_deg(attitude, source))
    if "battery_status" in topics:
        battery = topics["battery_status"]
        columns |= _sampled(battery, time_s, _BATTERY_AGE_S, _battery(battery))
    table = pd.DataFrame(columns)
    note = "load_w is voltage times current of battery_status" if "load_w" in table else ""
    return log_from_table(table, source, notes=[note] if note else [])


def _ulog_topics(source: str) -> dict[str, _Topic]:
    """First instance of every topic in the log."""
    try:
        from pyulog import ULog
    except ImportError:
        raise file_error(
            source, "reading a ULog needs the package pyulog: pip install pyulog (the extra 'log')"
        ) from None
    if not Path(source).is_file():
        raise file_error(source, "cannot be read: no such file")
    names = [_POWER_TOPIC, "vehicle_attitude", *_POSITION_TOPICS, "battery_status"]
    try:
        log = ULog(source, names)
    except Exception as error:  # pyulog raises whatever its parsing trips over
        raise file_error(source, f"is not a ULog: {printable(str(error))}") from None
    topics: dict[str, _Topic] = {}
    for data in sorted(log.data_list, key=lambda d: int(d.multi_id)):
        fields = {str(k): np.asarray(v) for k, v in data.data.items()}
        if len(fields["timestamp"]):
            topic = _Topic(str(data.name), fields["timestamp"] / 1e6, fields)
            topics.setdefault(topic.name, topic)
    return topics


def _topic(topics: dict[str, _Topic], names: Sequence[str], source: str, purpose: str) -> _Topic:
    for name in names:
        if name in topics:
            return topics[name]
    raise file_error(source, f"has no topic {' or '.join(names)}: {purpose}")


def _field(topic: _Topic, source: str, *names: str) -> NDArray[Any]:
    for name in names:
        if name in topic.fields:
            return topic.fields[name]
    raise file_error(source, f"topic {topic.name} has no field {' or '.join(names)}")


def _tracker(power: _Topic, source: str) -> tuple[FloatArray, FloatArray]:
    """Mean voltage [V] of the trackers in use, and power of all [W]."""
    _field(power, source, "mppt_volt[0]")
    _field(power, source, "mppt_amp[0]")
    count = sum(name.startswith("mppt_volt[") for name in power.fields)
    volt = np.array([power.fields[f"mppt_volt[{i}]"] for i in range(count)], float)
    amp = np.array([_field(power, source, f"mppt_amp[{i}]") for i in range(count)], float)
    used = np.any(volt != 0.0, axis=1)
    mean = volt[used].mean(axis=0) if used.any() else np.full(volt.shape[1], np.nan)
    return np.asarray(mean), np.asarray((volt * amp).sum(axis=0))


def _boot_s(position: _Topic, source: str) -> float:
    """Universal time of the boot [s since 1970]."""
    utc = np.asarray(_field(position, source, "time_utc_usec"), float) / 1e6
    known = (utc > 0.0) & _has_fix(position)
    if not known.any():
        raise file_error(source, f"topic {position.name} never knows the universal time")
    return float(np.median((utc - position.time_s)[known]))


def _has_fix(position: _Topic) -> BoolArray:
    fix = position.fields.get("fix_type")
    if fix is None:
        return np.ones(len(position.time_s), bool)
    return np.asarray(fix >= _FIX_3D)


def _place(position: _Topic, source: str) -> dict[str, FloatArray]:
    """Position in degrees and metres, from floating-point fields or the integers of old logs."""
    columns = {
        "latitude_deg": ("latitude_deg", "lat", 1e-7),
        "longitude_deg": ("longitude_deg", "lon", 1e-7),
        "altitude_m": ("altitude_msl_m", "alt", 1e-3),
    }
    fixed = _has_fix(position)
    result = {}
    for column, (new, old, unit) in columns.items():
        values = np.asarray(_field(position, source, new, old), float)
        scaled = values if new in position.fields else values * unit
        result[column] = np.where(fixed, scaled, np.nan)
    return result


def _euler_deg(attitude: _Topic, source: str) -> dict[str, FloatArray]:
    """Roll, pitch and yaw [deg] from the quaternion body (FRD) to North-East-Down.

    Source: Beard & McLain, Small Unmanned Aircraft (2012), eq. B.1 to B.3.
    """
    w, x, y, z = (np.asarray(_field(attitude, source, f"q[{i}]"), float) for i in range(4))
    # Normalised: single precision and estimators leave a quaternion a little off the unit.
    norm = np.sqrt(w * w + x * x + y * y + z * z)
    norm = np.where(norm > 0.0, norm, np.nan)
    w, x, y, z = w / norm, x / norm, y / norm, z / norm
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return dict(zip(ATTITUDE, map(np.degrees, (roll, pitch, yaw)), strict=True))


def _battery(battery: _Topic) -> dict[str, FloatArray]:
    """Load [W] and state of charge, where they are known (negative: unknown)."""
    fields, result = battery.fields, {}
    if "voltage_v" in fields and "current_a" in fields:
        volt, amp = (np.asarray(fields[name], float) for name in ("voltage_v", "current_a"))
        result["load_w"] = np.where(amp == -1.0, np.nan, volt * amp)
    if "remaining" in fields:
        remaining = np.asarray(fields["remaining"], float)
        result["state_of_charge"] = np.where(remaining < 0.0, np.nan, remaining)
    return result


def _sampled(
    topic: _Topic, time_s: FloatArray, age_s: float, columns: dict[str, FloatArray]
) -> dict[str, FloatArray]:
    """Nearest sample of a topic at other times, NaN if it is older or younger than allowed."""
    after = np.clip(np.searchsorted(topic.time_s, time_s), 1, max(len(topic.time_s) - 1, 1))
    after = np.minimum(after, len(topic.time_s) - 1)
    before = np.maximum(after - 1, 0)
    earlier = np.abs(time_s - topic.time_s[before]) <= np.abs(topic.time_s[after] - time_s)
    nearest = np.where(earlier, before, after)
    fresh = np.abs(topic.time_s[nearest] - time_s) <= age_s
    return {name: np.where(fresh, values[nearest], np.nan) for name, values in columns.items()}
