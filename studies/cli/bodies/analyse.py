"""What ``solar-uav analyse`` does."""

from __future__ import annotations

import click

from missions.weather.files import load_weather
from sizing.results import analysis
from sizing.results.weather import analyse_weather
from studies.cli.checks import require_climber, require_path
from studies.cli.commands.analyse import Analyse
from studies.cli.files import Case, load
from studies.cli.outputs import call, deliver, figure_of, table_of
from studies.cli.targets import refuse_to_overwrite
from studies.output.plots import plot_cycle, plot_flight
from studies.weather.plots import plot_weather


def analyse(options: Analyse) -> None:
    """Fly the mission, and tell what became of it."""
    for option, path in (("--table", options.table_file), ("--table-years", options.table_years)):
        refuse_to_overwrite(option, path, (options.weather_file,))
    case = load(options.case, options.place)
    if options.mass is not None:
        case = case.with_total_mass(options.mass)
    if options.days is not None and case.mission.climb is not None:
        raise click.UsageError("--days flies at constant altitude: give it or mission.climb")
    require_path(case)
    if options.weather_file is not None:
        _in_weather(case, options, options.weather_file)
        return
    require_climber(case)
    result = analysis.analyse(
        case.aircraft,
        case.mission,
        model=case.solar.model,
        correction=case.solar.correction,
        days=options.days,
    )
    flown = result.flight
    files = {
        options.table_file: table_of(result.trajectory, "cycle"),
        options.plot_file: figure_of(
            lambda: (
                plot_cycle(result, figure=options.figure)
                if flown is None
                else plot_flight(result, flown, figure=options.figure)
            )
        ),
    }
    perpetual = bool(result.performance.cycle.perpetual.all())
    step = _next_step(case, perpetual=perpetual)
    deliver(case, case.named(result.to_dict()), result, files, next_step=step)


def _next_step(case: Case, *, perpetual: bool) -> str:
    """What to do after an analysis."""
    if perpetual:
        return f"{call('map')} (where and when else)"
    if case.aircraft.airframe.kind == "parametric":
        return f"{call('size')} (a design that flies perpetually)"
    return f"{call('map')} (where and when it flies perpetually)"


def _in_weather(case: Case, options: Analyse, weather_file: str) -> None:
    """Fly the case through a weather record, and tell what became of it."""
    weather, solar = load_weather(weather_file), case.solar
    if options.table_years is not None and weather.typical:
        raise click.UsageError("--table-years needs a record of years: this is a typical year")
    result = analyse_weather(
        case.aircraft,
        case.mission,
        weather,
        model=solar.model,
        correction=solar.correction,
        mission_chosen=not case.mission_is_default,
    )
    record = {"weather": result.to_dict()}
    if case.as_json:
        clear_day = analysis.analyse(
            case.aircraft,
            result.mission,
            model=solar.model,
            correction=solar.correction,
            replay=False,
        )
        record = clear_day.to_dict() | record
    files = {
        options.table_file: table_of(result.to_frame, "days"),
        options.table_years: table_of(result.to_years_frame, "years"),
        options.plot_file: figure_of(lambda: plot_weather(result, figure=options.figure)),
    }
    deliver(case, case.named(record), result, files)
