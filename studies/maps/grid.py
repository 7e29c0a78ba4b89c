"""What maps over latitude and season share: their cells in chunks, and what all have in common."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from missions.dates import DAYS_PER_YEAR, days_of_year
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.optimisation.objectives import Objective
from sizing.sunlight import SolarModel
from solar.names import ATTITUDE_MODELS
from solar.types import FloatArray, IntArray
from studies.engine.run import pieces
from studies.output.gridded import Labelled

__all__ = [
    "DAYS",
    "LATITUDES_DEG",
    "SLOW_DAYS",
    "SLOW_LATITUDES_DEG",
    "Grid",
    "MapConfiguration",
    "cell_time_s",
]

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
