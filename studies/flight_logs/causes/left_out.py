"""Samples that say nothing of the modules: those in which the battery limits the power."""

from __future__ import annotations

import numpy as np

from missions.logs.table import FlightLog
from sizing.aircraft import Aircraft
from sizing.energy.battery import NoChargeLimit, charge_rate_per_h
from solar.types import BoolArray, FloatArray
from studies.flight_logs.errors import moving_average
from studies.flight_logs.log_view import SMOOTH_S

# State of charge from which a battery may take less; share of what load and battery take from which
# power may be limited by them: batteries of one type differ, and so does the logged charge.
NEAR_FULL, OF_LIMIT = 0.85, 0.8
# Load and power that are alike, as a share of rated power, where no charge is logged.
_ALIKE = 0.05


def may_be_limited(log: FlightLog, aircraft: Aircraft) -> BoolArray:
    """Samples in which the battery may hold power back, by what is logged; no model decides."""
    modules, battery = aircraft.modules, aircraft.battery
    rated = modules.full_load_w_per_m2 * modules.area_m2
    run = log.segment()

    def smooth(values: FloatArray) -> FloatArray:
        return moving_average(values, run, log.time_s, SMOOTH_S)

    power = smooth(log.solar_power_w)
    load = None if log.load_w is None else smooth(np.nan_to_num(log.load_w))
    if log.state_of_charge is None:
        if load is None:
            return np.zeros(len(log), bool)
        return np.asarray((np.abs(power - load) < _ALIKE * rated) & (power > 0.0))
    charge = np.clip(np.nan_to_num(log.state_of_charge, nan=0.0), 0.0, 1.0)
    if load is None:
        return charge >= NEAR_FULL
    if isinstance(battery.charge_limit, NoChargeLimit):
        return (charge >= NEAR_FULL) & (power > OF_LIMIT * load)
    taken = charge_rate_per_h(battery.charge_limit, charge) * battery.battery_energy_wh
    taken = taken / float(battery.mean_charge_efficiency)
    taken = np.where(taken < load, 0.0, taken)  # as good as full
    return np.asarray((charge >= NEAR_FULL) & (power > OF_LIMIT * (taken + load)))
