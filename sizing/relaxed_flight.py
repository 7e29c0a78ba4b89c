"""What suffices of one parameter; of a limited flight: more battery, more modules, a smaller load.

Battery and modules weigh what their file says, and the load grows with the mass as the aircraft's
model has it. Each change is the smallest on a scan whose value the simulator flies.
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
from solar.types import FloatArray

Direction = Literal["at least", "at most"]


@dataclass(frozen=True)
class Relaxation:
    """A parameter, and the value from which on the mission is feasible, all else unchanged.

    ``parameter``: key of the aircraft's or, behind ``mission.``, of the mission's file, or the
    whole load, ``load_w``. ``unit``: of the values. ``direction``: ``at least`` or ``at most``.
    ``value``: value that suffices, rounded to three digits away from the edge. ``excess_time_h``:
    worst excess time that the simulator finds there.
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
        return f"{self.parameter} {sign} {self.value:g}{unit} (now {self.present:g})"

    @property
    def relative_change(self) -> float:
        """Size of the change relative to the present value, to compare relaxations."""
        return abs(self.value - self.present) / max(abs(self.present), 1e-12)


def rounded(value: float, direction: Direction) -> float:
    """Value with three digits, on the safe side."""
    if value <= 0.0:
        return 0.0
    digits = 10.0 ** (math.floor(math.log10(value)) - 2)
    steps = value / digits
    return float(
        f"{(math.ceil(steps) if direction == 'at least' else math.floor(steps)) * digits:.6g}"
    )


LOAD = "load_w"
_BATTERY, _MODULES = "battery.mass_kg", "modules.area_m2"
_UNITS = {_BATTERY: "kg", _MODULES: "m2", LOAD: "W"}
# More than four times the battery or the modules is another aircraft; a load has to stay above 0.
_MOST, _LEAST = 4.0, 0.05
_VALUES = 40  # of a scan; a second one between two of them settles the value to 0.1 %


def relaxed_flight(
    aircraft: Aircraft, flown: Performance, total_mass_kg: float | None = None
) -> tuple[Relaxation, ...]:
    """Smallest change of battery mass, module area and load that makes a flight perpetual.

    ``flown``: repeated days of the aircraft; perpetual flight is asked for in all their scenarios.
    ``total_mass_kg``: where it is known it stays, and other mass gives way.
    The smallest relative change comes first; one that does not suffice within four times the
    battery or the modules, the wing's area, or a twentieth of the load is left out.
    """
    if flown.cycle.perpetual.all():
        return ()
    relaxations = [
        one for key in _UNITS for one in _smallest_change(aircraft, flown, key, total_mass_kg)
    ]
    return tuple(sorted(relaxations, key=lambda one: one.relative_change))


def _smallest_change(
    aircraft: Aircraft, flown: Performance, key: str, total_mass_kg: float | None
) -> Iterator[Relaxation]:
    """Relaxation of one quantity, if there is one."""
    present = _present(flown, key)
    if not present:
        return
    end = _LEAST if key == LOAD else _MOST
    if key == _MODULES and not isinstance(aircraft.airframe, MeasuredAirframe):
        end = min(end, float(flown.design.wing_area_m2) / present)
    if key != LOAD and end <= 1.0:
        return
    low, high = 1.0, end
    for _ in range(2):
        factors = np.geomspace(low, high, _VALUES + 1)[1:]
        perpetual = _worst_excess_h(aircraft, flown, key, present * factors, total_mass_kg) > 0.0
        if not perpetual.any():
            return
        first = int(np.argmax(perpetual))
        low, high = factors[first - 1] if first else low, factors[first]
    direction: Direction = "at most" if key == LOAD else "at least"
    value = rounded(present * high, direction)
    excess_h = float(_worst_excess_h(aircraft, flown, key, np.array([value]), total_mass_kg)[0])
    if excess_h > 0.0:
        yield Relaxation(key, _UNITS[key], present, direction, value, excess_h)


def _present(flown: Performance, key: str) -> float:
    """Value of the flight itself."""
    if key == LOAD:
        return float(flown.design.nominal_load_w(flown.mission))
    variables = flown.design.variables
    return float(variables.battery_mass_kg if key == _BATTERY else variables.module_area_m2)


def _worst_excess_h(
    aircraft: Aircraft, flown: Performance, key: str, values: FloatArray, total_kg: float | None
) -> FloatArray:
    """Excess time in the worst scenario for each value of a quantity [h]."""
    design = _designs(aircraft, flown, key, values, total_kg)
    cycle = performance(
        aircraft, flown.mission, flown.solar, day=flown.day, design=design, keep_trajectory=False
    ).cycle
    return np.asarray(cycle.excess_time_h.min(axis=-1))


def _designs(
    aircraft: Aircraft, flown: Performance, key: str, values: FloatArray, total_kg: float | None
) -> Design:
    """Design of each value, with its mass and load."""
    if key == LOAD:
        less_w = float(flown.design.nominal_load_w(flown.mission)) - values
        return flown.design._replace(constant_power_w=flown.design.constant_power_w - less_w)
    airframe = aircraft.airframe
    if not isinstance(airframe, MeasuredAirframe):
        variables = variables_of(aircraft)._replace(**{parameter(key).name: values})
        if total_kg is not None:
            return design_of_total_mass(aircraft, flown.mission, variables, total_kg)
        return closed_design(aircraft, flown.mission, variables)
    changed = {key: values}
    if key == _MODULES:
        more_kg = aircraft.modules.mass_kg_per_m2 * (values - aircraft.modules.area_m2)
        changed["airframe.mass_without_battery_kg"] = airframe.mass_without_battery_kg + more_kg
    if total_kg is not None:
        battery_kg = changed.get("battery.mass_kg", aircraft.battery.mass_kg)
        rest_kg = total_kg - flown.mission.payload.mass_kg - battery_kg
        changed["airframe.mass_without_battery_kg"] = np.where(rest_kg > 0.0, rest_kg, np.inf)
    return measured_design(all_replaced(aircraft, changed), flown.mission)
