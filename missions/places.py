"""Latitudes as people write them."""

from __future__ import annotations

import re

_NUMBER = r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)"
_FORM = re.compile(rf"({_NUMBER}) *°? *([ns])|([+-]?{_NUMBER}) *°", re.IGNORECASE)


def latitude_deg(text: str) -> float:
    """Latitude [deg], north positive, of ``-33.9``, ``-33.9°``, ``33.9S`` or ``33.9° S``.

    Another text is a ValueError.
    """
    match = _FORM.fullmatch(text.strip())
    try:
        if "_" in text:  # Python's own notation, nobody's latitude
            raise ValueError
        number = float((match[1] or match[3]) if match else text)
    except ValueError:
        raise ValueError(
            f"{text!r} is not a number of degrees; north is positive, or written 47.6N, 33.9S"
        ) from None
    number = -number if match and match[2] in ("s", "S") else number
    if not -90.0 <= number <= 90.0:
        raise ValueError(f"must be from -90 to 90 (got {text})")
    return number
