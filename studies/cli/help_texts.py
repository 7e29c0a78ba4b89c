"""Commands of ``solar-uav`` as their ``--help`` shows them: options by subject, and an example."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

import click

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
_LONGEST_CHOICE = 40  # characters beside the name of the option


class HelpedCommand(click.Command):
    """Command with examples, its options by subject.

    ``examples``: calls as they are typed, shown at the end of the help text.
    """

    def __init__(self, *, examples: Sequence[str] = (), **settings: Any) -> None:
        super().__init__(**settings)
        self.examples = tuple(examples)

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
