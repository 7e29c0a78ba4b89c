import numpy as np
import pytest
from propulsors import PARTS as OWN_PARTS
from propulsors import VOLTAGE

import sizing
from missions.library import load_mission
from sizing.catalogues.choice import entries
from sizing.day.light import UNCORRECTED_CAM
from sizing.mass_budget import design_of
from sizing.parameters import catalogue
from sizing.propulsion.part_masses import gear_mass_kg, motor_mass_fit, propeller_mass_fit
from sizing.uncertainty.inputs import uncertain_inputs
from sizing.uncertainty.propagation import Propagation, check_inputs

MISSION = load_mission("rafz-july")
MOTOR = {
    "speed_constant_rpm_per_v": 317.0,
    "resistance_ohm": 0.299,
    "no_load_current_a": 0.137,
    "maximum_current_a": 6.0,
}
PARTS = OWN_PARTS | {
    "propeller": {"diameter_m": 0.66, "pitch_m": 0.60, "mass_kg": 0.05},
    "gear": {"ratio": 5.0, "efficiency": 0.96},
    "motor": MOTOR,
}


def aircraft(ranges=None, **parts):
    values = {"battery.voltage": VOLTAGE, "airframe.propulsion": PARTS | parts}
    return sizing.load_aircraft("atlantiksolar-design", values | (ranges or {}))


def test_the_line_through_the_motors_is_the_least_squares_of_their_logarithms():
    rows = []
    for motor in entries("motors").values():
        numbers = motor.numbers()
        constant = 60.0 / (2.0 * np.pi * numbers["speed_constant_rpm_per_v"])
        useful = numbers["maximum_current_a"] - numbers["no_load_current_a"]
        rows.append((constant * useful, numbers["mass_kg"]))
    torque, mass = np.array(rows).T
    fit = motor_mass_fit()
    residual = np.log(mass) - np.log([fit.mass_kg(torque_nm) for torque_nm in torque])
    assert fit.number == len(rows) >= 20
    # The normal equations, and the scatter with two numbers fitted.
    assert residual.sum() == pytest.approx(0.0, abs=1e-10)
    assert residual @ np.log(torque) == pytest.approx(0.0, abs=1e-10)
    assert np.log(fit.scatter) ** 2 == pytest.approx(residual @ residual / (len(rows) - 2))


def test_gears_have_the_mass_of_aerosandbox():
    propulsion = pytest.importorskip("aerosandbox.library.propulsion_propeller")
    for power_w, rpm_out, ratio in ((20.0, 900.0, 5.0), (500.0, 2000.0, 3.0), (1e6, 400.0, 12.0)):
        torque_nm = power_w * 30.0 / np.pi / rpm_out
        theirs = propulsion.mass_gearbox(power_w, ratio * rpm_out, rpm_out)
        assert gear_mass_kg(torque_nm, ratio) == pytest.approx(float(theirs), rel=1e-9)
    assert gear_mass_kg(1.0, 1.0) == 0.0


def test_masses_of_the_file_hold():
    known = aircraft(motor=MOTOR | {"mass_kg": 0.4}, gear=PARTS["gear"] | {"mass_kg": 0.1})
    assert float(design_of(known, MISSION).masses.propulsion) == pytest.approx(0.05 + 0.4 + 0.1)
    per_watt = aircraft(mass_kg_per_w=0.002)
    design = design_of(per_watt, MISSION)
    # All that grows is in what the file says, five times the power of level flight.
    grown = 0.05 + 0.002 * 5.0 * float(design.propulsion_power_w)
    assert float(design.masses.propulsion) == pytest.approx(grown, rel=1e-9)


def test_a_gear_has_the_torque_of_the_rated_power():
    changed = aircraft(climb_power_ratio=8.0)
    analysis = sizing.analyse(changed, MISSION)
    point = analysis.power_budget.point
    # With the cube of the speed grows the power, with the square the torque.
    torque_nm = float(point.propeller_torque_nm) * 8.0 ** (2.0 / 3.0)
    masses = analysis.part_masses
    assert masses.gearbox_kg == pytest.approx(gear_mass_kg(torque_nm, 5.0), rel=1e-6)
    assert masses.motor_kg == pytest.approx(motor_mass_fit().mass_kg(30.0 / np.pi / 317 * 5.863))
    assert masses.motor_scatter == motor_mass_fit().scatter


@pytest.mark.long
def test_a_chosen_propeller_scales_and_its_file_says_so():
    ranges = {
        "design_space.propeller_diameter_m": {"minimum": 0.4, "maximum": 0.9},
        "design_space.gear_ratio": {"minimum": 2.0, "maximum": 12.0},
    }
    study = sizing.size(aircraft(ranges), MISSION, objective="min_mass")
    assert study.feasible
    diameter_m = float(study.design.variables.propeller_diameter_m)
    built = study.sized_aircraft()
    propulsion = getattr(built.airframe, "propulsion", None)
    grown = (diameter_m / 0.66) ** propeller_mass_fit().exponent
    assert propulsion.propeller.mass_kg == pytest.approx(0.05 * grown)
    mass_kg = float(design_of(built, MISSION).masses.propulsion)
    # Formulas and exact chain agree to 1e-5 in the efficiency, and so in the torque.
    assert mass_kg == pytest.approx(float(study.design.masses.propulsion), rel=1e-4)


def test_a_propeller_without_a_mass_has_that_of_its_diameter():
    propeller = {"diameter_m": 0.66, "pitch_m": 0.60}
    estimated, without = (aircraft(propeller=propeller | more) for more in ({}, {"mass_kg": 0.0}))
    more_kg = design_of(estimated, MISSION).masses.propulsion
    more_kg -= design_of(without, MISSION).masses.propulsion
    # The gear grows with the torque that the heavier aircraft needs.
    assert float(more_kg) == pytest.approx(propeller_mass_fit().mass_kg(0.66), rel=0.05)
    masses = sizing.analyse(estimated, MISSION).part_masses
    assert masses.propeller_kg == pytest.approx(propeller_mass_fit().mass_kg(0.66))
    # Where the file says how the whole group grows nothing is estimated.
    grouped = aircraft(propeller=propeller, mass_kg_per_w=0.002).propulsion_by_parts
    assert grouped.propeller_kg == 0.0
    known = aircraft(propeller={"product": "apc-26x15e"}).propulsion_by_parts
    assert known.propeller_kg == pytest.approx(0.214, abs=1e-3)


@pytest.mark.parametrize("part", ["motor", "propeller"])
def test_masses_scatter_in_draws_as_those_of_files(part):
    """Each draw is the aircraft of a file with that factor, mass budget closed anew."""
    key = f"airframe.propulsion.{part}_mass_factor"
    assert key in catalogue()  # whose parameters have sensitivities
    spread = {"distribution": "lognormal", "relative_sigma": motor_mass_fit().scatter - 1.0}
    changed = aircraft({"uncertainty.inputs": {key: spread}})
    inputs = uncertain_inputs(changed, MISSION, UNCORRECTED_CAM, model_error=False).inputs
    (scattering,) = (entry for entry in inputs if entry.key == key)
    low, middle, high = scattering.values(np.array([0.158655, 0.5, 0.841345]))
    assert (low, middle, high) == pytest.approx((1.0 / 1.62, 1.0, 1.62), rel=0.01)
    check_inputs(uncertain_inputs(changed, MISSION, UNCORRECTED_CAM), MISSION, UNCORRECTED_CAM)
    flights = Propagation(changed, MISSION, UNCORRECTED_CAM).flights({key: np.array([low, high])})
    for factor, mass_kg in zip((low, high), flights.total_mass_kg, strict=True):
        alone = design_of(aircraft(**{f"{part}_mass_factor": float(factor)}), MISSION)
        assert mass_kg == pytest.approx(float(alone.total_mass_kg), rel=1e-4)


def test_masses_scatter_with_a_propeller_by_tables(tmp_path):
    table = tmp_path / "own.csv"
    rows = "\n".join(
        f"{j},{0.16 - 0.12 * j},{0.11 - 0.05 * j},{rpm}"
        for rpm in (200, 4000)
        for j in (0.2, 0.6, 1.0, 1.2)
    )
    table.write_text(f"# diameter_m: 0.66\nJ,CT,CP,rpm\n{rows}\n")
    parts = {"propeller": {"table": str(table), "mass_kg": 0.05}}
    keys = {
        f"airframe.propulsion.{part}_mass_factor": np.array([1.5])
        for part in ("motor", "propeller")
    }
    flights = Propagation(aircraft(**parts), MISSION, UNCORRECTED_CAM).flights(keys)
    alone = design_of(aircraft(**parts, motor_mass_factor=1.5, propeller_mass_factor=1.5), MISSION)
    # Draws have the chain of the nominal aircraft.
    assert flights.total_mass_kg[0] == pytest.approx(float(alone.total_mass_kg), rel=1e-3)
