"""Roots of many functions at once, against functions whose roots are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import elementwise

from sizing.roots import bracketed_root, lightest_mass


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 9))
def test_bracketed_roots_are_those_of_scipy(seed, count):
    rng = np.random.default_rng(seed)
    root, bend = rng.uniform(-1.0, 1.0, count), rng.uniform(0.1, 30.0, count)
    ends = np.full(count, -1.0), np.full(count, 1.0)

    def value(x, *parameters):
        root, bend = parameters
        return np.expm1(bend * (root - x))

    tolerances = {"xrtol": 1e-11}
    reference = elementwise.find_root(value, ends, args=(root, bend), tolerances=tolerances)
    # The same steps, so the same points.
    np.testing.assert_array_equal(
        bracketed_root(lambda x: value(x, root, bend), *ends, 1e-11), reference.x
    )


def test_ends_of_a_bracket_are_roots_and_ends_of_one_sign_have_none():
    lower, upper = np.array([0.0, -1.0, 1.0]), np.array([1.0, 0.0, 2.0])
    np.testing.assert_array_equal(bracketed_root(lambda x: x, lower, upper), [0.0, 0.0, np.nan])


def test_the_lightest_of_two_masses_is_found_in_few_rounds():
    """Budgets of 8 + 0.02 m^2 and the like meet their mass twice, nearly once, or never."""
    rounds = []

    def lightest(*fixed_kg):
        def budget_kg(rows, assumed_kg):
            rounds.append(len(rows))
            return np.array(fixed_kg)[rows] + 0.02 * assumed_kg**2

        return lightest_mass(budget_kg, np.ones(len(fixed_kg)))

    masses = lightest(8.0, 12.49, 12.6)
    lower = (1.0 - np.sqrt(1.0 - 0.08 * np.array([8.0, 12.49]))) / 0.04
    assert masses == pytest.approx([*lower, np.inf], rel=1e-9)
    plain, mass_kg = 0, 1.0
    while abs(3.0 + 0.02 * mass_kg**2 - mass_kg) > 1e-13 * mass_kg:
        mass_kg, plain = 3.0 + 0.02 * mass_kg**2, plain + 1
    rounds.clear()
    assert lightest(3.0) == pytest.approx(mass_kg, rel=1e-12)
    assert len(rounds) <= plain // 2
