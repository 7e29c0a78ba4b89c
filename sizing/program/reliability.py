"""Sizing for a probability: the best design that most draws of the uncertain inputs can fly.

To the energy of a day a draw is two numbers: *income*, what the sun returns over the load, and
*storage*, what the battery holds over the load. The program has a factor on both and finds the best
design of the most probable point of failure, a reliability index away from the mean of the draws;
to first order that point lies towards the mean of the draws that fail (the sensitivity of their
share to the inputs: Rubinstein, R. Y. 1986, Math. Comput. Simul. 28:351). The index is bisected
until as many draws as asked for fly the design without the factors (performance measure approach:
Tu, J., Choi, K. K., Park, Y. H. 1999, J. Mech. Des. 121:557; sizing and judging by turns: Du, X.,
Chen, W. 2004, J. Mech. Des. 126:225).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import Design, DesignVariables, variable_keys
from sizing.design_space import PROPULSION_VARIABLES, LimitedQuantity
from sizing.limits import meets_requirements
from sizing.parameters import MISSION_PREFIX, with_parameter
from sizing.performance import performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult, SizingStatus, Violation
from sizing.program.size import size_aircraft
from sizing.program.whole_cell_designs import without_whole_cells
from sizing.sunlight import SolarDay, SolarModel, solar_day
from sizing.uncertainty.inputs import (
    SOLAR_MODEL,
    Proportion,
    UncertainInputs,
    sobol_points,
    uncertain_inputs,
)
from sizing.uncertainty.propagation import Propagation, check_inputs
from solar.types import FloatArray

_NORMAL = NormalDist()
SEARCH_SAMPLES = 4096
VERIFICATION_SAMPLES = 10_000
_SEARCH_SEED, _VERIFICATION_SEED = 20_040, 1_999  # any two that differ
_INDEX_TOLERANCE = 0.02  # moves the probability by at most 0.8 %, less than the draws leave open
_LEAST_STEP, _LARGEST_INDEX = 0.5, 12.0  # of the index
_MOST_FAILING = 0.95  # of the draws that show the direction


class Trial(NamedTuple):
    """A design that was sized with a margin, and what a judge finds of it without the margin.

    ``reached``: share of draws, or number of days, that it flies; ``enough``: whether that does.
    """

    result: SizingResult
    reached: float
    enough: bool


def least_margin(
    trial: Callable[[float], Trial | None], ends: tuple[float, float], step: float, tolerance: float
) -> Trial | None:
    """Design of the least margin that its judge accepts, by bisection; else of most reach.

    Parameters
    ----------
    trial : callable
        Design of a margin; None where the margin leaves none.
    ends : tuple
        A margin that is not enough, and the largest that is tried.
    step : float
        From a margin that is not enough to the next, as long as none is.
    tolerance : float
        Of the margin.
    """
    (low, most), high = ends, math.inf
    tried: list[Trial] = []
    while high - low > tolerance and low < most:
        margin = low + step if math.isinf(high) else (low + high) / 2.0
        one = trial(margin)
        if one is not None:
            tried.append(one)
        if one is None or one.enough:
            high = margin
        else:
            low = margin
    good = [one for one in tried if one.enough]
    if good:
        return max(good, key=lambda one: one.result.merit)
    return max(tried, key=lambda one: one.reached, default=None)


@dataclass(frozen=True)
class Reliability:
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

    def to_dict(self) -> dict[str, float]:
        """Record, JSON-ready."""
        achieved = self.achieved
        return {
            "required": self.required,
            "achieved": achieved.value,
            "low": achieved.low,
            "high": achieved.high,
            "samples": self.samples,
            "nominal": self.nominal.value,
            "nominal_objective": self.nominal_objective,
        }


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
    own = [one for one in inputs.inputs if one.key != SOLAR_MODEL]
    if not own:
        raise ValueError(
            f"neither {aircraft.name} nor {mission.name} has an uncertain input: a reliability "
            "needs uncertainty.inputs, for instance "
            "battery.specific_energy_wh_per_kg: {relative_sigma: 0.04}"
        )
    for one in own:
        # The distribution of what is chosen moves with it; one with ends of its own does not.
        if one.key in variable_keys() and not hasattr(one.distribution, "relative_sigma"):
            raise ValueError(
                f"{one.key} is chosen by the sizing: uncertainty.inputs.{one.key} must be normal "
                f"or lognormal, around what is chosen (got {one.distribution.distribution})"
            )
    check_inputs(inputs, mission, solar)


def with_design(aircraft: Aircraft, mission: Mission, design: Design) -> tuple[Aircraft, Mission]:
    """Aircraft and mission with the variables of a design put in, unchecked."""
    chosen = design.variables.mapped(float).chosen()
    aircraft = without_whole_cells(aircraft)
    if (propulsion := aircraft.propulsion_by_parts) is not None:
        parts = propulsion.sized(*design.variables.of_propulsion)
        aircraft = aircraft.with_airframe(propulsion=parts)
    for key, name in variable_keys().items():
        if name in chosen and name not in PROPULSION_VARIABLES:
            aircraft, mission = with_parameter(aircraft, mission, key, chosen[name])
    return aircraft, mission


# Limits on the battery, by the power of the factor on its storage with which they grow.
_SCALED_LIMITS: dict[LimitedQuantity, float] = {
    "battery_energy_wh": 1.0,
    "cruise_discharge_rate_per_h": -1.0,
    "climb_discharge_rate_per_h": -1.0,
}


def with_storage(aircraft: Aircraft, mission: Mission, factor: float) -> tuple[Aircraft, Mission]:
    """Aircraft and mission with another storage, of which the limits on the battery know nothing.

    The factor is no margin of a file: it may exceed 1.
    """
    space = aircraft.design_space
    for name in _SCALED_LIMITS.keys() & space.all_limits().keys():
        for end in ("minimum", "maximum"):
            if (value := getattr(space.all_limits()[name], end)) is not None:
                space = space.with_limit(name, end, value * factor ** _SCALED_LIMITS[name])
    key = f"{MISSION_PREFIX}uncertainty_margins.battery_capacity"
    capacity = factor * mission.uncertainty_margins.battery_capacity
    limited = aircraft.model_copy(update={"design_space": space})
    return with_parameter(limited, mission, key, capacity)


def size_with_margins(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel,
    day: SolarDay,
    start: DesignVariables | None,
    income: float,
    storage: float,
) -> SizingResult:
    """Size with factors on sun and storage; flight and objective are those without them."""
    larger = with_storage(aircraft, mission, float(storage))
    sun = day.scaled(float(income))
    result = size_aircraft(*larger, objective, solar, day=sun, start=start, explain=False)
    if result.design is None:
        return result
    given = (aircraft, mission, result.design.variables, solar)
    return result.with_design(performance_of_designs(*given, day=day))


def size_reliably(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel,
    *,
    reliability: float,
    start: DesignVariables | None = None,
) -> tuple[SizingResult, Reliability | None]:
    """Find the best design that has the required excess time with a given probability.

    ``aircraft``, ``mission``, ``objective``, ``solar``, ``start``: as for
    :func:`sizing.program.size.size_aircraft`, with uncertain inputs; the mission has the required
    excess time. ``reliability``: least probability of the required excess time in every scenario.
    Returns reliability is None where there is no design even without uncertainty.
    """
    nominal = size_aircraft(aircraft, mission, objective, solar, start=start)
    if nominal.design is None:
        return nominal, None
    day = solar_day(aircraft, mission, solar)
    return _Search(aircraft, mission, objective, solar, reliability, nominal, day).run()


@dataclass
class _Search:
    """Search for the factors of the best design that is reliable enough."""

    aircraft: Aircraft
    mission: Mission
    objective: Objective
    solar: SolarModel
    required: float
    nominal: SizingResult
    day: SolarDay

    def run(self) -> tuple[SizingResult, Reliability]:
        trial, case = self._judged(self.nominal), (self.aircraft, self.mission, self.objective)
        work, assumed = self.nominal.solver, self.nominal.design
        assert assumed is not None
        if not trial.enough:
            mean, towards = self._failure()
            step = max(_NORMAL.inv_cdf(self.required), _LEAST_STEP)

            def sized(index: float) -> Trial | None:
                nonlocal work
                income, storage = np.exp(mean + index * towards)
                result = size_with_margins(
                    *(*case, self.solar, self.day, assumed.variables), income, storage
                )
                work += result.solver
                return None if result.design is None else self._judged(result)

            ends = (0.0, _LARGEST_INDEX)
            trial = least_margin(sized, ends, step, _INDEX_TOLERANCE) or trial
        reliability = self._verified(trial)
        result = replace(trial.result, solver=work)
        if trial.enough:
            return result, reliability
        text = (
            f"a reliability of {100 * self.required:g} % is out of reach: the most reliable design "
            f"that was found has {100 * trial.reached:.1f} %"
        )
        missed = Violation("reliability", self.required - trial.reached, text)
        status = SizingStatus.infeasible
        return result.without_design(status, result.simulated, missed), reliability

    # --- flights -----------------------------------------------------------------------------

    def _study(self, result: SizingResult) -> tuple[Propagation, UncertainInputs]:
        """Flights of the draws of a design, and its uncertain inputs."""
        assert result.design is not None
        aircraft, mission = with_design(self.aircraft, self.mission, result.design)
        inputs = uncertain_inputs(aircraft, mission, self.solar)
        return Propagation(aircraft, mission, self.solar), inputs

    def _excess_h(self, result: SizingResult, shares: FloatArray | None = None) -> FloatArray:
        """Excess time of the draws of a design, minus infinity where they have none."""
        study, inputs = self._study(result)
        if shares is None:
            shares = sobol_points(len(inputs), SEARCH_SAMPLES, _SEARCH_SEED)
        excess_h = study.flights(inputs.values(shares)).excess_time_h
        return np.where(excess_h > 0.0, excess_h, -np.inf)

    def _judged(self, result: SizingResult) -> Trial:
        assert result.design is not None
        reached = float(np.mean(self._excess_h(result) >= self.mission.required_excess_time_h))
        sound = meets_requirements(self.aircraft, self.mission, result.design)
        return Trial(result, reached, bool(sound) and reached >= self.required)

    def _verified(self, trial: Trial) -> Reliability:
        """Reliability by draws that the search has not seen."""
        count = len(self._study(self.nominal)[1])
        rng = np.random.default_rng(_VERIFICATION_SEED)
        shares = rng.random((count, VERIFICATION_SAMPLES))
        achieved, nominal = (
            Proportion.of(self._excess_h(one, shares) >= self.mission.required_excess_time_h)
            for one in (trial.result, self.nominal)
        )
        value = self.nominal.objective_value
        assert value is not None
        return Reliability(self.required, achieved, VERIFICATION_SAMPLES, nominal, value)

    # --- factors on income and storage, as logarithms ----------------------------------------

    def _failure(self) -> tuple[FloatArray, FloatArray]:
        """Mean of the draws of the nominal design, and where those that fail lie from it."""
        (study, inputs), flown = self._study(self.nominal), self.nominal.simulated
        assert flown is not None
        worst = int(np.argmin(flown.cycle.excess_time_h))
        shares = sobol_points(len(inputs), SEARCH_SAMPLES, _SEARCH_SEED)
        files = {one.key: np.array([one.nominal]) for one in inputs.inputs}
        drawn, plain = (
            np.log(study.income_and_storage(one, worst)) for one in (inputs.values(shares), files)
        )
        excess_h = self._excess_h(self.nominal)
        # Where all of them fail, their mean says nothing.
        some = min(self.mission.required_excess_time_h, float(np.quantile(excess_h, _MOST_FAILING)))
        mean, failing = drawn.mean(axis=1), drawn[:, excess_h < some].mean(axis=1)
        return mean - plain[:, 0], failing - mean
