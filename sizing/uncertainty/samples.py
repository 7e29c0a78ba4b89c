"""Samples of uncertain inputs: points of the unit cube, and what a share of draws says."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from solar.types import BoolArray, FloatArray

_CONFIDENCE_Z = 1.959964  # of 95 %


@dataclass(frozen=True)
class Proportion:
    """Share of draws with a property, and its interval of 95 % confidence."""

    value: float
    low: float
    high: float

    @classmethod
    def of(cls, marks: BoolArray) -> Proportion:
        """Share of true values.

        Interval: Wilson, E. B. (1927), Probable inference, the law of succession, and statistical
        inference, J. Am. Stat. Assoc. 22, 209-212. It holds for independent draws; of the more even
        points of a Sobol sequence it is on the safe side.
        """
        count, z = len(marks), _CONFIDENCE_Z
        share = float(np.mean(marks))
        centre = (share + z * z / (2.0 * count)) / (1.0 + z * z / count)
        half = z * math.sqrt(share * (1.0 - share) / count + z * z / (4.0 * count * count))
        half /= 1.0 + z * z / count
        return cls(share, max(centre - half, 0.0), min(centre + half, 1.0))

    def text(self) -> str:
        """Share and interval in per cent."""
        value, low, high = (f"{100.0 * v:.1f}" for v in (self.value, self.low, self.high))
        return f"{value} %" if low == high else f"{value} % (95 % between {low} and {high} %)"


def sobol_points(dimension: int, samples: int, seed: int) -> FloatArray:
    """Points of a Sobol sequence with Owen's scrambling.

    Returns of the unit cube.
    """
    from scipy.stats import qmc

    power = math.ceil(math.log2(samples))
    return np.ascontiguousarray(qmc.Sobol(dimension, rng=seed).random_base2(power).T)
