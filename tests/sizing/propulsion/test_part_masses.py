"""Tests of the masses of parts that no file gives."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from propulsors import PARTS as OWN_PARTS
from propulsors import VOLTAGE

import sizing
from missions.library import load_mission
from sizing.catalogues.choice import entries
from sizing.design import design_of
from sizing.propulsion.part_masses import gear_mass_kg, motor_mass_fit

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


def aircraft(ranges: dict[str, Any] | None = None, **parts: Any) -> sizing.Aircraft:
    values = {"battery.voltage": VOLTAGE, "airframe.propulsion": PARTS | parts}
    return sizing.load_aircraft("atlantiksolar-design", values | (ranges or {}))


def test_the_line_through_the_motors_is_the_least_squares_of_their_logarithms() -> None:
    rows: list[tuple[float, float]] = []
    for one in entries("motors").values():
        numbers = one.numbers()
        constant = 60.0 / (2.0 * np.pi * numbers["speed_constant_rpm_per_v"])
        useful = numbers["maximum_current_a"] - numbers["no_load_current_a"]
        rows.append((constant * useful, numbers["mass_kg"]))
    torque, mass = np.array(rows).T
    fit = motor_mass_fit()
    residual = np.log(mass) - np.log([fit.mass_kg(one) for one in torque])
    assert fit.motors == len(rows) >= 20
    # The normal equations, and the scatter with two numbers fitted.
    assert residual.sum() == pytest.approx(0.0, abs=1e-10)
    assert residual @ np.log(torque) == pytest.approx(0.0, abs=1e-10)
    assert np.log(fit.scatter) ** 2 == pytest.approx(residual @ residual / (len(rows) - 2))


def test_gears_have_the_mass_of_aerosandbox() -> None:
    propulsion = pytest.importorskip("aerosandbox.library.propulsion_propeller")
    for power_w, rpm_out, ratio in ((20.0, 900.0, 5.0), (500.0, 2000.0, 3.0), (1e6, 400.0, 12.0)):
        torque_nm = power_w * 30.0 / np.pi / rpm_out
        theirs = propulsion.mass_gearbox(power_w, ratio * rpm_out, rpm_out)
        assert gear_mass_kg(torque_nm, ratio) == pytest.approx(float(theirs), rel=1e-9)
    assert gear_mass_kg(1.0, 1.0) == 0.0


def test_masses_of_the_file_hold() -> None:
    known = aircraft(motor=MOTOR | {"mass_kg": 0.4}, gear=PARTS["gear"] | {"mass_kg": 0.1})
    assert float(design_of(known, MISSION).masses.propulsion) == pytest.approx(0.05 + 0.4 + 0.1)
    per_watt = aircraft(mass_kg_per_w=0.002)
    design = design_of(per_watt, MISSION)
    # All that grows is in what the file says, five times the power of level flight.
    grown = 0.05 + 0.002 * 5.0 * float(design.propulsion_power_w)
    assert float(design.masses.propulsion) == pytest.approx(grown, rel=1e-9)


def test_a_gear_has_the_torque_of_the_rated_power() -> None:
    own = aircraft(climb_power_ratio=8.0)
    analysis = sizing.analyse(own, MISSION)
    point = analysis.power_budget.point
    assert point is not None
    # With the cube of the speed grows the power, with the square the torque.
    torque_nm = float(point.propeller_torque_nm) * 8.0 ** (2.0 / 3.0)
    masses = analysis.part_masses
    assert masses is not None
    assert masses.gearbox_kg == pytest.approx(gear_mass_kg(torque_nm, 5.0), rel=1e-6)
    assert masses.motor_kg == pytest.approx(motor_mass_fit().mass_kg(30.0 / np.pi / 317 * 5.863))
    text = " ".join(str(analysis.summary()).split())
    assert f"scatter by a factor of {motor_mass_fit().scatter:.2f}" in text


def test_a_chosen_propeller_scales_and_its_file_says_so() -> None:
    ranges = {
        "design_space.propeller_diameter_m": {"minimum": 0.4, "maximum": 0.9},
        "design_space.gear_ratio": {"minimum": 2.0, "maximum": 12.0},
    }
    study = sizing.size(aircraft(ranges), MISSION, objective="min_mass")
    assert study.feasible
    diameter_m = float(study.design.variables.propeller_diameter_m)
    built = study.sized_aircraft()
    propulsion = getattr(built.airframe, "propulsion", None)
    assert propulsion.propeller.mass_kg == pytest.approx(0.05 * (diameter_m / 0.66) ** 3)
    mass_kg = float(design_of(built, MISSION).masses.propulsion)
    # Formulas and exact chain agree to 1e-5 in the efficiency, and so in the torque.
    assert mass_kg == pytest.approx(float(study.design.masses.propulsion), rel=1e-4)
