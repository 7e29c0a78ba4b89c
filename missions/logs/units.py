"""Quantities of a log: possible ranges, names elsewhere, and units told by the values."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from missions.files.data_rows import data_rows
from solar.types import FloatArray

TIME, EPOCH = "time_utc", "time_utc_s"
ATTITUDE = ("roll_deg", "pitch_deg", "yaw_deg")
MPPT = "solar_power_w: "  # power of one of several MPPTs, before its own name


class Quantity(NamedTuple):
    """Quantity of a log: dimension, lowest and highest possible value in its unit.

    ``rests``: whether one value may stay for minutes in flight. ``aliases``: names that it goes by
    elsewhere, likeliest first, in lower case without anything between words and without a unit.
    """

    dimension: str
    low: float
    high: float
    rests: bool
    aliases: str


def quantity_of(column: str) -> str:
    """Return the quantity of a column; the power of an MPPT has its name behind it."""
    return column.partition(":")[0]


QUANTITIES: Mapping[str, Quantity] = {
    row["quantity"]: Quantity(
        row["dimension"],
        float(row["low"]),
        float(row["high"]),
        row["rests"] == "yes",
        row["aliases"],
    )
    for row in data_rows("log_quantities", "missions")
}
_TWO_PI = 2.0 * np.pi


def split_unit(name: str) -> tuple[str, str | None]:
    """Split a column's name from the unit behind it, in brackets or after a spaced slash."""
    for pattern in (r"(.*\S)\s*[\[(]([^\[\]()]*)[\])]", r"(.*\S)\s+/\s+(\S+)"):
        if match := re.fullmatch(pattern, name.strip()):
            return match[1], match[2].strip()
    return name.strip(), None


def recognised(quantity: str, dimension: str, values: FloatArray) -> str | None:
    """Return the unit that the values prove, None if they may be in the log format's."""
    known = values[np.isfinite(values)]
    if not len(known):
        return None
    largest, median = float(np.abs(known).max()), float(np.median(known))
    whole = bool(np.all(known == np.round(known)))
    if quantity in ("latitude_deg", "longitude_deg"):
        # Integers of 1e-7 degrees are what GPS receivers and autopilots write.
        return "dege7" if whole and 1e4 < largest <= 1.8e9 else None
    if dimension == "length":
        return "mm" if whole and largest > 32_000.0 else None
    if dimension == "share":
        return "%" if 1.5 < largest <= 105.0 else None
    if dimension == "temperature":
        return "k" if median > 150.0 else None
    return None


def in_radians(roll: FloatArray, pitch: FloatArray, yaw: FloatArray) -> bool:
    """Return true if three columns without a unit can be an attitude in radians."""
    angles = [a[np.isfinite(a)] for a in (roll, pitch, yaw)]
    if any(not len(a) for a in angles):
        return False
    within = all(float(np.abs(a).max()) <= _TWO_PI + 1e-3 for a in angles)
    return within and float(np.ptp(angles[2])) > 3.0


def surely_radians(roll: FloatArray, pitch: FloatArray, yaw: FloatArray) -> bool:
    """Return true if the yaw fills and jumps by a turn of 2 pi: surely radians."""
    if not in_radians(roll, pitch, yaw):
        return False
    known = yaw[np.isfinite(yaw)]
    edge = float(np.abs(known).max())
    full = 0.95 * np.pi < edge <= np.pi + 1e-3 or 1.9 * np.pi < edge <= _TWO_PI + 1e-3
    jumps = np.abs(np.abs(np.diff(known)) - _TWO_PI) < 0.25 * _TWO_PI
    return bool(full and jumps.sum() >= 2 and np.ptp(known) > 0.9 * _TWO_PI)
