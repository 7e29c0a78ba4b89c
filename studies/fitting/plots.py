"""Figure of a fit: what was measured, the model before and after, and what is left."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from solar.sun import SECONDS_PER_DAY
from solar.types import FloatArray
from studies.fitting.channels.bins import BIN_S
from studies.fitting.estimation import Estimate
from studies.fitting.flight import FlightFit
from studies.flight_logs.plots import broken_line
from studies.output.figures.drawing import BLUE, VERMILLION, Canvas, ink, new_figure, styled
from studies.output.figures.options import DEFAULT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BETWEEN_S = 7200.0  # on the figure, from one flight to the next
_PANEL_IN = (1.9, 1.1)  # a channel's and its residuals'


@styled
def plot_fit(fit: FlightFit, *, figure: Canvas = DEFAULT) -> Figure:
    """Draw each channel of a fit, and its residuals before and after below it.

    Parameters
    ----------
    fit : FlightFit
        With a channel at least.
    figure : FigureOptions or Figure
        How the figure looks, or one that is drawn on.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        If the log has no channel to fit.
    """
    count = len(fit.estimates)
    if not count:
        raise ValueError("nothing was fitted: there is nothing to draw")
    fitted = [
        f"{one.parameter.label} {one.value:.4g} ± {one.half_width:.2g} {one.parameter.unit}".strip()
        for one in fit.fitted
    ]
    drawn, panels = new_figure(
        2 * count,
        canvas=figure,
        title=f"{fit.aircraft.name} fitted to {', '.join(one.source for one in fit.logs)}",
        notes=(f"means over {BIN_S / 60.0:g} min", *fitted),
        size_in=(8.0, count * sum(_PANEL_IN) + 1.2),
        sharex=True,
        height_ratios=_PANEL_IN * count,
    )
    midnight_s = float(fit.log.time_s[0] // SECONDS_PER_DAY * SECONDS_PER_DAY)
    for part, upper, lower in zip(fit.estimates, panels[::2], panels[1::2], strict=True):
        _draw(upper, lower, part, _shown_hours(fit, part, midnight_s))
    date = str(np.datetime64(int(midnight_s), "s").astype("datetime64[D]"))
    apart = ", later flights close behind" if len(fit.logs) > 1 else ""
    panels[-1].set_xlabel(f"time since {date} 00:00 [h UTC]{apart}")
    handles, labels = panels[0].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside lower center", ncols=3)
    return drawn


def _shown_hours(fit: FlightFit, part: Estimate, midnight_s: float) -> FloatArray:
    """Hours of the first flight, and of the others as if each began when one ended."""
    lasts = [0.0, *(float(log.time_s[-1] - log.time_s[0]) + _BETWEEN_S for log in fit.logs)]
    starts = np.cumsum(lasts) + float(fit.log.time_s[0])
    hours = [
        part.channel.time_s[rows] - fit.logs[number].time_s[0] + starts[number] - midnight_s
        for number, rows in zip(part.channel.numbers, part.channel.flights, strict=True)
    ]
    return np.concatenate(hours) / 3600.0


def _draw(upper: Axes, lower: Axes, part: Estimate, hours: FloatArray) -> None:
    channel, unit = part.channel, f" [{part.channel.unit}]" if part.channel.unit else ""
    measured = channel.measured
    for residual, name, colour, dashes in (
        (part.before, "before", BLUE, "--"),
        (part.solution.residual, "fitted", VERMILLION, "-"),
    ):
        model = broken_line(channel.run, hours, measured - residual)
        upper.plot(*model, color=colour, linestyle=dashes, linewidth=1.2, label=name)
        left = broken_line(channel.run, hours, residual)
        lower.plot(*left, color=colour, linestyle=dashes, linewidth=1.0, label=f"_{name}")
    upper.plot(hours, measured, ".", color=ink(), markersize=2.5, label="measured")
    lower.axhline(0.0, color=ink(), linewidth=0.8)
    upper.set_ylabel(f"{channel.label}{unit}".replace(" (", "\n("))
    lower.set_ylabel(f"measured −\nmodelled{unit}")
