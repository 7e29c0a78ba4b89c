"""Commands to start with: ``solar-uav list``, ``show``, ``init``, ``validate`` and ``schema``."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from studies.cli.command import CommandOptions, argument, command, option
from studies.cli.options import EXIT_BAD_INPUT
from studies.cli.values import OutputFile

if TYPE_CHECKING:
    from sizing.catalogues.choice import Kind

_HEADINGS = {"aircraft": "aircraft", "mission": "missions", "weather": "weather records"}


@command(
    "Shipped aircraft, missions and weather records.",
    "solar-uav list",
)
class List(CommandOptions):
    """List the aircraft, missions and weather records that ship with the package.

    With --cells, --batteries, --motors, --propellers or --mppts list what a catalogue has; --json
    has the sources.
    """

    cells: bool = option("List the solar cells instead.")
    batteries: bool = option("List the batteries.")
    motors: bool = option("List the motors.")
    propellers: bool = option("List the propellers.")
    mppts: bool = option("List the MPPTs.")
    as_json: bool = option("Print JSON.")

    def refuse(self) -> None:
        """Refuse what does not go together."""
        if len(self.catalogues) > 1:
            named = " and ".join(f"--{kind}" for kind in self.catalogues)
            raise click.UsageError(f"{named}: one at a time")

    @property
    def catalogues(self) -> list[Kind]:
        """Catalogues that are asked for."""
        kinds: tuple[Kind, ...] = ("cells", "batteries", "motors", "propellers", "mppts")
        return [kind for kind in kinds if getattr(self, kind)]

    def run(self) -> None:
        """Print what ships, or a catalogue."""
        from missions.files import shipped
        from studies.output import terminal
        from studies.render.tables import Grid

        for catalogue in self.catalogues:
            from studies.output.catalogues import catalogue_record, catalogue_table  # pydantic

            if self.as_json:
                terminal.print_json(catalogue_record(catalogue))
            else:
                terminal.show(catalogue_table(catalogue))
            return
        every = {
            kind: {
                name: str(shipped.find_document(kind, name).data.get("description", ""))
                for name in shipped.shipped_names(kind)
            }
            for kind in ("aircraft", "mission")
        }
        records = shipped.shipped_names("record")
        every["weather"] = {name: shipped.record_description(name) for name in records}
        if self.as_json:
            terminal.print_json(every)
            return
        for kind, entries in every.items():
            terminal.tell_line(_HEADINGS[kind], "strong")
            grid = Grid(None, list(entries.items()), (False, False))
            for line in grid.lines(terminal.line_width() - 2):
                terminal.tell_line(f"  {line}")


@command(
    "The file of a shipped aircraft, mission or record.",
    "solar-uav show atlantiksolar-as2 > mine.yaml",
)
class Show(CommandOptions):
    """Print the file of the shipped aircraft or mission NAME, comments included.

    It is one to start your own from.
    """

    name: str = argument()

    def run(self) -> None:
        """Print a shipped file."""
        from missions.files.shipped import shipped_text

        click.echo(shipped_text(self.name), nl=False)


@command(
    "Commented files to start your own aircraft from.",
    "solar-uav init albatross",
)
class Init(CommandOptions):
    """Write commented starter files NAME.yaml and NAME-mission.yaml into this folder."""

    name: str = argument()

    def run(self) -> None:
        """Write starter files, and say what to do next; existing ones are never overwritten."""
        from importlib import resources

        from missions.files.errors import InputError, file_error
        from missions.files.writing import names_a_device, write_files_atomically

        name = re.sub(r"\.ya?ml$", "", self.name, flags=re.IGNORECASE)
        if re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}", name) is None:
            message = "a name has letters, digits, '-', '_' and '.', at most 64 of them"
            raise file_error(name, message)
        if names_a_device(name):
            message = "names a device of Windows, not a file: choose another name"
            raise file_error(name, message)
        aircraft, mission = f"{name}.yaml", f"{name}-mission.yaml"
        templates, folder = resources.files("studies").joinpath("templates"), Path.cwd()
        contents: dict[str | os.PathLike[str], bytes] = {}
        for file, template in ((aircraft, "aircraft.yaml"), (mission, "mission.yaml")):
            text = templates.joinpath(template).read_text(encoding="utf-8")
            contents[folder / file] = text.replace("NAME", name).encode()
        message = "exists already and is not overwritten"
        taken = [
            file_error(file, message)
            for file in (aircraft, mission)
            if os.path.lexists(folder / file)
        ]
        if taken:
            raise InputError([problem for error in taken for problem in error.problems])
        write_files_atomically(contents)
        click.echo(f"wrote {aircraft}\nwrote {mission}")
        click.echo(f"next: edit both, then solar-uav validate {aircraft} {mission}")
        for verb in ("analyse", "size"):
            click.echo(f"then: solar-uav {verb} {aircraft} --mission {mission}")


@command(
    "Everything that is wrong with files.",
    "solar-uav validate albatross.yaml albatross-mission.yaml",
)
class Validate(CommandOptions):
    """Check aircraft and mission FILES and say everything that is wrong with them."""

    files: tuple[str, ...] = argument(nargs=-1, required=True, type=click.Path())

    def run(self) -> None:
        """Tell of each file whether it is valid, or what is wrong with it."""
        import shlex

        from missions.files.errors import InputError, printable
        from missions.files.validation import validate
        from missions.files.yaml import read_yaml
        from missions.mission import Mission
        from sizing.aircraft import Aircraft
        from studies.cli.outputs import suggest
        from studies.cli.telling import tell_error

        wrong, valid = False, dict[str, str]()
        distinct = set(Aircraft.model_fields) ^ set(Mission.model_fields)
        for file in self.files:
            try:
                document = read_yaml(file)
                # It is an aircraft, unless more of its keys are a mission's.
                keys = distinct & set(document.data)
                is_mission = 2 * len(keys & set(Mission.model_fields)) > len(keys)
                validate(document, Mission if is_mission else Aircraft)
                kind = "mission" if is_mission else "aircraft"
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


@command(
    "Completion of files in an editor.",
    "solar-uav schema aircraft --out aircraft.schema.json",
)
class Schema(CommandOptions):
    """Print the JSON Schema of aircraft or mission files, for completion in an editor."""

    kind: Literal["aircraft", "mission"] = argument(type=click.Choice(("aircraft", "mission")))
    out_file: str | None = option(
        "Write it instead of printing it.", type=OutputFile(), metavar="FILE"
    )

    def run(self) -> None:
        """Print or write the schema of a kind of file."""
        from missions.files.writing import to_json, write_bytes_atomically
        from studies.exchange.schema import file_schema
        from studies.output.terminal import print_json

        record = file_schema(self.kind)
        if self.out_file is None:
            print_json(record)
            return
        write_bytes_atomically(self.out_file, f"{to_json(record, indent=2)}\n".encode())
        click.echo(f"written to {self.out_file}")
