"""Checks that make a weather record of a file's table: order, gaps, impossible values.

Impossible rows beyond a few are an error that names its line. A few missing or impossible rows are
filled, light at night is taken out, and notes count both. Filled rows take over the share of clear
light of their neighbours, not the light.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from missions.files.errors import refused, shown
from missions.weather.raw import END, RawTable
from missions.weather.record import SECONDS_PER_HOUR, TYPICAL_YEAR, Site, Weather, runs_of, sun_over
from solar.clearsky import clear_sky, extraterrestrial_irradiance, global_horizontal
from solar.schema import Allowed, refusal, spell
from solar.sun import SECONDS_PER_DAY
from solar.types import BoolArray, FloatArray, IntArray

# Up to here a gap is bridged between its neighbours; a longer one takes the day next to it.
SHORT_GAP_H = 3.0
LONGEST_GAP_H = 120.0
MAXIMUM_FILLED = 0.1  # share of a record that may be filled
MAXIMUM_IMPOSSIBLE = 0.01  # share of a record whose values cannot be true, which are taken out
MAXIMUM_DAYS = 366 * 60
EARLIEST_YEAR, LATEST_YEAR = 1900, 2200
LIGHT = ("ghi", "dni", "dhi")
_LINE = "line of the row"
_NIGHT_NOISE = 20.0  # light in darkness up to here is the noise of an instrument [W/m2]
_DARKEST = 0.01  # of a clear sky's light: no record of a day or more is darker
_DARK_COSINE = -0.02  # sun more than 1.1 degrees below the horizon


def checked_record(raw: RawTable, source: str) -> Weather:
    """Make a weather record of a table: no gaps, all three kinds of light."""
    time_s, lines, typical = _read_times(raw)
    apart_s = float(np.median(np.diff(time_s)))
    if not 60.0 <= apart_s <= 3.0 * SECONDS_PER_HOUR:
        message = f"has a row every {spell(apart_s / 60)} minutes"
        raise refused(f"{message}; allowed: from 1 minute to 3 hours")
    interval_s = min(raw.interval_s or apart_s, apart_s)
    stride = round(apart_s / interval_s)
    start_s = time_s + raw.offset_s - raw.passed * interval_s
    values = {
        name: _column_values(raw, name, lines) for name in (*LIGHT, *_AIR) if name in raw.table
    }
    logged = [name for name in LIGHT if name in values and np.isfinite(values[name]).any()]
    if "ghi" not in logged and len(logged) < 2:
        raise refused("has no light: ghi, or dni and dhi, are needed")
    grid = _place_on_grid(start_s, interval_s, values, lines)
    start_s, of_line = grid.index.to_numpy(), grid.pop(_LINE).to_numpy()
    columns = {str(name): column.to_numpy(copy=True) for name, column in grid.items()}
    sun = _Sun.over(raw.site, start_s, interval_s)
    missing, repairs = int(np.count_nonzero(of_line < 0)), []
    if stride > 1:
        apart, each = (spell(one_s / SECONDS_PER_HOUR) for one_s in (apart_s, interval_s))
        text = f"rows {apart} h apart have the light of {each} h each: shares of the clear sky "
        repairs.append(f"{text}between")
    elif missing:
        repairs.append(f"{missing} of {len(of_line)} rows are missing")
    light = {name: columns[name] for name in LIGHT if name in values}
    noisy = np.zeros(len(start_s), bool)
    for part in light.values():  # at night, and small negative values
        dark = (sun.highest < _DARK_COSINE) & (np.abs(part) <= _NIGHT_NOISE) & (part != 0.0)
        low = (part < 0.0) & (part >= -_NIGHT_NOISE)
        noisy |= (dark & (np.abs(part) > 1.0)) | (part < -1.0) & low
        part[dark | low] = 0.0
    if count := int(np.count_nonzero(noisy)):
        repairs.append(f"noise at night or below zero in {count} rows set to zero")
    repairs += _drop_impossible(light, sun, of_line)
    light = _complete_light(light, sun, repairs)
    repairs += _fill_gaps(light, sun, interval_s, start_s, stride=stride)
    if sum(float(np.sum(part)) for part in light.values()) <= 0.0:
        raise refused("is a record without sun: ghi, dni and dhi are zero throughout")
    share = float(np.sum(light["ghi"]) / max(np.sum(sun.clear["ghi"]), 1.0))
    if share < _DARKEST:
        message = f"has {spell(100.0 * share, 2)} % of the light of a clear sky"
        raise refused(f"{message}: is the unit wrong? W/m² are needed")
    air = {}
    for name in _AIR:
        air[name], notes = _checked_air(name, columns, of_line, stride)
        repairs += notes
    return Weather(
        source=source,
        layout=raw.layout,
        site=raw.site,
        start_s=start_s,
        interval_s=interval_s,
        **light,
        temperature_c=air["temp_air"],
        wind_m_per_s=air["wind_speed"],
        typical=typical,
        repairs=(*raw.notes, *repairs),
        air_altitude_m=raw.air_altitude_m,
    )


def _column_values(raw: RawTable, name: str, lines: IntArray) -> FloatArray:
    """Return a column's values, NaN where missing; text is an error that names its line."""
    column = raw.table[name]
    try:
        numbers = pd.to_numeric(column, errors="coerce")
    except OverflowError:  # an integer of hundreds of digits
        numbers = pd.to_numeric(column.astype(str), errors="coerce")
    values = np.asarray(numbers, float)
    text = np.flatnonzero(np.isnan(values) & column.notna().to_numpy())
    if len(text):
        at = int(text[0])
        message = refusal("must be a number", shown(str(column.iloc[at])))
        raise refused(message, line=lines[at], key=name, rows=len(text))
    # As light, a code between these may be a measurement: 999 W/m2 is a bright noon.
    code = ((values < -_NIGHT_NOISE) | (values >= 9999.0)) if name in LIGHT else True
    return np.where(np.isin(values, MISSING) & code, np.nan, values)


def _read_times(raw: RawTable) -> tuple[FloatArray, IntArray, bool]:
    """Return the rows' universal time [s], their lines, and true for a typical year."""
    index: Any = pd.DatetimeIndex(raw.table.index)
    if len(index) < 24:
        raise refused(f"has {len(index)} rows: a record has at least a day of them")
    lines = np.arange(len(index)) + raw.first_line if raw.first_line else np.zeros(len(index), int)
    wrong = np.flatnonzero(~((index.year >= EARLIEST_YEAR) & (index.year <= LATEST_YEAR)))
    if len(wrong):
        at = int(wrong[0])
        got = "no time" if index[at] is pd.NaT else str(index[at].year)
        message = refusal(f"years must be from {EARLIEST_YEAR} to {LATEST_YEAR}", got)
        raise refused(message, line=lines[at], key="time")
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
        raise refused(message, line=lines[at], rows=len(backwards))
    return typical, lines, True


def _typical_year(index: Any, raw: RawTable) -> FloatArray | None:
    """Return times in one common year [s] if months of several years follow, else None."""
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


def _place_on_grid(
    start_s: FloatArray, interval_s: float, values: dict[str, FloatArray], lines: IntArray
) -> pd.DataFrame:
    """Place rows on an even time axis, the last of one place; rows between places are errors.

    Returns the values by the start of each interval, with the line of each row; NaN and line -1
    where there is no row.
    """
    place = (start_s - start_s[0]) / interval_s
    nearest = np.rint(place).astype(int)
    off = np.flatnonzero(np.abs(place - nearest) > 0.02)
    if len(off):
        message = f"is not a whole number of {spell(interval_s / 60)} minutes after the first row"
        raise refused(message, line=lines[off[0]], key="time", rows=len(off))
    count = int(nearest[-1]) + 1
    if count * interval_s > MAXIMUM_DAYS * SECONDS_PER_DAY:
        raise refused(f"spans more than {MAXIMUM_DAYS // 366} years")
    rows = pd.DataFrame(values | {_LINE: lines}, index=nearest)
    rows = rows[~rows.index.duplicated(keep="last")].reindex(range(count))
    rows.index = pd.Index(start_s[0] + interval_s * np.arange(count))
    return rows.fillna({_LINE: -1}).astype({_LINE: int})


_SUN_STEP_S = 900.0  # a quarter of an hour: the sun moves by less than 4 degrees


@dataclass(frozen=True)
class _Sun:
    """Sun and clear sky of every interval.

    ``cosine``: cosine of the zenith angle in the middle, ``highest``: its maximum, ``of_beam``: its
    mean weighted by the clear sky's direct light. ``clear``: mean light [W/m2].
    """

    cosine: FloatArray
    highest: FloatArray
    of_beam: FloatArray
    extraterrestrial: FloatArray
    clear: dict[str, FloatArray]

    @classmethod
    def over(cls, site: Site, start_s: FloatArray, interval_s: float) -> _Sun:
        at_ends = (sun_over(site, start_s + share * interval_s)[2] for share in (0.0, 1.0))
        middle_day, _, cosine = sun_over(site, start_s + interval_s / 2.0)
        clear = dict.fromkeys((*LIGHT, "level"), np.zeros(len(start_s)))
        steps = max(1, round(interval_s / _SUN_STEP_S))
        for share in (np.arange(steps) + 0.5) / steps:
            day, _, up = sun_over(site, start_s + share * interval_s)
            sky = clear_sky(day, site.latitude_deg, up, site.altitude_m)
            parts = (global_horizontal(sky, up), sky.dni, sky.dhi, sky.dni * np.maximum(up, 0.0))
            clear = {
                name: clear[name] + part / steps for name, part in zip(clear, parts, strict=True)
            }
        level, dni = clear.pop("level"), clear["dni"]
        of_beam = np.where(dni > 1.0, level / np.maximum(dni, 1.0), np.maximum(cosine, 0.0))
        highest = np.maximum.reduce([cosine, *at_ends])
        return cls(cosine, highest, of_beam, extraterrestrial_irradiance(middle_day), clear)


def _drop_impossible(light: dict[str, FloatArray], sun: _Sun, lines: IntArray) -> list[str]:
    """Replace physically impossible values by NaN, in place; refuse too many of them.

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
    trouble = "have light that cannot be (first here): is the time zone or the unit wrong?"
    return _take_out(wrong, lines, "impossible light", f"{trouble} W/m² are needed")


def _take_out(
    wrong: BoolArray, lines: IntArray, what: str, trouble: str, key: str = ""
) -> list[str]:
    """Return a note on rows with impossible values; refuse too many of them at the first one."""
    count = int(np.count_nonzero(wrong))
    if count > MAXIMUM_IMPOSSIBLE * len(wrong):
        message = f"{count} of {len(wrong)} rows {trouble}"
        raise refused(message, line=lines[int(np.argmax(wrong))], key=key)
    return [f"{count} rows with {what} taken out"] if count else []


def _complete_light(
    light: dict[str, FloatArray], sun: _Sun, repairs: list[str]
) -> dict[str, FloatArray]:
    """Compute missing kinds of light by closure or, from global light alone, by decomposition.

    Closure: ``GHI = DNI cos z + DHI``. Decomposition: Erbs, D. G., Klein, S. A. and Duffie, J. A.
    (1982), Estimation of the diffuse radiation fraction, Solar Energy 28(4), 293-302.
    """
    up = sun.of_beam
    low = up < 0.0175  # a beam divided by so small a sine is noise
    ghi, dni, dhi = (light.get(name, np.full(len(up), np.nan)) for name in LIGHT)
    alone = np.isnan(dni) & np.isnan(dhi) & ~np.isnan(ghi)
    if alone.any():
        share = _diffuse_fraction(ghi, np.maximum(sun.cosine, 0.0) * sun.extraterrestrial)
        dhi = np.where(alone, share * ghi, dhi)
        rows = "" if np.all(alone | np.isnan(ghi)) else f" in {np.count_nonzero(alone)} rows"
        text = f"direct and diffuse light{rows} by the decomposition of Erbs et al. (1982)"
        repairs.append(text)
    beam = np.minimum(np.maximum(ghi - dhi, 0.0) / np.maximum(up, 0.0175), sun.extraterrestrial)
    beam[low & ~np.isnan(beam)] = 0.0
    known = {"dni": np.where(np.isnan(dni), beam, dni)}
    known["dhi"] = np.where(np.isnan(dhi), np.maximum(ghi - known["dni"] * up, 0.0), dhi)
    known["ghi"] = np.where(np.isnan(ghi), known["dni"] * up + known["dhi"], ghi)
    for name, values in light.items():
        count = int(np.count_nonzero(np.isnan(values) & ~np.isnan(known[name]) & ~alone))
        if count:
            repairs.append(f"{name} missing in {count} rows: from the other two")
    return {name: known[name] for name in LIGHT}


def _diffuse_fraction(ghi: FloatArray, horizontal: FloatArray) -> FloatArray:
    """Return the diffuse share of global light (Erbs et al., equation 1)."""
    daylight = horizontal > 1.0
    kt = np.clip(ghi / np.where(daylight, horizontal, 1.0), 0.0, 1.0)
    middle = 0.9511 - 0.1604 * kt + 4.388 * kt**2 - 16.638 * kt**3 + 12.336 * kt**4
    fraction = np.where(kt <= 0.22, 1.0 - 0.09 * kt, np.where(kt <= 0.8, middle, 0.165))
    return np.where(daylight, fraction, 1.0)


def _fill_gaps(
    light: dict[str, FloatArray],
    sun: _Sun,
    interval_s: float,
    start_s: FloatArray,
    *,
    stride: int = 1,
) -> list[str]:
    """Fill missing light with shares of the clear sky, in place; every ``stride``-th is a row."""
    empty = np.any([np.isnan(values) for values in light.values()], axis=0)
    begin, stop = max(runs_of(empty).tolist(), key=lambda gap: gap[1] - gap[0], default=(0, 0))
    if (gap_h := (stop - begin) * interval_s / SECONDS_PER_HOUR) > LONGEST_GAP_H:
        when = np.datetime64(int(start_s[begin]), "s")
        message = f"has a gap of {round(gap_h / 24, 1)} days from {when} UTC"
        most = f"at most {spell(LONGEST_GAP_H / 24)} days, which are filled"
        raise refused(f"{message}; allowed: {most}")
    for values in light.values():
        values[np.isnan(values) & (sun.highest < 0.0)] = 0.0  # a night without rows is no gap
    empty &= sun.highest >= 0.0
    count = int(np.count_nonzero(empty))
    if not count:
        return []
    if len(empty) - count < (1.0 - MAXIMUM_FILLED) * len(empty) / stride:
        most = f"at most {round(100 * MAXIMUM_FILLED)} %, which are filled"
        raise refused(f"lacks light in {count} of {len(empty)} rows; allowed: {most}")
    per_day = round(SECONDS_PER_DAY / interval_s)
    gaps = runs_of(empty).tolist()
    short = SHORT_GAP_H * SECONDS_PER_HOUR / interval_s  # rows
    copied = sum(stop - begin for begin, stop in gaps if stop - begin > short)
    for name, values in light.items():
        clear = sun.clear[name]
        share = np.where(clear > 10.0, values / np.maximum(clear, 10.0), np.nan)
        known, rows = np.flatnonzero(np.isfinite(share)), np.arange(len(share))
        bridge = np.interp(rows, known, share[known]) if len(known) else np.ones(len(share))
        for begin, stop in gaps:
            fill = bridge[begin:stop]
            if stop - begin > short:
                fill = _copy_nearest_days(share, fill, begin, per_day)
            values[begin:stop] = fill * clear[begin:stop]
    notes = [f"{count - copied} rows filled between their neighbours"] if count > copied else []
    if copied:
        notes.append(f"{copied} rows of long gaps filled from the nearest days")
    return notes


def _copy_nearest_days(
    share: FloatArray, bridge: FloatArray, begin: int, per_day: int
) -> FloatArray:
    """Return shares at the same hour of the nearest day, by default of the bridge."""
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


# Columns other than light: name, possible range, unit, what takes their place. Around the records
# of the WMO (World Weather & Climate Extremes Archive): -89.2 C, 56.7 C, and 113 m/s in a gust.
_AIR = {
    "temp_air": ("temperature", Allowed(-90.0, 70.0), "C", "that of the mission's air"),
    "wind_speed": ("wind speed", Allowed(0.0, 120.0), "m/s", "not used"),
}


def _checked_air(
    column: str, columns: Mapping[str, FloatArray], lines: IntArray, stride: int
) -> tuple[FloatArray | None, list[str]]:
    """Return temperature or wind without gaps, None if mostly missing, and notes on repairs.

    ``columns``: columns of the record, NaN where a value is missing. ``lines``: line of each row in
    the file; 0 if rows are not lines, -1 between rows, of which every ``stride``-th exists.
    """
    values = columns.get(column)
    if values is None:
        return None, []
    name, allowed, unit, instead = _AIR[column]
    possible, empty = allowed.holds(values), np.isnan(values)
    wrong = ~possible & ~empty
    what = f"a {name} not {allowed} {unit}"
    first = f"have {what} (first here, {spell(values[np.argmax(wrong)])}): is the unit wrong?"
    notes = _take_out(wrong, lines, what, first, key=column)
    known = np.flatnonzero(possible)
    enough = len(known) >= _LEAST_KNOWN * len(values) / stride
    missing = int(np.count_nonzero(empty & (lines >= 0)))
    if missing or not enough:
        repair = "filled between their neighbours" if enough else instead
        notes.append(f"{name} missing in {missing} of {len(lines)} rows: {repair}")
    return np.interp(np.arange(len(values)), known, values[known]) if enough else None, notes
