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
from functools import cached_property, partial
from itertools import count

import numpy as np

from missions.dates import date_label
from missions.files.errors import file_error
from missions.mission import Mission
from missions.weather.light import NODE_STEP_S
from missions.weather.record import Weather
from sizing.day.record import weather_run
from sizing.day.record_conditions import WeatherDays
from sizing.mass_budget import design_of
from sizing.program.margin import MarginCase, Trial, best_of, least_margin
from sizing.program.objectives import Objective, refuse_range
from sizing.program.reliability import with_design
from sizing.program.result import SizingResult, Violation
from solar.types import BoolArray

# What has a smallest or largest design on the edge of closing enough days.
OBJECTIVES = tuple(objective for objective in Objective if objective.of_design)
DAYS_THAT_CLOSE = "days_that_close"
# Of the logarithm of what is taken off the sun: from twice a clear sky to a twentieth of it.
_ENDS = -0.7, 3.0
_TOLERANCE = 1e-3  # of solar energy: some 0.05 % of a wingspan
_POWERS = (0.0, 0.25, 0.5, 1.0)  # of the sun's factor on the battery
_STEPS = 12 * len(_POWERS)  # that it takes, about


def check_survival(objective: Objective, survive: float) -> None:
    """Refuse what no sizing in weather can be."""
    if not 0.0 < survive <= 1.0:
        raise ValueError(
            f"the share of days that close must be above 0 and at most 1 (got {survive:g})"
        )
    why = f"no share of days can be asked of it; allowed: {', '.join(OBJECTIVES)}"
    refuse_range(objective, why)
    if objective not in OBJECTIVES:
        raise ValueError(f"{objective.value} is that of a repeated clear day: {why}")


def in_the_record(mission: Mission) -> Mission:
    """Mission of which clearness and required excess time play no part: the clouds are known."""
    margins = mission.uncertainty_margins.model_copy(update={"clearness_minimum": None})
    return mission.model_copy(
        update={"required_excess_time_h": 0.0, "clearness": 1.0, "uncertainty_margins": margins}
    )


@dataclass(frozen=True)
class SurvivalSizing:
    """Search for the best design for which a share of the days of a season closes.

    ``case``: its mission at the record's site (:func:`missions.weather.files.mission_at_site`), as
    :func:`in_the_record` has it; its dates are the season. ``required``: least share of the
    season's days that close [-]. ``progress``: called with the steps that are done, and in all.
    """

    case: MarginCase
    weather: Weather
    required: float
    progress: Callable[[int, int], None] = lambda done, steps: None

    def run(self) -> tuple[SizingResult, SizingResult, SizingResult | None]:
        """Return outcome, sizing under a clear sky, and the sizing whose days are reported."""
        season, clear, steps = int(np.count_nonzero(self.season)), self.case.plain, count()

        def tried_with(margin: float, power: float) -> Trial | None:
            done = next(steps)
            self.progress(done, max(done, _STEPS))
            result = self.case.sized(math.exp(-margin), math.exp(-margin * power))
            if result.design is None:
                return None
            return Trial(result, int(np.count_nonzero(self.closes(result)[self.season])))

        def surplus(days: float) -> float:
            """Return more or less than nothing: no number of days is on the edge."""
            return days - self.needed + 0.5

        trials = list[Trial]()
        for power in _POWERS:
            trials += least_margin(partial(tried_with, power=power), surplus, _ENDS, _TOLERANCE)
        done = max(next(steps), _STEPS)
        self.progress(done, done)
        if not trials:
            return clear, clear, None
        best, days = best_of(trials, self.needed)
        # Scenarios of the repeated day stand for the season.
        names = (DAYS_THAT_CLOSE if " (" in name else name for name in best.active_constraints)
        active = tuple(dict.fromkeys(names))
        best = replace(best, solver=self.case.solver, active_constraints=active, optimum=None)
        if days >= self.needed:
            return best, clear, best
        text = (
            f"{self.needed} of the season's {season} days are out of reach: the best design that "
            f"was found closes {days:.0f}, a share of {days / season:.3g}"
        )
        missed = Violation(DAYS_THAT_CLOSE, self.required - days / season, text)
        failed = best.without_design(best.simulated, missed)
        return failed, clear, best

    @property
    def needed(self) -> int:
        """Days that must close."""
        return max(1, math.ceil(self.required * np.count_nonzero(self.season) - 1e-9))

    @cached_property
    def days(self) -> WeatherDays:
        """Days of the record."""
        case = self.case
        return WeatherDays.of(
            case.aircraft, case.mission, self.weather, case.solar, step_s=NODE_STEP_S
        )

    @cached_property
    def season(self) -> BoolArray:
        """Which days of the record are the season's."""
        days, dates = self.days.axis.day_of_year, self.case.mission.dates.range()
        season = np.isin(days, dates)
        if not season.any():
            season_ends = dict.fromkeys(date_label(dates[i]) for i in (0, -1))
            first, last = (date_label(int(days[i])) for i in (0, -1))
            raise file_error(
                self.weather.source,
                f"has no day of the season of the mission {self.case.mission.name}, "
                f"{' to '.join(season_ends)}: the record covers {first} to {last} "
                "(set the mission's dates)",
            )
        return season

    def closes(self, result: SizingResult) -> BoolArray:
        """Which days of the record a design closes, flown as by an analysis of its aircraft."""
        assert result.design is not None
        aircraft, mission = with_design(self.case.aircraft, self.case.mission, result.design)
        days = replace(self.days, aircraft=aircraft, mission=mission)
        design = design_of(aircraft, mission)
        return weather_run(days, design, days.load_w(design), days.light.recorded).closes
