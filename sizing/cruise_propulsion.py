"""Aircraft with the efficiencies of their operating point: as constants, or by formulas."""

from __future__ import annotations

from math import isfinite, log

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft, ParametricAirframe, Range
from sizing.design import (
    Design,
    FlightConditions,
    ImpossibleDesignError,
    closed_design,
    design_of,
    first_chain,
    level_point,
    operating_trouble,
    parametric_design,
    variables_of,
)
from sizing.propulsion.chain import LINKS, OperatingPointPropulsion, Propulsion
from sizing.propulsion.operating_point import OperatingPoint, Propulsor, operating_point
from sizing.propulsion.smooth_chain import SmoothPropulsion, fitted_surface

__all__ = ["corrected", "smooth_at", "smooth_propulsion", "with_operating_point", "with_propulsion"]

_ROUNDS, _TOLERANCE = 50, 1e-10
# Logarithms within which a search moves from the design in the file: loading of the propeller,
# Reynolds number, pitch over diameter. Centres are rounded, so that alike cases share a surface.
_HALF_WIDTHS, _ROUNDED_TO = (log(6.0), log(4.0), 0.2), 0.25


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
    return with_propulsion(aircraft, changed)


def smooth_at(aircraft: Aircraft, mission: Mission) -> Aircraft:
    """Aircraft of a file with formulas that have the exact chain's efficiency for its own design.

    One with constants or formulas is returned as it is, one with a propeller by tables gets the
    constant efficiencies of level flight. Raises :class:`ImpossibleDesignError` if it cannot fly.
    """
    propulsion = getattr(aircraft.airframe, "propulsion", None)
    if not isinstance(propulsion, OperatingPointPropulsion) or not propulsion.is_exact:
        return aircraft
    design = design_of(aircraft, mission)
    if propulsion.propeller.table is not None:
        assert design.chain is not None
        return with_propulsion(aircraft, design.chain)
    smooth = smooth_propulsion(aircraft, mission, propulsion)
    return with_propulsion(aircraft, corrected(smooth, aircraft, mission, design))


def corrected(
    smooth: SmoothPropulsion, aircraft: Aircraft, mission: Mission, design: Design
) -> SmoothPropulsion:
    """Formulas that have the exact propeller's rotation and power at a design.

    Limits of the parts play no part. Raises :class:`ImpossibleDesignError` where the propeller has
    no speed of rotation.
    """
    point = level_point(aircraft, mission, design)
    own = smooth.sized(*design.variables.mapped(float).of_propulsion)
    given = (float(point.thrust_power_w) * smooth.propulsors, float(design.airspeed_m_per_s))
    air = FlightConditions.of(mission, aircraft).air
    rotation, shaft_w, _ = own.propeller_state(*given, air)
    ratios = (
        float(point.rotation_rpm / 60.0 / rotation),
        float(point.rotation_rpm * point.propeller_torque_nm * np.pi / 30.0 / shaft_w),
    )
    if not all(map(isfinite, ratios)):
        raise ImpossibleDesignError(operating_trouble(aircraft, mission, design.variables))
    both = tuple(a * b for a, b in zip(smooth.correction, ratios, strict=True))
    return smooth.model_copy(update={"correction": both})


def smooth_propulsion(
    aircraft: Aircraft, mission: Mission, propulsion: OperatingPointPropulsion
) -> SmoothPropulsion:
    """Propulsion by formulas, fitted around the conditions of the design in the file."""
    variables = variables_of(aircraft)
    usual = closed_design(with_propulsion(aircraft, first_chain(propulsion)), mission, variables)
    mass_kg = float(usual.total_mass_kg)
    if not isfinite(mass_kg):
        # Wrong by a third of the mass, well within the surface.
        mass_kg = 3.0 * (aircraft.battery.mass_kg + mission.payload.mass_kg)
    flown = parametric_design(
        with_propulsion(aircraft, first_chain(propulsion)), mission, variables, mass_kg
    )
    assert flown.chain is not None
    air = FlightConditions.of(mission, aircraft).air
    thrust_w = flown.propulsion_power_w * flown.chain.efficiency
    speed = float(flown.airspeed_m_per_s)
    space, propeller = aircraft.design_space, propulsion.propeller
    assert propeller.diameter_m is not None
    assert propeller.pitch_m is not None
    diameter_m, wider = _middle(space.propeller_diameter_m, propeller.diameter_m)
    pitch_m, steeper = _middle(space.propeller_pitch_m, propeller.pitch_m)
    loading = thrust_w / propulsion.propulsors / (air.density_kg_per_m3 * speed**3 * diameter_m**2)
    reynolds = air.density_kg_per_m3 * speed * diameter_m / air.dynamic_viscosity_pa_s
    middle = (float(loading), float(reynolds), pitch_m / diameter_m)
    more = (2.0 * wider, wider, wider + steeper)
    centre, half = (
        tuple(_ROUNDED_TO * round(log(one) / _ROUNDED_TO) for one in middle),
        tuple(a + b for a, b in zip(_HALF_WIDTHS, more, strict=True)),
    )
    surface = fitted_surface(propeller.blades, propeller.chords, centre, half)
    return SmoothPropulsion.of(propulsion, surface)


def _middle(ends: Range | None, value: float) -> tuple[float, float]:
    """Geometric mean of a range, and half the logarithm of its ratio; the value without one."""
    if ends is None:
        return value, 0.0
    return (ends.minimum * ends.maximum) ** 0.5, 0.5 * log(ends.maximum / ends.minimum)


def with_propulsion(
    aircraft: Aircraft, propulsion: Propulsion | OperatingPointPropulsion
) -> Aircraft:
    """Aircraft with another propulsion."""
    airframe = aircraft.airframe.model_copy(update={"propulsion": propulsion})
    return aircraft.model_copy(update={"airframe": airframe})
