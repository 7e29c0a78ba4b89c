"""The outcome of a prediction is right in every case that can arise."""

import math

import pytest

from sizing.day.metrics import Status
from studies.models.prediction import Prediction, duration, nights_survived


def prediction(**changes):
    fields = {
        "scenario": "50° N, 15 Aug",
        "latitude_deg": 50.0,
        "day_of_year": 227,
        "several_scenarios": True,
        "status": Status.limited,
        "excess_time_h": -3.0,
        "excess_time_low_h": -4.0,
        "excess_time_high_h": -2.0,
        "minimum_state_of_charge": 0.0,
        "charge_margin_h": 0.0,
        "endurance_h": 21.34,
        "nights": 0,
        "polar_day": False,
        "power_exceeds_load": True,
        "solar_energy_wh": 1000.0,
        "mean_solar_energy_wh": 1000.0,
    }
    return Prediction(**(fields | changes))


PERPETUAL = {"status": Status.perpetual, "excess_time_h": 3.04, "endurance_h": math.inf}


@pytest.mark.parametrize(
    ("changes", "required_h", "said"),
    [
        ({}, 0.0, "flies 21.3 h at 50° N, 15 Aug: its battery does not last the night"),
        ({"endurance_h": 30.0, "nights": 1}, 0.0, "flies 30.0 h at 50° N, 15 Aug: its battery lasts 1 night"),  # noqa: E501
        ({"endurance_h": 84.0, "nights": 3}, 0.0, "flies 3.5 days at 50° N, 15 Aug: its battery lasts 3 nights"),  # noqa: E501
        ({"endurance_h": 250.0, "nights": 10}, 0.0, "flies 10 days at 50° N, 15 Aug: the days return slightly less than the nights take"),  # noqa: E501
        ({"endurance_h": math.inf}, 0.0, "flies more than a year at 50° N, 15 Aug: the days return slightly less than the nights take"),  # noqa: E501
        ({"power_exceeds_load": False}, 0.0, "flies 21.3 h at 50° N, 15 Aug: solar power never reaches the load"),  # noqa: E501
        ({"status": Status.never_lit, "power_exceeds_load": False}, 0.0, "flies 21.3 h at 50° N, 15 Aug: there is no solar power"),  # noqa: E501
        ({"polar_day": True}, 0.0, "flies 21.3 h at 50° N, 15 Aug: the sun does not set, but the battery does not last through its low hours"),  # noqa: E501
        (PERPETUAL, 0.0, "flies perpetually in every scenario, with 3.0 h of excess time at 50° N, 15 Aug"),  # noqa: E501
        (PERPETUAL | {"several_scenarios": False}, 0.0, "flies perpetually, with 3.0 h of excess time at 50° N, 15 Aug"),  # noqa: E501
        (PERPETUAL, 3.0, "flies perpetually in every scenario, with 3.0 h of excess time at 50° N, 15 Aug"),  # noqa: E501
        (PERPETUAL, 3.04, "flies perpetually in every scenario, with 3.0 h of excess time at 50° N, 15 Aug"),  # noqa: E501
        (PERPETUAL, 6.5, "flies perpetually, but with 3.04 h of excess time at 50° N, 15 Aug instead of the required 6.5 h"),  # noqa: E501
        ({"status": Status.always_lit, "excess_time_h": math.inf}, 6.0, "flies perpetually, as solar power always exceeds the load"),  # noqa: E501
    ],
)  # fmt: skip
def test_outcome(changes, required_h, said):
    assert prediction(**changes).outcome(required_h) == said


@pytest.mark.parametrize(
    ("hours", "said"),
    [
        (0.04, "0.0 h"),
        (71.94, "71.9 h"),
        (72.0, "3 days"),
        (5605.7, "230 days"),
        (math.inf, "more than a year"),
    ],
)
def test_duration(hours, said):
    assert duration(hours) == said


@pytest.mark.parametrize(
    ("launch_h", "endurance_h", "nights"),
    [
        (6.0, 20.0, 0),  # down at 2:00
        (6.0, 23.9, 0),  # down just before the morning at 6:00
        (6.0, 24.1, 1),
        (16.0, 13.9, 0),  # launched in the evening
        (16.0, 14.1, 1),
        (23.9, 6.2, 1),  # from before midnight
        (1.0, 6.0, 0),  # from after midnight: less than half a night
        (1.0, 30.0, 1),
        (6.0, 24.1 + 72.0, 4),
        (6.0, math.inf, 0),
    ],
)
def test_nights_survived(launch_h, endurance_h, nights):
    assert nights_survived(launch_h, endurance_h, 6.0) == nights
    # No night ends without a morning.
    assert nights_survived(12.0, 50.0, math.nan) == 0
