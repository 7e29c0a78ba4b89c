"""Structural models beside built aircraft: cases, figure, tables, and the script that draws."""

import pytest

from benchmarks.validation.built_aircraft import ATLANTIKSOLAR, SKY_SAILOR, calibrated_rib_wing
from missions.library import load_mission
from sizing.library import load_aircraft
from sizing.mass_budget import design_of
from sizing.structures.torsion import WingTorsion

DESIGN = "atlantiksolar-design"


def test_one_factor_fits_atlantiksolar_and_sky_sailor_is_told_honestly():
    model = calibrated_rib_wing()
    # Published range of AtlantikSolar's structure; the factor is fitted to its middle.
    assert ATLANTIKSOLAR.mass_kg(model) == pytest.approx(1.35, abs=0.005)
    # Nothing fitted: one fifth is what the documentation admits to, and it is on the light side.
    assert 0.80 * 0.725 < SKY_SAILOR.mass_kg(model) < 0.725


def test_calibration_and_stiffness_are_all_that_the_file_says():
    # All other inputs are the model's own constants, the same for every aircraft.
    model = calibrated_rib_wing()
    stiffness = {"gusts_fall_with_altitude", "torsion"}
    battery = {"spar_battery_density_kg_per_m3", "pod_battery_mount_fraction"}
    assert model.model_fields_set == {"model", "build", "calibration"} | stiffness | battery
    assert model.torsion == WingTorsion()


def test_calibration_is_near_that_of_the_published_tool():
    # 1.21 with other assumptions on film, ribs and joints: a fifth either way is not another model.
    assert calibrated_rib_wing().calibration == pytest.approx(1.21, rel=0.2)


def test_case_agrees_with_the_shipped_design():
    aircraft, mission = load_aircraft(DESIGN), load_mission("rafz-july")
    design = design_of(aircraft, mission)
    # Air of 1.09 instead of 1.10 kg/m3, and 6.922 instead of 6.92 kg.
    assert ATLANTIKSOLAR.mass_kg(calibrated_rib_wing()) == pytest.approx(
        design.masses.structure, rel=2e-3
    )
