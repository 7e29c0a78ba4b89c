"""Motor, controller and wiring behind turning shafts, by formulas of numbers and symbols.

Speed and power of the shafts come from exact or approximated propellers. Limits are not checked:
operating points beyond them have a power, and a share of each limit above 1.
"""

from __future__ import annotations

import numpy as np

from missions.air import Air
from sizing.propulsion.chain import OperatingPointPropulsion
from sizing.propulsion.electric import MotorState
from sizing.smooth import Value

# Iterations of the voltage behind the wiring; each leaves at most a hundredth of the error.
_WIRING_ROUNDS = 5


def motor_state(
    parts: OperatingPointPropulsion, rotation_per_s: Value, shaft_w: Value
) -> MotorState:
    """Return current and voltage of the motor behind the gear."""
    gear = parts.gear
    torque = shaft_w / (2.0 * np.pi * rotation_per_s) / (gear.ratio * gear.efficiency)
    return parts.motor_constants.state(60.0 * rotation_per_s * gear.ratio, torque)


def inlet(parts: OperatingPointPropulsion, state: MotorState, bus_v: Value) -> tuple[Value, Value]:
    """Return voltage [V] and power [W] at the controller."""
    voltage = bus_v
    for _ in range(_WIRING_ROUNDS if parts.wiring_resistance_ohm else 0):
        power_w = parts.controller.input_power_w(state, voltage)
        voltage = bus_v - parts.wiring_resistance_ohm * power_w / voltage
    return voltage, parts.controller.input_power_w(state, voltage)


def power_of_shafts_w(
    parts: OperatingPointPropulsion, rotation_per_s: Value, shaft_w: Value, bus_v: Value
) -> Value:
    """Return the electric power of all propulsors [W] at a rotation [1/s] and shaft power [W]."""
    inlet_v, power_w = inlet(parts, motor_state(parts, rotation_per_s, shaft_w), bus_v)
    return parts.propulsors * power_w * bus_v / inlet_v / parts.efficiency_factor


def shares_of_limits(
    parts: OperatingPointPropulsion,
    rotation_per_s: Value,
    shaft_w: Value,
    airspeed_m_per_s: Value,
    air: Air,
    bus_v: Value,
) -> dict[str, Value]:
    """Return the use of each limit of the parts over that limit [-]."""
    state = motor_state(parts, rotation_per_s, shaft_w)
    least_v = state.voltage_v + state.current_a * parts.controller.resistance_ohm
    wires_v = parts.wiring_resistance_ohm * parts.controller.input_power_w(state, least_v) / least_v
    diameter_m = parts.propeller.diameter_m
    if diameter_m is None:  # the files of the table have it
        diameter_m = parts.propeller.propeller.diameter_m
    tip = ((np.pi * rotation_per_s * diameter_m) ** 2 + airspeed_m_per_s**2) ** 0.5
    motor = parts.motor_constants
    used = {
        "bus_voltage": (least_v + wires_v) / bus_v,
        "tip_mach": tip / (air.speed_of_sound_m_per_s * parts.maximum_tip_mach),
    }
    if motor.maximum_current_a is not None:
        used["motor_current"] = state.current_a / motor.maximum_current_a
    if motor.maximum_power_w is not None:
        used["motor_power"] = state.current_a * state.voltage_v / motor.maximum_power_w
    return used
