"""The command ``solar-uav map``."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

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


@click.command(name="map", short_help="Where and when it flies for ever.")
@click.argument("aircraft")
@mission_option()
@click.option(
    "--latitudes",
    type=Grid(-90.0, 90.0),
    default="-70:70:2",
    show_default=True,
    help="Latitudes [deg], north positive; both ends included.",
)
@click.option(
    "--days",
    type=Grid(1.0, 365.0),
    default="1:365:4",
    show_default=True,
    help="Days of the year, 1 to 365.",
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
    """Map where and when AIRCRAFT (name or file) flies for ever: latitude against season.

    Of the mission the air and the load count, not its latitudes and dates. With --resize: which
    design flies there and then.
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
    import numpy as np

    from sizing.optimisation.objectives import Objective
    from studies.maps import feasibility as feasibility_map
    from studies.maps import jobs as map_jobs

    check_outputs(out=out_file, plot=plot_file)
    axes = np.array(latitudes), np.unique(np.round(days).astype(int))
    solar = solar_model(model, correction)
    if objective is None:
        fixed = map_jobs.MapConfiguration(craft.aircraft, where.mission, solar, endurance)
        job = map_jobs.map_job(fixed, *axes)
    else:
        sized = map_jobs.SizedMapConfiguration(
            craft.aircraft, where.mission, solar, Objective(objective)
        )
        job = map_jobs.sized_map_job(sized, *axes)
    with completed(job, options, out_file, "cells") as outcome:
        if objective is None:
            data = map_jobs.map_dataset(job, outcome, *axes)
            figure: Any = feasibility_map.map_figure
        else:
            data = map_jobs.sized_map_dataset(job, outcome, *axes)
            figure = map_jobs.sized_map_figure
        write_results(
            out_file, lambda: feasibility_map.to_netcdf_bytes(data), plot_file, lambda: figure(data)
        )
    if objective is None:
        _print_seasons(data, as_json)
    else:
        _print_designs(data, as_json)


def _print_seasons(data: xr.Dataset, as_json: bool) -> None:
    from studies.maps.feasibility import season_length
    from studies.output.tables import print_seasons

    season = season_length(data)
    if not as_json:
        print_seasons(console(), data, season)
        return
    print_json(
        {
            "latitude_deg": data["latitude"].to_numpy().tolist(),
            "days": data["day"].to_numpy().tolist(),
            "perpetual_days": season.to_numpy().tolist(),
        }
    )


def _print_designs(data: xr.Dataset, as_json: bool) -> None:
    """Of every latitude: on how many days there is a design, and the range of its size."""
    from sizing.results.records import finite
    from studies.output.columns import SIZED, SizingStatus

    record: dict[str, Any] = {
        "latitude_deg": data["latitude"].to_numpy().tolist(),
        "days": data["day"].to_numpy().tolist(),
        "objective": data.attrs["objective"],
    }
    for status in SizingStatus:
        record[f"{status.name}_days"] = (data["status"] == status).sum("day").to_numpy().tolist()
    ranges: dict[str, list[float]] = {}
    for name, unit in (("wingspan", "m"), ("total_mass", "kg"), ("excess_time", "h")):
        for word, end in (("least", "min"), ("largest", "max")):
            values = getattr(data[name], end)("day").to_numpy().tolist()
            ranges[f"{word}_{name}_{unit}"] = values
            record[f"{word}_{name}_{unit}"] = [finite(value) for value in values]
    if as_json:
        print_json(record)
        return
    from rich.table import Table

    from missions.mission import latitude_label

    none = (SizingStatus.infeasible, SizingStatus.invalid)
    groups = (SIZED, none, [kind for kind in SizingStatus if kind not in (*SIZED, *none)])

    title = f"{data.attrs['title']} for {record['objective']}"
    table = Table(title=title, title_justify="left")
    shown = {"wingspan_m": "wingspan [m]", "total_mass_kg": "mass [kg]"}
    if record["objective"] == "max_excess_time":
        shown["excess_time_h"] = "excess time [h]"
    heads = ("latitude", f"designs on {data.sizes['day']} days", "none", "unknown")
    for name in (*heads, *shown.values()):
        table.add_column(name, justify="right")
    for i, latitude in enumerate(record["latitude_deg"]):
        table.add_row(
            latitude_label(latitude),
            *(str(sum(record[f"{kind.name}_days"][i] for kind in kinds)) for kinds in groups),
            *(_range(ranges[f"least_{name}"][i], ranges[f"largest_{name}"][i]) for name in shown),
        )
    console().print(table)


def _range(least: float, largest: float) -> str:
    if math.isnan(least):
        return "-"
    if math.isinf(least):
        return "no end"
    return f"{least:.2f} to {'no end' if math.isinf(largest) else f'{largest:.2f}'}"
