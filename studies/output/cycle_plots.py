"""Figures of a cycle and of a flight."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.dates import date_label, day_of_year
from sizing.validity.ranges import model_error_note
from studies.output.figures.drawing import (
    CHARGE,
    CHARGE_LINE,
    LOAD,
    LOAD_LINE,
    SUN,
    SUN_LINE,
    Canvas,
    add_legend,
    ink,
    new_figure,
    shade,
    styled,
)
from studies.output.figures.options import DEFAULT
from studies.render.notes import extrapolation_caption
from studies.render.tables import clock_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from sizing.climb import ClimbPerformance
    from sizing.day.replay import CalendarRun
    from sizing.performance import Performance
    from sizing.results.analysis import Analysis
    from solar.types import FloatArray


_WITH_ERROR = "with that error in solar power"


def _beside(axes: Axes, text: str, place: tuple[float, float], **options: Any) -> None:
    """Write a text a few points beside a place, on the side where there is more room."""
    right = place[0] <= sum(axes.get_xlim()) / 2.0
    sides: dict[str, Any] = {"ha": "left" if right else "right"} | options
    axes.annotate(text, place, (4 if right else -4, 0), textcoords="offset points", **sides)


# ---- The cycle of a day


@styled
def plot_cycle(
    analysis: Analysis, scenario: int | None = None, *, figure: Canvas = DEFAULT
) -> Figure:
    """Draw power and state of charge over the day of a scenario, or over its flight.

    An aircraft that flies perpetually is drawn on its repeated day. One that does not has none: it
    is drawn from the launch of its longest flight until the battery is empty.

    Parameters
    ----------
    analysis : Analysis
        What is drawn; its altitude as well, if it climbs.
    scenario : int, optional
        Number of the scenario, by default that of the worst.
    figure : FigureOptions or Figure
        How the figure looks, or one that is drawn on.

    Returns
    -------
    Figure
    """
    perf = analysis.performance
    index = analysis.worst if scenario is None else scenario
    whole = perf.cycle.perpetual[index] or analysis.mission.flight is not None
    if not whole and np.isfinite(perf.endurance_h[index]):
        return _plot_own_flight(analysis, index, figure)
    drawn, panels = _panels(analysis, index, figure)
    each = (perf, analysis.low, analysis.high)
    full_wh = float(perf.design.battery_energy_wh)
    _draw_curves(
        panels,
        perf.day.time_h,
        [p.solar_power_w[index] for p in each],
        perf.load_w[index],
        [p.cycle.energy_wh[index] / full_wh for p in each],
        _error_label(perf),
    )
    _mark_equal_power(panels[0], perf, index)
    _mark_charge(panels[1], perf, index)
    _add_legend_of(drawn, panels)
    if analysis.climb is not None:
        _draw_altitude(panels[2], analysis.climb, index)
    sunrise, sunset = perf.day.sunrise_h[index], perf.day.sunset_h[index]
    days = round(perf.day.time_h[-1] / 24.0)
    window_h = analysis.mission.flight_window_h(perf.day.scenarios)
    ends_h = (0, 24) if window_h is None else (window_h[0][index], window_h[1][index])
    nights = [
        (24.0 * k + a, 24.0 * k + b)
        for k in range(days)
        for a, b in ((0.0, sunrise), (sunset, 24.0))
    ]
    for axes in panels:
        shade(axes, [(a, b) for a, b in nights if b > a])
    panels[-1].set(xticks=range(0, 24 * days + 1, 2 * days), xlim=ends_h, xlabel="solar time [h]")
    return drawn


def _panels(
    analysis: Analysis, index: int, canvas: Canvas, end: str = ""
) -> tuple[Figure, list[Axes]]:
    """Return a figure with panels for power, charge and, with climbs, altitude of a scenario."""
    count = 2 if analysis.climb is None else 3
    where = f"{analysis.mission.name}, {analysis.performance.day.scenarios.label(index)}"
    return new_figure(
        count,
        canvas=canvas,
        title=f"{analysis.aircraft.name} on {where}{end}",
        notes=(analysis.performance.solar.label, extrapolation_caption(analysis.extrapolations)),
        size_in=(8.0, 2.8 * count),
        sharex=True,
    )


def _error_label(perf: Performance) -> str:
    """Return what the band of the solar power is."""
    after = "of the model" if perf.solar.correction == "none" else "after correction"
    where = model_error_note(perf.mission.altitude_m)
    return f"RMS error {after}{where}, {100 * perf.solar.rms_relative:.0f} %"


def _draw_curves(
    panels: Sequence[Axes],
    time_h: FloatArray,
    solar_w: Sequence[FloatArray],
    load_w: FloatArray,
    charge: Sequence[FloatArray],
    error: str = "",
) -> None:
    """Draw solar power, load and state of charge over time.

    ``solar_w``, ``charge``: as modelled, then with the model's error less and more, where bands of
    these are drawn.
    """
    curves = (
        (panels[0], solar_w, SUN, SUN_LINE, "solar power", error),
        (
            panels[1],
            [100.0 * v for v in charge],
            CHARGE,
            CHARGE_LINE,
            "state of charge",
            _WITH_ERROR,
        ),
    )
    for axes, (nominal, *ends), colour, line, label, band in curves:
        axes.plot(time_h, nominal, line, color=colour, label=label)
        if ends:
            low, high = ends
            axes.fill_between(time_h, low, high, color=colour, alpha=0.2, linewidth=0, label=band)
    panels[0].plot(time_h, load_w, LOAD_LINE, color=LOAD, label="load")
    panels[0].set(ylabel="power [W]", ylim=(0, None))
    panels[1].set(ylabel="state of charge [%]", ylim=(0, 105))


def _add_legend_of(figure: Figure, panels: Sequence[Axes]) -> None:
    """Write the legend below the axes, a column for each curve and its band."""
    power, charge = (axes.get_legend_handles_labels()[0] for axes in panels[:2])
    add_legend(figure, [*power[:2], *charge, *power[2:]], 3)


def _mark_equal_power(axes: Axes, perf: Performance, index: int) -> None:
    """Mark the instants at which solar power equals the load."""
    for name, hour, side in (
        (r"$t_\mathrm{eq}$", perf.cycle.equal_power_morning_h[index], "right"),
        (r"$t_\mathrm{eq,2}$", perf.cycle.equal_power_evening_h[index], "left"),
    ):
        if np.isfinite(hour):
            level = float(np.interp(hour, perf.day.time_h, perf.load_w[index]))
            axes.plot([hour], [level], "o", color=ink(), markersize=4)
            shift = -4 if side == "right" else 4
            axes.annotate(name, (hour, level), (shift, 6), textcoords="offset points", ha=side)


def _mark_charge(axes: Axes, perf: Performance, index: int) -> None:
    """Mark the first full charge, the charge margin and the excess time."""
    full = perf.cycle.full_charge_h[index]
    if np.isfinite(full):
        axes.axvline(full, color=ink(), linestyle=":", linewidth=1)
        _beside(axes, "full", (full, 30))
        _draw_margin(axes, float(full), float(perf.cycle.charge_margin_h[index]))
    _draw_excess(axes, perf, index)
    axes.set(ylim=(-36, 105), yticks=range(0, 101, 20))


def _draw_excess(axes: Axes, perf: Performance, index: int) -> None:
    """Draw the interval of the excess time, from equal power in the morning on."""
    excess = float(perf.cycle.excess_time_h[index])
    if not np.isfinite(excess):
        return
    dawn = float(perf.cycle.equal_power_morning_h[index])
    text = f"excess time {excess:.1f} h".replace("-", "−")
    if not np.isfinite(dawn):
        _beside(axes, text, (12.0, -18), ha="center")
        return
    end = min(max(dawn + excess, 0.0), 24.0)
    if excess > 0.0:
        lowest = 100.0 * float(perf.cycle.minimum_state_of_charge[index])
        at_end = lowest * (1.0 - (end - dawn) / excess)
        axes.plot([dawn, end], [lowest, at_end], ":", color=CHARGE, linewidth=1.0)
    _draw_interval(axes, dawn, end, -5.0, text, below=True)


def _draw_altitude(axes: Axes, climbs: ClimbPerformance, index: int) -> None:
    altitude_m = climbs.altitude_m[index]
    axes.plot(climbs.performance.day.time_h, altitude_m, color=LOAD)
    # Zero added: what rounds to -0 is no loss.
    gain = f"{round(float(climbs.gain_in_excess_time_h[index]), 1) + 0.0:+.1f}".replace("-", "−")
    axes.annotate(
        f"highest {altitude_m.max():.0f} m\nexcess time\n{gain} h by climbing",
        (0.0, 1.0),
        (4, -4),
        xycoords="axes fraction",
        textcoords="offset points",
        va="top",
    )
    _set_altitudes(axes, altitude_m)


def _set_altitudes(axes: Axes, altitude_m: FloatArray) -> None:
    lowest, top = float(altitude_m.min()), float(altitude_m.max())
    margin = max(0.1 * (top - lowest), 50.0)
    axes.set(ylabel="altitude [m]", ylim=(lowest - margin, top + margin))


def _draw_margin(axes: Axes, full_h: float, margin_h: float) -> None:
    """Draw the interval of the charge margin; a short one gets a text alone."""
    text = f"charge margin {margin_h:.1f} h"
    if margin_h < 2.0:
        _beside(axes, text, (full_h, 62))
        return
    _draw_interval(axes, full_h, full_h + margin_h, 60.0, text)


def _draw_interval(
    axes: Axes, start_h: float, end_h: float, level: float, text: str, *, below: bool = False
) -> None:
    """Draw an arrow over an interval of time, and what it is."""
    arrow = {"arrowstyle": "<->", "color": ink(), "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (end_h, level), (start_h, level), arrowprops=arrow)
    middle = (start_h + end_h) / 2.0
    shift, side = (-3, "top") if below else (3, "bottom")
    axes.annotate(
        text, (middle, level), (0, shift), textcoords="offset points", ha="center", va=side
    )


# ---- A flight that ends

_MOST_DAYS = 12  # labels along the axis of a long flight


def _plot_own_flight(analysis: Analysis, index: int, canvas: Canvas) -> Figure:
    """Draw the longest flight from its launch to the empty battery."""
    perf = analysis.performance
    longest = perf.endurances
    hours, launch = float(longest.endurance_h[index]), float(longest.launch_h[index])
    end = launch + hours
    drawn, panels = _panels(analysis, index, canvas, f": limited, {hours:.1f} h")
    each = [p.course(index, launch, hours) for p in (perf, analysis.low, analysis.high)]
    clock_h, altitude_m = each[0].clock_h, each[0].altitude_m
    _draw_curves(
        panels,
        clock_h,
        [np.interp(clock_h, course.clock_h, course.solar_power_w) for course in each],
        each[0].load_w,
        [np.interp(clock_h, course.clock_h, course.state_of_charge) for course in each],
        _error_label(perf),
    )
    sunrise, sunset = (float(v[index]) for v in (perf.day.sunrise_h, perf.day.sunset_h))
    if sunset > sunrise:
        nights = [(sunset + 24.0 * day, sunrise + 24.0 * (day + 1)) for day in range(-2, 367)]
    else:
        nights = [(launch, end)]
    shown = [(max(a, launch), min(b, end)) for a, b in nights if a < end and b > launch]
    for axes in panels:
        shade(axes, shown)
    for axes in panels[2:]:
        axes.plot(clock_h, altitude_m, color=LOAD)
        _set_altitudes(axes, altitude_m)
    panels[1].plot([end], [0.0], "o", color=ink(), markersize=4, clip_on=False, label="empty")
    panels[1].set(xlim=(launch, end))
    _label_clock(panels[-1], (launch, end), lambda day: f"day {day + 1}")
    panels[-1].set_xlabel(f"solar time, launched with a full battery at {clock_label(launch)}")
    _add_legend_of(drawn, panels)
    return drawn


# ---- A flight on the calendar


@styled
def plot_flight(analysis: Analysis, flight: CalendarRun, *, figure: Canvas = DEFAULT) -> Figure:
    """Draw power and state of charge of a replayed flight over local time.

    Parameters
    ----------
    analysis : Analysis
        Aircraft, mission and solar model, for the title.
    flight : CalendarRun
        The flight.
    figure : FigureOptions or Figure
        How the figure looks, or one that is drawn on.

    Returns
    -------
    Figure
    """
    drawn, panels = new_figure(
        2,
        canvas=figure,
        title=f"{analysis.aircraft.name} on {analysis.mission.name}",
        notes=(analysis.performance.solar.label, extrapolation_caption(analysis.extrapolations)),
        size_in=(9.0, 5.6),
        sharex=True,
    )
    _draw_curves(
        panels, flight.clock_h, [flight.solar_power_w], flight.load_w, [flight.state_of_charge]
    )
    add_legend(drawn, panels[0].get_legend_handles_labels()[0], 2)
    charge_axes = panels[1]
    for hour in flight.full_charge_clock_h:
        charge_axes.axvline(hour, color=ink(), linestyle=":", linewidth=1)
        _beside(charge_axes, "full", (hour, 50))
    dark = np.flatnonzero(np.diff(np.concatenate(([0], flight.solar_power_w <= 0.0, [0]))))
    nights = flight.clock_h[dark.reshape(-1, 2) - (0, 1)]
    for axes in panels:
        shade(axes, nights)
    first_day = day_of_year(flight.launch.date)
    ends = float(flight.clock_h[0]), float(flight.clock_h[-1])
    _label_clock(charge_axes, ends, lambda day: date_label((first_day + day - 1) % 365 + 1))
    charge_axes.set_xlabel(f"local time, launched on {date_label(first_day)}")
    charge_axes.set(xlim=ends)
    return drawn


def _label_clock(axes: Axes, ends: tuple[float, float], day_label: Callable[[int], str]) -> None:
    """Write the clock along the axis, and the day at midnight, counted from 0."""
    first, last = ends
    step = next((s for s in (3, 6, 12) if last - first <= 12 * s), 24)
    ticks = range(step * math.ceil(first / step), math.floor(last) + 1, step)
    if len(ticks) > _MOST_DAYS:
        ticks = ticks[:: math.ceil(len(ticks) / _MOST_DAYS)]
    labels = [
        f"{tick % 24:02d}:00" if tick % 24 else f"00:00\n{day_label(tick // 24)}" for tick in ticks
    ]
    axes.set_xticks(ticks, labels)
