"""A design in one pass, from conditions and an assumed total mass, and the closure around it.

The total mass appears on both sides of the mass budget: structure and propulsion grow with it. The
pass is that of floats, arrays and symbols; the optimiser keeps the mass as a variable and the
budget as a constraint, :func:`closed_design` finds the lightest solution by iteration. A measured
aircraft is scaled instead.
"""

from __future__ import annotations

from operator import itemgetter
from typing import TYPE_CHECKING, cast

import numpy as np

from missions.air import GRAVITY_M_PER_S2, plain_number
from missions.mission import Mission
from sizing.aerodynamics.parabolic import level_airspeed_m_per_s
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.balance.in_design import (
    drag_coefficient,
    polar_with_wires,
    structure_inputs,
    structure_with_tail,
)
from sizing.balance.surfaces import wing_of
from sizing.design import (
    Design,
    DesignVariables,
    FlightConditions,
    Masses,
    each,
    polar_at,
    variables_of,
)
from sizing.propulsion.chain import Propulsion
from sizing.roots import lightest_mass
from sizing.smooth import Value
from solar.modules import STC_IRRADIANCE_W_PER_M2
from solar.schema import spell
from solar.types import BoolArray, FloatArray, IntArray

if TYPE_CHECKING:
    from sizing.propulsion.operating_point import OperatingPoint


class ImpossibleDesignError(ValueError):
    """A design that cannot carry its own mass."""


def parametric_design(
    aircraft: Aircraft,
    mission: Mission | FlightConditions,
    variables: DesignVariables,
    total_mass_kg: Value,
    chain: Propulsion | None = None,
) -> Design:
    """Return masses and power of a parametric aircraft for an assumed total mass.

    The design is consistent where ``masses.total_kg`` equals ``total_mass_kg``. ``chain``: assumed
    efficiencies of the propulsion, instead of those of the aircraft.

    Returns of the type of ``variables`` and ``total_mass_kg``; the budget need not close.
    """
    airframe, lift = aircraft.parametric, variables.lift_coefficient
    polar = airframe.aerodynamics
    air = FlightConditions.of(mission, aircraft).with_payload_of(variables)
    propulsion, electric_w, airspeed = level_flight(aircraft, air, variables, total_mass_kg, chain)
    rated_w = propulsion.rated_power_w(electric_w, weight_n=total_mass_kg * GRAVITY_M_PER_S2)
    propulsion_kg = propulsion.mass_kg(rated_w)
    structure = structure_with_tail(airframe, variables.wingspan_m, variables.aspect_ratio)
    inputs = structure_inputs(aircraft, variables, air, total_mass_kg, airspeed, propulsion_kg)
    modules, battery_kg = aircraft.modules, variables.battery_mass_kg
    peak_w = STC_IRRADIANCE_W_PER_M2 * modules.efficiency_stc * variables.module_area_m2
    grown, specific_energy = 1.0 + airframe.mass_growth, aircraft.battery.specific_energy_wh_per_kg
    masses = Masses(
        structure=grown * structure.mass_kg(inputs),
        propulsion=propulsion_kg,
        battery=battery_kg,
        modules=modules.mass_kg_per_m2 * variables.module_area_m2,
        mppt=modules.mppt_mass_kg_per_w * peak_w,
        avionics=airframe.avionics_mass_kg,
        payload=air.payload_mass_kg,
        other=grown * airframe.other_mass_kg,
    )
    return Design(
        variables=variables,
        total_mass_kg=total_mass_kg,
        masses=masses,
        battery_energy_wh=battery_kg * specific_energy * air.battery_capacity_fraction,
        propulsion_power_w=electric_w,
        constant_power_w=constant_power_w(aircraft, air.payload_power_w) + air.heater_w(battery_kg),
        airspeed_m_per_s=airspeed,
        conditions=air,
        chain=propulsion,
        sized_from=inputs,
        lift_coefficient=polar.flight_lift_coefficient if lift is None else lift,
        maximum_lift_coefficient=polar.maximum_lift_coefficient,
    )


def level_flight(
    aircraft: Aircraft,
    air: FlightConditions,
    variables: DesignVariables,
    total_mass_kg: Value,
    chain: Propulsion | None = None,
) -> tuple[Propulsion, Value, Value]:
    """Return propulsion, electric power [W] and airspeed of level flight at a total mass."""
    airframe, density = aircraft.parametric, air.density_kg_per_m3
    wing = wing_of(airframe.planform, variables.wingspan_m, variables.aspect_ratio)
    polar = polar_at(airframe.aerodynamics, variables.lift_coefficient)
    lift, loading = polar.flight_lift_coefficient, total_mass_kg / wing.area_m2
    airspeed = level_airspeed_m_per_s(lift, loading, density)
    polar = polar_with_wires(aircraft, polar, variables, air, total_mass_kg, airspeed)
    reynolds = density * airspeed * wing.mean_chord_m / air.dynamic_viscosity
    drag_m2 = wing.area_m2 * drag_coefficient(airframe, polar, wing, reynolds)
    thrust_w = 0.5 * density * airspeed**3 * drag_m2
    propulsion = (chain or airframe.propulsion).sized(*variables.of_propulsion)
    links = propulsion.in_flight(thrust_w, airspeed, air.air, aircraft.battery.ends_v)
    return links, thrust_w / links.efficiency, airspeed


def constant_power_w(aircraft: Aircraft, payload_power_w: Value) -> Value:
    """Return the electric power of avionics and payload, drawn from the battery [W].

    ``aircraft``: its avionics, and the efficiency of their power supply. Returns ``(P_avionics +
    P_payload) / eta_supply`` [W].
    """
    return (aircraft.power.avionics_w + payload_power_w) / aircraft.power.supply_efficiency


def measured_design(aircraft: Aircraft, mission: Mission | FlightConditions) -> Design:
    """Return masses and power of a measured aircraft, scaled to the mission's mass and air.

    ``mission``: payload and air. At equal lift coefficient drag follows the weight and airspeed the
    root of weight over density: ``P = P_0 (m / m_0)^1.5 (rho / rho_0)^-0.5``. Returns of floats;
    all but the masses of battery, modules and payload is ``other``.
    """
    airframe = aircraft.airframe
    assert isinstance(airframe, MeasuredAirframe)
    air = FlightConditions.of(mission, aircraft)
    battery_kg = aircraft.battery.mass_kg
    total_kg = airframe.mass_without_battery_kg + battery_kg + air.payload_mass_kg
    flight = airframe.level_flight
    mass_ratio = total_kg / flight.mass_kg
    density_ratio = air.density_kg_per_m3 / flight.density_kg_per_m3
    airspeed = flight.airspeed_m_per_s
    if airspeed is not None:
        airspeed = airspeed * (mass_ratio / density_ratio) ** 0.5
    modules_kg = aircraft.modules.mass_kg_per_m2 * aircraft.modules.area_m2
    return Design(
        variables=variables_of(aircraft),
        total_mass_kg=total_kg,
        masses=Masses(
            battery=battery_kg,
            modules=modules_kg,
            payload=air.payload_mass_kg,
            other=airframe.mass_without_battery_kg - modules_kg,
        ),
        battery_energy_wh=aircraft.battery.battery_energy_wh * air.battery_capacity_fraction,
        propulsion_power_w=flight.electric_power_w * mass_ratio**1.5 * density_ratio**-0.5,
        constant_power_w=constant_power_w(aircraft, air.payload_power_w) + air.heater_w(battery_kg),
        airspeed_m_per_s=airspeed,
        conditions=air,
    )


def closed_design(
    aircraft: Aircraft,
    mission: Mission | FlightConditions,
    variables: DesignVariables,
    *,
    relative_tolerance: float = 1e-13,
) -> Design:
    """Return the design whose mass budget adds up, for variables that may be arrays.

    The lightest solution; where there is none (the aircraft cannot carry itself) mass and power are
    infinite. See :func:`sizing.roots.lightest_mass`.

    Parameters
    ----------
    aircraft, mission
        Technology; air and payload.
    variables : DesignVariables
        Numbers or arrays that broadcast.
    relative_tolerance : float
        Largest change of the mass in the last iteration, relative to it [-].

    Returns
    -------
    Design
        Of arrays of the variables' broadcast shape, infinite mass and power where impossible.

    Raises
    ------
    TypeError
        For a measured aircraft.
    """
    arrays = variables.broadcast()
    flat = arrays.mapped(np.ravel)
    conditions = FlightConditions.of(mission, aircraft)

    def closed(chain: Propulsion | None) -> Design:
        def budget_kg(rows: IntArray, assumed_kg: FloatArray) -> Value:
            open_designs = flat.mapped(itemgetter(rows))
            links = chain and chain.mapped(lambda value: np.ravel(value)[rows])
            design = parametric_design(aircraft, conditions, open_designs, assumed_kg, links)
            return design.masses.total_kg

        total_kg = lightest_mass(budget_kg, flat.battery_mass_kg, relative_tolerance)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            return parametric_design(
                aircraft, conditions, arrays, total_kg.reshape(np.shape(arrays.wingspan_m))
            )

    if not aircraft.propulsion.is_exact:
        return closed(None)
    # Mass and efficiencies settle in rounds. An operating point that does not exist leaves NaN.
    chain = aircraft.propulsion.first_chain()
    chain = chain.mapped(lambda value: np.full(np.shape(arrays[0]), value))
    for _ in range(_ROUNDS):
        design = closed(chain)
        assert design.chain is not None
        chain = design.chain
        with np.errstate(invalid="ignore"):
            open_share = np.abs(design.masses.total_kg / design.total_mass_kg - 1.0)
        if not np.any(open_share > _SETTLED):
            break
    return _impossible_where(design, ~np.isfinite(np.asarray(chain.efficiency)))


def _impossible_where(design: Design, missing: BoolArray) -> Design:
    """Return a design of arrays with infinite mass and power where something is missing."""
    return design._replace(
        total_mass_kg=np.where(missing, np.inf, design.total_mass_kg),
        masses=Masses(*(np.where(missing, np.inf, mass_kg) for mass_kg in design.masses)),
        propulsion_power_w=np.where(missing, np.inf, design.propulsion_power_w),
    )


# Rounds in which mass and efficiencies settle, and what may then be open of the mass budget.
_ROUNDS, _SETTLED = 30, 1e-10


# Of flights whose airspeed nobody measured, and of first guesses that cannot fly: lift coefficient
# of level flight (Noth 2008, Design of solar powered airplanes for continuous flight) and wing
# loading [kg/m2], in the middle of what has been built.
_LIFT_COEFFICIENT, _WING_LOADING = 0.8, 4.0


def airspeed_in_flight(aircraft: Aircraft, mission: Mission) -> float:
    """Return the airspeed of level flight of an aircraft's file, estimated where unknown [m/s]."""
    loading = _WING_LOADING
    if isinstance(aircraft.airframe, MeasuredAirframe):
        design = measured_design(aircraft, mission)
        loading = float(design.total_mass_kg / design.wing_area_m2)
    else:
        aircraft = aircraft.with_airframe(propulsion=aircraft.propulsion.first_chain())
        design = closed_design(aircraft, mission, variables_of(aircraft))
    known = design.airspeed_m_per_s
    if known is not None and np.isfinite(known):
        return float(known)
    density = design.conditions.density_kg_per_m3
    return float(level_airspeed_m_per_s(_LIFT_COEFFICIENT, loading, density))


def design_of(aircraft: Aircraft, mission: Mission) -> Design:
    """Return the design of an aircraft's file on a mission.

    Parameters
    ----------
    aircraft, mission
        Measured or parametric aircraft; air and payload.

    Returns
    -------
    Design
        Of floats, with the variables of the aircraft's file.

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
            operating_trouble(aircraft, mission)
            or f"{aircraft.name} cannot carry its own mass on mission {mission.name}: structure "
            "and propulsion grow faster than the lift they add"
        )
    return plain_design(design)


def plain_design(design: Design) -> Design:
    """Turn a design of zero-dimensional arrays into one of floats."""
    return cast(Design, each(design, plain_number))


def operating_trouble(
    aircraft: Aircraft, mission: Mission, variables: DesignVariables | None = None
) -> str:
    """Return why the propulsors cannot do level flight, as a sentence; empty where they can.

    ``variables``: of the design, by default those of the aircraft's file.
    """
    reason, where = operating_reason(aircraft, mission, variables), mission.name
    return reason and (
        f"the propulsion of {aircraft.name} cannot do level flight on {where} at "
        f"{spell(mission.altitude_m)} m: {reason}"
    )


def operating_reason(
    aircraft: Aircraft, mission: Mission, variables: DesignVariables | None = None
) -> str:
    """Return the limit that the propulsors exceed in level flight, and a remedy; empty if none."""
    propulsion = aircraft.propulsion_by_parts
    if propulsion is None:
        return ""
    variables = variables_of(aircraft) if variables is None else variables
    # With usual efficiencies where the propeller's data end.
    for chain in (propulsion.without_limits(), propulsion.first_chain()):
        design = closed_design(aircraft.with_airframe(propulsion=chain), mission, variables)
        if np.isfinite(design.total_mass_kg):
            return str(level_point(aircraft, mission, design).reason)
    return ""


def level_point(aircraft: Aircraft, mission: Mission, design: Design) -> OperatingPoint:
    """Return the operating point of a propulsor of a design of known mass in level flight."""
    propulsion = aircraft.propulsion_by_parts
    assert propulsion is not None
    usual, mass_kg = propulsion.first_chain(), design.total_mass_kg
    flight = parametric_design(aircraft, mission, design.variables, mass_kg, usual)
    speed, air = flight.airspeed_m_per_s, flight.conditions.air
    parts = propulsion.sized(*design.variables.mapped(float).of_propulsion)
    return parts.point(flight.thrust_power_w, speed, air, aircraft.battery.ends_v)


def design_of_total_mass(
    aircraft: Aircraft, mission: Mission, variables: DesignVariables, total_mass_kg: float
) -> Design:
    """Return designs of a known total mass; infinite mass and power where the parts are heavier."""
    conditions = FlightConditions.of(mission, aircraft)
    arrays = variables.broadcast()
    total = np.full(np.shape(arrays.wingspan_m), total_mass_kg)
    design = parametric_design(aircraft, conditions, arrays, total)
    other_kg = total_mass_kg - (design.masses.total_kg - design.masses.other)
    design = design._replace(masses=design.masses._replace(other=other_kg))
    with np.errstate(invalid="ignore"):
        return _impossible_where(design, ~(other_kg >= 0.0))


def with_total_mass(aircraft: Aircraft, mission: Mission, total_mass_kg: float) -> Aircraft:
    """Return the aircraft of a known total mass: the rest of its mass budget is other mass.

    Parameters
    ----------
    aircraft, mission
        Aircraft as its file gives it; air and payload.
    total_mass_kg : float
        Take-off mass, payload included [kg].

    Returns
    -------
    Aircraft
        With ``airframe.other_mass_kg`` (of a measured aircraft ``mass_without_battery_kg``)
        changed; structure and propulsion are those of the total mass.

    Raises
    ------
    ImpossibleDesignError
        If the parts alone are heavier.
    """
    airframe = aircraft.airframe
    if isinstance(airframe, MeasuredAirframe):
        rest_kg = aircraft.battery.mass_kg + mission.payload.mass_kg
    else:
        masses = parametric_design(aircraft, mission, variables_of(aircraft), total_mass_kg).masses
        rest_kg = float(masses.total_kg - masses.other)
    key = airframe.unaccounted_mass_key
    other_kg = total_mass_kg - rest_kg
    if other_kg < 0.0 or (other_kg == 0.0 and isinstance(airframe, MeasuredAirframe)):
        raise ImpossibleDesignError(
            f"the parts of {aircraft.name} weigh {round(rest_kg, 3)} kg already, without "
            f"airframe.{key}: more than the total mass of {spell(total_mass_kg)} kg"
        )
    grown = 1.0 if isinstance(airframe, MeasuredAirframe) else 1.0 + airframe.mass_growth
    return aircraft.with_airframe(**{key: other_kg / grown})
