"""An aircraft whose propulsion is at its operating point, for tests."""

import sizing

VOLTAGE = {
    "cells_in_series": 6,
    "state_of_charge": [0.0, 0.1, 0.9, 1.0],
    "cell_voltage_v": [3.0, 3.4, 4.0, 4.2],
}
PARTS = {
    "kind": "operating_point",
    "propeller": {"diameter_m": 0.66, "pitch_m": 0.60, "mass_kg": 0.0},
    "gear": {"ratio": 5.0, "efficiency": 0.96, "mass_kg": 0.0},
    "motor": "maxon-re40-148867",
    "controller": {"resistance_ohm": 0.02, "freewheel_voltage_v": 0.7},
    "wiring_resistance_ohm": 0.03,
}
# The same parts by the classes of the library.
PROPULSOR = sizing.Propulsor(
    propeller=sizing.BladeElementPropeller(0.66, 0.60),
    motor=sizing.Motor.from_catalogue("maxon-re40-148867"),
    controller=sizing.Controller(resistance_ohm=0.02, freewheel_voltage_v=0.7),
    gear=sizing.Gear(ratio=5.0, efficiency=0.96),
    wiring_resistance_ohm=0.03,
)


def aircraft(overrides=None, *, voltage=VOLTAGE, base="atlantiksolar-design", **parts):
    """Return a shipped aircraft with these parts, changed; a part that is None is left out."""
    chain = {key: value for key, value in (PARTS | parts).items() if value is not None}
    values = {"battery.voltage": voltage, "airframe.propulsion": chain}
    return sizing.load_aircraft(base, values | (overrides or {}))
