"""Which points of a trade study are best: the order of its table, and its Pareto front."""

from __future__ import annotations

from string import ascii_uppercase
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from sizing.optimisation.objectives import Objective
from studies.output.gridded import to_table
from studies.sweeps.study import feasible

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
    table = to_table(data).assign(_better=np.asarray(feasible(data)).ravel())
    upwards = column not in MORE_IS_BETTER
    table = table.sort_values(["_better", column], ascending=[False, upwards], kind="stable")
    words = {True: "least", False: "largest"}[upwards]
    what = "points with a design" if objective else "perpetual flight"
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
    table = to_table(data)[np.asarray(feasible(data)).ravel()].copy()
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
