"""Component-efficiency curves and the technology of the solar modules."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from refusals import refusals
from scipy.interpolate import PchipInterpolator

from solar.modules import Curve, IncidenceTable, SolarCell, shipped_curve


@st.composite
def curves(draw):
    grid = draw(st.lists(st.integers(-1000, 1000), min_size=2, max_size=8, unique=True))
    y = draw(st.lists(st.floats(-100.0, 100.0), min_size=len(grid), max_size=len(grid)))
    return Curve(x=tuple(value / 10.0 for value in sorted(grid)), y=tuple(y))


@given(curves(), st.floats(0.0, 1e6))
def test_curve_is_constant_outside_its_points(curve, beyond):
    assert curve(curve.x[0] - beyond) == pytest.approx(curve.y[0], abs=1e-9)
    assert curve(curve.x[-1] + beyond) == pytest.approx(curve.y[-1], abs=1e-9)


@given(curves(), st.integers(0, 2**32 - 1))
def test_curve_is_the_interpolant_of_scipy(curve, seed):
    x = np.random.default_rng(seed).uniform(curve.x[0], curve.x[-1], 50)
    x = np.concatenate((x, curve.x, np.nextafter(curve.x[1:], -np.inf)))
    expected = PchipInterpolator(np.asarray(curve.x), np.asarray(curve.y))(x)
    # The same polynomials, summed in another order: rounding of values up to 100.
    np.testing.assert_allclose(curve(x), expected, rtol=1e-12, atol=1e-11)


def test_curve_with_points_close_together_is_searched():
    curve = Curve(x=(0.0, 1e-6, 1.0), y=(0.0, 1.0, 2.0))
    x = np.array([0.0, 5e-7, 1e-6, 0.5, 1.0])
    expected = PchipInterpolator(np.asarray(curve.x), np.asarray(curve.y))(x)
    np.testing.assert_allclose(curve(x), expected, rtol=1e-12)
    assert curve(0.5).shape == ()
    np.testing.assert_equal(curve([np.nan, 1.0]), [np.nan, 2.0])
    assert curve(np.zeros((2, 3, 4))).shape == (2, 3, 4)


KINDS = {kind.__name__: kind for kind in (Curve, IncidenceTable, SolarCell)}


@pytest.mark.parametrize(
    ("kind", "keys", "message"), refusals(Path(__file__).with_name("refusals.txt"))
)
def test_tables_and_cells_that_cannot_be_are_refused(kind, keys, message):
    lists = yaml.safe_load(keys).items()
    given = {key: tuple(value) if isinstance(value, list) else value for key, value in lists}
    with pytest.raises(ValidationError, match=message):
        KINDS[kind](**given)


def test_a_curve_that_is_not_shipped_is_none():
    with pytest.raises(FileNotFoundError):
        shipped_curve("no_such_curve")


@pytest.mark.parametrize(
    ("name", "published"),
    [
        ("incidence_sunpower_glass", {0: 1.0, 45: 0.97, 60: 0.915, 80: 0.56, 90: 0.0}),
        ("low_light_sunpower_c60", {50: 0.913, 200: 0.966, 800: 0.999, 1000: 1.0}),
    ],
)
def test_shipped_curves_are_the_published_ones(name, published):
    assert shipped_curve(name)(list(published)) == pytest.approx(list(published.values()))


def test_temperature_efficiency_of_the_verification_flight():
    # Oettershagen's report, late-morning flight: 96 % at 37 C, rounded to the per cent.
    assert SolarCell().temperature_efficiency(37.0) == pytest.approx(0.96, abs=0.005)
    assert SolarCell().temperature_efficiency(25.0) == 1.0
    # 0.3 %/K uses the efficiency up 333 K above 25 C.
    assert SolarCell().temperature_efficiency([358.0, 359.0, 1000.0])[1:] == pytest.approx(0.0)


def test_incidence_efficiency_takes_the_angle_of_its_cosine():
    aoi_deg = np.array([0.0, 15.0, 45.0, 70.0, 87.0])
    published = np.array([1.0, 0.997, 0.97, 0.76, 0.34])
    efficiency = SolarCell().incidence_efficiency(np.cos(np.radians(aoi_deg)))
    assert efficiency == pytest.approx(published)
    # Products of unit vectors exceed one by rounding.
    assert SolarCell().incidence_efficiency(1.0 + 1e-12) == 1.0
