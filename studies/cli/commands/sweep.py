"""The command ``solar-uav sweep``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import click

from sizing.program.objectives import RESIZE_NAMES
from studies.cli.command import Command, Parsed, option
from studies.cli.options import (
    CaseOptions,
    WorkOptions,
    case_options,
    figure_options,
    grid_option,
    mass_option,
    plot_option,
    work_options,
)
from studies.output.figures.options import FigureOptions

if TYPE_CHECKING:
    from studies.sweeps.axes import Axis, SampleName

_SAMPLES = ("grid", "lhs", "sobol", "one-at-a-time")
_MOST_SAMPLES = 1_000_000
_TOP = 15


@dataclass(frozen=True)
class Sweep:
    """Trade study: vary keys of AIRCRAFT (name, file or folder) and mission, each point judged.

    The exit code is 1 if any point could not be computed.
    """

    case: CaseOptions = case_options()
    mass_kg: float | None = mass_option()
    axes: tuple[Axis, ...] = option(
        "--vary",
        type=Parsed("key=values", "studies.sweeps.axes:parse_axis", stepped=True),
        multiple=True,
        required=True,
        help="KEY=first:last:step (last is met where the steps lead to it) or KEY=v1,v2,...; a key "
        "as of --set, or wingspan_m, aspect_ratio, battery_mass_kg, module_area_m2. May be "
        "repeated.",
    )
    objective: str | None = option(
        "--resize",
        type=click.Choice(RESIZE_NAMES),
        help="Size each point for it; varied design variables are held.",
    )
    cover: bool | None = option(
        "--cover/--no-cover",
        default=None,
        help="Fill the wing with modules, to maximum_module_coverage.  [default: where a "
        "parametric wing is varied and the module area is not]",
    )
    sample: SampleName = option(
        "--sample",
        type=click.Choice(_SAMPLES),
        default="grid",
        show_default=True,
        help="All combinations; points drawn between least and largest values; or one key at a "
        "time.",
    )
    samples: int = option(
        "--samples",
        type=click.IntRange(1, _MOST_SAMPLES),
        default=64,
        show_default=True,
        help="Number of points that lhs and sobol draw.",
    )
    seed: int = option(
        "--seed", type=click.IntRange(0), default=0, show_default=True, help="For drawing."
    )
    out_file: str | None = grid_option("all points")
    plot_file: str | None = plot_option("Draw the study")
    pareto: tuple[str, str] | None = option(
        "--pareto",
        nargs=2,
        metavar="X Y",
        help="Only the front of two results or varied keys, e.g. wingspan payload_mass: the points "
        "for which no other is better in both.",
    )
    sort: str | None = option(
        "--sort",
        metavar="KEY",
        help="Sort the table by a result or varied key, the least first; by -KEY the largest "
        "first.  [default: from best to worst]",
    )
    top: int = option(
        "--top",
        type=click.IntRange(1),
        metavar="N",
        default=_TOP,
        show_default=True,
        help="Rows of the table.",
    )
    work: WorkOptions = work_options()
    figure: FigureOptions = figure_options()

    def __post_init__(self) -> None:
        """Refuse what does not go together."""
        if self.pareto is not None and self.sort is not None:
            raise click.UsageError("a front has its own order: give --pareto or --sort")


sweep = Command(
    "sweep",
    Sweep,
    "sweep:sweep",
    "solar-uav sweep atlantiksolar-design --vary battery_mass_kg=2:4:0.5",
)
