"""What is told on standard error: on as many lines as fit a screen, and nothing for terminals."""

from __future__ import annotations

import click

from missions.files.errors import printable

__all__ = ["brief", "tell_error"]

_LONGEST_WORD, _LONGEST_LINE, _MOST_LINES = 200, 4000, 30


def brief(message: str) -> str:
    """Message that fits a screen: the first mistakes, and no word or line that goes on for pages.

    Control characters, which a name of a file may hold, are spelled: they would steer a terminal.
    """
    lines = [
        _shortened(" ".join(_shortened(word) for word in printable(s).split(" ")), _LONGEST_LINE)
        for s in message.split("\n")
    ]
    more = len(lines) - _MOST_LINES
    return "\n".join(lines if more <= 0 else [*lines[:_MOST_LINES], f"... and {more} more"])


def tell_error(message: str) -> None:
    """Print a message on standard error."""
    click.echo(brief(message), err=True)


def _shortened(text: str, longest: int = _LONGEST_WORD) -> str:
    return text if len(text) <= longest else f"{text[:longest]}..."
