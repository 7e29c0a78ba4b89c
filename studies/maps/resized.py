"""Map of the best design over latitude and season: the aircraft is sized anew in every cell."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.day.light import SolarModel
from sizing.program.objectives import Objective, SizingStatus
from sizing.validity.extrapolations import with_worth
from sizing.validity.own_models import check_own_models
from sizing.validity.ranges import Extrapolation
from solar.names import CorrectionName, ModelName
from studies.engine.run import compute
from studies.engine.workers import Cell, Job
from studies.grid import Grid, GridStudy, MapConfiguration, cell_time_s, chunks_of
from studies.output.gridded import (
    BLANKS,
    DESCRIBED,
    SIZED,
    attributes,
    can_be_result,
    resize_objective,
    told_of_cells,
)
from studies.output.sized_columns import sized_cells, sized_flight

if TYPE_CHECKING:
    import xarray as xr

_SIZING_S = 4.5e-3  # of a cell, roughly


def resized_map(
    aircraft: Aircraft,
    mission: Mission,
    objective: str | Objective,
    *,
    latitudes: ArrayLike | None = None,
    days: ArrayLike | None = None,
    required_excess_time_h: float | None = None,
    model: ModelName = "CAM",
    correction: CorrectionName = "none",
    workers: int | None = 1,
    scheduler: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Best design in every cell of latitude and day.

    Parameters
    ----------
    aircraft : Aircraft
        Parametric aircraft whose design variables are chosen.
    mission : Mission
        In which air and with which payload; its own latitudes and dates play no part.
    objective : str or Objective
        ``min_wingspan``, ``min_mass``, ``max_excess_time``, ``max_payload_mass`` or
        ``max_payload_power``.
    latitudes : array_like, optional
        Latitudes [deg], north positive, ascending; by default each second degree from 70 south to
        70 north.
    days : array_like, optional
        Days of year from 1 to 365, or dates (``["06-21"]``, a ``DatetimeIndex``), ascending; by
        default each fourth.
    required_excess_time_h : float, optional
        Excess time that every design must have [h]; by default the mission's.
    model : {"CAM", "CDM", "VM", "FM"}, optional
        Solar power model.
    correction : {"none", "report", "loiter"}, optional
        Correction of the model's systematic error.
    workers : int or None, optional
        Processes that compute: 1 starts none, None as many as there are cores where that pays. The
        result is the same to the last bit. A script that starts workers needs
        ``if __name__ == "__main__":``.
    scheduler : str, optional
        Dask's scheduler that computes instead, ``tcp://HOST:PORT`` with its own workers, or
        ``local-cluster`` with ``workers`` of this machine.
    progress : callable, optional
        Called with the cells done and the cells in all.

    Returns
    -------
    xarray.Dataset
        On the dimensions ``latitude`` and ``day``, with CF attributes. Numbers of cells without a
        design are NaN; ``status`` (:class:`sizing.program.objectives.SizingStatus`),
        ``violated_requirement`` and ``message`` tell why. Cells that could not be computed have
        the status ``failed``; the attribute ``failed_cells`` lists them, and a warning counts them.

    Raises
    ------
    ValueError
        If a name or a number is out of what is allowed, or the aircraft is measured.
    ComputationError
        If every cell failed.
    """
    if required_excess_time_h is not None:
        if not 0.0 <= required_excess_time_h < math.inf:
            raise ValueError(f"required_excess_time_h must be >= 0 (got {required_excess_time_h})")
        mission = mission.model_copy(
            update={"required_excess_time_h": float(required_excess_time_h)}
        )
    solar = SolarModel(model, correction)
    study = prepare(aircraft, mission, objective, latitudes, days, solar)
    return study.dataset(compute(study.job, workers, progress, scheduler=scheduler))


def prepare(
    aircraft: Aircraft,
    mission: Mission,
    objective: str | Objective,
    latitudes: ArrayLike | None,
    days: ArrayLike | None,
    solar: SolarModel,
) -> GridStudy:
    """Check a map and divide it into chunks."""
    goal = resize_objective(objective)
    if isinstance(aircraft.airframe, MeasuredAirframe):
        raise ValueError(f"sizing needs a parametric aircraft, {aircraft.name} is measured")
    check_own_models(aircraft, mission)
    grid = Grid.of(latitudes, days, slow=True)
    grid.check_winds(mission)
    numbers = grid.chunks(_SIZING_S + cell_time_s(aircraft, mission, solar))
    configuration = MapConfiguration(aircraft, mission, solar, objective=goal)
    chunks, possible = chunks_of(grid.cells(), numbers), can_be_result(SizingStatus, SIZED)
    return GridStudy(
        Job(_resized_chunk, configuration, chunks, BLANKS, possible),
        np.concatenate(numbers),
        grid.coordinates(),
        DESCRIBED,
        SizingStatus,
        {
            **attributes(f"Best designs of {aircraft.name}", aircraft, mission, solar),
            "objective": goal.value,
            "required_excess_time_h": mission.required_excess_time_h,
        },
        lambda columns: _extrapolations_of_designs(configuration, grid, columns),
    )


def _extrapolations_of_designs(
    configuration: MapConfiguration, grid: Grid, columns: Mapping[str, NDArray[Any]]
) -> tuple[Extrapolation, ...]:
    """What the designs of all cells take from outside, its worth that of the lightest one."""
    goal = configuration.objective
    assert goal is not None
    mass_kg = np.where(np.isin(columns["status"], SIZED), columns["total_mass"], np.inf)
    row, column = np.unravel_index(int(np.argmin(mass_kg)), mass_kg.shape)
    cell = (float(grid.latitudes_deg[row]), int(grid.days[column]))
    return with_worth(
        told_of_cells(columns, SIZED, "cells"),
        configuration.aircraft,
        lambda: sized_flight(
            configuration.aircraft, configuration.mission, cell, goal, configuration.solar
        ),
    )


def _resized_chunk(configuration: MapConfiguration, cells: Sequence[Cell]) -> dict[str, Any]:
    """Best designs of some cells."""
    assert configuration.objective is not None
    return sized_cells(
        configuration.aircraft,
        configuration.mission,
        cells,
        configuration.objective,
        configuration.solar,
    )
