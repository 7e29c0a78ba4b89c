"""Flights by chance as people read them: under uncertain inputs, and through a weather record."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from sizing.results.numbers import PERCENTILES
from sizing.results.uncertainty import draw_percentiles
from studies import quantities as q
from studies.render import sentences as say
from studies.render.notes import extrapolation_blocks
from studies.render.numbers import hours, percent
from studies.render.tables import Line, Table, clock_label, facts

if TYPE_CHECKING:
    from sizing.results.uncertainty import UncertaintyAnalysis
    from sizing.results.weather import WeatherAnalysis

_INPUTS = 8  # of the table of a summary

# ---- Under uncertain inputs


def uncertainty_headline(analysis: UncertaintyAnalysis) -> str:
    """Aircraft, mission and probability in one line."""
    return (
        f"{analysis.aircraft.name} on {analysis.mission.name}: perpetual flight in "
        f"{percent(analysis.probability_perpetual.value)} of {analysis.samples} draws"
    )


def uncertainty_blocks(analysis: UncertaintyAnalysis, level: int) -> list[Any]:
    """Probabilities, spread, and what the excess time depends on: all inputs at level 2."""
    mission, inputs = analysis.mission, analysis.inputs
    rows = [("probability of perpetual flight", analysis.probability_perpetual.text())]
    if analysis.required_h > 0.0:
        label = f"probability of {analysis.required_h:g} h of excess time"
        rows.append((label, analysis.probability_required.text()))
    rows.append(("excess time with the files' values", hours(analysis.nominal_excess_time_h)))
    rows += _spread_rows(analysis)
    climbs = f"; {mission.climb_label}" if mission.climb else ""
    text = (
        f"{analysis.solar.label}{climbs}; seed {analysis.seed}. P90 is exceeded in 90 % of draws."
    )
    if not inputs.independent:
        text += " Inputs are correlated: shares of the variance are not defined."
    return [
        Line(uncertainty_headline(analysis), "strong"),
        *(facts("", rows), input_table(analysis, _INPUTS if level < 2 else len(inputs))),
        *extrapolation_blocks(analysis.extrapolations, level),
        Line(text, "faint"),
    ]


def _spread_rows(analysis: UncertaintyAnalysis) -> list[tuple[str, str]]:
    """Spread of excess time, endurance and state of charge; of two lobes each by itself."""
    scattered, lobes = analysis.scattered(), analysis.lobes
    if not lobes:
        return [
            ("excess time: P90, P50, P10 of draws", _three(q.EXCESS_TIME, scattered)),
            *((one.label, _three(one, scattered)) for one in (q.ENDURANCE, q.MINIMUM_CHARGE)),
        ]
    rows = []
    for name, varied in (("perpetual", q.MINIMUM_CHARGE), ("limited", q.ENDURANCE)):
        chosen = lobes[name]
        within = {one: values[chosen[: len(values)]] for one, values in scattered.items()}
        share = f"{name}, {percent(float(np.mean(chosen)))} of draws"
        rows.append((f"{share}: excess time, P90, P50, P10", _three(q.EXCESS_TIME, within)))
        rows.append((f"{share}: {varied.label}", _three(varied, within)))
    return rows


def _three(quantity: q.Quantity, values: dict[str, Any]) -> str:
    ends = draw_percentiles(values[quantity.name]).values()
    return ", ".join(quantity.fact(value)[1] for value in ends)


def input_table(analysis: UncertaintyAnalysis, most: int) -> Table:
    """Inputs with their spread and their shares of the excess time's variance."""
    shares = {key: (index.first, index.total) for key, index in analysis.sobol.items()}
    nothing, spread = (math.nan, math.nan), q.TABLE["nominal"].text
    order = sorted(analysis.inputs.inputs, key=lambda row: -shares.get(row.key, (0.0, 0.0))[1])
    rows = []
    for row in order[:most]:
        low, high = map(spread, np.percentile(analysis.values[row.key], [10.0, 90.0]))
        alone, with_others = shares.get(row.key, nothing)
        rows.append((row.label, row.nominal, f"{low} to {high}", alone, with_others))
    left = len(order) - len(rows)
    return Table(
        "what the excess time depends on",
        q.group("input nominal spread share_alone share_with_others"),
        tuple(rows),
        (f"{left} more matter less; -v has all",) if left else (),
    )


# ---- Through a weather record


def weather_headline(analysis: WeatherAnalysis) -> str:
    """Aircraft, site and days that close in one line."""
    return (
        f"{analysis.aircraft.name} in the weather of {analysis.weather.site.label}: "
        f"{analysis.days_that_close} of {analysis.days} days close"
    )


def weather_blocks(analysis: WeatherAnalysis, level: int) -> list[Any]:
    """Days that close; at level 2 by month and year, and windows of days."""
    blocks: list[Any] = [Line(weather_headline(analysis), "strong"), facts("", _rows(analysis))]
    if level > 1:
        blocks += _weather_tables(analysis)
    if (condition := analysis.battery_condition) is not None:
        blocks.append(say.battery_line(analysis.aircraft, condition))
    blocks += extrapolation_blocks(analysis.extrapolations, level)
    if level > 1:
        blocks += [Line(f"record: {text}", "faint") for text in analysis.weather.repairs]
    weather = analysis.weather
    kind = "typical year, months of several years" if weather.typical else "one record"
    text = (
        f"{analysis.performance.solar.label}; {weather.layout}, {kind}. A day closes if, begun at "
        "dawn with the charge carried over, it reaches the next dawn without an empty battery. "
        "P90 is exceeded on 90 % of days."
    )
    return [*blocks, *(Line(note, "faint") for note in (*analysis.notes, text))]


def _rows(analysis: WeatherAnalysis) -> list[tuple[str, str]]:
    run, clear, days = analysis.performance.recorded, analysis.performance.clear, analysis.days
    dawn_h = run.dawn_h + run.axis.midnight_h
    rows = [
        ("days that close", f"{analysis.days_that_close} of {days}"),
        ("the same under a clear sky", f"{analysis.clear_sky_days_that_close} of {days}"),
        *_year_rows(analysis),
        ("longest run of days that close", f"{run.longest_run_days} days"),
        ("longest run under a clear sky", f"{clear.longest_run_days} days"),
        (
            "endurance from dawn: P90, P50, P10 of days",
            ", ".join(map(hours, analysis.endurance_h.values())),
        ),
        (
            "launched at dawn, still flying at sunset",
            f"{percent(analysis.flown_to_sunset_share, '.0f')} of days",
        ),
        ("light, share of the clear sky's", percent(analysis.share_of_clear_light(), ".0f")),
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
    """Rows on the spread of the years; none where there are not two whole ones."""
    spread = analysis.year_to_year
    if spread is None:
        return []
    closed = {year.year: year.days_that_close for year in analysis.years}
    ends = (f"{year} ({closed[year]})" for year in (spread.worst_year, spread.best_year))
    days = ", ".join(str(round(spread.days_that_close[name])) for name in PERCENTILES)
    return [
        ("days that close in a year: 10, 50, 90 % of years", days),
        ("worst year, best year", ", ".join(ends)),
    ]


def _weather_tables(analysis: WeatherAnalysis) -> list[Table]:
    """Years, where there are several whole ones, months, and windows of days."""
    tables = []
    closed = "days days_that_close clear_sky_days_that_close"
    if analysis.year_to_year is not None:
        years = [
            vars(year)
            | {
                "year": f"{year.year}" if year.whole else f"{year.year} (part)",
                "endurance_of_years": ", ".join(hours(year.endurance_h[p]) for p in PERCENTILES),
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
