"""Times of a log: ISO 8601 with or without a zone, other forms, and numbers since 1970."""

from __future__ import annotations

import datetime
import re
import zoneinfo
from typing import NamedTuple

import numpy as np
import pandas as pd

from missions.files.errors import shown
from missions.units import SCALES
from solar.schema import spell
from solar.types import BoolArray, FloatArray

_DAY_S = 86400.0
_MOST_SINCE_START = 1e8  # s: smaller times count from the start of a log
_SPAN = re.compile(r"(?:(\d{4}-\d\d-\d\d)@)?(\d\d?:\d\d(?::\d\d)?)-(\d\d?:\d\d(?::\d\d)?)")
_OFFSET = re.compile(r"([+-])(\d{1,2})(?::?(\d\d))?")
# Other common forms as ISO 8601; between dots the order is day, month, year everywhere.
_REWRITTEN = (
    (r"^\s*(\d{1,2})\.(\d{1,2})\.(\d{4})[ T,]+", r"\3-\2-\1 "),
    (r"^(\d{4})[-/](\d\d?)[-/](\d\d?)", r"\1-\2-\3"),
    (r"^(\d{4})-(\d)-", r"\1-0\2-"),
    (r"^(\d{4}-\d\d)-(\d)(?!\d)", r"\1-0\2"),
)
_SLASHED = r"^\s*(\d{1,2})/(\d{1,2})/(\d{4})[ T,]+"
_NO_FORM = "must be ISO 8601 like 2015-07-01T05:30:00Z"
_NO_ZONE = "has no time zone; write UTC like 2015-07-01T05:30:00Z or +02:00, or give --timezone"
_NO_HOUR = "does not exist, or comes twice, in this time zone: the clocks were changed"
_HALF_DAY = r"^(.*?)(\d{1,2})(:\d\d(?::\d\d(?:\.\d+)?)?)\s*([AaPp])\.?[Mm]\.?$"


class Span(NamedTuple):
    """Times of day [s since midnight], on one date or on every day; the end may be on the next."""

    text: str
    date: datetime.date | None
    start_s: float
    end_s: float

    def holds(self, time_s: FloatArray, zone: datetime.tzinfo) -> BoolArray:
        """Return a flag per time [s since 1970]: within the span by the clock of a zone."""
        instants = pd.to_datetime(pd.Series(time_s), unit="s", utc=True).dt.tz_convert(zone)
        local = instants.dt.tz_localize(None) - pd.Timedelta(seconds=self.start_s)
        since = (local - local.dt.normalize()).dt.total_seconds()
        length_s = self.end_s - self.start_s
        inside = since <= (length_s if length_s >= 0.0 else length_s + _DAY_S)
        if self.date is not None:
            inside &= local.dt.date == self.date
        return np.asarray(inside, bool)


def parse_span(text: object) -> Span:
    """Read times of day like ``11:20-11:45`` or ``2015-07-01@11:20-11:45``."""
    match = _SPAN.fullmatch(written := str(text).strip())
    try:
        if match is None:
            raise ValueError
        date = datetime.date.fromisoformat(match[1]) if match[1] else None
        midnight = match[3] in ("24:00", "24:00:00")
        ends = (match[2], "00:00" if midnight else match[3])
        start, end = (datetime.time.fromisoformat(end.zfill(5)) for end in ends)
    except ValueError:
        raise ValueError(
            f"must be times like 11:20-11:45, or 2015-07-01@11:20-11:45 of one day "
            f"(got {shown(text)})"
        ) from None
    start_s, end_s = (3600.0 * t.hour + 60.0 * t.minute + t.second for t in (start, end))
    return Span(written, date, start_s, _DAY_S if midnight else end_s)


def parse_zone(text: object) -> datetime.tzinfo:
    """Read a time zone: ``UTC``, an offset like ``+02:00``, or a name like ``Europe/Zurich``."""
    name = str(text).strip()
    if name.upper() in ("UTC", "Z", "GMT"):
        return datetime.UTC
    match = _OFFSET.fullmatch(name.upper().removeprefix("UTC"))
    if match is not None:
        minutes = 60 * int(match[2]) + int(match[3] or 0)
        if minutes <= 14 * 60 and int(match[3] or 0) < 60:
            sign = 1 if match[1] == "+" else -1
            return datetime.timezone(datetime.timedelta(minutes=sign * minutes))
    try:
        return zoneinfo.ZoneInfo(name)
    except (KeyError, ValueError, OSError):
        raise ValueError(
            f"must be UTC, an offset like +02:00 (at most 14 h) or a name like Europe/Zurich "
            f"(got {shown(text)})"
        ) from None


def parse_instant(text: object) -> float:
    """Read an instant with its zone, ``2015-06-30T11:14:00+02:00``, as seconds since 1970."""
    try:
        instant = datetime.datetime.fromisoformat(str(text).strip())
    except ValueError:
        instant = None
    if instant is None or instant.tzinfo is None:
        raise ValueError(
            f"must be a time with its zone like 2015-06-30T11:14:00+02:00 (got {shown(text)})"
        )
    return instant.timestamp()


def times_from_text(
    column: pd.Series, zone: datetime.tzinfo | None, form: str | None = None
) -> tuple[FloatArray, dict[str, BoolArray], list[str]]:
    """Read written times; without ``zone`` times that name none are wrong.

    Returns seconds since 1970 (UTC), NaN where unknown; wrong rows by their message; and notes.
    """
    written = column.notna().to_numpy(bool)
    text = column.astype("string").str.strip()
    other = written & ~text.str.match(r"\d{4}-\d\d-\d\d", na=False).to_numpy(bool)
    notes: list[str] = []
    if form is None:
        halves = text.str.extract(_HALF_DAY).dropna()  # with AM or PM
        if len(halves):
            hour = halves[1].astype(int) % 12 + 12 * halves[3].str.lower().eq("p").astype(int)
            text[halves.index] = halves[0] + hour.map("{:02d}".format) + halves[2]
        # Other forms as ISO 8601; a day above 12, AM or PM tells the order of 07/12/2015.
        rest = text[other]
        parts = rest.str.extract(_SLASHED).dropna().astype(int)
        day_first = bool((parts[0] > 12).any())
        if len(parts) and (day_first or len(halves) or (parts[1] > 12).any()):
            notes.append(f"dates are read as {'day/month/year' if day_first else 'month/day/year'}")
            order = r"\3-\2-\1 " if day_first else r"\3-\1-\2 "
            rest = rest.str.replace(_SLASHED, order, regex=True)
        for pattern, iso in _REWRITTEN:
            rest = rest.str.replace(pattern, iso, regex=True)
        text[other] = rest
    if text.str.contains(",", regex=False, na=False).any():
        text = text.str.replace(r"(:\d\d),(\d)", r"\1.\2", regex=True)
    zoned = text.str.fullmatch(r".*\d.*(?:[Zz]|[+-]\d\d(?::?\d\d)?)", na=False).to_numpy(bool)
    # A bare date ends like an offset does.
    zoned &= text.str.contains("T|t| |:", regex=True, na=False).to_numpy(bool)
    zoned |= form is not None and "%z" in form
    time_s, naive = np.full(len(column), np.nan), np.zeros(len(column), bool)
    rows = written & zoned
    if rows.any():
        parsed = pd.to_datetime(text[rows], format=form or "ISO8601", utc=True, errors="coerce")
        time_s[rows] = _seconds(parsed)
    rows = written & ~zoned
    if rows.any():
        local = pd.to_datetime(text[rows], format=form or "ISO8601", errors="coerce")
        naive[rows] = local.notna().to_numpy(bool)
        if zone is not None:
            try:
                local = local.dt.tz_localize(zone, ambiguous="infer", nonexistent="NaT")
            except ValueError:  # an hour that comes twice, without its repetition to tell by
                local = local.dt.tz_localize(zone, ambiguous="NaT", nonexistent="NaT")
            time_s[rows] = _seconds(local.dt.tz_convert("UTC"))
    unknown = written & np.isnan(time_s)
    why = _NO_ZONE if zone is None else _NO_HOUR
    return time_s, {_NO_FORM: unknown & ~naive, why: unknown & naive}, notes


def _seconds(instants: pd.Series) -> FloatArray:
    """Convert instants to seconds since 1970, NaN where there is none."""
    plain = instants.dt.tz_localize(None).to_numpy("datetime64[us]")
    return np.where(np.isnat(plain), np.nan, plain.astype(np.int64) / 1e6)


def times_from_numbers(
    values: FloatArray, unit: str | None, start_s: float | None, name: str
) -> tuple[FloatArray, str | None]:
    """Read numeric times, counted from 1970 or from the log's start ``start_s``."""
    if start_s is not None:
        first = values[np.isfinite(values)][:1]
        since_first = values - (first[0] if len(first) else 0.0)
        return start_s + SCALES[unit].factor * since_first, None
    known = np.abs(values[np.isfinite(values)])
    size = float(np.median(known)) if len(known) else np.inf
    # 1e8 s are in 1973, 2.6e9 s in 2052: each range is clear of the next.
    factors = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}
    fits = (u for u, by in factors.items() if _MOST_SINCE_START * by <= size < 2.6e9 * by)
    epoch = next(fits, None)
    if epoch is None and size > _MOST_SINCE_START:
        return values, None  # refused by its size, as other times that no flight has
    if epoch is None:
        shape = f" ({spell(values[0])}, {spell(values[1])}, ...)" if len(values) > 1 else ""
        raise ValueError(
            f"counts from the start of the log, not from 1970{shape}: give the time of its first "
            "row with its zone, such as --start 2015-06-30T11:14:00+02:00"
        )
    note = None
    if unit is not None and SCALES[unit] != SCALES[epoch]:
        note = f"{name} is said to be in {unit}, and read as {epoch} since 1970: so its size says"
    elif unit is None:
        note = f"{name} read as {epoch} since 1970"
    return SCALES[epoch].factor * values, note
