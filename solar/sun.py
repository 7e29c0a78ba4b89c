"""Sun geometry for sizing: declination, equation of time, sun vector, sunrise and sunset.

Everything broadcasts. Angles are radians inside, degrees in arguments that end in ``_deg``.
Time is *local solar time* in hours (noon is 12); ``day_of_year`` is fractional and starts at
1.0 on 1 January, 00:00. A sizing study that repeats one day for ever holds the declination of
that day's noon (``day + 0.5``): morning and afternoon are then mirror images, and the sun's
elevation errs by up to 0.4 degrees against the true sun, far below the uncertainty of any clear
sky. With the fractional day of year the RMS error is below 0.08 degrees.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from solar.types import FloatArray

DAYS_PER_YEAR = 365.0
HOURS_PER_DAY = 24.0
NOON_H = 12.0


def day_angle(day_of_year: ArrayLike) -> FloatArray:
    """Angle of the Earth on its orbit since the start of the year [rad]."""
    return np.asarray(2.0 * np.pi * (np.asarray(day_of_year, float) - 1.0) / DAYS_PER_YEAR)


def declination(day_of_year: ArrayLike) -> FloatArray:
    """Declination of the sun [rad] from the fractional day of year.

    Source: Spencer, J. W. (1971), Fourier series representation of the position of the sun,
    Search 2(5), p. 172; also Duffie & Beckman, Solar Engineering of Thermal Processes, eq. 1.6.1b.
    """
    b = day_angle(day_of_year)
    return np.asarray(
        0.006918
        - 0.399912 * np.cos(b)
        + 0.070257 * np.sin(b)
        - 0.006758 * np.cos(2 * b)
        + 0.000907 * np.sin(2 * b)
        - 0.002697 * np.cos(3 * b)
        + 0.00148 * np.sin(3 * b)
    )


def equation_of_time_h(day_of_year: ArrayLike) -> FloatArray:
    """Apparent minus mean solar time [h] from the fractional day of year.

    Source: Spencer (1971); Duffie & Beckman, eq. 1.5.3.
    """
    b = day_angle(day_of_year)
    minutes = 229.18 * (
        0.000075
        + 0.001868 * np.cos(b)
        - 0.032077 * np.sin(b)
        - 0.014615 * np.cos(2 * b)
        - 0.04089 * np.sin(2 * b)
    )
    return np.asarray(minutes / 60.0)


def solar_time_h(utc_h: ArrayLike, day_of_year: ArrayLike, longitude_deg: ArrayLike) -> FloatArray:
    """Local solar time [h], not wrapped to a day, from universal time and east longitude.

    Parameters
    ----------
    utc_h : array_like
        Hours since 00:00 UTC of the day concerned [h].
    day_of_year : array_like
        Fractional day of year, for the equation of time.
    longitude_deg : array_like
        Longitude, positive eastwards [deg].
    """
    east_h = np.asarray(longitude_deg, float) / 15.0
    return np.asarray(np.asarray(utc_h, float) + east_h + equation_of_time_h(day_of_year))


def hour_angle(time_solar_h: ArrayLike) -> FloatArray:
    """Hour angle [rad], zero at solar noon, positive in the afternoon."""
    return np.asarray((np.asarray(time_solar_h, float) - NOON_H) * (2.0 * np.pi / HOURS_PER_DAY))


class SunArc(NamedTuple):
    """Path of a day's sun: the cosine of its zenith angle is ``mean + amplitude cos(hour)``."""

    mean: FloatArray
    amplitude: FloatArray


def sun_arc(latitude_deg: ArrayLike, sun_declination: ArrayLike) -> SunArc:
    """Path of the sun at a latitude [deg] for a declination [rad]."""
    lat = np.radians(np.asarray(latitude_deg, float))
    dec = np.asarray(sun_declination, float)
    return SunArc(np.asarray(np.sin(lat) * np.sin(dec)), np.asarray(np.cos(lat) * np.cos(dec)))


def cos_zenith(latitude_deg: ArrayLike, sun_declination: ArrayLike, hour: ArrayLike) -> FloatArray:
    """Cosine of the geometric zenith angle, negative below the horizon.

    Parameters
    ----------
    latitude_deg : array_like
        Latitude [deg].
    sun_declination, hour : array_like
        Declination and hour angle [rad].
    """
    arc = sun_arc(latitude_deg, sun_declination)
    return np.asarray(arc.mean + arc.amplitude * np.cos(np.asarray(hour, float)))


def sun_vector_ned(
    latitude_deg: ArrayLike, sun_declination: ArrayLike, hour: ArrayLike
) -> FloatArray:
    """Unit vector from the aircraft to the sun, North-East-Down, on the last axis.

    The parameters are those of :func:`cos_zenith`; the result has their broadcast shape plus
    an axis of length 3. Below the horizon the down component is positive.
    """
    lat = np.radians(np.asarray(latitude_deg, float))
    dec = np.asarray(sun_declination, float)
    w = np.asarray(hour, float)
    north = np.cos(lat) * np.sin(dec) - np.sin(lat) * np.cos(dec) * np.cos(w)
    east = -np.cos(dec) * np.sin(w)
    down = -(np.sin(lat) * np.sin(dec) + np.cos(lat) * np.cos(dec) * np.cos(w))
    return np.stack(np.broadcast_arrays(north, east, down), axis=-1)


class SunTimes(NamedTuple):
    """Sunrise and sunset in solar time [h]; both 12 in polar night, 0 and 24 in polar day."""

    sunrise_h: FloatArray
    sunset_h: FloatArray

    @property
    def day_length_h(self) -> FloatArray:
        """Hours with the sun above the geometric horizon [h]."""
        return np.asarray(self.sunset_h - self.sunrise_h)


def sun_times(latitude_deg: ArrayLike, sun_declination: ArrayLike) -> SunTimes:
    """Sunrise and sunset of the geometric sun (no refraction, sun's centre).

    Polar night is a day of length zero around noon, polar day one of 24 hours; at a pole, and
    at the horizon-grazing limit, the result is one of these two. Nothing is NaN.
    """
    lat = np.radians(np.asarray(latitude_deg, float))
    dec = np.asarray(sun_declination, float)
    # cos(w) = -tan(lat) tan(dec), written so that it stays finite at the poles.
    numerator = -np.sin(lat) * np.sin(dec)
    denominator = np.maximum(np.cos(lat) * np.cos(dec), 1e-12)
    half_day_h = np.arccos(np.clip(numerator / denominator, -1.0, 1.0)) * (
        HOURS_PER_DAY / (2.0 * np.pi)
    )
    return SunTimes(np.asarray(NOON_H - half_day_h), np.asarray(NOON_H + half_day_h))
