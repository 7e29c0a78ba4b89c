"""Requirements, bounds and parameters in words, with the key of the file that changes them.

Results name them by what the program calls them.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import NamedTuple

from sizing.aircraft import Aircraft
from sizing.data_rows import data_rows
from sizing.design_space import DesignSpace
from sizing.parameters import catalogue, label


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
