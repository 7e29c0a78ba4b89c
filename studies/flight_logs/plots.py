"""Figures of a verification: residuals of the whole flight, and power in each window."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.logs.plausible import utc_text
from solar.schema import spell
from solar.sun import SECONDS_PER_DAY
from solar.types import BoolArray, FloatArray
from studies.flight_logs.errors import moving_average
from studies.flight_logs.left_out import Reason
from studies.flight_logs.verification import Verification
from studies.output.figures import drawing
from studies.output.figures.drawing import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILLION
from studies.output.figures.options import DEFAULT, FigureOptions

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LEFT_OUT: dict[Reason, tuple[str, str]] = {
    "battery_full": ("battery full", "\\\\\\"),
    "no_power": ("no power", "oo"),
    "frozen": ("frozen", "||"),
    "implausible": ("implausible", "xx"),
    "excluded": ("by hand", "++"),
    "missing_data": ("no data", "///"),
}
_LOGGED: dict[str, Any] = {"color": VERMILLION, "linestyle": "-"}
_ESTIMATED: dict[str, Any] = {"color": BLUE, "linestyle": "--"}
# More points than this cannot be distinguished on a page.
_MOST_POINTS = 4000
_BRIGHT = 0.1  # of the peak: below, shares of MPPTs are noise


def figures(
    result: Verification, *, figure: FigureOptions = DEFAULT
) -> Iterator[tuple[str, Callable[[], Figure]]]:
    """Yield functions that draw residuals and windows, each with a name for its file."""
    yield "residuals", partial(residual_figure, result, figure=figure)
    for number in range(len(result.windows)):
        yield f"window-{number + 1}", partial(window_figure, result, number, figure=figure)


@drawing.styled
def window_figure(result: Verification, number: int, *, figure: drawing.Canvas = DEFAULT) -> Figure:
    """Draw measured and modelled power in a window, and errors of all models."""
    section = result.windows[number]
    page = _Page(result, 2, section.label, section.mask, section.filter_s, figure)
    power, error = page.panels
    page.draw_power(power)
    for model, modelled in result.samples.modelled_w.items():
        left = page.smooth(modelled - result.samples.measured_w)
        page.line(error, left, **drawing.MODEL_LOOKS[model])
    error.set_ylabel("model − measured [W]")
    return page.finished([power, error], [error])


@drawing.styled
def residual_figure(result: Verification, *, figure: drawing.Canvas = DEFAULT) -> Figure:
    """Draw power and residuals over time, the sun's elevation and azimuth, and by MPPT."""
    samples, bins = result.samples, result.residuals
    with_bearing = not bins["bearing"].empty
    panels = 3 + with_bearing + (result.mppts is not None)
    every, filter_s = np.ones(len(samples.time_s), bool), result.days[0].filter_s
    page = _Page(result, panels, "models against flight", every, filter_s, figure)
    power, error, elevation, *rest = page.panels
    page.draw_power(power)
    for label, modelled, style in (
        ("as logged", samples.modelled_w[samples.best_model], _LOGGED),
        ("with the estimates", result.estimated_w, _ESTIMATED),
    ):
        if modelled is not None:
            left = page.smooth(modelled - samples.measured_w)
            page.line(error, np.where(result.excluded, np.nan, left), label=label, **style)
    error.set_ylabel(f"{samples.best_model} − measured [W]")
    _draw_bins(elevation, bins["morning"], "morning", "o")
    _draw_bins(elevation, bins["afternoon"], "afternoon", "^")
    elevation.set(ylabel="error [%]", xlabel="elevation of the sun [deg]")
    zero = [error, elevation]
    if with_bearing:
        zero.append(rest[0])
        _draw_bins(rest[0], bins["bearing"], "", "o")
        rest[0].set(ylabel="error [%]", xlabel="azimuth of the sun from the nose, clockwise [deg]")
        rest[0].set(xlim=(0, 360), xticks=range(0, 361, 45))
    if result.mppts is not None:
        bright = result.mppts.modelled_w.sum(axis=1)
        bright = bright > _BRIGHT * bright.max()
        powers = result.mppts.measured_w.T, result.mppts.modelled_w.T
        colours = cycle((BLUE, ORANGE, GREEN, SKY, VERMILLION, PURPLE))
        columns = zip(result.mppts.each, *powers, colours, strict=False)
        for mppt, measured, modelled, colour in columns:
            share = page.smooth(measured) / np.maximum(page.smooth(modelled), 1e-9)
            percent = np.where(bright, 100.0 * share, np.nan)
            page.line(rest[-1], percent, label=mppt.name, color=colour)
        rest[-1].set_ylabel("measured / FM [%]")
    return page.finished([power, error, *rest[with_bearing:]], zero)


class _Page:
    """Panels for samples of a flight, over the hours of its first day, universal time."""

    def __init__(
        self,
        result: Verification,
        count: int,
        what: str,
        mask: BoolArray,
        filter_s: float,
        canvas: drawing.Canvas,
    ) -> None:
        self.figure, self.panels = drawing.new_figure(
            count,
            canvas=canvas,
            title=f"{result.aircraft}, {what}",
            notes=(f"time series averaged over ±{spell(filter_s)} s",),
            size_in=(8.0, 2.3 * count + 0.8),
        )
        self.result, self.filter_s = result, filter_s
        samples, places = result.samples, np.flatnonzero(mask)
        self.chosen = places[:: max(1, len(places) // _MOST_POINTS)]
        midnight_s = float(samples.time_s[places[0]] // SECONDS_PER_DAY * SECONDS_PER_DAY)
        self.midnight_s, self.date = midnight_s, utc_text(midnight_s)[:10]
        self.hours = (samples.time_s - midnight_s) / 3600.0
        # As in the errors, samples that are left out do not enter averages around them.
        self.run = samples.run + np.cumsum(np.abs(np.diff(result.excluded.astype(int), prepend=0)))

    def smooth(self, values: FloatArray) -> FloatArray:
        """Average over the time of the filter."""
        return moving_average(values, self.run, self.result.samples.time_s, self.filter_s)

    def line(self, axes: Axes, values: FloatArray, **style: Any) -> None:
        """Draw a line, broken between uninterrupted stretches."""
        hours, shown = self.hours[self.chosen], values[self.chosen]
        breaks = np.flatnonzero(np.diff(self.run[self.chosen])) + 1
        points = np.insert(hours, breaks, np.nan), np.insert(shown, breaks, np.nan)
        axes.plot(*points, **{"linewidth": 1.0, **style})

    def draw_power(self, axes: Axes) -> None:
        """Draw measured and modelled power."""
        samples = self.result.samples
        for model, modelled in samples.modelled_w.items():
            self.line(axes, self.smooth(modelled), label=model, **drawing.MODEL_LOOKS[model])
        measured = self.smooth(samples.measured_w)
        self.line(axes, measured, label="measured", color=drawing.ink(), linewidth=1.8)
        axes.set_ylabel("solar power [W]")

    def finished(self, by_time: list[Axes], with_zero: list[Axes]) -> Figure:
        """Add lines at zero, hatches on stretches left out, and legends; return the figure."""
        for axes in with_zero:
            axes.axhline(0.0, color=drawing.ink(), linewidth=0.8)
        shown = self.hours[self.chosen]
        first, last = float(shown.min()), float(np.nextafter(shown.max(), np.inf))
        named = set()
        for axes in by_time:
            axes.set_xlabel(f"time of {self.date} [h UTC]")
            for stretch in self.result.left_out:
                label, hatch = _LEFT_OUT[stretch.reason]
                start = (stretch.start_s - self.midnight_s) / 3600.0
                end = (stretch.end_s - self.midnight_s) / 3600.0
                if min(end, last) > max(start, first):
                    axes.axvspan(
                        max(start, first), min(end, last), hatch=hatch, zorder=0.5, linewidth=0.0,
                        facecolor="none", edgecolor=drawing.DARK_GREY,
                        label=None if label in named else label,
                    )  # fmt: skip
                    named.add(label)
            axes.set_xlim(first, last)
        for axes in self.figure.axes:
            if axes.get_legend_handles_labels()[0]:
                axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
        return self.figure


def _draw_bins(axes: Axes, bins: pd.DataFrame, when: str, marker: str) -> None:
    """Draw errors at the middle of each bin, as logged and with the estimates."""
    middle = 0.5 * (bins["low"] + bins["high"])
    for name, style in (("as_logged", _LOGGED), ("estimated", _ESTIMATED)):
        if len(bins) and bins[name].notna().all():
            label = ", ".join(filter(None, (when, name.replace("_", " "))))
            axes.plot(middle, 100.0 * bins[name], marker=marker, label=label, **style)
