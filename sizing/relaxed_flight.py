"""Relaxations of a limited flight: more battery, more modules, or a smaller load.

Masses of battery and modules, and the load by the total mass, follow the aircraft's models. Each
relaxation is the smallest feasible value of a scan by the simulator.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.design import Design, variables_of
from sizing.mass_budget import closed_design, design_of_total_mass, measured_design
from sizing.parameters import all_replaced, parameter
from sizing.performance import Performance, performance
from solar.schema import significant, spell
from solar.types import FloatArray

Direction = Literal["at least", "at most"]


@dataclass(frozen=True)
class Relaxation:
    """Value of a parameter at which the mission becomes feasible, all else unchanged.

    ``parameter``: key of the aircraft's file, with ``mission.`` of the mission's, or the whole
    load, ``load_w``. ``value``: sufficient value, rounded to three digits away from the edge.
    ``excess_time_h``: simulated excess time at that value in the critical scenario.
    """

    parameter: str
    unit: str
    present: float
    direction: Direction
    value: float
    excess_time_h: float

    @property
    def text(self) -> str:
        """Relaxation in words, for instance ``battery.specific_energy_wh_per_kg >= 287 Wh/kg``."""
        sign = ">=" if self.direction == "at least" else "<="
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{self.parameter} {sign} {spell(self.value)}{unit} (now {spell(self.present)})"

    @property
    def relative_change(self) -> float:
        """Size of the change relative to the present value [-]."""
        return abs(self.value - self.present) / max(abs(self.present), 1e-12)


def rounded(value: float, direction: Direction) -> float:
    """Return a value rounded to three digits, conservatively."""
    if value <= 0.0:
        return 0.0
    digits = 10.0 ** (math.floor(math.log10(value)) - 2)
    steps = value / digits
    whole = math.ceil(steps) if direction == "at least" else math.floor(steps)
    return significant(whole * digits)


LOAD = "load_w"
_BATTERY, _MODULES = "battery.mass_kg", "modules.area_m2"
_UNITS = {_BATTERY: "kg", _MODULES: "m2", LOAD: "W"}
# Largest change of battery and modules, and least load, relative to the present.
_MOST, _LEAST = 4.0, 0.05
_VALUES = 40  # of a scan; a second scan between two of them has steps of 0.1 %


def relaxed_flight(
    aircraft: Aircraft, perf: Performance, total_mass_kg: float | None = None
) -> tuple[Relaxation, ...]:
    """Return the smallest changes of battery mass, module area and load for perpetual flight.

    ``perf`` are the repeated days of the aircraft, all of which are to be perpetual. A known
    ``total_mass_kg`` stays, and other masses change. The smallest relative change comes first;
    changes beyond four times the battery or the modules, the wing's area, or a twentieth of the
    load are left out.
    """
    if perf.cycle.perpetual.all():
        return ()
    relaxations = [
        relaxation
        for key in _UNITS
        for relaxation in _smallest_change(aircraft, perf, key, total_mass_kg)
    ]
    return tuple(sorted(relaxations, key=lambda relaxation: relaxation.relative_change))


def _smallest_change(
    aircraft: Aircraft, perf: Performance, key: str, total_mass_kg: float | None
) -> Iterator[Relaxation]:
    """Yield the relaxation of a quantity, if there is one."""
    variables = perf.design.variables
    if key == LOAD:
        present = float(perf.design.nominal_load_w(perf.mission))
    else:
        present = float(variables.battery_mass_kg if key == _BATTERY else variables.module_area_m2)
    if not present:
        return
    end = _LEAST if key == LOAD else _MOST
    if key == _MODULES and not isinstance(aircraft.airframe, MeasuredAirframe):
        end = min(end, float(perf.design.wing_area_m2) / present)
    if key != LOAD and end <= 1.0:
        return
    low, high = 1.0, end
    for _ in range(2):
        factors = np.geomspace(low, high, _VALUES + 1)[1:]
        perpetual = _worst_excess_h(aircraft, perf, key, present * factors, total_mass_kg) > 0.0
        if not perpetual.any():
            return
        first = int(np.argmax(perpetual))
        low, high = factors[first - 1] if first else low, factors[first]
    direction: Direction = "at most" if key == LOAD else "at least"
    value = rounded(present * high, direction)
    excess_h = float(_worst_excess_h(aircraft, perf, key, np.array([value]), total_mass_kg)[0])
    if excess_h > 0.0:
        yield Relaxation(key, _UNITS[key], present, direction, value, excess_h)


def _worst_excess_h(
    aircraft: Aircraft, perf: Performance, key: str, values: FloatArray, total_kg: float | None
) -> FloatArray:
    """Return the critical scenario's excess time for each value of a quantity [h]."""
    design = _designs(aircraft, perf, key, values, total_kg)
    cycle = performance(
        aircraft, perf.mission, perf.solar, day=perf.day, design=design, keep_trajectory=False
    ).cycle
    return np.asarray(cycle.excess_time_h.min(axis=-1))


def _designs(
    aircraft: Aircraft, perf: Performance, key: str, values: FloatArray, total_kg: float | None
) -> Design:
    """Return the design for each value of a quantity, with its mass and load."""
    if key == LOAD:
        less_w = float(perf.design.nominal_load_w(perf.mission)) - values
        return perf.design._replace(constant_power_w=perf.design.constant_power_w - less_w)
    airframe = aircraft.airframe
    if not isinstance(airframe, MeasuredAirframe):
        variables = variables_of(aircraft)._replace(**{parameter(key).name: values})
        if total_kg is not None:
            return design_of_total_mass(aircraft, perf.mission, variables, total_kg)
        return closed_design(aircraft, perf.mission, variables)
    changed = {key: values}
    if key == _MODULES:
        more_kg = aircraft.modules.mass_kg_per_m2 * (values - aircraft.modules.area_m2)
        changed["airframe.mass_without_battery_kg"] = airframe.mass_without_battery_kg + more_kg
    if total_kg is not None:
        battery_kg = changed.get("battery.mass_kg", aircraft.battery.mass_kg)
        rest_kg = total_kg - perf.mission.payload.mass_kg - battery_kg
        changed["airframe.mass_without_battery_kg"] = np.where(rest_kg > 0.0, rest_kg, np.inf)
    return measured_design(all_replaced(aircraft, changed), perf.mission)
