"""The command ``solar-uav ceiling``."""

from __future__ import annotations

import click

from studies.cli.help_texts import command
from studies.cli.options import (
    EXIT_FAILED,
    Asked,
    RealRange,
    aircraft_argument,
    check_image,
    figure_options,
    mission_option,
    solar_options,
    table_option,
)
from studies.output.figures.options import FigureOptions
from studies.output.formats import table_bytes

_HIGHEST_M, _LEAST_STEP_M = 32000.0, 10.0


@command("solar-uav ceiling atlantiksolar-as2 --plot ceiling.png")
@aircraft_argument()
@mission_option()
@click.option(
    "--highest",
    "highest_m",
    type=RealRange(-500.0, _HIGHEST_M, unit="metres"),
    default=20000.0,
    show_default=True,
    metavar="METRES",
    help="End of the search, which starts at the mission's altitude.",
)
@click.option(
    "--step",
    "step_m",
    type=RealRange(_LEAST_STEP_M, 10000.0, unit="metres"),
    default=250.0,
    show_default=True,
    metavar="METRES",
    help="Spacing of the altitudes that are tried.",
)
@table_option("the altitudes")
@click.option("--plot", "plot_file", type=click.Path(), help="Draw them (png, svg, pdf).")
@solar_options
@figure_options
def ceiling(
    asked: Asked,
    highest_m: float,
    step_m: float,
    table_file: str | None,
    plot_file: str | None,
    figure: FigureOptions,
) -> None:
    """Find how high AIRCRAFT (name, file or folder) flies perpetually; exit code 1 if nowhere."""
    from studies.ceiling import perpetual_ceiling, plot_ceiling
    from studies.cli.checks import check_outputs, refuse_climb, refuse_polar_night, require_path
    from studies.cli.outputs import told, write_results
    from studies.cli.progress import progress_of

    check_image(plot_file)
    check_outputs(table=table_file, plot=plot_file)
    case = asked.case()
    refuse_climb(case, "ceiling")
    refuse_polar_night(case)
    require_path(case)
    lowest_m = case.mission.altitude_m
    if highest_m <= lowest_m:
        message = f"must be above the mission's altitude_m of {lowest_m:g} (got {highest_m:g})"
        raise click.BadParameter(message, param_hint="--highest")
    with progress_of("altitudes", lines=False) as progress:
        result = perpetual_ceiling(
            *(case.aircraft, case.mission),
            model=case.solar.model,
            correction=case.solar.correction,
            highest_m=highest_m,
            step_m=step_m,
            progress=progress,
        )
    record, files = case.named(result.to_dict()), (table_file, plot_file)
    with told(case, record, result, files=files):
        write_results(
            table_file,
            lambda: table_bytes(result.to_frame(), table_file, title="altitudes"),
            plot_file,
            lambda: plot_ceiling(result, figure=figure),
        )
    if result.found.highest is None:
        raise SystemExit(EXIT_FAILED)
