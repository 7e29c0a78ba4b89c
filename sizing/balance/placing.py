"""Places of the masses of a design, and of the one that is moved for a static margin.

Arithmetic only: the optimiser passes symbols.
"""

from __future__ import annotations

from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.balance.in_design import structure_with_tail
from sizing.balance.masses import (
    Balance,
    Item,
    centre_of_gravity,
    spar_x_m,
    tail_mass_x_m,
    wing_and_tail_items,
)
from sizing.balance.stability import neutral_point
from sizing.balance.surfaces import Tail, Wing, wing_of
from sizing.design import Design, FlightConditions, structure_inputs
from sizing.smooth import Value
from sizing.structures.rib_wing import RibWingStructure

__all__ = ["balance_items", "balanced_airframe", "body_volume_m3", "moved_ends", "moved_x_m"]


def balanced_airframe(aircraft: Aircraft) -> tuple[ParametricAirframe, Tail, Balance] | None:
    """Airframe with tail and balance; None where the file has not both."""
    airframe = aircraft.airframe
    if not isinstance(airframe, ParametricAirframe):
        return None
    if airframe.tail is None or airframe.balance is None:
        return None
    return airframe, airframe.tail, airframe.balance


def body_volume_m3(airframe: ParametricAirframe) -> float:
    """Volume of the pods [m3]; none without drag by components."""
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
        aircraft,
        variables,
        conditions.with_payload_of(variables),
        design.total_mass_kg,
        design.airspeed_m_per_s,
        masses.propulsion,
    )
    planes = airframe.tail.planes(wing)
    chords = airframe.balance.positions_chords
    places = {name: getattr(chords, name) * wing.mean_chord_m for name in type(chords).model_fields}
    tail_m = tail_mass_x_m(wing, planes.arm_m, planes.horizontal_chord_m)
    built = structure.breakdown(inputs)
    grown = type(built)(*((1.0 + airframe.mass_growth) * part for part in built))
    parts = wing_and_tail_items(grown, wing, tail_m, places["pod"])
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
    own = balanced_airframe(aircraft)
    if own is None or own[2].static_margin is None:
        return None
    airframe, tail, balance = own
    variables = design.variables
    wing = wing_of(airframe.planform, variables.wingspan_m, variables.aspect_ratio)
    items = _fixed_items(aircraft, conditions, design, wing)
    moved = items.pop(balance.moved)
    rest = list(items.values())
    rest_kg = sum((item.mass_kg for item in rest[1:]), rest[0].mass_kg)
    neutral_m = neutral_point(wing, tail, tail.planes(wing), body_volume_m3(airframe)).x_m
    wanted_m = neutral_m - balance.static_margin * wing.aerodynamic_chord_m
    return wanted_m + rest_kg * (wanted_m - centre_of_gravity(rest)) / moved.mass_kg


def balance_items(
    aircraft: Aircraft, conditions: FlightConditions, design: Design
) -> tuple[Item, ...]:
    """Masses with their places: as weighed, or of the mass budget."""
    own = balanced_airframe(aircraft)
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


def moved_ends(
    aircraft: Aircraft, conditions: FlightConditions, design: Design
) -> dict[str, Value]:
    """How far the moved mass lies within its ends, in mean chords, by the name of the row."""
    found_m = moved_x_m(aircraft, conditions, design)
    own = balanced_airframe(aircraft)
    if found_m is None or own is None:
        return {}
    chords = found_m * design.variables.aspect_ratio / design.variables.wingspan_m
    fore, rear = own[2].foremost_chords, own[2].rearmost_chords
    rows = {} if fore is None else {"moved_mass_foremost": chords - fore}
    return rows if rear is None else rows | {"moved_mass_rearmost": rear - chords}
