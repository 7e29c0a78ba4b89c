"""Recovery of known parameters by fits, in a few of the cases that the documentation has."""

from __future__ import annotations

import pytest

from benchmarks.fit_published import fit_published
from benchmarks.fit_recovery import recover

pytestmark = pytest.mark.slow


def test_intervals_hold_the_truth_and_other_flights_are_predicted() -> None:
    found = recover(4, seed=400)
    hits, count = found.all_covered()
    assert count >= 12
    assert hits >= 0.9 * count
    for _, _, before, after, _, stated, _ in found.prediction_table().rows:
        # Four flights: the spread of an RMS error is 35 %.
        assert after < 0.5 * before
        assert after < 2.0 * stated


def test_intervals_hold_under_another_sky_and_with_other_cells() -> None:
    found = recover(6, seed=500, independent=1)
    hits, count = found.all_covered()
    assert count >= 16
    # 95 % of 18: 17 with a standard deviation of 0.9.
    assert hits >= count - 2
    ((_, cases, _, after, bias, _, ratio),) = found.prediction_table().rows
    assert cases == 6
    # Six flights: the spread of an RMS of standard errors is 30 %.
    assert ratio < 1.8
    assert abs(bias) < 2.0 * after


def test_figures_of_one_flight_are_met_and_tell_the_other_no_better() -> None:
    found = fit_published()
    for _, quantity, published, before, after, use in found.figures.rows:
        if use == "fitted to":
            assert after == pytest.approx(published, abs=0.01)
        elif quantity.startswith("minimum"):
            # As docs/fit.md says: each of the two flights wants another level power.
            assert abs(after - published) > abs(before - published)
    assert found.collinearity < 20.0
