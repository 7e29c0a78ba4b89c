"""What ``solar-uav analyse`` does with a weather record."""

from __future__ import annotations

from typing import Any

import click

from missions.weather.files import load_weather
from sizing.results import analysis
from sizing.results.weather import analyse_weather
from studies.cli.commands.analyse import Analyse
from studies.cli.files import Case
from studies.cli.outputs import deliver, figure_of, table_of
from studies.weather.plots import plot_weather


def analyse_in_weather(case: Case, options: Analyse, weather_file: str) -> None:
    """Fly the case through a weather record, and tell what became of it."""
    weather = load_weather(weather_file, case.mission)
    if options.table_years is not None and weather.typical:
        raise click.UsageError("--table-years needs a record of years: this is a typical year")
    result = analyse_weather(
        **case.arguments, weather=weather, mission_chosen=not case.mission_is_default
    )

    def record() -> dict[str, Any]:
        there = case.arguments
        there["mission"] = result.mission
        clear_day = analysis.analyse(**there, replay=False)
        return clear_day.to_dict() | {"weather": result.to_dict()}

    files = {
        options.table_file: table_of(result.to_frame, "days"),
        options.table_years: table_of(result.to_years_frame, "years"),
        options.plot_file: figure_of(lambda: plot_weather(result, figure=options.figure)),
    }
    deliver(case, result, files, record=record)
