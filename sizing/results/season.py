"""Days of a weather record's season, and which of them a sized design closes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from missions.dates import date_code
from missions.mission import Mission
from missions.weather.days import DayAxis
from missions.weather.record import Weather, longest_run
from sizing.program.result import SizingResult
from solar.types import BoolArray, IntArray


@dataclass(frozen=True)
class SeasonDays:
    """Days of a record's season, and which of them close.

    ``year``: of each day of the season, by local date. ``closes``: whether it closes.
    ``longest_gap_days``: most consecutive days of the season that do not close.
    """

    year: IntArray
    closes: BoolArray
    longest_gap_days: int

    @classmethod
    def of(cls, axis: DayAxis, season: BoolArray, closes: BoolArray) -> SeasonDays:
        """Return the season's days, of all days of a record and which of them close."""
        return cls(
            year=axis.year[season],
            closes=closes[season],
            longest_gap_days=longest_run(season & ~closes),
        )

    def __len__(self) -> int:
        return len(self.closes)

    @property
    def that_close(self) -> int:
        """Days that close."""
        return int(np.count_nonzero(self.closes))

    @property
    def share(self) -> float:
        """Share of the days that close [-]."""
        return self.that_close / len(self)

    def by_year(self) -> list[dict[str, Any]]:
        """Return the days, and the days that close, of each year."""
        return [
            {
                "year": int(year),
                "days": int(np.count_nonzero(at)),
                "days_that_close": int(np.count_nonzero(self.closes[at])),
                "share": float(np.mean(self.closes[at])),
            }
            for year in np.unique(self.year)
            for at in [self.year == year]
        ]


@dataclass(frozen=True)
class Survival:
    """How a sized design flies through the season of a weather record.

    ``mission``: at the record's site; its dates are the season. ``required``: share of the days
    that was asked for [-]. ``days``: of the design; of the one with the most days that close that
    was found, where no design has enough. ``clear_sky``: sizing for perpetual flight under a clear
    sky on the same dates. ``clear_sky_days``: what its design makes of the record. ``notes``: what
    was changed to fly the mission at the record's site.
    """

    weather: Weather
    mission: Mission
    required: float
    days: SeasonDays
    clear_sky: SizingResult
    clear_sky_days: SeasonDays | None
    notes: tuple[str, ...] = ()

    @property
    def season(self) -> dict[str, str]:
        """First and last date."""
        days = self.mission.dates.range()
        return {"from": date_code(days[0]), "to": date_code(days[-1])}

    @property
    def achieved(self) -> float:
        """Share of the season's days that close [-]."""
        return self.days.share

    @property
    def by_year(self) -> list[dict[str, Any]]:
        """Days of each year that close; empty where the record does not tell years apart."""
        several = not self.weather.typical and len(np.unique(self.days.year)) > 1
        return self.days.by_year() if several else []
