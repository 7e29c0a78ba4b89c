"""Studies on a grid, or of drawn points: cells for the engine, their columns as one result.

A map is such a study over latitude and day, a trade study one over any keys.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sizing.validity.ranges import Extrapolation
from solar.types import FloatArray, IntArray
from studies.engine.run import Cell, Job, Outcome
from studies.output.columns import extrapolation_attribute, variables
from studies.output.gridded import Gridded, Labelled

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["VARIED", "GridStudy", "chunks_of"]

VARIED = "varied"  # a coordinate that no cell has a value of


def chunks_of(cells: FloatArray, numbers: Iterable[IntArray]) -> tuple[tuple[Cell, ...], ...]:
    """Chunks of cells, shape ``(cell, value)``, by the numbers of those in each."""
    return tuple(tuple(map(tuple, cells[some].tolist())) for some in numbers)


@dataclass(frozen=True)
class GridStudy:
    """A checked study, ready to be computed.

    ``order``: place of every cell of the job in the result. ``coordinates``: on a dimension each,
    the last one changing first from cell to cell, or all on one. ``described``: unit and long name
    of every variable. ``flags``: what ``status`` may be. ``attributes``: of the result.
    ``extrapolated``: what the columns take from outside the range of a model.
    """

    job: Job
    order: IntArray
    coordinates: Mapping[str, Labelled]
    described: Mapping[str, tuple[str, str]]
    flags: Iterable[IntEnum]
    attributes: Mapping[str, Any]
    extrapolated: Callable[[Mapping[str, NDArray[Any]]], Sequence[Extrapolation]]

    @property
    def _sizes(self) -> dict[str, int]:
        return {one.dims[0]: len(one.values) for one in self.coordinates.values()}

    def gridded(self, outcome: Outcome) -> Gridded:
        """Result with CF attributes, as plain arrays: for those who need no more."""
        place, shape = np.argsort(self.order), tuple(self._sizes.values())
        columns = {n: values[place].reshape(shape) for n, values in outcome.columns.items()}
        # What is varied is no result.
        results = {n: values for n, values in columns.items() if n not in self.coordinates}
        return Gridded(
            variables(tuple(self._sizes), results, self.described, self.flags),
            self.coordinates,
            {
                **self.attributes,
                **self._failed_cells(outcome, shape),
                **extrapolation_attribute(self.extrapolated(columns)),
            },
        )

    def _failed_cells(self, outcome: Outcome, shape: tuple[int, ...]) -> dict[str, str]:
        """Attribute that says which cells failed, and why, a line for each; none if none did."""
        lines = []
        for number, text in sorted(outcome.failures.items()):
            place = dict(zip(self._sizes, np.unravel_index(self.order[number], shape), strict=True))
            values = {
                name: one.values[place[one.dims[0]]]
                for name, one in self.coordinates.items()
                if name != VARIED
            }
            values_text = [
                f"{name} {value if isinstance(value, str) else format(value, 'g')}"
                for name, value in values.items()
            ]
            lines.append(f"{', '.join(values_text)}: {text}")
        return {"failed_cells": "\n".join(lines)} if lines else {}

    def dataset(self, outcome: Outcome) -> xr.Dataset:
        """Return the same as a dataset."""
        return self.gridded(outcome).to_xarray()
