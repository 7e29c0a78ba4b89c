"""Plain CSV tables of weather, with the site in comment lines."""

from __future__ import annotations

import csv
import io
import math
import re
from typing import Any

import pandas as pd

from missions.files.errors import InputError, Problem, refused, shown
from missions.weather.raw import START, RawTable
from missions.weather.record import Site
from solar.schema import Allowed, refusal

_SITE_KEYS = {
    "latitude_deg": 90.0,
    "longitude_deg": 180.0,
    "altitude_m": 9000.0,
    "utc_offset_h": 14.0,
}
_COLUMNS = {
    "time_utc": "time",
    "time": "time",
    "ghi": "ghi",
    "ghi_w_per_m2": "ghi",
    "dni": "dni",
    "dni_w_per_m2": "dni",
    "dhi": "dhi",
    "dhi_w_per_m2": "dhi",
    "temperature_c": "temp_air",
    "temp_air": "temp_air",
    "wind_m_per_s": "wind_speed",
    "wind_speed": "wind_speed",
}
_COMMENTS = re.compile(r"(?:(?:#[^\n]*)?\n)*")
_ROW = re.compile(r"\S[^\n]*")
CSV_HELP = (
    "a plain table begins with lines '# latitude_deg: 46.8', '# longitude_deg: 6.9' and "
    "'# altitude_m: 491', then a line of column names: time_utc (ISO 8601, start of the interval), "
    "ghi, dni, dhi [W/m²] (two of them, or ghi alone), temperature_c, wind_m_per_s"
)


def read_plain(text: str) -> RawTable:
    """Read a plain CSV table with its site in comment lines."""
    start = _COMMENTS.match(text).end()  # type: ignore[union-attr]  # matches any text
    comments, end = text[:start].split("\n")[:-1], text.find("\n", start)
    header, begin = text[start : end if end >= 0 else None], len(comments)
    meta, problems = _site_lines(comments)
    if not header or header.startswith("#"):
        raise refused(f"has no table: {CSV_HELP}")
    names = [name.strip() for name in next(csv.reader([header]))]
    unknown = [name for name in names if name not in _COLUMNS]
    chosen = [_COLUMNS[name] for name in names if name in _COLUMNS]
    if "time" not in chosen or not {"ghi", "dni", "dhi"} & set(chosen):
        raise refused(f"is no weather file that is known: {CSV_HELP}")
    if unknown:
        message = f"unknown columns: {', '.join(unknown[:5])}; known: {', '.join(_COLUMNS)}"
        problems.append(Problem("", begin + 1, None, "", message))
    if len(set(chosen)) < len(chosen):
        problems.append(Problem("", begin + 1, None, "", "names a column twice"))
    problems += [
        Problem("", None, None, "", f"lacks the line '# {key}: ...': {CSV_HELP}")
        for key in ("latitude_deg", "longitude_deg", "altitude_m")
        if key not in meta
    ]
    row = _ROW.search(text, start + len(header))
    count = len(next(csv.reader([row[0]]))) if row else 0
    if row and count > len(names):  # pandas would take the first of them for the names of rows
        message = f"has {count} values, but the table names {len(names)} columns"
        line = begin + 1 + text.count("\n", start, row.start())
        problems.append(Problem("", line, None, "", message))
    if problems:
        raise InputError(problems)
    # As bytes: text in memory takes four of them for a character.
    content = io.BytesIO(text[start:].encode("utf-8", "surrogatepass"))
    table = pd.read_csv(content, skipinitialspace=True)
    table.columns = pd.Index(chosen)
    written = table.pop("time")
    times = pd.to_datetime(written.astype("string"), format="ISO8601", utc=True, errors="coerce")
    wrong = times.isna().to_numpy().nonzero()[0]
    if len(wrong):
        got = shown(str(written.iloc[wrong[0]]))
        message = refusal("must be ISO 8601 like 2023-06-21T12:00Z", got)
        raise refused(message, line=begin + 2 + int(wrong[0]), key="time_utc", rows=len(wrong))
    table = table.set_index(pd.DatetimeIndex(times))
    site = Site(**{"name": "", "utc_offset_h": 0.0, **meta})
    return RawTable(site, table, START, first_line=begin + 2)


def _site_lines(lines: list[str]) -> tuple[dict[str, Any], list[Problem]]:
    """Return the values of comment lines ``# key: value``, and problems with them."""
    meta: dict[str, Any] = {}
    problems = []
    for number, line in enumerate(lines, start=1):
        if not line.startswith("#"):
            break
        key, colon, value = line.lstrip("# ").partition(":")
        key, value = key.strip(), value.strip()
        if key in ("name", "site") and colon:
            meta["name"] = value
        if key not in _SITE_KEYS or not colon:
            continue
        limit = _SITE_KEYS[key]
        try:
            meta[key] = float(value)
        except ValueError:
            meta[key] = math.nan
        if not (allowed := Allowed(-limit, limit)).holds(meta[key]):
            message = refusal(f"must be a number {allowed}", shown(value))
            problems.append(Problem("", number, None, key, message))
    return meta, problems
