"""Which parameters a channel determines, and how well.

Parameters that do the same to the measured quantity cannot both be fitted. The collinearity index
is one over the smallest singular value of the Jacobian whose columns have unit length (Brun, R.,
Reichert, P. & Kuensch, H. R. (2001), Water Resources Research 37, 1015-1030); up to about 20 a set
of parameters counts as identifiable (Soetaert, K. & Petzoldt, T. (2010), Journal of Statistical
Software 33(3), section 4).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from sizing.aircraft import Aircraft
from solar.types import FloatArray
from studies.fitting.channels.bins import BIN_S
from studies.fitting.channels.channel import Channel
from studies.fitting.channels.flight_errors import WARMTH, FlightError
from studies.fitting.least_squares import Problem, Solution, singular_values, solved
from studies.fitting.parameters import FitParameter, replaced_values

COLLINEAR = 20.0
# A parameter whose whole range of the search moves the model by less than so much of the residuals'
# spread plays no part; rounding moves it by less.
_NO_PART = 1e-9
# Fewer independent residuals say nothing about how large errors are.
_FEWEST_INDEPENDENT = 2.0
_AT_END = 1e-6  # of the range of the search
_WARMTH_KEYS = ("modules.temperature_rise_k", "modules.temperature_coefficient_per_k")


@dataclass(frozen=True)
class Fitted:
    """A parameter that was fitted.

    ``before``, ``value``: that of the file, and that of the fit. ``standard_error``: of the
    measurement's scatter and of the errors of sky, attitude and model together. ``low``, ``high``:
    ends of the confidence interval.
    """

    parameter: FitParameter
    before: float
    value: float
    standard_error: float
    low: float
    high: float

    @property
    def half_width(self) -> float:
        """Half of the confidence interval."""
        return 0.5 * (self.high - self.low)

    def to_dict(self) -> dict[str, Any]:
        """Key of the file with its value and interval, JSON-ready."""
        numbers = {name: value for name, value in vars(self).items() if name != "parameter"}
        return {"key": self.parameter.key, "unit": self.parameter.unit, **numbers}


def with_fitted(aircraft: Aircraft, fitted: Sequence[Fitted]) -> Aircraft:
    """Aircraft with the fitted values."""
    parameters, values = (one.parameter for one in fitted), (one.value for one in fitted)
    return replaced_values(aircraft, tuple(parameters), tuple(values))


@dataclass(frozen=True)
class Held:
    """A parameter that stays as the file has it, and why."""

    parameter: FitParameter
    value: float
    reason: str

    def to_dict(self) -> dict[str, Any]:
        """Key of the file with its value and the reason, JSON-ready."""
        return {"key": self.parameter.key, "value": self.value, "reason": self.reason}


class FoundError(NamedTuple):
    """An error of a flight: best value, and its standard error after the fit."""

    known: FlightError
    value: float
    standard_error: float


@dataclass(frozen=True)
class Estimate:
    """Fit of one channel; ``before``: residuals with the values of the file."""

    channel: Channel
    fitted: tuple[Fitted, ...]
    held: tuple[Held, ...]
    before: FloatArray
    solution: Solution
    errors: tuple[FoundError, ...]

    def noise(self, hours: float) -> float:
        """Deviation of the residuals' integral over hours: independent ones add up as squares."""
        left, independent = self.solution.residual, self.solution.independent
        if not 0.0 < independent < math.inf:
            return 0.0
        lasts_h = len(left) / independent * BIN_S / 3600.0
        return math.sqrt(float(np.mean(left**2)) * lasts_h * max(hours, 0.0))

    @property
    def collinearity(self) -> float:
        """Collinearity index of the fitted parameters; 1 where they do nothing in common."""
        return 1.0 / float(self.solution.singular.min(initial=1.0))

    def correlation(self) -> FloatArray:
        """Correlation of the fitted parameters."""
        own = self.solution.covariance[: len(self.fitted), : len(self.fitted)]
        root = np.sqrt(np.diag(own))
        return np.asarray(own / np.outer(root, root))


def estimate(
    channel: Channel, aircraft: Aircraft, parameters: tuple[FitParameter, ...]
) -> Estimate:
    """Fit as many parameters as a channel can tell apart; the later ones are held."""
    held: list[Held] = []
    problem = _told_apart(Problem(channel, aircraft, parameters), held)
    solution = solved(_free_of_known(problem))
    while (worst := _undetermined(problem, solution)) is not None:
        place, reason = worst
        held.append(_held(problem, place, reason))
        rest = problem.parameters[:place] + problem.parameters[place + 1 :]
        problem = replace(problem, parameters=rest)
        solution = solved(_free_of_known(problem))
    deviations = np.sqrt(np.diag(solution.covariance)).tolist()
    values, halves = solution.values.tolist(), solution.half_width.tolist()
    fitted = tuple(
        Fitted(one, one.value(aircraft), value, error, value - half, value + half)
        for one, value, error, half in zip(
            problem.parameters, values, deviations, halves, strict=False
        )
    )
    known, found = _free_of_known(problem).channel.errors, solution.errors.tolist()
    return Estimate(
        channel=channel,
        fitted=fitted,
        held=tuple(held),
        before=channel.residual(aircraft),
        solution=solution,
        errors=tuple(map(FoundError, known, found, deviations[len(fitted) :])),
    )


def _free_of_known(problem: Problem) -> Problem:
    """Problem without errors that are what is fitted."""
    if not any(one.key in _WARMTH_KEYS for one in problem.parameters):
        return problem
    errors = tuple(one for one in problem.channel.errors if one.name != WARMTH)
    return replace(problem, channel=replace(problem.channel, errors=errors))


def _held(problem: Problem, place: int, reason: str) -> Held:
    one = problem.parameters[place]
    return Held(one, one.value(problem.aircraft), reason)


# ---- What can be told apart


def _told_apart(problem: Problem, held: list[Held]) -> Problem:
    """Problem without parameters that play no part or do the same as those before them."""
    start = problem.start()
    jacobian = problem.jacobian(start)
    spread = float(np.std(problem.residual(start))) or 1.0
    kept: list[int] = []
    for place, one in enumerate(problem.parameters):
        moved = np.abs(jacobian[:, place]).max(initial=0.0) * (one.highest - one.lowest)
        if not moved > _NO_PART * spread:
            held.append(_held(problem, place, f"it plays no part in the {problem.channel.label}"))
            continue
        singular = singular_values(jacobian[:, [*kept, place]])
        index = 1.0 / max(float(singular.min()), 1e-300)
        if index > COLLINEAR:
            held.append(_held(problem, place, _alike(problem, jacobian, kept, place, index)))
            continue
        kept.append(place)
    return replace(problem, parameters=tuple(problem.parameters[place] for place in kept))


def _alike(
    problem: Problem, jacobian: FloatArray, kept: list[int], place: int, index: float
) -> str:
    """Words for a parameter that does what others do."""
    columns = jacobian / np.sqrt(np.sum(jacobian**2, axis=0))
    cosines = columns[:, kept].T @ columns[:, place]
    nearest = kept[int(np.argmax(np.abs(cosines)))]
    ratio = "above 1e6" if index > 1e6 else f"{index:.0f}"
    other = problem.parameters[nearest].name
    if len(kept) > 1:
        other += " and the others"
    return (
        f"the log cannot tell it from {other}: correlation of their effects "
        f"{float(np.max(np.abs(cosines))):.4f}, collinearity index {ratio} (at most {COLLINEAR:g})"
    )


def _undetermined(problem: Problem, solution: Solution) -> tuple[int, str] | None:
    """Parameter that the log leaves open most of all, and why; None where there is none."""
    if solution.independent < _FEWEST_INDEPENDENT:  # infinite where nothing is fitted
        return len(problem.parameters) - 1, (
            f"only {solution.independent:.1f} residuals are independent in effect: "
            "the log is too short, or its errors last too long"
        )
    worst, reason, most = None, "", 1.0
    for place, one in enumerate(problem.parameters):
        value, half = float(solution.values[place]), float(solution.half_width[place])
        margin = _AT_END * (one.highest - one.lowest)
        if not one.lowest + margin < value < one.highest - margin:
            return place, f"the best value is at the end of what is possible, {value:g} {one.unit}"
        open_by = half / one.widest(value)
        if open_by > most:
            worst, most = place, open_by
            reason = f"the interval is as wide as {value:.3g} ± {half:.2g} {one.unit}".rstrip()
    return None if worst is None else (worst, reason)
