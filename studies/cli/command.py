"""A command: a data class that declares its options, and a function that is given one.

The class stands in ``studies.cli.commands``, and is all that help needs; the function
in ``studies.cli.bodies``, imported with everything heavy once the options go together.
"""

from __future__ import annotations

import math
import os
import re
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field, fields
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from studies.cli.telling import tell_error
from studies.output.figures.options import TooManyDotsError

# Headings of ``--help`` for the options that many commands have, and these below each in their
# order; the rest is the command's own.
_SUBJECTS = {
    "Solar power model, changes of the files": ("--model", "--correction", "--set"),
    "Output": (
        "--out",
        "--table",
        "--table-years",
        "--markdown",
        "--plot",
        "--pareto",
        "--pdf",
        "--report",
        "--verbose",
        "--json",
    ),
    "Figures": ("--figure-size", "--dpi", "--style", "--no-title"),
    "Long computations": ("--workers", "--scheduler", "--work", "--keep-parts"),
}
_OWN = "Options"
_BODIES = "studies.cli.bodies"
_MAXIMUM_GRID = 2000  # numbers of first:last:step
_LONGEST_CHOICE = 40  # characters beside the name of the option
_DECIMAL = r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)"
_LATITUDE = re.compile(rf"({_DECIMAL}) *°? *([ns])|([+-]?{_DECIMAL}) *°", re.IGNORECASE)


class _Parameter(NamedTuple):
    """Parameter of the command line, apart from its name, which is that of a field."""

    kind: type[click.Parameter]
    spelled: tuple[str, ...]
    settings: dict[str, Any]


class _Group(NamedTuple):
    """What makes one value of several parameters; it refuses those that do not go together."""

    make: Callable[..., Any]
    parts: Mapping[str, _Parameter | _Group]


class OutputFile(click.Path):
    """File that a command writes; it is checked before any work is done for it."""


class OutputFolder(click.Path):
    """Folder that a command writes; it is checked before any work is done for it."""


def option(*spelled: str, **settings: Any) -> Any:
    """Field that an option fills; ``settings`` are those of :func:`click.option`."""
    return field(kw_only=True, metadata={"of": _Parameter(click.Option, spelled, settings)})


def argument(**settings: Any) -> Any:
    """Field that an argument fills; ``settings`` are those of :func:`click.argument`."""
    return field(kw_only=True, metadata={"of": _Parameter(click.Argument, (), settings)})


def group(make: Callable[..., Any], **parts: Any) -> Any:
    """Field whose value is made of several options and arguments, by their names.

    What does not go together is refused by ``make`` itself, with ``click.UsageError``.
    """
    found = {name: part.metadata["of"] for name, part in parts.items()}
    return field(kw_only=True, metadata={"of": _Group(make, found)})


class Command(click.Command):
    """Command whose options are the fields of a data class, whose help text is its docstring.

    ``body``: what is called with an instance, ``module:function`` of :mod:`studies.cli.bodies`.
    ``*examples``: calls as they are typed, shown first in the help text; options stand by subject.
    """

    def __init__(self, name: str, options: type[Any], body: str, *examples: str) -> None:
        self.options, self.body, self.examples = options, body, examples
        self._declared = _Group(options, {one.name: one.metadata["of"] for one in fields(options)})
        params = list(_parameters(self._declared))
        super().__init__(name, help=options.__doc__, callback=self._perform, params=params)

    def _perform(self, **given: Any) -> None:
        options = _made(self._declared, given)
        if (given.get("workers") or 1) > 1 and not given.get("scheduler"):
            from studies.engine.workers import fork_from

            fork_from(self.module)  # while this process imports the same
        body = self.loaded_body()
        written: dict[type[Any], dict[str, str | None]] = {OutputFile: {}, OutputFolder: {}}
        for one in self.params:
            if type(one.type) in written:
                written[type(one.type)][one.opts[0]] = given[str(one.name)]
        check_outputs(written[OutputFile], written[OutputFolder])
        try:
            body(options)
        except TooManyDotsError as error:  # of a figure whose height is that of its content
            raise click.BadParameter(str(error), param_hint="--dpi") from None

    @property
    def module(self) -> str:
        """Module of what the command does."""
        return f"{_BODIES}.{self.body.partition(':')[0]}"

    def loaded_body(self) -> Callable[[Any], None]:
        """Import what the command does, and all that it needs."""
        function = self.body.partition(":")[2]
        body: Callable[[Any], None] = getattr(import_module(self.module), function)
        return body

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options, those of many commands under headings of their own."""
        records: dict[str, list[tuple[str, str]]] = {_OWN: [], **{name: [] for name in _SUBJECTS}}
        options = [one for one in self.get_params(ctx) if isinstance(one, click.Option)]
        for option in sorted(options, key=lambda one: _position(one.opts)):
            record = option.get_help_record(ctx)
            if record is not None:
                records[_subject(option.opts)].append(_with_choices(option, *record))
        for name, some in records.items():
            if some:
                with formatter.section(name):
                    formatter.write_dl(some)

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the examples, and what the command is for."""
        write_examples(formatter, self.examples)
        super().format_help_text(ctx, formatter)


def write_examples(formatter: click.HelpFormatter, examples: Sequence[str]) -> None:
    """Write calls as they are typed under a heading of their own."""
    with formatter.section("Example" if len(examples) == 1 else "Examples"):
        indent = " " * formatter.current_indent
        for example in examples:
            lines = textwrap.wrap(
                example,
                formatter.width - len(" \\"),
                initial_indent=indent,
                subsequent_indent=f"{indent}    ",
                break_long_words=False,
                break_on_hyphens=False,
            )
            formatter.write(" \\\n".join(lines) + "\n")


def _parameters(declared: _Group) -> Iterator[click.Parameter]:
    for name, part in declared.parts.items():
        if isinstance(part, _Group):
            yield from _parameters(part)
        else:
            yield part.kind([*part.spelled, name], **part.settings)


def _made(declared: _Group, given: Mapping[str, Any]) -> Any:
    return declared.make(
        **{
            name: _made(part, given) if isinstance(part, _Group) else given[name]
            for name, part in declared.parts.items()
        }
    )


def check_outputs(
    files: Mapping[str, str | None], folders: Mapping[str, str | None] | None = None
) -> None:
    """Refuse what cannot be written, or not all of it, before any work is done for it.

    ``files``, ``folders``: path given with each option.
    """
    from missions.files.writing import check_writable_file, check_writable_folder  # not for help

    for option, path in (folders or {}).items():
        if path is not None:
            if not path:
                raise click.BadParameter("needs the name of a folder", param_hint=option)
            check_writable_folder(Path(path))
    taken: dict[str, str] = {}
    for option, path in files.items():
        if path is None:
            continue
        if not path:
            raise click.BadParameter("needs the name of a file", param_hint=option)
        check_writable_file(path)
        if os.path.exists(path) and not os.path.isfile(path):  # noqa: PTH110, PTH113
            continue  # a device or a pipe takes one after the other
        folder, file = os.path.split(os.path.abspath(path))  # noqa: PTH100
        place = os.path.join(os.path.realpath(folder), file)  # noqa: PTH118
        if place in taken:
            raise click.UsageError(f"{taken[place]} and {option} name the same file {path!r}")
        taken[place] = option


def _subject(options: Sequence[str]) -> str:
    return next((name for name, some in _SUBJECTS.items() if set(some) & set(options)), _OWN)


def _position(options: Sequence[str]) -> int:
    """Place of an option among those of its subject; a command's own stay in theirs, help last."""
    names = [*_SUBJECTS.get(_subject(options), ()), "--help"]
    return next((place for place, name in enumerate(names) if name in options), 0)


def _with_choices(option: click.Option, left: str, right: str) -> tuple[str, str]:
    """Names to choose from as one writes them; long lists in the text, where lines break."""
    if not isinstance(option.type, click.Choice):
        return left, right
    names = [str(name) for name in option.type.choices]
    left, _, _ = left.partition(" [")
    listed = "|".join(names)
    if len(listed) <= _LONGEST_CHOICE:
        return f"{left} [{listed}]", right
    return f"{left} NAME", f"One of {', '.join(names)}. {right}"


# ---- Types of values


if TYPE_CHECKING:
    from click import ParamType as ParamType
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
            converted = getattr(import_module(module), function)(str(value))
        except ValueError as error:
            self.fail(str(error), param, ctx)
        if self._stepped and str(value).count(":") == 2:
            written = f"{param.opts[0] if param else ''} {value}".strip()
            note_last(converted.values[-1], float(str(value).split(":")[1]), written)
        return converted


def latitude_deg(text: str) -> float:
    """Latitude [deg], north positive, of ``-33.9``, ``-33.9°``, ``33.9S`` or ``33.9° S``.

    Another text is a ValueError.
    """
    match = _LATITUDE.fullmatch(text.strip())
    try:
        if "_" in text:  # Python's own notation, nobody's latitude
            raise ValueError
        number = float((match[1] or match[3]) if match else text)
    except ValueError:
        raise ValueError(
            f"{text!r} is not a number of degrees; north is positive, or written 47.6N, 33.9S"
        ) from None
    number = -number if match and match[2] in ("s", "S") else number
    if not -90.0 <= number <= 90.0:
        raise ValueError(f"must be from -90 to 90 (got {text})")
    return number


class Grid(ParamType["list[float]"]):
    """Numbers ``first:last:step``, or one: first, and steps from there that do not go beyond last.

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
            parts: list[Any] = str(value).split(":")
            if len(parts) == 1:
                parts = [*parts, *parts, "1"]
            if self.latitudes:  # whose ends may be written as 40N and 20S
                parts[:2] = map(latitude_deg, parts[:2])
            first, last, step = map(float, parts)
        except ValueError:
            self.fail(
                f"{value!r} is no number and not first:last:step, for example -70:70:2", param, ctx
            )
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
        tell_error(f"solar-uav: {text}")


class RealRange(click.FloatRange):
    """Numbers of a range; unlike click's own it refuses NaN, which passes every comparison.

    ``above``, ``below``: whether numbers must lie above the lowest, and below the highest.
    """

    def __init__(
        self, lowest: float, highest: float, *, unit: str, above: bool = False, below: bool = False
    ) -> None:
        super().__init__(lowest, highest, min_open=above, max_open=below)
        self.unit = unit

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Read the number and check its range.

        Returns in :attr:`unit`, within the range.
        """
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if math.isnan(number):
            text = f"must be a number of {self.unit}, written without a unit (got {value})"
            self.fail(text, param, ctx)
        super().convert(number, param, ctx)
        return number
