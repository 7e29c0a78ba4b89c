"""The command ``solar-uav compare``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.shell_completion import CompletionItem

from sizing.optimisation.objectives import RESIZE_NAMES
from solar.names import (
    ATTITUDE_MODELS,
    CORRECTION_NAMES,
    MODEL_NAMES,
    CorrectionName,
    ModelName,
)
from studies.cli.help_texts import command
from studies.cli.options import (
    EXIT_FAILED,
    Asked,
    ParamType,
    aircraft_argument,
    case_options,
    check_image,
    figure_options,
    mission_option,
    out_option,
    required_time_option,
    table_option,
)
from studies.output.figures.options import FigureOptions
from studies.output.formats import csv_bytes, table_bytes

if TYPE_CHECKING:
    from studies.models.comparison import Comparison
    from studies.output.run_folder import RunInputs

DEFAULT_OBJECTIVE = "min_wingspan"


class Names(ParamType["tuple[str, ...]"]):
    """Names separated by commas, each of a given set."""

    name = "a,b"

    def __init__(self, allowed: tuple[str, ...]) -> None:
        self.allowed = allowed

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem[str]]:
        """Names that may follow the last comma."""
        head, comma, tail = incomplete.rpartition(",")
        some = (name for name in self.allowed if name.lower().startswith(tail.lower()))
        return [CompletionItem(f"{head}{comma}{name}") for name in some]

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, ...]:
        """Read the names in their usual order, without repetition.

        Returns names, those of ``allowed``.
        """
        by_lower = {name.lower(): name for name in self.allowed}
        found = []
        for part in str(value).split(","):
            name = by_lower.get(part.strip().lower())
            if name is None:
                allowed = ", ".join(self.allowed)
                self.fail(f"{part.strip()!r} is not one of {allowed}", param, ctx)
            found.append(name)
        return tuple(name for name in self.allowed if name in found)


@command("solar-uav compare atlantiksolar-design --objective min_mass --table models.csv")
@aircraft_argument()
@mission_option()
@click.option(
    "--models",
    type=Names(MODEL_NAMES),
    metavar="M,M,...",
    help=f"Models to compare.  [default: {','.join(MODEL_NAMES)}]",
)
@click.option(
    "--corrections",
    type=Names(CORRECTION_NAMES),
    metavar="C,C,...",
    help=f"Corrections to compare.  [default: {','.join(CORRECTION_NAMES)}]",
)
@click.option(
    "--objective",
    type=click.Choice(RESIZE_NAMES),
    default=DEFAULT_OBJECTIVE,
    show_default=True,
    help="What a parametric aircraft is sized for with every model.",
)
@required_time_option
@click.option("--no-design", is_flag=True, help="Compare predictions only, size nothing.")
@case_options
@out_option("figure")
@table_option("the table")
@click.option("--plot", "plot_file", type=click.Path(), help="Draw the figure (png, svg, pdf).")
@figure_options
def compare(
    asked: Asked,
    models: tuple[ModelName, ...] | None,
    corrections: tuple[CorrectionName, ...] | None,
    objective: str,
    no_design: bool,
    out_dir: str | None,
    table_file: str | None,
    plot_file: str | None,
    figure: FigureOptions,
) -> None:
    """Compare what the solar power models say of AIRCRAFT, and what each would have built."""
    from missions.files.writing import check_writable_folder
    from studies.cli.checks import check_outputs, refuse_climb, refuse_polar_night, require_path
    from studies.cli.outputs import told
    from studies.cli.progress import progress_of
    from studies.models.comparison import compare as compare_models
    from studies.models.solar_models import attitude_is_known

    if out_dir is not None and (table_file is not None or plot_file is not None):
        raise click.UsageError("give --out, or --table and --plot, not both")
    check_image(plot_file)
    check_outputs(table=table_file, plot=plot_file)
    if out_dir is not None:
        check_writable_folder(Path(out_dir))
    case = asked.case()
    refuse_climb(case, "compare")
    refuse_polar_night(case)
    needs_path = _needs_path(models, corrections)
    if needs_path is not None or attitude_is_known(case.aircraft, case.mission):
        # With surfaces and a path, the reference flies it even if no case does.
        require_path(case, needs_path or "the reference")
    with progress_of("models", lines=False) as progress:
        found = compare_models(
            *(case.aircraft, case.mission),
            models=models,
            corrections=corrections,
            objective=objective,
            design=not no_design,
            progress=progress,
        )
    record = case.named(found.to_dict())
    files = () if out_dir is not None else (table_file, plot_file)
    with told(case, record, found, out_dir=out_dir, files=files):
        if out_dir is None:
            _write_files(found, table_file, plot_file, figure)
        else:
            _write_folder(found, Path(out_dir), case.inputs(), record, figure)
    sized = [one.built for one in found.cases if one.built is not None]
    if sized and all(built.judged is None for built in sized):
        sys.exit(EXIT_FAILED)


def _write_files(
    found: Comparison, table_file: str | None, plot_file: str | None, figure: FigureOptions
) -> None:
    from studies.cli.outputs import write_results
    from studies.models.plots import plot_comparison

    write_results(
        table_file,
        lambda: table_bytes(found.to_frame(), table_file, title="models"),
        plot_file,
        lambda: plot_comparison(found, figure=figure),
    )


def _write_folder(
    found: Comparison, folder: Path, inputs: RunInputs, record: Any, figure: FigureOptions
) -> None:
    from studies.cli.outputs import figure_bytes
    from studies.models.plots import plot_comparison
    from studies.output.run_folder import write_run_folder

    contents = {"comparison.csv": csv_bytes(found.to_frame())}
    image = "comparison.png"
    drawn = {image: lambda: figure_bytes(plot_comparison(found, figure=figure), image)}
    write_run_folder(folder, inputs, record, contents, drawn)


def _needs_path(models: tuple[str, ...] | None, corrections: tuple[str, ...] | None) -> str | None:
    """Option that needs module surfaces and a flight path, None where there is none."""
    attitude = next((f"--models {m}" for m in models or () if m in ATTITUDE_MODELS), None)
    if attitude is None and "loiter" in (corrections or ()):
        return "--corrections loiter"
    return attitude
