"""Options and steps that several commands of ``solar-uav`` share."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

import click

from solar.names import ATTITUDE_MODELS, CORRECTION_NAMES, MODEL_NAMES
from studies.output import formats

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from missions.mission import Mission
    from sizing.performance import SolarModel
    from studies.cli.library import LoadedAircraft, LoadedMission

EXIT_FAILED, EXIT_BAD_INPUT = 1, 2

_MAXIMUM_GRID = 2000

Command = TypeVar("Command", bound=Callable[..., Any])


class Grid(click.ParamType["list[float]"]):
    """Numbers ``first:last:step``: first, and steps from there that do not lead beyond last.

    Where they do not lead to ``last`` itself, a note on standard error says where they end.

    Parameters
    ----------
    lowest, highest : float
        What is allowed.
    whole : bool
        Whether all numbers must be whole.
    """

    name = "first:last:step"

    def __init__(self, lowest: float, highest: float, *, whole: bool = False) -> None:
        self.lowest, self.highest, self.whole = lowest, highest, whole

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> list[float]:
        """Read the numbers and check their range."""
        try:
            first, last, step = (float(part) for part in str(value).split(":"))
        except ValueError:
            self.fail(f"{value!r} is not first:last:step, for example -70:70:2", param, ctx)
        # NaN is no number that rises, and a step without end none that could be added.
        if not (self.lowest <= first <= last <= self.highest and 0.0 < step < math.inf):
            self.fail(
                f"must rise within {self.lowest:g} to {self.highest:g} by a positive step "
                f"(got {value})",
                param,
                ctx,
            )
        if self.whole and not (first.is_integer() and step.is_integer()):
            self.fail(f"takes whole numbers (got {value})", param, ctx)
        steps = (last - first) / step + 1e-9
        if steps >= _MAXIMUM_GRID:
            self.fail(f"has more than the {_MAXIMUM_GRID} numbers that are allowed", param, ctx)
        numbers = [first + i * step for i in range(int(steps) + 1)]
        note_last(numbers[-1], last, f"{param.opts[0] if param else ''} {value}".strip())
        return numbers


def note_last(reached: float, last: float, written: str) -> None:
    """Say on standard error where the steps of ``first:last:step`` end, if not at ``last``."""
    if abs(reached - last) > 1e-9 * max(abs(reached), abs(last)):
        text = f"{written} ends at {reached:g}: no whole number of steps leads to {last:g}"
        click.echo(f"solar-uav: {text}", err=True)


class RealRange(click.FloatRange):
    """Numbers of a range; unlike click's own it refuses NaN, which passes every comparison."""

    def __init__(self, lowest: float, highest: float, *, unit: str) -> None:
        super().__init__(lowest, highest)
        self.unit = unit

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Read the number and check its range."""
        number = float(super().convert(value, param, ctx))
        if math.isnan(number):
            self.fail(f"must be a number of {self.unit}", param, ctx)
        return number


def mission_option(default: str | None = "rafz-july") -> Callable[[Command], Command]:
    """Option ``--mission``, required without a default."""
    if default is None:
        return click.option("--mission", "-m", required=True, help="Name or file.")
    return click.option("--mission", "-m", default=default, show_default=True, help="Name or file.")


set_option = click.option(
    "--set",
    "overrides",
    metavar="KEY=VALUE",
    multiple=True,
    help="Override a key of the aircraft file, e.g. power.avionics_w=8, or of the mission "
    "with the prefix 'mission.', e.g. mission.clearness=0.8. May be repeated.",
)
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON instead of tables.")
required_time_option = click.option(
    "--required-excess-time",
    "required_h",
    type=RealRange(0.0, 1000.0, unit="hours"),
    metavar="HOURS",
    help="Excess time that every scenario must have, instead of the mission's.",
)


def solar_options(command: Command) -> Command:
    """Options of the solar power model, shared by all studies."""
    for option in (
        set_option,
        click.option(
            "--correction",
            type=click.Choice(CORRECTION_NAMES),
            default="none",
            show_default=True,
            help="Correction of the model's systematic error: none; report, as one flight measured "
            "it; loiter, from FM on the mission's flight path.",
        ),
        click.option(
            "--model",
            type=click.Choice(MODEL_NAMES, case_sensitive=False),
            default="CAM",
            show_default=True,
            help="Solar power model. CDM and CAM: horizontal modules; VM and FM: the aircraft's "
            "module surfaces on the mission's flight path.",
        ),
        json_option,
    ):
        command = option(command)
    return command


def load(
    aircraft: str, mission: str, overrides: tuple[str, ...]
) -> tuple[LoadedAircraft, LoadedMission]:
    """Load both files and report what is wrong with either of them together."""
    from missions.files.errors import InputError
    from studies.cli.library import open_aircraft, open_mission, split_overrides

    of_aircraft, of_mission = split_overrides(overrides)
    try:
        craft = open_aircraft(aircraft, of_aircraft)
    except InputError as error:
        try:
            open_mission(mission, of_mission)
        except InputError as second:
            raise InputError([*error.problems, *second.problems]) from None
        raise
    return craft, open_mission(mission, of_mission)


def require_path(model: str, correction: str, craft: LoadedAircraft, where: LoadedMission) -> None:
    """Refuse VM, FM and the loiter correction without module surfaces and a flight path."""
    if model not in ATTITUDE_MODELS and correction != "loiter":
        return
    asked = f"--model {model}" if model in ATTITUDE_MODELS else "--correction loiter"
    require_path_for(asked, craft, where)


def require_path_for(asked: str, craft: LoadedAircraft, where: LoadedMission) -> None:
    """Refuse an aircraft without module surfaces and a mission without a flight path it can fly."""
    from missions.files.validation import located_error
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


def refuse_polar_night(mission: Mission, where: LoadedMission, *, options: bool) -> None:
    """Refuse scenarios in which the sun never rises: there is nothing to analyse or to size."""
    from missions.files.validation import located_error

    scenarios = mission.scenarios()
    dark = scenarios.in_polar_night()
    if not dark.any():
        return
    label = scenarios.label(int(dark.argmax()))
    message = f"polar night: the sun never rises at {label}; allowed: latitudes and dates with sun"
    if options:
        raise click.UsageError(f"--latitude/--date: {message}")
    raise located_error(where.document, ("latitude_deg",), message)


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


def solar_model(model: str, correction: str) -> SolarModel:
    """Solar model that the options name."""
    from sizing.performance import SolarModel

    return SolarModel(model, correction)  # type: ignore[arg-type]  # click checked both


def check_outputs(**options: str | None) -> None:
    """Refuse files that cannot be written, or all be written, before any work is done for them.

    Parameters
    ----------
    **options
        Path given with each option, by the name of the option.
    """
    from studies.engine.chunk_store import check_target

    taken: dict[str, str] = {}
    for name, path in options.items():
        if path is None:
            continue
        option = f"--{name}"
        if not path:
            raise click.BadParameter("needs the name of a file", param_hint=option)
        check_target(path)
        place = os.path.realpath(path)
        if os.path.exists(place) and not os.path.isfile(place):  # noqa: PTH110, PTH113
            continue  # a device or a pipe takes one after the other
        if place in taken:
            raise click.UsageError(f"{taken[place]} and {option} name the same file {path!r}")
        taken[place] = option


def write_results(
    data_file: str | None,
    data: Callable[[], bytes],
    plot_file: str | None,
    draw: Callable[[], Figure],
) -> None:
    """Make and write those of both files that were asked for; if one cannot be, neither is."""
    from missions.files.writing import write_files_atomically

    contents: dict[str | os.PathLike[str], bytes] = {}
    if data_file is not None:
        contents[data_file] = data()
    if plot_file is not None:
        contents[plot_file] = figure_bytes(draw(), plot_file)
    write_files_atomically(contents)


def csv_bytes(table: pd.DataFrame) -> bytes:
    """Table as CSV without its index."""
    return str(table.to_csv(index=False)).encode()


def figure_bytes(figure: Figure, path: str) -> bytes:
    """Figure in the format that its file name asks for."""
    from studies.output.plots import to_bytes

    return to_bytes(figure, image_format(path))


def require_parametric(craft: LoadedAircraft, asked: str) -> None:
    """Refuse a measured aircraft where masses and power must follow from the design."""
    from sizing.aircraft import MeasuredAirframe

    if not isinstance(craft.aircraft.airframe, MeasuredAirframe):
        return
    from missions.files.validation import located_error

    message = f"{asked} needs a parametric aircraft, this one is measured"
    raise located_error(craft.document, ("airframe", "kind"), message)


def check_image(path: str | None) -> None:
    """Refuse a figure's file name before any work if it asks for a format that is not drawn."""
    if path is not None:
        image_format(path)


def image_format(path: str) -> str:
    """Format that a figure's file name asks for; others are refused."""
    found = formats.image_format(path)
    if found is None:
        allowed = ", ".join(f".{name}" for name in formats.IMAGE_FORMATS)
        raise click.BadParameter(f"{path!r} must end in {allowed}", param_hint="--plot")
    return found


def console() -> Any:
    """Console for tables."""
    from rich.console import Console

    # Names from files are text, never markup.
    return Console(highlight=False, markup=False, emoji=False)


def print_json(record: Any) -> None:
    """Print a record as strict JSON."""
    click.echo(json.dumps(record, indent=2, allow_nan=False))
