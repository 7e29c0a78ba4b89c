"""Weather record: mean light, temperature and wind of equal intervals at a site.

Times are universal time, seconds since 1970. Typical meteorological years, put together from months
of several years, get the times of 2001, a year of 365 days.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from solar.sun import SECONDS_PER_DAY, cos_zenith, declination, hour_angle, solar_time_h
from solar.types import BoolArray, FloatArray, IntArray

SECONDS_PER_HOUR = 3600.0
TYPICAL_YEAR = 2001


@dataclass(frozen=True)
class Site:
    """Place of a weather record.

    Attributes
    ----------
    name : str
        Place as the file names it; empty where it does not.
    latitude_deg, longitude_deg : float
        Degrees, north and east positive.
    altitude_m : float
        Height of the ground above mean sea level [m].
    utc_offset_h : float
        Local standard time minus universal time [h].
    """

    name: str
    latitude_deg: float
    longitude_deg: float
    altitude_m: float
    utc_offset_h: float

    @property
    def label(self) -> str:
        """Name and place in one line."""
        north = f"{abs(self.latitude_deg):.2f}° {'N' if self.latitude_deg >= 0 else 'S'}"
        east = f"{abs(self.longitude_deg):.2f}° {'E' if self.longitude_deg >= 0 else 'W'}"
        place = f"{north}, {east}, {round(self.altitude_m)} m"
        return f"{self.name} ({place})" if self.name else place


@dataclass(frozen=True)
class Weather:
    """Means over equal intervals that follow each other without a gap.

    Attributes
    ----------
    source : str
        File name.
    layout : str
        Kind of the file, for instance ``EPW``.
    site : Site
        Place of measurement.
    start_s : ndarray
        Start of each interval, universal time [s since 1970-01-01].
    interval_s : float
        Length of the intervals [s].
    ghi, dni, dhi : ndarray
        Global horizontal, direct normal and diffuse horizontal irradiance [W/m2].
    temperature_c : ndarray or None
        Air temperature near the ground [C].
    wind_m_per_s : ndarray or None
        Wind speed 10 m above the ground [m/s].
    typical : bool
        True for a typical year, put together from months of several years.
    repairs : tuple of str
        Repairs, each with its count.
    air_altitude_m : float or None
        Altitude of temperature and wind [m], None near the ground.
    """

    source: str
    layout: str
    site: Site
    start_s: FloatArray
    interval_s: float
    ghi: FloatArray
    dni: FloatArray
    dhi: FloatArray
    temperature_c: FloatArray | None
    wind_m_per_s: FloatArray | None
    typical: bool
    repairs: tuple[str, ...] = ()
    air_altitude_m: float | None = None

    def __len__(self) -> int:
        return len(self.start_s)

    def origin(self) -> dict[str, Any]:
        """Return source, layout and site, JSON-ready, for the head of results."""
        return {
            "source": self.source,
            "layout": self.layout,
            "typical_year": self.typical,
            "site": asdict(self.site),
        }


def day_of_year(time_s: FloatArray) -> FloatArray:
    """Return the fractional day of a year of 365 days, 1.0 on 1 January, 00:00 UTC.

    29 February counts as a second 28 February, so that a date has the same number every year.
    ``time_s``: universal time [s since 1970-01-01].
    """
    whole = np.floor(np.asarray(time_s, float) / SECONDS_PER_DAY)
    date = whole.astype("datetime64[D]")
    year = date.astype("datetime64[Y]")
    start, end = (years.astype("datetime64[D]") for years in (year, year + 1))
    number, leap = (date - start).astype(int), (end - start).astype(int) == 366
    number = number - (leap & (number >= 59))
    return np.asarray(number + 1.0 + (time_s / SECONDS_PER_DAY - whole))


def sun_over(site: Site, time_s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return day of year, local solar time [h] and cosine of the sun's zenith angle."""
    day = day_of_year(time_s)
    solar_h = solar_time_h((day % 1.0) * 24.0, day, site.longitude_deg) % 24.0
    return day, solar_h, cos_zenith(site.latitude_deg, declination(day), hour_angle(solar_h))


def runs_of(marks: BoolArray) -> IntArray:
    """Return first index and the index after the last of every run of true values, a row each."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], marks, [False]]).astype(int)))
    return edges.reshape(-1, 2)


def longest_run(marks: BoolArray) -> int:
    """Return the length of the longest run of true values."""
    return int(np.diff(runs_of(marks)).max(initial=0))
