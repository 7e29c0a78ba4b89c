"""Figures of maps over season and latitude.

Excess time is drawn between cells too, linear in both directions; designs are drawn as cells, each
of which is a design of its own. Cells without a result are hatched, by the reason.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import from_levels_and_colors
from matplotlib.figure import Figure

from missions.dates import MONTH_NAMES, MONTH_STARTS, date_label
from missions.mission.scenarios import latitude_label
from sizing.program.objectives import Objective
from studies.output import cells
from studies.output.figures import drawing
from studies.output.figures.options import DEFAULT
from studies.output.gridded import SIZED, OnGrid, extrapolations_of, flown_caption
from studies.output.season_scale import LEVELS_H, UNLIMITED_H, colours
from studies.render.words import extrapolation_caption

if TYPE_CHECKING:
    from solar.types import FloatArray

_DATES = 6  # along an axis of less than two months


@drawing.styled
def plot_map(data: OnGrid, *, figure: drawing.Canvas = DEFAULT) -> Figure:
    """Draw excess time over season and latitude, with the edge of perpetual flight as a line.

    Parameters
    ----------
    data : xarray.Dataset
        Map of a fixed aircraft.
    """
    drawn, axes = _map_axes(figure, data, "line: edge of perpetual flight")
    days, latitudes = data["day"].to_numpy(), data["latitude"].to_numpy()
    excess_h = data["excess_time"].to_numpy()
    shown_h = _continued(np.where(np.isposinf(excess_h), 2.0 * UNLIMITED_H, excess_h))
    levels = (*LEVELS_H, UNLIMITED_H)
    colour_map, norm = from_levels_and_colors(levels, list(colours()), extend="both")
    shades: ScalarMappable | None = None
    if min(shown_h.shape) == 1 or np.isnan(shown_h).any():
        # Beside a cell without a result the bands end at the centres of its neighbours.
        edges = cells.cell_edges(days), cells.cell_edges(latitudes)
        shades = axes.pcolormesh(*edges, shown_h, cmap=colour_map, norm=norm)
    if min(shown_h.shape) > 1:
        shades = axes.contourf(
            days, latitudes, shown_h, levels, cmap=colour_map, norm=norm, extend="both"
        )
        if np.any(shown_h > 0.0) and np.any(shown_h <= 0.0):
            axes.contour(days, latitudes, shown_h, [0.0], colors=drawing.ink())
    assert shades is not None
    bar = drawn.colorbar(shades, ax=axes, ticks=LEVELS_H)
    bar.set_label("excess time [h]; darkest: no night")
    _finish(drawn, axes, data)
    return drawn


def _continued(excess_h: FloatArray) -> FloatArray:
    """Return excess times whose zero is the edge of perpetual flight also between cells.

    At the edge excess time jumps from zero by an hour or two. Cells behind the jump get the
    extrapolation of the two cells before it, within the same band of colours.
    """
    rows, columns = excess_h.shape
    around, band_h = np.pad(excess_h, 2, constant_values=np.nan), LEVELS_H[-4]
    results = []
    for sign in (1.0, -1.0):
        ahead = np.full(excess_h.shape, np.nan)
        for down, right in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            near, far = (
                sign * around[2 + k * down :, 2 + k * right :][:rows, :columns] for k in (1, 2)
            )
            ahead = np.fmax(ahead, np.where(near <= 0.0, 2.0 * near - far, np.nan))
        changeable = (sign * excess_h > 0.0) & (sign * excess_h < band_h) & np.isfinite(ahead)
        changed = np.where(changeable, sign * np.clip(ahead, 1e-6, 0.999 * band_h), excess_h)
        results.append((int((ahead[changeable] > 0.0).sum()), sign, changed))
    return max(results, key=lambda result: result[:2])[2]


@drawing.styled
def plot_resized_map(data: OnGrid, *, figure: drawing.Canvas = DEFAULT) -> Figure:
    """Draw the objective of the best design over season and latitude.

    Lines lead from cell to cell where both have a design.

    Parameters
    ----------
    data : xarray.Dataset
        Map of best designs.
    """
    name = Objective(data.attrs["objective"]).column
    drawn, axes = _map_axes(figure, data, drawing.objective_caption(data.attrs["objective"]))
    days, latitudes = data["day"].to_numpy(), data["latitude"].to_numpy()
    sized, about = np.isin(data["status"].to_numpy(), SIZED), data[name].attrs
    values = np.where(sized, data[name].to_numpy(), np.nan)
    norm = cells.finite_range(values)
    mesh = cells.draw_cells(axes, days, latitudes, values, norm)
    cells.draw_colour_bar(mesh, axes, f"{about['long_name']} [{about['units']}]", values)
    cells.draw_level_lines(axes, days, latitudes, values, norm, at_most=5)
    _finish(drawn, axes, data)
    return drawn


def _map_axes(canvas: drawing.Canvas, data: OnGrid, what: str) -> tuple[Figure, Axes]:
    """Return a figure with its heading, and its axes."""
    drawn, (axes,) = drawing.new_figure(
        canvas=canvas,
        title=f"{data.attrs['title']} on {json.loads(data.attrs['mission'])['name']}",
        notes=(what, flown_caption(data), extrapolation_caption(extrapolations_of(data))),
        size_in=(8.5, 5.2),
        grid="",
    )
    return drawn, axes


def _finish(figure: Figure, axes: Axes, data: OnGrid) -> None:
    """Add hatches with their legend, months along the axis of days, and latitudes."""
    days, latitudes = data["day"].to_numpy(), data["latitude"].to_numpy()
    entries = cells.hatch_reasons(axes, days, latitudes, data)
    if entries:
        drawing.add_legend(figure, entries, 3, side="right")
    if sum(days.min() <= start <= days.max() for start in MONTH_STARTS) > 1:
        axes.set_xticks(MONTH_STARTS, MONTH_NAMES, ha="left")
        axes.set_xlim(days.min(), days.max())
    else:
        shown = np.unique(np.linspace(days.min(), days.max(), _DATES).round().astype(int))
        axes.set_xticks(shown, [date_label(int(day)) for day in shown])
    lowest, highest = axes.dataLim.intervaly  # without a margin around what is drawn
    axes.set(ylabel="latitude", ylim=(max(lowest, -90.0), min(highest, 90.0)))
    axes.yaxis.set_major_formatter(lambda value, _: latitude_label(value))
