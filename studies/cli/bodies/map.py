"""What ``solar-uav map`` does."""

from __future__ import annotations

from typing import TYPE_CHECKING

from studies.cli.commands.analyse import Map
from studies.cli.files import (
    load,
    require_climb_power,
    require_climber,
    require_parametric,
    require_path,
)
from studies.cli.jobs import completed
from studies.cli.outputs import call, deliver, figure_of
from studies.maps.results import MapResult
from studies.maps.study import prepare
from studies.output.formats import grid_format
from studies.output.gridded import to_bytes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from studies.output.gridded import OnGrid


def map_(options: Map) -> None:
    """Compute the cells of a map, write it, and tell it."""
    case = load(options)
    require_path(case, in_winds_of_cells=True)
    resized = options.objective is not None
    if not resized:
        require_climber(case)
    else:
        require_parametric(case, "--resize needs a parametric aircraft, this one is measured")
        require_climb_power(case)
    study = prepare(
        case.aircraft,
        case.mission,
        options.latitudes,
        options.days,
        case.solar,
        endurance=options.endurance,
        objective=options.objective,
    )
    with completed(study, options, options.out_file) as data:
        deliver(
            case,
            MapResult(data),
            files={
                options.out_file: lambda path: to_bytes(data, grid_format(path), "cells"),
                options.plot_file: figure_of(lambda: _drawn_map(data, options)),
            },
            next_step=call("report", "--out", "report.html"),
        )


def _drawn_map(data: OnGrid, options: Map) -> Figure:
    from studies.maps.plots import plot_map, plot_resized_map  # matplotlib

    draw = plot_map if options.objective is None else plot_resized_map
    return draw(data, figure=options.figure)
