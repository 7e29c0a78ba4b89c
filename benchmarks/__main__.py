"""``python -m benchmarks``: speed as ratios against peers, measured in one process.

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
from benchmarks.day_and_night import one_day
from benchmarks.map_scaling import map_scaling
from benchmarks.own_sizing import sizing
from benchmarks.report import duration, markdown, plain
from benchmarks.solar_power import module_power
from benchmarks.weather_year import weather_year

PARTS: tuple[Callable[[], list[dict[str, Any]]], ...] = (
    module_power,
    one_day,
    sizing_against_aerosandbox,
    map_against_aerosandbox,
    sizing,
    map_scaling,
    weather_year,
)


@click.command()
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option("--markdown", "markdown_file", type=click.Path(), help="Write the page to a file.")
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
    rows = []
    for part in PARTS:
        if not names or part.__name__ in names:
            rows += map_scaling(long=with_long) if part is map_scaling else part()
    if markdown_file is not None:
        from missions.files.writing import write_text_atomically

        write_text_atomically(markdown_file, markdown(rows))
    if as_json:
        click.echo(json.dumps(rows, indent=2))
        return
    for r in rows:
        peer = ""
        if r["ratio"] is not None:
            peer = f"  {plain(r['ratio'])} x {r['peer']}"
        elif r["peer"] is not None:
            peer = f"  ({r['peer']})"
        click.echo(f"{r['name']:26} {duration(r['ours_s']):>8}  {r['work']}{peer}")


if __name__ == "__main__":
    main()
