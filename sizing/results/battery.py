"""What temperature and age leave of the battery, for results."""

from __future__ import annotations

from typing import Any

from missions.mission import Mission
from sizing.aircraft import Aircraft


def battery_record(aircraft: Aircraft, mission: Mission) -> dict[str, Any] | None:
    """Battery as it is flown on a mission, JSON-ready.

    Parameters
    ----------
    aircraft : Aircraft
    mission : Mission
        Its air; the margin of its capacity is not counted.

    Returns
    -------
    dict or None
        None for a battery without temperature, resistance and ageing.
    """
    battery = aircraft.battery
    if battery.temperature is None and battery.resistance is None and battery.ageing is None:
        return None
    air_c = float(mission.air_state().temperature_c)
    held, aged = battery.temperature, battery.ageing
    return {
        "pack_temperature_c": None if held is None else float(held.pack_c(air_c)),
        "heater_power_w": float(battery.heater_w(air_c)),
        "cycles": None if aged is None else float(aged.total_cycles),
        "months": None if aged is None else float(aged.total_months),
        "capacity_fraction": float(battery.capacity_fraction(air_c)),
        "charge_efficiency": float(battery.mean_charge_efficiency),
        "discharge_efficiency": float(battery.mean_discharge_efficiency),
    }


def battery_line(aircraft: Aircraft, mission: Mission) -> str | None:
    """State of the battery in a line, such as ``battery at 12 C: 90 % of its capacity``.

    Parameters
    ----------
    aircraft, mission
        As for :func:`battery_record`.

    Returns
    -------
    str or None
        None where there is no record.
    """
    record = battery_record(aircraft, mission)
    if record is None:
        return None
    words = "battery"
    if record["pack_temperature_c"] is not None:
        words += f" at {record['pack_temperature_c']:.0f} C"
    if record["cycles"] is not None:
        words += f", after {record['cycles']:.0f} cycles and {record['months']:.0f} months"
    words += f": {100.0 * record['capacity_fraction']:.0f} % of its capacity"
    if record["heater_power_w"] > 0.0:
        words += f", heated with {record['heater_power_w']:.1f} W"
    if aircraft.battery.resistance is not None:
        charge, discharge = record["charge_efficiency"], record["discharge_efficiency"]
        words += f", efficiencies {charge:.3f} (charge) and {discharge:.3f} (discharge)"
    return words
