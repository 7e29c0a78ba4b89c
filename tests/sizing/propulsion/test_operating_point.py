from pathlib import Path

import numpy as np
import pytest
from propulsors import aircraft

from missions.air import standard_air
from sizing.battery.battery import BatteryVoltage
from sizing.propulsion.electric import Controller, Gear, Motor, MotorState
from sizing.propulsion.nearby import NearbyPropulsion
from sizing.propulsion.operating_point import Propulsor, operating_point
from sizing.propulsion.propeller import BladeElementPropeller
from sizing.propulsion.propeller_files import read_propeller

UIUC = Path(__file__).parent / "uiuc"
AIR = standard_air(1000.0)
RE40 = Motor.from_catalogue("maxon-re40-148867")
# AtlantikSolar: 0.66 m by 0.60 m and 5:1; gearbox 0.96.
SIZE = BladeElementPropeller(0.66, 0.60)
CONTROLLER = Controller(
    resistance_ohm=0.02, freewheel_voltage_v=0.7, switching_loss=0.005, idle_power_w=0.2
)
GEAR = Gear(ratio=5.0, efficiency=0.96)
PROPULSOR = Propulsor(SIZE, RE40, CONTROLLER, GEAR, 0.03)


def motor(constant=317.0, **more):
    values = {"resistance_ohm": 0.299, "no_load_current_a": 0.137, **more}
    return Motor(speed_constant_rpm_per_v=constant, **values)


def test_thrust_torque_and_power_are_those_of_the_propeller():
    point = operating_point(PROPULSOR, 2.67, 8.4, AIR, 22.0)
    n = point.rotation_rpm / 60.0
    coefficients = SIZE.coefficients(8.4, n, AIR)
    rho = AIR.density_kg_per_m3
    assert coefficients.thrust * rho * n**2 * 0.66**4 == pytest.approx(2.67)
    assert coefficients.power * rho * n**3 * 0.66**5 == pytest.approx(
        float(2 * np.pi * n * point.propeller_torque_nm)
    )
    assert point.motor_rpm == pytest.approx(float(5 * point.rotation_rpm))
    assert point.motor_torque_nm == pytest.approx(float(point.propeller_torque_nm / 5 / 0.96))


def test_what_is_lost_adds_up():
    thrust = np.array([0.5, 2.67, 8.0])
    point = operating_point(PROPULSOR, thrust, 8.4, AIR, np.array([[22.0], [25.2]]))
    assert point.efficiency.shape == (2, 3)
    assert point.feasible.all()
    budget = point.budget_w()
    assert list(budget) == ["thrust", "propeller", "gear", "motor", "controller", "wiring"]
    assert sum(budget.values()) == pytest.approx(point.bus_power_w)
    assert all(np.all(share > 0.0) for share in budget.values())
    links = ("propeller", "gear", "motor", "controller", "wiring")
    product = np.prod([getattr(point, f"{link}_efficiency") for link in links], axis=0)
    assert product == pytest.approx(point.efficiency)
    # Currents and voltages, by hand.
    current, voltage = point.motor_current_a, point.motor_voltage_v
    copper = current**2 * 0.299 + 0.137 * point.motor_rpm / 317.0
    assert budget["motor"] == pytest.approx(copper)
    assert budget["wiring"] == pytest.approx(point.bus_current_a**2 * 0.03)
    inlet = point.bus_power_w / point.bus_current_a - point.bus_current_a * 0.03
    assert point.duty * inlet - (1 - point.duty) * 0.7 == pytest.approx(voltage + 0.02 * current)


def test_part_load_of_the_controller_costs_at_high_voltage():
    point = operating_point(PROPULSOR, 2.67, 8.4, AIR, np.array([18.0, 25.2, 50.0]))
    assert np.all(np.diff(point.controller_efficiency) < 0.0)
    ideal = Propulsor(SIZE, RE40, Controller(resistance_ohm=0.0), GEAR)
    same = operating_point(ideal, 2.67, 8.4, AIR, np.array([18.0, 50.0]))
    assert same.bus_power_w[0] == pytest.approx(same.bus_power_w[1])
    assert np.all(same.controller_efficiency == 1.0)


def table_9x6():
    return Propulsor(read_propeller(sorted(UIUC.glob("apce_9x6_rd*.txt"))), RE40, CONTROLLER)


def table_10x7():
    run = UIUC / "apce_10x7_pg0818_6519.txt"
    return Propulsor(read_propeller(run, any_speed=True), RE40, CONTROLLER)


def limited(**limits):
    return Propulsor(SIZE, motor(**limits), CONTROLLER, GEAR)


@pytest.mark.parametrize(
    ("propulsor", "thrust_airspeed_bus", "reason"),
    [
        (PROPULSOR, (2.67, 8.4, 12.0), "12 V is below 15.26 V, which 4592 rpm of the motor"),
        (limited(maximum_current_a=1.0), (2.67, 8.4, 22.0), "motor current 2.2 A is above 1 A"),
        (limited(maximum_power_w=30.0), (2.67, 8.4, 22.0), "motor power 33.3 W is above 30 W"),
        (
            Propulsor(SIZE, motor(), CONTROLLER, maximum_tip_mach=0.3),
            (60.0, 8.4, 500.0),
            "is above 0.3: a larger propeller turns slower",
        ),
        (
            table_10x7(),
            (500.0, 12.0, 22.0),
            "N, the most at 12 m/s in the propeller's data (J from 0.376 to 0.869)",
        ),
        (
            table_9x6(),
            (2.0, 30.0, 22.0),
            "an airspeed of 30 m/s lies outside the propeller's data (J from 0.095 to 0.804 and "
            "from 4003 to 6701 rpm)",
        ),
        (PROPULSOR, (1.0, 200.0, 22.0), "brakes at 200 m/s, at every speed of rotation"),
        (table_9x6(), (0.2, 5.0, 22.0), "thrust 0.2 N is below 1.18 N, the least at 5 m/s"),
    ],
)
def test_what_cannot_be_done_has_a_reason(propulsor, thrust_airspeed_bus, reason):
    thrust, airspeed, bus = thrust_airspeed_bus
    point = operating_point(propulsor, thrust, airspeed, AIR, bus)
    assert reason in str(point.reason)
    assert not point.feasible
    assert np.isnan(point.bus_power_w)
    assert np.isnan(point.efficiency)


def test_a_gap_between_two_speeds_is_told(tmp_path):
    # At 3000 and 6000 rpm no advance ratio is common: between them the table has nothing.
    slow, middle = ".1,.10,.05,3000\n.3,.09,.05,3000\n", ".5,.06,.05,6000\n.9,.01,.02,6000\n"
    path = tmp_path / "gap.csv"
    fast = ".05,.11,.05,9000\n.9,.11,.12,9000\n"
    path.write_text(f"J,CT,CP,rpm\n{slow}{middle}{fast}", encoding="utf-8")
    propulsor = Propulsor(read_propeller(path, diameter_m=0.25), RE40, CONTROLLER)
    v = 0.3 * 50.0 * 0.25
    point = operating_point(propulsor, [3.0, 500.0], v, AIR, 220.0)
    assert point.reason[0].startswith("thrust 3 N at 3.75 m/s lies in a gap of the propeller's")
    assert point.reason[1].startswith("thrust 500 N is above 10.7 N, the most at 3.75 m/s")


def test_the_voltage_told_is_the_least_that_does():
    point = operating_point(PROPULSOR, 2.67, 8.4, AIR, 12.0)
    needed = float(str(point.reason).split("below ")[1].split(" V")[0])
    bus = np.array([needed - 0.01, needed])
    assert list(operating_point(PROPULSOR, 2.67, 8.4, AIR, bus).feasible) == [False, True]


def test_a_table_pulls_between_its_speeds():
    table = read_propeller(sorted(UIUC.glob("apce_9x6_rd*.txt")))
    propulsor = Propulsor(table, motor(1000.0), CONTROLLER)
    point = operating_point(propulsor, np.array([2.0, 3.0]), 8.0, AIR, 15.0)
    assert point.feasible.all()
    n = point.rotation_rpm / 60.0
    thrust = table.coefficients(8.0, n).thrust * AIR.density_kg_per_m3 * n**2 * table.diameter_m**4
    assert thrust == pytest.approx([2.0, 3.0])
    assert np.all((point.rotation_rpm > 4003) & (point.rotation_rpm < 6701))


def test_parts_of_one_efficiency_have_it_at_every_load():
    motor = Motor(speed_constant_rpm_per_v=300.0, efficiency=0.82)
    parts = Propulsor(SIZE, motor, Controller(efficiency=0.9), GEAR)
    point = operating_point(parts, np.array([0.5, 2.67, 8.0]), 8.4, AIR, 22.0)
    assert point.motor_efficiency == pytest.approx(0.82)
    assert point.controller_efficiency == pytest.approx(0.9)
    chain = point.propeller_efficiency * 0.96 * 0.82 * 0.9
    assert point.efficiency == pytest.approx(chain)
    static = operating_point(PROPULSOR, 5.0, 0.0, AIR, 22.0)
    assert static.feasible
    assert static.efficiency == 0.0 < static.bus_power_w
    assert point.duty == pytest.approx(point.motor_rpm / 300.0 / 22.0)


MOTOR_KEYS = {"speed_constant_rpm_per_v": 300.0, "resistance_ohm": 0.3, "no_load_current_a": 0.1}
SIZE_AND_PARTS = {"propeller": SIZE, "motor": RE40, "controller": CONTROLLER}


def without(key):
    return {other: value for other, value in MOTOR_KEYS.items() if other != key}


def point_of(*arguments):
    return operating_point(PROPULSOR, *arguments)


def cells(charge=(0.0, 0.5, 1.0), volts=(3.0, 3.6, 4.2)):
    return BatteryVoltage(cells_in_series=6, state_of_charge=charge, cell_voltage_v=volts)


@pytest.mark.parametrize(
    ("part", "arguments", "message"),
    [
        (Propulsor, SIZE_AND_PARTS | {"wiring_resistance_ohm": -1.0}, r"at least 0 \(got -1\)"),
        (Propulsor, SIZE_AND_PARTS | {"maximum_tip_mach": 1.5}, r"and below 1 \(got 1.5\)"),
        (point_of, (0.0, 8.0, AIR, 22.0), r"thrust_n must be above 0 \(got 0\)"),
        (point_of, ([1.0, np.nan], 8.0, AIR, 22.0), "thrust_n must be above 0"),
        (point_of, (1.0, -8.0, AIR, 22.0), "airspeed_m_per_s must be at least 0"),
        (point_of, (1.0, 8.0, AIR, 0.0), "bus_voltage_v must be above 0"),
        (Controller, {}, "required key is missing"),
        (Controller, {"efficiency": 0.9, "idle_power_w": 0.1}, "not both .got 0.1"),
        (Motor, MOTOR_KEYS | {"efficiency": 0.8}, "not both .got 0.3"),
        (Motor, MOTOR_KEYS | {"resistance_ohm": 0.0}, "greater than 0"),
        *((Motor, without(key), f"{key}|required key is missing") for key in MOTOR_KEYS),
        (cells().voltage_v, (1.1,), r"state_of_charge must be from 0 to 1.*\(got 1.1\)"),
        (cells, ((0.0, 1.0), (3.0, 3.5, 4.0)), "must have the same length"),
        (cells, ((0.5, 0.5), (3.0, 3.5)), "state_of_charge must increase strictly"),
        (cells, ((0.0, 1.0), (4.0, 3.0)), "cell_voltage_v must not fall"),
    ],
)
def test_parts_and_points_that_cannot_be_are_refused(part, arguments, message):
    with pytest.raises(ValueError, match=message):
        part(**arguments) if isinstance(arguments, dict) else part(*arguments)


def test_controller_by_hand():
    power = CONTROLLER.input_power_w(MotorState(np.array(4.0), np.array(10.0)), np.array(20.0))
    duty = (10.0 + 0.08 + 0.7) / 20.7
    # Motor, switches, diode, changes of the switches, electronics.
    assert power == pytest.approx(40.0 + 0.32 + (1 - duty) * 2.8 + 0.4 + 0.2)
    still, fast = (motor(no_load_current_rise_a_per_1000_rpm=0.1).state(r, 0.05) for r in (0, 5e3))
    assert fast.current_a - still.current_a == pytest.approx(0.5)


def test_battery_voltage():
    assert cells().voltage_v([0.0, 0.25, 1.0]) == pytest.approx([18.0, 19.8, 25.2])


def test_parts_near_a_flight_are_the_exact_ones():
    parts = aircraft().propulsion_by_parts
    air, volts = AIR, (22.0, 25.2)
    near = NearbyPropulsion.of(parts, 24.0, 8.6, air)
    rng = np.random.default_rng(3)
    thrust_w = 24.0 * np.exp(rng.uniform(-0.4, 0.4, 40))
    speed = 8.6 * np.exp(rng.uniform(-0.15, 0.15, 40))
    exact, approximated = (
        propulsion.in_flight(thrust_w, speed, air, volts).efficiency for propulsion in (parts, near)
    )
    # Draws scatter by less; the polynomials' error is that of their degrees.
    assert approximated == pytest.approx(exact, rel=2e-4, nan_ok=True)
    powers = (own.bus_power_w(own.shaft(thrust_w, speed, air), 23.0) for own in (parts, near))
    assert next(powers) == pytest.approx(next(powers), rel=2e-4)
