"""Season of perpetual flight: the days of the year on which it is possible at a latitude.

The Full Model takes milliseconds for each day. Every eighth day is simulated, and all days between
two of these that differ; a gap or a spell that lies wholly between two equal ones is not seen.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missions.dates import DAYS_PER_YEAR
from missions.mission import SOLSTICES, Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.performance import performance
from sizing.sunlight import SolarDay, SolarModel, Sunlight

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
    known: dict[int, tuple[bool, ...]] = {}

    def simulate(days: Iterable[int]) -> None:
        chosen = np.array(sorted(set(days) - known.keys()), int)
        if not len(chosen):
            return
        scenarios = Scenarios(np.full(len(chosen), float(latitude_deg)), chosen)
        sun = Sunlight(aircraft, mission, scenarios)
        # One march for all models: the simulator sees nothing but their power.
        together = SolarDay.joined([sun.day(model) for model in models])
        perpetual = performance(aircraft, mission, models[0], day=together).cycle.perpetual
        by_day = perpetual.reshape(len(models), len(chosen)).T
        known.update(zip(chosen.tolist(), map(tuple, by_day.tolist()), strict=True))

    simulate([*range(1, DAYS_PER_YEAR + 1, _STRIDE), *SOLSTICES])
    sampled = sorted(known)
    pairs = zip(sampled, [*sampled[1:], sampled[0] + DAYS_PER_YEAR], strict=True)
    edges = [(a, b) for a, b in pairs if known[a] != known[_wrapped(b)]]
    simulate(_wrapped(day) for a, b in edges for day in range(a + 1, b))
    filled, last = [], known[sampled[-1]]
    for day in range(1, DAYS_PER_YEAR + 1):
        last = known.get(day, last)
        filled.append(last)
    return {model: np.array([row[i] for row in filled], bool) for i, model in enumerate(models)}


def _wrapped(day: int) -> int:
    return (day - 1) % DAYS_PER_YEAR + 1
