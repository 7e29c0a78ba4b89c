import numpy as np
import pytest
from propulsors import PARTS

import sizing
from missions.files.errors import InputError
from missions.library import load_mission
from sizing.mass_budget import design_of
from sizing.propulsion.electric import Motor
from sizing.propulsion.part_masses import continuous_torque_nm

MISSION = load_mission("rafz-july")
MOTOR = Motor(
    speed_constant_rpm_per_v=317.0,
    resistance_ohm=0.299,
    no_load_current_a=0.137,
    no_load_current_rise_a_per_1000_rpm=0.02,
    maximum_current_a=6.0,
    mass_kg=0.3,
)
RANGE = {"design_space.motor_speed_constant_rpm_per_v": {"minimum": 60.0, "maximum": 900.0}}
# Weaker by far than needs be at the empty battery, so that the winding matters.
WEAK = {"cells_in_series": 6, "state_of_charge": [0, 1], "cell_voltage_v": [3.0, 4.2]}


def aircraft(*changes):
    parts = PARTS | {"motor": MOTOR.model_dump(exclude_none=True)}
    values = {"battery.voltage": WEAK, "airframe.propulsion": parts}
    for change in changes:
        values |= change
    return sizing.load_aircraft("atlantiksolar-design", values)


@pytest.mark.parametrize("ratio", [0.3, 1.0, 2.5])
def test_speed_and_torque_cost_the_same_in_every_winding(ratio):
    """At a shaft's state power and losses are equal, voltage and current exchange a factor."""
    wound = MOTOR.rewound(ratio * MOTOR.speed_constant_rpm_per_v)
    rpm, torque_nm = np.array([1000.0, 4600.0, 9000.0]), np.array([0.02, 0.06, 0.15])
    original, rewound = MOTOR.state(rpm, torque_nm), wound.state(rpm, torque_nm)
    assert rewound.current_a == pytest.approx(ratio * original.current_a, rel=1e-12)
    assert rewound.voltage_v == pytest.approx(original.voltage_v / ratio, rel=1e-12)
    # So does what size and limits are made of: torque and copper's losses at the largest current.
    assert continuous_torque_nm(wound) == pytest.approx(continuous_torque_nm(MOTOR), rel=1e-12)
    assert wound.maximum_current_a**2 * wound.resistance_ohm == pytest.approx(36.0 * 0.299)


@pytest.fixture(scope="module")
def sized():
    return sizing.size(aircraft(RANGE), MISSION, objective="min_mass", required_excess_time_h=3.0)


@pytest.mark.long
def test_no_winding_of_a_scan_is_better(sized):
    assert sized.feasible
    best = float(sized.design.variables.motor_speed_constant_rpm_per_v)

    def lightest_kg(share):
        wound = MOTOR.rewound(share * best).model_dump(exclude_none=True)
        with_parts = aircraft({"airframe.propulsion": PARTS | {"motor": wound}})
        study = sizing.size(with_parts, MISSION, objective="min_mass", required_excess_time_h=3.0)
        return float(study.design.total_mass_kg)

    mass_kg = float(sized.design.total_mass_kg)
    faster = [lightest_kg(share) for share in (1.01, 1.4)]
    assert mass_kg < faster[0] < faster[1]
    assert faster[0] == pytest.approx(mass_kg, rel=1e-3)
    # With any less the empty battery's voltage asks for a slower and larger aircraft.
    assert mass_kg < lightest_kg(0.98)


def test_the_winding_is_limited_by_the_empty_battery(sized):
    """All windings are as efficient as each other, but for what the duty costs."""
    assert "bus_voltage" in sized.result.active_constraints


def test_the_sized_file_has_the_motor_that_was_wound(sized):
    built = sized.sized_aircraft()
    motor = built.airframe.propulsion.motor_constants
    constant = float(sized.design.variables.motor_speed_constant_rpm_per_v)
    assert motor.speed_constant_rpm_per_v == pytest.approx(constant)
    assert motor.resistance_ohm == pytest.approx(0.299 * (317.0 / constant) ** 2)
    assert motor.mass_kg == MOTOR.mass_kg
    again = design_of(built, MISSION)
    assert float(again.total_mass_kg) == pytest.approx(float(sized.design.total_mass_kg), rel=1e-5)
    assert sized.to_dict()["motor_speed_constant_rpm_per_v"] == pytest.approx(constant)


@pytest.mark.long
def test_a_motor_of_the_catalogue_is_wound_as_well():
    """Its mass by its torque is that of the file, whatever the winding."""
    constants = MOTOR.model_dump(exclude_none=True, exclude={"mass_kg"})
    parts = [PARTS | {"motor": motor} for motor in ("maxon-re40-148867", constants)]
    for part in parts:
        study = sizing.size(aircraft(RANGE, {"airframe.propulsion": part}), MISSION)
        assert study.feasible
        built = study.sized_aircraft()
        before = aircraft({"airframe.propulsion": part}).airframe.propulsion
        after = built.airframe.propulsion
        assert after.motor_mass_kg == pytest.approx(before.motor_mass_kg, rel=1e-9)


def test_a_chain_of_constants_has_no_winding():
    with pytest.raises(InputError, match=r"motor_speed_constant_rpm_per_v: goes with airframe"):
        sizing.load_aircraft("atlantiksolar-design", RANGE)
