"""Cells of a map of a fixed aircraft: metrics of its day at each latitude and date."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from missions.dates import month_and_day
from missions.files.errors import InputError
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel, solar_day
from sizing.day.metrics import ENDS, Status
from sizing.mass_budget import design_of
from sizing.performance import Performance, performance
from sizing.validity import checks as validity
from sizing.validity.extrapolations import add_effects, collect_extrapolations
from sizing.validity.ranges import Check, Extrapolation
from solar.types import FloatArray
from studies.quantities import ENDURANCE, MAP, MAXIMUM_ALTITUDE
from studies.study import merged


def scenarios_of(cells: FloatArray) -> Scenarios:
    """Convert cells of latitude [deg] and day, shape ``(cell, 2)``, to scenarios."""
    return Scenarios(cells[:, 0], cells[:, 1].astype(int))


def fixed_cells(
    fixed: tuple[Aircraft, Mission, SolarModel, bool], cells: FloatArray
) -> dict[str, NDArray[Any]]:
    """Compute metrics of cells, columns of :func:`studies.maps.study.feasibility_map`.

    Cells do not depend on each other; where the wind is too strong for the model's path, they are
    blank. ``fixed``: aircraft, mission, model, and whether longest flights are searched for.
    """
    aircraft, mission, solar, endurance = fixed
    scenarios = scenarios_of(cells)
    troubles = solar.path_troubles(aircraft, mission, scenarios)
    able = np.array([trouble is None for trouble in troubles])
    winds = {}
    if mission.wind_statistics is not None:
        winds["wind"] = _known_winds(mission, scenarios)
    if not able.all():
        known = fixed_cells(fixed, cells[able]) if able.any() else {}
        status = np.full(len(cells), Status.infeasible, np.int8)
        return merged(able, known, {"status": status[~able]}) | winds
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
    scenarios = scenarios_of(cells[known])
    checks = [*in_wind, *of_design, *validity.correction_check(scenarios, solar, mission)]
    if "charge_rate" in columns:
        checks.append(Check.of("charge_rate_per_h", "battery", columns["charge_rate"][known]))
    extrapolations = collect_extrapolations(checks, of=int(known.sum()), what="cells")
    excess_h = np.where(np.isfinite(columns["excess_time"]), columns["excess_time"], -np.inf)
    best = scenarios_of(cells[[int(np.argmax(excess_h))]])
    return add_effects(extrapolations, aircraft, lambda: _simulated(aircraft, mission, solar, best))
