"""What the mission makes of a flight, for results: battery in its air, wind, climbs."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.results import quantities as q
from sizing.results.records import change_text, climb_record, finite, hours, with_unit
from sizing.results.tables import Line
from solar.types import FloatArray

if TYPE_CHECKING:
    from sizing.climb import ClimbPerformance
    from sizing.program.result import SizingResult


def battery_record(
    aircraft: Aircraft, mission: Mission, mass_kg: float | None = None
) -> dict[str, Any] | None:
    """Battery as it is flown on a mission, JSON-ready.

    ``mission``: its air; the margin of its capacity is not counted. ``mass_kg``: that of a sized
    design. None for a battery without temperature, resistance and ageing.
    """
    air_c = mission.air_state().temperature_c
    return _record(aircraft, air_c, mission.altitude_m, float, mass_kg)


def battery_record_of_days(
    aircraft: Aircraft, air_c: FloatArray, altitude_m: float
) -> dict[str, Any] | None:
    """Battery as it is on the days of a weather record, JSON-ready.

    ``air_c``: mean temperature of the air of each day [C], at an altitude. Returns as
    :func:`battery_record`, with ``lowest``, ``mean`` and ``highest`` of what changes with the days.
    """
    return _record(aircraft, air_c, altitude_m, _ends_and_mean)


def _record(
    aircraft: Aircraft,
    air_c: Any,
    altitude_m: float,
    shown: Callable[[Any], Any],
    mass_kg: float | None = None,
) -> dict[str, Any] | None:
    """Battery in air of a temperature [C]; ``shown``: what is told of its numbers."""
    battery, aged = aircraft.battery, aircraft.battery.ageing
    held, _ = battery.temperature_at(altitude_m)
    if not any((held, battery.resistance, aged)):
        return None
    return {
        "pack_temperature_c": None if held is None else shown(held.pack_c(air_c)),
        "heater_power_w": shown(battery.heater_w(air_c, altitude_m, mass_kg)),
        "cycles": None if aged is None else float(aged.total_cycles),
        "months": None if aged is None else float(aged.total_months),
        "capacity_fraction": shown(battery.capacity_fraction(air_c, altitude_m)),
        "charge_efficiency": float(battery.mean_charge_efficiency),
        "discharge_efficiency": float(battery.mean_discharge_efficiency),
    }


def _ends_and_mean(values: Any) -> dict[str, float]:
    return {
        # Nothing times a temperature below zero is minus nothing.
        "lowest": float(np.min(values)) + 0.0,
        "mean": float(np.mean(values)) + 0.0,
        "highest": float(np.max(values)) + 0.0,
    }


def battery_line(aircraft: Aircraft, record: dict[str, Any] | None) -> str | None:
    """State of the battery in a line, such as ``battery at 12 °C: 90 % of its capacity``.

    ``record``: as it is flown on a mission, or on the days of a weather record; without one None.
    """
    if record is None:
        return None
    words = "battery"
    if record["pack_temperature_c"] is not None:
        words += f" at {_range(record['pack_temperature_c'])} °C"
    if record["cycles"] is not None:
        words += f", after {record['cycles']:.0f} cycles and {record['months']:.0f} months"
    words += f": {_range(record['capacity_fraction'], 100.0)} % of its capacity"
    heater_w = record["heater_power_w"]
    if not isinstance(heater_w, dict):
        words += f", heated with {heater_w:.1f} W" if heater_w > 0.0 else ""
    elif heater_w["highest"] > 0.0:
        mean_w, most_w = heater_w["mean"], heater_w["highest"]
        words += f", heated with {mean_w:.1f} W on average and up to {most_w:.1f} W"
    if aircraft.battery.resistance is not None:
        charge, discharge = record["charge_efficiency"], record["discharge_efficiency"]
        words += f", efficiencies {charge:.3f} (charge) and {discharge:.3f} (discharge)"
    return words


def _range(value: Any, factor: float = 1.0) -> str:
    """Number, or the ends of what changes with the days."""
    if not isinstance(value, dict):
        return f"{factor * value:.0f}"
    low, high = (f"{factor * value[end]:.0f}" for end in ("lowest", "highest"))
    return low if low == high else f"{low} to {high}"


def wind_record(mission: Mission) -> dict[str, Any] | None:
    """Percentile, table and wind of every scenario, JSON-ready; none for a given wind."""
    given = mission.wind_statistics
    if given is None:
        return None
    return {
        "percentile": given.percentile,
        "hold_station": given.hold_station,
        "source": given.table(mission.longitude_deg).source,
        "scenarios_m_per_s": mission.scenario_winds_m_per_s().tolist(),
    }


def wind_rows(mission: Mission) -> list[tuple[str, str]]:
    """Row of a table of facts: the wind, from the weakest to the strongest scenario."""
    given = mission.wind_statistics
    if given is None:
        return []
    heights_m = mission.climb_levels_m if given.hold_station else [mission.altitude_m]
    winds = [mission.at_altitude(one).scenario_winds_m_per_s() for one in heights_m]
    ends = dict.fromkeys(f"{w:.1f}" for w in (np.min(winds), np.max(winds)))
    source = given.table(mission.longitude_deg).source
    return [
        (
            f"wind, {given.percentile:g} % of the time at most"
            + (", at all heights" if len(heights_m) > 1 else ""),
            f"{' to '.join(ends)} m/s",
        ),
        ("winds from", source),
        *(
            [("flown, to hold its place", "as fast as the wind at least")]
            if given.hold_station
            else []
        ),
    ]


def climbs_record(climbs: ClimbPerformance, mission: Mission) -> dict[str, Any]:
    """Climbs of the optimum in its scenario of the least excess time, JSON-ready."""
    record = climb_record(climbs, mission, climbs.performance.worst_scenario())
    return record | {"dawn_altitude_m": finite(_dawn_altitude_m(climbs))}


def level_record(level: SizingResult) -> dict[str, Any]:
    """Optimum of level flight at the night's floor, JSON-ready."""
    design = level.design
    record = {
        "status": level.status.name,
        "objective_value": finite(level.objective_value),
    }
    return record | {
        one.name: None if design is None else finite(one.of(design))
        for one in (*q.CHOSEN, q.TOTAL_MASS)
    }


def climb_lines(
    mission: Mission,
    result: SizingResult,
    climbs: ClimbPerformance | None,
    level: SizingResult | None,
) -> list[Any]:
    """What the optimum's day looks like, and what it would be without climbs."""
    if climbs is None or result.design is None:
        return []
    assert mission.climb is not None
    floor_m, worst = mission.altitude_m, climbs.performance.worst_scenario()
    highest_m, gliding_h = float(climbs.altitude_m[worst].max()), float(climbs.gliding_h[worst])
    reached = "its ceiling of " if highest_m > mission.climb.ceiling_m - 1.0 else ""
    text = f"stays at {floor_m:.0f} m: no surplus, or no power, is left to climb with"
    if highest_m > floor_m + 1.0:
        text = (
            f"climbs by day from {floor_m:.0f} m to {reached}{highest_m:.0f} m, which stores "
            f"{float(climbs.stored_height_wh[worst]):.1f} Wh; glides {hours(gliding_h)} in "
            f"the evening; at dawn at {_dawn_altitude_m(climbs):.0f} m"
        )
    lines: list[Any] = [text]
    if level is not None:
        lines.append(Line(_without(mission, result, level)))
    return lines


def _without(mission: Mission, result: SizingResult, level: SizingResult) -> str:
    """The optimum of level flight, and how much larger it is."""
    where = f"in level flight at {mission.altitude_m:.0f} m"
    if level.design is None or result.design is None:
        return f"{where} no design was found ({level.status.label})"
    shown = [q.CHOSEN[0], q.TOTAL_MASS]
    parts = [
        f"{one.label} {one.fact(one.of(level.design))[1]} "
        f"({change_text(float(one.of(result.design)), float(one.of(level.design)))})"
        for one in shown
    ]
    if result.objective.variable not in [one.name for one in shown]:
        assert level.objective_value is not None
        assert result.objective_value is not None
        value = with_unit(level.objective_value, ".4g", result.objective)
        change = change_text(result.objective_value, level.objective_value)
        parts.insert(0, f"{result.objective.label} {value} ({change})")
    return f"{where}: {', '.join(parts)}"


def _dawn_altitude_m(climbs: ClimbPerformance) -> float:
    """Altitude at the morning's equal power, of a sun that always carries the load at midnight."""
    perf = climbs.performance
    worst = perf.worst_scenario()
    dawn_h = perf.cycle.equal_power_morning_h[worst]
    at_h = 0.0 if np.isnan(dawn_h) else float(dawn_h)
    return float(np.interp(at_h, perf.day.time_h, climbs.altitude_m[worst]))
