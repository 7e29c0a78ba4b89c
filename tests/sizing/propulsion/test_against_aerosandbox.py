"""The propulsion functions of AeroSandbox (MIT licence) as independent numbers."""

import numpy as np
import pytest

from missions.air import standard_air
from sizing.propulsion.electric import Controller, Gear, Motor
from sizing.propulsion.operating_point import Propulsor, operating_point
from sizing.propulsion.propeller import BladeElementPropeller, Coefficients

pytestmark = pytest.mark.extra
asb = pytest.importorskip("aerosandbox")
electric = pytest.importorskip("aerosandbox.library.propulsion_electric")
propellers = pytest.importorskip("aerosandbox.library.propulsion_propeller")

MOTOR = Motor(speed_constant_rpm_per_v=317.0, resistance_ohm=0.299, no_load_current_a=0.137)


def test_motor_over_speed_and_torque():
    rpm, torque = np.meshgrid([500.0, 3000.0, 6000.0], [0.01, 0.05, 0.2])
    state = MOTOR.state(rpm, torque)
    theirs = electric.motor_electric_performance(
        rpm=rpm, torque=torque, kv=317.0, resistance=0.299, no_load_current=0.137
    )
    assert state.current_a == pytest.approx(theirs["current"])
    assert state.voltage_v == pytest.approx(theirs["voltage"])
    shaft = torque * rpm * np.pi / 30.0
    assert shaft / (state.current_a * state.voltage_v) == pytest.approx(theirs["efficiency"])


@pytest.mark.parametrize("thrust", [0.5, 2.0, 5.0])
@pytest.mark.parametrize("airspeed", [5.0, 8.4, 15.0])
def test_blade_elements_lose_to_the_actuator_disc(thrust, airspeed):
    air = standard_air(500.0)
    propulsor = Propulsor(BladeElementPropeller(0.66, 0.60), MOTOR, Controller(resistance_ohm=0.0))
    point = operating_point(propulsor, thrust, airspeed, air, 500.0)
    shaft_w = point.propeller_torque_nm * point.rotation_rpm * np.pi / 30.0
    area = np.pi / 4.0 * 0.66**2
    ideal = propellers.propeller_shaft_power_from_thrust(
        thrust, area, airspeed, float(air.density_kg_per_m3), 1.0
    )
    assert 0.3 * shaft_w < ideal < shaft_w


class _Disc:
    """AeroSandbox's propeller: an actuator disc of 0.9 at one tip speed, for one thrust."""

    diameter_m, trials = 0.66, 33

    def __init__(self, thrust_n, power_w, rotation_per_s):
        self.thrust_n, self.power_w, self.n = thrust_n, power_w, rotation_per_s

    def at(self, indices, shape=None):
        return self

    def limits(self):
        return (0.0, 5.0), (0.5 * self.n, 2.0 * self.n)

    def coefficients(self, airspeed_m_per_s, rotation_per_s, air):
        n = rotation_per_s + 0.0 * airspeed_m_per_s
        scale = air.density_kg_per_m3 * self.diameter_m**4 * self.n**2
        return Coefficients(
            self.thrust_n / scale + 0.0 * n,
            self.power_w / (scale * self.n * self.diameter_m) + 0.0 * n,
        )


def test_whole_chain():
    thrust, airspeed = 2.67, 8.4
    atmosphere = asb.Atmosphere(altitude=1000.0)
    theirs = electric.electric_propeller_propulsion_analysis(
        total_thrust=thrust,
        n_engines=1,
        propeller_diameter=0.66,
        op_point=asb.OperatingPoint(atmosphere=atmosphere, velocity=airspeed),
        propeller_tip_mach=0.1,
        motor_kv=317.0,
        motor_no_load_current=0.137,
        motor_resistance=0.299,
        wire_resistance=0.03,
        battery_voltage=22.2,
        # Version 4.2.10 divides the speed by the ratio, where its text says that the motor turns
        # faster: a gear of 5:1 is 0.2 there.
        gearbox_ratio=1.0 / 5.0,
        gearbox_efficiency=0.96,
        esc_efficiency=1.0,
        battery_discharge_efficiency=1.0,
    )
    air = standard_air(1000.0)
    disc = _Disc(thrust, theirs["shaft_power"], theirs["propeller_rpm"] / 60.0)
    gear, controller = Gear(ratio=5.0, efficiency=0.96), Controller(resistance_ohm=0.0)
    point = operating_point(
        Propulsor(disc, MOTOR, controller, gear, 0.03), thrust, airspeed, air, 22.2
    )
    assert point.rotation_rpm == pytest.approx(theirs["propeller_rpm"], rel=1e-6)
    assert point.motor_rpm == pytest.approx(theirs["motor_rpm"], rel=1e-6)
    assert point.motor_torque_nm == pytest.approx(theirs["motor_torque_per_motor"], rel=1e-6)
    assert point.propeller_efficiency == pytest.approx(theirs["propeller_efficiency"], rel=1e-6)
    # AeroSandbox takes the wiring's current at the battery's voltage, not at the controller's.
    assert point.bus_power_w == pytest.approx(theirs["battery_power"], rel=1e-5)
    assert point.efficiency == pytest.approx(theirs["overall_efficiency"], rel=1e-5)
