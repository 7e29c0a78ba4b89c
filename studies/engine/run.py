"""Long computations in chunks of cells: in parallel, resumable, and not felled by one bad cell.

A :class:`Job` is a function, a configuration and chunks of cells; :func:`run` has a pool of workers
compute them. The chunks are part of the job and never depend on the workers, and a chunk is always
computed as a whole, so that the result is the same to the last bit whoever computes it, in whatever
order, in one run or in several.

* A chunk whose function raises is computed again cell by cell; a cell that raises by itself is
  recorded as failed with its message.
* Where a worker process dies, all chunks that were under way are tried again at the end, each with
  nothing else going on. One that a worker dies of even then is computed cell by cell, and a cell
  that a worker dies of is recorded as failed. (Cells computed singly agree with those of a chunk as
  far as the chunk's function does.)
* With a store every finished chunk is kept, under a key made of function, configuration, code and
  cells; what is there already is not computed again, unless cells of it failed.
* SIGINT and SIGTERM end the workers at once and raise :class:`Stopped`.
"""

from __future__ import annotations

import functools
import itertools
import threading
import time
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

import numpy as np

from solar._version import __version__
from studies.engine.chunk_store import ChunkStore, Part
from studies.engine.signals import Signals, interruptible
from studies.engine.workers import (
    Cell,
    Columns,
    Job,
    LocalPool,
    Pool,
    WorkersUnavailableError,
    code_digest,
)

Progress: TypeAlias = Callable[[int, int], None]

_DIED = "the worker process died"
_LOOK_S = 0.2


@dataclass(frozen=True)
class Outcome:
    """Columns over all cells, chunk after chunk; cells that failed, by number, with the reason."""

    columns: Columns
    failures: dict[int, str]
    computed_chunks: int
    kept_chunks: int

    @property
    def cells(self) -> int:
        """Number of cells."""
        return len(next(iter(self.columns.values())))

    def trouble(self, unit: str = "cells") -> str | None:
        """How many cells failed and why the first did; none if none did."""
        if not self.failures:
            return None
        first = self.failures[min(self.failures)]
        return f"{len(self.failures)} of {self.cells} {unit} failed; the first: {first}"

    @property
    def all_failed(self) -> bool:
        """Whether there is no result at all."""
        return self.cells == len(self.failures)


class ComputationError(RuntimeError):
    """Every cell of a computation failed."""


def compute(
    job: Job,
    workers: int | None = 1,
    progress: Progress | None = None,
    unit: str = "cells",
    scheduler: str | None = None,
) -> Outcome:
    """Compute a job in memory, for callers in Python.

    ``workers``: processes that compute: 1 starts none, None as many as there are cores where that
    pays. ``progress``: called with the cells done and the cells in all. ``scheduler``: that of
    dask, with the workers that were started for it, or ``local-cluster``. A warning tells how many
    cells failed, if any did.
    """
    if workers is not None and workers < 1:
        raise ValueError(f"workers must be at least 1, or None (got {workers})")
    if scheduler not in (None, "local-cluster") and "://" not in scheduler:
        raise ValueError(f"scheduler must be tcp://HOST:PORT or local-cluster (got {scheduler!r})")
    outcome = run(job, pool_of(workers, scheduler), progress=progress)
    trouble = outcome.trouble(unit)
    if outcome.all_failed:
        raise ComputationError(trouble)
    if trouble is not None:
        warnings.warn(trouble, RuntimeWarning, stacklevel=3)
    return outcome


def pool_of(
    workers: int | None = None,
    scheduler: str | None = None,
    tell: Callable[[str], None] | None = None,
) -> Pool:
    """Pool that the options ``--workers`` and ``--scheduler`` ask for.

    ``workers``: 1 for this process alone, more for so many processes; None for what pays. ``tell``:
    called with what the user should know while the work waits. Returns for one run, which closes
    it.
    """
    if scheduler is None:
        return LocalPool(workers)
    from studies.engine.dask_pool import DaskPool

    return DaskPool(scheduler, workers, tell)


def pieces(count: int, each: int) -> list[slice]:
    """Slices of at most ``each`` that cover ``count``, as even as possible.

    ``each``: largest number in a slice; less than 1 counts as 1. Returns in order, without gaps.
    """
    number = -(-count // max(each, 1))
    edges = np.linspace(0, count, number + 1).round().astype(int)
    return [slice(int(a), int(b)) for a, b in itertools.pairwise(edges)]


def run(
    job: Job, pool: Pool, store: ChunkStore | None = None, progress: Progress | None = None
) -> Outcome:
    """Compute a job; the pool is closed at the end.

    ``progress``: called with the cells done and the cells in all; what was kept counts as done from
    the start. Returns columns over all cells, and the cells that failed.
    """
    if not job.chunks:
        raise ValueError("a job needs at least one chunk")
    done = False
    # Between tasks a signal waits, so that it breaks nothing off but the task that is under way.
    with interruptible(held=True) as signals:
        try:
            outcome = _Run(job, pool, store, progress, signals).outcome()
            done = True
        finally:
            pool.close(at_once=not done)
    return outcome


@dataclass
class _Run:
    job: Job
    pool: Pool
    store: ChunkStore | None
    progress: Progress | None
    signals: Signals
    parts: dict[int, Part] = field(default_factory=dict)
    waiting: deque[int] = field(default_factory=deque)  # numbers of chunks
    retry: list[int] = field(default_factory=list)  # under way when a worker died
    flying: dict[Future[Part], int] = field(default_factory=dict)
    done: int = 0  # cells

    @functools.cached_property
    def keys(self) -> list[str]:
        return self.job.keys()

    def outcome(self) -> Outcome:
        kept = self._take_kept()
        self._report_progress()
        while self.waiting or self.flying:
            while self.waiting and len(self.flying) < self.pool.size(
                len(self.waiting) + len(self.flying)
            ):
                number = self.waiting.popleft()
                self.flying[self._submitted(self.job.chunks[number])] = number
            for future in self._finished(self.flying):
                number = self.flying.pop(future)
                part = self._part_of(future)
                if part is None:
                    self.retry.append(number)
                else:
                    self._keep(number, part)
        for number in self.retry:
            self._keep(number, self._alone(self.job.chunks[number]))
        whole = _joined([self.parts[i] for i in range(len(self.parts))])
        return Outcome(dict(whole.columns), dict(whole.failures), len(self.parts) - kept, kept)

    def _take_kept(self) -> int:
        """Read the chunks that an earlier run has left; the others wait."""
        for number, chunk in enumerate(self.job.chunks):
            part = self._kept_part(number, len(chunk))
            if part is None:
                self.waiting.append(number)
            else:
                self.parts[number] = part
                self.done += len(chunk)
        return len(self.parts)

    def _kept_part(self, number: int, cells: int) -> Part | None:
        """Part of a chunk that an earlier run has left; none that failed or cannot be a result."""
        if self.store is None:
            return None
        part = self.store.read(self.keys[number], self.job.blanks, cells)
        if part is None or part.failures:
            return None
        try:
            possible = self.job.possible is None or self.job.possible(part.columns)
        except Exception:
            return None  # nothing that was computed here
        return part if possible else None

    def _submitted(self, cells: tuple[Cell, ...]) -> Future[Part]:
        task = replace(self.job, chunks=(cells,), possible=None)  # which need not pickle
        if not self.pool.in_process:
            return self.pool.submit(compute_task, code_digest(), task)
        self.signals.held, begun = False, time.perf_counter()
        future: Future[Part] = Future()
        try:
            future.set_result(compute_task(None, task))
        finally:
            self.signals.held = True
        self.pool.own_times_s.append(time.perf_counter() - begun)
        return future

    def _finished(self, futures: Iterable[Future[Part]]) -> set[Future[Part]]:
        self.signals.check()
        finished, _ = wait(futures, timeout=_LOOK_S, return_when=FIRST_COMPLETED)
        self.signals.check()
        if not finished:
            self.pool.check()
        return finished

    def _part_of(self, future: Future[Part]) -> Part | None:
        """Result of a task; none if its worker died."""
        try:
            return self.pool.result(future)
        except self.pool.deaths:
            return None

    def _alone(self, cells: tuple[Cell, ...]) -> Part:
        """Compute cells with nothing else going on, one by one if a worker dies of them."""
        future = self._submitted(cells)
        while not self._finished([future]):
            pass
        part = self._part_of(future)
        if part is not None:
            return part
        if len(cells) == 1:
            return _failed_chunk(self.job.blanks, _DIED)
        return _joined([self._alone((cell,)) for cell in cells])

    def _keep(self, number: int, part: Part) -> None:
        if self.store is not None:
            self.store.write(self.keys[number], part)
        self.parts[number] = part
        self.done += len(self.job.chunks[number])
        self._report_progress()

    def _report_progress(self) -> None:
        if self.progress is not None:
            self.progress(self.done, len(self.job.cells))


# ---- In a worker, or here


# Solvers that a worker keeps are not safe in several threads, which a dask worker may have.
_ONE_AT_A_TIME = threading.Lock()


def compute_task(code: str | None, job: Job) -> Part:
    """Compute a job of one chunk; cells that raise are failures of the part.

    ``code``: digest of the driver's code; None within its process.
    """
    if code is not None and code != code_digest():
        raise WorkersUnavailableError(
            f"a worker has another version of solar-uav-sizing than this process ({__version__}): "
            "install the same one everywhere"
        )
    with _ONE_AT_A_TIME:
        return _computed_or_failed(job, job.cells)


def _computed_or_failed(job: Job, cells: tuple[Cell, ...]) -> Part:
    try:
        return _computed(job, cells)
    except Exception as error:
        if len(cells) == 1:
            return _failed_chunk(job.blanks, " ".join(f"{type(error).__name__}: {error}".split()))
    return _joined([_computed_or_failed(job, (cell,)) for cell in cells])


def _computed(job: Job, cells: tuple[Cell, ...]) -> Part:
    computed = job.function(job.configuration, cells)
    if set(computed) != set(job.blanks):
        raise ValueError(f"columns {sorted(computed)} are not {sorted(job.blanks)}")
    columns = {}
    for name, blank in job.blanks.items():
        kind = np.asarray(blank).dtype
        column = np.asarray(computed[name], None if kind.kind == "U" else kind)
        if column.shape != (len(cells),):
            raise ValueError(f"column {name} has the shape {column.shape}, not ({len(cells)},)")
        columns[name] = column
    return Part(columns)


def _failed_chunk(blanks: Mapping[str, Any], message: str) -> Part:
    """Part of a cell that failed."""
    return Part({name: np.asarray([blank]) for name, blank in blanks.items()}, {0: message})


def _joined(parts: Sequence[Part]) -> Part:
    """Parts one after the other, failures numbered on."""
    names = parts[0].columns
    columns = {name: np.concatenate([part.columns[name] for part in parts]) for name in names}
    failures: dict[int, str] = {}
    start = 0
    for part in parts:
        failures |= {start + cell: text for cell, text in part.failures.items()}
        start += len(part.columns[next(iter(names))])
    return Part(columns, failures)
