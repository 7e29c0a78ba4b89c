"""The command ``solar-uav uncertainty``."""

from __future__ import annotations

import click

from studies.cli.help_texts import command
from studies.cli.options import (
    Asked,
    aircraft_argument,
    check_image,
    figure_options,
    mission_option,
    solar_options,
    table_option,
)
from studies.output.figures.options import FigureOptions
from studies.output.formats import table_bytes


@command("solar-uav uncertainty atlantiksolar-as2 --samples 1024")
@aircraft_argument()
@mission_option()
@click.option(
    "--samples",
    type=click.IntRange(64, 2**20),
    default=8192,
    show_default=True,
    help="Draws of all uncertain inputs, rounded up to a power of two.",
)
@click.option(
    "--seed",
    type=click.IntRange(0, 2**31),
    default=0,
    show_default=True,
    help="The same seed gives the same draws.",
)
@click.option(
    "--no-model-error",
    is_flag=True,
    help="Leave out the error of the solar power model, which is an input by itself.",
)
@table_option("the draws")
@click.option("--plot", "plot_file", type=click.Path(), help="Draw them (png, svg, pdf).")
@solar_options
@figure_options
def uncertainty(
    asked: Asked,
    samples: int,
    seed: int,
    no_model_error: bool,
    table_file: str | None,
    plot_file: str | None,
    figure: FigureOptions,
) -> None:
    """Find how likely AIRCRAFT (name, file or folder) flies perpetually when its inputs scatter."""
    from sizing.results.uncertainty import analyse_uncertainty
    from studies.cli.checks import (
        check_outputs,
        refuse_climb,
        require_path,
        uncertain_inputs_of,
    )
    from studies.cli.outputs import told, write_results
    from studies.uncertainty.plots import plot_uncertainty

    check_image(plot_file)
    check_outputs(table=table_file, plot=plot_file)
    case = asked.case()
    refuse_climb(case, "uncertainty")
    require_path(case)
    with uncertain_inputs_of(case):
        result = analyse_uncertainty(
            case.aircraft,
            case.mission,
            model=case.solar.model,
            correction=case.solar.correction,
            samples=samples,
            seed=seed,
            model_error=not no_model_error,
        )
    record, files = case.named(result.to_dict()), (table_file, plot_file)
    with told(case, record, result, files=files):
        write_results(
            table_file,
            lambda: table_bytes(result.to_frame(), table_file, title="draws"),
            plot_file,
            lambda: plot_uncertainty(result, figure=figure),
        )
