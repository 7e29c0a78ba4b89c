"""Cells of a chart: coloured by their value, or hatched by the reason why they have none."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection, QuadMesh
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

__all__ = ["cell_edges", "draw_cells", "draw_colour_bar", "finite_range", "hatch_cells"]

_ENDLESS = "#D55E00"  # a colour that the scale does not have


def cell_edges(centres: NDArray[np.float64]) -> NDArray[np.float64]:
    """Edges half-way between the centres of cells."""
    centres = np.asarray(centres, float)
    if len(centres) == 1:
        half = 0.05 * abs(centres[0]) or 0.5
        return np.array([centres[0] - half, centres[0] + half])
    middle = (centres[:-1] + centres[1:]) / 2.0
    first, last = 2.0 * centres[0] - middle[0], 2.0 * centres[-1] - middle[-1]
    return np.concatenate(([first], middle, [last]))


def finite_range(values: NDArray[np.float64]) -> Normalize:
    """Range of colours from the least to the largest finite value."""
    finite = values[np.isfinite(values)]
    if not len(finite):
        return Normalize(0.0, 1.0)
    low, high = float(finite.min()), float(finite.max())
    return Normalize(low, high if high > low else low + 1.0)


def draw_cells(
    axes: Axes,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    values: NDArray[np.float64],
    norm: Normalize,
) -> QuadMesh:
    """Colour cells by their value, shape ``(y, x)``; NaN stays blank, infinity is above the top."""
    assert norm.vmin is not None
    assert norm.vmax is not None
    above = norm.vmax + (norm.vmax - norm.vmin)
    shown = np.where(np.isposinf(values), above, values)
    colours = matplotlib.colormaps["viridis"].with_extremes(over=_ENDLESS)
    return axes.pcolormesh(cell_edges(x), cell_edges(y), shown, cmap=colours, norm=norm)


def draw_colour_bar(
    figure: Figure, mesh: QuadMesh, axes: Axes | list[Axes], label: str, *, endless: bool
) -> None:
    """Draw the scale of :func:`draw_cells`, with a tip for values without end if there are any."""
    bar = figure.colorbar(mesh, ax=axes, extend="max" if endless else "neither")
    bar.set_label(f"{label}; tip: no end" if endless else label)


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
