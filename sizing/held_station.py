"""Flight as fast as the wind of its scenario, where a mission holds its place.

At the same mass a higher airspeed takes a lower lift coefficient, ``C_L = 2 m g / (rho V^2 S)``,
and the power of level flight at it. No more is flown than the propulsion's rated power.
"""

from __future__ import annotations

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.design import Design, FlightConditions, level_flight
from sizing.propulsion.chain import Propulsion
from sizing.smooth import Value
from solar.types import FloatArray

POWER_AGAINST_WIND = "power_against_wind"  # requirement of a scenario
_ROUNDING = 1e-6  # of the rated power: what the solver of a sizing leaves


def refuse_held_station(mission: Mission, study: str) -> None:
    """Refuse a mission that holds its place where one power is flown in all scenarios."""
    if mission.holds_station:
        raise ValueError(
            f"{study} flies at the design's airspeed: leave out wind.hold_station of {mission.name}"
        )


def refuse_one_airspeed(aircraft: Aircraft, what: str) -> None:
    """Refuse an aircraft whose power is known at one airspeed alone."""
    if not isinstance(aircraft.airframe, ParametricAirframe):
        raise ValueError(
            f"{aircraft.name} is a measured aircraft, whose power is known at one airspeed alone: "
            f"{what} needs a parametric one"
        )


def power_against_wind_w(
    aircraft: Aircraft, mission: Mission, design: Design, wind_m_per_s: FloatArray
) -> FloatArray:
    """Electric power of flight as fast as the wind, or at the design's airspeed if that is faster.

    Infinite where it exceeds the rated power. ``wind_m_per_s`` broadcasts against the designs.
    """
    return flight_against_wind(aircraft, mission, design, wind_m_per_s)[0]


def flight_against_wind(
    aircraft: Aircraft, mission: Mission, design: Design, wind_m_per_s: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """As :func:`power_against_wind_w`, with the thrust power [W] and the airspeed [m/s]."""
    refuse_one_airspeed(aircraft, "wind.hold_station")
    conditions = FlightConditions.of(mission, aircraft)
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        ratio = np.maximum(wind_m_per_s / np.asarray(design.airspeed_m_per_s), 1.0)
        chain, power_w, speed = _faster_flight(aircraft, conditions, design, ratio)
        rated_w, calm = design.rated_power_w, ratio <= 1.0
        thrust_w = power_w * np.asarray(chain.efficiency)
        power_w = np.where(calm, design.propulsion_power_w, power_w)
        able = calm | (power_w <= rated_w * (1.0 + _ROUNDING))
        return np.where(able, power_w, np.inf), thrust_w, np.asarray(speed)


def faster_flight_w(
    aircraft: Aircraft, conditions: FlightConditions, design: Design, ratio: Value
) -> tuple[Value, Value]:
    """Electric power of flight faster by a ratio, and the rated power; arrays or symbols."""
    return _faster_flight(aircraft, conditions, design, ratio)[1], design.rated_power_w


def _faster_flight(
    aircraft: Aircraft, conditions: FlightConditions, design: Design, ratio: Value
) -> tuple[Propulsion, Value, Value]:
    """Propulsion, electric power [W] and airspeed [m/s] of flight faster by a ratio."""
    lift = design.variables.lift_coefficient
    own = aircraft.parametric.aerodynamics.flight_lift_coefficient if lift is None else lift
    faster = design.variables._replace(lift_coefficient=own / ratio**2)
    return level_flight(aircraft, conditions, faster, design.total_mass_kg)
