"""Position of the sun at an instant of universal time, for flight logs.

Sizing repeats a typical day and can afford the series of :mod:`solar.sun`; a log is compared second
by second, with the sun near the horizon, where a tenth of a degree is a visible share of the power.

The position is geometric (no refraction), like that of :mod:`solar.sun`, and seen from the centre
of the Earth: the sun's parallax is below 0.0025 degrees.

Source: Michalsky, J. J. (1988), The Astronomical Almanac's algorithm for approximate solar position
(1950-2050), Solar Energy 40(3), pp. 227-235.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from solar.sun import NOON_H
from solar.types import FloatArray

J2000_UNIX_S = 946728000.0  # 1 January 2000, 12:00 UTC
SECONDS_PER_DAY = 86400.0
_DEGREES_PER_HOUR = 15.0


class SunPosition(NamedTuple):
    """Where the sun stands, and the solar time this makes.

    Attributes
    ----------
    vector_ned : ndarray, shape (..., 3)
        Unit vector to the sun, North-East-Down.
    elevation_rad, azimuth_rad : ndarray
        Angle above the horizon and bearing from north, clockwise, 0 to 2 pi [rad].
    time_solar_h : ndarray
        True solar time, 0 to 24 [h]: noon is 12 on every day.
    declination_rad : ndarray
        Declination [rad].
    """

    vector_ned: FloatArray
    elevation_rad: FloatArray
    azimuth_rad: FloatArray
    time_solar_h: FloatArray
    declination_rad: FloatArray


def sun_position(
    unix_time_s: ArrayLike, latitude_deg: ArrayLike, longitude_deg: ArrayLike
) -> SunPosition:
    """Geometric position of the sun from universal time and place.

    Parameters
    ----------
    unix_time_s : array_like
        Seconds since 1970-01-01 00:00 UTC, leap seconds not counted [s]. Good for 1950 to 2050.
    latitude_deg, longitude_deg : array_like
        Latitude and east longitude [deg]; all arguments broadcast.

    Returns
    -------
    SunPosition
        Arrays of the broadcast shape.
    """
    days = (np.asarray(unix_time_s, float) - J2000_UNIX_S) / SECONDS_PER_DAY
    right_ascension, sun_declination = _equatorial(days)
    sidereal = np.radians(_greenwich_sidereal_deg(days) + np.asarray(longitude_deg, float))
    hour = np.remainder(sidereal - right_ascension + np.pi, 2.0 * np.pi) - np.pi
    return _horizontal(np.radians(np.asarray(latitude_deg, float)), sun_declination, hour)


def _equatorial(days: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Right ascension and declination [rad] from days since J2000."""
    mean_longitude = np.radians(280.460 + 0.9856474 * days)
    anomaly = np.radians(357.528 + 0.9856003 * days)
    longitude = mean_longitude + np.radians(1.915 * np.sin(anomaly) + 0.020 * np.sin(2.0 * anomaly))
    obliquity = np.radians(23.439 - 0.0000004 * days)
    along = np.sin(longitude)
    return (
        np.arctan2(np.cos(obliquity) * along, np.cos(longitude)),
        np.arcsin(np.sin(obliquity) * along),
    )


def _greenwich_sidereal_deg(days: FloatArray) -> FloatArray:
    """Mean sidereal time at Greenwich [deg].

    The almanac's ``6.697375 h + 0.0657098242 h/d`` plus universal time is one linear function; the
    whole days are dropped first, which keeps the digits.
    """
    turns = 18.697375 + 0.0657098242 * days + 24.0 * np.remainder(days, 1.0)
    return np.asarray(_DEGREES_PER_HOUR * turns)


def _horizontal(latitude: FloatArray, dec: FloatArray, hour: FloatArray) -> SunPosition:
    sin_lat, cos_lat = np.sin(latitude), np.cos(latitude)
    sin_dec, cos_dec = np.sin(dec), np.cos(dec)
    cos_hour = np.cos(hour)
    north = cos_lat * sin_dec - sin_lat * cos_dec * cos_hour
    east = -cos_dec * np.sin(hour)
    up = sin_lat * sin_dec + cos_lat * cos_dec * cos_hour
    elevation = np.arctan2(up, np.hypot(north, east))
    vector = np.stack(np.broadcast_arrays(north, east, -up), axis=-1)
    solar_h = np.remainder(NOON_H + np.degrees(hour) / _DEGREES_PER_HOUR, 24.0)
    return SunPosition(
        vector_ned=vector,
        elevation_rad=np.asarray(elevation),
        azimuth_rad=np.asarray(np.remainder(np.arctan2(east, north), 2.0 * np.pi)),
        time_solar_h=np.asarray(np.broadcast_to(solar_h, np.shape(elevation))),
        declination_rad=np.asarray(np.broadcast_to(dec, np.shape(elevation))),
    )
