"""An aircraft whose efficiencies of propulsion are those of its operating point in level flight."""

from __future__ import annotations

from missions.mission import Mission
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.mass_budget import ImpossibleDesignError, design_of
from sizing.propulsion.chain import LINKS, Propulsion
from sizing.propulsion.operating_point import OperatingPoint, Propulsor, operating_point

_ROUNDS, _TOLERANCE = 50, 1e-10


def with_operating_point(
    aircraft: Aircraft,
    mission: Mission,
    propulsor: Propulsor,
    bus_voltage_v: float,
    propulsors: int = 1,
) -> tuple[Aircraft, OperatingPoint]:
    """Aircraft with the efficiencies of its propulsion at its operating point in level flight.

    Drag over the number of propulsors is the thrust of each; the efficiencies change the rated
    power, and with it the mass and the drag, until they stay. Analyses, replays and maps of the new
    aircraft are those of the old one with these constants: in climbs, thermals and other air they
    are not computed anew, nor is the voltage over the night.

    Parameters
    ----------
    aircraft : Aircraft
        Parametric; its constants of the propulsion are replaced.
    mission : Mission
        Its air and payload.
    propulsor : Propulsor
    bus_voltage_v : float
        Voltage of the bus [V], see :class:`BatteryVoltage`.
    propulsors : int
        Number of propulsors of that kind.

    Returns
    -------
    aircraft : Aircraft
    point : OperatingPoint
        Of one propulsor.

    Raises
    ------
    ImpossibleDesignError
        If the propulsor cannot do it, with what would do, or the aircraft cannot carry its mass.
    ValueError
        For a measured aircraft, whose power is known, or less than one propulsor.
    """
    if not isinstance(aircraft.airframe, ParametricAirframe):
        raise ValueError(f"{aircraft.name} is a measured aircraft: its power was measured")
    if propulsors < 1:
        raise ValueError(f"propulsors must be 1 or more (got {propulsors})")
    before = 0.0
    for _ in range(_ROUNDS):
        point = _point(aircraft, mission, propulsor, bus_voltage_v, propulsors)
        aircraft = _with_efficiencies(aircraft, point)
        if abs(float(point.efficiency) - before) < _TOLERANCE:
            return aircraft, point
        before = float(point.efficiency)
    raise ImpossibleDesignError(
        f"mass and propulsion of {aircraft.name} have no common operating point on {mission.name}"
    )


def _point(
    aircraft: Aircraft, mission: Mission, propulsor: Propulsor, bus_v: float, propulsors: int
) -> OperatingPoint:
    """Operating point of one of the propulsors in level flight."""
    design = design_of(aircraft, mission)
    power_w = float(design.propulsion_power_w) * _propulsion(aircraft).efficiency
    airspeed = float(design.airspeed_m_per_s)
    air = mission.air_state()
    point = operating_point(propulsor, power_w / airspeed / propulsors, airspeed, air, bus_v)
    if not point.feasible:
        raise ImpossibleDesignError(
            f"the propulsion of {aircraft.name} cannot do level flight on {mission.name}: "
            f"{point.reason}"
        )
    return point


def _propulsion(aircraft: Aircraft) -> Propulsion:
    assert isinstance(aircraft.airframe, ParametricAirframe)
    chain = aircraft.airframe.propulsion
    if not isinstance(chain, Propulsion):
        raise ValueError(f"{aircraft.name} has a propulsion at its operating point already")
    return chain


def _with_efficiencies(aircraft: Aircraft, point: OperatingPoint) -> Aircraft:
    """Aircraft with the efficiencies of an operating point."""
    changed = _propulsion(aircraft).model_copy(
        update={
            "motor": None,
            "motor_voltage_v": None,
            **{
                f"{name}_efficiency": float(getattr(point, f"{link}_efficiency"))
                for name, link in LINKS.items()
            },
        }
    )
    return aircraft.with_airframe(propulsion=changed)
