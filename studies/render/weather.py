"""Flights through a weather record as people read them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from studies import quantities as q
from studies.render import sentences as say
from studies.render.analysis import part_tables
from studies.render.tables import ALL, Line, Table, facts
from studies.render.words import extrapolation_blocks

if TYPE_CHECKING:
    from sizing.results.weather import WeatherAnalysis


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
    rows += say.wind_rows(mission) if mission.holds_station else []
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
