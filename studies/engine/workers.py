"""What is computed, and by whom: this process, processes of this machine, or a dask cluster.

What computes is a *pool* that takes a number of tasks at once and hands out futures; behind it
stands an executor of :mod:`concurrent.futures`.
"""

from __future__ import annotations

import functools
import hashlib
import itertools
import multiprocessing
import os
import signal
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib import resources
from multiprocessing.connection import wait
from pathlib import Path
from statistics import fmean
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic_core import to_json

from solar._version import __version__

T = TypeVar("T")
Cell: TypeAlias = tuple[float, ...]
Columns: TypeAlias = dict[str, NDArray[Any]]
ChunkFunction: TypeAlias = Callable[[Any, Sequence[Cell]], Mapping[str, Any]]

_PACKAGES = ("solar", "missions", "sizing", "studies")

# Processes are started when the work left would take this process longer [s]: each of them first
# spends about a second on imports.
_PAYS_S = 3.0
_STARTS = 3  # that may fail one after the other
# One process for each core is enough: threads of the linear algebra would only get in each other's
# way.
_ENVIRONMENT = dict.fromkeys(
    [f"{name}_NUM_THREADS" for name in ("OMP", "OPENBLAS", "MKL", "NUMEXPR")]
    + ["VECLIB_MAXIMUM_THREADS", "PYTHONSAFEPATH"],
    "1",
)


@dataclass(frozen=True)
class Job:
    """What is to be computed.

    ``function``: function of a module, called with the configuration and a sequence of cells;
    returns one value per cell for every column. ``configuration``: what the function needs besides:
    data classes, pydantic models, numbers and text, which pickle and can be written as JSON. Never
    a solver: workers keep theirs. ``chunks``: cells that are computed together; a chunk should take
    0.1 to 2 s. ``blanks``: name of every column, and the NumPy scalar that stands in it for a
    failed cell. ``possible``: whether columns without failures can be a result; what an earlier run
    has kept is computed again where it says no, or raises.
    """

    function: ChunkFunction
    configuration: Any
    chunks: tuple[tuple[Cell, ...], ...]
    blanks: Mapping[str, Any]
    possible: Callable[[Mapping[str, Any]], bool] | None = None

    @functools.cached_property
    def cells(self) -> tuple[Cell, ...]:
        """All cells, chunk after chunk."""
        return tuple(itertools.chain.from_iterable(self.chunks))

    @property
    def size_bytes(self) -> int:
        """Size of all columns, estimated [bytes]."""
        return len(self.cells) * sum(max(np.asarray(b).itemsize, 8) for b in self.blanks.values())

    def keys(self) -> list[str]:
        """Key of every chunk: changes with anything that may change its result."""
        function = f"{self.function.__module__}.{self.function.__qualname__}"
        common = [function, __version__, np.__version__, code_digest(), sorted(self.blanks)]
        # Files that the configuration names count with their contents, not with their path alone.
        context = {"contents": True}
        head = to_json([*common, self.configuration], inf_nan_mode="strings", context=context)
        return [hashlib.sha256(head + to_json(c)).hexdigest()[:40] for c in self.chunks]


@functools.cache
def code_digest() -> str:
    """Digest of all files of the packages: a result belongs to the code that computed it."""
    digest = hashlib.sha256()
    for package in _PACKAGES:
        root = Path(str(resources.files(package)))
        for path in sorted(root.rglob("*")):
            if path.is_file() and path.parent.name != "__pycache__":
                digest.update(path.relative_to(root).as_posix().encode() + b"\0")
                digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()[:16]


class WorkersUnavailableError(OSError):
    """No worker can be had; the text says why and what to do."""


class Pool(ABC):
    """Workers that compute tasks."""

    # Errors that say that a worker died.
    deaths: tuple[type[BaseException], ...] = (BrokenExecutor,)

    # Whether the next task is for this process, which computes it itself.
    in_process = False
    own_times_s: list[float]  # of the tasks that this process has computed

    @abstractmethod
    def size(self, tasks_left: int) -> int:
        """How many tasks the pool takes at once, told how many there are."""

    @abstractmethod
    def submit(self, work: Callable[..., T], *task: Any) -> Future[T]:
        """Give out a task; ``work`` is importable by name, for workers in other processes."""

    def result(self, future: Future[T]) -> T:
        """Result of a task that is done; raises what the task did, or one of ``deaths``."""
        return future.result()

    @abstractmethod
    def check(self) -> None:
        """Raise :class:`WorkersUnavailableError` if nobody is left to compute."""

    @abstractmethod
    def close(self, *, at_once: bool) -> None:
        """End the workers, in the middle of their tasks if need be."""


def available_cores() -> int:
    """Cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on every system
        return os.cpu_count() or 1


class LocalPool(Pool):
    """The present process for 1 worker, else so many processes of this machine.

    For None it is this process, and as many others as there are cores as soon as the work left is
    seen to be worth their start: small computations never wait for them.
    """

    def __init__(self, workers: int | None = None) -> None:
        self._most = available_cores() if workers is None else workers
        self.in_process = workers is None or self._most == 1
        self._executor: Executor | None = None
        self._started: Future[int] | None = None
        self._failed_starts = 0
        self._others = set(multiprocessing.active_children())
        self.own_times_s = []

    def size(self, tasks_left: int) -> int:
        """One, or the number of processes."""
        warm_s = self.own_times_s[1:]  # the first task also imports what it needs
        if self.in_process and self._most > 1 and warm_s:
            self.in_process = tasks_left * fmean(warm_s) <= _PAYS_S
        return 1 if self.in_process else self._most

    def submit(self, work: Callable[..., T], *task: Any) -> Future[T]:
        """Send the task to a process."""
        with for_children():
            if self._executor is not None:
                with suppress(BrokenExecutor):  # a worker died since
                    return self._executor.submit(work, *task)
            return self._restarted().submit(work, *task)

    def _restarted(self) -> Executor:
        """Start processes, or start them again."""
        if self._started is not None:
            ready = self._started.done() and self._started.exception() is None
            self._failed_starts = 0 if ready else self._failed_starts + 1
        if self._failed_starts >= _STARTS:
            raise WorkersUnavailableError(
                "a worker process ended before its first task (a script that starts workers needs "
                "`if __name__ == '__main__':`); --workers 1 computes without them"
            )
        context = multiprocessing.get_context("spawn")
        self._executor = ProcessPoolExecutor(self._most, context, _prepare_worker)
        self._started = self._executor.submit(os.getpid)
        return self._executor

    def check(self) -> None:
        """Nothing: a process that ends breaks its executor, which says so by itself."""

    def close(self, *, at_once: bool) -> None:
        """End all processes."""
        if self._executor is None:
            return
        if at_once:
            for process in set(multiprocessing.active_children()) - self._others:
                process.kill()
        self._executor.shutdown(wait=True, cancel_futures=at_once)


def _prepare_worker() -> None:
    """Leave Ctrl-C to the parent, and end when the parent ends, however it does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True, name="parent watch").start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        # No clean-up: the task has nobody left to answer to.
        os._exit(1)


@contextmanager
def for_children() -> Iterator[None]:
    """Start processes that compute with one thread each and never see Ctrl-C.

    Nor do they import what lies in the current folder, where a ``socket.py`` would be taken for
    the library's; the search path of this process reaches them later. All is inherited, and must
    be in place before a process imports anything.
    """
    before = {name: os.environ.get(name) for name in _ENVIRONMENT}
    os.environ.update(_ENVIRONMENT)
    masks = hasattr(signal, "pthread_sigmask")
    if masks:
        from multiprocessing import resource_tracker

        # It is started with the first process, and unblocks Ctrl-C for all that follow.
        resource_tracker.ensure_running()
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        if masks:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for name, value in before.items():
            os.environ.pop(name)
            if value is not None:
                os.environ[name] = value
