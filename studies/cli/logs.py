"""Flight logs of the command line."""

from __future__ import annotations

from pathlib import Path

import click

from missions.files.shipped import shipped_names
from missions.logs.columns import ColumnMap, read_column_map
from missions.logs.csv import read_flight_log
from missions.logs.table import FlightLog
from studies.cli.options import LogOptions

_YAML, _LOGS = (".yaml", ".yml"), (".csv", ".ulg", ".bin")


def read_log(options: LogOptions) -> FlightLog:
    """Read the flight log that the options of a command name."""
    file = options.columns_file
    layout = ColumnMap() if file is None else read_column_map(file)
    said = (options.timezone, options.start, options.ignore, options.exclude)
    layout = layout.with_options(dict(options.columns), *said)
    return read_flight_log(options.log_file, layout)


def refuse_swapped_log(aircraft: str, log_file: str, verb: str) -> None:
    """Refuse a log where the aircraft is meant, and the reverse."""
    named = log_file in shipped_names("aircraft") and not Path(log_file).exists()
    if aircraft.lower().endswith(_LOGS) and (named or log_file.lower().endswith(_YAML)):
        raise click.UsageError(f"the aircraft comes first: {verb} {log_file} {aircraft}")
