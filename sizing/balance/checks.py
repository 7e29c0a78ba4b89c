"""What the keys of balance and trim need of one another in an aircraft's file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from pydantic_core import PydanticCustomError

from sizing.structures.rib_wing import RibWingStructure

if TYPE_CHECKING:
    from sizing.aircraft import ParametricAirframe

__all__ = ["check_balance", "without_own_constants"]

# Of the structure's model, which airframe.tail stands for.
_TAIL_KEYS = ("fuselage_chords", "horizontal_tail_ratio", "vertical_tail_ratio")
# Of the drag polars, which airframe.drag stands for: none unless the file says so.
_DRAG_CONSTANTS = {
    "parabolic": ("parasitic_drag_coefficient",),
    "wing_polar": ("tail_area_ratio", "fuselage_wetted_area_ratio"),
}


def without_own_constants(data: Any) -> Any:
    """Airframe whose polar has no drag of its own for what ``drag`` builds up."""
    polar = data.get("aerodynamics") if isinstance(data, Mapping) else None
    if not isinstance(polar, Mapping) or data.get("drag") is None:
        return data
    keys = _DRAG_CONSTANTS.get(polar.get("model", "parabolic"), ())
    return {**data, "aerodynamics": {**dict.fromkeys(keys, 0.0), **polar}}


def check_balance(airframe: ParametricAirframe) -> None:
    """Refuse keys that lack what they need, and what is given twice."""
    balance = airframe.balance
    for key in ("drag", "balance"):
        if getattr(airframe, key) is not None and airframe.tail is None:
            _refuse("tail", f"required key is missing: airframe.{key} needs it")
    if airframe.tail is not None:
        _check_structure(airframe.structure)
    trimmed = balance is not None and balance.static_margin is not None
    polar = airframe.aerodynamics
    if polar.model == "own" and (airframe.drag is not None or trimmed):
        key = "drag" if airframe.drag is not None else "balance.static_margin"
        _refuse("aerodynamics.model", f"must be parabolic or wing_polar with airframe.{key} "
                "(got own)")  # fmt: skip
    if airframe.drag is not None and polar.model == "wing_polar":
        for key in _DRAG_CONSTANTS["wing_polar"]:
            if (value := getattr(polar, key)) > 0.0:
                text = f"must be 0 with airframe.drag, which has that part (got {value:g})"
                _refuse(f"aerodynamics.{key}", text)
    if balance is not None and trimmed:
        _check_moved(airframe)


def _check_structure(structure: Any) -> None:
    if not isinstance(structure, RibWingStructure):
        _refuse("structure.model", "must be rib_wing with airframe.tail, as it alone has the tail "
                f"as a part (got {structure.model})")  # fmt: skip
    for key in _TAIL_KEYS:
        if key in structure.model_fields_set and not structure.is_unchecked():
            value = getattr(structure, key)
            _refuse(f"structure.{key}", f"follows from airframe.tail; give one (got {value:g})")


def _check_moved(airframe: ParametricAirframe) -> None:
    assert airframe.balance is not None
    moved = airframe.balance.moved
    nothing = {
        "battery": airframe.distributed_battery_fraction == 1.0,
        "avionics": airframe.avionics_mass_kg == 0.0,
        "other": airframe.other_mass_kg == 0.0,
    }
    if nothing[moved]:
        allowed = ", ".join(name for name, none in nothing.items() if not none) or "none has mass"
        why = "is all in the wing's spar" if moved == "battery" else "has no mass"
        _refuse("balance.moved", f"{moved} {why}; allowed here: {allowed} (got {moved})")


def _refuse(key: str, text: str) -> None:
    raise PydanticCustomError("balance", "{text}", {"key": key, "text": text})
