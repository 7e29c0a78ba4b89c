"""Options that several commands of ``solar-uav`` share; light, for help texts import this alone."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields
from importlib import import_module
from typing import TYPE_CHECKING, Any, TypeVar, cast

import click

from solar.names import CORRECTION_NAMES, MODEL_NAMES
from studies.cli.telling import tell_error
from studies.output.figures.options import SHIPPED_STYLES, FigureOptions, TooManyDotsError
from studies.output.formats import (
    IMAGE_FORMATS,
    TABLE_FORMATS,
    image_format,
    missing_writer,
    table_format,
)

EXIT_FAILED, EXIT_BAD_INPUT = 1, 2

_MAXIMUM_GRID = 2000
_MAXIMUM_WORKERS = 1000

Command = TypeVar("Command", bound=Callable[..., Any])


if TYPE_CHECKING:
    from click import ParamType as ParamType

    from studies.cli.files import Case
else:

    class ParamType(click.ParamType):
        """Base of the types below; click before 8.4 does not say of which values one is."""

        def __class_getitem__(cls, item: Any) -> type[ParamType]:
            """Take the type of values, for readers alone."""
            return cls


class Parsed(ParamType[Any]):
    """Values that a function of a study reads; it is imported when there is a value.

    ``reader``: module and function, ``package.module:function``; it takes text, and raises
    ValueError. ``stepped``: whether ``first:last:step`` may stand in a value, of which ``values``
    then are read.
    """

    def __init__(self, name: str, reader: str, *, stepped: bool = False) -> None:
        self.name, self._reader, self._stepped = name, reader, stepped

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read a value."""
        module, _, function = self._reader.partition(":")
        try:
            found = getattr(import_module(module), function)(str(value))
        except ValueError as error:
            self.fail(str(error), param, ctx)
        if self._stepped and str(value).count(":") == 2:
            written = f"{param.opts[0] if param else ''} {value}".strip()
            note_last(found.values[-1], float(str(value).split(":")[1]), written)
        return found


class Grid(ParamType["list[float]"]):
    """Numbers ``first:last:step``: first, and steps from there that do not lead beyond last.

    Where they do not lead to ``last`` itself, a note on standard error says where they end.
    """

    name = "first:last:step"

    def __init__(
        self, lowest: float, highest: float, *, whole: bool = False, latitudes: bool = False
    ) -> None:
        self.lowest, self.highest, self.whole = lowest, highest, whole
        self.latitudes = latitudes

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> list[float]:
        """Read the numbers and check their range.

        Returns from the first to the last in steps, both in the unit of the option.
        """
        try:
            parts = str(value).split(":")
            first, last, step = map(float, self._in_numbers(parts) if self.latitudes else parts)
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

    def _in_numbers(self, parts: list[str]) -> list[Any]:
        """Ends that may be written as 40N and 20S, and what follows them."""
        from missions.places import latitude_deg

        return [*map(latitude_deg, parts[:2]), *parts[2:]]


def note_last(reached: float, last: float, written: str) -> None:
    """Say on standard error where the steps of ``first:last:step`` end, if not at ``last``."""
    if abs(reached - last) > 1e-9 * max(abs(reached), abs(last)):
        text = f"{written} ends at {reached:g}: no whole number of steps leads to {last:g}"
        tell_error(f"solar-uav: {text}")


class RealRange(click.FloatRange):
    """Numbers of a range; unlike click's own it refuses NaN, which passes every comparison.

    ``above``, ``below``: whether numbers must lie above the lowest, and below the highest.
    """

    def __init__(
        self,
        lowest: float,
        highest: float,
        *,
        unit: str,
        above: bool = False,
        below: bool = False,
    ) -> None:
        super().__init__(lowest, highest, min_open=above, max_open=below)
        self.unit = unit

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Read the number and check its range.

        Returns in :attr:`unit`, within the range.
        """
        number = float(super().convert(value, param, ctx))
        if math.isnan(number):
            self.fail(f"must be a number of {self.unit}", param, ctx)
        return number


def completes(name: str) -> Callable[[click.Context, click.Parameter, str], Any]:
    """What completes an argument or option on the command line, imported when a shell asks."""

    def values(ctx: click.Context, param: click.Parameter, incomplete: str) -> Any:
        from studies.cli.completion import values_for

        return values_for(name, incomplete)

    return values


def aircraft_argument(default: str | None = None) -> Callable[[Command], Command]:
    """Argument ``AIRCRAFT``: name, file or folder; required without a default."""
    # A default of None is one, by click's rules: the argument would be missing without a word.
    given: dict[str, Any] = {} if default is None else {"default": default}
    return click.argument(
        "aircraft", required=default is None, shell_complete=completes("aircraft"), **given
    )


def mission_option(default: str | None = "rafz-july") -> Callable[[Command], Command]:
    """Option ``--mission``; without a default only a folder of results may stand in for it."""
    needed = "" if default else "  [required, unless AIRCRAFT is a folder that --out wrote]"
    help_text = f"Name or file.{needed}"
    return click.option(
        "--mission",
        "-m",
        default=default,
        show_default=True,
        shell_complete=completes("mission"),
        help=help_text,
    )


@dataclass(frozen=True)
class Asked:
    """What the options common to commands say: what is asked about, and in which form."""

    aircraft: str
    mission: str | None
    overrides: tuple[str, ...] = ()
    model: str = "CAM"
    correction: str = "none"
    as_json: bool = False
    required_h: float | None = None

    def case(self) -> Case:
        """Aircraft and mission as they are loaded; what is wrong with them is reported together."""
        from studies.cli.files import load

        given = vars(self).copy()
        required_h = given.pop("required_h")
        case = load(**given)
        if required_h is None:
            return case
        return case.with_mission(required_excess_time_h=required_h)


@dataclass(frozen=True)
class WorkOptions:
    """Where a command computes in chunks, and what it keeps of them."""

    workers: int | None = None
    scheduler: str | None = None
    work_dir: str | None = None
    keep_parts: bool = False

    def __post_init__(self) -> None:
        """Refuse what does not go together."""
        if self.scheduler not in (None, "local-cluster"):
            if self.workers is not None:
                raise click.UsageError(
                    "--workers: the scheduler's workers are those that were started for it; "
                    "allowed with --scheduler local-cluster"
                )
            if "://" not in str(self.scheduler):
                raise click.BadParameter(
                    f"must be tcp://HOST:PORT or local-cluster (got {self.scheduler!r})",
                    param_hint="--scheduler",
                )
        if self.keep_parts and self.work_dir is None:
            context = click.get_current_context(silent=True)
            if context is not None and context.params.get("out_file") is None:
                raise click.UsageError("--keep-parts needs --out or --work")


def gathered(name: str, kind: type[Any]) -> Callable[[Command], Command]:
    """Gather the options that a dataclass has as fields into a single argument of that name.

    What does not go together is refused by the class itself, with ``click.UsageError``.
    """
    names = [field.name for field in fields(kind)]

    def decorated(command: Command) -> Command:
        @functools.wraps(command)
        def gathering(*args: Any, **kwargs: Any) -> Any:
            given = {key: kwargs.pop(key) for key in names if key in kwargs}
            return command(*args, **kwargs, **{name: kind(**given)})

        return cast(Command, gathering)

    return decorated


set_option = click.option(
    "--set",
    "overrides",
    metavar="KEY=VALUE",
    multiple=True,
    shell_complete=completes("overrides"),
    help="Override a key of the aircraft file, e.g. power.avionics_w=8, or of the mission "
    "with the prefix 'mission.', e.g. mission.clearness=0.8. May be repeated.",
)
required_time_option = click.option(  # of ``asked``
    "--required-excess-time",
    "required_h",
    type=RealRange(0.0, 1000.0, unit="hours"),
    metavar="HOURS",
    help="Excess time that every scenario must have, instead of the mission's.",
)
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON instead of tables.")


def solar_options(command: Command) -> Command:
    """Options of the solar power model, ``--set`` and ``--json``, shared by all studies."""
    return json_option(model_options(command))


def set_options(command: Command) -> Command:
    """Option ``--set``; the command has it, aircraft and mission as ``asked``."""
    return set_option(gathered("asked", Asked)(command))


def case_options(command: Command) -> Command:
    """Options ``--set`` and ``--json``, of commands whose models are given; as ``asked``."""
    return set_options(json_option(command))


def model_options(command: Command) -> Command:
    """Options of the solar power model, and ``--set``; the command has them as ``asked``."""
    command = set_options(command)
    for option in (
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
    ):
        command = option(command)
    return command


def work_options(command: Command) -> Command:
    """Options of commands that compute in chunks; the command has them as ``work``."""
    command = gathered("work", WorkOptions)(command)
    for option in (
        click.option(
            "--keep-parts",
            is_flag=True,
            help="Keep the finished chunks when the result is written.",
        ),
        click.option(
            "--work",
            "work_dir",
            type=click.Path(),
            help="Folder for finished chunks.  [default: the name of --out with .parts]",
        ),
        click.option(
            "--scheduler",
            metavar="ADDRESS",
            help="Compute on a dask cluster: tcp://HOST:PORT, or local-cluster for one of this "
            "machine.",
        ),
        click.option(
            "--workers",
            type=click.IntRange(1, _MAXIMUM_WORKERS),
            help="Processes that compute; 1 starts none.  [default: as many as there are cores, "
            "where the work is worth their start]",
        ),
    ):
        command = option(command)
    return command


def out_option(contents: str) -> Callable[[Command], Command]:
    """Option ``--out`` of commands that write a folder."""
    text = f"Folder for aircraft, mission, results and {contents}; see docs/cli.md."
    return click.option("--out", "out_dir", type=click.Path(), help=text)


def table_option(
    contents: str, name: str = "--table", *, older: str = "--csv"
) -> Callable[[Command], Command]:
    """Option ``--table FILE`` of commands that write a table.

    ``name``: the option; the command has its file as ``table_file``, or ``table_years`` and the
    like. ``older``: what it was called when CSV was all that it wrote.
    """

    def checked(_: click.Context, option: click.Parameter, path: str | None) -> str | None:
        if path:
            check_table(path, table_format(path), TABLE_FORMATS, name)
        return path

    return click.option(
        *(name, older),
        "table_file" if name == "--table" else name.removeprefix("--").replace("-", "_"),
        type=click.Path(),
        metavar="FILE",
        callback=checked,
        help=f"Write {contents} ({', '.join(TABLE_FORMATS)}).",
    )


def check_table(path: str, found: str | None, allowed: Iterable[str], option: str) -> None:
    """Refuse the name of a table's file if its format is not one that can be written.

    ``found``: its format, none where it is not one of the allowed.
    """
    missing = missing_writer(found)
    if found is None:
        endings = ", ".join(f".{name}" for name in allowed)
        missing = f"{path!r} must end in {endings}"
    if missing is not None:
        raise click.BadParameter(missing, param_hint=option)


def figure_options(command: Command) -> Command:
    """Options of commands that draw; the command has them as ``figure``, a FigureOptions.

    They are refused where no figure is asked for: a command draws with ``--plot`` or ``--out``.
    """

    @functools.wraps(command)
    def drawing(*args: Any, **kwargs: Any) -> Any:
        given = {
            "size_in": kwargs.pop("figure_size"),
            "dots_per_inch": kwargs.pop("dpi"),
            "style": kwargs.pop("style"),
            "title": False if kwargs.pop("no_title") else None,
        }
        asked = {name: value for name, value in given.items() if value is not None}
        places = {"plot_file": "--plot", "out_dir": "--out"}
        draws = [option for name, option in places.items() if name in kwargs]
        if asked and not any(kwargs.get(name) is not None for name in places):
            option = _FIGURE_OPTIONS[next(iter(asked))]
            raise click.UsageError(f"{option} is of the figure: give {' or '.join(draws)} too")
        try:
            figure = FigureOptions(**asked)
        except ValueError as error:
            raise click.BadParameter(str(error), param_hint="--dpi") from None
        try:
            return command(*args, figure=figure, **kwargs)
        except TooManyDotsError as error:  # of a figure whose height is that of its content
            raise click.BadParameter(str(error), param_hint="--dpi") from None

    found: Any = drawing
    for option in (
        click.option("--no-title", is_flag=True, help="Leave title and notes to the caption."),
        click.option(
            "--style",
            type=Parsed("name|file", "studies.output.figures.drawing:read_style"),
            metavar="NAME|FILE",
            help=f"Type, lines and colours: {', '.join(SHIPPED_STYLES)}, a style of matplotlib, or "
            "an .mplstyle file.  [default: default]",
        ),
        click.option(
            "--dpi",
            type=Parsed("dots", "studies.output.figures.options:read_dots_per_inch"),
            metavar="DOTS",
            help="Dots per inch of PNG.  [default: 150]",
        ),
        click.option(
            "--figure-size",
            type=Parsed("size", "studies.output.figures.options:read_size"),
            metavar="WIDTHxHEIGHT",
            help="For example 170x100mm or 7x4in; a width alone, 85mm, leaves the height to the "
            "figure.",
        ),
    ):
        found = option(found)
    return cast(Command, found)


_FIGURE_OPTIONS = {
    "size_in": "--figure-size",
    "dots_per_inch": "--dpi",
    "style": "--style",
    "title": "--no-title",
}


def report_option(command: Command) -> Command:
    """Option ``--report`` of commands whose results a page may show."""
    text = "Also write a report, .html or .pdf; see docs/report.md."
    option = click.option("--report", "report_file", type=click.Path(), metavar="FILE", help=text)
    return option(command)


def check_image(path: str | None) -> None:
    """Refuse a figure's file name before any work if it asks for a format that is not drawn."""
    if path is not None and image_format(path) is None:
        allowed = ", ".join(f".{name}" for name in IMAGE_FORMATS)
        raise click.BadParameter(f"{path!r} must end in {allowed}", param_hint="--plot")


def print_json(record: Any) -> None:
    """Print a record as strict JSON."""
    from missions.files.writing import to_json  # not for --help

    click.echo(to_json(record, indent=2))
