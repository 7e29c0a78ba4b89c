"""What the terminal and JSON tell of a map: by latitude, the days with a flight or a design."""

from __future__ import annotations

import math
from typing import Any

import xarray as xr
from rich.console import Console
from rich.table import Table

from missions.mission import latitude_label
from sizing.results.records import finite
from studies.maps.feasibility import season_length
from studies.output.columns import SIZED, SizingStatus
from studies.output.tables import print_seasons

_RANGES = {"wingspan_m": "wingspan", "total_mass_kg": "total_mass", "excess_time_h": "excess_time"}


def seasons_record(data: xr.Dataset) -> dict[str, Any]:
    """Days of perpetual flight at each latitude, JSON-ready."""
    return {
        "latitude_deg": data["latitude"].to_numpy().tolist(),
        "days": data["day"].to_numpy().tolist(),
        "perpetual_days": season_length(data).to_numpy().tolist(),
    }


def show_seasons(console: Console, data: xr.Dataset) -> None:
    """Print the days of perpetual flight at each latitude."""
    print_seasons(console, data, season_length(data))


def designs_record(data: xr.Dataset) -> dict[str, Any]:
    """Of every latitude: on how many days there is a design, and the range of its size."""
    record: dict[str, Any] = {
        "latitude_deg": data["latitude"].to_numpy().tolist(),
        "days": data["day"].to_numpy().tolist(),
        "objective": data.attrs["objective"],
    }
    for status in SizingStatus:
        record[f"{status.name}_days"] = (data["status"] == status).sum("day").to_numpy().tolist()
    for name in _RANGES:
        least, largest = _range(data, name)
        record[f"least_{name}"] = [finite(value) for value in least]
        record[f"largest_{name}"] = [finite(value) for value in largest]
    return record


def show_designs(console: Console, data: xr.Dataset) -> None:
    """Print on how many days there is a design at each latitude, and the range of its size."""
    record = designs_record(data)
    none = (SizingStatus.infeasible, SizingStatus.invalid)
    groups = (SIZED, none, [kind for kind in SizingStatus if kind not in (*SIZED, *none)])
    title = f"{data.attrs['title']} for {record['objective']}"
    table = Table(title=title, title_justify="left")
    shown = {"wingspan_m": "wingspan [m]", "total_mass_kg": "mass [kg]"}
    if record["objective"] == "max_excess_time":
        shown["excess_time_h"] = "excess time [h]"
    heads = ("latitude", f"designs on {data.sizes['day']} days", "none", "unknown")
    for name in (*heads, *shown.values()):
        table.add_column(name, justify="right")
    ranges = [list(zip(*_range(data, name), strict=True)) for name in shown]
    for i, latitude in enumerate(record["latitude_deg"]):
        table.add_row(
            latitude_label(latitude),
            *(str(sum(record[f"{kind.name}_days"][i] for kind in kinds)) for kinds in groups),
            *(_range_text(*values[i]) for values in ranges),
        )
    console.print(table)


def _range(data: xr.Dataset, name: str) -> tuple[list[float], list[float]]:
    """Least and largest value over the days, at each latitude."""
    values = data[_RANGES[name]]
    return values.min("day").to_numpy().tolist(), values.max("day").to_numpy().tolist()


def _range_text(least: float, largest: float) -> str:
    if math.isnan(least):
        return "-"
    if math.isinf(least):
        return "unlimited"
    return f"{least:.2f} to {'unlimited' if math.isinf(largest) else f'{largest:.2f}'}"
