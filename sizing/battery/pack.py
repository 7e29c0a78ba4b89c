"""Battery pack of whole cells in series and in parallel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import ValidationError, model_validator

from sizing.catalogues.choice import known_entry
from solar.schema import (
    MOST_CELLS,
    CellCount,
    PositiveReal,
    Record,
    UnitInterval,
    is_positive,
    significant,
    spell,
    wrong_value,
)

# Tolerance of rounded masses in files, relative to a string of cells.
_ROUNDED = 0.02


class BatteryPack(Record):
    """Whole cells of a battery.

    ``cells_in_series`` is by default that of ``battery.voltage``. ``cells_in_parallel`` and
    ``battery.mass_kg`` follow from each other. Mass and largest charge current are those of a cell,
    by default of the catalogue's entry. The energy between ``minimum_state_of_charge`` and
    ``maximum_state_of_charge`` is usable.
    """

    _above: ClassVar[Mapping[str, str]] = {"maximum_state_of_charge": "minimum_state_of_charge"}

    cells_in_series: CellCount
    cells_in_parallel: CellCount
    cell_mass_kg: PositiveReal
    maximum_charge_current_a: PositiveReal | None = None
    minimum_state_of_charge: UnitInterval = 0.0
    maximum_state_of_charge: UnitInterval = 1.0

    @model_validator(mode="after")
    def _check_cells(self) -> BatteryPack:
        if self.count > MOST_CELLS:
            most = MOST_CELLS // self.cells_in_series
            text = f"{MOST_CELLS} cells in all, {self.cells_in_series} in series"
            text = f"must be at most {most}: {text}"
            raise wrong_value("cells_in_parallel", text, got=self.cells_in_parallel)
        return self

    @property
    def count(self) -> int:
        """Number of cells."""
        return self.cells_in_series * self.cells_in_parallel

    @property
    def usable(self) -> float:
        """Usable share of a cell's energy [-]."""
        return self.maximum_state_of_charge - self.minimum_state_of_charge

    @property
    def charge_current_a(self) -> float | None:
        """Largest charge current of the pack [A]; None if unknown for a cell."""
        current = self.maximum_charge_current_a
        return None if current is None else self.cells_in_parallel * current

    def mass_kg(self, cell_mass_fraction: float) -> float:
        """Return the mass of the pack, by its cells and their mass fraction [kg]."""
        return self.count * self.cell_mass_kg / cell_mass_fraction


def with_pack_values(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a battery's data with the values by its pack.

    Wrong data are left to the validation of the records.
    """
    raw = data["pack"]
    raw = raw.model_dump(exclude_unset=True) if isinstance(raw, BatteryPack) else raw
    if not isinstance(raw, Mapping):
        return {"mass_kg": 1.0, **data}
    voltage_values = _cells_in_series(data, raw)
    if any(not is_positive(n) or n > MOST_CELLS or n % 1 for n in voltage_values.values()):
        return {"mass_kg": 1.0, **data, "pack": None}
    pack = {**_entry_values(data), **voltage_values, **raw}
    mass_kg, share = data.get("mass_kg"), data.get("cell_mass_fraction", 1.0)
    series, cell_kg = pack.get("cells_in_series"), pack.get("cell_mass_kg")
    unit: float | None = None  # mass of a string of cells [kg]
    if is_positive(series) and is_positive(cell_kg) and is_positive(share):
        unit = series * cell_kg / share
    if unit is not None and is_positive(mass_kg):
        pack.setdefault("cells_in_parallel", max(round(mass_kg / unit), 1))
    try:
        record = BatteryPack.model_validate(pack)
    except ValidationError:
        record = None
    if record is None or unit is None or not (mass_kg is None or is_positive(mass_kg)):
        return {"mass_kg": 1.0, **data, "pack": pack}
    if mass_kg is not None and abs(mass_kg / unit - record.cells_in_parallel) > _ROUNDED:
        below = max(int(mass_kg / unit), 1)
        numbers = [record.cells_in_parallel] if "cells_in_parallel" in raw else [below, below + 1]
        allowed = " or ".join(f"{spell(n * unit, 4)} kg ({series} × {n})" for n in numbers)
        raise wrong_value("mass_kg", f"must be that of whole cells, {allowed}", got=mass_kg)
    mass = {"mass_kg": record.mass_kg(share)}
    return {**data, **mass, "pack": pack, **_usable_energy_values(data, record)}


def _usable_energy_values(data: Mapping[str, Any], pack: BatteryPack) -> dict[str, Any]:
    """Return specific energy and charge limit for the usable part of the energy."""
    entry = known_entry("batteries", data, "cell")
    if pack.usable == 1.0 or (entry is None and data.get("cell") is not None):
        return {}
    if "specific_energy_wh_per_kg" in data or entry is None:
        key = (
            "minimum_state_of_charge"
            if pack.minimum_state_of_charge > 0.0
            else "maximum_state_of_charge"
        )
        text = "goes with battery.cell: specific_energy_wh_per_kg is usable energy already"
        raise wrong_value(f"pack.{key}", text)
    values = entry.parameters(data)
    energy = values["specific_energy_wh_per_kg"] * pack.usable
    window: dict[str, Any] = {"specific_energy_wh_per_kg": significant(energy)}
    limit = values.get("charge_limit")
    if limit is not None and "charge_limit" not in data:
        rate = significant(limit["c_rate_per_h"] / pack.usable)
        window["charge_limit"] = limit | {"c_rate_per_h": rate}
    return window


def _entry_values(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return mass and charge current of the catalogue's cell, as far as it has them."""
    entry = known_entry("batteries", data, "cell")
    if entry is None:
        return {}
    if entry.kind == "pack":
        raise wrong_value("pack", f"is of no use here: {entry.label} is a whole pack, not a cell")
    mass = entry.mass_kg
    if mass is None and entry.energy is not None:
        mass = entry.energy / entry.specific_energy
    keys = {"cell_mass_kg": mass, "maximum_charge_current_a": entry.maximum_charge_current_a}
    return {key: value for key, value in keys.items() if value is not None}


def _cells_in_series(data: Mapping[str, Any], raw: Mapping[str, Any]) -> dict[str, Any]:
    """Return the cells in series of the battery's table of voltages."""
    voltage = data.get("voltage")
    voltage = voltage.model_dump() if isinstance(voltage, Record) else voltage
    known = voltage.get("cells_in_series") if isinstance(voltage, Mapping) else None
    number = raw.get("cells_in_series", known)
    if known is not None and number != known:
        text = f"must be that of battery.voltage, {known} (got {number}); it may be left out"
        raise wrong_value("pack.cells_in_series", text)
    return {} if known is None else {"cells_in_series": known}
