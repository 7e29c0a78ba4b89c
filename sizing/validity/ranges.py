"""Ranges in which the models hold, and checks of quantities against them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cache
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from sizing.data_rows import data_rows
from sizing.limits import ROW_TOLERANCE
from sizing.parameters import Parameter, unit_text
from solar.types import BoolArray, FloatArray

_MOST_DIGITS = 8  # of a value that rounds to an end of its range
EXPERIENCE = "experience"


@dataclass(frozen=True)
class Extrapolation:
    """Quantity of a result outside the range in which a model holds.

    Attributes
    ----------
    quantity, label, unit : str
        Key, name and unit (``1`` for none) of the quantity.
    value : float
        Value of the result; of several, the farthest outside.
    minimum, maximum : float or None
        Range of the model; None for an open end.
    model, holder, source : str
        Model of the range, as in files and in words, and the source of the range.
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

    quantity: str
    label: str
    unit: str
    value: float
    minimum: float | None
    maximum: float | None
    model: str
    holder: str
    source: str
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
        held = range_text(self.minimum, self.maximum, self.unit)
        among = f" (worst; {self.count} of {self.of} {self.what})" if self.of else ""
        effect = f"; {self.worth}" if self.worth else ""
        outside = f"outside the range of {self.holder}, {held}"
        return f"{self.label} {value}{unit}{self.at}{among}: {outside}{effect}"

    @property
    def distance(self) -> float:
        """Distance of the value from the range, relative to its end [-]."""
        low, high = self.minimum, self.maximum
        below = 0.0 if low is None else (low - self.value) / (abs(low) or 1.0)
        above = 0.0 if high is None else (self.value - high) / (abs(high) or 1.0)
        return max(below, above)

    def to_dict(self) -> dict[str, Any]:
        """Return all fields and the text, JSON-ready."""
        return asdict(self) | {"scenarios": list(self.scenarios), "text": self.text}

    @classmethod
    def from_dict(cls, record: Mapping[str, Any]) -> Extrapolation:
        """Return the record of :meth:`to_dict`, of earlier versions too."""
        values = {name: record[name] for name in cls.__dataclass_fields__ if name in record}
        return cls(**values | {"scenarios": tuple(record["scenarios"])})


class Range(NamedTuple):
    """Row of the catalogue of ranges; an end is None if it is open or not a constant."""

    quantity: str
    model: str
    label: str
    unit: str
    holder: str
    minimum: float | None
    maximum: float | None
    source: str

    @property
    def held(self) -> str:
        """Range in words; empty where aircraft or mission give it."""
        return range_text(self.minimum, self.maximum, self.unit)


def range_text(minimum: float | None, maximum: float | None, unit: str) -> str:
    """Return a range in words, such as ``3 to 8 m``; empty if both ends are open."""
    low, high = (None if end is None else _readable(end, unit=unit) for end in (minimum, maximum))
    if low is None and high is None:
        return ""
    text = f"up to {high}" if low is None else f"from {low}" if high is None else f"{low} to {high}"
    return f"{text} {unit_text(unit)}".rstrip()


@cache
def ranges() -> Mapping[tuple[str, str], Range]:
    """Return the ranges of all models, by quantity and model."""
    rows = data_rows("validity")
    return MappingProxyType({(row["key"], row["model"]): _from_row(row) for row in rows})


def model_error_note(altitude_m: float) -> str:
    """Return a note on where model errors were measured, for far higher flights; else empty."""
    known = ranges()["altitude_m", "model_error"].maximum
    return " as measured at 0.5 km" if known is not None and altitude_m > known else ""


def _from_row(row: Mapping[str, str]) -> Range:
    low, high = (None if row[end] in ("", "own") else float(row[end]) for end in ("low", "high"))
    return Range(
        quantity=row["key"],
        model=row["model"],
        label=row["label"],
        unit=row["unit"],
        holder=row["holder"],
        minimum=low,
        maximum=high,
        source=row["source"],
    )


def experience(of: Parameter) -> Range:
    """Return the range of a technology parameter in which there is experience."""
    source = "sensible range of the catalogue of parameters: built or in sight; assumption"
    ends = (of.minimum, of.maximum)
    return Range(of.key, EXPERIENCE, of.label, of.unit, EXPERIENCE, *ends, source)


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
        shape = np.broadcast_shapes(self.value.shape, self.minimum.shape, self.maximum.shape)
        value, low, high = (
            float(np.broadcast_to(v, shape)[place])
            for v in (self.value, self.minimum, self.maximum)
        )
        at = ""
        if self.airspeed_m_per_s is not None:
            speed = float(np.broadcast_to(self.airspeed_m_per_s, shape)[place])
            at = f" at {speed:.1f} m/s"
        masses = {
            name: float(np.broadcast_to(mass, shape)[place])
            for name, mass in (self.masses_kg or {}).items()
        }
        comparison = ", ".join(f"{_readable(mass)} kg by {name}" for name, mass in masses.items())
        return replace(extrapolation(self.range, value, low, high), at=at, worth=comparison)


def extrapolation(row: Range, value: float, low: float, high: float) -> Extrapolation:
    """Return the extrapolation of a value beyond a range, whose open ends are infinite."""
    return Extrapolation(
        quantity=row.quantity,
        label=row.label,
        unit=row.unit,
        value=value,
        minimum=None if math.isinf(low) else low,
        maximum=None if math.isinf(high) else high,
        model=row.model,
        holder=row.holder,
        source=row.source,
    )


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
