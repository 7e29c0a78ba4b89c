"""Sun geometry against the Solar Position Algorithm of pvlib, spherical astronomy and limits."""

from __future__ import annotations

from functools import cache

import numpy as np
import pandas as pd
import pvlib
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from solar.sun import (
    cos_zenith,
    day_angle,
    declination,
    equation_of_time_h,
    hour_angle,
    solar_time_h,
    sun_times,
    sun_vector_ned,
)

YEARS = (2015, 2024)  # a common year and a leap year
SITES = ((47.6, 8.53), (0.0, -60.0), (-35.0, 150.0), (70.0, 25.0), (-80.0, 100.0))

latitudes = st.floats(-90.0, 90.0)
days = st.floats(1.0, 367.0)
hours = st.floats(0.0, 24.0)


@cache
def utc_hours(year: int) -> pd.DatetimeIndex:
    return pd.date_range(f"{year}-01-01", f"{year}-12-31 23:00", freq="h", tz="UTC")


@cache
def spa(year: int, latitude: float, longitude: float) -> pd.DataFrame:
    """Position of the true sun, without refraction in the column ``elevation``."""
    return pvlib.solarposition.spa_python(utc_hours(year), latitude, longitude)


def clock(year: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Hour of the day and fractional day of year, both UTC."""
    times = utc_hours(year)
    hour = np.asarray(times.hour, float)
    return hour, np.asarray(times.day_of_year, float) + hour / 24.0


def sun_vectors(year: int, latitude: float, longitude: float) -> NDArray[np.float64]:
    hour, day = clock(year)
    time = solar_time_h(hour, day, longitude)
    return sun_vector_ned(latitude, declination(day), hour_angle(time))


@pytest.mark.parametrize(("latitude", "longitude"), SITES)
@pytest.mark.parametrize("year", YEARS)
def test_elevation_with_the_day_held_at_noon(year: int, latitude: float, longitude: float) -> None:
    hour, day = clock(year)
    time = solar_time_h(hour, day, longitude)
    # Noon of the local solar day, which need not be the UTC day.
    noon = np.floor(day) + np.floor(time / 24.0) + 0.5
    cosine = cos_zenith(latitude, declination(noon), hour_angle(time))
    truth = spa(year, latitude, longitude).elevation.to_numpy()
    error = (np.degrees(np.arcsin(cosine)) - truth)[truth > 0.0]
    # Half a day changes the declination by at most 0.2 degrees (at the equinoxes); the other
    # 0.2 degrees are those of the series.
    assert np.max(np.abs(error)) < 0.4


@pytest.mark.parametrize(("latitude", "longitude"), SITES)
@pytest.mark.parametrize("year", YEARS)
def test_sun_vector_agrees_with_spa(year: int, latitude: float, longitude: float) -> None:
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
def test_equation_of_time_agrees_with_spa(year: int) -> None:
    _, day = clock(year)
    truth_min = spa(year, *SITES[0]).equation_of_time.to_numpy()
    # Spencer (1971) states 35 s; a leap year's lag of up to a day adds up to half a minute per day
    # in December, so 0.75 min bounds both.
    assert equation_of_time_h(day) * 60.0 == pytest.approx(truth_min, abs=0.75)


def test_equation_of_time_has_its_known_extremes() -> None:
    day = np.arange(1.0, 366.0)
    minutes = equation_of_time_h(day) * 60.0
    # Almanac: -14.2 min on 11 February (day 42), +16.4 min on 3 November (day 307). The extremes
    # are flat, so that the 35 s of the series can move them by some days.
    assert (minutes.min(), minutes.max()) == pytest.approx((-14.2, 16.4), abs=0.6)
    assert day[minutes.argmin()] == pytest.approx(42.0, abs=5.0)
    assert day[minutes.argmax()] == pytest.approx(307.0, abs=5.0)


@pytest.mark.parametrize(
    ("day", "declination_deg"),
    [
        (79.948, 0.0),  # equinox of 20 March 2015, 22:45 UTC
        (172.693, 23.436),  # solstice of 21 June 2015, 16:38 UTC
        (266.348, 0.0),  # equinox of 23 September 2015, 08:21 UTC
        (356.200, -23.436),  # solstice of 22 December 2015, 04:48 UTC
    ],
)
def test_declination_at_equinoxes_and_solstices(day: float, declination_deg: float) -> None:
    # The series errs by up to 0.035 degrees for its own year and by 0.4 degrees a day times a
    # quarter of a day for the position of 2015 in the leap-year cycle.
    assert np.degrees(declination(day)) == pytest.approx(declination_deg, abs=0.15)


def test_declination_agrees_with_another_implementation_of_the_series() -> None:
    whole_days = np.arange(1, 366)
    other = pvlib.solarposition.declination_spencer71(whole_days)
    # The same published coefficients: nothing but rounding may differ.
    assert declination(whole_days) == pytest.approx(other, abs=1e-12)


@given(days)
def test_the_year_is_periodic(day: float) -> None:
    # Rounding only.
    assert declination(day + 365.0) == pytest.approx(float(declination(day)), abs=1e-12)
    assert equation_of_time_h(day + 365.0) == pytest.approx(float(equation_of_time_h(day)))


def test_day_one_is_the_start_of_the_year() -> None:
    assert day_angle(1.0) == 0.0
    assert day_angle(366.0) == pytest.approx(2.0 * np.pi)


@pytest.mark.parametrize(
    ("longitude", "sign"), [(90.0, 1.0), (-90.0, -1.0), (0.0, 0.0), (180.0, 2.0)]
)
def test_solar_time_is_ahead_in_the_east(longitude: float, sign: float) -> None:
    expected = 12.0 + 6.0 * sign + equation_of_time_h(100.0)  # 15 degrees are one hour
    assert solar_time_h(12.0, 100.0, longitude) == pytest.approx(expected)


@pytest.mark.parametrize("year", YEARS)
def test_solar_noon_is_the_transit_of_spa(year: int) -> None:
    latitude, longitude = SITES[0]
    midnights = pd.date_range(f"{year}-01-01", f"{year}-12-31", freq="D", tz="UTC")
    transit = pvlib.solarposition.sun_rise_set_transit_spa(midnights, latitude, longitude).transit
    utc_h = (transit - midnights).dt.total_seconds().to_numpy() / 3600.0
    day = np.asarray(midnights.day_of_year, float) + 0.5
    # 0.0125 h are the 45 s of the equation of time (see above).
    assert solar_time_h(utc_h, day, longitude) == pytest.approx(12.0, abs=0.0125)


@pytest.mark.parametrize(
    ("latitude", "longitude"), [(47.6, 8.53), (0.0, -60.0), (-35.0, 150.0), (60.0, 25.0)]
)
def test_sunrise_and_sunset_agree_with_geometric_times(latitude: float, longitude: float) -> None:
    utc_days = pd.date_range("2015-01-01", "2015-12-31", freq="D", tz="UTC")
    day = np.asarray(utc_days.day_of_year, float)
    rise, fall, _ = pvlib.solarposition.sun_rise_set_transit_geometric(
        utc_days,
        latitude,
        longitude,
        pvlib.solarposition.declination_spencer71(day),
        pvlib.solarposition.equation_of_time_spencer71(day),
    )
    times = sun_times(latitude, declination(day + 0.5))
    for theirs, ours in ((rise, times.sunrise_h), (fall, times.sunset_h)):
        utc_h = np.asarray((theirs - utc_days).total_seconds()) / 3600.0
        solar_h = solar_time_h(utc_h, day + 0.5, longitude)
        minutes = ((solar_h - ours + 12.0) % 24.0 - 12.0) * 60.0
        # They take the declination at midnight, we at noon: half a day of at most 0.4 deg/day is
        # 0.2 deg, times tan(60 deg) and 4 min per degree of hour angle 1.4 min; then 15 s for the
        # equation of time.
        assert np.max(np.abs(minutes)) < 2.0


@pytest.mark.parametrize(("latitude", "longitude"), SITES[:3])
@pytest.mark.parametrize("year", YEARS)
def test_true_sun_is_on_the_horizon_at_sunrise_and_sunset(
    year: int, latitude: float, longitude: float
) -> None:
    midnights = pd.date_range(f"{year}-01-01", f"{year}-12-31", freq="D", tz="UTC")
    noon = np.asarray(midnights.day_of_year, float) + 0.5
    for solar_h in sun_times(latitude, declination(noon)):
        utc_h = solar_h - longitude / 15.0 - equation_of_time_h(noon)
        moments = midnights + pd.to_timedelta(utc_h, unit="h")
        elevation = pvlib.solarposition.spa_python(moments, latitude, longitude).elevation
        # A day held at noon: 0.1 deg for the quarter of a day until sunrise, 0.2 deg for the
        # series, together two minutes of time.
        assert np.max(np.abs(elevation)) < 0.3


def test_day_lengths_at_special_places() -> None:
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


@given(latitudes, days)
def test_day_of_one_hemisphere_is_night_of_the_other(latitude: float, day: float) -> None:
    delta = declination(day)
    sunrise, sunset = sun_times(latitude, delta)
    assert 0.0 <= sunrise <= 12.0 <= sunset <= 24.0
    assert sunrise + sunset == pytest.approx(24.0)  # mirrored about noon
    assert sunset - sunrise + sun_times(-latitude, delta).day_length_h == pytest.approx(24.0)


@given(st.floats(-66.0, 66.0), days)
def test_sun_is_on_the_horizon_at_sunrise(latitude: float, day: float) -> None:
    delta = declination(day)
    sunrise = sun_times(latitude, delta).sunrise_h
    # Rounding only; below the polar circle there is a sunrise on every day.
    assert cos_zenith(latitude, delta, hour_angle(sunrise)) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("latitude", [-60.0, 0.0, 47.6, 66.0, 80.0])
@pytest.mark.parametrize("day", [1.5, 80.5, 172.5, 300.5])
def test_daily_sum_of_the_projected_sun(latitude: float, day: float) -> None:
    delta = float(declination(day))
    lat = np.radians(latitude)
    sunrise, sunset = sun_times(latitude, delta)
    half = np.pi / 12.0 * float(sunset - sunrise) / 2.0
    # Closed form of the daily extraterrestrial irradiation, any textbook of solar engineering.
    expected = (
        24.0
        / np.pi
        * (np.cos(lat) * np.cos(delta) * np.sin(half) + half * np.sin(lat) * np.sin(delta))
    )
    time = np.linspace(0.0, 24.0, 24 * 60 + 1)
    up = np.maximum(cos_zenith(latitude, delta, hour_angle(time)), 0.0)
    # Trapezoids of a minute: an error of the order of (1 min / 1 h)^2 / 12.
    assert np.trapezoid(up, time) == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize(
    ("latitude", "time_h", "expected"),
    [
        (0.0, 12.0, (0.0, 0.0, -1.0)),  # overhead at noon on the equator
        (0.0, 6.0, (0.0, 1.0, 0.0)),  # due east at sunrise
        (0.0, 18.0, (0.0, -1.0, 0.0)),  # due west at sunset
        (0.0, 0.0, (0.0, 0.0, 1.0)),  # below at midnight
        (45.0, 12.0, (-np.sqrt(0.5), 0.0, -np.sqrt(0.5))),  # in the south at noon
        (-45.0, 12.0, (np.sqrt(0.5), 0.0, -np.sqrt(0.5))),  # in the north at noon
    ],
)
def test_sun_vector_at_an_equinox(
    latitude: float, time_h: float, expected: tuple[float, float, float]
) -> None:
    vector = sun_vector_ned(latitude, 0.0, hour_angle(time_h))
    assert vector == pytest.approx(np.array(expected), abs=1e-12)  # exact but for rounding


@given(latitudes, days, hours)
def test_sun_vector_has_unit_length_and_points_up_with_the_zenith_angle(
    latitude: float, day: float, time_h: float
) -> None:
    delta, w = declination(day), hour_angle(time_h)
    vector = sun_vector_ned(latitude, delta, w)
    assert np.linalg.norm(vector) == pytest.approx(1.0)
    # Rounding only.
    assert -vector[2] == pytest.approx(float(cos_zenith(latitude, delta, w)), abs=1e-12)


@given(latitudes, st.floats(-0.41, 0.41), hours)
def test_afternoon_mirrors_morning_and_south_north(
    latitude: float, delta: float, time_h: float
) -> None:
    sun = sun_vector_ned(latitude, delta, hour_angle(time_h))
    afternoon = sun_vector_ned(latitude, delta, hour_angle(24.0 - time_h))
    # Rounding only: the sun stands as far in the west as it stood in the east.
    assert afternoon == pytest.approx(sun * [1.0, -1.0, 1.0], abs=1e-12)
    south = sun_vector_ned(-latitude, -delta, hour_angle(time_h))
    assert south == pytest.approx(sun * [-1.0, 1.0, 1.0], abs=1e-12)  # rounding only


@given(days, hours)
def test_at_the_poles_the_elevation_is_the_declination(day: float, time_h: float) -> None:
    delta, w = float(declination(day)), hour_angle(time_h)
    # Rounding only.
    assert cos_zenith(90.0, delta, w) == pytest.approx(np.sin(delta), abs=1e-12)
    assert cos_zenith(-90.0, delta, w) == pytest.approx(-np.sin(delta), abs=1e-12)


def test_broadcasting_equals_scalar_calls() -> None:
    lat = np.array([-90.0, -20.0, 47.6])
    day = np.array([1.5, 172.5])
    time = np.array([0.0, 5.0, 12.0, 19.0])
    delta, w = declination(day)[:, np.newaxis], hour_angle(time)
    vectors = sun_vector_ned(lat[:, np.newaxis, np.newaxis], delta, w)
    lengths = sun_times(lat[:, np.newaxis], declination(day)).day_length_h
    assert vectors.shape == (3, 2, 4, 3)
    for i, j, k in np.ndindex(3, 2, 4):
        one = sun_vector_ned(lat[i], declination(day[j]), hour_angle(time[k]))
        # Vectorised and scalar sines may differ in the last bit.
        assert vectors[i, j, k] == pytest.approx(one, abs=1e-14)
        length = sun_times(lat[i], declination(day[j])).day_length_h
        assert lengths[i, j] == pytest.approx(float(length))
