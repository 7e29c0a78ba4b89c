"""Files of weather records: which layout a file has, and its table of pvlib.

The files are read by :mod:`pvlib.iotools`; here is what its readers leave open: which layout a file
has, whether a row's time is the start, the middle or the end of its interval, and the names of the
columns. pvlib is imported when a file is read, and only here.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from missions.files.errors import InputError, Problem, file_error, printable, shortened
from missions.weather.record import Site

if TYPE_CHECKING:
    import pandas as pd

MAXIMUM_BYTES = 200_000_000
# Share of the interval that has passed at a row's time.
START, MIDDLE, END = 0.0, 0.5, 1.0

_BSRN_LINES = 40  # a station's name stands within these


class RawTable(NamedTuple):
    """Table of a file, as pvlib gives it.

    Attributes
    ----------
    layout : str
        Kind of the file.
    site : Site
        Where it was taken.
    table : DataFrame
        Columns ``ghi``, ``dni``, ``dhi`` [W/m2], ``temp_air`` [C], ``wind_speed`` [m/s], as far as
        the file has them; its index is the time, with its zone.
    passed : float
        Share of the interval that has passed at a row's time: 0 start, 0.5 middle, 1 end.
    offset_s : float
        Seconds to be added to every row's time.
    first_line : int
        Line of the first row in the file, counted from 1; 0 where a row is no line.
    """

    layout: str
    site: Site
    table: pd.DataFrame
    passed: float
    offset_s: float = 0.0
    first_line: int = 0


def read_layout(path: Path, source: str) -> RawTable:
    """Read a weather file of any known layout.

    Parameters
    ----------
    path : Path
        File: EPW, TMY2, TMY3, PVGIS (typical year or hourly), NSRDB PSM, BSRN, or plain CSV.
    source : str
        Its name, for messages.

    Returns
    -------
    RawTable

    Raises
    ------
    InputError
        If the file cannot be read or has none of these layouts.
    """
    layout = layout_of(path, source)
    read: Callable[[Path, str, Any], RawTable] | None = {
        "EPW": _epw,
        "TMY2": _tmy2,
        "TMY3": _tmy3,
        "PVGIS typical year": _pvgis_tmy,
        "PVGIS hourly": _pvgis_hourly,
        "NSRDB PSM": _psm,
        "BSRN": _bsrn,
    }.get(layout)
    try:
        raw = _plain(path, source) if read is None else read(path, source, _iotools(source))
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


def layout_of(path: Path, source: str) -> str:
    """Layout of a weather file, by its first lines.

    Parameters
    ----------
    path : Path
        File.
    source : str
        Its name, for messages.

    Returns
    -------
    str
        For instance ``EPW``; ``CSV`` for any other table.

    Raises
    ------
    InputError
        If the file cannot be read or is no text.
    """
    head = _head(path, source)
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
    if first.startswith("Source,Location ID"):
        return "NSRDB PSM"
    if re.match(r"\*[UC]0001", first):
        return "BSRN"
    return "CSV"


def _head(path: Path, source: str) -> list[str]:
    """First lines of a file, as text."""
    import gzip

    try:
        if not path.is_file():
            other = "is no regular file" if path.exists() else "there is no such file"
            problem = "is a folder" if path.is_dir() else other
            raise file_error(source, problem)
        if path.stat().st_size > MAXIMUM_BYTES:
            raise file_error(source, f"is larger than {MAXIMUM_BYTES // 1_000_000} MB")
        opener: Callable[..., Any] = gzip.open if path.suffix == ".gz" else open
        with opener(path, "rb") as file:
            start = file.read(16384)
    except (OSError, EOFError) as error:
        raise file_error(source, f"cannot be read: {error}") from error
    if not start.strip():
        raise file_error(source, "is empty")
    if b"\0" in start:
        raise file_error(source, "is no text file")
    return _decoded(start).splitlines()


def _decoded(content: bytes) -> str:
    """Text in UTF-8, or in Latin-1, which many EPW files are written in."""
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _text(path: Path) -> str:
    import gzip

    content = gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()
    return _decoded(content).replace("\r\n", "\n").replace("\r", "\n")


def _epw(path: Path, source: str, iotools: Any) -> RawTable:
    text = _text(path)
    table, meta = iotools.read_epw(io.StringIO(text))
    place = str(meta.get("city", "")).strip()
    name = "" if place.lower() in ("unknown", "-") else place.title()
    site = Site(name, *_numbers(source, meta, "latitude", "longitude", "altitude", "TZ"))
    instant = re.search(
        r"^COMMENTS 2,Irradiance Time Offset \(h\): *(-?[\d.]+)", text, re.MULTILINE
    )
    if instant:
        # PVGIS writes hours of universal time, whatever zone its head names, and counts the offset
        # of its instants from the hour's number, which pvlib takes one from.
        table.index = table.index.tz_localize(None).tz_localize("UTC")
        offset_s = 3600.0 * (1.0 + float(instant[1]))
        utc = replace(site, utc_offset_h=0.0)
        return RawTable("EPW", utc, table, MIDDLE, offset_s=offset_s, first_line=9)
    # An hour of 1 is the first of the day, and pvlib gives its start.
    return RawTable("EPW", site, table, START, first_line=9)


def _tmy2(path: Path, source: str, iotools: Any) -> RawTable:
    table, meta = iotools.read_tmy2(str(path))
    table = table.rename(
        columns={"GHI": "ghi", "DNI": "dni", "DHI": "dhi", "DryBulb": "temp_air", "Wspd": "wind"}
    )
    # Tenths in the file.
    table["temp_air"] = table["temp_air"] / 10.0
    table["wind_speed"] = table.pop("wind") / 10.0
    site = Site(
        str(meta["City"]).strip().title(),
        *_numbers(source, meta, "latitude", "longitude", "altitude", "TZ"),
    )
    return RawTable("TMY2", site, table, START, first_line=2)


def _tmy3(path: Path, source: str, iotools: Any) -> RawTable:
    table, meta = iotools.read_tmy3(io.StringIO(_text(path)), map_variables=True)
    site = Site(
        str(meta.get("Name", "")).strip(' "').title(),
        *_numbers(source, meta, "latitude", "longitude", "altitude", "TZ"),
    )
    return RawTable("TMY3", site, table, END, first_line=3)


def _pvgis_site(source: str, inputs: dict[str, Any]) -> Site:
    place = inputs.get("location", inputs)
    latitude, longitude, altitude = _numbers(source, place, "latitude", "longitude", "elevation")
    return Site("", latitude, longitude, altitude, 0.0)


def _pvgis_tmy(path: Path, source: str, iotools: Any) -> RawTable:
    kind = _pvgis_format(path)
    content = io.StringIO(_text(path)) if kind == "json" else io.BytesIO(_text(path).encode())
    table, meta = iotools.read_pvgis_tmy(content, pvgis_format=kind)
    inputs = meta.get("inputs", {})
    # CSV has it among the inputs, JSON with the place.
    place = inputs.get("location", {})
    given = inputs.get("irradiance time offset", place.get("irradiance_time_offset"))
    offset_h = float(given or 0.0)
    if "latitude" not in inputs and "location" not in inputs:
        raise file_error(source, "does not name its site: write it with its first lines")
    return RawTable(
        "PVGIS typical year",
        _pvgis_site(source, inputs),
        table,
        MIDDLE,
        offset_s=3600.0 * offset_h,
    )


def _pvgis_hourly(path: Path, source: str, iotools: Any) -> RawTable:
    kind = _pvgis_format(path)
    table, meta = iotools.read_pvgis_hourly(io.StringIO(_text(path)), pvgis_format=kind)
    inputs = meta["inputs"]
    slope = _slope_deg(inputs)
    if slope not in (None, 0.0):
        raise file_error(
            source,
            f"is the light on a surface of {slope:g} deg slope: ask PVGIS for a slope of 0",
        )
    import numpy as np

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
    """Slope of the surface that a file of PVGIS is for; None where it does not say."""
    if "Slope" in inputs:
        found = re.search(r"-?[\d.]+", str(inputs["Slope"]))
        return float(found[0]) if found else None
    mounting: Any = next(iter(inputs.get("mounting_system", {}).values()), {})
    value = mounting.get("slope", {}).get("value") if isinstance(mounting, dict) else None
    return None if value is None else float(value)


def _psm(path: Path, source: str, iotools: Any) -> RawTable:
    # pandas 3 refuses the columns without a name, and pvlib's reader with them.
    lines = _text(path).split("\n")
    lines[2] = lines[2].rstrip(", ")
    table, meta = iotools.read_nsrdb_psm4(io.StringIO("\n".join(lines)), map_variables=True)
    city = str(meta.get("City", "")).strip(" -")
    site = Site(city, *_numbers(source, meta, "latitude", "longitude", "altitude", "Time Zone"))
    return RawTable("NSRDB PSM", site, table, MIDDLE, first_line=4)


def _bsrn(path: Path, source: str, iotools: Any) -> RawTable:
    table, meta = iotools.read_bsrn(str(path))
    address = str(meta.get("address", "")).split(",")
    name = address[1].strip() if len(address) > 1 else str(meta.get("address", "")).strip()
    latitude, longitude, altitude = _numbers(source, meta, "latitude", "longitude", "altitude")
    return RawTable("BSRN", Site(name, latitude, longitude, altitude, 0.0), table, START)


def _numbers(source: str, meta: dict[str, Any], *keys: str) -> list[float]:
    """Numbers of a file's head, in the order of the keys."""
    limits = {"latitude": 90.0, "longitude": 180.0, "TZ": 14.0, "Time Zone": 14.0}
    found = []
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
        found.append(value)
    return found


# --- plain CSV -------------------------------------------------------------------------------

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
CSV_HELP = (
    "a plain table begins with lines '# latitude_deg: 46.8', '# longitude_deg: 6.9' and "
    "'# altitude_m: 491', then a line of column names: time_utc (ISO 8601, start of the interval), "
    "ghi, dni, dhi [W/m2] (two of them, or ghi alone), temperature_c, wind_m_per_s"
)


def _plain(path: Path, source: str) -> RawTable:
    """Plain CSV with its site in comment lines."""
    import pandas as pd

    lines = _text(path).split("\n")
    meta, problems = _site_lines(lines, source)
    begin = next((i for i, line in enumerate(lines) if line and not line.startswith("#")), None)
    if begin is None:
        raise file_error(source, f"has no table: {CSV_HELP}")
    names = [name.strip() for name in next(csv.reader([lines[begin]]))]
    unknown = [name for name in names if name not in _COLUMNS]
    chosen = [_COLUMNS[name] for name in names if name in _COLUMNS]
    if "time" not in chosen or not {"ghi", "dni", "dhi"} & set(chosen):
        raise file_error(source, f"is no weather file that is known: {CSV_HELP}")
    if unknown:
        message = f"unknown columns: {', '.join(unknown[:5])}; known: {', '.join(_COLUMNS)}"
        problems.append(Problem(source, begin + 1, None, "", message))
    if len(set(chosen)) < len(chosen):
        problems.append(Problem(source, begin + 1, None, "", "names a column twice"))
    problems += [
        Problem(source, None, None, "", f"lacks the line '# {key}: ...': {CSV_HELP}")
        for key in ("latitude_deg", "longitude_deg", "altitude_m")
        if key not in meta
    ]
    if problems:
        raise InputError(problems)
    table = pd.read_csv(io.StringIO("\n".join(lines[begin:])), skipinitialspace=True)
    table.columns = pd.Index(chosen)
    table = table.set_index(_plain_times(table.pop("time"), meta, source, begin + 2))
    site = Site(
        str(meta.get("name", "")),
        float(meta["latitude_deg"]),
        float(meta["longitude_deg"]),
        float(meta["altitude_m"]),
        float(meta.get("utc_offset_h", 0.0)),
    )
    return RawTable("CSV", site, table, START, first_line=begin + 2)


def _site_lines(lines: list[str], source: str) -> tuple[dict[str, Any], list[Problem]]:
    """Values of the comment lines ``# key: value``, and what is wrong with them."""
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
        if not abs(meta[key]) <= limit:
            message = f"must be a number from {-limit:g} to {limit:g} (got {value[:40]!r})"
            problems.append(Problem(source, number, None, key, message))
    return meta, problems


def _plain_times(column: pd.Series, meta: dict[str, Any], source: str, first: int) -> Any:
    """Times of a plain table; without a zone they are universal."""
    import pandas as pd

    times = pd.to_datetime(column.astype("string"), format="ISO8601", utc=True, errors="coerce")
    wrong = times.isna().to_numpy().nonzero()[0]
    if len(wrong):
        row = int(wrong[0])
        more = f" (and {len(wrong) - 1} more rows)" if len(wrong) > 1 else ""
        message = f"must be ISO 8601 like 2023-06-21T12:00Z (got {str(column.iloc[row])[:40]!r})"
        raise InputError([Problem(source, first + row, None, "time_utc", message + more)])
    return pd.DatetimeIndex(times)
