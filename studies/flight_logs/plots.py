"""Figures of a verification after those of Oettershagen's report: details of a window, a day.

Time is universal time, as the log has it; solar time stands above.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from solar.names import ModelName
from solar.sun import SECONDS_PER_DAY
from solar.types import BoolArray, FloatArray, IntArray
from studies.flight_logs.errors import Section, day_masks, moving_average
from studies.flight_logs.log_view import Kind
from studies.flight_logs.samples import Detail, Samples
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
# More points than this are not told apart on a page.
_MOST_POINTS = 4000


@dataclass(frozen=True)
class _View:
    """What one figure shows: samples of one window or day, filtered, over universal time.

    ``hours`` counts on across midnight from that of ``date``, solar time is ``solar_ahead_h`` more;
    ``raw`` are the samples as they were logged. ``gaps`` are where samples are missing that the sun
    would have lit, ``faults`` what looks wrong, by kind.
    """

    date: str
    solar_ahead_h: float

    hours: FloatArray
    run: IntArray
    measured: FloatArray
    modelled: dict[ModelName, FloatArray]
    angles: list[tuple[str, FloatArray]]
    yaw_deg: FloatArray | None
    detail: Detail | None
    raw_shaded_m2: FloatArray | None
    raw_volts: FloatArray | None
    excluded: BoolArray
    gaps: list[tuple[float, float]]
    faults: dict[Kind, list[tuple[float, float]]]


Draw: TypeAlias = "Callable[[Axes, _View], None]"


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


def _gaps(result: Verification, mask: BoolArray, midnight_s: float) -> list[tuple[float, float]]:
    """Spans without samples between those of the mask, night apart: nothing is known of them."""
    samples = result.samples
    time_s, runs = samples.time_s[mask], samples.run[mask]
    at = np.flatnonzero(np.diff(runs))
    log_s = result.log.time_s
    gaps = []
    for start, end in zip(time_s[at], time_s[at + 1], strict=True):
        between = np.count_nonzero((log_s > start) & (log_s < end))
        if between * result.log.step_s < 0.5 * (end - start):  # else the log goes on in the dark
            gaps.append(((start - midnight_s) / 3600.0, (end - midnight_s) / 3600.0))
    return gaps


def _faults(
    result: Verification, hours: FloatArray, midnight_s: float
) -> dict[Kind, list[tuple[float, float]]]:
    """What looks wrong in the hours that are shown, by its kind."""
    spans: dict[Kind, list[tuple[float, float]]] = {}
    for one in result.anomalies:
        start, end = ((t - midnight_s) / 3600.0 for t in (one.start_s, one.end_s))
        start, end = max(start, float(hours.min())), min(end, float(hours.max()))
        if one.kind != "missing_data" and end > start:
            spans.setdefault(one.kind, []).append((start, end))
    return spans


def _view(result: Verification, mask: BoolArray, filter_s: float, *, attitude: bool) -> _View:
    samples, log = result.samples, result.log
    stride = max(1, int(mask.sum()) // _MOST_POINTS)
    chosen = np.flatnonzero(mask)[::stride]
    # As in the errors, limited power does not leak into the averages beside it.
    limits = np.cumsum(np.abs(np.diff(result.excluded.astype(int), prepend=0)))
    run = samples.run + limits

    def shown(values: FloatArray) -> FloatArray:
        return moving_average(values, run, samples.time_s, filter_s)[chosen]

    angles, yaw = [], None
    if attitude and log.attitude is not None:
        roll, pitch, heading = (np.degrees(a[samples.index]) for a in log.attitude)
        angles = [("roll", shown(roll)), ("pitch", shown(pitch))]
        yaw = heading[chosen] % 360.0  # not averaged: across north the mean would point south
    detail = None
    if samples.detail is not None:
        detail = samples.detail.mapped(lambda _, values: shown(values))
    shaded = None if samples.detail is None else samples.detail.shaded_m2
    volts = log.mppt_voltage_v
    hours, midnight_s = _hours(samples, mask)
    solar_h = samples.time_solar_h[mask] + 24.0 * samples.solar_day[mask]
    ahead = solar_h - hours - midnight_s / 3600.0
    return _View(
        date=str(np.datetime64(int(midnight_s), "s").astype("datetime64[D]")),
        solar_ahead_h=float(np.median(ahead)),
        hours=hours[::stride],
        run=run[chosen],
        measured=shown(samples.measured_w),
        modelled={m: shown(power) for m, power in samples.modelled_w.items()},
        angles=angles,
        yaw_deg=yaw,
        detail=detail,
        raw_shaded_m2=None if shaded is None else shaded[chosen],
        raw_volts=None if volts is None else volts[samples.index][chosen],
        excluded=result.excluded[chosen],
        gaps=_gaps(result, mask, midnight_s),
        faults=_faults(result, hours, midnight_s),
    )


def _figure(
    result: Verification,
    section: Section,
    view: _View,
    patches: list[tuple[float, float]],
    canvas: Canvas,
) -> Figure:
    rows = _rows(view)
    heights = [2.0 if draw is _draw_power else 1.2 for draw in rows]
    figure, every = new_figure(
        len(rows),
        canvas=canvas,
        title=f"{result.aircraft}, {section.label}: models against flight",
        notes=(f"average over ±{section.filter_s:g} s",),
        size_in=(8.0, 1.4 * sum(heights) + 0.8),
        sharex=True,
        height_ratios=heights,
    )
    edges = np.flatnonzero(np.diff(np.concatenate(([0], view.excluded.astype(int), [0]))))
    excluded = view.hours[edges.reshape(-1, 2) - (0, 1)]
    for axes, draw in zip(every, rows, strict=True):
        draw(axes, view)
        named = draw is _draw_power
        shade(axes, patches, "window" if named else None)
        shade(axes, excluded, "excluded" if named else None, color=LIMITED, alpha=0.3)
        _mark_faults(axes, view, named=named)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    every[-1].set_xlabel(f"time of {view.date} [h UTC]")
    every[-1].set_xlim(float(view.hours.min()), float(np.nextafter(view.hours.max(), np.inf)))
    ahead = view.solar_ahead_h
    top = every[0].secondary_xaxis("top", functions=(_shift(ahead), _shift(-ahead)))
    top.set_xlabel("solar time [h]")
    return figure


def _shift(hours: float) -> Callable[[Any], Any]:
    return lambda time_h: time_h + hours


def _mark_faults(axes: Axes, view: _View, *, named: bool) -> None:
    """Hatch what looks wrong, a hatch for each kind, and where there are no samples."""
    marked = dict(view.faults)
    if view.gaps:
        marked["missing_data"] = view.gaps
    for kind, spans in marked.items():
        label, hatch = _FAULTS[kind]
        style: dict[str, Any] = {"facecolor": "none", "edgecolor": DARK_GREY, "hatch": hatch}
        for number, (start, end) in enumerate(spans):
            name = label if named and number == 0 else None
            axes.axvspan(start, end, zorder=0.5, linewidth=0.0, label=name, **style)


def _rows(view: _View) -> list[Draw]:
    rows: list[Draw] = [_draw_power, _draw_residuals]
    if view.angles or view.detail is not None:
        rows.append(_draw_angles)
    if view.yaw_deg is not None:
        rows.append(_draw_yaw)
    if view.detail is not None:
        rows.append(_draw_efficiencies)
    if view.raw_shaded_m2 is not None:
        rows.append(_draw_shade)
    if view.raw_volts is not None:
        rows.append(_draw_voltage)
    return rows


def _line(
    axes: Axes,
    view: _View,
    values: FloatArray,
    *,
    color: str,
    label: str,
    linestyle: Any = "-",
    linewidth: float = 1.0,
) -> None:
    """Draw a line that is broken where samples are missing."""
    points = broken_line(view.run, view.hours, values)
    axes.plot(*points, linewidth=linewidth, color=color, linestyle=linestyle, label=label)


def broken_line(
    run: IntArray, hours: FloatArray, values: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Points of a line that is broken between uninterrupted stretches."""
    breaks = np.flatnonzero(np.diff(run)) + 1
    return np.insert(hours, breaks, np.nan), np.insert(np.asarray(values, float), breaks, np.nan)


def _draw_power(axes: Axes, view: _View) -> None:
    for model, power in view.modelled.items():
        _line(
            axes, view, power,
            color=MODEL_COLOURS[model], linestyle=MODEL_LINES[model], label=model,
        )  # fmt: skip
    _line(axes, view, view.measured, color=ink(), label="measured", linewidth=_MEASURED_WIDTH)
    axes.set_ylabel("solar power [W]")


def _draw_residuals(axes: Axes, view: _View) -> None:
    for model, power in view.modelled.items():
        _line(
            axes, view, power - view.measured,
            color=MODEL_COLOURS[model], linestyle=MODEL_LINES[model], label=f"_{model}",
        )  # fmt: skip
    axes.axhline(0.0, color=ink(), linewidth=0.8)
    axes.set_ylabel("model − measured [W]")


def _draw_angles(axes: Axes, view: _View) -> None:
    for (name, values), colour, dashes in zip(view.angles, (GREEN, SKY), ("-", "--"), strict=False):
        _line(axes, view, values, color=colour, linestyle=dashes, label=name)
    if view.detail is not None:
        angle = view.detail.incidence_deg
        _line(axes, view, angle, color=VERMILLION, linestyle=":", label="incidence")
    axes.set_ylabel("angle [deg]")


def _draw_yaw(axes: Axes, view: _View) -> None:
    assert view.yaw_deg is not None  # a row of figures of a window with attitude
    axes.plot(view.hours, view.yaw_deg, ".", color="grey", markersize=2, label="yaw")
    axes.set(ylabel="angle [deg]", ylim=(0, 360), yticks=(0, 90, 180, 270, 360))


def _draw_efficiencies(axes: Axes, view: _View) -> None:
    detail = view.detail
    assert detail is not None  # a row of figures with a Full Model
    for values, label, colour, dashes in (
        (detail.incidence_efficiency, "incidence", ORANGE, ":"),
        (detail.low_light_efficiency, "low light", SKY, "-."),
        (detail.temperature_efficiency, "temperature", GREEN, (0, (6, 1, 1, 1, 1, 1))),
        (detail.mppt_efficiency, "MPPT", BLUE, "--"),
        (detail.module_efficiency, "module", VERMILLION, "-"),
    ):
        _line(axes, view, 100.0 * values, color=colour, linestyle=dashes, label=label)
    axes.set_ylabel("efficiency [%]")


def _draw_shade(axes: Axes, view: _View) -> None:
    assert view.raw_shaded_m2 is not None  # a row of figures with a tail
    _line(axes, view, 1e4 * view.raw_shaded_m2, color=LOGGED, label="modelled")
    axes.set_ylabel("shaded [cm²]")
    top = max(1.0, 1.05e4 * float(np.nanmax(view.raw_shaded_m2, initial=0.0)))
    axes.set_ylim(-0.03 * top, top)  # a line at zero stays visible


def _draw_voltage(axes: Axes, view: _View) -> None:
    assert view.raw_volts is not None  # a row of figures with a voltage
    _line(axes, view, view.raw_volts, color=LOGGED, label="MPPT")
    axes.set_ylabel("voltage [V]")
