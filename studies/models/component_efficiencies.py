"""Component efficiencies of the Full Model over the day."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.loiter_power import PathModules, module_power_on_path
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import day_axis_h
from sizing.day.module_power import clear_daylight, on_path, surroundings_in_flight
from solar.attitude_models import ModulePower
from solar.types import FloatArray
from solar.versions import software_record

if TYPE_CHECKING:
    import xarray as xr


def component_efficiencies(
    aircraft: Aircraft, mission: Mission, scenario: int = 0, *, step_h: float = 1.0 / 12.0
) -> xr.Dataset:
    """Compute component efficiencies of the Full Model over a day, averaged over the flight path.

    The mission's uncertainty margins reduce the power, as in every other study.

    Parameters
    ----------
    aircraft : Aircraft
        Needs module surfaces.
    mission : Mission
        Needs a flight path.
    scenario : int
        Number of the mission's scenario.
    step_h : float
        Step of the time axis [h].

    Returns
    -------
    xarray.Dataset
        Over solar time [h], means over the time of the orbit; some by ``surface``.

    Raises
    ------
    ValueError
        If the aircraft has no module geometry or the mission no flight path.
    """
    geometry, path = aircraft.modules.geometry, on_path(aircraft, mission).flight_path
    if geometry is None or path is None:
        raise ValueError("component efficiencies need modules.geometry and a flight_path")
    time_h = day_axis_h(step_h)
    scenarios = mission.scenarios()
    latitude_deg = float(scenarios.latitude_deg[scenario])
    daylight, orbit, power = module_power_on_path(
        PathModules(geometry, aircraft.modules, path, mission.wind, aircraft.modules.shading),
        clear_daylight(mission, latitude_deg, float(scenarios.noon_day[scenario]), time_h),
        ambient_temperature_c=float(mission.air_state().temperature_c),
        surroundings=surroundings_in_flight(aircraft, mission),
    )
    factor = mission.pessimistic_power_factor("FM")
    specific_power = power.specific_power_w_per_m2 * factor
    power = replace(power, specific_power_w_per_m2=specific_power)
    import xarray as xr  # two thirds of a second

    return xr.Dataset(
        _variables(power, orbit.weights),
        {
            "time": ("time", time_h[daylight], {"units": "h", "long_name": "solar time"}),
            "surface": [s.name for s in geometry.surfaces],
        },
        {
            "aircraft": aircraft.name,
            "mission": mission.name,
            "scenario": scenarios.label(scenario),
            "model": "FM",
            **software_record(),
        },
    )


def _variables(power: ModulePower, weights: FloatArray) -> dict[str, Any]:
    """Return variables of the dataset: means over attitudes (second axis), with CF attributes."""
    aoi_deg = np.degrees(np.arccos(np.clip(power.cos_aoi_by_surface, -1.0, 1.0)))
    columns = {
        "specific_power": (power.specific_power_w_per_m2, "W m-2", "specific power"),
        "irradiance": (power.irradiance_w_per_m2, "W m-2", "irradiance on the modules"),
        "module_temperature": (power.module_temperature_c, "degC", "module temperature"),
        "module_efficiency": (power.module_efficiency, "1", "module efficiency"),
        "mppt_efficiency": (power.mppt_efficiency, "1", "MPPT efficiency"),
        "temperature_efficiency": (power.temperature_efficiency, "1", "eps_T"),
        "aoi": (aoi_deg, "degree", "angle of incidence"),
        "incidence_efficiency": (power.incidence_efficiency_by_surface, "1", "eps_gamma"),
        "low_light_efficiency": (power.low_light_efficiency_by_surface, "1", "eps_I"),
    }
    result = {}
    for name, (values, units, long_name) in columns.items():
        mean = np.tensordot(values, weights, axes=([1], [0]))
        dimensions = ("time", "surface")[: mean.ndim]
        result[name] = (dimensions, mean, {"units": units, "long_name": long_name})
    return result
