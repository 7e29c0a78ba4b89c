"""Analysis of an aircraft in a weather record: which days it flies through, and how long at all."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from operator import itemgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from missions.dates import MONTH_NAMES
from missions.mission import Mission, Scenarios
from missions.weather.files import mission_at_site
from missions.weather.record import Weather, longest_run
from sizing.aircraft import Aircraft
from sizing.battery.condition import BatteryTemperature
from sizing.day.light import SolarModel
from sizing.day.record import WeatherPerformance, WeatherRun, weather_performance
from sizing.results.design_result import BatteryCondition, battery_condition, check_subjects
from sizing.results.result import Result, data_frame, finite, percentiles
from sizing.validity.checks import (
    battery_checks,
    charge_rate_check,
    correction_check,
    design_checks,
    record_check,
)
from sizing.validity.extrapolations import collect_extrapolations, keep_worst
from sizing.validity.ranges import Extrapolation
from solar.names import CorrectionName, ModelName
from solar.sun import declination, sun_times
from solar.types import BoolArray, FloatArray, IntArray

if TYPE_CHECKING:
    import pandas as pd

# Windows whose waiting times are told [d].
WINDOWS_DAYS = (1, 2, 3, 5, 7)
# A year that lacks more days than these is told, and not counted among the whole ones.
_MISSING_DAYS, _DAYS = 7, 365
# Quantities that have the air of each day.
_OF_DAYS = ("pack_temperature_c", "air_temperature_c")
# Quantities of what is assumed high up, and the models that it stands for.
_ASSUMED = ("height_above_record_m", "altitude_m", "air_temperature_c")
_ASSUMPTIONS = ("weather_record", "module_temperature", "battery")


class Window(NamedTuple):
    """Consecutive days that close: how many days begin one, and the median wait for it [d].

    The wait is None where most launches wait in vain.
    """

    days: int
    starts: int
    median_wait_days: float | None


@dataclass(frozen=True, repr=False, eq=False)
class WeatherAnalysis(Result):
    """An aircraft in a weather record.

    Attributes
    ----------
    aircraft : Aircraft
    performance : WeatherPerformance
        Runs in the record's light and under a clear sky.
    notes : tuple of str
        What was changed to fly the mission at the record's site.
    """

    renderer = "studies.weather"

    aircraft: Aircraft
    performance: WeatherPerformance
    notes: tuple[str, ...] = ()

    @property
    def weather(self) -> Weather:
        """Record that is flown through."""
        return self.performance.days.weather

    @property
    def mission(self) -> Mission:
        """Mission at the record's site."""
        return self.performance.days.mission

    @cached_property
    def years(self) -> list[dict[str, Any]]:
        """Calendar years, or what of them is in the record; none of a typical year.

        ``whole``: at most a week is missing. ``longest_run_days``: most consecutive days that
        close. ``endurance_h``: of the launches at its dawns: ``p10``, ``p50``, ``p90`` [h].
        """
        run = self.performance.recorded
        return [
            {
                "year": year,
                "whole": closing["days"] >= _DAYS - _MISSING_DAYS,
                **closing,
                "longest_run_days": longest_run(run.closes[at]),
                "endurance_h": percentiles(run.endurance_h[at], "linear"),
                "share_of_days_that_close": closing["days_that_close"] / closing["days"],
            }
            for year, at, closing in self._by(run.axis.year)
            if not self.weather.typical
        ]

    @property
    def year_to_year(self) -> dict[str, Any] | None:
        """Spread of the whole years, by percentiles that occurred; None without two of them."""
        whole = [year for year in self.years if year["whole"]]
        if len(whole) < 2:
            return None
        share = itemgetter("share_of_days_that_close")
        return {
            "whole_years": len(whole),
            "days_that_close": percentiles([year["days_that_close"] for year in whole]),
            "longest_run_days": percentiles([year["longest_run_days"] for year in whole]),
            "median_endurance_h": percentiles([year["endurance_h"]["p50"] for year in whole]),
            "worst_year": min(whole, key=share)["year"],
            "best_year": max(whole, key=share)["year"],
        }

    @property
    def months(self) -> list[dict[str, Any]]:
        """Days that close, state of charge at dawn and endurance of every month."""
        run = self.performance.recorded
        return [
            {
                "month": MONTH_NAMES[month - 1],
                **closing,
                "median_dawn_state_of_charge": float(np.median(run.dawn_state_of_charge[at])),
                "median_endurance_h": float(np.median(run.endurance_h[at])),
            }
            for month, at, closing in self._by(run.axis.month)
        ]

    def _by(self, label: IntArray) -> Iterator[tuple[int, BoolArray, dict[str, int]]]:
        """Yield every label of the days, which of them have it, and how many of these close."""
        for each in np.unique(label).tolist():
            at = label == each
            runs = {"": self.performance.recorded, "clear_sky_": self.performance.clear}
            closing = {
                f"{of}days_that_close": int(run.closes[at].sum()) for of, run in runs.items()
            }
            yield each, at, {"days": int(np.count_nonzero(at)), **closing}

    @cached_property
    def endurance_h(self) -> dict[str, float]:
        """Percentiles of the endurance from a dawn [h]: ``p10``, ``p50``, ``p90``."""
        return percentiles(self.performance.recorded.endurance_h, "linear")

    @cached_property
    def flown_to_sunset_share(self) -> float:
        """Share of the days on which a launch at dawn, with a full battery, reaches sunset [-]."""
        run = self.performance.recorded
        sunset_h = sun_times(
            self.mission.latitudes()[0], declination(run.axis.day_of_year + 0.5)
        ).sunset_h
        return float(np.mean(run.outlasts | (self.dawn_solar_h + run.endurance_h >= sunset_h)))

    @property
    def dawn_solar_h(self) -> FloatArray:
        """Solar time of every dawn [h]."""
        return self.performance.recorded.dawn_h + self.performance.recorded.axis.midnight_h

    @cached_property
    def windows(self) -> tuple[Window, ...]:
        """Waiting times for windows of some days."""
        closes = self.performance.recorded.closes
        waits = {days: wait_for_window(closes, days) for days in WINDOWS_DAYS}
        return tuple(
            Window(days, int(np.count_nonzero(wait == 0.0)), finite(np.median(wait)))
            for days, wait in waits.items()
        )

    @cached_property
    def extrapolations(self) -> tuple[Extrapolation, ...]:
        """What the flight takes from outside the range of a model, each quantity once."""
        done, axis = self.performance, self.performance.recorded.axis
        aircraft, mission, design = self.aircraft, done.days.mission, done.design
        days = Scenarios(np.full(len(axis), mission.latitudes()[0]), axis.day_of_year)
        peak_w = np.max(done.recorded.solar_power_w, axis=1)
        of_air = battery_checks(aircraft.battery, done.days.mean_air_c, mission.altitude_m)
        always = [
            *design_checks(aircraft, mission, design, done.days.solar),
            record_check(mission, self.weather.site.altitude_m),
        ]
        of_days = [
            *(check for check in of_air if check.range.quantity in _OF_DAYS),
            *correction_check(days, done.days.solar, mission),
            *charge_rate_check(aircraft, mission, design, peak_w),
        ]
        constant = (check for check in always if check.range.quantity not in _OF_DAYS)
        outside = keep_worst(
            [
                *collect_extrapolations(constant),
                *collect_extrapolations(of_days, of=len(axis), what="days"),
            ]
        )
        return tuple(
            replace(row, worth=self._worth(row.model))
            if row.quantity in _ASSUMED and row.model in _ASSUMPTIONS
            else row
            for row in outside
        )

    def _worth(self, model: str) -> str:
        """Return in words what an assumption is worth, by the model that it replaces."""
        aircraft, mission, run = self.aircraft, self.mission, self.performance.recorded
        if model == "weather_record":
            share = 100.0 * self.share_of_clear_light()
            return (
                f"flown through are its clouds and its air: {share:.0f} % of the clear sky's light"
            )
        if model == "battery":
            unheated = aircraft.battery.model_copy(update={"temperature": BatteryTemperature()})
            colder = self._flown(aircraft.model_copy(update={"battery": unheated}), mission)
            return f"unheated {colder.closes.sum()} instead of {self.days_that_close} days close"
        air_c = float(mission.air_state().temperature_c)
        air = mission.air.model_copy(update={"module_temperature_c": air_c})
        colder = self._flown(aircraft, mission.model_copy(update={"air": air}))
        cold_w, warm_w = (float(np.sum(each.solar_power_w)) for each in (colder, run))
        percent = 100.0 * (cold_w / max(warm_w, 1e-9) - 1.0)
        return f"as cold as the air they would give {percent:+.0f} % of solar energy"

    def _flown(self, aircraft: Aircraft, mission: Mission) -> WeatherRun:
        solar = self.performance.days.solar
        return weather_performance(aircraft, mission, self.weather, solar).recorded

    @property
    def days(self) -> int:
        """Days of the record."""
        return len(self.performance.recorded.closes)

    @property
    def days_that_close(self) -> int:
        """Days that close in the record's light."""
        return int(self.performance.recorded.closes.sum())

    @property
    def irradiation_kwh_per_m2(self) -> float:
        """Global horizontal irradiation of the record [kWh/m²]."""
        return float(self.weather.ghi.sum() * self.weather.interval_s / 3.6e6)

    @property
    def battery_condition(self) -> BatteryCondition | None:
        """Battery in the mean air of the days; None where nothing there changes it."""
        done = self.performance
        return battery_condition(self.aircraft, done.days.mean_air_c, done.days.mission.altitude_m)

    def share_of_clear_light(self) -> float:
        """Return the light of the record over that of the clear sky, at flight altitude [-]."""
        light = self.performance.days.light
        up = np.maximum(light.cos_zenith, 0.0)
        recorded, clear = (
            float(np.sum(part.dni * up + part.dhi)) for part in (light.recorded, light.clear)
        )
        return recorded / clear if clear > 0.0 else 0.0

    def wind_above_airspeed_share(self) -> float | None:
        """Return the share of the time in which the wind exceeds the airspeed [-]."""
        wind, airspeed = (
            self.performance.days.light.wind_m_per_s,
            self.performance.design.airspeed_m_per_s,
        )
        if wind is None or airspeed is None:
            return None
        return float(np.mean(wind > float(airspeed)))

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each day: date, dawn, whether it closes, state of charge, endurance."""
        run, clear = self.performance.recorded, self.performance.clear
        axis = run.axis
        solar_w, clear_w, load_w = run.solar_power_w, clear.solar_power_w, run.load_w
        daily_wh = (np.trapezoid(w, axis.time_h, axis=1) for w in (solar_w, clear_w, load_w))
        solar_wh, clear_wh, load_wh = daily_wh
        return data_frame(
            {
                "year": axis.year,
                "day_of_year": axis.day_of_year,
                "date": [str(date)[5:] for date in axis.date],
                "dawn_solar_h": self.dawn_solar_h,
                "closes": run.closes,
                "clear_sky_closes": clear.closes,
                "dawn_state_of_charge": run.dawn_state_of_charge,
                "clear_sky_dawn_state_of_charge": clear.dawn_state_of_charge,
                "endurance_h": run.endurance_h,
                "outlasts_record": run.outlasts,
                "solar_energy_wh": solar_wh,
                "clear_sky_solar_energy_wh": clear_wh,
                "load_energy_wh": load_wh,
            }
        )

    def to_years_frame(self) -> pd.DataFrame:
        """Return a row for each year: days, days that close, longest run and endurance."""
        rows = [{**year} for year in self.years]
        for row in rows:
            row |= {f"endurance_{name}_h": h for name, h in row.pop("endurance_h").items()}
        return data_frame(rows)


def analyse_weather(
    aircraft: Aircraft,
    mission: Mission,
    weather: Weather,
    *,
    model: ModelName = "CAM",
    correction: CorrectionName = "none",
    mission_chosen: bool = True,
) -> WeatherAnalysis:
    """Analyse how an aircraft flies through a weather record, day after day.

    Parameters
    ----------
    aircraft : Aircraft
    mission : Mission
        Altitude, air, turbulence, payload, flight path and margins; it is flown at the record's
        site, on all days of the record. Its clearness plays no part.
    weather : Weather
        Record, see :func:`missions.load_weather`.
    model : {"CAM", "CDM", "VM", "FM"}
        Solar power model; VM and FM need module surfaces and a flight path.
    correction : {"none", "report", "loiter"}
        Correction of the model's systematic error.
    mission_chosen : bool
        Whether somebody chose the mission; one by default follows the record anywhere.

    Returns
    -------
    WeatherAnalysis

    Raises
    ------
    InputError
        If a chosen mission is far from the record's site or flies below its ground.
    TypeError
        For what is no aircraft, mission or weather.
    ValueError
        For an unknown model or correction, or a model that lacks surfaces or path.
    """
    check_subjects(aircraft, mission)
    if not isinstance(weather, Weather):
        got = type(weather).__name__
        raise TypeError(f"expected Weather (got {got}); missions.load_weather(path) reads one")
    there, notes = mission_at_site(mission, weather, chosen=mission_chosen)
    solar = SolarModel(model, correction)
    done = weather_performance(aircraft, there, weather, solar)
    if mission.pessimistic_clearness < 1.0:
        notes = (*notes, "the mission's clearness plays no part: the clouds are the record's")
    if mission.launch is not None:
        notes = (*notes, "launched at every dawn: the mission's launch plays no part")
    return WeatherAnalysis(aircraft, done, notes)


def wait_for_window(closes: BoolArray, days: int) -> FloatArray:
    """Return the days to wait, from every day, until a window of days that close begins.

    Returns whole days, 0 where a window begins; infinite where none comes before the record's end.
    """
    if days < 1:
        raise ValueError(f"a window has at least one day (got {days})")
    begins = np.empty(0, int)
    if days <= len(closes):
        windows = np.lib.stride_tricks.sliding_window_view(closes, days)
        begins = np.flatnonzero(windows.all(axis=1))
    every = np.arange(len(closes))
    return np.append(begins, np.inf)[np.searchsorted(begins, every)] - every
