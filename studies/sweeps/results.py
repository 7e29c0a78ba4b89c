"""What the terminal and JSON tell of a trade study: how its points end, and which are best."""

from __future__ import annotations

import math
from collections.abc import Sequence
from string import ascii_uppercase
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from sizing.parameters import parameter
from sizing.program.objectives import Objective
from sizing.results.notes import extrapolation_blocks, extrapolation_records
from sizing.results.quantities import BATTERY_MASS, BELOW_ZERO, PAYLOAD_MASS, WINGSPAN
from sizing.results.records import finite_values
from sizing.results.tables import Column, Line, Summary, Table
from studies.output.gridded import (
    CLIMB,
    extrapolations_of,
    feasible,
    reasons_without_result,
    to_table,
)
from studies.sweeps.axes import unit_label, without_unit

_ROWS = 15
# Results that are the same as a varied key.
_VARIED_AS = {
    **{one.variable: one.name for one in (WINGSPAN, BATTERY_MASS)},
    PAYLOAD_MASS.variable: parameter(PAYLOAD_MASS.name).key,
}


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
        **({CLIMB: data.attrs[CLIMB]} if CLIMB in data.attrs else {}),
        "sample": data.attrs["sample"],
        "objective": data.attrs["objective"] or None,
        "status": _counts(data),
        "extrapolations": extrapolation_records(extrapolations_of(data)),
        "points": rows,
    }


def _counts(data: xr.Dataset) -> dict[str, int]:
    return {str(k): int(v) for k, v in to_table(data)["status"].value_counts().items()}


def front_record(data: xr.Dataset, x: str, y: str) -> dict[str, Any]:
    """Key ``pareto_front`` of the record: the front's points with their names."""
    front = pareto_table(data, x, y)
    rows = front[front["pareto_front"]][
        list(dict.fromkeys(["point", *_varied(data), x, y]))
    ].to_dict("records")
    named = [{str(key): value for key, value in row.items()} for row in rows]
    return {"pareto_front": {"x": x, "y": y, "points": list(map(finite_values, named))}}


def points_summary(
    data: xr.Dataset,
    *,
    sort: str | None = None,
    top: int = _ROWS,
    front: tuple[str, str] | None = None,
) -> Summary:
    """How many points end in which way, and the best of them, or those of a Pareto front.

    ``sort``: column to sort by, see :func:`sorted_by`; the best first
    without it.
    """
    counts = ", ".join(f"{n} {name.replace('_', ' ')}" for name, n in _counts(data).items())
    count = data["status"].size
    noun = "point" if count == 1 else "points"
    subject = data.attrs["title"].removeprefix("Trade study of ")
    heading = Line(f"{subject}: trade study of {count} {noun}, {counts}", "strong")
    if front is None:
        rows, order = best_first(data) if sort is None else sorted_by(data, sort)
        what = f"sorted: {order}{'' if sort is None else ' first'}"
        table = _table(data, rows, top, ())
    else:
        every = pareto_table(data, *front)
        rows = every[every["pareto_front"]]
        better = [f"{'more' if n in MORE_IS_BETTER else 'less'} {_plain(n)}" for n in front]
        what = (
            f"Pareto front of {' and '.join(better)}: {len(rows)} of {len(every)} feasible points; "
            "no other is better in both"
        )
        table = _table(data, rows, top, front)
    blocks: list[Any] = [heading]
    if count > 1:
        blocks.append(what)
    blocks.append(table)
    if (rows["excess_time"].head(top) < 0.0).any():
        blocks.append(Line(BELOW_ZERO, "faint"))
    if len(rows) > top:
        blocks.append(f"{len(rows) - top} more not shown: --top N shows more, --out FILE has all")
    if CLIMB in data.attrs:
        blocks.append(Line(data.attrs[CLIMB], "faint"))
    return Summary((*blocks, *extrapolation_blocks(extrapolations_of(data))))


def _varied(data: xr.Dataset) -> list[str]:
    return [str(name) for name in data.coords if name not in ("sample", "varied")]


def _table(data: xr.Dataset, rows: pd.DataFrame, top: int, front: Sequence[str]) -> Table:
    """Rows with what was varied, how they end, and the results that matter."""
    reasons = pd.Series(reasons_without_result(data).ravel(), to_table(data).index)
    rows, varied = rows.head(top).copy(), _varied(data)
    rows["why"] = reasons.reindex(rows.index)
    if "varied" in data.coords:
        # Of each point only one key differs from the file.
        rows["value"] = [row[row["varied"]] if row["varied"] else "" for _, row in rows.iterrows()]
        varied = ["varied", "value"]
    sized = ("wingspan", "battery_mass") if data.attrs["objective"] else ()
    results = [name for name in sized if _VARIED_AS[name] not in varied]
    results += ["total_mass", "excess_time"]
    objective = Objective(data.attrs["objective"]).column if sized else ""
    results += [objective] if objective not in (*results, "", "wingspan") else []
    # Where flight is perpetual the endurance is unlimited, which the status says.
    endurance = rows["endurance"].to_numpy(float) if "endurance" in rows else np.array([])
    results += ["endurance"] if np.isfinite(endurance).any() else []
    results += ["charge_margin"]
    point = ["point"] if front else []
    named = [*point, *varied, "status", *results]
    shown = {*named, *(name for name, key in _VARIED_AS.items() if key in varied)}
    names = [*named, *(name for name in front if name not in shown)]
    names += ["why"] if rows["why"].any() else []
    columns = tuple(_column(data, name, ".6g" if name in varied else ".2f") for name in names)
    cells = rows[names].astype(object).itertuples(index=False, name=None)
    return Table("", columns, tuple(tuple(map(_spaced, row)) for row in cells))


def _plain(name: str) -> str:
    return without_unit(name).replace("_", " ")


def _column(data: xr.Dataset, name: str, form: str) -> Column:
    """Column of a result or a varied key; its heading has the unit once."""
    unit = data[name].attrs.get("units", "1") if name in data else "1"
    return Column(name, _plain(name), "" if unit == "1" else unit_label(unit), form)


def _spaced(value: Any) -> Any:
    return value.replace("_", " ") if isinstance(value, str) else value


# ---- Which points are best


# Of everything else less is better.
MORE_IS_BETTER = {
    "excess_time",
    "charge_margin",
    "endurance",
    "minimum_state_of_charge",
    "payload_mass",
    "payload_power",
    "payload_mass_kg",  # the varied key
}


def best_first(data: xr.Dataset) -> tuple[pd.DataFrame, str]:
    """Points of a study with the best on top, and in words what is best.

    Points that fly perpetually, or were sized, come first; of these the objective decides, or the
    excess time where nothing was sized. Equal points remain in the order of the study.
    """
    objective = data.attrs["objective"]
    column = Objective(objective).column if objective else "excess_time"
    table = to_table(data).assign(_better=feasible(data).ravel())
    upwards = column not in MORE_IS_BETTER
    table = table.sort_values(["_better", column], ascending=[False, upwards], kind="stable")
    words = {True: "least", False: "largest"}[upwards]
    what = "points with a design" if objective else "perpetual flight"
    if (table["status"] == "lands").any():
        what = "flights that land"
    text = f"{what} first, then the {words} {column.replace('_', ' ')}"
    return table.drop(columns="_better"), text


def sorted_by(data: xr.Dataset, key: str) -> tuple[pd.DataFrame, str]:
    """Points of a study in the order of one column, and that order in words.

    ``key``: column of its table, the least first; the largest first with a minus in front.
    """
    table = to_table(data)
    column = key.removeprefix("-")
    allowed = [str(name) for name in table.columns]
    if column not in allowed:
        raise ValueError(f"{column!r} is not one of {', '.join(allowed)}")
    downwards = key != column
    end = "largest" if downwards else "least"
    return table.sort_values(column, ascending=not downwards, kind="stable"), f"{end} {column}"


def point_names(count: int) -> list[str]:
    """Names of points: A to Z, then AA, AB and so on."""
    names = list(ascii_uppercase)
    while len(names) < count:
        names += [first + last for first in names[-26:] for last in ascii_uppercase]
    return names[:count]


def pareto_front(x: NDArray[Any], y: NDArray[Any]) -> NDArray[np.bool_]:
    """Mark the points that no other point beats in one and equals or beats in the other.

    Less is better in both; NaN is never on the front.

    Returns whether a point is on the front; of equal points all are.
    """
    front: NDArray[np.bool_] = np.isfinite(x) & np.isfinite(y)
    order = np.lexsort((y, x))
    best_x, best_y = np.inf, np.inf
    for i in order[front[order]]:
        # In this order a point is beaten by one before it, or by none.
        front[i] = y[i] < best_y or (x[i] == best_x and y[i] == best_y)
        if y[i] < best_y:
            best_x, best_y = x[i], y[i]
    return front


def pareto_table(data: xr.Dataset, x: str, y: str) -> pd.DataFrame:
    """Feasible points, and which of them are on the front over two variables or varied keys.

    ``x``, ``y``: numeric columns of its table; more is better of excess times, margins and
    payloads, less of everything else. Returns one row for each feasible point, those of the front
    first, in the order of ``x``; with the columns ``pareto_front`` and ``point``, the names of the
    front's points: A, B, C, ...
    """
    table = to_table(data)[feasible(data).ravel()].copy()
    allowed = [str(n) for n in table.columns if pd.api.types.is_numeric_dtype(table[n])]
    signs = []
    for name in (x, y):
        if name not in allowed:
            raise ValueError(f"{name!r} is not one of {', '.join(allowed)}")
        signs.append(-1.0 if name in MORE_IS_BETTER else 1.0)
    table["pareto_front"] = pareto_front(
        signs[0] * table[x].to_numpy(float), signs[1] * table[y].to_numpy(float)
    )
    table = table.sort_values(["pareto_front", x, y], ascending=[False, True, True], kind="stable")
    names = point_names(int(table["pareto_front"].sum()))
    table["point"] = [*names, *[""] * (len(table) - len(names))]
    return table
