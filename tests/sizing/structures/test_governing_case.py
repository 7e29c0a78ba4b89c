"""What results say of the structure: load case, remarks, mass budget, infeasible answers."""

import pytest

import sizing
from missions.library import load_mission
from sizing.library import load_aircraft

RIB = "airframe.structure"
DESIGN = "atlantiksolar-design"


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
    # So is the changed sense of the deflection limit.
    limit, changed = f"{RIB}.maximum_tip_deflection=0.1", "until 1.0 it held at every limit load"
    assert changed in remarks(limit)
    for case in ("level_flight", "limit_load"):
        assert changed not in remarks(limit, f"{RIB}.deflection_load_case={case}")
