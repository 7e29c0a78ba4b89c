"""What the mission makes of a flight, in numbers: battery in its air, wind, climbs, calendar."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from solar.types import FloatArray

if TYPE_CHECKING:
    from sizing.climb import ClimbPerformance
    from sizing.day.replay import CalendarRun
    from sizing.performance import Performance


class Spread(NamedTuple):
    """What changes with the days of a weather record."""

    lowest: float
    mean: float
    highest: float

    @classmethod
    def of(cls, values: Any) -> Spread:
        """Return the ends and the mean of values; nothing times what is below zero is plain 0."""
        return cls(*(float(end(values)) + 0.0 for end in (np.min, np.mean, np.max)))


class BatteryCondition(NamedTuple):
    """Battery in the air of a mission, or of the days of a weather record; aged as its file says.

    ``pack_temperature_c``: None where no temperature is held.
    """

    pack_temperature_c: float | Spread | None
    heater_power_w: float | Spread
    cycles: float | None
    months: float | None
    capacity_fraction: float | Spread
    charge_efficiency: float
    discharge_efficiency: float


def battery_condition(
    aircraft: Aircraft, mission: Mission, mass_kg: float | None = None
) -> BatteryCondition | None:
    """Return the battery as it is on a mission; the margin of its capacity is not counted.

    ``mass_kg``: that of a sized design. None for a battery without temperature, resistance and
    ageing.
    """
    air_c = mission.air_state().temperature_c
    return _condition(aircraft, air_c, mission.altitude_m, float, mass_kg)


def battery_condition_of_days(
    aircraft: Aircraft, air_c: FloatArray, altitude_m: float
) -> BatteryCondition | None:
    """Return the battery as it is in the mean air of each day [C], at an altitude."""
    return _condition(aircraft, air_c, altitude_m, Spread.of)


def _condition(
    aircraft: Aircraft,
    air_c: Any,
    altitude_m: float,
    reported: Callable[[Any], Any],
    mass_kg: float | None = None,
) -> BatteryCondition | None:
    battery, aged = aircraft.battery, aircraft.battery.ageing
    held, _ = battery.temperature_at(altitude_m)
    if not any((held, battery.resistance, aged)):
        return None
    return BatteryCondition(
        pack_temperature_c=None if held is None else reported(held.pack_c(air_c)),
        heater_power_w=reported(battery.heater_w(air_c, altitude_m, mass_kg)),
        cycles=None if aged is None else float(aged.total_cycles),
        months=None if aged is None else float(aged.total_months),
        capacity_fraction=reported(battery.capacity_fraction(air_c, altitude_m)),
        charge_efficiency=float(battery.mean_charge_efficiency),
        discharge_efficiency=float(battery.mean_discharge_efficiency),
    )


class Wind(NamedTuple):
    """Percentile of a table of winds, and its wind in every scenario [m/s]."""

    percentile: float
    hold_station: bool
    source: str
    scenarios_m_per_s: tuple[float, ...]


def wind_of(mission: Mission) -> Wind | None:
    """Return the wind of every scenario; None for one that the mission gives."""
    statistics = mission.wind_statistics
    if statistics is None:
        return None
    source = statistics.table(mission.longitude_deg).source
    winds = tuple(mission.scenario_winds_m_per_s().tolist())
    return Wind(statistics.percentile, statistics.hold_station, source, winds)


class ModelError(NamedTuple):
    """Excess time with the solar power one RMS error of its model lower and higher [h]."""

    solar_power_rms_relative: float
    excess_time_low_h: float
    excess_time_high_h: float

    @classmethod
    def of(cls, low: Performance, high: Performance, index: int | None = None) -> ModelError:
        """Return that of a scenario; by default the least of all, which may be another in each."""
        ends = (
            np.min(end.cycle.excess_time_h) if index is None else end.cycle.excess_time_h[index]
            for end in (low, high)
        )
        return cls(low.solar.rms_relative, *map(float, ends))


class ClimbOfDay(NamedTuple):
    """What climbing does in a scenario; ``held_up_to_m`` only where a place is held."""

    ceiling_m: float
    held_up_to_m: float | None
    maximum_altitude_m: float
    gliding_h: float
    stored_height_wh: float
    climb_energy_wh: float
    constant_altitude_excess_time_h: float
    gain_in_excess_time_h: float
    dawn_altitude_m: float

    @classmethod
    def of(cls, climbs: ClimbPerformance, mission: Mission, index: int) -> ClimbOfDay:
        """Return the climbs of a scenario; a sun that carries the load at night has no dawn."""
        assert mission.climb is not None
        perf, held_m = climbs.performance, climbs.held_up_to_m
        dawn_h = float(np.nan_to_num(perf.cycle.equal_power_morning_h[index]))
        return cls(
            ceiling_m=mission.climb.ceiling_m,
            held_up_to_m=None if held_m is None else float(held_m[index]),
            maximum_altitude_m=float(climbs.altitude_m[index].max()),
            gliding_h=float(climbs.gliding_h[index]),
            stored_height_wh=float(climbs.stored_height_wh[index]),
            climb_energy_wh=float(climbs.climb_energy_wh[index]),
            constant_altitude_excess_time_h=float(climbs.constant.cycle.excess_time_h[index]),
            gain_in_excess_time_h=float(climbs.gain_h[index]),
            dawn_altitude_m=float(np.interp(dawn_h, perf.day.time_h, climbs.altitude_m[index])),
        )


class CalendarFlight(NamedTuple):
    """Replayed flight; clock times are local hours since the launch day's midnight."""

    launch: str
    utc_offset_h: float
    duration_h: float
    full_charge_clock_h: tuple[float, ...]
    minimum_state_of_charge: float
    final_state_of_charge: float
    empty_clock_h: float | None

    @classmethod
    def of(cls, flight: CalendarRun) -> CalendarFlight:
        """Return the numbers of a replay."""
        return cls(
            launch=f"{flight.launch.date} {flight.launch.time_local}",
            utc_offset_h=flight.launch.utc_offset_h,
            duration_h=float(flight.clock_h[-1] - flight.clock_h[0]),
            full_charge_clock_h=flight.full_charge_clock_h,
            minimum_state_of_charge=flight.minimum_state_of_charge,
            final_state_of_charge=float(flight.state_of_charge[-1]),
            empty_clock_h=flight.empty_clock_h,
        )
