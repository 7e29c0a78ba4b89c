"""A battery pack of whole cells in series and in parallel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeGuard

from pydantic import ValidationError, model_validator
from pydantic_core import PydanticCustomError

from missions.files.errors import InputError
from solar.schema import PositiveInteger, PositiveReal, Record, UnitInterval

__all__ = ["BatteryPack", "packed"]

# Masses in files are rounded: a share of a string of cells in parallel that counts as none.
_ROUNDED = 0.02
_LARGEST = 1e12  # of any number in a file


class BatteryPack(Record):
    """Whole cells of a battery.

    ``cells_in_series`` is that of ``battery.voltage`` where the file has one; ``cells_in_parallel``
    follows from ``battery.mass_kg`` where it is left out, and the mass from it. Mass and largest
    charge current are those of one cell; without them those of the catalogue's entry. Of a cell's
    energy the part between the states of charge ``usable_from`` and ``usable_to`` is used.
    """

    cells_in_series: PositiveInteger
    cells_in_parallel: PositiveInteger
    cell_mass_kg: PositiveReal
    maximum_charge_current_a: PositiveReal | None = None
    usable_from: UnitInterval = 0.0
    usable_to: UnitInterval = 1.0

    @model_validator(mode="after")
    def _check_window(self) -> BatteryPack:
        if self.usable_from >= self.usable_to:
            raise PydanticCustomError(
                "window",
                "must be above usable_from {low} (got {high})",
                {
                    "key": "usable_to",
                    "low": f"{self.usable_from:g}",
                    "high": f"{self.usable_to:g}",
                },
            )
        return self

    @property
    def count(self) -> int:
        """Cells of the pack."""
        return self.cells_in_series * self.cells_in_parallel

    @property
    def usable(self) -> float:
        """Part of a cell's energy that is used [-]."""
        return self.usable_to - self.usable_from

    @property
    def charge_current_a(self) -> float | None:
        """Largest charge current of the pack [A]; None where that of a cell is not known."""
        current = self.maximum_charge_current_a
        return None if current is None else self.cells_in_parallel * current

    def mass_kg(self, cell_mass_fraction: float) -> float:
        """Mass of the pack: that of the cells over their share of it [kg]."""
        return self.count * self.cell_mass_kg / cell_mass_fraction


def packed(data: Any) -> tuple[Any, set[str]]:
    """Data of a battery with what its pack gives, and the keys that are new.

    Data that are wrong are left to the validation of the records.
    """
    raw = data.get("pack") if isinstance(data, Mapping) else None
    raw = raw.model_dump(exclude_unset=True) if isinstance(raw, BatteryPack) else raw
    if not isinstance(raw, Mapping):
        return data, set()
    pack = {**_of_entry(data), **_series(data), **raw}
    _check_series(data, raw)
    given = data.get("mass_kg")
    share = data.get("cell_mass_fraction", 1.0)
    if "cells_in_parallel" not in pack and _is_number(given):
        pack["cells_in_parallel"] = _parallel(pack, given, share)
    try:
        found = BatteryPack.model_validate(pack)
    except ValidationError:
        return {"mass_kg": 1.0, **data, "pack": pack}, set()
    if not _is_number(share) or share > 1.0:
        return {"mass_kg": 1.0, **data, "pack": pack}, set()
    mass = found.mass_kg(share)
    unit = mass / found.cells_in_parallel
    if _is_number(given) and abs(given - mass) > _ROUNDED * unit:
        raise _no_whole_number(pack, given, unit)
    values = {**data, "pack": pack} | _in_window(data, found)
    if given is None or _is_number(given):
        values["mass_kg"] = mass
    return values, set(values) - set(data)


def _in_window(data: Mapping[str, Any], pack: BatteryPack) -> dict[str, Any]:
    """Specific energy and charge limit of the part of the energy that is used."""
    if pack.usable == 1.0:
        return {}
    if "specific_energy_wh_per_kg" in data or data.get("cell") is None:
        key = "usable_from" if pack.usable_from > 0.0 else "usable_to"
        raise PydanticCustomError(
            "window",
            "goes with battery.cell: specific_energy_wh_per_kg is usable energy already",
            {"key": f"pack.{key}"},
        )
    try:
        values = _entry(data).parameters(data)
    except (InputError, OSError):
        return {}  # told by the validation of the name
    energy = values["specific_energy_wh_per_kg"] * pack.usable
    found: dict[str, Any] = {"specific_energy_wh_per_kg": float(f"{energy:.6g}")}
    limit = values.get("charge_limit")
    if limit is not None and "charge_limit" not in data:
        rate = float(f"{limit['c_rate_per_h'] / pack.usable:.6g}")
        found["charge_limit"] = limit | {"c_rate_per_h": rate}
    return found


def _entry(data: Mapping[str, Any]) -> Any:
    from sizing.catalogues.files import entry

    return entry("batteries", str(data["cell"]))


def _of_entry(data: Mapping[str, Any]) -> dict[str, Any]:
    """Mass and charge current of a cell of the catalogue, as far as it has them."""
    if data.get("cell") is None:
        return {}
    try:
        one = _entry(data)
    except (InputError, OSError):
        return {}  # told by the validation of the name
    keys = {"cell_mass_kg": one.mass_kg, "maximum_charge_current_a": one.maximum_charge_current_a}
    if one.kind == "pack":
        raise PydanticCustomError(
            "whole_pack",
            "is of no use here: {label} is a whole pack, not a cell",
            {"key": "pack", "label": one.label},
        )
    return {key: value for key, value in keys.items() if value is not None}


def _series(data: Mapping[str, Any]) -> dict[str, Any]:
    """Cells in series of the battery's table of voltages."""
    voltage = data.get("voltage")
    if isinstance(voltage, Record):
        voltage = voltage.model_dump()
    known = voltage.get("cells_in_series") if isinstance(voltage, Mapping) else None
    return {} if known is None else {"cells_in_series": known}


def _check_series(data: Mapping[str, Any], raw: Mapping[str, Any]) -> None:
    known = _series(data).get("cells_in_series")
    own = raw.get("cells_in_series")
    if known is not None and own is not None and known != own:
        raise PydanticCustomError(
            "series",
            "must be that of battery.voltage, {known} (got {own}); it may be left out",
            {"key": "pack.cells_in_series", "known": str(known), "own": str(own)},
        )


def _parallel(pack: Mapping[str, Any], mass_kg: float, share: Any) -> int:
    """Cells in parallel of a mass; a mass that is no whole number of cells is refused."""
    series, cell_kg = pack.get("cells_in_series"), pack.get("cell_mass_kg")
    if not (_is_number(series) and _is_number(cell_kg) and _is_number(share)):
        return 1  # told by the validation of the record
    unit = series * cell_kg / share
    parallel = round(mass_kg / unit)
    if parallel < 1 or abs(mass_kg / unit - parallel) > _ROUNDED:
        raise _no_whole_number(pack, mass_kg, unit)
    return parallel


def _no_whole_number(pack: Mapping[str, Any], mass_kg: float, unit: float) -> PydanticCustomError:
    below = max(int(mass_kg / unit), 1)
    series = pack["cells_in_series"]
    known = pack.get("cells_in_parallel")
    numbers = [below, below + 1] if known is None else [known]
    allowed = " or ".join(f"{n * unit:.4g} kg ({series} × {n} cells)" for n in numbers)
    return PydanticCustomError(
        "whole_cells",
        "must be that of whole cells, {allowed} (got {mass})",
        {"key": "mass_kg", "allowed": allowed, "mass": f"{mass_kg:g}"},
    )


def _is_number(value: Any) -> TypeGuard[float]:
    """Whether it is a number that arithmetic takes; what is none the records refuse."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and 0.0 < value <= _LARGEST
