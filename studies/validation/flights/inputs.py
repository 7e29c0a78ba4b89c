"""Inputs of the simulator that may explain a difference from a flight, and how well each is known.

A range is published, or an assumption that says so. Its standard uncertainty is half the range over
the square root of 3, that of a value of which nothing but its limits is known (JCGM 100:2008, Guide
to the Expression of Uncertainty in Measurement, 4.3.7), unless the source gives one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from missions.mission import Turbulence
from sizing.sunlight import SolarModel
from solar.systematic_errors import REPORTED_ERRORS
from studies.validation.flights import published_flights as flights
from studies.validation.flights.published_flights import Flight, Quantity, Trial


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
    update = {"ambient_temperature_c": celsius, "module_temperature_c": celsius}
    return trial.with_mission(air=trial.mission.air.model_copy(update=update))


def _wind(trial: Trial, wind_m_per_s: float) -> Trial:
    return replace(trial.with_mission(wind_m_per_s=wind_m_per_s), solar=SolarModel("FM"))


def _turbulence(trial: Trial, **keys: float) -> Trial:
    return trial.with_mission(turbulence=Turbulence().model_copy(update=keys))


def _modules(trial: Trial, efficiency: float) -> Trial:
    return trial.with_aircraft(modules={"efficiency_stc": efficiency})


def _battery(trial: Trial, energy_wh: float) -> Trial:
    specific = energy_wh / trial.aircraft.battery.mass_kg
    return trial.with_aircraft(battery={"specific_energy_wh_per_kg": specific})


LOAD = Input(
    "load in level flight",
    "W",
    lambda trial: trial.load_w,
    Trial.with_load,
    lambda used: (0.4 * used, 2.0 * used),
)
SOLAR_POWER = Input(
    "solar power over CAM's",
    "-",
    lambda trial: 1.0,
    lambda trial, factor: _modules(trial, factor * trial.aircraft.modules.efficiency_stc),
    lambda used: (0.3, 2.0),
    separate=False,
)
CLEARNESS = Input(
    "clearness",
    "-",
    lambda trial: trial.mission.clearness,
    lambda trial, value: trial.with_mission(clearness=value),
    lambda used: (0.3, 2.0),
    scales_power=True,
)
MODULES = Input(
    "efficiency of the modules",
    "-",
    lambda trial: trial.aircraft.modules.efficiency_stc,
    _modules,
    lambda used: (0.3 * used, 2.0 * used),
    scales_power=True,
)
BATTERY = Input(
    "energy of the battery",
    "Wh",
    lambda trial: trial.aircraft.battery.battery_energy_wh,
    _battery,
    lambda used: (0.5 * used, 2.0 * used),
)
DISCHARGE = Input(
    "discharge efficiency",
    "-",
    lambda trial: trial.aircraft.battery.discharge_efficiency,
    lambda trial, value: trial.with_aircraft(battery={"discharge_efficiency": value}),
    lambda used: (0.5, 1.2),
)
TEMPERATURE = Input(
    "air and module temperature",
    "°C",
    lambda trial: float(trial.mission.air_state().temperature_c),
    _air,
    lambda used: (-50.0, 100.0),
)
TURBULENCE = Input(
    "turbulence, all day",
    "-",
    lambda trial: 0.0,
    lambda trial, value: _turbulence(trial, all_day=value),
    lambda used: (-0.6, 1.0),
    separate=False,
)
THERMALS = Input(
    "level power saved in thermals",
    "-",
    lambda trial: 0.0,
    lambda trial, value: _turbulence(trial, thermal=-value),
    lambda used: (0.0, 2.0),
)
WIND = Input(
    "easterly wind (FM, circle)",
    "m/s",
    lambda trial: 0.0,
    _wind,
    lambda used: (0.0, 8.0),
    separate=False,
)
FULL = Input(
    "charge that counts as full",
    "-",
    lambda trial: trial.full_charge,
    lambda trial, value: replace(trial, full_charge=value),
    lambda used: (0.9, 1.0),
)
LAUNCH = Input(
    "state of charge at launch",
    "-",
    lambda trial: trial.mission.launch.state_of_charge if trial.mission.launch else 1.0,
    lambda trial, value: trial.with_mission(
        launch=trial.mission.launch
        and trial.mission.launch.model_copy(update={"state_of_charge": value})
    ),
    lambda used: (0.3, 1.0),
)

_ASSUMED = "assumption"
_CAM_ERROR = Spread(
    SOLAR_POWER,
    1.0 - REPORTED_ERRORS["CAM"].rms,
    1.0 + REPORTED_ERRORS["CAM"].rms,
    "RMS error of CAM in flight, report's table 3",
    REPORTED_ERRORS["CAM"].rms,
)
_SKIES = Spread(CLEARNESS, 0.91, 1.02, "Ineichen and simplified Solis at Rafz, 21 June")
_E60 = Spread(MODULES, 0.230, 0.244, "assumption: 3 % of 0.237")
_AS2_LOAD = Spread(LOAD, 35.0, 46.0, flights.NEWS_81H)
_AS2_BATTERY = Spread(BATTERY, 705.0, 732.0, flights.PAPERS)
_AS2_DISCHARGE = Spread(DISCHARGE, 0.95, 1.0, _ASSUMED)
_CALM = Spread(TURBULENCE, 0.0, 0.1, "assumption: calm nights")
_AS2_WIND = Spread(WIND, 0.0, 5.0, flights.BLOG_28H)
_NEARLY_FULL = Spread(FULL, 0.98, 1.0, _ASSUMED)
_HOT = "assumption: air, to modules 12 K above it (report)"

MISSES = (
    Miss(
        flights.FLIGHT_81H,
        flights.FLIGHT_81H.quantity("excess time"),
        (
            _AS2_LOAD, _CAM_ERROR, _SKIES, _E60, _AS2_BATTERY, _AS2_DISCHARGE,
            Spread(TEMPERATURE, 21.3, 43.3, "assumption: 10 K colder, to modules 12 K warmer"),
            _CALM, _AS2_WIND,
        ),
    ),
    Miss(
        flights.FLIGHT_28H,
        flights.FLIGHT_28H.quantity("minimum state of charge"),
        (
            _AS2_LOAD, _CAM_ERROR, _SKIES, _E60, _AS2_BATTERY, _AS2_DISCHARGE,
            Spread(TEMPERATURE, 17.0, 37.0, f"{flights.REPORT}: 27 and 37 C; night assumed"),
            _CALM, _AS2_WIND,
        ),
    ),
    Miss(
        flights.FLIGHT_28H,
        flights.FLIGHT_28H.quantity("full charge on the first day (CEST)"),
        (
            _NEARLY_FULL, _CAM_ERROR, _SKIES, _AS2_LOAD, _AS2_BATTERY,
            Spread(LAUNCH, 0.57, 0.577, "57 and 57.7 %"),
        ),
    ),
    Miss(
        flights.FLIGHT_81H_CLOCK,
        flights.FLIGHT_81H_CLOCK.quantity("full charge on the second day (CEST)"),
        (_NEARLY_FULL, _CAM_ERROR, _SKIES, _AS2_LOAD, _AS2_BATTERY),
    ),
    Miss(
        flights.FLIGHT_27H,
        flights.FLIGHT_27H.quantity("minimum state of charge"),
        (
            Spread(LOAD, 16.0, 17.1, "16 W; 8 % more propulsion at 9.0 than at 8.4 m/s (polar)"),
            _CAM_ERROR, _SKIES,
            Spread(MODULES, 0.164, 0.174, "assumption: 3 % of 0.169"),
            Spread(BATTERY, 234.0, 254.0, "40 % of 2.44 kg, and 1.06 kg, of 240 Wh/kg"),
            Spread(DISCHARGE, 0.90, 1.0, _ASSUMED),
            Spread(TEMPERATURE, 10.0, 32.0, "assumption: night, to modules 12 K above the air"),
            Spread(TURBULENCE, 0.0, 0.2, "assumption: a rather windy night (ETH Life)"),
        ),
    ),
    Miss(
        flights.FLIGHT_48H,
        flights.FLIGHT_48H.quantity("time flown"),
        (
            Spread(LOAD, 90.0, 100.0, "assumption: 5 % of 95 W"),
            _CAM_ERROR,
            Spread(CLEARNESS, 0.99, 1.01, "Ineichen and simplified Solis at Tucson, 21 June"),
            Spread(MODULES, 0.193, 0.2, f"{flights.SOLONG_ENGINEER}: cells of 20 %"),
            Spread(BATTERY, 1200.0, 1240.0, "1.2 kWh, and 44 % of 12.8 kg of 220 Wh/kg"),
            Spread(DISCHARGE, 0.95, 1.0, f"{flights.SOLONG_ENGINEER}: over 95 % a cycle"),
            Spread(THERMALS, 0.0, 1.0, "assumption: at most a motor that is off at noon"),
        ),
    ),
    Miss(
        flights.SEASON,
        flights.SEASON.quantity("days of perpetual flight"),
        (
            _AS2_LOAD, _CAM_ERROR,
            Spread(CLEARNESS, 0.88, 1.0, "Ineichen and simplified Solis at Rafz, March, September"),
            _E60, _AS2_BATTERY, _AS2_DISCHARGE,
            Spread(TEMPERATURE, 5.0, 32.0, _ASSUMED),
            Spread(TURBULENCE, 0.0, 0.3, "assumption: thermals by day, gusts"),
        ),
    ),
)  # fmt: skip
