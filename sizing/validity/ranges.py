"""Ranges in which the models hold, and a quantity beside its range."""

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

_MOST_DIGITS = 8
EXPERIENCE = "experience"


@dataclass(frozen=True)
class Extrapolation:
    """A quantity of a result that lies outside the range in which a model holds.

    Attributes
    ----------
    quantity, label, unit : str
        Key, words and unit (``1`` for none) of the quantity.
    value : float
        That of the result; the farthest outside where there are several.
    minimum, maximum : float or None
        Range of the model; None for an end that it does not have.
    model, holder, source : str
        Whose range it is, as files name it and in words, and where the range comes from.
    at : str
        Circumstance that belongs to the value, such as an airspeed.
    scenarios : tuple of str
        Scenarios concerned; none for all of them.
    count, of, what : int, int, str
        Of how many cells of a map, points of a trade study or altitudes it is told; 0 of a single
        result.
    worth : str
        What the assumption that stands in for the model changes, in words.
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
        """In a line: quantity, value, and the range in which the model holds."""
        unit = "" if self.unit == "1" else f" {unit_text(self.unit)}"
        both = (self.minimum, self.maximum)
        ends = [_readable(end, unit=self.unit) for end in both if end is not None]
        digits = 3
        while (value := _readable(self.value, digits, self.unit)) in ends and digits < _MOST_DIGITS:
            digits += 1
        held = range_text(self.minimum, self.maximum, self.unit)
        among = f" (worst; {self.count} of {self.of} {self.what})" if self.of else ""
        worth = f"; {self.worth}" if self.worth else ""
        outside = f"outside the range of {self.holder}, {held}"
        return f"{self.label} {value}{unit}{self.at}{among}: {outside}{worth}"

    @property
    def distance(self) -> float:
        """How far outside, relative to the end of the range."""
        low, high = self.minimum, self.maximum
        below = 0.0 if low is None else (low - self.value) / (abs(low) or 1.0)
        above = 0.0 if high is None else (self.value - high) / (abs(high) or 1.0)
        return max(below, above)

    def to_dict(self) -> dict[str, Any]:
        """All of it, JSON-ready."""
        return asdict(self) | {"scenarios": list(self.scenarios), "text": self.text}

    @classmethod
    def from_dict(cls, record: Mapping[str, Any]) -> Extrapolation:
        """What :meth:`to_dict` wrote, by an earlier version too."""
        values = {name: record[name] for name in cls.__dataclass_fields__ if name in record}
        return cls(**values | {"scenarios": tuple(record["scenarios"])})


class Range(NamedTuple):
    """Row of the catalogue; an end is none where the range has none, or is not a constant."""

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
    """Range in words, such as ``3 to 8 m``.

    Empty without any end.
    """
    low, high = (None if end is None else _readable(end, unit=unit) for end in (minimum, maximum))
    if low is None and high is None:
        return ""
    text = f"up to {high}" if low is None else f"from {low}" if high is None else f"{low} to {high}"
    return f"{text} {unit_text(unit)}".rstrip()


@cache
def ranges() -> Mapping[tuple[str, str], Range]:
    """Ranges of all models, by quantity and model."""
    rows = data_rows("validity")
    return MappingProxyType({(row["key"], row["model"]): _from_row(row) for row in rows})


def where_error_is_known(altitude_m: float) -> str:
    """Where errors of the solar power models were measured, of flights far above; else empty."""
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
    """Range of a technology parameter in which there is experience.

    No model ends there, but who goes beyond should mean it.
    """
    source = "sensible range of the catalogue of parameters: built or in sight; assumption"
    ends = (of.minimum, of.maximum)
    return Range(of.key, EXPERIENCE, of.label, of.unit, EXPERIENCE, *ends, source)


class Check(NamedTuple):
    """A quantity of one or many designs beside the range of a model.

    Values and ends are numbers or arrays of the designs; those of scenarios have these on their
    last axis. ``airspeed_m_per_s`` belongs to them, if any; ``beside`` has masses to be told with
    them by the names of their models [kg].
    """

    range: Range
    value: FloatArray
    minimum: FloatArray
    maximum: FloatArray
    airspeed_m_per_s: FloatArray | None = None
    beside: Mapping[str, FloatArray] | None = None

    @classmethod
    def of(
        cls,
        quantity: str,
        model: str,
        value: Any,
        ends: tuple[Any, Any] | None = None,
        airspeed_m_per_s: Any = None,
        beside: Mapping[str, FloatArray] | None = None,
    ) -> Check:
        """Check against the range of the catalogue, or one that aircraft or mission give."""
        row = ranges()[quantity, model]
        low, high = (row.minimum, row.maximum) if ends is None else ends
        return cls(
            row,
            np.asarray(value, float),
            np.asarray(-np.inf if low is None else low, float),
            np.asarray(np.inf if high is None else high, float),
            None if airspeed_m_per_s is None else np.asarray(airspeed_m_per_s, float),
            beside,
        )

    @property
    def outside(self) -> BoolArray:
        """Where the value is outside; never where there is none."""
        low, high, value = self.minimum, self.maximum, self.value
        with np.errstate(invalid="ignore"):
            below = value < low - ROW_TOLERANCE * np.abs(low)
            above = value > high + ROW_TOLERANCE * np.abs(high)
        return np.asarray((below | above) & np.isfinite(value))

    @property
    def distance(self) -> FloatArray:
        """How far outside, relative to the end of the range; 0 inside."""
        with np.errstate(invalid="ignore"):
            below = (self.minimum - self.value) / (np.abs(self.minimum) + (self.minimum == 0.0))
            above = (self.value - self.maximum) / (np.abs(self.maximum) + (self.maximum == 0.0))
        return np.where(self.outside, np.fmax(below, above), 0.0)

    def over(self, shape: tuple[int, ...]) -> Check:
        """Same check for every design of a batch, whose axes come first."""
        return self._replace(value=np.broadcast_to(self.value, shape + self.value.shape))

    def found(self, place: tuple[int, ...]) -> Extrapolation:
        """What is to be told of one place of the arrays."""
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
            for name, mass in (self.beside or {}).items()
        }
        worth = ", ".join(f"{_readable(mass)} kg by {name}" for name, mass in masses.items())
        return replace(extrapolation(self.range, value, low, high), at=at, worth=worth)


def extrapolation(row: Range, value: float, low: float, high: float) -> Extrapolation:
    """What is to be told of a value.

    ``value``, ``low``, ``high``: value, and the ends of the range; infinite where it has none.
    """
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
    """Number as people read it, of so many digits and no fewer than its integer part.

    Thousands are set apart, but not in metres, as wherever altitudes are printed.
    """
    size = abs(value)
    whole = len(str(int(size))) if size >= 1.0 else 1
    if size >= 10000.0:
        rounded = round(value, min(digits - whole, 0))
        return f"{rounded:.0f}" if unit == "m" else f"{rounded:,.0f}"
    return f"{value:.{max(digits, whole)}g}"
