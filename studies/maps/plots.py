"""Figures of maps over season and latitude.

Cells are drawn as they are: nothing is smoothed or filled in between. Cells without a result are
hatched, by the reason.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure

from missions.dates import MONTH_NAMES, date_label
from sizing.optimisation.objectives import Objective
from studies.output.cells import (
    cell_edges,
    diverging,
    draw_cells,
    draw_colour_bar,
    draw_level_lines,
    finite_range,
    hatch_reasons,
)
from studies.output.columns import SIZED, extrapolations_of
from studies.output.figures.drawing import (
    Canvas,
    dataset_caption,
    ink,
    new_figure,
    objective_caption,
    outside_ranges,
    styled,
)
from studies.output.figures.options import DEFAULT
from studies.output.gridded import OnGrid

if TYPE_CHECKING:
    from solar.types import FloatArray

__all__ = ["plot_map", "plot_resized_map"]

_LEVELS = 6  # on either side of zero
_DATES = 6  # along an axis of less than two months


@styled
def plot_map(data: OnGrid, *, figure: Canvas = DEFAULT) -> Figure:
    """Excess time over season and latitude, with the edge of perpetual flight drawn as a line.

    Parameters
    ----------
    data : xarray.Dataset
        Map of a fixed aircraft.
    figure : FigureOptions or Figure
        How the figure looks, or one that is drawn on.

    Returns
    -------
    Figure
    """
    drawn, axes = _begun(figure, data, "line: edge of perpetual flight")
    days, latitudes = data["day"].to_numpy(), data["latitude"].to_numpy()
    excess = data["excess_time"].to_numpy()
    top = np.nanmax(np.where(np.isfinite(excess), excess, np.nan), initial=1.0)
    shown = np.where(np.isposinf(excess), 2.0 * top, excess)
    levels = _levels(top)
    norm = BoundaryNorm(levels, ncolors=256, extend="both")
    mesh = axes.pcolormesh(cell_edges(days), cell_edges(latitudes), shown, norm=norm)
    mesh.set_cmap(diverging())
    bar = drawn.colorbar(mesh, ax=axes, ticks=levels)
    bar.set_label("excess time [h]; beyond the top: no night")
    if min(excess.shape) > 1 and np.any(shown > 0.0) and np.any(shown <= 0.0):
        # No edge leads along cells of which nothing is known.
        perpetual = np.where(np.isnan(shown), np.nan, shown > 0.0)
        axes.contour(days, latitudes, perpetual, [0.5], colors=ink())
    _finish(drawn, axes, data)
    return drawn


@styled
def plot_resized_map(data: OnGrid, *, figure: Canvas = DEFAULT) -> Figure:
    """Objective of the best design over season and latitude.

    Lines lead from cell to cell where both have a design.

    Parameters
    ----------
    data : xarray.Dataset
        Map of best designs.
    figure : FigureOptions or Figure
        How the figure looks, or one that is drawn on.

    Returns
    -------
    Figure
    """
    name = Objective(data.attrs["objective"]).column
    drawn, axes = _begun(figure, data, objective_caption(data.attrs["objective"]))
    days, latitudes = data["day"].to_numpy(), data["latitude"].to_numpy()
    sized, about = np.isin(data["status"].to_numpy(), SIZED), data[name].attrs
    values = np.where(sized, data[name].to_numpy(), np.nan)
    norm = finite_range(values)
    draw_colour_bar(
        drawn,
        draw_cells(axes, days, latitudes, values, norm),
        axes,
        f"{about['long_name']} [{about['units']}]",
        unlimited=bool(np.isposinf(values).any()),
    )
    draw_level_lines(axes, days, latitudes, values, norm, at_most=5)
    _finish(drawn, axes, data)
    return drawn


def _begun(canvas: Canvas, data: OnGrid, what: str) -> tuple[Figure, Axes]:
    """Figure with its heading."""
    drawn, (axes,) = new_figure(
        canvas=canvas,
        title=f"{data.attrs['title']} on {json.loads(data.attrs['mission'])['name']}",
        notes=(what, dataset_caption(data), outside_ranges(extrapolations_of(data))),
        size_in=(8.5, 5.2),
        grid="",
    )
    return drawn, axes


def _finish(figure: Figure, axes: Axes, data: OnGrid) -> None:
    """Hatches with their legend, and months."""
    days, latitudes = data["day"].to_numpy(), data["latitude"].to_numpy()
    entries = hatch_reasons(axes, days, latitudes, data)
    if entries:
        figure.legend(handles=entries, loc="outside lower right", ncols=3)
    _season_axes(axes, days)


def _levels(top: float) -> FloatArray:
    """Symmetric levels around zero, so that white is where perpetual flight begins."""
    steps = (0.5, 1.0, 2.0, 3.0, 4.0)
    step = next((s for s in steps if top <= _LEVELS * s), float(np.ceil(top / _LEVELS)))
    return step * np.arange(-_LEVELS, _LEVELS + 1.0)


def _season_axes(axes: Axes, days: FloatArray) -> None:
    """Months along the axis of days, and the name of the other one."""
    starts = np.cumsum([0, 31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30]) + 1
    if np.count_nonzero((days.min() <= starts) & (starts <= days.max())) > 1:
        axes.set_xticks(starts, MONTH_NAMES, ha="left")
        axes.set_xlim(days.min(), days.max())
    else:
        shown = np.unique(np.linspace(days.min(), days.max(), _DATES).round().astype(int))
        axes.set_xticks(shown, [date_label(int(day)) for day in shown])
    lowest, highest = axes.get_ylim()
    axes.set(ylabel="latitude [deg]", ylim=(max(lowest, -90.0), min(highest, 90.0)))
