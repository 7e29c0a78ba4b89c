"""Aircraft with the propulsion efficiencies of its operating point in level flight."""

from __future__ import annotations

from missions.mission import Mission
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.mass_budget import ImpossibleDesignError, design_of
from sizing.propulsion.chain import LINKS, Propulsion
from sizing.propulsion.operating_point import OperatingPoint, Propulsor, operating_point
from solar.schema import refusal

_ROUNDS, _TOLERANCE = 50, 1e-10  # of the efficiency [-]


def with_operating_point(
    aircraft: Aircraft,
    mission: Mission,
    propulsor: Propulsor,
    bus_voltage_v: float,
    propulsors: int = 1,
) -> tuple[Aircraft, OperatingPoint]:
    """Return the aircraft with the efficiencies of its operating point in level flight.

    The efficiencies change rated power, mass and drag, and are iterated until they converge.
    Analyses, replays and maps of the returned aircraft have constant efficiencies, in climbs,
    thermals, other air and at any bus voltage.

    Parameters
    ----------
    aircraft : Aircraft
        Parametric; its constants of the propulsion are replaced.
    mission : Mission
        Only air and payload are used.
    propulsor : Propulsor
    bus_voltage_v : float
        Voltage of the bus [V], see :class:`BatteryVoltage`.
    propulsors : int
        Number of propulsors of that kind.

    Returns
    -------
    aircraft : Aircraft
    point : OperatingPoint
        Operating point of a propulsor.

    Raises
    ------
    ImpossibleDesignError
        If level flight exceeds a limit of the propulsor, or the aircraft cannot carry its mass.
    ValueError
        For a measured aircraft, whose power is known, or less than one propulsor.
    """
    if not isinstance(aircraft.airframe, ParametricAirframe):
        raise ValueError(f"{aircraft.name} is a measured aircraft: its power was measured")
    if propulsors < 1:
        raise ValueError(refusal("propulsors must be 1 or more", propulsors))
    before = 0.0
    for _ in range(_ROUNDS):
        chain = aircraft.airframe.propulsion
        if not isinstance(chain, Propulsion):
            raise ValueError(f"{aircraft.name} has a propulsion at its operating point already")
        design = design_of(aircraft, mission)
        airspeed = float(design.airspeed_m_per_s)
        thrust_n = float(design.propulsion_power_w) * chain.efficiency / airspeed / propulsors
        air = mission.air_state()
        point = operating_point(propulsor, thrust_n, airspeed, air, bus_voltage_v)
        if not point.feasible:
            raise ImpossibleDesignError(
                f"the propulsion of {aircraft.name} cannot do level flight on {mission.name}: "
                f"{point.reason}"
            )
        links = {
            f"{name}_efficiency": float(getattr(point, f"{link}_efficiency"))
            for name, link in LINKS.items()
        }
        changed = chain.model_copy(update={"motor": None, "motor_voltage_v": None} | links)
        aircraft = aircraft.with_airframe(propulsion=changed)
        if abs(float(point.efficiency) - before) < _TOLERANCE:
            return aircraft, point
        before = float(point.efficiency)
    raise ImpossibleDesignError(
        f"mass and propulsion of {aircraft.name} have no common operating point on {mission.name}"
    )
