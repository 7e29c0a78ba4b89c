"""From design variables to masses and power: the mass closure of a parametric aircraft.

The same formulas serve floats, arrays and symbols. The total mass appears on both sides of the
mass budget (structure and propulsion grow with it); the optimiser keeps it as a variable and the
budget as a constraint, :func:`closed_design` solves it by iteration.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cache
from operator import itemgetter
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from missions.air import GRAVITY_M_PER_S2, Air
from missions.mission import Mission
from sizing.aerodynamics.parabolic import (
    DragPolar,
    OwnDragPolar,
    Polar,
    level_flight_power_w,
    scaled_power_w,
)
from sizing.aerodynamics.wing_polar import WingPolar
from sizing.aircraft import (
    PROPULSION_VARIABLES,
    Aircraft,
    MeasuredAirframe,
    ParametricAirframe,
)
from sizing.balance.in_design import (
    polar_with_tail,
    structure_with_tail,
    with_horizontal_tail,
)
from sizing.balance.placing import balance_rows, margin_error, sizes_tail, tail_volume
from sizing.parameters import all_replaced, catalogue, replaced
from sizing.propulsion.chain import (
    LINKS,
    ChainOfParts,
    OperatingPointPropulsion,
    Propulsion,
    air_of,
)
from sizing.smooth import Value
from sizing.structures.assessment import StructureAssessment, assess, flight_envelope
from sizing.structures.loads import StructureInputs, gust_speed_fraction
from sizing.structures.models import CALIBRATIONS, other_model
from sizing.structures.rib_wing import RibWingStructure
from sizing.structures.rib_wing_keys import StructureParts
from solar.modules import STC_IRRADIANCE_W_PER_M2
from solar.types import FloatArray, IntArray

if TYPE_CHECKING:
    from sizing.propulsion.operating_point import OperatingPoint
    from sizing.propulsion.part_load import PartLoad


class ImpossibleDesignError(ValueError):
    """A design that cannot carry its own mass."""


class DesignVariables(NamedTuple):
    """What the optimiser chooses.

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
        """Diameter and pitch of the propeller [m], gear and speed constant of the motor [rpm/V]."""
        return self[-len(PROPULSION_VARIABLES) :]

    def mapped(self, function: Callable[[Value], Value]) -> DesignVariables:
        """Apply a function to every variable that is chosen."""
        return DesignVariables(*(None if v is None else function(v) for v in self))

    def chosen(self) -> dict[str, Value]:
        """Variables that are chosen, by name."""
        return {name: value for name, value in self._asdict().items() if value is not None}


@cache
def variable_keys() -> Mapping[str, str]:
    """Design variables by their keys in the files; those of the mission have its prefix."""
    named = {
        key: one.name
        for key, one in catalogue().items()
        if one.name in DesignVariables._fields and one.name != key
    }
    # The catalogue has it as technology of the airframe, and of a design under its own name.
    lift = {"airframe.aerodynamics.lift_coefficient": "lift_coefficient"}
    return MappingProxyType(named | lift)


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
    avionics, payload and the battery's heater draw; ``airspeed_m_per_s`` may be unknown (None) for
    a measured aircraft. ``chain``: efficiencies of the propulsion in level flight; None for a
    measured aircraft. ``horizontal_volume``: volume coefficient of the horizontal tail, where its
    size follows from the static margin; None leaves the file's.
    """

    variables: DesignVariables
    total_mass_kg: Value
    masses: Masses
    battery_energy_wh: Value
    propulsion_power_w: Value
    constant_power_w: Value
    airspeed_m_per_s: Value
    chain: Propulsion | None = None
    horizontal_volume: Value | None = None

    @property
    def wing_area_m2(self) -> Value:
        """Wing area [m2]."""
        return self.variables.wingspan_m**2 / self.variables.aspect_ratio

    def mapped(self, function: Callable[[Value], Value]) -> Design:
        """Apply a function to all that level flight depends on; the budget of masses stays."""
        return self._replace(
            variables=self.variables.mapped(function),
            total_mass_kg=function(self.total_mass_kg),
            propulsion_power_w=function(self.propulsion_power_w),
            airspeed_m_per_s=function(self.airspeed_m_per_s),
            chain=None if self.chain is None else _links_of(self.chain, function),
            horizontal_volume=(
                None if self.horizontal_volume is None else function(self.horizontal_volume)
            ),
        )

    def nominal_load_w(self, mission: Mission) -> Value:
        """Load with the turbulence of all hours, without thermals [W]."""
        return self.load_in_turbulence_w(mission.turbulence.all_day)

    def load_in_turbulence_w(self, turbulence: Value) -> Value:
        """Load with that much more propulsion power, relative to level flight [W]."""
        return self.propulsion_power_w * (1.0 + turbulence) + self.constant_power_w


class FlightConditions(NamedTuple):
    """What the design needs to know of a mission; numbers or symbols.

    ``wind_m_per_s``: that its own airspeed must exceed; none where it flies faster to hold its
    place.
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
        """State of the air."""
        return air_of(self.density_kg_per_m3, self.dynamic_viscosity, self.temperature_k)

    @classmethod
    def of(cls, mission: Mission | FlightConditions, aircraft: Aircraft) -> FlightConditions:
        """Conditions of a mission, and what its air and age leave of an aircraft's battery.

        Returns numbers, or arrays where inputs are; conditions themselves as they are.
        """
        if isinstance(mission, FlightConditions):
            return mission
        air = mission.air_state()
        battery, air_c = aircraft.battery, _scalar(air.temperature_c)
        fixed_w, at_1_kg_w = battery.heater_parts_w(air_c, mission.altitude_m)
        left = battery.capacity_fraction(air_c, mission.altitude_m)
        return cls(
            density_kg_per_m3=_scalar(air.density_kg_per_m3),
            dynamic_viscosity=_scalar(air.dynamic_viscosity_pa_s),
            payload_mass_kg=mission.payload.mass_kg,
            payload_power_w=mission.payload.power_w,
            turbulence=mission.turbulence.all_day,
            wind_m_per_s=0.0 if mission.holds_station else mission.strongest_wind_m_per_s,
            battery_capacity_fraction=_scalar(mission.uncertainty_margins.battery_capacity * left),
            battery_heater_w=_scalar(fixed_w),
            gust_fraction=_scalar(gust_speed_fraction(mission.altitude_m)),
            temperature_k=_scalar(air.temperature_k),
            insulated_heater_w_at_1_kg=_scalar(at_1_kg_w),
        )

    def heater_w(self, battery_mass_kg: Value) -> Value:
        """Power that the heater of a battery draws [W]."""
        return self.battery_heater_w + self.insulated_heater_w_at_1_kg * battery_mass_kg ** (
            2.0 / 3.0
        )

    def with_payload_of(self, variables: DesignVariables) -> FlightConditions:
        """Conditions with the payload that the design carries, where it is chosen."""
        mass, power = variables.payload_mass_kg, variables.payload_power_w
        return self._replace(
            payload_mass_kg=self.payload_mass_kg if mass is None else mass,
            payload_power_w=self.payload_power_w if power is None else power,
        )


def _scalar(value: Value) -> Value:
    """Array without a dimension as the number that it is; others as they are."""
    return float(value) if np.ndim(value) == 0 else value


def constant_power_w(aircraft: Aircraft, payload_power_w: Value) -> Value:
    """Electric power of avionics and payload, drawn from the battery [W].

    ``aircraft``: its avionics, and the efficiency of their power supply. Returns ``(P_avionics +
    P_payload) / eta_supply`` [W].
    """
    return (aircraft.power.avionics_w + payload_power_w) / aircraft.power.supply_efficiency


def variables_of(aircraft: Aircraft) -> DesignVariables:
    """Design variables as the aircraft's file gives them."""
    return DesignVariables(
        wingspan_m=aircraft.airframe.wingspan_m,
        aspect_ratio=aircraft.airframe.aspect_ratio,
        battery_mass_kg=aircraft.battery.mass_kg,
        module_area_m2=aircraft.modules.area_m2,
    )


def parametric_design(
    aircraft: Aircraft,
    mission: Mission | FlightConditions,
    variables: DesignVariables,
    total_mass_kg: Value,
    chain: Propulsion | None = None,
    horizontal_volume: Value | None = None,
) -> Design:
    """Masses and power of a parametric aircraft for an assumed total mass.

    The design is consistent where ``masses.total_kg`` equals ``total_mass_kg``. ``chain``: assumed
    efficiencies of the propulsion, instead of those of the aircraft. ``horizontal_volume``: of the
    tail, by default that of the file, or the one that the static margin asks for (numbers only).

    Returns of the type of ``variables`` and ``total_mass_kg``; the budget need not close.
    """
    airframe = aircraft.airframe
    if not isinstance(airframe, ParametricAirframe):
        raise TypeError(f"{aircraft.name} is a measured aircraft: it has no mass budget to size")
    air = FlightConditions.of(mission, aircraft).with_payload_of(variables)

    def with_tail(volume: Value | None) -> Design:
        own = with_horizontal_tail(aircraft, volume)
        return _with_own_tail(own, air, variables, total_mass_kg, chain, volume)

    if horizontal_volume is None and airframe.balance is not None and sizes_tail(aircraft):

        def error(volume: FloatArray) -> FloatArray:
            design = with_tail(volume)
            return np.asarray(margin_error(*_margin_of(aircraft, air, design)), float)

        horizontal_volume = _scalar(tail_volume(airframe.balance, error))
    return with_tail(horizontal_volume)


def _with_own_tail(
    aircraft: Aircraft,
    air: FlightConditions,
    variables: DesignVariables,
    total_mass_kg: Value,
    chain: Propulsion | None,
    horizontal_volume: Value | None,
) -> Design:
    """Design of an aircraft whose file has its tail, and the payload that it carries."""
    airframe = aircraft.airframe
    assert isinstance(airframe, ParametricAirframe)
    found, electric_w, airspeed = level_flight(aircraft, air, variables, total_mass_kg, chain)
    weight_n = total_mass_kg * GRAVITY_M_PER_S2
    propulsion_kg = found.mass_kg(found.rated_power_w(electric_w, weight_n=weight_n))
    structure = structure_with_tail(airframe, variables.wingspan_m, variables.aspect_ratio)
    inputs = structure_inputs(aircraft, variables, air, total_mass_kg, airspeed, propulsion_kg)
    modules, battery_kg = aircraft.modules, variables.battery_mass_kg
    rated_w = STC_IRRADIANCE_W_PER_M2 * modules.efficiency_stc * variables.module_area_m2
    grown, specific_energy = 1.0 + airframe.mass_growth, aircraft.battery.specific_energy_wh_per_kg
    masses = Masses(
        structure=grown * structure.mass_kg(inputs),
        propulsion=propulsion_kg,
        battery=battery_kg,
        modules=modules.mass_kg_per_m2 * variables.module_area_m2,
        mppt=modules.mppt_mass_kg_per_w * rated_w,
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
        chain=found,
        horizontal_volume=horizontal_volume,
    )


def balance_inputs(
    aircraft: Aircraft, conditions: FlightConditions, design: Design
) -> tuple[ParametricAirframe, StructureInputs]:
    """Airframe with the tail of a design, and what its structure is sized from."""
    airframe = with_horizontal_tail(aircraft, design.horizontal_volume).airframe
    assert isinstance(airframe, ParametricAirframe)
    inputs = structure_inputs(
        aircraft,
        design.variables,
        conditions.with_payload_of(design.variables),
        design.total_mass_kg,
        design.airspeed_m_per_s,
        design.masses.propulsion,
    )
    return airframe, inputs


def margin_rows(
    aircraft: Aircraft, conditions: FlightConditions, design: Design
) -> dict[str, Value]:
    """Rows of the static margin that the file asks for, see :func:`balance_rows`."""
    balance = getattr(aircraft.airframe, "balance", None)
    if balance is None or balance.static_margin is None:
        return {}
    return balance_rows(*_margin_of(aircraft, conditions, design))


def _margin_of(
    aircraft: Aircraft, conditions: FlightConditions, design: Design
) -> tuple[ParametricAirframe, Masses, StructureInputs]:
    """Airframe, masses and inputs of the structure, which the static margin follows from."""
    airframe, inputs = balance_inputs(aircraft, conditions, design)
    return airframe, design.masses, inputs


def level_flight(
    aircraft: Aircraft,
    air: FlightConditions,
    variables: DesignVariables,
    total_mass_kg: Value,
    chain: Propulsion | None = None,
) -> tuple[Propulsion, Value, Value]:
    """Propulsion of a parametric aircraft in level flight, its electric power [W] and airspeed."""
    airframe = aircraft.airframe
    assert isinstance(airframe, ParametricAirframe)
    polar = flown_at(airframe.aerodynamics, variables.lift_coefficient)
    airspeed = polar.airspeed_m_per_s(
        mass_kg=total_mass_kg,
        wing_area_m2=variables.wingspan_m**2 / variables.aspect_ratio,
        density_kg_per_m3=air.density_kg_per_m3,
    )
    aerodynamics = polar_with_tail(
        airframe,
        _with_wires(polar, aircraft, variables, air, total_mass_kg, airspeed),
        variables.wingspan_m,
        variables.aspect_ratio,
    )
    shaft_w = level_flight_power_w(
        aerodynamics,
        mass_kg=total_mass_kg,
        wingspan_m=variables.wingspan_m,
        aspect_ratio=variables.aspect_ratio,
        density_kg_per_m3=air.density_kg_per_m3,
        dynamic_viscosity=air.dynamic_viscosity,
    )
    found = airframe.propulsion if chain is None else chain
    if isinstance(found, OperatingPointPropulsion):
        found = found.sized(*variables.of_propulsion)
        found = found.in_flight(shaft_w, airspeed, air.air, bus_voltage_v(aircraft))
    elif found.efficiency_model is not None:
        found = found.in_level_flight(shaft_w, airspeed, air.density_kg_per_m3)
    return found, shaft_w / found.efficiency, airspeed


def propulsion_margins(
    aircraft: Aircraft, design: Design, conditions: FlightConditions
) -> dict[str, Value]:
    """How far a propulsion by formulas is from the limits of its parts; empty for others."""
    propulsion = aircraft.propulsion_by_parts
    if propulsion is None or propulsion.is_exact:
        return {}
    from sizing.propulsion.smooth_chain import SmoothPropulsion

    assert isinstance(propulsion, SmoothPropulsion)
    assert design.chain is not None
    # The thrust, whatever the propulsion's own efficiency is.
    thrust_w = design.propulsion_power_w * design.chain.efficiency
    own = propulsion.sized(*design.variables.of_propulsion)
    speed, bus_v = design.airspeed_m_per_s, bus_voltage_v(aircraft)
    return own.margins(thrust_w, speed, conditions.air, bus_v)


def bus_voltage_v(aircraft: Aircraft) -> tuple[float, float]:
    """Voltages of the bus with an empty and with a full battery [V]."""
    ends_v = aircraft.battery.ends_v
    assert ends_v is not None  # refused at validation
    return ends_v


def flown_at(
    aerodynamics: DragPolar | OwnDragPolar | WingPolar, lift_coefficient: Value | None
) -> Polar:
    """Polar in level flight at a chosen lift coefficient.

    ``lift_coefficient``: lift coefficient of level flight [-]; None leaves the polar's own. Returns
    same polar with ``lift_coefficient`` replaced, not validated.
    """
    if lift_coefficient is None:
        return aerodynamics
    return replaced(aerodynamics, ["lift_coefficient"], lift_coefficient)


def _with_wires(
    polar: Polar,
    aircraft: Aircraft,
    variables: DesignVariables,
    air: FlightConditions,
    total_mass_kg: Value,
    airspeed_m_per_s: Value,
) -> Polar:
    """Polar with the drag of the wires that carry the wing; itself where there are none."""
    structure = getattr(aircraft.airframe, "structure", None)
    if not isinstance(structure, RibWingStructure) or structure.bracing is None:
        return polar
    assert isinstance(polar, DragPolar | WingPolar)  # others are refused at validation
    inputs = structure_inputs(aircraft, variables, air, total_mass_kg, airspeed_m_per_s, 0.0)
    wing = structure.wing(inputs)
    added = structure.wires(wing).drag_area_m2 / wing.wing_area_m2
    return replaced(polar, ["parasitic_drag_coefficient"], polar.parasitic_drag_coefficient + added)


def structure_inputs(
    aircraft: Aircraft,
    variables: DesignVariables,
    air: FlightConditions,
    total_mass_kg: Value,
    airspeed_m_per_s: Value,
    propulsion_kg: Value,
) -> StructureInputs:
    """Inputs of the structure; along the span lie the modules and the shares of the file."""
    airframe = aircraft.airframe
    assert isinstance(airframe, ParametricAirframe)
    battery_kg = airframe.distributed_battery_fraction * variables.battery_mass_kg
    systems_kg = airframe.avionics_mass_kg + air.payload_mass_kg + airframe.other_mass_kg
    along_kg = battery_kg + airframe.distributed_propulsion_fraction * propulsion_kg
    along_kg = along_kg + airframe.distributed_systems_fraction * systems_kg
    return StructureInputs(
        wingspan_m=variables.wingspan_m,
        aspect_ratio=variables.aspect_ratio,
        total_mass_kg=total_mass_kg,
        span_load_kg=aircraft.modules.mass_kg_per_m2 * variables.module_area_m2 + along_kg,
        airspeed_m_per_s=airspeed_m_per_s,
        density_kg_per_m3=air.density_kg_per_m3,
        wing_battery_kg=battery_kg,
        pod_battery_kg=variables.battery_mass_kg - battery_kg,
        gust_fraction=air.gust_fraction,
    )


def structure_parts(aircraft: Aircraft, mission: Mission, design: Design) -> StructureParts | None:
    """Masses of the structure's parts, without the airframe's mass growth.

    Returns masses [kg]; None where the model of the structure knows no parts.
    """
    sized = _sized_rib_wing(aircraft, mission, design)
    return None if sized is None else sized[0].breakdown(sized[1])


def structure_assessment(
    aircraft: Aircraft, mission: Mission, design: Design
) -> StructureAssessment | None:
    """What sizes the structure, and how far it bends and twists.

    None where the model of the structure does not say.
    """
    sized = _sized_rib_wing(aircraft, mission, design)
    if sized is None:
        return None
    assert isinstance(aircraft.airframe, ParametricAirframe)
    polar = flown_at(aircraft.airframe.aerodynamics, design.variables.lift_coefficient)
    return replace(
        assess(*sized),
        remarks=tuple(_structure_remarks(aircraft, *sized)),
        envelope=flight_envelope(*sized, float(polar.maximum_lift_coefficient)),
    )


def _structure_remarks(
    aircraft: Aircraft, model: RibWingStructure, inputs: StructureInputs
) -> Iterator[str]:
    """What the criteria of the structure do not cover, and a key whose sense has changed."""
    tail = aircraft.modules.tail
    excluded = {
        "T-tails": tail is not None and tail.is_t_tail,
        "masses along the wing": inputs.wing_battery_kg > 0.0,
    }
    left_out = [name for name, has in excluded.items() if has]
    if model.torsion is not None and left_out:
        yield f"flutter: CAA Report 45 excludes {' and '.join(left_out)}, as here"
    chosen = "deflection_load_case" in model.model_fields_set
    if model.maximum_tip_deflection is not None and not chosen:
        yield (
            f"maximum_tip_deflection {model.maximum_tip_deflection:g} holds in level flight; until "
            "1.0 it held at every limit load and in landing (deflection_load_case: limit_load, "
            "maximum_landing_deflection)"
        )


def structure_by_both(
    aircraft: Aircraft, mission: Mission, design: Design
) -> dict[str, Value] | None:
    """Mass of the structure by the file's model, and by the other one, without mass growth [kg].

    By their names, the file's first; None where there is no second opinion. The other one has the
    calibration of the file too, relative to that of AtlantikSolar.
    """
    sized = _sized_structure(aircraft, mission, design)
    other = None if sized is None else other_model(sized[0])
    if sized is None or other is None:
        return None
    structure, inputs = sized
    factor = structure.calibration / CALIBRATIONS[structure.model]
    return {structure.model: structure.mass_kg(inputs), other.model: factor * other.mass_kg(inputs)}


def _sized_rib_wing(
    aircraft: Aircraft, mission: Mission, design: Design
) -> tuple[RibWingStructure, StructureInputs] | None:
    """Rib wing of an aircraft and what it is sized from; None where it has another structure."""
    sized = _sized_structure(aircraft, mission, design)
    if sized is None or not isinstance(sized[0], RibWingStructure):
        return None
    return sized[0], sized[1]


def _sized_structure(
    aircraft: Aircraft, mission: Mission, design: Design
) -> tuple[Any, StructureInputs] | None:
    """Model of an aircraft's structure and what it is sized from; None of a measured aircraft."""
    if not isinstance(aircraft.airframe, ParametricAirframe):
        return None
    airframe, inputs = balance_inputs(aircraft, FlightConditions.of(mission, aircraft), design)
    return structure_with_tail(airframe, inputs.wingspan_m, inputs.aspect_ratio), inputs


def measured_design(aircraft: Aircraft, mission: Mission) -> Design:
    """Masses and power of a measured aircraft, scaled to the mission's mass and air.

    ``mission``: payload and air. Power scales with mass^1.5 and density^-0.5
    (:func:`sizing.aerodynamics.parabolic.scaled_power_w`), airspeed with their square roots.
    Returns of floats; all but the masses of battery, modules and payload is ``other``.
    """
    airframe = aircraft.airframe
    assert isinstance(airframe, MeasuredAirframe)
    air = FlightConditions.of(mission, aircraft)
    battery_kg = aircraft.battery.mass_kg
    total_kg = airframe.mass_without_battery_kg + battery_kg + mission.payload.mass_kg
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
            structure=0.0,
            propulsion=0.0,
            battery=battery_kg,
            modules=modules_kg,
            mppt=0.0,
            avionics=0.0,
            payload=mission.payload.mass_kg,
            other=airframe.mass_without_battery_kg - modules_kg,
        ),
        battery_energy_wh=aircraft.battery.battery_energy_wh * air.battery_capacity_fraction,
        propulsion_power_w=scaled_power_w(
            flight.electric_power_w, mass_ratio=mass_ratio, density_ratio=density_ratio
        ),
        constant_power_w=constant_power_w(aircraft, air.payload_power_w) + air.heater_w(battery_kg),
        airspeed_m_per_s=airspeed,
    )


def closed_design(
    aircraft: Aircraft,
    mission: Mission | FlightConditions,
    variables: DesignVariables,
    *,
    relative_tolerance: float = 1e-13,
) -> Design:
    """Design whose mass budget adds up, for variables that may be arrays.

    The lightest solution; where there is none (the aircraft cannot carry itself, or no tail has the
    static margin asked for) mass and power are infinite. See :func:`lightest_mass_kg`.

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
    given = variables.chosen()
    even = np.broadcast_arrays(*(np.asarray(v, float) for v in given.values()))
    arrays = DesignVariables(**dict(zip(given, even, strict=True)))
    flat = arrays.mapped(np.ravel)
    conditions = FlightConditions.of(mission, aircraft)

    def closed(chain: Propulsion | None) -> Design:
        def budget_kg(assumed_kg: FloatArray, designs: IntArray) -> FloatArray:
            some = flat.mapped(itemgetter(designs))
            given = None if chain is None else _links_of(chain, lambda one: np.ravel(one)[designs])
            closing = parametric_design(aircraft, conditions, some, assumed_kg, given)
            return np.asarray(closing.masses.total_kg, float)

        mass = lightest_mass_kg(
            budget_kg, np.array(flat.battery_mass_kg), relative_tolerance=relative_tolerance
        )
        with np.errstate(over="ignore", invalid="ignore"):
            total = mass.reshape(np.shape(arrays.wingspan_m))
            volume = None
            if chain is not None and sizes_tail(aircraft):
                # With the chain of the budget, as its own one takes long to compute.
                assumed = parametric_design(aircraft, conditions, arrays, total, chain)
                volume = assumed.horizontal_volume
            return parametric_design(aircraft, conditions, arrays, total, horizontal_volume=volume)

    propulsion = aircraft.propulsion_by_parts
    if propulsion is None or not propulsion.is_exact:
        design = closed(None)
    else:
        chain = _links_of(first_chain(propulsion), lambda one: np.full(np.shape(arrays[0]), one))
        design = _settled(closed, chain)
    if not sizes_tail(aircraft):
        return design
    with np.errstate(invalid="ignore"):
        off = np.abs(margin_rows(aircraft, conditions, design)["static_margin"])
    return _impossible_where(design, ~(off <= MARGIN_TOLERANCE))


def _impossible_where(design: Design, missing: Value) -> Design:
    """Design of arrays with infinite mass and power where something is missing."""
    return design._replace(
        total_mass_kg=np.where(missing, np.inf, design.total_mass_kg),
        masses=Masses(*(np.where(missing, np.inf, one) for one in design.masses)),
        propulsion_power_w=np.where(missing, np.inf, design.propulsion_power_w),
    )


def first_chain(propulsion: OperatingPointPropulsion) -> Propulsion:
    """Chain of these parts at which a search for their operating point begins."""
    usual = Propulsion()
    return propulsion.with_links({name: _link(usual, name) for name in LINKS})


def mixed_chain(chain: Propulsion, other: Propulsion, beyond: float) -> Propulsion:
    """Chain beyond a first one by a share of what it differs from another."""
    links = {name: _link(chain, name) for name in LINKS}
    further = {
        f"{name}_efficiency": one + beyond * (one - _link(other, name))
        for name, one in links.items()
    }
    return chain.model_copy(update=further)


def _settled(closed: Callable[[Propulsion | None], Design], chain: Propulsion) -> Design:
    """Design whose mass closes with the efficiencies that it has itself in level flight.

    An operating point that does not exist leaves NaN, and with it an infinite mass.
    """
    for _ in range(_ROUNDS):
        design = closed(chain)
        assert design.chain is not None
        chain = design.chain
        with np.errstate(invalid="ignore"):
            open_share = np.abs(design.masses.total_kg / design.total_mass_kg - 1.0)
        if not np.any(open_share > _SETTLED):
            break
    return _impossible_where(design, ~np.isfinite(np.asarray(chain.efficiency)))


def _link(chain: Propulsion, name: str) -> Value:
    """Efficiency of a link; 1 where a chain has none."""
    efficiency = getattr(chain, f"{name}_efficiency")
    return 1.0 if efficiency is None else efficiency


def _links_of(chain: Propulsion, function: Callable[[Value], Value]) -> Propulsion:
    """Chain with a function of every link's efficiency."""
    links = {f"{name}_efficiency": function(_link(chain, name)) for name in LINKS}
    mapped = chain.model_copy(update=links)
    return mapped.mapped(function) if isinstance(mapped, ChainOfParts) else mapped


# What a static margin may be off by that the size of the tail holds.
MARGIN_TOLERANCE = 1e-7
# Rounds in which mass and efficiencies settle, and what may then be open of the mass budget.
_ROUNDS, _SETTLED = 30, 1e-10
# In these an estimated mass of a gear is found with usual efficiencies, well within a gram.
_MASS_ROUNDS = 3
# Up to this slope of the budget a step follows the secant; beyond, next to the largest design that
# closes, a long step might pass the lightest solution and find a heavier one.
_STEEPEST = 0.8


def lightest_mass_kg(
    budget_kg: Callable[[FloatArray, IntArray], FloatArray],
    start_kg: FloatArray,
    *,
    relative_tolerance: float = 1e-13,
) -> FloatArray:
    """Lightest masses that equal the budgets which they lead to.

    Steps to the budget itself climb from below to the lightest solution. Where a budget is convex
    in the mass it assumes, which it nearly always is, a step along the secant of the last two never
    passes that solution either, and is longer. Where it is not, or is steep, steps are plain ones.
    Only designs that have not settled are iterated on.

    ``budget_kg``: budget [kg] for assumed masses [kg] of some designs, given by their indices.
    ``start_kg``: masses below all solutions, such as that of a part [kg]. ``relative_tolerance``:
    largest change of the mass in the last iteration, relative to it [-]. Infinite where there is
    none [kg].
    """
    mass = np.array(start_kg, float)
    before, budget_before, slope_before = np.full((3, mass.size), np.nan)
    climbing = np.arange(mass.size)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        for _ in range(2000):
            assumed = mass[climbing]
            budget = budget_kg(assumed, climbing)
            budget = np.where(np.isfinite(budget) & (budget < 1e9), budget, np.inf)
            still = np.abs(budget - assumed) <= relative_tolerance * assumed
            slope = (budget - budget_before[climbing]) / (assumed - before[climbing])
            convex = slope >= slope_before[climbing]
            # No two secants yet, or ones that lead nowhere: the plain step.
            sound = convex & (slope > 0.0) & (slope <= _STEEPEST) & (budget > assumed)
            longer = np.where(sound, 1.0 / (1.0 - slope), 1.0)
            before[climbing], budget_before[climbing] = assumed, budget
            slope_before[climbing] = slope
            settled = still | np.isinf(budget)
            mass[climbing] = np.where(settled, budget, assumed + longer * (budget - assumed))
            climbing = climbing[~settled]
            if climbing.size == 0:
                break
        mass[climbing] = np.inf
    return mass


def design_of(aircraft: Aircraft, mission: Mission) -> Design:
    """Design of an aircraft as its file gives it, flying a mission.

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
            or _tail_trouble(aircraft, mission)
            or f"{aircraft.name} cannot carry its own mass on mission {mission.name}: structure "
            "and propulsion grow faster than the lift they add"
        )
    return plain_design(design)


def plain_design(design: Design) -> Design:
    """Turn a design of zero-dimensional arrays into one of floats."""
    numbers = {
        name: float(value)
        for name, value in design._asdict().items()
        if name not in ("variables", "masses", "chain") and value is not None
    }
    masses = Masses(*(float(mass) for mass in design.masses))
    variables = design.variables.mapped(float)
    return Design(variables=variables, masses=masses, chain=design.chain, **numbers)


def _tail_trouble(aircraft: Aircraft, mission: Mission) -> str:
    """Why no horizontal tail has the static margin asked for, as a sentence; empty where one has.

    The static margins of the smallest and of the largest tail are those that would do.
    """
    balance = getattr(aircraft.airframe, "balance", None)
    if balance is None or not balance.sizes_tail:
        return ""
    kept, ends = {"static_margin": None, "held_by": "moved_mass"}, []
    for volume in (balance.minimum_horizontal_volume, balance.maximum_horizontal_volume):
        own = with_horizontal_tail(aircraft, volume)
        free = all_replaced(own, {f"airframe.balance.{key}": one for key, one in kept.items()})
        conditions = FlightConditions.of(mission, aircraft)
        design = closed_design(free, conditions, variables_of(aircraft))
        error = margin_error(*_margin_of(own, conditions, design))
        ends.append(float(error) + balance.static_margin)
    if not np.isfinite(ends).all():
        return ""
    return (
        f"no horizontal tail gives {aircraft.name} the static margin of {balance.static_margin:g} "
        f"on {mission.name}: it is {ends[0]:.3f} with the smallest volume coefficient, "
        f"{balance.minimum_horizontal_volume:g}, and {ends[1]:.3f} with the largest, "
        f"{balance.maximum_horizontal_volume:g}"
    )


def operating_trouble(
    aircraft: Aircraft, mission: Mission, variables: DesignVariables | None = None
) -> str:
    """Why the propulsors cannot do level flight, as a sentence; empty where they can.

    ``variables``: of the design, by default those of the aircraft's file.
    """
    reason, where = operating_reason(aircraft, mission, variables), mission.name
    return reason and (
        f"the propulsion of {aircraft.name} cannot do level flight on {where} at "
        f"{mission.altitude_m:g} m: {reason}"
    )


def operating_reason(
    aircraft: Aircraft, mission: Mission, variables: DesignVariables | None = None
) -> str:
    """What the propulsors cannot do in level flight, with what would do; empty where they can."""
    propulsion = aircraft.propulsion_by_parts
    if propulsion is None:
        return ""
    variables = variables_of(aircraft) if variables is None else variables
    chain, reason = first_chain(propulsion), ""
    for _ in range(_MASS_ROUNDS):
        airframe = aircraft.airframe.model_copy(update={"propulsion": chain})
        usual = aircraft.model_copy(update={"airframe": airframe})
        design = closed_design(usual, mission, variables)
        if not np.isfinite(design.total_mass_kg):
            break
        point = level_point(aircraft, mission, design)
        reason = str(point.reason)
        links = {name: _link(chain, name) for name in LINKS}
        own = propulsion.sized(*variables.of_propulsion)
        if own.gear.mass_kg is not None:
            break
        chain = own.with_links(links, point.propeller_torque_nm, design.propulsion_power_w)
    return reason


def level_point(aircraft: Aircraft, mission: Mission, design: Design) -> OperatingPoint:
    """Operating point of one propulsor of a design of known mass in level flight."""
    propulsion = aircraft.propulsion_by_parts
    assert propulsion is not None
    usual, mass_kg = first_chain(propulsion), design.total_mass_kg
    flown = parametric_design(
        aircraft, mission, design.variables, mass_kg, usual, design.horizontal_volume
    )
    power_w = flown.propulsion_power_w * usual.efficiency
    air = FlightConditions.of(mission, aircraft).air
    own = propulsion.sized(*design.variables.mapped(float).of_propulsion)
    return own.point(power_w, flown.airspeed_m_per_s, air, bus_voltage_v(aircraft))


def with_total_mass(aircraft: Aircraft, mission: Mission, total_mass_kg: float) -> Aircraft:
    """Aircraft of a known total mass: what the mass budget does not account for is other mass.

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
            f"a total mass of {total_mass_kg:g} kg is less than the {rest_kg:.3f} kg of "
            f"{aircraft.name} without airframe.{key}"
        )
    grown = 1.0 if isinstance(airframe, MeasuredAirframe) else 1.0 + airframe.mass_growth
    changed = airframe.model_copy(update={key: other_kg / grown})
    return aircraft.model_copy(update={"airframe": changed})


def load_profile(
    time_h: ArrayLike,
    design: Design,
    mission: Mission,
    sunrise_h: ArrayLike,
    sunset_h: ArrayLike,
    part_load: PartLoad | None = None,
    bus_v: FloatArray | None = None,
) -> Value:
    """Load over the day: level flight, turbulence and thermals.

    ``mission``: with its turbulence; draws of it are arrays of the batch. ``part_load``: power of a
    propulsion whose efficiency is that of the moment, with axes for scenarios and time; ``bus_v``:
    voltage at the nodes, by default that of :meth:`PartLoad.at`. Returns power that the aircraft
    draws [W].
    """
    propulsion = np.asarray(design.propulsion_power_w)[..., np.newaxis]
    constant = np.asarray(design.constant_power_w)[..., np.newaxis]
    all_day, most = (
        np.asarray(value, float)[..., np.newaxis]
        for value in (mission.turbulence.all_day, mission.turbulence.thermal)
    )
    steady = 1.0 + all_day
    if part_load is not None:
        thermal = most * thermal_shape(time_h, sunrise_h, sunset_h)
        return propulsion * part_load.at(steady + thermal, bus_v) + constant
    if not np.any(most):
        load = propulsion * steady + constant
        shape = np.broadcast_shapes(load.shape, (*np.shape(sunrise_h), np.size(time_h)))
        return np.broadcast_to(load, shape)
    thermal = most * thermal_shape(time_h, sunrise_h, sunset_h)
    return propulsion * (steady + thermal) + constant


def thermal_shape(time_h: ArrayLike, sunrise_h: ArrayLike, sunset_h: ArrayLike) -> Value:
    """Triangle over the lit day: 0 at sunrise and sunset, 1 half-way between.

    Returns share of the thermals' extra power [-].
    """
    rise = np.asarray(sunrise_h, float)[..., np.newaxis]
    half = (np.asarray(sunset_h, float)[..., np.newaxis] - rise) / 2.0
    distance = np.abs(np.asarray(time_h, float) - (rise + half))
    sunlit = half > 0.0
    return np.where(sunlit, np.maximum(1.0 - distance / np.where(sunlit, half, 1.0), 0.0), 0.0)
