"""The command ``solar-uav``."""

from __future__ import annotations

import io
import os
import signal
import sys
import warnings
from typing import Any

import click

from missions.files.errors import InputError, did_you_mean
from solar._version import __version__
from solar.versions import DeprecatedKeyWarning
from studies.cli import commands as commands  # which declares them
from studies.cli.command import COMMANDS, write_examples, write_shared_options
from studies.cli.options import EXIT_BAD_INPUT, EXIT_FAILED
from studies.cli.telling import tell_error
from studies.signals import Signals, interruptible

_SHOW_WARNING = warnings.showwarning


_EXAMPLES = (
    "solar-uav analyse atlantiksolar-as2 --latitude 47.6 --date 10-15",
    "solar-uav size atlantiksolar-design -m central-europe-summer --required-excess-time 3",
    "solar-uav init albatross",
)


class _Group(click.Group):
    """Group of all commands, whose page has them by task, and the options of several of them."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands, in one spelling."""
        return list(COMMANDS)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command of the first argument; refuse a misspelt one with the one meant."""
        try:
            return super().resolve_command(ctx, args)
        except click.UsageError as error:
            meant = did_you_mean(args[0], COMMANDS)
            raise click.UsageError(f"{error.message.rstrip('.')}{meant}", ctx) from None

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the examples, and what the command is for."""
        write_examples(formatter, _EXAMPLES)
        super().format_help_text(ctx, formatter)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands by what they are for, and the options of several of them."""
        longest = max(map(len, COMMANDS))
        for task in dict.fromkeys(made.task for made in COMMANDS.values()):
            rows = [
                (f"{n:{longest}}", str(c.short_help)) for n, c in COMMANDS.items() if c.task == task
            ]
            with formatter.section(task):
                formatter.write_dl(rows)
        write_shared_options(ctx, formatter)


@click.group(
    cls=_Group,
    commands={**COMMANDS, "analyze": COMMANDS["analyse"]},
    context_settings={"help_option_names": ["-h", "--help"], "show_default": True},
)
@click.version_option(__version__, prog_name="solar-uav")
def cli() -> None:
    """Size solar-electric aircraft and predict how long they remain airborne.

    AIRCRAFT and missions are shipped names (see list) or paths of YAML files (see init). AIRCRAFT
    may also be a folder that --out wrote. Solar cells, batteries, motors and propellers have names,
    too (list --cells). COMMAND --help shows examples and options.
    """


def main() -> None:
    """Run the command; a user's mistake or a signal ends as one message and an exit code."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        # One that was closed takes nothing, and leaves its number to no file of ours.
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: PTH123, SIM115
    for stream in (sys.stdout, sys.stderr):
        # A terminal that cannot show a character shows a stand-in; it is no reason to fail.
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    warnings.showwarning = _tell_warning
    signals, code = Signals(), 0
    try:
        with interruptible() as signals:
            try:
                code = cli.main(prog_name="solar-uav", standalone_mode=False) or 0
            except Exception as error:
                # What a signal breaks is of no interest: an import ends as an ImportError.
                if signals.signum is None:
                    code = _tell_mistake(error)
    except KeyboardInterrupt as stopped:
        signals.signum = getattr(stopped, "signum", signal.SIGINT)
    if signals.signum is not None:  # even if a library swallowed the interrupt
        by = "Ctrl-C" if signals.signum == signal.SIGINT else "SIGTERM"
        click.echo(f"solar-uav: stopped by {by}", err=True)
        code = 128 + signals.signum
    sys.exit(code)


def _tell_warning(
    message: Warning | str, category: type[Warning], *place: Any, **others: Any
) -> None:
    """Tell of a deprecated key in one line, without the place in our code."""
    if issubclass(category, DeprecatedKeyWarning):
        click.echo(f"note: {message}", err=True)
    else:
        _SHOW_WARNING(message, category, *place, **others)


def _tell_mistake(error: BaseException) -> int:
    """Print a mistake of the user, and return the exit code; raise what is ours."""
    if isinstance(error, click.ClickException):
        shown = io.StringIO()  # with the usage and the hint of the command
        error.show(shown)
        tell_error(shown.getvalue().rstrip().replace("\n\t", "\n  "))  # click lists with tabs
        return error.exit_code
    if isinstance(error, click.Abort):
        return 128 + signal.SIGINT
    if isinstance(error, InputError):
        tell_error(str(error))
        return EXIT_BAD_INPUT
    from sizing.mass_budget import ImpossibleDesignError

    if isinstance(error, ImpossibleDesignError | OSError):
        tell_error(f"solar-uav: {error}")
        return EXIT_FAILED
    raise error


if __name__ == "__main__":
    from studies.cli.start import start

    start()
