"""Sun geometry against the Solar Position Algorithm of pvlib, spherical astronomy and limits."""

from functools import cache

import numpy as np
import pandas as pd
import pvlib
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solar.sun import (
    cos_zenith,
    day_angle,
    declination,
    equation_of_time_h,
    hour_angle,
    solar_time_h,
    sun_position,
    sun_times,
    sun_vector_ned,
)

YEARS = (2015, 2024)  # a common year and a leap year
SITES = ((47.6, 8.53), (0.0, -60.0), (-35.0, 150.0), (70.0, 25.0), (-80.0, 100.0))

days = st.floats(1.0, 367.0)


@cache
def utc_hours(year):
    return pd.date_range(f"{year}-01-01", f"{year}-12-31 23:00", freq="h", tz="UTC")


@cache
def spa(year, latitude, longitude):
    """Position of the true sun, without refraction in the column ``elevation``."""
    return pvlib.solarposition.spa_python(utc_hours(year), latitude, longitude)


def clock(year):
    """Hour of the day and fractional day of year, both UTC."""
    times = utc_hours(year)
    hour = np.asarray(times.hour, float)
    return hour, np.asarray(times.day_of_year, float) + hour / 24.0


def sun_vectors(year, latitude, longitude):
    hour, day = clock(year)
    time = solar_time_h(hour, day, longitude)
    return sun_vector_ned(latitude, declination(day), hour_angle(time))


@pytest.mark.parametrize(("latitude", "longitude"), SITES)
@pytest.mark.parametrize("year", YEARS)
def test_sun_vector_agrees_with_spa(year, latitude, longitude):
    truth = spa(year, latitude, longitude)
    elevation, azimuth = np.radians(truth.elevation), np.radians(truth.azimuth)
    level = np.cos(elevation)
    parts = [level * np.cos(azimuth), level * np.sin(azimuth), -np.sin(elevation)]
    vectors = sun_vectors(year, latitude, longitude)
    # The chord between two unit vectors is their angle.
    angle = np.degrees(np.linalg.norm(vectors - np.stack(parts, axis=-1), axis=-1))
    # Hour angle (0.16 deg) and declination (0.15 deg late in the leap-year cycle) at once.
    assert np.max(angle) < 0.25
    error = (np.degrees(np.arcsin(-vectors[:, 2])) - truth.elevation)[truth.elevation > 0.0]
    # Spencer's series for declination and equation of time are each good to a few hundredths of
    # a degree (0.035 deg; 35 s of time, 0.15 deg of hour angle), and the leap-year cycle shifts
    # the declination by up to half a day: RMS 0.03 to 0.08 degrees.
    assert np.sqrt(np.mean(error**2)) < 0.08
    # The worst case adds the two up instead of averaging them.
    assert np.max(np.abs(error)) < 0.2


@pytest.mark.parametrize("year", YEARS)
def test_equation_of_time_agrees_with_spa(year):
    _, day = clock(year)
    truth_min = spa(year, *SITES[0]).equation_of_time.to_numpy()
    # Spencer (1971) states 35 s; a leap year's lag of up to a day adds up to half a minute per day
    # in December, so 0.75 min bounds both.
    assert equation_of_time_h(day) * 60.0 == pytest.approx(truth_min, abs=0.75)


def test_declination_agrees_with_another_implementation_of_the_series():
    whole_days = np.arange(1, 366)
    other = pvlib.solarposition.declination_spencer71(whole_days)
    # The same published coefficients: nothing but rounding may differ.
    assert declination(whole_days) == pytest.approx(other, abs=1e-12)


def test_day_lengths_at_special_places():
    north = np.radians(23.44)
    assert sun_times(0.0, north).day_length_h == pytest.approx(12.0)  # equator: always 12 h
    assert sun_times(47.6, 0.0).day_length_h == pytest.approx(12.0)  # equinox: 12 h everywhere
    for latitude in (70.0, 90.0):
        assert sun_times(latitude, north) == (0.0, 24.0)  # polar day
        assert sun_times(-latitude, north) == (12.0, 12.0)  # polar night
    # The polar circle is at 90 deg minus the declination.
    outside, inside = sun_times([66.55, 66.57], north).day_length_h
    assert outside < 24.0 == inside
    # 47.6° N at the summer solstice: 15.78 h, given to the second decimal.
    assert sun_times(47.6, declination(172.5)).day_length_h == pytest.approx(15.78, abs=0.005)


@given(st.floats(-66.0, 66.0), days)
def test_sun_is_on_the_horizon_at_sunrise(latitude, day):
    delta = declination(day)
    sunrise = sun_times(latitude, delta).sunrise_h
    # Rounding only; below the polar circle there is a sunrise on every day.
    assert cos_zenith(latitude, delta, hour_angle(sunrise)) == pytest.approx(0.0, abs=1e-9)


# The almanac's algorithm is good for 0.01 deg in ecliptic longitude; SPA sees the sun from the
# surface, which lowers it by up to 0.0025 deg.
TOLERANCE_DEG = 0.02
FIRST_S, LAST_S = 946684800.0, 2556143999.0  # 2000 to 2050
ALMANAC_SITES = ((47.6, 8.53), (0.0, -179.9), (-35.0, 150.0), (70.0, 25.0), (-89.9, 100.0))


@pytest.mark.parametrize(("latitude", "longitude"), ALMANAC_SITES)
def test_position_agrees_with_spa(latitude, longitude):
    time_s = np.sort(np.random.default_rng(1).uniform(FIRST_S, LAST_S, 2000))
    index = pd.DatetimeIndex(pd.to_datetime(time_s, unit="s", utc=True))
    spa = pvlib.solarposition.spa_python(index, latitude, longitude, delta_t=None)
    sun = sun_position(time_s, latitude, longitude)
    elevation, azimuth = np.degrees(sun.elevation_rad), np.degrees(sun.azimuth_rad)
    assert np.abs(elevation - spa["elevation"]).max() < TOLERANCE_DEG
    # On the sphere: an azimuth means nothing with the sun overhead.
    across = (azimuth - spa["azimuth"] + 180.0) % 360.0 - 180.0
    assert np.abs(across * np.cos(sun.elevation_rad)).max() < TOLERANCE_DEG


def test_vector_points_where_the_angles_say():
    time_s = np.linspace(1.4e9, 1.4e9 + 86400.0, 97)
    sun = sun_position(time_s, 47.6, 8.53)
    level = np.cos(sun.elevation_rad)
    north, east, down = sun.vector_ned.T
    assert north == pytest.approx(level * np.cos(sun.azimuth_rad), abs=1e-12)
    assert east == pytest.approx(level * np.sin(sun.azimuth_rad), abs=1e-12)
    assert down == pytest.approx(-np.sin(sun.elevation_rad), abs=1e-12)
    assert np.linalg.norm(sun.vector_ned, axis=1) == pytest.approx(1.0)


def test_solar_time_agrees_with_the_equation_of_time():
    day = np.arange(1, 366)
    time_s = 1420070400.0 + 86400.0 * (day - 0.5)  # noon UTC of every day of 2015
    sun = sun_position(time_s, 0.0, 0.0)
    assert day_angle(1) == 0.0
    # Spencer's series is good for about half a minute.
    assert sun.time_solar_h - 12.0 == pytest.approx(equation_of_time_h(day + 0.5), abs=0.012)
