"""The command ``solar-uav compare``."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from solar.names import ATTITUDE_MODELS, CORRECTION_NAMES, MODEL_NAMES, RESIZE_NAMES
from studies.cli.checks import refuse_climb
from studies.cli.options import (
    EXIT_FAILED,
    check_image,
    check_outputs,
    csv_bytes,
    figure_bytes,
    json_option,
    load,
    mission_option,
    print_json,
    progress_bar,
    refuse_polar_night,
    require_path_for,
    required_time_option,
    set_option,
    write_results,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from solar.names import CorrectionName, ModelName
    from studies.cli.library import LoadedAircraft, LoadedMission
    from studies.models.comparison import Comparison

DEFAULT_OBJECTIVE = "min_wingspan"


class Names(click.ParamType["tuple[str, ...]"]):
    """Names separated by commas, each of a given set."""

    name = "a,b"

    def __init__(self, allowed: tuple[str, ...]) -> None:
        self.allowed = allowed

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, ...]:
        """Read the names in their usual order, without repetition."""
        by_lower = {name.lower(): name for name in self.allowed}
        found = []
        for part in str(value).split(","):
            name = by_lower.get(part.strip().lower())
            if name is None:
                allowed = ", ".join(self.allowed)
                self.fail(f"{part.strip()!r} is not one of {allowed}", param, ctx)
            found.append(name)
        return tuple(name for name in self.allowed if name in found)


@click.command(short_help="All solar power models side by side.")
@click.argument("aircraft")
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
@set_option
@json_option
@click.option("--out", "out_dir", type=click.Path(), help="Folder for table, JSON and figure.")
@click.option("--csv", "csv_file", type=click.Path(), help="Write the table as CSV.")
@click.option("--plot", "plot_file", type=click.Path(), help="Draw the figure (png, svg, pdf).")
def compare(
    aircraft: str,
    mission: str,
    models: tuple[ModelName, ...] | None,
    corrections: tuple[CorrectionName, ...] | None,
    objective: str,
    required_h: float | None,
    no_design: bool,
    overrides: tuple[str, ...],
    as_json: bool,
    out_dir: str | None,
    csv_file: str | None,
    plot_file: str | None,
) -> None:
    """Compare what the solar power models say of AIRCRAFT, and what each would have built."""
    if out_dir is not None and (csv_file is not None or plot_file is not None):
        raise click.UsageError("give --out, or --csv and --plot, not both")
    check_image(plot_file)
    check_outputs(csv=csv_file, plot=plot_file)
    if out_dir is not None:
        from missions.files.writing import check_writable_folder

        check_writable_folder(Path(out_dir))
    craft, where = load(aircraft, mission, overrides)
    refuse_climb(where, "compare")
    refuse_polar_night(where.mission, where, options=False)
    _require_path(models, corrections, craft, where)
    from studies.models.comparison import compare as compare_models
    from studies.output.terminal import show

    with progress_bar("models") as progress:
        found = compare_models(
            craft.aircraft,
            where.mission,
            models=models,
            corrections=corrections,
            objective=objective,
            required_excess_time_h=required_h,
            design=not no_design,
            progress=progress,
        )
    if out_dir is not None:
        from missions.files.writing import write_folder

        write_folder(Path(out_dir), _folder_contents(found))
    else:
        write_results(
            csv_file, lambda: csv_bytes(found.to_frame()), plot_file, lambda: _figure(found)
        )
    if as_json:
        print_json(found.to_dict())
    else:
        show(found)
        if out_dir is not None:
            click.echo(f"written to {out_dir}")
    sized = [case.built for case in found.cases if case.built is not None]
    if sized and all(built.judged is None for built in sized):
        sys.exit(EXIT_FAILED)


def _require_path(
    models: tuple[ModelName, ...] | None,
    corrections: tuple[CorrectionName, ...] | None,
    craft: LoadedAircraft,
    where: LoadedMission,
) -> None:
    """Refuse what was asked for by name and is not possible; the rest may be left out."""
    from studies.models.solar_models import attitude_is_known

    asked = next((f"--models {m}" for m in models or () if m in ATTITUDE_MODELS), None)
    if asked is None and "loiter" in (corrections or ()):
        asked = "--corrections loiter"
    if asked is not None or attitude_is_known(craft.aircraft, where.mission):
        # With surfaces and a path, the reference flies it even if no case does.
        require_path_for(asked or "the reference", craft, where)


def _folder_contents(found: Comparison) -> dict[str, bytes]:
    """Files of ``--out``, each with its content."""
    return {
        "comparison.json": json.dumps(found.to_dict(), indent=2, allow_nan=False).encode(),
        "comparison.csv": csv_bytes(found.to_frame()),
        "comparison.png": figure_bytes(_figure(found), "comparison.png"),
    }


def _figure(found: Comparison) -> Figure:
    from studies.models.plots import comparison_figure

    return comparison_figure(found)
