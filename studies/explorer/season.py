"""Map of the explorer: excess time over latitude and day, with the light kept for the next one.

Light does not depend on the design: it is computed once for each technology of modules, air and
solar power model, and multiplied by the module area. Models that follow the flight path take
milliseconds for each cell; their map is filled a few latitudes at a time.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from math import isfinite
from typing import Any

import numpy as np

from missions.mission import Scenarios
from sizing.day.light import DEFAULT_STEP_H, SolarDay, solar_day
from sizing.design import Design
from sizing.performance import performance
from solar.types import FloatArray
from studies.case import Case
from studies.quantities import EXCESS_TIME

# Excess times are then within 0.05 h in 99 of 100 cells: see docs/explorer.md.
COARSE_STEP_H = 0.25
# Evenly spaced: the page interpolates. A coarse map has every second row and column.
LATITUDES_DEG, DAYS = np.linspace(-90.0, 90.0, 73), np.arange(1, 366, 4)
COARSE_LATITUDES_DEG, COARSE_DAYS = LATITUDES_DEG[::2], DAYS[::2]
_DAYS_ON_PATH = DAYS[::4]
# Keys of the mission that light knows of; the rest of it changes the load alone. Wind turns the
# modules of an aircraft that follows a path.
_KEYS_OF_LIGHT = ("altitude_m", "climb", "air", "clear_sky", "clearness", "uncertainty_margins")
_KEYS_OF_PATH = ("wind_m_per_s", "wind_statistics", "wind_from_deg", "flight_path")
_KEPT = 6  # lights, of 16 MB at most each
# Of filling a slow map, before others have their turn: while a slider moves, and when it rests.
_SHORT_TURN_S, _TURN_S = 0.02, 0.12


@dataclass
class _Light:
    """Light of the rows of a map that are known, in their order; ``None`` before the first."""

    rows: list[int]
    day: SolarDay | None = None

    def add(self, row: int, day: SolarDay) -> None:
        """Take another row."""
        self.rows.append(row)
        self.day = day if self.day is None else SolarDay.joined([self.day, day])


class SeasonMaps:
    """Maps of one aircraft and its variations; the light of the last few is kept."""

    def __init__(self) -> None:
        self._light = lru_cache(_KEPT)(lambda *settings: _Light([]))

    def excess_time(
        self, case: Case, *, coarse: bool, design: Design | None = None
    ) -> dict[str, Any]:
        """Return the excess time of the cells of a map.

        ``case``: what flies, in which air, with which load; the mission's own
        place plays no part. ``coarse``: every second row and column, in steps of a quarter of an
        hour; slow models always have these, and flights with climbs these rows and columns.
        ``design``: of the aircraft on the mission, where it is known already. Returns
        ``latitudes_deg``, ``days``, ``step_h`` and ``excess_time_h``: rows of hours to three
        decimals, null where it is unlimited; a row that is not yet known is null, and so is one
        whose wind nobody knows. ``complete`` says whether there is none of the former.
        """
        aircraft, mission, solar = case.aircraft, case.mission, case.solar
        on_path = solar.needs_path
        few = coarse or mission.climb is not None  # whose march takes as long as four others
        step_h = COARSE_STEP_H if coarse or on_path else DEFAULT_STEP_H
        latitudes = COARSE_LATITUDES_DEG if few or on_path else LATITUDES_DEG
        days = _DAYS_ON_PATH if on_path else COARSE_DAYS if few else DAYS
        # Of an area of modules, filled once for each of its settings.
        modules = aircraft.modules.model_copy(update={"area_m2": 1.0})
        names = _KEYS_OF_LIGHT + (_KEYS_OF_PATH if on_path else ())
        light = self._light(modules, *(getattr(mission, name) for name in names), solar, step_h)
        south, north = solar.latitudes_with_wind_deg(mission)
        known = np.flatnonzero((latitudes >= south) & (latitudes <= north))

        def sunlight_at(latitudes_deg: FloatArray) -> SolarDay:
            latitude, day = np.meshgrid(latitudes_deg, days, indexing="ij")
            cells = Scenarios(latitude.ravel(), day.ravel())
            return solar_day(aircraft, mission, solar, scenarios=cells, step_h=step_h)

        if on_path:
            _fill(light, sunlight_at, known.tolist(), _SHORT_TURN_S if coarse else _TURN_S)
        elif light.day is None:
            light.rows, light.day = known.tolist(), sunlight_at(latitudes[known])
        rows: list[list[float | None] | None] = [None] * len(latitudes)
        flight = performance(
            aircraft, mission, solar, day=light.day, keep_trajectory=False, design=design
        )
        hours = flight.cycle.excess_time_h.reshape(len(light.rows), len(days))
        for row, values in zip(light.rows, hours, strict=True):
            rows[row] = [round(v, 3) if isfinite(v) else None for v in values.tolist()]
        return {
            "latitudes_deg": latitudes.tolist(),
            "days": days.tolist(),
            "step_h": step_h,
            EXCESS_TIME.name: rows,
            "complete": len(light.rows) == len(known),
        }


def _fill(
    light: _Light, sunlight_at: Callable[[FloatArray], SolarDay], known: list[int], turn_s: float
) -> None:
    """Add rows that are missing, as many as a turn allows and at least one."""
    end = time.monotonic() + turn_s
    # Every eighth row first: a part of them covers the whole evenly.
    count = len(COARSE_LATITUDES_DEG)
    for row in dict.fromkeys(n for stride in (8, 4, 2, 1) for n in range(0, count, stride)):
        if row in light.rows or row not in known:
            continue
        light.add(row, sunlight_at(COARSE_LATITUDES_DEG[row : row + 1]))
        if time.monotonic() > end:
            return
