"""Tables that the site makes from data at its build, in place of ``<!-- table: NAME -->``.

On GitHub a page shows the command that prints such a table, or links to the file of its data: long
tables that take time lie in ``tables/``.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from sphinx.application import Sphinx

from sizing.catalogues.choice import KINDS, Kind, entries
from sizing.validity.ranges import ranges
from studies.output.catalogues import catalogue_table
from studies.render.tables import Column, Table

DOCS = Path(__file__).parents[1]
# With the sentence that links to the file of the table.
MARK = re.compile(r"(?:^\[Table\]\(tables/.*\n\n)?^<!-- table: ([\w-]+) -->$", re.M)


def catalogue(kind: Kind) -> str:
    """Return the entries of a catalogue as Markdown, and the sources of their numbers."""
    table = catalogue_table(kind)
    rows = tuple((f"`{name}`", *others) for name, *others in table.rows)
    columns = (Column("name"), Column("numbers"), Column("source"), Column("note"))
    sources = []
    for name, entry in entries(kind).items():
        others = [f"{key}: {text}" for key, text in entry.sources.items()]
        numbers = ", ".join(f"{key} {value:g}" for key, value in entry.numbers().items())
        sources.append((f"`{name}`", numbers, "; ".join([entry.source, *others]), entry.note or ""))
    shown = replace(table, title="", rows=rows).to_markdown()
    return f"{shown}\n{Table('', columns, tuple(sources)).to_markdown()}"


def validity() -> str:
    """Return the ranges in which the models hold, as Markdown."""
    columns = (Column("quantity"), Column("model"), Column("holds"), Column("where from"))
    rows = [
        (row.label, f"`{row.model}`", row.held or "as the file gives it", row.source)
        for row in ranges().values()
    ]
    return Table("", columns, tuple(rows)).to_markdown()


def symbols() -> str:
    """Return the symbols of the formulas as Markdown, with links to their pages."""
    with (DOCS / "symbols.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    lines = ["| symbol | unit | meaning | on the page |", "|---|---|---|---|"]
    for row in rows:
        links = ", ".join(f"[{page}]({page}.md)" for page in row["pages"].split())
        lines.append(f"| {row['symbol']} | {row['unit']} | {row['meaning']} | {links} |")
    return "\n".join(lines) + "\n"


TABLES: dict[str, Callable[[], str]] = {
    **{f"catalogue-{kind}": partial(catalogue, kind) for kind in KINDS},
    "ranges": validity,
    "symbols": symbols,
}


def table(name: str) -> str:
    """Return a table as Markdown: made now, or written before."""
    if name in TABLES:
        return TABLES[name]()
    return (DOCS / "tables" / f"{name}.md").read_text(encoding="utf-8")


def fill(app: Sphinx, docname: str, source: list[str]) -> None:
    """Put the tables into the text of a page before it is parsed."""
    source[0] = MARK.sub(lambda mark: table(mark[1]), source[0])


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx, before comments are left out."""
    app.connect("source-read", fill, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
