"""Who computes: this process, processes of this machine, or workers of a dask cluster.

What computes is a *pool* that takes a number of tasks at once and hands out futures; behind it
stands an executor of :mod:`concurrent.futures`. On Linux its processes are forked from a server
that has imported what they need, has one thread, and holds nothing of this process; elsewhere each
is started and imports for itself.
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import (
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
)
from contextlib import ExitStack, contextmanager, suppress
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


# ---- A cluster, with words for the user where dask has a page of its log

LOCAL_CLUSTER = "local-cluster"

_CONNECT_S = 20.0
_LOOK_S = 5.0
_ANSWER_S = 1.0
# How long a cluster may be without a worker: the time in which one that died is started again.
_WITHOUT_WORKERS_S = 60.0
_TOLD_AFTER_S = 10.0
_LOGGERS = ("distributed", "tornado")


class DaskPool(Pool):
    """Workers of a dask cluster: one that runs already, or one of this machine for the occasion.

    The scheduler itself moves the tasks of a dead worker to others; it gives up on a task that has
    ended several (`distributed.scheduler.allowed-failures`).

    ``tell``: called with what the user should know while the work waits.
    """

    same_code = False

    def __init__(
        self, scheduler: str, workers: int | None = None, tell: Callable[[str], None] | None = None
    ) -> None:
        try:
            import dask
            import distributed
        except ImportError:
            raise WorkersUnavailableError(
                "--scheduler needs dask: pip install distributed (the extra 'cluster')"
            ) from None
        self._killed, self.in_process = distributed.KilledWorker, False
        self._tell = tell or (lambda text: None)
        local = scheduler == LOCAL_CLUSTER
        self._name = "the cluster of this machine" if local else f"the scheduler {scheduler}"
        self._remedy = "" if local else f"; start one with: dask worker {scheduler}"
        # A worker that dies twice within this time may be taken for lost, and is not started again.
        patience = {"distributed.deploy.lost-worker-timeout": "1 day"}
        with ExitStack() as opened, for_children():  # a signal, too, leaves no process
            opened.enter_context(_silenced())
            opened.enter_context(dask.config.set(patience))
            address: Any = scheduler
            if local:
                address = distributed.LocalCluster(
                    n_workers=available_cores() if workers is None else workers,
                    threads_per_worker=1,
                    # Any free port: that of a cluster that runs already would be warned of.
                    dashboard_address="127.0.0.1:0",
                    silence_logs=logging.CRITICAL,
                )
                opened.callback(_close, address)
            try:
                self._client = distributed.Client(address, timeout=_CONNECT_S, set_as_default=False)
            except (OSError, TimeoutError, ValueError) as error:
                reason = str(error).partition("\n")[0]
                raise WorkersUnavailableError(
                    f"no answer of {self._name}: {reason}; start it with: dask scheduler, "
                    "or compute on this machine with --workers"
                ) from None
            opened.callback(_close, self._client)
            self._opened = opened.pop_all()
        self._threads, self._looked_s = 1, -_LOOK_S
        self._last_seen_s, self._told = time.monotonic(), False

    @property
    def size(self) -> int:
        """Two for each thread of the cluster, so that none waits for the network."""
        self._look()
        return max(2 * self._threads, 1)

    def check(self) -> None:
        """Tell that the cluster has no worker; raise if it has had none for a while."""
        self._look()
        without_s = time.monotonic() - self._last_seen_s
        if without_s > _WITHOUT_WORKERS_S:
            text = f"{self._name} has had no worker for {_WITHOUT_WORKERS_S:.0f} s{self._remedy}"
            raise WorkersUnavailableError(text)
        if without_s > _TOLD_AFTER_S and not self._told:
            self._told = True
            left_s = _WITHOUT_WORKERS_S - without_s
            self._tell(f"{self._name} has no worker; waiting {left_s:.0f} s{self._remedy}")

    def _look(self) -> None:
        now = time.monotonic()
        if now - self._looked_s <= _LOOK_S:
            return
        self._looked_s = now
        # A scheduler that does not answer must not keep a signal waiting.
        with suppress(OSError, TimeoutError, AttributeError):  # without a connection
            self._threads = sum(self._client.nthreads(callback_timeout=_ANSWER_S).values())
            if self._threads:
                self._last_seen_s, self._told = now, False

    def submit(self, work: Callable[..., T], *task: Any) -> Future[T]:
        """Send the task to the scheduler."""
        try:
            future: Future[T] = self._client.get_executor(pure=False).submit(work, *task)
        except Exception:
            if self._client.status == "running":
                raise
            raise self._lost() from None
        return future

    def result(self, future: Future[T]) -> T:
        """Return the result of a task."""
        try:
            return future.result()
        except self._killed as error:
            raise BrokenExecutor from error
        except CancelledError:
            raise self._lost() from None

    def _lost(self) -> WorkersUnavailableError:
        return WorkersUnavailableError(
            f"{self._name} is gone, or has dropped the work; start it and its workers again, "
            "or compute on this machine with --workers"
        )

    def close(self, *, at_once: bool) -> None:
        """Leave the cluster, and end the one that was started here."""
        self._opened.close()


def _close(opened: Any) -> None:
    with suppress(OSError, TimeoutError):  # of a scheduler that is gone
        opened.close()


@contextmanager
def _silenced() -> Iterator[None]:
    """Silence the log of dask, which has a traceback for all that is told in words here."""
    levels = {}
    for name, logger in list(logging.root.manager.loggerDict.items()):
        if name.partition(".")[0] in _LOGGERS and isinstance(logger, logging.Logger):
            levels[logger] = logger.level
            logger.setLevel(logging.CRITICAL + 1)
    yield
    for logger, level in levels.items():
        logger.setLevel(level)
