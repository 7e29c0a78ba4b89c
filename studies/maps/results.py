"""What the terminal and JSON tell of a map: by latitude, the days with a flight or a design."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from missions.dates import date_label
from missions.mission.scenarios import latitude_label
from missions.weather.record import runs_of
from sizing.day.metrics import Status
from sizing.program.objectives import Objective, SizingStatus
from sizing.results.notes import extrapolation_lines, extrapolation_records
from sizing.results.quantities import (
    BELOW_ZERO,
    EXCESS_TIME,
    PAYLOAD_MASS,
    PAYLOAD_POWER,
    TOTAL_MASS,
    WINGSPAN,
    Quantity,
)
from sizing.results.records import finite
from sizing.results.tables import Column, Table
from solar.types import BoolArray, IntArray
from studies.output.gridded import (
    SIZED,
    TOO_WINDY,
    OnGrid,
    extrapolations_of,
    feasible,
    flown_caption,
    status_names,
)

_ROWS = 16  # latitudes of a table
_DAYS = 365
_RUNS = 2  # seasons of a latitude


def seasons_record(data: OnGrid) -> dict[str, Any]:
    """On how many of the days each latitude is flown perpetually, and how many are unknown."""
    # Of models that need a path in winds, with which it may be too strong for the path.
    windy = Status.infeasible in status_names(data)
    return _places(data) | {
        "perpetual_days": feasible(data).sum(axis=1).tolist(),
        "failed_days": _days_of(data, Status.failed),
        **({"too_windy_days": _days_of(data, Status.infeasible)} if windy else {}),
        **_endurances(data),
        "extrapolations": extrapolation_records(extrapolations_of(data)),
    }


def _endurances(data: OnGrid) -> dict[str, Any]:
    """Shortest and longest flight of the days without perpetual flight, if they were asked for."""
    if "endurance" not in data:
        return {}
    hours = data["endurance"].to_numpy()
    limited = np.where(np.isposinf(hours), np.nan, hours)
    ends = zip(("least", "largest"), _range_of_days(limited), strict=True)
    return {f"{end}_endurance_h": list(map(finite, values)) for end, values in ends}


def seasons_table(data: OnGrid) -> Table:
    """Days of perpetual flight at each latitude, and the largest excess time."""
    record = seasons_record(data)
    _, most = _range_of_days(data["excess_time"].to_numpy())
    days = data["day"].to_numpy()
    columns: tuple[Column, ...] = (
        Column("season", _flown(data)),
        Column("largest_excess_time_h", "largest excess time", "h", ".2f"),
    )
    seasons = (season_text(days, perpetual) for perpetual in feasible(data))
    rows: list[tuple[Any, ...]] = list(zip(seasons, most, strict=True))
    if len(days) == _DAYS:  # else a number of mapped days says little
        columns = (columns[0], Column("perpetual_days", "days"), columns[1])
        counts = record["perpetual_days"]
        rows = [(season, count, h) for (season, h), count in zip(rows, counts, strict=True)]
    if "endurance" in data:
        columns += (Column("endurance_h", "endurance on the other days", "h", to_right=True),)
        ends = zip(record["least_endurance_h"], record["largest_endurance_h"], strict=True)
        rows = [
            (*row, _range(*(math.nan if end is None else end for end in both)))
            for row, both in zip(rows, ends, strict=True)
        ]
    title = f"{_subject(data)}: seasons of {_flown(data)}"
    table = _table(data, title, record, columns, rows)
    negative = any(value < 0.0 for value in most)
    return replace(table, notes=(*table.notes, BELOW_ZERO)) if negative else table


def _flown(data: OnGrid) -> str:
    """What is wanted of a cell, in words."""
    landed = np.any(data["status"].to_numpy() == Status.lands)
    return "flights that land" if landed else "perpetual flight"


def season_text(days: IntArray, perpetual: BoolArray) -> str:
    """First and last of the mapped days with perpetual flight; the year is a circle if mapped."""
    if perpetual.all() or not perpetual.any():
        return "on all mapped days" if perpetual.all() else "none"
    starts, stops = runs_of(perpetual)
    ends = [[int(days[a]), int(days[b - 1])] for a, b in zip(starts, stops, strict=True)]
    gaps = np.diff(days, append=days[0] + 365)
    if len(ends) > 1 and perpetual[0] and perpetual[-1] and gaps[-1] <= gaps[:-1].max():
        ends[0][0] = ends.pop()[0]
    spans = [
        date_label(first) if first == last else f"{date_label(first)} to {date_label(last)}"
        for first, last in ends
    ]
    return ", ".join(spans[:_RUNS]) + (", ..." if len(spans) > _RUNS else "")


def designs_record(data: OnGrid) -> dict[str, Any]:
    """Of every latitude: on how many days a sizing ends in which way, and the range of its size."""
    record = _places(data) | {"objective": data.attrs["objective"]}
    for status in SizingStatus:
        record[f"{status.name}_days"] = _days_of(data, status)
    windy = data["violated_requirement"].to_numpy() == TOO_WINDY
    if windy.any():
        record["too_windy_days"] = windy.sum(axis=1).tolist()
    for one in (WINGSPAN, TOTAL_MASS, EXCESS_TIME, *_payload(data)):
        ends = _range_of_days(data[one.variable].to_numpy())
        for word, values in zip(("least", "largest"), ends, strict=True):
            record[f"{word}_{one.name}"] = [finite(value) for value in values]
    record["extrapolations"] = extrapolation_records(extrapolations_of(data))
    return record


def designs_table(data: OnGrid) -> Table:
    """Days with a design at each latitude, and the range of its size."""
    record = designs_record(data)
    groups = {
        f"designs on {len(record['days'])} days": SIZED,
        "none": (SizingStatus.infeasible, SizingStatus.invalid),
        "unknown": (SizingStatus.not_converged,),
    }
    shown = [WINGSPAN, replace(TOTAL_MASS, label="mass")]
    if record["objective"] == "max_excess_time":
        shown.append(EXCESS_TIME)
    shown += _payload(data)
    columns = (
        *(Column(head) for head in groups),
        *(Column(one.variable, one.label, one.unit) for one in shown),
    )
    ends = [_range_of_days(data[one.variable].to_numpy()) for one in shown]
    rows = [
        (
            *(sum(record[f"{kind.name}_days"][i] for kind in kinds) for kinds in groups.values()),
            *(_range(least[i], largest[i]) for least, largest in ends),
        )
        for i in range(len(record["latitude_deg"]))
    ]
    return _table(
        data, f"{_subject(data)}: best designs for {record['objective']}", record, columns, rows
    )


def _payload(data: OnGrid) -> tuple[Quantity, ...]:
    """Payload of the designs, where it is as large as possible."""
    column = Objective(data.attrs["objective"]).column
    return tuple(one for one in (PAYLOAD_MASS, PAYLOAD_POWER) if one.variable == column)


def _days_of(data: OnGrid, status: int) -> list[int]:
    """On how many days each latitude ends in a way."""
    days: list[int] = (data["status"].to_numpy() == status).sum(axis=1).tolist()
    return days


def _range_of_days(values: NDArray[Any]) -> tuple[list[float], list[float]]:
    """Least and largest value of each latitude; NaN where there is none on any day."""
    # No warning for a latitude without a value, as nanmin has one.
    least = np.fmin.reduce(values, axis=1)
    return least.tolist(), np.fmax.reduce(values, axis=1).tolist()


def _subject(data: OnGrid) -> str:
    """Aircraft and mission by name."""
    names = (json.loads(data.attrs[one])["name"] for one in ("aircraft", "mission"))
    return " on ".join(names)


def _places(data: OnGrid) -> dict[str, Any]:
    return {
        "latitude_deg": data["latitude"].to_numpy().tolist(),
        "days": data["day"].to_numpy().tolist(),
    }


def _table(
    data: OnGrid,
    title: str,
    record: dict[str, Any],
    columns: Sequence[Column],
    rows: Sequence[tuple[Any, ...]],
) -> Table:
    """Table of one row for each latitude; days without a result have columns if there are any."""
    without = {"failed_days": "failed", "too_windy_days": "too windy for the path"}
    lacking = {head: record[key] for key, head in without.items() if any(record.get(key, ()))}
    latitude_deg = record["latitude_deg"]
    shown = _shown_latitudes(latitude_deg)
    every = [
        (latitude_label(latitude_deg[i]), *rows[i], *(days[i] for days in lacking.values()))
        for i in shown
    ]
    heads = (Column("latitude"), *columns, *map(Column, lacking))
    days = data["day"].to_numpy()
    flown = f"{flown_caption(data)}; days {days[0]} to {days[-1]}, {len(days)} of them"
    notes = (flown, *extrapolation_lines(extrapolations_of(data)))
    if len(shown) < len(rows):
        part = f"{len(shown)} of {len(rows)} latitudes; --json and --out FILE have all"
        notes = (part, *notes)
    return Table(title, heads, tuple(every), notes)


def _shown_latitudes(latitude_deg: Sequence[float]) -> list[int]:
    """Places of the latitudes that a table shows: of many, those at a round number of degrees."""
    every = list(range(len(latitude_deg)))
    if len(every) <= _ROWS:
        return every
    for step in (1.0, 2.0, 5.0, 10.0, 15.0, 30.0):
        round_ones = [i for i in every if latitude_deg[i] % step == 0.0]
        if 0 < len(round_ones) <= _ROWS:
            return round_ones
    return every[:: math.ceil(len(every) / _ROWS)]


def _range(least: float, largest: float) -> str:
    ends = Column("", form=".2f")
    if math.isnan(least) or math.isinf(least):
        return ends.text(least)
    return f"{ends.text(least)} to {ends.text(largest)}"
