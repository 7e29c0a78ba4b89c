"""Weather records from gridded data: NetCDF of ERA5, NASA POWER and others, and their CSV.

Variables are known by their names or CF standard names, axes as in :mod:`missions.winds.netcdf`;
grids are read at the point nearest to the mission. ERA5 gives the light of the hour that ends at a
row's time, whatever the rows' spacing, ERA5-Land the light since 00 UTC (ECMWF, data
documentation of both), NASA POWER the light of the hour that begins at a row's time.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from missions.air import pressure_altitude_m
from missions.files.errors import refused
from missions.mission import Mission
from missions.units import columns_of, unit_of
from missions.weather.checks import MISSING
from missions.weather.raw import END, START, RawTable
from missions.weather.record import SECONDS_PER_HOUR, Site
from missions.winds import netcdf
from missions.winds.table import neighbours
from solar.schema import spell
from solar.sun import SECONDS_PER_DAY
from solar.types import FloatArray

if TYPE_CHECKING:
    import xarray as xr


_NAMES = columns_of("grid")
_DIMENSIONS = {
    "temp_air": ("temperature",),
    "ground": ("length", "geopotential"),
    "pressure": ("pressure",),
    **dict.fromkeys(("wind_speed", "u", "v"), ("speed",)),
    **dict.fromkeys(("ghi", "direct", "dni", "dhi"), ("irradiance",)),
}
_ERA5 = {*_NAMES["ghi"][:3], *_NAMES["direct"]}
_POWER_UNITS = {"temp_air": "C", "wind_speed": "m/s"} | dict.fromkeys(("ghi", "dni", "dhi"), "W/m2")
_MOST_DIRECT = 1.01  # of global light; the two are rounded
_LEAST_GROUND_PA = 40000.0  # 7.2 km
_PACKED = 1e-3  # of the largest value: rounding of packed files
_SINCE_MIDNIGHT = "light summed up from 00 UTC, as of ERA5-Land, taken apart by the row"
_SEA_LEVEL = "height of the ground unknown: taken as sea level"


def read_netcdf(path: Path, mission: Mission | None) -> RawTable:
    """Read the grid point nearest to a mission, the only one without a mission."""
    with netcdf.opened(str(path)) as data:
        known = {key: netcdf.find_variable(data, names) for key, names in _NAMES.items()}
        first = next((variable for variable in known.values() if variable is not None), None)
        if first is None or (known["ghi"] is None and known["dni"] is None):
            names = ", ".join(_NAMES["ghi"][:4])
            raise refused(f"has no light (variables named {names}, ...)")
        point = _nearest_point(data, mission)
        columns = {}
        air_m = None
        for key, variable in known.items():
            if variable is None:
                continue
            values, height = _values_at_point(point[variable.name], mission)
            air_m = height if key == "temp_air" and height is not None else air_m
            columns[key] = _convert_units(values, str(variable.attrs.get("units", "")), key)
        index = pd.DatetimeIndex(netcdf.axis_of(data, "time").to_numpy(), tz="UTC")
        passed = END if known["ghi"] is not None and known["ghi"].name in _ERA5 else START
        latitude, longitude = float(point["latitude"]), netcdf.east_deg(float(point["longitude"]))
    table = _make_table(columns, index, (latitude, longitude), passed)
    return table._replace(air_altitude_m=air_m)


def read_era5_csv(text: str) -> RawTable:
    """Read ERA5 hourly time series, CSV of the Climate Data Store."""
    data = pd.read_csv(io.StringIO(text))
    if "expver" in data:  # final and preliminary rows, each with gaps where the other one stands
        data = data.sort_values(["valid_time", "expver"], kind="stable")
        data = data.groupby("valid_time", as_index=False).first()
    ends = [float(data[name].mean()) for name in ("latitude", "longitude") if name in data]
    if len(ends) < 2:
        raise refused("does not name its place: latitude and longitude are needed")
    columns = {key: column.to_numpy(float) for key, column in columns_named(data).items()}
    units = {"ghi": "J/m2", "direct": "J/m2", "temp_air": "K"}
    columns |= {
        key: _convert_units(columns[key], units[key], key) for key in units & columns.keys()
    }
    index = pd.DatetimeIndex(pd.to_datetime(data["valid_time"], utc=True))
    place = (ends[0], netcdf.east_deg(ends[1]))
    return _make_table(columns, index, place, END)._replace(first_line=2)


def read_power_csv(text: str) -> RawTable:
    """Read NASA POWER's hourly point data."""
    head = text[: text.find("-END HEADER-")] if "-END HEADER-" in text else text
    place = re.search(r"latitude\s+(-?[\d.]+)\s+longitude\s+(-?[\d.]+)", head, re.IGNORECASE)
    ground = re.search(r"elevation.*=\s*(-?[\d.]+)\s*meters", head, re.IGNORECASE)
    if place is None:
        raise refused("does not name its place: write it with its first lines")
    latitude, longitude = float(place[1]), float(place[2])

    def written_unit(key: str) -> str:
        names = "|".join(map(re.escape, _NAMES[key]))
        match = re.search(rf"^(?:{names})\s.*\(([^()]+)\)\s*$", head, re.MULTILINE)
        return _POWER_UNITS.get(key, "m") if match is None else match[1].strip()

    data = pd.read_csv(io.StringIO(text), skiprows=head.count("\n") + 1)
    columns = {
        key: np.where(
            np.isin(values, MISSING) & (values < 0.0),
            np.nan,
            _convert_units(values.to_numpy(float), written_unit(key), key),
        )
        for key, values in columns_named(data).items()
    }
    parts = {"year": data["YEAR"], "month": data["MO"], "day": data["DY"], "hour": data["HR"]}
    index = pd.DatetimeIndex(pd.to_datetime(pd.DataFrame(parts), utc=True))
    notes: tuple[str, ...] = ()
    if re.search(r"\bin\s+LST\b", head):
        # NASA POWER, Hourly API, Time Standards: moved by the hours of the 15-degree swath.
        ahead_h = math.floor(longitude / 15.0 + 0.5)
        index -= pd.Timedelta(hours=ahead_h)
        notes = (f"local solar time taken as UTC{ahead_h:+d} h, that of its belt of 15 degrees",)
    if ground is not None and float(ground[1]) not in MISSING:
        columns["ground"] = np.array([float(ground[1])])
    table = _make_table(columns, index, (latitude, longitude), START)
    return table._replace(first_line=head.count("\n") + 3, notes=(*notes, *table.notes))


def columns_named(columns: Any, names: Mapping[str, tuple[str, ...]] = _NAMES) -> dict[str, Any]:
    """Return columns by quantity, each by the first of its known names."""
    present = {key: next((n for n in known if n in columns), None) for key, known in names.items()}
    return {key: columns[name] for key, name in present.items() if name is not None}


def _make_table(
    columns: dict[str, FloatArray],
    index: pd.DatetimeIndex,
    place: tuple[float, float],
    passed: float,
) -> RawTable:
    """Make a table of a file's columns; diffuse light is global less direct horizontal light."""
    light = columns.keys() & {"ghi", "direct"}
    apart = {key: _means_between_rows(columns[key], index) for key in light if passed == END}
    since_midnight = bool(apart) and all(values is not None for values in apart.values())
    columns |= {key: values for key, values in apart.items() if values is not None}
    if {"direct", "ghi"} <= columns.keys() and "dhi" not in columns:
        if np.nansum(columns["direct"]) > _MOST_DIRECT * np.nansum(columns["ghi"]):
            raise refused("has more direct than global light: is the unit wrong?")
        columns["dhi"] = np.maximum(columns["ghi"] - columns["direct"], 0.0)
    if "u" in columns and "v" in columns and "wind_speed" not in columns:
        columns["wind_speed"] = np.hypot(columns["u"], columns["v"])
    if "ground" in columns:
        ground_m = float(np.nanmean(columns["ground"]))
    elif "pressure" in columns:
        pressure_pa = float(np.nanmean(columns["pressure"]))
        if pressure_pa < _LEAST_GROUND_PA:
            raise refused(f"has a pressure at the ground of {spell(pressure_pa)} Pa")
        ground_m = float(pressure_altitude_m(pressure_pa))
    else:
        ground_m = np.nan
    kept = ("ghi", "dni", "dhi", "temp_air", "wind_speed")
    table = pd.DataFrame({k: columns[k] for k in kept if k in columns}, index=index)
    flat = not np.isfinite(ground_m)
    notes = ((_SINCE_MIDNIGHT,) if since_midnight else ()) + ((_SEA_LEVEL,) if flat else ())
    site = Site("", *place, 0.0 if flat else ground_m, 0.0)
    hour_s = SECONDS_PER_HOUR if passed == END and not since_midnight else None
    return RawTable(site, table, passed, interval_s=hour_s, notes=notes)


def _means_between_rows(values: FloatArray, index: pd.DatetimeIndex) -> FloatArray | None:
    """Return means between rows of light that accumulates from 00 UTC, None for other light.

    Of other light the sum falls, at the latest from noon on. ``values``: sums over an hour.
    """
    end_s = index.tz_localize(None).to_numpy("datetime64[s]").astype(float)
    steps_s = np.diff(end_s)
    if not len(steps_s) or steps_s.min() <= 0.0:
        return None
    midnight_s = np.floor((end_s - 1.0) / SECONDS_PER_DAY) * SECONDS_PER_DAY
    before_s = np.concatenate([[-np.inf], end_s[:-1]])
    same_day = before_s > midnight_s
    rise = values - np.where(same_day, np.concatenate([[0.0], values[:-1]]), 0.0)
    most = np.nanmax(values)
    if not most > 0.0 or np.nanmin(rise) < -_PACKED * most:
        return None
    since_s = end_s - np.maximum(before_s, midnight_s)
    mean = np.maximum(rise, 0.0) * SECONDS_PER_HOUR / since_s
    return np.where(since_s > 1.5 * np.median(steps_s), np.nan, mean)


def _nearest_point(data: xr.Dataset, mission: Mission | None) -> xr.Dataset:
    """Return the data of the grid point nearest to the mission."""
    wanted = (None, None) if mission is None else (mission.latitudes()[0], mission.longitude_deg)
    place = {}
    for name, degrees in zip(("latitude", "longitude"), wanted, strict=True):
        values = netcdf.degrees_of(netcdf.axis_of(data, name))
        if not len(values) or not np.all(np.isfinite(values)):
            raise refused(f"has a {name} without values, or one that is no number")
        if degrees is None and len(values) > 1:
            key = f"{name}_deg"
            raise refused(f"has {len(values)} values of {key}: give {key} on the mission")
        alone = len(values) == 1
        place[name] = 0 if alone or degrees is None else netcdf.nearest(name, values, degrees)
    return data.isel({name: index for name, index in place.items() if name in data.dims})


def _values_at_point(
    variable: xr.DataArray, mission: Mission | None
) -> tuple[FloatArray, float | None]:
    """Return values over time at a grid point, and their altitude [m] if there are levels.

    Levels are interpolated at the mission's altitude.
    """
    at = netcdf.without_other_axes(variable)
    if "level" not in at.dims:
        return netcdf.values_of(at), None
    if "time" not in at.dims:
        raise refused(f"has {variable.name} on levels, but not over time")
    heights = netcdf.altitudes_m(at["level"])
    order = np.argsort(heights)
    altitude_m = heights[order[0]] if mission is None else mission.altitude_m
    if not heights[order[0]] <= altitude_m <= heights[order[-1]]:
        raise netcdf.not_of_the_mission(
            f"{variable.name} at altitude_m", heights.round(), altitude_m
        )
    values = netcdf.values_of(at.transpose("time", "level"))[:, order]
    lower, upper, share = neighbours(heights[order], altitude_m)
    return (1.0 - share) * values[:, lower] + share * values[:, upper], float(altitude_m)


def _convert_units(values: FloatArray, unit: str, key: str) -> FloatArray:
    """Convert values to W/m2, C, m/s, m or Pa."""
    scale = unit_of(unit, key, *_DIMENSIONS[key])
    return scale.factor * values + scale.offset
