"""Levels and colours of excess time in every season map: figures, reports and the explorer.

Brown falls short, purple has hours to spare, and the darkest purple has no night at all. The
colours are equal steps on straight lines in CIE 1976 L*a*b* (D65), from brown (40, 28, 48) and
purple (40, 28, -48) to white (96, 0, 0): where distance is the difference that the eye sees, steps
on either side of zero look equal. Those beside zero are tinted, so that a glance tells the sides
apart.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from solar.types import FloatArray

LEVELS_H = (-12.0, -9.0, -6.0, -3.0, 0.0, 3.0, 6.0, 9.0, 12.0)
UNLIMITED_H = 24.0  # where there is a night, excess times are shorter
_SHORT = "954a06 b06d3d c7926f dbb8a2 ecdfd8"
_SPARE = "e3e0ec c2bbdd a196cd 7f73bd 5b52ad"
_NO_NIGHT = "2a266c"


def colours() -> FloatArray:
    """Colour of each band, red, green and blue from 0 to 1, shape ``(band, 3)``.

    The bands are those below, between and above :data:`LEVELS_H`, and the last is that of excess
    times without a limit.
    """
    digits = f"{_SHORT} {_SPARE} {_NO_NIGHT}".split()
    return np.array([list(bytes.fromhex(colour)) for colour in digits]) / 255.0


def page_scale() -> dict[str, Any]:
    """Return the scale for a page: ``levels_h``, ``unlimited_h``, ``colours`` (0 to 255)."""
    bands = np.round(255.0 * colours()).astype(int).tolist()
    return {"levels_h": LEVELS_H, "unlimited_h": UNLIMITED_H, "colours": bands}
