"""The command ``solar-uav map``."""

from __future__ import annotations

from dataclasses import dataclass

import click

from sizing.program.objectives import RESIZE_NAMES
from studies.cli.command import Command, Grid, option
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


@dataclass(frozen=True)
class Map:
    """Map where and when AIRCRAFT (name, file or folder) flies perpetually.

    Latitude against season; of the mission the air and the load count, not its latitudes and
    dates. With --resize: which design flies there and then. The exit code is 1 if any cell could
    not be computed.
    """

    case: CaseOptions = case_options()
    mass_kg: float | None = mass_option()
    latitudes: list[float] | None = option(
        "--latitudes",
        type=Grid(-90.0, 90.0, latitudes=True),
        help="Latitudes [deg], north positive; the last one is met where the steps lead to it. "
        "[default: -70:70:1; with --resize, --endurance, VM, FM, loiter and climb -70:70:2]",
    )
    days: list[float] | None = option(
        "--days",
        type=Grid(1.0, 365.0, whole=True),
        help="Days of the year, 1 to 365; the last one is met where the steps lead to it. "
        "[default: 1:365:1; where --latitudes has steps of 2 by itself 1:365:4]",
    )
    endurance: bool = option(
        "--endurance",
        is_flag=True,
        help="Also the longest flight of each cell (slow); not with --resize.",
    )
    objective: str | None = option(
        "--resize",
        type=click.Choice(RESIZE_NAMES),
        help="Size the aircraft anew in every cell for it.",
    )
    out_file: str | None = grid_option("all cells")
    plot_file: str | None = plot_option("Draw the map")
    work: WorkOptions = work_options()
    figure: FigureOptions = figure_options()

    def __post_init__(self) -> None:
        """Refuse what does not go together."""
        if self.objective is not None and self.endurance:
            raise click.UsageError("--endurance is of a fixed aircraft; not with --resize")


map_ = Command(
    "map", Map, "map:map_", "solar-uav map atlantiksolar-as2 --latitudes 0:70:5 --plot map.png"
)
