"""Percentiles of the wind from NetCDF files with its components, such as those of ERA5.

Axes are known by their names, so that their order plays no part; longitudes may count from 0 to 360
or from -180 to 180, latitudes and levels up or down.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from functools import reduce
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.air import MAXIMUM_ALTITUDE_M, MINIMUM_ALTITUDE_M, pressure_altitude_m
from missions.files.errors import InputError, file_error, printable
from missions.files.texts import open_plain
from missions.winds.table import STRONGEST_M_PER_S, WindTable
from solar.types import FloatArray

if TYPE_CHECKING:
    import xarray as xr


# What a file is reduced to, beside the percentile that is asked for.
PERCENTILES = (5.0, 10.0, 25.0, 50.0, 75.0, 90.0, 95.0, 99.0)
# Names of axes: those of ERA5 before and after its change of 2024, and of the CF conventions.
AXES = {
    "time": ("time", "valid_time"),
    "latitude": ("latitude", "lat"),
    "longitude": ("longitude", "lon"),
    "level": ("pressure_level", "level", "isobaricInhPa", "plev", "height", "altitude"),
}
_COMPONENTS = {
    "eastward_wind": ("u", "u_component_of_wind", "ua"),
    "northward_wind": ("v", "v_component_of_wind", "va"),
}
_PASCALS = {"hpa": 100.0, "millibars": 100.0, "millibar": 100.0, "mbar": 100.0, "pa": 1.0}
_METRES = {"m": 1.0, "metre": 1.0, "meter": 1.0, "metres": 1.0, "meters": 1.0, "km": 1000.0}
_SPEEDS = {
    ("m/s", "ms-1", "meters/second", "metres/second", "metersecond-1"): 1.0,
    ("km/h", "kmh-1", "kmhr-1", "kph"): 1.0 / 3.6,
    ("knots", "knot", "kt", "kts", "kn"): 1852.0 / 3600.0,
}


_HDF5 = b"\x89HDF"
# A century of hours is 0.9 million; what is read at once is then some 2 GB in memory.
_LONGEST_AXIS, _MOST_AT_ONCE = 10_000_000, 100_000_000


def wind_table_from_netcdf(
    path: str, longitude_deg: float | None = None, *, also: float | None = None
) -> WindTable:
    """Percentiles of the wind speed in a file of its components over time."""
    source = printable(path)
    with opened(path, source) as data:
        u, v = (_component(data, name, source) for name in _COMPONENTS)
        u, v = (_arranged(one, source) for one in (u, v))
        factors = [_to_m_per_s(one, source) for one in (u, v)]
        if u.shape != v.shape:
            raise file_error(source, "has components of the wind on different axes")
        u, v, at = _at_longitude(u, v, longitude_deg, source)
        months = _months(u, source)
        altitude_m = altitudes_m(u["level"], source)
        kept = (altitude_m >= MINIMUM_ALTITUDE_M) & (altitude_m <= MAXIMUM_ALTITUDE_M)
        levels = np.flatnonzero(kept)[np.argsort(altitude_m[kept])]
        latitudes = latitudes_deg(u["latitude"], source)
        if not len(levels):
            raise file_error(source, f"has no level up to {MAXIMUM_ALTITUDE_M:g} m")
        percentiles = np.array(sorted({*PERCENTILES, *([] if also is None else [also])}))
        known = sorted(set(months.tolist()))
        north = np.argsort(latitudes)
        winds = np.stack(
            [
                _of_latitude(
                    _speed_m_per_s(u[:, i, levels], v[:, i, levels], factors, source),
                    *(months, known, percentiles),
                )
                for i in north.tolist()
            ]
        )
    if not np.isfinite(winds).all():
        raise file_error(source, "has gaps in the wind")
    fewest = min(int(np.sum(months == month)) for month in known) * u.shape[-1]
    sampled = percentiles[percentiles <= 100.0 * (1.0 - 1.0 / fewest)]
    if also is not None and also not in sampled:
        message = f"has {fewest} values in a month, too few for percentile {also:g}"
        raise file_error(source, message)
    table = f"{source} ({at})"
    return WindTable(
        table,
        latitudes[north],
        altitude_m[levels],
        tuple(known),
        sampled,
        winds[..., : len(sampled)],
    )


@contextmanager
def opened(path: str, source: str) -> Iterator[xr.Dataset]:
    """Dataset of a NetCDF file while it is read."""
    import xarray as xr

    try:
        with open_plain(path) as file:
            packed = file.read(len(_HDF5)) == _HDF5  # else it is no larger than its file
        if packed:
            _check_sizes(path, source)
        with xr.open_dataset(path) as data:
            yield data
    except InputError:
        raise
    except Exception as error:  # the libraries raise whatever a damaged file makes them trip over
        reason = printable(" ".join(str(error).split()))[:160]
        raise file_error(source, f"cannot be read as NetCDF: {reason}") from error


def _check_sizes(path: str, source: str) -> None:
    """Refuse a file that unpacks to more than is ever read of one at once.

    Axes are unpacked whole, other variables chunk by chunk.
    """
    import h5py

    def check(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or item.shape is None:
            return
        for what, shape, most in (
            ("", item.shape if item.ndim == 1 else (), _LONGEST_AXIS),
            (" in a chunk", item.chunks or (), _MOST_AT_ONCE),
        ):
            if math.prod(shape) > most:
                found = f"{printable(name)[:60]} has {math.prod(shape):,} values{what}"
                raise file_error(source, f"is not read: {found}, at most {most:,}")

    with h5py.File(path) as file:
        file.visititems(check)


def values_of(one: xr.DataArray, source: str) -> FloatArray:
    """Values of a variable, if they are not too many."""
    if one.size > _MOST_AT_ONCE:
        found = f"{one.name} has {one.size:,} values at one place, at most {_MOST_AT_ONCE:,}"
        raise file_error(source, f"is not read: {found}")
    return np.asarray(one.to_numpy(), float)


def _component(data: xr.Dataset, standard_name: str, source: str) -> xr.DataArray:
    names = _COMPONENTS[standard_name]
    for name, one in data.data_vars.items():
        if name in names or one.attrs.get("standard_name") == standard_name:
            return merged_versions(one)
    raise file_error(source, f"has no {standard_name} (variables named {', '.join(names)})")


def merged_versions(one: xr.DataArray) -> xr.DataArray:
    """Variable of ERA5 with its preliminary months, which older files hold beside the final ones.

    Each has gaps where the other stands (ECMWF: ERA5, expver 1 and 5).
    """
    if "expver" not in one.dims:
        return one
    parts = [one.isel(expver=i, drop=True) for i in np.argsort(one["expver"].to_numpy())]
    return reduce(lambda known, other: known.fillna(other), parts).assign_attrs(one.attrs)


def _to_m_per_s(one: xr.DataArray, source: str) -> float:
    """Factor from a component's unit to m/s; without a unit it is taken as that."""
    unit = str(one.attrs.get("units", "m/s"))
    plain = unit.lower().replace(" ", "").replace("*", "").replace("^", "")
    for names, factor in _SPEEDS.items():
        if plain in names:
            return factor
    allowed = ", ".join(names[0] for names in _SPEEDS)
    raise file_error(source, f"has {one.name} in {printable(unit)} (known: {allowed})")


def _arranged(one: xr.DataArray, source: str) -> xr.DataArray:
    """Component with the axes time, latitude, level and longitude, in this order."""
    for axis, names in AXES.items():
        name = next((n for n in names if n in one.coords), None)
        if name is None:
            raise file_error(source, f"has no {axis} for {one.name} (named {', '.join(names)})")
        if name not in one.dims:
            one = one.expand_dims(name)
        one = one.rename({name: axis}) if name != axis else one
    rest = [str(name) for name in one.dims if name not in AXES]
    for name in rest:
        if one.sizes[name] != 1:
            raise file_error(source, f"has the axis {name} beside time, latitude, longitude, level")
        one = one.isel({name: 0})
    return one.transpose("time", "latitude", "level", "longitude")


def _at_longitude(
    u: xr.DataArray, v: xr.DataArray, longitude_deg: float | None, source: str
) -> tuple[xr.DataArray, xr.DataArray, str]:
    """Components at the longitude nearest to one, and that in words; all of them without one."""
    longitudes = u["longitude"].to_numpy().astype(float)
    if longitude_deg is None:
        return u, v, f"all {len(longitudes)} longitudes" if len(longitudes) > 1 else "one longitude"
    nearest = nearest_longitude(longitudes, longitude_deg, source)
    east = east_deg(longitudes[nearest])
    some = slice(nearest, nearest + 1)
    return u[..., some], v[..., some], f"longitude {east:g}, nearest to {longitude_deg:g}"


def latitudes_deg(axis: xr.DataArray, source: str) -> FloatArray:
    """Latitudes of a grid."""
    values = np.atleast_1d(axis.to_numpy()).astype(float)
    if np.any(np.abs(values) > 90.0):
        raise file_error(source, "has latitudes beyond 90 degrees: its axes may be swapped")
    return values


def east_deg(longitude_deg: float) -> float:
    """Longitude from -180 to 180."""
    return (longitude_deg + 180.0) % 360.0 - 180.0


def nearest_longitude(longitudes: FloatArray, wanted_deg: float, source: str) -> int:
    """Place of the longitude nearest to one, no further away than the grid is wide."""
    away = np.abs((longitudes - wanted_deg + 180.0) % 360.0 - 180.0)
    nearest = int(np.argmin(away))
    spacing = float(np.min(np.diff(np.sort(longitudes)))) if len(longitudes) > 1 else 0.0
    if away[nearest] > max(spacing, 1e-6):
        ends = " to ".join(dict.fromkeys(f"{f(longitudes):g}" for f in (np.min, np.max)))
        raise file_error(source, f"has longitudes {ends}, not {wanted_deg:g} of the mission")
    return nearest


def _months(u: xr.DataArray, source: str) -> FloatArray:
    if u["time"].dtype.kind != "M":
        raise file_error(source, "has times that are no dates")
    return np.asarray(u["time"].dt.month.to_numpy())


def altitudes_m(level: Any, source: str) -> FloatArray:
    """Altitude of levels [m]; that of a pressure in the standard atmosphere."""
    unit = str(level.attrs.get("units", "")).lower()
    values = level.to_numpy().astype(float)
    if unit in _METRES:
        return np.asarray(values * _METRES[unit])
    if unit not in _PASCALS:
        known = ", ".join([*_PASCALS, *_METRES])
        raise file_error(source, f"has levels in {unit or 'no unit'} (known: {known})")
    # No pressure at all, or one below zero, is as high as one without a height.
    return pressure_altitude_m(np.maximum(values * _PASCALS[unit], 1e-9))


def _speed_m_per_s(
    u: xr.DataArray, v: xr.DataArray, factors: list[float], source: str
) -> FloatArray:
    """Wind speed at one latitude; one is read at a time."""
    components = [f * values_of(one, source) for f, one in zip(factors, (u, v), strict=True)]
    speed = np.hypot(*components)
    if np.any(speed > STRONGEST_M_PER_S):
        fastest = f"{np.nanmax(speed):.4g} m/s"
        raise file_error(source, f"has a wind of {fastest}: a code of missing values or its unit")
    return np.asarray(speed)


def _of_latitude(
    speed: FloatArray, months: FloatArray, known: list[int], percentiles: FloatArray
) -> FloatArray:
    """Percentiles at one latitude, shape ``(level, month, percentile)``."""
    of_months = [
        np.percentile(speed[months == month], percentiles, axis=(0, 2)).T for month in known
    ]
    return np.stack(of_months, axis=1)
