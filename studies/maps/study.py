"""Maps over latitude and season: of a fixed aircraft, or sized anew in every cell."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from enum import IntEnum
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from missions.dates import DAYS_PER_YEAR, days_of_year, month_and_day
from missions.files.errors import InputError
from missions.files.overrides import with_values
from missions.flight_path import largest_wind_m_per_s
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.day.light import SolarModel, solar_day
from sizing.day.metrics import CYCLE_ENDS, ENDS, SUFFICIENT, Status
from sizing.day.module_power import on_path
from sizing.design import DesignVariables
from sizing.mass_budget import design_of, parametric_design
from sizing.performance import Performance, performance, performance_of_designs
from sizing.program.objectives import Objective, SizingStatus
from sizing.validity import checks as validity
from sizing.validity.checks import charge_rate_is_open, check_user_models
from sizing.validity.extrapolations import add_effects, cell_texts, collect_extrapolations
from sizing.validity.ranges import Check, Extrapolation
from solar.names import ATTITUDE_MODELS, CorrectionName, ModelName
from solar.schema import spell
from solar.types import FloatArray
from studies.engine.run import Study, merged
from studies.output import gridded
from studies.quantities import (
    DESIGN_COLUMNS,
    ENDURANCE,
    LOAD,
    MAP,
    MAXIMUM_ALTITUDE,
    REACHED,
    described,
)

if TYPE_CHECKING:
    import xarray as xr

# Default grids of fast maps, and of maps whose cells take milliseconds.
LATITUDES_DEG, DAYS = np.arange(-70.0, 71.0), np.arange(1, 366)
SLOW_LATITUDES_DEG, SLOW_DAYS = LATITUDES_DEG[::2], DAYS[::4]

# Rough time of a cell [s], and additions to it.
_CELL_S, _CELL_ON_PATH_S = 2.5e-5, 1e-2
_ENDURANCE_S = 2e-4
_CLIMB_S = 5e-2  # of the program of a day
_SIZING_S = 2e-2
_SIZED_TOGETHER = 96  # each starts from its neighbours, and all fly in one batch

# Variable -> unit, long name.
_DESCRIBED = {quantity.variable: quantity.described for quantity in MAP}

# Aircraft, mission, model and objective of all cells.
Sized: TypeAlias = tuple[Aircraft, Mission, SolarModel, Objective]


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
    """Compute metrics of the repeated day in every cell of latitude and day.

    Parameters
    ----------
    aircraft : Aircraft
        Fixed aircraft.
    mission : Mission
        Air, load and flight; its latitudes and dates are ignored.
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
    solar = SolarModel(model, correction)
    study = prepare(aircraft, mission, latitudes, days, solar, endurance=endurance)
    return study.computed(workers, scheduler, progress).to_xarray()


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
    """Compute the best design in every cell of latitude and day.

    Parameters
    ----------
    aircraft : Aircraft
        Parametric aircraft whose design variables are chosen.
    mission : Mission
        Air, payload and flight; its latitudes and dates are ignored.
    objective : str or Objective
        ``min_wingspan``, ``min_mass``, ``max_excess_time``, ``max_payload_mass`` or
        ``max_payload_power``.
    required_excess_time_h : float, optional
        Excess time that every design must have [h]; by default the mission's.
    latitudes, days, model, correction, workers, scheduler, progress
        See :func:`feasibility_map`; by default each second latitude and each fourth day.

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
        mission = with_values(mission, {"required_excess_time_h": required_excess_time_h})
    solar = SolarModel(model, correction)
    study = prepare(aircraft, mission, latitudes, days, solar, objective=objective)
    return study.computed(workers, scheduler, progress).to_xarray()


def prepare(
    aircraft: Aircraft,
    mission: Mission,
    latitudes: ArrayLike | None,
    days: ArrayLike | None,
    solar: SolarModel,
    *,
    endurance: bool = False,
    objective: str | Objective | None = None,
) -> Study:
    """Check a map and return its study; with an objective, of best designs."""
    goal = None if objective is None else gridded.resize_objective(objective)
    if goal is not None and isinstance(aircraft.airframe, MeasuredAirframe):
        raise ValueError(f"sizing needs a parametric aircraft, {aircraft.name} is measured")
    check_user_models(aircraft, mission)
    climbs = mission.climb is not None
    slow = goal is not None or solar.needs_path or endurance or climbs
    north_deg, days = _grid(latitudes, days, slow=slow)
    cells = np.array(np.meshgrid(north_deg, days, indexing="ij"), float).reshape(2, -1).T
    if goal is not None or solar.meets_wind(mission):
        mission.scenario_winds_m_per_s(Scenarios.of_cells(cells))  # refuses cells without a wind
    coordinates = {
        "latitude": gridded.Labelled(
            ("latitude",), north_deg, {"units": "degrees_north", "standard_name": "latitude"}
        ),
        "day": gridded.Labelled(("day",), days, {"long_name": "day of year", "units": "1"}),
    }
    cell_s = _CELL_ON_PATH_S if solar.needs_path else _CELL_S
    option = f"model {solar.model}" if solar.model in ATTITUDE_MODELS else "correction loiter"
    if solar.needs_path and aircraft.modules.geometry is None:
        raise ValueError(f"{option} needs modules.geometry on the aircraft {aircraft.name}")
    if solar.needs_path and mission.flight_path is None:
        raise ValueError(f"{option} needs a flight_path on the mission {mission.name}")
    if goal is not None:
        sized = (aircraft, mission, solar, goal)

        def of_designs(columns: Mapping[str, NDArray[Any]]) -> tuple[Extrapolation, ...]:
            """Return where designs leave the range of a model; its effect is on the lightest."""
            is_sized = np.isin(columns["status"], gridded.SIZED)
            lightest = int(np.argmin(np.where(is_sized, columns["total_mass"], np.inf)))
            told = gridded.told_of_cells(columns, gridded.SIZED, "cells")
            return add_effects(told, aircraft, lambda: sized_flight(sized, cells[[lightest]]))

        return Study(
            sized_cells,
            sized,
            cells,
            cell_s=cell_s + _SIZING_S,
            together=_SIZED_TOGETHER,
            described=gridded.DESCRIBED,
            statuses=tuple(SizingStatus),
            coordinates=coordinates,
            attributes={
                **gridded.attributes(f"Best designs of {aircraft.name}", aircraft, mission, solar),
                "objective": goal.value,
                "required_excess_time_h": mission.required_excess_time_h,
            },
            extrapolated=of_designs,
        )
    parts = {
        "endurance_h": endurance,
        "maximum_altitude_m": climbs,
        "charge_rate": charge_rate_is_open(aircraft),
        "wind": mission.wind_statistics is not None,
        "status": True,
    }
    keys = " ".join(key for key, is_there in parts.items() if is_there)
    ends: tuple[IntEnum, ...] = ENDS if mission.flight is not None else CYCLE_ENDS
    return Study(
        fixed_cells,
        (aircraft, mission, solar, endurance),
        cells,
        cell_s=cell_s + endurance * _ENDURANCE_S + climbs * _CLIMB_S,
        described=_DESCRIBED | described(keys),
        statuses=(Status.failed, *ends, *[Status.infeasible] * solar.has_many_paths(mission)),
        coordinates=coordinates,
        attributes=gridded.attributes(f"Feasibility of {aircraft.name}", aircraft, mission, solar),
        extrapolated=partial(extrapolations_of_cells, aircraft, mission, solar, cells),
    )


def _grid(
    latitudes: ArrayLike | None, days: ArrayLike | None, *, slow: bool
) -> tuple[FloatArray, NDArray[np.int_]]:
    """Return checked latitudes [deg] and days of year; ``slow``: default to a coarser grid."""
    if latitudes is None:
        latitudes = SLOW_LATITUDES_DEG if slow else LATITUDES_DEG
    if days is None:
        days = SLOW_DAYS if slow else DAYS
    north_deg = np.atleast_1d(np.asarray(latitudes, float))
    date = np.asarray(days_of_year(days), float)
    for name, values, low, high in (
        ("latitudes", north_deg, -90.0, 90.0),
        ("days", date, 1.0, float(DAYS_PER_YEAR)),
    ):
        good = values.ndim == 1 and len(values) and values[0] >= low and values[-1] <= high
        if not (good and np.all(np.diff(values) > 0.0)):
            raise ValueError(f"{name} must ascend within {spell(low)} to {spell(high)}")
    if np.any(date != np.round(date)):
        raise ValueError("days must be whole numbers")
    return north_deg, date.astype(int)


def season_length(data: xr.Dataset) -> xr.DataArray:
    """Count the map's days on which each latitude has perpetual flight, or lands."""
    return data["status"].isin(SUFFICIENT).sum("day")


# ---- Cells of a fixed aircraft


def fixed_cells(
    fixed: tuple[Aircraft, Mission, SolarModel, bool], cells: FloatArray
) -> dict[str, NDArray[Any]]:
    """Compute metrics of cells, columns of :func:`studies.maps.study.feasibility_map`.

    Cells do not depend on each other; where the wind is too strong for the model's path, they are
    blank. ``fixed``: aircraft, mission, model, and whether longest flights are searched for.
    """
    aircraft, mission, solar, endurance = fixed
    scenarios = Scenarios.of_cells(cells)
    troubles = solar.path_troubles(aircraft, mission, scenarios)
    able = np.array([trouble is None for trouble in troubles])
    winds = {}
    if mission.wind_statistics is not None:
        winds["wind"] = _known_winds(mission, scenarios)
    if not able.all():
        known = fixed_cells(fixed, cells[able]) if able.any() else {}
        status = np.full(len(cells), Status.infeasible, np.int8)
        return merged(able, known, {"status": status}) | winds
    result = _simulated(aircraft, mission, solar, scenarios)
    others = {ENDURANCE: endurance, MAXIMUM_ALTITUDE: mission.climb is not None}
    quantities = (*MAP, *(quantity for quantity, is_there in others.items() if is_there))
    columns = {quantity.variable: quantity.of(result) for quantity in quantities}
    columns["status"] = result.cycle.status.astype(np.int8)
    most_w = result.solar_power_w.max(axis=-1)
    for check in validity.charge_rate_check(aircraft, mission, result.design, most_w):
        columns["charge_rate"] = check.value
    return columns | winds


def _simulated(
    aircraft: Aircraft, mission: Mission, solar: SolarModel, scenarios: Scenarios
) -> Performance:
    """Simulate a fixed aircraft in scenarios."""
    design = design_of(aircraft, mission)
    day = solar_day(aircraft, mission, solar, scenarios=scenarios, design=design)
    return performance(aircraft, mission, solar, day=day, keep_trajectory=False, design=design)


def _known_winds(mission: Mission, cells: Scenarios) -> FloatArray:
    """Return the wind of each cell [m/s]; NaN outside the table of winds, which only informs."""
    try:
        return mission.scenario_winds_m_per_s(cells)
    except InputError:
        months = [month_and_day(int(day))[0] for day in cells.day_of_year]
    pairs = np.column_stack([cells.latitude_deg, months])
    _, first, place = np.unique(pairs, axis=0, return_index=True, return_inverse=True)
    winds = np.full(len(first), np.nan)
    for number, i in enumerate(first.tolist()):
        scenario = Scenarios(cells.latitude_deg[i : i + 1], cells.day_of_year[i : i + 1])
        with suppress(InputError):
            winds[number] = mission.scenario_winds_m_per_s(scenario)[0]
    return winds[place.ravel()]


def extrapolations_of_cells(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel,
    cells: FloatArray,
    columns: Mapping[str, NDArray[Any]],
) -> tuple[Extrapolation, ...]:
    """Return where the map leaves the range of a model; all cells share one design."""
    columns = {name: values.ravel() for name, values in columns.items()}
    known = np.isin(columns["status"], ENDS)
    if not known.any():
        return ()
    design, calm, in_wind = design_of(aircraft, mission), mission, list[Check]()
    if "wind" in columns:  # the wind of each cell replaces the mission's
        calm, winds = mission.in_wind(0.0), columns["wind"][known]
        in_wind += validity.wind_check(design, mission.wind_to_beat_m_per_s(winds))
    climbs = MAXIMUM_ALTITUDE.variable in columns
    highest_m = columns[MAXIMUM_ALTITUDE.variable][known] if climbs else None
    of_design = validity.design_checks(aircraft, calm, design, solar, highest_m)
    scenarios = Scenarios.of_cells(cells[known])
    checks = [*in_wind, *of_design, *validity.correction_check(scenarios, solar, mission)]
    if "charge_rate" in columns:
        checks.append(Check.of("charge_rate_per_h", "battery", columns["charge_rate"][known]))
    extrapolations = collect_extrapolations(checks, of=int(known.sum()), what="cells")
    excess_h = np.where(np.isfinite(columns["excess_time"]), columns["excess_time"], -np.inf)
    best = Scenarios.of_cells(cells[[int(np.argmax(excess_h))]])
    return add_effects(extrapolations, aircraft, lambda: _simulated(aircraft, mission, solar, best))


# ---- Cells that are sized


def sized_cells(sized: Sized, cells: FloatArray) -> dict[str, NDArray[Any]]:
    """Size the aircraft in every cell; return columns of :data:`.gridded.DESCRIBED`.

    A cell replaces the mission's latitude [deg] and day of year.
    """
    aircraft, mission, solar, goal = sized
    scenarios = Scenarios.of_cells(cells)
    troubles = solar.path_troubles(aircraft, mission, scenarios)
    windy = np.array([trouble is not None for trouble in troubles], bool)
    if windy.any():
        calm = sized_cells(sized, cells[~windy]) if not windy.all() else {}
        path = on_path(aircraft, mission).flight_path
        assert path is not None
        over_limit = mission.winds_on_path_m_per_s(scenarios) / largest_wind_m_per_s(path)
        return merged(
            ~windy,
            calm,
            {
                "status": np.full(len(cells), SizingStatus.infeasible, np.int8),
                "violated_requirement": np.full(len(cells), gridded.TOO_WINDY),
                "shortfall": over_limit - 1.0,
                "message": np.array([f"flight path: {text}" for text in troubles]),
            },
        )
    from sizing.program.cells import size_cells  # with the optimiser, a seventh of a second

    sizings = size_cells(aircraft, mission, scenarios, goal, solar)
    variables = sizings.variables
    design = parametric_design(aircraft, mission, variables, sizings.total_mass_kg)
    checks = [
        *validity.design_checks(aircraft, mission, design, solar),
        *validity.correction_check(scenarios, solar, mission),
    ]
    if validity.charge_rate_is_open(aircraft):
        day = solar_day(aircraft, mission, solar, scenarios=scenarios)
        peak_w = np.max(day.specific_power_w_per_m2, axis=-1) * variables.module_area_m2
        checks += validity.charge_rate_check(aircraft, mission, design, peak_w)
    outside = np.array(cell_texts(checks, len(scenarios)))
    known = variables._asdict() | vars(sizings)
    message = np.where(
        sizings.status == SizingStatus.not_converged,
        "the solver did not converge",
        sizings.message.astype(str),
    )
    return {
        "status": sizings.status.astype(np.int8),
        **{quantity.variable: known[quantity.name] for quantity in (*DESIGN_COLUMNS, *REACHED)},
        LOAD.variable: sizings.load_w,
        "shortfall": sizings.shortfall,
        "violated_requirement": sizings.requirement.astype(str),
        "message": message,
        "extrapolations": np.where(np.isin(sizings.status, gridded.SIZED), outside, ""),
    }


def sized_flight(sized: Sized, cell: FloatArray) -> Performance | None:
    """Simulate the best design of a single cell, shape ``(1, 2)``; None without a design."""
    from sizing.program.cells import size_cells

    aircraft, mission, solar, goal = sized
    scenario = Scenarios.of_cells(cell)
    sizings = size_cells(aircraft, mission, scenario, goal, solar)
    if sizings.status[0] not in gridded.SIZED:
        return None
    values = (None if v is None else np.ravel(v)[0] for v in sizings.variables)
    day = solar_day(aircraft, mission, solar, scenarios=scenario)
    return performance_of_designs(aircraft, mission, DesignVariables(*values), solar, day=day)
