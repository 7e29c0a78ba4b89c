"""Layouts of weather files, and the table of a file.

Most files are read by :mod:`pvlib.iotools`, imported here alone and on demand. This module adds
the file's layout, the place of a row's time in its interval (start, middle or end), and the names
of the columns.
"""

from __future__ import annotations

import csv
import io
import re
import warnings
from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import timedelta, timezone
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from missions.files.errors import InputError, Problem, printable, refused, shortened, shown
from missions.files.tables import number_of, text_table
from missions.mission import Mission
from missions.units import columns_of
from missions.weather.gridded import columns_named, read_era5_csv, read_netcdf, read_power_csv
from missions.weather.raw import (
    END,
    HEAD_LENGTH,
    MIDDLE,
    START,
    RawTable,
    as_file,
    text_of,
)
from missions.weather.record import TYPICAL_YEAR, Site
from solar.schema import Allowed, refusal, spell

# Keys of a site, and their limits, in the order of its fields.
_SITE = {
    "latitude_deg": Allowed(-90.0, 90.0),
    "longitude_deg": Allowed(-180.0, 180.0),
    "altitude_m": Allowed(-500.0, 9000.0),
    "utc_offset_h": Allowed(-14.0, 14.0),
}


def read_layout(path: Path, mission: Mission | None = None) -> RawTable:
    """Read a weather file: EPW, TMY2, TMY3, PVGIS, SAM, NSRDB PSM, BSRN, NASA POWER, ERA5, CSV.

    ``mission``: its place chooses the point of gridded data.
    """
    text, layout = text_of(path), "NetCDF"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the errors below say what is wrong
            if text is None:
                raw = read_netcdf(path, mission)
            else:
                head = text[:HEAD_LENGTH]
                layout, read = next((n, read) for n, key, read in _LAYOUTS if re.match(key, head))
                raw = read(text)
        for key, allowed in _SITE.items():
            name = key.rpartition("_")[0]
            if trouble := allowed.trouble(f"the {name} of its site", getattr(raw.site, key)):
                raise refused(trouble)
        site = replace(raw.site, name=shortened(printable(raw.site.name)))
        return raw._replace(layout=layout, site=site)
    except (InputError, RecursionError, MemoryError):
        raise
    except Exception as error:  # of a reader that was given a damaged file
        reason = printable(" ".join(str(error).split())[:160])
        raise refused(f"is no readable {layout} file: {type(error).__name__}: {reason}") from error


def _iotools() -> Any:
    try:
        import pvlib.iotools
    except ImportError:
        raise refused("needs pvlib to be read: pip install 'solar-uav-sizing[weather]'") from None
    return pvlib.iotools


def _epw(text: str) -> RawTable:
    table, meta = _iotools().read_epw(io.StringIO(text))
    place = str(meta.get("city", "")).strip()
    name = "" if place.lower() in ("unknown", "-") else place.title()
    site = _site(name, meta, zone="TZ")
    records = int(table.groupby(table.index).size().median())
    if records > 1:  # pvlib leaves out the minutes, which end a record but where the first is zero
        ends = 0 if (table["minute"] == 0).any() else 60 / records
        table.index += pd.to_timedelta(table["minute"].to_numpy() - ends, unit="min")
    instant = re.search(
        r"^COMMENTS 2,Irradiance Time Offset \(h\): *(-?[\d.]+)", text, re.MULTILINE
    )
    if instant or str(meta["data_type"]).strip() == "ECMWF/ERA":
        # PVGIS writes hours of universal time, whatever zone its head names, and counts the offset
        # of its instants from the hour's number, which pvlib takes one from.
        table.index = table.index.tz_localize(None).tz_localize("UTC")
        offset_s = 3600.0 * (1.0 + float(instant[1])) if instant else 0.0
        notes = () if instant else ("hours taken as UTC, as PVGIS before 5.3 wrote them",)
        utc = replace(site, utc_offset_h=0.0)
        return RawTable(utc, table, MIDDLE, offset_s=offset_s, first_line=9, notes=notes)
    # An hour of 1 is the first of the day, and pvlib gives its start.
    return RawTable(site, table, START, first_line=9)


def _tmy2(text: str) -> RawTable:
    with as_file(text) as plain:
        table, meta = _iotools().read_tmy2(plain)
    table = table.rename(
        columns={"GHI": "ghi", "DNI": "dni", "DHI": "dhi", "DryBulb": "temp_air", "Wspd": "wind"}
    )
    # Tenths in the file.
    table["temp_air"] = table["temp_air"] / 10.0
    table["wind_speed"] = table.pop("wind") / 10.0
    site = _site(str(meta["City"]).strip().title(), meta, zone="TZ")
    return RawTable(site, table, START, first_line=2)


def _tmy3(text: str) -> RawTable:
    table, meta = _iotools().read_tmy3(io.StringIO(text), map_variables=True)
    site = _site(str(meta.get("Name", "")).strip(' "').title(), meta, zone="TZ")
    return RawTable(site, table, END, first_line=3)


_FULL_HOURS = "light taken at the full hours: the file does not say by how much it is off them"


def _pvgis_tmy(text: str) -> RawTable:
    kind = _pvgis_format(text)
    content = io.StringIO(text) if kind == "json" else io.BytesIO(text.encode())
    table, meta = _iotools().read_pvgis_tmy(content, pvgis_format=kind)
    inputs = meta.get("inputs", {})
    # CSV has it among the inputs, JSON with the place.
    place = inputs.get("location", {})
    offset_h = inputs.get("irradiance time offset", place.get("irradiance_time_offset"))
    notes = () if offset_h is not None else (_FULL_HOURS,)
    if "latitude" not in inputs and "location" not in inputs:
        raise refused("does not name its site: write it with its first lines")
    site, offset_s = _pvgis_site(inputs), 3600.0 * float(offset_h or 0.0)
    return RawTable(site, table, MIDDLE, offset_s=offset_s, notes=notes)


def _pvgis_hourly(text: str) -> RawTable:
    kind = _pvgis_format(text)
    table, meta = _iotools().read_pvgis_hourly(io.StringIO(text), pvgis_format=kind)
    inputs = meta["inputs"]
    if "Slope" in inputs:
        match = re.search(r"-?[\d.]+", str(inputs["Slope"]))
        slope = match[0] if match else None
    else:
        mounting: Any = next(iter(inputs.get("mounting_system", {}).values()), {})
        slope = mounting.get("slope", {}).get("value") if isinstance(mounting, dict) else None
    if slope is not None and float(slope):
        message = f"is the light on a surface of {spell(float(slope))} deg slope"
        raise refused(f"{message}: ask PVGIS for a slope of 0")
    if "poa_direct" in table:
        beam, sky = table["poa_direct"], table["poa_sky_diffuse"]
        table["ghi"], table["dhi"] = beam + sky, sky
        sine = np.sin(np.radians(table["solar_elevation"]))
        # Below 1 degree a beam divided by its sine is noise.
        table["dni"] = np.where(sine > 0.0175, beam / np.maximum(sine, 0.0175), 0.0)
    else:
        table = table.rename(columns={"poa_global": "ghi"})
    return RawTable(_pvgis_site(inputs), table, MIDDLE)


def _pvgis_format(text: str) -> str:
    """Return the format of a text of PVGIS as pvlib calls it."""
    return "json" if text.startswith("{") else "csv"


def _pvgis_site(inputs: dict[str, Any]) -> Site:
    """Return the site, which JSON has in a record of its own."""
    return _site("", inputs.get("location", inputs), altitude="elevation")


_SAM_HEAD, _SAM_COLUMNS = columns_of("sam_head"), columns_of("sam")  # as read, in this order


def _sam(text: str) -> RawTable:
    names, values = (next(csv.reader([line])) for line in text.split("\n", 2)[:2])
    head = {name.strip().lower(): value.strip() for name, value in zip(names, values, strict=False)}
    place = columns_named(head, _SAM_HEAD)
    site = _site(head.get("city", "").strip(" -"), place, zone="Time Zone")
    units = head.get("units", head.get("hasunits", "")).lower() in ("yes", "1")
    skipped = [0, 1, *([3] if units else [])]
    data = pd.read_csv(io.StringIO(text), skiprows=skipped, index_col=False, low_memory=False)
    columns = {str(name).strip().lower(): data[name] for name in data}
    table = pd.DataFrame(columns_named(columns, _SAM_COLUMNS))
    lacking = [name for name in ("month", "day", "hour") if name not in table]
    if lacking:
        raise refused(f"has no column {lacking[0]}")
    year = table["year"] if "year" in table else pd.Series(TYPICAL_YEAR, table.index)
    date = {"year": year, "month": table["month"], "day": table["day"]}
    days = pd.to_datetime(pd.DataFrame(date).astype(int))
    clock = days + pd.to_timedelta(60.0 * table["hour"] + table.get("minute", 0.0), unit="min")
    zone = timezone(timedelta(hours=site.utc_offset_h))
    table.index = pd.DatetimeIndex(clock).tz_localize(zone)
    # A minute is an instant's, and an hour without one is taken at its middle.
    whole = END if table["hour"].max() == 24 else START
    passed = MIDDLE if "minute" in table else whole
    return RawTable(site, table, passed, first_line=4 + units)


def _bsrn(text: str) -> RawTable:
    with as_file(text) as plain:
        table, meta = _iotools().read_bsrn(plain)
    address = str(meta.get("address", "")).split(",")
    name = address[1].strip() if len(address) > 1 else str(meta.get("address", "")).strip()
    return RawTable(_site(name, meta), table, START)


def _site(
    name: str, head: Mapping[str, Any], *, altitude: str = "altitude", zone: str = ""
) -> Site:
    """Return the site of a file's head; ``altitude``, ``zone``: names of these numbers in it."""
    values = []
    for key, allowed in zip(("latitude", "longitude", altitude, zone), _SITE.values(), strict=True):
        try:
            value = float(head[key]) if key else 0.0
        except (KeyError, TypeError, ValueError):
            raise refused(f"its head has no number for {key}") from None
        if trouble := allowed.trouble("", value):
            raise refused(trouble, line=1, key=key)
        values.append(value)
    return Site(name, *values)


_CSV_COLUMNS = {name: key for key, names in columns_of("csv").items() for name in names}
_CSV_HELP = (
    "a plain table begins with lines '# latitude_deg: 46.8', '# longitude_deg: 6.9' and "
    "'# altitude_m: 491', then a line of column names: time_utc (ISO 8601, start of the interval), "
    "ghi, dni, dhi [W/m²] (two of them, or ghi alone), temperature_c, wind_m_per_s"
)


def _plain(text: str) -> RawTable:
    """Read a plain CSV table with its site in comment lines."""
    head = text_table(text[:HEAD_LENGTH])
    names = [name.strip('"') for name in head.names]
    chosen = [_CSV_COLUMNS[name] for name in names if name in _CSV_COLUMNS]
    lacks = "time" not in chosen or not {"ghi", "dni", "dhi"} & set(chosen)
    if head.line is None or head.separator is None or lacks:
        raise refused(f"is no weather file that is known: {_CSV_HELP}")
    problems = []
    if unknown := [name for name in names if name not in _CSV_COLUMNS]:
        message = f"unknown columns: {', '.join(unknown[:5])}; known: {', '.join(_CSV_COLUMNS)}"
        problems.append(Problem("", head.line, None, "", message))
    if len(set(chosen)) < len(chosen):
        problems.append(Problem("", head.line, None, "", "names a column twice"))
    site: dict[str, Any] = {"name": head.header.get("name", head.header.get("site", ""))}
    for key, allowed in _SITE.items():
        value = head.header.get(key, "0" if key == "utc_offset_h" else None)
        site[key] = number_of(value or "")
        if value is None:
            message = f"lacks the line '# {key}: ...': {_CSV_HELP}"
            problems.append(Problem("", None, None, "", message))
        elif not allowed.holds(site[key]):
            message = refusal(f"must be a number {allowed}", shown(value))
            problems.append(Problem("", head.lines[key], None, key, message))
    for line, row in head.rows[:1]:
        # Of a longer row pandas would take the first values for the names of rows.
        if (count := row.count(",") + 1) > len(names):
            message = f"has {count} values, but the table names {len(names)} columns"
            problems.append(Problem("", line, None, "", message))
    if problems:
        raise InputError(problems)
    # As bytes: text in memory takes four of them for a character.
    content = io.BytesIO(text.encode("utf-8", "surrogatepass"))
    for _ in range(head.line - 1):
        content.readline()
    table = pd.read_csv(content, skipinitialspace=True)
    table.columns = pd.Index(chosen)
    written = table.pop("time")
    times = pd.to_datetime(written.astype("string"), format="ISO8601", utc=True, errors="coerce")
    wrong = times.isna().to_numpy().nonzero()[0]
    if len(wrong):
        got = shown(str(written.iloc[wrong[0]]))
        message = refusal("must be ISO 8601 like 2023-06-21T12:00Z", got)
        line = head.line + 1 + int(wrong[0])
        raise refused(message, line=line, key="time_utc", rows=len(wrong))
    table = table.set_index(pd.DatetimeIndex(times))
    return RawTable(Site(**site), table, START, first_line=head.line + 1)


# SAM's first line: its names of all numbers of a head, in any order.
_SAM = "(?i)" + "".join(
    rf"(?=(?:.*,)?[ \t]*(?:{'|'.join(names)})[ \t]*[,\n])" for names in _SAM_HEAD.values()
)
# Layouts by the first lines of a file, the first that fits.
_Reader = Callable[[str], RawTable]
_LAYOUTS: tuple[tuple[str, str, _Reader], ...] = (
    ("EPW", "LOCATION,", _epw),
    ("TMY2", r" ?\d{5} .{22} [A-Z]{2} +-?\d+ [NS] ", _tmy2),
    ("TMY3", r".*\n.*ETR \(W/m\^2\)", _tmy3),
    ("PVGIS typical year", r"(?s).*time\(UTC\),T2m", _pvgis_tmy),
    ("PVGIS hourly", r'(?s)\{(?=.*"inputs")(?=.*"meteo_data").*"mounting_system"', _pvgis_hourly),
    ("PVGIS typical year", r'(?s)\{(?=.*"inputs").*"meteo_data"', _pvgis_tmy),
    ("PVGIS typical year", r"(?s)Latitude \(decimal degrees\).*month,year", _pvgis_tmy),
    ("PVGIS hourly", r"Latitude \(decimal degrees\)", _pvgis_hourly),
    ("NSRDB PSM", _SAM + r".*\nNSRDB", _sam),
    ("SAM", _SAM + r".*\n.", _sam),
    ("BSRN", r"\*[UC]0001", _bsrn),
    ("NASA POWER", r"(?s)-BEGIN HEADER-.*NASA/POWER", read_power_csv),
    ("ERA5", r"(?=.*valid_time).*ssrd", read_era5_csv),
    ("CSV", "", _plain),
)
