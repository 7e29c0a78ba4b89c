"""Station keeping: how fast an aircraft flies perpetually, and how often the wind lets it stay.

An aircraft holds its place while the wind is not faster than it flies. It may fly faster than its
design does: at a lower lift coefficient, with more power, as far as the repeated day returns the
energy of the night.
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
from sizing.held_station import held_flight, refuse_one_airspeed
from sizing.mass_budget import design_of
from sizing.performance import fly
from solar.types import BoolArray, FloatArray

# Airspeed over that of the design: more takes over 20 times the power.
FASTEST = 3.0
_SPEEDS = 201
# Halvings of the interval of airspeeds: to 0.01 % of it.
_HALVINGS = 14


@dataclass(frozen=True)
class StationKeeping:
    """Scenarios, their wind and what the aircraft can do against it, arrays of one length.

    ``airspeed_m_per_s``: the fastest at which the repeated day is perpetual, NaN where none is.
    ``share``: of the time in which the wind is at most as fast, 0 where it does not fly
    perpetually. ``wind_m_per_s``: at the mission's percentile. ``at_end``: whether the airspeed is
    the fastest that is considered.
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
    """Share of the time in which an aircraft holds its place while it flies perpetually."""
    given = winds_of(aircraft, mission)
    # How fast it flies is looked for here.
    update = {"wind_statistics": given.model_copy(update={"hold_station": False})}
    mission = mission.model_copy(update=update)
    some = mission.scenarios() if scenarios is None else scenarios
    winds = mission.scenario_winds_m_per_s(some)
    day = solar_day(aircraft, mission, solar, scenarios=some)
    fastest, at_end = _fastest(aircraft, mission, solar, day)
    months = [month_and_day(int(one))[0] for one in some.day_of_year]
    table = given.table(mission.longitude_deg)
    below = table.share_below(fastest, some.latitude_deg, mission.altitude_m, months)
    share = np.where(np.isfinite(fastest), below, 0.0)
    return StationKeeping(some, fastest, share, winds, at_end)


def winds_of(aircraft: Aircraft, mission: Mission) -> WindStatistics:
    """Return the mission's winds; refuse an aircraft that cannot hold its place against them."""
    refuse_one_airspeed(aircraft, "station keeping")
    if mission.wind_statistics is None:
        raise file_error(mission.name, "lacks wind: {percentile: ...}, for station keeping")
    return mission.wind_statistics


def faster_flight(
    aircraft: Aircraft, mission: Mission, design: Design
) -> tuple[FloatArray, FloatArray]:
    """Airspeeds from the design's up, and the least electric power at each or faster.

    What would be slower and take more power is left out: the aircraft may always fly faster than it
    must. Infinite above the rated power.
    """
    ratio = np.linspace(1.0, FASTEST, _SPEEDS)
    airspeed = np.asarray(design.airspeed_m_per_s, float) * ratio
    power = np.asarray(held_flight(aircraft, mission, design, airspeed).propulsion_power_w)
    least = np.minimum.accumulate(power[::-1])[::-1]
    return airspeed, least


def _fastest(
    aircraft: Aircraft, mission: Mission, solar: SolarModel, day: SolarDay
) -> tuple[FloatArray, BoolArray]:
    """Fastest airspeed of a perpetual day in every scenario, and whether nothing faster is known.

    Power never falls with the airspeed, and more load never makes a day perpetual: the interval
    between an airspeed that is and one that is not is halved.
    """
    design = design_of(aircraft, mission)
    airspeeds, powers = faster_flight(aircraft, mission, design)
    highest = int(np.flatnonzero(np.isfinite(powers))[-1])
    count = len(day.scenarios)

    def perpetual(airspeed: FloatArray) -> BoolArray:
        power = np.interp(airspeed, airspeeds, powers)
        flown = design._replace(
            propulsion_power_w=power,
            airspeed_m_per_s=airspeed,
            battery_energy_wh=np.full(count, float(design.battery_energy_wh)),
        )
        perf = fly(aircraft, mission, solar, flown, day, keep_trajectory=False, paired=True)
        return np.asarray(perf.cycle.perpetual)

    low, high = np.full(count, airspeeds[0]), np.full(count, airspeeds[highest])
    flies, at_end = perpetual(low), perpetual(high)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2.0
        good = perpetual(middle)
        low, high = np.where(good, middle, low), np.where(good, high, middle)
    fastest = np.where(at_end, airspeeds[highest], np.where(flies, low, np.nan))
    return fastest, np.asarray(at_end)
