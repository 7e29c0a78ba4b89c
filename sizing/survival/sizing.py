"""Sizing for a share of the days of a season, as a weather record has them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from missions.mission import Mission
from missions.weather.light import NODE_STEP_S
from missions.weather.record import Weather
from sizing.aircraft import Aircraft
from sizing.optimisation.infeasibility import least_mission
from sizing.optimisation.objectives import Objective
from sizing.optimisation.problem import SizingProblems
from sizing.optimisation.relaxations import MINIMAL, Relaxation, bisected, relaxations, rounded
from sizing.optimisation.result import (
    SizingResult,
    SizingStatus,
    Violation,
    objective_value,
    plain_design,
)
from sizing.optimisation.search import size_aircraft
from sizing.optimisation.solver import SolverReport
from sizing.parameters import catalogue, parameter_value, with_parameter
from sizing.performance import performance_of_designs
from sizing.sunlight import SolarModel
from sizing.survival.contour import least_step
from sizing.survival.flights import SeasonFlights
from sizing.survival.result import SeasonDays, Survival
from sizing.survival.search import Candidate, Steps, SurvivalSearch
from solar.types import FloatArray

# What has a smallest or largest design on the edge of closing enough days.
OBJECTIVES = tuple(one for one in Objective if one.of_design)
DAYS_THAT_CLOSE = "days_that_close"
# Days before the season that the search flies, from a full battery. The answer is of all days.
_LEAD_DAYS = 20
_COARSE_STEP_S = 900.0
_CORRECTIONS = 4  # where all days of the record tell otherwise than the search
# Relaxations of the program's day that are none in a record.
_OF_THE_SITE = ("mission.latitude_deg", "mission.required_excess_time_h")
_FURTHER = (1.0, 4.0, 16.0, 32.0)  # than the program's day says
_WIDER = 4.0  # bounds, to find what is wanted of a design
_MOST_STEPS = 1.5  # logarithm of how far income and storage may be from enough for a relaxation


def check_survival(objective: Objective, survive: float) -> None:
    """Refuse what no sizing in weather can be."""
    if not 0.0 < survive <= 1.0:
        raise ValueError(
            f"the share of days that close must be above 0 and at most 1 (got {survive:g})"
        )
    if objective not in OBJECTIVES:
        what = "counts days or degrees" if objective.of_range else "is that of a repeated clear day"
        raise ValueError(
            f"{objective.value} {what}: no share of days can be asked of it; allowed: "
            f"{', '.join(OBJECTIVES)}"
        )


def in_the_record(mission: Mission) -> Mission:
    """Mission of which clearness and required excess time play no part: the clouds are known."""
    margins = mission.uncertainty_margins.model_copy(update={"clearness_minimum": None})
    return mission.model_copy(
        update={"required_excess_time_h": 0.0, "clearness": 1.0, "uncertainty_margins": margins}
    )


class Survived(NamedTuple):
    """Outcome: the sizing, what its design makes of the record, and what would help."""

    result: SizingResult
    survival: Survival | None
    relaxations: tuple[Relaxation, ...]


def size_surviving(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel,
    *,
    weather: Weather,
    survive: float,
    notes: tuple[str, ...] = (),
    progress: Callable[[int, int], None] | None = None,
) -> Survived:
    """Find the best design for which a share of the days of a season closes.

    ``mission``: at the record's site (:func:`missions.weather.site.mission_at_site`); its dates are
    the season. Its clearness and required excess time play no part. ``survive``: least share of the
    season's days that close [-]. ``notes``: what was changed to fly the mission at the site.
    ``progress``: called with the steps of the search that are done, and those in all. Returns
    without survival where there is no design at all, whatever the sun.
    """
    sizing = _SurvivalSizing(aircraft, mission, objective, solar, weather, survive, Steps(progress))
    return sizing.run(notes)


class _SurvivalSizing:
    def __init__(
        self,
        aircraft: Aircraft,
        mission: Mission,
        objective: Objective,
        solar: SolarModel,
        weather: Weather,
        required: float,
        steps: Steps | None = None,
    ) -> None:
        self.aircraft, self.objective, self.solar, self.steps = aircraft, objective, solar, steps
        self.mission = in_the_record(mission)
        self.weather, self.required = weather, required
        self.problems = SizingProblems(aircraft)
        self.record = self._flights(NODE_STEP_S, None)
        self.needed = max(1, math.ceil(required * len(self.record) - 1e-9))
        self.search = self._search(aircraft, self.problems)

    def _flights(
        self, step_s: float, lead_days: int | None, aircraft: Aircraft | None = None
    ) -> SeasonFlights:
        craft = self.aircraft if aircraft is None else aircraft
        return SeasonFlights.of(
            *(craft, self.mission, self.weather, self.solar), step_s=step_s, lead_days=lead_days
        )

    def _search(self, aircraft: Aircraft, problems: SizingProblems) -> SurvivalSearch:
        fine, coarse = (
            self._flights(step_s, _LEAD_DAYS, aircraft) for step_s in (NODE_STEP_S, _COARSE_STEP_S)
        )
        return SurvivalSearch(
            *(
                aircraft,
                self.mission,
                self.objective,
                self.solar,
                fine,
                coarse,
                problems,
                self.steps,
            )
        )

    def run(self, notes: tuple[str, ...]) -> Survived:
        clear = size_aircraft(
            *(self.aircraft, self.mission, self.objective, self.solar),
            required_excess_time_h=0.0,
            problems=self.problems,
        )
        best = self._best()
        if best is None and not self.search.found:
            return Survived(self._nothing(clear), None, self._relaxed_clear(clear))
        shown = best if best is not None else self._most_days()
        found = Survival(
            *(self.weather, self.mission, self.required),
            days=SeasonDays.of(self.record, shown.powers),
            clear_sky_status=clear.status,
            clear_sky_objective=clear.objective_value,
            clear_sky_days=self._clear_days(clear),
            notes=notes,
        )
        if best is None:
            return Survived(self._failed(shown, found), found, tuple(self._relaxed(shown)))
        return Survived(self._optimal(best), found, ())

    def _best(self) -> Candidate | None:
        """Best design of the search that all days of the record confirm."""
        needed = self.needed
        for _ in range(_CORRECTIONS):
            best = self.search.best(needed)
            if best is None:
                return None
            missing = self.needed - int(self.record.that_close(best.powers)[0])
            if missing <= 0:
                return best
            needed = min(needed + missing, len(self.record))
        good = [o for o in self.search.found if self.record.that_close(o.powers)[0] >= self.needed]
        return min(good, key=lambda one: one.cost, default=None)

    def _most_days(self) -> Candidate:
        return max(self.search.found, key=lambda one: (one.days, -one.cost))

    def _clear_days(self, clear: SizingResult) -> SeasonDays | None:
        if clear.design is None:
            return None
        return SeasonDays.of(self.record, self.search.powers_of(clear.design.variables))

    # --- verdicts ----------------------------------------------------------------------------

    def _optimal(self, best: Candidate) -> SizingResult:
        perf = performance_of_designs(self.aircraft, self.mission, best.variables, self.solar)
        return replace(
            best.result,
            objective=self.objective,
            required_excess_time_h=0.0,
            objective_value=float(objective_value(self.objective, perf)),
            design=plain_design(perf.design),
            simulated=perf,
            active_constraints=_of_the_record(best.result.active_constraints),
            solver=self._report(),
            optimum=None,
        )

    def _failed(self, nearest: Candidate, found: Survival) -> SizingResult:
        perf = performance_of_designs(self.aircraft, self.mission, nearest.variables, self.solar)
        text = (
            f"{self.needed} of the season's {len(found.days)} days are out of reach: the best "
            f"design that was found closes {found.days.that_close}, a share of {found.achieved:.3g}"
        )
        return SizingResult(
            status=SizingStatus.infeasible,
            objective=self.objective,
            required_excess_time_h=0.0,
            objective_value=None,
            design=None,
            simulated=None,
            nearest=perf,
            active_constraints=_of_the_record(nearest.result.active_constraints),
            violations=(Violation(DAYS_THAT_CLOSE, self.required - found.achieved, text),),
            solver=self._report(),
        )

    def _nothing(self, clear: SizingResult) -> SizingResult:
        """Sizing without any design: that under a clear sky says why."""
        if clear.design is None:
            return clear
        return replace(
            clear,
            status=SizingStatus.not_converged,
            objective_value=None,
            design=None,
            simulated=None,
            nearest=clear.simulated,
            optimum=None,
        )

    def _relaxed_clear(self, clear: SizingResult) -> tuple[Relaxation, ...]:
        if clear.status is not SizingStatus.infeasible:
            return ()
        return tuple(
            relaxations(self.aircraft, self.mission, clear, self.solar, problems=self.problems)
        )

    def _relaxed(self, nearest: Candidate) -> list[Relaxation]:
        """What would let a design close enough days: found for the program's day, then flown.

        The program's day has the factors of the best design of a wider design space; where that has
        none either, as much less income and storage as the nearest design lacks.
        """
        factors = self._wanted_factors(nearest)
        if factors is None or self.search.limited:
            return []
        mission, day = self.search.given(factors, least_mission(self.mission, self.objective))
        short = size_aircraft(
            *(self.aircraft, mission, self.objective, self.solar),
            required_excess_time_h=0.0,
            day=day,
            problems=self.problems,
        )
        if short.status is not SizingStatus.infeasible:
            return []
        found = relaxations(self.aircraft, mission, short, self.solar, problems=self.problems)
        flown = (self._flown(one, factors) for one in found if one.parameter not in _OF_THE_SITE)
        return [one for one in flown if one is not None]

    def _wanted_factors(self, nearest: Candidate) -> FloatArray | None:
        aircraft = self.aircraft
        for key, one in catalogue().items():
            bound = parameter_value(aircraft, self.mission, key) if one.kind == "bound" else None
            if bound is not None and math.isfinite(bound):
                aircraft = with_parameter(aircraft, self.mission, key, _WIDER * bound)[0]
        best = self._search(aircraft, SizingProblems(aircraft)).best(self.needed)
        if best is not None:
            return best.factors
        count = self.search.counts(nearest, self.search.flights)
        step = least_step(count, np.ones(2), (0.0, _MOST_STEPS), self.needed)
        return None if math.isnan(step) else nearest.factors - step

    def _flown(self, one: Relaxation, factors: FloatArray) -> Relaxation | None:
        """Relaxation with which a design closes enough days of the record, if it is near.

        The value is moved on from the program's, further and further, and then bisected.
        """

        def suffices(value: float) -> bool:
            return self._closes_enough(one.parameter, value, factors)

        def told(value: float) -> float:
            return rounded(value, one.direction)

        short = one.present
        for further in _FURTHER:
            value = told(one.present + further * (one.value - one.present))
            if suffices(value):
                least = bisected(short, value, suffices, lambda found: MINIMAL * abs(found), told)
                return replace(one, value=least, excess_time_h=math.nan)
            short = value
        return None

    def _closes_enough(self, key: str, value: float, factors: FloatArray) -> bool:
        """Whether the best design with another value of a parameter closes enough days."""
        try:
            aircraft, mission = with_parameter(self.aircraft, self.mission, key, value)
            other = _SurvivalSizing(
                *(aircraft, mission, self.objective, self.solar, self.weather, self.required)
            )
        except (AttributeError, KeyError, ValueError):  # nothing that a file may say
            return False
        best = other.search.candidate(factors, Objective.max_excess_time)
        return best is not None and int(other.record.that_close(best.powers)[0]) >= self.needed

    def _report(self) -> SolverReport:
        """Work of all sizings."""
        reports = self.search.reports
        return SolverReport(
            iterations=sum(one.iterations for one in reports),
            time_s=sum(one.time_s for one in reports),
            build_time_s=sum(one.build_time_s for one in reports),
            solves=sum(one.solves for one in reports),
            message=reports[-1].message,
        )


def _of_the_record(active: tuple[str, ...]) -> tuple[str, ...]:
    """Constraints that hold a design back, those of the program's day by what they stand for."""
    return tuple(dict.fromkeys(DAYS_THAT_CLOSE if " (" in name else name for name in active))
