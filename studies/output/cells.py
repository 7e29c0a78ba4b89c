"""Charts of cells: coloured by value, hatched where there is none, and lines of equal value.

Cells are drawn as they were computed, between edges half-way to their neighbours.
"""

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
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from studies.output.figures.drawing import DARK_GREY, GREY, VERMILLION

FloatArray = NDArray[np.float64]
_UNLIMITED = VERMILLION  # a colour that the scale does not have


def cell_edges(centres: FloatArray) -> FloatArray:
    """Edges half-way between the centres of cells."""
    centres = np.asarray(centres, float)
    if len(centres) == 1:
        half = 0.05 * abs(centres[0]) or 0.5
        return np.array([centres[0] - half, centres[0] + half])
    middle = (centres[:-1] + centres[1:]) / 2.0
    first, last = 2.0 * centres[0] - middle[0], 2.0 * centres[-1] - middle[-1]
    return np.concatenate(([first], middle, [last]))


def finite_range(values: FloatArray) -> Normalize:
    """Range of colours from the least to the largest finite value."""
    finite = values[np.isfinite(values)]
    if not len(finite):
        return Normalize(0.0, 1.0)
    low, high = float(finite.min()), float(finite.max())
    return Normalize(low, high if high > low else low + 1.0)


def draw_cells(
    axes: Axes, x: FloatArray, y: FloatArray, values: FloatArray, norm: Normalize
) -> QuadMesh:
    """Colour cells by their value.

    Parameters
    ----------
    axes : Axes
        Where to draw.
    x, y : ndarray
        Centres of the columns and rows of cells, ascending.
    values : ndarray, shape (y, x)
        NaN stays blank, infinity has a colour beyond the top of the scale.
    norm : Normalize
        Ends of the scale, for instance of :func:`finite_range`.

    Returns
    -------
    QuadMesh
        The cells, for :func:`draw_colour_bar`.
    """
    low, high = _ends(norm)
    shown = np.where(np.isposinf(values), high + (high - low), values)
    colours = matplotlib.colormaps["viridis"].with_extremes(over=_UNLIMITED)
    return axes.pcolormesh(cell_edges(x), cell_edges(y), shown, cmap=colours, norm=norm)


def _ends(norm: Normalize) -> tuple[float, float]:
    assert norm.vmin is not None
    assert norm.vmax is not None
    return norm.vmin, norm.vmax


def draw_colour_bar(
    figure: Figure, mesh: QuadMesh, axes: Axes | list[Axes], label: str, *, unlimited: bool
) -> None:
    """Draw the scale of :func:`draw_cells`.

    Parameters
    ----------
    figure, axes
        Figure, and axes beside which the scale stands.
    mesh : QuadMesh
        Cells of :func:`draw_cells`.
    label : str
        Quantity with its unit.
    unlimited : bool
        Whether there are infinite values, to which the tip of the scale belongs.
    """
    bar = figure.colorbar(mesh, ax=axes, extend="max" if unlimited else "neither")
    bar.set_label(f"{label}; tip: unlimited" if unlimited else label)


def hatch_cells(
    axes: Axes,
    x: FloatArray,
    y: FloatArray,
    status: NDArray[Any],
    hatches: Mapping[Any, str],
    names: Mapping[Any, str],
) -> list[Patch]:
    """Hatch cells by their status.

    Parameters
    ----------
    axes : Axes
        Where to draw.
    x, y : ndarray
        Centres of the columns and rows of cells, ascending.
    status : ndarray, shape (y, x)
        Status of each cell.
    hatches : mapping
        Hatch of each status, in the language of matplotlib; an empty one is filled with grey.
    names : mapping
        Name of each status in the legend.

    Returns
    -------
    list of Patch
        Entries of a legend, for those statuses that occur.
    """
    across, up = cell_edges(x), cell_edges(y)
    entries = []
    for value, hatch in hatches.items():
        rows, columns = np.nonzero(status == value)
        if not len(rows):
            continue
        left, right, low, high = across[columns], across[columns + 1], up[rows], up[rows + 1]
        corners = np.stack([left, low, right, low, right, high, left, high], axis=-1)
        style: dict[str, Any] = {
            "facecolor": "none" if hatch else GREY,
            "edgecolor": DARK_GREY,
            "hatch": hatch or None,
        }
        axes.add_collection(PolyCollection(list(corners.reshape(-1, 4, 2)), linewidth=0.0, **style))
        entries.append(Patch(label=names[value].replace("_", " "), linewidth=0.5, **style))
    return entries


def draw_level_lines(
    axes: Axes,
    x: FloatArray,
    y: FloatArray,
    values: FloatArray,
    norm: Normalize,
    *,
    at_most: int = 8,
) -> None:
    """Draw labelled lines of equal value between neighbouring cells that have a value.

    Parameters
    ----------
    axes : Axes
        Where to draw.
    x, y : ndarray
        Centres of the columns and rows of cells, ascending.
    values : ndarray, shape (y, x)
        No line leads from a cell with a value to one without (NaN).
    norm : Normalize
        Scale of the colours: panels that share it have the same lines.
    at_most : int
        Number of lines that is not exceeded.
    """
    if min(values.shape) < 2 or np.isfinite(values).sum() <= 3:
        return
    lowest, highest = _ends(norm)
    levels = np.asarray(MaxNLocator(at_most).tick_values(lowest, highest))
    levels = levels[(levels > lowest) & (levels < highest)]
    lines = axes.contour(x, y, values, levels, colors="black", linewidths=0.7)
    halo = withStroke(linewidth=2.0, foreground="white")  # legible on dark cells too
    for text in axes.clabel(lines, fontsize="small"):
        text.set_path_effects([halo])
