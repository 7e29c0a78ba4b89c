"""Loads of the wing: published numbers and moments by quadrature."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from sizing.structures.loads import (
    StructureInputs,
    gust_load_increment,
    limit_load_factor,
    root_bending_moment_nm,
)

G = 9.80665

spans = st.floats(1.0, 30.0)
masses = st.floats(0.5, 300.0)


@pytest.mark.parametrize(
    ("mass_kg", "expected"),
    # 2.1 + 10900/(m + 4536) worked by hand; CS 23.337 gives 2.1 + 24000/(W + 10000), W in lb.
    [(0.0, 4.503), (6.92, 4.499), (464.0, 4.280), (5464.0, 3.190)],
)
def test_limit_load_factor_values(mass_kg, expected):
    # To the digits written down.
    assert limit_load_factor(mass_kg) == pytest.approx(expected, abs=5e-4)
    pounds = mass_kg / 0.45359237
    # 10900 kg and 4536 kg are 24000 lb and 10000 lb rounded: 0.13 % of a term of 2.4.
    assert limit_load_factor(mass_kg) == pytest.approx(2.1 + 24000 / (pounds + 10000), abs=4e-3)


@given(span=spans, mass=masses, share=st.floats(0.0, 0.7))
def test_root_moment_is_that_of_an_elliptic_lift_relieved_by_an_even_mass(span, mass, share):
    half = span / 2.0
    n = limit_load_factor(mass)
    # Moments integrated numerically: lift 4 m n g/(pi b) sqrt(1 - (y/half)^2), mass evenly spread.
    lift = 4.0 * mass * n * G / (np.pi * span)
    up, _ = quad(lambda y: lift * np.sqrt(1.0 - (y / half) ** 2) * y, 0.0, half)
    down, _ = quad(lambda y: share * mass * n * G / span * y, 0.0, half)
    expected = max(up - down, 0.25 * up)
    moment = root_bending_moment_nm(span, mass, share * mass, 0.25)
    # The smooth maximum lies above by at most 2 % of the unrelieved moment, as documented.
    assert expected * (1.0 - 1e-6) <= moment <= expected + 0.02 * up * (1.0 + 1e-6)


@given(
    span=spans,
    aspect=st.floats(6.0, 35.0),
    mass=masses,
    speed=st.floats(4.0, 40.0),
    density=st.floats(0.05, 1.3),
)
def test_gust_load_is_that_of_the_rule_in_pounds_and_knots(span, aspect, mass, speed, density):
    # CS/FAR 23.341 in customary units: K U V a / (498 W/S), U in ft/s, V in knots, W/S in lb/ft2;
    # K = 0.88 mu / (5.3 + mu) with mu = 2 W/S / (rho c a g), rho in slug/ft3.
    chord_ft, area_ft2 = span / aspect / 0.3048, span**2 / aspect / 0.3048**2
    slope = 2.0 * np.pi * aspect / (aspect + 2.0)
    loading = mass / 0.45359237 / area_ft2
    ratio = 2.0 * loading / (density * 0.00194032 * chord_ft * slope * 32.174)
    alleviation = 0.88 * ratio / (5.3 + ratio)
    expected = alleviation * (15.25 / 0.3048) * (speed / 0.514444) * slope / (498.0 * loading)
    inputs = StructureInputs(span, aspect, mass, 0.0, speed, density)
    # 498 is rounded to three digits.
    assert gust_load_increment(15.25 * speed, inputs) == pytest.approx(expected, rel=2e-3)
