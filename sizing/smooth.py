"""Maximum and absolute value without a kink, for floats, arrays and symbols alike.

A hyperbola replaces the kink, so that derivatives exist everywhere, as Newton's method needs.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import reduce
from typing import Any

# A number, an array or a symbolic expression.
Value = Any

# Blending width relative to the two values, and relative overshoot where they are equal.
BLEND = 0.02


def smooth_maximum(first: Value, second: Value) -> Value:
    """Return the larger of two values of positive sum, smoothly.

    ``(s + sqrt(d^2 + (BLEND s)^2)) / 2`` with sum s and difference d. It exceeds the larger value
    by at most ``BLEND`` times it, where both are equal, and rises with either value.
    """
    total = first + second
    gap = first - second
    return (total + (gap * gap + (BLEND * total) ** 2) ** 0.5) / 2.0


def smooth_minimum(first: Value, second: Value) -> Value:
    """Return the smaller of two positive values, smoothly: their product over the smooth maximum.

    It is below the smaller value by at most ``BLEND`` times it, where both are equal.
    """
    return first * second / smooth_maximum(first, second)


def smooth_absolute(value: Value, scale: Value, blend: float = BLEND) -> Value:
    """Return the absolute value without its kink, ``sqrt(value^2 + (blend scale)^2)``.

    It exceeds the absolute value by at most ``blend scale``, at 0.
    """
    return (value * value + (blend * scale) ** 2) ** 0.5


def chebyshev_series(coefficients: Iterable[Value], x: Value) -> Value:
    """Return a Chebyshev series by Clenshaw's recurrence; coefficients may be expressions."""
    first, *others = coefficients
    last: Value = 0.0
    before: Value = 0.0
    for coefficient in reversed(others):
        last, before = coefficient + 2.0 * x * last - before, last
    return first + x * last - before


def largest(needs: dict[str, Value]) -> Value:
    """Return the smooth maximum of the needs of several criteria, in their order."""
    return reduce(smooth_maximum, needs.values())
