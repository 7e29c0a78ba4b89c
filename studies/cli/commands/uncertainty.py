"""The command ``solar-uav uncertainty``."""

from __future__ import annotations

from dataclasses import dataclass

import click

from studies.cli.command import Command, option
from studies.cli.options import CaseOptions, case_options, figure_options, plot_option, table_option
from studies.output.figures.options import FigureOptions


@dataclass(frozen=True)
class Uncertainty:
    """Find how likely AIRCRAFT (name, file or folder) flies perpetually when its inputs scatter."""

    case: CaseOptions = case_options()
    samples: int = option(
        "--samples",
        type=click.IntRange(64, 2**20),
        default=8192,
        show_default=True,
        help="Draws of all uncertain inputs, rounded up to a power of two.",
    )
    seed: int = option(
        "--seed",
        type=click.IntRange(0, 2**31),
        default=0,
        show_default=True,
        help="The same seed gives the same draws.",
    )
    no_model_error: bool = option(
        "--no-model-error",
        is_flag=True,
        help="Leave out the error of the solar power model, which is an input by itself.",
    )
    table_file: str | None = table_option("the draws")
    plot_file: str | None = plot_option("Draw them")
    figure: FigureOptions = figure_options()


uncertainty = Command(
    "uncertainty",
    Uncertainty,
    "uncertainty:uncertainty",
    "solar-uav uncertainty atlantiksolar-as2 --samples 1024",
)
