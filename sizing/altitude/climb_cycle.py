"""Potential-energy storage: climb with surplus power by day, sink back in the evening.

The state is the energy of the battery ``E`` and the potential energy ``W = m g h_e``, with the
energy height ``h_e = h + V^2 / 2g`` above that of level flight at the lowest altitude. With the
solar power ``S``, the constant load ``C`` and the propulsion power of level flight ``R``, all at
the altitude of the moment, and ``eta`` the efficiency of the propulsion:

* Surplus, ``S > C + R``: the battery is charged as fast as it can be. What is left over climbs,
  ``dW/dt = eta P_climb``, up to the propulsion's largest power and the ceiling: once the battery is
  full, or at any time (:class:`missions.mission.Climb`). The rest is not used.
* Deficit, ``S < C + R``, above the lowest altitude: the motor gets ``S - C`` or nothing, and the
  aircraft sinks, ``dW/dt = -eta (R - P_motor)``. The battery gives what the avionics lack.
* Deficit at the lowest altitude: the battery gives it all.

This is the energy-height method: Rutowski, E. S. (1954), Energy Approach to the General Aircraft
Performance Problem, J. Aeronaut. Sci. 21 (3). Drag is that of level flight, which shallow paths
keep to (1 - cos of 3 degrees is 0.1 %). Constant efficiencies do not depend on the load; those of
parts at their operating point do (:mod:`sizing.altitude.climb_chain`).

Solar power and load are piecewise linear in time between the nodes of the day and linear in the
potential energy between levels. A step takes both at the altitude extrapolated to its middle, so
that the error is of second order; at the lowest altitude it is the step of
:mod:`sizing.energy.march`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.altitude.climb_day import ClimbCycle, simulate_climb
from sizing.altitude.climb_levels import ClimbLimits, checked_climb_limits, flight_levels
from sizing.mass_budget import design_of
from sizing.performance import Performance, performance
from sizing.sunlight import UNCORRECTED_CAM, SolarModel, solar_day
from solar.types import FloatArray


@dataclass(frozen=True)
class ClimbPerformance:
    """Flight with climbs beside the flight at the mission's constant altitude.

    ``performance`` has the cycles, solar power and load of the flight with climbs.
    """

    performance: Performance
    constant: Performance
    climb: ClimbCycle
    limits: ClimbLimits

    @property
    def gain_h(self) -> FloatArray:
        """Excess time that climbing adds [h]; 0 where both are infinite."""
        ours, theirs = self.performance.cycle.excess_time_h, self.constant.cycle.excess_time_h
        unlimited = np.isinf(ours) & np.isinf(theirs)
        return np.where(unlimited, 0.0, ours - np.where(unlimited, 0.0, theirs))

    @property
    def held_up_to_m(self) -> FloatArray | None:
        """Altitude up to which the winds are held [m], NaN where not even at the floor.

        None where no place is to be held.
        """
        levels = self.performance.levels
        if levels is None or not self.performance.mission.holds_station:
            return None
        up_to_m = levels.altitude_at(levels.highest_wh[:, np.newaxis])[:, 0]
        return np.where(levels.flies, up_to_m, np.nan)


def climb_performance(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    solar_factor: float = 1.0,
    scenarios: Scenarios | None = None,
) -> ClimbPerformance:
    """Simulate an aircraft on a mission with ``climb`` in every scenario.

    ``solar_factor``: factor on all solar power, for what an error of the model does.
    ``scenarios``: others than the mission's own. Returns flight
    with climbs, and the flight at the mission's altitude to compare it with.
    """
    if mission.climb is None:
        raise ValueError(f"mission {mission.name} has no climb")
    design = design_of(aircraft, mission)
    limits = checked_climb_limits(aircraft, design)
    day = solar_day(aircraft, mission, solar, scenarios=scenarios).scaled(solar_factor)
    lowest = mission.at_altitude(mission.altitude_m)
    constant = performance(aircraft, lowest, solar, day=day, design=design)
    levels = flight_levels(aircraft, mission, design, day)
    store = constant.store.flat((len(day.scenarios),))
    flown = simulate_climb(day.time_h, levels, store, mission.climb.strategy)
    ours = replace(
        constant,
        mission=mission,
        solar_power_w=flown.solar_power_w[:, flown.nodes],
        load_w=flown.load_w[:, flown.nodes],
        cycle=flown.cycle,
        maximum_altitude_m=flown.maximum_altitude_m,
        levels=levels,
    )
    return ClimbPerformance(ours, constant, flown, limits)
