"""``python -m benchmarks.reliability``: run attacks, keep what they found, write the page."""

from __future__ import annotations

import importlib
import sys
import time

import click

from benchmarks.reliability.record import Record, Row, kept, merged

# Modules of this package with ``attacks(count, seed) -> iterator of Row``; count None: as many
# cases as the page is made of.
_PARTS = ("faults", "inputs")


@click.group(invoke_without_command=True)
@click.option("--markdown", "page", type=click.Path(), help="Write the page of the kept records.")
@click.pass_context
def main(context: click.Context, page: str | None) -> None:
    """Attack the software, and count what holds."""
    if page is None:
        if context.invoked_subcommand is None:
            raise click.UsageError("nothing to do: give faults, inputs or --markdown FILE")
        return
    if context.invoked_subcommand is not None:
        raise click.UsageError("--markdown writes the page of kept records: give it alone")
    from benchmarks.reliability.page import markdown
    from missions.files.writing import write_text_atomically

    write_text_atomically(page, markdown(kept()))


def _part(name: str) -> click.Command:
    @click.option("--count", type=click.IntRange(1), help="Cases of each kind, or of all.")
    @click.option("--seed", type=click.IntRange(0), default=1, show_default=True)
    @click.option("--only", default="", metavar="TEXT", help="Kinds whose name holds this text.")
    @click.option(
        "--keep",
        is_flag=True,
        help="Keep the record that the page is made of; with --only, of these kinds.",
    )
    def run(count: int | None, seed: int, only: str, keep: bool) -> None:
        begun = time.monotonic()
        rows = []
        for row in importlib.import_module(f"benchmarks.reliability.{name}").attacks(
            count, seed, only
        ):
            _show(row)
            rows.append(row)
        command = f"python -m benchmarks.reliability {name}"
        record = Record(name, command, seed, round(time.monotonic() - begun), tuple(rows))
        click.echo(f"{record.held} of {record.cases} cases held, in {record.seconds:.0f} s")
        if keep:
            (merged(kept().get(name), record) if only else record).keep()
        if record.held < record.cases:
            sys.exit(1)

    return click.command(name, help=f"Attack by {name}.")(run)


def _show(row: Row) -> None:
    click.echo(f"{row.held:6} of {row.cases:6}  {row.subject}: {row.attack}")
    for text in row.broken:
        click.echo(f"        {text}")


for _name in _PARTS:
    main.add_command(_part(_name))

if __name__ == "__main__":
    main()
