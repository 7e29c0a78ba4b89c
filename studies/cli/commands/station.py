"""The command ``solar-uav station``."""

from __future__ import annotations

from dataclasses import dataclass

from studies.cli.command import Command, Grid, option
from studies.cli.options import (
    CaseOptions,
    WorkOptions,
    case_options,
    figure_options,
    grid_option,
    plot_option,
    work_options,
)
from studies.output.figures.options import FigureOptions


@dataclass(frozen=True)
class Station:
    """Tell how much of the time AIRCRAFT (name, file or folder) holds its place, by month.

    Latitude against month, altitude against month at the mission's latitude, or latitude against
    month at the best altitude. It flies as fast as the repeated
    day allows, and the wind is that of the mission's key wind.
    """

    case: CaseOptions = case_options()
    latitudes: list[float] | None = option(
        "--latitudes",
        type=Grid(-90.0, 90.0, latitudes=True),
        help="Latitudes [deg], north positive. [default: -70:70:5]",
    )
    altitudes: list[float] | None = option(
        "--altitudes",
        type=Grid(-500.0, 32000.0),
        help="Altitudes [m] in place of latitudes; with --latitudes too, that of the largest share "
        "is flown in each month.",
    )
    out_file: str | None = grid_option("all cells")
    plot_file: str | None = plot_option("Draw them")
    figure: FigureOptions = figure_options()
    work: WorkOptions = work_options()


station = Command(
    "station",
    Station,
    "station:station",
    "solar-uav station my-aircraft.yaml -m my-mission.yaml --latitudes 0:60:5 --plot station.png",
)
