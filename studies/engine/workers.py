"""Who computes: this process, processes of this machine, or a dask cluster.

Each is a *crew* of lanes, and a lane has one task at a time. Behind a lane stands an executor of
:mod:`concurrent.futures`. On this machine every lane has a pool of its own with a single process: a
process that dies breaks that pool alone, and it is certain which task it died of.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from multiprocessing.process import BaseProcess
from typing import Any, Protocol, TypeVar

from studies.engine.worker_process import SINGLE_THREAD, prepare_worker

__all__ = [
    "AutomaticCrew",
    "Crew",
    "DaskCrew",
    "ProcessCrew",
    "SerialCrew",
    "WorkersUnavailableError",
    "available_cores",
    "crew_of",
]

T = TypeVar("T")

LOCAL_CLUSTER = "local-cluster"

# Processes are started when the work left would take this process longer [s]: each of them first
# spends about a second on imports.
_PAYS_S = 3.0
_CONNECT_S = 20.0
_LOOK_S = 5.0
_STILLBORN = 2


class WorkersUnavailableError(OSError):
    """No worker can be had; the text says why and what to do."""


class Crew(Protocol):
    """Lanes that compute tasks."""

    @property
    def retries(self) -> int:
        """How often a task that a worker died of is given out again."""

    @property
    def elsewhere(self) -> bool:
        """Whether tasks run in other processes."""

    @property
    def certain(self) -> bool:
        """Whether a task whose worker died was the only one that this worker had."""

    def lanes(self, tasks_left: int) -> int:
        """How many tasks the crew takes at once, told how many there are."""

    def submit(self, lane: int, work: Callable[[Any], T], task: Any) -> Future[T]:
        """Give a task to a free lane."""

    def died(self, lane: int, error: BaseException) -> bool:
        """Whether an error says that a worker died; the lane is then ready for another task."""

    def close(self, *, at_once: bool) -> None:
        """End the crew, in the middle of its tasks if need be."""


def available_cores() -> int:
    """Cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on every system
        return os.cpu_count() or 1


class _InThisProcess(Executor):
    """Executor that is done when it has taken a task."""

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """Compute at once."""
        future: Future[T] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


class SerialCrew:
    """The present process alone."""

    retries = 0
    elsewhere = False
    certain = True

    def __init__(self) -> None:
        self._executor = _InThisProcess()

    def lanes(self, tasks_left: int) -> int:
        """One."""
        return 1

    def submit(self, lane: int, work: Callable[[Any], T], task: Any) -> Future[T]:
        """Compute the task now."""
        return self._executor.submit(work, task)

    def died(self, lane: int, error: BaseException) -> bool:
        """Never: nobody would be left to ask."""
        return False

    def close(self, *, at_once: bool) -> None:
        """There is nothing to end."""


class _Lane:
    """One worker process, started with its first task and again after it died."""

    def __init__(self) -> None:
        self._executor: ProcessPoolExecutor | None = None
        self._started: Future[int] | None = None
        self._processes: list[BaseProcess] = []
        self._stillborn = 0

    def submit(self, work: Callable[[Any], T], task: Any) -> Future[T]:
        if self._executor is None:
            self._start()
        assert self._executor is not None
        return self._executor.submit(work, task)

    def _start(self) -> None:
        known = set(multiprocessing.active_children())
        context = multiprocessing.get_context("spawn")
        with _for_children():
            self._executor = ProcessPoolExecutor(1, mp_context=context, initializer=prepare_worker)
            self._started = self._executor.submit(os.getpid)
        self._processes = [p for p in multiprocessing.active_children() if p not in known]

    def drop(self) -> None:
        """Forget a broken pool.

        Raises
        ------
        WorkersUnavailableError
            If its process died again and again before it was ready for any task.
        """
        started = self._started
        self.close(at_once=True)
        ready = started is not None and started.done() and started.exception() is None
        self._stillborn = 0 if ready else self._stillborn + 1
        if self._stillborn > _STILLBORN:
            raise WorkersUnavailableError(
                "a worker process ended before its first task (a script that starts workers needs "
                "`if __name__ == '__main__':`); --workers 1 computes without them"
            )

    def close(self, *, at_once: bool) -> None:
        if self._executor is None:
            return
        if at_once:
            for process in self._processes:
                process.kill()
        self._executor.shutdown(wait=True, cancel_futures=at_once)
        self._executor, self._processes = None, []


class ProcessCrew:
    """Processes of this machine, one for each lane."""

    retries = 2
    elsewhere = True
    certain = True

    def __init__(self, workers: int | None = None) -> None:
        self._lanes = [_Lane() for _ in range(available_cores() if workers is None else workers)]

    def lanes(self, tasks_left: int) -> int:
        """As many as processes were asked for; each starts when a task needs it."""
        return len(self._lanes)

    def submit(self, lane: int, work: Callable[[Any], T], task: Any) -> Future[T]:
        """Send the task to the lane's process."""
        return self._lanes[lane].submit(work, task)

    def died(self, lane: int, error: BaseException) -> bool:
        """Whether the lane's process died."""
        if not isinstance(error, BrokenExecutor):
            return False
        self._lanes[lane].drop()
        return True

    def close(self, *, at_once: bool) -> None:
        """End all processes."""
        for lane in self._lanes:
            lane.close(at_once=at_once)


class AutomaticCrew:
    """The present process first; others as soon as the work left is seen to be worth their start.

    Small computations thus never wait for a pool.
    """

    def __init__(self, workers: int | None = None) -> None:
        self._most = available_cores() if workers is None else workers
        self._crew: SerialCrew | ProcessCrew = SerialCrew()
        self._tasks, self._spent_s, self._warm = 0, 0.0, False

    @property
    def retries(self) -> int:
        """Those of the present crew."""
        return self._crew.retries

    @property
    def elsewhere(self) -> bool:
        """Whether the processes have taken over."""
        return self._crew.elsewhere

    @property
    def certain(self) -> bool:
        """That of the present crew."""
        return self._crew.certain

    def lanes(self, tasks_left: int) -> int:
        """One, or the number of processes once they pay."""
        serial = isinstance(self._crew, SerialCrew)
        if serial and self._most > 1 and self._tasks > 0:
            left_s = tasks_left * self._spent_s / self._tasks
            if left_s > _PAYS_S:
                self._crew = ProcessCrew(min(self._most, tasks_left))
        return self._crew.lanes(tasks_left)

    def submit(self, lane: int, work: Callable[[Any], T], task: Any) -> Future[T]:
        """Compute here and take the time, or send the task to a process."""
        begun = time.perf_counter()
        future = self._crew.submit(lane, work, task)
        if self._warm:
            self._tasks += 1
            self._spent_s += time.perf_counter() - begun
        self._warm = True  # the first task also imports what it needs
        return future

    def died(self, lane: int, error: BaseException) -> bool:
        """Whether a process died."""
        return self._crew.died(lane, error)

    def close(self, *, at_once: bool) -> None:
        """End all processes."""
        self._crew.close(at_once=at_once)


class DaskCrew:
    """Workers of a dask cluster: one that runs already, or one of this machine for the occasion.

    The scheduler itself moves the tasks of a dead worker to others; it gives up on a task that has
    ended several (`distributed.scheduler.allowed-failures`).
    """

    retries = 1
    elsewhere = True
    certain = False

    def __init__(self, scheduler: str, workers: int | None = None) -> None:
        try:
            import distributed
        except ImportError:
            raise WorkersUnavailableError(
                "--scheduler needs dask: pip install distributed (the extra 'cluster')"
            ) from None
        self._cluster: Any = None
        self._killed: type[BaseException] = distributed.KilledWorker
        with _for_children():
            if scheduler == LOCAL_CLUSTER:
                self._cluster = distributed.LocalCluster(
                    n_workers=available_cores() if workers is None else workers,
                    threads_per_worker=1,
                    dashboard_address=None,
                    silence_logs="ERROR",
                )
            address = scheduler if self._cluster is None else self._cluster
            try:
                self._client = distributed.Client(address, timeout=_CONNECT_S, set_as_default=False)
                self._client.wait_for_workers(1, timeout=_CONNECT_S)
            except (OSError, TimeoutError, ValueError) as error:
                self.close(at_once=True)
                raise WorkersUnavailableError(
                    f"no worker at the scheduler {scheduler}: {error}"
                ) from error
        self._executor: Executor = self._client.get_executor(pure=False)
        self._lanes, self._looked_s = 0, -_LOOK_S

    def lanes(self, tasks_left: int) -> int:
        """Two for each thread of the cluster, so that none waits for the network."""
        if time.monotonic() - self._looked_s > _LOOK_S:
            with suppress(OSError, TimeoutError):
                self._lanes = max(2 * sum(self._client.nthreads().values()), 1)
            self._looked_s = time.monotonic()
        return self._lanes

    def submit(self, lane: int, work: Callable[[Any], T], task: Any) -> Future[T]:
        """Send the task to the scheduler."""
        return self._executor.submit(work, task)

    def died(self, lane: int, error: BaseException) -> bool:
        """Whether the scheduler gave up on the task."""
        return isinstance(error, self._killed)

    def close(self, *, at_once: bool) -> None:
        """Leave the cluster, and end the one that was started here."""
        client = getattr(self, "_client", None)
        if client is not None:
            client.close()
        if self._cluster is not None:
            self._cluster.close()


def crew_of(workers: int | None, scheduler: str | None) -> Crew:
    """Crew that the options ``--workers`` and ``--scheduler`` ask for.

    Parameters
    ----------
    workers : int or None
        1 for this process alone, more for so many processes; None for what pays.
    scheduler : str or None
        Address of a dask scheduler, or ``local-cluster``.

    Raises
    ------
    WorkersUnavailableError
        If dask is not installed, or no worker is there.
    """
    if scheduler is not None:
        return DaskCrew(scheduler, workers)
    if workers is None:
        return AutomaticCrew()
    return SerialCrew() if workers == 1 else ProcessCrew(workers)


@contextmanager
def _for_children() -> Iterator[None]:
    """Start processes that compute with one thread each and never see Ctrl-C.

    Both are inherited, and must be in place before a process imports anything.
    """
    before = {name: os.environ.get(name) for name in SINGLE_THREAD}
    os.environ.update(SINGLE_THREAD)
    masks = hasattr(signal, "pthread_sigmask")
    if masks:
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        if masks:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
