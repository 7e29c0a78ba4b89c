"""What ``solar-uav ceiling`` does."""

from __future__ import annotations

import sys

import click

from missions.files.validation import located_error
from studies.ceiling import perpetual_ceiling, plot_ceiling
from studies.cli.commands.analyse import Ceiling
from studies.cli.files import load_flyable, refuse_polar_night
from studies.cli.options import EXIT_FAILED
from studies.cli.outputs import deliver, figure_of, table_of
from studies.cli.telling import progress_of


def ceiling(options: Ceiling) -> None:
    """Find the highest altitude of perpetual flight, and tell it."""
    case = load_flyable(options)
    refuse_polar_night(case)
    lowest_m, highest_m = case.mission.altitude_m, options.highest_m
    climb = case.mission.climb
    if climb is not None and climb.ceiling_m <= lowest_m:
        message = f"must be above the night's floor of {lowest_m:g} (got {climb.ceiling_m:g})"
        raise located_error(case.mission_file.document, ("climb", "ceiling_m"), message)
    if highest_m is not None and highest_m <= lowest_m:
        message = f"must be above the mission's altitude_m of {lowest_m:g} (got {highest_m:g})"
        raise click.BadParameter(message, param_hint="--highest")
    with progress_of("altitudes", lines=False) as progress:
        result = perpetual_ceiling(
            **case.arguments, highest_m=highest_m, step_m=options.step_m, progress=progress
        )
    files = {
        options.table_file: table_of(result.to_frame, "altitudes"),
        options.plot_file: figure_of(lambda: plot_ceiling(result, figure=options.figure)),
    }
    deliver(case, result, files)
    if result.search.highest is None:
        sys.exit(EXIT_FAILED)
