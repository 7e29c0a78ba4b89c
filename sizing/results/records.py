"""Numbers of results as JSON writes them, and times as people read them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.dates import date_label
from missions.files.overrides import with_values
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.parameters import unit_text
from sizing.results.tables import MISSING, UNLIMITED
from sizing.results.tables import clock_label as clock_label
from sizing.validity.checks import check_own_models
from solar.schema import Record
from solar.types import FloatArray

if TYPE_CHECKING:
    from sizing.program.objectives import Objective

# What is smaller, in its unit, is nothing: a solver leaves such payloads, and no change is relative
# to it.
NEGLIGIBLE = 1e-6

# As reports on solar power have them: P90 is exceeded in 90 % of all cases.
PERCENTILES = {"p90": 10.0, "p50": 50.0, "p10": 90.0}


def check_subjects(aircraft: object, mission: object) -> None:
    """Refuse what is no aircraft and no mission, such as the names of some."""
    for thing, kind, load in (
        (aircraft, Aircraft, "sizing.load_aircraft"),
        (mission, Mission, "missions.load_mission"),
    ):
        if not isinstance(thing, kind):
            raise TypeError(
                f"expected {kind.__name__} (got {type(thing).__name__}); {load}(name or path) "
                "reads one"
            )
        _check_copies(thing)
    if isinstance(aircraft, Aircraft) and isinstance(mission, Mission):
        check_own_models(aircraft, mission)


def _check_copies(record: Record) -> None:
    """Validate what ``model_copy`` has changed, in a record and those inside it."""
    for name in type(record).model_fields:
        inner = getattr(record, name)
        if isinstance(inner, Record):
            _check_copies(inner)
    if record.is_unchecked():
        unknown = record.model_fields_set - type(record).model_fields.keys()
        with_values(record, {name: getattr(record, name) for name in unknown})


def finite(value: Any) -> float | None:
    """Number for JSON: null where it is infinite, not defined or missing."""
    if value is None:
        return None
    number = float(value)
    return number if math.isfinite(number) else None


def finite_values(record: Mapping[str, Any]) -> dict[str, Any]:
    """Record with null for numbers that are infinite or not defined."""
    return {
        name: finite(value) if isinstance(value, float) else value for name, value in record.items()
    }


def relative_change(before: float, after: float) -> float | None:
    """Change over the value before it [-]; None of what was next to nothing."""
    return None if abs(before) <= NEGLIGIBLE else (after - before) / before


def change_text(before: float, after: float) -> str:
    """Change over the value before it, in percent."""
    relative = relative_change(before, after)
    if relative is None:
        return MISSING
    percent = round(100.0 * relative, 1)
    return f"{percent:+.1f} %" if percent else "0.0 %"  # too small to show, it has no sign


def with_unit(value: float | None, digits: str, objective: Objective) -> str:
    """Value of an objective with its unit; an excess time may be unlimited."""
    if value is None or math.isnan(value):
        return MISSING
    return (
        UNLIMITED if math.isinf(value) else f"{value:{digits}} {unit_text(objective.unit)}".rstrip()
    )


def percentiles(values: FloatArray, method: Any) -> dict[str, float]:
    """P90, exceeded in 90 % of cases, P50 and P10.

    By the method ``inverted_cdf`` each is a value that occurred.
    """
    return {
        name: float(np.percentile(values, at, method=method)) for name, at in PERCENTILES.items()
    }


# How numbers with a unit are written in sentences.
_FORMS = {"kg": ".3f", "m": ".3f", "W": ".2f", "Wh": ".1f", "V": ".1f", "A": ".1f", "m/s": ".1f"}


def amount(value: float, unit: str) -> str:
    """Number with its unit, with the digits that people read of it."""
    return f"{format(float(value), _FORMS[unit])} {unit}"


def percent(share: float, form: str = ".1f") -> str:
    """Share in per cent."""
    return f"{format(100.0 * float(share), form)} %"


def hours(value: float) -> str:
    """Hours with two decimals."""
    return UNLIMITED if math.isinf(value) else f"{value:.2f} h"


def date_and_clock(clock_h: float, first_day: int) -> str:
    """Hours since the midnight that begins a day of the year, as a date and a clock reading."""
    days, hour = divmod(round(clock_h * 60.0) / 60.0, 24.0)
    return f"{date_label(first_day + int(days))} {clock_label(hour)}"
