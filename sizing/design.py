"""A design: its variables, masses, conditions of flight, and what follows from them.

:mod:`sizing.mass_budget` makes it, of floats, arrays and symbols alike.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from types import MappingProxyType
from typing import Any, NamedTuple, cast

import numpy as np

from missions.air import GAS_CONSTANT_AIR, GRAVITY_M_PER_S2, Air, gust_speed_fraction, plain_number
from missions.mission import Mission
from sizing.aerodynamics.wing_polar import Polar
from sizing.aircraft import Aircraft
from sizing.design_space import PROPULSION_VARIABLES
from sizing.parameters import all_replaced, catalogue
from sizing.propulsion.chain import Propulsion
from sizing.smooth import Value
from sizing.structures.loads import StructureInputs

NO_FLIGHT_W = 1e12  # load of what cannot carry itself, or be as fast as the wind


class DesignVariables(NamedTuple):
    """Variables that the optimiser chooses.

    The last seven are chosen on request; None stands for what aircraft and mission say.
    """

    wingspan_m: Value
    aspect_ratio: Value
    battery_mass_kg: Value
    module_area_m2: Value
    lift_coefficient: Value | None = None
    payload_mass_kg: Value | None = None
    payload_power_w: Value | None = None
    propeller_diameter_m: Value | None = None
    propeller_pitch_m: Value | None = None
    gear_ratio: Value | None = None
    motor_speed_constant_rpm_per_v: Value | None = None

    @property
    def of_propulsion(self) -> tuple[Value | None, ...]:
        """Return diameter, pitch [m], gear ratio and speed constant of the motor [rpm/V]."""
        return self[-len(PROPULSION_VARIABLES) :]

    def mapped(self, function: Callable[[Value], Value]) -> DesignVariables:
        """Apply a function to every variable that is chosen."""
        return cast(DesignVariables, each(self, function))

    def broadcast(self) -> DesignVariables:
        """Return every variable that is chosen as an array of floats, all of one shape."""
        chosen = self.chosen()
        arrays = np.broadcast_arrays(*(np.asarray(value, float) for value in chosen.values()))
        return DesignVariables(**dict(zip(chosen, arrays, strict=True)))

    def chosen(self) -> dict[str, Value]:
        """Return the variables that are chosen, by name."""
        return {name: value for name, value in self._asdict().items() if value is not None}


@cache
def variable_keys() -> Mapping[str, str]:
    """Return design variables by their keys in the files; those of the mission have its prefix."""
    named = {
        key: parameter.name
        for key, parameter in catalogue().items()
        if parameter.name in DesignVariables._fields and parameter.name != key
    }
    # The catalogue has it as technology of the airframe, and of a design under its own name.
    lift = {"airframe.aerodynamics.lift_coefficient": "lift_coefficient"}
    return MappingProxyType(named | lift)


class Masses(NamedTuple):
    """Mass budget [kg]."""

    structure: Value = 0.0
    propulsion: Value = 0.0
    battery: Value = 0.0
    modules: Value = 0.0
    mppt: Value = 0.0
    avionics: Value = 0.0
    payload: Value = 0.0
    other: Value = 0.0

    @property
    def total_kg(self) -> Value:
        """Return the take-off mass [kg]."""
        return sum(self[1:], self[0])


class FlightConditions(NamedTuple):
    """Conditions of a mission for a design; numbers, arrays or symbols.

    ``wind_m_per_s``: that the calm airspeed must exceed; none where the place is held.
    """

    density_kg_per_m3: Value
    dynamic_viscosity: Value
    payload_mass_kg: Value
    payload_power_w: Value
    turbulence: Value
    wind_m_per_s: Value
    battery_capacity_fraction: Value
    battery_heater_w: Value
    gust_fraction: Value
    temperature_k: Value
    insulated_heater_w_at_1_kg: Value = 0.0

    @property
    def air(self) -> Air:
        """Return the state of the air, its pressure from density and temperature."""
        pressure = self.density_kg_per_m3 * GAS_CONSTANT_AIR * self.temperature_k
        return Air(self.temperature_k, pressure, self.density_kg_per_m3, self.dynamic_viscosity)

    @classmethod
    def of(cls, mission: Mission | FlightConditions, aircraft: Aircraft) -> FlightConditions:
        """Return the conditions of a mission, and of an aircraft's battery in its air.

        Returns numbers, or arrays where inputs are; conditions themselves as they are.
        """
        if isinstance(mission, FlightConditions):
            return mission
        air = mission.air.state(mission.altitude_m)
        battery, air_c = aircraft.battery, air.temperature_c
        fixed_w, at_1_kg_w = battery.heater_parts_w(air_c, mission.altitude_m)
        left = battery.capacity_fraction(air_c, mission.altitude_m)
        known = cls(
            density_kg_per_m3=air.density_kg_per_m3,
            dynamic_viscosity=air.dynamic_viscosity_pa_s,
            payload_mass_kg=mission.payload.mass_kg,
            payload_power_w=mission.payload.power_w,
            turbulence=mission.turbulence.all_day,
            wind_m_per_s=mission.wind_to_beat_m_per_s(mission.strongest_wind_m_per_s),
            battery_capacity_fraction=mission.uncertainty_margins.battery_capacity * left,
            battery_heater_w=fixed_w,
            gust_fraction=gust_speed_fraction(mission.altitude_m),
            temperature_k=air.temperature_k,
            insulated_heater_w_at_1_kg=at_1_kg_w,
        )
        return cls._make(map(plain_number, known))

    @classmethod
    def of_levels(
        cls, missions: Sequence[Mission], aircraft: Aircraft, axes: int
    ) -> FlightConditions:
        """Return the conditions of a mission at several altitudes, before ``axes`` of designs."""
        rows = zip(*(cls.of(mission, aircraft) for mission in missions), strict=True)
        # A condition may vary with the draws at some levels alone.
        arrays = (
            np.stack(np.broadcast_arrays(*(np.asarray(value, float) for value in values)))
            for values in rows
        )
        return cls._make(
            array.reshape(len(missions), *(1,) * (axes + 1 - array.ndim), *array.shape[1:])
            for array in arrays
        )

    def heater_w(self, battery_mass_kg: Value) -> Value:
        """Return the power that the heater of a battery draws [W]."""
        return self.battery_heater_w + self.insulated_heater_w_at_1_kg * battery_mass_kg ** (
            2.0 / 3.0
        )

    def with_payload_of(self, variables: DesignVariables) -> FlightConditions:
        """Return the conditions with the payload that the design carries, where it is chosen."""
        mass, power = variables.payload_mass_kg, variables.payload_power_w
        return self._replace(
            payload_mass_kg=self.payload_mass_kg if mass is None else mass,
            payload_power_w=self.payload_power_w if power is None else power,
        )


class Design(NamedTuple):
    """A design and what follows from it; numbers, arrays or symbols.

    ``propulsion_power_w`` is electric, of level flight in calm air; ``constant_power_w`` is what
    avionics, payload and the battery's heater draw; ``airspeed_m_per_s`` may be unknown (None) for
    a measured aircraft. ``conditions``: those it was made in, with the payload that it carries.
    ``chain``: efficiencies of the propulsion in level flight, ``sized_from``: what its structure is
    sized from, ``lift_coefficient``: of level flight, ``maximum_lift_coefficient``: at the stall
    [-]; None for a measured aircraft.
    """

    variables: DesignVariables
    total_mass_kg: Value
    masses: Masses
    battery_energy_wh: Value
    propulsion_power_w: Value
    constant_power_w: Value
    airspeed_m_per_s: Value
    conditions: FlightConditions
    chain: Propulsion | None = None
    sized_from: StructureInputs | None = None
    lift_coefficient: Value = None
    maximum_lift_coefficient: Value = None

    @property
    def wing_area_m2(self) -> Value:
        """Return the wing area [m2]."""
        return self.variables.wingspan_m**2 / self.variables.aspect_ratio

    @property
    def chord_m(self) -> Value:
        """Return the mean chord [m]."""
        return self.variables.wingspan_m / self.variables.aspect_ratio

    @property
    def reynolds_number(self) -> Value:
        """Return the Reynolds number of the mean chord in level flight [-]."""
        air = self.conditions
        flow = air.density_kg_per_m3 * self.airspeed_m_per_s * self.chord_m
        return flow / air.dynamic_viscosity

    @property
    def stall_margin(self) -> Value:
        """Return the airspeed over the stall speed [-]."""
        return (self.maximum_lift_coefficient / self.lift_coefficient) ** 0.5

    def mapped(self, function: Callable[[Value], Value]) -> Design:
        """Apply a function to all that a flight depends on; the budget of masses stays."""
        return self._replace(**{name: each(getattr(self, name), function) for name in _OF_FLIGHT})

    def over_scenarios(self) -> Design:
        """Return a batch with an axis for scenarios behind its own; numbers stay."""
        return self.mapped(lambda value: value[..., np.newaxis] if np.ndim(value) else value)

    @property
    def thrust_power_w(self) -> Value:
        """Return drag times airspeed, by the efficiency of the propulsion [W]."""
        assert self.chain is not None
        return self.propulsion_power_w * self.chain.efficiency

    @property
    def rated_power_w(self) -> Value:
        """Return the largest electric power of the propulsion [W]."""
        assert self.chain is not None
        weight_n = self.total_mass_kg * GRAVITY_M_PER_S2
        return self.chain.rated_power_w(self.propulsion_power_w, weight_n=weight_n)

    @property
    def climb_rate_m_per_s(self) -> Value:
        """Return the climb rate at rated power and airspeed of level flight [m/s].

        Excess power over weight.
        """
        assert self.chain is not None
        excess_w = self.rated_power_w - self.propulsion_power_w
        return excess_w * self.chain.efficiency / (self.total_mass_kg * GRAVITY_M_PER_S2)

    @property
    def load_w(self) -> Value:
        """Return the load in the turbulence of its conditions [W]."""
        return self.load_in_turbulence_w(self.conditions.turbulence)

    def nominal_load_w(self, mission: Mission) -> Value:
        """Return the load with the turbulence of all hours, without thermals [W]."""
        return self.load_in_turbulence_w(mission.turbulence.all_day)

    def load_in_turbulence_w(self, turbulence: Value) -> Value:
        """Return the load with so much more propulsion power, relative to level flight [W]."""
        return self.propulsion_power_w * (1.0 + turbulence) + self.constant_power_w


# What a flight depends on.
_OF_FLIGHT = ("variables", "total_mass_kg", "battery_energy_wh", "propulsion_power_w",
              "constant_power_w", "airspeed_m_per_s", "chain", "lift_coefficient",
              "maximum_lift_coefficient")  # fmt: skip


def each(value: Any, function: Callable[[Any], Any]) -> Any:
    """Apply a function to all that a design has, in its tuples and chain as well; None stays."""
    if isinstance(value, Propulsion):
        return value.mapped(function)
    if isinstance(value, tuple):  # design, variables, masses
        return type(value)._make(each(part, function) for part in value)  # type: ignore[attr-defined]  # a NamedTuple
    return None if value is None else function(value)


def picked(design: Design, rows: Any) -> Design:
    """Return a part of a batch of designs, of every array; numbers stay."""

    def part(value: Any) -> Any:
        return value[rows] if getattr(value, "ndim", 0) else value

    return cast(Design, each(design, part))


def variables_of(aircraft: Aircraft) -> DesignVariables:
    """Return the design variables of the aircraft's file."""
    return DesignVariables(
        wingspan_m=aircraft.airframe.wingspan_m,
        aspect_ratio=aircraft.airframe.aspect_ratio,
        battery_mass_kg=aircraft.battery.mass_kg,
        module_area_m2=aircraft.modules.area_m2,
    )


def polar_at(aerodynamics: Polar, lift_coefficient: Value | None) -> Polar:
    """Return the polar in level flight at a chosen lift coefficient.

    ``lift_coefficient``: lift coefficient of level flight [-]; None leaves the polar's own. Not
    validated.
    """
    if lift_coefficient is None:
        return aerodynamics
    return all_replaced(aerodynamics, {"lift_coefficient": lift_coefficient})
