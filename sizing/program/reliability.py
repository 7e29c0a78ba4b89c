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

from collections.abc import Callable
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
from sizing.program.margin import MarginCase, Trial, best_of, least_margin
from sizing.program.objectives import Objective, refuse_range
from sizing.program.result import SizingResult, Violation
from sizing.program.whole_cells import without_whole_cells
from sizing.uncertainty.inputs import (
    SOLAR_MODEL,
    Proportion,
    UncertainInputs,
    sobol_points,
    uncertain_inputs,
)
from sizing.uncertainty.propagation import Profiles, Propagation, check_inputs, propagation_of
from solar.types import FloatArray

SEARCH_SAMPLES = 4096
VERIFICATION_SAMPLES = 10_000
_SEARCH_SEED, _VERIFICATION_SEED = 20_040, 1_999  # any two that differ
_INDEX_TOLERANCE = 0.02  # moves the probability by at most 0.8 %, less than the draws leave open
_LARGEST_INDEX = 12.0  # of which nothing fails
_MOST_FAILING = 0.95  # of the draws that show the direction
_MOST_TILT = 1.0 / 3.0  # of the margins: none is less than half of the other
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
    refuse_range(objective, "no reliability can be asked of it")
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
    parts = aircraft.propulsion.sized(*design.variables.of_propulsion)
    aircraft = aircraft.with_airframe(propulsion=parts)
    for key, name in variable_keys().items():
        if name in chosen and name not in PROPULSION_VARIABLES:
            aircraft, mission = with_parameter(aircraft, mission, key, chosen[name])
    return aircraft, mission


_score = NormalDist().inv_cdf


def size_reliably(case: MarginCase, reliability: float) -> tuple[SizingResult, Reliability | None]:
    """Find the best design that has the required excess time with a given probability.

    ``reliability``: least probability of the mission's required excess time in every scenario.
    Returns the outcome, and how reliable it is; None without a design for any margin.
    """
    nominal, required_h = case.plain, case.mission.required_excess_time_h
    if nominal.design is None or nominal.objective_value is None:
        return nominal, None
    draws = _Draws(case)
    hours = draws.excess_h(nominal)
    trials = [Trial(nominal, float(np.mean(hours >= required_h)))]
    if trials[0].reached < reliability:
        factors = _factors(draws, hours, reliability)

        def tried_with(index: float) -> Trial | None:
            result = case.sized(*factors(index))
            if result.design is None:
                return None
            allowed = meets_requirements(case.aircraft, result.design)
            return Trial(result, float(np.mean(allowed & (draws.excess_h(result) >= required_h))))

        def surplus(reached: float) -> float:
            """Return by how much a share is above the required one, as normal scores."""
            half = 0.5 / SEARCH_SAMPLES
            return _score(min(max(reached, half), 1.0 - half)) - _score(reliability)

        shortfall = -surplus(trials[0].reached)
        ends = 0.0, _LARGEST_INDEX
        trials += least_margin(tried_with, surplus, ends, _INDEX_TOLERANCE, shortfall)
    best = best_of(trials, reliability)
    # Draws that have not chosen it; those of the search have not chosen the nominal design.
    fresh = np.random.default_rng(_VERIFICATION_SEED)
    shares = fresh.random((len(draws.shares), VERIFICATION_SAMPLES))
    achieved = Proportion.of(draws.excess_h(best.result, shares) >= required_h)
    before = achieved if best.result is nominal else Proportion.of(hours >= required_h)
    result = replace(best.result, solver=case.solver)
    if best.reached < reliability:
        text = (
            f"a reliability of {100 * reliability:g} % is out of reach: the most reliable design "
            f"that was found has {100 * best.reached:.1f} %"
        )
        missed = Violation("reliability", reliability - best.reached, text)
        result = result.without_design(result.simulated, missed)
    known = reliability, achieved, VERIFICATION_SAMPLES, before, nominal.objective_value
    return result, Reliability(*known)


def _factors(
    draws: _Draws, hours: FloatArray, reliability: float
) -> Callable[[float], tuple[float, float]]:
    """Return the factors on sun and battery of an index, from the nominal design's draws.

    ``hours``: their excess times. Income and storage are logarithms: their mean, and from there
    towards the draws that fail, the dearer of them less far: with ``b (1 + t)`` and ``b (1 - t)``
    of an index ``b`` the objective is best where what more of either costs is in proportion to the
    failures that it prevents, ``ln(loss_2 / loss_1) = 2 t b^2`` for normal draws to first order.
    """
    plain = draws.case.plain
    assert plain.simulated is not None
    propagation, inputs = draws.study(plain)
    worst = plain.simulated.worst_scenario()
    files = {uncertain.key: np.array([uncertain.nominal]) for uncertain in inputs.inputs}
    drawn, of_files = (
        np.log(propagation.income_and_storage(values, worst))
        for values in (inputs.values(draws.shares), files)
    )
    mean = drawn.mean(axis=1)
    # Where all of them fail, their mean says nothing.
    required_h = draws.case.mission.required_excess_time_h
    failing = hours < min(required_h, float(np.quantile(hours, _MOST_FAILING)))
    towards = drawn[:, failing].mean(axis=1) - mean
    # Along the mean failure either way to fail has the index of half of the permitted failures.
    each = _score((1.0 + reliability) / 2.0)
    alone = np.exp(each * np.diag(towards)).tolist()
    losses = [plain.merit - draws.case.sized(*factors).merit for factors in alone]
    income, storage = np.clip(losses, _NO_LOSS, 1.0 / _NO_LOSS)
    tilt = float(np.clip(np.log(storage / income) / (2.0 * each**2), -_MOST_TILT, _MOST_TILT))
    towards *= 1.0 + tilt, 1.0 - tilt

    def factors(index: float) -> tuple[float, float]:
        income, storage = np.exp(mean - of_files[:, 0] + index * towards).tolist()
        return income, storage

    return factors


@dataclass
class _Draws:
    """Draws of the inputs of a case, and the flights of designs with them."""

    case: MarginCase
    _profiles: Profiles = field(default_factory=lambda: Profiles({}, {}))

    @cached_property
    def shares(self) -> FloatArray:
        """Draws of the search."""
        case = self.case
        count = len(uncertain_inputs(case.aircraft, case.mission, case.solar))
        return sobol_points(count, SEARCH_SAMPLES, _SEARCH_SEED)

    def excess_h(self, result: SizingResult, shares: FloatArray | None = None) -> FloatArray:
        """Return a design's excess time with every draw; minus infinity if not perpetual."""
        propagation, inputs = self.study(result)
        flights = propagation.flights(
            inputs.values(self.shares if shares is None else shares),
            stop_at_excess_time_h=self.case.mission.required_excess_time_h,
        )
        return np.where(flights.excess_time_h > 0.0, flights.excess_time_h, -np.inf)

    def study(self, result: SizingResult) -> tuple[Propagation, UncertainInputs]:
        """Return the flights of the draws of a design, along known profiles, and its inputs."""
        assert result.design is not None
        case = self.case
        aircraft, mission = with_design(case.aircraft, case.mission, result.design)
        propagation = propagation_of(aircraft, mission, case.solar, self._profiles)
        return propagation, uncertain_inputs(aircraft, mission, case.solar)
