"""Sizing for a probability: the best design that most draws of the uncertain inputs can fly.

To the energy of a day a draw is two numbers: *income*, what the sun returns over the load, and
*storage*, what the battery holds over the load. The program has a factor on both and finds the best
design of the most probable point of failure, a reliability index away from the mean of the draws;
to first order that point lies towards the mean of the draws that fail (the sensitivity of their
share to the inputs: Rubinstein, R. Y. 1986, Math. Comput. Simul. 28:351). The index is the margin
(:mod:`sizing.program.margin`), and its judge flies the draws (performance measure approach: Tu, J.,
Choi, K. K., Park, Y. H. 1999, J. Mech. Des. 121:557).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel
from sizing.design import Design, variable_keys
from sizing.design_space import PROPULSION_VARIABLES
from sizing.limits import meets_requirements
from sizing.parameters import with_parameter
from sizing.program.margin import MarginSearch, Trial
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult
from sizing.program.whole_cells import without_whole_cells
from sizing.uncertainty.inputs import (
    SOLAR_MODEL,
    Proportion,
    UncertainInputs,
    sobol_points,
    uncertain_inputs,
)
from sizing.uncertainty.propagation import Profiles, Propagation, check_inputs
from solar.types import FloatArray

SEARCH_SAMPLES = 4096
VERIFICATION_SAMPLES = 10_000
_SEARCH_SEED, _VERIFICATION_SEED = 20_040, 1_999  # any two that differ
_INDEX_TOLERANCE = 0.02  # moves the probability by at most 0.8 %, less than the draws leave open
_LEAST_STEP, _LARGEST_INDEX = 0.5, 12.0  # of the index
_MOST_FAILING = 0.95  # of the draws that show the direction
_MOST_TILT = 0.5  # of the margins: none is less than a third of the other
_NO_LOSS = 1e-9  # of an objective by a margin that costs nothing


class Reliability(NamedTuple):
    """How reliable a sized design is.

    ``required``: probability that was asked for [-]. ``achieved``: share of independent draws that
    have the required excess time in every scenario; of the most reliable design that was found
    where none is reliable enough. ``samples``: number of those draws. ``nominal``: the same of the
    optimum without any uncertainty. ``nominal_objective``: objective of that optimum, in its unit.
    """

    required: float
    achieved: Proportion
    samples: int
    nominal: Proportion
    nominal_objective: float


def check_reliability(
    aircraft: Aircraft, mission: Mission, objective: Objective, solar: SolarModel, required: float
) -> None:
    """Refuse what no design can be sized for."""
    if not 0.0 < required < 1.0:
        raise ValueError(f"the reliability must be above 0 and below 1 (got {required:g})")
    if objective.of_range:
        raise ValueError(
            f"{objective.value} counts days or degrees: no reliability can be asked of it"
        )
    inputs = uncertain_inputs(without_whole_cells(aircraft), mission, solar)
    of_files = [it for it in inputs.inputs if it.key != SOLAR_MODEL]
    if not of_files:
        raise ValueError(
            f"neither {aircraft.name} nor {mission.name} has an uncertain input: a reliability "
            "needs uncertainty.inputs, for instance "
            "battery.specific_energy_wh_per_kg: {relative_sigma: 0.04}"
        )
    for uncertain in of_files:
        # The distribution of what is chosen moves with it; one with ends of its own does not.
        key, distribution = uncertain.key, uncertain.distribution
        if key in variable_keys() and not hasattr(distribution, "relative_sigma"):
            raise ValueError(
                f"{key} is chosen by the sizing: uncertainty.inputs.{key} must be normal or "
                f"lognormal, around what is chosen (got {distribution.distribution})"
            )
    check_inputs(inputs, mission, solar)


def with_design(aircraft: Aircraft, mission: Mission, design: Design) -> tuple[Aircraft, Mission]:
    """Return aircraft and mission with the variables of a design put in, unchecked."""
    chosen = design.variables.mapped(float).chosen()
    aircraft = without_whole_cells(aircraft)
    if (propulsion := aircraft.propulsion_by_parts) is not None:
        parts = propulsion.sized(*design.variables.of_propulsion)
        aircraft = aircraft.with_airframe(propulsion=parts)
    for key, name in variable_keys().items():
        if name in chosen and name not in PROPULSION_VARIABLES:
            aircraft, mission = with_parameter(aircraft, mission, key, chosen[name])
    return aircraft, mission


_NORMAL = NormalDist()
_score = _NORMAL.inv_cdf


def _weights(losses: FloatArray, correlation: float, reliability: float) -> FloatArray:
    """Weights of the margins on sun and storage, of which the dearer becomes the smaller.

    ``losses``: of the objective by each alone. Along the mean failure both ways to fail have the
    index ``b`` of half of the permitted failures, and the objective is best where more of either
    costs as much for what it gains. Of two normal ways with a correlation ``r`` more of one index
    gains ``phi(b_1) Phi((b_2 - r b_1) / sqrt(1 - r^2))``: with ``b (1 + t)`` and ``b (1 - t)``,
    ``ln(loss_2 / loss_1)`` is to first order ``2 t b^2 (1 + phi(u) / (u Phi(u)))``, where ``u`` is
    ``b sqrt((1 - r) / (1 + r))``. Ways that always fail together have no dearer one.
    """
    each = _score((1.0 + reliability) / 2.0)
    income, storage = np.clip(losses, _NO_LOSS, 1.0 / _NO_LOSS)
    together = float(np.clip(np.nan_to_num(correlation), _NO_LOSS - 1.0, 1.0 - _NO_LOSS))
    u = each * math.sqrt((1.0 - together) / (1.0 + together))
    steep = 2.0 * each**2 * (1.0 + _NORMAL.pdf(u) / (u * _NORMAL.cdf(u)))
    tilt = float(np.clip(np.log(storage / income) / steep, -_MOST_TILT, _MOST_TILT))
    return np.array([1.0 + tilt, 1.0 - tilt])


@dataclass
class ReliableSizing(MarginSearch):
    """Search for the best design that has the required excess time with a given probability.

    The margin is the index of reliability, its judge flies the draws. ``reliability``: least
    probability of the mission's required excess time in every scenario.
    """

    reliability: float
    _profiles: Profiles = field(default_factory=lambda: Profiles({}, {}))

    def run(self) -> tuple[SizingResult, Reliability | None]:
        """Return the outcome, and how reliable it is; None without a design for any margin."""
        nominal, least = self.plain, self.reliability
        if nominal.design is None or nominal.objective_value is None:
            return nominal, None
        hours = self._excess_h(nominal, self._shares)
        trial = self._judged(nominal, hours)
        if trial.surplus < 0.0:
            trial = self._searched(hours, trial.surplus) or trial
            work = nominal.solver + trial.result.solver
            trial = trial._replace(result=replace(trial.result, solver=work))
        # Draws that have not chosen it; those of the search have not chosen the nominal design.
        fresh = np.random.default_rng(_VERIFICATION_SEED)
        shares = fresh.random((len(self._shares), VERIFICATION_SAMPLES))
        achieved = Proportion.of(self._excess_h(trial.result, shares) >= self._required_h)
        plain = trial.result is nominal
        before = achieved if plain else Proportion.of(hours >= self._required_h)
        text = (
            f"a reliability of {100 * least:g} % is out of reach: the most reliable design "
            f"that was found has {100 * trial.reached:.1f} %"
        )
        result = trial.outcome("reliability", least - trial.reached, text)
        known = least, achieved, VERIFICATION_SAMPLES, before, nominal.objective_value
        return result, Reliability(*known)

    def _searched(self, hours: FloatArray, surplus: float) -> Trial | None:
        """Return the design of the least sufficient index, from the nominal design's draws on."""
        # Income and storage, as logarithms: their mean, and where the draws that fail lie from it.
        propagation, inputs = self._study(self.plain)
        assert self.plain.simulated is not None
        worst = int(np.argmin(self.plain.simulated.cycle.excess_time_h))
        files = {uncertain.key: np.array([uncertain.nominal]) for uncertain in inputs.inputs}
        drawn, plain = (
            np.log(propagation.income_and_storage(values, worst))
            for values in (inputs.values(self._shares), files)
        )
        mean = drawn.mean(axis=1)
        # Where all of them fail, their mean says nothing.
        failing = hours < min(self._required_h, float(np.quantile(hours, _MOST_FAILING)))
        towards = drawn[:, failing].mean(axis=1) - mean
        step = max(_score(self.reliability), _LEAST_STEP)
        income, storage = np.exp(step * towards).tolist()
        merits = [self.sized(*alone).merit for alone in ((income, 1.0), (1.0, storage))]
        with np.errstate(invalid="ignore"):  # one of them may be certain
            correlation = float(np.corrcoef(drawn)[0, 1])
        losses = self.plain.merit - np.array(merits)
        towards = towards * _weights(losses, correlation, self.reliability)

        def factors(index: float) -> tuple[float, float]:
            income, storage = np.exp(mean - plain[:, 0] + index * towards).tolist()
            return income, storage

        return self.least(factors, (0.0, _LARGEST_INDEX), step, _INDEX_TOLERANCE, surplus)

    def judge(self, result: SizingResult) -> Trial:
        """Fly the draws of a design."""
        return self._judged(result, self._excess_h(result, self._shares))

    def _judged(self, result: SizingResult, hours: FloatArray) -> Trial:
        """Return the trial of the draws' excess times; its surplus is of normal scores."""
        assert result.design is not None
        good, count = int(np.count_nonzero(hours >= self._required_h)), len(hours)
        surplus = _score((good + 0.5) / (count + 1.0)) - _score(self.reliability)
        sufficient = good >= self.reliability * count
        surplus = max(surplus, 0.0) if sufficient else min(surplus, -_NO_LOSS)
        feasible = meets_requirements(self.aircraft, result.design)
        return Trial(result, good / count, surplus if feasible else -math.inf)

    def _excess_h(self, result: SizingResult, shares: FloatArray) -> FloatArray:
        propagation, inputs = self._study(result)
        flights = propagation.flights(inputs.values(shares), stop_at_excess_time_h=self._required_h)
        return np.where(flights.excess_time_h > 0.0, flights.excess_time_h, -np.inf)

    def _study(self, result: SizingResult) -> tuple[Propagation, UncertainInputs]:
        """Return the flights of the draws of a design, along known profiles, and its inputs."""
        assert result.design is not None
        aircraft, mission = with_design(self.aircraft, self.mission, result.design)
        propagation = Propagation(aircraft, mission, self.solar, profiles=self._profiles)
        return propagation, uncertain_inputs(aircraft, mission, self.solar)

    @cached_property
    def _shares(self) -> FloatArray:
        """Draws of the search."""
        count = len(uncertain_inputs(self.aircraft, self.mission, self.solar))
        return sobol_points(count, SEARCH_SAMPLES, _SEARCH_SEED)

    @property
    def _required_h(self) -> float:
        return self.mission.required_excess_time_h
