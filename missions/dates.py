"""Calendar of a year of 365 days; ranges may wrap the year's end."""

from __future__ import annotations

import datetime
import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy.typing import NDArray

DAYS_PER_YEAR = 365
_NEW_YEAR = datetime.date(2001, 1, 1)  # of a year without 29 February
MONTH_LENGTHS = (31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31)
_MONTHS = (
    "January", "February", "March", "April", "May", "June",
    "July", "August", "September", "October", "November", "December",
)  # fmt: skip
# Day of the year with which each month begins.
MONTH_STARTS = tuple(1 + sum(MONTH_LENGTHS[:month]) for month in range(12))
MONTH_NAMES = tuple(name[:3] for name in _MONTHS)
_FORM = re.compile(r"(?:[0-9]{4}-)?([0-9]{1,2})-([0-9]{1,2})")
_WORDS = re.compile(r"([0-9]{1,2})\.?[ -]*([a-z]{3,9})|([a-z]{3,9}) *([0-9]{1,2})", re.IGNORECASE)


def day_of_year(date: str) -> int:
    """Return the day of year, 1 to 365, of a date ``MM-DD``, ``YYYY-MM-DD`` or ``21 Jun``.

    The year is ignored.

    Raises
    ------
    ValueError
        If the text is no such date; 29 February is not in a year of 365 days.
    """
    month = day = None
    if match := _FORM.fullmatch(date.strip()):
        month, day = int(match[1]), int(match[2])
    elif match := _WORDS.fullmatch(date.strip()):
        name, day = (match[2] or match[3]).title(), int(match[1] or match[4])
        # Three letters are enough to tell one month from another.
        month = next((i for i, word in enumerate(_MONTHS, 1) if word.startswith(name)), None)
    if month is None or day is None:
        raise ValueError(f"must be a date MM-DD, for instance 07-15 (got {date!r})")
    if not 1 <= month <= 12:
        raise ValueError(f"the month must be 01 to 12 (got {date!r})")
    length = MONTH_LENGTHS[month - 1]
    if not 1 <= day <= length:
        raise ValueError(f"month {month:02d} has days 01 to {length} (got {date!r})")
    return sum(MONTH_LENGTHS[: month - 1]) + day


def days_of_year(days: Any) -> NDArray[Any]:
    """Convert days to days of year, shape ``(day,)``.

    ``days``: numbers, which stay as they are, texts as :func:`day_of_year` reads them, or dates of
    Python, NumPy or pandas, such as a ``DatetimeIndex``.
    """
    import numpy as np  # dates are read for --help as well

    values = np.atleast_1d(np.asarray(days))
    if values.dtype.kind == "M":
        values = np.datetime_as_string(values, unit="D")
    if values.dtype.kind not in "UO":
        return values
    texts = [f"{day:%m-%d}" if isinstance(day, datetime.date) else day for day in values]
    return np.array([day_of_year(day) if isinstance(day, str) else day for day in texts])


def month_and_day(day: int) -> tuple[int, int]:
    """Return month and day of month of a day of year; days beyond the year's end wrap."""
    date = _NEW_YEAR + datetime.timedelta(days=(int(day) - 1) % DAYS_PER_YEAR)
    return date.month, date.day


def date_label(day: int) -> str:
    """Return a readable date, for instance ``21 Jun``."""
    month, day_of_month = month_and_day(day)
    return f"{day_of_month} {MONTH_NAMES[month - 1]}"


def date_code(day: int) -> str:
    """Return a date as ``MM-DD``, the form that mission files use."""
    month, day_of_month = month_and_day(day)
    return f"{month:02d}-{day_of_month:02d}"


def days_in_range(first: int, last: int) -> list[int]:
    """Return the days of year from first to last, both included, across the year's end."""
    span = (last - first) % DAYS_PER_YEAR
    return [(first - 1 + i) % DAYS_PER_YEAR + 1 for i in range(span + 1)]
