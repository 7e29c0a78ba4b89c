"""Plain numbers of results: what JSON can hold, relative changes and percentiles."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from solar.types import FloatArray

# What is smaller, in its unit, is nothing: a solver leaves such payloads, and no change is relative
# to it.
NEGLIGIBLE = 1e-6

# As reports on solar power have them: P90 is exceeded in 90 % of all cases.
PERCENTILES = {"p90": 10.0, "p50": 50.0, "p10": 90.0}


def finite(value: Any) -> float | None:
    """Return a number for JSON: null where it is infinite, not defined or missing."""
    if value is None:
        return None
    number = float(value)
    return number if math.isfinite(number) else None


def relative_change(before: float, after: float) -> float | None:
    """Return a change over the value before it [-]; None where that was next to nothing."""
    return None if abs(before) <= NEGLIGIBLE else (after - before) / before


def percentiles(values: FloatArray | list[float], method: Any = "inverted_cdf") -> dict[str, float]:
    """Return P90, which 90 % of cases exceed, P50 and P10.

    By default each is a value that occurred.
    """
    return {
        name: float(np.percentile(values, at, method=method)) for name, at in PERCENTILES.items()
    }
