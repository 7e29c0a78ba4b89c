"""Two designs side by side: their quantities, and the keys of their files that differ."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.parameters import MISSION_PREFIX, unit_text
from sizing.results.analysis import Analysis
from sizing.results.records import finite
from sizing.results.tables import MISSING, Column, Result, Summary, Table, data_frame
from studies.exchange.design_sheet import (
    DesignSheet,
    Entry,
    design_sheet,
    group_starts,
    number_text,
)

if TYPE_CHECKING:
    import pandas as pd

# Relative differences below this are rounding, of files that were written and read again.
_EQUAL = 1e-9
# Names and remarks, and what differs between two files of one and the same aircraft.
_NOT_COMPARED = {"name", "description", "format_version"}
_LONGEST_VALUE = 24  # characters of a value in the table


@dataclass(frozen=True)
class ChangedKey:
    """A key of the files whose values differ; None stands for a file that does not have it.

    ``key``: of the aircraft, or of the mission behind ``mission.``. ``first``, ``second``: values,
    JSON-ready; defaults count as values.
    """

    key: str
    first: Any
    second: Any


@dataclass(frozen=True, repr=False)
class DesignDifference(Result):
    """Two designs, quantity by quantity.

    Attributes
    ----------
    first, second : DesignSheet
    keys : tuple of ChangedKey
        Keys of aircraft and mission whose values differ.
    """

    first: DesignSheet
    second: DesignSheet
    keys: tuple[ChangedKey, ...]

    def headline(self) -> str:
        """Both designs, and how many keys differ."""
        return f"{self.first.title} and {self.second.title}: {_count(len(self.keys), 'key')} differ"

    def rows(self) -> list[tuple[Entry, float | str | None, float | str | None]]:
        """Quantities of either design, and their values in both; None where one has none."""
        one, two = ({q.key: q for q in sheet.quantities} for sheet in (self.first, self.second))
        pairs = [(q, q.value, two[q.key].value if q.key in two else None) for q in one.values()]
        for q in two.values():
            if q.key not in one:
                last = max(
                    (i for i, row in enumerate(pairs) if row[0].group == q.group), default=-1
                )
                pairs.insert(last + 1, (q, None, q.value))
        return pairs

    def summary(self) -> Summary:
        """Quantities side by side, then the keys of the files that differ."""
        titles = f"A: {self.first.title}. B: {self.second.title}."
        return Summary((titles, self._compared_quantities(), self._changed()))

    def to_dict(self) -> dict[str, Any]:
        """Everything, JSON-ready."""
        return {
            "a": self.first.title,
            "b": self.second.title,
            "quantities": [
                {
                    "key": q.key,
                    "label": q.label,
                    "unit": q.unit,
                    "a": _json(one),
                    "b": _json(two),
                    "difference": _json(difference(one, two)),
                }
                for q, one, two in self.rows()
            ],
            "keys": [{"key": k.key, "a": k.first, "b": k.second} for k in self.keys],
        }

    def to_frame(self) -> pd.DataFrame:
        """Quantities of both designs as a pandas frame, all digits."""
        rows = [(q.key, q.label, q.unit, a, b, difference(a, b)) for q, a, b in self.rows()]
        return data_frame(rows, columns=["key", "label", "unit", "a", "b", "difference"])

    def _compared_quantities(self) -> Table:
        columns = (
            Column("quantity"),
            Column("a", "A", to_right=True),
            Column("b", "B", to_right=True),
            Column("change", to_right=True),
            Column("relative", "relative", to_right=True),
            Column("unit"),
        )
        compared = self.rows()
        rows = tuple(
            (quantity.label, number_text(one), number_text(two), *_difference_text(one, two),
             unit_text(quantity.unit))
            for quantity, one, two in compared
        )  # fmt: skip
        sections = group_starts([quantity for quantity, _, _ in compared])
        notes = dict.fromkeys((*self.first.notes, *self.second.notes))
        if len(notes) > 1:
            texts = [f"{letter}: {' '.join(s.notes)}" for letter, s in
                     (("A", self.first), ("B", self.second))]  # fmt: skip
        else:
            texts = list(notes)
        return Table("", columns, rows, tuple(texts), sections=sections)

    def _changed(self) -> Table:
        columns = (Column("key"), Column("a", "A"), Column("b", "B"))
        rows = tuple((k.key, _shown(k.first), _shown(k.second)) for k in self.keys)
        if not rows:
            return Table("", columns, (), ("No key of the files differs.",), headings=False)
        return Table("keys of the files that differ", columns, rows)


def compare_designs(first: Analysis, second: Analysis) -> DesignDifference:
    """Put two designs side by side.

    Parameters
    ----------
    first, second : Analysis
        Of any two aircraft, on the same mission or on two.

    Returns
    -------
    DesignDifference
    """
    keys = [
        *_changed_keys("", first.aircraft, second.aircraft),
        *_changed_keys(MISSION_PREFIX, first.mission, second.mission),
    ]
    return DesignDifference(design_sheet(first), design_sheet(second), tuple(keys))


def difference(one: float | str | None, two: float | str | None) -> float | None:
    """Second minus first; None where it is not defined, zero where they differ by rounding."""
    if not isinstance(one, int | float) or not isinstance(two, int | float):
        return None
    if one == two:
        return 0.0
    step = two - one
    if math.isinf(step):
        return step
    return 0.0 if abs(step) <= _EQUAL * max(abs(one), abs(two)) else step


def _difference_text(one: float | str | None, two: float | str | None) -> tuple[str, str]:
    """Difference, and relative to the first in per cent."""
    step = difference(one, two)
    if step is None:
        return MISSING, MISSING
    if step == 0.0:
        return "=", ""
    if math.isinf(step):
        return MISSING, MISSING
    sign = "+" if step > 0 else "-"
    share = 100.0 * step / abs(float(one)) if one else float("nan")
    relative = f"{share:+.1f} %" if abs(share) >= 0.05 else f"{sign}0.0 %" if one else MISSING
    return f"{sign}{number_text(abs(step))}", relative


def _changed_keys(
    prefix: str, first: Aircraft | Mission, second: Aircraft | Mission
) -> Iterator[ChangedKey]:
    one, two = (record.model_dump(mode="json", by_alias=True) for record in (first, second))
    for name in _NOT_COMPARED:
        one.pop(name, None)
        two.pop(name, None)
    yield from _changes(prefix, one, two)


def _changes(prefix: str, one: Any, two: Any) -> Iterator[ChangedKey]:
    """Values that differ; a mapping that only one of both has is a single one."""
    if not (isinstance(one, Mapping) and isinstance(two, Mapping)):
        if not _equal(one, two):
            yield ChangedKey(prefix, one, two)
        return
    for name in dict.fromkeys((*one, *two)):
        key = f"{prefix}{name}" if not prefix or prefix == MISSION_PREFIX else f"{prefix}.{name}"
        yield from _changes(key, one.get(name), two.get(name))


def _equal(one: Any, two: Any) -> bool:
    if isinstance(one, float | int) and isinstance(two, float | int):
        return difference(one, two) == 0.0
    if isinstance(one, Sequence) and isinstance(two, Sequence) and not isinstance(one, str):
        return len(one) == len(two) and all(map(_equal, one, two))
    if isinstance(one, Mapping) and isinstance(two, Mapping):
        return one.keys() == two.keys() and all(_equal(one[key], two[key]) for key in one)
    return bool(one == two)


def _shown(value: Any) -> str:
    """Value in a few characters: a list by its length, a mapping by what it is."""
    if value is None:
        return MISSING
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, Mapping):
        return str(value.get("model") or value.get("kind") or "given")
    if isinstance(value, list):
        return f"{_count(len(value), 'value')}"
    text = str(value)
    return text if len(text) <= _LONGEST_VALUE else f"{text[: _LONGEST_VALUE - 3]}..."


def _json(value: float | str | None) -> float | str | None:
    return value if value is None or isinstance(value, str) else finite(value)


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
