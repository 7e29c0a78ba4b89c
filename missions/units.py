"""Units in files of logs, winds and weather by their spellings, and names of columns."""

from __future__ import annotations

from typing import NamedTuple

from missions.files.data_rows import data_rows
from missions.files.errors import printable, refused

_SIGNS = str.maketrans("", "", " *^·")


class Unit(NamedTuple):
    """Unit: written values times ``factor`` plus ``offset`` are in the unit of the dimension."""

    factor: float
    offset: float = 0.0


def _plain(text: str) -> str:
    """Return a spelling without brackets, signs of powers and products, and capitals."""
    text = text.strip().strip("[]()").translate(_SIGNS)
    return text if text == "MW" else text.lower().replace("°deg", "°")  # else it would be mW


# Units of a dimension, and of all, which share no spelling; None is that of the dimension itself.
UNITS: dict[str, dict[str, Unit]] = {}
SCALES: dict[str | None, Unit] = {None: Unit(1.0)}
SPELLED: dict[str, str] = {}  # as they are usually spelled
for _row in data_rows("units", "missions"):
    _spellings = {_plain(name): name for name in _row["spellings"].split()}
    _same = dict.fromkeys(_spellings, Unit(float(_row["factor"]), float(_row["offset"])))
    UNITS.setdefault(_row["dimension"], {}).update(_same)
    SCALES.update(_same)
    SPELLED.update(_spellings)


def known_unit(text: str, *dimensions: str) -> str | None:
    """Return the key of a unit in :data:`UNITS`, None if of none of the dimensions."""
    plain = _plain(text)
    return plain if any(plain in UNITS[dimension] for dimension in dimensions) else None


def spellings(*dimensions: str) -> str:
    """Return the spellings of all units of some dimensions, in a line."""
    return ", ".join(SPELLED[unit] for dimension in dimensions for unit in UNITS[dimension])


def unit_of(text: str, what: str, *dimensions: str) -> Unit:
    """Return the unit of a quantity in a file, refused if of none of the dimensions."""
    if (unit := known_unit(text, *dimensions)) is None:
        known = spellings(*dimensions)
        raise refused(f"has {what} in {printable(text) or 'no unit'} (known: {known})")
    return SCALES[unit]


def columns_of(layout: str) -> dict[str, tuple[str, ...]]:
    """Return the names that columns and axes of a layout have in files, by quantity."""
    rows = data_rows("columns", "missions")
    return {r["quantity"]: tuple(r["names"].split("|")) for r in rows if r["layout"] == layout}
