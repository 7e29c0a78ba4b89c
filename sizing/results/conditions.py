"""What the mission makes of a flight, in numbers: battery in its air, and wind."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from missions.mission import Mission
from sizing.aircraft import Aircraft


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
    aircraft: Aircraft, air_c: ArrayLike, altitude_m: float, mass_kg: float | None = None
) -> BatteryCondition | None:
    """Return the battery in air, or in the mean air of each day, at an altitude [C, m].

    The margin of its capacity is not counted. ``mass_kg``: that of a sized design. None for a
    battery without temperature, resistance and ageing.
    """
    reported: Callable[[Any], Any] = Spread.of if np.ndim(air_c) else float
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
