"""Values of modules from a layout of cells, and checks of the layout on an aircraft."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from sizing.catalogues.choice import known_entry
from sizing.catalogues.entries import CellEntry, MpptEntry
from sizing.layout.cells import CellLayout, Wing
from solar.schema import Record, is_positive, spell, wrong_value
from solar.shading import TailGeometry

_OF_A_CELL = ("mpp_voltage_v", "open_circuit_voltage_v", "mpp_current_a")
_HALF_A_CELL = 0.5  # tolerance of a given area, in cells


def with_layout_values(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the modules' data with the area of the layout's cells.

    Wrong data are left to the validation of the records.
    """
    raw = data["layout"]
    raw = raw.model_dump(exclude_unset=True) if isinstance(raw, Record) else raw
    if not isinstance(raw, Mapping):
        return data
    board = known_entry("mppts", data, "mppt_board")
    layout = _with_entry(raw, known_entry("cells", data, "cell"), board)
    try:
        cells = CellLayout.model_validate(layout)
    except ValidationError:
        return {"area_m2": 0.0, **data, "layout": layout}
    area = data.get("area_m2")
    if "area_m2" in data and not (area == 0.0 or is_positive(area)):
        return {**data, "layout": layout}
    if area is not None and abs(area / cells.area_of_a_cell_m2 - cells.count) >= _HALF_A_CELL:
        text = f"must be that of the {cells.count} cells of modules.layout, "
        text += f"{spell(cells.area_m2, 4)} m², or left out"
        raise wrong_value("area_m2", text, got=area)
    return {**data, "layout": layout, "area_m2": cells.area_m2}


def _with_entry(
    raw: Mapping[str, Any], entry: CellEntry | None, board: MpptEntry | None
) -> dict[str, Any]:
    """Return the layout with missing area and voltages from the catalogue's cell and MPPT."""
    layout, strings = dict(raw), raw.get("strings")
    if board is not None and isinstance(strings, Mapping):
        mppt = strings.get("mppt", {})
        mppt = board.window() | dict(mppt) if isinstance(mppt, Mapping) else mppt
        layout["strings"] = strings = {**strings, "mppt": mppt}
    if entry is None:
        return layout
    part = _part_of(raw, entry.area_m2)
    if part == 1.0:
        layout.setdefault("cell_area_m2", entry.area_m2)
    if isinstance(strings, Mapping):
        known = {key: getattr(entry, key) for key in _OF_A_CELL}
        if known["mpp_current_a"] is not None:
            known["mpp_current_a"] *= part
        layout["strings"] = {k: v for k, v in known.items() if v is not None} | dict(strings)
    return layout


def _part_of(raw: Mapping[str, Any], area_m2: float | None) -> float:
    """Return the area of the layout's cell over the catalogue's: 1 for a whole cell [-].

    Current scales with the area, voltage does not. A whole cell has at least the area of the round
    wafer in its outline.
    """
    span_m, chord_m = raw.get("cell_span_m"), raw.get("cell_chord_m")
    if area_m2 is None or not is_positive(span_m) or not is_positive(chord_m):
        return 1.0
    outline, cell_area_m2 = span_m * chord_m, raw.get("cell_area_m2")
    if math.pi / 4.0 * outline <= area_m2 <= outline:
        return 1.0
    return (cell_area_m2 if is_positive(cell_area_m2) else outline) / area_m2


def check_layout(
    layout: CellLayout,
    wing: Wing,
    tail: TailGeometry | None,
    loss_per_k: float,
    battery_v: tuple[float, float] | None,
) -> None:
    """Refuse cells that do not fit on wing and tail, and strings that do not fit the MPPT."""
    layout.placed(wing, tail)
    strings = layout.strings
    if strings is None:
        return
    if battery_v is None and strings.mppt.conversion != "any":
        text = f"required key is missing: modules.layout.strings.mppt has {strings.mppt.conversion}"
        raise wrong_value("battery.voltage", text)
    problem = strings.problem(layout.count, loss_per_k, battery_v)
    if problem is not None:
        raise wrong_value(f"modules.layout.strings.{problem[0]}", problem[1])
