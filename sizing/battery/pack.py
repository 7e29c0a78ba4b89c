"""A battery pack of whole cells in series and in parallel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError, model_validator

from sizing.catalogues.choice import known_entry
from solar.schema import (
    MOST_CELLS,
    CellCount,
    PositiveReal,
    Record,
    UnitInterval,
    check_order,
    is_positive,
    wrong_value,
)

# Masses in files are rounded: a share of a string of cells in parallel that counts as none.
_ROUNDED = 0.02


class BatteryPack(Record):
    """Whole cells of a battery.

    ``cells_in_series`` is that of ``battery.voltage`` where the file has one; ``cells_in_parallel``
    follows from ``battery.mass_kg`` where it is left out, and the mass from it. Mass and largest
    charge current are those of one cell; without them those of the catalogue's entry. Of a cell's
    energy the part between ``minimum_state_of_charge`` and ``maximum_state_of_charge`` is used.
    """

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
            text = f"must be at most {most}: {text} (got {self.cells_in_parallel})"
            raise wrong_value("cells_in_parallel", text)
        check_order(self, "minimum_state_of_charge", "maximum_state_of_charge")
        return self

    @property
    def count(self) -> int:
        """Cells of the pack."""
        return self.cells_in_series * self.cells_in_parallel

    @property
    def usable(self) -> float:
        """Part of a cell's energy that is used [-]."""
        return self.maximum_state_of_charge - self.minimum_state_of_charge

    @property
    def charge_current_a(self) -> float | None:
        """Largest charge current of the pack [A]; None where that of a cell is not known."""
        current = self.maximum_charge_current_a
        return None if current is None else self.cells_in_parallel * current

    def mass_kg(self, cell_mass_fraction: float) -> float:
        """Mass of the pack: that of the cells over their share of it [kg]."""
        return self.count * self.cell_mass_kg / cell_mass_fraction


def packed(data: Mapping[str, Any]) -> tuple[Mapping[str, Any], set[str]]:
    """Data of a battery with what its pack gives, and the keys that are new.

    Data that are wrong are left to the validation of the records.
    """
    raw = data["pack"]
    raw = raw.model_dump(exclude_unset=True) if isinstance(raw, BatteryPack) else raw
    if not isinstance(raw, Mapping):
        return {"mass_kg": 1.0, **data}, set()
    of_voltage = _cells_in_series(data, raw)
    if any(not is_positive(n) or n > MOST_CELLS or n % 1 for n in of_voltage.values()):
        return {"mass_kg": 1.0, **data, "pack": None}, set()
    pack = {**_of_entry(data), **of_voltage, **raw}
    given, share = data.get("mass_kg"), data.get("cell_mass_fraction", 1.0)
    unit = _unit_kg(pack, share)
    if unit is not None and is_positive(given):
        pack.setdefault("cells_in_parallel", max(round(given / unit), 1))
    try:
        found = BatteryPack.model_validate(pack)
    except ValidationError:
        found = None
    if found is None or unit is None or not (given is None or is_positive(given)):
        return {"mass_kg": 1.0, **data, "pack": pack}, set()
    if given is not None and abs(given / unit - found.cells_in_parallel) > _ROUNDED:
        raise wrong_value("mass_kg", _no_whole_number(found, raw, given, unit))
    mass = {"mass_kg": found.mass_kg(share)}
    values = {**data, **mass, "pack": pack, **_in_window(data, found)}
    return values, set(values) - set(data)


def _unit_kg(pack: Mapping[str, Any], share: Any) -> float | None:
    """Mass of one string of cells of the pack [kg]; None where the record will refuse it."""
    series, cell_kg = pack.get("cells_in_series"), pack.get("cell_mass_kg")
    if is_positive(series) and is_positive(cell_kg) and is_positive(share):
        return series * cell_kg / share
    return None


def _no_whole_number(
    pack: BatteryPack, raw: Mapping[str, Any], mass_kg: float, unit_kg: float
) -> str:
    below = max(int(mass_kg / unit_kg), 1)
    fixed = "cells_in_parallel" in raw
    numbers = [pack.cells_in_parallel] if fixed else [below, below + 1]
    allowed = " or ".join(f"{n * unit_kg:.4g} kg ({pack.cells_in_series} × {n})" for n in numbers)
    return f"must be that of whole cells, {allowed} (got {mass_kg:g})"


def _in_window(data: Mapping[str, Any], pack: BatteryPack) -> dict[str, Any]:
    """Specific energy and charge limit of the part of the energy that is used."""
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
    found: dict[str, Any] = {"specific_energy_wh_per_kg": float(f"{energy:.6g}")}
    limit = values.get("charge_limit")
    if limit is not None and "charge_limit" not in data:
        rate = float(f"{limit['c_rate_per_h'] / pack.usable:.6g}")
        found["charge_limit"] = limit | {"c_rate_per_h": rate}
    return found


def _of_entry(data: Mapping[str, Any]) -> dict[str, Any]:
    """Mass and charge current of a cell of the catalogue, as far as it has them."""
    one = known_entry("batteries", data, "cell")
    if one is None:
        return {}
    if one.kind == "pack":
        raise wrong_value("pack", f"is of no use here: {one.label} is a whole pack, not a cell")
    mass = one.mass_kg
    if mass is None and one.energy is not None:
        mass = one.energy / one.specific_energy
    keys = {"cell_mass_kg": mass, "maximum_charge_current_a": one.maximum_charge_current_a}
    return {key: value for key, value in keys.items() if value is not None}


def _cells_in_series(data: Mapping[str, Any], raw: Mapping[str, Any]) -> dict[str, Any]:
    """Cells in series of the battery's table of voltages."""
    voltage = data.get("voltage")
    voltage = voltage.model_dump() if isinstance(voltage, Record) else voltage
    known = voltage.get("cells_in_series") if isinstance(voltage, Mapping) else None
    own = raw.get("cells_in_series", known)
    if known is not None and own != known:
        text = f"must be that of battery.voltage, {known} (got {own}); it may be left out"
        raise wrong_value("pack.cells_in_series", text)
    return {} if known is None else {"cells_in_series": known}
