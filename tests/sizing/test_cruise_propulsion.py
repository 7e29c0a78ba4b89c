import pytest
from builders import AS2, DESIGN
from propulsors import PROPULSOR

import sizing
from missions.library import load_mission

MISSION = load_mission("rafz-july")


def test_bus_power_is_that_of_level_flight():
    aircraft, point = sizing.with_operating_point(DESIGN, MISSION, PROPULSOR, 22.2)
    design = sizing.design_of(aircraft, MISSION)
    assert design.propulsion_power_w == pytest.approx(float(point.bus_power_w), rel=1e-8)
    assert aircraft.airframe.propulsion.efficiency == pytest.approx(float(point.efficiency))
    # The thrust is the drag of this design, at its airspeed.
    assert point.thrust_power_w == pytest.approx(
        float(design.propulsion_power_w) * aircraft.airframe.propulsion.efficiency
    )
    # Better than the constants of the file, so lighter: the rated power is less.
    before = sizing.design_of(DESIGN, MISSION)
    assert DESIGN.airframe.propulsion.efficiency < float(point.efficiency)
    assert design.total_mass_kg < before.total_mass_kg
    assert (
        sizing.analyse(aircraft, MISSION).excess_time_h
        > sizing.analyse(DESIGN, MISSION).excess_time_h
    )


def test_what_the_file_says_of_the_chain_plays_no_part():
    worse = DESIGN.airframe.propulsion.model_copy(update={"propeller_efficiency": 0.5})
    airframe = DESIGN.airframe.model_copy(update={"propulsion": worse})
    other = DESIGN.model_copy(update={"airframe": airframe})
    point = sizing.with_operating_point(DESIGN, MISSION, PROPULSOR, 22.2)[1]
    same = sizing.with_operating_point(other, MISSION, PROPULSOR, 22.2)[1]
    assert same.bus_power_w == pytest.approx(float(point.bus_power_w), rel=1e-7)


def test_two_propulsors_share_the_thrust():
    point = sizing.with_operating_point(DESIGN, MISSION, PROPULSOR, 22.2)[1]
    aircraft, of_two = sizing.with_operating_point(DESIGN, MISSION, PROPULSOR, 22.2, propulsors=2)
    assert of_two.thrust_power_w == pytest.approx(float(point.thrust_power_w) / 2, rel=0.03)
    power_w = sizing.design_of(aircraft, MISSION).propulsion_power_w
    assert power_w == pytest.approx(2.0 * float(of_two.bus_power_w), rel=1e-8)
    # Both motors have their no-load loss, at a quarter of their duty.
    assert of_two.motor_efficiency < point.motor_efficiency


def test_measured_aircraft_and_no_propulsor_are_refused():
    with pytest.raises(ValueError, match="is a measured aircraft"):
        sizing.with_operating_point(AS2, MISSION, PROPULSOR, 22.2)
    with pytest.raises(ValueError, match=r"propulsors must be 1 or more \(got 0\)"):
        sizing.with_operating_point(DESIGN, MISSION, PROPULSOR, 22.2, propulsors=0)
