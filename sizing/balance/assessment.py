"""Balance of a design: masses with their places, static margin, trim, control authority."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees, sin

from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.balance.drag import DragShares
from sizing.balance.in_design import (
    balance_items,
    body_volume_m3,
    drag_by_parts,
    drag_coefficient,
    volume_for_margin,
)
from sizing.balance.masses import Item, centre_of_gravity
from sizing.balance.surfaces import (
    NeutralPoint,
    TailPlanes,
    Trim,
    Wing,
    directional_stability,
    elevator_deflection,
    neutral_point,
    trim,
    wing_of,
)
from sizing.design import Design, polar_at
from sizing.smooth import Value

_SLOW = 1.2  # airspeed over stall speed for the assessment of controls


@dataclass(frozen=True)
class BalanceAssessment:
    """Balance in level flight, and controls at 1.2 times the stall speed.

    ``required_margin``: static margin of the file; ``volume_for_margin``: volume coefficient of the
    horizontal tail with this margin, None if there is none. ``design_mass_kg``: total of the mass
    budget, from which weighed masses may differ. ``sideslip_deg``: sideslip at the full rudder.
    ``motor_out``: share of the rudder to balance a single motor of two at the fronts of two booms;
    None for other aircraft.
    """

    items: tuple[Item, ...]
    required_margin: float | None
    volume_for_margin: float | None
    design_mass_kg: float
    wing: Wing
    planes: TailPlanes
    neutral_point: NeutralPoint
    gravity_m: float
    level: Trim
    drag_coefficient: float
    elevator_deg: float
    elevator_at_stall_deg: float
    elevator_limit_deg: float
    directional_slope: float
    sideslip_deg: float
    crosswind_m_per_s: float
    motor_out: float | None

    @property
    def static_margin(self) -> float:
        """Neutral point behind the centre of gravity, over the mean aerodynamic chord [-]."""
        return float((self.neutral_point.x_m - self.gravity_m) / self.wing.aerodynamic_chord_m)

    def in_chord(self, x_m: float) -> float:
        """Return a position over the mean aerodynamic chord, behind its leading edge [-]."""
        return float((x_m - self.wing.at_chord(0.0)) / self.wing.aerodynamic_chord_m)

    @property
    def gravity_in_chord(self) -> float:
        """Centre of gravity over the mean aerodynamic chord [-]."""
        return self.in_chord(self.gravity_m)

    @property
    def neutral_in_chord(self) -> float:
        """Neutral point over the mean aerodynamic chord [-]."""
        return self.in_chord(float(self.neutral_point.x_m))

    @property
    def chord_leading_edge_m(self) -> float:
        """Position of the leading edge of the mean aerodynamic chord [m]."""
        return float(self.wing.at_chord(0.0))

    @property
    def mass_kg(self) -> float:
        """Sum of the masses [kg]."""
        return float(sum(item.mass_kg for item in self.items))


def drag_shares(aircraft: Aircraft, design: Design) -> DragShares | None:
    """Return the drag of the parts in level flight; None without a drag build-up in the file."""
    airframe = aircraft.airframe
    if not isinstance(airframe, ParametricAirframe) or airframe.drag is None:
        return None
    polar = polar_at(airframe.aerodynamics, design.lift_coefficient)
    wing = wing_of(airframe.planform, design.variables.wingspan_m, design.variables.aspect_ratio)
    shares = drag_by_parts(airframe, polar, wing, design.reynolds_number)
    assert shares is not None
    return DragShares(*(float(share) for share in shares))


def balance_assessment(aircraft: Aircraft, design: Design) -> BalanceAssessment | None:
    """Return the balance of a design of floats; None without tail or balance in the file."""
    airframe = aircraft.airframe
    if not isinstance(airframe, ParametricAirframe) or airframe.balance is None:
        return None
    tail, balance = airframe.tail, airframe.balance
    assert tail is not None  # refused at validation
    assert design.sized_from is not None
    variables = design.variables
    wing = wing_of(airframe.planform, variables.wingspan_m, variables.aspect_ratio)
    wing = Wing(*(float(value) for value in wing))
    planes, body_m3 = tail.planes(wing), body_volume_m3(airframe)
    neutral = neutral_point(wing, tail, planes, body_m3)
    masses, inputs = design.masses, design.sized_from
    items = tuple(
        Item(item.name, float(item.mass_kg), float(item.x_m))
        for item in balance_items(airframe, masses, inputs)
        if float(item.mass_kg) > 0.0
    )
    gravity_m = float(centre_of_gravity(items))
    lift = float(design.lift_coefficient)
    stall_lift = lift * float(design.stall_margin) ** 2
    slow_lift = stall_lift / _SLOW**2
    moment = balance.pitching_moment_coefficient
    efficiency = getattr(airframe.aerodynamics, "span_efficiency", 1.0)

    def trimmed(lift: float) -> Trim:
        return trim(wing, tail, planes, lift=lift, moment=moment, gravity_x_m=gravity_m,
                    span_efficiency=efficiency)  # fmt: skip

    def drag_at(lift: float, reynolds: Value) -> float:
        polar = polar_at(airframe.aerodynamics, lift)
        return float(drag_coefficient(airframe, polar, wing, reynolds))

    level, slow, stall = trimmed(lift), trimmed(slow_lift), trimmed(stall_lift)
    slow_ratio = (lift / slow_lift) ** 0.5
    yaw, rudder = directional_stability(wing, tail, planes, gravity_x_m=gravity_m, body_m3=body_m3)
    slow_drag = drag_at(slow_lift, design.reynolds_number * slow_ratio)
    elevator = elevator_deflection(tail, neutral, level, slow, slow_lift - lift)
    elevator_at_stall = elevator_deflection(tail, neutral, level, stall, stall_lift - lift)
    sideslip = float(rudder / yaw)
    slow_speed = float(design.airspeed_m_per_s) * slow_ratio
    motors = getattr(airframe.propulsion, "propulsors", 1)
    twin = motors == 2 and getattr(airframe.structure, "booms", 1) == 2
    yawing = slow_drag * planes.horizontal_span_m / 2.0 / wing.wingspan_m
    return BalanceAssessment(
        items=items,
        required_margin=balance.static_margin,
        volume_for_margin=volume_for_margin(airframe, masses, inputs),
        design_mass_kg=float(design.total_mass_kg),
        wing=wing,
        planes=planes,
        neutral_point=neutral,
        gravity_m=gravity_m,
        level=level,
        drag_coefficient=drag_at(lift, design.reynolds_number),
        elevator_deg=degrees(elevator),
        elevator_at_stall_deg=degrees(elevator_at_stall),
        elevator_limit_deg=tail.elevator_deflection_deg,
        directional_slope=float(yaw),
        sideslip_deg=degrees(sideslip),
        crosswind_m_per_s=slow_speed * sin(sideslip),
        motor_out=float(yawing / rudder) if twin else None,
    )
