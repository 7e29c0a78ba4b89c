"""What is told on standard error, so that standard output holds results alone.

Messages, on as many lines as fit a screen and without what steers a terminal; and how far a long
computation is: a bar on a terminal, a line now and then elsewhere.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import click

from missions.files.errors import printable

# Elsewhere than on a terminal: silence for what is quick, then a line at this pace [s].
_FIRST_LINE_S = 5.0
_EVERY_S = 15.0

_LONGEST_WORD, _LONGEST_LINE, _MOST_LINES = 200, 4000, 30


def brief(message: str) -> str:
    """Return a message that fits a screen: the first mistakes, without overlong words or lines.

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


@contextmanager
def progress_of(unit: str, *, lines: bool = True) -> Iterator[Callable[[int, int], None]]:
    """Show progress; the function taken is told what is done and what there is in all.

    ``lines``: whether there are lines where there is no terminal. Returns to be called with the
    number that is done and the number there is in all.
    """
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield _Lines(unit) if lines else lambda done, total: None
        return
    from rich import progress as shown

    columns = (
        shown.TextColumn("{task.description}"),
        shown.BarColumn(),
        shown.MofNCompleteColumn(),
        shown.TextColumn("{task.fields[rate]}"),
        shown.TimeRemainingColumn(),
    )
    with shown.Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(unit, rate="")
        pace = _Pace()

        def update(done: int, total: int) -> None:
            rate = pace.per_s(done)
            text = "" if rate is None else f"{rate:.3g}/s"
            bar.update(task, completed=done, total=total, rate=text)

        yield update


class _Pace:
    """Rate since the first call; what was done before does not count."""

    def __init__(self) -> None:
        self._start: tuple[float, int] | None = None

    def per_s(self, done: int) -> float | None:
        now = time.monotonic()
        if self._start is None:
            self._start = now, done
        began, before = self._start
        return (done - before) / (now - began) if done > before and now > began else None


class _Lines:
    def __init__(self, unit: str) -> None:
        self._unit, self._pace = unit, _Pace()
        self._next_s: float | None = None
        self._said = False

    def __call__(self, done: int, total: int) -> None:
        rate = self._pace.per_s(done)
        now = time.monotonic()
        if self._next_s is None:  # what came before, such as the start of a cluster, is no work
            self._next_s = now + _FIRST_LINE_S
        if done >= total and self._said:  # or the last line would look like an end half-way
            print(f"{done} of {total} {self._unit}", file=sys.stderr, flush=True)
        if now < self._next_s or done >= total:
            return
        self._said = True
        self._next_s = now + _EVERY_S
        left = "" if rate is None else f", {rate:.3g}/s, {(total - done) / rate:.0f} s left"
        print(f"{done} of {total} {self._unit}{left}", file=sys.stderr, flush=True)
