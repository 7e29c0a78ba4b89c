"""Specific power of an aircraft's modules over scenarios and time, by any solar power model."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from missions.loiter_power import Daylight, FlownModules, mean_power_on_path
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.module_heat import balances_heat, convection_in_flight, surroundings
from solar.heat_balance import Surroundings
from solar.horizontal_models import (
    HORIZONTAL_MODELS,
    horizontal_specific_power,
    in_surroundings,
)
from solar.names import ATTITUDE_MODELS, ModelName
from solar.types import FloatArray


def modelled_power(
    aircraft: Aircraft, mission: Mission, model: ModelName, scenarios: Scenarios, time_h: FloatArray
) -> FloatArray:
    """Specific power of a model, uncorrected, over scenarios and time.

    CDM and CAM see one horizontal surface
    (:func:`solar.horizontal_models.horizontal_specific_power`); VM and
    FM are averaged over the mission's flight path (:mod:`missions.loiter_power`).

    Returns electric power per area of module [W/m2].
    """
    around = own_surroundings(aircraft, mission)
    return power_in_surroundings(aircraft, mission, model, scenarios, time_h, around)


def own_surroundings(aircraft: Aircraft, mission: Mission) -> Surroundings | None:
    """Surroundings of modules in the aircraft's own flow, where they balance their heat."""
    if not balances_heat(mission):
        return None
    return surroundings(mission, convection_in_flight(aircraft, mission))


def power_in_surroundings(
    aircraft: Aircraft,
    mission: Mission,
    model: ModelName,
    scenarios: Scenarios,
    time_h: FloatArray,
    around: Surroundings | None,
) -> FloatArray:
    """Specific power of a model whose modules are in some surroundings; none: as told."""
    latitude_deg, day = scenarios.latitude_deg, scenarios.noon_day
    if model not in ATTITUDE_MODELS:
        # In memory the time comes first: the simulator marches over it, all scenarios at once.
        column = time_h[:, np.newaxis]
        return specific_power(aircraft, mission, model, latitude_deg, day, column, around).T
    flown = [mission] * len(scenarios)
    if mission.wind_statistics is not None:
        flown = [mission.in_wind(w) for w in mission.scenario_winds_m_per_s(scenarios).tolist()]
    return np.stack(
        [
            specific_power(aircraft, one, model, float(latitude), noon, time_h, around)
            for one, latitude, noon in zip(flown, latitude_deg, day, strict=True)
        ]
    )


def flown_modules(aircraft: Aircraft, mission: Mission, model: ModelName) -> FlownModules:
    """What VM and FM need of aircraft and mission."""
    modules = aircraft.modules
    if modules.geometry is None:
        raise ValueError(f"model {model} needs modules.geometry on the aircraft {aircraft.name}")
    if mission.flight_path is None:
        raise ValueError(f"model {model} needs a flight_path on the mission {mission.name}")
    return FlownModules(
        modules.geometry, modules, mission.flight_path, mission.wind, modules.shading
    )


def specific_power(
    aircraft: Aircraft,
    mission: Mission,
    model: ModelName,
    latitude_deg: float | FloatArray,
    day_of_year: ArrayLike,
    time_solar_h: FloatArray,
    around: Surroundings | None,
) -> FloatArray:
    """Uncorrected power by any model [W/m2]; VM and FM take a single latitude."""
    modules = aircraft.modules
    if model not in ATTITUDE_MODELS:
        return horizontal_specific_power(
            latitude_deg,
            day_of_year,
            time_solar_h,
            cell=modules,
            module_temperature_c=mission.module_temperature_c(),
            altitude_m=mission.altitude_m,
            clearness=mission.pessimistic_clearness,
            sky=mission.sky,
            model=model if around is None else in_surroundings(HORIZONTAL_MODELS[model], around),
        )
    return mean_power_on_path(
        model,
        flown_modules(aircraft, mission, model),
        Daylight(
            float(latitude_deg),
            day_of_year,
            time_solar_h,
            mission.altitude_m,
            mission.pessimistic_clearness,
            mission.sky,
            albedo=mission.air.albedo or 0.0,
        ),
        ambient_temperature_c=float(mission.air_state().temperature_c),
        module_temperature_c=mission.module_temperature_c(),
        surroundings=around,
    )
