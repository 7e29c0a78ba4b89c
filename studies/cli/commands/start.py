"""Commands to start with: ``solar-uav list``, ``show``, ``init``, ``validate`` and ``schema``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import click

from studies.cli.command import CommandOptions, argument, command, option
from studies.cli.options import json_option
from studies.cli.values import OutputFile

if TYPE_CHECKING:
    from sizing.catalogues.choice import Kind


@command(
    "Start",
    "Shipped aircraft, missions and weather records.",
    "shipped:list_",
    "solar-uav list",
)
class List(CommandOptions):
    """List the aircraft, missions and weather records that ship with the package.

    With --cells, --batteries, --motors, --propellers or --mppts list what a catalogue has; --json
    has the sources.
    """

    cells: bool = option("--cells", is_flag=True, help="List the solar cells instead.")
    batteries: bool = option("--batteries", is_flag=True, help="List the batteries.")
    motors: bool = option("--motors", is_flag=True, help="List the motors.")
    propellers: bool = option("--propellers", is_flag=True, help="List the propellers.")
    mppts: bool = option("--mppts", is_flag=True, help="List the MPPTs.")
    as_json: bool = json_option("Print JSON.")

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


@command(
    "Start",
    "The file of a shipped aircraft, mission or record.",
    "shipped:show",
    "solar-uav show atlantiksolar-as2 > mine.yaml",
)
class Show(CommandOptions):
    """Print the file of the shipped aircraft or mission NAME, comments included.

    It is one to start your own from.
    """

    name: str = argument()


@command(
    "Start",
    "Commented files to start your own aircraft from.",
    "files:init",
    "solar-uav init albatross",
)
class Init(CommandOptions):
    """Write commented starter files NAME.yaml and NAME-mission.yaml into this folder."""

    name: str = argument()


@command(
    "Start",
    "Everything that is wrong with files.",
    "files:validate",
    "solar-uav validate albatross.yaml albatross-mission.yaml",
)
class Validate(CommandOptions):
    """Check aircraft and mission FILES and say everything that is wrong with them."""

    files: tuple[str, ...] = argument(nargs=-1, required=True, type=click.Path())


@command(
    "Start",
    "Completion of files in an editor.",
    "files:schema",
    "solar-uav schema aircraft --out aircraft.schema.json",
)
class Schema(CommandOptions):
    """Print the JSON Schema of aircraft or mission files, for completion in an editor."""

    kind: Literal["aircraft", "mission"] = argument(type=click.Choice(("aircraft", "mission")))
    out_file: str | None = option(
        "--out", type=OutputFile(), metavar="FILE", help="Write it instead of printing it."
    )
