"""What the terminal and JSON tell of a trade study: its points, and how they end."""

from __future__ import annotations

import math
from typing import Any

import xarray as xr
from rich.console import Console
from rich.table import Table

from studies.sweeps.axes import unit_label, without_unit
from studies.sweeps.study import to_table

_ROWS = 40
# Results that are the same as a varied key.
_VARIED_AS = {"wingspan": "wingspan_m", "battery_mass": "battery_mass_kg"}


def points_record(data: xr.Dataset) -> dict[str, Any]:
    """All points, JSON-ready; undefined and infinite numbers are null, the status says why."""
    table = to_table(data)
    rows = [
        {
            name: None if isinstance(value, float) and not math.isfinite(value) else value
            for name, value in row.items()
        }
        for row in table.to_dict("records")
    ]
    return {
        "title": data.attrs["title"],
        "sample": data.attrs["sample"],
        "objective": data.attrs["objective"] or None,
        "status": _counts(data),
        "points": rows,
    }


def _counts(data: xr.Dataset) -> dict[str, int]:
    return {str(k): int(v) for k, v in to_table(data)["status"].value_counts().items()}


def show_points(console: Console, data: xr.Dataset) -> None:
    """How many points end in which way, and the points where they fit on a screen."""
    counts = ", ".join(f"{n} {name.replace('_', ' ')}" for name, n in _counts(data).items())
    count = data["status"].size
    noun = "point" if count == 1 else "points"
    console.print(f"{data.attrs['title']}: {count} {noun}: {counts}")
    rows = to_table(data)
    varied = [str(name) for name in data.coords if name != "sample"]
    if "varied" in varied:
        # Of each point only one key differs from the file.
        rows["value"] = [row[row["varied"]] if row["varied"] else "" for _, row in rows.iterrows()]
        varied = ["varied", "value"]
    sized = ("wingspan", "battery_mass") if data.attrs["objective"] else ()
    results = [name for name in sized if _VARIED_AS[name] not in varied]
    names = [*varied, "status", *results, "total_mass", "excess_time", "charge_margin"]
    table = Table()
    for name in names:
        unit = data[name].attrs.get("units", "1") if name in data else "1"
        head = _head(name) if unit == "1" else f"{_head(name)} [{unit_label(unit)}]"
        table.add_column(head, justify="left" if name in ("status", "varied") else "right")
    for _, row in rows.head(_ROWS).iterrows():
        table.add_row(*(_cell(row[name], ".6g" if name in varied else ".2f") for name in names))
    console.print(table)
    if len(rows) > _ROWS:
        console.print(f"... {len(rows) - _ROWS} more points: --out FILE or --json has them all")


def _head(name: str) -> str:
    """Name without the unit that it ends in."""
    return without_unit(name).replace("_", " ")


def _cell(value: Any, form: str) -> str:
    if isinstance(value, str):
        return value.replace("_", " ")
    if math.isnan(value):
        return "-"
    return "unlimited" if math.isinf(value) else f"{value:{form}}"
