"""Season of perpetual flight: the days of the year on which it is possible at a latitude.

The Full Model takes milliseconds for each day. Every eighth day is simulated; between two of these
that differ the edge is found by halving, which takes for granted that there is one. A gap or a
spell that lies wholly between two equal ones is not seen.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missions.dates import DAYS_PER_YEAR
from missions.mission import SOLSTICES, Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.performance import performance
from sizing.sunlight import SolarDay, SolarModel, Sunlight, modelled_power
from solar.names import ModelName
from solar.types import FloatArray

_STRIDE = 8

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Season:
    """Days of perpetual flight in a year: all of them, and those around the summer solstice.

    ``first`` and ``last`` are the ends of the unbroken window of ``window_days`` around the summer
    solstice; the window may cross the year's end. They are none where the solstice itself is not
    flown perpetually, and the year's ends where every day is.
    """

    days: int
    window_days: int
    first: int | None
    last: int | None


def season_of(perpetual: Flags, latitude_deg: float) -> Season:
    """Season from a flag for each day of the year; the solstice is that of the hemisphere.

    ``perpetual``: whether the flight is perpetual on each day of the year. Returns days in all, and
    of the window around the summer solstice.
    """
    total = int(perpetual.sum())
    if total == DAYS_PER_YEAR:
        return Season(total, total, 1, DAYS_PER_YEAR)
    solstice = SOLSTICES[0 if latitude_deg >= 0.0 else 1] - 1
    if not perpetual[solstice]:
        return Season(total, 0, None, None)
    # Seen from the solstice, the first day without perpetual flight on either side.
    after = int(np.argmin(np.roll(perpetual, -solstice)))
    before = int(np.argmin(np.roll(perpetual, -solstice - 1)[::-1]))
    first, last = (solstice - before + 1), (solstice + after - 1)
    return Season(total, last - first + 1, first % DAYS_PER_YEAR + 1, last % DAYS_PER_YEAR + 1)


def perpetual_flags(
    aircraft: Aircraft, mission: Mission, latitude_deg: float, models: Sequence[SolarModel]
) -> dict[SolarModel, Flags]:
    """For each model, on which of the 365 days of the year the aircraft can fly perpetually.

    ``latitude_deg``: latitude [deg], north positive, instead of the mission's own. Returns for each
    model an array of bool, shape ``(365,)``.
    """
    known: list[dict[int, bool]] = [{} for _ in models]
    powers: _Powers = {}

    def simulate(wanted: Sequence[set[int]]) -> None:
        asked = [(number, sorted(days)) for number, days in enumerate(wanted) if days]
        # One march for all models: the simulator sees nothing but their power.
        together = SolarDay.joined(
            [
                _SunlightOfYear(aircraft, mission, latitude_deg, days, powers).day(models[number])
                for number, days in asked
            ]
        )
        flown = performance(aircraft, mission, models[0], day=together, keep_trajectory=False)
        flags = iter(flown.cycle.perpetual.tolist())
        for number, days in asked:
            known[number].update((day, next(flags)) for day in days)

    simulate([{*range(1, DAYS_PER_YEAR + 1, _STRIDE), *SOLSTICES}] * len(models))
    while any(halves := [_middles_of_edges(days) for days in known]):
        simulate(halves)
    return {model: _filled(days) for model, days in zip(models, known, strict=True)}


_Powers = dict[tuple[ModelName, int], FloatArray]


class _SunlightOfYear(Sunlight):
    """Sunlight on days of the year at a latitude; a day's power by a model is computed once."""

    def __init__(
        self,
        aircraft: Aircraft,
        mission: Mission,
        latitude_deg: float,
        days: Sequence[int],
        known: _Powers,
    ) -> None:
        latitudes = np.full(len(days), float(latitude_deg))
        super().__init__(aircraft, mission, Scenarios(latitudes, np.array(days, int)))
        self._days, self._known = days, known

    def modelled_power(self, model: ModelName) -> FloatArray:
        """Uncorrected specific power [W/m2], shape ``(day, time)``."""
        known, lacking = self._known, [d for d in self._days if (model, d) not in self._known]
        if lacking:
            scenarios = Scenarios(self.scenarios.latitude_deg[: len(lacking)], np.array(lacking))
            powers = modelled_power(self.aircraft, self.mission, model, scenarios, self.time_h)
            known.update(((model, day), power) for day, power in zip(lacking, powers, strict=True))
        return np.stack([known[model, day] for day in self._days])


def _middles_of_edges(flown: Mapping[int, bool]) -> set[int]:
    """Days half-way between two neighbours, one of which is flown perpetually and one not."""
    days = sorted(flown)
    pairs = itertools.pairwise([*days, days[0] + DAYS_PER_YEAR])
    edges = [(a, b) for a, b in pairs if flown[a] != flown[_wrapped(b)] and b - a > 1]
    return {_wrapped((a + b) // 2) for a, b in edges}


def _filled(flown: Mapping[int, bool]) -> Flags:
    """Flag of every day: that of the last known one."""
    days = np.array(sorted(flown))
    flags = np.array([flown[day] for day in days.tolist()], bool)
    return flags[np.searchsorted(days, np.arange(1, DAYS_PER_YEAR + 1), side="right") - 1]


def _wrapped(day: int) -> int:
    return (day - 1) % DAYS_PER_YEAR + 1
