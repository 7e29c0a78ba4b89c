"""Temperature and wind of a weather record: what cannot be, and what is lacking."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from missions.files.errors import InputError, Problem
from solar.types import FloatArray, IntArray

MAXIMUM_IMPOSSIBLE = 0.01  # share of a record whose values cannot be true, which are taken out
_LEAST_KNOWN = 0.8  # share of a record without which a quantity is not used
# What stands for "missing": EPW (99.9 C, 999 m/s), TMY3 (-9900), BSRN (-99.9, -999) and others.
_MISSING = (99.9, 99.99, 999.0, 999.9, 9999.0, 99999.0, -99.0, -99.9, -999.0, -9999.0, -9900.0)


class Quantity(NamedTuple):
    """A column beside the light, and what it can be."""

    column: str
    name: str
    lowest: float
    highest: float
    unit: str


# Around the records of the WMO (World Weather & Climate Extremes Archive): -89.2 C, 56.7 C, and
# 113 m/s in a gust.
TEMPERATURE = Quantity("temp_air", "temperature", -90.0, 70.0, "C")
WIND = Quantity("wind_speed", "wind speed", 0.0, 120.0, "m/s")


def checked_air(
    quantity: Quantity, columns: Mapping[str, FloatArray], lines: IntArray, source: str
) -> tuple[FloatArray | None, list[str]]:
    """Temperature or wind without gaps, and what was taken out of it.

    ``columns``: columns of the record, NaN where a value is missing. ``lines``: line of each row in
    the file; 0 where there is none. None where the record does not have it, or in too few rows.
    Returns what was taken out.
    """
    values = columns.get(quantity.column)
    if values is None:
        return None, []
    lowest, highest, notes = quantity.lowest, quantity.highest, []
    with np.errstate(invalid="ignore"):
        possible = (values >= lowest) & (values <= highest)
    wrong = np.flatnonzero(~possible & ~np.isnan(values) & ~np.isin(values, _MISSING))
    what = f"a {quantity.name} outside of {lowest:g} to {highest:g} {quantity.unit}"
    if len(wrong) > MAXIMUM_IMPOSSIBLE * len(values):
        first = int(wrong[0])
        message = (
            f"{len(wrong)} of {len(values)} rows have {what} (first here, {values[first]:g}): "
            "is the unit wrong?"
        )
        raise InputError(
            [Problem(source, int(lines[first]) or None, None, quantity.column, message)]
        )
    if len(wrong):
        notes.append(f"{len(wrong)} rows with {what} taken out")
    known = np.flatnonzero(possible)
    if len(known) >= _LEAST_KNOWN * len(values):
        return np.interp(np.arange(len(values)), known, values[known]), notes
    if len(known):
        notes.append(f"{quantity.name} not used: it lacks in {len(values) - len(known)} rows")
    return None, notes
