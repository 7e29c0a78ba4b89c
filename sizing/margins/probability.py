"""Sizing for a probability: the best design that most draws of the uncertain inputs can fly.

The chance constraint ``P(every scenario has the required excess time) >= reliability`` is met by
margins. Draws differ, for the energy over a day, in income and storage. A design that is sized with
both lowered to a quantile of the draws withstands most of them. One margin alone saturates: a
design without any margin on the other number fails in half of the draws.

The step from a missed probability to another margin is made in the reliability index, its normal
score, as in the performance measure approach (Tu, J., Choi, K. K., Park, Y. H. (1999), A new study
on reliability-based design optimization, J. Mech. Des. 121, 557-564). Other than there, no most
probable point is searched for: thousands of draws are flown instead, so that failures in several
scenarios and by income or storage all count. How the permitted failures are divided between income
and storage is chosen for the best objective.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from statistics import NormalDist

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import Design, DesignVariables, variable_keys
from sizing.design_space import PROPULSION_VARIABLES
from sizing.margins.search import MarginSearch, Trial
from sizing.optimisation.problem import SizingProblems
from sizing.optimisation.search import size_aircraft
from sizing.parameters import with_parameter
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult, SizingStatus, Violation
from sizing.sunlight import SolarModel, solar_day
from sizing.uncertainty.inputs import (
    SOLAR_MODEL,
    Proportion,
    UncertainInputs,
    sobol_points,
    uncertain_inputs,
)
from sizing.uncertainty.propagation import Propagation, check_inputs
from solar.types import BoolArray, FloatArray

_NORMAL = NormalDist()
SEARCH_SAMPLES = 8192
VERIFICATION_SAMPLES = 10_000
_SEARCH_SEED, _VERIFICATION_SEED = 20_040, 1_999  # any two that differ
# Steps of the search for the share of the permitted failures that income has, as a normal score;
# storage has the rest.
_SHARE_STEPS = (0.84, 0.42, 0.21)
_SHARE_GAIN = 1e-3  # of the objective, relative, that another share must promise
_LEAST_SHARE = 0.005
_TRIALS = 10  # of a share
_BAND = 0.06  # of the permitted failures, that may be left unused
_INFEASIBLE_STEP = 0.4  # of the reliability index
# Moves the probability by less than the search's draws leave open, whatever it is.
_LEAST_STEP = 0.01
_INCOME_STEP = 1.0  # of the margin on income, in standard deviations: brackets the most reliable
_INCOME_TOLERANCE = 0.25  # of that margin: at the summit it moves the probability by 0.1 %
_STEEPEST = 2.5  # rise of the reliability index with that of the margins
_LEAST_SPREAD = 0.003  # of income and storage, where no input moves them


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
    inputs = uncertain_inputs(aircraft, mission, solar)
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


def size_reliably(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel,
    *,
    reliability: float,
    problems: SizingProblems,
) -> tuple[SizingResult, Reliability | None]:
    """Find the best design that has the required excess time with a given probability.

    ``aircraft``, ``mission``, ``objective``, ``solar``: as for
    :func:`sizing.optimisation.search.size_aircraft`, with uncertain inputs; the mission has the
    required excess time. ``reliability``: least probability of the required excess time in every
    scenario [-]. Returns reliability is None where there is no design even without uncertainty.
    """
    return _ReliableSizing(aircraft, mission, objective, solar, reliability, problems).run()


class _ReliableSizing(MarginSearch):
    """Search for the margins of the best design that is reliable enough."""

    def __init__(
        self,
        aircraft: Aircraft,
        mission: Mission,
        objective: Objective,
        solar: SolarModel,
        required: float,
        problems: SizingProblems,
    ) -> None:
        day = solar_day(aircraft, mission, solar)
        super().__init__(aircraft, mission, objective, solar, day, problems)
        self.required = required
        self.count = len(uncertain_inputs(aircraft, mission, solar))
        self.shares = sobol_points(self.count, SEARCH_SAMPLES, _SEARCH_SEED)
        self.start: DesignVariables | None = None
        self.telling = np.arange(len(self.day.scenarios))  # scenarios that draws are flown in

    def run(self) -> tuple[SizingResult, Reliability | None]:
        nominal = size_aircraft(
            *(self.aircraft, self.mission, self.objective, self.solar),
            day=self.day,
            problems=self.problems,
        )
        if nominal.design is None:
            return nominal, None
        self.start = nominal.design.variables
        everywhere = self.telling
        self.nominal = trial = self.judged(nominal, np.zeros(2))
        if trial.reached < self.required:
            study, inputs = self._study(trial.design)
            self.telling = np.unique(study.flights(inputs.values(self.shares)).worst).astype(int)
            trial = self._search()
        if len(self.telling) < len(everywhere):
            enough = min(trial.reached, self.required)
            self.telling, self.tried = everywhere, [self.nominal]
            trial = self.judged(trial.result, trial.factors)
            if trial.reached < enough:
                trial = self._search()
        return self._verdict(trial), self._verified(trial)

    def _meets(self, trial: Trial) -> bool:
        return trial.sound and trial.reached >= self.required

    # --- margins ---------------------------------------------------------------------------

    @cached_property
    def _margin_spread(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Median over the nominal value, and standard deviation of the logarithm's lower half."""
        study, inputs = self._study(self.nominal.design)
        worst = int(np.argmin(self.nominal.performance.cycle.excess_time_h[self.telling]))
        drawn = study.income_and_storage(inputs.values(self.shares), worst)
        plain = {one.key: np.array([one.nominal]) for one in inputs.inputs}
        trials = []
        for values, own in zip(drawn, study.income_and_storage(plain, worst), strict=True):
            low, median = np.log(np.percentile(values / own, [10.0, 50.0]))
            sigma = max(float((low - median) / _NORMAL.inv_cdf(0.1)), _LEAST_SPREAD)
            trials.append((float(median), sigma))
        return trials[0], trials[1]

    def _margins(self, share: float, index: float) -> list[float]:
        """Factors on income and storage, as logarithms, that fail as a reliability index does."""
        failures = _NORMAL.cdf(-index)
        parts = (share * failures, (1.0 - share) * failures)
        return [
            median + sigma * _NORMAL.inv_cdf(part)
            for (median, sigma), part in zip(self._margin_spread, parts, strict=True)
        ]

    def _search(self) -> Trial:
        """Best design that is reliable enough; where none is found, the most reliable one."""
        score, steps = 0.0, list(_SHARE_STEPS)
        index, merit = self._on_share(score, _NORMAL.inv_cdf(self.required))
        if math.isinf(merit):
            most, score = self._most_reliable()
            if not self._meets(most):
                return most
            del steps[0]  # near the edge few shares have a design
            index, merit = self._on_share(score, self._index(most.reached))
            merit = max(merit, most.merit)
        self._try_shares(score, index, merit, steps)
        best = self.best_of_tried(self.required)
        assert best is not None
        return best

    def _try_shares(self, score: float, index: float, merit: float, steps: Sequence[float]) -> None:
        """Move the share of income to where the merit is best, by ever smaller steps."""
        for step in steps:
            beside = []
            for side in (score - step, score + step):
                _, other = self._on_share(side, index)
                beside.append(other)
                if other > merit:
                    score, merit = side, other
                    break
            else:
                # The summit of a parabola through the three is higher by at most an eighth of what
                # the lower neighbour lacks.
                if (merit - min(beside)) / 8.0 < _SHARE_GAIN * abs(merit):
                    break

    def _most_reliable(self) -> tuple[Trial, float]:
        """Most reliable design, and the normal score of the share of its failures by income.

        Of the designs that withstand a given income, that of largest excess time withstands the
        lowest storage, whatever is required: one margin leads to all that are worth a flight.
        """
        from scipy.optimize import minimize_scalar

        (median, sigma), _ = self._margin_spread
        trials: dict[float, Trial] = {}

        def failing(deviations: float) -> float:
            """Share of draws that fails with a margin on income of some standard deviations."""
            income = median - deviations * sigma
            trial = self.trial([income, 0.0], Objective.max_excess_time, self.start)
            if trial is None:
                return 1.0
            trials[deviations] = trial
            return 1.0 - trial.reached

        margin, least = 0.0, failing(0.0)
        while (beyond := failing(margin + _INCOME_STEP)) < least:
            margin, least = margin + _INCOME_STEP, beyond
        bounds = (margin - _INCOME_STEP, margin + _INCOME_STEP)
        minimize_scalar(
            failing, bounds=bounds, method="bounded", options={"xatol": _INCOME_TOLERANCE}
        )
        sound = [one for one in (*trials.values(), self.nominal) if one.sound]
        most = max(sound, key=lambda one: one.reached)
        own = [margin for margin, one in trials.items() if one is most]
        failures = _NORMAL.cdf(-self._index(most.reached))
        by_income = _NORMAL.cdf(-own[0]) / failures if own else 0.5
        return most, _NORMAL.inv_cdf(min(max(by_income, _LEAST_SHARE), 1.0 - _LEAST_SHARE))

    def _on_share(self, score: float, index: float) -> tuple[float, float]:
        """Reliability index of the margins that just do, and the merit that they leave.

        Secants in the reliability index; where the margins leave no design, half the way back.
        """
        wanted = _NORMAL.inv_cdf(self.required + 0.5 * self._band)
        tried: list[tuple[float, float]] = []
        infeasible, merit = math.inf, -math.inf
        for _ in range(_TRIALS):
            one = self.trial(self._margins(_NORMAL.cdf(score), index), start=self.start)
            if one is None:
                infeasible, index = index, math.inf
            else:
                if self._meets(one):
                    merit = max(merit, one.merit)
                    if one.reached - self.required <= self._band:
                        break
                tried.append((index, self._index(one.reached)))
                index = _next_index(tried, wanted)
            if index < infeasible:
                continue
            if not tried:
                index = infeasible - _INFEASIBLE_STEP
                continue
            highest, reached = max(tried)
            step = (infeasible - highest) / 2.0
            index = highest + step
            if step < _LEAST_STEP or reached + 2.0 * _STEEPEST * step < wanted:
                break  # the margins that would do leave no design
        return index, merit

    @property
    def _band(self) -> float:
        """What may be left unused: no more than the draws themselves leave open."""
        failures = 1.0 - self.required
        return min(_BAND * failures, math.sqrt(self.required * failures / self.shares.shape[1]))

    def _index(self, reliability: float) -> float:
        least = 0.5 / self.shares.shape[1]
        return _NORMAL.inv_cdf(min(max(reliability, least), 1.0 - least))

    # --- flights ---------------------------------------------------------------------------

    def reached(self, design: Design) -> float:
        """Share of the draws that a design withstands."""
        study, inputs = self._study(design)
        return float(np.mean(self._flying(study, inputs.values(self.shares))))

    def _study(self, design: Design) -> tuple[Propagation, UncertainInputs]:
        """Flights of the draws of a design, and its uncertain inputs."""
        aircraft, mission = self.aircraft, self.mission
        chosen = design.variables.chosen()
        if (propulsion := aircraft.propulsion_by_parts) is not None:
            aircraft = aircraft.with_airframe(
                propulsion=propulsion.sized(*design.variables.of_propulsion)
            )
        for key, name in variable_keys().items():
            if name in chosen and name not in PROPULSION_VARIABLES:
                aircraft, mission = with_parameter(aircraft, mission, key, float(chosen[name]))
        inputs = uncertain_inputs(aircraft, mission, self.solar)
        return Propagation(aircraft, mission, self.solar, day=self.day.at(self.telling)), inputs

    def _flying(self, study: Propagation, values: dict[str, FloatArray]) -> BoolArray:
        """Draws with the required excess time in every scenario."""
        excess_h = study.flights(values).excess_time_h
        return (excess_h > 0.0) & (excess_h >= self.mission.required_excess_time_h)

    # --- verdicts --------------------------------------------------------------------------

    def _verified(self, trial: Trial) -> Reliability:
        """Reliability by draws that the search has not seen."""
        shares = np.random.default_rng(_VERIFICATION_SEED).random(
            (self.count, VERIFICATION_SAMPLES)
        )
        trials = []
        for one in (trial, self.nominal):
            study, inputs = self._study(one.design)
            trials.append(Proportion.of(self._flying(study, inputs.values(shares))))
        merit = self.nominal.merit
        objective = merit if self.objective.maximised else -merit
        return Reliability(self.required, trials[0], VERIFICATION_SAMPLES, trials[1], objective)

    def _verdict(self, trial: Trial) -> SizingResult:
        """Optimum, or that the most reliable design that was found is not reliable enough."""
        # Work of all sizings that found a design.
        reports = [one.solver for one in {id(t.result): t.result for t in self.tried}.values()]
        result = self.as_asked(trial, reports)
        if self._meets(trial):
            return result.with_design(trial.performance)
        reached = trial.reached
        if reached >= self.required:  # by a design of largest excess time
            return result.without_design(SizingStatus.not_converged, trial.performance)
        text = (
            f"a reliability of {100 * self.required:g} % is out of reach: the most reliable design "
            f"that was found has {100 * reached:.1f} %"
        )
        missed = Violation("reliability", self.required - reached, text)
        return result.without_design(SizingStatus.infeasible, trial.performance, missed)


def _next_index(tried: list[tuple[float, float]], wanted: float) -> float:
    """Index of margins from those that were tried: between two on either side, or by a secant.

    Margins and the flights' reliability index rise together, about one to one.
    """
    below = max((one for one in tried if one[1] < wanted), default=None)
    above = min((one for one in tried if one[1] >= wanted), default=None)
    if below is not None and above is not None and above[0] > below[0]:
        (low, at_low), (high, at_high) = below, above
        part = (wanted - at_low) / (at_high - at_low)
        return low + min(max(part, 0.1), 0.9) * (high - low)
    index, found = tried[-1]
    slope = 1.0
    if len(tried) > 1 and tried[-2][0] != index:
        slope = (found - tried[-2][1]) / (index - tried[-2][0])
    return index + (wanted - found) / min(max(slope, 0.4), _STEEPEST)
