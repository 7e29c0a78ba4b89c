"""Figures: drawn on their own canvas, returned as bytes, never shown."""

from __future__ import annotations

import io
import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from missions.dates import date_label, day_of_year
from sizing.altitude.climb_cycle import ClimbPerformance
from sizing.optimisation.objectives import Objective
from sizing.optimisation.sensitivity import Sensitivity
from sizing.performance import Performance
from sizing.replay import CalendarRun
from sizing.results.analysis import Analysis
from sizing.sunlight import SolarModel

# Okabe & Ito's palette: told apart by readers with any colour vision, and in grey.
SUN, LOAD, CHARGE, NIGHT = "#E69F00", "#0072B2", "#009E73", "#DDDDDD"
# Instants of the day around which a short text fits into the axes.
_ROOM_FOR_TEXT_H = (2.4, 21.6)


def to_bytes(figure: Figure, image_format: str) -> bytes:
    """Image of a figure."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format=image_format, dpi=150)
    return buffer.getvalue()


def caption(solar: SolarModel) -> str:
    """Model and correction, for every figure."""
    return f"{solar.model}, {correction_label(solar.correction)}"


def correction_label(correction: str) -> str:
    """Correction in the words of a title."""
    return "uncorrected" if correction == "none" else f"correction: {correction}"


def _band_name(solar: SolarModel) -> str:
    corrected = solar.correction != "none"
    return "RMS error after correction" if corrected else "RMS error of the model"


def cycle_figure(analysis: Analysis, scenario: int | None = None) -> Figure:
    """State of charge and power over the cycle of a scenario, the worst one by default."""
    perf = analysis.performance
    index = analysis.worst if scenario is None else scenario
    panels = 2 if analysis.climb is None else 3
    figure = Figure(figsize=(8.0, 2.8 * panels), layout="constrained")
    every: list[Axes] = list(figure.subplots(panels, 1, sharex=True))
    _draw_power(every[0], perf, index)
    _draw_charge(every[1], analysis, index)
    # Below the axes, where no curve can run through it.
    power, charge = (axes.get_legend_handles_labels()[0] for axes in every[:2])
    handles = [*power[:2], *charge, *power[2:]]  # each column a curve and its band
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize="small")
    if analysis.climb is not None:
        _draw_altitude(every[2], analysis.climb, index)
    for axes in every:
        _shade_night(axes, perf, index)
        axes.grid(alpha=0.3)
    every[-1].set(xlim=(0, 24), xticks=range(0, 25, 2), xlabel="solar time [h]")
    where = perf.day.scenarios.label(index)
    title = f"{analysis.aircraft.name}, {where} ({caption(perf.solar)})"
    figure.suptitle(title, parse_math=False)
    return figure


def _draw_power(axes: Axes, perf: Performance, index: int) -> None:
    time_h = perf.day.time_h
    solar, load = perf.solar_power_w[index], perf.load_w[index]
    band = perf.solar.rms_relative
    axes.plot(time_h, solar, color=SUN, label="solar power")
    axes.fill_between(
        time_h,
        solar * (1 - band),
        solar * (1 + band),
        color=SUN,
        alpha=0.2,
        linewidth=0,
        label=f"{_band_name(perf.solar)}, {100 * band:.0f} %",
    )
    axes.plot(time_h, load, color=LOAD, label="load")
    for name, hour, side in (
        (r"$t_\mathrm{eq}$", perf.cycle.equal_power_morning_h[index], "right"),
        (r"$t_\mathrm{eq,2}$", perf.cycle.equal_power_evening_h[index], "left"),
    ):
        if np.isfinite(hour):
            level = float(np.interp(hour, time_h, load))
            axes.plot([hour], [level], "o", color="black", markersize=4)
            shift = -4 if side == "right" else 4
            axes.annotate(name, (hour, level), (shift, 6), textcoords="offset points", ha=side)
    axes.set(ylabel="power [W]", ylim=(0, None))


def _draw_charge(axes: Axes, analysis: Analysis, index: int) -> None:
    perf = analysis.performance
    energy_max = float(perf.design.battery_energy_wh)
    time_h = perf.day.time_h
    low, high = (p.cycle.energy_wh[index] / energy_max for p in (analysis.low, analysis.high))
    charge = 100 * perf.cycle.energy_wh[index] / energy_max
    axes.plot(time_h, charge, color=CHARGE, label="state of charge")
    axes.fill_between(
        time_h,
        100 * low,
        100 * high,
        color=CHARGE,
        alpha=0.2,
        linewidth=0,
        label="with that error in solar power",
    )
    full = perf.cycle.full_charge_h[index]
    if np.isfinite(full):
        axes.axvline(full, color="black", linestyle=":", linewidth=1)
        axes.annotate("full", (full, 50), (4, 0), textcoords="offset points")
        margin = perf.cycle.charge_margin_h[index]
        _draw_margin(axes, float(full), float(margin))
    excess = perf.cycle.excess_time_h[index]
    if np.isfinite(excess):
        dawn = perf.cycle.equal_power_morning_h[index]
        at = dawn if np.isfinite(dawn) else 12.0
        lowest = 100 * perf.cycle.minimum_state_of_charge[index]
        axes.annotate(
            f"excess time {excess:.1f} h".replace("-", "−"),
            (np.clip(at, *_ROOM_FOR_TEXT_H), lowest),
            (0, -14),
            textcoords="offset points",
            ha="center",
            bbox={"facecolor": "white", "alpha": 0.7, "linewidth": 0.0, "pad": 1.0},
        )
    axes.set(ylabel="state of charge [%]", ylim=(-16, 105), yticks=range(0, 101, 20))


def _draw_altitude(axes: Axes, climbs: ClimbPerformance, index: int) -> None:
    flown = climbs.climb
    altitude_m = flown.altitude_m[index]
    axes.plot(flown.time_h, altitude_m, color=LOAD)
    at = int(np.argmax(altitude_m))
    gain = float(climbs.gain_h[index])
    axes.annotate(
        f"highest {altitude_m[at]:.0f} m\nexcess time {gain:+.1f} h by climbing",
        (0.02, 0.8),
        xycoords="axes fraction",
    )
    top = float(altitude_m[at])
    margin = max(0.1 * (top - float(altitude_m.min())), 50.0)
    axes.set(ylabel="altitude [m]", ylim=(float(altitude_m.min()) - margin, top + margin))


def _draw_margin(axes: Axes, full_h: float, margin_h: float) -> None:
    """Arrow over the charge margin; a short one has no room for it and gets a text alone."""
    text = f"charge margin {margin_h:.1f} h"
    if margin_h < 2.0:
        axes.annotate(text, (full_h, 62), (4, 0), textcoords="offset points")
        return
    arrow = {"arrowstyle": "<->", "color": "black", "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (full_h + margin_h, 60), (full_h, 60), arrowprops=arrow)
    axes.annotate(text, (full_h + margin_h / 2, 63), ha="center")


def _shade_night(axes: Axes, perf: Performance, index: int) -> None:
    sunrise, sunset = perf.day.sunrise_h[index], perf.day.sunset_h[index]
    for start, end in ((0.0, sunrise), (sunset, 24.0)):
        if end > start:
            axes.axvspan(start, end, color=NIGHT, zorder=0, linewidth=0)


def flight_figure(analysis: Analysis, flight: CalendarRun) -> Figure:
    """State of charge and power of a replayed flight over local time."""
    figure = Figure(figsize=(9.0, 5.6), layout="constrained")
    power_axes, charge_axes = figure.subplots(2, 1, sharex=True)
    power_axes.plot(flight.clock_h, flight.solar_power_w, color=SUN, label="solar power")
    power_axes.plot(flight.clock_h, flight.load_w, color=LOAD, label="load")
    power_axes.set(ylabel="power [W]", ylim=(0, None))
    figure.legend(*power_axes.get_legend_handles_labels(), loc="outside upper right", ncols=2)
    charge_axes.plot(flight.clock_h, 100 * flight.state_of_charge, color=CHARGE)
    for hour in flight.full_charge_clock_h:
        charge_axes.axvline(hour, color="black", linestyle=":", linewidth=1)
        charge_axes.annotate("full", (hour, 50), (4, 0), textcoords="offset points")
    dark = flight.solar_power_w <= 0.0
    for axes in (power_axes, charge_axes):
        axes.fill_between(
            flight.clock_h,
            0,
            1,
            where=dark,
            transform=axes.get_xaxis_transform(),
            color=NIGHT,
            zorder=0,
            linewidth=0,
        )
        axes.grid(alpha=0.3)
    _label_clock(charge_axes, flight)
    charge_axes.set(
        ylabel="state of charge [%]",
        ylim=(0, 105),
        xlim=(flight.clock_h[0], flight.clock_h[-1]),
    )
    solar = analysis.performance.solar
    title = f"{analysis.aircraft.name}, {analysis.mission.name} ({caption(solar)})"
    figure.suptitle(title, parse_math=False)
    return figure


def _label_clock(axes: Axes, flight: CalendarRun) -> None:
    """Clock and, at midnight, date along the axis of a replayed flight."""
    first, last = float(flight.clock_h[0]), float(flight.clock_h[-1])
    step = next((s for s in (3, 6, 12) if last - first <= 12 * s), 24)
    ticks = range(step * math.ceil(first / step), math.floor(last) + 1, step)
    day = day_of_year(flight.launch.date)
    labels = [
        f"{tick % 24:02d}:00"
        if tick % 24
        else f"00:00\n{date_label((day + tick // 24 - 1) % 365 + 1)}"
        for tick in ticks
    ]
    axes.set_xticks(ticks, labels)
    axes.set_xlabel(f"local time, launched on {date_label(day)}")


def tornado_figure(
    worth: list[Sensitivity],
    objective: Objective,
    name: str,
    solar: SolarModel,
    *,
    bars: int = 15,
) -> Figure:
    """Change of the objective by one per cent more of each parameter, most important on top."""
    shown = [s for s in worth if s.value != 0.0][:bars][::-1]
    figure = Figure(figsize=(9.0, 0.9 + 0.32 * len(shown)), layout="constrained")
    axes = figure.subplots()
    labels = [f"{s.parameter} = {s.value:.4g}" for s in shown]
    sign = 1.0 if objective.maximised else -1.0
    for verdict, good, colour, hatch in (("better", True, CHARGE, ""), ("worse", False, SUN, "//")):
        change = [s.per_percent if (sign * s.per_percent > 0.0) is good else 0.0 for s in shown]
        axes.barh(
            labels, change, label=verdict, facecolor=colour, edgecolor="white", hatch=hatch, lw=0.0
        )
    axes.axvline(0.0, color="black", linewidth=0.8)
    axes.set(xlabel=f"change of the {objective.label} for +1 % [{objective.unit}]")
    axes.set_axisbelow(True)
    figure.suptitle(f"{name} ({caption(solar)})", parse_math=False)
    figure.legend(loc="outside lower right", ncols=2, fontsize="small")
    axes.grid(alpha=0.3, axis="x")
    return figure


def mass_figure(masses_kg: dict[str, float], title: str) -> Figure:
    """Mass budget as horizontal bars, heaviest first."""
    items = sorted(((k, v) for k, v in masses_kg.items() if v > 0), key=lambda item: item[1])
    figure = Figure(figsize=(7.0, 3.6), layout="constrained")
    axes = figure.subplots()
    bars = axes.barh([k for k, _ in items], [v for _, v in items], color=LOAD)
    axes.bar_label(bars, fmt="%.2f kg", padding=3)
    axes.set(xlabel="mass [kg]")
    axes.set_title(title, parse_math=False)
    axes.margins(x=0.15)
    return figure
