"""Sun position of the almanac against the Solar Position Algorithm of pvlib."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pvlib
import pytest

from solar.sun import day_angle, equation_of_time_h, sun_position

# The almanac's algorithm is good for 0.01 deg in ecliptic longitude; SPA sees the sun from the
# surface, which lowers it by up to 0.0025 deg.
TOLERANCE_DEG = 0.02
FIRST_S, LAST_S = 946684800.0, 2556143999.0  # 2000 to 2050
SITES = ((47.6, 8.53), (0.0, -179.9), (-35.0, 150.0), (70.0, 25.0), (-89.9, 100.0))


@pytest.mark.parametrize(("latitude", "longitude"), SITES)
def test_position_agrees_with_spa(latitude: float, longitude: float) -> None:
    time_s = np.sort(np.random.default_rng(1).uniform(FIRST_S, LAST_S, 2000))
    index = pd.DatetimeIndex(pd.to_datetime(time_s, unit="s", utc=True))
    spa = pvlib.solarposition.spa_python(index, latitude, longitude, delta_t=None)
    sun = sun_position(time_s, latitude, longitude)
    elevation, azimuth = np.degrees(sun.elevation_rad), np.degrees(sun.azimuth_rad)
    assert np.abs(elevation - spa["elevation"]).max() < TOLERANCE_DEG
    # On the sphere: an azimuth means nothing with the sun overhead.
    across = (azimuth - spa["azimuth"] + 180.0) % 360.0 - 180.0
    assert np.abs(across * np.cos(sun.elevation_rad)).max() < TOLERANCE_DEG


def test_vector_points_where_the_angles_say() -> None:
    time_s = np.linspace(1.4e9, 1.4e9 + 86400.0, 97)
    sun = sun_position(time_s, 47.6, 8.53)
    level = np.cos(sun.elevation_rad)
    north, east, down = sun.vector_ned.T
    assert north == pytest.approx(level * np.cos(sun.azimuth_rad), abs=1e-12)
    assert east == pytest.approx(level * np.sin(sun.azimuth_rad), abs=1e-12)
    assert down == pytest.approx(-np.sin(sun.elevation_rad), abs=1e-12)
    assert np.linalg.norm(sun.vector_ned, axis=1) == pytest.approx(1.0)


def test_sun_is_south_and_highest_at_solar_noon() -> None:
    time_s = 1435708800.0 + np.arange(0.0, 86400.0, 10.0)  # 1 July 2015
    sun = sun_position(time_s, 47.6, 8.53)
    noon = int(np.argmax(sun.elevation_rad))
    # Ten seconds of time are 0.003 h.
    assert sun.time_solar_h[noon] == pytest.approx(12.0, abs=0.005)
    assert np.degrees(sun.azimuth_rad[noon]) == pytest.approx(180.0, abs=0.2)


def test_solar_time_agrees_with_the_equation_of_time() -> None:
    day = np.arange(1, 366)
    time_s = 1420070400.0 + 86400.0 * (day - 0.5)  # noon UTC of every day of 2015
    sun = sun_position(time_s, 0.0, 0.0)
    assert day_angle(1) == 0.0
    # Spencer's series is good for about half a minute.
    assert sun.time_solar_h - 12.0 == pytest.approx(equation_of_time_h(day + 0.5), abs=0.012)


def test_arguments_broadcast() -> None:
    sun = sun_position(np.full((4, 1), 1.43e9), np.zeros(3), 10.0)
    assert sun.vector_ned.shape == (4, 3, 3)
    assert sun.declination_rad.shape == sun.time_solar_h.shape == (4, 3)
