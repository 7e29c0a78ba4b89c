"""The command ``solar-uav sweep``."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import click

from missions.files.errors import InputError
from solar.names import RESIZE_NAMES
from studies.cli.help_texts import command
from studies.cli.options import (
    EXIT_FAILED,
    Asked,
    Parsed,
    WorkOptions,
    aircraft_argument,
    check_image,
    check_table,
    completes,
    figure_options,
    mission_option,
    solar_options,
    work_options,
)
from studies.cli.telling import tell_error
from studies.output.figures.options import FigureOptions

if TYPE_CHECKING:
    from studies.sweeps.axes import Axis

_SAMPLES = ("grid", "lhs", "sobol", "one-at-a-time")
_MOST_SAMPLES = 1_000_000
_TOP = 40


@command("solar-uav sweep atlantiksolar-design --vary battery_mass_kg=2:4:0.5")
@aircraft_argument()
@mission_option()
@click.option(
    "--vary",
    "axes",
    type=Parsed("key=values", "studies.sweeps.axes:parse_axis", stepped=True),
    multiple=True,
    required=True,
    shell_complete=completes("axes"),
    help="KEY=first:last:step (last is met where the steps lead to it) or KEY=v1,v2,...; a key as "
    "of --set, or wingspan_m, aspect_ratio, battery_mass_kg, module_area_m2. May be repeated.",
)
@click.option(
    "--resize",
    "objective",
    type=click.Choice(RESIZE_NAMES),
    help="Size each point for it; varied design variables are held.",
)
@click.option(
    "--cover/--no-cover",
    default=None,
    help="Fill the wing with modules, to maximum_module_coverage.  [default: where a parametric "
    "wing is varied and the module area is not]",
)
@click.option(
    "--sample",
    type=click.Choice(_SAMPLES),
    default="grid",
    show_default=True,
    help="All combinations; points drawn between least and largest values; or one key at a time.",
)
@click.option(
    "--samples",
    type=click.IntRange(1, _MOST_SAMPLES),
    default=64,
    show_default=True,
    help="Number of points that lhs and sobol draw.",
)
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="For drawing.")
@click.option(
    "--out", "out_file", type=click.Path(), help="Write all points (nc, csv, parquet, xlsx)."
)
@click.option("--plot", "plot_file", type=click.Path(), help="Draw the study (png, svg, pdf).")
@click.option(
    "--pareto",
    nargs=2,
    metavar="X Y",
    shell_complete=completes("pareto"),
    help="Only the front of two results or varied keys, e.g. wingspan payload_mass: the points "
    "that no other beats in both.",
)
@click.option(
    "--sort",
    metavar="KEY",
    shell_complete=completes("sort"),
    help="Sort the table by a result or varied key, the least first; by -KEY the largest first.  "
    "[default: the best first]",
)
@click.option(
    "--top",
    type=click.IntRange(1),
    metavar="N",
    default=_TOP,
    show_default=True,
    help="Rows of the table.",
)
@work_options
@solar_options
@figure_options
def sweep(
    asked: Asked,
    axes: tuple[Axis, ...],
    objective: str | None,
    cover: bool | None,
    sample: str,
    samples: int,
    seed: int,
    out_file: str | None,
    plot_file: str | None,
    figure: FigureOptions,
    pareto: tuple[str, str] | None,
    sort: str | None,
    top: int,
    work: WorkOptions,
) -> None:
    """Trade study: vary keys of AIRCRAFT (name, file or folder) and mission, each point judged.

    The exit code is 1 if any point could not be computed.
    """
    from missions.files.writing import write_files_atomically
    from studies.cli.checks import check_outputs, refuse_climb, require_path
    from studies.cli.jobs import completed
    from studies.cli.outputs import call, figure_bytes, told
    from studies.sweeps import study
    from studies.sweeps.axes import axis_names
    from studies.sweeps.files import FORMATS, table_format, to_bytes
    from studies.sweeps.points import BLANKS, SIZED_BLANKS
    from studies.sweeps.results import front_record, points_record, points_summary

    if pareto is not None and sort is not None:
        raise click.UsageError("a front has its own order: give --pareto or --sort")
    blanks = BLANKS if objective is None else SIZED_BLANKS
    varied = axis_names(axes)
    numbers = [n for n, axis in zip(varied, axes, strict=True) if not axis.names]
    numbers += [*(n for n, blank in blanks.items() if isinstance(blank, float))]
    texts = [n for n in varied if n not in numbers]
    _check_names("--pareto", pareto or (), numbers)
    sorted_by = () if sort is None else (sort.removeprefix("-"),)
    _check_names("--sort", sorted_by, ["status", *texts, *numbers])
    check_image(plot_file)
    file_format = None if out_file is None else table_format(out_file)
    if out_file is not None:
        check_table(out_file, file_format, FORMATS, "--out")
    case = asked.case()
    refuse_climb(case, "sweep")
    require_path(case)
    try:
        prepared = study.prepare(
            *(case.aircraft, case.mission, axes, case.solar),
            sample=sample,  # type: ignore[arg-type]  # click checked it
            samples=samples,
            seed=seed,
            resize=objective,
            cover=cover,
        )
    except InputError as error:
        named = [replace(p, source=f"--vary {p.source}") for p in error.problems]
        raise InputError(named) from None
    check_outputs(out=out_file, plot=plot_file)
    with completed(prepared.job, work, out_file, "points") as outcome:
        data = study.dataset(prepared, outcome)
        record = case.named(points_record(data))
        if pareto is not None:
            record |= front_record(data, *pareto)
        contents: dict[str | os.PathLike[str], bytes] = {}
        trouble = None
        with told(
            *(case, record, lambda: points_summary(data, sort=sort, top=top, front=pareto)),
            files=contents,
            next_step=f"{call('explore')} (the same with sliders)",
        ):
            if out_file is not None and file_format is not None:
                contents[out_file] = to_bytes(data, file_format)
            if plot_file is not None:
                from studies.sweeps.plots import plot_pareto, plot_sweep

                try:
                    drawn = (
                        plot_sweep(data, figure=figure)
                        if pareto is None
                        else plot_pareto(data, *pareto, figure=figure)
                    )
                    contents[plot_file] = figure_bytes(drawn, plot_file)
                except ValueError as error:
                    # The points are worth keeping even where there is nothing to draw.
                    trouble = str(error)
            write_files_atomically(contents)
        if trouble is not None:
            tell_error(f"solar-uav: no chart: {trouble}")
    if trouble is not None:
        sys.exit(EXIT_FAILED)


def _check_names(option: str, names: Sequence[str], allowed: list[str]) -> None:
    """Refuse names that no result will have before the work starts."""
    for name in names:
        if name not in allowed:
            known = ", ".join(dict.fromkeys(allowed))
            raise click.BadParameter(f"{name!r} is not one of {known}", param_hint=option)
