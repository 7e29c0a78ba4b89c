"""The command ``solar-uav``.

Each command has a module of its own or with its like. Heavy packages are imported inside the
commands that use them, so that help texts appear at once.
"""

from __future__ import annotations

import io
import sys

import click

from solar._version import __version__
from studies.cli.commands.analyse import analyse
from studies.cli.commands.ceiling import ceiling
from studies.cli.commands.compare import compare
from studies.cli.commands.files import init, list_, validate
from studies.cli.commands.map import map_
from studies.cli.commands.show import show
from studies.cli.commands.size import size
from studies.cli.commands.sweep import sweep
from studies.cli.commands.validation import (
    efficiencies,
    loiter_correction,
    published,
    reproduce_report,
)
from studies.cli.commands.verify import verify
from studies.cli.options import EXIT_BAD_INPUT, EXIT_FAILED


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="solar-uav")
def cli() -> None:
    """Size solar-electric aircraft and predict how long they stay up.

    AIRCRAFT and missions are shipped names (see list) or paths of YAML files (see init).
    """


cli.add_command(analyse)
cli.add_command(size)
cli.add_command(map_)
cli.add_command(sweep)
cli.add_command(compare)
cli.add_command(ceiling)
cli.add_command(verify)
cli.add_command(list_)
cli.add_command(show)
cli.add_command(init)
cli.add_command(validate)
cli.add_command(published)
cli.add_command(loiter_correction)
cli.add_command(efficiencies)
cli.add_command(reproduce_report)


def main() -> None:
    """Run the command; a user's mistake ends as one clear message and exit code 2."""
    for stream in (sys.stdout, sys.stderr):
        # A terminal that cannot show a character shows a stand-in; it is no reason to fail.
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    try:
        cli.main(prog_name="solar-uav", standalone_mode=True)
    except ValueError as error:
        from missions.files.errors import InputError
        from sizing.design import ImpossibleDesignError

        if isinstance(error, InputError):
            click.echo(str(error), err=True)
            sys.exit(EXIT_BAD_INPUT)
        if isinstance(error, ImpossibleDesignError):
            click.echo(f"solar-uav: {error}", err=True)
            sys.exit(EXIT_FAILED)
        raise
    except OSError as error:
        click.echo(f"solar-uav: {error}", err=True)
        sys.exit(EXIT_FAILED)


if __name__ == "__main__":
    main()
