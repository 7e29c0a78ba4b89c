"""What ``solar-uav analyse`` does."""

from __future__ import annotations

from sizing.results import analysis
from studies.cli.commands.analyse import Analyse
from studies.cli.files import Case, load, require_climber, require_path
from studies.cli.outputs import call, deliver, figure_of, refuse_to_overwrite, table_of
from studies.output.cycle_plots import plot_cycle, plot_flight


def analyse(options: Analyse) -> None:
    """Fly the mission, and tell what became of it."""
    for option, path in (("--table", options.table_file), ("--table-years", options.table_years)):
        refuse_to_overwrite(option, path, (options.weather_file,))
    case = load(options.case, options.place, total_mass_kg=options.mass_kg)
    require_path(case)
    require_climber(case)
    if options.weather_file is not None:
        from studies.cli.bodies.weather import analyse_in_weather

        analyse_in_weather(case, options, options.weather_file)
        return
    result = analysis.analyse(**case.arguments, known_mass_kg=case.total_mass_kg)
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
