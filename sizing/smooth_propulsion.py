"""Aircraft whose propulsion at its operating point is formulas, for programs and draws."""

from __future__ import annotations

from math import isfinite, log, pi
from typing import Any

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.catalogues.entries import PARTS_OF_PROPELLER
from sizing.design import Design, FlightConditions, parametric_design, variables_of
from sizing.design_space import Range
from sizing.mass_budget import (
    ImpossibleDesignError,
    closed_design,
    design_of,
    first_chain,
    level_point,
    operating_trouble,
)
from sizing.propulsion.chain import OperatingPointPropulsion
from sizing.propulsion.operating_point import OperatingPoint
from sizing.propulsion.smooth_chain import SmoothPropulsion, fitted_surface

# Logarithms within which a search moves from the design that is fitted around: loading of the
# propeller, Reynolds number, pitch over diameter. Centres are rounded: alike cases share a surface.
_HALF_WIDTHS, _ROUNDED_TO = (log(6.0), log(4.0), 0.25), 0.25


def smooth_at(aircraft: Aircraft, mission: Mission) -> Aircraft:
    """Aircraft of a file with formulas that have the exact chain's efficiency for its own design.

    One with constants or formulas is returned as it is, one with a propeller by tables gets the
    constant efficiencies of level flight. Raises :class:`ImpossibleDesignError` if it cannot fly.
    """
    propulsion = aircraft.propulsion_by_parts
    if propulsion is None or not propulsion.is_exact:
        return aircraft
    design = design_of(aircraft, mission)
    if propulsion.propeller.table is not None:
        assert design.chain is not None
        return aircraft.with_airframe(propulsion=design.chain)
    smooth = smooth_propulsion(aircraft, mission, propulsion)
    return aircraft.with_airframe(propulsion=corrected(smooth, aircraft, mission, design))


def corrected(
    smooth: SmoothPropulsion,
    aircraft: Aircraft,
    mission: Mission,
    design: Design,
    point: OperatingPoint | None = None,
) -> SmoothPropulsion:
    """Formulas that have the exact propeller's rotation and power at a design.

    ``point``: of :func:`level_point`, where it is known. Limits of the parts play no part. Raises
    :class:`ImpossibleDesignError` where the propeller has no speed of rotation.
    """
    point = level_point(aircraft, mission, design) if point is None else point
    own = smooth.sized(*design.variables.mapped(float).of_propulsion)
    given = (float(point.thrust_power_w) * smooth.propulsors, float(design.airspeed_m_per_s))
    air = FlightConditions.of(mission, aircraft).air
    rotation, shaft_w, _ = own.propeller_state(*given, air)
    ratios = (
        float(point.rotation_rpm / 60.0 / rotation),
        float(point.rotation_rpm * point.propeller_torque_nm * pi / 30.0 / shaft_w),
    )
    if not all(map(isfinite, ratios)):
        raise ImpossibleDesignError(operating_trouble(aircraft, mission, design.variables))
    both = tuple(a * b for a, b in zip(smooth.correction, ratios, strict=True))
    return smooth.model_copy(update={"correction": both})


def smooth_propulsion(
    aircraft: Aircraft,
    mission: Mission,
    propulsion: OperatingPointPropulsion,
    around: Design | None = None,
) -> SmoothPropulsion:
    """Propulsion by formulas, fitted around a design.

    ``around``: by default the design in the file, and then as wide as diameter and pitch are free.
    """
    space, propeller = aircraft.design_space, propulsion.propeller
    assert propeller.diameter_m is not None
    assert propeller.pitch_m is not None
    if around is None:
        flown = _usual_design(aircraft, mission, propulsion)
        diameter_m, wider = _middle(space.propeller_diameter_m, propeller.diameter_m)
        pitch_m, steeper = _middle(space.propeller_pitch_m, propeller.pitch_m)
    else:
        flown, wider, steeper = around, 0.0, 0.0
        own = propulsion.sized(*around.variables.mapped(float).of_propulsion).propeller
        assert own.diameter_m is not None
        assert own.pitch_m is not None
        diameter_m, pitch_m = own.diameter_m, own.pitch_m
    air = FlightConditions.of(mission, aircraft).air
    thrust_w = float(flown.thrust_power_w) / propulsion.propulsors
    speed = float(flown.airspeed_m_per_s)
    loading = thrust_w / (air.density_kg_per_m3 * speed**3 * diameter_m**2)
    reynolds = air.density_kg_per_m3 * speed * diameter_m / air.dynamic_viscosity_pa_s
    middle = (float(loading), float(reynolds), pitch_m / diameter_m)
    more = (2.0 * wider, wider, wider + steeper)
    centre, half = (
        tuple(_ROUNDED_TO * round(log(one) / _ROUNDED_TO) for one in middle),
        tuple(a + b for a, b in zip(_HALF_WIDTHS, more, strict=True)),
    )
    surface = fitted_surface(propeller.blades, propeller.chords, centre, half)
    return SmoothPropulsion.of(propulsion, surface)


def _usual_design(
    aircraft: Aircraft, mission: Mission, propulsion: OperatingPointPropulsion
) -> Design:
    """Design in the file with usual efficiencies, whether or not its propulsion can fly it."""
    usual = aircraft.with_airframe(propulsion=first_chain(propulsion))
    variables = variables_of(aircraft)
    mass_kg = float(closed_design(usual, mission, variables).total_mass_kg)
    if not isfinite(mass_kg):
        # Wrong by a third of the mass, well within the surface.
        mass_kg = 3.0 * (aircraft.battery.mass_kg + mission.payload.mass_kg)
    return parametric_design(usual, mission, variables, mass_kg)


def _middle(ends: Range | None, value: float) -> tuple[float, float]:
    """Geometric mean of a range, and half the logarithm of its ratio; the value without one."""
    if ends is None:
        return value, 0.0
    return (ends.minimum * ends.maximum) ** 0.5, 0.5 * log(ends.maximum / ends.minimum)


def put_parts_in(data: dict[str, Any], aircraft: Aircraft, design: Design) -> None:
    """Put the chosen propeller and gear into an aircraft's file as data, in place."""
    variables = design.variables
    if all(one is None for one in variables.of_propulsion):
        return
    propulsion = aircraft.propulsion_by_parts
    assert propulsion is not None
    places = (("propeller", "diameter_m"), ("propeller", "pitch_m"), ("gear", "ratio"))
    parts = data["airframe"]["propulsion"]
    for (part, key), value in zip(places, variables.of_propulsion, strict=False):
        if value is not None:
            parts.setdefault(part, {})[key] = float(value)
    if variables.motor_speed_constant_rpm_per_v is not None:
        # A product of the catalogue has its own winding.
        wound = propulsion.own_motor.rewound(float(variables.motor_speed_constant_rpm_per_v))
        parts["motor"] = wound.model_dump(exclude_none=True)
    sized = any(one is not None for one in variables.of_propulsion[:2])
    mass_kg = propulsion.sized(*variables.mapped(float).of_propulsion).propeller.mass_kg
    if sized and mass_kg is not None:
        parts["propeller"]["mass_kg"] = float(mass_kg)
    # No longer the product that the file names.
    if sized and parts["propeller"].pop("product", None) is not None:
        for key in PARTS_OF_PROPELLER:
            parts["propeller"].setdefault(key, getattr(propulsion.propeller, key))
