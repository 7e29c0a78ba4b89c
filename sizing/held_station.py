"""Flight at the speed of the wind, for missions that hold their place.

At constant mass a higher airspeed needs a lower lift coefficient, ``C_L = 2 m g / (rho V^2 S)``.
The power is limited by the rated power of the propulsion.
"""

from __future__ import annotations

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.design import Design, FlightConditions
from sizing.mass_budget import level_flight
from sizing.smooth import Value
from solar.types import BoolArray, FloatArray

POWER_AGAINST_WIND = "power_against_wind"  # requirement of a scenario
_ROUNDING = 1e-6  # relative tolerance of the rated power, above the solver's


def refuse_measured_aircraft(aircraft: Aircraft, what: str) -> None:
    """Refuse a measured aircraft, whose power is known at one airspeed only."""
    if not isinstance(aircraft.airframe, ParametricAirframe):
        raise ValueError(
            f"{aircraft.name} is a measured aircraft, whose power is known at one airspeed alone: "
            f"{what} needs a parametric one"
        )


def held_flight(
    aircraft: Aircraft, mission: Mission, design: Design, wind_m_per_s: FloatArray
) -> Design:
    """Return designs that fly as fast as the wind, or at their calm airspeed if that is faster.

    The power is infinite where it exceeds the rated power. The wind broadcasts with the designs.
    """
    flight, able = against_wind(aircraft, mission, design, wind_m_per_s, design.rated_power_w)
    return flight._replace(propulsion_power_w=np.where(able, flight.propulsion_power_w, np.inf))


def against_wind(
    aircraft: Aircraft,
    mission: Mission | FlightConditions,
    design: Design,
    wind_m_per_s: FloatArray,
    rated_power_w: FloatArray,
) -> tuple[Design, BoolArray]:
    """Return designs as fast as the wind, or as in calm air if faster, and whether they can.

    What exceeds the rated power is no flight, whatever its power is; where no power is known the
    design keeps its airspeed.
    """
    refuse_measured_aircraft(aircraft, "wind.hold_station")
    conditions = FlightConditions.of(mission, aircraft)
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        ratio = np.maximum(wind_m_per_s / np.asarray(design.airspeed_m_per_s), 1.0)
        calm, calm_w = ratio <= 1.0, design.propulsion_power_w
        faster = flight_faster(aircraft, conditions, design, ratio)
        power_w = np.where(calm, calm_w, faster.propulsion_power_w)
        able = calm | (power_w <= rated_power_w * (1.0 + _ROUNDING))
        unknown = ~np.isfinite(power_w) & np.isfinite(calm_w)
        if np.any(unknown):
            faster = flight_faster(aircraft, conditions, design, np.where(unknown, 1.0, ratio))
            power_w = np.where(calm | unknown, calm_w, faster.propulsion_power_w)
    return faster._replace(propulsion_power_w=power_w), able


def flight_faster(
    aircraft: Aircraft, conditions: FlightConditions, design: Design, ratio: Value
) -> Design:
    """Return a design in level flight faster by a ratio; numbers, arrays or symbols."""
    lower_lift = design.variables._replace(lift_coefficient=design.lift_coefficient / ratio**2)
    chain, power_w, speed = level_flight(aircraft, conditions, lower_lift, design.total_mass_kg)
    return design._replace(propulsion_power_w=power_w, airspeed_m_per_s=speed, chain=chain)
