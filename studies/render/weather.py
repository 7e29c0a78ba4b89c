"""Flights through a weather record as people read them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sizing.results.numbers import PERCENTILES
from studies import quantities as q
from studies.render import sentences as say
from studies.render.notes import extrapolation_blocks
from studies.render.numbers import hours, percent
from studies.render.parts import part_tables
from studies.render.tables import ALL, Line, Table, clock_label, facts

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
    shown: list[Any] = [Line(headline(analysis), "strong"), facts("", _rows(analysis))]
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


def _rows(analysis: WeatherAnalysis) -> list[tuple[str, str]]:
    run, clear, days = analysis.performance.recorded, analysis.performance.clear, analysis.days
    dawn_h = run.dawn_h + run.axis.midnight_h
    rows = [
        ("days that close", f"{analysis.days_that_close} of {days}"),
        ("days that close under a clear sky", f"{clear.closes.sum()} of {days}"),
        *_year_rows(analysis),
        ("longest run of days that close", f"{run.longest_run_days} days"),
        ("longest run of days under a clear sky", f"{clear.longest_run_days} days"),
        (
            "endurance from dawn: P90, P50, P10 of days",
            ", ".join(map(hours, analysis.endurance_h.values())),
        ),
        (
            "flights from dawn that reach sunset",
            f"{percent(analysis.flown_to_sunset_share, '.0f')} of days",
        ),
        ("light relative to a clear sky", percent(analysis.share_of_clear_light(), ".0f")),
        (
            "dawn: earliest, latest (solar time)",
            ", ".join(clock_label(float(end)) for end in (dawn_h.min(), dawn_h.max())),
        ),
        ("flight altitude", q.text_of("altitude_m", analysis.mission.altitude_m)),
        *(say.wind_rows(analysis.mission) if analysis.mission.holds_station else []),
    ]
    if (wind := analysis.wind_above_airspeed_share()) is not None:
        rows.append(("time with wind above the airspeed", percent(wind)))
    return rows


def _year_rows(analysis: WeatherAnalysis) -> list[tuple[str, str]]:
    """Return rows on the spread of the years; none where there are not two whole ones."""
    spread = analysis.year_to_year
    if spread is None:
        return []
    closed = {year["year"]: year["days_that_close"] for year in analysis.years}
    ends = (f"{year} ({closed[year]})" for year in (spread["worst_year"], spread["best_year"]))
    days = ", ".join(str(round(spread["days_that_close"][name])) for name in PERCENTILES)
    return [
        ("days that close in a year: 10, 50, 90 % of years", days),
        ("worst year, best year", ", ".join(ends)),
    ]


def _weather_tables(analysis: WeatherAnalysis) -> list[Table]:
    """Return the years, where there are several whole ones, months, and windows of days."""
    tables = []
    closed = "days days_that_close clear_sky_days_that_close"
    if analysis.year_to_year is not None:
        years = [
            year
            | {
                "year": f"{year['year']}{'' if year['whole'] else ' (part)'}",
                "endurance_of_years": ", ".join(hours(year["endurance_h"][p]) for p in PERCENTILES),
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
