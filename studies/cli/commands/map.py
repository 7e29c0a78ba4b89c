"""The command ``solar-uav map``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from sizing.optimisation.objectives import RESIZE_NAMES
from studies.cli.help_texts import command
from studies.cli.options import (
    Asked,
    Grid,
    WorkOptions,
    aircraft_argument,
    check_image,
    figure_options,
    gathered,
    mission_option,
    solar_options,
    work_options,
)
from studies.output.figures.options import FigureOptions

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from studies.cli.files import Case
    from studies.grid import GridStudy
    from studies.output.gridded import OnGrid


@dataclass(frozen=True)
class _Cells:
    """Places and days of the map, and what is computed of each."""

    latitudes: list[float]
    days: list[float]
    endurance: bool
    objective: str | None

    def __post_init__(self) -> None:
        """Refuse what does not go together."""
        if self.objective is not None and self.endurance:
            raise click.UsageError("--endurance is of a fixed aircraft; not with --resize")

    def prepared(self, case: Case) -> GridStudy:
        """Cells ready to be computed."""
        flown = case.aircraft, case.mission
        if self.objective is None:
            from studies.maps import feasibility

            return feasibility.prepare(
                *flown, self.latitudes, self.days, case.solar, self.endurance
            )
        from studies.maps import resized  # the optimiser takes a seventh of a second

        return resized.prepare(*flown, self.objective, self.latitudes, self.days, case.solar)


@command("solar-uav map atlantiksolar-as2 --latitudes 0:70:5 --plot map.png", name="map")
@aircraft_argument()
@mission_option()
@click.option(
    "--latitudes",
    type=Grid(-90.0, 90.0, latitudes=True),
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
    help="Size the aircraft anew in every cell for it.",
)
@click.option(
    "--weather",
    "weather_file",
    type=click.Path(),
    metavar="FILE",
    help="Map the days of a weather record that close instead: half months against batteries.",
)
@click.option(
    "--batteries",
    type=Grid(0.01, 100.0),
    default="0.5:2:0.125",
    show_default=True,
    help="With --weather: batteries, as multiples of the aircraft's own.",
)
@click.option("--out", "out_file", type=click.Path(), help="Write the map as NetCDF (nc).")
@click.option("--plot", "plot_file", type=click.Path(), help="Draw the map (png, svg, pdf).")
@work_options
@solar_options
@figure_options
@gathered("cells", _Cells)
def map_(
    asked: Asked,
    cells: _Cells,
    weather_file: str | None,
    batteries: list[float],
    out_file: str | None,
    plot_file: str | None,
    figure: FigureOptions,
    work: WorkOptions,
) -> None:
    """Map where and when AIRCRAFT (name, file or folder) flies perpetually.

    Latitude against season; of the mission the air and the load count, not its latitudes and
    dates. With --resize: which design flies there and then. The exit code is 1 if any cell could
    not be computed.
    """
    from studies.cli.checks import check_outputs, refuse_climb, require_parametric, require_path
    from studies.cli.jobs import completed
    from studies.cli.outputs import call, told, write_results
    from studies.maps import results
    from studies.output.gridded import to_netcdf_bytes

    if out_file is not None and not out_file.lower().endswith(".nc"):
        raise click.BadParameter(f"{out_file!r} must end in .nc", param_hint="--out")
    check_image(plot_file)
    _check_weather(weather_file)
    case = asked.case()
    refuse_climb(case, "map")
    require_path(case)
    if cells.objective is not None:
        require_parametric(case, "--resize needs a parametric aircraft, this one is measured")
    check_outputs(out=out_file, plot=plot_file)
    if weather_file is not None:
        _in_weather(case, weather_file, batteries, (out_file, plot_file), figure)
        return
    study, resized = cells.prepared(case), cells.objective is not None
    record = results.designs_record if resized else results.seasons_record
    table = results.designs_table if resized else results.seasons_table
    with completed(study.job, work, out_file, "cells") as outcome:
        data = study.gridded(outcome)
        with told(
            *(case, case.named(record(data)), lambda: table(data)),
            files=(out_file, plot_file),
            next_step=call("report", "--out", "report.html"),
        ):
            write_results(
                out_file,
                lambda: to_netcdf_bytes(data),
                plot_file,
                lambda: _map_figure(data, figure, resized=resized),
            )


# Options of a map over latitudes, and those of one in a weather record.
_OF_LATITUDES = {
    "latitudes": "a weather record has its own site",
    "days": "all days of the record are flown",
    "endurance": "solar-uav analyse --weather tells the endurance of each day's launch",
    "objective": "solar-uav size --weather --survive finds the smallest design of a season",
    "workers": "a record is flown in seconds, by one process",
    "scheduler": "a record is flown in seconds, by one process",
    "work_dir": "a record is flown in seconds, there are no parts to keep",
    "keep_parts": "a record is flown in seconds, there are no parts to keep",
}


def _check_weather(weather_file: str | None) -> None:
    """Refuse options that mean nothing with, or without, a weather record."""
    context = click.get_current_context()
    given = {
        name
        for name in (*_OF_LATITUDES, "batteries")
        if context.get_parameter_source(name) is not ParameterSource.DEFAULT
    }
    if weather_file is None:
        if "batteries" in given:
            raise click.UsageError("--batteries needs --weather as well")
        return
    names = {"objective": "--resize", "work_dir": "--work"}
    for name, reason in _OF_LATITUDES.items():
        if name in given:
            option = names.get(name, f"--{name.replace('_', '-')}")
            raise click.UsageError(f"{option} does not go with --weather: {reason}")


def _in_weather(
    case: Case,
    weather_file: str,
    batteries: list[float],
    files: tuple[str | None, str | None],
    figure: FigureOptions,
) -> None:
    """Map the days of a record that close, and tell it."""
    from missions.weather.files import load_weather
    from studies.cli.outputs import told, write_results
    from studies.output.gridded import to_netcdf_bytes
    from studies.weather import battery_map as maps

    data = maps.battery_map(
        *(case.aircraft, case.mission, load_weather(weather_file), batteries),
        solar=case.solar,
        mission_chosen=not case.mission_is_default,
    )
    record = case.named({"days_in_weather": maps.battery_map_record(data)})
    with told(case, record, lambda: maps.battery_map_table(data), files=files):
        write_results(
            files[0],
            lambda: to_netcdf_bytes(data),
            files[1],
            lambda: maps.plot_battery_map(data, figure=figure),
        )


def _map_figure(data: OnGrid, figure: FigureOptions, *, resized: bool) -> Figure:
    from studies.maps.plots import plot_map, plot_resized_map

    return (plot_resized_map if resized else plot_map)(data, figure=figure)
