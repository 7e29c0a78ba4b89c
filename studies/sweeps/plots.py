"""Charts of trade studies. Nothing is smoothed: points without a design are hatched or left out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import cycle
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from sizing.day.metrics import ENDS
from sizing.program.objectives import Objective, SizingStatus
from solar.schema import spell
from solar.types import FloatArray
from studies.output import cells, gridded
from studies.output.figures import drawing
from studies.output.figures.options import DEFAULT
from studies.render.words import extrapolation_caption
from studies.sweeps.axes import axis_label, unit_label
from studies.sweeps.results import MORE_IS_BETTER, pareto_table

MAXIMUM_PANELS = 12
# How lines mark points without a result, by reason.
_MARKERS = "x+*v1234"


@drawing.styled
def plot_sweep(data: xr.Dataset, *, figure: drawing.Canvas = DEFAULT) -> Figure:
    """Draw a study as lines, contours, panels, parallel coordinates or a tornado.

    Parameters
    ----------
    data : xarray.Dataset
        Trade study.

    Raises
    ------
    ValueError
        If there are more panels than a page takes, or no point to draw.
    """
    if data.attrs["sample"] == "one-at-a-time":
        return _tornado_figure(data, figure)
    if not _drawable(data).any():
        reasons = Counter(gridded.reasons_without_result(data).ravel())
        why = "; ".join(f"{count} points: {reason}" for reason, count in reasons.most_common())
        raise ValueError(f"no point has a result: there is nothing to draw ({why})")
    axes = [str(name) for name in data["status"].dims]
    if data.attrs["sample"] != "grid" or len(axes) > 3:
        return _parallel_figure(data, figure)
    if len(axes) == 1 and _has_names(data, axes[0]):
        return _names_figure(data, figure)
    if len(axes) == 1:
        return _line_figure(data, figure)
    return _contour_figure(data, figure)


def _label(data: xr.Dataset, name: str) -> str:
    about = data[name].attrs
    text = str(about["long_name"]).removesuffix(" of the worst scenario")
    text = axis_label(text) if name in data.coords else text.replace("_", " ")
    return text if about["units"] == "1" else f"{text} [{unit_label(about['units'])}]"


def _title_and_notes(data: xr.Dataset, note: str = "") -> dict[str, Any]:
    """Return title and notes, as :func:`new_figure` takes them."""
    objective = data.attrs["objective"]
    failed = np.sum(data["status"].to_numpy() == SizingStatus.failed)  # the same in every status
    notes = (
        f"sized for the {drawing.objective_caption(objective)}" if objective else "",
        gridded.flown_caption(data),
        f"{failed} of {data['status'].size} points failed" if failed else "",
        note,
        extrapolation_caption(gridded.extrapolations_of(data)),
    )
    return {"title": str(data.attrs["title"]), "notes": notes}


def _plotted_variables(data: xr.Dataset) -> tuple[str, str]:
    objective = data.attrs["objective"]
    if not objective:
        return "excess_time", "charge_margin"
    sized = Objective(objective)
    others = (sized.beside, "battery_mass", "module_area", "wingspan")
    varied = {_label(data, str(name)) for name in data.coords}
    return sized.column, next(name for name in others if _label(data, name) not in varied)


def _drawable(data: xr.Dataset) -> NDArray[np.bool_]:
    """Flag the points with a result, feasible or not."""
    return np.isin(data["status"].to_numpy(), gridded.SIZED if data.attrs["objective"] else ENDS)


# ---- Grids


def _line_figure(data: xr.Dataset, canvas: drawing.Canvas) -> Figure:
    """Draw both variables over a single axis; points without a result break the line."""
    (name,) = (str(n) for n in data["status"].dims)
    figure, panels = drawing.new_figure(
        2, canvas=canvas, **_title_and_notes(data), size_in=(7.0, 5.4), sharex=True
    )
    x, reasons = data[name].to_numpy(), gridded.reasons_without_result(data)
    for axes, (variable, values, colour) in zip(panels, _finite_values(data), strict=True):
        axes.plot(x, values, "o-", color=colour, markersize=4)
        _mark_extrapolated(axes, x, values, _extrapolated(data))
        axes.set(ylabel=_label(data, variable))
        if variable == "excess_time":
            axes.axhline(0.0, color=drawing.ink(), linewidth=0.8)
        at_bottom = axes.get_xaxis_transform()
        for mark, words in zip(cycle(_MARKERS), sorted(set(reasons) - {""}), strict=False):
            gone = x[reasons == words]
            low = [0.03] * len(gone)
            axes.plot(gone, low, mark, color=drawing.DARK_GREY, transform=at_bottom, label=words)
        if axes.get_legend_handles_labels()[0]:
            axes.legend()
    panels[-1].set(xlabel=_label(data, name))
    return figure


def _names_figure(data: xr.Dataset, canvas: drawing.Canvas) -> Figure:
    """Draw both variables by product of a catalogue, or the reason without a result.

    Nothing lies between two names.
    """
    (name,) = (str(n) for n in data["status"].dims)
    places, reasons = _axis_positions(data, name), gridded.reasons_without_result(data)
    figure, panels = drawing.new_figure(
        1,
        2,
        canvas=canvas,
        **_title_and_notes(data),
        size_in=(8.0, 1.6 + 0.28 * len(places)),
        lines=True,
        sharey=True,
    )
    for axes, (variable, values, colour) in zip(panels, _finite_values(data), strict=True):
        axes.plot(values, places, "o", color=colour)
        _mark_extrapolated(axes, values, places, _extrapolated(data))
        axes.set(xlabel=_label(data, variable))
        axes.margins(x=0.1)
    for place in np.flatnonzero(reasons != ""):
        drawing.note(panels[0], reasons[place], (0.02, place), across=True, va="center")
    _name_places(panels[0].yaxis, data, name)
    panels[0].set_ylim(len(places) - 0.5, -0.5)
    if entries := panels[0].get_legend_handles_labels()[0]:
        drawing.add_legend(figure, entries, 1)
    return figure


def _finite_values(data: xr.Dataset) -> Iterator[tuple[str, FloatArray, str]]:
    """Yield both variables with their values, NaN where they are not drawn, and their colours."""
    for variable, colour in zip(
        _plotted_variables(data), (drawing.LOAD, drawing.CHARGE), strict=True
    ):
        values = data[variable].to_numpy()
        yield variable, np.where(_drawable(data) & ~np.isinf(values), values, np.nan), colour


def _contour_figure(data: xr.Dataset, canvas: drawing.Canvas) -> Figure:
    """Draw two variables over the first two axes; a third axis makes panels.

    Coloured cells are the computed points; contour lines connect feasible neighbours. Limited
    points are grey, points without a result hatched, by the reasons of a legend.
    """
    names = [str(n) for n in data["status"].dims]
    third = data[names[2]].to_numpy() if len(names) == 3 else [None]
    if len(third) > MAXIMUM_PANELS:
        raise ValueError(
            f"{names[2]} has {len(third)} values, a chart takes at most {MAXIMUM_PANELS} panels"
        )
    figure, panels = drawing.new_figure(
        2,
        len(third),
        canvas=canvas,
        **_title_and_notes(data),
        size_in=(1.6 + 3.6 * len(third), 7.2),
        grid="",
        sharex=True,
        sharey=True,
    )
    rows = (panels[: len(third)], panels[len(third) :])
    handles: dict[str, Any] = {}
    for row, variable in zip(rows, _plotted_variables(data), strict=True):
        every = _shown_values(data, variable)
        norm = cells.finite_range(every)
        for axes, value in zip(row, third, strict=True):
            part = data if value is None else data.isel({names[2]: list(third).index(value)})
            mesh, entries = _draw_contours(axes, part, names[:2], variable, norm)
            handles |= {str(entry.get_label()): entry for entry in entries}
            if value is not None and variable == _plotted_variables(data)[0]:
                value_text = value if isinstance(value, str) else spell(value)
                axes.set_title(f"{_label(data, names[2])} = {value_text}", fontsize="medium")
        cells.draw_colour_bar(mesh, row, _label(data, variable), every)
    for axes in panels:
        _name_places(axes.xaxis, data, names[0])
        _name_places(axes.yaxis, data, names[1])
    for axes in rows[-1]:
        axes.set(xlabel=_label(data, names[0]))
    for row in rows:
        row[0].set(ylabel=_label(data, names[1]))
    if handles:
        drawing.add_legend(figure, list(handles.values()), 4, side="right")
    return figure


def _has_names(data: xr.Dataset, name: str) -> bool:
    """Return true for a varied key with names of a catalogue."""
    return data[name].dtype.kind in "OU"


def _axis_positions(data: xr.Dataset, name: str) -> NDArray[Any]:
    """Return the values of a varied key, indices for names."""
    return np.arange(data[name].size) if _has_names(data, name) else data[name].to_numpy()


# Letters of all names of a horizontal axis that fit in a row.
_LETTERS_IN_A_ROW = 45


def _name_places(axis: Any, data: xr.Dataset, key: str) -> None:
    """Write the names of a varied key at their places, upright where they are many."""
    if not _has_names(data, key):
        return
    names = [str(name) for name in data[key].to_numpy()]
    upright = axis.axis_name == "x" and sum(map(len, names)) > _LETTERS_IN_A_ROW
    axis.set_ticks(_axis_positions(data, key), names, rotation=90 if upright else 0)


def _shown_values(data: xr.Dataset, variable: str) -> NDArray[np.float64]:
    """Return the values of feasible points, NaN elsewhere."""
    values = np.where(gridded.feasible(data), data[variable].to_numpy(), np.nan)
    return np.where(np.isneginf(values), np.nan, values)


def _draw_contours(
    axes: Axes, data: xr.Dataset, names: list[str], variable: str, norm: Normalize
) -> tuple[Any, list[Any]]:
    flat = data.transpose(*names[::-1])
    x, y = (_axis_positions(data, name) for name in names)
    values = _shown_values(flat, variable)
    mesh = cells.draw_cells(axes, x, y, values, norm)
    good = gridded.feasible(flat)
    limited = ~good & _drawable(flat)
    # A battery that is never full would not be fuller if it were larger.
    by_night = limited & (flat["charge_margin"].to_numpy() > 0.0)
    why = np.where(by_night, 2, np.where(limited, 1, 0))
    entries = cells.hatch_cells(axes, x, y, why, {1: "", 2: "--"}, _LIMITED)
    entries += cells.hatch_reasons(axes, x, y, flat)
    entries += cells.hatch_cells(
        axes, x, y, _extrapolated(flat) & good, {True: "."}, {True: "extrapolated"}
    )
    if not any(_has_names(data, name) for name in names):
        cells.draw_level_lines(axes, x, y, values, norm)
    return mesh, entries


_LIMITED = {1: "limited: the day gives too little", 2: "limited: the battery is too small"}


def _extrapolated(data: xr.Dataset) -> NDArray[np.bool_]:
    """Flag the points outside the range of a model."""
    return np.asarray(data["extrapolations"].to_numpy() != "")


def _mark_extrapolated(axes: Axes, x: Any, y: Any, outside: NDArray[np.bool_]) -> None:
    """Draw rings around the points outside the range of a model."""
    if np.isfinite(np.where(outside, y, np.nan)).any():
        ring: dict[str, Any] = {"markersize": 9, "fillstyle": "none", "color": drawing.VERMILLION}
        over, up = np.asarray(x)[outside], np.asarray(y)[outside]
        axes.plot(over, up, "o", label="extrapolated", **ring)


# ---- Samples


def _parallel_figure(data: xr.Dataset, canvas: drawing.Canvas) -> Figure:
    """Draw each point as a line over the varied keys and the first variable, its colour."""
    variable = _plotted_variables(data)[0]
    table = gridded.to_table(data).assign(good=gridded.feasible(data).ravel())
    table = table[_drawable(data).ravel() & np.isfinite(table[variable])]
    if table.empty:
        raise ValueError("no point has a result: there is nothing to draw")
    names = [n for n in (str(name) for name in data.coords) if n in table.columns]
    odd = [name for name in names if _has_names(data, name)]
    if odd:
        raise ValueError(f"{odd[0]} has names: a chart of more than three keys takes numbers")
    columns = [*names, variable]
    lost = int((~_drawable(data)).sum())
    note = f"{lost} points without a result left out" if lost else ""
    if _extrapolated(data).any():
        note = "; ".join(filter(None, (note, "dotted: extrapolated")))
    figure, (axes,) = drawing.new_figure(
        canvas=canvas,
        **_title_and_notes(data, note),
        size_in=(2.0 + 1.7 * len(columns), 5.0),
        grid="",
    )
    low, high = (getattr(table[columns], end)() for end in ("min", "max"))
    span = (high - low).where(high > low, 1.0)
    good = table[table["good"]]
    norm = Normalize(float(good[variable].min()), float(good[variable].max()))
    colours = matplotlib.colormaps["viridis"]
    for _, row in table.sort_values(["good", variable]).iterrows():
        heights = ((row[columns] - low) / span).astype(float)
        colour = colours(norm(row[variable])) if row["good"] else drawing.GREY
        dash = ":" if row["extrapolations"] else "-"
        axes.plot(range(len(columns)), heights, dash, color=colour, alpha=0.7, linewidth=1)
    for place, name in enumerate(columns):
        axes.plot([place, place], [0.0, 1.0], color=drawing.ink(), linewidth=0.8)
        for height, value in ((-0.04, low[name]), (1.04, high[name])):
            axes.annotate(spell(value, 4), (place, height), ha="center", va="center")
    axes.set_xticks(range(len(columns)), [_label(data, n).replace(" [", "\n[") for n in columns])
    axes.set(yticks=[], ylim=(-0.1, 1.1), xlim=(-0.5, len(columns) - 0.5))
    for side in ("left", "right", "top", "bottom"):
        axes.spines[side].set_visible(False)
    if len(good):
        bar = figure.colorbar(ScalarMappable(norm, colours), ax=axes)
        bar.set_label(f"{_label(data, variable)}; grey: limited")
    return figure


def _tornado_figure(data: xr.Dataset, canvas: drawing.Canvas) -> Figure:
    """Draw the range of the first variable over the values of each key, widest on top."""
    odd = [str(name) for name in data.coords if name != "varied" and _has_names(data, str(name))]
    if odd:
        raise ValueError(f"{odd[0]} has names: this chart is one of less and more of numbers")
    variable = _plotted_variables(data)[0]
    table = gridded.to_table(data)
    table["drawable"] = _drawable(data).ravel() & np.isfinite(table[variable])
    base = table[table["varied"] == ""].iloc[0]
    if not base["drawable"]:
        raise ValueError(f"the files' own point has no result to start from ({base['status']})")
    bars = [
        (str(name), rows[rows["drawable"]], int((~rows["drawable"]).sum()))
        for name, rows in table[table["varied"] != ""].groupby("varied", sort=False)
    ]
    bars.sort(key=lambda bar: float(np.ptp([*bar[1][variable], base[variable]])))
    figure, (axes,) = drawing.new_figure(
        canvas=canvas,
        **_title_and_notes(data),
        size_in=(9.0, 1.8 + 0.6 * len(bars)),
        lines=True,
        grid="x",
    )
    for place, (name, rows, lost) in enumerate(bars):
        _draw_bar(axes, place, rows, name, variable, base)
        if lost:
            at, words = (0.99, place + 0.3), f"{lost} without a result"
            drawing.note(axes, words, at, across=True, ha="right", fontsize="x-small")
    axes.axvline(base[variable], color=drawing.ink(), linewidth=0.8)
    labels = [f"{_label(data, name)}\n(file: {spell(base[name], 4)})" for name, _, _ in bars]
    axes.set_yticks(range(len(bars)), labels)
    axes.set(xlabel=_label(data, variable), ylim=(-0.6, len(bars) - 0.4))
    entries = [
        Patch(label=name, linewidth=0.0, **_bar_style(low=low))
        for name, low in (("less than in the file", True), ("more", False))
    ]
    drawing.add_legend(figure, entries, 2, side="right")
    axes.use_sticky_edges = False
    axes.margins(x=0.12)
    return figure


def _bar_style(*, low: bool) -> dict[str, Any]:
    colour, hatch = (drawing.SUN, "") if low else (drawing.LOAD, "//")
    return {"facecolor": colour, "edgecolor": drawing.paper(), "hatch": hatch}


def _draw_bar(
    axes: Axes, place: int, rows: pd.DataFrame, name: str, variable: str, base: pd.Series[Any]
) -> None:
    """Draw a bar from the least to the largest result, with the key's values at its ends."""
    for low in (True, False):
        side = rows[rows[name] < base[name]] if low else rows[rows[name] > base[name]]
        if side.empty:
            continue
        least, most = side[variable].min(), side[variable].max()
        start, end = min(least, base[variable]), max(most, base[variable])
        height = 0.25 if low else -0.25
        style = _bar_style(low=low)
        axes.barh(place + height / 2, end - start, 0.25, left=start, linewidth=0.0, **style)
        extreme = side.loc[(side[variable] - base[variable]).abs().idxmax()]
        right = extreme[variable] >= base[variable]
        drawing.note(
            axes,
            spell(extreme[name], 4),
            (extreme[variable], place + height / 2),
            (4 if right else -4, 0),
            ha="left" if right else "right",
            va="center",
            fontsize="x-small",
        )


# ---- Pareto front


@drawing.styled
def plot_pareto(data: xr.Dataset, x: str, y: str, *, figure: drawing.Canvas = DEFAULT) -> Figure:
    """Draw all feasible points over two variables, and the Pareto front.

    Parameters
    ----------
    data : xarray.Dataset
        Trade study.
    x, y : str
        Columns over and up, see :func:`pareto_table`.

    Raises
    ------
    ValueError
        If a name is unknown, or no point is feasible.
    """
    table = pareto_table(data, x, y)
    if table.empty:
        raise ValueError("no point is feasible: there is no front to draw")
    front = table[table["pareto_front"]]
    count = data["status"].size - len(table)
    note = f"{count} points without a design left out" if count else ""
    drawn, (axes,) = drawing.new_figure(
        canvas=figure, **_title_and_notes(data, note), size_in=(7.0, 5.0)
    )
    if len(front) < len(table):
        axes.plot(table[x], table[y], "o", color=drawing.DARK_GREY, markersize=4, label="feasible")
    over, up = (front.sort_values([x, y])[name] for name in (x, y))
    axes.plot(over, up, "s-", color=drawing.LOAD, markersize=6, linewidth=1.0, label="Pareto front")
    _mark_extrapolated(axes, table[x], table[y], table["extrapolations"].to_numpy() != "")
    for label, over, up in zip(front["point"], front[x], front[y], strict=True):
        drawing.note(axes, label, (over, up), (4, 4))
    better = {name: "more" if name in MORE_IS_BETTER else "less" for name in (x, y)}
    axes.set(
        xlabel=f"{_label(data, x)}; {better[x]} is better",
        ylabel=f"{_label(data, y)}; {better[y]} is better",
    )
    axes.legend()
    return drawn
