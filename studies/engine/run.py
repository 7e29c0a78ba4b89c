"""Long computations in chunks of cells: in parallel, resumable, and not felled by one bad cell.

Maps, trade studies and station keeping are each a :class:`Study`: cells, the function that computes
them, names and units of its columns, which become one result, on a dimension for each coordinate or
all along one. Its :class:`Job` is what :func:`run` has a pool compute. Chunks never depend on the
workers and are always computed as a whole, so that the result is the same to the last bit whoever
computes it, in one run or in several.

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
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import IntEnum
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic_core import to_json

from sizing.validity.ranges import Extrapolation
from solar._version import __version__
from solar.types import BoolArray, FloatArray, IntArray
from studies.engine.chunk_store import FAILURE, ChunkStore, Part
from studies.engine.workers import DaskPool, Pool, WorkersUnavailableError
from studies.output.gridded import Gridded, Labelled, extrapolation_attribute, variables
from studies.signals import Signals, interruptible

Progress: TypeAlias = Callable[[int, int], None]
ChunkFunction: TypeAlias = Callable[[Any, FloatArray], Mapping[str, Any]]

VARIED = "varied"  # a coordinate that no cell has a value of
# Columns of text; the others are numbers.
_TEXTS = ("violated_requirement", "message", "extrapolations")

# Time of a chunk [s], less in small studies, so that there is work for many workers. Independent of
# their number, or results would depend on it.
_LEAST_CHUNK_S, _CHUNK_S = 0.1, 0.5
_CHUNKS = 128
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


# ---- A study, whose cells are a job


class ComputationError(RuntimeError):
    """Failure of every cell of a computation."""


@dataclass(frozen=True)
class Study:
    """Checked study, ready to be computed.

    ``function``, ``configuration``, ``cells``: see :class:`studies.engine.run.Job`; on a grid the
    last coordinate changes first. ``cell_s``: rough time of a cell on one core [s], for the size of
    chunks and the choice of processes. ``described``: unit and long name of every column.
    ``statuses``: values of ``status``, ``failed`` included. ``coordinates``: on a dimension each,
    or all on one. ``attributes``: of the result. ``extrapolated``: function of the columns that
    returns values outside a model's range. ``order``: indices of the cells in the order of
    computation. ``unit``: name of cells, in the plural. ``together``: least cells in a chunk, for
    cells that are faster together.
    """

    function: ChunkFunction
    configuration: Any
    cells: FloatArray
    cell_s: float
    described: Mapping[str, tuple[str, str]]
    statuses: Sequence[IntEnum]
    coordinates: Mapping[str, Labelled]
    attributes: Mapping[str, Any]
    extrapolated: Callable[[Mapping[str, NDArray[Any]]], Sequence[Extrapolation]]
    order: IntArray | None = None
    unit: str = "cells"
    together: int = 1

    @cached_property
    def job(self) -> Job:
        """Job of the engine."""
        count = len(self.cells)
        chunk_s = min(max(count * self.cell_s / _CHUNKS, _LEAST_CHUNK_S), _CHUNK_S)
        order = np.arange(count) if self.order is None else self.order
        each = max(round(chunk_s / self.cell_s), self.together)
        # As even as possible.
        edges = np.linspace(0, count, -(-count // each) + 1).round().astype(int)
        chunks = np.split(order, edges[1:-1])
        blanks = blanks_of(self.described)
        return Job(self.function, self.configuration, self.cells, chunks, blanks)

    def run(
        self,
        workers: int | None,
        scheduler: str | None = None,
        *,
        store: ChunkStore | None = None,
        progress: Progress | None = None,
        tell: Callable[[str], None] | None = None,
    ) -> tuple[Gridded | None, str]:
        """Compute the study; see :func:`studies.engine.run.run`.

        ``workers``: 1 for this process alone, more for so many processes; None for what pays.
        ``scheduler``: address of dask's scheduler, or ``local-cluster``. ``tell``: called with what
        the user should know while the work waits. Returns the result, None where every cell failed,
        and what is wrong: the number of failed cells and the first reason, empty without failures.
        """
        count = len(self.cells)
        pool = Pool(workers, self.cell_s * count)
        if scheduler is not None:
            pool = DaskPool(scheduler, workers, tell)
        outcome = run(self.job, pool, store, progress)
        failures, trouble = outcome.failures, ""
        if failures:
            failed = f"{len(failures)} of {count} {self.unit} failed"
            trouble = f"{failed}; the first: {failures[min(failures)]}"
        return None if len(failures) == count else self._gridded(outcome), trouble

    def computed(
        self,
        workers: int | None = 1,
        scheduler: str | None = None,
        progress: Progress | None = None,
    ) -> Gridded:
        """Compute the study in memory, for callers in Python; arguments as :meth:`run`.

        A warning counts failed cells; where all failed there is an error.
        """
        if workers is not None and workers < 1:
            raise ValueError(f"workers must be at least 1, or None (got {workers})")
        if scheduler not in (None, "local-cluster") and "://" not in scheduler:
            text = f"scheduler must be tcp://HOST:PORT or local-cluster (got {scheduler!r})"
            raise ValueError(text)
        data, trouble = self.run(workers, scheduler, progress=progress)
        if data is None:
            raise ComputationError(trouble)
        if trouble:
            warnings.warn(trouble, RuntimeWarning, stacklevel=3)
        return data

    def _gridded(self, outcome: Outcome) -> Gridded:
        """Return the result with CF attributes, as plain arrays."""
        sizes = {c.dims[0]: len(c.values) for c in self.coordinates.values()}
        known, failures = dict(outcome.columns), outcome.failures
        if "message" in known and failures:
            messages = known["message"].astype(object)
            messages[list(failures)] = list(failures.values())
            known["message"] = messages.astype(str)
        failed_cells = []
        for number, reason in sorted(failures.items()):
            place = np.unravel_index(number, tuple(sizes.values()))
            where = dict(zip(sizes, place, strict=True))
            values = {
                name: coordinate.values[where[coordinate.dims[0]]]
                for name, coordinate in self.coordinates.items()
                if name != VARIED
            }
            texts = (
                f"{n} {v if isinstance(v, str) else format(v, 'g')}" for n, v in values.items()
            )
            failed_cells.append(f"{', '.join(texts)}: {reason}")
        columns = {
            name: values.reshape(tuple(sizes.values()))
            # Varied columns are coordinates, not results.
            for name, values in known.items()
            if name not in self.coordinates
        }
        return Gridded(
            variables(tuple(sizes), columns, self.described, self.statuses),
            self.coordinates,
            {
                **self.attributes,
                **({"failed_cells": "\n".join(failed_cells)} if failures else {}),
                **extrapolation_attribute(self.extrapolated(columns)),
            },
        )


def blanks_of(described: Mapping[str, Any]) -> dict[str, Any]:
    """Return the blank value of every column, for cells without a result."""
    blanks: dict[str, Any] = {name: np.float64("nan") for name in described}
    blanks |= {name: np.str_("") for name in _TEXTS if name in described}
    return blanks | ({"status": np.int8(-1)} if "status" in described else {})


def merged(
    able: BoolArray, known: Mapping[str, Any], others: Mapping[str, NDArray[Any]]
) -> dict[str, NDArray[Any]]:
    """Return columns of all cells: of those able to what is known of them, else of the others.

    ``others``: a value for each of all cells; a column that it lacks is blank there.
    """
    place, columns = np.maximum(np.cumsum(able) - 1, 0), dict(others)
    for name, values in known.items():
        whole = np.asarray(values)[place]
        blank = "" if whole.dtype.kind == "U" else np.nan
        columns[name] = np.where(able, whole, others.get(name, blank))
    return columns


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
