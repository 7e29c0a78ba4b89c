"""Flights over a night that share no sun, sky, incidence or temperature with the project.

Sun, sky, circles, cells and attitude errors of :mod:`benchmarks.independent_logs`; an aircraft of
known modules, level power and battery, from the morning over a night. What is true of it is given
in the keys of the aircraft's file.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count

import numpy as np
import pandas as pd

from benchmarks.independent_logs import (
    COEFFICIENT_PER_K,
    MPPT_AT_STC,
    STEP_S,
    Cells,
    Place,
    Truth,
    angles_on_circles,
    biased,
    drawn_place,
    lasting_noise,
    power_of_modules,
)
from sizing.aircraft import Aircraft
from sizing.energy.battery import Store
from solar.types import FloatArray

HOURS = 30.0
_HIGHEST_NIGHT_H = 12.5  # that the battery lasts for at the load
_LEAST_NOON_DEG = 40.0
_LAUNCH_H = (-4.5, 1.5)  # after noon: batteries become full on some of the flights
_START_CHARGE, _LEAST_CHARGE = (0.1, 0.5), 0.05
_FULL_FROM = 0.88  # charge from which the current falls, as at constant voltage


@dataclass(frozen=True)
class Flown:
    """Rows as logged, and the least true charge from the first evening to the next morning."""

    rows: pd.DataFrame
    minimum_charge: float


def drawn_cells(rng: np.random.Generator) -> Cells:
    """Cells on a foil or on foam, of good and of poor efficiency in low light."""
    return Cells(rng.uniform(15.0, 35.0), rng.uniform(4.0, 12.0))


def true_values(aircraft: Aircraft, cells: Cells) -> dict[str, float]:
    """What a fit of the shipped models should find, by the names of its parameters.

    Light, MPPT and modules are one factor: at standard test conditions, by the file's MPPT. The
    temperature is what costs as much power at the file's coefficient.
    """
    modules = aircraft.modules
    at_full = float(np.asarray(modules.mppt_efficiency_at(1.0)))
    efficiency = modules.efficiency_stc * MPPT_AT_STC / at_full
    efficiency *= 1000.0 / (1000.0 + cells.halved_w_per_m2)
    coefficient = COEFFICIENT_PER_K / modules.temperature_coefficient_per_k
    # Light at which the modules give the power that the file's temperature rise belongs to.
    rated = modules.full_load_w_per_m2 / (modules.efficiency_stc * modules.camber_efficiency)
    light = rated / at_full / (1.0 - COEFFICIENT_PER_K * (rated / cells.heat_transfer - 10.0))
    return {
        "module_efficiency": efficiency,
        "temperature_rise": coefficient * light / cells.heat_transfer,
        # A measured aircraft, as below.
        "level_power": aircraft.airframe.level_flight.electric_power_w,  # type: ignore[union-attr]  # measured
        "specific_energy": aircraft.battery.specific_energy_wh_per_kg or 0.0,
    }


def flown(aircraft: Aircraft, cells: Cells, seed: int, hours: float = HOURS) -> Flown:
    """Fly over a night; ``seed`` decides place, day, launch, weather, circle and noise.

    Flights that run empty are flown again from other draws.
    """
    tries = (_flown(aircraft, cells, np.random.default_rng([seed, one]), hours) for one in count())
    return next(one for one in tries if one.minimum_charge > _LEAST_CHARGE)


def _flown(aircraft: Aircraft, cells: Cells, rng: np.random.Generator, hours: float) -> Flown:
    place = _place(rng)
    elapsed = np.arange(0.0, 3600.0 * hours, STEP_S)
    launch = place.noon + pd.Timedelta(hours=rng.uniform(*_LAUNCH_H))
    times = launch + pd.to_timedelta(elapsed, unit="s")
    angles = angles_on_circles(elapsed, rng)
    day = np.cos(2.0 * np.pi * ((launch - place.noon).total_seconds() + elapsed) / 86400.0 - 0.7)
    air_c = rng.uniform(2.0, 26.0) + 4.0 * day
    nowhere = np.zeros(len(elapsed), bool)
    each = power_of_modules(aircraft, place, times, angles, air_c, Truth(), nowhere, cells)
    power = each.sum(axis=1) * (
        1.0 + 0.01 * lasting_noise(rng.standard_normal(len(elapsed)), 1200.0)
    )
    level_w = true_values(aircraft, cells)["level_power"] * _thinner(aircraft, place, air_c)
    load = level_w + aircraft.power.avionics_w
    load = load + 3.0 * lasting_noise(rng.standard_normal(len(elapsed)), 360.0)
    power, charge = _charged(aircraft, power, load, rng.uniform(*_START_CHARGE))
    gauge = 0.004 * lasting_noise(rng.standard_normal(len(elapsed)), 1800.0)
    rows = pd.DataFrame(
        {
            "time_utc_s": times.as_unit("ns").asi8 / 1e9,
            "latitude_deg": place.latitude + rng.normal(0.0, 1e-5, len(elapsed)),
            "longitude_deg": place.longitude + rng.normal(0.0, 1e-5, len(elapsed)),
            "altitude_m": place.altitude + rng.normal(0.0, 1.0, len(elapsed)),
            **biased(angles, rng),
            "solar_power_w": power + rng.normal(0.0, 1.0, len(power)),
            "ambient_temperature_c": air_c,
            "load_w": load + rng.normal(0.0, 1.0, len(power)),
            "state_of_charge": np.clip(charge + gauge, 0.0, 1.0),
        }
    )
    evening = int(np.argmax(charge[elapsed < 12.0 * 3600.0]))
    return Flown(rows, float(charge[evening:].min()))


def _place(rng: np.random.Generator) -> Place:
    """Place, day and sky on which the battery lasts over the night."""
    while True:
        place = drawn_place(rng)
        day = place.noon.day_of_year
        declination = np.radians(23.45 * np.sin(2.0 * np.pi * (day + 284) / 365.0))
        latitude = np.radians(place.latitude)
        cosine = np.clip(-np.tan(latitude) * np.tan(declination), -1.0, 1.0)
        night_h = 24.0 - 24.0 / np.pi * float(np.arccos(cosine))
        noon_deg = 90.0 - abs(np.degrees(latitude - declination))
        if night_h < _HIGHEST_NIGHT_H and noon_deg > _LEAST_NOON_DEG:
            return place


def _thinner(aircraft: Aircraft, place: Place, air_c: FloatArray) -> FloatArray:
    """Power of level flight in this air over the measured: as the root of the density.

    The barometric formula of a standard atmosphere (ICAO Doc 7488), and the ideal gas.
    """
    pressure = 101325.0 * (1.0 - 2.25577e-5 * place.altitude) ** 5.25588
    density = pressure / (287.05287 * (air_c + 273.15))
    # The aircraft is a measured one.
    measured = aircraft.airframe.level_flight.density_kg_per_m3  # type: ignore[union-attr]  # measured
    return np.asarray(np.sqrt(measured / density))


def _charged(
    aircraft: Aircraft, power: FloatArray, load: FloatArray, start: float
) -> tuple[FloatArray, FloatArray]:
    """Power that load and battery take [W], and the true state of charge."""
    store = Store.of(aircraft.battery)
    full, gain = float(store.battery_energy_wh), float(store.charge_efficiency)
    drain = float(store.discharge_efficiency)
    taken, charge, state = np.empty(len(power)), np.empty(len(power)), start
    for i, (available, used) in enumerate(zip(power.tolist(), load.tolist(), strict=True)):
        charge[i] = state
        limit = 0.4 * full * min(1.0, max(0.0, (1.0 - state) / (1.0 - _FULL_FROM)))
        taken[i] = min(available, used + limit)
        net_wh = (taken[i] - used) * STEP_S / 3600.0
        state = max(state + (net_wh * gain if net_wh > 0.0 else net_wh / drain) / full, 0.0)
    return taken, charge
