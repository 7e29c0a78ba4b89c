"""How the errors of CDM and CAM change with latitude, season and wind.

The report's corrections are two numbers from one morning. Here the truth at any place is taken to
be the Full Model on the mission's loiter path, corrected by its own measured bias, and the error of
a simple model is that of its daily energy against this truth. Wind is averaged over eight
directions; the spread over them is given beside the mean.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from missions.dates import date_label
from missions.mission import Mission, Scenarios
from missions.mission.scenarios import latitude_label
from sizing.aircraft import Aircraft
from sizing.day.light import day_axis_h
from sizing.day.module_power import modelled_power, surroundings_in_flight
from solar.names import MODELS, ModelName
from solar.types import FloatArray
from studies.render.tables import Column, Table

LATITUDES_DEG = (0.0, 15.0, 30.0, 45.0, 55.0, 65.0)
DAYS = (80, 172, 355)
WINDS_M_PER_S = (0.0, 2.0, 4.0, 6.0)
SIMPLE_MODELS: tuple[ModelName, ...] = ("CDM", "CAM")
_DIRECTIONS_DEG = tuple(45.0 * i for i in range(8))
_STEP_H = 0.25


@dataclass(frozen=True)
class TransferredError:
    """Relative error of a model's daily energy: mean over wind directions, and half their range."""

    model: ModelName
    latitude_deg: float
    day_of_year: int
    wind_m_per_s: float
    error: float
    half_range: float


def transferred_errors(
    aircraft: Aircraft,
    mission: Mission,
    *,
    latitudes_deg: Sequence[float] = LATITUDES_DEG,
    days: Sequence[int] = DAYS,
    winds_m_per_s: Sequence[float] = WINDS_M_PER_S,
) -> list[TransferredError]:
    """Errors of CDM and CAM over latitudes, days and winds; polar nights are left out.

    ``latitudes_deg``, ``days``, ``winds_m_per_s``: latitudes [deg], days of the year and wind
    speeds [m/s], each with each.
    """
    time_h = day_axis_h(_STEP_H)
    grid = [(lat, day) for lat in latitudes_deg for day in days]
    scenarios = Scenarios(np.array([lat for lat, _ in grid]), np.array([day for _, day in grid]))
    simple = {m: _energy(aircraft, mission, m, scenarios, time_h) for m in SIMPLE_MODELS}
    errors: list[TransferredError] = []
    for wind in winds_m_per_s:
        directions = _DIRECTIONS_DEG if wind > 0.0 else (0.0,)
        truth = np.stack(
            [
                _energy(
                    aircraft,
                    mission.in_wind(wind).model_copy(update={"wind_from_deg": direction}),
                    "FM",
                    scenarios,
                    time_h,
                )
                for direction in directions
            ]
        ) / (1.0 + MODELS["FM"].average)
        for model in SIMPLE_MODELS:
            errors += _errors(model, wind, scenarios, simple[model], truth)
    return errors


def _energy(
    aircraft: Aircraft, mission: Mission, model: ModelName, scenarios: Scenarios, time_h: FloatArray
) -> FloatArray:
    power = modelled_power(
        aircraft, mission, model, scenarios, time_h, surroundings_in_flight(aircraft, mission)
    )
    return np.asarray(np.trapezoid(power, time_h, axis=-1))


def _errors(
    model: ModelName, wind: float, scenarios: Scenarios, energy: FloatArray, truth: FloatArray
) -> list[TransferredError]:
    errors = []
    for i in np.flatnonzero(energy > 0.0):
        relative = energy[i] / truth[:, i] - 1.0
        errors.append(
            TransferredError(
                model,
                float(scenarios.latitude_deg[i]),
                int(scenarios.day_of_year[i]),
                wind,
                float(relative.mean()),
                float(np.ptp(relative) / 2.0),
            )
        )
    return errors


def transfer_table(errors: Sequence[TransferredError]) -> Table:
    """Row for each latitude and day, and a column for each model and wind [%]."""
    cases = sorted({(e.model, e.wind_m_per_s) for e in errors})
    rows: dict[tuple[float, int], dict[tuple[str, float], str]] = {}
    for e in errors:
        spread = f" ± {100 * e.half_range:.1f}" if e.wind_m_per_s > 0.0 else ""
        row = rows.setdefault((e.latitude_deg, e.day_of_year), {})
        row[e.model, e.wind_m_per_s] = f"{100 * e.error:+.1f}{spread}"
    return Table(
        "error of daily solar energy [%]",
        tuple(map(Column, ("latitude", "date", *(f"{m}, {w:g} m/s" for m, w in cases)))),
        tuple(
            (latitude_label(latitude), date_label(day), *(found[case] for case in cases))
            for (latitude, day), found in sorted(rows.items())
        ),
        ("±: half the range over eight wind directions",),
    )
