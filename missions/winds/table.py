"""Percentiles of the wind over latitude, altitude and month.

Linear in latitude, altitude and percentile, constant within a month; no extrapolation.
"""

from __future__ import annotations

import gzip
import math
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources

import numpy as np
from numpy.typing import ArrayLike

from missions.dates import MONTH_NAMES
from missions.files.errors import InputError, Problem, file_error
from missions.files.tables import number_rows, text_table
from solar.schema import Allowed, refusal, spell, spell_ends
from solar.types import FloatArray, IntArray

COLUMNS = ("latitude_deg", "altitude_m", "month", "percentile", "wind_m_per_s")
SHIPPED_SOURCE = "the shipped table"
_SHIPPED = "zonal-p95.csv.gz"
# Strongest wind of a table: the stratosphere's polar night jet reaches some 200 m/s.
STRONGEST_M_PER_S = 400.0
_ALLOWED = {
    "latitude_deg": Allowed(-90.0, 90.0),
    "altitude_m": Allowed(-500.0, 80000.0),
    "month": Allowed(1.0, 12.0),
    "percentile": Allowed(0.0, 100.0),
    "wind_m_per_s": Allowed(0.0, STRONGEST_M_PER_S),
}


def neighbours(axis: FloatArray, values: ArrayLike) -> tuple[IntArray, IntArray, FloatArray]:
    """Return indices of the neighbours of values within an axis, and the weight of the upper ones.

    The axis may have a single point.
    """
    at = np.asarray(values, float)
    upper = np.clip(np.searchsorted(axis, at), min(1, len(axis) - 1), len(axis) - 1)
    lower = np.maximum(upper - 1, 0)
    width = axis[upper] - axis[lower]
    weight = np.where(width > 0.0, (at - axis[lower]) / np.where(width > 0.0, width, 1.0), 0.0)
    return lower, upper, weight


@dataclass(frozen=True, eq=False)
class WindTable:
    """Percentiles of the wind speed, on ascending axes.

    ``wind_m_per_s`` has the shape ``(latitude, altitude, month, percentile)``.
    """

    source: str
    latitude_deg: FloatArray
    altitude_m: FloatArray
    months: tuple[int, ...]
    percentiles: FloatArray
    wind_m_per_s: FloatArray

    def _check(self, name: str, values: ArrayLike, axis: FloatArray, hint: str = "") -> None:
        """Refuse values beyond an axis, with a hint for the shipped table."""
        requested = np.atleast_1d(np.asarray(values, float))
        outside = requested[(requested < axis[0]) | (requested > axis[-1])]
        if outside.size:
            hint = hint if self.source == SHIPPED_SOURCE else ""
            why = refusal(f"has {name} {spell_ends(axis)}", outside[0])
            raise file_error(self.source, why + hint)

    def at(
        self, latitude_deg: ArrayLike, altitude_m: ArrayLike, month: ArrayLike, percentile: float
    ) -> FloatArray:
        """Return the wind speed that is not exceeded for ``percentile`` of the time [m/s]."""
        curve = self.curve(latitude_deg, altitude_m, month)
        hint = ": give wind.file with others"
        self._check("percentile", percentile, self.percentiles, hint)
        lower, upper, weight = neighbours(self.percentiles, percentile)
        return np.asarray(curve[..., lower] * (1.0 - weight) + curve[..., upper] * weight)

    def curve(self, latitude_deg: ArrayLike, altitude_m: ArrayLike, month: ArrayLike) -> FloatArray:
        """Return the wind speed of every percentile of the table, on the last axis [m/s]."""
        self._check("latitude_deg", latitude_deg, self.latitude_deg)
        self._check("altitude_m", altitude_m, self.altitude_m)
        for number in np.unique(np.asarray(month, int)).tolist():
            if number not in self.months:
                raise file_error(self.source, f"lacks the month {MONTH_NAMES[number - 1]}")
        places = np.broadcast_arrays(
            *neighbours(self.latitude_deg, latitude_deg),
            *neighbours(self.altitude_m, altitude_m),
            np.searchsorted(self.months, np.asarray(month, int)),
        )
        south, north, to_north, below, above, to_above, m = places
        winds = self.wind_m_per_s
        v, w = to_above[..., np.newaxis], to_north[..., np.newaxis]
        southern = winds[south, below, m] * (1.0 - v) + winds[south, above, m] * v
        northern = winds[north, below, m] * (1.0 - v) + winds[north, above, m] * v
        return np.asarray(southern * (1.0 - w) + northern * w)

    def share_below(
        self,
        speed_m_per_s: ArrayLike,
        latitude_deg: ArrayLike,
        altitude_m: ArrayLike,
        month: ArrayLike,
    ) -> FloatArray:
        """Return the share of the time in which the wind is at most so strong [-].

        Linear between the percentiles of the table; below the lowest and above the highest the
        speeds are distributed as Rayleigh's, through that percentile:
        ``F(v) = 1 - (1 - p)^((v / v_p)^2)``.
        """
        curve = self.curve(latitude_deg, altitude_m, month)
        speed, levels = np.asarray(speed_m_per_s, float), self.percentiles / 100.0
        share = _rayleigh(speed, curve[..., 0], levels[0])
        for i in range(len(levels) - 1):
            low, high = curve[..., i], curve[..., i + 1]
            width = high - low
            part = np.where(width > 0.0, (speed - low) / np.where(width > 0.0, width, 1.0), 1.0)
            between = levels[i] + (levels[i + 1] - levels[i]) * np.clip(part, 0.0, 1.0)
            share = np.where(speed >= low, between, share)
        above = _rayleigh(speed, curve[..., -1], levels[-1])
        return np.asarray(np.where(speed >= curve[..., -1], above, share))


def _rayleigh(speed: FloatArray, wind: FloatArray, share: float) -> FloatArray:
    """Return the share below ``speed`` of a Rayleigh distribution with ``share`` below ``wind``."""
    calm = wind <= 0.0
    ratio = np.maximum(speed, 0.0) / np.where(calm, 1.0, wind)
    return np.where(calm, 1.0, -np.expm1(np.log1p(-share) * ratio**2))


@lru_cache(maxsize=1)
def shipped_winds() -> WindTable:
    """Read the shipped table: 95th percentiles, zonal, from 9.1 to 33 km."""
    file = resources.files("missions").joinpath("winds", "data", _SHIPPED)
    return wind_table_from_text(gzip.decompress(file.read_bytes()).decode(), SHIPPED_SOURCE)


def wind_table_from_text(text: str, source: str) -> WindTable:
    """Read CSV text: a row for each latitude, altitude, month and percentile."""
    table = text_table(text)
    if sorted(table.names) != sorted(COLUMNS):
        raise file_error(source, f"has no line of the columns {', '.join(COLUMNS)}")
    rows, lines, problems = number_rows(table, _ALLOWED, source)
    columns = {name: rows[:, table.names.index(name)] for name in COLUMNS}
    for row in np.flatnonzero(columns["month"] % 1.0)[:1]:
        message = refusal("must be a whole number", columns["month"][row])
        problems.append(Problem(source, lines[row], None, "month", message))
    if problems:
        raise InputError(problems[:1])
    if not len(rows):
        raise file_error(source, "has no row")
    axes, places = zip(
        *(np.unique(columns[name], return_inverse=True) for name in COLUMNS[:-1]), strict=True
    )
    shape = tuple(len(axis) for axis in axes)
    is_full = math.prod(shape) == len(rows)
    values = np.full(shape if is_full else 0, np.nan)  # what is no grid would fill the memory
    if is_full:
        values[places] = columns["wind_m_per_s"]
    if not is_full or np.isnan(values).any():
        many = "has twice some of" if math.prod(shape) < len(rows) else "lacks some of"
        combinations = " x ".join(str(len(axis)) for axis in axes)
        raise file_error(
            source,
            f"{many} the {combinations} combinations of latitude, altitude, month and percentile "
            f"(rows: {len(rows)})",
        )
    falling = np.argwhere(np.diff(values, axis=-1) < 0.0)
    if len(falling):
        higher = (*falling[0][:3], falling[0][3] + 1)
        place = [axis[index] for axis, index in zip(axes, higher, strict=True)]
        raise file_error(
            source,
            "the wind of a higher percentile must not be lower (latitude {}, altitude {}, month "
            "{}, percentile {})".format(*map(spell, place)),
        )
    months = tuple(int(month) for month in axes[2])
    return WindTable(source, axes[0], axes[1], months, axes[3], values)
