"""What ``solar-uav analyse`` does."""

from __future__ import annotations

from sizing.results import analysis
from studies.cli.commands.analyse import Analyse
from studies.cli.files import Case, load_flyable
from studies.cli.outputs import call, deliver, figure_of, refuse_to_overwrite, table_of
from studies.output.cycle_plots import plot_cycle, plot_flight


def analyse(options: Analyse) -> None:
    """Fly the mission, and tell what became of it."""
    for option, path in (("--table", options.table_file), ("--table-years", options.table_years)):
        refuse_to_overwrite(option, path, (options.weather_file,))
    case = load_flyable(options)
    if options.weather_file is not None:
        from studies.cli.bodies.weather import analyse_in_weather

        analyse_in_weather(case, options, options.weather_file)
        return
    result = analysis.analyse(**case.arguments, known_mass_kg=case.total_mass_kg)
    replay = result.flight
    files = {
        options.table_file: table_of(result.trajectory, "cycle"),
        options.plot_file: figure_of(
            lambda: (
                plot_cycle(result, figure=options.figure)
                if replay is None
                else plot_flight(result, replay, figure=options.figure)
            )
        ),
    }
    deliver(case, result, files, next_step=_next_step(case, perpetual=result.is_perpetual))


def _next_step(case: Case, *, perpetual: bool) -> str:
    """Return what to do after an analysis."""
    if perpetual:
        return f"{call('map')} (where and when else)"
    flies = "flies perpetually" if case.mission.flight is None else "lands with power left"
    if case.aircraft.airframe.kind == "parametric":
        return f"{call('size')} (a design that {flies})"
    return f"{call('map')} (where and when it {flies})"
