"""One study: cells, a function of them, and what its columns are called and mean.

Maps, trade studies and station keeping are such studies: the engine computes the cells in chunks,
and the columns become one result, on a dimension for each coordinate or all along one.
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
from studies.engine.run import ChunkFunction, Job, Outcome, Progress, pool_of, run
from studies.engine.workers import Pool
from studies.output.gridded import Gridded, Labelled, extrapolation_attribute, variables

VARIED = "varied"  # a coordinate that no cell has a value of
# Columns of text; the others are numbers.
_TEXTS = ("violated_requirement", "message", "extrapolations")

# A chunk takes so long [s], of small studies less, so that there is work for many workers. Neither
# depends on how many there are, or results would.
_LEAST_CHUNK_S, _CHUNK_S = 0.1, 0.5
_CHUNKS = 128


class ComputationError(RuntimeError):
    """Every cell of a computation failed."""


@dataclass(frozen=True)
class Study:
    """A checked study, ready to be computed.

    ``function``, ``configuration``, ``cells``: see :class:`studies.engine.run.Job`; of cells on a
    grid the last coordinate changes first. ``cell_s``: time of a cell on one core, roughly [s]: it
    decides the size of chunks, and whether processes pay. ``described``: unit and long name of
    every column. ``statuses``: what ``status`` may be, ``failed`` among them. ``coordinates``: on a
    dimension each, or all on one. ``attributes``: of the result. ``extrapolated``: what the columns
    take from outside the range of a model. ``order``: numbers of the cells in the order in which
    they are computed. ``unit``: what cells are called, in the plural. ``together``: cells that a
    chunk has at least, where they are quicker computed together.
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
        """What the engine computes."""
        count = len(self.cells)
        chunk_s = min(max(count * self.cell_s / _CHUNKS, _LEAST_CHUNK_S), _CHUNK_S)
        order = np.arange(count) if self.order is None else self.order
        each = max(round(chunk_s / self.cell_s), self.together)
        chunks = [order[some] for some in pieces(count, each)]
        blanks = blanks_of(self.described)
        return Job(self.function, self.configuration, self.cells, chunks, blanks)

    def pool(
        self,
        workers: int | None,
        scheduler: str | None,
        tell: Callable[[str], None] | None = None,
    ) -> Pool:
        """Who computes the study, see :func:`studies.engine.run.pool_of`."""
        return pool_of(workers, scheduler, tell, self.cell_s * len(self.cells))

    def trouble(self, outcome: Outcome) -> str | None:
        """How many cells failed and why the first did; none if none did."""
        if not outcome.failures:
            return None
        first = outcome.failures[min(outcome.failures)]
        failed = f"{len(outcome.failures)} of {len(self.cells)} {self.unit} failed"
        return f"{failed}; the first: {first}"

    def computed(
        self,
        workers: int | None = 1,
        scheduler: str | None = None,
        progress: Progress | None = None,
    ) -> Gridded:
        """Compute the study in memory, for callers in Python.

        ``workers``: processes that compute: 1 starts none, None as many as there are cores where
        that pays. ``scheduler``: that of dask, with the workers that were started for it, or
        ``local-cluster``. ``progress``: called with the cells done and the cells in all. A warning
        tells how many cells failed, if any did.
        """
        if workers is not None and workers < 1:
            raise ValueError(f"workers must be at least 1, or None (got {workers})")
        if scheduler not in (None, "local-cluster") and "://" not in scheduler:
            text = f"scheduler must be tcp://HOST:PORT or local-cluster (got {scheduler!r})"
            raise ValueError(text)
        outcome = run(self.job, self.pool(workers, scheduler), progress=progress)
        trouble = self.trouble(outcome)
        if len(outcome.failures) == len(self.cells):
            raise ComputationError(trouble)
        if trouble is not None:
            warnings.warn(trouble, RuntimeWarning, stacklevel=3)
        return self.gridded(outcome)

    def gridded(self, outcome: Outcome) -> Gridded:
        """Result with CF attributes, as plain arrays: for those who need no more."""
        sizes = {one.dims[0]: len(one.values) for one in self.coordinates.values()}
        columns = {
            name: values.reshape(tuple(sizes.values()))
            # What is varied is no result.
            for name, values in _with_reasons(outcome).items()
            if name not in self.coordinates
        }
        return Gridded(
            variables(tuple(sizes), columns, self.described, self.statuses),
            self.coordinates,
            {
                **self.attributes,
                **self._failed_cells(outcome, sizes),
                **extrapolation_attribute(self.extrapolated(columns)),
            },
        )

    def _failed_cells(self, outcome: Outcome, sizes: Mapping[str, int]) -> dict[str, str]:
        """Attribute that says which cells failed, and why, a line for each; none if none did."""
        lines = []
        for number, reason in sorted(outcome.failures.items()):
            place = np.unravel_index(number, tuple(sizes.values()))
            where = dict(zip(sizes, place, strict=True))
            values = {
                name: one.values[where[one.dims[0]]]
                for name, one in self.coordinates.items()
                if name != VARIED
            }
            texts = (
                f"{name} {value if isinstance(value, str) else format(value, 'g')}"
                for name, value in values.items()
            )
            lines.append(f"{', '.join(texts)}: {reason}")
        return {"failed_cells": "\n".join(lines)} if lines else {}


def _with_reasons(outcome: Outcome) -> dict[str, NDArray[Any]]:
    """Columns with the reason of a cell that failed as its message."""
    if "message" not in outcome.columns or not outcome.failures:
        return outcome.columns
    messages = outcome.columns["message"].astype(object)
    messages[list(outcome.failures)] = list(outcome.failures.values())
    return outcome.columns | {"message": messages.astype(str)}


def blanks_of(described: Mapping[str, Any]) -> dict[str, Any]:
    """What stands in every column for a cell without a result."""
    blanks: dict[str, Any] = {name: np.float64("nan") for name in described}
    blanks |= {name: np.str_("") for name in _TEXTS if name in described}
    return blanks | ({"status": np.int8(-1)} if "status" in described else {})


def merged(
    chosen: BoolArray, there: Mapping[str, Any], elsewhere: Mapping[str, Any]
) -> dict[str, NDArray[Any]]:
    """Columns of all cells from those of the chosen ones and of the others.

    A column that one side lacks is blank there.
    """
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
    """Slices of at most ``each`` that cover ``count``, as even as possible.

    ``each``: largest number in a slice; less than 1 counts as 1. Returns in order, without gaps.
    """
    number = -(-count // max(each, 1))
    edges = np.linspace(0, count, number + 1).round().astype(int)
    return [slice(int(a), int(b)) for a, b in itertools.pairwise(edges)]
