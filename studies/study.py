"""Study: cells, the function that computes them, and names and units of its columns.

Maps, trade studies and station keeping are studies: the engine computes the cells in chunks, and
the columns become one result, on a dimension for each coordinate or all along one.
"""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sizing.validity.ranges import Extrapolation
from solar.types import BoolArray, FloatArray, IntArray
from studies.engine.chunk_store import ChunkStore
from studies.engine.run import ChunkFunction, Job, Outcome, Progress, run
from studies.engine.workers import DaskPool, Pool
from studies.output.gridded import Gridded, Labelled, extrapolation_attribute, variables

VARIED = "varied"  # a coordinate that no cell has a value of
# Columns of text; the others are numbers.
_TEXTS = ("violated_requirement", "message", "extrapolations")

# Time of a chunk [s], less in small studies, so that there is work for many workers. Independent of
# their number, or results would depend on it.
_LEAST_CHUNK_S, _CHUNK_S = 0.1, 0.5
_CHUNKS = 128


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
        chunks = [order[part] for part in pieces(count, each)]
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
    chosen: BoolArray, there: Mapping[str, Any], elsewhere: Mapping[str, Any]
) -> dict[str, NDArray[Any]]:
    """Merge columns of chosen cells and of the others, blank where a side lacks one."""
    columns = {}
    for name in {**there, **elsewhere}:
        known = [
            (np.asarray(side[name]), where)
            for side, where in ((there, chosen), (elsewhere, ~chosen))
            if name in side
        ]
        kind = np.result_type(*(values for values, _ in known))
        columns[name] = np.full(len(chosen), np.nan if kind.kind == "f" else kind.type(), kind)
        for values, where in known:
            columns[name][where] = values
    return columns


def pieces(count: int, each: int) -> list[slice]:
    """Return slices of at most ``each`` (at least 1) that cover ``count``, as even as possible."""
    number = -(-count // max(each, 1))
    edges = np.linspace(0, count, number + 1).round().astype(int)
    return [slice(int(a), int(b)) for a, b in itertools.pairwise(edges)]
