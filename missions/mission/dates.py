"""When an aircraft flies: a date, or the days that stand for a range of dates."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import Field, Strict, field_validator, model_validator

from missions import dates
from solar.schema import Record

SOLSTICES = (172, 355)  # 21 June and 21 December


def date_as_code(value: Any) -> str:
    """Date of a file as ``MM-DD``; ValueError for what is none."""
    if not isinstance(value, str):
        raise ValueError(f"must be a date MM-DD, for instance 07-15 (got {value!r})")
    return dates.date_code(dates.day_of_year(value))


class Dates(Record):
    """One date (``on``) or a range (``from`` to ``to``, across the year's end if need be).

    A range stands for ``count`` of its days (default 3), evenly spaced with both ends. The longest
    and the shortest day drive a design: a pick between the ends is moved to a solstice within the
    range, or the solstice is added where no count was asked for. Dates are MM-DD.
    """

    on: str | None = None
    first: str | None = Field(default=None, alias="from")
    last: str | None = Field(default=None, alias="to")
    count: Annotated[int, Strict(), Field(ge=1, le=365)] | None = None

    @field_validator("on", "first", "last", mode="before")
    @classmethod
    def _check_date(cls, value: Any) -> str | None:
        return None if value is None else date_as_code(value)

    @model_validator(mode="after")
    def _check_form(self) -> Dates:
        one = self.on is not None
        if one and (self.first or self.last or self.count):
            raise ValueError("give either 'on: MM-DD' or 'from: MM-DD' and 'to: MM-DD', not both")
        if not one and (self.first is None or self.last is None):
            raise ValueError("empty date range: give 'on: MM-DD', or 'from: MM-DD' and 'to: MM-DD'")
        return self

    def range(self) -> list[int]:
        """Every day of year that the dates cover."""
        first, last = self.on or self.first, self.on or self.last
        assert first is not None  # both checked on construction
        assert last is not None
        return dates.days_in_range(dates.day_of_year(first), dates.day_of_year(last))

    def days(self) -> list[int]:
        """Days of year that stand for the range, in its order."""
        every = self.range()
        count = min(self.count or 3, len(every))
        picks = np.unique(np.round(np.linspace(0, len(every) - 1, count)).astype(int)).tolist()
        inside = {every.index(day) for day in SOLSTICES if count > 1 and day in every}
        for solstice in sorted(inside - set(picks)):
            if not _move_pick(picks, solstice, inside) and self.count is None:
                picks.append(solstice)
        return [every[i] for i in sorted(set(picks))]


def _move_pick(picks: list[int], wanted: int, kept: set[int]) -> bool:
    """Move the nearest pick between the ends to the wanted one; false where none may move."""
    movable = [i for i in range(1, len(picks) - 1) if picks[i] not in kept]
    if not movable:
        return False
    picks[min(movable, key=lambda i: abs(picks[i] - wanted))] = wanted
    return True
