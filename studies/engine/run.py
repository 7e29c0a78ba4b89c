"""Long computations in chunks of cells: in parallel, resumable, and not felled by one bad cell.

A :class:`Job` is a function, a configuration and chunks of cells; :func:`run` has a crew of workers
compute them. The chunks are part of the job and never depend on the workers, and a chunk is always
computed as a whole, so that the result is the same to the last bit whoever computes it, in whatever
order, in one run or in several.

* A chunk whose function raises is computed again cell by cell; a cell that raises by itself is
  recorded as failed with its message.
* A chunk that its worker process dies of is tried again twice, then cell by cell; a cell that its
  process dies of twice is recorded as failed. (Cells computed singly agree with those of a chunk
  as far as the chunk's function does.) Where it is not certain which of several tasks a worker died
  of, each is tried again with nothing else going on.
* With a store every finished chunk is kept, under a key made of function, configuration, code and
  cells; what is there already is not computed again, unless cells of it failed.
* SIGINT and SIGTERM end the workers at once and raise :class:`Stopped`.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import itertools
import json
import signal
import threading
import warnings
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum
from importlib import resources
from types import FrameType
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from solar._version import __version__
from studies.engine.chunk_store import ChunkStore, Part
from studies.engine.workers import Crew, WorkersUnavailableError, crew_of

__all__ = ["Cell", "Columns", "Job", "Outcome", "Stopped", "pieces", "run"]

Cell: TypeAlias = tuple[float, ...]
Columns: TypeAlias = dict[str, NDArray[Any]]
ChunkFunction: TypeAlias = Callable[[Any, Sequence[Cell]], Mapping[str, Any]]

_PACKAGES = ("solar", "missions", "sizing", "studies")
# Deaths that a single cell may cause before it counts as failed: the first may be bad luck.
_DEATHS_OF_A_CELL = 2
_DIED = "the worker process died"
_LOOK_S = 1.0


class Stopped(BaseException):
    """The computation was stopped by a signal; what was finished is kept in the store."""

    def __init__(self, signum: int) -> None:
        super().__init__(signum)
        self.signum = signum


@dataclass(frozen=True)
class Job:
    """What is to be computed.

    Attributes
    ----------
    function : callable
        Function of a module, called with the configuration and a sequence of cells; returns one
        value per cell for every column.
    configuration : Any
        What the function needs besides: data classes, pydantic models, numbers and text, which
        pickle and can be written as JSON. Never a solver: workers keep theirs.
    chunks : tuple of tuples of cells
        Cells that are computed together; a chunk should take 0.1 to 2 s.
    blanks : mapping
        Name of every column, and the NumPy scalar that stands in it for a failed cell.
    """

    function: ChunkFunction
    configuration: Any
    chunks: tuple[tuple[Cell, ...], ...]
    blanks: Mapping[str, Any]

    @property
    def cells(self) -> int:
        """Number of cells."""
        return sum(len(chunk) for chunk in self.chunks)

    @property
    def size_bytes(self) -> int:
        """Size of all columns, estimated [bytes]."""
        return self.cells * sum(max(np.asarray(b).itemsize, 8) for b in self.blanks.values())

    def keys(self) -> list[str]:
        """Key of every chunk: changes with anything that may change its result."""
        function = f"{self.function.__module__}.{self.function.__qualname__}"
        common = [function, __version__, np.__version__, code_digest(), sorted(self.blanks)]
        head = _canonical([*common, self.configuration])
        return [
            hashlib.sha256((head + _canonical(chunk)).encode()).hexdigest()[:40]
            for chunk in self.chunks
        ]


@dataclass(frozen=True)
class Outcome:
    """Columns over all cells, chunk after chunk; cells that failed, by number, with the reason."""

    columns: Columns
    failures: dict[int, str]
    computed_chunks: int
    kept_chunks: int

    def trouble(self, unit: str = "cells") -> str | None:
        """How many cells failed and why the first did; none if none did."""
        if not self.failures:
            return None
        count = len(next(iter(self.columns.values())))
        first = self.failures[min(self.failures)]
        return f"{len(self.failures)} of {count} {unit} failed; the first: {first}"

    @property
    def all_failed(self) -> bool:
        """Whether there is no result at all."""
        return len(self.failures) == len(next(iter(self.columns.values())))


class ComputationError(RuntimeError):
    """Every cell of a computation failed."""


def compute(
    job: Job,
    workers: int | None = 1,
    progress: Callable[[int, int], None] | None = None,
    unit: str = "cells",
) -> Outcome:
    """Compute a job in memory, for callers in Python.

    Parameters
    ----------
    job : Job
        What is to be computed.
    workers : int or None, optional
        Processes that compute: 1 starts none, None as many as there are cores where that pays.
    progress : callable, optional
        Called with the cells done and the cells in all.
    unit : str, optional
        What the cells are called in messages.

    Returns
    -------
    Outcome
        A warning tells how many cells failed, if any did.

    Raises
    ------
    ComputationError
        If every cell failed.
    ValueError
        If the number of workers is less than 1.
    """
    if workers is not None and workers < 1:
        raise ValueError(f"workers must be at least 1, or None (got {workers})")
    outcome = run(job, crew_of(workers, None), progress=progress)
    trouble = outcome.trouble(unit)
    if outcome.all_failed:
        raise ComputationError(trouble)
    if trouble is not None:
        warnings.warn(trouble, RuntimeWarning, stacklevel=3)
    return outcome


def pieces(count: int, each: int) -> list[slice]:
    """Slices of at most ``each`` that cover ``count``, as even as possible."""
    number = -(-count // max(each, 1))
    edges = np.linspace(0, count, number + 1).round().astype(int)
    return [slice(int(a), int(b)) for a, b in itertools.pairwise(edges)]


def _canonical(value: Any) -> str:
    return json.dumps(value, sort_keys=True, default=_plain)


def _plain(value: Any) -> Any:
    """Plain data of what a configuration may hold."""
    if isinstance(value, BaseModel):
        return [type(value).__qualname__, value.model_dump(mode="json")]
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        shallow = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
        return [type(value).__qualname__, shallow]
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"a configuration cannot hold a {type(value).__name__}")


@functools.cache
def code_digest() -> str:
    """Digest of all files of the packages: a result belongs to the code that computed it."""
    digest = hashlib.sha256()
    for package in _PACKAGES:
        for name, data in _files(resources.files(package)):
            digest.update(name.encode() + b"\0" + hashlib.sha256(data).digest())
    return digest.hexdigest()[:16]


def _files(folder: Any, prefix: str = "") -> Iterator[tuple[str, bytes]]:
    for item in sorted(folder.iterdir(), key=lambda item: item.name):
        if item.is_dir() and item.name != "__pycache__":
            yield from _files(item, f"{prefix}{item.name}/")
        elif item.is_file():
            yield prefix + item.name, item.read_bytes()


# ---- In the worker


@dataclass(frozen=True)
class _Task:
    function: ChunkFunction
    configuration: Any
    cells: tuple[Cell, ...]
    blanks: Mapping[str, Any]
    code: str


# Solvers that a worker keeps are not safe in several threads, which a dask worker may have.
_ONE_AT_A_TIME = threading.Lock()


def _compute(task: _Task) -> Part:
    """Compute a task; cells that raise are failures of the part."""
    if task.code != code_digest():
        raise WorkersUnavailableError(
            f"a worker has another version of solar-uav-sizing than this process ({__version__}): "
            "install the same one everywhere"
        )
    with _ONE_AT_A_TIME:
        try:
            return _computed(task, task.cells)
        except Exception as error:
            if len(task.cells) == 1:
                return _failed(task.blanks, _message(error))
        singles = []
        for cell in task.cells:
            try:
                singles.append(_computed(task, (cell,)))
            except Exception as error:
                singles.append(_failed(task.blanks, _message(error)))
        return _joined(singles)


def _computed(task: _Task, cells: tuple[Cell, ...]) -> Part:
    found = task.function(task.configuration, cells)
    if set(found) != set(task.blanks):
        raise ValueError(f"columns {sorted(found)} are not {sorted(task.blanks)}")
    columns = {}
    for name, blank in task.blanks.items():
        kind = np.asarray(blank).dtype
        column = np.asarray(found[name], None if kind.kind == "U" else kind)
        if column.shape != (len(cells),):
            raise ValueError(f"column {name} has the shape {column.shape}, not ({len(cells)},)")
        columns[name] = column
    return Part(columns)


def _message(error: Exception) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())


def _failed(blanks: Mapping[str, Any], message: str) -> Part:
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


# ---- In the driver


def run(
    job: Job,
    crew: Crew,
    store: ChunkStore | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Outcome:
    """Compute a job; the crew is closed at the end.

    Parameters
    ----------
    job : Job
    crew : Crew
        Who computes, see :func:`studies.engine.workers.crew_of`.
    store : ChunkStore, optional
        An opened store, for what is finished.
    progress : callable, optional
        Called with the cells done and the cells in all; what was kept counts as done from the
        start.

    Raises
    ------
    Stopped
        After SIGINT or SIGTERM (noticed in the main thread alone).
    OutputError
        If a finished chunk cannot be kept; those before it are.
    WorkersUnavailableError
        If there are no workers.
    """
    if not job.chunks:
        raise ValueError("a job needs at least one chunk")
    done = False
    with _signals() as stop:
        try:
            outcome = _Run(job, crew, store, progress, stop).outcome()
            done = True
        finally:
            with stop.held():
                crew.close(at_once=not done)
    return outcome


@dataclass
class _Piece:
    """Cells that are sent to a worker: a whole chunk, or one cell of it."""

    chunk: int
    cells: slice
    deaths: int = 0


class _Run:
    def __init__(
        self,
        job: Job,
        crew: Crew,
        store: ChunkStore | None,
        progress: Callable[[int, int], None] | None,
        stop: _Stop,
    ) -> None:
        self.job, self.crew, self.store, self.stop = job, crew, store, stop
        self.progress = progress or (lambda done, total: None)
        self.keys = job.keys()
        self.parts: dict[int, Part] = {}
        self.singles: dict[int, dict[int, Part]] = {}  # of chunks computed cell by cell
        self.waiting: deque[_Piece] = deque()
        self.suspects: deque[_Piece] = deque()  # what may have ended a worker
        self.flying: dict[Future[Part], tuple[int, _Piece]] = {}
        self.done, self.total = 0, job.cells

    def outcome(self) -> Outcome:
        kept = self._take_kept()
        self.progress(self.done, self.total)
        while self.waiting or self.suspects or self.flying:
            self.stop.check()
            self._send()
            finished, _ = wait(self.flying, timeout=_LOOK_S, return_when=FIRST_COMPLETED)
            self.stop.check()
            with self.stop.held():
                for future in finished:
                    lane, piece = self.flying.pop(future)
                    self._receive(future, lane, piece)
        whole = _joined([self.parts[i] for i in range(len(self.parts))])
        computed = len(self.parts) - kept
        return Outcome(dict(whole.columns), dict(whole.failures), computed, kept)

    def _take_kept(self) -> int:
        """Read the chunks that an earlier run has left; the others wait."""
        for number, (key, chunk) in enumerate(zip(self.keys, self.job.chunks, strict=True)):
            part = None if self.store is None else self.store.read(key)
            if part is None or part.failures:
                self.waiting.append(_Piece(number, slice(0, len(chunk))))
            else:
                self.parts[number] = part
                self.done += len(chunk)
        return len(self.parts)

    def _send(self) -> None:
        """Give every free lane a piece; suspects come last, each by itself."""
        if self.suspects and not (self.waiting or self.flying):
            self.waiting.append(self.suspects.popleft())
        lanes = self.crew.lanes(len(self.waiting) + len(self.flying))
        free = set(range(lanes)) - {lane for lane, _ in self.flying.values()}
        for lane in sorted(free):
            if not self.waiting:
                return
            piece = self.waiting.popleft()
            task = _Task(
                self.job.function,
                self.job.configuration,
                self.job.chunks[piece.chunk][piece.cells],
                self.job.blanks,
                code_digest(),
            )
            if self.crew.elsewhere:
                with self.stop.held():
                    future = self._submitted(lane, task)
            else:
                future = self._submitted(lane, task)
            self.flying[future] = lane, piece

    def _submitted(self, lane: int, task: _Task) -> Future[Part]:
        try:
            return self.crew.submit(lane, _compute, task)
        except Exception as error:
            # The worker may have died while it was idle.
            future: Future[Part] = Future()
            future.set_exception(error)
            return future

    def _receive(self, future: Future[Part], lane: int, piece: _Piece) -> None:
        try:
            self._file(piece, future.result())
        except CancelledError:
            raise WorkersUnavailableError("the scheduler dropped the work") from None
        except Exception as error:
            if not self.crew.died(lane, error):
                raise
            self._mourn(piece)

    def _mourn(self, piece: _Piece) -> None:
        """Decide what becomes of a piece whose worker died."""
        piece.deaths += 1
        alone = len(self.job.chunks[piece.chunk]) == 1 or piece.chunk in self.singles
        allowed = self.crew.retries
        if alone:
            allowed = min(allowed, _DEATHS_OF_A_CELL - 1)
        if piece.deaths <= allowed:
            (self.waiting if self.crew.certain else self.suspects).append(piece)
        elif alone:
            self._file(piece, _failed(self.job.blanks, _DIED))
        else:
            self.singles[piece.chunk] = {}
            count = len(self.job.chunks[piece.chunk])
            self.waiting.extend(_Piece(piece.chunk, slice(i, i + 1)) for i in range(count))

    def _file(self, piece: _Piece, part: Part) -> None:
        """Keep a result, and its chunk once that is complete."""
        if piece.chunk in self.singles:
            singles = self.singles[piece.chunk]
            singles[piece.cells.start] = part
            count = len(self.job.chunks[piece.chunk])
            if len(singles) < count:
                return
            part = _joined([singles[i] for i in range(count)])
            del self.singles[piece.chunk]
        if self.store is not None:
            self.store.write(self.keys[piece.chunk], part)
        self.parts[piece.chunk] = part
        self.done += len(self.job.chunks[piece.chunk])
        self.progress(self.done, self.total)


# ---- Signals


class _Stop:
    """Turns signals into :class:`Stopped`, but not in the middle of what must be whole."""

    def __init__(self) -> None:
        self._signum: int | None = None
        self._held = 0

    def handle(self, signum: int, frame: FrameType | None) -> None:
        again = self._signum is not None
        self._signum = signum
        # Others that come while the workers are ended change nothing.
        if not (again or self._held):
            raise Stopped(signum)

    def check(self) -> None:
        """Raise what came while it was held back, or was swallowed by a library."""
        if self._signum is not None:
            raise Stopped(self._signum)

    @contextmanager
    def held(self) -> Iterator[None]:
        self._held += 1
        try:
            yield
        finally:
            self._held -= 1


@contextmanager
def _signals() -> Iterator[_Stop]:
    stop = _Stop()
    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    caught = (signal.SIGINT, signal.SIGTERM)
    before = {number: signal.signal(number, stop.handle) for number in caught}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
