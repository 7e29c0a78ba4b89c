"""Checks of the keys of balance and trim in an aircraft's file against each other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from sizing.structures.rib_wing import RibWingStructure
from solar.schema import wrong_value

if TYPE_CHECKING:
    from sizing.balance.surfaces import Planform
    from sizing.layout.cells import CellLayout


# Tolerance of equal relative chords: a table of cells may have four digits.
_SAME_CHORD = 1e-3
# Keys of the structure's model that airframe.tail replaces.
_TAIL_KEYS = ("fuselage_chords", "horizontal_tail_ratio", "vertical_tail_ratio")
# Keys of the drag polars that airframe.drag replaces: 0 by default.
_DRAG_CONSTANTS = {
    "parabolic": ("parasitic_drag_coefficient",),
    "wing_polar": ("tail_area_ratio", "fuselage_wetted_area_ratio"),
}


def without_replaced_constants(data: Any) -> Any:
    """Return an airframe's data with 0 for drag constants that ``drag`` replaces."""
    polar = data.get("aerodynamics") if isinstance(data, Mapping) else None
    if not isinstance(polar, Mapping) or data.get("drag") is None:
        return data
    keys = _DRAG_CONSTANTS.get(polar.get("model", "parabolic"), ())
    return {**data, "aerodynamics": {**dict.fromkeys(keys, 0.0), **polar}}


def _relative_chords(inner: float, taper: float) -> dict[str, tuple[float, ...]]:
    """Return the planform of two panels as relative chords along the half-span, for cells."""
    root = 1.0 / (inner + (1.0 - inner) * (1.0 + taper) / 2.0)
    if inner == 0.0:
        return {"half_span": (0.0, 1.0), "relative_chord": (root, taper * root)}
    return {"half_span": (0.0, inner, 1.0), "relative_chord": (root, root, taper * root)}


def cells_on_planform(data: Any) -> Any:
    """Return an aircraft's data with cells on ``airframe.planform``, unless given otherwise."""
    airframe, modules = (_mapping(data, key) for key in ("airframe", "modules"))
    planform, layout = _mapping(airframe, "planform"), _mapping(modules, "layout")
    shape: list[Any] = [planform.get(key) for key in ("inner_fraction", "taper_ratio")]
    valid = all(isinstance(value, int | float) and 0.0 <= value <= 1.0 for value in shape)
    if not (valid and layout) or "planform" in layout or shape[0] == 1.0 or shape[1] == 0.0:
        return data
    placed = {**layout, "planform": _relative_chords(*shape)}
    return {**data, "modules": {**modules, "layout": placed}}


def _mapping(holder: Any, key: str) -> Mapping[str, Any]:
    """Return the mapping under a key; empty if there is none."""
    value = holder.get(key) if isinstance(holder, Mapping) else None
    return value if isinstance(value, Mapping) else {}


def check_planforms(wing: Planform | None, layout: CellLayout) -> None:
    """Refuse cells on another planform than the wing."""
    if wing is None or layout.planform is None:
        return
    cells, shape = layout.planform, _relative_chords(wing.inner_fraction, wing.taper_ratio)
    places = sorted({*cells.half_span, *shape["half_span"]})
    chords = np.interp(places, cells.half_span, cells.relative_chord)
    if not np.allclose(chords, np.interp(places, shape["half_span"], shape["relative_chord"]),
                       atol=_SAME_CHORD):  # fmt: skip
        raise wrong_value(
            "modules.layout.planform", "is another wing than airframe.planform; give one"
        )


def check_balance(airframe: Any) -> None:
    """Refuse missing and duplicate keys of a parametric airframe."""
    balance = airframe.balance
    for key in ("drag", "balance"):
        if getattr(airframe, key) is not None and airframe.tail is None:
            raise wrong_value("tail", f"required key is missing: airframe.{key} needs it")
    if airframe.tail is not None:
        structure = airframe.structure
        if not isinstance(structure, RibWingStructure):
            text = "must be rib_wing with airframe.tail, as it alone has the tail as a part"
            raise wrong_value("structure.model", text, got=structure.model)
        if structure.booms == 0:
            raise wrong_value("structure.booms", "must be 1 or 2 with airframe.tail", got=0)
        built_m2 = None if airframe.drag is None else airframe.drag.built_m2
        replaced = {} if structure.is_unchecked() else dict.fromkeys(_TAIL_KEYS, "tail")
        replaced |= {} if built_m2 is None else {"pod_wetted_area_ratio": "drag.pods"}
        for key, part in replaced.items():
            if key in structure.model_fields_set:
                text, value = f"follows from airframe.{part}; give one", getattr(structure, key)
                raise wrong_value(f"structure.{key}", text, got=value)
    trimmed = balance is not None and balance.static_margin is not None
    polar = airframe.aerodynamics
    if polar.model == "own" and (airframe.drag is not None or trimmed):
        key = "drag" if airframe.drag is not None else "balance.static_margin"
        text = f"must be parabolic or wing_polar with airframe.{key}"
        raise wrong_value("aerodynamics.model", text, got="own")
    if airframe.drag is not None and polar.model == "wing_polar":
        for key in _DRAG_CONSTANTS["wing_polar"]:
            if (value := getattr(polar, key)) > 0.0:
                text = "must be 0 with airframe.drag, which has that part"
                raise wrong_value(f"aerodynamics.{key}", text, got=value)
