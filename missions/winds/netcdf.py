"""Percentiles of the wind from NetCDF files of its components, such as ERA5's.

Axes are known by their names, so that their order plays no part; longitudes may count from 0 to 360
or from -180 to 180, latitudes and levels up or down.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import reduce
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.air import MAXIMUM_ALTITUDE_M, MINIMUM_ALTITUDE_M, pressure_altitude_m
from missions.files.errors import InputError, in_file, printable, refused
from missions.files.texts import open_plain
from missions.units import columns_of, known_unit, unit_of
from missions.winds.table import STRONGEST_M_PER_S, WindTable
from solar.schema import spell, spell_ends
from solar.types import FloatArray

if TYPE_CHECKING:
    import xarray as xr


# Percentiles that a file is reduced to, besides the requested one.
PERCENTILES = (5.0, 10.0, 25.0, 50.0, 75.0, 90.0, 95.0, 99.0)
AXES = columns_of("axis")
_EVERY = ", ".join(AXES)
_HDF5 = b"\x89HDF"
# A century of hours is 0.9 million; values read at once take some 2 GB of memory.
_LONGEST_AXIS, _MOST_AT_ONCE = 10_000_000, 100_000_000


def wind_table_from_netcdf(
    path: str, longitude_deg: float | None = None, *, also: float | None = None
) -> WindTable:
    """Compute percentiles of the wind speed from components over time."""
    source = printable(path)
    with in_file(source), opened(path) as data:
        u, v = (_component(data, *names) for names in columns_of("wind").values())
        factors = [
            unit_of(str(wind.attrs.get("units", "m/s")), str(wind.name), "speed").factor
            for wind in (u, v)
        ]
        if u.shape != v.shape:
            raise refused("has components of the wind on different axes")
        longitudes = degrees_of(u["longitude"])
        at = f"all {len(longitudes)} longitudes" if len(longitudes) > 1 else "one longitude"
        if longitude_deg is not None:
            at_east = nearest("longitude", longitudes, longitude_deg)
            u, v = (wind[..., at_east : at_east + 1] for wind in (u, v))
            east = spell(east_deg(longitudes[at_east]))
            at = f"longitude {east}, nearest to {spell(longitude_deg)}"
        if u["time"].dtype.kind != "M":
            raise refused("has times that are no dates")
        months = np.asarray(u["time"].dt.month.to_numpy())
        altitude_m = altitudes_m(u["level"])
        kept = (altitude_m >= MINIMUM_ALTITUDE_M) & (altitude_m <= MAXIMUM_ALTITUDE_M)
        levels = np.flatnonzero(kept)[np.argsort(altitude_m[kept])]
        latitudes = degrees_of(u["latitude"])
        if not len(levels):
            raise refused(f"has no level up to {spell(MAXIMUM_ALTITUDE_M)} m")
        percentiles = np.unique([*PERCENTILES, *([] if also is None else [also])])
        known = sorted(set(months.tolist()))
        north = np.argsort(latitudes)
        winds = np.empty((len(north), len(levels), len(known), len(percentiles)))
        for row, i in zip(winds, north.tolist(), strict=True):  # one by one, for the memory
            parts = (values_of(wind[:, i, levels]) for wind in (u, v))
            speed = np.hypot(*(factor * part for factor, part in zip(factors, parts, strict=True)))
            if np.any(speed > STRONGEST_M_PER_S):
                fastest = spell(np.nanmax(speed), 4)
                raise refused(f"has a wind of {fastest} m/s: a code of missing values or its unit")
            for column, month in enumerate(known):
                row[:, column] = np.percentile(speed[months == month], percentiles, axis=(0, 2)).T
        if not np.isfinite(winds).all():
            raise refused("has gaps in the wind")
        fewest = min(int(np.sum(months == month)) for month in known) * u.shape[-1]
        sampled = percentiles[percentiles <= 100.0 * (1.0 - 1.0 / fewest)]
        if also is not None and also not in sampled:
            message = f"has {fewest} values in a month, too few for percentile"
            raise refused(f"{message} {spell(also)}")
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
def opened(path: str) -> Iterator[xr.Dataset]:
    """Yield the dataset of a NetCDF file while it is read."""
    import xarray as xr

    try:
        with open_plain(path) as file:
            packed = file.read(len(_HDF5)) == _HDF5  # else it is no larger than its file
        if packed:
            _check_sizes(path)
        with xr.open_dataset(path) as data:
            named = {axis: [n for n in names if n in data.coords] for axis, names in AXES.items()}
            yield data.rename(
                {names[0]: axis for axis, names in named.items() if names and axis not in names}
            )
    except InputError:
        raise
    except Exception as error:  # the libraries raise whatever a damaged file makes them trip over
        reason = printable(" ".join(str(error).split()))[:160]
        raise refused(f"cannot be read as NetCDF: {reason}") from error


def axis_of(data: xr.Dataset | xr.DataArray, axis: str) -> xr.DataArray:
    """Return the values of an axis, refused if missing."""
    if axis not in data.coords:
        what = "" if data.name is None else f" for {data.name}"
        raise refused(f"has no {axis}{what} (named {', '.join(AXES[axis])})")
    return data[axis]


def without_other_axes(variable: xr.DataArray) -> xr.DataArray:
    """Return a variable without axes besides those of :data:`AXES`, which must be of length 1."""
    if "expver" in variable.dims:
        # Final and preliminary months of ERA5, versions 1 and 5 of ECMWF's, each with gaps where
        # the other has values.
        order = np.argsort(variable["expver"].to_numpy())
        parts = [variable.isel(expver=i, drop=True) for i in order]
        merged = reduce(lambda known, other: known.fillna(other), parts)
        variable = merged.assign_attrs(variable.attrs)
    for name in set(map(str, variable.dims)) - AXES.keys():
        if variable.sizes[name] != 1:
            raise refused(f"has the axis {name} for {variable.name}, beside {_EVERY}")
        variable = variable.isel({name: 0})
    return variable


def _check_sizes(path: str) -> None:
    """Refuse a file that unpacks to too many values at once: whole axes, chunks of variables."""
    import h5py

    def check(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or item.shape is None:
            return
        for what, shape, most in (
            ("", item.shape if item.ndim == 1 else (), _LONGEST_AXIS),
            (" in a chunk", item.chunks or (), _MOST_AT_ONCE),
        ):
            if math.prod(shape) > most:
                text = f"{printable(name)[:60]} has {math.prod(shape):,} values{what}"
                raise refused(f"is not read: {text}, at most {most:,}")

    with h5py.File(path) as file:
        file.visititems(check)


def values_of(variable: xr.DataArray) -> FloatArray:
    """Return the values of a variable, refused if too many."""
    if variable.size > _MOST_AT_ONCE:
        text = f"{variable.name} has {variable.size:,} values at one place"
        raise refused(f"is not read: {text}, at most {_MOST_AT_ONCE:,}")
    return np.asarray(variable.to_numpy(), float)


def find_variable(data: xr.Dataset, names: Iterable[str]) -> xr.DataArray | None:
    """Return a quantity's variable by the first of its names or standard names."""
    for name in names:
        for key, variable in data.data_vars.items():
            if name in (key, variable.attrs.get("standard_name")):
                return variable
    return None


def _component(data: xr.Dataset, *names: str) -> xr.DataArray:
    """Return a component of the wind over time, latitude, level and longitude, in this order."""
    component = find_variable(data, names)
    if component is None:
        raise refused(f"has no {names[0]} (variables named {', '.join(names[1:])})")
    component = without_other_axes(component)
    for axis in AXES:
        axis_of(component, axis)
        if axis not in component.dims:
            component = component.expand_dims(axis)
    return component.transpose(*AXES)


def degrees_of(axis: xr.DataArray) -> FloatArray:
    """Return the latitudes or longitudes of a grid [deg]."""
    values = np.atleast_1d(axis.to_numpy()).astype(float)
    if axis.name == "latitude" and np.any(np.abs(values) > 90.0):
        raise refused("has latitudes beyond 90 degrees: its axes may be swapped")
    return values


def east_deg(longitude_deg: float) -> float:
    """Return a longitude from -180 to 180 [deg]."""
    return (longitude_deg + 180.0) % 360.0 - 180.0


def nearest(axis: str, values: FloatArray, degrees: float) -> int:
    """Return the index of the nearest latitude or longitude, at most a grid spacing away."""
    away = np.abs((values - degrees + 180.0) % 360.0 - 180.0)
    index = int(np.argmin(away))
    around = np.sort(values % 360.0)
    # The widest gap around the globe is where the grid has no values.
    gaps = np.sort(np.diff(around, append=around[0] + 360.0))[:-1]
    if away[index] > max(gaps.max(initial=0.0), 1e-6):
        raise not_of_the_mission(f"{axis}s", values, degrees)
    return index


def not_of_the_mission(name: str, known: FloatArray, needed: float) -> InputError:
    """Return the error of a grid that does not reach the mission's place."""
    return refused(f"has {name} {spell_ends(known)}, not {spell(needed)} of the mission")


def altitudes_m(level: Any) -> FloatArray:
    """Return the altitude of levels [m]; of pressures in the standard atmosphere."""
    text = str(level.attrs.get("units", ""))
    unit = unit_of(text, "levels", "pressure", "length")
    values = np.asarray(unit.factor * level.to_numpy().astype(float))
    if known_unit(text, "pressure") is None:
        return values
    # Pressures of zero or below are as high as the least one.
    return pressure_altitude_m(np.maximum(values, 1e-9))
