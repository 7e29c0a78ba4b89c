"""Roots of many functions at once, against functions whose roots are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import elementwise

from sizing.roots import FallingRoots, bracketed_root

LIMIT = 1e-11


def falling_root(gain, lower, upper, limit):
    every = np.arange(len(lower))
    search = FallingRoots(lower, upper, gain(every, lower), gain(every, upper), limit)
    while search.open.size:
        search.take(gain(search.open, search.trial))
    return search.root


def kinked(place, x, root, slopes):
    """Falling lines with a kink half-way to the root; no slope is steeper than -1."""
    r, left, right = root[place], slopes[0][place], slopes[1][place]
    return np.where(x < r, left * (r - x), -right * (x - r))


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 9))
def test_roots_of_kinked_lines_are_found(seed, count):
    rng = np.random.default_rng(seed)
    root = rng.uniform(0.01, 0.99, count)
    slopes = rng.uniform(1e-3, 1.0, (2, count))
    zeros, ones, limit = np.zeros(count), np.ones(count), np.full(count, LIMIT)
    roots = falling_root(lambda i, x: kinked(i, x, root, slopes), zeros, ones, limit)
    # The value is settled to the limit; the argument to that over the least slope.
    np.testing.assert_allclose(roots, root, atol=LIMIT / 1e-3)


@pytest.mark.parametrize(
    ("value", "most"),
    [
        # Two ends, and secants that gain digits by half again each: bisection would take 36.
        pytest.param(lambda x: 0.7 * np.exp(-x) - 0.35 - 0.3 * x, 10, id="smooth"),
        # A day that loses the same from most states: false positions alone creep along it, but the
        # lower end's value leads to the root, as the day cannot lose more than it began with.
        pytest.param(
            lambda x: np.maximum(0.52 - x, -1e-4) - 0.2 * np.maximum(x - 0.75, 0.0), 7, id="plateau"
        ),
    ],
)
def test_smooth_functions_and_plateaus_take_few_rounds(value, most):
    rounds = []

    def gain(place, x):
        rounds.append(len(place))
        return value(x)

    roots = falling_root(gain, np.zeros(1), np.ones(1), np.full(1, LIMIT))
    assert value(roots[0]) == pytest.approx(0.0, abs=LIMIT)
    assert len(rounds) <= most


def test_functions_do_not_depend_on_each_other():
    rng = np.random.default_rng(3)
    root, bend = rng.uniform(0.1, 0.9, 20), rng.uniform(1.0, 9.0, 20)

    def found(numbers):
        def gain(place, x):
            of = numbers[place]
            return np.tanh(bend[of] * (root[of] - x)) / bend[of]

        zeros = np.zeros(len(numbers))
        return falling_root(gain, zeros, zeros + 1.0, zeros + 1e-3)

    alone = [found(np.array([number]))[0] for number in range(20)]
    assert found(np.arange(20)).tolist() == alone
    # An element without gain at the lower end has its root there.
    roots = falling_root(lambda i, x: -0.2 * x, np.zeros(3), np.ones(3), np.full(3, LIMIT))
    assert roots.tolist() == [0.0, 0.0, 0.0]


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
