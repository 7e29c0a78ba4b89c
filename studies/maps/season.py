"""Season of perpetual flight: the days of the year on which it is possible at a latitude.

Every eighth day is simulated, and edges between two that differ are bisected, on the assumption
that there is one. Changes wholly between two equal days are missed. A day whose wind is too strong
for the flight path counts as not perpetual.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from missions.dates import DAYS_PER_YEAR
from missions.mission import Mission, Scenarios
from missions.mission.scenarios import SOLSTICES
from sizing.aircraft import Aircraft
from sizing.day.light import SolarDay, SolarModel, Sunlight
from sizing.performance import performance
from solar.types import BoolArray

_STRIDE = 8


@dataclass(frozen=True)
class Season:
    """Number of days of perpetual flight in a year, and the window around the summer solstice.

    ``first`` and ``last``: ends of the unbroken window of ``window_days``, which may cross the
    year's end; None if flight is not perpetual on the solstice, the year's ends if it is on all
    days.
    """

    days: int
    window_days: int
    first: int | None
    last: int | None


def season_of(perpetual: BoolArray, latitude_deg: float) -> Season:
    """Return the season of flags of perpetual flight by day of year, shape ``(365,)``."""
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
) -> dict[SolarModel, BoolArray]:
    """Flag days of perpetual flight by model, each of shape ``(365,)``.

    ``latitude_deg``: replaces the mission's latitude [deg], north positive.
    """
    known: dict[SolarModel, dict[int, bool]] = {model: {} for model in models}
    lacking = {*range(1, DAYS_PER_YEAR + 1, _STRIDE), *SOLSTICES}
    while lacking:
        days = np.array(sorted(lacking))
        scenarios = Scenarios(np.full(len(days), float(latitude_deg)), days)
        for model, flags in _perpetual_by_model(aircraft, mission, scenarios, models).items():
            known[model].update(zip(days.tolist(), flags.tolist(), strict=True))
        lacking = set().union(*map(_middles_of_edges, known.values()))
    every, perpetual = np.arange(1, DAYS_PER_YEAR + 1), {}
    for model, known_flags in known.items():
        days = np.array(sorted(known_flags))
        filled = np.array([known_flags[day] for day in days.tolist()], bool)
        # Every day is as the last known one before.
        perpetual[model] = filled[np.searchsorted(days, every, side="right") - 1]
    return perpetual


def _perpetual_by_model(
    aircraft: Aircraft, mission: Mission, scenarios: Scenarios, models: Sequence[SolarModel]
) -> dict[SolarModel, BoolArray]:
    """Flag perpetual flight in scenarios by model; none where the wind is too strong for a path."""
    sunlight: dict[tuple[bool, ...], Sunlight] = {}  # shared by models of the same days
    suns, flags = [], {model: np.zeros(len(scenarios), bool) for model in models}
    for model in models:
        troubles = model.path_troubles(aircraft, mission, scenarios)
        able = tuple(trouble is None for trouble in troubles)
        if any(able):
            flags[model][list(able)] = True
            there = Scenarios(scenarios.latitude_deg[list(able)], scenarios.day_of_year[list(able)])
            sunlight.setdefault(able, Sunlight(aircraft, mission, there))
            suns.append(sunlight[able].day(model))
    if not suns:
        return flags
    # A model matters to the simulator by its power alone, so all share one march.
    together = SolarDay.joined(suns)
    perpetual = np.zeros(len(together.scenarios), bool)
    if mission.climb is not None:  # level flight is one of the schedules, and known at once
        level = mission.at_altitude(mission.altitude_m)
        perpetual |= performance(
            aircraft, level, day=together, keep_trajectory=False
        ).cycle.sufficient
    if not perpetual.all():
        others = together.at(np.flatnonzero(~perpetual))
        flown = performance(aircraft, mission, day=others, keep_trajectory=False)
        perpetual[~perpetual] = flown.cycle.sufficient
    each = iter(perpetual)
    for of_model in flags.values():
        of_model[of_model] = [next(each) for _ in range(of_model.sum())]
    return flags


def _middles_of_edges(flags: Mapping[int, bool]) -> set[int]:
    """Return the days half-way between neighbouring days with different flags, unless adjacent.

    Neighbours are those across the year's end, too.
    """
    days = sorted(flags)
    pairs = zip(days, [*days[1:], days[0]], strict=True)
    apart = [
        (day, (after - day) % DAYS_PER_YEAR) for day, after in pairs if flags[day] != flags[after]
    ]
    return {(day + count // 2 - 1) % DAYS_PER_YEAR + 1 for day, count in apart if count > 1}
