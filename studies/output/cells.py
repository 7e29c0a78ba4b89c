"""Charts of cells: coloured by value, hatched where there is none, and lines of equal value.

Cells are drawn as they were computed, between edges half-way to their neighbours; ``x`` and ``y``
are the centres of their columns and rows, ascending.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection, QuadMesh
from matplotlib.colors import Normalize
from matplotlib.patches import Patch
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from solar.types import FloatArray
from studies.output.figures.drawing import DARK_GREY, VERMILLION, night
from studies.output.gridded import OnGrid, reasons_without_result

# Hatches that are told apart in small cells.
_HATCHES = ("///", "\\\\\\", "xx", "..", "++", "oo", "--", "||", "**")
_LEAST_SHARE = 0.3  # of the cells that have a value: lines among fewer are stubs
_UNLIMITED = VERMILLION  # a colour that the scale does not have


def cell_edges(centres: FloatArray) -> FloatArray:
    """Return the edges half-way between the centres of cells."""
    centres = np.asarray(centres, float)
    if len(centres) == 1:
        half = 0.05 * abs(centres[0]) or 0.5
        return np.array([centres[0] - half, centres[0] + half])
    middle = (centres[:-1] + centres[1:]) / 2.0
    first, last = 2.0 * centres[0] - middle[0], 2.0 * centres[-1] - middle[-1]
    return np.concatenate(([first], middle, [last]))


def finite_range(values: FloatArray) -> Normalize:
    """Return the range of colours from the least to the largest finite value."""
    finite = values[np.isfinite(values)]
    if not len(finite):
        return Normalize(0.0, 1.0)
    low, high = float(finite.min()), float(finite.max())
    return Normalize(low, high if high > low else low + 1.0)


def draw_cells(
    axes: Axes, x: FloatArray, y: FloatArray, values: FloatArray, norm: Normalize
) -> QuadMesh:
    """Colour cells by their value.

    ``values``: NaN stays blank, infinity has a colour beyond the top of the scale. Returns the
    cells, for :func:`draw_colour_bar`.
    """
    beyond = norm.inverse(2.0)
    colours = matplotlib.colormaps["viridis"].with_extremes(over=_UNLIMITED)
    shown = np.where(np.isposinf(values), beyond, values)
    return axes.pcolormesh(cell_edges(x), cell_edges(y), shown, cmap=colours, norm=norm)


def draw_colour_bar(
    mesh: QuadMesh, axes: Axes | list[Axes], label: str, values: FloatArray
) -> None:
    """Draw the scale of :func:`draw_cells`; infinite values have its tip."""
    unlimited = bool(np.isposinf(values).any())
    bar = mesh.figure.colorbar(mesh, ax=axes, extend="max" if unlimited else "neither")
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

    ``hatches``: hatch of each status, in the language of matplotlib; an empty one is filled with
    grey. Returns entries of a legend, for those statuses that occur.
    """
    across, up = cell_edges(x), cell_edges(y)
    entries = []
    for value, hatch in hatches.items():
        marked = status == value
        if not marked.any():
            continue
        style: dict[str, Any] = {"edgecolor": DARK_GREY, "hatch": hatch or None}
        style["facecolor"] = "none" if hatch else night()
        axes.add_collection(PathCollection([_area(marked, across, up)], linewidth=0.0, **style))
        entries.append(Patch(label=names[value].replace("_", " "), linewidth=0.5, **style))
    return entries


def _area(marked: NDArray[np.bool_], across: FloatArray, up: FloatArray) -> Path:
    """Return marked cells as one path: hatching ten thousand of them takes a second.

    Neighbours in a row are one rectangle.
    """
    changes = np.diff(np.pad(marked, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    rows, begins = np.nonzero(changes > 0)
    ends = np.nonzero(changes < 0)[1]
    left, right, low, high = across[begins], across[ends], up[rows], up[rows + 1]
    corners = np.stack([left, low, right, low, right, high, left, high, left, low], axis=-1)
    codes = [Path.MOVETO, *[Path.LINETO] * 3, Path.CLOSEPOLY]
    return Path(corners.reshape(-1, 2), codes * len(rows))


def hatch_reasons(axes: Axes, x: FloatArray, y: FloatArray, data: OnGrid) -> list[Patch]:
    """Hatch the cells that have no result by the reason why.

    ``data``: with the status of each cell, over y and x, and the requirement that no design meets
    where aircraft are sized. Returns entries of a legend, for the reasons that occur.
    """
    reasons = reasons_without_result(data)
    hatches = dict(zip(sorted({*reasons[reasons != ""]}), itertools.cycle(_HATCHES), strict=False))
    return hatch_cells(axes, x, y, reasons, hatches, {name: name for name in hatches})


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

    ``values``: no line leads from a cell with a value to one without (NaN). ``norm``: scale of the
    colours: panels that share it have the same lines.
    """
    if min(values.shape) < 2 or np.isfinite(values).mean() < _LEAST_SHARE:
        return
    ends = norm.inverse(0.0), norm.inverse(1.0)
    levels = np.asarray(MaxNLocator(at_most).tick_values(*ends))
    levels = levels[(levels > ends[0]) & (levels < ends[1])]
    lines = axes.contour(x, y, values, levels, colors="black", linewidths=0.7)
    halo = withStroke(linewidth=2.0, foreground="white")  # legible on dark cells too
    for text in axes.clabel(lines, fontsize="small", inline=False):
        text.set_path_effects([halo])
