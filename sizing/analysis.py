"""Analysis of one aircraft on one mission: every scenario's cycle, and the flight if it has one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.dates import date_code, date_label
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.altitude.climb_cycle import ClimbPerformance, climb_performance
from sizing.energy.cycle import Status
from sizing.energy.endurance import Endurance
from sizing.performance import Performance, performance
from sizing.replay import CalendarRun, calendar_run
from sizing.sunlight import SolarModel, solar_day
from solar._version import __version__

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Analysis:
    """Performance of an aircraft in the scenarios of a mission.

    ``low`` and ``high`` are the same with the solar power one RMS error of the model lower and
    higher. ``climb`` is there for a mission with climbs, which the three performances then have.
    """

    aircraft: Aircraft
    mission: Mission
    performance: Performance
    low: Performance
    high: Performance
    flight: CalendarRun | None
    climb: ClimbPerformance | None = None

    @property
    def worst(self) -> int:
        """Index of the scenario with the least excess time."""
        return self.performance.worst_scenario()


def analyse(
    aircraft: Aircraft, mission: Mission, solar: SolarModel, *, replay: bool = True
) -> Analysis:
    """Analyse an aircraft on a mission; ``replay`` flies the mission's launch if it has one."""
    rms = solar.rms_relative
    if mission.climb is not None:
        down, climbs, up = (
            climb_performance(aircraft, mission, solar, solar_factor=factor)
            for factor in (1.0 - rms, 1.0, 1.0 + rms)
        )
        return Analysis(
            aircraft,
            mission,
            climbs.performance,
            down.performance,
            up.performance,
            flight=None,
            climb=climbs,
        )
    day = solar_day(aircraft, mission, solar)
    low, centre, high = (
        performance(aircraft, mission, solar, day=day.scaled(factor))
        for factor in (1.0 - rms, 1.0, 1.0 + rms)
    )
    fly = replay and mission.launch is not None
    flight = calendar_run(aircraft, mission, solar) if fly else None
    return Analysis(aircraft, mission, centre, low, high, flight)


def finite(value: Any) -> float | None:
    """Number for JSON: null where it is infinite or not defined."""
    number = float(value)
    return number if math.isfinite(number) else None


def scenario_record(analysis: Analysis, index: int, endurance: Endurance | None) -> dict[str, Any]:
    """Metrics of one scenario, JSON-ready."""
    perf = analysis.performance
    cycle, account = perf.cycle, perf.cycle.energy_budget
    lit = perf.day.sunset_h[index] > perf.day.sunrise_h[index]
    record = {
        "excess_time_h": finite(cycle.excess_time_h[index]),
        "charge_margin_h": finite(cycle.charge_margin_h[index]),
        "endurance_h": None if endurance is None else finite(endurance.endurance_h),
        "best_launch_h": None if endurance is None else finite(endurance.launch_h),
        "minimum_state_of_charge": finite(cycle.minimum_state_of_charge[index]),
        "status": _status_name(int(cycle.status[index])),
        "sunrise_h": finite(perf.day.sunrise_h[index]) if lit else None,
        "sunset_h": finite(perf.day.sunset_h[index]) if lit else None,
        "equal_power_morning_h": finite(cycle.equal_power_morning_h[index]),
        "equal_power_evening_h": finite(cycle.equal_power_evening_h[index]),
        "full_charge_h": finite(cycle.full_charge_h[index]),
        "power_out_w": finite(np.broadcast_to(perf.nominal_load_w, cycle.status.shape)[index]),
        "solar_energy_wh": finite(account.solar_wh[index]),
        "load_energy_wh": finite(account.load_wh[index]),
        "curtailed_energy_wh": finite(account.curtailed_wh[index]),
        "model": perf.solar.model,
        "correction": perf.solar.correction,
        "latitude_deg": finite(perf.day.scenarios.latitude_deg[index]),
        "day_of_year": int(perf.day.scenarios.day_of_year[index]),
        "date": date_code(int(perf.day.scenarios.day_of_year[index])),
        "uncertainty": {
            "solar_power_rms_relative": perf.solar.rms_relative,
            "excess_time_low_h": finite(analysis.low.cycle.excess_time_h[index]),
            "excess_time_high_h": finite(analysis.high.cycle.excess_time_h[index]),
        },
    }
    if analysis.climb is not None:
        record["climb"] = climb_record(analysis.climb, analysis.mission, index)
    return record


def climb_record(climbs: ClimbPerformance, mission: Mission, index: int) -> dict[str, Any]:
    """What climbing does in one scenario, JSON-ready."""
    assert mission.climb is not None
    flown, account = climbs.climb, climbs.climb.energy_budget
    return {
        "strategy": mission.climb.strategy,
        "ceiling_m": mission.climb.ceiling_m,
        "maximum_altitude_m": finite(flown.maximum_altitude_m[index]),
        "gliding_h": finite(flown.gliding_h[index]),
        "stored_height_wh": finite(flown.maximum_height_wh[index]),
        "climb_energy_wh": finite(account.climb_electric_wh[index]),
        "constant_altitude_excess_time_h": finite(climbs.constant.cycle.excess_time_h[index]),
        "gain_in_excess_time_h": finite(climbs.gain_h[index]),
    }


def _status_name(status: int) -> str:
    """Status for users; a cycle without any solar power is one of the limited ones."""
    return Status.limited.name if status == Status.never_lit else Status(status).name


def to_json(analysis: Analysis) -> dict[str, Any]:
    """Whole analysis, JSON-ready; the top level is the worst scenario."""
    flights = _endurances(analysis)
    records = [scenario_record(analysis, i, flight) for i, flight in enumerate(flights)]
    design = analysis.performance.design
    result = dict(records[analysis.worst])
    result |= {
        "aircraft": analysis.aircraft.name,
        "mission": analysis.mission.name,
        "total_mass_kg": finite(design.total_mass_kg),
        "battery_energy_wh": finite(design.battery_energy_wh),
        "propulsion_power_w": finite(design.propulsion_power_w),
        "airspeed_m_per_s": (
            None if design.airspeed_m_per_s is None else finite(design.airspeed_m_per_s)
        ),
        "airspeed_above_wind": (
            None
            if design.airspeed_m_per_s is None
            else bool(design.airspeed_m_per_s > analysis.mission.wind_m_per_s)
        ),
        "version": __version__,
        "scenarios": records,
    }
    if analysis.flight is not None:
        result["flight"] = flight_record(analysis.flight)
    return result


def _endurances(analysis: Analysis) -> list[Endurance | None]:
    """Longest flights; with climbs those at constant altitude, which are no longer."""
    if analysis.climb is None:
        return analysis.performance.endurances()
    endless = analysis.performance.cycle.perpetual
    flights = analysis.climb.constant.endurances()
    return [None if e else flight for e, flight in zip(endless, flights, strict=True)]


def flight_record(flight: CalendarRun) -> dict[str, Any]:
    """Replayed flight, JSON-ready; clock times are local hours since the launch day's midnight."""
    return {
        "launch": f"{flight.launch.date} {flight.launch.time_local}",
        "utc_offset_h": flight.launch.utc_offset_h,
        "duration_h": float(flight.clock_h[-1] - flight.clock_h[0]),
        "full_charge_clock_h": list(flight.full_charge_clock_h),
        "minimum_state_of_charge": flight.minimum_state_of_charge,
        "final_state_of_charge": float(flight.state_of_charge[-1]),
        "empty_clock_h": flight.empty_clock_h,
    }


def trajectory_table(analysis: Analysis) -> pd.DataFrame:
    """Power and state of charge over the cycle of every scenario, one row per node."""
    import pandas as pd

    perf = analysis.performance
    scenarios = perf.day.scenarios
    nodes = len(perf.day.time_h)
    energy_max = float(perf.design.battery_energy_wh)
    table = pd.DataFrame(
        {
            "latitude_deg": np.repeat(scenarios.latitude_deg, nodes),
            "day_of_year": np.repeat(scenarios.day_of_year, nodes),
            "time_solar_h": np.tile(perf.day.time_h, len(scenarios)),
            "solar_power_w": perf.solar_power_w.ravel(),
            "load_w": perf.load_w.ravel(),
            "energy_wh": perf.cycle.energy_wh.ravel(),
            "state_of_charge": perf.cycle.energy_wh.ravel() / energy_max,
        }
    )
    if analysis.climb is not None:
        flown = analysis.climb.climb
        table["altitude_m"] = flown.altitude_m[:, flown.nodes].ravel()
    return table


def clock_label(clock_h: float | None, *, first_day: int | None = None) -> str:
    """Hours as a clock reading; with a first day, hours beyond 24 carry their date."""
    if clock_h is None or not math.isfinite(clock_h):
        return "-"
    minutes = round(clock_h * 60.0)
    days, rest = divmod(minutes, 24 * 60)
    reading = f"{rest // 60:02d}:{rest % 60:02d}"
    if first_day is None:
        return "24:00" if days == 1 and rest == 0 else reading
    return f"{date_label(first_day + days)} {reading}"
