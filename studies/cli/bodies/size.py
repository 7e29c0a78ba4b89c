"""What ``solar-uav size`` does."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

import click

from missions.weather.files import load_weather
from sizing.day.module_power import path_troubles
from sizing.program.reliability import check_reliability
from sizing.program.survival import check_survival
from sizing.results import sizing
from sizing.results.sizing_study import SizingStudy
from sizing.results.weather_sizing import size_in_weather
from studies.cli import files as checks
from studies.cli.commands.design import Size
from studies.cli.files import Case, load
from studies.cli.options import EXIT_FAILED
from studies.cli.outputs import check_report, deliver, figure_of
from studies.cli.telling import progress_of
from studies.models.solar_models import perpetual_by_model, perpetual_line
from studies.output.run_folder import write_run_folder
from studies.output.sizing_files import sized_inputs, sizing_figures, sizing_tables
from studies.render.tables import SUMMARY, Line, Summary

_MOST_SCENARIOS = 12  # VM and FM take some 10 ms for each


def size(options: Size) -> None:
    """Find the best design, write it, and tell it."""
    if options.survive is not None:
        try:
            check_survival(options.goal, options.survive)
        except ValueError as error:
            raise click.UsageError(str(error)) from error
    case = load(options)
    if options.hold_station is not None:
        case = case.holding_station(options.hold_station)
    _refuse_unsizable(case, options)
    check_report(options.report_file, option="--report")
    study = _designed(case, options)
    folder, report = (options.out_dir, options.report_file) if study.feasible else (None, None)

    def write(folder: str) -> None:
        inputs = sized_inputs(study, case.inputs(options.weather_file))
        figures = sizing_figures(study, options.figure)
        drawn = {name: figure_of(draw) for name, draw in figures.items()}
        record = case.named(study.to_dict())
        write_run_folder(Path(folder), inputs, record, sizing_tables(study), drawn)

    def write_page(path: str) -> None:
        from studies.cli.reports import report_on_sizing  # with all that a page has

        record = case.named(study.to_dict())
        report_on_sizing(case, study, record, path, overrides=options.overrides)

    deliver(
        case,
        lambda: _summary(study, options),
        record=study.to_dict,
        writers={folder: write, report: write_page},
        next_step=_next_step(study, folder),
    )
    if not study.feasible:
        sys.exit(EXIT_FAILED)


def _summary(study: SizingStudy, options: Size) -> Summary:
    """Return the summary of a sizing, with what the other models say of the optimum."""
    summary: Summary = study.at_level(SUMMARY + options.verbose)
    if not study.feasible or options.weather_file is not None:
        return summary
    aircraft, mission = study.sized_aircraft(), study.sized_mission()
    blown = path_troubles(aircraft, mission)[0] is not None
    if blown or len(mission.scenarios()) > _MOST_SCENARIOS:
        return summary
    line = perpetual_line(list(perpetual_by_model(aircraft, mission).values()), mission)
    return Summary((*summary.blocks, Line(f"the sized design with all solar power models: {line}")))


def _refuse_unsizable(case: Case, options: Size) -> None:
    """Refuse an aircraft or a mission that cannot be sized so."""
    measured = "a measured aircraft cannot be sized; allowed: parametric"
    checks.require_parametric(case, measured)
    checks.require_climb_power(case)
    if not options.goal.of_range and options.weather_file is None:
        checks.refuse_polar_night(case)
    checks.require_path(case)
    if options.whole_cells:
        checks.require_whole_cells(case)
    least = options.reliability
    if least is not None:
        with checks.uncertain_inputs_of(case):
            check_reliability(case.aircraft, case.mission, options.goal, case.solar, least)


def _designed(case: Case, options: Size) -> SizingStudy:
    """Find the design."""
    if options.weather_file is None or options.survive is None:
        return sizing.size(
            **case.arguments,
            objective=options.goal,
            with_sensitivities=options.with_sensitivities,
            with_cross_check=options.with_cross_check,
            with_margin=not options.whole_cells,
            with_builds=True,
            whole_cells=options.whole_cells,
            reliability=options.reliability,
        )
    weather = load_weather(options.weather_file, case.mission)
    with progress_of("steps of the search") as progress:
        return size_in_weather(
            **case.arguments,
            weather=weather,
            objective=options.goal,
            survive=options.survive,
            progress=progress,
        )


def _next_step(study: SizingStudy, written: str | None) -> str:
    """Return what to do after a sizing."""
    if written is not None:
        folder = shlex.quote(written)
        return f"solar-uav report {folder} --out report.html; solar-uav analyse {folder}"
    if study.feasible:
        return "the same with --out FOLDER keeps the design, for analyse, map and report"
    eased = study.relaxations
    if eased:
        return f"the same with --set {eased[0].parameter}={eased[0].value:g}, or another of these"
    return "ease what holds it back; docs/sizing-answers.md, Infeasible, says how to read it"
