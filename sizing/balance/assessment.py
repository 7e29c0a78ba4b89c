"""Balance of a design: masses with their places, static margin, trim, control authority."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees, pi
from typing import Any

from missions.mission import Mission
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.balance.drag import DragShares
from sizing.balance.in_design import polar_with_tail, structure_with_tail
from sizing.balance.masses import (
    Balance,
    Item,
    centre_of_gravity,
    spar_x_m,
    tail_mass_x_m,
    wing_and_tail_items,
)
from sizing.balance.stability import (
    NeutralPoint,
    Trim,
    directional_stability,
    elevator_deflection,
    neutral_point,
    trim,
)
from sizing.balance.surfaces import Tail, TailPlanes, Wing, wing_of
from sizing.design import Design, FlightConditions, flown_at, structure_inputs
from sizing.limits import DesignInFlight
from sizing.propulsion.chain import OperatingPointPropulsion
from sizing.smooth import Value
from sizing.structures.rib_wing import RibWingStructure

__all__ = [
    "BalanceAssessment",
    "balance_assessment",
    "balance_items",
    "drag_shares",
    "moved_x_m",
]

_SLOW = 1.2  # speed over the stall speed at which the controls are assessed


@dataclass(frozen=True)
class BalanceAssessment:
    """Balance in level flight, controls at 1.2 times the stall speed.

    ``items``: masses with their places. ``design_mass_kg``: of the mass budget, which a weighed list
    need not meet. ``found``: neutral point. ``sideslip_deg``: held by the whole rudder. ``motor_out``:
    share of the rudder that one of two motors needs; None with another number of booms or motors.
    """

    items: tuple[Item, ...]
    design_mass_kg: float
    wing: Wing
    planes: TailPlanes
    found: NeutralPoint
    gravity_m: float
    level: Trim
    drag_coefficient: float
    elevator_deg: float
    elevator_limit_deg: float
    directional_slope: float
    sideslip_deg: float
    motor_out: float | None

    @property
    def static_margin(self) -> float:
        """Neutral point behind the centre of gravity, over the mean aerodynamic chord [-]."""
        return float((self.found.x_m - self.gravity_m) / self.wing.aerodynamic_chord_m)

    def in_chord(self, x_m: float) -> float:
        """Place over the mean aerodynamic chord, behind its leading edge [-]."""
        return float((x_m - self.wing.at_chord(0.0)) / self.wing.aerodynamic_chord_m)

    @property
    def mass_kg(self) -> float:
        """Sum of the items [kg]."""
        return float(sum(item.mass_kg for item in self.items))

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "items": [item._asdict() for item in self.items],
            "mass_kg": self.mass_kg,
            "centre_of_gravity_m": self.gravity_m,
            "neutral_point_m": float(self.found.x_m),
            "aerodynamic_chord_m": float(self.wing.aerodynamic_chord_m),
            "aerodynamic_chord_leading_edge_m": float(self.wing.at_chord(0.0)),
            "static_margin": self.static_margin,
            "downwash_slope": float(self.found.downwash),
            "lift_slope_per_rad": float(self.found.slope),
            "tail": {name: float(one) for name, one in self.planes._asdict().items()},
            "tail_lift_coefficient": float(self.level.tail_lift),
            "wing_lift_coefficient": float(self.level.wing_lift),
            "trim_drag_coefficient": float(self.level.drag),
            "elevator_deg": self.elevator_deg,
            "elevator_limit_deg": self.elevator_limit_deg,
            "directional_slope_per_rad": self.directional_slope,
            "rudder_sideslip_deg": self.sideslip_deg,
            "motor_out_rudder_share": self.motor_out,
        }


def _own(aircraft: Aircraft) -> tuple[ParametricAirframe, Tail, Balance] | None:
    """Airframe with tail and balance; None where the file has not both."""
    airframe = aircraft.airframe
    if not isinstance(airframe, ParametricAirframe):
        return None
    if airframe.tail is None or airframe.balance is None:
        return None
    return airframe, airframe.tail, airframe.balance


def _body_m3(airframe: ParametricAirframe) -> float:
    return 0.0 if airframe.drag is None else airframe.drag.volume_m3


def _fixed_items(
    aircraft: Aircraft, conditions: FlightConditions, design: Design, wing: Wing
) -> dict[str, Item]:
    """Items of the mass budget by their places in the file; they add up to the total mass."""
    airframe, masses, variables = aircraft.airframe, design.masses, design.variables
    assert isinstance(airframe, ParametricAirframe)
    assert airframe.balance is not None
    assert airframe.tail is not None
    structure = structure_with_tail(airframe, variables.wingspan_m, variables.aspect_ratio)
    assert isinstance(structure, RibWingStructure)  # others are refused at validation
    inputs = structure_inputs(
        aircraft, variables, conditions, design.total_mass_kg, design.airspeed_m_per_s
    )
    planes = airframe.tail.planes(wing)
    chords = airframe.balance.positions_chords
    places = {
        name: getattr(chords, name) * wing.mean_chord_m for name in type(chords).model_fields
    }
    tail_m = tail_mass_x_m(wing, planes.arm_m, planes.horizontal_chord_m)
    parts = wing_and_tail_items(structure.breakdown(inputs), wing, tail_m, places["pod"])
    in_pod_kg = structure.wing(inputs).pod_battery_kg
    in_spar_kg = masses.battery - in_pod_kg
    items = [*parts, Item("battery in the wing", in_spar_kg, spar_x_m(wing))]
    items.append(Item("battery", in_pod_kg, places["battery"]))
    names = ("propulsion", "modules", "mppt", "avionics", "payload", "other")
    items += [Item(name, getattr(masses, name), places[name]) for name in names]
    return {item.name: item for item in items}


def moved_x_m(aircraft: Aircraft, conditions: FlightConditions, design: Design) -> Value | None:
    """Where the moved mass has to be for the static margin that is asked for [m].

    ``x = (x_cg sum(m) - sum of the others' m x)/m_moved``. None where the file asks for none.
    """
    own = _own(aircraft)
    if own is None or own[2].static_margin is None:
        return None
    airframe, tail, balance = own
    variables = design.variables
    wing = wing_of(airframe.planform, variables.wingspan_m, variables.aspect_ratio)
    items = _fixed_items(aircraft, conditions, design, wing)
    moved = items.pop(balance.moved)
    rest = list(items.values())
    rest_kg = sum((item.mass_kg for item in rest[1:]), rest[0].mass_kg)
    neutral_m = neutral_point(wing, tail, tail.planes(wing), _body_m3(airframe)).x_m
    wanted_m = neutral_m - balance.static_margin * wing.aerodynamic_chord_m
    return wanted_m + rest_kg * (wanted_m - centre_of_gravity(rest)) / moved.mass_kg


def balance_items(
    aircraft: Aircraft, conditions: FlightConditions, design: Design
) -> tuple[Item, ...]:
    """Masses with their places: as weighed, or of the mass budget."""
    own = _own(aircraft)
    assert own is not None
    airframe, _, balance = own
    if balance.weighed:
        return tuple(Item(one.name, one.mass_kg, one.x_m) for one in balance.weighed)
    variables = design.variables
    wing = wing_of(airframe.planform, variables.wingspan_m, variables.aspect_ratio)
    items = _fixed_items(aircraft, conditions, design, wing)
    found_m = moved_x_m(aircraft, conditions, design)
    if found_m is not None:
        items[balance.moved] = items[balance.moved]._replace(x_m=found_m)
    return tuple(items.values())


def drag_shares(aircraft: Aircraft, mission: Mission, design: Design) -> DragShares | None:
    """Drag of the parts in level flight; None where the file does not build it up."""
    it = DesignInFlight(aircraft, design, FlightConditions.of(mission, aircraft))
    airframe = aircraft.airframe
    if not isinstance(airframe, ParametricAirframe) or airframe.drag is None:
        return None
    polar = _polar(airframe, design, it.lift_coefficient)
    return DragShares(*(float(one) for one in polar.shares(it.reynolds_number)))


def _polar(airframe: ParametricAirframe, design: Design, lift: Value) -> Any:
    """Polar of a design at a lift coefficient, built up where the file asks for it."""
    variables = design.variables
    return polar_with_tail(
        airframe,
        flown_at(airframe.aerodynamics, lift),
        variables.wingspan_m,
        variables.aspect_ratio,
    )


def balance_assessment(
    aircraft: Aircraft, mission: Mission, design: Design
) -> BalanceAssessment | None:
    """Balance of a design of floats; None where the file has no tail or no balance."""
    own = _own(aircraft)
    if own is None:
        return None
    airframe, tail, balance = own
    conditions = FlightConditions.of(mission, aircraft).with_payload_of(design.variables)
    it = DesignInFlight(aircraft, design, conditions)
    variables = design.variables
    wing = wing_of(airframe.planform, variables.wingspan_m, variables.aspect_ratio)
    wing = Wing(*(float(one) for one in wing))
    planes, body_m3 = tail.planes(wing), _body_m3(airframe)
    found = neutral_point(wing, tail, planes, body_m3)
    items = tuple(
        Item(one.name, float(one.mass_kg), float(one.x_m))
        for one in balance_items(aircraft, conditions, design)
        if float(one.mass_kg) > 0.0
    )
    gravity_m = float(centre_of_gravity(items))
    lift = float(it.lift_coefficient)
    slow_lift = lift * (float(it.stall_margin) / _SLOW) ** 2
    moment = balance.pitching_moment_coefficient
    efficiency = getattr(airframe.aerodynamics, "span_efficiency", 1.0)
    level, slow = (
        trim(wing, tail, planes, lift=one, moment=moment, gravity_x_m=gravity_m,
             span_efficiency=efficiency)
        for one in (lift, slow_lift)
    )  # fmt: skip
    directional = directional_stability(
        wing, tail, planes, gravity_x_m=gravity_m, body_m3=body_m3
    )
    drag, slow_drag = (
        float(_polar(airframe, design, one).drag_coefficient(wing.aspect_ratio, reynolds))
        for one, reynolds in (
            (lift, it.reynolds_number),
            (slow_lift, it.reynolds_number * (lift / slow_lift) ** 0.5),
        )
    )
    twin = _motors(airframe) == 2 and getattr(airframe.structure, "booms", 1) == 2
    yawing = slow_drag * planes.horizontal_span_m / 2.0 / wing.wingspan_m
    return BalanceAssessment(
        items=items,
        design_mass_kg=float(design.total_mass_kg),
        wing=wing,
        planes=planes,
        found=found,
        gravity_m=gravity_m,
        level=level,
        drag_coefficient=drag,
        elevator_deg=degrees(elevator_deflection(tail, found, level, slow, slow_lift - lift)),
        elevator_limit_deg=tail.elevator_deflection_deg,
        directional_slope=float(directional.slope),
        sideslip_deg=float(directional.rudder / directional.slope * 180.0 / pi),
        motor_out=float(yawing / directional.rudder) if twin else None,
    )


def _motors(airframe: ParametricAirframe) -> int:
    chain = airframe.propulsion
    return chain.propulsors if isinstance(chain, OperatingPointPropulsion) else 1

