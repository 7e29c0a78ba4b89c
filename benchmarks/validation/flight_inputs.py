"""Inputs of the simulator that may explain a difference from a flight, and how well each is known.

A range is published, or an assumption that says so. Its standard uncertainty is half the range over
the square root of 3, that of a value of which nothing but its limits is known (JCGM 100:2008, Guide
to the Expression of Uncertainty in Measurement, 4.3.7), unless the source gives one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from benchmarks.validation.published_flights import FLIGHTS, Flight, Quantity, Trial, data
from missions.mission.mission import Turbulence
from sizing.day.light import SolarModel
from solar.names import MODELS


@dataclass(frozen=True)
class Input:
    """An input of the simulator that can be changed alone.

    ``search`` are the ends between which a value is looked for, whether or not they are possible.
    One that is not ``separate`` overlaps with others, or changes the solar power model. CAM's power
    is in proportion to some.
    """

    name: str
    unit: str
    read: Callable[[Trial], float]
    change: Callable[[Trial, float], Trial]
    search: Callable[[float], tuple[float, float]]
    separate: bool = True
    scales_power: bool = False


@dataclass(frozen=True)
class Spread:
    """Range in which an input of a flight is known to lie, and who says so.

    ``uncertainty`` is the standard uncertainty where the source gives one.
    """

    input: Input
    low: float
    high: float
    source: str
    uncertainty: float | None = None

    @property
    def standard_uncertainty(self) -> float:
        """Of the source, else that of an even distribution over the range."""
        even = (self.high - self.low) / math.sqrt(12.0)
        return even if self.uncertainty is None else self.uncertainty


@dataclass(frozen=True)
class Miss:
    """A published number that is not met, and the inputs that may explain it."""

    flight: Flight
    quantity: Quantity
    spreads: tuple[Spread, ...]


def _air(trial: Trial, celsius: float) -> Trial:
    air = trial.mission.air
    update = {"ambient_temperature_c": celsius}
    if air.module_temperature_c is not None:
        update["module_temperature_c"] = celsius
    return trial.with_mission(air=air.model_copy(update=update))


def _turbulence(trial: Trial, **keys: float) -> Trial:
    return trial.with_mission(turbulence=Turbulence().model_copy(update=keys))


def _modules(trial: Trial, efficiency: float) -> Trial:
    return trial.with_aircraft(modules={"efficiency_stc": efficiency})


def _battery_energy(trial: Trial, energy_wh: float) -> Trial:
    specific = energy_wh / trial.aircraft.battery.mass_kg
    return trial.with_aircraft(battery={"specific_energy_wh_per_kg": specific})


INPUTS = {
    "load": Input(
        "load in level flight",
        "W",
        lambda trial: trial.load_w,
        Trial.with_load,
        lambda used: (0.4 * used, 2.0 * used),
    ),
    "solar_power": Input(
        "solar power over CAM's",
        "-",
        lambda trial: 1.0,
        lambda trial, factor: _modules(trial, factor * trial.aircraft.modules.efficiency_stc),
        lambda used: (0.3, 2.0),
        separate=False,
    ),
    "clearness": Input(
        "clearness",
        "-",
        lambda trial: trial.mission.clearness,
        lambda trial, value: trial.with_mission(clearness=value),
        lambda used: (0.3, 2.0),
        scales_power=True,
    ),
    "modules": Input(
        "efficiency of the modules",
        "-",
        lambda trial: trial.aircraft.modules.efficiency_stc,
        _modules,
        lambda used: (0.3 * used, 2.0 * used),
        scales_power=True,
    ),
    "battery": Input(
        "energy of the battery",
        "Wh",
        lambda trial: trial.aircraft.battery.battery_energy_wh,
        _battery_energy,
        lambda used: (0.5 * used, 2.0 * used),
    ),
    "discharge": Input(
        "discharge efficiency",
        "-",
        lambda trial: trial.aircraft.battery.discharge_efficiency,
        lambda trial, value: trial.with_aircraft(battery={"discharge_efficiency": value}),
        lambda used: (0.5, 1.2),
    ),
    "temperature": Input(
        "air and module temperature",
        "°C",
        lambda trial: float(trial.mission.air_state().temperature_c),
        _air,
        lambda used: (-50.0, 100.0),
    ),
    "turbulence": Input(
        "turbulence, all day",
        "-",
        lambda trial: 0.0,
        lambda trial, value: _turbulence(trial, all_day=value),
        lambda used: (-0.6, 1.0),
        separate=False,
    ),
    "thermals": Input(
        "level power saved in thermals",
        "-",
        lambda trial: 0.0,
        lambda trial, value: _turbulence(trial, thermal=-value),
        lambda used: (0.0, 2.0),
    ),
    "wind": Input(
        "easterly wind (FM, circle)",
        "m/s",
        lambda trial: 0.0,
        lambda trial, value: replace(
            trial.with_mission(wind_m_per_s=value), solar=SolarModel("FM")
        ),
        lambda used: (0.0, 8.0),
        separate=False,
    ),
    "full": Input(
        "charge that counts as full",
        "-",
        lambda trial: trial.full_charge,
        lambda trial, value: replace(trial, full_charge=value),
        lambda used: (0.9, 1.0),
    ),
    "launch": Input(
        "state of charge at launch",
        "-",
        lambda trial: trial.mission.launch.state_of_charge if trial.mission.launch else 1.0,
        lambda trial, value: trial.with_mission(
            launch=trial.mission.launch
            and trial.mission.launch.model_copy(update={"state_of_charge": value})
        ),
        lambda used: (0.3, 1.0),
    ),
}


def _spread_of(row: dict[str, Any]) -> Spread:
    """Spread as the file gives it; ``error_of`` stands for the RMS error of a model in flight."""
    if "error_of" in row:
        error = MODELS[row["error_of"]].rms
        return Spread(INPUTS[row["input"]], 1.0 - error, 1.0 + error, row["source"], error)
    return Spread(INPUTS[row["input"]], row["low"], row["high"], row["source"])


def _miss_of(row: dict[str, Any]) -> Miss:
    flight = FLIGHTS[row["flight"]]
    return Miss(flight, flight.quantity(row["quantity"]), tuple(map(_spread_of, row["inputs"])))


MISSES = tuple(map(_miss_of, data()["differences"]))
