"""What the terminal and JSON tell of a trade study: its points, and how they end."""

from __future__ import annotations

import math
from typing import Any

import xarray as xr

from sizing.results.notes import extrapolation_blocks, extrapolation_records
from sizing.results.tables import Column, Line, Summary, Table
from studies.output.columns import extrapolations_of
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
        "extrapolations": extrapolation_records(extrapolations_of(data)),
        "points": rows,
    }


def _counts(data: xr.Dataset) -> dict[str, int]:
    return {str(k): int(v) for k, v in to_table(data)["status"].value_counts().items()}


def points_summary(data: xr.Dataset) -> Summary:
    """How many points end in which way, and the points where they fit on a screen."""
    counts = ", ".join(f"{n} {name.replace('_', ' ')}" for name, n in _counts(data).items())
    count = data["status"].size
    noun = "point" if count == 1 else "points"
    subject = data.attrs["title"].removeprefix("Trade study of ")
    heading = Line(f"{subject}: trade study of {count} {noun}, {counts}", "strong")
    rows = to_table(data)
    varied = [str(name) for name in data.coords if name != "sample"]
    if "varied" in varied:
        # Of each point only one key differs from the file.
        rows["value"] = [row[row["varied"]] if row["varied"] else "" for _, row in rows.iterrows()]
        varied = ["varied", "value"]
    sized = ("wingspan", "battery_mass") if data.attrs["objective"] else ()
    results = [name for name in sized if _VARIED_AS[name] not in varied]
    names = [*varied, "status", *results, "total_mass", "excess_time", "charge_margin"]
    columns = tuple(_column(data, name, ".6g" if name in varied else ".2f") for name in names)
    cells = rows.head(_ROWS)[names].astype(object).itertuples(index=False, name=None)
    table = Table("", columns, tuple(tuple(map(_words, row)) for row in cells))
    blocks: list[Any] = [heading, table]
    if len(rows) > _ROWS:
        blocks.append(f"... {len(rows) - _ROWS} more points: --out FILE or --json has them all")
    return Summary((*blocks, *extrapolation_blocks(extrapolations_of(data))))


def _column(data: xr.Dataset, name: str, form: str) -> Column:
    """Column of a result or a varied key; its heading has the unit once."""
    unit = data[name].attrs.get("units", "1") if name in data else "1"
    label = without_unit(name).replace("_", " ")
    return Column(name, label, "" if unit == "1" else unit_label(unit), form)


def _words(value: Any) -> Any:
    return value.replace("_", " ") if isinstance(value, str) else value
