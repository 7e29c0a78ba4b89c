"""An aircraft by its parts, for results: balance and drag, solar and battery cells."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from sizing.aircraft import Aircraft
from sizing.balance.assessment import BalanceAssessment
from sizing.balance.drag import DragShares
from sizing.catalogues.choice import taken
from sizing.chosen_parts import put_parts_in
from sizing.design import Design
from sizing.layout.cells import rows_text
from sizing.parameters import parameter
from sizing.program.objectives import Objective
from sizing.results.quantities import CHOSEN, TOTAL_MASS
from sizing.results.records import finite_values, with_unit
from sizing.results.tables import UNLIMITED, Column, Line, Table

if TYPE_CHECKING:
    from sizing.program.whole_cells import WholeCells


_DRAG_WORDS = {
    "wing_profile": "wing, profile",
    "wing_induced": "wing, induced",
    "horizontal_tail": "horizontal tail",
    "vertical_tail": "vertical tail",
    "gaps": "gaps, leaks, protuberances",
    "other": "constants of the file",
}
_MASS_WORDS = {"mppt": "MPPT", "spar_caps": "spar caps", "spar_web": "spar web"}
_CLOSE = 0.01  # what a weighed list and the mass budget may differ by without a note


def balance_blocks(shares: DragShares | None, balance: BalanceAssessment | None) -> list[Any]:
    """Tables and lines of an analysis; none where the file has no such keys."""
    blocks: list[Any] = []
    if shares is not None:
        share = 100.0 * float(shares.parasitic / shares.total)
        text = (
            f"Parasitic drag, all but the wing and the trim: C_D {float(shares.parasitic):.5f}, "
            f"{share:.1f} % of the drag."
        )
        blocks += [drag_table(shares), Line(text)]
    if balance is not None:
        blocks.append(balance_table(balance))
        blocks += [Line(text) for text in balance_lines(balance)]
    return blocks


def drag_table(shares: DragShares) -> Table:
    """Drag of the parts of level flight, with their shares."""
    columns = (
        Column("part"),
        Column("coefficient", "C_D on the wing area", form=".5f"),
        Column("share", "share", "%", ".1f"),
    )
    rows = [
        (_DRAG_WORDS.get(name, name), float(one), 100.0 * float(one / shares.total))
        for name, one in (*shares._asdict().items(), ("sum", shares.total))
        if one != 0.0
    ]
    return Table("drag budget of level flight", columns, tuple(rows))


def drag_record(shares: DragShares) -> dict[str, float]:
    """Drag coefficients of the parts, JSON-ready, and their sums."""
    parts = {name: float(one) for name, one in shares._asdict().items()}
    return parts | {"parasitic": float(shares.parasitic), "total": float(shares.total)}


def balance_table(balance: BalanceAssessment) -> Table:
    """Masses with their places."""
    columns = (
        Column("item"),
        Column("mass", "mass", "kg", ".3f"),
        Column("place", "behind leading edge", "m", ".3f"),
    )
    rows = [(_MASS_WORDS.get(one.name, one.name), one.mass_kg, one.x_m) for one in balance.items]
    rows.append(("centre of gravity", balance.mass_kg, balance.gravity_m))
    return Table("balance, from the leading edge of the wing root", columns, tuple(rows))


def balance_lines(balance: BalanceAssessment) -> list[str]:
    """Static margin, tail, trim and controls in sentences."""
    tail, level, out = balance.planes, balance.level, balance.motor_out
    stable = "stable" if balance.static_margin > 0.0 else "unstable"
    lines = [
        f"Static margin {100.0 * balance.static_margin:.1f} % of the mean aerodynamic chord "
        f"({stable}): centre of gravity at {100.0 * balance.in_chord(balance.gravity_m):.1f} %, "
        f"neutral point at {100.0 * balance.in_chord(balance.found.x_m):.1f} % of "
        f"{balance.wing.aerodynamic_chord_m:.3f} m.",
        f"Tail planes of {tail.horizontal_m2:.3f} and {tail.vertical_m2:.3f} m², "
        f"{tail.arm_m:.2f} m behind the wing; trimmed C_L {level.wing_lift:.3f} of the wing and "
        f"{level.tail_lift:.3f} of the tail, trim drag {level.drag:+.5f} "
        f"({100.0 * level.drag / balance.drag_coefficient:+.1f} % of the drag).",
        f"Elevator, trailing edge up positive, of {balance.elevator_limit_deg:g}°: "
        f"{-balance.elevator_deg:+.1f}° trims 1.2 times the stall speed, "
        f"{-balance.elevator_at_stall_deg:+.1f}° the stall. Rudder at 1.2 times the stall speed: "
        f"{balance.sideslip_deg:.0f}° of sideslip, {balance.crosswind_m_per_s:.1f} m/s of crosswind"
        + ("." if out is None else f"; one motor out needs {100.0 * out:.0f} % of it."),
    ]
    if (margin := balance.asked_margin) is not None:
        volume = balance.holding_volume
        would = "no horizontal tail" if volume is None else f"a horizontal volume of {volume:.3f}"
        lines[0] += f" The {100.0 * margin:g} % asked for would take {would}."
    off = balance.mass_kg / balance.design_mass_kg - 1.0
    if abs(off) > _CLOSE:
        lines.append(
            f"The weighed masses add up to {balance.mass_kg:.3f} kg, {100.0 * off:+.1f} % off the "
            f"mass budget of {balance.design_mass_kg:.3f} kg."
        )
    return lines


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
    loss, lengths = aircraft.modules.temperature_coefficient_per_k, strings.lengths(layout.count)
    mpp, unloaded = strings.mpp_voltage_v, strings.open_circuit_voltage_v
    shortest, longest = min(lengths), max(lengths)
    return {
        "count": len(lengths),
        "cells_in_series": longest if shortest == longest else list(lengths),
        "mppts": strings.mppts(layout.count),
        "hottest_mpp_voltage_v": shortest * strings.voltage_v(mpp, strings.hottest_c, loss),
        "coldest_mpp_voltage_v": longest * strings.voltage_v(mpp, strings.coldest_c, loss),
        "coldest_open_voltage_v": longest * strings.voltage_v(unloaded, strings.coldest_c, loss),
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
            series = strings["cells_in_series"]
            series = ", ".join(map(str, series)) if isinstance(series, list) else series
            text += (
                f"; {_counted(strings['count'], 'string')} of {series} on "
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
    return with_unit(math.inf if value is None else value, ".4g", objective)


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


def sized_data(aircraft: Aircraft, design: Design, whole_cells: bool) -> dict[str, Any]:
    """Aircraft's file as data, with an optimum put in.

    Without ``whole_cells`` those of the file are another design's, and leave the technology they
    had given.
    """
    data = aircraft.model_dump(mode="json", exclude_unset=True)
    data["name"] = f"{data['name']}-sized"
    for one in CHOSEN:
        section, key = parameter(one.name).key.split(".")
        data[section][key] = one.of(design)
    put_parts_in(data, aircraft, design)
    if whole_cells:
        return data
    if data["modules"].pop("layout", None) is not None:
        # The boards of the strings, which may have less than the power that they take.
        data["modules"]["mppt_mass_kg_per_w"] = aircraft.modules.mppt_mass_kg_per_w
        if data["modules"].pop("mppt_board", None) is not None:
            data["modules"]["mppt_efficiency"] = aircraft.modules.mppt_efficiency
    if data["battery"].pop("pack", None) is not None:
        technology = aircraft.battery.model_dump(mode="json")
        of_entry = {one.key for one in taken(aircraft.battery, "")}
        for key in ("specific_energy_wh_per_kg", "charge_limit"):
            if key not in of_entry:
                data["battery"][key] = technology[key]
    return data
