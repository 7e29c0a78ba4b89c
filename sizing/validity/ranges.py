"""Ranges in which the models hold, and checks of quantities against them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from missions.files.data_rows import data_rows
from sizing.limits import ROW_TOLERANCE
from sizing.parameters import Parameter, unit_text
from solar.types import BoolArray, FloatArray

_MOST_DIGITS = 8  # of a value that rounds to an end of its range
EXPERIENCE = "experience"


@dataclass(frozen=True)
class Range:
    """Range of a quantity in which a model holds; a row of the catalogue of ranges.

    ``unit``: ``1`` for none. ``minimum``, ``maximum``: None for an open end, in the catalogue also
    for one that differs. ``model``, ``holder``: model of the range, as in files and in words.
    """

    quantity: str
    label: str
    unit: str
    minimum: float | None
    maximum: float | None
    model: str
    holder: str
    source: str

    @property
    def held(self) -> str:
        """Range in words, such as ``3 to 8 m``; empty if both ends are open."""
        low, high = (
            None if end is None else _readable(end, unit=self.unit)
            for end in (self.minimum, self.maximum)
        )
        if low is None and high is None:
            return ""
        upper = f"up to {high}" if low is None else f"{low} to {high}"
        return f"{f'from {low}' if high is None else upper} {unit_text(self.unit)}".rstrip()


@dataclass(frozen=True)
class Extrapolation(Range):
    """Quantity of a result outside the range in which a model holds.

    Attributes
    ----------
    value : float
        Value of the result; of several, the farthest outside.
    at : str
        Condition of the value, such as an airspeed.
    scenarios : tuple of str
        Scenarios concerned; empty for all.
    count, of, what : int, int, str
        Number of cells of a map, points of a trade study or altitudes concerned, their total, and
        their name; 0 for a single result.
    worth : str
        Effect of the assumption made in place of the model, in words.
    excess_time_h : float or None
        Excess time without that assumption [h]; None where it is unlimited, or not known.
    """

    value: float = math.nan
    at: str = ""
    scenarios: tuple[str, ...] = ()
    count: int = 0
    of: int = 0
    what: str = ""
    worth: str = ""
    excess_time_h: float | None = None

    @property
    def text(self) -> str:
        """Line of text with quantity, value, and the range in which the model holds."""
        unit = "" if self.unit == "1" else f" {unit_text(self.unit)}"
        both = (self.minimum, self.maximum)
        ends = [_readable(end, unit=self.unit) for end in both if end is not None]
        digits = 3
        while (value := _readable(self.value, digits, self.unit)) in ends and digits < _MOST_DIGITS:
            digits += 1
        among = f" (worst; {self.count} of {self.of} {self.what})" if self.of else ""
        effect = f"; {self.worth}" if self.worth else ""
        outside = f"outside the range of {self.holder}, {self.held}"
        return f"{self.label} {value}{unit}{self.at}{among}: {outside}{effect}"

    @property
    def distance(self) -> float:
        """Distance of the value from the range, relative to its end [-]."""
        low, high, value = self.minimum, self.maximum, self.value
        below = 0.0 if low is None else (low - value) / (abs(low) or 1.0)
        return max(below, 0.0 if high is None else (value - high) / (abs(high) or 1.0))

    @classmethod
    def from_dict(cls, record: Mapping[str, Any]) -> Extrapolation:
        """Return what JSON has as a record, that of earlier versions too."""
        values = {name: record[name] for name in cls.__dataclass_fields__ if name in record}
        return cls(**values | {"scenarios": tuple(record["scenarios"])})


@cache
def ranges() -> Mapping[tuple[str, str], Range]:
    """Return the ranges of all models, by quantity and model."""
    known = {}
    for row in data_rows("validity", "sizing"):
        low, high = (
            None if row[end] in ("", "own") else float(row[end]) for end in ("low", "high")
        )
        words = (row[name] for name in ("model", "holder", "source"))
        held = Range(row["key"], row["label"], row["unit"], low, high, *words)
        known[held.quantity, held.model] = held
    return MappingProxyType(known)


def model_error_note(altitude_m: float) -> str:
    """Return a note on where model errors were measured, for far higher flights; else empty."""
    known = ranges()["altitude_m", "model_error"].maximum
    return " as measured at 0.5 km" if known is not None and altitude_m > known else ""


def experience(of: Parameter) -> Range:
    """Return the range of a technology parameter in which there is experience."""
    source = "sensible range of the catalogue of parameters: built or in sight; assumption"
    ends = (of.minimum, of.maximum)
    return Range(of.key, of.label, of.unit, *ends, EXPERIENCE, EXPERIENCE, source)


class Check(NamedTuple):
    """Quantity of one or many designs, and the range of a model.

    Values and ends are numbers or arrays of shape ``(*designs)`` or ``(*designs, scenario)``. The
    text has ``airspeed_m_per_s`` and ``masses_kg``, masses by the names of their models, if any.
    """

    range: Range
    value: FloatArray
    minimum: FloatArray
    maximum: FloatArray
    airspeed_m_per_s: FloatArray | None = None
    masses_kg: Mapping[str, FloatArray] | None = None

    @classmethod
    def of(
        cls,
        quantity: str,
        model: str,
        value: Any,
        ends: tuple[Any, Any] | None = None,
        airspeed_m_per_s: Any = None,
        masses_kg: Mapping[str, FloatArray] | None = None,
    ) -> Check:
        """Return the check against the catalogue's range, or the ends of aircraft or mission."""
        row = ranges()[quantity, model]
        low, high = (row.minimum, row.maximum) if ends is None else ends
        return cls(
            row,
            np.asarray(value, float),
            np.asarray(-np.inf if low is None else low, float),
            np.asarray(np.inf if high is None else high, float),
            None if airspeed_m_per_s is None else np.asarray(airspeed_m_per_s, float),
            masses_kg,
        )

    @property
    def outside(self) -> BoolArray:
        """True where the value is outside the range; false for NaN."""
        low, high, value = self.minimum, self.maximum, self.value
        with np.errstate(invalid="ignore"):
            below = value < low - ROW_TOLERANCE * np.abs(low)
            above = value > high + ROW_TOLERANCE * np.abs(high)
        return np.asarray((below | above) & np.isfinite(value))

    @property
    def distance(self) -> FloatArray:
        """Distance from the range, relative to its end [-]; 0 inside."""
        with np.errstate(invalid="ignore"):
            below = (self.minimum - self.value) / (np.abs(self.minimum) + (self.minimum == 0.0))
            above = (self.value - self.maximum) / (np.abs(self.maximum) + (self.maximum == 0.0))
        return np.where(self.outside, np.fmax(below, above), 0.0)

    def over(self, shape: tuple[int, ...]) -> Check:
        """Return the check broadcast to a batch of designs, whose axes come first."""
        return self._replace(value=np.broadcast_to(self.value, shape + self.value.shape))

    def extrapolation_at(self, place: tuple[int, ...]) -> Extrapolation:
        """Return the extrapolation at an index of the arrays."""
        every = np.broadcast_arrays(self.value, self.minimum, self.maximum)
        shape, (value, low, high) = every[0].shape, (float(numbers[place]) for numbers in every)
        at = ""
        if self.airspeed_m_per_s is not None:
            speed = float(np.broadcast_to(self.airspeed_m_per_s, shape)[place])
            at = f" at {round(speed, 1)} m/s"
        comparison = ", ".join(
            f"{_readable(float(np.broadcast_to(mass, shape)[place]))} kg by {name}"
            for name, mass in (self.masses_kg or {}).items()
        )
        return extrapolation(self.range, value, low, high, at=at, worth=comparison)


def extrapolation(row: Range, value: float, low: float, high: float, **words: Any) -> Extrapolation:
    """Return the extrapolation of a value beyond a range, whose open ends are infinite."""
    minimum, maximum = (None if math.isinf(end) else end for end in (low, high))
    ends = {"minimum": minimum, "maximum": maximum}
    return Extrapolation(**vars(row) | ends, value=value, **words)


def _readable(value: float, digits: int = 3, unit: str = "") -> str:
    """Return a number with some digits, at least all of its integer part.

    Thousands have separators, except in metres, as in all printed altitudes.
    """
    size = abs(value)
    whole = len(str(int(size))) if size >= 1.0 else 1
    if size >= 10000.0:
        rounded = round(value, min(digits - whole, 0))
        return f"{rounded:.0f}" if unit == "m" else f"{rounded:,.0f}"
    return f"{value:.{max(digits, whole)}g}"
