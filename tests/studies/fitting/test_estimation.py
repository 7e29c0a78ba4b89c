"""Intervals of least squares with residuals that last."""

from __future__ import annotations

import numpy as np
import pytest
from builders import AS2

from sizing.aircraft import Aircraft
from solar.types import FloatArray
from studies.fitting.channels.channel import Channel
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

    def predict(craft: Aircraft, light: float) -> FloatArray:
        return np.full(COUNT, PARAMETERS["level_power"].value(craft))

    measured = PARAMETERS["level_power"].value(AS2) + noise
    time_s = 300.0 * np.arange(COUNT)
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


def test_ends_of_stretches_are_no_neighbours() -> None:
    run = np.repeat(np.arange(COUNT // 4), 4)
    noise = np.repeat(np.random.default_rng(4).standard_normal(COUNT // 4), 4)
    joined = correlation_time(noise, NIGHT, 1)
    assert correlation_time(noise, run, 1) != joined
    assert 1.0 <= joined <= COUNT / 2
