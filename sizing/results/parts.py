"""Whole solar and battery cells of an aircraft, in numbers."""

from __future__ import annotations

from typing import Any

from sizing.aircraft import Aircraft


def cells_record(aircraft: Aircraft) -> dict[str, Any]:
    """Return solar cells, strings and pack of an aircraft; empty without whole cells."""
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
    """Return strings, their voltages at the coldest and hottest modules, and their MPPTs."""
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
