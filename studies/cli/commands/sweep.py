"""The command ``solar-uav sweep``."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import click

from missions.files.errors import InputError
from sizing.optimisation.objectives import RESIZE_NAMES
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
    gathered,
    mission_option,
    solar_options,
    work_options,
)
from studies.cli.telling import tell_error
from studies.output.figures.options import FigureOptions

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from xarray import Dataset

    from sizing.results.tables import Summary
    from studies.cli.files import Case
    from studies.grid import GridStudy
    from studies.sweeps.axes import Axis, SampleName

_SAMPLES = ("grid", "lhs", "sobol", "one-at-a-time")
_MOST_SAMPLES = 1_000_000
_TOP = 40


@dataclass(frozen=True)
class _Points:
    """Which points there are, and how each is judged."""

    axes: tuple[Axis, ...]
    objective: str | None
    cover: bool | None
    sample: SampleName
    samples: int
    seed: int

    def prepared(self, case: Case) -> GridStudy:
        """Points ready to be computed; what is wrong with them is told by the option."""
        from studies.sweeps.study import prepare

        try:
            return prepare(
                *(case.aircraft, case.mission, self.axes, case.solar),
                sample=self.sample,
                samples=self.samples,
                seed=self.seed,
                resize=self.objective,
                cover=self.cover,
            )
        except InputError as error:
            named = [replace(p, source=f"--vary {p.source}") for p in error.problems]
            raise InputError(named) from None


@dataclass(frozen=True)
class _Shown:
    """Which points are printed and drawn, and in which order."""

    pareto: tuple[str, str] | None
    sort: str | None
    top: int

    def check(self, points: _Points) -> None:
        """Refuse names that no result will have, before the work starts."""
        from studies.sweeps.axes import axis_names
        from studies.sweeps.points import BLANKS, SIZED_BLANKS

        if self.pareto is not None and self.sort is not None:
            raise click.UsageError("a front has its own order: give --pareto or --sort")
        blanks = BLANKS if points.objective is None else SIZED_BLANKS
        varied = axis_names(points.axes)
        numbers = [n for n, axis in zip(varied, points.axes, strict=True) if not axis.names]
        numbers += [*(n for n, blank in blanks.items() if isinstance(blank, float))]
        texts = [n for n in varied if n not in numbers]
        _check_names("--pareto", self.pareto or (), numbers)
        sorted_by = () if self.sort is None else (self.sort.removeprefix("-"),)
        _check_names("--sort", sorted_by, ["status", *texts, *numbers])

    def record(self, data: Dataset) -> dict[str, Any]:
        """What JSON says."""
        from studies.sweeps.results import front_record, points_record

        front = {} if self.pareto is None else front_record(data, *self.pareto)
        return points_record(data) | front

    def summary(self, data: Dataset) -> Summary:
        """What is printed."""
        from studies.sweeps.results import points_summary

        return points_summary(data, sort=self.sort, top=self.top, front=self.pareto)

    def figure(self, data: Dataset, options: FigureOptions) -> Figure:
        """Chart of the points, or of their front."""
        from studies.sweeps.plots import plot_pareto, plot_sweep

        if self.pareto is None:
            return plot_sweep(data, figure=options)
        return plot_pareto(data, *self.pareto, figure=options)


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
@gathered("points", _Points)
@gathered("shown", _Shown)
def sweep(
    asked: Asked,
    points: _Points,
    shown: _Shown,
    out_file: str | None,
    plot_file: str | None,
    figure: FigureOptions,
    work: WorkOptions,
) -> None:
    """Trade study: vary keys of AIRCRAFT (name, file or folder) and mission, each point judged.

    The exit code is 1 if any point could not be computed.
    """
    from missions.files.writing import write_files_atomically
    from studies.cli.checks import check_outputs, refuse_climb, require_path
    from studies.cli.jobs import completed
    from studies.cli.outputs import call, figure_bytes, told
    from studies.sweeps.files import FORMATS, table_format, to_bytes
    from studies.sweeps.study import dataset

    shown.check(points)
    check_image(plot_file)
    file_format = None if out_file is None else table_format(out_file)
    if out_file is not None:
        check_table(out_file, file_format, FORMATS, "--out")
    case = asked.case()
    refuse_climb(case, "sweep")
    require_path(case)
    prepared = points.prepared(case)
    check_outputs(out=out_file, plot=plot_file)
    with completed(prepared.job, work, out_file, "points") as outcome:
        data = dataset(prepared, outcome)
        contents: dict[str | os.PathLike[str], bytes] = {}
        trouble = None
        with told(
            *(case, case.named(shown.record(data)), lambda: shown.summary(data)),
            files=contents,
            next_step=f"{call('explore')} (the same with sliders)",
        ):
            if out_file is not None and file_format is not None:
                contents[out_file] = to_bytes(data, file_format)
            if plot_file is not None:
                try:
                    contents[plot_file] = figure_bytes(shown.figure(data, figure), plot_file)
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
