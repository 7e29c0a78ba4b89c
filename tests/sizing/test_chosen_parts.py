import re

import numpy as np
import pytest
from propulsors import PARTS, VOLTAGE, aircraft

import sizing
import studies
from missions.files.errors import InputError
from missions.library import load_mission
from sizing.ceiling import flight_at_altitude
from sizing.day.light import SolarModel
from sizing.mass_budget import level_point

MISSION = load_mission("rafz-july")
FACTOR = "airframe.propulsion.efficiency_factor"


def ranged(motor=PARTS["motor"], **ranges):
    space = {
        f"design_space.{key}": {"minimum": low, "maximum": high}
        for key, (low, high) in ranges.items()
    }
    return aircraft(space, motor=motor)


def test_the_efficiency_factor_is_one_of_the_power():
    design, better = (sizing.design_of(aircraft({FACTOR: f}), MISSION) for f in (1.0, 1.05))
    ratio = better.chain.efficiency / design.chain.efficiency
    # A better chain has a smaller thrust to give, as its mass is less.
    assert ratio == pytest.approx(1.05, rel=2e-3)
    point = level_point(aircraft({FACTOR: 1.05}), MISSION, better)
    assert point.bus_power_w * point.efficiency == pytest.approx(float(point.thrust_power_w))


@pytest.fixture(scope="module")
def chosen():
    return sizing.size(ranged(propeller_diameter_m=(0.4, 1.0), gear_ratio=(2.0, 12.0)), MISSION)


def test_a_chosen_propeller_has_the_exact_chain(chosen):
    exact = sizing.design_of(chosen.sized_aircraft(), MISSION)
    assert chosen.design.chain.efficiency == pytest.approx(exact.chain.efficiency, rel=2e-6)
    assert chosen.design.total_mass_kg == pytest.approx(float(exact.total_mass_kg), rel=2e-6)


def test_draws_have_their_own_operating_points():
    inputs = {FACTOR: {"relative_sigma": 0.03}}
    built = {"airframe.structure.build": 1.0}  # a class would scatter as well
    subject = aircraft({"uncertainty.inputs": inputs, **built})
    drawn = sizing.analyse_uncertainty(subject, MISSION, samples=64)
    least = int(np.argmin(drawn.values[FACTOR]))
    worst = aircraft({FACTOR: float(drawn.values[FACTOR][least]), **built})
    power_w = sizing.design_of(worst, MISSION).propulsion_power_w
    assert drawn.flights.propulsion_power_w[least] == pytest.approx(power_w, rel=1e-3)


def test_a_propeller_by_tables_is_not_chosen(tmp_path):
    ends = {"minimum": 0.4, "maximum": 1.0}
    with pytest.raises(InputError, match=r"goes with .*operating_point"):
        sizing.load_aircraft("atlantiksolar-design", {"design_space.gear_ratio": ends})
    table = tmp_path / "own.csv"
    rows = "".join(
        f"{j},{0.11 - 0.09 * j},{0.075 - 0.03 * j},{n}\n" for n in (600, 1500) for j in (0.3, 1.15)
    )
    table.write_text(f"# diameter_m: 0.66\nJ,CT,CP,rpm\n{rows}")
    with pytest.raises(InputError, match=r"design_space\.propeller_diameter_m"):
        aircraft({"design_space.propeller_diameter_m": ends}, propeller={"table": str(table)})
    study = sizing.size(aircraft(propeller={"table": str(table)}), MISSION)
    exact = sizing.design_of(study.sized_aircraft(), MISSION)
    assert study.design.propulsion_power_w == pytest.approx(exact.propulsion_power_w, rel=5e-4)


def test_an_altitude_that_cannot_be_flown_has_its_reason():
    subject = aircraft()
    flight = flight_at_altitude(subject, MISSION, SolarModel("CAM"), 6000.0)
    reason_match = re.search(r"bus voltage 18 V is below (\d+\.\d+) V", flight.reason)
    assert reason_match
    # The voltage that it names does, one per cent less does not.
    for factor, flies in ((1.0, True), (0.99, False)):
        least_v = factor * float(reason_match[1]) / 6.0
        volts = VOLTAGE | {"cell_voltage_v": [least_v, least_v, 5.0, 5.1]}
        other = flight_at_altitude(
            aircraft({"battery.voltage": volts}), MISSION, SolarModel("CAM"), 6000.0
        )
        assert (other.reason == "") is flies
    ceiling = studies.perpetual_ceiling(subject, MISSION, highest_m=7000.0, step_m=1000.0)
    assert "reason" in str(ceiling.summary())
    reasons = [row["reason"] for row in ceiling.to_dict()["altitudes"]]
    assert reasons[0] == ""
    assert "bus voltage" in reasons[-1]


def test_a_propeller_efficiency_that_scatters_is_the_factor():
    # The shipped file has it with the constants.
    drawn = sizing.analyse_uncertainty(aircraft(), MISSION, samples=64)
    assert FACTOR in drawn.values
    assert drawn.values[FACTOR].std() == pytest.approx(0.03, rel=0.15)
    for part in ("motor_efficiency", "gear.efficiency"):
        inputs = {f"airframe.propulsion.{part}": {"sigma": 0.01}}
        with pytest.raises(ValueError, match="efficiency_factor scatter"):
            sizing.analyse_uncertainty(
                aircraft({"uncertainty.inputs": inputs}), MISSION, samples=64
            )


def test_a_sized_propeller_is_no_product():
    subject = aircraft(
        {"design_space.propeller_diameter_m": {"minimum": 0.4, "maximum": 0.6}},
        propeller={"product": "apc-22x12e"},
        gear={"ratio": 2.5, "efficiency": 0.96},
    )
    study = sizing.size(subject, MISSION)
    propeller = study.sized_aircraft().propulsion_by_parts.propeller
    assert propeller.product is None
    assert propeller.pitch_m == pytest.approx(0.3048)
    assert propeller.diameter_m == study.variables.propeller_diameter_m
