"""Map of a fixed aircraft over latitude and season: where and when it flies for ever."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from missions.dates import MONTH_NAMES, date_label
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.energy.cycle import Status
from sizing.performance import Performance, performance
from sizing.sunlight import SolarModel, solar_day
from solar._version import __version__

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from solar.types import FloatArray

# Cells simulated at once: their arrays over one day take some 20 MB each.
_CELLS_AT_ONCE = 8192

FAILED = -1  # status of a cell that could not be computed

# Variable -> unit, long name.
VARIABLES = {
    "excess_time": ("h", "excess time; infinite where solar power always exceeds the load"),
    "minimum_state_of_charge": ("1", "minimum state of charge of the repeated day"),
    "charge_margin": ("h", "time from first full charge to last instant of full charge"),
    "equal_power_morning": ("h", "solar time at which solar power first equals the load"),
    "equal_power_evening": ("h", "solar time at which solar power last equals the load"),
    "full_charge": ("h", "solar time of the first full charge"),
    "solar_energy": ("Wh", "electric energy of the modules over the day"),
    "load_energy": ("Wh", "energy drawn over the day"),
    "day_length": ("h", "time from sunrise to sunset"),
}


def feasibility_map(
    aircraft: Aircraft,
    mission: Mission,
    latitudes_deg: ArrayLike,
    days: ArrayLike,
    solar: SolarModel,
    *,
    endurance: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Metrics of the repeated day in every cell of latitude and day.

    Parameters
    ----------
    aircraft, mission, solar
        What flies, in which air, with which load; the mission's own latitudes and dates play no
        part.
    latitudes_deg, days : array_like
        Latitudes [deg] and days of year.
    endurance : bool
        Also search the longest flight of every cell that is not perpetual (some twenty times the
        work of a cell's other metrics).
    progress : callable, optional
        Called with the cells done and the cells in all.

    Returns
    -------
    xarray.Dataset
        On the dimensions ``latitude`` and ``day``, with CF attributes; undefined values are NaN,
        and ``status`` tells why.
    """
    columns = map_block(aircraft, mission, latitudes_deg, days, solar, endurance, progress=progress)
    return map_dataset(aircraft, mission, solar, latitudes_deg, days, columns)


def map_block(
    aircraft: Aircraft,
    mission: Mission,
    latitudes_deg: ArrayLike,
    days: ArrayLike,
    solar: SolarModel,
    endurance: bool = False,
    *,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, NDArray[Any]]:
    """Metrics of the cells of some latitudes, arrays of shape ``(latitude, day)``.

    A cell does not depend on the others to its last digit: maps may be computed in parts of any
    size, by other processes too, and put together. Parameters are those of
    :func:`feasibility_map`; the keys are its variables.
    """
    grid = np.meshgrid(np.asarray(latitudes_deg, float), np.asarray(days, int), indexing="ij")
    latitude, day = (v.ravel() for v in grid)
    parts: list[dict[str, NDArray[Any]]] = []
    for start in range(0, len(latitude), _CELLS_AT_ONCE):
        some = slice(start, start + _CELLS_AT_ONCE)
        parts.append(
            _cells(aircraft, mission, Scenarios(latitude[some], day[some]), solar, endurance)
        )
        if progress is not None:
            progress(min(some.stop, len(latitude)), len(latitude))
    shape = grid[0].shape
    return {name: np.concatenate([p[name] for p in parts]).reshape(shape) for name in parts[0]}


def _cells(
    aircraft: Aircraft, mission: Mission, cells: Scenarios, solar: SolarModel, endurance: bool
) -> dict[str, NDArray[Any]]:
    lit = solar_day(aircraft, mission, solar, scenarios=cells)
    found = performance(aircraft, mission, solar, day=lit, keep_trajectory=False)
    columns: dict[str, NDArray[Any]] = dict(_metrics(found))
    columns["status"] = found.cycle.status.astype(np.int8)
    if endurance:
        columns["endurance"] = found.endurance_h()
    return columns


def _metrics(perf: Performance) -> dict[str, FloatArray]:
    cycle = perf.cycle
    return {
        "excess_time": cycle.excess_time_h,
        "minimum_state_of_charge": cycle.minimum_state_of_charge,
        "charge_margin": cycle.charge_margin_h,
        "equal_power_morning": cycle.equal_power_morning_h,
        "equal_power_evening": cycle.equal_power_evening_h,
        "full_charge": cycle.full_charge_h,
        "solar_energy": cycle.energy_budget.solar_wh,
        "load_energy": cycle.energy_budget.load_wh,
        "day_length": perf.day.sunset_h - perf.day.sunrise_h,
    }


def map_dataset(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel,
    latitudes_deg: ArrayLike,
    days: ArrayLike,
    columns: dict[str, NDArray[Any]],
) -> xr.Dataset:
    """Map of what :func:`map_block` found, in one block or in many that are put together.

    Cells that failed have a flag of their own.
    """
    import xarray as xr

    described = VARIABLES | {
        "endurance": ("h", "longest flight over all launch times; infinite where perpetual")
    }
    dims = ("latitude", "day")
    variables: dict[str, Any] = {
        name: (dims, values, {"units": described[name][0], "long_name": described[name][1]})
        for name, values in columns.items()
        if name != "status"
    }
    failed = [("failed", FAILED)] if np.any(columns["status"] == FAILED) else []
    flags = failed + [(s.name, s.value) for s in Status]
    variables["status"] = (
        dims,
        columns["status"],
        {
            "long_name": "how the repeated day ends",
            "flag_values": np.array([value for _, value in flags], np.int8),
            "flag_meanings": " ".join(name for name, _ in flags),
        },
    )
    return xr.Dataset(
        variables,
        coords=coordinates(latitudes_deg, days),
        attrs={
            "Conventions": "CF-1.11",
            "title": f"Feasibility of {aircraft.name}",
            "source": f"solar-uav {__version__}",
            "solar_model": solar.model,
            "correction": solar.correction,
            "aircraft": aircraft.model_dump_json(),
            "mission": mission.model_dump_json(),
        },
    )


def to_netcdf_bytes(data: xr.Dataset) -> bytes:
    """NetCDF-4 file of a map."""
    import tempfile
    from pathlib import Path

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map.nc"
        data.to_netcdf(path, engine="h5netcdf")
        return path.read_bytes()


def season_length(data: xr.Dataset) -> xr.DataArray:
    """Days of the map's days on which each latitude is flown perpetually."""
    perpetual = data["status"].isin([Status.perpetual, Status.always_lit])
    return perpetual.sum("day")


def map_figure(data: xr.Dataset) -> Figure:
    """Excess time over season and latitude, with the edge of perpetual flight drawn as a line.

    Cells are drawn as they are: nothing is smoothed or filled in between.
    """
    from matplotlib.colors import BoundaryNorm

    from studies.output.cells import cell_edges
    from studies.output.plots import correction_label, new_figure

    corrected = correction_label(data.attrs["correction"])
    figure, (axes,) = new_figure(
        title=f"{data.attrs['title']} ({data.attrs['solar_model']}, {corrected}); "
        "line: edge of perpetual flight",
        size_in=(8.5, 5.2),
        grid="",
    )
    days, latitudes = data["day"].to_numpy(), data["latitude"].to_numpy()
    excess = data["excess_time"].to_numpy()
    top = np.nanmax(np.where(np.isfinite(excess), excess, np.nan), initial=1.0)
    shown = np.where(np.isposinf(excess), 2.0 * top, excess)
    levels = _levels(top)
    norm = BoundaryNorm(levels, ncolors=256, extend="both")
    edges = cell_edges(days), cell_edges(latitudes)
    mesh = axes.pcolormesh(*edges, shown, cmap="PuOr", norm=norm)
    bar = figure.colorbar(mesh, ax=axes, ticks=levels)
    bar.set_label("excess time [h]; beyond the top: no night")
    if min(excess.shape) > 1 and np.any(shown > 0.0) and np.any(shown <= 0.0):
        axes.contour(days, latitudes, np.where(shown > 0.0, 1.0, 0.0), [0.5], colors="black")
    season_axes(axes, days)
    return figure


_LEVELS = 6  # on either side of zero


def _levels(top: float) -> FloatArray:
    """Symmetric levels around zero, so that white is where perpetual flight begins."""
    steps = (0.5, 1.0, 2.0, 3.0, 4.0)
    step = next((s for s in steps if top <= _LEVELS * s), float(np.ceil(top / _LEVELS)))
    return step * np.arange(-_LEVELS, _LEVELS + 1.0)


def coordinates(latitudes_deg: ArrayLike, days: ArrayLike) -> dict[str, Any]:
    """Coordinates of a map, with CF attributes."""
    degrees = {"units": "degrees_north", "standard_name": "latitude"}
    return {
        "latitude": ("latitude", np.asarray(latitudes_deg, float), degrees),
        "day": ("day", np.asarray(days, int), {"long_name": "day of year", "units": "1"}),
    }


_DATES = 6  # along an axis of less than two months


def season_axes(axes: Axes, days: FloatArray) -> None:
    """Months along the axis of days, and the name of the other one."""
    starts = np.cumsum([0, 31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30]) + 1
    if np.count_nonzero((days.min() <= starts) & (starts <= days.max())) > 1:
        axes.set_xticks(starts, MONTH_NAMES, ha="left")
        axes.set_xlim(days.min(), days.max())
    else:
        shown = np.unique(np.linspace(days.min(), days.max(), _DATES).round().astype(int))
        axes.set_xticks(shown, [date_label(int(day)) for day in shown])
    lowest, highest = axes.get_ylim()
    axes.set(ylabel="latitude [deg]", ylim=(max(lowest, -90.0), min(highest, 90.0)))
