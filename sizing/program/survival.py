"""Sizing for a share of the days of a season, as a weather record has them.

The program finds the best design of repeated clear days with any factor on their solar energy, and
some power of it on the battery; a judge flies it through all days of the record, and the factor is
bisected to the largest with which enough of the season's days close. How dark days are best met, by
modules or by the battery, depends on how they follow each other: the best of a few powers is taken.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from missions.dates import date_label
from missions.files.errors import file_error
from missions.mission import Mission
from missions.weather.light import NODE_STEP_S
from missions.weather.record import Weather
from sizing.day.record import weather_run
from sizing.day.record_conditions import WeatherDays
from sizing.mass_budget import design_of
from sizing.program.margin import MarginSearch, Trial, best_of
from sizing.program.objectives import Objective
from sizing.program.reliability import with_design
from sizing.program.result import SizingResult
from solar.types import BoolArray

# What has a smallest or largest design on the edge of closing enough days.
OBJECTIVES = tuple(objective for objective in Objective if objective.of_design)
DAYS_THAT_CLOSE = "days_that_close"
# Of the logarithm of what is taken off the sun: from twice a clear sky to a twentieth of it.
_ENDS, _STEP = (-0.7, 3.0), 0.7
_TOLERANCE = 1e-3  # of solar energy: some 0.05 % of a wingspan
_POWERS = (0.0, 0.25, 0.5, 1.0)  # of the sun's factor on the battery
_STEPS = 12 * len(_POWERS)  # that it takes, about


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


@dataclass
class SurvivalSizing(MarginSearch):
    """Search for the best design for which a share of the days of a season closes.

    ``mission``: at the record's site (:func:`missions.weather.site.mission_at_site`), as
    :func:`in_the_record` has it; its dates are the season. ``required``: least share of the
    season's days that close [-]. ``progress``: called with the steps that are done, and in all.
    """

    weather: Weather
    required: float
    progress: Callable[[int, int], None] | None = None
    _done: int = 0

    def run(self) -> tuple[SizingResult, SizingResult, SizingResult | None]:
        """Return outcome, sizing under a clear sky, and the sizing whose days are reported."""
        season, clear = int(np.count_nonzero(self.season)), self.plain
        tried = [trial for power in _POWERS if (trial := self._searched(power)) is not None]
        work = sum((trial.result.solver for trial in tried), clear.solver)
        best = best_of(tried)
        self._done = max(self._done, _STEPS)
        self._report(self._done)
        if best is None:
            return clear, clear, None
        best = best._replace(result=replace(best.result, solver=work))
        text = (
            f"{self.needed} of the season's {season} days are out of reach: the best design that "
            f"was found closes {best.reached:.0f}, a share of {best.reached / season:.3g}"
        )
        missed = self.required - best.reached / season
        return best.outcome(DAYS_THAT_CLOSE, missed, text), clear, best.result

    def _searched(self, power: float) -> Trial | None:
        """Return the best design with a power of the sun's factor on the battery."""

        def factors(margin: float) -> tuple[float, float]:
            self._report(self._done + 1)
            self._done += 1
            return math.exp(-margin), math.exp(-margin * power)

        return self.least(factors, _ENDS, _STEP, _TOLERANCE)

    def _report(self, steps: int) -> None:
        if self.progress is not None:
            self.progress(self._done, max(steps, _STEPS))

    def judge(self, result: SizingResult) -> Trial:
        """Count the days of the season that a design closes."""
        active = (DAYS_THAT_CLOSE if " (" in n else n for n in result.active_constraints)
        sizing = replace(result, active_constraints=tuple(dict.fromkeys(active)), optimum=None)
        days = int(np.count_nonzero(self.closes(result)[self.season]))
        return Trial(sizing, days, math.inf if days >= self.needed else -math.inf)

    @property
    def needed(self) -> int:
        """Days that must close."""
        return max(1, math.ceil(self.required * np.count_nonzero(self.season) - 1e-9))

    @cached_property
    def days(self) -> WeatherDays:
        """Days of the record."""
        return WeatherDays.of(
            self.aircraft, self.mission, self.weather, self.solar, step_s=NODE_STEP_S
        )

    @cached_property
    def season(self) -> BoolArray:
        """Which days of the record are the season's."""
        days, dates = self.days.axis.day_of_year, self.mission.dates.range()
        season = np.isin(days, dates)
        if not season.any():
            season_ends = dict.fromkeys(date_label(dates[i]) for i in (0, -1))
            first, last = (date_label(int(days[i])) for i in (0, -1))
            raise file_error(
                self.weather.source,
                f"has no day of the season of the mission {self.mission.name}, "
                f"{' to '.join(season_ends)}: the record covers {first} to {last} "
                "(set the mission's dates)",
            )
        return season

    def closes(self, result: SizingResult) -> BoolArray:
        """Which days of the record a design closes, flown as by an analysis of its aircraft."""
        assert result.design is not None
        aircraft, mission = with_design(self.aircraft, self.mission, result.design)
        days = replace(self.days, aircraft=aircraft, mission=mission)
        design = design_of(aircraft, mission)
        return weather_run(days, design, days.load_w(design), days.light.recorded).closes
