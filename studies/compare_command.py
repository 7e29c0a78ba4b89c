"""The command ``solar-uav compare``."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from solar.names import ATTITUDE_MODELS, CORRECTION_NAMES, MODEL_NAMES, RESIZE_NAMES
from studies.climb_checks import refuse_climb
from studies.command_options import (
    EXIT_FAILED,
    check_outputs,
    console,
    image_format,
    load,
    print_json,
    progress_bar,
    refuse_polar_night,
    require_path_for,
    write_files,
)

if TYPE_CHECKING:
    from sizing.performance import SolarModel
    from studies.comparison import Comparison
    from studies.library import LoadedAircraft, LoadedMission

DEFAULT_MISSION = "rafz-july"
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


@click.command()
@click.argument("aircraft")
@click.option("--mission", "-m", default=DEFAULT_MISSION, show_default=True, help="Name or file.")
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
@click.option(
    "--required-excess-time",
    "required_h",
    type=click.FloatRange(0.0, 1000.0),
    metavar="HOURS",
    help="Excess time that every scenario must have, instead of the mission's.",
)
@click.option("--no-design", is_flag=True, help="Compare predictions only, size nothing.")
@click.option(
    "--set",
    "overrides",
    metavar="KEY=VALUE",
    multiple=True,
    help="Override a key of the aircraft file, or of the mission with the prefix 'mission.'. "
    "May be repeated.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON instead of the table.")
@click.option("--out", "out_dir", type=click.Path(), help="Folder for table, JSON and figure.")
@click.option("--csv", "csv_file", type=click.Path(), help="Write the table as CSV.")
@click.option("--plot", "plot_file", type=click.Path(), help="Draw the figure (png, svg, pdf).")
def compare(
    aircraft: str,
    mission: str,
    models: tuple[str, ...] | None,
    corrections: tuple[str, ...] | None,
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
    if required_h is not None and required_h != required_h:
        raise click.BadParameter("must be a number of hours", param_hint="--required-excess-time")
    image = image_format(plot_file)
    check_outputs(csv=csv_file, plot=plot_file)
    if out_dir is not None:
        from missions.output_files import check_writable_folder

        check_writable_folder(Path(out_dir))
    craft, where = load(aircraft, mission, overrides)
    refuse_climb(where, "compare")
    refuse_polar_night(where.mission, where, options=False)
    wanted = _wanted(models, corrections, craft, where)
    from sizing.objectives import Objective
    from studies import comparison as study
    from studies.comparison_sentence import sentence

    with progress_bar("models") as progress:
        found = study.compare(
            craft.aircraft,
            where.mission,
            wanted,
            objective=Objective(objective),
            required_excess_time_h=required_h,
            designs=not no_design,
            progress=progress,
        )
    record = study.to_json(found, sentence(found))
    if out_dir is not None:
        from missions.output_files import write_folder

        write_folder(Path(out_dir), _folder_contents(found, record))
    else:
        write_files(_file_contents(found, record, csv_file, plot_file, image))
    if as_json:
        print_json(record)
    else:
        from studies.comparison_tables import print_comparison

        print_comparison(console(), record)
        if out_dir is not None:
            click.echo(f"written to {out_dir}")
    sized = [case.built for case in found.cases if case.built is not None]
    if sized and all(built.judged is None for built in sized):
        sys.exit(EXIT_FAILED)


def _wanted(
    models: tuple[str, ...] | None,
    corrections: tuple[str, ...] | None,
    craft: LoadedAircraft,
    where: LoadedMission,
) -> list[SolarModel]:
    """Cases to compare; what was asked for by name must be possible, the rest may be left out."""
    from studies.solar_models import attitude_is_known, combinations

    asked = next((f"--models {m}" for m in models or () if m in ATTITUDE_MODELS), None)
    if asked is None and "loiter" in (corrections or ()):
        asked = "--corrections loiter"
    known = attitude_is_known(craft.aircraft, where.mission)
    if asked is not None or known:
        # With surfaces and a path, the reference flies it even if no case does.
        require_path_for(asked or "the reference", craft, where)
    chosen_models: Any = models or MODEL_NAMES
    chosen_corrections: Any = corrections or CORRECTION_NAMES
    return combinations(chosen_models, chosen_corrections, attitude=known)


def _folder_contents(found: Comparison, record: dict[str, Any]) -> dict[str, bytes]:
    """Files of ``--out``, each with its content."""
    return {
        "comparison.json": json.dumps(record, indent=2, allow_nan=False).encode(),
        "comparison.csv": _csv(record),
        "comparison.png": _figure(found, "png"),
    }


def _file_contents(
    found: Comparison,
    record: dict[str, Any],
    csv_file: str | None,
    plot_file: str | None,
    image: str | None,
) -> dict[str | os.PathLike[str], bytes]:
    """Files of ``--csv`` and ``--plot``, each with its content."""
    contents: dict[str | os.PathLike[str], bytes] = {}
    if csv_file is not None:
        contents[csv_file] = _csv(record)
    if plot_file is not None and image is not None:
        contents[plot_file] = _figure(found, image)
    return contents


def _csv(record: dict[str, Any]) -> bytes:
    from studies.comparison import case_table

    return str(case_table(record).to_csv(index=False)).encode()


def _figure(found: Comparison, image: str) -> bytes:
    from studies.comparison_plots import comparison_figure
    from studies.plots import to_bytes

    return to_bytes(comparison_figure(found), image)
