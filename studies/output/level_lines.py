"""Labelled lines of equal value over a chart of cells."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

__all__ = ["draw_level_lines"]


def draw_level_lines(
    axes: Axes,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    values: NDArray[np.float64],
    lowest: float,
    highest: float,
    *,
    at_most: int = 8,
) -> None:
    """Draw lines between neighbouring cells that have a value, shape ``(y, x)``.

    No line leads from a cell with a value to one without (NaN). ``lowest`` and ``highest`` are the
    ends of the colours, so that panels that share them have the same lines.
    """
    if min(values.shape) < 2 or np.isfinite(values).sum() <= 3:
        return
    levels = np.asarray(MaxNLocator(at_most).tick_values(lowest, highest))
    levels = levels[(levels > lowest) & (levels < highest)]
    lines = axes.contour(x, y, values, levels, colors="black", linewidths=0.7)
    halo = withStroke(linewidth=2.0, foreground="white")  # legible on dark cells too
    for text in axes.clabel(lines, fontsize="small"):
        text.set_path_effects([halo])
