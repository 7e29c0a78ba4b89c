"""What ``solar-uav verify`` does."""

from __future__ import annotations

from pathlib import Path

import click

from missions.files.shipped import shipped_names
from missions.logs.columns import ColumnMap, read_column_map
from missions.logs.csv import read_flight_log
from missions.logs.table import FlightLog
from studies.cli.commands.verify import Verify
from studies.cli.files import load
from studies.cli.options import LogOptions
from studies.cli.outputs import check_report, deliver, figure_of, refuse_to_overwrite
from studies.flight_logs import verification
from studies.flight_logs.plots import figures
from studies.output.run_folder import write_run_folder

_YAML, _LOGS = (".yaml", ".yml"), (".csv", ".ulg", ".bin")
# File of a folder of results with the samples.
_SAMPLES = "samples.csv"


def verify(options: Verify) -> None:
    """Compare the models with a flight, write what was found, and tell it."""
    log_file, folder, report = options.log_file, options.out_dir, options.report_file
    if folder is not None:
        refuse_to_overwrite("--out", str(Path(folder) / _SAMPLES), (log_file,))
    check_report(report, option="--report")
    _refuse_swapped_log(options.aircraft, log_file, "verify")
    case = load(options)
    result = verification.verify(
        case.aircraft,
        _read_log(options),
        case.mission,
        windows=options.windows,
        filter_s=options.filter_s,
        clock_offset_min=options.clock_offset_min,
        heading_offset_deg=options.heading_offset_deg,
    )

    def write(folder: str) -> None:
        contents = {_SAMPLES: result.to_csv().encode()}
        drawn = {
            f"{name}.png": figure_of(draw) for name, draw in figures(result, figure=options.figure)
        }
        inputs = case.inputs(log=Path(log_file))
        write_run_folder(Path(folder), inputs, case.named(result.to_dict()), contents, drawn)

    def write_page(path: str) -> None:
        from studies.cli.reports import report_on_log  # with all that a page has

        report_on_log(case, result, log_file, path, overrides=options.overrides)

    deliver(case, result, writers={folder: write, report: write_page})


def _read_log(options: LogOptions) -> FlightLog:
    """Read the flight log that the options of a command name."""
    file = options.columns_file
    layout = ColumnMap() if file is None else read_column_map(file)
    said = (options.timezone, options.start, options.ignore, options.exclude)
    layout = layout.with_options(dict(options.columns), *said)
    return read_flight_log(options.log_file, layout)


def _refuse_swapped_log(aircraft: str, log_file: str, verb: str) -> None:
    """Refuse a log where the aircraft is meant, and the reverse."""
    named = log_file in shipped_names("aircraft") and not Path(log_file).exists()
    if aircraft.lower().endswith(_LOGS) and (named or log_file.lower().endswith(_YAML)):
        raise click.UsageError(f"the aircraft comes first: {verb} {log_file} {aircraft}")
