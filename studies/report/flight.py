"""Sections on the flight: the day, the season, the solar power models, scatter and weather."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.contour import ContourSet

from missions.dates import DAYS_PER_YEAR, MONTH_NAMES, MONTH_STARTS, date_label
from missions.mission.scenarios import latitude_label
from studies.maps.plots import plot_map
from studies.maps.study import prepare
from studies.models.plots import plot_comparison
from studies.output.cycle_plots import panel_count, plot_cycle, plot_flight
from studies.quantities import BELOW_ZERO, EXCESS_TIME, MINIMUM_CHARGE, group
from studies.render.analysis import scenario_table
from studies.render.tables import ALL, Table
from studies.report.blocks import Block, Section, page_figure, page_options
from studies.report.subject import Subject
from studies.uncertainty import plot_uncertainty
from studies.weather import plot_weather

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Plot

_MOST_SCENARIOS = 20  # rows of the table
_WIDTH_IN = 7.4
# Cells of the season map: latitudes and days; fewer of the models that take 10 ms each.
CELLS, CLIMBING_CELLS, SLOW_CELLS = (57, 74), (29, 37), (15, 14)
_MIDDLE_OF_MONTH = 14  # days after its first
_POLEWARD_DEG = 70.0  # or the poles, for a mission beyond
_MOST_RINGS = 30
# Lines on the cells of a map: black on a dark page as well, unlike the axes.
_ON_CELLS = "#111111"


def day_section(subject: Subject) -> Section:
    """Return the weakest scenario's day, all scenarios, and the flight on the calendar."""
    analysis = subject.analysis
    where = analysis.performance.worst_label
    several = len(analysis.performance.cycle.status) > 1
    height = 1.2 + 2.0 * panel_count(analysis)
    caption = (
        f"Solar power, load and state of charge over solar time at {where}"
        f"{', the weakest scenario' if several else ''}; bands: the solar model's RMS error. Grey: "
        "night."
    )
    plot = plot_cycle(analysis, figure=page_options(_WIDTH_IN, height))
    _, least = MINIMUM_CHARGE.fact(analysis.minimum_state_of_charge)
    words = f"{caption} The charge is least, {least}, in the morning."
    title = f"Day cycle at {where}"
    blocks: list[Block] = [page_figure(plot, caption, title=title, description=words, key="cycle")]
    if several:
        excess_h = analysis.performance.cycle.excess_time_h
        weakest, notes = None, []
        if len(excess_h) > _MOST_SCENARIOS:
            weakest = np.argsort(excess_h, kind="stable")[:_MOST_SCENARIOS]
            notes = [f"the {_MOST_SCENARIOS} weakest of {len(excess_h)} scenarios"]
        blocks.append(dataclasses.replace(scenario_table(analysis, weakest), notes=tuple(notes)))
    if analysis.flight is not None:
        plot = plot_flight(analysis, analysis.flight, figure=page_options(_WIDTH_IN, 4.8))
        caption = "Solar power, load and state of charge from the mission's launch. Grey: night."
        blocks.append(page_figure(plot, caption, title="Flight on the calendar", key="calendar"))
        blocks += subject.sections["flight"]
    return Section("day", "The day", blocks)


# ---- Season


def season_section(subject: Subject) -> Section:
    """Return where and when the flight is perpetual, and the months."""
    solar, scenarios = subject.solar, subject.analysis.performance.day.scenarios
    rows, columns = SLOW_CELLS if solar.needs_path else CELLS
    if subject.mission.climb is not None and not solar.needs_path:
        rows, columns = CLIMBING_CELLS
    farthest = 90.0 if np.max(np.abs(scenarios.latitude_deg)) > _POLEWARD_DEG else _POLEWARD_DEG
    south, north = solar.latitudes_with_wind_deg(subject.mission)
    latitudes = np.unique(np.linspace(max(-farthest, south), min(farthest, north), rows))
    days = np.linspace(1, DAYS_PER_YEAR, columns).round().astype(int)
    data = prepare(subject.aircraft, subject.mission, latitudes, days, solar).computed()
    plot = plot_map(data, figure=page_options(_WIDTH_IN, 4.6))
    _ring_places(plot, scenarios.latitude_deg, scenarios.day_of_year)
    season = _season_text(subject)
    texts = [season] if season else []
    caption = (
        "Excess time of this aircraft on every day at every latitude, in the mission's air; black "
        "line: edge of perpetual flight; ring: the mission's scenarios."
    )
    if subject.mission.holds_station:
        caption = f"{caption[:-1]}; flown as fast as the wind, at the latitudes where it is known."
    if subject.mission.climb is not None:
        caption = f"{caption[:-1]}; with {subject.mission.climb_label}."
    words = f"{caption} {season}"
    drawing = page_figure(plot, caption, title="Season map", description=words, key="season")
    return Section("season", "The season", [*texts, drawing, _months(subject)])


def _months(subject: Subject) -> Table:
    """Return the repeated day in the middle of every month, at the latitude of the worst one."""
    scenarios, worst = subject.analysis.performance.day.scenarios, subject.analysis.worst
    latitude = float(scenarios.latitude_deg[worst])
    days = np.array(MONTH_STARTS) + _MIDDLE_OF_MONTH
    data = prepare(subject.aircraft, subject.mission, [latitude], days, subject.solar).computed()
    columns = group("month day_length_h solar_energy_wh load_energy_wh excess_time_h "
                    "charge_margin_h minimum_state_of_charge")  # fmt: skip
    values = (data[column.variable].to_numpy()[0] for column in columns[1:])
    rows = tuple(zip(MONTH_NAMES, *values, strict=True))
    title = f"the months at {latitude_label(latitude)}, each on its {_MIDDLE_OF_MONTH + 1}th"
    short = bool(np.any(data[EXCESS_TIME.variable].to_numpy() < 0.0))
    return Table(title, columns, rows, (BELOW_ZERO,) if short else ())


def _ring_places(plot: Plot, latitude_deg: Any, day: Any) -> None:
    """Ring the places of a mission: of many, the corners of what they cover."""
    if len(day) > _MOST_RINGS:
        days, latitudes = ((min(v), max(v)) for v in (day, latitude_deg))
        day, latitude_deg = (*days, *days), (latitudes[0], *latitudes, latitudes[1])
    axes = plot.axes[0]
    for contour in axes.collections:
        if isinstance(contour, ContourSet) and not contour.filled:
            contour.set_edgecolor(_ON_CELLS)
    for colour, width in (("white", 3.2), (_ON_CELLS, 1.4)):
        looks: dict[str, Any] = {"color": colour, "markeredgewidth": width, "fillstyle": "none"}
        axes.plot(day, latitude_deg, "o", markersize=9.0, clip_on=False, zorder=5, **looks)


def _season_text(subject: Subject) -> str:
    """Return the days of the year with perpetual flight at all latitudes, in words."""
    comparison = subject.comparison
    cases = () if comparison is None else comparison.cases
    latitudes = () if comparison is None else comparison.mission.latitudes()
    season = next((case.season for case in cases if case.solar == subject.solar), None)
    if season is None:
        return ""
    where = _places(latitudes)
    if season.days in (0, DAYS_PER_YEAR):
        day = "no day" if season.days == 0 else "every day"
        return f"At {where}, flight is perpetual on {day} of the year."
    text = f"At {where}, flight is perpetual on {season.days} days of the year"
    if season.first is None or season.last is None:
        return f"{text}, none of them at midsummer."
    window = f"{date_label(season.first)} to {date_label(season.last)}"
    return f"{text}, {window} without a break."


def _places(latitudes: Sequence[float]) -> str:
    """Return one latitude, or the ends of several, in words."""
    ends = [latitude_label(latitude) for latitude in latitudes]
    return ends[0] if len(ends) == 1 else f"all latitudes from {ends[0]} to {ends[-1]}"


# ---- Models


def models_section(subject: Subject) -> Section:
    """Return all solar power models side by side."""
    title = "Solar power models"
    if subject.path_trouble is not None:
        text = f"The solar power models are not compared: {subject.path_trouble}."
        return Section("models", title, [text])
    comparison = subject.comparison
    assert comparison is not None  # the path has no trouble
    height = 1.9 + 0.26 * len(comparison.cases)
    plot = plot_comparison(comparison, figure=page_options(_WIDTH_IN + 0.4, height))
    at = comparison.mission.latitudes()
    where = "" if len(at) == len(subject.mission.latitudes()) else f" at {_places(at)}"
    caption = (
        f"What each model predicts{where}: solar energy and excess time with bars of the model's "
        "RMS error, and the perpetual season."
    )
    words = f"{caption} The same numbers are in the table below."
    blocks: list[Block] = [
        f"{comparison.headline()} {comparison.perpetual_line()}",
        page_figure(plot, caption, title=title, description=words, key="models"),
        *comparison.scenario_tables(),
        *(f"- {note}" for note in comparison.notes),
    ]
    return Section("models", title, blocks)


# ---- Scatter, weather, logs


def uncertainty_section(subject: Subject) -> Section | None:
    """Return how likely the flight is perpetual when inputs scatter, if any do."""
    uncertainty = subject.uncertainty
    if uncertainty is None:
        return None
    caption = (
        f"Excess time of the weakest scenario in {uncertainty.samples} draws of the uncertain "
        "inputs, and what it depends on."
    )
    words = f"{caption} {uncertainty.headline()}. The shares are in the table below."
    plot = plot_uncertainty(uncertainty, figure=page_options(9.6))
    title = "Excess time under uncertain inputs"
    drawing = page_figure(plot, caption, title=title, description=words, key="scatter")
    first, *others = uncertainty.at_level(ALL).blocks
    blocks = [first, drawing, *others]
    return Section("uncertainty", "Uncertain inputs", blocks)


def weather_section(subject: Subject) -> Section | None:
    """Return the flight through a weather record; None without one."""
    weather = subject.weather
    if weather is None:
        return None
    caption = "State of charge at every dawn, survival of launches, and the season in this weather."
    plot = plot_weather(weather, figure=page_options(_WIDTH_IN + 0.4, 6.4))
    title, words = "Flight through the weather record", f"{weather.headline()}. {caption}"
    drawing = page_figure(plot, caption, title=title, description=words, key="weather")
    first, *others = weather.at_level(ALL).blocks
    return Section("weather", "Weather", [first, drawing, *others])


def verification_section(subject: Subject) -> Section | None:
    """Return the models against a flight log; None without one."""
    verification = subject.verification
    if verification is None:
        return None
    from studies.flight_logs.plots import figures  # a fifth of a second, with pandas

    blocks: list[Block] = [*verification.at_level(ALL).blocks]
    for name, draw in figures(verification, figure=page_options(_WIDTH_IN + 0.4)):
        key, caption = f"log-{name}", f"Measured and modelled power: {name}."
        blocks.append(page_figure(draw(), caption, title=f"Log and models, {name}", key=key))
    return Section("verification", "Models against the flight log", blocks)
