"""A command: a data class that declares its options, and a function that is given one.

The class stands in ``studies.cli.commands``, and is all that help and completion need; the function
in ``studies.cli.bodies``, imported with everything heavy once the options go together.
"""

from __future__ import annotations

import os
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field, fields
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import click

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
        "--json",
    ),
    "Figures": ("--figure-size", "--dpi", "--style", "--no-title"),
    "Long computations": ("--workers", "--scheduler", "--work", "--keep-parts"),
}
_OWN = "Options"
_BODIES = "studies.cli.bodies"
_LONGEST_CHOICE = 40  # characters beside the name of the option


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
    ``*examples``: calls as they are typed, shown at the end of the help text, below options by
    subject.
    """

    def __init__(self, name: str, options: type[Any], body: str, *examples: str) -> None:
        self.options, self.body, self.examples = options, body, examples
        self._declared = _Group(options, {one.name: one.metadata["of"] for one in fields(options)})
        params = list(_parameters(self._declared))
        super().__init__(name, help=options.__doc__, callback=self._perform, params=params)

    def _perform(self, **given: Any) -> None:
        options, body = _made(self._declared, given), self.loaded_body()
        self._check_outputs(given)
        try:
            body(options)
        except TooManyDotsError as error:  # of a figure whose height is that of its content
            raise click.BadParameter(str(error), param_hint="--dpi") from None

    def loaded_body(self) -> Callable[[Any], None]:
        """Import what the command does, and all that it needs."""
        module, _, function = self.body.partition(":")
        body: Callable[[Any], None] = getattr(import_module(f"{_BODIES}.{module}"), function)
        return body

    def _check_outputs(self, given: Mapping[str, Any]) -> None:
        """Refuse files and folders that cannot be written, before any work is done for them."""
        written: dict[type[Any], dict[str, str | None]] = {OutputFile: {}, OutputFolder: {}}
        for one in self.params:
            if type(one.type) in written:
                written[type(one.type)][one.opts[0]] = given[str(one.name)]
        check_outputs(written[OutputFile], written[OutputFolder])

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

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the examples."""
        if self.examples:
            with formatter.section("Example" if len(self.examples) == 1 else "Examples"):
                indent = " " * formatter.current_indent
                for example in self.examples:
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
