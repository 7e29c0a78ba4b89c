"""Options of commands that read a flight log: which of its columns is what, and its clock."""

from __future__ import annotations

import functools
from typing import Any, cast

import click

from studies.cli.options import Command, Parsed


def log_options(command: Command) -> Command:
    """Options that say how a log is written; the command has them as ``layout``, a ColumnMap."""

    @functools.wraps(command)
    def reading(*args: Any, **kwargs: Any) -> Any:
        from missions.logs.columns import ColumnMap, read_column_map

        file, columns = kwargs.pop("columns_file"), kwargs.pop("columns")
        layout = ColumnMap() if file is None else read_column_map(file)
        layout = layout.with_options(dict(columns), kwargs.pop("timezone"))
        return command(*args, layout=layout, **kwargs)

    found: Any = reading
    for option in (
        click.option(
            "--timezone",
            type=Parsed("zone", "missions.logs.clock:zone_name"),
            metavar="ZONE",
            help="Zone of times that are written without one: UTC, +02:00 or Europe/Zurich.",
        ),
        click.option(
            "--column",
            "columns",
            type=Parsed("quantity=column", "missions.logs.columns:parse_column"),
            multiple=True,
            metavar="QUANTITY=COLUMN",
            help="Column of the log, e.g. 'solar_power_w=P [kW]' or 'solar_power_w=U * I [mA]'. "
            "May be repeated.",
        ),
        click.option(
            "--columns",
            "columns_file",
            type=click.Path(),
            metavar="FILE",
            help="YAML that says which column is what; what it does not say is guessed.",
        ),
    ):
        found = option(found)
    return cast(Command, found)
