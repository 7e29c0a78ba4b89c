"""A command: a class that declares its options, and whose ``run`` does it.

Help needs the declarations alone: ``run`` imports what is heavy once the options go together.
"""

from __future__ import annotations

import os
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from inspect import get_annotations
from pathlib import Path
from typing import Any, ClassVar, TypeVar, dataclass_transform

import click

from studies.cli.values import OutputFile, OutputFolder
from studies.output.figures.options import TooManyDotsError

Declared = TypeVar("Declared", bound="type[CommandOptions]")

_OWN, _PLACE = "Options", "Place and day"
_FIGURES, _WORK = "Figures", "Long computations"
# Headings of ``--help`` for the options that many commands have, and these below each in their
# order; the rest is the command's own.
_SUBJECTS = {
    _PLACE: "--latitude --day-of-year --date --mass",
    "Solar power model, changes of the files": "--model --correction --set",
    "Output": "--out --table --table-years --plot --pareto --pdf --report --verbose --json",
    _FIGURES: "--figure-size --dpi --style --no-title",
    _WORK: "--workers --scheduler --work --keep-parts",
}
# Subject of an option, and its place there.
_PLACES = {
    name: (subject, place)
    for subject, names in _SUBJECTS.items()
    for place, name in enumerate(names.split())
}
# Subjects that the page of all commands explains once; the page of a command that has more options
# than this names those of the first of them alone.
_SHARED = (_FIGURES, _WORK, _PLACE)
_MOST_OPTIONS = 18
# What fields of options have around the name of their option.
_AROUND = re.compile(r"^(as|with)_|_(deg|dir|file|files|kg|m|min|s)$")
_LONGEST_CHOICE = 40  # characters beside the name of the option


class _Declared:
    """Option or argument of a class of options, which its field's name and type say more of."""

    def __init__(self, make: Callable[[str, str], click.Parameter]) -> None:
        self._make = make

    def __set_name__(self, owner: type, name: str) -> None:
        self.parameter = self._make(name, get_annotations(owner)[name])


def option(text: str, *spelled: str, **settings: Any) -> Any:
    """Return a field that an option fills, called as the field without its unit.

    A bool is a flag, and a ``tuple[..., ...]`` may be repeated.

    ``text``: what help says of it. ``spelled``: other names, a long one in place of the field's.
    ``settings``: of :func:`click.option`.
    """

    def make(name: str, kind: str) -> click.Option:
        names = list(spelled)
        if not any(each.startswith("--") for each in names):
            names.insert(0, f"--{_AROUND.sub('', name).replace('_', '-')}")
        flag = {"is_flag": True} if kind.startswith("bool") else {}
        implied = flag | {"multiple": kind.endswith(", ...]")}
        return click.Option([*names, name], help=text, **implied | settings)

    return _Declared(make)


def argument(**settings: Any) -> Any:
    """Return a field that an argument fills; ``settings``: of :func:`click.argument`."""
    return _Declared(lambda name, _: click.Argument([name], **settings))


@dataclass_transform(kw_only_default=True, field_specifiers=(option, argument))
class CommandOptions:
    """Options and arguments of a command: those of its fields that :func:`option` declares.

    What does not go together is refused by the ``refuse`` of each class, those of the bases first.
    ``run`` does what the command is for, with the loaded case of one that ``has_case``.
    """

    def __init__(self, **values: Any) -> None:
        vars(self).update(values)
        for kind in reversed(type(self).__mro__):
            if "refuse" in vars(kind):
                kind.refuse(self)  # type: ignore[attr-defined]  # looked up a line above

    has_case = False
    run: ClassVar[Callable[..., None]]

    @classmethod
    def parameters(cls) -> list[click.Parameter]:
        """Return the options and arguments, those of the bases first."""
        fields = {
            name: field for kind in reversed(cls.__mro__) for name, field in vars(kind).items()
        }
        return [field.parameter for field in fields.values() if isinstance(field, _Declared)]


class Command(click.Command):
    """Command whose options are the fields of a class, whose help text is its docstring.

    ``task``: what it is for, as its module is called. ``examples``: calls as they are typed, shown
    first in the help text; options stand by subject.
    """

    def __init__(self, options: type[CommandOptions], summary: str, *examples: str) -> None:
        self.options, self.examples = options, examples
        self.task = options.__module__.rpartition(".")[2].capitalize()
        super().__init__(
            re.sub(r"(?<=[a-z])(?=[A-Z])", "-", options.__name__).lower(),
            help=options.__doc__,
            short_help=summary,
            callback=self._perform,
            params=options.parameters(),
        )

    def _perform(self, **values: Any) -> None:
        options: Any = self.options(**values)
        files: dict[str, str | None] = {}
        for parameter in self.params:
            path = values[str(parameter.name)]
            if isinstance(parameter.type, OutputFile):
                files[parameter.opts[0]] = path
            elif isinstance(parameter.type, OutputFolder) and path is not None:
                from missions.files.writing import check_writable_folder  # not for help

                if not path:
                    hint = parameter.opts[0]
                    raise click.BadParameter("needs the name of a folder", param_hint=hint)
                check_writable_folder(Path(path))
        check_outputs(files)
        case = []
        if self.options.has_case:
            from studies.cli.files import load  # not for help

            case = [load(options)]
        try:
            options.run(*case)
        except TooManyDotsError as error:  # of a figure whose height is that of its content
            raise click.BadParameter(str(error), param_hint="--dpi") from None

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options by subject; of many those that are explained elsewhere by name."""
        records = self.records(ctx)
        listed = dict(records)
        for name in _SHARED:
            if sum(map(len, listed.values())) - 1 > _MOST_OPTIONS:  # which do not count the help
                listed.pop(name, None)
        for name, rows in listed.items():
            with formatter.section(name):
                formatter.write_dl(rows)
        named = [
            (name, ", ".join(left.split()[0] for left, _ in rows))
            for name, rows in records.items()
            if name not in listed
        ]
        if named:
            with formatter.section("More, which solar-uav --help explains"):
                formatter.write_dl(named)

    def records(self, ctx: click.Context) -> dict[str, list[tuple[str, str]]]:
        """Return rows of the help text by subject: an option, and what it does."""
        records: dict[str, list[tuple[str, str]]] = {_OWN: [], **{name: [] for name in _SUBJECTS}}
        options = [p for p in self.get_params(ctx) if isinstance(p, click.Option)]
        for option in sorted(options, key=lambda option: _place(option)[1]):
            record = option.get_help_record(ctx)
            if record is None:
                continue
            left, right = record
            if isinstance(option.type, click.Choice):  # long lists go into the text
                names = [str(name) for name in option.type.choices]
                left, listed = left.partition(" [")[0], "|".join(names)
                if len(listed) <= _LONGEST_CHOICE:
                    left = f"{left} [{listed}]"
                else:
                    left, right = f"{left} NAME", f"One of {', '.join(names)}. {right}"
            records[_place(option)[0]].append((left, right))
        return {name: rows for name, rows in records.items() if rows}

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


# All commands by name, in the order in which they are declared.
COMMANDS: dict[str, Command] = {}


def command(summary: str, *examples: str) -> Callable[[Declared], Declared]:
    """Declare a class of options as the command of its name; see :class:`Command`."""

    def declared(options: Declared) -> Declared:
        made = Command(options, summary, *examples)
        COMMANDS[str(made.name)] = made
        return options

    return declared


def write_shared_options(ctx: click.Context, formatter: click.HelpFormatter) -> None:
    """Write the options that pages of several commands only name."""
    for subject in _SHARED:
        rows: dict[str, str] = {}
        for made in COMMANDS.values():
            rows |= made.records(ctx).get(subject, [])
        with formatter.section(f"{subject}, of several commands"):
            formatter.write_dl(list(rows.items()))


def check_outputs(files: Mapping[str, str | None]) -> None:
    """Refuse files that cannot be written, or not all of them, before any work is done for them.

    ``files``: path given with each option.
    """
    from missions.files.writing import check_writable_file  # not for help

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


def _place(option: click.Option) -> tuple[str, int]:
    """Return subject of an option and place there; a command's own keep their order."""
    return next((_PLACES[name] for name in option.opts if name in _PLACES), (_OWN, 0))
