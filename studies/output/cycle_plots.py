"""Figures of a cycle and of a flight."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.dates import date_label, day_of_year
from missions.weather.record import runs_of
from sizing.day.flight import Course
from sizing.validity.ranges import model_error_note
from studies.output.figures import drawing
from studies.output.figures.options import DEFAULT
from studies.render.tables import clock_label
from studies.render.words import amount, extrapolation_caption, percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from sizing.day.replay import CalendarRun
    from sizing.performance import Performance
    from sizing.results.analysis import Analysis


_EXCESS_PERCENT, _MARGIN_PERCENT = -10.0, 110.0  # of charge, where these intervals are drawn
_NIGHTS = range(-2, 367)  # of the longest flight


def panel_count(analysis: Analysis) -> int:
    """Return the number of axes of a cycle: power, charge and, with climbs, altitude."""
    return 2 + ("altitude_m" in analysis.curves)


def _draw(
    analysis: Analysis,
    flights: Sequence[Course | CalendarRun],
    *,
    canvas: drawing.Canvas,
    ends_h: tuple[float, float],
    nights_h: Sequence[tuple[float, float]],
    day_label: Callable[[int], str],
    end: str = "",
) -> tuple[Figure, list[Axes]]:
    """Draw solar power, load, state of charge and, with climbs, altitude over the clock.

    ``flights``: as modelled, then with the model's error less and more, where bands are drawn.
    ``end``: of the title. ``day_label``: of the midnight that a day begins with, by its number.
    """
    perf, flight, count = analysis.performance, flights[0], panel_count(analysis)
    drawn, panels = drawing.new_figure(
        count,
        canvas=canvas,
        title=f"{analysis.aircraft.name} on {analysis.mission.name}{end}",
        notes=(perf.solar.label, extrapolation_caption(analysis.extrapolations)),
        size_in=(8.0, 2.8 * count),
        sharex=True,
    )
    after = "of the model" if perf.solar.correction == "none" else "after correction"
    where = model_error_note(perf.mission.altitude_m)
    error = f"RMS error {after}{where}, {percent(perf.solar.rms_relative, '.0f')}"
    clock_h = flight.clock_h
    for axes, name, scale, colour, label, band in (
        (panels[0], "solar_power_w", 1.0, drawing.SUN, "solar power", error),
        (panels[1], "state_of_charge", 100.0, drawing.CHARGE, "state of charge", "with that error"),
    ):
        curve, *ends = (
            scale * np.interp(clock_h, each.clock_h, getattr(each, name)) for each in flights
        )
        axes.plot(clock_h, curve, "-", color=colour, label=label)
        if ends:
            axes.fill_between(clock_h, *ends, color=colour, alpha=0.2, linewidth=0, label=band)
    # Dashes tell it from the sun in a print in grey, too.
    panels[0].plot(clock_h, flight.load_w, "--", color=drawing.LOAD, label="load")
    panels[0].set(ylabel="power [W]", ylim=(0, None))
    panels[1].set(ylabel="charge [%]", ylim=(0, 105), yticks=(0, 50, 100))
    for axes in panels[2:]:
        assert isinstance(flight, Course)
        axes.plot(clock_h, flight.altitude_m, color=drawing.LOAD)
        axes.margins(y=0.1)
        axes.set(ylabel="altitude [m]")
    first, last = ends_h
    nights = [(max(dusk, first), min(dawn, last)) for dusk, dawn in nights_h]
    for axes in panels:
        drawing.shade(axes, [(dusk, dawn) for dusk, dawn in nights if dusk < dawn])
    most = 4 if drawing.is_narrow(drawn, (0.0, 0.0)) else 8  # labels along the clock
    step = 3 * 2 ** max(math.ceil(math.log2((last - first) / (3 * most))), 0)
    ticks = range(step * math.ceil(first / step), math.floor(last) + 1, step)
    days = [day_label(tick // 24 + 1) if tick % 24 == 0 else "" for tick in ticks]
    labels = [f"{tick % 24:02d}:00\n{day}".strip() for tick, day in zip(ticks, days, strict=True)]
    panels[-1].set_xticks(ticks, labels)
    panels[-1].set(xlim=ends_h, xlabel="solar time")
    return drawn, panels


def _add_legend(figure: Figure, panels: Sequence[Axes]) -> Figure:
    """Write the legend below the axes, a column for each curve and its band."""
    power, charge = (axes.get_legend_handles_labels()[0] for axes in panels[:2])
    drawing.add_legend(figure, [*power[:2], *charge, *power[2:]], 3)
    return figure


@drawing.styled
def plot_cycle(
    analysis: Analysis, scenario: int | None = None, *, figure: drawing.Canvas = DEFAULT
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
    """
    perf = analysis.performance
    index = analysis.worst if scenario is None else scenario
    every, where = (perf, analysis.low, analysis.high), perf.day.scenarios.label(index)
    sunrise, sunset = (float(v[index]) for v in (perf.day.sunrise_h, perf.day.sunset_h))
    nights_h = [(sunset + 24.0 * day, sunrise + 24.0 * (day + 1)) for day in _NIGHTS]
    draw = partial(_draw, analysis, canvas=figure, nights_h=nights_h)
    whole = perf.cycle.perpetual[index] or analysis.mission.flight is not None
    if not whole and np.isfinite(perf.endurance_h[index]):
        longest = perf.endurances
        hours, launch = float(longest.endurance_h[index]), float(longest.launch_h[index])
        drawn, panels = draw(
            [each.course(index, launch, hours) for each in every],
            ends_h=(launch, launch + hours),
            day_label="day {}".format,
            end=f", {where}: limited, {amount(hours, 'h', '.1f')}",
        )
        looks: dict[str, Any] = {"color": drawing.ink(), "markersize": 4, "clip_on": False}
        panels[1].plot([launch + hours], [0.0], "o", label="empty", **looks)
        panels[-1].set_xlabel(f"solar time, launched with a full battery at {clock_label(launch)}")
        return _add_legend(drawn, panels)
    window_h = analysis.mission.flight_window_h(perf.day.scenarios)
    drawn, panels = draw(
        [_day_of(each, index) for each in every],
        ends_h=(0.0, 24.0) if window_h is None else (window_h[0][index], window_h[1][index]),
        day_label="".format if window_h is None else "day {}".format,
        end=f", {where}",
    )
    _mark_equal_power(panels[0], perf, index)
    _mark_charge(panels[1], perf, index)
    if (climb := analysis.climb) is not None:
        gain = f"{float(climb.gain_in_excess_time_h[index]):+z.1f}".replace("-", "\N{MINUS SIGN}")
        highest = f"highest {amount(climb.altitude_m[index].max(), 'm', '.0f')}"
        panels[2].set_title(f"{highest}, excess time {gain} h by climbing", fontsize="small")
    return _add_legend(drawn, panels)


def _day_of(perf: Performance, index: int) -> Course:
    """Return the repeated day of a scenario."""
    height_m = np.nan if perf.altitude_m is None else perf.altitude_m[index]
    return Course(
        perf.day.time_h,
        perf.solar_power_w[index],
        perf.load_w[index],
        perf.cycle.energy_wh[index] / float(perf.design.battery_energy_wh),
        np.broadcast_to(height_m, perf.day.time_h.shape),
    )


def _mark_equal_power(axes: Axes, perf: Performance, index: int) -> None:
    """Mark the instants at which solar power equals the load."""
    for name, hour, side in (
        (r"$t_\mathrm{eq}$", perf.cycle.equal_power_morning_h[index], "right"),
        (r"$t_\mathrm{eq,2}$", perf.cycle.equal_power_evening_h[index], "left"),
    ):
        if np.isfinite(hour):
            level = float(np.interp(hour, perf.day.time_h, perf.load_w[index]))
            axes.plot([hour], [level], "o", color=drawing.ink(), markersize=4)
            shift = (-4 if side == "right" else 4, 6)
            drawing.note(axes, name, (hour, level), shift, ha=side, fontsize="medium")


def _mark_charge(axes: Axes, perf: Performance, index: int) -> None:
    """Mark the charge margin above the curve, and the excess time from equal power on below it."""
    axes.set(ylim=(-50, 150))
    cycle = perf.cycle
    full, margin = float(cycle.full_charge_h[index]), float(cycle.charge_margin_h[index])
    if np.isfinite(full):
        text = f"charge margin {amount(margin, 'h', '.1f')}"
        _draw_interval(axes, full, full + margin, _MARGIN_PERCENT, text, "bottom")
    dawn, excess = (float(v[index]) for v in (cycle.equal_power_morning_h, cycle.excess_time_h))
    if not np.isfinite(excess):
        return
    text = f"excess time {amount(excess, 'h', '.1f')}".replace("-", "\N{MINUS SIGN}")
    dawn = dawn if np.isfinite(dawn) else 12.0
    end = min(max(dawn + excess, 0.0), 24.0)
    if excess > 0.0:
        lowest = 100.0 * float(cycle.minimum_state_of_charge[index])
        at_end = lowest * (1.0 - (end - dawn) / excess)
        axes.plot([dawn, end], [lowest, at_end], ":", color=drawing.CHARGE, linewidth=1.0)
    _draw_interval(axes, dawn, end, _EXCESS_PERCENT, text, "top")


def _draw_interval(
    axes: Axes, start_h: float, end_h: float, level: float, text: str, side: str
) -> None:
    """Draw an arrow over an interval of time, and what it is, on the side with more room."""
    drawing.arrow(axes, (start_h, level), (end_h, level), drawing.ink())
    to_right = start_h <= sum(axes.get_xlim()) / 2.0
    place = (start_h if to_right else end_h, level)
    shift = (0, 2 if side == "bottom" else -2)
    drawing.note(axes, text, place, shift, ha="left" if to_right else "right", va=side)


@drawing.styled
def plot_flight(
    analysis: Analysis, flight: CalendarRun, *, figure: drawing.Canvas = DEFAULT
) -> Figure:
    """Draw power and state of charge of a replayed flight over local time.

    Parameters
    ----------
    analysis : Analysis
        Aircraft, mission and solar model, for the title.
    flight : CalendarRun
        The flight.
    """
    dark = runs_of(flight.solar_power_w <= 0.0)
    first_day = day_of_year(flight.launch.date)
    drawn, panels = _draw(
        analysis,
        [flight],
        canvas=figure,
        ends_h=(float(flight.clock_h[0]), float(flight.clock_h[-1])),
        nights_h=flight.clock_h[dark - (0, 1)].tolist(),
        day_label=lambda day: date_label((first_day + day - 2) % 365 + 1),
    )
    for number, hour in enumerate(flight.full_charge_clock_h):
        label = None if number else "full"
        panels[1].axvline(hour, color=drawing.ink(), linestyle=":", linewidth=1, label=label)
    panels[1].set_xlabel(f"local time, launched on {date_label(first_day)}")
    return _add_legend(drawn, panels)
