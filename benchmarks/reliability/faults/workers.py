"""Workers and schedulers that are killed while they compute."""

from __future__ import annotations

import functools
import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

from benchmarks.reliability.faults.kept import MAP, SWEEP, Fault, Work
from benchmarks.reliability.faults.processes import ROOT, Running, trouble

__all__ = ["faults"]

_NOT_WORKERS = (b"resource_tracker", b"forkserver")


def faults() -> Iterator[Fault]:
    """Kinds of deaths."""
    for work in (MAP, SWEEP):
        killed = functools.partial(_pool, work)
        yield Fault(f"{work.name} by two worker processes", "a worker killed", 6, killed)
    try:
        import distributed  # noqa: F401
    except ImportError:
        return
    for what in ("a worker of two", "every worker, and one comes later", "the scheduler"):
        case = functools.partial(_cluster, what)
        yield Fault(f"{MAP.name} by a dask cluster", f"{what} killed", 3, case)


def _pool(work: Work, rng: random.Random, folder: Path) -> str | None:
    """Kill worker processes of the machine: their chunks are tried again."""
    process = work.start(folder, "--workers", "2")
    for _ in range(rng.randint(1, 3)):
        process.until(lambda: bool(_workers(process)))
        process.until(lambda: False, rng.uniform(0.0, 0.8))
        for pid in _workers(process)[:1]:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
    # Workers that die again and again before their first chunk end the command in words.
    end = process.end()
    if (wrong := trouble(end, {0, 1}, folder)) is not None:
        return wrong
    if end.code == 1 and "worker" not in end.err:
        return f"no word of the workers: {end.last!r}"
    if end.code == 0 and (folder / work.target).read_bytes() != work.whole[0]:
        return "another result"
    return work.finished(folder, "--workers", "1")


def _workers(process: Running) -> list[int]:
    """Worker processes of a command."""
    found = []
    for pid in process.children():
        try:
            words = Path(f"/proc/{pid}/cmdline").read_bytes()
        except OSError:
            continue
        if words and not any(word in words for word in _NOT_WORKERS):
            found.append(pid)
    return found


class _Cluster(NamedTuple):
    address: str
    scheduler: subprocess.Popen[bytes]
    workers: list[subprocess.Popen[bytes]]

    def add(self) -> None:
        """Start another worker."""
        words = ("worker", self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard")
        self.workers.append(_dask(*words))


@contextmanager
def _started(folder: Path, workers: int) -> Iterator[_Cluster]:
    place = folder.parent / "scheduler.json"
    options = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard")
    scheduler = _dask("scheduler", *options, "--scheduler-file", str(place))
    cluster = _Cluster("", scheduler, [])
    try:
        while not place.exists() or not place.read_text().strip().endswith("}"):
            time.sleep(0.02)
        cluster = cluster._replace(address=json.loads(place.read_text())["address"])
        for _ in range(workers):
            cluster.add()
        yield cluster
    finally:
        for process in (scheduler, *cluster.workers):
            process.kill()
            process.wait()


def _dask(*arguments: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "dask", *arguments],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"},
    )


def _cluster(what: str, rng: random.Random, folder: Path) -> str | None:
    """Kill a part of a cluster: the work goes on, or ends in words and can be gone on with."""
    _, chunks, _ = MAP.whole
    with _started(folder, 1 if what.startswith("every") else 2) as cluster:
        process = MAP.start(folder, "--scheduler", cluster.address)
        wanted = rng.randrange(1, chunks)
        process.until(lambda: len(MAP.parts(folder)) >= wanted)
        hit = cluster.scheduler if what == "the scheduler" else cluster.workers[0]
        hit.kill()
        process.struck_s = time.monotonic()
        if what.startswith("every"):
            cluster.add()
        end = process.end()
    codes = {0, 1} if what == "the scheduler" else {0}
    if (wrong := trouble(end, codes, folder)) is not None:
        return wrong
    if end.code == 1 and not ("is gone" in end.err and "to go on:" in end.err):
        return f"no word of the scheduler: {end.err!r}"
    return MAP.finished(folder, "--workers", "1")
