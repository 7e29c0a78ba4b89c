"""Figures of a verification after those of Oettershagen's report: details of a window, a day.

Time is universal time, as the log has it; solar time stands above.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from solar.sun import SECONDS_PER_DAY
from solar.types import BoolArray, FloatArray, IntArray
from studies.flight_logs.errors import Section, day_masks, moving_average
from studies.flight_logs.log_view import Kind
from studies.flight_logs.samples import Samples
from studies.flight_logs.verification import Verification
from studies.output.figures.drawing import (
    BLUE,
    DARK_GREY,
    GREEN,
    MODEL_COLOURS,
    MODEL_LINES,
    ORANGE,
    SKY,
    VERMILLION,
    YELLOW,
    Canvas,
    ink,
    new_figure,
    shade,
    styled,
)
from studies.output.figures.options import DEFAULT, FigureOptions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOGGED, LIMITED = BLUE, YELLOW
_MEASURED_WIDTH = 1.8  # wider than the models'
# Kind of what looks wrong -> its words and hatch.
_FAULTS: dict[Kind, tuple[str, str]] = {
    "mppt_not_tracking": ("MPPT does not track", "xx"),
    "power_loss": ("no power", "oo"),
    "modules_missing": ("modules missing", ".."),
    "cloud": ("cloud", "--"),
    "shading": ("shading", "++"),
    "battery_full": ("battery full", "\\\\\\"),
    "frozen_channel": ("channel frozen", "||"),
    "missing_data": ("no data", "///"),
}
_POWER = "solar power [W]"  # the highest panel
# More points than this are not told apart on a page.
_MOST_POINTS = 4000


class _Row(NamedTuple):
    """One of the panels: label, values and style of each line, whether zero is marked, limits."""

    label: str
    lines: list[tuple[str, FloatArray, dict[str, Any]]]
    zero: bool = False
    limits: Mapping[str, Any] = {}


class _View(NamedTuple):
    """What one figure shows: samples of one window or day, filtered, over universal time.

    ``hours`` counts on across midnight from that of ``date``, solar time is ``solar_ahead_h`` more.
    ``faults``: what looks wrong by kind, and where samples are missing that the sun would have lit.
    """

    date: str
    solar_ahead_h: float
    hours: FloatArray
    run: IntArray
    rows: list[_Row]
    excluded: BoolArray
    faults: dict[Kind, list[tuple[float, float]]]


def figures(
    result: Verification, *, figure: FigureOptions = DEFAULT
) -> Iterator[tuple[str, Callable[[], Figure]]]:
    """Functions that draw all windows and days, each with a name for its file."""
    for number in range(len(result.windows)):
        yield f"window-{number + 1}", partial(window_figure, result, number, figure=figure)
    for section, (date, mask) in zip(result.days, day_masks(result.samples), strict=True):
        yield f"day-{date}", partial(day_figure, result, section, mask, figure=figure)


@styled
def window_figure(result: Verification, number: int, *, figure: Canvas = DEFAULT) -> Figure:
    """Power, attitude, efficiencies, shade and MPPT voltage in one window."""
    section = result.windows[number]
    view = _view(result, result.window_masks[number], result.window_filter_s, attitude=True)
    return _figure(result, section, view, [], figure)


@styled
def day_figure(
    result: Verification, section: Section, mask: BoolArray, *, figure: Canvas = DEFAULT
) -> Figure:
    """The same over a day (UTC), the windows as grey patches."""
    view = _view(result, mask, result.day_filter_s, attitude=False)
    hours, _ = _hours(result.samples, mask)
    inside = [hours[window[mask]] for window in result.window_masks]
    patches = [(float(h.min()), float(h.max())) for h in inside if len(h)]
    return _figure(result, section, view, patches, figure)


def _hours(samples: Samples, mask: BoolArray) -> tuple[FloatArray, float]:
    """Universal time [h] since midnight of the mask's first day, and that midnight [s]."""
    time_s = samples.time_s[mask]
    midnight_s = float(time_s.min() // SECONDS_PER_DAY * SECONDS_PER_DAY)
    return np.asarray((time_s - midnight_s) / 3600.0), midnight_s


def _faults(
    result: Verification, mask: BoolArray, hours: FloatArray, midnight_s: float
) -> dict[Kind, list[tuple[float, float]]]:
    """What looks wrong in the hours that are shown, and where samples are missing, by its kind."""
    spans: dict[Kind, list[tuple[float, float]]] = {}
    for one in result.anomalies:
        start, end = ((t - midnight_s) / 3600.0 for t in (one.start_s, one.end_s))
        start, end = max(start, float(hours.min())), min(end, float(hours.max()))
        if one.kind != "missing_data" and end > start:
            spans.setdefault(one.kind, []).append((start, end))
    time_s, log_s = result.samples.time_s[mask], result.log.time_s
    for at in np.flatnonzero(np.diff(result.samples.run[mask])).tolist():
        between = np.count_nonzero((log_s > time_s[at]) & (log_s < time_s[at + 1]))
        # Where it holds more samples, the log goes on in the dark.
        if between * result.log.step_s < 0.5 * (time_s[at + 1] - time_s[at]):
            spans.setdefault("missing_data", []).append((hours[at], hours[at + 1]))
    return spans


def _view(result: Verification, mask: BoolArray, filter_s: float, *, attitude: bool) -> _View:
    samples = result.samples
    stride = max(1, int(mask.sum()) // _MOST_POINTS)
    chosen = np.flatnonzero(mask)[::stride]
    # As in the errors, limited power does not leak into the averages beside it.
    limits = np.cumsum(np.abs(np.diff(result.excluded.astype(int), prepend=0)))
    run = samples.run + limits

    def shown(values: FloatArray) -> FloatArray:
        return moving_average(values, run, samples.time_s, filter_s)[chosen]

    hours, midnight_s = _hours(samples, mask)
    solar_h = samples.time_solar_h[mask] + 24.0 * samples.solar_day[mask]
    return _View(
        date=str(np.datetime64(int(midnight_s), "s").astype("datetime64[D]")),
        solar_ahead_h=float(np.median(solar_h - hours - midnight_s / 3600.0)),
        hours=hours[::stride],
        run=run[chosen],
        rows=list(_rows(result, chosen, shown, attitude=attitude)),
        excluded=result.excluded[chosen],
        faults=_faults(result, mask, hours, midnight_s),
    )


def _rows(
    result: Verification,
    chosen: IntArray,
    shown: Callable[[FloatArray], FloatArray],
    *,
    attitude: bool,
) -> Iterator[_Row]:
    """Panels of a figure: ``shown`` averages what is drawn of the samples that are ``chosen``."""
    samples, log, detail = result.samples, result.log, result.samples.detail
    measured = shown(samples.measured_w)
    models = [
        (m, shown(power), {"color": MODEL_COLOURS[m], "linestyle": MODEL_LINES[m]})
        for m, power in samples.modelled_w.items()
    ]
    flown = ("measured", measured, {"color": ink(), "linewidth": _MEASURED_WIDTH})
    yield _Row(_POWER, [*models, flown])
    left = [(f"_{m}", power - measured, style) for m, power, style in models]
    yield _Row("model − measured [W]", left, zero=True)
    attitude &= log.attitude is not None
    angles: list[tuple[str, FloatArray, dict[str, Any]]] = []
    yaw = np.zeros(0)
    if attitude and log.attitude is not None:
        roll, pitch, yaw = (np.degrees(angle[samples.index]) for angle in log.attitude)
        angles = [
            ("roll", shown(roll), {"color": GREEN}),
            ("pitch", shown(pitch), {"color": SKY, "linestyle": "--"}),
        ]
    if detail is not None:
        style = {"color": VERMILLION, "linestyle": ":"}
        angles.append(("incidence", shown(detail.incidence_deg), style))
    if angles:
        yield _Row("angle [deg]", angles)
    if attitude:  # not averaged: across north the mean would point south
        dots = {"color": "grey", "linestyle": "none", "marker": ".", "markersize": 2}
        compass = {"ylim": (0, 360), "yticks": (0, 90, 180, 270, 360)}
        yield _Row("angle [deg]", [("yaw", yaw[chosen] % 360.0, dots)], limits=compass)
    if detail is not None:
        every = (
            ("incidence", detail.incidence_efficiency, ORANGE, ":"),
            ("low light", detail.low_light_efficiency, SKY, "-."),
            ("temperature", detail.temperature_efficiency, GREEN, (0, (6, 1, 1, 1, 1, 1))),
            ("MPPT", detail.mppt_efficiency, BLUE, "--"),
            ("module", detail.module_efficiency, VERMILLION, "-"),
        )
        drawn = [
            (label, 100.0 * shown(values), {"color": colour, "linestyle": dashes})
            for label, values, colour, dashes in every
        ]
        yield _Row("efficiency [%]", drawn)
    if detail is not None and detail.shaded_m2 is not None:
        shaded = 1e4 * detail.shaded_m2[chosen]
        top = max(1.0, 1.05 * float(np.nanmax(shaded, initial=0.0)))
        limits = {"ylim": (-0.03 * top, top)}  # a line at zero stays visible
        yield _Row("shaded [cm²]", [("modelled", shaded, {"color": LOGGED})], limits=limits)
    if log.mppt_voltage_v is not None:
        volts = log.mppt_voltage_v[samples.index][chosen]
        yield _Row("voltage [V]", [("MPPT", volts, {"color": LOGGED})])


def _figure(
    result: Verification,
    section: Section,
    view: _View,
    patches: list[tuple[float, float]],
    canvas: Canvas,
) -> Figure:
    heights = [2.0 if row.label == _POWER else 1.2 for row in view.rows]
    figure, every = new_figure(
        len(heights),
        canvas=canvas,
        title=f"{result.aircraft}, {section.label}: models against flight",
        notes=(f"average over ±{section.filter_s:g} s",),
        size_in=(8.0, 1.4 * sum(heights) + 0.8),
        sharex=True,
        height_ratios=heights,
    )
    edges = np.flatnonzero(np.diff(np.concatenate(([0], view.excluded.astype(int), [0]))))
    excluded = view.hours[edges.reshape(-1, 2) - (0, 1)]
    for axes, row in zip(every, view.rows, strict=True):
        for label, values, style in row.lines:
            points = broken_line(view.run, view.hours, values)
            axes.plot(*points, label=label, **{"linewidth": 1.0, **style})
        if row.zero:
            axes.axhline(0.0, color=ink(), linewidth=0.8)
        axes.set(ylabel=row.label, **row.limits)
        named = row.label == _POWER
        shade(axes, patches, "window" if named else None)
        shade(axes, excluded, "excluded" if named else None, color=LIMITED, alpha=0.3)
        _mark_faults(axes, view, named=named)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    every[-1].set_xlabel(f"time of {view.date} [h UTC]")
    every[-1].set_xlim(float(view.hours.min()), float(np.nextafter(view.hours.max(), np.inf)))
    ahead = view.solar_ahead_h
    shifts = (lambda time_h: time_h + ahead, lambda time_h: time_h - ahead)
    top = every[0].secondary_xaxis("top", functions=shifts)
    top.set_xlabel("solar time [h]")
    return figure


def _mark_faults(axes: Axes, view: _View, *, named: bool) -> None:
    """Hatch what looks wrong, a hatch for each kind, and where there are no samples."""
    for kind, spans in view.faults.items():
        label, hatch = _FAULTS[kind]
        style: dict[str, Any] = {"facecolor": "none", "edgecolor": DARK_GREY, "hatch": hatch}
        for number, (start, end) in enumerate(spans):
            name = label if named and number == 0 else None
            axes.axvspan(start, end, zorder=0.5, linewidth=0.0, label=name, **style)


def broken_line(
    run: IntArray, hours: FloatArray, values: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Points of a line that is broken between uninterrupted stretches."""
    breaks = np.flatnonzero(np.diff(run)) + 1
    return np.insert(hours, breaks, np.nan), np.insert(np.asarray(values, float), breaks, np.nan)
