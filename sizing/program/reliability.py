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
from dataclasses import replace
from functools import partial
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel, solar_day
from sizing.design import Design, variable_keys
from sizing.design_space import PROPULSION_VARIABLES, LimitedQuantity
from sizing.limits import meets_requirements
from sizing.parameters import MISSION_PREFIX, with_parameter
from sizing.performance import performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult, SizingStatus, Violation
from sizing.program.size import size_aircraft
from sizing.program.whole_cells import without_whole_cells
from sizing.roots import bisected
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
_CAPACITY = f"{MISSION_PREFIX}uncertainty_margins.battery_capacity"
_MOST_FAILING = 0.95  # of the draws that show the direction
_MOST_TILT = 0.5  # of the margins: none is less than a third of the other
_NO_LOSS = 1e-9  # of an objective by a margin that costs nothing


class Trial(NamedTuple):
    """A design that was sized with a margin, and what a judge finds of it without the margin.

    ``reached``: share of draws, or number of days, that it flies; ``enough``: whether that does.
    """

    result: SizingResult
    reached: float
    enough: bool


# Limits on the battery, by the power of the factor on its storage with which they grow.
_SCALED_LIMITS: dict[LimitedQuantity, float] = {
    "battery_energy_wh": 1.0,
    "cruise_discharge_rate_per_h": -1.0,
    "climb_discharge_rate_per_h": -1.0,
}


def least_margin(
    case: tuple[Aircraft, Mission, Objective, SolarModel],
    near: SizingResult,
    factors: Callable[[float], tuple[float, float]],
    judge: Callable[[SizingResult], Trial],
    ends: tuple[float, float],
    step: float,
    tolerance: float,
) -> Trial | None:
    """Find the design of the least margin that its judge accepts; else the one of most reach.

    ``near``: sizing without a margin. ``factors``: those of a margin on sun and storage; the
    judge's flight and objective are without them. ``ends``: a margin that is not enough, and the
    largest that is tried. ``step``: from the first margin to the next.
    """
    aircraft, mission, objective, solar = case
    day, limits = solar_day(aircraft, mission, solar), aircraft.design_space.all_limits()
    start = None if near.design is None else near.design.variables
    capacity, work, tried = mission.uncertainty_margins.battery_capacity, near.solver, []

    def suffices(margin: float) -> bool:
        nonlocal work
        income, storage = factors(margin)
        # Limits know nothing of the factor, which is no margin of a file: it may exceed 1.
        space = aircraft.design_space
        for name in _SCALED_LIMITS.keys() & limits.keys():
            for end in ("minimum", "maximum"):
                if (value := getattr(limits[name], end)) is not None:
                    space = space.with_limit(name, end, value * storage ** _SCALED_LIMITS[name])
        limited = aircraft.model_copy(update={"design_space": space})
        larger = with_parameter(limited, mission, _CAPACITY, storage * capacity)
        sun = day.scaled(income)
        result = size_aircraft(*larger, objective, solar, day=sun, start=start, explain=False)
        work += result.solver
        if result.design is None:
            return True
        variables = result.design.variables
        flown = performance_of_designs(aircraft, mission, variables, solar, day=day)
        tried.append(judge(result.with_design(flown)))
        return tried[-1].enough

    bisected(ends[0], math.inf, suffices, lambda _: tolerance, step=step, most=ends[1])
    good = [one for one in tried if one.enough]
    best = max(good, key=lambda one: one.result.merit, default=None)
    best = best or max(tried, key=lambda one: one.reached, default=None)
    return best and best._replace(result=replace(best.result, solver=work))


def out_of_reach(trial: Trial, requirement: str, missed: float, text: str) -> SizingResult:
    """Outcome whose nearest design is that of a trial."""
    violation = Violation(requirement, missed, text)
    return trial.result.without_design(SizingStatus.infeasible, trial.result.simulated, violation)


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


def _along(direction: FloatArray, index: float) -> tuple[float, float]:
    """Factors on sun and storage at an index along a direction of their logarithms."""
    income, storage = np.exp(index * direction)
    return float(income), float(storage)


def _weights(losses: FloatArray, reliability: float) -> FloatArray:
    """Weights of the margins on sun and storage, of which the dearer becomes the smaller.

    ``losses``: of the objective by each alone. Along the mean failure both ways to fail have the
    index ``b`` of half of the permitted failures, and the objective is best where more of either
    costs as much for what it gains: ``loss_1 / phi(b (1 + t))`` is ``loss_2 / phi(b (1 - t))``, so
    that ``ln(loss_2 / loss_1)`` is ``2 t b^2``.
    """
    each = NormalDist().inv_cdf((1.0 + reliability) / 2.0)
    income, storage = np.clip(losses, _NO_LOSS, 1.0 / _NO_LOSS)
    tilt = float(np.clip(np.log(storage / income) / (2.0 * each**2), -_MOST_TILT, _MOST_TILT))
    return np.array([1.0 + tilt, 1.0 - tilt])


def size_reliably(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel,
    *,
    reliability: float,
) -> tuple[SizingResult, Reliability | None]:
    """Find the best design that has the required excess time with a given probability.

    ``aircraft``, ``mission``, ``objective``, ``solar``: as for
    :func:`sizing.program.size.size_aircraft`, with uncertain inputs; the mission has the required
    excess time. ``reliability``: least probability of the required excess time in every scenario.
    Returns reliability is None where there is no design even without uncertainty.
    """
    nominal = size_aircraft(aircraft, mission, objective, solar)
    if nominal.design is None or nominal.simulated is None or nominal.objective_value is None:
        return nominal, None
    case, required_h = (aircraft, mission, objective, solar), mission.required_excess_time_h
    profiles = Profiles({}, {})

    def study(result: SizingResult) -> tuple[Propagation, UncertainInputs]:
        """Flights of the draws of a design, along profiles of one alike, and its inputs."""
        assert result.design is not None
        given = *with_design(aircraft, mission, result.design), solar
        return Propagation(*given, profiles=profiles), uncertain_inputs(*given)

    def excess_h(result: SizingResult, shares: FloatArray) -> FloatArray:
        flights, inputs = study(result)
        hours = flights.flights(inputs.values(shares)).excess_time_h
        return np.where(hours > 0.0, hours, -np.inf)

    propagation, inputs = study(nominal)
    shares = sobol_points(len(inputs), SEARCH_SAMPLES, _SEARCH_SEED)

    def judged(result: SizingResult, hours: FloatArray) -> Trial:
        assert result.design is not None
        reached = float(np.mean(hours >= required_h))
        sound = meets_requirements(aircraft, result.design)
        return Trial(result, reached, bool(sound) and reached >= reliability)

    hours = excess_h(nominal, shares)
    trial, spent = judged(nominal, hours), nominal
    if not trial.enough:
        # Income and storage, as logarithms: their mean, and where the draws that fail lie from it.
        worst = int(np.argmin(nominal.simulated.cycle.excess_time_h))
        files = {one.key: np.array([one.nominal]) for one in inputs.inputs}
        drawn, plain = (
            np.log(propagation.income_and_storage(values, worst))
            for values in (inputs.values(shares), files)
        )
        # Where all of them fail, their mean says nothing.
        failing = hours < min(required_h, float(np.quantile(hours, _MOST_FAILING)))
        mean = drawn.mean(axis=1)
        towards = drawn[:, failing].mean(axis=1) - mean

        step = max(NormalDist().inv_cdf(reliability), _LEAST_STEP)
        merits = []
        for alone in np.eye(2) * towards:
            one = least_margin(
                case,
                spent,
                factors=partial(_along, alone),
                judge=lambda result: Trial(result, 0.0, True),
                ends=(0.0, step),
                step=step,
                tolerance=math.inf,
            )
            merits.append(-math.inf if one is None else one.result.merit)
            spent = spent if one is None else replace(spent, solver=one.result.solver)
        towards = towards * _weights(nominal.merit - np.array(merits), reliability)

        def factors(index: float) -> tuple[float, float]:
            income, storage = np.exp(mean - plain[:, 0] + index * towards)
            return float(income), float(storage)

        trial = (
            least_margin(
                case,
                spent,
                factors=factors,
                judge=lambda result: judged(result, excess_h(result, shares)),
                ends=(0.0, _LARGEST_INDEX),
                step=step,
                tolerance=_INDEX_TOLERANCE,
            )
            or trial
        )
    # Draws that the search has not seen.
    fresh = np.random.default_rng(_VERIFICATION_SEED).random((len(inputs), VERIFICATION_SAMPLES))
    achieved, before = (
        Proportion.of(excess_h(one, fresh) >= required_h) for one in (trial.result, nominal)
    )
    value = nominal.objective_value
    verified = Reliability(reliability, achieved, VERIFICATION_SAMPLES, before, value)
    if trial.enough:
        return trial.result, verified
    text = (
        f"a reliability of {100 * reliability:g} % is out of reach: the most reliable design "
        f"that was found has {100 * trial.reached:.1f} %"
    )
    return out_of_reach(trial, "reliability", reliability - trial.reached, text), verified
