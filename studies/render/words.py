"""Numbers, requirements, parameters and notes of results as people read them.

Numbers have their units, changes are in per cent; requirements come with the key of the file that
changes them: results name them by what the program calls them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from missions.dates import date_label
from missions.files.data_rows import data_rows
from missions.mission import Mission
from sizing.design_space import DesignSpace
from sizing.parameters import catalogue, label, unit_text
from sizing.results.result import relative_change
from studies.render.tables import MISSING, UNLIMITED, Line, clock_label

if TYPE_CHECKING:
    from sizing.aircraft import Aircraft
    from sizing.program.objectives import Objective
    from sizing.validity.ranges import Extrapolation


# ---- Numbers


def change_text(before: float, after: float) -> str:
    """Return a change over the value before it, in per cent."""
    if (relative := relative_change(before, after)) is None:
        return MISSING
    shown = round(relative, 3)
    return percent(shown, "+.1f") if shown else percent(0.0)  # too small to show, it has no sign


def with_unit(value: float | None, objective: Objective, form: str = ".4g") -> str:
    """Return the value of an objective with its unit; an excess time may be unlimited."""
    if value is None or math.isnan(value):
        return MISSING
    return amount(value, objective.unit, form)


def objective_text(objective: Objective, value: float | None) -> str:
    """Return an objective in words, with its value."""
    return f"{objective.label} {with_unit(value, objective)}"


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


def required(excess_time_h: float, mission: Mission) -> str:
    """Return what is required of every scenario."""
    least, plain = given(excess_time_h, "h"), "a landing" if mission.flight else "perpetual flight"
    return f"{least} of excess time" if excess_time_h > 0.0 else plain


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


# ---- Requirements, bounds, parameters


@cache
def requirements() -> Mapping[str, Mapping[str, str]]:
    """Return words, key and reason of every requirement by its name."""
    rows = data_rows("requirements", "studies")
    return MappingProxyType({row["name"]: MappingProxyType(row) for row in rows})


_ENDS = ("maximum", "minimum")


class Words(NamedTuple):
    """A constraint for people: what, in which scenario, and the key that changes it."""

    label: str
    where: str = ""
    key: str = ""

    @property
    def without_key(self) -> str:
        """What limits, and where."""
        return f"{self.label} at {self.where}" if self.where else self.label

    def __str__(self) -> str:
        return f"{self.without_key} ({self.key})" if self.key else self.without_key


def constraint_words(name: str, aircraft: Aircraft | None = None) -> Words:
    """Return the words for a requirement or bound as results name it.

    ``name``: such as ``excess_time (45° N, 15 Aug)``, ``stall_margin_minimum``, ``wingspan_m at its
    maximum`` or ``wingspan_m at its bound``. ``aircraft``: whose design space has the keys of
    limits; without it they are those under ``limits``. Returns the name itself where nothing is
    known of it.
    """
    bounded, at_its, end = name.partition(" at its ")
    if at_its:
        largest, fields = f"maximum_{bounded}", DesignSpace.model_fields
        key = f"{bounded}.{end}" if end in _ENDS else bounded
        key = largest if largest in fields else key
        known = bounded in fields or largest in fields
        return Words(f"{label(bounded)} at its {end}", "", f"design_space.{key}" if known else "")
    plain, _, rest = name.partition(" (")
    where = rest.removesuffix(")")
    named = requirements().get(plain)
    if named is not None and named["words"]:
        return Words(named["words"], where, named["key"])
    quantity, _, end = plain.rpartition("_")
    if end in _ENDS and quantity in catalogue():
        key = f"limits.{quantity}.{end}"
        if aircraft is not None and (row := aircraft.design_space.limit_rows().get(plain)):
            key = row.key
        return Words(f"{label(quantity)} at its {end}", where, f"design_space.{key}")
    return Words(plain, where)


def parameter_words(key: str) -> str:
    """Label of a parameter by its key, limits of the design space included.

    ``key``: of the aircraft's or, behind ``mission.``, of the mission's file. Returns the key
    itself where the catalogue has no label.
    """
    if key in catalogue():
        return label(key)
    last = key.removeprefix("design_space.").removeprefix("limits.")
    for end, word in zip(_ENDS, ("largest", "least"), strict=True):
        quantity = last.removesuffix(f".{end}").removeprefix(f"{end}_")
        if quantity != last and quantity in catalogue():
            return f"{word} {label(quantity)}"
    return key


# ---- What lies outside the range of a model

HEADING = "outside the range of a model:"
# Of what is assumed instead of a model, by the model: whose excess time a note has.
_OTHERWISE = {"module_temperature": "modules as cold as the air", "battery": "unheated battery"}


def extrapolation_blocks(extrapolations: Sequence[Extrapolation], level: int) -> list[Any]:
    """Return the extrapolations in one line at level 1, in a line each at level 2."""
    if not extrapolations:
        return []
    if level > 1:
        return [Line(HEADING, "warning"), *(f"  {row.text}" for row in extrapolations)]
    labels = ", ".join(dict.fromkeys(row.label for row in extrapolations))
    text = labels if len(extrapolations) > 1 else replace(extrapolations[0], worth="").text
    return [Line(f"{HEADING} {text}", "warning")]


def extrapolation_caption(extrapolations: Sequence[Extrapolation]) -> str:
    """Return the extrapolations for a figure's caption; empty where there are none."""
    if not extrapolations:
        return ""
    names = dict.fromkeys(
        row.label
        if row.excess_time_h is None
        else f"{row.holder} ({_OTHERWISE[row.model]}: excess time {hours(row.excess_time_h)})"
        for row in extrapolations
    )
    return f"extrapolated: {', '.join(names)}"
