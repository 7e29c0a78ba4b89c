"""Tables of the documentation, written by the software itself: ``python -m benchmarks.doc_tables``.

A table stands between the markers ``<!-- NAME -->`` and ``<!-- /NAME -->`` of a page.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from benchmarks.validation import altitude_tables, clear_sky_comparison, found_designs
from benchmarks.validation.slender_wings import aspect_ratio_table, structure_table
from benchmarks.validation.structure_comparison import gust_table, structure_tables
from missions.files.writing import write_text_atomically
from missions.library import load_mission
from sizing.catalogues.files import KINDS, Kind
from sizing.energy.battery_condition import Ageing, cycles_to_end_of_life
from sizing.library import load_aircraft
from sizing.results.tables import Column, Table
from sizing.validity.ranges import ranges
from studies.models.comparison import compare
from studies.models.transfer import transfer_table, transferred_errors
from studies.output.catalogues import catalogue_table, sources_table
from studies.validation.flights.published_flights import facts_table
from studies.validation.flights.season import seasons
from studies.validation.flights.single_inputs import explain
from studies.validation.published import published
from studies.validation.report_reproduction import reference, reproduce


def _markdown(*tables: Table) -> str:
    return "\n".join(table.to_markdown() for table in tables)


def _clear_sky(sites: Sequence[clear_sky_comparison.Site] = clear_sky_comparison.SITES) -> str:
    return _markdown(clear_sky_comparison.clear_sky_table(clear_sky_comparison.compare(sites)))


def _light() -> str:
    return _markdown(clear_sky_comparison.light_table(clear_sky_comparison.light_up_to()))


def _comparison(aircraft: str, mission: str, required_h: float) -> str:
    found = compare(
        load_aircraft(aircraft), load_mission(mission), required_excess_time_h=required_h
    )
    return f"{_markdown(*found.tables())}\n{found.headline()}\n"


def _ranges() -> str:
    """Catalogue of the ranges in which the models hold."""
    columns = (Column("quantity"), Column("model"), Column("holds"), Column("where from"))
    rows = [
        (row.label, f"`{row.model}`", row.held or "as the file gives it", row.source)
        for row in ranges().values()
    ]
    return _markdown(Table("", columns, tuple(rows)))


def _battery_life() -> str:
    """Cycles to the end of a battery's life, a cycle a day."""
    temperatures_c = (0.0, 10.0, 25.0, 35.0)
    columns = (
        Column("depth of discharge"),
        *(Column(f"at_{t:.0f}", f"stored at {t:.0f} C") for t in temperatures_c),
    )
    rows = []
    for depth in (0.2, 0.4, 0.6, 0.8, 1.0):
        lives = (
            cycles_to_end_of_life(Ageing(depth_of_discharge=depth, temperature_c=t))
            for t in temperatures_c
        )
        rows.append((f"{100.0 * depth:.0f} %", *(f"{life:.0f}" for life in lives)))
    return _markdown(Table("", columns, tuple(rows)))


def _catalogue(kind: Kind) -> str:
    table = catalogue_table(kind)
    rows = tuple((f"`{name}`", *others) for name, *others in table.rows)
    return _markdown(replace(table, title="", rows=rows))


TABLES: dict[str, tuple[str, Callable[[], str]]] = {
    "published": ("validation.md", lambda: _markdown(published().table())),
    "flights": ("validation.md", lambda: _markdown(facts_table())),
    "single-inputs": ("validation.md", lambda: _markdown(explain().page())),
    "season": ("validation.md", lambda: _markdown(seasons().table())),
    "clear-sky": ("validation.md", _clear_sky),
    "clear-sky-rafz": ("solar.md", partial(_clear_sky, (clear_sky_comparison.RAFZ,))),
    "found-designs": ("validation.md", lambda: _markdown(found_designs.found_table())),
    "report": ("validation.md", lambda: _markdown(*reproduce(*reference(), vary=True).tables())),
    "structure": ("structure.md", lambda: _markdown(*structure_tables())),
    "gusts": ("structure.md", lambda: _markdown(gust_table())),
    "aspect-ratio": ("structure.md", lambda: _markdown(aspect_ratio_table())),
    "slender-wings": (
        "validation.md",
        lambda: _markdown(structure_table()),
    ),
    "transfer": (
        "full-model.md",
        lambda: _markdown(transfer_table(transferred_errors(*reference()))),
    ),
    "light": ("altitude.md", _light),
    "battery-life": ("battery.md", _battery_life),
    "catalogue-cells": ("catalogues.md", partial(_catalogue, "cells")),
    "catalogue-batteries": ("catalogues.md", partial(_catalogue, "batteries")),
    "catalogue-motors": ("catalogues.md", partial(_catalogue, "motors")),
    "catalogue-sources": ("catalogues.md", lambda: _markdown(*map(sources_table, KINDS))),
    "ranges": ("validity.md", _ranges),
    "ceilings": ("altitude.md", lambda: _markdown(altitude_tables.ceilings())),
    "climbs": ("altitude.md", lambda: _markdown(altitude_tables.climbs())),
    "compare-as2": ("compare.md", partial(_comparison, "atlantiksolar-as2", "rafz-july", 0.0)),
    "compare-design": (
        "compare.md",
        partial(_comparison, "atlantiksolar-design", "central-europe-summer", 3.0),
    ),
}


def with_table(page: str, name: str, table: str) -> str:
    """Page with a table put between its markers.

    Parameters
    ----------
    page : str
        Text of the page, in Markdown.
    name : str
        Name in the markers, ``<!-- name -->`` and ``<!-- /name -->``.
    table : str
        What comes between them.

    Returns
    -------
    str
        Text of the page.

    Raises
    ------
    ValueError
        If the page does not have exactly one pair of the markers.
    """
    pattern = re.compile(rf"(<!-- {name} -->\n).*?(<!-- /{name} -->)", re.DOTALL)
    found = pattern.findall(page)
    if len(found) != 1:
        raise ValueError(f"need one pair of markers for {name}, found {len(found)}")
    return pattern.sub(lambda m: f"{m[1]}\n{table}\n{m[2]}", page)


def update(folder: Path) -> list[Path]:
    """Write all tables into the pages of a folder; returns the pages that changed."""
    changed = []
    for name, (page, make) in TABLES.items():
        path = folder / page
        before = path.read_text(encoding="utf-8")
        after = with_table(before, name, make())
        if after != before:
            write_text_atomically(path, after)
            changed.append(path)
    return changed


def main(arguments: Sequence[str]) -> int:
    """Write the tables into the pages of a folder; the exit code is 1 where that cannot be.

    Parameters
    ----------
    arguments : sequence of str
        The folder; ``docs`` in the working folder if there is none.
    """
    folder = Path(arguments[0] if arguments else "docs")
    pages = dict.fromkeys(page for page, _ in TABLES.values())
    missing = [page for page in pages if not (folder / page).is_file()]
    if missing:
        print(
            f"{folder} has no {missing[0]}: start this in a clone of the project, or name the "
            "folder of the pages",
            file=sys.stderr,
        )
        return 1
    try:
        changed = update(folder)
    except ImportError as error:
        print(f"{error}: install the extra 'test', pip install '.[test]'", file=sys.stderr)
        return 1
    for page in changed:
        print(f"updated {page}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
