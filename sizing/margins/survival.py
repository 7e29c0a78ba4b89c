"""Sizing for a share of the days of a season, as a weather record has them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from missions.mission import Mission
from missions.weather.light import NODE_STEP_S
from missions.weather.record import Weather
from sizing.aircraft import Aircraft
from sizing.margins.search import Trial, least_step
from sizing.margins.season_flights import Powers, SeasonDays, SeasonFlights, Survival
from sizing.margins.season_search import SeasonSearch, Steps
from sizing.optimisation.infeasibility import least_mission
from sizing.optimisation.problem import SizingProblems
from sizing.optimisation.relaxations import MINIMAL, bisected, relaxations
from sizing.optimisation.search import size_aircraft
from sizing.parameters import catalogue, parameter_value, with_parameter
from sizing.performance import Performance, performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult, SizingStatus, Violation
from sizing.relaxed_flight import Relaxation, rounded
from sizing.sunlight import SolarModel
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
    sizing = _SurvivalSizing(aircraft, mission, objective, solar, weather, survive, progress)
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
        progress: Callable[[int, int], None] | None = None,
    ) -> None:
        self.aircraft, self.objective, self.solar = aircraft, objective, solar
        self.steps = Steps(progress)
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

    def _search(self, aircraft: Aircraft, problems: SizingProblems) -> SeasonSearch:
        fine, coarse = (
            self._flights(step_s, _LEAD_DAYS, aircraft) for step_s in (NODE_STEP_S, _COARSE_STEP_S)
        )
        given = (aircraft, self.mission, self.objective, self.solar)
        return SeasonSearch(*given, fine, coarse, problems, self.steps)

    def run(self, notes: tuple[str, ...]) -> Survived:
        clear = size_aircraft(
            *(self.aircraft, self.mission, self.objective, self.solar),
            required_excess_time_h=0.0,
            problems=self.problems,
        )
        best = self._best()
        if best is None and not self.search.found:
            return Survived(self._nothing(clear), None, self._relaxed_clear(clear))
        shown = best or max(self.search.found, key=lambda one: (one.reached, one.merit))
        survival = Survival(
            *(self.weather, self.mission, self.required),
            days=SeasonDays.of(self.record, Powers.of(shown.design, self.record.days)),
            clear_sky_status=clear.status,
            clear_sky_objective=clear.objective_value,
            clear_sky_days=self._clear_days(clear),
            notes=notes,
        )
        if best is None:
            return Survived(self._failed(shown, survival), survival, tuple(self._changes(shown)))
        return Survived(self._as_asked(best).with_design(self._flown_there(best)), survival, ())

    def _best(self) -> Trial | None:
        """Best design of the search that all days of the record confirm."""
        needed = self.needed
        for _ in range(_CORRECTIONS):
            best = self.search.best(needed)
            if best is None:
                return None
            missing = self.needed - self._days_of(best)
            if missing <= 0:
                return best
            needed = min(needed + missing, len(self.record))
        good = [one for one in self.search.found if self._days_of(one) >= self.needed]
        return max(good, key=lambda one: one.merit, default=None)

    def _days_of(self, one: Trial) -> int:
        """Days that close in all of the record."""
        return int(self.record.that_close(Powers.of(one.design, self.record.days))[0])

    def _clear_days(self, clear: SizingResult) -> SeasonDays | None:
        if clear.design is None:
            return None
        return SeasonDays.of(self.record, Powers.of(clear.design, self.record.days))

    # --- verdicts ----------------------------------------------------------------------------

    def _as_asked(self, one: Trial) -> SizingResult:
        """Result of a trial; the program's day stands for the record's."""
        result = self.search.as_asked(one, self.search.reports)
        active = (DAYS_THAT_CLOSE if " (" in name else name for name in result.active_constraints)
        return replace(result, active_constraints=tuple(dict.fromkeys(active)), optimum=None)

    def _flown_there(self, one: Trial) -> Performance:
        """Design under a clear sky, on the mission's dates at the record's site."""
        return performance_of_designs(self.aircraft, self.mission, one.variables, self.solar)

    def _failed(self, nearest: Trial, survival: Survival) -> SizingResult:
        text = (
            f"{self.needed} of the season's {len(survival.days)} days are out of reach: the best "
            f"design that was found closes {survival.days.that_close}, a share of "
            f"{survival.achieved:.3g}"
        )
        missed = Violation(DAYS_THAT_CLOSE, self.required - survival.achieved, text)
        perf = self._flown_there(nearest)
        return self._as_asked(nearest).without_design(SizingStatus.infeasible, perf, missed)

    def _nothing(self, clear: SizingResult) -> SizingResult:
        """Sizing without any design: that under a clear sky says why."""
        if clear.design is None:
            return clear
        return clear.without_design(SizingStatus.not_converged, clear.simulated)

    def _relaxed_clear(self, clear: SizingResult) -> tuple[Relaxation, ...]:
        if clear.status is not SizingStatus.infeasible:
            return ()
        return tuple(
            relaxations(self.aircraft, self.mission, clear, self.solar, problems=self.problems)
        )

    def _changes(self, nearest: Trial) -> list[Relaxation]:
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
        relaxed = relaxations(self.aircraft, mission, short, self.solar, problems=self.problems)
        flown = (self._flown(one, factors) for one in relaxed if one.parameter not in _OF_THE_SITE)
        return [one for one in flown if one is not None]

    def _wanted_factors(self, nearest: Trial) -> FloatArray | None:
        aircraft = self.aircraft
        for key, one in catalogue().items():
            bound = parameter_value(aircraft, self.mission, key) if one.kind == "bound" else None
            if bound is not None and math.isfinite(bound):
                aircraft = with_parameter(aircraft, self.mission, key, _WIDER * bound)[0]
        best = self._search(aircraft, SizingProblems(aircraft)).best(self.needed)
        if best is not None:
            return best.factors
        count = self.search.counts(nearest, self.search.flights)
        step = least_step(count, (0.0, _MOST_STEPS), self.needed)
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
        best = other.search.trial(factors, Objective.max_excess_time)
        return best is not None and other._days_of(best) >= self.needed
