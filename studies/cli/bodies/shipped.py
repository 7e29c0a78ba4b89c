"""What ``solar-uav list`` and ``show`` do."""

from __future__ import annotations

from typing import Any

import click

from missions.files.shipped import (
    find_document,
    record_description,
    shipped_names,
    shipped_records,
    shipped_text,
)
from missions.files.writing import to_json
from studies.cli.commands.start import List, Show
from studies.output import terminal
from studies.render.layout import Grid

_HEADINGS = {"aircraft": "aircraft", "mission": "missions", "weather": "weather records"}


def list_(options: List) -> None:
    """Print what ships, or a catalogue."""
    for catalogue in options.catalogues:
        from studies.output.catalogues import catalogue_record, catalogue_table  # pydantic

        if options.as_json:
            _print_json(catalogue_record(catalogue))
        else:
            terminal.show(catalogue_table(catalogue))
        return
    shipped = {
        kind: {
            name: str(find_document(kind, name).data.get("description", ""))
            for name in shipped_names(kind)
        }
        for kind in ("aircraft", "mission")
    }
    shipped["weather"] = {name: record_description(name) for name in shipped_records()}
    if options.as_json:
        _print_json(shipped)
        return
    for kind, entries in shipped.items():
        terminal.tell_line(_HEADINGS[kind], "strong")
        grid = Grid(None, list(entries.items()), (False, False))
        for line in grid.lines(terminal.line_width() - 2):
            terminal.tell_line(f"  {line}")


def _print_json(record: Any) -> None:
    click.echo(to_json(record, indent=2))


def show(options: Show) -> None:
    """Print a shipped file."""
    click.echo(shipped_text(options.name), nl=False)
