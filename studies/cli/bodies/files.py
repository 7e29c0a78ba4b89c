"""What ``solar-uav init`` and ``validate`` do."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

import click

from missions.files.errors import InputError, printable
from missions.files.validation import validate as check
from missions.files.yaml import read_yaml
from missions.mission import Mission
from sizing.aircraft import Aircraft
from studies.cli.commands.files import Init, Validate
from studies.cli.files import write_starters
from studies.cli.options import EXIT_BAD_INPUT
from studies.cli.outputs import suggest
from studies.cli.telling import tell_error


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
    """What a file with these keys describes: an aircraft, unless more are keys of a mission."""
    own = set(Aircraft.model_fields) ^ set(Mission.model_fields)
    of_mission = keys & own & set(Mission.model_fields)
    return Mission if 2 * len(of_mission) > len(keys & own) else Aircraft
