"""Ceiling of perpetual flight: excess time over altitude.

Each flight stays at its altitude by day and night, in the same weather
(:meth:`missions.mission.Mission.at_altitude`). Thin air needs more power, but has more sunlight and
colder modules: feasibility need not be monotone. The altitudes are scanned, and the highest change
from feasible to infeasible is refined. A feasible band narrower than the scan's step may be missed.

For a mission with climbs the altitude is the night's floor; the ceiling of its climbs stays, and
bounds the floor.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from missions.air import MAXIMUM_ALTITUDE_M
from missions.files.errors import InputError
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import UNCORRECTED_CAM, SolarModel
from sizing.mass_budget import ImpossibleDesignError, operating_reason, operating_trouble
from sizing.performance import performance
from sizing.validity.extrapolations import extrapolations
from sizing.validity.ranges import Extrapolation
from solar.schema import Allowed, refusal, spell
from solar.types import FloatArray

# Default end of a search; missions near it search to the end of the atmosphere.
_HIGHEST_M, _NEAR_M = 20000.0, 5000.0
DEFAULT_STEP_M = 250.0  # of the scan
_RESOLUTION_M = 0.1  # of the ceiling
# Bound of excess time in the search for roots, where it is infinite.
_FAR_H = 1000.0
HOPELESS_H = -24.0  # excess time of an aircraft that cannot carry itself

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class AltitudeFlight:
    """Flight at an altitude in its critical scenario.

    Power is electric; ``airspeed_m_per_s`` is NaN where unknown. For an aircraft that cannot carry
    itself all values but altitude, air density and excess time (-24 h) are NaN. Module temperature
    is that of the mission, NaN for a heat balance. ``extrapolations`` are the quantities outside
    the range of a model, ``reason`` is why it cannot fly there. ``maximum_altitude_m`` is the
    highest altitude of the day, None without climbs; all other values but those of the cycle are at
    the night's floor.
    """

    altitude_m: float
    excess_time_h: float
    minimum_state_of_charge: float = math.nan
    propulsion_power_w: float = math.nan
    solar_energy_wh: float = math.nan
    load_energy_wh: float = math.nan
    airspeed_m_per_s: float = math.nan
    density_kg_per_m3: float = math.nan
    module_temperature_c: float = math.nan
    worst_scenario: int = 0
    extrapolations: tuple[Extrapolation, ...] = ()
    reason: str = ""
    maximum_altitude_m: float | None = None


@dataclass(frozen=True)
class PerpetualCeiling:
    """Excess time over altitude, and the highest altitude with more than the required one.

    ``highest`` is None if there is none. ``at_search_limit`` is true if the end of the search is
    feasible, so that the ceiling lies higher.
    """

    flights: tuple[AltitudeFlight, ...]
    required_excess_time_h: float
    highest: AltitudeFlight | None
    best: AltitudeFlight
    at_search_limit: bool

    def column(self, name: str) -> FloatArray:
        """Return a quantity of :class:`AltitudeFlight` over the scanned altitudes."""
        return np.array([getattr(flight, name) for flight in self.flights], float)


def highest_perpetual_altitude(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    highest_m: float | None = None,
    step_m: float = DEFAULT_STEP_M,
    progress: Progress | None = None,
) -> PerpetualCeiling:
    """Find the highest altitude of perpetual flight in all of a mission's scenarios.

    Parameters
    ----------
    aircraft, mission, solar
        As for :func:`sizing.performance.performance`. The search starts at the mission's altitude,
        and goes down from there if no altitude above is feasible; a parametric aircraft's mass
        budget is closed at each altitude, or night's floor.
    highest_m : float
        End of the search [m]; if left out 20,000 m, or 32,000 m for missions above 15,000 m. With
        climbs it ends at their ceiling at the latest.
    step_m : float
        Spacing of the scan [m]; the ceiling itself is found to 0.1 m.
    progress : callable, optional
        Called after every scanned altitude with the number of altitudes done, and of all.

    Returns
    -------
    PerpetualCeiling
        Flights at the scanned altitudes, the highest perpetual one, and the one with the largest
        excess time.

    Raises
    ------
    ValueError
        If the search has no length or no step.
    ImpossibleDesignError
        If the aircraft cannot carry its own mass at any altitude.
    """
    if highest_m is None:
        high_up = mission.altitude_m > _HIGHEST_M - _NEAR_M
        highest_m = MAXIMUM_ALTITUDE_M if high_up else _HIGHEST_M
    highest_m = min(highest_m, mission.highest_floor_m)
    if not highest_m > mission.altitude_m:
        text = f"highest_m must be above the mission's altitude of {spell(mission.altitude_m)}"
        raise ValueError(refusal(text, highest_m))
    Allowed(0.0, above=True).check("step_m", step_m)
    altitudes = scanned_altitudes_m(mission.altitude_m, highest_m, step_m)
    simulate = partial(flight_at_altitude, aircraft, mission, solar)
    flights = []
    for number, altitude_m in enumerate(altitudes, start=1):
        flights.append(simulate(altitude_m))
        if progress is not None:
            progress(number, len(altitudes))
    required_h = mission.required_excess_time_h
    below = scanned_altitudes_m(0.0, mission.altitude_m, step_m)[:-1]
    while below and not any(flight.excess_time_h > required_h for flight in flights):
        try:
            flights.insert(0, simulate(below.pop()))
        except InputError:  # the table of winds ends
            break
        if progress is not None:
            progress(len(flights), len(flights) + len(below))
    if all(np.isnan(flight.propulsion_power_w) for flight in flights):
        raise ImpossibleDesignError(
            operating_trouble(aircraft, mission)
            or f"{aircraft.name} cannot carry its own mass at any altitude"
        )
    highest = _highest(flights, simulate, required_h)
    return PerpetualCeiling(
        flights=tuple(flights),
        required_excess_time_h=required_h,
        highest=highest,
        best=_best_altitude(flights, simulate),
        at_search_limit=highest is flights[-1],
    )


def scanned_altitudes_m(lowest_m: float, highest_m: float, step_m: float) -> list[float]:
    """Return the altitudes to scan: both ends, and multiples of the step between them [m]."""
    if not lowest_m < highest_m:
        return [float(highest_m)]
    first, last = np.floor(lowest_m / step_m) + 1.0, np.ceil(highest_m / step_m) - 1.0
    between = step_m * np.arange(first, last + 1.0)
    return [float(lowest_m), *(float(h) for h in between), float(highest_m)]


def flight_at_altitude(
    aircraft: Aircraft, mission: Mission, solar: SolarModel, altitude_m: float
) -> AltitudeFlight:
    """Return the critical scenario's flight at another altitude, or from another night's floor.

    The excess time is -24 h for an aircraft that cannot carry its own mass there.
    """
    mission_at_altitude = mission.climbing_from(altitude_m)
    density_kg_per_m3 = float(mission_at_altitude.air_state().density_kg_per_m3)
    try:
        result = performance(aircraft, mission_at_altitude, solar)
    except ImpossibleDesignError:
        reason = operating_reason(aircraft, mission_at_altitude) or "cannot carry its own mass"
        return AltitudeFlight(
            altitude_m,
            HOPELESS_H,
            density_kg_per_m3=density_kg_per_m3,
            reason=reason,
            maximum_altitude_m=None if mission_at_altitude.climb is None else math.nan,
        )
    worst, cycle, design = result.worst_scenario(), result.cycle, result.design
    airspeed, highest_m = design.airspeed_m_per_s, result.maximum_altitude_m
    module_c = mission_at_altitude.air.module_temperature_c
    return AltitudeFlight(
        altitude_m=altitude_m,
        excess_time_h=float(cycle.excess_time_h[worst]),
        minimum_state_of_charge=float(cycle.minimum_state_of_charge[worst]),
        propulsion_power_w=float(design.propulsion_power_w),
        solar_energy_wh=float(cycle.energy_budget.solar_wh[worst]),
        load_energy_wh=float(cycle.energy_budget.load_wh[worst]),
        airspeed_m_per_s=math.nan if airspeed is None else float(airspeed),
        density_kg_per_m3=density_kg_per_m3,
        module_temperature_c=math.nan if module_c is None else module_c,
        worst_scenario=worst,
        extrapolations=extrapolations(aircraft, result),
        maximum_altitude_m=None if highest_m is None else float(highest_m[worst]),
    )


def _highest(
    flights: list[AltitudeFlight], simulate: Callable[[float], AltitudeFlight], required_h: float
) -> AltitudeFlight | None:
    """Return the last feasible flight, refined to the edge of feasibility, or None."""
    feasible = [i for i, flight in enumerate(flights) if flight.excess_time_h > required_h]
    if not feasible:
        return None
    last = feasible[-1]
    if last == len(flights) - 1:
        return flights[-1]

    def margin_h(altitude_m: float) -> float:
        return float(np.clip(simulate(altitude_m).excess_time_h - required_h, -_FAR_H, _FAR_H))

    # Excess time may jump at the edge; the change of sign is found either way.
    below, above = flights[last].altitude_m, flights[last + 1].altitude_m
    edge = float(brentq(margin_h, below, above, xtol=_RESOLUTION_M))
    # The root has a finite resolution: step down to the feasible side.
    retreat = _RESOLUTION_M
    highest = simulate(edge)
    while highest.excess_time_h <= required_h and edge - retreat > below:
        highest = simulate(edge - retreat)
        retreat *= 2.0
    return highest if highest.excess_time_h > required_h else flights[last]


def _best_altitude(
    flights: list[AltitudeFlight], simulate: Callable[[float], AltitudeFlight]
) -> AltitudeFlight:
    """Return the flight of largest excess time, refined between the neighbours of the scan's."""
    index = int(np.argmax([flight.excess_time_h for flight in flights]))
    best = flights[index]
    if np.isinf(best.excess_time_h):
        return best

    lower, upper = flights[max(index - 1, 0)], flights[min(index + 1, len(flights) - 1)]
    least = minimize_scalar(
        lambda altitude_m: -max(simulate(float(altitude_m)).excess_time_h, -_FAR_H),
        bounds=(lower.altitude_m, upper.altitude_m),
        method="bounded",
        options={"xatol": 1.0},
    )
    refined = simulate(float(least.x))
    return refined if refined.excess_time_h > best.excess_time_h else best
