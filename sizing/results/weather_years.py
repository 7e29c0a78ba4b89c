"""Years of a weather record: each by itself, and how they differ."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from missions.weather.record import run_lengths
from sizing.day.record import WeatherRun
from sizing.results.records import PERCENTILES, hours, percentiles
from sizing.results.tables import Column, Table

# A year that lacks more days than these is told, and not counted among the whole ones.
_MISSING_DAYS = 7
_DAYS = 365


@dataclass(frozen=True)
class YearInWeather:
    """A calendar year of a record, or what of it is in the record.

    ``whole``: whether at most a week of it is missing. ``days``, ``days_that_close``,
    ``clear_sky_days_that_close``: days of the year in the record, those that close, and those that
    close under a clear sky. ``longest_run_days``: most consecutive days of the year that close.
    ``endurance_h``: of the launches at its dawns: ``p10``, ``p50``, ``p90`` [h].
    """

    year: int
    whole: bool
    days: int
    days_that_close: int
    clear_sky_days_that_close: int
    longest_run_days: int
    endurance_h: dict[str, float]

    @property
    def share(self) -> float:
        """Days that close over days [-]."""
        return self.days_that_close / self.days

    @property
    def label(self) -> str:
        """Year, and how much of it is there."""
        return f"{self.year}" if self.whole else f"{self.year} (part)"

    def to_dict(self) -> dict[str, Any]:
        """All of it, JSON-ready."""
        return vars(self) | {"share_of_days_that_close": self.share}


def years_of(recorded: WeatherRun, clear: WeatherRun) -> tuple[YearInWeather, ...]:
    """Years of a record in their order.

    ``recorded``, ``clear``: in the record's light, and under the clear sky.
    """
    years = []
    for year in np.unique(recorded.axis.year).tolist():
        of_year = recorded.axis.year == year
        closes = recorded.closes[of_year]
        years.append(
            YearInWeather(
                year=year,
                whole=len(closes) >= _DAYS - _MISSING_DAYS,
                days=len(closes),
                days_that_close=int(closes.sum()),
                clear_sky_days_that_close=int(clear.closes[of_year].sum()),
                longest_run_days=int(np.max(run_lengths(closes), initial=0)),
                endurance_h=percentiles(recorded.endurance_h[of_year], "linear"),
            )
        )
    return tuple(years)


def year_to_year(years: tuple[YearInWeather, ...]) -> dict[str, Any] | None:
    """Spread of the whole years, JSON-ready; None where there are not two of them.

    Returns percentiles are values of years that occurred.
    """
    whole = [one for one in years if one.whole]
    if len(whole) < 2:
        return None

    def spread(values: list[float]) -> dict[str, float]:
        return percentiles(np.array(values), "inverted_cdf")

    return {
        "whole_years": len(whole),
        "days_that_close": spread([one.days_that_close for one in whole]),
        "longest_run_days": spread([one.longest_run_days for one in whole]),
        "median_endurance_h": spread([one.endurance_h["p50"] for one in whole]),
        "worst_year": min(whole, key=lambda one: one.share).year,
        "best_year": max(whole, key=lambda one: one.share).year,
    }


def year_rows(years: tuple[YearInWeather, ...]) -> list[tuple[str, str]]:
    """Rows on the spread of the years; none where there are not two whole ones."""
    record = year_to_year(years)
    if record is None:
        return []
    spread = ", ".join(f"{record['days_that_close'][p]:.0f}" for p in PERCENTILES)
    worst, best = (
        next(one for one in years if one.year == record[name])
        for name in ("worst_year", "best_year")
    )
    return [
        ("days that close in a year: 10, 50, 90 % of years", spread),
        (
            "worst year, best year",
            f"{worst.year} ({worst.days_that_close}), {best.year} ({best.days_that_close})",
        ),
    ]


def year_table(years: tuple[YearInWeather, ...]) -> Table:
    """A row a year."""
    columns = (
        Column("year"),
        Column("days"),
        Column("days_that_close", "close"),
        Column("clear_sky_days_that_close", "clear sky"),
        Column("longest_run_days", "longest run", "d"),
        Column("endurance", "endurance: 10, 50, 90 %"),
    )
    rows = [
        (
            one.label,
            one.days,
            one.days_that_close,
            one.clear_sky_days_that_close,
            one.longest_run_days,
            ", ".join(hours(one.endurance_h[p]) for p in PERCENTILES),
        )
        for one in years
    ]
    return Table("year by year", columns, tuple(rows))
