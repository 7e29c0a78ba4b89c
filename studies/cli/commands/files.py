"""Commands about files: ``solar-uav list``, ``show``, ``init`` and ``validate``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import click

from studies.cli.command import Command, argument, option
from studies.cli.options import json_option

if TYPE_CHECKING:
    from sizing.catalogues.choice import Kind


@dataclass(frozen=True)
class List:
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

    def __post_init__(self) -> None:
        """Refuse what does not go together."""
        if len(self.catalogues) > 1:
            named = " and ".join(f"--{kind}" for kind in self.catalogues)
            raise click.UsageError(f"{named}: one at a time")

    @property
    def catalogues(self) -> list[Kind]:
        """Catalogues that are asked for."""
        kinds: tuple[Kind, ...] = ("cells", "batteries", "motors", "propellers", "mppts")
        return [kind for kind in kinds if getattr(self, kind)]


@dataclass(frozen=True)
class Show:
    """Print the file of the shipped aircraft or mission NAME, comments included.

    It is one to start your own from.
    """

    name: str = argument()


@dataclass(frozen=True)
class Init:
    """Write commented starter files NAME.yaml and NAME-mission.yaml into this folder."""

    name: str = argument()


@dataclass(frozen=True)
class Validate:
    """Check aircraft and mission FILES and say everything that is wrong with them."""

    files: tuple[str, ...] = argument(nargs=-1, required=True, type=click.Path())


list_ = Command("list", List, "shipped:list_", "solar-uav list")
show = Command("show", Show, "shipped:show", "solar-uav show atlantiksolar-as2 > mine.yaml")
init = Command("init", Init, "files:init", "solar-uav init albatross")
validate = Command(
    "validate",
    Validate,
    "files:validate",
    "solar-uav validate albatross.yaml albatross-mission.yaml",
)
