"""Who computes: this process, or processes of this machine.

What computes is a *pool* that takes a number of tasks at once and hands out futures; behind it
stands an executor of :mod:`concurrent.futures`. On Linux its processes are forked from a server
that has imported what they need, has one thread, and holds nothing of this process; elsewhere each
is started and imports for itself.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from multiprocessing.connection import wait
from typing import Any, TypeVar

T = TypeVar("T")

# Processes are started when the work would take this process longer [s]: each of them may spend a
# second on imports.
_PAYS_S = 3.0
_STARTS = 3  # that may fail one after the other
# One process for each core is enough: threads of the linear algebra would only get in each other's
# way.
_ENVIRONMENT = dict.fromkeys(
    [f"{name}_NUM_THREADS" for name in ("OMP", "OPENBLAS", "MKL", "NUMEXPR")]
    + ["VECLIB_MAXIMUM_THREADS", "PYTHONSAFEPATH"],
    "1",
)
# Libraries of macOS do not bear a fork.
_METHOD = "forkserver" if sys.platform == "linux" else "spawn"


class WorkersUnavailableError(OSError):
    """No worker can be had; the text says why and what to do."""


def available_cores() -> int:
    """Return the cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on every system
        return os.cpu_count() or 1


class Pool:
    """The present process for 1 worker, else so many processes of this machine.

    For None they are as many as there are cores if the work is worth their start, or 1: small
    computations never wait for processes. ``work_s``: time that it takes on one core, roughly [s].

    ``in_process``: whether tasks are computed here, which a single worker's are if they may be.
    ``same_code``: whether workers have the code of this process for certain. ``imports``: modules
    that the tasks need.
    """

    same_code = True
    imports: tuple[str, ...] = ()

    def __init__(
        self, workers: int | None = None, work_s: float = 0.0, *, in_process: bool = True
    ) -> None:
        if workers is None:
            workers = available_cores() if work_s > _PAYS_S else 1
        self._workers, self.in_process = workers, in_process and workers == 1
        self._executor: Executor | None = None
        self._started: Future[int] | None = None
        self._failed_starts = 0
        self._others = set(multiprocessing.active_children())

    @property
    def size(self) -> int:
        """How many tasks the pool takes at once."""
        return 1 if self.in_process else self._workers + 1  # none waits for its next one

    def submit(self, work: Callable[..., T], *task: Any) -> Future[T]:
        """Give out a task; ``work`` is importable by name."""
        with for_children():
            executor = self._executor or self._restarted()
            while True:
                with suppress(BrokenExecutor):  # a worker died since
                    return executor.submit(work, *task)
                executor = self._restarted()

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
        fork_from(*self.imports)
        context = multiprocessing.get_context(_METHOD)
        self._executor = ProcessPoolExecutor(self._workers, context, _prepare_worker)
        self._started = self._executor.submit(os.getpid)
        return self._executor

    def result(self, future: Future[T]) -> T:
        """Return the result of a task; raise what it did, or BrokenExecutor if a worker died."""
        return future.result()

    def check(self) -> None:
        """Raise :class:`WorkersUnavailableError` if nobody is left to compute."""

    def close(self, *, at_once: bool) -> None:
        """End the workers, in the middle of their tasks if need be."""
        if self._executor is None:
            return
        if at_once:
            for process in set(multiprocessing.active_children()) - self._others:
                process.kill()
        self._executor.shutdown(wait=True, cancel_futures=at_once)


def fork_from(*modules: str) -> None:
    """Start the server that workers are forked from; where there is one already, nothing happens.

    ``modules``: what it imports meanwhile. It ends with this process.
    """
    if _METHOD == "forkserver":
        from multiprocessing import forkserver

        multiprocessing.set_forkserver_preload(list(modules))
        with for_children():
            forkserver.ensure_running()


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
