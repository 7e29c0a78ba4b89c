"""Commands about files: ``solar-uav list``, ``show``, ``init`` and ``validate``."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from missions.files.errors import InputError, printable
from studies.cli.help_texts import command
from studies.cli.options import EXIT_BAD_INPUT, completes, print_json
from studies.cli.telling import tell_error
from studies.output import terminal

if TYPE_CHECKING:
    from sizing.catalogues.files import Kind


@command("solar-uav list", name="list")
@click.option("--cells", is_flag=True, help="List the solar cells instead.")
@click.option("--batteries", is_flag=True, help="List the batteries.")
@click.option("--motors", is_flag=True, help="List the motors.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def list_(cells: bool, batteries: bool, motors: bool, as_json: bool) -> None:
    """List the aircraft, missions and weather records that ship with the package.

    With --cells, --batteries or --motors list what a catalogue has; --json has the sources.
    """
    flags: dict[Kind, bool] = {"cells": cells, "batteries": batteries, "motors": motors}
    asked = [kind for kind, flag in flags.items() if flag]
    if len(asked) > 1:
        raise click.UsageError(f"{' and '.join(f'--{kind}' for kind in asked)}: one at a time")
    if asked:
        from studies.output.catalogues import catalogue_record, catalogue_table

        if as_json:
            print_json(catalogue_record(asked[0]))
        else:
            terminal.show(catalogue_table(asked[0]))
        return
    from missions.files.shipped import (
        find_document,
        record_description,
        shipped_names,
        shipped_records,
    )
    from sizing.results.layout import Grid
    from studies.output.terminal import line_width, tell_line

    shipped = {
        kind: {
            name: str(find_document(kind, name).data.get("description", ""))
            for name in shipped_names(kind)
        }
        for kind in ("aircraft", "mission")
    }
    shipped["weather"] = {name: record_description(name) for name in shipped_records()}
    if as_json:
        print_json(shipped)
        return
    headings = {"aircraft": "aircraft", "mission": "missions", "weather": "weather records"}
    for kind, entries in shipped.items():
        tell_line(headings[kind], "strong")
        for line in Grid(None, list(entries.items()), (False, False)).lines(line_width() - 2):
            tell_line(f"  {line}")


@command("solar-uav show atlantiksolar-as2 > mine.yaml")
@click.argument("name", shell_complete=completes("shipped"))
def show(name: str) -> None:
    """Print the file of the shipped aircraft or mission NAME, comments included.

    It is one to start your own from.
    """
    from missions.files.shipped import shipped_text

    click.echo(shipped_text(name), nl=False)


@command("solar-uav init albatross")
@click.argument("name")
def init(name: str) -> None:
    """Write commented starter files NAME.yaml and NAME-mission.yaml into this folder."""
    from studies.cli.files import write_starters

    aircraft, mission = (path.name for path in write_starters(name, Path.cwd()))
    click.echo(f"wrote {aircraft}\nwrote {mission}")
    click.echo(f"next: edit both, then solar-uav validate {aircraft} {mission}")
    click.echo(f"then: solar-uav size {aircraft} --mission {mission}")


@command("solar-uav validate albatross.yaml albatross-mission.yaml")
@click.argument("files", nargs=-1, required=True, shell_complete=completes("files"))
def validate(files: tuple[str, ...]) -> None:
    """Check aircraft and mission FILES and say everything that is wrong with them."""
    from missions.files.shipped import document_kind
    from missions.files.validation import validate as check
    from missions.files.yaml import read_yaml
    from missions.mission import Mission
    from sizing.aircraft import Aircraft
    from studies.cli.outputs import suggest

    wrong = False
    valid: dict[str, str] = {}
    for file in files:
        try:
            document = read_yaml(file)
            kind = document_kind(document)
            if kind == "aircraft":
                check(document, Aircraft)
            else:
                check(document, Mission)
            click.echo(f"{printable(file)}: valid {kind}")
            valid.setdefault(kind, file)
        except InputError as error:
            tell_error(str(error))
            wrong = True
    if wrong:
        sys.exit(EXIT_BAD_INPUT)
    if len(valid) == 2:
        names = f"{shlex.quote(valid['aircraft'])} -m {shlex.quote(valid['mission'])}"
        suggest(f"solar-uav size {names}; a measured aircraft: solar-uav analyse {names}")
