"""The command ``solar-uav compare``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import click

from sizing.program.objectives import RESIZE_NAMES
from solar.names import ATTITUDE_MODELS, CORRECTION_NAMES, MODEL_NAMES, CorrectionName, ModelName
from studies.cli.command import Command, ParamType, option
from studies.cli.options import (
    CaseOptions,
    case_options,
    figure_options,
    out_option,
    plot_option,
    required_time_option,
    table_option,
)
from studies.output.figures.options import FigureOptions

DEFAULT_OBJECTIVE = "min_wingspan"


class Names(ParamType["tuple[str, ...]"]):
    """Names separated by commas, each of a given set."""

    name = "a,b"

    def __init__(self, allowed: tuple[str, ...]) -> None:
        self.allowed = allowed

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, ...]:
        """Read the names in their usual order, without repetition.

        Returns names, those of ``allowed``.
        """
        by_lower = {name.lower(): name for name in self.allowed}
        models = []
        for part in str(value).split(","):
            name = by_lower.get(part.strip().lower())
            if name is None:
                allowed = ", ".join(self.allowed)
                self.fail(f"{part.strip()!r} is not one of {allowed}", param, ctx)
            models.append(name)
        return tuple(name for name in self.allowed if name in models)


@dataclass(frozen=True)
class Compare:
    """Compare what the solar power models say of AIRCRAFT, and what each would have built."""

    case: CaseOptions = case_options(with_models=False, with_levels=True)
    models: tuple[ModelName, ...] | None = option(
        "--models",
        type=Names(MODEL_NAMES),
        metavar="M,M,...",
        help=f"Models to compare.  [default: {','.join(MODEL_NAMES)}]",
    )
    corrections: tuple[CorrectionName, ...] | None = option(
        "--corrections",
        type=Names(CORRECTION_NAMES),
        metavar="C,C,...",
        help=f"Corrections to compare.  [default: {','.join(CORRECTION_NAMES)}]",
    )
    objective: str = option(
        "--objective",
        type=click.Choice(RESIZE_NAMES),
        default=DEFAULT_OBJECTIVE,
        show_default=True,
        help="What a parametric aircraft is sized for with every model.",
    )
    required_h: float | None = required_time_option()
    no_design: bool = option(
        "--no-design", is_flag=True, help="Compare predictions only, size nothing."
    )
    out_dir: str | None = out_option("figure")
    table_file: str | None = table_option("the table")
    plot_file: str | None = plot_option("Draw the figure")
    figure: FigureOptions = figure_options()

    def __post_init__(self) -> None:
        """Refuse what does not go together."""
        files = (self.table_file, self.plot_file)
        if self.out_dir is not None and files != (None, None):
            raise click.UsageError("give --out, or --table and --plot, not both")

    @property
    def needs_path(self) -> str | None:
        """Option that needs module surfaces and a flight path, None where there is none."""
        for model in self.models or ():
            if model in ATTITUDE_MODELS:
                return f"--models {model}"
        return "--corrections loiter" if "loiter" in (self.corrections or ()) else None


compare = Command(
    "compare",
    Compare,
    "compare:compare",
    "solar-uav compare atlantiksolar-design --objective min_mass --table models.csv",
)
