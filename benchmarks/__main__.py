"""``python -m benchmarks``: speed of commands, and of computing as ratios against peers.

CPU times depend on the machine and on what else it does; the ratios hold up better. A ratio above
one says how many times faster this project does the same work. Peers that are not installed are
left out, with a note.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import click

from benchmarks.against_aerosandbox import map_against_aerosandbox, sizing_against_aerosandbox
from benchmarks.commands import start_up, whole_commands
from benchmarks.day_and_night import one_day
from benchmarks.map_scaling import (
    full_map,
    large_maps,
    map_endurance,
    map_memory,
    map_sizes,
    two_processes,
)
from benchmarks.own_sizing import sizing
from benchmarks.report import duration, markdown, measured_before, plain, remember, this_machine
from benchmarks.solar_power import module_power

# In the order of the page.
PARTS: tuple[Callable[[], list[dict[str, Any]]], ...] = (
    start_up,
    whole_commands,
    module_power,
    one_day,
    sizing_against_aerosandbox,
    map_against_aerosandbox,
    sizing,
    full_map,
    map_endurance,
    two_processes,
    map_memory,
    map_sizes,
    large_maps,
)


@click.command()
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option(
    "--markdown",
    "markdown_file",
    type=click.Path(),
    help="Write the page to a file; parts that are not run stand there as they were measured last.",
)
@click.option(
    "--only",
    "names",
    multiple=True,
    type=click.Choice([part.__name__ for part in PARTS]),
    help="Part to run; may be repeated.",
)
@click.option("--long", "with_long", is_flag=True, help="Also maps of 10^6 and 10^7 cells.")
def main(as_json: bool, markdown_file: str | None, names: tuple[str, ...], with_long: bool) -> None:
    """Run the benchmarks and print a table, or JSON."""
    found: dict[str, Any] = {}
    for part in PARTS:
        name = part.__name__
        if name in names or (not names and (with_long or part is not large_maps)):
            found[name] = {"machine": this_machine(), "rows": part()}
            if not as_json:
                _show(found[name]["rows"])
    if markdown_file is not None:
        from missions.files.writing import write_bytes_atomically

        known = {**measured_before(), **found}
        known = {part.__name__: known[part.__name__] for part in PARTS if part.__name__ in known}
        remember(known)
        write_bytes_atomically(markdown_file, markdown(known).encode())
    if as_json:
        click.echo(json.dumps([r for part in found.values() for r in part["rows"]], indent=2))


def _show(rows: list[dict[str, Any]]) -> None:
    for r in rows:
        beside = ""
        if r["ratio"] is not None:
            beside = f"  {plain(r['ratio'])} x {r['peer']}"
        elif r["peer"] is not None:
            beside = f"  ({r['peer']})"
        elif "wall_s" in r:
            beside = f"  wall {duration(r['wall_s'])}"
        click.echo(f"{r['name']:26} {duration(r['ours_s']):>8}  {r['work']}{beside}")


if __name__ == "__main__":
    main()
