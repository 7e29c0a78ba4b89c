"""Figure of flights under uncertain inputs: the spread of the excess time, and its causes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sizing.results.uncertainty import PERCENTILES, UncertaintyAnalysis
from sizing.uncertainty.inputs import UncertainInput
from studies.output.figures.drawing import (
    BLUE,
    DARK_GREY,
    ORANGE,
    VERMILLION,
    Canvas,
    caption,
    new_figure,
    styled,
)
from studies.output.figures.options import DEFAULT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_BARS = 12


@styled
def plot_uncertainty(analysis: UncertaintyAnalysis, *, figure: Canvas = DEFAULT) -> Figure:
    """Draw how the excess time scatters, and which inputs make it scatter.

    On the left a histogram of the draws with P10, P50 and P90; on the right a tornado: the range of
    the excess time's mean when one input goes from its P10 to its P90, and the share of the
    variance that the input explains together with all others.

    Parameters
    ----------
    analysis : UncertaintyAnalysis
    figure : FigureOptions or Figure
        How the figure looks, or one that is drawn on.

    Returns
    -------
    Figure
    """
    count = min(len(analysis.inputs), _MOST_BARS)
    drawn, (spread, causes) = new_figure(
        1,
        2,
        canvas=figure,
        title=analysis.headline(),
        notes=(caption(analysis.solar),),
        size_in=(10.0, max(3.6, 1.8 + 0.42 * count)),
        grid="x",
        width_ratios=(1.0, 1.15),
    )
    _draw_spread(spread, analysis)
    _draw_causes(causes, analysis)
    return drawn


def _draw_spread(axes: Axes, analysis: UncertaintyAnalysis) -> None:
    excess = analysis.flights.excess_time_h
    finite = excess[np.isfinite(excess)]
    axes.set(xlabel="excess time [h]", ylabel="draws [%]")
    if not len(finite):
        axes.text(0.5, 0.5, "unlimited in all draws", transform=axes.transAxes, ha="center")
        return
    weights = np.full(len(finite), 100.0 / len(excess))
    axes.hist(finite, bins=60, weights=weights, color=BLUE, alpha=0.8)
    for name, at in PERCENTILES.items():
        value = float(np.percentile(excess, at, method="inverted_cdf"))
        if np.isfinite(value):
            axes.axvline(value, color=DARK_GREY, linestyle="-" if at == 50.0 else "--")
            axes.text(
                value, 1.01, name.upper(), transform=axes.get_xaxis_transform(), ha="center",
                fontsize="small",
            )  # fmt: skip
    low, high = axes.get_xlim()
    if low < 0.0 < high:
        axes.axvspan(low, 0.0, color=VERMILLION, alpha=0.12, linewidth=0, label="not perpetual")
        axes.legend()
    axes.set_xlim(low, high)


def _draw_causes(axes: Axes, analysis: UncertaintyAnalysis) -> None:
    """Bars from the mean excess time of each input's lowest draws to that of its highest."""
    excess = analysis.flights.excess_time_h
    finite = np.isfinite(excess)
    rows: list[tuple[UncertainInput, float, float]] = []
    for one in analysis.inputs.inputs:
        value = analysis.values[one.key]
        low, high = (
            float(np.mean(excess[finite & side])) if np.any(finite & side) else np.nan
            for side in (
                value <= np.percentile(value, 20.0),
                value >= np.percentile(value, 80.0),
            )
        )
        rows.append((one, low, high))
    rows.sort(key=lambda row: np.nan_to_num(abs(row[2] - row[1])))
    rows = rows[-_MOST_BARS:]
    centre = float(np.mean(excess[finite])) if np.any(finite) else 0.0
    for y, (one, low, high) in enumerate(rows):
        axes.barh(y, low - centre, left=centre, color=ORANGE, height=0.6)
        axes.barh(y, high - centre, left=centre, color=BLUE, height=0.6, hatch="//")
        index = analysis.sobol.get(one.key)
        if index is not None:
            axes.text(
                1.01, y, f"{100 * index.total:.0f} %", transform=axes.get_yaxis_transform(),
                va="center", fontsize="small",
            )  # fmt: skip
    axes.axvline(centre, color=DARK_GREY)
    axes.set_yticks(range(len(rows)), [row[0].label for row in rows])
    axes.set_xlabel(
        "mean excess time [h] of an input's lowest fifth (plain)\nand of its highest (hatched)"
    )
    if analysis.sobol:
        axes.text(1.01, 1.01, "variance", transform=axes.transAxes, fontsize="small", va="bottom")
