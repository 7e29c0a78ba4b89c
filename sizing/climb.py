"""Flights with climbs, compared with flight at the mission's constant altitude.

Excess power is stored as height by day, and used in the evening; the height profile is optimal for
the design (:mod:`sizing.program.schedule`). This is the energy-height method: Rutowski, E. S.
(1954), Energy Approach to the General Aircraft Performance Problem, J. Aeronaut. Sci. 21 (3). Drag
is that of level flight, which holds for shallow paths (1 - cos of 3 degrees is 0.1 %).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sizing.aircraft import Aircraft
from sizing.day.heights import FlightLevels, flight_levels
from sizing.day.light import FINE_STEP_H, solar_day
from sizing.performance import Performance, performance
from solar.types import FloatArray

_SINKS_M = 0.1  # least loss of height in a step of the day that counts as sinking


@dataclass(frozen=True)
class ClimbPerformance:
    """Flight with climbs and flight at the mission's constant altitude, in its scenarios."""

    performance: Performance
    constant: Performance

    @property
    def altitude_m(self) -> FloatArray:
        """Return the altitude at the nodes of the day [m], ``(scenario, time)``."""
        assert self.performance.altitude_m is not None
        return self.performance.altitude_m

    @property
    def maximum_altitude_m(self) -> FloatArray:
        """Return the highest altitude of the day [m]."""
        return np.asarray(self.altitude_m.max(axis=-1))

    @property
    def ceiling_m(self) -> float:
        """Return the ceiling of the mission's climbs [m]."""
        return self.performance.mission.ceiling_m

    @property
    def constant_altitude_excess_time_h(self) -> FloatArray:
        """Return the excess time at the constant altitude [h]."""
        return self.constant.cycle.excess_time_h

    @property
    def dawn_altitude_m(self) -> FloatArray:
        """Return the altitude at equal power in the morning, or at midnight without one [m]."""
        time_h, dawns_h = self.performance.day.time_h, self.performance.cycle.equal_power_morning_h
        ways = zip(np.nan_to_num(dawns_h), self.altitude_m, strict=True)
        return np.array([np.interp(dawn_h, time_h, altitude_m) for dawn_h, altitude_m in ways])

    @property
    def _levels(self) -> FlightLevels:
        assert self.performance.levels is not None
        return self.performance.levels

    @property
    def gain_in_excess_time_h(self) -> FloatArray:
        """Gain of excess time by climbing [h]; 0 where both are infinite."""
        ours, theirs = self.performance.cycle.excess_time_h, self.constant.cycle.excess_time_h
        unlimited = np.isinf(ours) & np.isinf(theirs)
        return np.where(unlimited, 0.0, ours - np.where(unlimited, 0.0, theirs))

    @property
    def held_up_to_m(self) -> FloatArray | None:
        """Altitude up to which the aircraft holds its place against the wind [m].

        NaN if it cannot at the floor, None if the mission holds no place.
        """
        levels = self._levels
        if not self.performance.mission.holds_station:
            return None
        return np.where(levels.flies, levels.altitude_m[0] + levels.reach_m, np.nan)

    @property
    def stored_height_wh(self) -> FloatArray:
        """Return the largest potential energy above the lowest altitude [Wh]."""
        levels = self._levels
        height_m = self.altitude_m.max(axis=-1) - levels.altitude_m[0]
        return np.asarray(levels.weight_n * height_m / 3600.0)

    @property
    def climb_energy_wh(self) -> FloatArray:
        """Electric energy of climbs beyond level flight [Wh]."""
        levels = self._levels
        climbed_m = np.maximum(np.diff(self.altitude_m), 0.0).sum(axis=-1)
        return np.asarray(levels.weight_n * climbed_m / levels.efficiency / 3600.0)

    @property
    def gliding_h(self) -> FloatArray:
        """Duration of sinking while solar power is below the nominal load [h]."""
        perf = self.performance
        dark = perf.solar_power_w < perf.nominal_load_w[:, np.newaxis]
        sinks = (np.diff(self.altitude_m) < -_SINKS_M) & dark[:, 1:]
        return np.asarray(sinks @ np.diff(perf.day.time_h))


@dataclass(frozen=True)
class ClimbOfDay:
    """Climbs of a scenario: its element of what :class:`ClimbPerformance` has of all."""

    climbs: ClimbPerformance
    index: int

    def __getattr__(self, name: str) -> Any:
        value = getattr(self.climbs, name)
        return float(value[self.index]) if isinstance(value, np.ndarray) else value


def fine_step_excess_time_h(aircraft: Aircraft, perf: Performance) -> float:
    """Return the critical scenario's excess time on the same heights by minute steps [h]."""
    from sizing.program.schedule import flown_along  # imports CasADi

    assert perf.altitude_m is not None
    worst, floor_m = perf.worst_scenario(), perf.mission.altitude_m
    scenarios = perf.day.at([worst]).scenarios
    day = solar_day(aircraft, perf.mission, perf.solar, scenarios=scenarios, step_h=FINE_STEP_H)
    levels = flight_levels(aircraft, perf.mission, perf.design, day)
    height_m = np.interp(day.time_h, perf.day.time_h, perf.altitude_m[worst] - floor_m)
    store = perf.store.flat(perf.cycle.status.shape).select(slice(worst, worst + 1))
    along = flown_along(day.time_h, levels, store, height_m[np.newaxis])
    return float(along.cycle.excess_time_h[0])


def compare_with_constant(aircraft: Aircraft, perf: Performance) -> ClimbPerformance:
    """Return flights with climbs, and their design's flights at the lowest altitude."""
    lowest = perf.mission.at_altitude(perf.mission.altitude_m)
    constant = performance(aircraft, lowest, perf.solar, day=perf.day, design=perf.design)
    return ClimbPerformance(perf, constant)
