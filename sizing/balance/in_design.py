"""Tail, drag and balance of an aircraft's file in its designs.

The tail goes into the models of structure and drag. A static margin that is asked for is had by the
place of a mass, in closed form, or by the size of the horizontal tail, found here for numbers; the
optimiser has the size among its variables and passes symbols to the rest.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import numpy as np

from sizing.aerodynamics.parabolic import DragPolar, Polar
from sizing.aerodynamics.wing_polar import WingPolar
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.balance.drag import Booms, BuiltUpPolar
from sizing.balance.masses import (
    Balance,
    Item,
    centre_of_gravity,
    spar_x_m,
    tail_mass_x_m,
    wing_and_tail_items,
)
from sizing.balance.stability import neutral_point
from sizing.balance.surfaces import Wing, wing_of
from sizing.parameters import all_replaced, replaced
from sizing.smooth import Value
from sizing.structures.loads import StructureInputs
from sizing.structures.models import StructureModel
from sizing.structures.rib_wing import RibWingStructure
from solar.types import FloatArray


def with_horizontal_tail(aircraft: Aircraft, volume: Value | None) -> Aircraft:
    """Aircraft whose horizontal tail has another volume coefficient; itself with None."""
    tail = getattr(aircraft.airframe, "tail", None)
    if volume is None or tail is None:
        return aircraft
    airframe = replaced(aircraft.airframe, ["tail"], tail.with_volume(volume))
    return aircraft.model_copy(update={"airframe": airframe})


def structure_with_tail(
    airframe: ParametricAirframe, wingspan_m: Value, aspect_ratio: Value
) -> StructureModel:
    """Model of the structure with the tail of the file, where it has one."""
    structure = airframe.structure
    if airframe.tail is None:
        return structure
    wing = wing_of(airframe.planform, wingspan_m, aspect_ratio)
    keys = airframe.tail.structure_keys(wing)
    pods_m2 = None if airframe.drag is None else airframe.drag.built_m2
    if pods_m2 is not None:
        keys["pod_wetted_area_ratio"] = pods_m2 / wing.area_m2
    changed = all_replaced(cast(Any, structure), keys)
    return cast(StructureModel, changed)


def polar_with_tail(
    airframe: ParametricAirframe, polar: Polar, wingspan_m: Value, aspect_ratio: Value
) -> Polar:
    """Polar with the drag of tail, booms and pods, and of the trim that the file asks for.

    ``polar``: of the file, at the lift coefficient of level flight; it is returned as it is where
    the file asks for neither.
    """
    balance, tail, structure = airframe.balance, airframe.tail, airframe.structure
    margin = None if balance is None else balance.static_margin
    if tail is None or (airframe.drag is None and margin is None):
        return polar
    assert isinstance(polar, DragPolar | WingPolar)  # others are refused at validation
    assert isinstance(structure, RibWingStructure)
    wing = wing_of(airframe.planform, wingspan_m, aspect_ratio)
    return BuiltUpPolar(
        base=polar,
        wing=wing,
        tail=tail,
        booms=Booms(structure.booms, structure.boom_diameter_chords * wing.mean_chord_m),
        components=airframe.drag,
        static_margin=margin,
        moment=0.0 if balance is None else balance.pitching_moment_coefficient,
    )


# Of the secant search for a tail's size: rounds, and what is left of the volume coefficient.
_ROUNDS, _SETTLED = 40, 1e-14


def body_volume_m3(airframe: ParametricAirframe) -> float:
    """Volume of the pods [m3]; none without drag by components."""
    return 0.0 if airframe.drag is None else airframe.drag.volume_m3


def _wing(airframe: ParametricAirframe, inputs: StructureInputs) -> Wing:
    return wing_of(airframe.planform, inputs.wingspan_m, inputs.aspect_ratio)


def _fixed_items(
    airframe: ParametricAirframe, masses: Any, inputs: StructureInputs
) -> dict[str, Item]:
    """Items of a mass budget by their places in the file; they add up to the total mass."""
    wing = _wing(airframe, inputs)
    assert airframe.balance is not None
    assert airframe.tail is not None
    structure = structure_with_tail(airframe, wing.wingspan_m, wing.aspect_ratio)
    assert isinstance(structure, RibWingStructure)  # others are refused at validation
    planes = airframe.tail.planes(wing)
    chords = airframe.balance.positions_chords
    places = {name: getattr(chords, name) * wing.mean_chord_m for name in type(chords).model_fields}
    tail_m = tail_mass_x_m(wing, planes.arm_m, planes.horizontal_chord_m)
    if planes.vertical_arm_m is not planes.arm_m:
        fins_m = tail_mass_x_m(wing, planes.vertical_arm_m, planes.fin_chord_m)
        share = planes.vertical_m2 / (planes.horizontal_m2 + planes.vertical_m2)
        tail_m = tail_m + share * (fins_m - tail_m)
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


def _wanted_m(airframe: ParametricAirframe, wing: Wing) -> Value:
    """Centre of gravity that has the static margin of the file [m]."""
    tail, balance = airframe.tail, airframe.balance
    assert tail is not None
    assert balance is not None
    assert balance.static_margin is not None
    neutral_m = neutral_point(wing, tail, tail.planes(wing), body_volume_m3(airframe)).x_m
    return neutral_m - balance.static_margin * wing.aerodynamic_chord_m


def _moved_x_m(airframe: ParametricAirframe, wing: Wing, items: dict[str, Item]) -> Value:
    """Where the moved mass has to be for the static margin that is asked for [m].

    ``x = (x_cg sum(m) - sum of the others' m x)/m_moved``.
    """
    assert airframe.balance is not None
    moved = items[airframe.balance.moved]
    rest = [item for item in items.values() if item is not moved]
    rest_kg = sum((item.mass_kg for item in rest[1:]), rest[0].mass_kg)
    wanted_m = _wanted_m(airframe, wing)
    return wanted_m + rest_kg * (wanted_m - centre_of_gravity(rest)) / moved.mass_kg


def balance_items(
    airframe: ParametricAirframe, masses: Any, inputs: StructureInputs
) -> tuple[Item, ...]:
    """Masses with their places: as weighed, or of the mass budget."""
    balance = airframe.balance
    assert balance is not None
    if balance.weighed:
        return tuple(Item(one.name, one.mass_kg, one.x_m) for one in balance.weighed)
    items = _fixed_items(airframe, masses, inputs)
    if balance.moves_mass:
        found_m = _moved_x_m(airframe, _wing(airframe, inputs), items)
        items[balance.moved] = items[balance.moved]._replace(x_m=found_m)
    return tuple(items.values())


def margin_error(airframe: ParametricAirframe, masses: Any, inputs: StructureInputs) -> Value:
    """Static margin of a mass budget less that of the file [-]."""
    wing = _wing(airframe, inputs)
    gravity_m = centre_of_gravity(list(_fixed_items(airframe, masses, inputs).values()))
    return (_wanted_m(airframe, wing) - gravity_m) / wing.aerodynamic_chord_m


def balance_rows(
    airframe: ParametricAirframe, masses: Any, inputs: StructureInputs
) -> dict[str, Value]:
    """What a design has to meet for its static margin, by the names of the rows.

    How far the moved mass lies within its ends, in mean chords; for a tail whose size is found, by
    how much its static margin is off.
    """
    balance = airframe.balance
    assert balance is not None
    if balance.sizes_tail:
        return {"static_margin": margin_error(airframe, masses, inputs)}
    wing = _wing(airframe, inputs)
    chords = _moved_x_m(airframe, wing, _fixed_items(airframe, masses, inputs)) / wing.mean_chord_m
    fore, rear = balance.foremost_chords, balance.rearmost_chords
    rows = {} if fore is None else {"moved_mass_foremost": chords - fore}
    return rows if rear is None else rows | {"moved_mass_rearmost": rear - chords}


def tail_volume(balance: Balance, error: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """Volume coefficient of the horizontal tail that leaves no error of the static margin [-].

    By secants, of numbers or arrays, which converge fast as the neutral point is nearly linear in
    the size of the tail; at an end of the range where the range has none.

    ``error``: of the static margin, of designs with given volume coefficients [-].
    """
    least, most = balance.minimum_horizontal_volume, balance.maximum_horizontal_volume
    first = np.asarray(error(np.asarray(least)), float)
    last = np.full(first.shape, least)
    here = np.full(first.shape, min(2.0 * least + 0.2, most))
    with np.errstate(invalid="ignore", divide="ignore"):
        for _ in range(_ROUNDS):
            now = np.asarray(error(here), float)
            slope = (now - first) / (here - last)
            # Beyond its best size a tail weighs more than it steadies: no size is enough.
            step = np.where(slope > 0.0, -now / slope, np.inf)
            step = np.where((now == 0.0) | (here == last), 0.0, step)
            moved = np.clip(here + step, least, most)
            # What a step leaves is less than the product of the last two.
            settled = np.abs((moved - here) * (here - last)) < _SETTLED
            last, first, here = here, now, moved
            if np.all(settled | np.isnan(here)):
                break
    return here
