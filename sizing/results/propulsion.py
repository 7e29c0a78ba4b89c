"""Propulsion in results: where the electric power of level flight goes, masses that are estimated.

And what the efficiency of the moment changes against that of level flight.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.cycle import simulate_cycle
from sizing.day.load import Load, flight_of, interpolation_error, load_shape
from sizing.design import Design
from sizing.mass_budget import level_point
from sizing.performance import Performance
from sizing.propulsion.chain import LINKS
from sizing.propulsion.part_load import PROPORTIONAL
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


@dataclass(frozen=True)
class Instant:
    """Propulsion at an instant of the day, computed by the exact chain.

    ``hour``: solar time [h]. ``load``: thrust power over that of level flight [-]. ``efficiency``:
    thrust power over bus power [-], NaN where the parts cannot do it, for a ``reason``.
    """

    hour: float
    load: float
    state_of_charge: float
    bus_voltage_v: float
    efficiency: float
    reason: str


@dataclass(frozen=True)
class VaryingEfficiency:
    """Scenario of least excess time, by the efficiency of the moment and by that of level flight.

    ``level_excess_time_h``, ``level_minimum_state_of_charge``: by that of level flight at the
    voltage that takes more. ``night``, ``most``: where the charge and where the load are least and
    most; ``most`` is None for a load that does not vary. ``interpolation_error``: largest one of
    the table, relative to the power, half-way between its nodes.
    """

    excess_time_h: float
    level_excess_time_h: float
    minimum_state_of_charge: float
    level_minimum_state_of_charge: float
    night: Instant
    most: Instant | None
    interpolation_error: float


def varying_efficiency(aircraft: Aircraft, performance: Performance) -> VaryingEfficiency | None:
    """Return what the varying efficiency changes for a single design; None where it is constant."""
    if aircraft.propulsion_by_parts is None:
        return None
    design, mission, at = performance.design, performance.mission, performance.worst_scenario()
    day = performance.day.at([at])
    constant = Load.of(aircraft, mission, design, day.scenarios, PROPORTIONAL)
    level = simulate_cycle(
        day.time_h,
        performance.solar_power_w[[at]],
        constant.along(mission, day.time_h, day.sunrise_h, day.sunset_h),
        performance.store.flat(performance.cycle.status.shape).select(slice(at, at + 1)),
        nominal_load_w=design.nominal_load_w(mission),
    )
    charge = performance.cycle.energy_wh[at] / float(
        np.ravel(performance.store.battery_energy_wh)[0]
    )
    bus_v = aircraft.battery.nominal_voltage_v
    shape = load_shape(mission, day.time_h, day.sunrise_h, day.sunset_h)
    load = np.broadcast_to(shape, (1, len(day.time_h)))[0]
    propulsion, flight = flight_of(aircraft, mission, design)

    def instant(node: int) -> Instant:
        point = propulsion.point(flight.thrust_w * load[node], *flight[1:], (bus_v, bus_v))
        hour, share, soc = (float(values[node]) for values in (day.time_h, load, charge))
        return Instant(hour, share, soc, bus_v, float(point.efficiency), str(point.reason))

    varies = np.ptp(load) > 0.0
    return VaryingEfficiency(
        excess_time_h=float(performance.cycle.excess_time_h[at]),
        level_excess_time_h=float(level.excess_time_h[0]),
        minimum_state_of_charge=float(performance.cycle.minimum_state_of_charge[at]),
        level_minimum_state_of_charge=float(level.minimum_state_of_charge[0]),
        night=instant(int(np.argmin(charge))),
        most=instant(int(np.argmax(load))) if varies else None,
        interpolation_error=interpolation_error(aircraft, mission, design),
    )
