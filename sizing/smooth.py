"""Maximum and absolute value without a kink, for floats, arrays and symbols alike.

A hyperbola replaces the kink: its derivatives exist everywhere, which Newton's method needs.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import reduce
from typing import Any

# A number, an array or a symbolic expression: whatever the arithmetic is asked to carry.
Value = Any

# Blending width relative to the two values: the overshoot is this much where they are equal and
# its square over four where one of them vanishes.
BLEND = 0.02


def smooth_maximum(first: Value, second: Value, blend: float = BLEND) -> Value:
    """Larger of two values whose sum is positive, differentiable any number of times.

    ``(s + sqrt(d^2 + (blend s)^2)) / 2`` with sum s and difference d. Never below the larger value,
    above it by at most ``blend`` times it, where both are equal; rises with either value; scales
    with both, so that it needs no absolute width.

    Returns in the unit of the values.
    """
    total = first + second
    gap = first - second
    return (total + (gap * gap + (blend * total) ** 2) ** 0.5) / 2.0


def smooth_minimum(first: Value, second: Value, blend: float = BLEND) -> Value:
    """Smaller of two positive values: their product over the smooth maximum, so positive as well.

    Never above the smaller value, below it by at most ``blend`` times it, where both are equal.

    Returns in the unit of the values.
    """
    return first * second / smooth_maximum(first, second, blend)


def smooth_absolute(value: Value, scale: Value, blend: float = BLEND) -> Value:
    """Absolute value with its kink rounded, ``sqrt(value^2 + (blend scale)^2)``.

    ``blend``: width of the rounded kink relative to the scale [-]. Returns above the absolute value
    by at most ``blend scale``, at zero.
    """
    return (value * value + (blend * scale) ** 2) ** 0.5


def chebyshev_series(coefficients: Iterable[Value], x: Value) -> Value:
    """Chebyshev series by Clenshaw's recurrence; coefficients may be expressions themselves."""
    first, *others = coefficients
    one: Value = 0.0
    two: Value = 0.0
    for coefficient in reversed(others):
        one, two = coefficient + 2.0 * x * one - two, one
    return first + x * one - two


def largest(needs: dict[str, Value]) -> Value:
    """Smooth maximum of what several criteria ask for, in their order."""
    return reduce(smooth_maximum, needs.values())
