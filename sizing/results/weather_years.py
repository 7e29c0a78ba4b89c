"""Years of a weather record: each by itself, and how they differ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import numpy as np

from missions.weather.record import longest_run
from sizing.day.record import WeatherRun
from sizing.results.numbers import percentiles

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
    def share_of_days_that_close(self) -> float:
        """Days that close over days [-]."""
        return self.days_that_close / self.days

    def row(self) -> dict[str, Any]:
        """Return the year as a row of a frame."""
        row = vars(self) | {"share_of_days_that_close": self.share_of_days_that_close}
        del row["endurance_h"]
        ends = {f"endurance_{name}_h": self.endurance_h[name] for name in ("p90", "p50", "p10")}
        return row | ends


@dataclass(frozen=True)
class YearToYear:
    """Spread of the whole years of a record, by percentiles that occurred in one of them."""

    whole_years: int
    days_that_close: dict[str, float]
    longest_run_days: dict[str, float]
    median_endurance_h: dict[str, float]
    worst_year: int
    best_year: int

    @classmethod
    def of(cls, years: Sequence[YearInWeather]) -> YearToYear | None:
        """Return the spread; None where there are not two whole years."""
        whole = [year for year in years if year.whole]
        if len(whole) < 2:
            return None
        share = attrgetter("share_of_days_that_close")
        return cls(
            whole_years=len(whole),
            days_that_close=percentiles([year.days_that_close for year in whole]),
            longest_run_days=percentiles([year.longest_run_days for year in whole]),
            median_endurance_h=percentiles([year.endurance_h["p50"] for year in whole]),
            worst_year=min(whole, key=share).year,
            best_year=max(whole, key=share).year,
        )


def years_of(recorded: WeatherRun, clear: WeatherRun) -> tuple[YearInWeather, ...]:
    """Return the years of a record in their order.

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
                longest_run_days=longest_run(closes),
                endurance_h=percentiles(recorded.endurance_h[of_year], "linear"),
            )
        )
    return tuple(years)
