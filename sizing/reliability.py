"""Sizing for a probability: the best design that most draws of the uncertain inputs can fly.

The chance constraint ``P(every scenario has the required excess time) >= reliability`` is met by
margins. Draws differ, for the energy over a day, in two numbers: *income*, what the sun returns
over the load, and *storage*, what the battery holds over the load. A design that is sized with both
lowered to a quantile of the draws withstands most of them. One margin alone saturates: a design
without any margin on the other number fails in half of the draws.

Sizing with fixed margins and assessment by simulation alternate, as in sequential optimisation and
reliability assessment (SORA: Du, X., Chen, W. (2004), Sequential optimization and reliability
assessment method for efficient probabilistic design, J. Mech. Des. 126, 225-233); the step from a
missed probability to another margin is made in the reliability index, its normal score, as in the
performance measure approach (Tu, J., Choi, K. K., Park, Y. H. (1999), A new study on
reliability-based design optimization, J. Mech. Des. 121, 557-564). Other than there, no most
probable point is searched for: thousands of draws are flown instead, so that failures in several
scenarios and by income or storage all count. How the permitted failures are divided between income
and storage is chosen for the best objective.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from statistics import NormalDist

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import DesignVariables, FlightConditions
from sizing.limits import meets_requirements
from sizing.optimisation.infeasibility import least_mission
from sizing.optimisation.objectives import Objective
from sizing.optimisation.problem import SizingProblems
from sizing.optimisation.result import (
    SizingResult,
    SizingStatus,
    Violation,
    objective_value,
    plain_design,
)
from sizing.optimisation.search import size_aircraft
from sizing.optimisation.solver import SolverReport
from sizing.parameters import MISSION_PREFIX, with_parameter
from sizing.performance import Performance, performance_of_designs
from sizing.sunlight import SolarDay, SolarModel, solar_day
from sizing.uncertainty.inputs import SOLAR_MODEL, UncertainInputs, uncertain_inputs
from sizing.uncertainty.propagation import Propagation, check_inputs
from sizing.uncertainty.samples import Proportion, sobol_points
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
_ROW_TOLERANCE = 1e-5  # of requirements, relative: the solver meets them to about 1e-8
_LEAST_SPREAD = 0.003  # of income and storage, where no input moves them

# Keys of what the sizing chooses; distributions with ends of their own do not move with it.
_CHOSEN = {
    "airframe.wingspan_m": "wingspan_m",
    "airframe.aspect_ratio": "aspect_ratio",
    "airframe.aerodynamics.lift_coefficient": "lift_coefficient",
    "battery.mass_kg": "battery_mass_kg",
    "modules.area_m2": "module_area_m2",
    "mission.payload.mass_kg": "payload_mass_kg",
    "mission.payload.power_w": "payload_power_w",
}


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


@dataclass(frozen=True)
class _Trial:
    """A design that was sized with margins, and the share of draws that it withstands."""

    result: SizingResult
    performance: Performance
    reliability: float
    merit: float
    sound: bool


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
        if one.key in _CHOSEN and not hasattr(one.distribution, "relative_sigma"):
            raise ValueError(
                f"{one.key} is chosen by the sizing: uncertainty.inputs.{one.key} must be normal "
                f"or lognormal, around what is chosen (got {one.distribution.distribution})"
            )
    check_inputs(inputs, solar)


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
    search = _ReliableSizing(aircraft, mission, objective, solar, reliability, problems)
    return search.run()


class _ReliableSizing:
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
        self.aircraft, self.mission, self.objective = aircraft, mission, objective
        self.solar, self.required, self.problems = solar, required, problems
        self.day = solar_day(aircraft, mission, solar)
        self.count = len(uncertain_inputs(aircraft, mission, solar))
        self.shares = sobol_points(self.count, SEARCH_SAMPLES, _SEARCH_SEED)
        self.trials: list[_Trial] = []
        self.start: DesignVariables | None = None
        self.telling = np.arange(len(self.day.scenarios))  # scenarios that draws are flown in

    def run(self) -> tuple[SizingResult, Reliability | None]:
        nominal = self._sized_with_margins(self.mission, self.day, self.objective, explain=True)
        if nominal.design is None or nominal.simulated is None:
            return nominal, None
        self.start = nominal.design.variables
        everywhere = self.telling
        self.nominal = found = self._judged(nominal)
        if found.reliability < self.required:
            study, inputs = self._study(found.performance)
            self.telling = np.unique(study.flights(inputs.values(self.shares)).worst).astype(int)
            found = self._search()
        if len(self.telling) < len(everywhere):
            enough = min(found.reliability, self.required)
            self.telling, self.trials = everywhere, [self.nominal]
            found = self._judged(found.result)
            if found.reliability < enough:
                found = self._search()
        result = self._reliable_optimum(found) if self._meets(found) else self._unreachable(found)
        return result, self._verified(found)

    def _meets(self, trial: _Trial) -> bool:
        return trial.sound and trial.reliability >= self.required

    # --- margins ---------------------------------------------------------------------------

    @cached_property
    def _spread(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Median over the nominal value, and standard deviation of the logarithm's lower half."""
        study, inputs = self._study(self.nominal.performance)
        worst = int(np.argmin(self.nominal.performance.cycle.excess_time_h[self.telling]))
        drawn = study.income_and_storage(inputs.values(self.shares), worst)
        plain = {one.key: np.array([one.nominal]) for one in inputs.inputs}
        found = []
        for values, own in zip(drawn, study.income_and_storage(plain, worst), strict=True):
            low, median = np.log(np.percentile(values / own, [10.0, 50.0]))
            sigma = max(float((low - median) / _NORMAL.inv_cdf(0.1)), _LEAST_SPREAD)
            found.append((float(median), sigma))
        return found[0], found[1]

    def _margins(self, share: float, index: float) -> tuple[float, float]:
        """Factors on income and storage whose failures are those of a reliability index."""
        failures = _NORMAL.cdf(-index)
        parts = (share * failures, (1.0 - share) * failures)
        income, storage = (
            math.exp(median + sigma * _NORMAL.inv_cdf(part))
            for (median, sigma), part in zip(self._spread, parts, strict=True)
        )
        return income, storage

    def _search(self) -> _Trial:
        """Best design that is reliable enough; where none is found, the most reliable one."""
        score, steps = 0.0, list(_SHARE_STEPS)
        index, merit = self._on_share(score, _NORMAL.inv_cdf(self.required))
        if math.isinf(merit):
            most, score = self._most_reliable()
            if not self._meets(most):
                return most
            del steps[0]  # near the edge few shares have a design
            index, merit = self._on_share(score, self._index(most.reliability))
            merit = max(merit, most.merit)
        self._try_shares(score, index, merit, steps)
        return max(filter(self._meets, self.trials), key=lambda one: one.merit)

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

    def _most_reliable(self) -> tuple[_Trial, float]:
        """Most reliable design, and the normal score of the share of its failures by income.

        Of the designs that withstand a given income, that of largest excess time withstands the
        lowest storage, whatever is required: one margin leads to all that are worth a flight.
        """
        from scipy.optimize import minimize_scalar

        (median, sigma), _ = self._spread
        found: dict[float, _Trial] = {}

        def failing(deviations: float) -> float:
            """Share of draws that fails with a margin on income of some standard deviations."""
            trial = self._of_largest_excess(math.exp(median - deviations * sigma))
            if trial is None:
                return 1.0
            found[deviations] = trial
            return 1.0 - trial.reliability

        margin, least = 0.0, failing(0.0)
        while (beyond := failing(margin + _INCOME_STEP)) < least:
            margin, least = margin + _INCOME_STEP, beyond
        bounds = (margin - _INCOME_STEP, margin + _INCOME_STEP)
        minimize_scalar(
            failing, bounds=bounds, method="bounded", options={"xatol": _INCOME_TOLERANCE}
        )
        sound = [one for one in (*found.values(), self.nominal) if one.sound]
        most = max(sound, key=lambda one: one.reliability)
        own = [margin for margin, one in found.items() if one is most]
        failures = _NORMAL.cdf(-self._index(most.reliability))
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
            one = self._trial(*self._margins(_NORMAL.cdf(score), index))
            if one is None:
                infeasible, index = index, math.inf
            else:
                if self._meets(one):
                    merit = max(merit, one.merit)
                    if one.reliability - self.required <= self._band:
                        break
                tried.append((index, self._index(one.reliability)))
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

    # --- sizing and flights ----------------------------------------------------------------

    def _trial(self, income: float, storage: float) -> _Trial | None:
        """Design that is sized with margins; None where there is none."""
        capacity = storage * self.mission.uncertainty_margins.battery_capacity
        key = f"{MISSION_PREFIX}uncertainty_margins.battery_capacity"
        _, darker = with_parameter(self.aircraft, self.mission, key, capacity)
        result = self._sized_with_margins(darker, self.day.scaled(income), self.objective)
        return None if result.design is None else self._judged(result)

    def _of_largest_excess(self, income: float) -> _Trial | None:
        """Design of largest excess time with a margin on income; None where none flies."""
        mission = least_mission(self.mission, self.objective)
        free = mission.model_copy(update={"required_excess_time_h": 0.0})
        result = self._sized_with_margins(free, self.day.scaled(income), Objective.max_excess_time)
        return None if result.design is None else self._judged(result)

    def _sized_with_margins(
        self, mission: Mission, day: SolarDay, objective: Objective, *, explain: bool = False
    ) -> SizingResult:
        return size_aircraft(
            *(self.aircraft, mission, objective, self.solar),
            day=day,
            problems=self.problems,
            start=self.start,
            explain=explain,
        )

    def _judged(self, result: SizingResult) -> _Trial:
        """Design without margins in the simulator, and the draws that it withstands."""
        assert result.design is not None
        variables = result.design.variables
        perf = performance_of_designs(
            self.aircraft, self.mission, variables, self.solar, day=self.day
        )
        conditions = FlightConditions.of(self.mission, self.aircraft)
        sound = meets_requirements(self.aircraft, perf.design, conditions, tolerance=_ROW_TOLERANCE)
        value = float(objective_value(self.objective, perf))
        study, inputs = self._study(perf)
        share = float(np.mean(self._flying(study, inputs.values(self.shares))))
        merit = value if self.objective.maximised else -value
        trial = _Trial(result, perf, share, merit, bool(np.all(sound)))
        self.trials.append(trial)
        return trial

    def _study(self, perf: Performance) -> tuple[Propagation, UncertainInputs]:
        """Flights of the draws of a design, and its uncertain inputs."""
        craft, mission = self.aircraft, self.mission
        chosen = perf.design.variables.chosen()
        for key, name in _CHOSEN.items():
            if name in chosen:
                craft, mission = with_parameter(craft, mission, key, float(chosen[name]))
        inputs = uncertain_inputs(craft, mission, self.solar)
        return Propagation(craft, mission, self.solar, day=self.day.at(self.telling)), inputs

    def _flying(self, study: Propagation, values: dict[str, FloatArray]) -> BoolArray:
        """Draws with the required excess time in every scenario."""
        excess_h = study.flights(values).excess_time_h
        return (excess_h > 0.0) & (excess_h >= self.mission.required_excess_time_h)

    # --- verdicts --------------------------------------------------------------------------

    def _verified(self, trial: _Trial) -> Reliability:
        """Reliability by draws that the search has not seen."""
        shares = np.random.default_rng(_VERIFICATION_SEED).random(
            (self.count, VERIFICATION_SAMPLES)
        )
        found = []
        for one in (trial, self.nominal):
            study, inputs = self._study(one.performance)
            found.append(Proportion.of(self._flying(study, inputs.values(shares))))
        merit = self.nominal.merit
        objective = merit if self.objective.maximised else -merit
        return Reliability(self.required, found[0], VERIFICATION_SAMPLES, found[1], objective)

    def _reliable_optimum(self, trial: _Trial) -> SizingResult:
        return replace(
            trial.result,
            objective=self.objective,
            required_excess_time_h=self.mission.required_excess_time_h,
            objective_value=float(objective_value(self.objective, trial.performance)),
            design=plain_design(trial.performance.design),
            simulated=trial.performance,
            solver=self._report(),
        )

    def _unreachable(self, nearest: _Trial) -> SizingResult:
        reached = nearest.reliability
        enough = reached >= self.required  # by a design of largest excess time
        text = (
            f"a reliability of {100 * self.required:g} % is out of reach: the most reliable design "
            f"that was found has {100 * reached:.1f} %"
        )
        missed = Violation("reliability", self.required - reached, text)
        return SizingResult(
            status=SizingStatus.not_converged if enough else SizingStatus.infeasible,
            objective=self.objective,
            required_excess_time_h=self.mission.required_excess_time_h,
            objective_value=None,
            design=None,
            simulated=None,
            nearest=nearest.performance,
            active_constraints=nearest.result.active_constraints,
            violations=() if enough else (missed,),
            solver=self._report(),
        )

    def _report(self) -> SolverReport:
        """Work of all sizings that found a design."""
        reports = [one.solver for one in {id(t.result): t.result for t in self.trials}.values()]
        return SolverReport(
            iterations=sum(one.iterations for one in reports),
            time_s=sum(one.time_s for one in reports),
            build_time_s=sum(one.build_time_s for one in reports),
            solves=sum(one.solves for one in reports),
            message=reports[-1].message,
        )


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
