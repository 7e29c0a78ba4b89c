"""Tables and records of the catalogues."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from sizing.catalogues.choice import Kind, entries
from sizing.catalogues.entries import BatteryEntry, CellEntry, Entry, MotorEntry, MpptEntry
from studies.render.tables import Column, Table

_TITLES: dict[Kind, str] = {
    "cells": "solar cells: modules.cell",
    "batteries": "batteries: battery.cell",
    "motors": "motors: airframe.propulsion.motor",
    "propellers": "propellers: airframe.propulsion.propeller.product",
    "mppts": "MPPTs: modules.mppt_board",
}
_NOTES: dict[Kind, str] = {
    "cells": "Mass with 0.20 kg/m² of encapsulation and cables. What is unknown is that of the "
    "aircraft's file, else the default.",
    "batteries": "Wh/kg of the cells; battery.cell_mass_fraction is their share of a pack. "
    "Basis: min/max is the least energy over the largest mass of the data sheet; typical has a "
    "typical capacity or mass, since the sheet has no other; stated is the maker's Wh/kg; pack is "
    "a whole pack. Compare cells of one basis: typical and stated values are up to 10 % above "
    "min/max. Charge: current over capacity. Loss: at 1 C.",
    "motors": "Efficiency: the best at 24 V; at more or less current it is lower.",
    "propellers": "Greatest efficiency: computed by the maker for 3000 rpm, measured in a wind "
    "tunnel (its speed: --json).",
    "mppts": "Power: of the modules that one takes. Efficiency: the least that is stated. Input: "
    "largest voltage and current.",
}
_COLUMNS: dict[Kind, tuple[Column, ...]] = {
    "cells": (
        Column("efficiency_stc", "efficiency", "%", ".1f"),
        Column("efficiency_am0", "AM0", "%", ".1f"),
        Column("temperature_coefficient_per_k", "temp. coeff.", "%/K", ".2f", "unknown"),
        Column("mass_kg_per_m2", "mass", "kg/m2", ".2f", "unknown"),
    ),
    "batteries": (
        Column("specific_energy_wh_per_kg", "energy", "Wh/kg", ".0f"),
        Column("basis"),
        Column("capacity_ah", "capacity", "Ah", ".3g"),
        Column("charge_rate_per_h", "charge", "1/h", ".2f"),
        Column("loss_at_1c", "loss", "%", ".1f"),
    ),
    "motors": (
        Column("mass_kg", "mass", "kg", ".3f"),
        Column("speed_constant_rpm_per_v", "speed", "rpm/V", ".0f"),
        Column("resistance_ohm", "resist.", "ohm", ".3f"),
        Column("no_load_current_a", "no-load", "A", ".2f"),
        Column("efficiency_24_v", "effic.", "%", ".0f"),
    ),
    "propellers": (
        Column("diameter_m", "diameter", "m", ".3f"),
        Column("pitch_m", "pitch", "m", ".3f"),
        Column("blades", "blades", "", ".0f"),
        Column("computed_efficiency_3000_rpm", "computed", "%", ".0f"),
        Column("measured_efficiency", "measured", "%", ".0f"),
    ),
    "mppts": (
        Column("mass_kg", "mass", "kg", ".3f"),
        Column("rated_power_w", "power", "W", ".0f"),
        Column("mass_g_per_w", "mass", "g/W", ".2f"),
        Column("efficiency", "effic.", "%", ".0f"),
        Column("maximum_voltage_v", "input", "V", ".0f"),
        Column("maximum_current_a", "input", "A", ".0f"),
    ),
}

# Columns that are called otherwise in an entry.
_ATTRIBUTES = {"specific_energy_wh_per_kg": "specific_energy", "capacity_ah": "capacity"}


def catalogue_table(kind: Kind) -> Table:
    """Return the entries of a catalogue, a row each."""
    columns = (Column("name"), Column("label", "product"), *_COLUMNS[kind])
    rows = tuple(
        (name, entry.label, *_values(entry, _COLUMNS[kind]))
        for name, entry in entries(kind).items()
    )
    return Table(_TITLES[kind], columns, rows, (_NOTES[kind],))


def _values(entry: Entry, columns: Sequence[Column]) -> Iterator[float | str | None]:
    """Yield the values of an entry in the units of the columns."""
    for column in columns:
        name = column.name
        if isinstance(entry, CellEntry) and name == "mass_kg_per_m2":
            value = entry.parameters({"efficiency_stc": 1.0}).get(name)
        elif isinstance(entry, MotorEntry) and name == "efficiency_24_v":
            value = entry.best_efficiency(24.0)
        elif isinstance(entry, MpptEntry) and name == "mass_g_per_w":
            value = 1000.0 * entry.mass_kg_per_w
        else:
            value = getattr(entry, _ATTRIBUTES.get(name, name))
        yield 100.0 * value if column.unit.startswith("%") and value is not None else value


def catalogue_record(kind: Kind) -> dict[str, Any]:
    """Return the entries of a catalogue by their names, JSON-ready."""
    return {
        name: entry.model_dump(mode="json", exclude_none=True)
        | ({"basis": entry.basis} if isinstance(entry, BatteryEntry) else {})
        for name, entry in entries(kind).items()
    }
