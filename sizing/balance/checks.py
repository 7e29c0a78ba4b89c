"""What the keys of balance and trim need of one another in an aircraft's file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from sizing.structures.rib_wing import RibWingStructure
from solar.schema import wrong_value

if TYPE_CHECKING:
    from sizing.balance.surfaces import Planform
    from sizing.layout.cells import CellLayout


# Chords over the mean chord that count as the same: a table of cells may have four digits.
_SAME_CHORD = 1e-3
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


def _relative_chords(inner: float, taper: float) -> dict[str, tuple[float, ...]]:
    """Planform of two panels as that of cells: chord over the mean chord along the half-span."""
    root = 1.0 / (inner + (1.0 - inner) * (1.0 + taper) / 2.0)
    if inner == 0.0:
        return {"half_span": (0.0, 1.0), "relative_chord": (root, taper * root)}
    return {"half_span": (0.0, inner, 1.0), "relative_chord": (root, root, taper * root)}


def cells_on_planform(data: Any) -> Any:
    """Aircraft whose cells lie on the wing of ``airframe.planform``, unless they have their own."""
    airframe, modules = (_mapping(data, key) for key in ("airframe", "modules"))
    planform, layout = _mapping(airframe, "planform"), _mapping(modules, "layout")
    shape: list[Any] = [planform.get(key) for key in ("inner_fraction", "taper_ratio")]
    valid = all(isinstance(one, int | float) and 0.0 <= one <= 1.0 for one in shape)
    if not (valid and layout) or "planform" in layout or shape[0] == 1.0 or shape[1] == 0.0:
        return data
    placed = {**layout, "planform": _relative_chords(*shape)}
    return {**data, "modules": {**modules, "layout": placed}}


def _mapping(holder: Any, key: str) -> Mapping[str, Any]:
    """Mapping under a key; empty where there is none."""
    found = holder.get(key) if isinstance(holder, Mapping) else None
    return found if isinstance(found, Mapping) else {}


def check_planforms(wing: Planform | None, layout: CellLayout) -> None:
    """Refuse cells on another planform than that of the wing."""
    if wing is None or layout.planform is None:
        return
    cells, shape = layout.planform, _relative_chords(wing.inner_fraction, wing.taper_ratio)
    places = sorted({*cells.half_span, *shape["half_span"]})
    own = np.interp(places, cells.half_span, cells.relative_chord)
    if not np.allclose(own, np.interp(places, shape["half_span"], shape["relative_chord"]),
                       atol=_SAME_CHORD):  # fmt: skip
        raise wrong_value(
            "modules.layout.planform", "is another wing than airframe.planform; give one"
        )


def check_balance(airframe: Any) -> None:
    """Refuse keys of a parametric airframe that lack what they need, and what is given twice."""
    balance = airframe.balance
    for key in ("drag", "balance"):
        if getattr(airframe, key) is not None and airframe.tail is None:
            raise wrong_value("tail", f"required key is missing: airframe.{key} needs it")
    if airframe.tail is not None:
        _check_structure(airframe.structure)
        built_m2 = None if airframe.drag is None else airframe.drag.built_m2
        key = "pod_wetted_area_ratio"
        if built_m2 is not None and key in airframe.structure.model_fields_set:
            value = getattr(airframe.structure, key)
            text = f"follows from airframe.drag.pods; give one (got {value:g})"
            raise wrong_value(f"structure.{key}", text)
    trimmed = balance is not None and balance.static_margin is not None
    polar = airframe.aerodynamics
    if polar.model == "own" and (airframe.drag is not None or trimmed):
        key = "drag" if airframe.drag is not None else "balance.static_margin"
        raise wrong_value(
            "aerodynamics.model", f"must be parabolic or wing_polar with airframe.{key} (got own)"
        )
    if airframe.drag is not None and polar.model == "wing_polar":
        for key in _DRAG_CONSTANTS["wing_polar"]:
            if (value := getattr(polar, key)) > 0.0:
                text = f"must be 0 with airframe.drag, which has that part (got {value:g})"
                raise wrong_value(f"aerodynamics.{key}", text)


def _check_structure(structure: Any) -> None:
    if not isinstance(structure, RibWingStructure):
        text = "must be rib_wing with airframe.tail, as it alone has the tail as a part"
        raise wrong_value("structure.model", f"{text} (got {structure.model})")
    if structure.booms == 0:
        raise wrong_value("structure.booms", "must be 1 or 2 with airframe.tail (got 0)")
    for key in _TAIL_KEYS:
        if key in structure.model_fields_set and not structure.is_unchecked():
            value = getattr(structure, key)
            raise wrong_value(
                f"structure.{key}", f"follows from airframe.tail; give one (got {value:g})"
            )
