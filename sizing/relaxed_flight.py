"""What alone would make a limited flight perpetual: more battery, more modules, or a smaller load.

Battery and modules weigh what their file says, and the load grows with the mass as the aircraft's
model has it. Each change is the smallest on a scan whose value the simulator flies.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.design import Design, closed_design, measured_design, variables_of
from sizing.parameters import all_replaced, parameter
from sizing.performance import Performance, performance
from sizing.relaxation import Direction, Relaxation, rounded
from solar.types import FloatArray

LOAD = "load_w"
_BATTERY, _MODULES = "battery.mass_kg", "modules.area_m2"
_UNITS = {_BATTERY: "kg", _MODULES: "m2", LOAD: "W"}
# More than four times the battery or the modules is another aircraft; a load has to stay above 0.
_MOST, _LEAST = 4.0, 0.05
_VALUES = 40  # of a scan; a second one between two of them settles the value to 0.1 %


def relaxed_flight(aircraft: Aircraft, flown: Performance) -> tuple[Relaxation, ...]:
    """Smallest change of battery mass, module area and load that makes a flight perpetual.

    ``flown``: repeated days of the aircraft; perpetual flight is asked for in all their scenarios.
    The smallest relative change comes first; one that does not suffice within four times the
    battery or the modules, the wing's area, or a twentieth of the load is left out.
    """
    if flown.cycle.perpetual.all():
        return ()
    relaxations = [one for key in _UNITS for one in _relaxed(aircraft, flown, key)]
    return tuple(sorted(relaxations, key=lambda one: one.relative_change))


def _relaxed(aircraft: Aircraft, flown: Performance, key: str) -> Iterator[Relaxation]:
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
        perpetual = _worst_excess_h(aircraft, flown, key, present * factors) > 0.0
        if not perpetual.any():
            return
        first = int(np.argmax(perpetual))
        low, high = factors[first - 1] if first else low, factors[first]
    direction: Direction = "at most" if key == LOAD else "at least"
    value = rounded(present * high, direction)
    excess_h = float(_worst_excess_h(aircraft, flown, key, np.array([value]))[0])
    if excess_h > 0.0:
        yield Relaxation(key, _UNITS[key], present, direction, value, excess_h)


def _present(flown: Performance, key: str) -> float:
    """Value of the flight itself."""
    if key == LOAD:
        return float(flown.design.nominal_load_w(flown.mission))
    variables = flown.design.variables
    return float(variables.battery_mass_kg if key == _BATTERY else variables.module_area_m2)


def _worst_excess_h(
    aircraft: Aircraft, flown: Performance, key: str, values: FloatArray
) -> FloatArray:
    """Excess time in the worst scenario for each value of a quantity [h]."""
    design = _designs(aircraft, flown, key, values)
    cycle = performance(
        aircraft, flown.mission, flown.solar, day=flown.day, design=design, keep_trajectory=False
    ).cycle
    return np.asarray(cycle.excess_time_h.min(axis=-1))


def _designs(aircraft: Aircraft, flown: Performance, key: str, values: FloatArray) -> Design:
    """Design of each value, with its mass and load."""
    if key == LOAD:
        less_w = float(flown.design.nominal_load_w(flown.mission)) - values
        return flown.design._replace(constant_power_w=flown.design.constant_power_w - less_w)
    airframe = aircraft.airframe
    if not isinstance(airframe, MeasuredAirframe):
        variables = variables_of(aircraft)._replace(**{parameter(key).name: values})
        return closed_design(aircraft, flown.mission, variables)
    changed = {key: values}
    if key == _MODULES:
        more_kg = aircraft.modules.mass_kg_per_m2 * (values - aircraft.modules.area_m2)
        changed["airframe.mass_without_battery_kg"] = airframe.mass_without_battery_kg + more_kg
    return measured_design(all_replaced(aircraft, changed), flown.mission)
