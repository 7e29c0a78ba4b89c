"""A command: a data class that declares its options, and a function that is given one.

The class stands in ``studies.cli.commands``, and is all that help and completion need; the function
in ``studies.cli.bodies``, imported with everything heavy once the options go together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import field, fields
from importlib import import_module
from typing import Any, NamedTuple

import click

from studies.cli.help_texts import HelpedCommand
from studies.output.figures.options import TooManyDotsError


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


class Command(HelpedCommand):
    """Command whose options are the fields of a data class, whose help text is its docstring.

    ``body``: what is called with an instance, ``package.module:function``. ``*examples``: calls as
    they are typed, shown at the end of the help text.
    """

    def __init__(self, name: str, options: type[Any], body: str, *examples: str) -> None:
        self.options, self.body = options, body
        self._declared = _Group(options, {one.name: one.metadata["of"] for one in fields(options)})
        params = list(_parameters(self._declared))
        super().__init__(
            name=name,
            help=options.__doc__,
            callback=self._perform,
            params=params,
            examples=examples,
        )

    def _perform(self, **given: Any) -> None:
        options = _made(self._declared, given)
        module, _, function = self.body.partition(":")
        body = getattr(import_module(module), function)
        self._check_outputs(given)
        try:
            body(options)
        except TooManyDotsError as error:  # of a figure whose height is that of its content
            raise click.BadParameter(str(error), param_hint="--dpi") from None

    def _check_outputs(self, given: Mapping[str, Any]) -> None:
        """Refuse files and folders that cannot be written, before any work is done for them."""
        written: dict[type[Any], dict[str, str | None]] = {OutputFile: {}, OutputFolder: {}}
        for one in self.params:
            if type(one.type) in written:
                written[type(one.type)][one.opts[0]] = given[str(one.name)]
        if any(written.values()):
            from studies.cli.targets import check_files, check_folder  # not for `list`

            for name, path in written[OutputFolder].items():
                check_folder(name, path)
            check_files(written[OutputFile])


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
