"""A year of weather against loops in Python and in C, and 8,192 draws against one after the other.

Both loops do what the project does, from the same power at the nodes: dawns, the charge carried
over, the charge limit, days that close, and the endurance of a launch at every dawn. Their results
are compared with ours before anything is timed.
"""

from __future__ import annotations

import ctypes
import math
import shutil
import subprocess
import sys
import tempfile
from bisect import bisect_right
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.measuring import best_time_s, row
from missions.files.overrides import with_values
from missions.library import load_mission
from missions.mission import Mission
from missions.weather.files import load_weather
from missions.weather.record import Weather
from missions.weather.site import mission_at_site
from sizing.aircraft import Aircraft
from sizing.energy.carried_days import carried_over, dawns_of, flight_hours
from sizing.energy.power_balance import PowerBalance
from sizing.library import load_aircraft
from sizing.mass_budget import design_of
from sizing.parameters import MISSION_PREFIX
from sizing.results.analysis import analyse
from sizing.results.uncertainty import DEFAULT_SAMPLES
from sizing.sunlight import SolarModel
from sizing.uncertainty.inputs import sobol_points, uncertain_inputs
from sizing.uncertainty.propagation import Propagation
from sizing.weather_run import WeatherDays, weather_performance
from solar.sun import HOURS_PER_DAY
from solar.types import BoolArray, FloatArray

_SOURCE = Path(__file__).with_name("weather_bound.c")
_NAME, _DRAWS_NAME = "weather year", "uncertain inputs"
_SHORT = 1e-12
# Draws that are analysed one by one; the rest of their time is scaled.
_LOOPED_DRAWS = 48


class Flown(NamedTuple):
    """Dawns [h], days that close and endurances of launches at every dawn [h]; shape ``(day,)``."""

    dawn_h: FloatArray
    closes: BoolArray
    endurance_h: FloatArray


class Year(NamedTuple):
    """What the runs are given: power at the nodes, batteries, noons."""

    time_h: FloatArray
    solar_w: FloatArray
    load_w: FloatArray
    noon_h: FloatArray
    store: Any

    @classmethod
    def of(cls, aircraft: Aircraft, mission: Mission, weather: Weather) -> Year:
        """Year of an aircraft in a record."""
        days, design = WeatherDays.of(aircraft, mission, weather), design_of(aircraft, mission)
        power = aircraft.modules.area_m2 * days.specific_power_w_per_m2(days.light.recorded)
        noon_h = HOURS_PER_DAY / 2.0 - days.axis.midnight_h
        store = days.store(design.battery_energy_wh)
        return cls(
            days.axis.time_h,
            power,
            days.flown(design, None).load_w,
            noon_h,
            store,
        )


def weather_year() -> list[dict[str, Any]]:
    """All entries of this module."""
    return [*_energy(), *_whole(), _draws()]


def ours(year: Year) -> Flown:
    """The year as the project flies it."""
    store = year.store
    balance = PowerBalance.of(year.time_h, year.solar_w, year.load_w)
    carried = carried_over(balance, store, store.battery_energy_wh[:1], len(year.noon_h))
    dawns = dawns_of(balance, carried.day, store, year.noon_h)
    hours, _ = flight_hours(carried, dawns.hour, store.battery_energy_wh, dawns.deficit_wh)
    return Flown(dawns.hour, carried.closes(dawns), hours)


def _check(found: Flown, known: Flown) -> None:
    """A loop that computes something else is no measure."""
    np.testing.assert_allclose(found.dawn_h, known.dawn_h, atol=1e-9)
    np.testing.assert_array_equal(found.closes, known.closes)
    np.testing.assert_allclose(found.endurance_h, known.endurance_h, atol=1e-6)


def _at_site(mission: str, weather: Weather) -> Mission:
    return mission_at_site(load_mission(mission), weather, chosen=False)[0]


def _energy() -> list[dict[str, Any]]:
    """The energy of a year, its light given."""
    weather = load_weather("colorado-2023")
    aircraft, mission = load_aircraft("atlantiksolar-as2"), _at_site("rafz-july", weather)
    year = Year.of(aircraft, mission, weather)
    known, ours_s = ours(year), best_time_s(lambda: ours(year))
    work = (
        f"{len(known.closes)} days at 5 min, power given: days that close, endurance of every "
        "launch, charge limit"
    )
    loop = PythonYear(year)
    _check(loop.fly(), known)
    rows = [row(_NAME, work, ours_s, "plain Python loop", best_time_s(loop.fly, 2))]
    with tempfile.TemporaryDirectory() as folder:
        bound = CYear.compiled(Path(folder), year)
        if bound is not None:
            _check(bound.fly(), known)
            rows.append(row(_NAME, work, ours_s, "C loop, gcc -O3, one thread", bound.time_s()))
    return rows


def _whole() -> list[dict[str, Any]]:
    """Whole runs: light at flight altitude, and the year beside that of the clear sky."""
    weather, aircraft = load_weather("colorado-2023"), load_aircraft("atlantiksolar-as2")
    rows = []
    for model, mission, repeats in (
        ("CAM", "rafz-july", 5),
        ("VM", "rafz-loiter", 2),
        ("FM", "rafz-loiter", 1),
    ):
        there, solar = _at_site(mission, weather), SolarModel(model)  # type: ignore[arg-type]  # named above

        def run(there: Mission = there, solar: SolarModel = solar) -> Any:
            return weather_performance(aircraft, there, weather, solar)

        spent = best_time_s(run, repeats, warm_up=repeats > 1)
        work = f"a whole run, light included, under clouds and under a clear sky; {model}"
        rows.append(row(_NAME, work, spent, None, None))
    return rows


def _draws() -> dict[str, Any]:
    """Draws of uncertain inputs at once, and one analysis after the other."""
    aircraft, mission = load_aircraft("atlantiksolar-design"), load_mission("rafz-july")
    inputs = uncertain_inputs(aircraft, mission, SolarModel(), model_error=False)
    values = inputs.values(sobol_points(len(inputs), DEFAULT_SAMPLES, 0))

    def at_once() -> FloatArray:
        return Propagation(aircraft, mission, SolarModel()).flights(values).excess_time_h

    def one_by_one() -> list[float]:
        found = []
        for number in range(_LOOPED_DRAWS):
            of_craft: dict[str, Any] = {}
            of_mission: dict[str, Any] = {}
            for key, value in values.items():
                into = of_mission if key.startswith(MISSION_PREFIX) else of_craft
                into[key.removeprefix(MISSION_PREFIX)] = float(value[number])
            craft, where = with_values(aircraft, of_craft), with_values(mission, of_mission)
            found.append(float(analyse(craft, where).excess_time_h))
        return found

    np.testing.assert_allclose(at_once()[:_LOOPED_DRAWS], one_by_one(), atol=1e-6)
    ours_s, loop_s = best_time_s(at_once, 3), best_time_s(one_by_one, 2)
    work = (
        f"{DEFAULT_SAMPLES} draws of {len(inputs)} inputs, design and day of each; the peer "
        f"measured on {_LOOPED_DRAWS} draws and scaled"
    )
    peer_s = loop_s * DEFAULT_SAMPLES / _LOOPED_DRAWS
    return row(_DRAWS_NAME, work, ours_s, "loop over sizing.analyse", peer_s)


class PythonYear:
    """The year in plain Python; lists and floats, one interval after the other."""

    def __init__(self, year: Year) -> None:
        store = year.store
        self.net: list[list[float]] = (year.solar_w - year.load_w).tolist()
        self.full: list[float] = store.battery_energy_wh.tolist()
        self.noon: list[float] = year.noon_h.tolist()
        self.step = float(year.time_h[1] - year.time_h[0])
        self.eta_in = float(store.charge_efficiency)
        self.eta_out = float(store.discharge_efficiency)
        clock = store.clock
        assert clock is not None  # of this aircraft
        self.up_to, self.rate = float(clock.constant_up_to), float(clock.constant_rate_per_h)
        self.soc: list[float] = clock.state_of_charge.tolist()
        self.hours: list[float] = clock.hours.tolist()

    def fly(self) -> Flown:
        """All of it."""
        flows = [[self._flow(a, b) for a, b in pairwise(n)] for n in self.net]
        dawns = [self._dawn(day, flows[day]) for day in range(len(flows))]
        closes = self._closes(flows, dawns)
        energy_at, end_at = [-1.0] * len(flows), [0.0] * len(flows)
        endurance = [0.0] * len(flows)
        for day in range(len(flows) - 1, -1, -1):
            end = self._end(day, dawns[day], flows, energy_at, end_at)
            endurance[day] = min(end, 24.0 * len(flows)) - 24.0 * day - dawns[day][0]
        return Flown(np.array([d[0] for d in dawns]), np.array(closes), np.array(endurance))

    def _flow(self, left: float, right: float) -> tuple[float, float, float]:
        """Surplus, early and late deficit of an interval [Wh]."""
        above, below = max(left, 0.0) + max(right, 0.0), max(-left, 0.0) + max(-right, 0.0)
        total = 2.0 * (above + below)
        if total == 0.0:
            return 0.0, 0.0, 0.0
        surplus, deficit = above * above / total * self.step, below * below / total * self.step
        return (surplus, deficit, 0.0) if left < 0.0 else (surplus, 0.0, deficit)

    def _dawn(self, day: int, flows: list[tuple[float, float, float]]) -> tuple[float, int, bool]:
        """Hour, interval, and whether the interval's early deficit comes before."""
        net, charge, least = self.net[day], 0.0, np.inf
        found = (0.0, 0, False)
        k = 0
        while (k + 1) * self.step <= self.noon[day]:
            surplus, early, late = flows[k]
            if charge - early / self.eta_out < least:
                least = charge - early / self.eta_out
                falls = net[k] < 0.0
                share = 0.0 if not falls else 1.0 if net[k + 1] < 0.0 else _crossing(net, k)
                found = ((k + share) * self.step, k, falls)
            charge += self.eta_in * surplus - (early + late) / self.eta_out
            k += 1
        return (k * self.step, k, False) if charge < least else found

    def _charged(self, energy: float, full: float, surplus: float) -> float:
        target = min(energy + self.eta_in * surplus, full)
        after = min(target, energy + self.rate * full * self.step)
        if after <= max(energy, self.up_to * full):
            return after
        begun = _interpolated(self.soc, self.hours, min(energy / full, 1.0))
        limited = full * _interpolated(self.hours, self.soc, begun + self.step)
        return max(min(target, limited), energy)

    def _closes(self, flows: Any, dawns: Any) -> list[bool]:
        energy, eta = self.full[0], self.eta_out
        closes = [True] * len(flows)
        for day, of_day in enumerate(flows):
            full, (_, at, after_deficit) = self.full[day], dawns[day]
            for k, (surplus, early, late) in enumerate(of_day):
                left = energy - early / eta
                if left < -_SHORT * full:
                    self._mark(closes, day, k < at or (k == at and after_deficit))
                energy = max(left, 0.0)
                if surplus > 0.0:
                    energy = self._charged(energy, full, surplus)
                left = energy - late / eta
                if left < -_SHORT * full:
                    self._mark(closes, day, k < at)
                energy = max(left, 0.0)
            if day + 1 < len(flows):
                energy *= self.full[day + 1] / full
        return closes

    @staticmethod
    def _mark(closes: list[bool], day: int, before: bool) -> None:
        if not before:
            closes[day] = False
        elif day:
            closes[day - 1] = False

    def _end(
        self, first: int, dawn: Any, flows: Any, energy_at: list[float], end_at: list[float]
    ) -> float:
        """End of a flight, hours since the record's begin; infinite if it outlasts the record."""
        _, begin, after_deficit = dawn
        energy, eta, passed = self.full[first], self.eta_out, []
        end = np.inf
        for day in range(first, len(flows)):
            full = self.full[day]
            for k in range(begin, len(flows[day])):
                surplus, early, late = flows[day][k]
                deficit = 0.0 if after_deficit else early
                after_deficit = False
                left = energy - deficit / eta
                if left >= -_SHORT * full:
                    energy = max(left, 0.0)
                    if surplus > 0.0:
                        energy = self._charged(energy, full, surplus)
                    deficit = late
                    left = energy - deficit / eta
                if left < -_SHORT * full:
                    end = 24.0 * day + k * self.step + self._empty_h(day, k, deficit, eta * energy)
                    break
                energy = max(left, 0.0)
            begin = 0
            if end < np.inf or day + 1 == len(flows):
                break
            energy *= self.full[day + 1] / full
            if energy == energy_at[day + 1]:
                end = end_at[day + 1]
                break
            energy_at[day + 1] = energy
            passed.append(day + 1)
        for day in passed:
            end_at[day] = end
        return float(end)

    def _empty_h(self, day: int, k: int, deficit: float, served: float) -> float:
        net = self.net[day]
        left, right = max(-net[k], 0.0), max(-net[k + 1], 0.0)
        begin, length = 0.0, self.step
        if not net[k] < 0.0:
            begin = _crossing(net, k) * self.step
            length -= begin
        elif not net[k + 1] < 0.0:
            length *= _crossing(net, k)
        goal = min(max(served / deficit, 0.0), 1.0) * (left + right) / 2.0
        root = math.sqrt(max(left * left + 2.0 * (right - left) * goal, 0.0))
        return begin + length * min(2.0 * goal / max(left + root, 1e-300), 1.0)


def _crossing(net: list[float], k: int) -> float:
    return min(max(net[k] / (net[k] - net[k + 1]), 0.0), 1.0)


def _interpolated(x: list[float], y: list[float], at: float) -> float:
    if at >= x[-1]:
        return y[-1]
    i = max(bisect_right(x, at) - 1, 0)
    return y[i] + (y[i + 1] - y[i]) / (x[i + 1] - x[i]) * (at - x[i])


_DOUBLES = ctypes.POINTER(ctypes.c_double)


class _Year(ctypes.Structure):
    _fields_ = [
        *((name, ctypes.c_int) for name in ("days", "intervals", "clock_nodes")),
        *(
            (name, ctypes.c_double)
            for name in (
                *("step_h", "eta_charge", "eta_discharge"),
                *("constant_up_to", "constant_rate_per_h"),
            )
        ),
        *((name, _DOUBLES) for name in ("clock_soc", "clock_h", "net_w", "full_wh", "noon_h")),
    ]


class CYear:
    """The year in C."""

    def __init__(self, function: Callable[..., None], year: Year) -> None:
        self._function = function
        self._kept: list[Any] = []  # arrays alive
        store, days = year.store, len(year.noon_h)
        clock = store.clock
        self._year = _Year(
            *(days, len(year.time_h) - 1, len(clock.hours)),
            *(float(year.time_h[1]), store.charge_efficiency, store.discharge_efficiency),
            *(clock.constant_up_to, clock.constant_rate_per_h),
            self._pointer(clock.state_of_charge),
            self._pointer(clock.hours),
            self._pointer(year.solar_w - year.load_w),
            self._pointer(store.battery_energy_wh),
            self._pointer(year.noon_h),
        )
        self._dawn, self._hours, self._work = np.empty(days), np.empty(days), np.empty(2 * days)
        self._closes = np.empty(days, np.int32)

    @classmethod
    def compiled(cls, folder: Path, year: Year) -> CYear | None:
        """Compile the loop where there is a compiler."""
        compiler = shutil.which("gcc")
        if compiler is None:
            print("no gcc: the year is not measured against C", file=sys.stderr)
            return None
        library = folder / "weather_bound.so"
        command = [compiler, "-O3", "-shared", "-fPIC", str(_SOURCE), "-o", str(library), "-lm"]
        subprocess.run(command, check=True)
        function = ctypes.CDLL(str(library)).fly_year
        function.restype = None
        return cls(function, year)

    def _pointer(self, values: FloatArray) -> Any:
        array = np.ascontiguousarray(values, float)
        self._kept.append(array)
        return array.ctypes.data_as(_DOUBLES)

    def fly(self) -> Flown:
        """All of it."""
        closes = self._closes.ctypes.data_as(ctypes.POINTER(ctypes.c_int))
        arrays = (a.ctypes.data_as(_DOUBLES) for a in (self._dawn, self._hours, self._work))
        dawn, hours, work = arrays
        self._function(ctypes.byref(self._year), dawn, closes, hours, work)
        return Flown(self._dawn, self._closes != 0, self._hours)

    def time_s(self) -> float:
        """CPU time of one run, of many in a row [s]."""
        many = 20

        def runs() -> None:
            for _ in range(many):
                self.fly()

        return best_time_s(runs, 3) / many
