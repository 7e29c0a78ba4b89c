"""What ``solar-uav init``, ``validate`` and ``schema`` do."""

from __future__ import annotations

import os
import re
import shlex
import sys
from importlib import resources
from pathlib import Path

import click

from missions.files.errors import InputError, file_error, printable
from missions.files.validation import validate as check
from missions.files.writing import (
    names_a_device,
    to_json,
    write_files_atomically,
    write_text_atomically,
)
from missions.files.yaml import read_yaml
from missions.mission import Mission
from sizing.aircraft import Aircraft
from studies.cli.commands.start import Init, Schema, Validate
from studies.cli.options import EXIT_BAD_INPUT
from studies.cli.outputs import print_json, suggest
from studies.cli.telling import tell_error
from studies.exchange.schema import file_schema


def init(options: Init) -> None:
    """Write starter files, and say what to do next."""
    aircraft, mission = (path.name for path in write_starters(options.name, Path.cwd()))
    click.echo(f"wrote {aircraft}\nwrote {mission}")
    click.echo(f"next: edit both, then solar-uav validate {aircraft} {mission}")
    for verb in ("analyse", "size"):
        click.echo(f"then: solar-uav {verb} {aircraft} --mission {mission}")


def validate(options: Validate) -> None:
    """Tell of each file whether it is valid, or what is wrong with it."""
    wrong = False
    valid: dict[str, str] = {}
    for file in options.files:
        try:
            document = read_yaml(file)
            record = _record_of(set(document.data))
            check(document, record)
            kind = record.__name__.lower()
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


def _record_of(keys: set[str]) -> type[Aircraft | Mission]:
    """Return what a file with these keys describes: an aircraft, unless more are a mission's."""
    distinct = set(Aircraft.model_fields) ^ set(Mission.model_fields)
    of_mission = keys & distinct & set(Mission.model_fields)
    return Mission if 2 * len(of_mission) > len(keys & distinct) else Aircraft


def write_starters(name: str, folder: Path) -> list[Path]:
    """Write ``NAME.yaml`` and ``NAME-mission.yaml``; existing files are never overwritten.

    Returns the aircraft's file and the mission's.
    """
    name = re.sub(r"\.ya?ml$", "", name, flags=re.IGNORECASE)
    if re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}", name) is None:
        raise file_error(name, "a name has letters, digits, '-', '_' and '.', at most 64 of them")
    if names_a_device(name):
        message = "names a device of Windows, not a file: choose another name"
        raise file_error(name, message)
    templates = resources.files("studies").joinpath("templates")
    contents = {
        folder / f"{name}{ending}": templates.joinpath(template).read_text(encoding="utf-8")
        for ending, template in ((".yaml", "aircraft.yaml"), ("-mission.yaml", "mission.yaml"))
    }
    message = "exists already and is not overwritten"
    taken = [file_error(path.name, message) for path in contents if os.path.lexists(path)]
    if taken:
        raise InputError([problem for error in taken for problem in error.problems])
    write_files_atomically(
        {path: text.replace("NAME", name).encode() for path, text in contents.items()}
    )
    return list(contents)


def schema(options: Schema) -> None:
    """Print or write the schema of a kind of file."""
    record = file_schema(options.kind)
    if options.out_file is None:
        print_json(record)
        return
    write_text_atomically(options.out_file, to_json(record, indent=2) + "\n")
    click.echo(f"written to {options.out_file}")
