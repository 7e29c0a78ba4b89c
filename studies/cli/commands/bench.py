"""The command ``solar-uav bench``."""

from __future__ import annotations

from dataclasses import dataclass

import click

from studies.cli.command import Command, argument, option
from studies.cli.options import aircraft_argument, json_option, write_option

# Kinds of tests; a test compares them with studies.bench.result.
KINDS = ("iv-curve", "thrust-stand", "glide-polar", "capacity")


def _print_template(context: click.Context, _: click.Parameter, kind: str | None) -> None:
    """Print a template before anything else is asked for."""
    if kind is not None and not context.resilient_parsing:
        from studies.bench.result import LAYOUTS

        click.echo(LAYOUTS[kind].template(), nl=False)
        context.exit()


@dataclass(frozen=True)
class Bench:
    """Take values of AIRCRAFT from bench tests, with confidence intervals.

    FILE is a CSV file as --template prints it; its columns say which test it is.
    """

    aircraft: str = aircraft_argument()
    files: tuple[str, ...] = argument(metavar="FILE...", nargs=-1, required=True)
    template: None = option(
        "--template",
        type=click.Choice(KINDS),
        is_eager=True,
        callback=_print_template,
        help="Print the CSV template of a test, and nothing else.",
    )
    write_file: str | None = write_option(
        "Write the aircraft with these values, and where they come from."
    )
    as_json: bool = json_option()


bench = Command(
    "bench", Bench, "bench:bench", "solar-uav bench atlantiksolar-as2 iv.csv --write tested.yaml"
)
