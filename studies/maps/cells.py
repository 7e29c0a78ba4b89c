"""Cells of a map of a fixed aircraft: what becomes of its day at each latitude and date."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from missions.dates import month_and_day
from missions.files.errors import InputError
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel, solar_day
from sizing.day.metrics import ENDS, Status
from sizing.day.module_power import path_troubles
from sizing.mass_budget import design_of
from sizing.performance import Performance, performance
from sizing.program.objectives import Objective
from sizing.validity.checks import (
    at_highest,
    charge_rate_check,
    correction_check,
    design_checks,
    wind_check,
)
from sizing.validity.extrapolations import add_effects, collect_extrapolations
from sizing.validity.ranges import Check, Extrapolation
from solar.types import FloatArray
from studies.quantities import ENDURANCE, MAP, MAXIMUM_ALTITUDE
from studies.study import merged

# Cells simulated at once: their arrays over one day take some 10 MB each.
_CELLS_AT_ONCE = 4096
_CLIMBING_AT_ONCE = 1024  # as many as are marched at once; with their light at all levels


@dataclass(frozen=True)
class MapConfiguration:
    """What all cells of a map have in common; ``objective``: what they are sized for, if so."""

    aircraft: Aircraft
    mission: Mission
    solar: SolarModel
    endurance: bool = False
    objective: Objective | None = None


def scenarios_of(cells: FloatArray) -> Scenarios:
    """Cells of latitude [deg] and day, shape ``(cell, 2)``, as scenarios."""
    return Scenarios(cells[:, 0], cells[:, 1].astype(int))


def fixed_cells(configuration: MapConfiguration, cells: FloatArray) -> dict[str, NDArray[Any]]:
    """Metrics of cells, as the columns of :func:`studies.maps.study.feasibility_map`.

    A cell does not depend on the others: a map may be computed in parts of any size.
    """
    climbs = configuration.mission.climb is not None
    at_once = _CLIMBING_AT_ONCE if climbs else _CELLS_AT_ONCE
    starts = range(0, len(cells), at_once)
    parts = [_cells(configuration, cells[i : i + at_once]) for i in starts]
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _cells(configuration: MapConfiguration, cells: FloatArray) -> dict[str, NDArray[Any]]:
    """Metrics of cells; none where the wind is too strong for a path that the model needs."""
    if not configuration.solar.needs_path:
        return _flown_cells(configuration, cells)
    troubles = path_troubles(configuration.aircraft, configuration.mission, scenarios_of(cells))
    able = np.array([trouble is None for trouble in troubles])
    if able.all():
        return _flown_cells(configuration, cells)
    windy = cells[~able]
    return merged(
        able,
        _flown_cells(configuration, cells[able]) if able.any() else {},
        {
            "status": np.full(len(windy), Status.infeasible, np.int8),
            "wind": _known_winds(configuration.mission, scenarios_of(windy)),
        },
    )


def _flown_cells(configuration: MapConfiguration, cells: FloatArray) -> dict[str, NDArray[Any]]:
    scenarios = scenarios_of(cells)
    mission, flight = configuration.mission, _fly(configuration, scenarios)
    quantities = [*MAP, *([ENDURANCE] if configuration.endurance else [])]
    if mission.climb is not None:
        quantities.append(MAXIMUM_ALTITUDE)
    columns: dict[str, NDArray[Any]] = {
        **{one.variable: one.of(flight) for one in quantities},
        "status": flight.cycle.status.astype(np.int8),
    }
    if mission.wind_statistics is not None:
        columns["wind"] = _known_winds(mission, scenarios)
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


def extrapolations_of_cells(
    configuration: MapConfiguration, cells: FloatArray, columns: Mapping[str, NDArray[Any]]
) -> tuple[Extrapolation, ...]:
    """What the map takes from outside the range of a model: one design in all cells."""
    columns = {name: values.ravel() for name, values in columns.items()}
    known = np.isin(columns["status"], ENDS)
    if not known.any():
        return ()
    aircraft, mission, solar = configuration.aircraft, configuration.mission, configuration.solar
    design, calm, in_wind = design_of(aircraft, mission), mission, []
    if "wind" in columns:  # of each cell; that of the mission's own latitudes plays no part
        calm, winds = mission.in_wind(0.0), columns["wind"][known]
        in_wind = [] if mission.holds_station else list(wind_check(design, winds))
    of_design = list(design_checks(aircraft, calm, design, solar))
    if MAXIMUM_ALTITUDE.variable in columns:
        highest_m = columns[MAXIMUM_ALTITUDE.variable][known]
        of_design = at_highest(of_design, aircraft, calm, solar, highest_m)
    scenarios = scenarios_of(cells[known])
    checks = [*in_wind, *of_design, *correction_check(scenarios, solar, mission)]
    if "charge_rate" in columns:
        checks.append(Check.of("charge_rate_per_h", "battery", columns["charge_rate"][known]))
    extrapolations = collect_extrapolations(checks, of=int(known.sum()), what="cells")
    excess_h = np.where(np.isfinite(columns["excess_time"]), columns["excess_time"], -np.inf)
    best = scenarios_of(cells[[int(np.argmax(excess_h))]])
    return add_effects(extrapolations, aircraft, lambda: _fly(configuration, best))
