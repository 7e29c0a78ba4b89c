"""Flights with climbs beside the flight at the mission's constant altitude.

Surplus power is stored as height by day, and given back in the evening; the heights are those that
the sizing program finds best with the design held (:mod:`sizing.program.schedule`). This is the
energy-height method: Rutowski, E. S. (1954), Energy Approach to the General Aircraft Performance
Problem, J. Aeronaut. Sci. 21 (3). Drag is that of level flight, which shallow paths keep to
(1 - cos of 3 degrees is 0.1 %).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.heights import FlightLevels, checked_climb_limits, flight_levels
from sizing.day.light import FINE_STEP_H, UNCORRECTED_CAM, SolarDay, SolarModel, solar_day
from sizing.design import Design
from sizing.mass_budget import design_of
from sizing.performance import Performance, performance
from solar.types import FloatArray

_SINKS_M = 0.1  # in a step of the day: less is level flight


@dataclass(frozen=True)
class ClimbPerformance:
    """Flight with climbs beside the flight at the mission's constant altitude, in its scenarios."""

    performance: Performance
    constant: Performance

    @property
    def altitude_m(self) -> FloatArray:
        """Return the altitude at the nodes of the day [m], ``(scenario, time)``."""
        assert self.performance.altitude_m is not None
        return self.performance.altitude_m

    @property
    def _levels(self) -> FlightLevels:
        assert self.performance.levels is not None
        return self.performance.levels

    @property
    def gain_h(self) -> FloatArray:
        """Return the excess time that climbing adds [h]; 0 where both are infinite."""
        ours, theirs = self.performance.cycle.excess_time_h, self.constant.cycle.excess_time_h
        unlimited = np.isinf(ours) & np.isinf(theirs)
        return np.where(unlimited, 0.0, ours - np.where(unlimited, 0.0, theirs))

    @property
    def held_up_to_m(self) -> FloatArray | None:
        """Return the altitude up to which the winds are held [m], NaN where not even at the floor.

        None where no place is to be held.
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
        """Return the electric energy that climbs take beyond level flight [Wh]."""
        levels = self._levels
        climbed_m = np.maximum(np.diff(self.altitude_m), 0.0).sum(axis=-1)
        return np.asarray(levels.weight_n * climbed_m / levels.efficiency / 3600.0)

    @property
    def gliding_h(self) -> FloatArray:
        """Return the hours of sinking while the sun does not carry the nominal load [h]."""
        perf = self.performance
        dark = perf.solar_power_w < perf.nominal_load_w[:, np.newaxis]
        sinks = (np.diff(self.altitude_m) < -_SINKS_M) & dark[:, 1:]
        return np.asarray(sinks @ np.diff(perf.day.time_h))


def excess_at_one_minute_h(aircraft: Aircraft, flown: Performance) -> float:
    """Return the excess time of the worst scenario along its heights in steps of a minute [h]."""
    from sizing.program.schedule import flown_along  # CasADi, which level flight does without

    assert flown.altitude_m is not None
    worst, floor_m = flown.worst_scenario(), flown.mission.altitude_m
    one = flown.day.at([worst]).scenarios
    day = solar_day(aircraft, flown.mission, flown.solar, scenarios=one, step_h=FINE_STEP_H)
    levels = flight_levels(aircraft, flown.mission, flown.design, day)
    height_m = np.interp(day.time_h, flown.day.time_h, flown.altitude_m[worst] - floor_m)
    store = flown.store.flat(flown.cycle.status.shape).select(slice(worst, worst + 1))
    along = flown_along(day.time_h, levels, store, height_m[np.newaxis])
    return float(along.cycle.excess_time_h[0])


def climb_performance(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    solar_factor: float = 1.0,
) -> ClimbPerformance:
    """Simulate an aircraft on a mission with ``climb`` in every scenario.

    ``solar_factor``: factor on all solar power, for what an error of the model does. Returns flight
    with climbs, and the flight at the mission's altitude to compare it with.
    """
    if mission.climb is None:
        raise ValueError(f"mission {mission.name} has no climb")
    design = design_of(aircraft, mission)
    checked_climb_limits(aircraft, design)
    day = solar_day(aircraft, mission, solar).scaled(solar_factor)
    flown = performance(aircraft, mission, solar, day=day, design=design)
    return beside_constant(aircraft, flown, design, day)


def beside_constant(
    aircraft: Aircraft, flown: Performance, design: Design, day: SolarDay
) -> ClimbPerformance:
    """Return a flight with climbs beside that of its design at the lowest altitude."""
    lowest = flown.mission.at_altitude(flown.mission.altitude_m)
    constant = performance(aircraft, lowest, flown.solar, day=day, design=design)
    return ClimbPerformance(flown, constant)
