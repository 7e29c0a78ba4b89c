"""From design variables to masses and power: the mass closure of a parametric aircraft.

The same formulas serve floats, arrays and symbols. The total mass appears on both sides of the
mass budget (structure and propulsion grow with it); the optimiser keeps it as a variable and the
budget as a constraint, :func:`closed_design` solves it by iteration.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from missions.mission import Mission
from sizing.aerodynamics import level_flight_power_w, scaled_power_w
from sizing.aircraft import Aircraft, MeasuredAirframe, ParametricAirframe
from sizing.structure import Value
from solar.modules import STC_IRRADIANCE_W_PER_M2


class ImpossibleDesignError(ValueError):
    """A design that cannot carry its own mass."""


class DesignVariables(NamedTuple):
    """What the optimiser chooses."""

    wingspan_m: Value
    aspect_ratio: Value
    battery_mass_kg: Value
    module_area_m2: Value


class Masses(NamedTuple):
    """Mass budget [kg]."""

    structure: Value
    propulsion: Value
    battery: Value
    modules: Value
    mppt: Value
    avionics: Value
    payload: Value
    other: Value

    @property
    def total_kg(self) -> Value:
        """Take-off mass [kg]."""
        return sum(self[1:], self[0])


class Design(NamedTuple):
    """A design and what follows from it; numbers, arrays or symbols.

    ``propulsion_power_w`` is electric, of level flight in calm air; ``constant_power_w`` is what
    avionics and payload draw; ``airspeed_m_per_s`` may be unknown (None) for a measured aircraft.
    """

    variables: DesignVariables
    total_mass_kg: Value
    masses: Masses
    battery_energy_wh: Value
    propulsion_power_w: Value
    constant_power_w: Value
    airspeed_m_per_s: Value

    @property
    def wing_area_m2(self) -> Value:
        """Wing area [m2]."""
        return self.variables.wingspan_m**2 / self.variables.aspect_ratio

    def nominal_load_w(self, mission: Mission) -> Value:
        """Load with the turbulence of all hours, without thermals [W]."""
        factor = 1.0 + mission.turbulence.all_day
        return self.propulsion_power_w * factor + self.constant_power_w


@dataclass(frozen=True)
class _FlightAir:
    density: float
    dynamic_viscosity: float

    @classmethod
    def of(cls, mission: Mission) -> _FlightAir:
        air = mission.air_state()
        return cls(float(air.density_kg_per_m3), float(air.dynamic_viscosity_pa_s))


def constant_power_w(aircraft: Aircraft, mission: Mission) -> float:
    """Electric power of avionics and payload [W]."""
    return (aircraft.power.avionics_w + mission.payload.power_w) / aircraft.power.supply_efficiency


def variables_of(aircraft: Aircraft) -> DesignVariables:
    """Design variables as the aircraft's file gives them."""
    return DesignVariables(
        wingspan_m=aircraft.airframe.wingspan_m,
        aspect_ratio=aircraft.airframe.aspect_ratio,
        battery_mass_kg=aircraft.battery.mass_kg,
        module_area_m2=aircraft.modules.area_m2,
    )


def parametric_design(
    aircraft: Aircraft, mission: Mission, variables: DesignVariables, total_mass_kg: Value
) -> Design:
    """Masses and power of a parametric aircraft for an assumed total mass.

    The design is consistent where ``masses.total_kg`` equals ``total_mass_kg``.

    Raises
    ------
    TypeError
        For a measured aircraft, whose mass does not follow from its geometry.
    """
    airframe = aircraft.airframe
    if not isinstance(airframe, ParametricAirframe):
        raise TypeError(f"{aircraft.name} is a measured aircraft: it has no mass budget to size")
    air = _FlightAir.of(mission)
    shaft_w = level_flight_power_w(
        airframe.aerodynamics,
        mass_kg=total_mass_kg,
        wingspan_m=variables.wingspan_m,
        aspect_ratio=variables.aspect_ratio,
        density=air.density,
        dynamic_viscosity=air.dynamic_viscosity,
    )
    electric_w = shaft_w / airframe.propulsion.efficiency
    airspeed = airframe.aerodynamics.airspeed_m_per_s(
        mass_kg=total_mass_kg,
        wing_area_m2=variables.wingspan_m**2 / variables.aspect_ratio,
        density=air.density,
    )
    return Design(
        variables=variables,
        total_mass_kg=total_mass_kg,
        masses=_masses(aircraft, airframe, mission, variables, total_mass_kg, electric_w),
        battery_energy_wh=variables.battery_mass_kg * aircraft.battery.specific_energy_wh_per_kg,
        propulsion_power_w=electric_w,
        constant_power_w=constant_power_w(aircraft, mission),
        airspeed_m_per_s=airspeed,
    )


def _masses(
    aircraft: Aircraft,
    airframe: ParametricAirframe,
    mission: Mission,
    variables: DesignVariables,
    total_mass_kg: Value,
    electric_w: Value,
) -> Masses:
    modules = aircraft.modules
    modules_kg = modules.mass_kg_per_m2 * variables.module_area_m2
    rated_w = STC_IRRADIANCE_W_PER_M2 * modules.efficiency_stc * variables.module_area_m2
    span_load_kg = modules_kg + airframe.distributed_battery_fraction * variables.battery_mass_kg
    propulsion = airframe.propulsion
    return Masses(
        structure=airframe.structure.mass_kg(
            wingspan_m=variables.wingspan_m,
            aspect_ratio=variables.aspect_ratio,
            total_mass_kg=total_mass_kg,
            span_load_kg=span_load_kg,
        ),
        propulsion=propulsion.mass_kg_per_w * propulsion.climb_power_ratio * electric_w,
        battery=variables.battery_mass_kg,
        modules=modules_kg,
        mppt=modules.mppt_mass_kg_per_w * rated_w,
        avionics=airframe.avionics_mass_kg,
        payload=mission.payload.mass_kg,
        other=airframe.other_mass_kg,
    )


def measured_design(aircraft: Aircraft, mission: Mission) -> Design:
    """Masses and power of a measured aircraft, scaled to the mission's mass and air."""
    airframe = aircraft.airframe
    assert isinstance(airframe, MeasuredAirframe)
    air = _FlightAir.of(mission)
    battery_kg = aircraft.battery.mass_kg
    total_kg = airframe.mass_without_battery_kg + battery_kg + mission.payload.mass_kg
    flight = airframe.level_flight
    mass_ratio = total_kg / flight.mass_kg
    density_ratio = air.density / flight.density_kg_per_m3
    airspeed = flight.airspeed_m_per_s
    if airspeed is not None:
        airspeed = airspeed * (mass_ratio / density_ratio) ** 0.5
    modules_kg = aircraft.modules.mass_kg_per_m2 * aircraft.modules.area_m2
    return Design(
        variables=variables_of(aircraft),
        total_mass_kg=total_kg,
        masses=Masses(
            structure=0.0,
            propulsion=0.0,
            battery=battery_kg,
            modules=modules_kg,
            mppt=0.0,
            avionics=0.0,
            payload=mission.payload.mass_kg,
            other=airframe.mass_without_battery_kg - modules_kg,
        ),
        battery_energy_wh=aircraft.battery.energy_wh,
        propulsion_power_w=scaled_power_w(
            flight.electric_power_w, mass_ratio=mass_ratio, density_ratio=density_ratio
        ),
        constant_power_w=constant_power_w(aircraft, mission),
        airspeed_m_per_s=airspeed,
    )


def closed_design(
    aircraft: Aircraft,
    mission: Mission,
    variables: DesignVariables,
    *,
    relative_tolerance: float = 1e-13,
) -> Design:
    """Design whose mass budget adds up, for variables that may be arrays.

    The budget grows faster than the mass it assumes, so the iteration from below climbs to the
    lightest solution; where there is none (the aircraft cannot carry itself) mass and power are
    infinite.
    """
    arrays = DesignVariables(*np.broadcast_arrays(*(np.asarray(v, float) for v in variables)))
    mass = np.asarray(arrays.battery_mass_kg, float)
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(2000):
            budget = np.asarray(parametric_design(aircraft, mission, arrays, mass).masses.total_kg)
            budget = np.where(np.isfinite(budget) & (budget < 1e9), budget, np.inf)
            settled = (budget <= mass * (1.0 + relative_tolerance)) | np.isinf(budget)
            mass = budget
            if np.all(settled):
                break
        else:
            mass = np.where(settled, mass, np.inf)
        return parametric_design(aircraft, mission, arrays, mass)


def design_of(aircraft: Aircraft, mission: Mission) -> Design:
    """Design of an aircraft as its file gives it, flying a mission.

    Raises
    ------
    ImpossibleDesignError
        If a parametric aircraft cannot carry its own mass.
    """
    if isinstance(aircraft.airframe, MeasuredAirframe):
        return measured_design(aircraft, mission)
    design = closed_design(aircraft, mission, variables_of(aircraft))
    if not np.isfinite(design.total_mass_kg):
        raise ImpossibleDesignError(
            f"{aircraft.name} cannot carry its own mass on mission {mission.name}: structure and "
            "propulsion grow faster than the lift they add"
        )
    return Design(
        variables=variables_of(aircraft),
        total_mass_kg=float(design.total_mass_kg),
        masses=Masses(*(float(m) for m in design.masses)),
        battery_energy_wh=float(design.battery_energy_wh),
        propulsion_power_w=float(design.propulsion_power_w),
        constant_power_w=design.constant_power_w,
        airspeed_m_per_s=float(design.airspeed_m_per_s),
    )


def load_profile(
    time_h: ArrayLike, design: Design, mission: Mission, sunrise_h: ArrayLike, sunset_h: ArrayLike
) -> Value:
    """Load over the day [W], shape ``(..., time)``: level flight, turbulence and thermals.

    ``sunrise_h`` and ``sunset_h`` have the shape of the batch.
    """
    propulsion = np.asarray(design.propulsion_power_w)[..., np.newaxis]
    constant = np.asarray(design.constant_power_w)[..., np.newaxis]
    steady = 1.0 + mission.turbulence.all_day
    if mission.turbulence.thermal == 0.0:
        load = propulsion * steady + constant
        shape = np.broadcast_shapes(load.shape, (*np.shape(sunrise_h), np.size(time_h)))
        return np.broadcast_to(load, shape)
    thermal = mission.turbulence.thermal * thermal_shape(time_h, sunrise_h, sunset_h)
    return propulsion * (steady + thermal) + constant


def thermal_shape(time_h: ArrayLike, sunrise_h: ArrayLike, sunset_h: ArrayLike) -> Value:
    """Triangle over the lit day: 0 at sunrise and sunset, 1 half-way between; ``(..., time)``."""
    rise = np.asarray(sunrise_h, float)[..., np.newaxis]
    half = (np.asarray(sunset_h, float)[..., np.newaxis] - rise) / 2.0
    distance = np.abs(np.asarray(time_h, float) - (rise + half))
    lit = half > 0.0
    return np.where(lit, np.maximum(1.0 - distance / np.where(lit, half, 1.0), 0.0), 0.0)
