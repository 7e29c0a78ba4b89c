"""Designs of whole cells against a scan of wingspans through the simulator."""

from functools import cache

import numpy as np
import pytest

import sizing
from missions.library import load_mission
from sizing.aircraft import Aircraft
from sizing.design import DesignVariables
from sizing.layout.cells import Wing
from sizing.limits import meets_requirements
from sizing.performance import performance_of_designs
from sizing.program.whole_cells import without_whole_cells

MISSION = load_mission("central-europe-summer")
REQUIRED_H = 3.0
HALF_CELLS = {
    "cell_span_m": 0.125,
    "cell_chord_m": 0.0625,
    "cell_area_m2": 0.0153436 / 2.0,
    "bays": [{"cells": [44, 44, 44, 44]}],
}
WHOLE_CELLS = {"cell_span_m": 0.125, "cell_chord_m": 0.125, "bays": [{"cells": [22, 22]}]}
PACK = {"cells_in_series": 6, "cell_mass_kg": 0.0486}
UNIT_KG = 6 * 0.0486


def plane(layout, **changes):
    count = 2 * sum(layout["bays"][0]["cells"])
    area_m2 = count * layout.get("cell_area_m2", 0.0153436)
    given = {
        "modules.cell": "sunpower-e60",
        "modules.layout": layout,
        "modules.area_m2": area_m2,
        "battery.pack": PACK,
        "airframe.wingspan_m": 11.3 if count > 88 else 5.65,
    }
    return sizing.load_aircraft("atlantiksolar-design", given | changes)


@cache
def halves():
    return sized(plane(HALF_CELLS))


def sized(aircraft, objective="min_wingspan"):
    return sizing.size(
        aircraft, MISSION, objective, required_excess_time_h=REQUIRED_H, whole_cells=True
    )


def least_span_m(aircraft, per_half, parallel, spans):
    """Least of some wingspans that holds the cells and flies as required, by the simulator."""
    layout, ratio = aircraft.modules.layout, aircraft.airframe.aspect_ratio
    cell_m2 = layout.area_of_a_cell_m2
    holds = np.array([layout.capacity(Wing(b, b / ratio)) >= per_half for b in spans])
    variables = DesignVariables(
        wingspan_m=spans,
        aspect_ratio=np.full_like(spans, ratio),
        battery_mass_kg=np.full_like(spans, parallel * UNIT_KG),
        module_area_m2=np.full_like(spans, 2 * per_half * cell_m2),
    )
    plain = without_whole_cells(aircraft)
    flown = performance_of_designs(plain, MISSION, variables)
    enough = np.min(flown.cycle.excess_time_h, axis=-1) >= REQUIRED_H
    sound = meets_requirements(plain, flown.design)
    return float(np.min(spans[holds & enough & sound], initial=np.inf))


def test_best_design_is_that_of_a_scan():
    study = halves()
    cells, spans = study.whole_cells, np.arange(4.24, 4.40, 0.004)
    found = {
        (per_half, parallel): least_span_m(study.aircraft, per_half, parallel, spans)
        for per_half in range(47, 53)
        for parallel in (9, 10, 11)
    }
    # The scan's step of 4 mm; 0.012 h of excess time that a search may leave are another 1 mm.
    assert study.variables.wingspan_m == pytest.approx(min(found.values()), abs=0.006)
    chosen = cells.chosen.cells // 2, cells.chosen.cells_in_parallel
    assert found[chosen] == pytest.approx(min(found.values()), abs=0.006)


def test_loss_is_against_the_sizing_without_cells():
    study = halves()
    aircraft = plane(HALF_CELLS)
    relaxed = sizing.size(aircraft, MISSION, "min_wingspan", required_excess_time_h=REQUIRED_H)
    cells = study.whole_cells
    assert cells.relaxed.objective_value == relaxed.result.objective_value
    assert cells.loss == pytest.approx(
        study.result.objective_value / relaxed.result.objective_value - 1.0, rel=1e-12
    )
    assert 0.0 < cells.loss < 0.1


def test_sized_aircraft_is_a_file_with_its_cells_that_flies_as_told():
    study = halves()
    aircraft = study.sized_aircraft()
    again = Aircraft.model_validate(aircraft.model_dump(mode="json", exclude_unset=True))
    assert again == aircraft
    chosen = study.whole_cells.chosen
    assert len(again.placed_cells()) == chosen.cells
    assert again.battery.mass_kg == pytest.approx(chosen.cells_in_parallel * UNIT_KG, rel=1e-12)
    flown = sizing.analyse(again, MISSION)
    excess_h = float(np.min(flown.performance.cycle.excess_time_h))
    assert excess_h >= REQUIRED_H
    simulated = study.result.simulated
    assert excess_h == pytest.approx(float(np.min(simulated.cycle.excess_time_h)), rel=1e-6)


def test_relaxed_sizing_of_such_an_aircraft_leaves_the_cells_out():
    aircraft = plane(WHOLE_CELLS)
    study = sizing.size(aircraft, MISSION, "min_mass", required_excess_time_h=REQUIRED_H)
    written = study.sized_aircraft()
    assert written.modules.layout is None
    assert written.battery.pack is None
    flown = sizing.analyse(written, MISSION).performance
    assert flown.design.total_mass_kg == pytest.approx(study.design.total_mass_kg, rel=1e-9)


@pytest.mark.long
def test_wing_that_holds_the_cells_limits():
    study = sized(plane(WHOLE_CELLS))
    # Two rows of 0.125 m with 2 mm between them are 0.252 m of chord, at an aspect ratio of 18.5.
    assert study.variables.wingspan_m == pytest.approx(18.5 * 0.252, abs=1e-4)
    assert "whole_cells" in study.result.active_constraints
    assert "wing that holds the cells" in " ".join(str(study).split())
    # A wider wing that the design space asks for holds them with room to spare.
    wider = plane(WHOLE_CELLS, **{"design_space.wingspan_m.minimum": 5.0})
    names = sized(wider).result.active_constraints
    assert "wingspan_m at its minimum" in names
    assert "whole_cells" not in names


@pytest.mark.slow
def test_payload_is_sized_beside_whole_cells_that_fit():
    study = sized(
        plane(WHOLE_CELLS, **{"design_space.wingspan_m.maximum": 5.65}), "max_payload_mass"
    )
    cells = study.whole_cells
    # 22 cells of 0.125 m and their gaps are all that 2.825 m hold.
    assert cells.chosen.cells == 88
    assert cells.loss > 0.0
    told = [one for one in cells.tried if one.value is None]
    assert any("need a wingspan of 5.84" in one.reason for one in told)


@pytest.mark.long
def test_strings_leave_numbers_of_cells_out():
    window = {"minimum_voltage_v": 9.0, "maximum_voltage_v": 16.0, "maximum_current_a": 7.0}
    strings = {"cells_in_series": 18, "coldest_c": -20.0, "hottest_c": 70.0, "mppt": window}
    strings |= {"mpp_voltage_v": 0.63, "open_circuit_voltage_v": 0.73, "mpp_current_a": 5.9}
    layout = WHOLE_CELLS | {"bays": [{"cells": [18, 18]}], "strings": strings}
    data = plane(layout).model_dump(mode="json", exclude_unset=True)
    del data["modules"]["mppt_mass_kg_per_w"]
    data["modules"]["layout"]["strings"]["mppt"]["mass_kg"] = 0.06
    study = sized(Aircraft.model_validate(data))
    cells = study.whole_cells
    # With the MPPTs that the written aircraft has.
    flown = sizing.analyse(study.sized_aircraft(), MISSION).performance
    assert flown.design.total_mass_kg == pytest.approx(study.design.total_mass_kg, rel=1e-6)
    assert flown.design.masses.mppt == pytest.approx(0.06 * cells.chosen.mppts, rel=1e-6)
    # By hand: 9 V / (0.63 V * 0.865) = 16.5 and 16 V / (0.73 V * 1.135) = 19.3 cells in series.
    allowed = [n for n in range(2, 200, 2) if any(n % series == 0 for series in (17, 18, 19))]
    assert cells.chosen.cells in allowed
    assert 17 <= cells.chosen.cells / cells.chosen.strings <= 19
    assert all((one.value is None) or one.cells in allowed for one in cells.tried)
    assert any("do not divide into strings of 17 to 19" in one.reason for one in cells.tried)


def test_no_whole_cells_at_all_is_infeasible_with_reasons():
    small = {"design_space.module_area_m2": {"minimum": 0.1, "maximum": 0.6}}
    wide = WHOLE_CELLS | {"cell_span_m": 2.5, "cell_area_m2": 0.3125}
    aircraft = plane(
        wide | {"bays": [{"cells": [1, 1]}]}, **small, **{"design_space.wingspan_m.maximum": 6.0}
    )
    study = sized(aircraft, "min_mass")
    assert not study.feasible
    assert study.status.name == "infeasible"
    assert "no design of whole cells" in str(study.summary())
    assert study.to_dict()["whole_cells"]["chosen"] is None
    (missed,) = study.result.violations
    assert (missed.requirement, missed.shortfall) == ("whole_cells", 1.0)  # all of them
    assert all(design.value is None and design.reason for design in study.whole_cells.tried)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"with_sensitivities": True}, "leave them out"),
        ({"reliability": 0.9}, "leave them out"),
        ({"objective": "longest_season"}, "no whole cells"),
        ({"aircraft": sizing.load_aircraft("atlantiksolar-design")}, r"need modules\.layout"),
    ],
)
def test_what_does_not_go_together_is_refused(options, words):
    aircraft = options.pop("aircraft", plane(WHOLE_CELLS))
    with pytest.raises(ValueError, match=words):
        sizing.size(aircraft, MISSION, whole_cells=True, **options)
