"""What the terminal and JSON tell of a map: by latitude, the days with a flight or a design."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table

from missions.mission import latitude_label
from sizing.results.records import finite
from studies.maps.feasibility import MapStatus, season_length
from studies.output.columns import SIZED, SizingStatus

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["designs_record", "seasons_record", "show_designs", "show_seasons"]


def seasons_record(data: xr.Dataset) -> dict[str, Any]:
    """On how many of the days each latitude is flown perpetually, and how many are unknown."""
    failed = (data["status"] == MapStatus.failed).sum("day")
    return _places(data) | {
        "perpetual_days": season_length(data).to_numpy().tolist(),
        "failed_days": failed.to_numpy().tolist(),
    }


def show_seasons(console: Console, data: xr.Dataset) -> None:
    """Print the days of perpetual flight at each latitude, and the largest excess time."""
    record = seasons_record(data)
    most = data["excess_time"].max("day").to_numpy().tolist()
    rows = [
        [str(days), _number(most_h, ".2f", " h")]
        for days, most_h in zip(record["perpetual_days"], most, strict=True)
    ]
    heads = [f"days of {data.sizes['day']} mapped", "largest excess time"]
    console.print(_table(f"{data.attrs['title']}: perpetual flight", record, heads, rows))


def designs_record(data: xr.Dataset) -> dict[str, Any]:
    """Of every latitude: on how many days a sizing ends in which way, and the range of its size."""
    record = _places(data) | {"objective": data.attrs["objective"]}
    for status in SizingStatus:
        record[f"{status.name}_days"] = (data["status"] == status).sum("day").to_numpy().tolist()
    for name, unit in (("wingspan", "m"), ("total_mass", "kg"), ("excess_time", "h")):
        for word, end in (("least", "min"), ("largest", "max")):
            values = getattr(data[name], end)("day").to_numpy().tolist()
            record[f"{word}_{name}_{unit}"] = [finite(value) for value in values]
    return record


def show_designs(console: Console, data: xr.Dataset) -> None:
    """Print the days with a design at each latitude, and the range of its size."""
    record = designs_record(data)
    groups = (
        SIZED,
        (SizingStatus.infeasible, SizingStatus.invalid),
        (SizingStatus.not_converged,),
    )
    shown = {"wingspan": "wingspan [m]", "total_mass": "mass [kg]"}
    if record["objective"] == "max_excess_time":
        shown["excess_time"] = "excess time [h]"
    ends = {
        name: [getattr(data[name], end)("day").to_numpy().tolist() for end in ("min", "max")]
        for name in shown
    }
    rows = [
        [
            *(str(sum(record[f"{kind.name}_days"][i] for kind in kinds)) for kinds in groups),
            *(_range(least[i], largest[i]) for least, largest in ends.values()),
        ]
        for i in range(data.sizes["latitude"])
    ]
    heads = [f"designs on {data.sizes['day']} days", "none", "unknown", *shown.values()]
    console.print(_table(f"{data.attrs['title']} for {record['objective']}", record, heads, rows))


def _places(data: xr.Dataset) -> dict[str, Any]:
    return {
        "latitude_deg": data["latitude"].to_numpy().tolist(),
        "days": data["day"].to_numpy().tolist(),
    }


def _table(title: str, record: dict[str, Any], heads: list[str], rows: list[list[str]]) -> Table:
    """Table of one row for each latitude; failed days have a column where there are any."""
    table = Table(title=title, title_justify="left")
    failed = record["failed_days"] if any(record["failed_days"]) else None
    for head in ("latitude", *heads, *(["failed"] if failed else [])):
        table.add_column(head, justify="right")
    for i, latitude in enumerate(record["latitude_deg"]):
        table.add_row(latitude_label(latitude), *rows[i], *([str(failed[i])] if failed else []))
    return table


def _range(least: float, largest: float) -> str:
    if math.isnan(least) or math.isinf(least):
        return _number(least, ".2f")
    return f"{least:.2f} to {_number(largest, '.2f')}"


def _number(value: float, form: str, unit: str = "") -> str:
    if math.isnan(value):
        return "-"
    return "unlimited" if math.isinf(value) else f"{value:{form}}{unit}"
