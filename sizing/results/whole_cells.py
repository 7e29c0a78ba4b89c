"""Whole cells of an aircraft, and of a sizing, for results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from sizing.aircraft import Aircraft
from sizing.layout.cells import rows_text
from sizing.optimisation.objectives import Objective
from sizing.parameters import unit_text
from sizing.results.quantities import TOTAL_MASS
from sizing.results.records import finite_values
from sizing.results.tables import UNLIMITED, Column, Table

if TYPE_CHECKING:
    from sizing.optimisation.whole_cells import WholeCells


_SHOWN = 10  # designs in the table; JSON has all


def cells_record(aircraft: Aircraft) -> dict[str, Any]:
    """Solar cells, strings and pack of an aircraft, JSON-ready; empty without whole cells."""
    layout, pack, battery = aircraft.modules.layout, aircraft.battery.pack, aircraft.battery
    record: dict[str, Any] = {}
    if layout is not None:
        record["solar_cells"] = {
            "count": layout.count,
            "area_m2": layout.area_m2,
            "mass_kg": layout.area_m2 * aircraft.modules.mass_kg_per_m2,
            "rows_of_each_half": [list(bay.cells) for bay in layout.bays],
            "tail_rows": list(layout.tail_cells),
        }
        if layout.strings is not None:
            record["strings"] = _strings_record(aircraft)
    if pack is not None:
        low_v, high_v = battery.ends_v or (None, None)
        record["battery_pack"] = {
            "cells_in_series": pack.cells_in_series,
            "cells_in_parallel": pack.cells_in_parallel,
            "mass_kg": battery.mass_kg,
            "battery_energy_wh": battery.battery_energy_wh,
            "empty_voltage_v": low_v,
            "full_voltage_v": high_v,
            "charge_current_a": pack.charge_current_a,
        }
    return record


def _strings_record(aircraft: Aircraft) -> dict[str, Any]:
    """Strings, their voltages at the ends of the modules' temperature, and their MPPTs."""
    layout = aircraft.modules.layout
    strings = None if layout is None else layout.strings
    assert layout is not None
    assert strings is not None
    assert strings.mpp_voltage_v is not None
    assert strings.open_circuit_voltage_v is not None
    loss, series = aircraft.modules.temperature_coefficient_per_k, strings.cells_in_series
    mpp, unloaded = strings.mpp_voltage_v, strings.open_circuit_voltage_v
    return {
        "count": layout.count // series,
        "cells_in_series": series,
        "mppts": strings.mppts(layout.count),
        "hottest_mpp_voltage_v": series * strings.voltage_v(mpp, strings.hottest_c, loss),
        "coldest_mpp_voltage_v": series * strings.voltage_v(mpp, strings.coldest_c, loss),
        "coldest_open_voltage_v": series * strings.voltage_v(unloaded, strings.coldest_c, loss),
    }


def cells_lines(record: Mapping[str, Any]) -> list[str]:
    """Whole cells in words, from their record: a line for modules and one for the battery."""
    lines = []
    solar, strings = record.get("solar_cells"), record.get("strings")
    pack = record.get("battery_pack")
    if solar is not None:
        rows = ", then ".join(rows_text(bay) for bay in solar["rows_of_each_half"])
        text = f"solar cells: {solar['count']}, each half of the wing {rows}"
        if solar["tail_rows"]:
            text += f", the tail {rows_text(solar['tail_rows'])}"
        if strings is not None:
            text += (
                f"; {_counted(strings['count'], 'string')} of {strings['cells_in_series']} on "
                f"{_counted(strings['mppts'], 'MPPT')}, {strings['hottest_mpp_voltage_v']:.1f} to "
                f"{strings['coldest_mpp_voltage_v']:.1f} V, "
                f"{strings['coldest_open_voltage_v']:.1f} V unloaded"
            )
        lines.append(text)
    if pack is not None:
        series, parallel = pack["cells_in_series"], pack["cells_in_parallel"]
        text = f"battery cells: {series * parallel}, {series} in series and {parallel} in parallel"
        if pack["empty_voltage_v"] is not None:
            text += f", {pack['empty_voltage_v']:.1f} to {pack['full_voltage_v']:.1f} V"
        if pack["charge_current_a"] is not None:
            text += f", charged with at most {pack['charge_current_a']:.1f} A"
        lines.append(text)
    return lines


def _counted(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' if number > 1 else ''}"


def loss_line(record: Mapping[str, Any], objective: Objective) -> str:
    """What whole cells cost, from the record of a sizing."""
    chosen, loss = record["chosen"], record["loss"]
    relaxed = f"the relaxed optimum's {_value(record['relaxed'], objective)}"
    if chosen is None:
        return f"no whole cells beside {relaxed}"
    text = f"{objective.label} {_value(chosen, objective)}"
    if loss is None:
        return f"whole cells: {text}, beside {relaxed}"
    return f"loss by whole cells: {text}, {100.0 * loss:.1f} % worse than {relaxed}"


def _value(design: Mapping[str, Any], objective: Objective) -> str:
    """Objective of a design with its unit; JSON has null for an unlimited one."""
    value = design["value"]
    return UNLIMITED if value is None else f"{value:.4g} {unit_text(objective.unit)}".rstrip()


def neighbour_table(record: Mapping[str, Any], objective: Objective) -> Table:
    """Designs of whole cells that were tried, the best first, infeasible ones with the reason."""
    tried = record["tried"]
    feasible = [one for one in tried if not one["reason"]]
    infeasible = [one for one in tried if one["reason"]]
    room = max(_SHOWN - len(infeasible), _SHOWN // 2)
    shown = [*feasible[:room], *infeasible[: _SHOWN - min(room, len(feasible))]]
    strung = any(one["strings"] is not None for one in tried)
    columns = [
        Column("cells", "solar cells"),
        *([Column("strings")] if strung else []),
        Column("battery_cells", "battery cells"),
        Column("value", objective.label, objective.unit, ".4g"),
        *([] if objective is Objective.min_mass else [replace(TOTAL_MASS, form=".4g")]),
        Column("reason", "why not", missing=""),
    ]
    unlimited = {"value": UNLIMITED}
    rows = tuple(
        tuple(
            (one | unlimited if one["value"] is None and not one["reason"] else one)[column.name]
            for column in columns
        )
        for one in shown
    )
    left = len(tried) - len(shown)
    notes = (f"{left} more were tried; the record of the sizing has all",) if left else ()
    return Table("designs of whole cells", tuple(columns), rows, notes)


def sizing_record(cells: WholeCells, aircraft: Aircraft) -> dict[str, Any]:
    """Whole cells of a sizing, JSON-ready: an unlimited objective is null."""
    design = cells.relaxed.design
    variables = {} if design is None else design.variables.chosen()
    relaxed = {"value": cells.relaxed.objective_value} | variables
    record: dict[str, Any] = {
        "loss": cells.loss,
        "relaxed": finite_values(relaxed),
        "chosen": None if cells.chosen is None else finite_values(cells.chosen.__dict__),
        "tried": [finite_values(one.__dict__) for one in cells.tried],
    }
    return record | (cells_record(aircraft) if cells.aircraft is not None else {})
