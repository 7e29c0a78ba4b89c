"""Levels and colours of excess time in every season map: figures, reports and the explorer.

Brown falls short, purple has hours to spare, and the darkest purple has no night at all. Colours
lie on straight lines in CIE 1976 L*a*b* (D65), where distance is the difference that the eye
sees, with ends of the same lightness: equal steps on either side of zero look equal.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from solar.types import FloatArray

LEVELS_H = (-12.0, -9.0, -6.0, -3.0, 0.0, 3.0, 6.0, 9.0, 12.0)
UNLIMITED_H = 24.0  # where there is a night, excess times are shorter
# Ends and middle of the colours, and that of a day without a night: CIE L*, a*, b*.
_BROWN_LAB, _WHITE_LAB, _PURPLE_LAB = (40.0, 28.0, 48.0), (96.0, 0.0, 0.0), (40.0, 28.0, -48.0)
_NO_NIGHT_LAB = (20.0, 24.0, -40.0)
_D65 = np.array([0.95047, 1.0, 1.08883])
_SRGB_OF_XYZ = np.array(
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
)


def colours() -> FloatArray:
    """Colour of each band, red, green and blue from 0 to 1, shape ``(band, 3)``.

    The bands are those below, between and above :data:`LEVELS_H`, and the last is that of excess
    times without a limit.
    """
    low, zero, high = np.array([_BROWN_LAB, _WHITE_LAB, _PURPLE_LAB])
    each = (len(LEVELS_H) + 1) // 2
    # The bands beside zero are tinted, so that a glance tells the sides apart.
    share = np.arange(each)[:, np.newaxis] / (each - 0.5)
    lab = [low + share * (zero - low), high + share[::-1] * (zero - high), [_NO_NIGHT_LAB]]
    return _srgb_of_lab(np.concatenate(lab))


def page_scale() -> dict[str, Any]:
    """Return the scale for a page: ``levels_h``, ``unlimited_h``, ``colours`` (0 to 255)."""
    return {
        "levels_h": LEVELS_H,
        "unlimited_h": UNLIMITED_H,
        "colours": np.round(255.0 * colours()).astype(int).tolist(),
    }


def _srgb_of_lab(lab: FloatArray) -> FloatArray:
    """Return the colours of a screen (IEC 61966-2-1) of CIE L*a*b* with white D65."""
    f_y = (lab[:, 0] + 16.0) / 116.0
    f = np.stack([f_y + lab[:, 1] / 500.0, f_y, f_y - lab[:, 2] / 200.0], axis=1)
    edge = 6.0 / 29.0
    xyz = np.where(f > edge, f**3, 3.0 * edge**2 * (f - 4.0 / 29.0)) * _D65
    linear = np.clip(xyz @ _SRGB_OF_XYZ.T, 0.0, 1.0)
    srgb: FloatArray = np.where(
        linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055
    )
    return srgb
