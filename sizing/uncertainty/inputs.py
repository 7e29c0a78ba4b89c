"""Uncertain inputs of an aircraft on a mission, and draws of them.

Draws are points of the unit cube, one axis an input: quantiles turn them into values, and a
Gaussian copula ties inputs together (Nelsen, R. B. (2006), An Introduction to Copulas, section
2.3).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

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


# Factor on the power of the solar model, whose error was measured in flight.
SOLAR_MODEL = "solar_model"
_PROPULSION = "airframe.propulsion."
_FACTOR = f"{_PROPULSION}efficiency_factor"
# Share of draws beyond which a distribution is cut off, and that must be possible.
_TAIL = 1e-4


@dataclass(frozen=True)
class UncertainInput:
    """An input that scatters.

    ``key``: in the aircraft's file, behind ``mission.`` in the mission's, or :data:`SOLAR_MODEL`.
    ``nominal``: value that the file gives. ``distribution``: how it scatters.
    """

    key: str
    nominal: float
    distribution: Distribution

    @property
    def label(self) -> str:
        """Input in words."""
        if self.key == SOLAR_MODEL:
            return "error of the solar model"
        known = catalogue().get(self.key)
        return known.label if known else self.key.replace("_", " ").replace(".", ", ")

    def values(self, share: FloatArray) -> FloatArray:
        """Values below which shares of all draws lie; the tails are cut off."""
        return self.distribution.values(np.clip(share, _TAIL, 1.0 - _TAIL), self.nominal)


@dataclass(frozen=True)
class UncertainInputs:
    """All uncertain inputs of a case.

    ``correlation``: of their normal scores [-].
    """

    inputs: tuple[UncertainInput, ...]
    correlation: FloatArray

    def __len__(self) -> int:
        return len(self.inputs)

    @property
    def independent(self) -> bool:
        """Whether no input goes with another."""
        return bool(np.array_equal(self.correlation, np.eye(len(self))))

    @cached_property
    def _root(self) -> FloatArray:
        return np.asarray(np.linalg.cholesky(self.correlation), float)

    def values(self, shares: FloatArray) -> dict[str, FloatArray]:
        """Values of all inputs at points of the unit cube.

        Returns values of each input by its key, shape ``(sample,)``.
        """
        if not self.independent:
            from scipy.special import ndtr, ndtri

            shares = ndtr(self._root @ ndtri(np.clip(shares, 1e-12, 1.0 - 1e-12)))
        return {one.key: one.values(share) for one, share in zip(self.inputs, shares, strict=True)}


def uncertain_inputs(
    aircraft: Aircraft, mission: Mission, solar: SolarModel, *, model_error: bool = True
) -> UncertainInputs:
    """Collect and check the uncertain inputs that aircraft and mission name.

    ``solar``: solar power model, whose RMS error is an input of its own.
    """
    inputs: list[UncertainInput] = []
    problems: list[Problem] = []
    pairs: list[tuple[str, str, float]] = []
    for owner, prefix in ((aircraft, ""), (mission, MISSION_PREFIX)):
        if owner.uncertainty is None:
            continue
        named: dict[str, str] = {}
        for given, distribution in owner.uncertainty.inputs.items():
            named[given] = key = _of_operating_point(owner, given, distribution)
            nominal = parameter_value(owner, None, key)
            place = f"uncertainty.inputs.{given}"
            if nominal is None:
                message = "is no key of the file that holds a number"
                if given.startswith(_PROPULSION) and _is_computed(owner):
                    message += f"; of an operating point {_FACTOR} scatters, by a relative_sigma"
                problems.append(Problem(owner.name, None, None, place, message))
                continue
            one = UncertainInput(prefix + key, nominal, distribution)
            problems += _impossible(owner, key, one)
            inputs.append(one)
        pairs += [
            (prefix + named.get(one, one), prefix + named.get(other, other), c.coefficient)
            for c in owner.uncertainty.correlations
            for one, other in [c.between]
        ]
    if model_error and solar.rms_relative > 0.0:
        inputs.append(UncertainInput(SOLAR_MODEL, 1.0, Normal(sigma=solar.rms_relative)))
    inputs += _scatter_of_build(aircraft, {one.key for one in inputs})
    correlation, wrong = _correlations(aircraft.name, [one.key for one in inputs], pairs)
    if problems or wrong:
        raise InputError([*problems, *wrong])
    return UncertainInputs(tuple(inputs), correlation)


def _scatter_of_build(aircraft: Aircraft, named: set[str]) -> list[UncertainInput]:
    """Scatter of a class of building, unless the file says how the structure scatters."""
    build = value_at(aircraft, BUILD_KEY)
    if not isinstance(build, str) or named & {BUILD_KEY, *FITTED_KEYS}:
        return []
    quality = build_qualities()[build]
    scatter = LogNormal(distribution="lognormal", relative_sigma=math.expm1(quality.log_sigma))
    return [UncertainInput(BUILD_KEY, quality.factor, scatter)]


def _is_computed(owner: Aircraft | Mission) -> bool:
    """Whether the efficiencies of the propulsion are those of an operating point."""
    return isinstance(owner, Aircraft) and owner.propulsion_by_parts is not None


def _of_operating_point(owner: Aircraft | Mission, key: str, distribution: Distribution) -> str:
    """Key that an input stands for: of a propeller's efficiency that is computed, its factor."""
    assert owner.uncertainty is not None
    relative = getattr(distribution, "relative_sigma", None) is not None
    named = key == f"{_PROPULSION}propeller_efficiency" and _FACTOR not in owner.uncertainty.inputs
    return _FACTOR if named and relative and _is_computed(owner) else key


def _impossible(owner: Aircraft | Mission, key: str, one: UncertainInput) -> list[Problem]:
    """What is wrong with the ends of a distribution, by the rules of the file."""
    problems = []
    for share, end in ((_TAIL, "lowest"), (1.0 - _TAIL, "highest")):
        value = float(one.values(np.array([share]))[0])
        try:
            with_values(owner, {key: value})
        except InputError as error:
            message = (
                f"scatters to impossible values, the {end} in {1 / _TAIL:.0f} draws is {value:g}: "
                f"{error.problems[0].message}"
            )
            place = f"uncertainty.inputs.{key}"
            problems.append(Problem(owner.name, None, None, place, message))
            break
    return problems


def _correlations(
    source: str, keys: list[str], pairs: list[tuple[str, str, float]]
) -> tuple[FloatArray, list[Problem]]:
    """Matrix of the correlations, and what is wrong with them."""
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
