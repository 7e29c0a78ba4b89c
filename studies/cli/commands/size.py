"""The command ``solar-uav size``."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from solar.names import OBJECTIVE_NAMES
from studies.cli.help_texts import command
from studies.cli.options import (
    EXIT_FAILED,
    Asked,
    RealRange,
    aircraft_argument,
    completes,
    figure_options,
    mission_option,
    out_option,
    report_option,
    required_time_option,
    solar_options,
)
from studies.output.figures.options import FigureOptions

if TYPE_CHECKING:
    from sizing.optimisation.objectives import Objective
    from sizing.results.sizing import SizingStudy


def _renamed(_: click.Context, option: click.Parameter, given: bool) -> None:
    if given:
        raise click.UsageError(f"{option.opts[0]} is called --cross-check now")


def _next_step(study: SizingStudy, written: str | None) -> str:
    """What to do after a sizing."""
    if written is not None:
        folder = shlex.quote(written)
        return f"solar-uav report {folder} --out report.html; solar-uav analyse {folder}"
    if study.feasible:
        return "the same with --out FOLDER keeps the design, for analyse, map and report"
    eased = study.relaxations
    if eased:
        return f"the same with --set {eased[0].parameter}={eased[0].value:g}, or another of these"
    return "ease what holds it back; docs/sizing.md, Infeasible, says how to read it"


def _check_weather(objective: Objective, survive: float, others: Mapping[str, bool]) -> None:
    """Refuse a share of days together with what is asked of clear days."""
    from sizing.survival.sizing import check_survival

    for option, given in others.items():
        if given:
            raise click.UsageError(
                f"{option} is of repeated clear days: leave it out, or --weather with --survive"
            )
    try:
        check_survival(objective, survive)
    except ValueError as error:
        raise click.UsageError(str(error)) from error


@command(
    "solar-uav size atlantiksolar-design -m rafz-july --required-excess-time 2",
    "solar-uav size atlantiksolar-design -m mission.yaml --weather FILE --survive 0.9",
)
@aircraft_argument()
@mission_option(None)
@click.option(
    "--objective",
    type=click.Choice(OBJECTIVE_NAMES),
    default="min_mass",
    show_default=True,
    help="Masses and wingspan become as small as the mission's required excess "
    "time allows; max_excess_time ends at the bounds of the design space; the last two search for "
    "the most days, or degrees of latitude, in which one design flies perpetually.",
)
@required_time_option
@out_option("figures")
@report_option
@click.option(
    "--sensitivities",
    "with_sensitivities",
    is_flag=True,
    help="Tell how the optimum changes with each technology parameter.",
)
@click.option("--certify", is_flag=True, hidden=True, expose_value=False, callback=_renamed)
@click.option(
    "--cross-check",
    "with_cross_check",
    is_flag=True,
    help="Try to beat the optimum with thousands of other designs in the simulator.",
)
@click.option(
    "--reliability",
    type=RealRange(0.0, 1.0, unit="the interval from 0 to 1", above=True, below=True),
    metavar="PROBABILITY",
    help="Least probability of the required excess time in every scenario when the uncertain "
    "inputs of aircraft and mission scatter, for instance 0.95.",
)
@click.option(
    "--weather",
    "weather_file",
    shell_complete=completes("weather_file"),
    type=click.Path(),
    metavar="FILE",
    help="Size for the days of a weather record on the mission's dates, instead of clear ones; "
    "with --survive.",
)
@click.option(
    "--survive",
    type=RealRange(0.0, 1.0, unit="the interval from 0 to 1", above=True),
    metavar="SHARE",
    help="Least share of the days of the weather record that close, for instance 0.9.",
)
@solar_options
@figure_options
def size(
    asked: Asked,
    objective: str,
    required_h: float | None,
    out_dir: str | None,
    figure: FigureOptions,
    report_file: str | None,
    with_sensitivities: bool,
    with_cross_check: bool,
    reliability: float | None,
    weather_file: str | None,
    survive: float | None,
) -> None:
    """Find the best design of AIRCRAFT (name, file or folder) for a mission."""
    from missions.files.writing import check_writable_folder
    from missions.weather.files import load_weather
    from sizing.optimisation.objectives import Objective
    from sizing.reliability import check_reliability
    from sizing.results import sizing
    from sizing.results.weather_sizing import size_in_weather
    from studies.cli.checks import (
        refuse_climb,
        refuse_polar_night,
        require_parametric,
        require_path,
        uncertain_inputs_of,
    )
    from studies.cli.outputs import told
    from studies.cli.progress import progress_of
    from studies.cli.reports import check_report, report_on_sizing
    from studies.output.run_folder import write_run_folder
    from studies.output.sizing_files import sized_inputs, sizing_figures, sizing_tables

    goal = Objective(objective)
    if goal.of_range and (with_sensitivities or with_cross_check):
        raise click.UsageError(
            f"{objective} counts days or degrees: it has no sensitivities and no cross-check"
        )
    if reliability is not None and (with_sensitivities or with_cross_check):
        raise click.UsageError("--sensitivities and --cross-check know of no --reliability")
    if (weather_file is None) != (survive is None):
        given, other = ("--weather", "--survive") if survive is None else ("--survive", "--weather")
        raise click.UsageError(f"{given} needs {other} as well")
    if survive is not None and report_file is not None:
        raise click.UsageError(
            "--report is of repeated clear days: use --out FOLDER, then solar-uav report FOLDER "
            "--weather FILE"
        )
    if survive is not None:
        _check_weather(
            goal,
            survive,
            {
                "--sensitivities": with_sensitivities,
                "--cross-check": with_cross_check,
                "--reliability": reliability is not None,
                "--required-excess-time": required_h is not None,
            },
        )
    case = asked.case()
    if required_h is not None:
        case = case.with_mission(required_excess_time_h=required_h)
    require_parametric(case, "a measured aircraft cannot be sized; allowed: parametric")
    refuse_climb(case, "size")
    if not goal.of_range and weather_file is None:
        refuse_polar_night(case)
    require_path(case)
    if reliability is not None:
        with uncertain_inputs_of(case):
            check_reliability(case.aircraft, case.mission, goal, case.solar, reliability)
    if out_dir is not None:
        if not out_dir:
            raise click.BadParameter("needs the name of a folder", param_hint="--out")
        check_writable_folder(Path(out_dir))
    check_report(report_file, option="--report")
    if weather_file is not None and survive is not None:
        record_read = load_weather(weather_file)
        with progress_of("steps of the search") as progress:
            study = size_in_weather(
                *(case.aircraft, case.mission, record_read, goal),
                survive=survive,
                model=case.solar.model,
                correction=case.solar.correction,
                progress=progress,
            )
    else:
        study = sizing.size(
            *(case.aircraft, case.mission, goal),
            model=case.solar.model,
            correction=case.solar.correction,
            with_sensitivities=with_sensitivities,
            with_cross_check=with_cross_check,
            reliability=reliability,
        )
    record = case.named(study.to_dict())
    written = out_dir if study.feasible else None
    reported = report_file if study.feasible else None
    with told(
        *(case, record, study),
        out_dir=written,
        files=(reported,),
        next_step=_next_step(study, written),
    ):
        if written is not None:
            read = case.inputs() if weather_file is None else case.inputs_with_weather(weather_file)
            inputs, tables = sized_inputs(study, read), sizing_tables(study)
            write_run_folder(Path(written), inputs, record, tables, sizing_figures(study, figure))
        if reported is not None:
            report_on_sizing(case, study, record, reported, overrides=asked.overrides)
    if not study.feasible:
        sys.exit(EXIT_FAILED)
