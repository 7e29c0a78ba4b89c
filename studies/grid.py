"""Studies on a grid, or of drawn points: cells for the engine, their columns as one result.

A map is such a study over latitude and day, and has a grid of its own; a trade study is one over
any keys.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from missions.dates import DAYS_PER_YEAR, days_of_year
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel
from sizing.program.objectives import Objective
from sizing.validity.ranges import Extrapolation
from solar.names import ATTITUDE_MODELS
from solar.types import FloatArray, IntArray
from studies.engine.run import Outcome, pieces
from studies.engine.workers import Cell, Job
from studies.output.gridded import Gridded, Labelled, extrapolation_attribute, variables

if TYPE_CHECKING:
    import xarray as xr

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


# ---- Latitude and day

# Of a map for which no other grid is requested, and of one whose cells take milliseconds.
LATITUDES_DEG, DAYS = np.arange(-70.0, 71.0), np.arange(1, 366)
SLOW_LATITUDES_DEG, SLOW_DAYS = LATITUDES_DEG[::2], DAYS[::4]

# Time of a cell [s], roughly: it decides the size of a chunk and nothing else. A chunk must not
# depend on the workers, or results would.
_CHUNK_S = 0.5
_CELL_S, _CELL_ON_PATH_S = 2.5e-5, 1e-2


@dataclass(frozen=True)
class MapConfiguration:
    """What all cells of a map have in common; ``objective``: what they are sized for, if so."""

    aircraft: Aircraft
    mission: Mission
    solar: SolarModel
    endurance: bool = False
    objective: Objective | None = None


@dataclass(frozen=True)
class Grid:
    """Latitudes [deg], north positive, and days of year from 1 to 365; see :meth:`of`."""

    latitudes_deg: FloatArray
    days: IntArray

    @classmethod
    def of(cls, latitudes: ArrayLike | None, days: ArrayLike | None, *, slow: bool) -> Grid:
        """Check a grid.

        ``latitudes``, ``days``: None for 1 degree and 1 day, or 2 degrees and 4 days of ``slow``
        cells; days of year are whole numbers from 1 to 365, or dates.
        """
        if latitudes is None:
            latitudes = SLOW_LATITUDES_DEG if slow else LATITUDES_DEG
        if days is None:
            days = SLOW_DAYS if slow else DAYS
        north = np.atleast_1d(np.asarray(latitudes, float))
        date = np.asarray(days_of_year(days), float)
        for name, values, low, high in (
            ("latitudes", north, -90.0, 90.0),
            ("days", date, 1.0, float(DAYS_PER_YEAR)),
        ):
            good = values.ndim == 1 and len(values) and values[0] >= low and values[-1] <= high
            if not (good and np.all(np.diff(values) > 0.0)):
                raise ValueError(f"{name} must ascend within {low:g} to {high:g}")
        if np.any(date != np.round(date)):
            raise ValueError("days must be whole numbers")
        return cls(north, date.astype(int))

    def cells(self) -> FloatArray:
        """Latitude [deg] and day of all cells, shape ``(cell, 2)``."""
        return np.array(list(itertools.product(self.latitudes_deg, self.days)), float)

    def check_winds(self, mission: Mission) -> None:
        """Refuse cells whose wind the mission's table does not know, where it matters."""
        if mission.wind_statistics is not None:
            latitude, day = self.cells().T
            mission.scenario_winds_m_per_s(Scenarios(latitude, day.astype(int)))

    def chunks(self, cell_s: float) -> list[IntArray]:
        """Numbers of the cells of rectangles: whole rows of latitude if a row is short enough."""
        shape = len(self.latitudes_deg), len(self.days)
        most = max(round(_CHUNK_S / cell_s), 1)
        numbers = np.arange(shape[0] * shape[1]).reshape(shape)
        rows, columns = pieces(shape[0], most // shape[1]), pieces(shape[1], most)
        return [numbers[row, column].ravel() for row in rows for column in columns]

    def coordinates(self) -> dict[str, Labelled]:
        """Coordinates of a result, with CF attributes."""
        degrees = {"units": "degrees_north", "standard_name": "latitude"}
        date = {"long_name": "day of year", "units": "1"}
        return {
            "latitude": Labelled(("latitude",), self.latitudes_deg, degrees),
            "day": Labelled(("day",), self.days, date),
        }


def cell_time_s(aircraft: Aircraft, mission: Mission, solar: SolarModel) -> float:
    """Time that the solar power of a cell takes on one core, roughly [s].

    ``solar``: model and correction; those that follow the flight path take longer.
    """
    if not solar.needs_path:
        return _CELL_S
    option = f"model {solar.model}" if solar.model in ATTITUDE_MODELS else "correction loiter"
    if aircraft.modules.geometry is None:
        raise ValueError(f"{option} needs modules.geometry on the aircraft {aircraft.name}")
    if mission.flight_path is None:
        raise ValueError(f"{option} needs a flight_path on the mission {mission.name}")
    return _CELL_ON_PATH_S
