"""Where an aircraft flies: latitudes, and the scenarios of every latitude on every day."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field, Strict, model_validator

from missions import dates
from missions.air import MAXIMUM_ALTITUDE_M, MINIMUM_ALTITUDE_M
from solar.schema import Record
from solar.sun import declination, sun_times
from solar.types import BoolArray, FloatArray, IntArray

Latitude = Annotated[float, Strict(), Field(ge=-90.0, le=90.0, allow_inf_nan=False)]
Longitude = Annotated[float, Strict(), Field(ge=-180.0, le=180.0, allow_inf_nan=False)]
Altitude = Annotated[
    float, Strict(), Field(ge=MINIMUM_ALTITUDE_M, le=MAXIMUM_ALTITUDE_M, allow_inf_nan=False)
]


class LatitudeRange(Record):
    """Latitudes from one to another, evenly spaced."""

    from_deg: Latitude
    to_deg: Latitude
    count: Annotated[int, Strict(), Field(ge=2, le=181)] = 3

    @model_validator(mode="after")
    def _check_ends(self) -> LatitudeRange:
        if self.from_deg == self.to_deg:
            raise ValueError(
                f"from_deg and to_deg must differ (got {self.from_deg:g} twice): a single latitude "
                "is written latitude_deg: 47.6"
            )
        return self

    def values(self) -> list[float]:
        """Latitudes [deg], ends included."""
        return [float(v) for v in np.linspace(self.from_deg, self.to_deg, self.count)]


def latitude_label(latitude_deg: float) -> str:
    """Readable latitude, for instance ``47.6° N``."""
    hemisphere = "" if latitude_deg == 0 else " S" if latitude_deg < 0 else " N"
    return f"{abs(float(latitude_deg)):g}\N{DEGREE SIGN}{hemisphere}"


@dataclass(frozen=True)
class Scenarios:
    """Latitude and day of year of each scenario, two arrays of one length.

    The days may be given as dates, ``["06-21"]`` or a ``DatetimeIndex``.
    """

    latitude_deg: FloatArray
    day_of_year: IntArray

    def __post_init__(self) -> None:
        if getattr(self.day_of_year, "dtype", np.dtype(object)).kind in "MUO":  # dates
            object.__setattr__(self, "day_of_year", dates.days_of_year(self.day_of_year))

    def __len__(self) -> int:
        return len(self.latitude_deg)

    @property
    def noon_day(self) -> FloatArray:
        """Fractional day of year of each scenario's noon, for the sun."""
        return np.asarray(self.day_of_year + 0.5)

    def label(self, index: int) -> str:
        """Readable name of a scenario, for instance ``47.6° N, 21 Jun``."""
        date = dates.date_label(int(self.day_of_year[index]))
        return f"{latitude_label(float(self.latitude_deg[index]))}, {date}"

    def in_polar_night(self) -> BoolArray:
        """Mark the scenarios in which the sun never rises."""
        times = sun_times(self.latitude_deg, declination(self.noon_day))
        return np.asarray(times.day_length_h <= 0.0)
