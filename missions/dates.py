"""Calendar days of a year of 365 days, and ranges of them that may wrap the year's end."""

from __future__ import annotations

import datetime
import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy.typing import NDArray

DAYS_PER_YEAR = 365
MONTH_LENGTHS = (31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31)
_MONTHS = (
    *("January", "February", "March", "April", "May", "June"),
    *("July", "August", "September", "October", "November", "December"),
)
# Day of the year with which each month begins.
MONTH_STARTS = tuple(1 + sum(MONTH_LENGTHS[:month]) for month in range(12))
MONTH_NAMES = tuple(name[:3] for name in _MONTHS)
_FORM = re.compile(r"(?:[0-9]{4}-)?([0-9]{1,2})-([0-9]{1,2})")
_WORDS = re.compile(r"([0-9]{1,2})\.?[ -]*([a-z]{3,9})|([a-z]{3,9}) *([0-9]{1,2})", re.IGNORECASE)


def day_of_year(date: str) -> int:
    """Day of year, 1 to 365, of a date written ``MM-DD``, ``YYYY-MM-DD`` or ``21 Jun``.

    A year is read and plays no part.

    Raises
    ------
    ValueError
        If the text is no such date; 29 February is not in a year of 365 days.
    """
    written = _month_and_day_written(date.strip())
    if written is None:
        raise ValueError(f"must be a date MM-DD, for instance 07-15 (got {date!r})")
    month, day = written
    if not 1 <= month <= 12:
        raise ValueError(f"the month must be 01 to 12 (got {date!r})")
    length = MONTH_LENGTHS[month - 1]
    if not 1 <= day <= length:
        raise ValueError(f"month {month:02d} has days 01 to {length} (got {date!r})")
    return sum(MONTH_LENGTHS[: month - 1]) + day


def days_of_year(days: Any) -> NDArray[Any]:
    """Days of year of days however they are given, one or many.

    ``days``: numbers, which stay as they are, dates as :func:`day_of_year` reads them, dates of
    Python, NumPy or pandas, such as a ``DatetimeIndex``. Returns an array of one dimension.
    """
    import numpy as np  # dates are read for --help as well

    given = np.atleast_1d(np.asarray(days))
    if given.dtype.kind == "M":
        given = np.datetime_as_string(given, unit="D")
    if given.dtype.kind not in "UO":
        return given
    return np.array([_one_day(day) for day in given])


def _one_day(day: Any) -> Any:
    if isinstance(day, datetime.date):
        return day_of_year(f"{day:%m-%d}")
    return day_of_year(str(day)) if isinstance(day, str) else day


def _month_and_day_written(date: str) -> tuple[int, int] | None:
    """Month and day of month as written, None where the text is in no form of a date."""
    if match := _FORM.fullmatch(date):
        return int(match[1]), int(match[2])
    if match := _WORDS.fullmatch(date):
        name, day = (match[2] or match[3]).title(), int(match[1] or match[4])
        # Three letters are enough to tell one month from another.
        return next(
            ((i, day) for i, month in enumerate(_MONTHS, 1) if month.startswith(name)), None
        )
    return None


def month_and_day(day: int) -> tuple[int, int]:
    """Month and day of month of a day of year; days beyond a year's end wrap."""
    rest = (int(day) - 1) % DAYS_PER_YEAR
    for month, length in enumerate(MONTH_LENGTHS, start=1):
        if rest < length:
            return month, rest + 1
        rest -= length
    raise AssertionError("unreachable: the month lengths add up to a year")


def date_label(day: int) -> str:
    """Readable date, for instance ``21 Jun``."""
    month, day_of_month = month_and_day(day)
    return f"{day_of_month} {MONTH_NAMES[month - 1]}"


def date_code(day: int) -> str:
    """Date as ``MM-DD``, the form that mission files use."""
    month, day_of_month = month_and_day(day)
    return f"{month:02d}-{day_of_month:02d}"


def days_in_range(first: int, last: int) -> list[int]:
    """All days from the first to the last, both included, across the year's end if need be.

    Returns days of year in the order of the calendar.
    """
    span = (last - first) % DAYS_PER_YEAR
    return [(first - 1 + i) % DAYS_PER_YEAR + 1 for i in range(span + 1)]
