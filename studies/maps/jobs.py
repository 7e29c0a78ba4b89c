"""Maps over latitude and season as jobs of the engine: of a fixed aircraft, or sized in each cell.

A chunk is a rectangle of latitudes and days.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.optimisation.objectives import Objective
from sizing.sunlight import SolarModel
from solar._version import __version__
from solar.names import ATTITUDE_MODELS
from studies.engine.run import Cell, Job, Outcome, pieces
from studies.maps import feasibility as feasibility_map
from studies.output import columns as sizing_columns
from studies.output.columns import SizingStatus

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from solar.types import FloatArray

# Time of a cell [s], roughly: it decides the size of a chunk and nothing else. A chunk must not
# depend on the workers, or results would.
_CHUNK_S = 0.5
_CELL_S, _CELL_ON_PATH_S, _CELL_ENDURANCE_S, _CELL_SIZING_S = 2.5e-5, 1e-2, 2e-4, 8e-3


@dataclass(frozen=True)
class MapConfiguration:
    """A map of a fixed aircraft."""

    aircraft: Aircraft
    mission: Mission
    solar: SolarModel
    endurance: bool = False


@dataclass(frozen=True)
class SizedMapConfiguration:
    """A map of the best design in each cell."""

    aircraft: Aircraft
    mission: Mission
    solar: SolarModel
    objective: Objective


def map_job(configuration: MapConfiguration, latitudes_deg: FloatArray, days: FloatArray) -> Job:
    """Job of a map of a fixed aircraft; :func:`map_dataset` reads its outcome."""
    cell_s = _solar_s(configuration.solar)
    cell_s += _CELL_ENDURANCE_S if configuration.endurance else 0.0
    names = [*feasibility_map.VARIABLES, *(["endurance"] if configuration.endurance else [])]
    blanks: dict[str, Any] = dict.fromkeys(names, np.float64("nan"))
    blanks["status"] = np.int8(feasibility_map.FAILED)
    chunks = rectangles(latitudes_deg, days, cell_s)
    return Job(map_chunk, configuration, chunks, blanks)


def sized_map_job(
    configuration: SizedMapConfiguration, latitudes_deg: FloatArray, days: FloatArray
) -> Job:
    """Job of a map of best designs; :func:`sized_map_dataset` reads its outcome."""
    cell_s = _CELL_SIZING_S + _solar_s(configuration.solar)
    chunks = rectangles(latitudes_deg, days, cell_s)
    return Job(sized_map_chunk, configuration, chunks, sizing_columns.BLANKS)


def _solar_s(solar: SolarModel) -> float:
    on_path = solar.model in ATTITUDE_MODELS or solar.correction == "loiter"
    return _CELL_ON_PATH_S if on_path else _CELL_S


def rectangles(
    latitudes_deg: FloatArray, days: FloatArray, cell_s: float
) -> tuple[tuple[Cell, ...], ...]:
    """Cells of latitude and day in chunks: whole rows of latitude where a row is short enough."""
    cells = max(round(_CHUNK_S / cell_s), 1)
    rows = pieces(len(latitudes_deg), cells // len(days))
    columns = pieces(len(days), cells)
    return tuple(
        tuple((float(lat), float(day)) for lat in latitudes_deg[row] for day in days[column])
        for row in rows
        for column in columns
    )


def map_chunk(configuration: MapConfiguration, cells: Sequence[Cell]) -> dict[str, Any]:
    """Metrics of a rectangle of cells."""
    latitudes = np.array(list(dict.fromkeys(cell[0] for cell in cells)))
    days = np.array(list(dict.fromkeys(int(cell[1]) for cell in cells)))
    found = feasibility_map.map_block(
        configuration.aircraft,
        configuration.mission,
        latitudes,
        days,
        configuration.solar,
        configuration.endurance,
    )
    return {name: values.ravel() for name, values in found.items()}


def sized_map_chunk(configuration: SizedMapConfiguration, cells: Sequence[Cell]) -> dict[str, Any]:
    """Best designs of some cells."""
    return sizing_columns.size_cells(
        configuration.aircraft,
        configuration.mission,
        cells,
        configuration.objective,
        configuration.solar,
    )


# ---- Results


def _on_grid(job: Job, outcome: Outcome, latitudes_deg: FloatArray, days: FloatArray) -> Any:
    """Columns of an outcome, laid out over latitude and day."""
    cells = [cell for chunk in job.chunks for cell in chunk]
    row = {float(lat): i for i, lat in enumerate(latitudes_deg)}
    column = {float(day): j for j, day in enumerate(days)}
    place = np.array([row[lat] * len(days) + column[day] for lat, day in cells])
    order = np.argsort(place)
    shape = (len(latitudes_deg), len(days))
    return {name: values[order].reshape(shape) for name, values in outcome.columns.items()}


def _failed_cells(job: Job, outcome: Outcome) -> dict[str, str]:
    """Attribute that says which cells failed, and why; none where none did."""
    if not outcome.failures:
        return {}
    cells = [cell for chunk in job.chunks for cell in chunk]
    lines = [
        f"latitude {cells[i][0]:g}, day {cells[i][1]:g}: {text}"
        for i, text in sorted(outcome.failures.items())
    ]
    return {"failed_cells": "\n".join(lines)}


def map_dataset(
    job: Job, outcome: Outcome, latitudes_deg: FloatArray, days: FloatArray
) -> xr.Dataset:
    """Map of a fixed aircraft, as :func:`studies.maps.feasibility.feasibility_map` returns it."""
    asked: MapConfiguration = job.configuration
    columns = _on_grid(job, outcome, latitudes_deg, days)
    data = feasibility_map.map_dataset(
        asked.aircraft, asked.mission, asked.solar, latitudes_deg, days, columns
    )
    return data.assign_attrs(_failed_cells(job, outcome))


def sized_map_dataset(
    job: Job, outcome: Outcome, latitudes_deg: FloatArray, days: FloatArray
) -> xr.Dataset:
    """Best designs over latitude and day, with CF attributes; ``status`` tells why one is NaN."""
    import xarray as xr

    asked: SizedMapConfiguration = job.configuration
    columns = _on_grid(job, outcome, latitudes_deg, days)
    dims = ("latitude", "day")
    variables = {
        name: (dims, columns[name], {"units": unit, "long_name": text})
        for name, (unit, text) in sizing_columns.DESCRIBED.items()
    }
    data = xr.Dataset(
        variables
        | {"status": (dims, columns["status"], sizing_columns.flag_attributes(SizingStatus))},
        coords=feasibility_map.coordinates(latitudes_deg, days),
        attrs={
            "Conventions": "CF-1.11",
            "title": f"Best designs of {asked.aircraft.name}",
            "source": f"solar-uav {__version__}",
            "objective": asked.objective.value,
            "required_excess_time_h": asked.mission.required_excess_time_h,
            "solar_model": asked.solar.model,
            "correction": asked.solar.correction,
            "aircraft": asked.aircraft.model_dump_json(),
            "mission": asked.mission.model_dump_json(),
        },
    )
    return data.assign_attrs(_failed_cells(job, outcome))


# Objective -> variable that is drawn.
_SHOWN = {
    "max_excess_time": "excess_time",
    "min_wingspan": "wingspan",
    "min_mass": "total_mass",
    "max_payload_mass": "payload_mass",
    "max_payload_power": "payload_power",
}


HATCHES = {
    SizingStatus.infeasible: "///",
    SizingStatus.not_converged: "xx",
    SizingStatus.failed: "..",
    SizingStatus.invalid: "..",
}


def sized_map_figure(data: xr.Dataset) -> Figure:
    """Objective of the best design over season and latitude; cells without one are hatched.

    Cells are drawn as they are: nothing is smoothed or filled in between. Lines lead from cell to
    cell where both have a design.
    """
    from studies.output.cells import (
        draw_cells,
        draw_colour_bar,
        draw_level_lines,
        finite_range,
        hatch_cells,
    )
    from studies.output.plots import correction_label, new_figure

    name = _SHOWN.get(data.attrs["objective"], "wingspan")
    corrected = correction_label(data.attrs["correction"])
    figure, (axes,) = new_figure(
        title=f"{data.attrs['title']}: {data.attrs['objective']} "
        f"({data.attrs['solar_model']}, {corrected})",
        size_in=(8.5, 5.2),
        grid="",
    )
    days, latitudes = data["day"].to_numpy(), data["latitude"].to_numpy()
    optimal = np.isin(data["status"].to_numpy(), sizing_columns.SIZED)
    values = np.where(optimal, data[name].to_numpy(), np.nan)
    norm = finite_range(values)
    draw_colour_bar(
        figure,
        draw_cells(axes, days, latitudes, values, norm),
        axes,
        f"{data[name].long_name} [{data[name].units}]",
        unlimited=bool(np.isposinf(values).any()),
    )
    draw_level_lines(axes, days, latitudes, values, norm, at_most=5)
    names = {status: status.name for status in HATCHES}
    handles = hatch_cells(axes, days, latitudes, data["status"].to_numpy(), HATCHES, names)
    if handles:
        figure.legend(handles=handles, loc="outside lower right", ncols=3)
    feasibility_map.season_axes(axes, days)
    return figure
