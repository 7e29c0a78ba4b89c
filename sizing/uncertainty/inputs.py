"""Uncertain inputs of an aircraft on a mission, and their random draws.

A draw is a point of the unit cube with an axis for each input: quantiles turn it into values, and
a Gaussian copula correlates inputs (Nelsen, R. B. (2006), An Introduction to Copulas, section 2.3).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from missions.files.errors import InputError, Problem
from missions.files.overrides import with_values
from missions.mission import Mission
from missions.uncertainty import Distribution, LogNormal, Normal
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel
from sizing.parameters import (
    BUILD_KEY,
    FITTED_KEYS,
    MISSION_PREFIX,
    catalogue,
    parameter_value,
    value_at,
)
from sizing.structures.build import build_qualities
from solar.schema import spell
from solar.types import BoolArray, FloatArray


@dataclass(frozen=True)
class Proportion:
    """Share of draws with a property, and its 95 % confidence interval."""

    value: float
    low: float
    high: float

    @classmethod
    def of(cls, marks: BoolArray) -> Proportion:
        """Return the share of true values and its interval.

        Interval: Wilson, E. B. (1927), Probable inference, the law of succession, and statistical
        inference, J. Am. Stat. Assoc. 22, 209-212. It holds for independent draws, and is
        conservative for the points of a Sobol sequence.
        """
        from scipy.stats import binomtest

        found = binomtest(int(np.count_nonzero(marks)), len(marks))
        ends = found.proportion_ci(0.95, method="wilson")
        return cls(float(np.mean(marks)), float(ends.low), float(ends.high))

    def text(self) -> str:
        """Return share and interval in per cent."""
        value, low, high = (round(100.0 * v, 1) for v in (self.value, self.low, self.high))
        return f"{value} %" if low == high else f"{value} % (95 % between {low} and {high} %)"


def sobol_points(dimension: int, samples: int, seed: int) -> FloatArray:
    """Return points of a Sobol sequence with Owen's scrambling, of shape (dimension, draws)."""
    from scipy.stats import qmc

    power = math.ceil(math.log2(samples))
    return np.ascontiguousarray(qmc.Sobol(dimension, rng=seed).random_base2(power).T)


# Key of the factor on the power of the solar model, whose error was measured in flight.
SOLAR_MODEL = "solar_model"
_PROPULSION = "airframe.propulsion."
_FACTOR = f"{_PROPULSION}efficiency_factor"
# Share of draws in each tail that is cut off; the values at the ends must be possible.
_TAIL = 1e-4


@dataclass(frozen=True)
class UncertainInput:
    """Uncertain input with its distribution.

    ``key`` is that of the aircraft's file, of the mission's with the prefix ``mission.``, or
    :data:`SOLAR_MODEL`; ``nominal`` is the value of the file.
    """

    key: str
    nominal: float
    distribution: Distribution

    @property
    def label(self) -> str:
        """Name of the input in words."""
        if self.key == SOLAR_MODEL:
            return "error of the solar model"
        known = catalogue().get(self.key)
        return known.label if known else self.key.replace("_", " ").replace(".", ", ")

    def values(self, share: FloatArray) -> FloatArray:
        """Return the quantiles at shares of all draws, with the tails cut off."""
        return self.distribution.values(np.clip(share, _TAIL, 1.0 - _TAIL), self.nominal)


@dataclass(frozen=True)
class UncertainInputs:
    """Uncertain inputs of aircraft and mission, with the correlation of their normal scores [-]."""

    inputs: tuple[UncertainInput, ...]
    correlation: FloatArray

    def __len__(self) -> int:
        return len(self.inputs)

    @property
    def independent(self) -> bool:
        """True if no two inputs are correlated."""
        return bool(np.array_equal(self.correlation, np.eye(len(self))))

    def values(self, shares: FloatArray) -> dict[str, FloatArray]:
        """Return the values of each input by its key at points of the unit cube, ``(sample,)``."""
        if not self.independent:
            from scipy.special import ndtr, ndtri

            root = np.linalg.cholesky(self.correlation)
            shares = ndtr(root @ ndtri(np.clip(shares, 1e-12, 1.0 - 1e-12)))
        return {
            scattering.key: scattering.values(share)
            for scattering, share in zip(self.inputs, shares, strict=True)
        }


def uncertain_inputs(
    aircraft: Aircraft, mission: Mission, solar: SolarModel, *, model_error: bool = True
) -> UncertainInputs:
    """Collect and check the uncertain inputs of aircraft and mission.

    The RMS error of the solar power model is an additional input.
    """
    inputs: list[UncertainInput] = []
    problems: list[Problem] = []
    pairs: list[tuple[str, str, float]] = []
    for owner, prefix in ((aircraft, ""), (mission, MISSION_PREFIX)):
        if owner.uncertainty is None:
            continue
        named: dict[str, str] = {}
        for file_key, distribution in owner.uncertainty.inputs.items():
            key, relative = file_key, getattr(distribution, "relative_sigma", None) is not None
            # The efficiency factor in place of a computed propeller efficiency.
            computed = key == f"{_PROPULSION}propeller_efficiency" and _has_operating_point(owner)
            if computed and relative and _FACTOR not in owner.uncertainty.inputs:
                key = _FACTOR
            named[file_key] = key
            nominal = parameter_value(owner, None, key)
            place = f"uncertainty.inputs.{file_key}"
            if nominal is None:
                message = "is no key of the file that holds a number"
                if file_key.startswith(_PROPULSION) and _has_operating_point(owner):
                    message += f"; of an operating point {_FACTOR} scatters, by a relative_sigma"
                problems.append(Problem(owner.name, None, None, place, message))
                continue
            scattering = UncertainInput(prefix + key, nominal, distribution)
            inputs.append(scattering)
            # The first end of the distribution that the file's rules refuse.
            for share, end in ((_TAIL, "lowest"), (1.0 - _TAIL, "highest")):
                value = float(scattering.values(np.array([share]))[0])
                try:
                    with_values(owner, {key: value})
                except InputError as error:
                    message = (
                        f"scatters to impossible values, the {end} in {round(1 / _TAIL)} draws is "
                        f"{spell(value)}: {error.problems[0].message}"
                    )
                    place = f"uncertainty.inputs.{key}"
                    problems.append(Problem(owner.name, None, None, place, message))
                    break
        pairs += [
            (prefix + named.get(first, first), prefix + named.get(second, second), c.coefficient)
            for c in owner.uncertainty.correlations
            for first, second in [c.between]
        ]
    if model_error and solar.rms_relative > 0.0:
        inputs.append(UncertainInput(SOLAR_MODEL, 1.0, Normal(sigma=solar.rms_relative)))
    keys = [scattering.key for scattering in inputs]
    build = value_at(aircraft, BUILD_KEY)
    # The scatter of the build quality, unless the file has one for the structure.
    if isinstance(build, str) and not {BUILD_KEY, *FITTED_KEYS}.intersection(keys):
        quality = build_qualities()[build]
        scatter = LogNormal(distribution="lognormal", relative_sigma=math.expm1(quality.log_sigma))
        inputs.append(UncertainInput(BUILD_KEY, quality.factor, scatter))
        keys.append(BUILD_KEY)
    correlation, wrong = _correlations(aircraft.name, keys, pairs)
    if problems or wrong:
        raise InputError([*problems, *wrong])
    return UncertainInputs(tuple(inputs), correlation)


def _has_operating_point(owner: Aircraft | Mission) -> bool:
    """Return whether the propulsion's efficiencies are computed at an operating point."""
    return isinstance(owner, Aircraft) and owner.propulsion_by_parts is not None


def _correlations(
    source: str, keys: list[str], pairs: list[tuple[str, str, float]]
) -> tuple[FloatArray, list[Problem]]:
    """Return the correlation matrix, and its problems."""
    matrix, problems = np.eye(len(keys)), []
    for first, second, coefficient in pairs:
        unknown = [key for key in (first, second) if key not in keys]
        if unknown:
            message = f"{unknown[0]} is no uncertain input; there are: {', '.join(keys)}"
            problems.append(Problem(source, None, None, "uncertainty.correlations", message))
            continue
        i, j = keys.index(first), keys.index(second)
        matrix[i, j] = matrix[j, i] = coefficient
    if len(keys) and np.linalg.eigvalsh(matrix).min() <= 1e-10:
        message = "contradict each other: their matrix is not positive definite"
        problems.append(Problem(source, None, None, "uncertainty.correlations", message))
    return matrix, problems
