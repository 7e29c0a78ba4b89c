"""Cells of a chart that have no value, hatched by the reason."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.patches import Patch
from numpy.typing import NDArray

__all__ = ["cell_edges", "hatch_cells"]


def cell_edges(centres: NDArray[np.float64]) -> NDArray[np.float64]:
    """Edges half-way between the centres of cells."""
    centres = np.asarray(centres, float)
    if len(centres) == 1:
        half = 0.05 * abs(centres[0]) or 0.5
        return np.array([centres[0] - half, centres[0] + half])
    middle = (centres[:-1] + centres[1:]) / 2.0
    first, last = 2.0 * centres[0] - middle[0], 2.0 * centres[-1] - middle[-1]
    return np.concatenate(([first], middle, [last]))


def hatch_cells(
    axes: Axes,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    status: NDArray[Any],
    hatches: Mapping[Any, str],
    names: Mapping[Any, str],
) -> list[Patch]:
    """Hatch cells by their status, shape ``(y, x)``, and return the entries of a legend.

    Cells whose hatch is empty are filled with grey.
    """
    across, up = cell_edges(x), cell_edges(y)
    entries = []
    for value, hatch in hatches.items():
        rows, columns = np.nonzero(status == value)
        if not len(rows):
            continue
        corners = [
            [
                (across[j], up[i]),
                (across[j + 1], up[i]),
                (across[j + 1], up[i + 1]),
                (across[j], up[i + 1]),
            ]
            for i, j in zip(rows, columns, strict=True)
        ]
        style: dict[str, Any] = {
            "facecolor": "none" if hatch else "lightgrey",
            "edgecolor": "grey",
            "hatch": hatch or None,
        }
        axes.add_collection(PolyCollection(corners, linewidth=0.0, **style))
        entries.append(Patch(label=names[value].replace("_", " "), linewidth=0.5, **style))
    return entries
