"""The latitude nearest to a mission's at which a design flies perpetually."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from missions.mission import LatitudeRange, Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.performance import Performance, performance_of_designs
from sizing.relaxed_flight import Direction
from sizing.sunlight import SolarModel, solar_day
from solar.types import BoolArray, FloatArray

_STEP_DEG = 0.25
_REACH_DEG = 60.0
_AT_ONCE = 4  # latitudes that are sized together
_STEPS_BEYOND = 3  # where the scenarios left out need a little more


def nearest_latitude(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel,
    nearest: Performance,
    *,
    enough: Callable[[list[Mission]], BoolArray],
    confirmed_h: Callable[[Mission], float | None],
) -> tuple[str, float, Direction, float, float] | None:
    """Key, present value, direction and value of the latitude, and the worst excess time there.

    ``nearest``: design that comes closest, where the mission is. ``enough``: whether missions at
    other latitudes have a design with enough excess time, roughly. ``confirmed_h``: its worst
    excess time; None where it is not enough. Of a band the end that holds back is moved.
    """
    key, latitude = "mission.latitude_deg", mission.latitude_deg
    if isinstance(latitude, LatitudeRange):
        band = latitude
        worst = float(nearest.day.scenarios.latitude_deg[nearest.worst_scenario()])
        at_end = abs(worst - band.to_deg) < abs(worst - band.from_deg)
        present, other = (band.to_deg, band.from_deg) if at_end else (band.from_deg, band.to_deg)
        count = round(abs(other - present) / _STEP_DEG)
        places = np.linspace(present, other, count + 1)[1:-1]
        end = "to_deg" if at_end else "from_deg"
        key = f"{key}.{end}"
    else:
        band, end, present = None, "", latitude
        places = _easier_latitudes(aircraft, mission, solar, nearest)

    def moved(place: float) -> Mission:
        to = place if band is None else band.model_copy(update={end: place})
        return mission.model_copy(update={"latitude_deg": to})

    found = _first_enough(places, moved, enough, confirmed_h)
    if found is None:
        return None
    return key, present, "at most" if found[0] < present else "at least", *found


def _easier_latitudes(
    aircraft: Aircraft, mission: Mission, solar: SolarModel, nearest: Performance
) -> FloatArray:
    """Latitudes from the mission's to where the nearest design does best, in steps."""
    latitude = mission.latitudes()[0]
    reach = np.arange(_STEP_DEG, _REACH_DEG, _STEP_DEG)
    ends = mission.wind_latitudes_deg
    sides = [np.clip(latitude + sign * reach, *ends) for sign in (-1.0, 1.0)]
    tried = np.stack(sides)[:, 3::20]
    days = np.asarray(mission.dates.days(), int)
    scenarios = Scenarios(np.repeat(tried.ravel(), len(days)), np.tile(days, tried.size))
    day = solar_day(aircraft, mission, solar, scenarios=scenarios, step_h=0.5)
    variables = nearest.design.variables.mapped(float)
    perf = performance_of_designs(aircraft, mission, variables, solar, day=day)
    excess = perf.cycle.excess_time_h.reshape(*tried.shape, -1).min(axis=-1)
    side, peak = np.unravel_index(int(np.argmax(excess)), excess.shape)
    return sides[side][: 4 + 20 * int(peak)]


def _first_enough(
    places: FloatArray,
    moved: Callable[[float], Mission],
    enough: Callable[[list[Mission]], BoolArray],
    confirmed_h: Callable[[Mission], float | None],
) -> tuple[float, float] | None:
    """First of the places, ordered from hard to easy, that is enough, and the excess time there.

    The easiest tells whether there is any. Of the others a few are sized at once, and then a few
    between the two that matter.
    """

    def tell(some: FloatArray) -> BoolArray:
        return enough([moved(float(place)) for place in some])

    if not len(places) or not tell(places[-1:])[0]:
        return None
    low, high = -1, len(places) - 1
    while high - low > 1:
        some = np.unique(np.linspace(low + 1, high - 1, _AT_ONCE).round().astype(int))
        first = int(np.argmax([*tell(places[some]), True]))
        if first > 0:
            low = int(some[first - 1])
        if first < len(some):
            high = int(some[first])
    # Next to the edge the sizing of many cells at once may miss a design by minutes.
    for place in places[max(high - 1, 0) : high + _STEPS_BEYOND]:
        worst_h = confirmed_h(moved(float(place)))
        if worst_h is not None:
            return float(place), worst_h
    return None
