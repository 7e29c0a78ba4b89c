"""``wind`` of a mission: wind that is not exceeded for a share of the time."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field, SerializationInfo, Strict, field_serializer

from missions.dates import month_and_day
from missions.files.errors import printable
from missions.files.texts import read_text, reading
from missions.winds.table import WindTable, shipped_winds, wind_table_from_text
from solar.schema import Flag, Record, Text
from solar.types import FloatArray, IntArray

_NETCDF = (".nc", ".nc4", ".cdf", ".netcdf")


class WindStatistics(Record):
    """Wind that is not exceeded for a share of the time, by latitude, altitude and month.

    ``file``: CSV table or NetCDF file with wind components, by default the shipped table.
    ``hold_station``: the aircraft flies faster in wind above its airspeed.
    """

    percentile: Annotated[float, Strict(), Field(gt=0.0, lt=100.0, allow_inf_nan=False)]
    file: Text | None = None
    hold_station: Flag = False

    def table(self, longitude_deg: float | None = None) -> WindTable:
        """Return the table of winds."""
        if self.file is None:
            return shipped_winds()
        is_netcdf = self.file.lower().endswith(_NETCDF)
        key = (longitude_deg, self.percentile) if is_netcdf else ()
        return _read(self.file, self.contents_read(), *key)

    def speeds(
        self,
        latitude_deg: FloatArray,
        day_of_year: IntArray,
        altitude_m: float,
        longitude_deg: float | None,
    ) -> FloatArray:
        """Return the wind [m/s], shape ``(scenario,)`` or ``(scenario, altitude)``."""
        months = [month_and_day(int(day))[0] for day in day_of_year]
        shape = (len(months),) + (1,) * getattr(altitude_m, "ndim", 0)
        table = self.table(longitude_deg)
        latitude = latitude_deg.reshape(shape)
        return table.at(latitude, altitude_m, np.reshape(months, shape), self.percentile)

    def contents_read(self) -> str | None:
        """Return a text that changes with the file's contents; None if shipped."""
        if self.file is None:
            return None
        with reading(self.file):
            about = Path(self.file).stat()
        return f"{about.st_size} {about.st_mtime_ns}"

    @field_serializer("file")
    def _with_contents(self, file: str | None, info: SerializationInfo) -> str | None:
        """Return the path, with the state of its contents in such a context."""
        contents = self.contents_read() if (info.context or {}).get("contents") else None
        return file if contents is None else f"{file} {contents}"


@lru_cache(maxsize=4)
def _read(
    path: str,
    state: str | None,
    longitude_deg: float | None = None,
    percentile: float | None = None,
) -> WindTable:
    """Read the table of a file, cached until its ``state`` changes."""
    if percentile is None:
        return wind_table_from_text(read_text(path), printable(path))
    from missions.winds.netcdf import wind_table_from_netcdf  # which few missions need

    return wind_table_from_netcdf(path, longitude_deg, also=percentile)
