"""Results on the terminal: what describes itself is shown, in one place."""

from __future__ import annotations

import os
import shutil
import sys
from typing import Any

import click

from missions.files.errors import printable
from missions.files.writing import to_json
from sizing.results.result import Result
from studies.render.tables import RULE, Emphasis, Summary, Table

# Letters beyond ASCII that results have, for a terminal that has none.
_PLAIN = str.maketrans(
    {RULE: "-", "\N{DEGREE SIGN}": "", "\N{SUPERSCRIPT TWO}": "2", "\N{SUPERSCRIPT THREE}": "3"}
    | {"\N{MINUS SIGN}": "-", "\N{EN DASH}": "-", "\N{PLUS-MINUS SIGN}": "+-"}
)
_PIPED = 80  # characters of a line where there is no terminal
_STYLES: dict[Emphasis, dict[str, Any]] = {
    "plain": {},
    "strong": {"bold": True},
    "faint": {"dim": True},
    "warning": {"bold": True, "fg": "red"},
    "good": {"fg": "green"},
}


def line_width() -> int:
    """Return the characters of a line: the terminal's, 80 in a file, or ``COLUMNS``."""
    if os.environ.get("COLUMNS", "").isdecimal() or sys.stdout.isatty():
        return shutil.get_terminal_size().columns
    return _PIPED


def show(shown: Result | Summary | Table) -> None:
    """Print a result, a summary or a table to standard output, as wide as the terminal is."""
    summary = shown.summary() if isinstance(shown, Result) else shown
    for line, emphasis in summary.styled_lines(line_width()):
        tell_line(line, emphasis)


def print_json(record: Any) -> None:
    """Print a record as strict JSON."""
    click.echo(to_json(record, indent=2))


def tell_line(text: str, emphasis: Emphasis = "plain") -> None:
    """Print a line with its emphasis, which only terminals show."""
    styles = {} if "NO_COLOR" in os.environ else _STYLES[emphasis]
    click.echo(click.style(_printable(text), **styles) if styles and text else _printable(text))


def _printable(text: str) -> str:
    """Return a text without control characters, in letters that the terminal has."""
    text = printable(text)
    try:
        RULE.encode(sys.stdout.encoding or "ascii")
    except UnicodeEncodeError:
        return text.translate(_PLAIN)
    return text
