"""Long computations that are struck and go on: nothing finished is lost, nothing else changes."""

from __future__ import annotations

import functools
import random
import signal
import time
from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from benchmarks.reliability.faults.processes import (
    Ended,
    Running,
    ended,
    own_folder,
    running,
    trouble,
)

__all__ = ["MAP", "SWEEP", "Fault", "Work", "struck_and_finished"]

Case = Callable[[random.Random, Path], str | None]


class Fault(NamedTuple):
    """A kind of fault; its case gets a source of chance and an empty folder."""

    subject: str
    attack: str
    cases: int  # as many as the page is made of
    case: Case


@dataclass(frozen=True)
class Work:
    """A computation of many short chunks."""

    name: str
    arguments: tuple[str, ...]
    target: str
    chunk_s: float

    def command(self, *more: str, keep: bool = True) -> tuple[str, ...]:
        """Arguments of ``solar-uav``.

        Parameters
        ----------
        *more : str
            Further ones.
        keep : bool
            Whether chunks are kept in a folder ``w``.

        Returns
        -------
        tuple of str
        """
        kept = ("--work", "w", "--keep-parts") if keep else ()
        return (*self.arguments, "--out", self.target, *kept, *more)

    def parts(self, folder: Path, *, keep: bool = True) -> dict[str, int]:
        """Finished chunks, with the time of their files [ns]."""
        place = folder / ("w" if keep else f"{self.target}.parts")
        found = {}
        for path in place.glob("*.part"):
            try:
                found[path.name] = path.stat().st_mtime_ns
            except OSError:  # gone meanwhile
                continue
        return found

    @functools.cached_property
    def whole(self) -> tuple[bytes, int, float]:
        """Result undisturbed, its number of chunks, and its time [s]."""
        with own_folder() as folder:
            begun = time.monotonic()
            end = ended(folder, *self.command("--workers", "1"), chunk_s=self.chunk_s)
            took = time.monotonic() - begun
            if end.code:
                raise RuntimeError(end.err)
            return (folder / self.target).read_bytes(), len(self.parts(folder)), took

    def start(self, folder: Path, *more: str, keep: bool = True, before: str = "") -> Running:
        """Start it.

        Parameters
        ----------
        folder : Path
            Where.
        *more : str
            Further arguments.
        keep : bool
            As for :meth:`command`.
        before : str
            Python that is run first.

        Returns
        -------
        Running
        """
        words = self.command(*more, keep=keep)
        return running(folder, *words, chunk_s=self.chunk_s, before=before)

    def finished(self, folder: Path, *more: str, keep: bool = True) -> str | None:
        """Go on to the end, and tell what is wrong with the result; None if nothing is.

        Parameters
        ----------
        folder : Path
            Where.
        *more : str
            Further arguments.
        keep : bool
            As for :meth:`command`.

        Returns
        -------
        str or None
        """
        before = self.parts(folder, keep=keep)
        end = self.start(folder, *more, keep=keep).end()
        after = self.parts(folder, keep=keep)
        if (wrong := trouble(end, {0}, folder)) is not None:
            return f"going on: {wrong}"
        if (folder / self.target).read_bytes() != self.whole[0]:
            return "another result"
        if keep and (again := [name for name in before if after.get(name) != before[name]]):
            return f"{len(again)} of {len(before)} finished chunks computed again"
        expected = {self.target, "w"} if keep else {self.target}
        found = {path.name for path in folder.iterdir()}
        return None if found == expected else f"files {sorted(found)}"


MAP = Work(
    "map of sized aircraft",
    (
        *("map", "atlantiksolar-design", "--resize", "min_wingspan"),
        *("--latitudes", "0:60:10", "--days", "1:365:91"),
    ),
    "m.nc",
    0.01,
)
SWEEP = Work(
    "trade study",
    (
        *("sweep", "atlantiksolar-design", "--resize", "min_mass"),
        *("--vary", "battery.specific_energy_wh_per_kg=200:400:10"),
    ),
    "s.nc",
    0.01,
)


def struck_and_finished(
    work: Work,
    strike: Callable[[Running, random.Random], None],
    codes: Collection[int],
    *more: str,
) -> Case:
    """Case: a computation is struck at a random moment, once or twice, and then goes on.

    Parameters
    ----------
    work : Work
        What is computed.
    strike : callable
        What is done to it when the moment has come.
    codes : collection of int
        Exit codes that are right, beside 0 of what has ended before.
    *more : str
        Further arguments of the command.

    Returns
    -------
    callable
    """

    def case(rng: random.Random, folder: Path) -> str | None:
        keep = rng.random() < 0.7
        _, chunks, took_s = work.whole

        def kept(count: int) -> bool:
            return len(work.parts(folder, keep=keep)) >= count

        for _ in range(rng.choice((1, 1, 2))):
            process = work.start(folder, *more, keep=keep)
            if rng.random() < 0.3:
                process.until(lambda: False, rng.uniform(0.0, took_s))
            else:
                wanted = rng.randrange(1, chunks + 1)
                process.until(functools.partial(kept, wanted))
                process.until(lambda: False, rng.uniform(0.0, 0.1))
            strike(process, rng)
            end = process.end()
            killed = end.code == -signal.SIGKILL
            wrong = trouble(end, {0, *codes}, None if killed else folder)
            if wrong is None and end.code in (130, 143) and not _says_how(end):
                wrong = f"no way to go on: {end.err.strip()!r}"
            if wrong is not None:
                return wrong
        return work.finished(folder, *more, keep=keep)

    return case


def _says_how(end: Ended) -> bool:
    """Whether the message says how to go on, or that there was nothing to keep yet."""
    return "to go on:" in end.err or end.err.strip().startswith("solar-uav: stopped by")
