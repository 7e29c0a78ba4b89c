"""Tail and drag of an aircraft's file in the models of structure and drag, for a wing."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

from sizing.aerodynamics.parabolic import DragPolar, Polar
from sizing.aerodynamics.wing_polar import WingPolar
from sizing.balance.drag import Booms, BuiltUpPolar
from sizing.balance.surfaces import wing_of
from sizing.parameters import all_replaced, replaced
from sizing.smooth import Value
from sizing.structures.models import StructureModel
from sizing.structures.rib_wing import RibWingStructure

if TYPE_CHECKING:
    from sizing.aircraft import Aircraft, ParametricAirframe


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
    changed = all_replaced(cast(Any, structure), airframe.tail.structure_keys(wing))
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
