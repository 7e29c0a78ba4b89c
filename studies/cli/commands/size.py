"""The command ``solar-uav size``."""

from __future__ import annotations

import shlex
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from sizing.optimisation.objectives import OBJECTIVE_NAMES, Objective
from studies.cli.help_texts import command
from studies.cli.options import (
    EXIT_FAILED,
    Asked,
    RealRange,
    aircraft_argument,
    completes,
    figure_options,
    gathered,
    mission_option,
    out_option,
    report_option,
    required_time_option,
    solar_options,
)
from studies.output.figures.options import FigureOptions

if TYPE_CHECKING:
    from sizing.results.sizing import SizingStudy
    from studies.cli.files import Case


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


@dataclass(frozen=True)
class _Sizing:
    """What is to be found, and how it is judged."""

    objective: str
    with_sensitivities: bool
    with_cross_check: bool
    reliability: float | None
    weather_file: str | None
    survive: float | None

    def __post_init__(self) -> None:
        """Refuse what does not go together."""
        of_optimum = self.with_sensitivities or self.with_cross_check
        if self.goal.of_range and of_optimum:
            raise click.UsageError(
                f"{self.objective} counts days or degrees: it has no sensitivities and no "
                "cross-check"
            )
        if self.reliability is not None and of_optimum:
            raise click.UsageError("--sensitivities and --cross-check know of no --reliability")
        if (self.weather_file is None) != (self.survive is None):
            names = ("--weather", "--survive")
            given, other = names if self.survive is None else names[::-1]
            raise click.UsageError(f"{given} needs {other} as well")
        if self.survive is not None:
            self._check_weather(self.survive)

    @property
    def goal(self) -> Objective:
        """Objective of the optimiser."""
        return Objective(self.objective)

    def _check_weather(self, survive: float) -> None:
        """Refuse a share of days together with what is asked of clear days."""
        from sizing.margins.seasons import check_survival

        options = click.get_current_context().params
        if options["report_file"] is not None:
            raise click.UsageError(
                "--report is of repeated clear days: use --out FOLDER, then solar-uav report "
                "FOLDER --weather FILE"
            )
        others = {
            "--sensitivities": self.with_sensitivities,
            "--cross-check": self.with_cross_check,
            "--reliability": self.reliability is not None,
            "--required-excess-time": options["required_h"] is not None,
        }
        for option, given in others.items():
            if given:
                raise click.UsageError(
                    f"{option} is of repeated clear days: leave it out, or --weather with --survive"
                )
        try:
            check_survival(self.goal, survive)
        except ValueError as error:
            raise click.UsageError(str(error)) from error

    def check(self, case: Case) -> None:
        """Refuse an aircraft or a mission that cannot be sized so."""
        from sizing.margins.probability import check_reliability
        from studies.cli import checks

        checks.require_parametric(case, "a measured aircraft cannot be sized; allowed: parametric")
        checks.refuse_climb(case, "size")
        if not self.goal.of_range and self.weather_file is None:
            checks.refuse_polar_night(case)
        checks.require_path(case)
        if self.reliability is not None:
            with checks.uncertain_inputs_of(case):
                check_reliability(
                    *(case.aircraft, case.mission, self.goal, case.solar, self.reliability)
                )

    def run(self, case: Case) -> SizingStudy:
        """Find the design."""
        from missions.weather.files import load_weather
        from sizing.results import sizing
        from sizing.results.weather_sizing import size_in_weather
        from studies.cli.progress import progress_of

        model, correction = case.solar.model, case.solar.correction
        if self.weather_file is None or self.survive is None:
            return sizing.size(
                *(case.aircraft, case.mission, self.goal),
                model=model,
                correction=correction,
                with_sensitivities=self.with_sensitivities,
                with_cross_check=self.with_cross_check,
                reliability=self.reliability,
            )
        weather = load_weather(self.weather_file)
        with progress_of("steps of the search") as progress:
            return size_in_weather(
                *(case.aircraft, case.mission, weather, self.goal),
                survive=self.survive,
                model=model,
                correction=correction,
                progress=progress,
            )


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
@gathered("sizing", _Sizing)
def size(
    asked: Asked,
    sizing: _Sizing,
    out_dir: str | None,
    figure: FigureOptions,
    report_file: str | None,
) -> None:
    """Find the best design of AIRCRAFT (name, file or folder) for a mission."""
    from missions.files.writing import check_writable_folder
    from studies.cli.outputs import told
    from studies.cli.reports import check_report, report_on_sizing
    from studies.output.run_folder import write_run_folder
    from studies.output.sizing_files import sized_inputs, sizing_figures, sizing_tables

    case = asked.case()
    sizing.check(case)
    if out_dir is not None:
        if not out_dir:
            raise click.BadParameter("needs the name of a folder", param_hint="--out")
        check_writable_folder(Path(out_dir))
    check_report(report_file, option="--report")
    study = sizing.run(case)
    record = case.named(study.to_dict())
    written, reported = (out_dir, report_file) if study.feasible else (None, None)
    with told(
        *(case, record, study),
        out_dir=written,
        files=(reported,),
        next_step=_next_step(study, written),
    ):
        if written is not None:
            inputs = sized_inputs(study, case.inputs(sizing.weather_file))
            contents = sizing_tables(study), sizing_figures(study, figure)
            write_run_folder(Path(written), inputs, record, *contents)
        if reported is not None:
            report_on_sizing(case, study, record, reported, overrides=asked.overrides)
    if not study.feasible:
        sys.exit(EXIT_FAILED)
