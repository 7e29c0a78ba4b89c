"""Where and when an aircraft flies: latitudes, dates, and the scenarios of both."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field, Strict, model_validator

from missions import dates
from missions.air import MAXIMUM_ALTITUDE_M, MINIMUM_ALTITUDE_M
from solar.schema import Record, spell
from solar.sun import declination, sun_times
from solar.types import BoolArray, FloatArray, IntArray

Latitude = Annotated[float, Strict(), Field(ge=-90.0, le=90.0, allow_inf_nan=False)]
Longitude = Annotated[float, Strict(), Field(ge=-180.0, le=180.0, allow_inf_nan=False)]
Altitude = Annotated[
    float, Strict(), Field(ge=MINIMUM_ALTITUDE_M, le=MAXIMUM_ALTITUDE_M, allow_inf_nan=False)
]


SOLSTICES = (172, 355)  # 21 June and 21 December
# Why a second name of one of the mission's keys is refused.
OTHER_NAME = "is the mission's {} of {} by another name: leave one of them out"


class LatitudeRange(Record):
    """Latitudes from one to another, evenly spaced."""

    from_deg: Latitude
    to_deg: Latitude
    count: Annotated[int, Strict(), Field(ge=2, le=181)] = 3

    @model_validator(mode="after")
    def _check_ends(self) -> LatitudeRange:
        if self.from_deg == self.to_deg:
            raise ValueError(
                f"from_deg and to_deg must differ (got {spell(self.from_deg)} twice): a single "
                "latitude is written latitude_deg: 47.6"
            )
        return self

    def values(self) -> list[float]:
        """Return the latitudes [deg], ends included."""
        return [float(v) for v in np.linspace(self.from_deg, self.to_deg, self.count)]


def _date_as_code(value: Any) -> str:
    """Return a date of a file as ``MM-DD``; raise ValueError for what is none."""
    if not isinstance(value, str):
        raise ValueError(f"must be a date MM-DD, for instance 07-15 (got {value!r})")
    return dates.date_code(dates.day_of_year(value))


Date = Annotated[str, BeforeValidator(_date_as_code)]


class Dates(Record):
    """One date (``on``) or a range (``from`` to ``to``, across the year's end if need be).

    A range stands for ``count`` of its days (default 3), evenly spaced with both ends. The longest
    and the shortest day drive a design: a pick between the ends is moved to a solstice within the
    range, or the solstice is added where no count was asked for. Dates are MM-DD.
    """

    on: Date | None = None
    first: Date | None = Field(default=None, alias="from")
    last: Date | None = Field(default=None, alias="to")
    count: Annotated[int, Strict(), Field(ge=1, le=365)] | None = None

    @model_validator(mode="after")
    def _check_form(self) -> Dates:
        single = self.on is not None
        if single and (self.first or self.last or self.count):
            raise ValueError("give either 'on: MM-DD' or 'from: MM-DD' and 'to: MM-DD', not both")
        if not single and (self.first is None or self.last is None):
            raise ValueError("empty date range: give 'on: MM-DD', or 'from: MM-DD' and 'to: MM-DD'")
        return self

    def range(self) -> list[int]:
        """Return every day of year that the dates cover."""
        first, last = self.on or self.first, self.on or self.last
        assert first is not None  # both checked on construction
        assert last is not None
        return dates.days_in_range(dates.day_of_year(first), dates.day_of_year(last))

    def days(self) -> list[int]:
        """Return the days of year that stand for the range, in its order."""
        every = self.range()
        count = min(self.count or 3, len(every))
        places = np.round(np.linspace(0, len(every) - 1, count)).astype(int)
        picks = sorted(set(places.tolist()))
        inside = {every.index(day) for day in SOLSTICES if count > 1 and day in every}
        for solstice in sorted(inside - set(picks)):
            movable = [i for i in range(1, len(picks) - 1) if picks[i] not in inside]
            if movable:  # the nearest pick between the ends
                picks[min(movable, key=lambda i: abs(picks[i] - solstice))] = solstice
            elif self.count is None:
                picks.append(solstice)
        return [every[i] for i in sorted(set(picks))]


def latitude_label(latitude_deg: float) -> str:
    """Return a readable latitude, for instance ``47.6° N``."""
    hemisphere = "" if latitude_deg == 0 else " S" if latitude_deg < 0 else " N"
    return f"{spell(abs(latitude_deg))}\N{DEGREE SIGN}{hemisphere}"


@dataclass(frozen=True)
class Scenarios:
    """Latitude and day of year of each scenario, two arrays of one length.

    The days may be given as dates, ``["06-21"]`` or a ``DatetimeIndex``.
    """

    latitude_deg: FloatArray
    day_of_year: IntArray

    def __post_init__(self) -> None:
        if getattr(self.day_of_year, "dtype", np.dtype(object)).kind in "MUO":  # dates
            object.__setattr__(self, "day_of_year", dates.days_of_year(self.day_of_year))

    @classmethod
    def of_cells(cls, cells: FloatArray) -> Scenarios:
        """Return the scenarios of cells of latitude [deg] and day of year, ``(cell, 2)``."""
        return cls(cells[:, 0], cells[:, 1].astype(int))

    def __len__(self) -> int:
        return len(self.latitude_deg)

    @property
    def noon_day(self) -> FloatArray:
        """Return the fractional day of year of each scenario's noon, for the sun."""
        return np.asarray(self.day_of_year + 0.5)

    def label(self, index: int) -> str:
        """Return a readable name of a scenario, for instance ``47.6° N, 21 Jun``."""
        date = dates.date_label(int(self.day_of_year[index]))
        return f"{latitude_label(float(self.latitude_deg[index]))}, {date}"

    def in_polar_night(self) -> BoolArray:
        """Mark the scenarios in which the sun never rises."""
        times = sun_times(self.latitude_deg, declination(self.noon_day))
        return np.asarray(times.day_length_h <= 0.0)
