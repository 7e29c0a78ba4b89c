"""Workers of a dask cluster, with words for the user where dask has a page of its log."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Future
from contextlib import ExitStack, contextmanager, suppress
from typing import Any, TypeVar

from studies.engine.workers import Pool, WorkersUnavailableError, available_cores, for_children

T = TypeVar("T")

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
