"""Long computations in chunks of cells: in parallel, resumable, and not felled by one bad cell.

A :class:`Job` is a function, a configuration, cells, and which of them are computed together;
:func:`run` has a pool compute them. Chunks never depend on the workers and are always computed as a
whole, so that the result is the same to the last bit whoever computes it, in one run or in several.

* A chunk whose function raises is computed again cell by cell; a cell that raises by itself is
  recorded as failed with its message.
* Where a worker process dies, all chunks that were under way are tried again at the end, each with
  nothing else going on. One that a worker dies of even then is computed cell by cell, and a cell
  that a worker dies of is recorded as failed.
* With a store every finished chunk is kept, under a key made of function, configuration, code and
  cells; what is there already is not computed again, unless cells of it failed.
* SIGINT and SIGTERM end the workers at once and raise :class:`Stopped`.
"""

from __future__ import annotations

import functools
import hashlib
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from contextlib import suppress
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic_core import to_json

from solar._version import __version__
from solar.types import FloatArray, IntArray
from studies.engine.chunk_store import FAILURE, ChunkStore, Part
from studies.engine.workers import Pool, WorkersUnavailableError
from studies.signals import Signals, interruptible

Progress: TypeAlias = Callable[[int, int], None]
ChunkFunction: TypeAlias = Callable[[Any, FloatArray], Mapping[str, Any]]

_PACKAGES = ("solar", "missions", "sizing", "studies")
_DIED = "the worker process died"
_LOOK_S = 0.2


@dataclass(frozen=True)
class Job:
    """What is to be computed.

    ``function``: function of a module, called with the configuration and an array of cells; returns
    one value per cell for the columns that it knows. ``configuration``: what the function needs
    besides: data classes, pydantic models, numbers and text, which pickle and can be written as
    JSON. Never a solver: workers keep theirs. ``cells``: shape ``(cell, value)``. ``chunks``:
    numbers of the cells that are computed together, each cell in one of them. ``blanks``: name of
    every column, and the NumPy scalar that stands in it for a failed or unknown cell.
    """

    function: ChunkFunction
    configuration: Any
    cells: FloatArray
    chunks: Sequence[IntArray]
    blanks: Mapping[str, Any]

    @property
    def size_bytes(self) -> int:
        """Size of all columns, estimated [bytes]."""
        return len(self.cells) * sum(max(np.asarray(b).itemsize, 8) for b in self.blanks.values())

    def keys(self) -> list[str]:
        """Return the key of every chunk: it changes with anything that may change its result."""
        function = f"{self.function.__module__}.{self.function.__qualname__}"
        common = [function, __version__, np.__version__, code_digest(), sorted(self.blanks)]
        # Files that the configuration names count with their contents, not with their path alone.
        context = {"contents": True}
        head = to_json([*common, self.configuration], inf_nan_mode="strings", context=context)
        chunks = (self.cells[chunk].tobytes() for chunk in self.chunks)
        return [hashlib.sha256(head + chunk).hexdigest()[:40] for chunk in chunks]


@functools.cache
def code_digest() -> str:
    """Return a digest of the packages' files: a result belongs to the code that computed it."""
    digest = hashlib.sha256()
    for package in _PACKAGES:
        root = Path(str(resources.files(package)))
        for path in sorted(root.rglob("*")):
            if path.is_file() and path.parent.name != "__pycache__":
                digest.update(path.relative_to(root).as_posix().encode() + b"\0")
                digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()[:16]


@dataclass(frozen=True)
class Outcome:
    """Columns over all cells; cells that failed, by number, with the reason."""

    columns: dict[str, NDArray[Any]]
    failures: dict[int, str]
    computed_chunks: int
    kept_chunks: int


def run(
    job: Job, pool: Pool, store: ChunkStore | None = None, progress: Progress | None = None
) -> Outcome:
    """Compute a job; the pool is closed at the end.

    ``progress``: called with the cells done and the cells in all; what was kept counts as done from
    the start. Returns columns over all cells, and the cells that failed.
    """
    module = job.function.__module__
    pool.imports = () if module == "__main__" else (module,)
    cells = [len(chunk) for chunk in job.chunks]
    parts: dict[int, Part] = {}
    finished = False

    def tell() -> None:
        if progress is not None:
            progress(sum(cells[number] for number in parts), len(job.cells))

    # Between tasks a signal waits, so that it breaks nothing off but the task that is under way.
    with interruptible(held=True) as signals:
        try:
            keys = () if store is None else job.keys()
            for number, key in enumerate(keys):
                part = None if store is None else store.read(key, job.blanks, cells[number])
                if part is not None and not np.any(part[FAILURE] != ""):
                    parts[number] = part
            kept = len(parts)
            tell()
            lacking = [number for number in range(len(cells)) if number not in parts]
            for number, part in _computed(job, pool, signals, lacking):
                if store is not None:
                    store.write(keys[number], part)
                parts[number] = part
                tell()
            finished = True
        finally:
            pool.close(at_once=not finished)
    whole = _joined([parts[number] for number in range(len(cells))])
    place = np.argsort(np.concatenate(job.chunks), kind="stable")
    columns = {name: values[place] for name, values in whole.items()}
    reasons = columns.pop(FAILURE)
    failures = {int(i): str(reasons[i]) for i in np.flatnonzero(reasons != "")}
    return Outcome(columns, failures, len(cells) - kept, kept)


def _computed(
    job: Job, pool: Pool, signals: Signals, numbers: Sequence[int]
) -> Iterator[tuple[int, Part]]:
    """Yield numbers of chunks with their parts, those last whose worker died."""
    waiting, again = deque(numbers), []
    flying: dict[Future[Part], int] = {}

    def submitted(chunk: IntArray) -> Future[Part]:
        task = replace(job, cells=job.cells[chunk], chunks=())
        signals.held = not pool.in_process
        try:
            if pool.in_process:
                here = Future[Part]()
                here.set_result(compute_task(task))
                return here
            return pool.submit(compute_task, task, None if pool.same_code else code_digest())
        finally:
            signals.held = True

    def finished(futures: Iterable[Future[Part]]) -> set[Future[Part]]:
        signals.check()
        done, _ = wait(futures, timeout=_LOOK_S, return_when=FIRST_COMPLETED)
        signals.check()
        if not done:
            pool.check()
        return done

    def result(future: Future[Part]) -> Part | None:
        """Return the part of a task; None if its worker died."""
        with suppress(BrokenExecutor):
            return pool.result(future)
        return None

    def alone(chunk: IntArray) -> Part:
        """Compute cells with nothing else going on, one by one if a worker dies of them."""
        future = submitted(chunk)
        while not finished([future]):
            pass
        part = result(future)
        if part is None and len(chunk) == 1:
            return _failed(job, _DIED)
        return part or _joined([alone(chunk[i : i + 1]) for i in range(len(chunk))])

    while waiting or flying:
        while waiting and len(flying) < pool.size:
            number = waiting.popleft()
            flying[submitted(job.chunks[number])] = number
        for future in finished(flying):
            number, part = flying.pop(future), result(future)
            if part is None:
                again.append(number)
            else:
                yield number, part
    for number in again:
        yield number, alone(job.chunks[number])


# ---- In a worker, or here


# Solvers that a worker keeps are not safe in several threads, which a dask worker may have.
_ONE_AT_A_TIME = threading.Lock()


def compute_task(job: Job, code: str | None = None) -> Part:
    """Compute the cells of a job as one chunk; cells that raise are failures of the part.

    ``code``: digest of the driver's code, where it may be another than that of this process.
    """
    if code is not None and code != code_digest():
        raise WorkersUnavailableError(
            f"a worker has another version of solar-uav-sizing than this process ({__version__}): "
            "install the same one everywhere"
        )
    with _ONE_AT_A_TIME:
        return _computed_or_failed(job, job.cells)


def _computed_or_failed(job: Job, cells: FloatArray) -> Part:
    try:
        return _part_of(job, cells)
    except Exception as error:
        if len(cells) == 1:
            return _failed(job, " ".join(f"{type(error).__name__}: {error}".split()))
    return _joined([_computed_or_failed(job, cells[i : i + 1]) for i in range(len(cells))])


def _part_of(job: Job, cells: FloatArray) -> Part:
    computed = job.function(job.configuration, cells)
    if not set(computed) <= set(job.blanks):
        raise ValueError(f"columns {sorted(computed)} are not {sorted(job.blanks)}")
    part = {FAILURE: np.zeros(len(cells), "U1")}
    for name, blank in job.blanks.items():
        kind = np.asarray(blank).dtype
        values = computed[name] if name in computed else np.full(len(cells), blank)
        part[name] = np.asarray(values, None if kind.kind == "U" else kind)
        if part[name].shape != (len(cells),):
            raise ValueError(f"column {name} has the shape {part[name].shape}, not ({len(cells)},)")
    return part


def _joined(parts: Sequence[Part]) -> Part:
    """Return parts one after the other."""
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _failed(job: Job, message: str) -> Part:
    """Return the part of a cell that failed."""
    return {name: np.asarray([value]) for name, value in {**job.blanks, FAILURE: message}.items()}
