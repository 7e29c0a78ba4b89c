"""Measures of a flight in every scenario, by the keys of records and frames."""

from __future__ import annotations

from collections.abc import Callable
from operator import attrgetter
from typing import Any

import numpy as np

from sizing.day.metrics import Status
from sizing.performance import Performance


def _in_daylight(flight: Performance, hours: Any) -> Any:
    """Return instants of the sun; NaN where it does not rise or does not set."""
    return np.where(flight.day.sunset_h > flight.day.sunrise_h, hours, np.nan)


def _status_names(flight: Performance) -> list[str]:
    """Return the status for users; a cycle without any solar power is one of the limited ones."""
    every = (Status(int(number)) for number in flight.cycle.status)
    return [(Status.limited if end is Status.never_lit else end).name for end in every]


MEASURES: dict[str, Callable[[Performance], Any]] = {
    "excess_time_h": attrgetter("cycle.excess_time_h"),
    "charge_margin_h": attrgetter("cycle.charge_margin_h"),
    "endurance_h": attrgetter("endurance_h"),
    "best_launch_h": lambda flight: np.where(
        flight.cycle.perpetual, np.nan, flight.endurances.launch_h
    ),
    "minimum_state_of_charge": attrgetter("cycle.minimum_state_of_charge"),
    "status": _status_names,
    "sunrise_h": lambda flight: _in_daylight(flight, flight.day.sunrise_h),
    "sunset_h": lambda flight: _in_daylight(flight, flight.day.sunset_h),
    "day_length_h": lambda flight: flight.day.sunset_h - flight.day.sunrise_h,
    "equal_power_morning_h": attrgetter("cycle.equal_power_morning_h"),
    "equal_power_evening_h": attrgetter("cycle.equal_power_evening_h"),
    "full_charge_h": attrgetter("cycle.full_charge_h"),
    "power_out_w": lambda flight: np.broadcast_to(flight.nominal_load_w, flight.cycle.status.shape),
    "solar_energy_wh": attrgetter("cycle.energy_budget.solar_wh"),
    "load_energy_wh": attrgetter("cycle.energy_budget.load_wh"),
    "curtailed_energy_wh": attrgetter("cycle.energy_budget.curtailed_wh"),
}
# Those of the record of a scenario.
OF_SCENARIO = tuple(key for key in MEASURES if key != "day_length_h")
