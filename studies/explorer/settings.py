"""What a page asks for, checked at the edge: numbers by key, solar power model, correction."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from sizing.day.light import SolarModel
from studies.explorer.fields import Choice, Field

_MAXIMUM_SHOWN = 60


class Refusal(NamedTuple):
    """A field that is refused, in words.

    ``value``: what was given, shortened. ``message``: what is wrong. ``allowed``: what may stand
    there.
    """

    field: str
    value: Any
    message: str
    allowed: str = ""


class AnsweredError(Exception):
    """An error that is answered in words: HTTP status, sort of mistake, and fields in question."""

    refusals: tuple[Refusal, ...] = ()

    def __init__(self, words: str, status: int = 400, kind: str = "malformed") -> None:
        super().__init__(words)
        self.status, self.kind = status, kind


class RefusedError(AnsweredError, ValueError):
    """Settings that cannot be computed; ``refusals`` says why, ``kind`` what sort of mistake."""

    def __init__(self, refusals: Iterable[Refusal], kind: str = "refused") -> None:
        self.refusals = tuple(refusals)
        super().__init__("; ".join(f"{r.field}: {r.message}" for r in self.refusals), 422, kind)


@dataclass(frozen=True)
class Settings:
    """State of the page.

    ``values``: every number by its key. ``solar``: model and correction.
    """

    values: Mapping[str, float]
    solar: SolarModel


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
        message, allowed = "is not a field of the explorer", ", ".join(fields)
        if field is not None:
            message, allowed = field.mistake(value), field.allowed
        if message:
            refusals.append(Refusal(str(shown(key)), shown(value), message, allowed))
        else:
            accepted[key] = value
    if refusals:
        raise RefusedError(refusals)
    values = {
        key: float(accepted[key]) for key, field in fields.items() if isinstance(field, Field)
    }
    return Settings(values, SolarModel(accepted["model"], accepted["correction"]))


def shown(value: object) -> Any:
    """Return a value as a message may repeat it: a short text, or a number of JSON."""
    # An integer may be too large for a float.
    numbers = isinstance(value, int | float) and abs(value) < 2**53
    if value is None or numbers:
        return value
    if isinstance(value, int):
        return "a number of more than 15 digits"
    text = str(value) if isinstance(value, str | float) else f"a {type(value).__name__}"
    return text if len(text) <= _MAXIMUM_SHOWN else text[: _MAXIMUM_SHOWN - 3] + "..."
