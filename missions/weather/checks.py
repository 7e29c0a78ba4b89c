"""From the table of a file to a weather record: order, gaps, impossible values, missing parts.

What cannot be true is an error that names its line. What every record has a little of is repaired,
counted and told: rows that are missing or impossible are filled, light at night is taken out. The
filled rows follow the clear sky, not the clock: what is carried over is the share of clear light.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from missions.files.errors import file_error, shown
from missions.weather.raw import END, RawTable, row_error
from missions.weather.record import (
    SECONDS_PER_HOUR,
    TYPICAL_YEAR,
    Site,
    Weather,
    day_of_year,
    runs_of,
)
from solar.clearsky import clear_sky, extraterrestrial_irradiance, global_horizontal
from solar.sun import SECONDS_PER_DAY, cos_zenith, declination, hour_angle, solar_time_h
from solar.types import BoolArray, FloatArray, IntArray

# Up to here a gap is bridged between its neighbours; a longer one takes the day next to it.
SHORT_GAP_H = 3.0
LONGEST_GAP_H = 120.0
MAXIMUM_FILLED = 0.1  # share of a record that may be filled
MAXIMUM_IMPOSSIBLE = 0.01  # share of a record whose values cannot be true, which are taken out
MAXIMUM_DAYS = 366 * 60
EARLIEST_YEAR, LATEST_YEAR = 1900, 2200
LIGHT = ("ghi", "dni", "dhi")
_NIGHT_NOISE = 20.0  # light in darkness up to here is the noise of an instrument [W/m2]
_DARKEST = 0.01  # of a clear sky's light: no record of a day or more is darker
_DARK_COSINE = -0.02  # sun more than 1.1 degrees below the horizon


def checked_record(raw: RawTable, source: str) -> Weather:
    """Make a table a record without gaps, with all three kinds of light."""
    time_s, lines, typical = _times(raw, source)
    interval_s = float(np.median(np.diff(time_s)))
    if not 60.0 <= interval_s <= 3.0 * SECONDS_PER_HOUR:
        message = f"has a row every {interval_s / 60:g} minutes"
        raise file_error(source, f"{message}; allowed: from 1 minute to 3 hours")
    start_s = time_s + raw.offset_s - raw.passed * interval_s
    values = {
        name: _column_values(raw, name, source, lines)
        for name in (*LIGHT, "temp_air", "wind_speed")
        if name in raw.table
    }
    given = [name for name in LIGHT if name in values and np.isfinite(values[name]).any()]
    if "ghi" not in given and len(given) < 2:
        raise file_error(source, "has no light: ghi, or dni and dhi, are needed")
    grid = _on_grid(start_s, interval_s, values, lines, source)
    sun = _Sun.over(raw.site, grid.start_s, interval_s)
    repairs = list(grid.repairs)
    light = {name: grid.values[name] for name in given}
    repairs += _without_night_noise(light, sun)
    repairs += _without_impossible(light, sun, source, grid.lines)
    light = _completed(light, sun, repairs)
    repairs += _filled(light, sun, interval_s, source, grid.start_s)
    if sum(float(np.sum(part)) for part in light.values()) <= 0.0:
        raise file_error(source, "is a record without sun: ghi, dni and dhi are zero throughout")
    share = float(np.sum(light["ghi"]) / max(np.sum(sun.clear["ghi"]), 1.0))
    if share < _DARKEST:
        percent = f"{100.0 * share:.2g} %"
        message = f"has {percent} of the light of a clear sky: is the unit wrong? W/m² are needed"
        raise file_error(source, message)
    temperature_c, left_out = checked_air(TEMPERATURE, grid.values, grid.lines, source)
    repairs += left_out
    wind_m_per_s, left_out = checked_air(WIND, grid.values, grid.lines, source)
    repairs += left_out
    return Weather(
        source=source,
        layout=raw.layout,
        site=raw.site,
        start_s=grid.start_s,
        interval_s=interval_s,
        ghi=light["ghi"],
        dni=light["dni"],
        dhi=light["dhi"],
        temperature_c=temperature_c,
        wind_m_per_s=wind_m_per_s,
        typical=typical,
        repairs=(*raw.notes, *repairs),
        air_altitude_m=raw.air_altitude_m,
    )


def _column_values(raw: RawTable, name: str, source: str, lines: IntArray) -> FloatArray:
    """Values of a column, NaN where there is none; text is an error that names its line."""
    column = raw.table[name]
    try:
        numbers = pd.to_numeric(column, errors="coerce")
    except OverflowError:  # an integer of hundreds of digits
        numbers = pd.to_numeric(column.astype(str), errors="coerce")
    values = np.asarray(numbers, float)
    text = np.flatnonzero(np.isnan(values) & column.notna().to_numpy())
    if len(text):
        at = int(text[0])
        message = f"must be a number (got {shown(str(column.iloc[at]))})"
        raise row_error(source, lines[at], name, message, len(text))
    return values


def _times(raw: RawTable, source: str) -> tuple[FloatArray, IntArray, bool]:
    """Universal time of the rows [s], their lines, and whether it is a typical year."""
    index: Any = pd.DatetimeIndex(raw.table.index)
    if len(index) < 24:
        raise file_error(source, f"has {len(index)} rows: a record has at least a day of them")
    lines = np.arange(len(index)) + raw.first_line if raw.first_line else np.zeros(len(index), int)
    wrong = np.flatnonzero(~((index.year >= EARLIEST_YEAR) & (index.year <= LATEST_YEAR)))
    if len(wrong):
        at = int(wrong[0])
        got = "no time" if index[at] is pd.NaT else str(index[at].year)
        message = f"years must be from {EARLIEST_YEAR} to {LATEST_YEAR} (got {got})"
        raise row_error(source, lines[at], "time", message)
    utc = index.tz_convert("UTC") if index.tz is not None else index.tz_localize("UTC")
    time_s = utc.tz_localize(None).to_numpy("datetime64[ns]").astype(np.int64) / 1e9
    backwards = np.flatnonzero(np.diff(time_s) <= 0.0)
    if not len(backwards):
        return time_s, lines, False
    typical = _typical_year(index, raw)
    if typical is None:
        at = int(backwards[0]) + 1
        what = "is the same as before" if time_s[at] == time_s[at - 1] else "goes back in time"
        message = f"{index[at]} {what}: rows must be in order"
        raise row_error(source, lines[at], "", message, len(backwards))
    return typical, lines, True


def _typical_year(index: Any, raw: RawTable) -> FloatArray | None:
    """Times in one common year [s], if months of several years follow each other; else None."""
    local = index.tz_localize(None) if index.tz is not None else index
    # An hour's end at midnight belongs to the month before.
    begins = local - (pd.Timedelta(local[1] - local[0]) if raw.passed == END else pd.Timedelta(0))
    month, day = np.asarray(begins.month), np.asarray(begins.day)
    if np.any(np.diff(month) < 0) or len(set(month)) < 2:
        return None
    extra = (month == 2) & (day == 29)
    if np.count_nonzero(extra) > 1:  # 29 February has no place in a year of 365 days
        return None
    stamp = begins.to_numpy("datetime64[s]")
    # The end of 28 February in a leap year: pvlib's reader of TMY3 names the day after the next.
    since_s = (stamp - stamp.astype("datetime64[M]")).astype(float) - SECONDS_PER_DAY * extra
    first = np.array([f"{TYPICAL_YEAR}-{m:02d}" for m in month.tolist()], "datetime64[s]")
    time_s = first.astype("datetime64[s]").astype(float) + since_s
    if np.any(np.diff(time_s) <= 0.0):
        return None
    passed_s = float(np.median(np.diff(time_s))) if raw.passed == END else 0.0
    return np.asarray(time_s + passed_s - raw.site.utc_offset_h * SECONDS_PER_HOUR)


@dataclass(frozen=True)
class _Grid:
    """Values on a time axis without gaps, NaN where there is no row."""

    start_s: FloatArray
    values: dict[str, FloatArray]
    lines: IntArray
    repairs: tuple[str, ...]


def _on_grid(
    start_s: FloatArray,
    interval_s: float,
    values: dict[str, FloatArray],
    lines: IntArray,
    source: str,
) -> _Grid:
    """Place rows on an even axis; those between its places are errors."""
    place = (start_s - start_s[0]) / interval_s
    nearest = np.rint(place).astype(int)
    off = np.flatnonzero(np.abs(place - nearest) > 0.02)
    if len(off):
        message = f"is not a whole number of {interval_s / 60:g} minutes after the first row"
        raise row_error(source, lines[off[0]], "time", message, len(off))
    count = int(nearest[-1]) + 1
    if count * interval_s > MAXIMUM_DAYS * SECONDS_PER_DAY:
        raise file_error(source, f"spans more than {MAXIMUM_DAYS // 366} years")
    placed = {name: np.full(count, np.nan) for name in values}
    for name, column in values.items():
        placed[name][nearest] = column
    of_line = np.zeros(count, int)
    of_line[nearest] = lines
    missing = count - len(nearest)
    repairs = (f"{missing} of {count} rows are missing",) if missing else ()
    return _Grid(start_s[0] + interval_s * np.arange(count), placed, of_line, repairs)


@dataclass(frozen=True)
class _Sun:
    """Sun and clear sky in the middle of every interval, and where the sun stands highest in it."""

    cosine: FloatArray
    highest: FloatArray
    extraterrestrial: FloatArray
    clear: dict[str, FloatArray]

    @classmethod
    def over(cls, site: Site, start_s: FloatArray, interval_s: float) -> _Sun:
        at_ends = (_cos_zenith(site, start_s + share * interval_s) for share in (0.0, 1.0))
        middle_s = start_s + interval_s / 2.0
        day, cosine = day_of_year(middle_s), _cos_zenith(site, middle_s)
        sky = clear_sky(day, site.latitude_deg, cosine, site.altitude_m)
        clear = {"ghi": global_horizontal(sky, cosine), "dni": sky.dni, "dhi": sky.dhi}
        highest = np.maximum.reduce([cosine, *at_ends])
        return cls(cosine, highest, extraterrestrial_irradiance(day), clear)


def _cos_zenith(site: Site, time_s: FloatArray) -> FloatArray:
    day = day_of_year(time_s)
    solar_h = solar_time_h((day % 1.0) * 24.0, day, site.longitude_deg)
    return cos_zenith(site.latitude_deg, declination(day), hour_angle(solar_h))


def _without_night_noise(light: dict[str, FloatArray], sun: _Sun) -> list[str]:
    """Set the light of the night, and small negative values, to zero."""
    noisy = np.zeros(len(sun.highest), bool)
    for values in light.values():
        dark = (sun.highest < _DARK_COSINE) & (np.abs(values) <= _NIGHT_NOISE) & (values != 0.0)
        low = (values < 0.0) & (values >= -_NIGHT_NOISE)
        noisy |= (dark & (np.abs(values) > 1.0)) | (values < -1.0) & low
        values[dark | low] = 0.0
    count = int(np.count_nonzero(noisy))
    return [f"noise at night or below zero in {count} rows set to zero"] if count else []


def _without_impossible(
    light: dict[str, FloatArray], sun: _Sun, source: str, lines: IntArray
) -> list[str]:
    """Take out values that are physically impossible; too many of them are an error.

    Limits: Long, C. N. and Dutton, E. G. (2002), BSRN Global Network recommended QC tests, V2.0,
    "physically possible".
    """
    up = np.maximum(sun.highest, 0.0)
    normal = sun.extraterrestrial
    most = {
        "ghi": 1.5 * normal * up**1.2 + 100.0,
        "dhi": 0.95 * normal * up**1.2 + 50.0,
        "dni": normal,
    }
    wrong = np.zeros(len(up), bool)
    for name, values in light.items():
        with np.errstate(invalid="ignore"):
            bad = (values > most[name]) | (values < 0.0) | np.isinf(values)
        wrong |= bad
        values[bad] = np.nan
    count = int(np.count_nonzero(wrong))
    if count > MAXIMUM_IMPOSSIBLE * len(up):
        first = int(np.flatnonzero(wrong)[0])
        message = (
            f"{count} of {len(up)} rows have light that cannot be (first here): is the time zone "
            "or the unit wrong? W/m² are needed"
        )
        raise row_error(source, lines[first], "", message)
    return [f"{count} rows with impossible light taken out"] if count else []


def _completed(
    light: dict[str, FloatArray], sun: _Sun, repairs: list[str]
) -> dict[str, FloatArray]:
    """All three kinds of light, by closure or, from global light alone, by a decomposition.

    Closure: ``GHI = DNI cos z + DHI``. Decomposition: Erbs, D. G., Klein, S. A. and Duffie, J. A.
    (1982), Estimation of the diffuse radiation fraction, Solar Energy 28(4), 293-302.
    """
    up = np.maximum(sun.cosine, 0.0)
    if set(light) == {"ghi"}:
        fraction = _diffuse_fraction(light["ghi"], up * sun.extraterrestrial)
        light = {**light, "dhi": fraction * light["ghi"]}
        repairs.append("direct and diffuse light by the decomposition of Erbs et al. (1982)")
    low = up < 0.0175  # a beam divided by so small a sine is noise
    beam = np.minimum(
        np.maximum(light.get("ghi", 0.0) - light.get("dhi", 0.0), 0.0) / np.maximum(up, 0.0175),
        sun.extraterrestrial,
    )
    parts = dict(light)
    if "dni" not in parts:
        parts["dni"] = np.where(low, 0.0, beam)
    elif {"ghi", "dhi"} <= set(parts):
        parts["dni"] = np.where(np.isnan(parts["dni"]), np.where(low, 0.0, beam), parts["dni"])
    closed = np.maximum(parts.get("ghi", np.nan) - parts["dni"] * up, 0.0)
    parts["dhi"] = _first_known(parts.get("dhi"), np.asarray(closed))
    parts["ghi"] = _first_known(parts.get("ghi"), np.asarray(parts["dni"] * up + parts["dhi"]))
    return {name: np.asarray(parts[name], float) for name in LIGHT}


def _first_known(values: FloatArray | None, otherwise: FloatArray) -> FloatArray:
    """Values where they are known, and what stands for them elsewhere."""
    return otherwise if values is None else np.where(np.isnan(values), otherwise, values)


def _diffuse_fraction(ghi: FloatArray, horizontal: FloatArray) -> FloatArray:
    """Share of diffuse in global light by the clearness index (Erbs et al., equation 1)."""
    sunlit = horizontal > 1.0
    kt = np.clip(ghi / np.where(sunlit, horizontal, 1.0), 0.0, 1.0)
    middle = 0.9511 - 0.1604 * kt + 4.388 * kt**2 - 16.638 * kt**3 + 12.336 * kt**4
    fraction = np.where(kt <= 0.22, 1.0 - 0.09 * kt, np.where(kt <= 0.8, middle, 0.165))
    return np.where(sunlit, fraction, 1.0)


def _filled(
    light: dict[str, FloatArray], sun: _Sun, interval_s: float, source: str, start_s: FloatArray
) -> list[str]:
    """Fill what is missing with shares of the clear sky, in place."""
    empty = np.any([np.isnan(values) for values in light.values()], axis=0)
    _check_gaps(empty, interval_s, source, start_s)
    for values in light.values():
        values[np.isnan(values) & (sun.highest < 0.0)] = 0.0  # a night without rows is no gap
    empty &= sun.highest >= 0.0
    count = int(np.count_nonzero(empty))
    if not count:
        return []
    gaps = _gaps(empty)
    if count > MAXIMUM_FILLED * len(empty):
        raise file_error(
            source,
            f"lacks light in {count} of {len(empty)} rows; allowed: at most "
            f"{MAXIMUM_FILLED:.0%}, which are filled",
        )
    per_day = round(SECONDS_PER_DAY / interval_s)
    copied = 0
    for begin, stop in gaps:
        short = (stop - begin) * interval_s <= SHORT_GAP_H * SECONDS_PER_HOUR
        copied += 0 if short else stop - begin
        for name, values in light.items():
            clear = sun.clear[name]
            sunlit = clear > 10.0
            share = np.where(sunlit, values / np.where(sunlit, clear, 1.0), np.nan)
            bridge = _bridged(share, begin, stop)
            fill = bridge if short else _from_next_day(share, bridge, begin, per_day)
            values[begin:stop] = fill * clear[begin:stop]
    notes = [f"{count - copied} rows filled between their neighbours"] if count > copied else []
    if copied:
        notes.append(f"{copied} rows of long gaps filled from the nearest days")
    return notes


def _check_gaps(empty: BoolArray, interval_s: float, source: str, start_s: FloatArray) -> None:
    """Refuse a gap that is too long to be filled."""
    begin, stop = max(_gaps(empty), key=lambda gap: gap[1] - gap[0], default=(0, 0))
    gap_h = (stop - begin) * interval_s / SECONDS_PER_HOUR
    if gap_h > LONGEST_GAP_H:
        when = np.datetime64(int(start_s[begin]), "s")
        raise file_error(
            source,
            f"has a gap of {gap_h / 24:.1f} days from {when} UTC; allowed: at most "
            f"{LONGEST_GAP_H / 24:g} days, which are filled",
        )


def _gaps(empty: BoolArray) -> list[tuple[int, int]]:
    """Begin and end of every gap."""
    begin, stop = runs_of(empty)
    return list(zip(begin.tolist(), stop.tolist(), strict=True))


def _bridged(share: FloatArray, begin: int, stop: int) -> FloatArray:
    """Shares between the nearest known ones before and after a gap."""
    known = np.flatnonzero(np.isfinite(share))
    if not len(known):
        return np.ones(stop - begin)
    return np.interp(np.arange(begin, stop), known, share[known])


def _from_next_day(share: FloatArray, bridge: FloatArray, begin: int, per_day: int) -> FloatArray:
    """Shares at the same hour of the nearest day that has them, else those of a bridge."""
    rows = begin + np.arange(len(bridge))
    filled = np.full(len(rows), np.nan)
    for away in range(1, 16):
        for step in (-away, away):
            there = rows + step * per_day
            inside = (there >= 0) & (there < len(share)) & np.isnan(filled)
            filled[inside] = share[there[inside]]
        if np.isfinite(filled).all():
            break
    return np.where(np.isnan(filled), bridge, filled)


# ---- Temperature and wind


_LEAST_KNOWN = 0.8  # share of a record without which a quantity is not used
# What stands for "missing": EPW (99.9 C, 999 m/s), TMY3 (-9900), BSRN (-99.9, -999) and others.
MISSING = (99.9, 99.99, 999.0, 999.9, 9999.0, 99999.0, -99.0, -99.9, -999.0, -9999.0, -9900.0)


class Quantity(NamedTuple):
    """A column beside the light, and what it can be."""

    column: str
    name: str
    lowest: float
    highest: float
    unit: str


# Around the records of the WMO (World Weather & Climate Extremes Archive): -89.2 C, 56.7 C, and
# 113 m/s in a gust.
TEMPERATURE = Quantity("temp_air", "temperature", -90.0, 70.0, "C")
WIND = Quantity("wind_speed", "wind speed", 0.0, 120.0, "m/s")


def checked_air(
    quantity: Quantity, columns: Mapping[str, FloatArray], lines: IntArray, source: str
) -> tuple[FloatArray | None, list[str]]:
    """Temperature or wind without gaps, and what was taken out of it.

    ``columns``: columns of the record, NaN where a value is missing. ``lines``: line of each row in
    the file; 0 where there is none. None where the record does not have it, or in too few rows.
    Returns what was taken out.
    """
    values = columns.get(quantity.column)
    if values is None:
        return None, []
    lowest, highest, notes = quantity.lowest, quantity.highest, []
    with np.errstate(invalid="ignore"):
        possible = (values >= lowest) & (values <= highest)
    wrong = np.flatnonzero(~possible & ~np.isnan(values) & ~np.isin(values, MISSING))
    what = f"a {quantity.name} outside of {lowest:g} to {highest:g} {quantity.unit}"
    if len(wrong) > MAXIMUM_IMPOSSIBLE * len(values):
        first = int(wrong[0])
        message = (
            f"{len(wrong)} of {len(values)} rows have {what} (first here, {values[first]:g}): "
            "is the unit wrong?"
        )
        raise row_error(source, lines[first], quantity.column, message)
    if len(wrong):
        notes.append(f"{len(wrong)} rows with {what} taken out")
    known = np.flatnonzero(possible)
    if len(known) >= _LEAST_KNOWN * len(values):
        return np.interp(np.arange(len(values)), known, values[known]), notes
    if len(known):
        notes.append(f"{quantity.name} not used: it lacks in {len(values) - len(known)} rows")
    return None, notes
