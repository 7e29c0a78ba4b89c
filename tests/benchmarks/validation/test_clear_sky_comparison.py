"""Our clear sky beside pvlib's: simplified Solis up to 25 km, and both by day on the ground."""

import numpy as np
import pandas as pd
import pvlib
import pytest

from benchmarks.validation import clear_sky_comparison as study
from benchmarks.validation.clear_sky_comparison import light_up_to
from solar.clearsky import extraterrestrial_irradiance


@pytest.mark.parametrize(
    ("latitude_deg", "day", "of_noon", "of_day"),
    [
        (47.6, 172, 0.032, 0.042),
        (0.0, 80, 0.034, 0.031),
        (32.0, 195, 0.038, 0.033),
        # Low sun: the coefficients of the ground give too much at 9 km, Solis at 25 km.
        (47.6, 80, 0.037, 0.07),
    ],
)
def test_light_on_a_horizontal_surface_up_to_25_km_is_that_of_solis(
    latitude_deg, day, of_noon, of_day
):
    for row in light_up_to(latitude_deg=latitude_deg, day_of_year=day):
        ours, solis = row.ours, row.solis
        assert ours.ghi == pytest.approx(solis.ghi, rel=of_noon)
        assert ours.day_wh == pytest.approx(solis.day_wh, rel=of_day)
        if row.altitude_m >= 12000.0:
            assert ours.dhi == pytest.approx(solis.dhi, abs=4.0)
        if 12000.0 <= row.altitude_m <= 20000.0:
            assert ours.dni == pytest.approx(solis.dni, rel=0.06)
            assert ours.day_wh == pytest.approx(solis.day_wh, rel=0.033)


def test_solis_gives_more_than_the_sun_sends_far_above_its_range():
    # Why it is no formula to compute with there: the table says so.
    highest = light_up_to((25000.0,))[0]
    outside = float(extraterrestrial_irradiance(172.5))
    assert highest.solis.dni > outside > highest.ours.dni


@pytest.fixture(scope="module")
def rafz():
    return study.compare([study.RAFZ])


def test_own_sun_of_pvlib_changes_little(rafz):
    site = pvlib.location.Location(47.6, 8.53, altitude=536.0)
    for row in rafz:
        midnight = pd.Timestamp("2015-01-01", tz="UTC") + pd.Timedelta(days=row.day_of_year - 1)
        times = pd.date_range(midnight, periods=289, freq="5min")
        for model, ours_wh in (("ineichen", row.ineichen_wh), ("simplified_solis", row.solis_wh)):
            ghi = site.get_clearsky(times, model=model).ghi.to_numpy()
            theirs_wh = np.trapezoid(np.nan_to_num(ghi), dx=1.0 / 12.0)
            # What the pages say: refraction and the declination within the day, up to 0.8 %.
            assert theirs_wh == pytest.approx(ours_wh, rel=0.008)


def test_turbidity_is_that_of_the_climatology(rafz):
    # Ineichen & Perez (2002): 2 is very clean cold air, 3 moderate, 4 moist warm, 5 hazy.
    assert all(3.0 < row.linke_turbidity < 5.0 for row in rafz)
    assert rafz[1].linke_turbidity > rafz[3].linke_turbidity
