"""Layouts of weather files, and the table of a file.

Most files are read by :mod:`pvlib.iotools`, imported here alone and on demand. This module adds
the file's layout, the place of a row's time in its interval (start, middle or end), and the names
of the columns.
"""

from __future__ import annotations

import csv
import io
import math
import re
import warnings
from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import timedelta, timezone
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from missions.files.errors import InputError, Problem, file_error, printable, shortened
from missions.mission import Mission
from missions.weather.gridded import is_netcdf, read_era5_csv, read_netcdf, read_power_csv
from missions.weather.plain import read_plain
from missions.weather.raw import END, MIDDLE, START, RawTable, as_file, head_of, text_of
from missions.weather.record import TYPICAL_YEAR, Site


def read_layout(path: Path, source: str, mission: Mission | None = None) -> RawTable:
    """Read a weather file: EPW, TMY2, TMY3, PVGIS, SAM, NSRDB PSM, BSRN, NASA POWER, ERA5, CSV.

    ``mission``: its place chooses the point of gridded data.
    """
    layout = "NetCDF" if is_netcdf(path) else layout_of(path, source)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the errors below say what is wrong
            if layout == "NetCDF":
                raw = read_netcdf(path, source, mission)
            else:
                raw = _READERS.get(layout, read_plain)(path, source)
        _check_place(raw.site, source)
        return raw._replace(site=replace(raw.site, name=shortened(printable(raw.site.name))))
    except InputError:
        raise
    except (RecursionError, MemoryError):
        raise
    except Exception as error:  # of a reader that was given a damaged file
        reason = printable(" ".join(str(error).split())[:160])
        raise file_error(
            source, f"is no readable {layout} file: {type(error).__name__}: {reason}"
        ) from error


def _iotools(source: str) -> Any:
    try:
        import pvlib.iotools
    except ImportError:
        message = "needs pvlib to be read: pip install 'solar-uav-sizing[weather]'"
        raise file_error(source, message) from None
    return pvlib.iotools


def _check_place(site: Site, source: str) -> None:
    """Refuse an impossible place."""
    for name, value, lowest, highest in (
        ("latitude", site.latitude_deg, -90.0, 90.0),
        ("longitude", site.longitude_deg, -180.0, 360.0),
        ("altitude", site.altitude_m, -500.0, 9000.0),
    ):
        if not lowest <= value <= highest:
            allowed = f"allowed: {lowest:g} to {highest:g}"
            raise file_error(source, f"has its site at the {name} {value:g}; {allowed}")


def layout_of(path: Path, source: str) -> str:
    """Return the layout of a weather file by its first lines, ``CSV`` for any other table."""
    head = head_of(path, source)
    first = head[0] if head else ""
    text = "\n".join(head)
    if first.startswith("LOCATION,"):
        return "EPW"
    if re.match(r" ?\d{5} .{22} [A-Z]{2} +-?\d+ [NS] ", first):
        return "TMY2"
    if len(head) > 1 and "ETR (W/m^2)" in head[1]:
        return "TMY3"
    if "time(UTC),T2m" in text:
        return "PVGIS typical year"
    if first.startswith("{") and '"inputs"' in text and '"meteo_data"' in text:
        return "PVGIS hourly" if '"mounting_system"' in text else "PVGIS typical year"
    if first.startswith("Latitude (decimal degrees)"):
        return "PVGIS typical year" if "month,year" in text else "PVGIS hourly"
    fields = {name.strip().lower() for name in first.split(",")}
    if len(head) > 1 and all(fields & set(names) for names in _SAM_HEAD.values()):
        return _sam_layout(head[1].split(","))
    if re.match(r"\*[UC]0001", first):
        return "BSRN"
    if first.startswith("-BEGIN HEADER-") and "NASA/POWER" in text:
        return "NASA POWER"
    if "valid_time" in first and "ssrd" in first:
        return "ERA5"
    return "CSV"


def _epw(path: Path, source: str) -> RawTable:
    text = text_of(path)
    table, meta = _iotools(source).read_epw(io.StringIO(text))
    place = str(meta.get("city", "")).strip()
    name = "" if place.lower() in ("unknown", "-") else place.title()
    site = Site(name, *_head_values(source, meta, "latitude", "longitude", "altitude", "TZ"))
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
        return RawTable("EPW", utc, table, MIDDLE, offset_s=offset_s, first_line=9, notes=notes)
    # An hour of 1 is the first of the day, and pvlib gives its start.
    return RawTable("EPW", site, table, START, first_line=9)


def _tmy2(path: Path, source: str) -> RawTable:
    with as_file(path) as plain:
        table, meta = _iotools(source).read_tmy2(plain)
    table = table.rename(
        columns={"GHI": "ghi", "DNI": "dni", "DHI": "dhi", "DryBulb": "temp_air", "Wspd": "wind"}
    )
    # Tenths in the file.
    table["temp_air"] = table["temp_air"] / 10.0
    table["wind_speed"] = table.pop("wind") / 10.0
    site = Site(
        str(meta["City"]).strip().title(),
        *_head_values(source, meta, "latitude", "longitude", "altitude", "TZ"),
    )
    return RawTable("TMY2", site, table, START, first_line=2)


def _tmy3(path: Path, source: str) -> RawTable:
    table, meta = _iotools(source).read_tmy3(io.StringIO(text_of(path)), map_variables=True)
    site = Site(
        str(meta.get("Name", "")).strip(' "').title(),
        *_head_values(source, meta, "latitude", "longitude", "altitude", "TZ"),
    )
    return RawTable("TMY3", site, table, END, first_line=3)


def _pvgis_site(source: str, inputs: dict[str, Any]) -> Site:
    place = inputs.get("location", inputs)
    latitude, longitude, altitude = _head_values(
        source, place, "latitude", "longitude", "elevation"
    )
    return Site("", latitude, longitude, altitude, 0.0)


_FULL_HOURS = "light taken at the full hours: the file does not say by how much it is off them"


def _pvgis_tmy(path: Path, source: str) -> RawTable:
    kind = _pvgis_format(path)
    content = io.StringIO(text_of(path)) if kind == "json" else io.BytesIO(text_of(path).encode())
    table, meta = _iotools(source).read_pvgis_tmy(content, pvgis_format=kind)
    inputs = meta.get("inputs", {})
    # CSV has it among the inputs, JSON with the place.
    place = inputs.get("location", {})
    offset_h = inputs.get("irradiance time offset", place.get("irradiance_time_offset"))
    notes = () if offset_h is not None else (_FULL_HOURS,)
    if "latitude" not in inputs and "location" not in inputs:
        raise file_error(source, "does not name its site: write it with its first lines")
    site, offset_s = _pvgis_site(source, inputs), 3600.0 * float(offset_h or 0.0)
    return RawTable("PVGIS typical year", site, table, MIDDLE, offset_s=offset_s, notes=notes)


def _pvgis_hourly(path: Path, source: str) -> RawTable:
    kind = _pvgis_format(path)
    table, meta = _iotools(source).read_pvgis_hourly(io.StringIO(text_of(path)), pvgis_format=kind)
    inputs = meta["inputs"]
    slope = _slope_deg(inputs)
    if slope not in (None, 0.0):
        raise file_error(
            source, f"is the light on a surface of {slope:g} deg slope: ask PVGIS for a slope of 0"
        )

    if "poa_direct" in table:
        beam, sky = table["poa_direct"], table["poa_sky_diffuse"]
        table["ghi"], table["dhi"] = beam + sky, sky
        sine = np.sin(np.radians(table["solar_elevation"]))
        # Below 1 degree a beam divided by its sine is noise.
        table["dni"] = np.where(sine > 0.0175, beam / np.maximum(sine, 0.0175), 0.0)
    else:
        table = table.rename(columns={"poa_global": "ghi"})
    return RawTable("PVGIS hourly", _pvgis_site(source, inputs), table, MIDDLE)


def _pvgis_format(path: Path) -> str:
    name = path.name.removesuffix(".gz").lower()
    return "json" if name.endswith(".json") else "csv"


def _slope_deg(inputs: dict[str, Any]) -> float | None:
    """Return the slope of the surface of PVGIS' light, None if not stated."""
    if "Slope" in inputs:
        match = re.search(r"-?[\d.]+", str(inputs["Slope"]))
        return float(match[0]) if match else None
    mounting: Any = next(iter(inputs.get("mounting_system", {}).values()), {})
    value = mounting.get("slope", {}).get("value") if isinstance(mounting, dict) else None
    return None if value is None else float(value)


# Names of SAM (System Advisor Model, weather file format CSV), whose layout NSRDB PSM has too; in
# the order of what is read.
_SAM_HEAD = {
    "latitude": ("latitude", "lat"),
    "longitude": ("longitude", "lon", "long", "lng"),
    "altitude": ("elevation", "elev", "el", "site elevation"),
    "Time Zone": ("time zone", "timezone", "tz"),
}
_SAM_COLUMNS = {
    "year": ("year", "yr"),
    "month": ("month", "mo"),
    "day": ("day",),
    "hour": ("hour", "hr"),
    "minute": ("minute", "min"),
    "ghi": ("ghi", "gh", "global", "global horizontal", "global horizontal irradiance"),
    "dni": ("dni", "dn", "beam", "direct normal", "direct normal irradiance"),
    "dhi": ("dhi", "df", "diffuse", "diffuse horizontal", "diffuse horizontal irradiance"),
    "temp_air": ("tdry", "temperature", "dry bulb", "dry bulb temp", "ambient", "ambient temp"),
    "wind_speed": ("wspd", "wind speed"),
}


def _sam(path: Path, source: str) -> RawTable:
    text = text_of(path)
    names, values = (next(csv.reader([line])) for line in text.split("\n", 2)[:2])
    head = {name.strip().lower(): value.strip() for name, value in zip(names, values, strict=False)}
    site = Site(
        head.get("city", "").strip(" -"),
        *_head_values(source, _select_columns(head, _SAM_HEAD), *_SAM_HEAD),
    )
    units = head.get("units", head.get("hasunits", "")).lower() in ("yes", "1")
    skipped = [0, 1, *([3] if units else [])]
    data = pd.read_csv(io.StringIO(text), skiprows=skipped, index_col=False, low_memory=False)
    columns = {str(name).strip().lower(): data[name] for name in data}
    table = pd.DataFrame(_select_columns(columns, _SAM_COLUMNS))
    lacking = [name for name in ("month", "day", "hour") if name not in table]
    if lacking:
        raise file_error(source, f"has no column {lacking[0]}")
    year = table["year"] if "year" in table else pd.Series(TYPICAL_YEAR, table.index)
    date = {"year": year, "month": table["month"], "day": table["day"]}
    days = pd.to_datetime(pd.DataFrame(date).astype(int))
    clock = days + pd.to_timedelta(60.0 * table["hour"] + table.get("minute", 0.0), unit="min")
    zone = timezone(timedelta(hours=site.utc_offset_h))
    table.index = pd.DatetimeIndex(clock).tz_localize(zone)
    # A minute is an instant's, and an hour without one is taken at its middle.
    whole = END if table["hour"].max() == 24 else START
    passed = MIDDLE if "minute" in table else whole
    return RawTable(_sam_layout(values), site, table, passed, first_line=4 + units)


def _sam_layout(values: list[str]) -> str:
    """Return the layout's name by the first word below SAM's heading."""
    return "NSRDB PSM" if values and values[0].startswith("NSRDB") else "SAM"


def _select_columns(
    columns: Mapping[str, Any], names: Mapping[str, tuple[str, ...]]
) -> dict[str, Any]:
    """Return columns by quantity, each by the first of its known names."""
    present = {key: next((n for n in known if n in columns), None) for key, known in names.items()}
    return {key: columns[name] for key, name in present.items() if name is not None}


def _bsrn(path: Path, source: str) -> RawTable:
    with as_file(path) as plain:
        table, meta = _iotools(source).read_bsrn(plain)
    address = str(meta.get("address", "")).split(",")
    name = address[1].strip() if len(address) > 1 else str(meta.get("address", "")).strip()
    latitude, longitude, altitude = _head_values(source, meta, "latitude", "longitude", "altitude")
    return RawTable("BSRN", Site(name, latitude, longitude, altitude, 0.0), table, START)


def _head_values(source: str, meta: dict[str, Any], *keys: str) -> list[float]:
    """Return numbers of a file's head, in the order of the keys."""
    limits = {"latitude": 90.0, "longitude": 180.0, "TZ": 14.0, "Time Zone": 14.0}
    values = []
    for key in keys:
        try:
            value = float(meta[key])
        except (KeyError, TypeError, ValueError):
            raise file_error(source, f"its head has no number for {key}") from None
        limit = limits.get(key, 9000.0)
        if not math.isfinite(value) or abs(value) > limit:
            raise InputError(
                [Problem(source, 1, None, key, f"must be from {-limit:g} to {limit:g}")]
            )
        values.append(value)
    return values


_READERS: dict[str, Callable[[Path, str], RawTable]] = {
    "EPW": _epw,
    "TMY2": _tmy2,
    "TMY3": _tmy3,
    "PVGIS typical year": _pvgis_tmy,
    "PVGIS hourly": _pvgis_hourly,
    "NSRDB PSM": _sam,
    "SAM": _sam,
    "BSRN": _bsrn,
    "NASA POWER": read_power_csv,
    "ERA5": read_era5_csv,
}
