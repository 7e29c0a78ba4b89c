"""What temperature and age leave of the battery, for results."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from solar.types import FloatArray


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
    return _record(aircraft, air_c, altitude_m, _spread)


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


def _spread(values: Any) -> dict[str, float]:
    return {
        # Nothing times a temperature below zero is minus nothing.
        "lowest": float(np.min(values)) + 0.0,
        "mean": float(np.mean(values)) + 0.0,
        "highest": float(np.max(values)) + 0.0,
    }


def battery_line(aircraft: Aircraft, mission: Mission, mass_kg: float | None = None) -> str | None:
    """State of the battery in a line, such as ``battery at 12 C: 90 % of its capacity``.

    None where there is no record.
    """
    return _battery_line(aircraft, battery_record(aircraft, mission, mass_kg))


def battery_line_of_days(aircraft: Aircraft, air_c: FloatArray, altitude_m: float) -> str | None:
    """State of the battery on the days of a weather record in a line.

    None where there is no record.
    """
    return _battery_line(aircraft, battery_record_of_days(aircraft, air_c, altitude_m))


def _battery_line(aircraft: Aircraft, record: dict[str, Any] | None) -> str | None:
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
