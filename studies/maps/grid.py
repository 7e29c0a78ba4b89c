"""What maps over latitude and season share: cells in chunks, and results laid out on the grid."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from missions.dates import DAYS_PER_YEAR
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.sunlight import SolarModel
from sizing.validity.ranges import Extrapolation
from solar.names import ATTITUDE_MODELS
from studies.engine.run import Cell, Job, Outcome, pieces
from studies.output.columns import (
    attributes,
    extrapolation_attribute,
    failed_cells,
    variables,
)
from studies.output.gridded import Gridded, Labelled

if TYPE_CHECKING:
    import xarray as xr

    from solar.types import FloatArray

__all__ = ["DAYS", "LATITUDES_DEG", "Grid", "MapStudy", "cell_time_s"]

# Of a map for which no other grid is asked.
LATITUDES_DEG, DAYS = np.arange(-70.0, 71.0, 2.0), np.arange(1, 366, 4)

# Time of a cell [s], roughly: it decides the size of a chunk and nothing else. A chunk must not
# depend on the workers, or results would.
_CHUNK_S = 0.5
_CELL_S, _CELL_ON_PATH_S = 2.5e-5, 1e-2


@dataclass(frozen=True)
class Grid:
    """Latitudes [deg], north positive, and days of year from 1 to 365; see :meth:`of`."""

    latitudes_deg: FloatArray
    days: NDArray[np.int_]

    @classmethod
    def of(cls, latitudes: ArrayLike, days: ArrayLike) -> Grid:
        """Check a grid.

        ``days``: days of year, whole numbers from 1 to 365.
        """
        north = np.atleast_1d(np.asarray(latitudes, float))
        date = np.atleast_1d(np.asarray(days, float))
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

    def chunks(self, cell_s: float) -> tuple[tuple[Cell, ...], ...]:
        """Rectangles of cells (latitude, day): whole rows of latitude if a row is short enough."""
        cells = max(round(_CHUNK_S / cell_s), 1)
        rows = pieces(len(self.latitudes_deg), cells // len(self.days))
        columns = pieces(len(self.days), cells)
        north, date = self.latitudes_deg.tolist(), self.days.astype(float).tolist()
        return tuple(
            tuple(itertools.product(north[row], date[column])) for row in rows for column in columns
        )

    def laid_out(self, job: Job, outcome: Outcome) -> dict[str, NDArray[Any]]:
        """Columns of an outcome, shape ``(latitude, day)``.

        ``job``: what was computed, with the latitude [deg] and day of its cells. Returns by the
        names of the columns.
        """
        cells = np.array(job.cells)
        row = np.searchsorted(self.latitudes_deg, cells[:, 0])
        order = np.argsort(row * len(self.days) + np.searchsorted(self.days, cells[:, 1]))
        shape = (len(self.latitudes_deg), len(self.days))
        return {name: values[order].reshape(shape) for name, values in outcome.columns.items()}

    def coordinates(self) -> dict[str, Labelled]:
        """Coordinates of a result, with CF attributes."""
        degrees = {"units": "degrees_north", "standard_name": "latitude"}
        date = {"long_name": "day of year", "units": "1"}
        return {
            "latitude": Labelled(("latitude",), self.latitudes_deg, degrees),
            "day": Labelled(("day",), self.days, date),
        }


@dataclass(frozen=True)
class MapStudy:
    """A checked map, ready to be computed.

    ``job``: its configuration has an aircraft, a mission and a solar model. ``described``: unit and
    long name of every variable. ``flags``: what ``status`` may be. ``attributes``: attributes of
    the result that other maps do not have. ``extrapolated``: what lies outside the range of a
    model, of the columns laid out.
    """

    job: Job
    grid: Grid
    title: str
    described: Mapping[str, tuple[str, str]]
    flags: Iterable[IntEnum]
    attributes: Mapping[str, Any] = field(default_factory=dict)
    extrapolated: Callable[[Mapping[str, NDArray[Any]]], Sequence[Extrapolation]] | None = None

    def dataset(self, outcome: Outcome) -> xr.Dataset:
        """Result on the dimensions ``latitude`` and ``day``, with CF attributes."""
        return self.gridded(outcome).to_xarray()

    def gridded(self, outcome: Outcome) -> Gridded:
        """Return the same as plain arrays: for those who need no more."""
        asked = self.job.configuration
        columns = self.grid.laid_out(self.job, outcome)
        outside = () if self.extrapolated is None else self.extrapolated(columns)
        return Gridded(
            variables(("latitude", "day"), columns, self.described, self.flags),
            self.grid.coordinates(),
            attributes(self.title, asked.aircraft, asked.mission, asked.solar)
            | dict(self.attributes)
            | failed_cells(self.job.cells, outcome.failures, ("latitude", "day"))
            | extrapolation_attribute(outside),
        )


def cell_time_s(aircraft: Aircraft, mission: Mission, solar: SolarModel) -> float:
    """Time that the solar power of a cell takes, roughly [s].

    ``solar``: model and correction; those that follow the flight path take longer. Returns time on
    one core [s].
    """
    if not solar.needs_path:
        return _CELL_S
    asked = f"model {solar.model}" if solar.model in ATTITUDE_MODELS else "correction loiter"
    if aircraft.modules.geometry is None:
        raise ValueError(f"{asked} needs modules.geometry on the aircraft {aircraft.name}")
    if mission.flight_path is None:
        raise ValueError(f"{asked} needs a flight_path on the mission {mission.name}")
    return _CELL_ON_PATH_S
