"""Capacity tests: specific energy of a battery, from full to empty at about the load of flight.

What the terminals deliver is the energy times the discharge efficiency of the file. The integral
is that of the trapezoidal rule, from row to row of a run.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.integrate import trapezoid

from sizing.aircraft import Aircraft
from studies.bench.tables import BenchTable, Layout, Quantity
from studies.bench.values import Measured, linear_fit, parameter

LAYOUT = Layout(
    "capacity",
    "Discharge of a pack or a cell from full to empty; runs one below the other.",
    (
        Quantity("run", "number of the discharge", 1, 1e4),
        Quantity("time_s", "since the start of the run", 0, 1e7),
        Quantity("current_a", "out of the battery", 0, 1e4),
        Quantity("voltage_v", "at the terminals", 0, 1e4),
        Quantity("mass_kg", "of what is tested", 1e-3, 1e5),
    ),
    tuple((1.0, t, 0.68, v, 0.0486) for t, v in (
        (0, 4.17), (1800, 4.05), (3600, 3.94), (7200, 3.74), (10800, 3.57), (14400, 3.40),
        (16200, 3.22), (17400, 2.95), (17880, 2.50),
    )),
)  # fmt: skip
# Standard uncertainty of current and voltage together: assumption.
METER_SIGMA = 0.01
_LONGEST_STEP = 0.25  # of a run: a longer gap is no measurement


def evaluate(table: BenchTable, aircraft: Aircraft) -> Sequence[Measured]:
    """Specific energy of the runs."""
    runs = np.unique(table["run"]).tolist()
    found = np.array([_specific_energy(table, number) for number in runs])
    found = found / float(aircraft.battery.mean_discharge_efficiency)
    (value,), covariance, free = linear_fit(np.ones((len(found), 1)), found)
    count = len(runs)
    notes = [
        f"{table.source}: {count} run{'' if count == 1 else 's'} from full to empty; meter right "
        f"to {METER_SIGMA:.0%} (assumption), discharge efficiency as in the file",
    ]
    if aircraft.battery.cell_mass_fraction == 1.0:
        notes.append("a cell's energy per mass is that of the pack only if nothing else weighs")
    scatter = math.sqrt(float(covariance[0, 0]))
    parts = (float(value), scatter, free, METER_SIGMA * float(value), tuple(notes))
    return [Measured(parameter("specific_energy"), *parts)]


def _specific_energy(table: BenchTable, number: float) -> float:
    """Energy at the terminals over the mass [Wh/kg]."""
    own = table["run"] == number
    time_s, mass_kg = table["time_s"][own], table["mass_kg"][own]
    if np.count_nonzero(own) < 3 or (np.diff(time_s) <= 0.0).any():
        raise table.refused(f"run {number:g}: time_s must rise over 3 rows or more")
    if np.ptp(mass_kg) > 0.0:
        raise table.refused(f"run {number:g}: mass_kg changes within the run")
    if np.diff(time_s).max() > _LONGEST_STEP * (time_s[-1] - time_s[0]):
        raise table.refused(
            f"run {number:g}: {np.diff(time_s).max():g} s lie between two rows (allowed: at most "
            f"{_LONGEST_STEP:.0%} of the run)"
        )
    power = table["current_a"][own] * table["voltage_v"][own]
    return float(trapezoid(power, time_s)) / 3600.0 / float(mass_kg[0])
