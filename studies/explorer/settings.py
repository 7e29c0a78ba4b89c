"""What a page asks for, checked at the edge: numbers by key, solar power model, correction."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from sizing.day.light import SolarModel
from studies.explorer.fields import DAY, LATITUDE, Choice, Field

_MAXIMUM_SHOWN = 60


@dataclass(frozen=True)
class Refusal:
    """A field that is refused, in words.

    ``value``: what was given, shortened. ``message``: what is wrong. ``allowed``: what may stand
    there.
    """

    field: str
    value: Any
    message: str
    allowed: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Return the refusal, JSON-ready."""
        return dict(vars(self))


class RefusedError(ValueError):
    """Settings that cannot be computed; ``refusals`` says why, ``kind`` what sort of mistake."""

    def __init__(self, refusals: Iterable[Refusal], kind: str = "refused") -> None:
        self.refusals = tuple(refusals)
        self.kind = kind
        super().__init__("; ".join(f"{r.field}: {r.message}" for r in self.refusals))


@dataclass(frozen=True)
class Settings:
    """State of the page.

    ``values``: every number by its key. ``solar``: model and correction.
    """

    values: Mapping[str, float]
    solar: SolarModel

    @property
    def latitude_deg(self) -> float:
        """Latitude [deg], north positive."""
        return self.values[LATITUDE]

    @property
    def day_of_year(self) -> int:
        """Day of year, 1 to 365."""
        return int(self.values[DAY])


def read_settings(data: object, fields: Mapping[str, Field | Choice]) -> Settings:
    """Check what a page sent; a field that is left out has its first value.

    ``data``: mapping of numbers and names by key, of unknown origin.
    """
    if not isinstance(data, Mapping):
        raise RefusedError([Refusal("settings", shown(data), "must be an object of values by key")])
    refusals = []
    accepted: dict[str, Any] = {key: field.value for key, field in fields.items()}
    for key, value in data.items():
        field = fields.get(key)
        if field is None:
            message, allowed = "is not a field of the explorer", ", ".join(fields)
        elif isinstance(field, Field):
            message, allowed = _number_mistake(field, value), field.allowed
        else:
            message, allowed = _choice_mistake(field, value), field.allowed
        if message:
            name = shown(key)
            refusals.append(Refusal(str(name), shown(value), message, allowed))
        else:
            accepted[key] = value
    if refusals:
        raise RefusedError(refusals)
    values = {
        key: float(accepted[key]) for key, field in fields.items() if isinstance(field, Field)
    }
    return Settings(values, SolarModel(accepted["model"], accepted["correction"]))


def _number_mistake(field: Field, value: object) -> str:
    """Return what is wrong with a number; empty if nothing is."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return "must be a number"
    # An integer may be too large for a float.
    if not field.minimum <= value <= field.maximum or not math.isfinite(value):
        return "is out of range"
    if field.whole and value != int(value):
        return "must be a whole number"
    if field.fixed and value != field.value:
        return f"cannot be changed; {field.fixed}"
    return ""


def _choice_mistake(choice: Choice, value: object) -> str:
    """Return what is wrong with a name; empty if nothing is."""
    for option in choice.options:
        if option.name == value:
            return option.reason
    return "is not one of the names"


def shown(value: object) -> Any:
    """Return a value as a message may repeat it: a short text, or a number of JSON."""
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, float) and math.isfinite(value):
        return value
    if isinstance(value, int) and abs(value) < 2**53:
        return value
    if isinstance(value, int):
        return "a number of more than 15 digits"
    text = str(value) if isinstance(value, str | float) else f"a {type(value).__name__}"
    return text if len(text) <= _MAXIMUM_SHOWN else text[: _MAXIMUM_SHOWN - 3] + "..."
