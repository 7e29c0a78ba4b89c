"""Uncertain inputs of an aircraft or a mission: distributions and correlations.

A file names a key of its own and how the value scatters around what the file says::

    uncertainty:
      inputs:
        battery.specific_energy_wh_per_kg: {relative_sigma: 0.04}
        modules.efficiency_stc: {distribution: uniform, low: 0.23, high: 0.24}
      correlations:
        - {between: [battery.specific_energy_wh_per_kg, battery.mass_kg], coefficient: 0.5}
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, Strict, model_validator

from solar.schema import Allowed, PositiveReal, Real, Record, Text, kind_by_default, wrong_value
from solar.types import FloatArray


def _standard_normal(share: FloatArray) -> FloatArray:
    """Return quantiles of the standard normal distribution."""
    from scipy.special import ndtri  # takes longer than reading a file

    return np.asarray(ndtri(share))


class Normal(Record):
    """Normal distribution around the file's value; ``sigma`` is in the unit of its key."""

    _either: ClassVar[Mapping[str, str]] = {"relative_sigma": "sigma"}

    distribution: Literal["normal"] = "normal"
    sigma: PositiveReal | None = None
    relative_sigma: PositiveReal | None = None

    def values(self, share: FloatArray, nominal: float) -> FloatArray:
        """Return the quantiles at ``share``, in the unit of ``nominal``."""
        sigma = self.sigma if self.sigma is not None else (self.relative_sigma or 0.0) * nominal
        return np.asarray(nominal + sigma * _standard_normal(share))


class LogNormal(Record):
    """Lognormal distribution: the file's value is its median, it never changes sign."""

    distribution: Literal["lognormal"]
    relative_sigma: PositiveReal

    def values(self, share: FloatArray, nominal: float) -> FloatArray:
        """Return the quantiles at ``share``, in the unit of ``nominal``."""
        return np.asarray(nominal * np.exp(np.log1p(self.relative_sigma) * _standard_normal(share)))


class Uniform(Record):
    """Uniform distribution between two ends."""

    _above: ClassVar[Mapping[str, str]] = {"high": "low"}

    distribution: Literal["uniform"]
    low: Real
    high: Real

    def values(self, share: FloatArray, nominal: float) -> FloatArray:
        """Return the quantiles at ``share``."""
        return np.asarray(self.low + (self.high - self.low) * share)


class Triangular(Record):
    """Triangular distribution, its peak at ``mode``, by default the file's value."""

    _above: ClassVar[Mapping[str, str]] = {"high": "low"}

    distribution: Literal["triangular"]
    low: Real
    high: Real
    mode: Real | None = None

    @model_validator(mode="after")
    def _check_corners(self) -> Triangular:
        if self.mode is not None:
            Allowed(self.low, self.high).check("mode", self.mode)
        return self

    def values(self, share: FloatArray, nominal: float) -> FloatArray:
        """Return the quantiles at ``share``."""
        peak = min(max(nominal if self.mode is None else self.mode, self.low), self.high)
        width, rise, fall = self.high - self.low, peak - self.low, self.high - peak
        return np.where(
            share < rise / width,
            self.low + np.sqrt(share * width * rise),
            self.high - np.sqrt((1.0 - share) * width * fall),
        )


class Data(Record):
    """Distribution of measured values, equally likely, linear between them."""

    distribution: Literal["data"]
    data: tuple[Real, ...] = Field(min_length=3)

    def values(self, share: FloatArray, nominal: float) -> FloatArray:
        """Return the quantiles at ``share``."""
        ordered = np.sort(np.asarray(self.data, float))
        places = (np.arange(len(ordered)) + 0.5) / len(ordered)
        return np.asarray(np.interp(share, places, ordered))


Distribution = Annotated[
    Normal | LogNormal | Uniform | Triangular | Data,
    Field(discriminator="distribution"),
    kind_by_default("distribution", "normal"),
]


class Correlation(Record):
    """Correlation of two inputs' normal scores (a Gaussian copula)."""

    between: tuple[Text, Text]
    coefficient: Annotated[float, Strict(), Field(gt=-1.0, lt=1.0, allow_inf_nan=False)]


class Uncertainty(Record):
    """Uncertain inputs by their keys, and correlations between them."""

    inputs: dict[Text, Distribution] = Field(default_factory=dict)
    correlations: tuple[Correlation, ...] = ()

    def __hash__(self) -> int:
        # A mapping has no hash of its own.
        return hash((frozenset(self.inputs.items()), self.correlations))

    @model_validator(mode="after")
    def _check_correlations(self) -> Uncertainty:
        pairs: set[frozenset[str]] = set()
        for number, correlation in enumerate(self.correlations):
            first, second = correlation.between
            key = f"correlations.{number}.between"
            if first == second:
                raise wrong_value(key, f"needs two different inputs (got {first} twice)")
            if frozenset(correlation.between) in pairs:
                text = (
                    f"is the second correlation of {first} and {second}; allowed: one of each pair"
                )
                raise wrong_value(key, text)
            pairs.add(frozenset(correlation.between))
        return self
