"""The command ``solar-uav map``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from solar.names import RESIZE_NAMES
from studies.cli.checks import refuse_climb
from studies.cli.jobs import WorkOptions, completed, work_options
from studies.cli.options import (
    Grid,
    check_image,
    check_outputs,
    console,
    load,
    mission_option,
    print_json,
    require_parametric,
    require_path,
    solar_model,
    solar_options,
    write_results,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


@click.command(name="map", short_help="Where and when it can fly perpetually.")
@click.argument("aircraft")
@mission_option()
@click.option(
    "--latitudes",
    type=Grid(-90.0, 90.0),
    default="-70:70:2",
    show_default=True,
    help="Latitudes [deg], north positive; the last one is met where the steps lead to it.",
)
@click.option(
    "--days",
    type=Grid(1.0, 365.0, whole=True),
    default="1:365:4",
    show_default=True,
    help="Days of the year, 1 to 365; the last one is met where the steps lead to it.",
)
@click.option(
    "--endurance",
    is_flag=True,
    help="Also the longest flight of each cell (slow); not with --resize.",
)
@click.option(
    "--resize",
    "objective",
    type=click.Choice(RESIZE_NAMES),
    help="Size the aircraft anew in every cell, for this objective.",
)
@click.option("--out", "out_file", type=click.Path(), help="Write the map as NetCDF (nc).")
@click.option("--plot", "plot_file", type=click.Path(), help="Draw the map (png, svg, pdf).")
@work_options
@solar_options
def map_(
    aircraft: str,
    mission: str,
    latitudes: list[float],
    days: list[float],
    endurance: bool,
    objective: str | None,
    out_file: str | None,
    plot_file: str | None,
    workers: int | None,
    scheduler: str | None,
    work_dir: str | None,
    keep_parts: bool,
    model: str,
    correction: str,
    overrides: tuple[str, ...],
    as_json: bool,
) -> None:
    """Map where and when AIRCRAFT (name or file) can fly perpetually: latitude against season.

    Of the mission the air and the load count, not its latitudes and dates. With --resize: which
    design flies there and then. The exit code is 1 if any cell could not be computed.
    """
    if objective is not None and endurance:
        raise click.UsageError("--endurance is of a fixed aircraft; not with --resize")
    if out_file is not None and not out_file.lower().endswith(".nc"):
        raise click.BadParameter(f"{out_file!r} must end in .nc", param_hint="--out")
    options = WorkOptions(workers, scheduler, work_dir, keep_parts)
    check_image(plot_file)
    craft, where = load(aircraft, mission, overrides)
    refuse_climb(where, "map")
    require_path(model, correction, craft, where)
    if objective is not None:
        require_parametric(craft, "--resize")
    from studies.maps import feasibility, resized, tables
    from studies.output.columns import to_netcdf_bytes

    check_outputs(out=out_file, plot=plot_file)
    solar = solar_model(model, correction)
    if objective is None:
        study = feasibility.prepare(
            craft.aircraft, where.mission, latitudes, days, solar, endurance
        )
    else:
        study = resized.prepare(craft.aircraft, where.mission, objective, latitudes, days, solar)
    with completed(study.job, options, out_file, "cells") as outcome:
        data = study.dataset(outcome)
        resize = objective is not None
        write_results(
            out_file, lambda: to_netcdf_bytes(data), plot_file, lambda: _figure(data, resize)
        )
        if as_json:
            print_json(tables.designs(data) if resize else tables.seasons(data))
        else:
            console().print(tables.designs_table(data) if resize else tables.seasons_table(data))


def _figure(data: xr.Dataset, resize: bool) -> Figure:
    from studies.maps.plots import map_figure, resized_map_figure

    return resized_map_figure(data) if resize else map_figure(data)
