"""What ``solar-uav station`` does."""

from __future__ import annotations

from studies.cli.commands.analyse import Station
from studies.cli.files import IN_WINDS, load, refuse_climb, require_parametric, require_path
from studies.cli.jobs import completed
from studies.cli.outputs import deliver, figure_of
from studies.output.formats import csv_bytes, grid_format, table_bytes
from studies.output.gridded import to_netcdf_bytes
from studies.station import plot_station, prepare, station_of


def station(options: Station) -> None:
    """Compute the time on station of each month, and tell it."""
    case = load(options)
    refuse_climb(case, "station", IN_WINDS)
    require_path(case)
    require_parametric(case, "station needs a parametric aircraft, this one is measured")
    study = prepare(case.aircraft, case.mission, options.latitudes, options.altitudes, case.solar)
    with completed(study, options, options.out_file) as data:
        result = station_of(study, data)

        def content(path: str) -> bytes:
            kind = grid_format(path)
            if kind == "nc":
                return to_netcdf_bytes(result.cells)
            frame = result.to_frame()
            return csv_bytes(frame) if kind == "csv" else table_bytes(frame, f"station.{kind}")

        files = {
            options.out_file: content,
            options.plot_file: figure_of(lambda: plot_station(result, figure=options.figure)),
        }
        deliver(case, result, files)
