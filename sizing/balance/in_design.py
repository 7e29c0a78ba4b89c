"""Tail, drag build-up and balance of an aircraft's file in its designs.

Tail, masses along the span and wires to the wing enter the models of structure and drag, for
numbers and symbols. The horizontal tail for a required static margin is reported.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from sizing.aerodynamics.parabolic import DragPolar
from sizing.aerodynamics.wing_polar import Polar, WingPolar
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.balance.drag import DragShares
from sizing.balance.masses import SPAR, TAIL_MASS, WING_PARTS, Item, centre_of_gravity
from sizing.balance.surfaces import Wing, neutral_point, trim, wing_of
from sizing.design import DesignVariables, FlightConditions
from sizing.parameters import all_replaced
from sizing.roots import bracketed_root
from sizing.smooth import Value
from sizing.structures.loads import StructureInputs
from sizing.structures.models import StructureModel
from sizing.structures.rib_wing import RibWingStructure
from solar.types import FloatArray


def structure_with_tail(
    airframe: ParametricAirframe, wingspan_m: Value, aspect_ratio: Value
) -> StructureModel:
    """Return the model of the structure with the tail of the file, if any."""
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


def drag_by_parts(
    airframe: ParametricAirframe, polar: Polar, wing: Wing, reynolds: Value
) -> DragShares | None:
    """Return the drag of wing, tail, booms and pods, and of trim, if required.

    ``polar`` is that of the file at the lift coefficient of level flight, ``reynolds`` that of the
    mean chord. None where the file's polar has all of the drag.
    """
    it, tail, structure, balance = (
        getattr(airframe, key) for key in ("drag", "tail", "structure", "balance")
    )
    margin = None if balance is None else balance.static_margin
    if tail is None or (it is None and margin is None):
        return None
    assert isinstance(polar, DragPolar | WingPolar)  # others are refused at validation
    profile, induced, other = polar.parts(wing.aspect_ratio, reynolds)
    shares = DragShares(profile, induced, other=other)
    if it is not None:
        parts = it.coefficients(wing, tail, structure, reynolds)
        gaps = it.gaps_fraction * sum(parts.values(), profile)
        shares = shares._replace(**parts, gaps=gaps)
    if margin is not None:
        planes = tail.planes(wing)
        neutral_m = neutral_point(wing, tail, planes, body_volume_m3(airframe)).x_m
        trimmed = trim(
            wing,
            tail,
            planes,
            lift=polar.flight_lift_coefficient,
            moment=balance.pitching_moment_coefficient,
            gravity_x_m=neutral_m - margin * wing.aerodynamic_chord_m,
            span_efficiency=polar.span_efficiency,
        )
        shares = shares._replace(trim=trimmed.drag)
    return shares


def drag_coefficient(
    airframe: ParametricAirframe, polar: Polar, wing: Wing, reynolds: Value
) -> Value:
    """Return the drag coefficient of the aircraft in level flight; see :func:`drag_by_parts`."""
    shares = drag_by_parts(airframe, polar, wing, reynolds)
    return polar.drag_coefficient(wing.aspect_ratio, reynolds) if shares is None else shares.total


def polar_with_wires(
    aircraft: Aircraft,
    polar: Polar,
    variables: DesignVariables,
    air: FlightConditions,
    total_mass_kg: Value,
    airspeed_m_per_s: Value,
) -> Polar:
    """Return the polar with the drag of wires to the wing, if any."""
    structure = getattr(aircraft.airframe, "structure", None)
    if not isinstance(structure, RibWingStructure) or structure.bracing is None:
        return polar
    assert isinstance(polar, DragPolar | WingPolar)  # others are refused at validation
    inputs = structure_inputs(aircraft, variables, air, total_mass_kg, airspeed_m_per_s, 0.0)
    wing = structure.wing(inputs)
    added = structure.wires(wing).drag_area_m2 / wing.wing_area_m2
    parasitic = polar.parasitic_drag_coefficient + added
    return all_replaced(polar, {"parasitic_drag_coefficient": parasitic})


def structure_inputs(
    aircraft: Aircraft,
    variables: DesignVariables,
    air: FlightConditions,
    total_mass_kg: Value,
    airspeed_m_per_s: Value,
    propulsion_kg: Value,
) -> StructureInputs:
    """Return the inputs of the structure, with the mass along the span."""
    airframe = aircraft.parametric
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


def body_volume_m3(airframe: ParametricAirframe) -> float:
    """Return the volume of the pods; 0 without drag by components [m3]."""
    return 0.0 if airframe.drag is None else airframe.drag.volume_m3


def balance_items(
    airframe: ParametricAirframe, masses: Any, inputs: StructureInputs
) -> tuple[Item, ...]:
    """Return masses with their places, weighed or by the mass budget."""
    balance = airframe.balance
    assert balance is not None
    assert airframe.tail is not None
    if balance.weighed:
        return tuple(
            Item(weighed.name, weighed.mass_kg, weighed.x_m) for weighed in balance.weighed
        )
    wing = wing_of(airframe.planform, inputs.wingspan_m, inputs.aspect_ratio)
    structure = structure_with_tail(airframe, wing.wingspan_m, wing.aspect_ratio)
    assert isinstance(structure, RibWingStructure)  # others are refused at validation
    planes = airframe.tail.planes(wing)
    chords = balance.positions_chords
    places = {name: getattr(chords, name) * wing.mean_chord_m for name in type(chords).model_fields}
    # Centroid of the tail planes; the boom ends there and at the wing's quarter chord.
    tail_m = wing.quarter_m + planes.arm_m + TAIL_MASS * planes.horizontal_chord_m
    if planes.vertical_arm_m is not planes.arm_m:
        fins_m = wing.quarter_m + planes.vertical_arm_m + TAIL_MASS * planes.fin_chord_m
        share = planes.vertical_m2 / (planes.horizontal_m2 + planes.vertical_m2)
        tail_m = tail_m + share * (fins_m - tail_m)
    parts = structure.breakdown(inputs)._asdict()
    parts = {name: (1.0 + airframe.mass_growth) * part for name, part in parts.items()}
    at = {name: wing.at_chord(share) for name, share in WING_PARTS.items()}
    at |= {"tails": tail_m, "boom": (wing.quarter_m + tail_m) / 2.0, "pod": places["pod"]}
    items = [Item(name, parts[name], x_m) for name, x_m in at.items()]
    # Joints lie at the centroid of the other parts.
    items.append(Item("joints", parts["joints"], centre_of_gravity(items)))
    in_pod_kg = structure.wing(inputs).pod_battery_kg
    in_spar_kg = masses.battery - in_pod_kg
    items.append(Item("battery in the wing", in_spar_kg, wing.at_chord(SPAR)))
    items.append(Item("battery", in_pod_kg, places["battery"]))
    names = ("propulsion", "modules", "mppt", "avionics", "payload", "other")
    items += [Item(name, getattr(masses, name), places[name]) for name in names]
    return tuple(items)


# Range of volume coefficients in the search for a static margin.
_LEAST_VOLUME, _MOST_VOLUME = 0.01, 3.0


def volume_for_margin(
    airframe: ParametricAirframe, masses: Any, inputs: StructureInputs
) -> float | None:
    """Return the volume coefficient of the horizontal tail for the required static margin [-].

    The tail's mass changes with it, all other masses stay. None if no margin is required or found.
    """
    tail, balance = airframe.tail, airframe.balance
    assert tail is not None
    assert balance is not None
    if (margin := balance.static_margin) is None:
        return None
    wing = wing_of(airframe.planform, inputs.wingspan_m, inputs.aspect_ratio)

    def error(volume: FloatArray) -> FloatArray:
        size = {"horizontal_volume": volume, "horizontal_area_m2": None}
        sized = all_replaced(tail, size)
        neutral_m = neutral_point(wing, sized, sized.planes(wing), body_volume_m3(airframe)).x_m
        changed = airframe.model_copy(update={"tail": sized})
        gravity_m = centre_of_gravity(balance_items(changed, masses, inputs))
        return np.asarray((neutral_m - gravity_m) / wing.aerodynamic_chord_m - margin)

    volume = bracketed_root(error, np.array([_LEAST_VOLUME]), np.array([_MOST_VOLUME]))
    return None if np.isnan(volume[0]) else float(volume[0])
