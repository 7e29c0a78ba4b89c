"""Tables and records of the catalogues."""

from __future__ import annotations

from collections.abc import Callable
from operator import attrgetter
from typing import Any

from missions.files.data_rows import data_rows
from sizing.catalogues.choice import Kind, entries
from sizing.catalogues.entries import BatteryEntry, Entry
from studies.render.tables import MISSING, Column, Table

# Values that an entry has by another name, or computes.
_VALUES: dict[str, Callable[[Any], float | None]] = {
    "mass_kg_per_m2": lambda cell: cell.parameters({"efficiency_stc": 1.0}).get("mass_kg_per_m2"),
    "specific_energy_wh_per_kg": attrgetter("specific_energy"),
    "capacity_ah": attrgetter("capacity"),
    "efficiency_24_v": lambda motor: motor.best_efficiency(24.0),
    "mass_g_per_w": lambda mppt: 1000.0 * mppt.mass_kg_per_w,
}


def catalogue_table(kind: Kind) -> Table:
    """Return the entries of a catalogue, a row each."""
    of_kind = {row["catalogue"]: row for row in data_rows("catalogue_notes", "studies")}[kind]
    columns = [
        Column(row["name"], row["label"], row["unit"], row["form"], row["missing"] or MISSING)
        for row in data_rows("catalogues", "studies")
        if row["catalogue"] == kind
    ]
    rows = tuple(
        (name, entry.label, *(_value(entry, column) for column in columns))
        for name, entry in entries(kind).items()
    )
    described = (Column("name"), Column("label", "product"), *columns)
    return Table(of_kind["title"], described, rows, (of_kind["note"],))


def _value(entry: Entry, column: Column) -> Any:
    """Return a value of an entry in the unit of its column."""
    value = _VALUES.get(column.name, attrgetter(column.name))(entry)
    return 100.0 * value if column.unit.startswith("%") and value is not None else value


def catalogue_record(kind: Kind) -> dict[str, Any]:
    """Return the entries of a catalogue by their names, JSON-ready."""
    return {
        name: entry.model_dump(mode="json", exclude_none=True)
        | ({"basis": entry.basis} if isinstance(entry, BatteryEntry) else {})
        for name, entry in entries(kind).items()
    }
