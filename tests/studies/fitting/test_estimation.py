"""Intervals of least squares with residuals that last."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import AS2

from sizing.aircraft import Aircraft
from solar.types import FloatArray
from studies.fitting.channels.channel import Channel, joined
from studies.fitting.channels.flight_errors import FlightError
from studies.fitting.estimation import estimate
from studies.fitting.parameters import PARAMETERS
from studies.flight_logs.autocorrelation import correlation_time

COUNT = 200
NIGHT = np.zeros(COUNT, int)


def wandering(rho: float, rng: np.random.Generator) -> FloatArray:
    """Noise of the first order of unit variance."""
    found = np.empty(COUNT)
    found[0] = rng.standard_normal()
    for place, shock in enumerate(rng.standard_normal(COUNT - 1)):
        found[place + 1] = rho * found[place] + np.sqrt(1.0 - rho**2) * shock
    return found


def load(noise: FloatArray) -> Channel:
    """Load of an aircraft that has exactly the power of the file."""

    def predict(craft: Aircraft) -> FloatArray:
        return np.full(COUNT, PARAMETERS["level_power"].value(craft))

    measured = np.asarray(PARAMETERS["level_power"].value(AS2) + noise, float)
    time_s = np.asarray(300.0 * np.arange(COUNT), float)
    return Channel("load", "load", "W", time_s, measured, NIGHT, predict)


def test_of_independent_residuals_it_is_the_error_of_the_mean() -> None:
    noise = np.random.default_rng(1).standard_normal(COUNT)
    (one,) = estimate(load(noise), AS2, (PARAMETERS["level_power"],)).fitted
    assert one.value - one.before == pytest.approx(noise.mean(), abs=1e-6)
    # The autocorrelation time is estimated: of 200 residuals to some ten per cent.
    assert one.standard_error == pytest.approx(noise.std(ddof=1) / np.sqrt(COUNT), rel=0.25)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.85])
def test_autocorrelation_time_is_that_of_the_process(rho: float) -> None:
    rng = np.random.default_rng(2)
    times = []
    for _ in range(60):
        noise = wandering(rho, rng)
        times.append(correlation_time(noise - noise.mean(), NIGHT, 1))
    # (1 + rho)/(1 - rho); never less than the first-order estimate, so somewhat more.
    assert np.median(times) == pytest.approx((1.0 + rho) / (1.0 - rho), rel=0.25)


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    rng = np.random.default_rng(3)
    held = []
    for _ in range(120):
        (one,) = estimate(load(wandering(0.8, rng)), AS2, (PARAMETERS["level_power"],)).fitted
        held.append(one.low <= one.before <= one.high)
    # 95 % of 120: 114 with a standard deviation of 2.4.
    assert sum(held) >= 108


def test_a_known_error_widens_the_interval_by_what_is_known_of_it() -> None:
    noise = np.random.default_rng(5).standard_normal(COUNT)
    gauge = FlightError("scale", 0.04, np.ones(COUNT))
    (plain,) = estimate(load(noise), AS2, (PARAMETERS["level_power"],)).fitted
    wrong = estimate(replace(load(noise), errors=(gauge,)), AS2, (PARAMETERS["level_power"],))
    (one,) = wrong.fitted
    # A factor on everything: the flight says nothing of it, and it is independent of the noise.
    expected = np.hypot(plain.standard_error, 0.04 * one.value)
    assert one.standard_error == pytest.approx(expected, rel=0.02)
    assert one.value == pytest.approx(plain.value, rel=1e-6)
    assert wrong.errors[0].standard_error == pytest.approx(0.04, rel=0.02)


def test_several_flights_share_the_parameter_and_say_whether_they_agree() -> None:
    rng = np.random.default_rng(6)
    gauge = FlightError("scale", 0.04, np.ones(COUNT))
    parts = {n: replace(load(rng.standard_normal(COUNT)), errors=(gauge,)) for n in range(4)}
    whole = estimate(joined(parts), AS2, (PARAMETERS["level_power"],))
    (one,) = whole.fitted
    # Each flight has an error of its own: four of them halve it.
    assert one.standard_error == pytest.approx(0.5 * 0.04 * one.value, rel=0.05)
    shares = [float(flight.shares[0]) for flight in whole.solution.flights]
    assert sum(shares) == pytest.approx(1.0)
    assert shares == pytest.approx([0.25] * 4, abs=0.05)
    assert whole.solution.freedom == 3
    assert 0.0 <= whole.solution.chi_square < 11.3  # one in a hundred
    shifted = replace(parts[3], measured=parts[3].measured + 20.0)
    apart = estimate(joined({**parts, 3: shifted}), AS2, (PARAMETERS["level_power"],))
    assert apart.solution.chi_square > 30.0
    widened = np.sqrt(apart.solution.chi_square / apart.solution.freedom)
    assert apart.fitted[0].standard_error > 0.9 * widened * one.standard_error


def test_an_error_of_the_aircraft_is_one_for_all_flights() -> None:
    rng = np.random.default_rng(7)
    own = FlightError("model", 0.04, np.ones(COUNT), flight=None)
    parts = {n: replace(load(rng.standard_normal(COUNT)), errors=(own,)) for n in range(4)}
    whole = estimate(joined(parts), AS2, (PARAMETERS["level_power"],))
    assert len(whole.errors) == 1
    assert whole.fitted[0].standard_error == pytest.approx(0.04 * whole.fitted[0].value, rel=0.05)


def test_ends_of_stretches_are_no_neighbours() -> None:
    run = np.repeat(np.arange(COUNT // 4), 4)
    noise = np.repeat(np.random.default_rng(4).standard_normal(COUNT // 4), 4)
    joined = correlation_time(noise, NIGHT, 1)
    assert correlation_time(noise, run, 1) != joined
    assert 1.0 <= joined <= COUNT / 2
