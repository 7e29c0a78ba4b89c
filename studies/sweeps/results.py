"""Results of a trade study on the terminal and as JSON: points by status, and the best."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from string import ascii_uppercase
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from sizing.parameters import parameter
from sizing.program.objectives import Objective
from sizing.results.result import Result
from studies.output import gridded
from studies.quantities import BATTERY_MASS, BELOW_ZERO, PAYLOAD_MASS, WINGSPAN
from studies.render.tables import Column, Line, Table
from studies.render.words import extrapolation_blocks
from studies.serialise import serialise
from studies.sweeps.axes import unit_label, without_unit

_ROWS = 15  # of the table of a summary
# Results that repeat a varied key.
_VARIED_AS = {
    **{quantity.variable: quantity.name for quantity in (WINGSPAN, BATTERY_MASS)},
    PAYLOAD_MASS.variable: parameter(PAYLOAD_MASS.name).key,
}


@dataclass(frozen=True, repr=False)
class SweepResult(Result):
    """Trade study: number of points by status, and the best points or a Pareto front.

    ``sort``: column to sort by, see :func:`sorted_by`; by default the best first. ``top``: rows of
    the table; by default as many as fit a screen. ``front``: two results or varied keys of a
    Pareto front.
    """

    data: xr.Dataset
    sort: str | None = None
    top: int | None = None
    front: tuple[str, str] | None = None

    @property
    def counts(self) -> dict[str, int]:
        """Number of points by status."""
        counts = gridded.to_table(self.data)["status"].value_counts()
        return {str(name): int(count) for name, count in counts.items()}

    def to_dict(self) -> dict[str, Any]:
        """Return all points and the front, JSON-ready; undefined and infinite numbers are null."""
        about = self.data.attrs
        record: dict[str, Any] = {
            "title": about["title"],
            **({gridded.CLIMB: about[gridded.CLIMB]} if gridded.CLIMB in about else {}),
            "sample": about["sample"],
            "objective": about["objective"] or None,
            "status": self.counts,
            "extrapolations": gridded.extrapolations_of(self.data),
            "points": gridded.to_table(self.data).to_dict("records"),
        }
        if self.front is not None:
            x, y = self.front
            points = pareto_table(self.data, x, y)
            columns = list(dict.fromkeys(["point", *self._varied, x, y]))
            rows = points[points["pareto_front"]][columns].to_dict("records")
            record["pareto_front"] = {"x": x, "y": y, "points": rows}
        written: dict[str, Any] = serialise(record)
        return written

    def _ordered(self) -> tuple[pd.DataFrame, str]:
        """Return the points in their order, and the order in words."""
        if self.front is None:
            if self.sort is None:
                rows, order = best_first(self.data)
                return rows, f"sorted: {order}"
            rows, order = sorted_by(self.data, self.sort)
            return rows, f"sorted: {order} first"
        every = pareto_table(self.data, *self.front)
        rows = every[every["pareto_front"]]
        better = (f"{'more' if n in MORE_IS_BETTER else 'less'} {_plain(n)}" for n in self.front)
        return rows, (
            f"Pareto front of {' and '.join(better)}: {len(rows)} of {len(every)} feasible points; "
            "no other is better in both"
        )

    @property
    def _varied(self) -> list[str]:
        return [str(name) for name in self.data.coords if name not in ("sample", "varied")]

    def _table(self, rows: pd.DataFrame) -> Table:
        """Return a table of rows: varied values, status, and the main results."""
        data, rows, varied = self.data, rows.copy(), self._varied
        # Rows are numbered as the points are.
        rows["why"] = gridded.reasons_without_result(data).ravel()[rows.index]
        if "varied" in data.coords:
            # Each point differs from the file in one key.
            rows["value"] = [row.get(row["varied"], "") for _, row in rows.iterrows()]
            varied = ["varied", "value"]
        sized = ("wingspan", "battery_mass") if data.attrs["objective"] else ()
        results = [name for name in sized if _VARIED_AS[name] not in varied]
        results += ["total_mass", "excess_time"]
        objective = Objective(data.attrs["objective"]).column if sized else ""
        results += [objective] if objective not in (*results, "", "wingspan") else []
        # Endurance is unlimited for perpetual flight, which the status says.
        endurance = rows["endurance"].to_numpy(float) if "endurance" in rows else np.array([])
        results += ["endurance"] if np.isfinite(endurance).any() else []
        named = [*(["point"] if self.front else []), *varied, "status", *results, "charge_margin"]
        shown = {*named, *(name for name, key in _VARIED_AS.items() if key in varied)}
        names = [*named, *(name for name in self.front or () if name not in shown)]
        names += ["why"] if rows["why"].any() else []
        columns = tuple(_column(data, name, ".6g" if name in varied else ".2f") for name in names)
        cells = rows[names].astype(object).itertuples(index=False, name=None)
        spaced = (
            tuple(cell.replace("_", " ") if isinstance(cell, str) else cell for cell in row)
            for row in cells
        )
        return Table("", columns, tuple(spaced))


def headline(result: SweepResult) -> str:
    """Return the title and the number of points by status."""
    ends = ", ".join(f"{n} {name.replace('_', ' ')}" for name, n in result.counts.items())
    count = result.data["status"].size
    noun = "point" if count == 1 else "points"
    subject = result.data.attrs["title"].removeprefix("Trade study of ")
    return f"{subject}: trade study of {count} {noun}, {ends}"


def blocks(result: SweepResult, level: int) -> list[Any]:
    """Return headline, the best points, and values outside a model's range."""
    rows, what = result._ordered()
    top = (_ROWS if level == 1 else len(rows)) if result.top is None else result.top
    shown: list[Any] = [Line(headline(result), "strong")]
    if result.data["status"].size > 1:
        shown.append(what)
    shown.append(result._table(rows.head(top)))
    if (rows["excess_time"].head(top) < 0.0).any():
        shown.append(Line(BELOW_ZERO, "faint"))
    if len(rows) > top:
        more = f"{len(rows) - top} more not shown"
        shown.append(f"{more}: --top N shows more; all with -v and in --out FILE")
    if gridded.CLIMB in result.data.attrs:
        shown.append(Line(result.data.attrs[gridded.CLIMB], "faint"))
    return [*shown, *extrapolation_blocks(gridded.extrapolations_of(result.data), level)]


def _plain(name: str) -> str:
    return without_unit(name).replace("_", " ")


def _column(data: xr.Dataset, name: str, form: str) -> Column:
    """Return the column of a result or a varied key."""
    unit = data[name].attrs.get("units", "1") if name in data else "1"
    return Column(name, _plain(name), "" if unit == "1" else unit_label(unit), form)


# ---- Which points are best


# Columns of which more is better; of all others less is.
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
    """Return the points of a study, best first, and the order in words.

    Points that fly perpetually, or were sized, come first, ordered by the objective, or by excess
    time where nothing was sized. Equal points remain in the order of the study.
    """
    objective = data.attrs["objective"]
    column = Objective(objective).column if objective else "excess_time"
    table = gridded.to_table(data).assign(_better=gridded.feasible(data).ravel())
    upwards = column not in MORE_IS_BETTER
    table = table.sort_values(["_better", column], ascending=[False, upwards], kind="stable")
    words = {True: "least", False: "largest"}[upwards]
    what = "points with a design" if objective else "perpetual flight"
    if (table["status"] == "lands").any():
        what = "flights that land"
    text = f"{what} first, then the {words} {column.replace('_', ' ')}"
    return table.drop(columns="_better"), text


def sorted_by(data: xr.Dataset, key: str) -> tuple[pd.DataFrame, str]:
    """Return the points of a study by a column, and the order in words.

    ``key``: column, least first; with a minus in front largest first.
    """
    table = gridded.to_table(data)
    column = key.removeprefix("-")
    allowed = [str(name) for name in table.columns]
    if column not in allowed:
        raise ValueError(f"{column!r} is not one of {', '.join(allowed)}")
    downwards = key != column
    end = "largest" if downwards else "least"
    return table.sort_values(column, ascending=not downwards, kind="stable"), f"{end} {column}"


def point_names() -> Iterator[str]:
    """Yield names of points: A to Z, then AA, AB and so on."""
    for count in itertools.count(1):
        yield from map("".join, itertools.product(ascii_uppercase, repeat=count))


def pareto_front(x: NDArray[Any], y: NDArray[Any]) -> NDArray[np.bool_]:
    """Flag the points of the Pareto front: no other point is less in one and at most in the other.

    NaN is never on the front; equal points all are.
    """
    front: NDArray[np.bool_] = np.isfinite(x) & np.isfinite(y)
    order = np.lexsort((y, x))
    best_x, best_y = np.inf, np.inf
    for i in order[front[order]]:
        # In this order only earlier points can be better.
        front[i] = y[i] < best_y or (x[i] == best_x and y[i] == best_y)
        if y[i] < best_y:
            best_x, best_y = x[i], y[i]
    return front


def pareto_table(data: xr.Dataset, x: str, y: str) -> pd.DataFrame:
    """Return the feasible points with the columns ``pareto_front`` and ``point`` (A, B, C, ...).

    ``x``, ``y``: numeric columns; more of excess times, margins and payloads is better, less of
    everything else. Points of the front come first, in the order of ``x``.
    """
    table = gridded.to_table(data)[gridded.feasible(data).ravel()].copy()
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
    names = point_names()
    table["point"] = [next(names) if on_front else "" for on_front in table["pareto_front"]]
    return table
