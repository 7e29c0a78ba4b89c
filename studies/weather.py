"""Flights through a weather record as people read them; calendar, survival and season drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from missions.dates import MONTH_NAMES
from sizing.day.record import WeatherRun
from sizing.results.design_result import wind_of
from sizing.results.weather import WeatherAnalysis
from solar.schema import spell
from solar.types import BoolArray
from studies import quantities as q
from studies.output.figures.drawing import BLUE, ORANGE, Canvas, new_figure, styled
from studies.output.figures.options import DEFAULT
from studies.render.analysis import part_tables, wind_rows
from studies.render.tables import ALL, Line, Table, facts
from studies.render.words import extrapolation_blocks, extrapolation_caption

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Survival of flights is drawn up to here [d].
_LONGEST_DAYS = 200.0
_TICKS_DAYS = (0.5, 1, 2, 5, 10, 20, 50, 100, 200)
_FEW_DAYS = 2  # up to here the scale is linear, from the launch
# A longer record is drawn with a row a year, not a row a month.
_MONTHS_UP_TO_DAYS = 400
# Of a leap year, counted from 0.
_MONTH_STARTS = np.array([0, 31, 60, 91, 121, 152, 182, 213, 244, 274, 305, 335])


def headline(analysis: WeatherAnalysis) -> str:
    """Return aircraft, site and days that close in one line."""
    return (
        f"{analysis.aircraft.name} in the weather of {analysis.weather.site.label}: "
        f"{analysis.days_that_close} of {analysis.days} days close"
    )


def blocks(analysis: WeatherAnalysis, level: int) -> list[Any]:
    """Return the days that close; at level 2 by month and year, and windows of days."""
    mission = analysis.mission
    rows = q.facts_of(q.of_part("weather"), analysis, level)
    rows += wind_rows(wind_of(mission)) if mission.holds_station else []
    shown: list[Any] = [Line(headline(analysis), "strong"), facts("", rows)]
    if level >= ALL:
        shown += _weather_tables(analysis)
    if analysis.battery_condition is not None:
        shown.append(part_tables(analysis, "battery"))
    shown += extrapolation_blocks(analysis.extrapolations, level)
    if level >= ALL:
        shown += [Line(f"record: {text}", "faint") for text in analysis.weather.repairs]
    weather, solar = analysis.weather, analysis.performance.days.solar
    kind = "typical year, months of several years" if weather.typical else "one record"
    text = (
        f"{solar.label}; {weather.layout}, {kind}. Dawn is the instant of "
        "least charge before noon. A day closes if its flight, from dawn with the charge carried "
        "over, reaches the next dawn before the battery is empty. P90 is exceeded on 90 % of days."
    )
    return [*shown, *(Line(note, "faint") for note in (*analysis.notes, text))]


def _weather_tables(analysis: WeatherAnalysis) -> list[Table]:
    """Return the years, where there are several whole ones, months, and windows of days."""
    tables, hours_of = [], q.ENDURANCE.fact
    closed = "days days_that_close clear_sky_days_that_close"
    if analysis.year_to_year is not None:
        years = [
            year
            | {
                "year": f"{year['year']}{'' if year['whole'] else ' (part)'}",
                "endurance_of_years": hours_of(year["endurance_h"])[1],
            }
            for year in analysis.years
        ]
        keys = f"year {closed} longest_run_days endurance_of_years"
        tables.append(q.table_of("year by year", keys, years))
    keys = f"month {closed} median_dawn_state_of_charge median_endurance_h"
    tables.append(q.table_of("month by month", keys, analysis.months))
    if analysis.days_that_close:
        title = "windows of consecutive days that close"
        tables.append(
            Table(title, q.group("window_days starts median_wait_days"), analysis.windows)
        )
    return tables


# ---- Figure


@styled
def plot_weather(analysis: WeatherAnalysis, *, figure: Canvas = DEFAULT) -> Figure:
    """Draw the flights of an aircraft through a weather record.

    Above, a calendar of the state of charge at every dawn, days that do not close crossed, or of
    endurance if none closes; below, the share of launches still airborne over time, and of days
    that close by month, both in the record's light and under a clear sky.

    Parameters
    ----------
    analysis : WeatherAnalysis
    """
    run = analysis.performance.recorded
    drawn, panels = new_figure(
        2,
        2,
        canvas=figure,
        title=analysis.headline(),
        notes=(
            analysis.performance.days.solar.label,
            analysis.mission.climb_label,
            extrapolation_caption(analysis.extrapolations),
        ),
        size_in=(9.0, 7.4),
        grid="",
        height_ratios=(1.5, 1.0),
    )
    calendar, spare, survival, season = panels
    grid = calendar.get_subplotspec().get_gridspec()  # type: ignore[union-attr]  # subplots have one
    calendar.set_subplotspec(grid[0, :])
    spare.remove()
    _draw_calendar(drawn, calendar, analysis)
    _draw_survival(survival, analysis)
    _draw_season(season, analysis)
    if not np.any(run.closes):
        season.text(0.5, 0.5, "no day closes", transform=season.transAxes, ha="center")
    return drawn


def _draw_calendar(figure: Figure, axes: Axes, analysis: WeatherAnalysis) -> None:
    """Draw the state of charge at dawn by day: months by days, or years by days of the year.

    Endurance from dawn [h] if no day closes.
    """
    run = analysis.performance.recorded
    axis = run.axis
    several = len(axis) > _MONTHS_UP_TO_DAYS and len(set(axis.year.tolist())) > 1
    day_of_month = (axis.date - axis.date.astype("datetime64[M]")).astype(int)
    if several:
        first, last = int(axis.year.min()), int(axis.year.max())
        width = 366
        rows, columns = axis.year - first, _MONTH_STARTS[axis.month - 1] + day_of_month
        names = [str(year) for year in range(first, last + 1)]
    else:
        present = sorted(set(axis.month.tolist()))
        rows, columns, width = np.searchsorted(present, axis.month), day_of_month, 31
        names = [MONTH_NAMES[month - 1] for month in present]
    failed, none = ~run.closes, not run.closes.any()
    shown = np.full((len(names), width), np.nan)
    shown[rows, columns] = run.endurance_h if none else 100.0 * run.dawn_state_of_charge
    if not none:
        shown[rows[0], columns[0]] = np.nan  # still the full battery of the start
    largest = 10.0 * np.ceil(max(float(np.nanmax(shown)), 1.0) / 10.0)
    image = axes.imshow(
        shown, aspect="auto", cmap="viridis", vmin=0.0, vmax=largest, interpolation="nearest"
    )
    bar = figure.colorbar(image, ax=axes, pad=0.01)
    bar.set_label("flown from dawn [h]" if none else "state of charge at dawn [%]")
    shown_rows = range(0, len(names), 1 + len(names) // 20)
    axes.set_yticks(shown_rows, [names[i] for i in shown_rows])
    if several:
        axes.set_xticks(_MONTH_STARTS, MONTH_NAMES)
    else:
        axes.set_xticks(range(0, 31, 2), [str(day) for day in range(1, 32, 2)])
        axes.set_xlabel("day of the month")
    if none:  # every day would be crossed
        return
    cross, edge, ring = (1.5, 0.4, 2.0) if several else (4.0, 0.8, 6.0)
    looks: dict[str, Any] = {"color": "white", "markersize": cross, "markeredgewidth": edge}
    if failed.any():
        axes.plot(columns[failed], rows[failed], "x", label="does not close", **looks)
    looks = {"color": ORANGE, "markersize": ring, "markerfacecolor": "none"}
    axes.plot(columns[0], rows[0], "s", label="start, battery full", **looks)
    looks = {"facecolor": "#404040", "labelcolor": "white"}
    axes.legend(ncols=2, loc="lower right", bbox_to_anchor=(1.0, 1.0), **looks)


def _draw_survival(axes: Axes, analysis: WeatherAnalysis) -> None:
    """Draw the share of launches at dawn with a full battery still airborne; grey: each year."""
    done = analysis.performance
    whole = [year["year"] for year in analysis.years if year["whole"]]
    for index, year in enumerate(whole if len(whole) > 1 else ()):
        of_year = done.recorded.axis.year == year
        label = "launches of each year" if not index else ""
        _draw_share(axes, done.recorded, of_year, color="0.7", linewidth=0.7, label=label)
    every = np.ones(len(done.recorded.closes), bool)
    _draw_share(axes, done.clear, every, color=ORANGE, linestyle="--", label="clear sky")
    _draw_share(axes, done.recorded, every, color=BLUE, label="record")
    longest = max(float(run.endurance_h.max()) for run in (done.recorded, done.clear)) / 24.0
    last = next((days for days in _TICKS_DAYS if days >= longest), _LONGEST_DAYS)
    axes.set(
        ylim=(0.0, 102.0),
        xlabel="time since the launch at dawn [d]",
        ylabel="launches still airborne [%]",
    )
    if last > _FEW_DAYS:
        axes.set(xscale="log", xlim=(0.5, last))
        ticks = [days for days in _TICKS_DAYS if days <= last]
        axes.set_xticks(ticks, [spell(days) for days in ticks], minor=False)
        axes.minorticks_off()
    else:
        axes.set_xlim(0.0, last)
    axes.grid(alpha=0.3)
    axes.legend()


def _draw_share(axes: Axes, run: WeatherRun, launches: BoolArray, **style: Any) -> None:
    """Draw the share of launches that are still airborne over time."""
    hours = np.sort(run.endurance_h[launches]) / 24.0
    share = 100.0 * (1.0 - np.arange(len(hours)) / len(hours))
    at_last = share[-1] if run.outlasts[launches].any() else 0.0
    axes.step(np.append(hours, _LONGEST_DAYS), np.append(share, at_last), where="pre", **style)


def _draw_season(axes: Axes, analysis: WeatherAnalysis) -> None:
    """Draw the share of days that close by month."""
    done = analysis.performance
    month = done.recorded.axis.month
    present = sorted(set(month.tolist()))
    for run, colour, shift, label, hatch in (
        (done.clear, ORANGE, -0.2, "clear sky", "//"),
        (done.recorded, BLUE, 0.2, "record", ""),
    ):
        share = [100.0 * float(np.mean(run.closes[month == number])) for number in present]
        axes.bar(
            np.arange(len(present)) + shift, share, 0.4, color=colour, hatch=hatch, label=label
        )
    axes.set_xticks(range(len(present)), [MONTH_NAMES[number - 1][:1] for number in present])
    axes.set(ylim=(0.0, 102.0), xlabel="month", ylabel="days that close [%]")
    axes.grid(alpha=0.3, axis="y")
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2)
