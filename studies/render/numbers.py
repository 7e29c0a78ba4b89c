"""Numbers as people read them: with units, changes in per cent, hours and dates."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from missions.dates import date_label
from sizing.parameters import unit_text
from sizing.results.numbers import relative_change
from studies.render.tables import MISSING, UNLIMITED, clock_label

if TYPE_CHECKING:
    from sizing.program.objectives import Objective


def change_text(before: float, after: float) -> str:
    """Return a change over the value before it, in per cent."""
    relative = relative_change(before, after)
    if relative is None:
        return MISSING
    shown = round(relative, 3)
    return percent(shown, "+.1f") if shown else percent(0.0)  # too small to show, it has no sign


def with_unit(value: float | None, digits: str, objective: Objective) -> str:
    """Return the value of an objective with its unit; an excess time may be unlimited."""
    if value is None or math.isnan(value):
        return MISSING
    return amount(value, objective.unit, digits)


# How numbers with a unit are written in sentences.
_FORMS = {"kg": ".3f", "m": ".3f", "W": ".2f", "h": ".2f"} | dict.fromkeys(
    ("Wh", "V", "A", "m/s"), ".1f"
)


def amount(value: float, unit: str = "", form: str = "") -> str:
    """Return a number with its unit, with the digits that people read of it, or in another form."""
    if not math.isfinite(value):
        return UNLIMITED if value > 0.0 else "none"
    digits = form or _FORMS.get(unit, "g")
    return f"{format(float(value), digits)} {unit_text(unit)}".rstrip()


def given(value: float, unit: str = "") -> str:
    """Return a number with its unit, with the digits that a file gave."""
    return amount(value, unit, "g")


def required(excess_time_h: float) -> str:
    """Return what is required of every scenario."""
    least = given(excess_time_h, "h")
    return f"{least} of excess time" if excess_time_h > 0.0 else "perpetual flight"


def percent(share: float, form: str = ".1f") -> str:
    """Return a share in per cent."""
    return f"{format(100.0 * float(share), form)} %"


def hours(value: float) -> str:
    """Return hours with two decimals."""
    return amount(value, "h")


def date_and_clock(clock_h: float, first_day: int) -> str:
    """Return hours since the first midnight of a day of the year as a date and a clock reading."""
    days, hour = divmod(round(clock_h * 60.0) / 60.0, 24.0)
    return f"{date_label(first_day + int(days))} {clock_label(hour)}"


def clock_of_day(hour: float) -> str:
    """Return the clock of an hour counted on from the first midnight, with its day."""
    days = int(hour // 24.0)
    return f"{clock_label(hour % 24.0)}" + (f" on day {days + 1}" if days else "")
