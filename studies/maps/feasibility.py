"""Map of a fixed aircraft over latitude and season: where and when it can fly perpetually."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from missions.dates import month_and_day
from missions.files.errors import InputError
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel, solar_day
from sizing.day.metrics import (
    CYCLE_ENDS,
    ENDS,
    FLOWN,
    Status,
)
from sizing.day.module_power import path_troubles
from sizing.mass_budget import design_of
from sizing.performance import Performance, performance
from sizing.results.quantities import ENDURANCE, MAP, MAXIMUM_ALTITUDE
from sizing.validity.checks import (
    at_highest,
    charge_rate_check,
    charge_rate_is_open,
    correction_check,
    design_checks,
    wind_check,
)
from sizing.validity.extrapolations import told, with_worth
from sizing.validity.own_models import check_own_models
from sizing.validity.ranges import Check, Extrapolation
from solar.names import CorrectionName, ModelName
from solar.types import FloatArray
from studies.engine.run import compute
from studies.engine.workers import Cell, Job
from studies.grid import Grid, GridStudy, MapConfiguration, cell_time_s, chunks_of
from studies.output.gridded import OnGrid, attributes, can_be_result

if TYPE_CHECKING:
    import xarray as xr

# Cells simulated at once: their arrays over one day take some 20 MB each.
_CELLS_AT_ONCE = 8192
_CLIMBING_AT_ONCE = 1024  # as many as are marched at once; with their light at all levels
_ENDURANCE_S = 2e-4  # of a cell, roughly
_CLIMB_S = 5e-2  # of the program of a day


# Variable -> unit, long name.
_DESCRIBED = {one.variable: one.described for one in MAP}
_ENDURANCE = {ENDURANCE.variable: ENDURANCE.described}
_CHARGE_RATE = {"charge_rate": ("1/h", "fastest charge that the day's sun offers the battery")}
_WIND = {"wind": ("m s-1", "wind speed, at the mission's percentile")}
_HIGHEST = {MAXIMUM_ALTITUDE.variable: MAXIMUM_ALTITUDE.described}
_STATUS = {"status": ("1", "how the repeated day ends")}


def feasibility_map(
    aircraft: Aircraft,
    mission: Mission,
    *,
    latitudes: ArrayLike | None = None,
    days: ArrayLike | None = None,
    model: ModelName = "CAM",
    correction: CorrectionName = "none",
    endurance: bool = False,
    workers: int | None = 1,
    scheduler: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Metrics of the repeated day in every cell of latitude and day.

    Parameters
    ----------
    aircraft : Aircraft
        What flies.
    mission : Mission
        In which air and with which load; its own latitudes and dates play no part.
    latitudes : array_like, optional
        Latitudes [deg], north positive, ascending; by default from 70 south to 70 north, each
        degree, or each second one where a cell takes milliseconds.
    days : array_like, optional
        Days of year from 1 to 365, or dates (``["06-21"]``, a ``DatetimeIndex``), ascending; by
        default each, or each fourth one where a cell takes milliseconds.
    model : {"CAM", "CDM", "VM", "FM"}, optional
        Solar power model.
    correction : {"none", "report", "loiter"}, optional
        Correction of the model's systematic error.
    endurance : bool, optional
        Also search the longest flight of every cell that is not perpetual (some twenty times the
        work of a cell's other metrics).
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
        On the dimensions ``latitude`` and ``day``, with CF attributes. Undefined values are NaN,
        and ``status`` (:class:`~sizing.day.metrics.Status`) tells why. Cells that could not be
        computed have the status ``failed``; the attribute ``failed_cells`` lists them, and a
        warning counts them.

    Raises
    ------
    ValueError
        If a name or a number is out of what is allowed.
    ComputationError
        If every cell failed.
    """
    study = prepare(aircraft, mission, latitudes, days, SolarModel(model, correction), endurance)
    return study.dataset(compute(study.job, workers, progress, scheduler=scheduler))


def prepare(
    aircraft: Aircraft,
    mission: Mission,
    latitudes: ArrayLike | None,
    days: ArrayLike | None,
    solar: SolarModel,
    endurance: bool = False,
) -> GridStudy:
    """Check a map and divide it into chunks."""
    check_own_models(aircraft, mission)
    climbs = mission.climb is not None
    grid = Grid.of(latitudes, days, slow=solar.needs_path or endurance or climbs)
    if solar.needs_path or mission.holds_station:
        grid.check_winds(mission)
    cell_s = cell_time_s(aircraft, mission, solar) + (_ENDURANCE_S if endurance else 0.0)
    cell_s += _CLIMB_S if climbs else 0.0
    described = _DESCRIBED | (_ENDURANCE if endurance else {})
    described |= _HIGHEST if climbs else {}
    described |= _CHARGE_RATE if charge_rate_is_open(aircraft) else {}
    described |= {} if mission.wind_statistics is None else _WIND
    blanks: dict[str, Any] = dict.fromkeys(described, np.float64("nan"))
    blanks["status"] = np.int8(Status.failed)
    configuration = MapConfiguration(aircraft, mission, solar, endurance)
    numbers = grid.chunks(cell_s)
    windy = solar.needs_path and mission.wind_statistics is not None
    ends = ENDS if mission.flight is not None else CYCLE_ENDS
    ends = (*ends, Status.infeasible) if windy else ends
    chunks, possible = chunks_of(grid.cells(), numbers), can_be_result(ends, ENDS)
    return GridStudy(
        Job(_map_chunk, configuration, chunks, blanks, possible),
        np.concatenate(numbers),
        grid.coordinates(),
        described | _STATUS,
        (Status.failed, *ends),
        attributes(f"Feasibility of {aircraft.name}", aircraft, mission, solar),
        lambda columns: _extrapolations_of_map(configuration, grid, columns),
    )


def _extrapolations_of_map(
    configuration: MapConfiguration, grid: Grid, columns: Mapping[str, NDArray[Any]]
) -> tuple[Extrapolation, ...]:
    """What the map takes from outside the range of a model: one design in all cells."""
    known = np.isin(columns["status"], ENDS)
    if not known.any():
        return ()
    aircraft, mission, solar = configuration.aircraft, configuration.mission, configuration.solar
    latitude, day = np.meshgrid(grid.latitudes_deg, grid.days, indexing="ij")
    design, calm, in_wind = design_of(aircraft, mission), mission, []
    if "wind" in columns:  # of each cell; that of the mission's own latitudes plays no part
        calm, winds = mission.in_wind(0.0), columns["wind"][known]
        in_wind = [] if mission.holds_station else list(wind_check(design, winds))
    of_design = list(design_checks(aircraft, calm, design, solar))
    if MAXIMUM_ALTITUDE.variable in columns:
        highest_m = columns[MAXIMUM_ALTITUDE.variable][known]
        of_design = at_highest(of_design, aircraft, calm, solar, highest_m)
    cells = Scenarios(latitude[known], day[known])
    checks = [*in_wind, *of_design, *correction_check(cells, solar, mission)]
    if "charge_rate" in columns:
        checks.append(Check.of("charge_rate_per_h", "battery", columns["charge_rate"][known]))
    extrapolations = told(checks, of=int(known.sum()), what="cells")
    excess_h = np.where(np.isfinite(columns["excess_time"]), columns["excess_time"], -np.inf)
    best = np.unravel_index(int(np.argmax(excess_h)), excess_h.shape)
    cell = Scenarios(latitude[best][np.newaxis], day[best][np.newaxis])
    return with_worth(extrapolations, aircraft, lambda: _fly(configuration, cell))


def _map_chunk(configuration: MapConfiguration, cells: Sequence[Cell]) -> dict[str, Any]:
    """Metrics of a rectangle of cells."""
    block = map_block(
        configuration.aircraft,
        configuration.mission,
        list(dict.fromkeys(cell[0] for cell in cells)),
        list(dict.fromkeys(int(cell[1]) for cell in cells)),
        configuration.solar,
        configuration.endurance,
    )
    return {name: values.ravel() for name, values in block.items()}


def map_block(
    aircraft: Aircraft,
    mission: Mission,
    latitudes_deg: ArrayLike,
    days: ArrayLike,
    solar: SolarModel,
    endurance: bool = False,
) -> dict[str, NDArray[Any]]:
    """Metrics of the cells of some latitudes, as plain arrays.

    A cell does not depend on the others to its last digit: maps may be computed in parts of any
    size and put together.

    ``aircraft``, ``mission``, ``solar``: what flies, in which air, with which load, and by which
    solar power model. Returns the variables of :func:`feasibility_map`.
    """
    grid = np.meshgrid(np.asarray(latitudes_deg, float), np.asarray(days, int), indexing="ij")
    latitude, day = (v.ravel() for v in grid)
    configuration = MapConfiguration(aircraft, mission, solar, endurance)
    parts: list[dict[str, NDArray[Any]]] = []
    at_once = _CELLS_AT_ONCE if mission.climb is None else _CLIMBING_AT_ONCE
    for start in range(0, len(latitude), at_once):
        some = slice(start, start + at_once)
        parts.append(_cells(configuration, Scenarios(latitude[some], day[some])))
    shape = grid[0].shape
    return {name: np.concatenate([p[name] for p in parts]).reshape(shape) for name in parts[0]}


def _cells(configuration: MapConfiguration, cells: Scenarios) -> dict[str, NDArray[Any]]:
    """Metrics of cells; none where the wind is too strong for a path that the model needs."""
    mission = configuration.mission
    if not configuration.solar.needs_path:
        return _flown_cells(configuration, cells)
    troubles = path_troubles(configuration.aircraft, mission, cells)
    able = np.array([trouble is None for trouble in troubles])
    if able.all():
        return _flown_cells(configuration, cells)
    some = Scenarios(cells.latitude_deg[able], cells.day_of_year[able])
    if len(some):
        flown = _flown_cells(configuration, some)
    else:  # any flight, for the names of its columns
        one = Scenarios(cells.latitude_deg[:1], cells.day_of_year[:1])
        still = _flown_cells(replace(configuration, mission=mission.in_wind(0.0)), one)
        flown = {name: values[:0] for name, values in still.items()}
    columns: dict[str, NDArray[Any]] = {}
    for name, values in flown.items():
        columns[name] = np.full(len(cells), np.nan)
        columns[name][able] = values
    columns["wind"] = _known_winds(mission, cells)
    columns["status"] = np.full(len(cells), Status.infeasible, np.int8)
    columns["status"][able] = flown["status"]
    return columns


def _flown_cells(configuration: MapConfiguration, cells: Scenarios) -> dict[str, NDArray[Any]]:
    mission, flight = configuration.mission, _fly(configuration, cells)
    quantities = [*MAP, *([ENDURANCE] if configuration.endurance else [])]
    if mission.climb is not None:
        quantities.append(MAXIMUM_ALTITUDE)
    columns: dict[str, NDArray[Any]] = {
        **{one.variable: one.of(flight) for one in quantities},
        "status": flight.cycle.status.astype(np.int8),
    }
    if mission.wind_statistics is not None:
        columns["wind"] = _known_winds(mission, cells)
    most_w = flight.solar_power_w.max(axis=-1)
    for check in charge_rate_check(configuration.aircraft, mission, flight.design, most_w):
        columns["charge_rate"] = check.value
    return columns


def _fly(configuration: MapConfiguration, cells: Scenarios) -> Performance:
    aircraft, mission, solar = configuration.aircraft, configuration.mission, configuration.solar
    design = design_of(aircraft, mission)
    sunlit = solar_day(aircraft, mission, solar, scenarios=cells, design=design)
    return performance(aircraft, mission, solar, day=sunlit, keep_trajectory=False, design=design)


def _known_winds(mission: Mission, cells: Scenarios) -> FloatArray:
    """Wind of each cell [m/s]; NaN where the table of winds ends, as it changes nothing else."""
    try:
        return mission.scenario_winds_m_per_s(cells)
    except InputError:
        months = [month_and_day(int(day))[0] for day in cells.day_of_year]
    pairs = np.column_stack([cells.latitude_deg, months])
    _, first, place = np.unique(pairs, axis=0, return_index=True, return_inverse=True)
    winds = np.full(len(first), np.nan)
    for number, i in enumerate(first.tolist()):
        one = Scenarios(cells.latitude_deg[i : i + 1], cells.day_of_year[i : i + 1])
        with suppress(InputError):
            winds[number] = mission.scenario_winds_m_per_s(one)[0]
    return winds[place.ravel()]


def season_length(data: xr.Dataset) -> xr.DataArray:
    """Number of the map's days on which each latitude is flown perpetually, or to a landing."""
    return data["status"].isin(FLOWN).sum("day")


def perpetual_cells(data: OnGrid) -> NDArray[np.bool_]:
    """Mark the cells of a map that are flown perpetually, or to a landing: ``(latitude, day)``."""
    return np.isin(data["status"].to_numpy(), FLOWN)
