"""Station keeping: fastest perpetual flight, and the share of time that the wind is below it.

An aircraft holds its place if it flies at least as fast as the wind. It may fly faster than its
design, at a lower lift coefficient with more power, as long as the repeated day is perpetual.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from missions.dates import month_and_day
from missions.files.errors import file_error
from missions.mission import Mission, Scenarios
from missions.winds.statistics import WindStatistics
from sizing.aircraft import Aircraft
from sizing.day.light import UNCORRECTED_CAM, SolarDay, SolarModel, solar_day
from sizing.design import Design
from sizing.held_station import held_flight, refuse_measured_aircraft
from sizing.mass_budget import design_of
from sizing.performance import fly
from solar.types import BoolArray, FloatArray

# Largest airspeed over the design's: more needs over 20 times the power.
FASTEST = 3.0
_SPEEDS = 201  # of the table of powers
# Number of halvings of the interval of airspeeds, to 0.01 % of it.
_HALVINGS = 14


@dataclass(frozen=True)
class StationKeeping:
    """Scenarios with their winds and the aircraft's fastest perpetual flight, ``(scenario,)``.

    ``airspeed_m_per_s``: fastest airspeed of perpetual flight, NaN if there is none. ``share``:
    share of the time that the wind is at most that fast, 0 without perpetual flight.
    ``wind_m_per_s``: at the mission's percentile. ``at_end``: whether the airspeed is the fastest
    of the search.
    """

    scenarios: Scenarios
    airspeed_m_per_s: FloatArray
    share: FloatArray
    wind_m_per_s: FloatArray
    at_end: BoolArray


def station_keeping(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    scenarios: Scenarios | None = None,
) -> StationKeeping:
    """Return the share of time that an aircraft holds its place in perpetual flight."""
    statistics = required_winds(aircraft, mission)
    # The airspeed is searched for here.
    update = {"wind_statistics": statistics.model_copy(update={"hold_station": False})}
    mission = mission.model_copy(update=update)
    scenarios = mission.scenarios() if scenarios is None else scenarios
    winds = mission.scenario_winds_m_per_s(scenarios)
    day = solar_day(aircraft, mission, solar, scenarios=scenarios)
    fastest, at_end = _fastest(aircraft, mission, solar, day)
    months = [month_and_day(int(day_of_year))[0] for day_of_year in scenarios.day_of_year]
    table = statistics.table(mission.longitude_deg)
    below = table.share_below(fastest, scenarios.latitude_deg, mission.altitude_m, months)
    share = np.where(np.isfinite(fastest), below, 0.0)
    return StationKeeping(scenarios, fastest, share, winds, at_end)


def required_winds(aircraft: Aircraft, mission: Mission) -> WindStatistics:
    """Return the mission's winds; refuse an aircraft that cannot hold its place against them."""
    refuse_measured_aircraft(aircraft, "station keeping")
    if mission.wind_statistics is None:
        raise file_error(mission.name, "lacks wind: {percentile: ...}, for station keeping")
    return mission.wind_statistics


def faster_flight(
    aircraft: Aircraft, mission: Mission, design: Design
) -> tuple[FloatArray, FloatArray]:
    """Return airspeeds from the design's up, and the least electric power at each or a faster one.

    The power is infinite above the rated power.
    """
    ratio = np.linspace(1.0, FASTEST, _SPEEDS)
    airspeed = np.asarray(design.airspeed_m_per_s, float) * ratio
    power = np.asarray(held_flight(aircraft, mission, design, airspeed).propulsion_power_w)
    least = np.minimum.accumulate(power[::-1])[::-1]
    return airspeed, least


def _fastest(
    aircraft: Aircraft, mission: Mission, solar: SolarModel, day: SolarDay
) -> tuple[FloatArray, BoolArray]:
    """Return the fastest perpetual airspeed of every scenario, and whether it ends the search.

    Power never falls with airspeed, so that the interval between a feasible and an infeasible
    airspeed is halved.
    """
    design = design_of(aircraft, mission)
    airspeeds, powers = faster_flight(aircraft, mission, design)
    highest = int(np.flatnonzero(np.isfinite(powers))[-1])
    count = len(day.scenarios)

    def perpetual(airspeed: FloatArray) -> BoolArray:
        power = np.interp(airspeed, airspeeds, powers)
        faster = design._replace(
            propulsion_power_w=power,
            airspeed_m_per_s=airspeed,
            battery_energy_wh=np.full(count, float(design.battery_energy_wh)),
        )
        perf = fly(aircraft, mission, solar, faster, day, keep_trajectory=False, paired=True)
        return np.asarray(perf.cycle.perpetual)

    low, high = np.full(count, airspeeds[0]), np.full(count, airspeeds[highest])
    flies, at_end = perpetual(low), perpetual(high)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2.0
        good = perpetual(middle)
        low, high = np.where(good, middle, low), np.where(good, high, middle)
    fastest = np.where(at_end, airspeeds[highest], np.where(flies, low, np.nan))
    return fastest, np.asarray(at_end)
