"""What the commands share: loading, refusing, progress, files and printing."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from solar.names import ATTITUDE_MODELS

if TYPE_CHECKING:
    from missions.mission import Mission
    from studies.library import LoadedAircraft, LoadedMission


def load_both(
    aircraft: str, mission: str, overrides: tuple[str, ...]
) -> tuple[LoadedAircraft, LoadedMission]:
    """Load both files and report what is wrong with either of them together."""
    from missions.problems import InputError
    from studies.library import load_aircraft, load_mission, split_overrides

    of_aircraft, of_mission = split_overrides(overrides)
    try:
        craft = load_aircraft(aircraft, of_aircraft)
    except InputError as error:
        try:
            load_mission(mission, of_mission)
        except InputError as second:
            raise InputError([*error.problems, *second.problems]) from None
        raise
    return craft, load_mission(mission, of_mission)


def refuse_polar_night(mission: Mission, where: LoadedMission, *, options: bool) -> None:
    """Refuse scenarios in which the sun never rises: there is nothing to analyse or to size."""
    from missions.configfile import located_error

    scenarios = mission.scenarios()
    dark = scenarios.in_polar_night()
    if not dark.any():
        return
    label = scenarios.label(int(dark.argmax()))
    message = f"polar night: the sun never rises at {label}; allowed: latitudes and dates with sun"
    if options:
        raise click.UsageError(f"--latitude/--date: {message}")
    raise located_error(where.document, ("latitude_deg",), message)


def require_path(model: str, correction: str, craft: LoadedAircraft, where: LoadedMission) -> None:
    """Refuse VM, FM and the loiter correction without module surfaces and a flight path."""
    if model not in ATTITUDE_MODELS and correction != "loiter":
        return
    asked = f"--model {model}" if model in ATTITUDE_MODELS else "--correction loiter"
    require_path_for(asked, craft, where)


def require_path_for(asked: str, craft: LoadedAircraft, where: LoadedMission) -> None:
    """Refuse an aircraft without module surfaces and a mission without a flight path it can fly."""
    from missions.configfile import located_error
    from missions.flight_path import orbit

    if craft.aircraft.modules.geometry is None:
        message = f"{asked} needs the module surfaces: add geometry with its surfaces"
        raise located_error(craft.document, ("modules",), message)
    if where.mission.flight_path is None:
        message = f"{asked} needs a flight path: add flight_path with kind, radius_m, ..."
        raise located_error(where.document, ("name",), message)
    try:
        orbit(where.mission.flight_path, where.mission.wind, samples=4)
    except ValueError as error:
        raise located_error(where.document, ("flight_path",), str(error)) from None


@contextmanager
def progress_bar(unit: str) -> Iterator[Callable[[int, int], None]]:
    """Progress bar on a terminal's standard error, nothing elsewhere."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(unit)

        def update(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total)

        yield update


def write_files(contents: dict[str | os.PathLike[str], bytes]) -> None:
    """Write all files of a command, or none."""
    from missions.output_files import write_files_atomically

    write_files_atomically(contents)


def plot_format(path: str | None) -> str | None:
    """Image format of the file given to ``--plot``, none without one."""
    if path is None:
        return None
    from studies.formats import IMAGE_FORMATS, image_format

    found = image_format(path)
    if found is None:
        allowed = ", ".join(f".{f}" for f in IMAGE_FORMATS)
        raise click.BadParameter(f"{path!r} must end in {allowed}", param_hint="--plot")
    return found


def console() -> Any:
    """Console that prints names from files as they are."""
    from rich.console import Console

    return Console(highlight=False, markup=False, emoji=False)


def print_json(record: Any) -> None:
    """Print a record as strict JSON."""
    click.echo(json.dumps(record, indent=2, allow_nan=False))
