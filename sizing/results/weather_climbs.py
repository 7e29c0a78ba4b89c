"""Climbs through a weather record: how high, and what they are worth."""

from __future__ import annotations

from typing import Any

import numpy as np

from sizing.weather_run import WeatherPerformance


def climbs_record(done: WeatherPerformance) -> dict[str, Any] | None:
    """Climbs, and the days that close without them, JSON-ready; None of flight at one altitude."""
    climb, constant, altitude_m = done.mission.climb, done.constant, done.recorded.altitude_m
    if climb is None or constant is None or altitude_m is None:
        return None
    return {
        **climb.record,
        "median_highest_altitude_m": round(float(np.median(altitude_m.max(axis=1))), 3),
        "constant_altitude_days_that_close": int(constant.closes.sum()),
        "constant_altitude_median_endurance_h": float(np.median(constant.endurance_h)),
    }


def climbs_rows(done: WeatherPerformance) -> list[tuple[str, str]]:
    """Rows of the summary; none of flight at one altitude."""
    record = climbs_record(done)
    if record is None:
        return []
    closed, highest_m = (
        record[key] for key in ("constant_altitude_days_that_close", "median_highest_altitude_m")
    )
    return [
        ("in the record at constant altitude", f"{closed} of {len(done.recorded.closes)}"),
        ("highest altitude of a day, median", f"{highest_m:.0f} m"),
    ]


def climbs_columns(done: WeatherPerformance) -> dict[str, Any]:
    """Columns of the table of days; none of flight at one altitude."""
    constant, altitude_m = done.constant, done.recorded.altitude_m
    if constant is None or altitude_m is None:
        return {}
    highest_m = altitude_m.max(axis=1)
    return {"highest_altitude_m": highest_m, "constant_altitude_closes": constant.closes}
