"""What results say of the structure: load case, remarks, mass budget, infeasible answers."""

import pytest

import sizing
from missions.library import load_mission
from sizing.library import load_aircraft
from sizing.mass_budget import ImpossibleDesignError, design_of

RIB = "airframe.structure"
DESIGN = "atlantiksolar-design"


def high_aircraft(*changes):
    """Aircraft of 25 m with what is published of Zephyr 8, in the technology of the file.

    25 m, 24 kg of battery with 435 Wh/kg, 75 kg in all; aspect ratio, 20 m2 of modules of 0.3
    kg/m2, 4 kg of avionics, 5 kg of payload and the motor's 4 g/W are assumptions.
    """
    return load_aircraft(
        DESIGN,
        [
            "airframe.wingspan_m=25.0",
            "airframe.aspect_ratio=22.0",
            "airframe.avionics_mass_kg=4.0",
            "airframe.other_mass_kg=0.2",
            "airframe.aerodynamics.lift_coefficient=1.1",
            "airframe.aerodynamics.maximum_lift_coefficient=1.5",
            "airframe.aerodynamics.profile_drag_coefficient=0.011",
            "airframe.aerodynamics.parasitic_drag_coefficient=0.003",
            "airframe.propulsion.motor_efficiency=0.92",
            "airframe.propulsion.gearbox_efficiency=1.0",
            "airframe.propulsion.propeller_efficiency=0.83",
            "modules.efficiency_stc=0.27",
            "airframe.propulsion.mass_kg_per_w=0.004",
            "airframe.propulsion.climb_power_ratio=2.0",
            "modules.area_m2=20.0",
            "modules.mass_kg_per_m2=0.3",
            "battery.mass_kg=24.0",
            "battery.specific_energy_wh_per_kg=435.0",
            *changes,
        ],
    )


def high_mission():
    return load_mission(
        "rafz-july", ["altitude_m=18300", "payload={mass_kg: 5, power_w: 50}", "latitude_deg=32"]
    )


def test_wing_of_25_m_weighs_what_such_aircraft_weigh():
    design = design_of(high_aircraft(), high_mission())
    # Published: 75 kg in all; computed 95 kg. A third is what the assumptions above and a model
    # that is calibrated at 5.65 m leave open; with 0.05 at the limit load it cannot carry itself.
    assert design.total_mass_kg == pytest.approx(75.0, rel=1.0 / 3.0)
    stiff = high_aircraft(
        f"{RIB}.maximum_tip_deflection=0.05",
        f"{RIB}.deflection_load_case=limit_load",
        f"{RIB}.gusts_fall_with_altitude=false",
    )
    with pytest.raises(ImpossibleDesignError):
        design_of(stiff, high_mission())


def test_analysis_has_the_mass_budget_and_what_sizes_the_structure():
    analysis = sizing.analyse(load_aircraft(DESIGN), load_mission("rafz-july"))
    record = analysis.to_dict()
    assert sum(record["masses_kg"].values()) == pytest.approx(record["total_mass_kg"], rel=1e-9)
    assert record["structure"]["spar_caps_case"] == "landing"
    printed = str(analysis.at_level(2))
    assert "mass budget" in printed
    assert "landing 2.0 g" in " ".join(printed.split())
    measured = sizing.analyse(load_aircraft("atlantiksolar-as2"), load_mission("rafz-july"))
    assert measured.masses_kg is None
    assert measured.structure is None


def test_flutter_criterion_says_where_it_does_not_hold():
    mission = load_mission("rafz-july")

    def remarks(*changes):
        analysis = sizing.analyse(load_aircraft(DESIGN, list(changes)), mission).structure
        return " ".join(analysis.remarks)

    assert "CAA Report 45 does not cover T-tails and masses along the wing" in remarks()
    in_pod = "airframe.distributed_battery_fraction=0.0"
    assert remarks(in_pod).endswith("does not cover T-tails")
    low = "modules.tail.horizontal_height_m=0.0"
    assert remarks(low).endswith("does not cover masses along the wing")
    assert remarks(in_pod, low) == ""
    assert remarks(f"{RIB}.torsion=null") == ""


def test_changed_sense_of_the_deflection_limit_is_told():
    mission, limit = load_mission("rafz-july"), f"{RIB}.maximum_tip_deflection=0.1"

    def told(*changes):
        analysis = sizing.analyse(load_aircraft(DESIGN, [limit, *changes]), mission).structure
        return any("until 1.0 it held at every limit load" in text for text in analysis.remarks)

    assert told()
    assert not told(f"{RIB}.deflection_load_case=level_flight")
    assert not told(f"{RIB}.deflection_load_case=limit_load")


def test_infeasible_answer_names_the_structure_and_its_keys():
    # A wing far too stiff to carry itself.
    limit = 0.02
    study = sizing.size(
        high_aircraft(
            f"{RIB}.maximum_tip_deflection={limit}",
            f"{RIB}.deflection_load_case=limit_load",
            "design_space.wingspan_m={minimum: 12, maximum: 30}",
            "design_space.module_area_m2={minimum: 2, maximum: 30}",
            "design_space.battery_mass_kg={minimum: 2, maximum: 60}",
        ),
        high_mission(),
        objective="min_mass",
    )
    assert study.status.name == "infeasible"
    text = " ".join(str(study.at_level(2)).split())
    assert "its structure outgrows every mass" in text or "are structure" in text
    assert "spar caps sized by tip deflection" in text
    assert study.to_dict()["structure"]["spar_caps"]["tip_deflection"] > 0.9
    (eased,) = (
        relaxation
        for relaxation in study.relaxations
        if relaxation.parameter == f"{RIB}.maximum_tip_deflection"
    )
    assert eased.direction == "at least"
    assert eased.value > limit
