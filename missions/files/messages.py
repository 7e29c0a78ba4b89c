"""The complaints of pydantic in plain words, and suggestions for keys that do not exist."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping, Sequence
from typing import Any

from pydantic_core import ErrorDetails

from missions.files.errors import shown

__all__ = ["one_line", "unknown_key", "worded"]

_A_NUMBER = "must be a number"
_A_WHOLE_NUMBER = "must be a whole number"
_A_LIST = "must be a list"
_A_MAPPING = "must be a mapping of keys and values"
_FINITE = "must be a finite number"

# What the field types in use complain of; other complaints keep the words of pydantic.
_WORDS = {
    "greater_than": "must be greater than {gt}",
    "greater_than_equal": "must be at least {ge}",
    "less_than": "must be less than {lt}",
    "less_than_equal": "must be at most {le}",
    "finite_number": _FINITE,
    "float_type": _A_NUMBER,
    "float_parsing": _A_NUMBER,
    "int_type": _A_WHOLE_NUMBER,
    "int_parsing": _A_WHOLE_NUMBER,
    "int_from_float": _A_WHOLE_NUMBER,
    "bool_type": "must be true or false",
    "string_type": "must be text",
    "string_too_short": "must have at least {min_length} characters",
    "string_too_long": "must have at most {max_length} characters",
    "string_pattern_mismatch": "must match the pattern {pattern}",
    "literal_error": "must be {expected}",
    "list_type": _A_LIST,
    "tuple_type": _A_LIST,
    "too_short": "must have at least {min_length} items",
    "too_long": "must have at most {max_length} items",
    "dict_type": _A_MAPPING,
    "model_type": _A_MAPPING,
    "model_attributes_type": _A_MAPPING,
}


def worded(detail: ErrorDetails) -> tuple[str, str]:
    """Return what is wrong with a value, and after it the value itself with a hint."""
    kind, value, context = detail["type"], detail["input"], detail.get("ctx", {})
    if kind not in _WORDS:
        return re.sub(r"^[A-Z]\w* should ", "must ", one_line(detail["msg"])), ""
    return _message(kind, value, context), f" (got {shown(value)}){_hint(kind, value)}"


def one_line(text: str) -> str:
    """Put a message on one line."""
    return " ".join(text.splitlines())


def _message(kind: str, value: object, context: Mapping[str, Any]) -> str:
    if kind == "float_type" and isinstance(value, int) and not isinstance(value, bool):
        return _FINITE  # an integer beyond the largest float
    if context.get("min_length") == 1:
        return "must not be empty"
    text = _WORDS[kind].format(**{name: _limit(limit) for name, limit in context.items()})
    return re.sub(r" 1 (item|character)s$", r" 1 \1", text)


def _limit(value: object) -> str:
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    return str(value)


def _hint(kind: str, value: object) -> str:
    numeric = kind.startswith(("float_", "int_"))
    if numeric and isinstance(value, str) and re.fullmatch(r"[-+]?[0-9]+,[0-9]+", value.strip()):
        return "; write a point before the decimals, not a comma"
    if numeric and isinstance(value, str) and re.match(r"\s*[-+]?\.?[0-9]", value):
        return "; write the plain number; the unit is in the key"
    if kind == "string_type" and isinstance(value, bool | int | float):
        return "; put it in quotes"
    return ""


_UNIT = re.compile(
    r"[mk]?g|t|lbs?|oz|grams|[mckd]?m[23]?|ft2?|in|inch|n?mi|met(?:er|re)s|l"
    r"|m?s|sec|min|h|hr|d|(?:second|minute|hour|day)s?|[km]?wh?|[km]?j|[mk]?v|m?ah?|n|nm|kn"
    r"|[hkmg]?pa|m?bar|psi|deg|degrees?|rad|c|k|f|deg[ckf]|kelvin|celsius|k?hz|rpm"
    r"|pct|percent|fraction|ratio|per|mps|km?h|kmh|kph|mph|kts?|knots"
)


def unknown_key(key: str, allowed: Sequence[str]) -> str:
    """Say that a key does not exist, and which one may be meant."""
    if meant := _closest(key, allowed):
        return f"unknown key; did you mean '{meant}'?"
    return f"unknown key; allowed keys: {', '.join(allowed)}" if allowed else "unknown key"


def _closest(key: str, allowed: Sequence[str]) -> str | None:
    """Return the allowed key most like `key`; the same quantity in another unit comes first."""
    wanted = key.lower()
    same = [name for name in allowed if _quantity(name) == _quantity(wanted)]
    for names, cutoff in ((same, 0.0), (allowed, 0.6)):
        by_lower = {name.lower(): name for name in names}
        if found := difflib.get_close_matches(wanted, by_lower, n=1, cutoff=cutoff):
            return by_lower[found[0]]
    return None


def _quantity(key: str) -> str:
    """Return a key without its unit: `energy_wh_per_kg` gives `energy`."""
    words = key.lower().split("_")
    while len(words) > 1 and _UNIT.fullmatch(words[-1]):
        words.pop()
    return "_".join(words)
