"""What ``solar-uav analyse`` does."""

from __future__ import annotations

from typing import Any

import click

from missions.dates import date_code
from sizing.results import analysis
from studies.cli.checks import require_climber, require_path
from studies.cli.commands.analyse import Analyse
from studies.cli.files import Case, load
from studies.cli.outputs import call, deliver, figure_of, table_of
from studies.cli.targets import refuse_to_overwrite
from studies.output.plots import plot_cycle, plot_flight


def analyse(options: Analyse) -> None:
    """Fly the mission, and tell what became of it."""
    for option, path in (("--table", options.table_file), ("--table-years", options.table_years)):
        refuse_to_overwrite(option, path, (options.weather_file,))
    case = _at_its_place(load(options.case), options)
    require_path(case)
    if options.weather_file is not None:
        from studies.cli.bodies.weather import analyse_in_weather

        analyse_in_weather(case, options, options.weather_file)
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


def _at_its_place(case: Case, options: Analyse) -> Case:
    """Case at the place and on the day that the options say."""
    place = options.latitude
    moved: dict[str, Any] = {} if place is None else {"latitude_deg": place}
    day = options.day_of_year if options.day_of_year is not None else options.date
    if day is not None:
        moved["dates"] = {"on": date_code(day)}
    if moved:
        # The mission's launch is one at its own place and day.
        case = case.with_mission(**moved, launch=None)
    if options.days is not None and case.mission.climb is not None:
        raise click.UsageError("--days flies at constant altitude: give it or mission.climb")
    return case


def _next_step(case: Case, *, perpetual: bool) -> str:
    """What to do after an analysis."""
    if perpetual:
        return f"{call('map')} (where and when else)"
    if case.aircraft.airframe.kind == "parametric":
        return f"{call('size')} (a design that flies perpetually)"
    return f"{call('map')} (where and when it flies perpetually)"
