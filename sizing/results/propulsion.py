"""Propulsion in results: where the electric power of level flight goes, masses that are estimated.

And whether the parts can do the load of the day.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.load import flight_of, load_shape
from sizing.design import Design
from sizing.mass_budget import level_point
from sizing.performance import Performance
from sizing.propulsion.chain import LINKS
from sizing.propulsion.part_masses import motor_mass_fit, propeller_mass_fit

if TYPE_CHECKING:
    from sizing.propulsion.operating_point import OperatingPoint


@dataclass(frozen=True)
class PowerBudget:
    """Power of level flight, with the turbulence of all hours.

    ``watts``: by the keys of its rows [W], which add up to ``bus_w``; a measured aircraft has
    ``propulsion_w`` instead of drag and losses. ``efficiencies``: of the links and of the chain
    [-], empty for a measured aircraft. ``point``: of one propulsor, where the aircraft's file says
    what it is made of. ``assumed``: efficiency of the chain that the design was found with [-].
    """

    watts: dict[str, float]
    efficiencies: dict[str, float]
    point: OperatingPoint | None
    assumed: float | None

    @property
    def bus_w(self) -> float:
        """Sum of the rows [W]."""
        return sum(self.watts.values())


def power_budget(aircraft: Aircraft, mission: Mission, design: Design) -> PowerBudget:
    """Return the power budget of a design in level flight on a mission.

    The design may be an optimum with the aircraft's technology. An operating point is computed
    anew, at the design's mass.
    """
    level_w, chain = float(design.propulsion_power_w), design.chain
    point = assumed = None
    watts, efficiencies = {"propulsion_w": level_w}, {}
    if chain is not None:
        assumed = float(chain.efficiency)
        thrust_w, efficiencies = level_w * assumed, chain.links
        if aircraft.propulsion_by_parts is not None:
            point = level_point(aircraft, mission, design)
            efficiencies = {k: float(getattr(point, f"{v}_efficiency")) for k, v in LINKS.items()}
        efficiencies = {k: float(v) for k, v in efficiencies.items()}
        watts, after = {"aerodynamic_w": thrust_w}, thrust_w
        for link in reversed(LINKS):
            before = after / efficiencies[link]
            watts[f"{link}_loss_w"], after = before - after, before
        efficiencies["chain"], level_w = thrust_w / after, after
    power, chosen = aircraft.power, design.variables.payload_power_w
    payload_w = mission.payload.power_w if chosen is None else float(chosen)
    consumers_w = power.avionics_w + payload_w
    supplied_w = consumers_w / power.supply_efficiency
    watts |= {
        "turbulence_w": level_w * mission.turbulence.all_day,
        "avionics_w": power.avionics_w,
        "payload_w": payload_w,
        "supply_loss_w": supplied_w - consumers_w,
        "heater_w": float(design.constant_power_w) - supplied_w,
    }
    return PowerBudget(watts, efficiencies, point, assumed)


class PartMasses(NamedTuple):
    """Estimated masses of one propulsor [kg]; None for a part whose mass is known.

    ``motor_scatter``, ``propeller_scatter``: one standard deviation of those of the catalogue, as a
    factor.
    """

    motor_kg: float | None
    motor_scatter: float | None
    gearbox_kg: float | None
    propeller_kg: float | None
    propeller_scatter: float | None


def part_masses(aircraft: Aircraft, design: Design) -> PartMasses | None:
    """Return the estimated masses of a design's propulsion; None where nothing is estimated."""
    propulsion, chain = aircraft.propulsion_by_parts, design.chain
    if propulsion is None or not propulsion.estimates_masses:
        return None
    assert chain is not None
    chosen = propulsion.sized(*design.variables.mapped(float).of_propulsion)
    # Wound anew it has the mass that it had.
    motor = None if propulsion.motor_constants.mass_kg is not None else propulsion.motor_mass_kg
    gears_kg = float(design.masses.propulsion) - float(chain.fixed_mass_kg or 0.0)
    has_gear = chosen.gear.mass_kg is None and chosen.gear.ratio != 1.0
    propeller = None if chosen.propeller.mass_kg is not None else float(chosen.propeller_kg)
    if motor is None and propeller is None and not has_gear:
        return None
    return PartMasses(
        propeller_kg=propeller,
        propeller_scatter=None if propeller is None else propeller_mass_fit().scatter,
        motor_kg=motor,
        motor_scatter=None if motor is None else motor_mass_fit().scatter,
        gearbox_kg=gears_kg / chosen.propulsors if has_gear else None,
    )


def beyond_parts(aircraft: Aircraft, performance: Performance) -> str | None:
    """Return why the propulsion's parts cannot do the greatest load of the day; None if they can.

    Of a single design, with climbs that of level flight.
    """
    if aircraft.propulsion_by_parts is None:
        return None
    mission, day = performance.mission, performance.day
    shape = load_shape(mission, day.time_h, day.sunrise_h, day.sunset_h)
    propulsion, flight = flight_of(aircraft, mission, performance.design)
    bus_v = aircraft.battery.nominal_voltage_v
    point = propulsion.point(flight.thrust_w * np.max(shape), *flight[1:], (bus_v, bus_v))
    return str(point.reason) or None
