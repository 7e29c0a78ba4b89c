"""Many sizings at once: the same designs and verdicts as one by one."""

import numpy as np
import pytest

from missions.dates import date_code
from missions.library import load_mission
from missions.mission import Scenarios
from missions.mission.scenarios import Dates
from sizing.day.light import UNCORRECTED_CAM, solar_day
from sizing.library import load_aircraft
from sizing.performance import performance_of_designs
from sizing.program.cells import _Cells, size_cells
from sizing.program.objectives import SINGLE_OBJECTIVES, Objective
from sizing.program.result import SizingStatus
from sizing.program.size import size_aircraft
from sizing.program.task import SizingTask

pytestmark = pytest.mark.slow

LATITUDES = np.arange(0.0, 75.0, 12.0)
DAYS = np.array([1, 80, 130, 172, 230, 300])
CELLS = Scenarios(np.repeat(LATITUDES, len(DAYS)), np.tile(DAYS, len(LATITUDES)))
AIRCRAFT = load_aircraft("atlantiksolar-design", ["design_space.wingspan_m.maximum=7"])
MISSION = load_mission("central-europe-summer", ["required_excess_time_h=2.0"])


def at(cell):
    on = Dates(on=date_code(int(CELLS.day_of_year[cell])))
    place = float(CELLS.latitude_deg[cell])
    return MISSION.model_copy(update={"latitude_deg": place, "dates": on})


@pytest.mark.parametrize("objective", SINGLE_OBJECTIVES)
def test_cells_are_sized_as_one_by_one(objective):
    found = size_cells(AIRCRAFT, MISSION, CELLS, objective)
    feasible = 0
    for cell in range(0, len(CELLS), 5):
        alone = size_aircraft(AIRCRAFT, at(cell), objective)
        sized = found.status[cell] in (SizingStatus.cross_checked, SizingStatus.optimal)
        assert sized == alone.feasible, CELLS.label(cell)
        if not sized:
            assert found.status[cell] == SizingStatus.infeasible
            assert found.requirement[cell]
            assert found.shortfall[cell] > 0.0
            assert np.isnan(found.objective_value[cell])
            continue
        feasible += 1
        # Both stop within 0.012 h of the requirement; payload falls by a percent in that time.
        assert found.objective_value[cell] == pytest.approx(alone.objective_value, rel=0.01)
    assert 0 < feasible < len(range(0, len(CELLS), 5))


def test_a_cell_without_design_says_what_a_sizing_alone_says():
    cell = CELLS.label(place := int(np.argmax(LATITUDES == 60.0)) * len(DAYS))
    found = size_cells(AIRCRAFT, MISSION, CELLS, Objective.min_wingspan)
    alone = size_aircraft(AIRCRAFT, at(place), Objective.min_wingspan)
    (text,) = [one.text for one in alone.violations if one.requirement == found.requirement[place]]
    assert cell in text
    # By how much is a matter of the nearest design, of which a hopeless cell has many.
    assert found.message[place].partition(" short by ")[0] == text.partition(" short by ")[0]


def test_reported_numbers_are_the_simulators():
    found = size_cells(AIRCRAFT, MISSION, CELLS, Objective.min_mass)
    for cell in np.flatnonzero(found.status == SizingStatus.cross_checked)[::4]:
        variables = found.variables.mapped(lambda v, cell=cell: float(v[cell]))
        perf = performance_of_designs(AIRCRAFT, at(int(cell)), variables)
        assert float(perf.cycle.excess_time_h[0]) == pytest.approx(
            found.excess_time_h[cell], rel=1e-9
        )
        assert found.excess_time_h[cell] >= 2.0
        assert float(perf.design.total_mass_kg) == pytest.approx(
            found.total_mass_kg[cell], rel=1e-9
        )


def test_payload_of_each_cell_counts():
    same = Scenarios(np.full(5, 47.6), np.full(5, 172))
    payload = np.array([0.0, 0.5, 1.0, 2.0, 60.0])
    found = size_cells(AIRCRAFT, MISSION, same, Objective.min_wingspan, payload_mass_kg=payload)
    assert np.all(np.diff(found.objective_value[:4]) > 0.0)
    assert found.status[4] == SizingStatus.infeasible
    np.testing.assert_allclose(found.variables.payload_mass_kg[:4], payload[:4], atol=1e-12)
    drawing = size_cells(
        AIRCRAFT, MISSION, same, Objective.min_wingspan, payload_power_w=10.0 * payload
    )
    assert np.all(np.diff(drawing.objective_value[:3]) > 0.0)


def test_polar_night_and_midnight_sun_are_ordinary_cells():
    found = size_cells(AIRCRAFT, MISSION, Scenarios(np.array([80.0, 80.0]), np.array([355, 172])))
    assert found.status[0] == SizingStatus.infeasible
    assert found.requirement[0] == "sun"
    assert found.message[0] == "polar night: the sun never rises at 80° N, 21 Dec"
    assert found.status[1] in (SizingStatus.cross_checked, SizingStatus.optimal)


def test_best_of_designs_without_end_is_cross_checked():
    # All neighbours of such an optimum are without end as well: none is better.
    pole = Scenarios(np.array([90.0]), np.array([172]))
    with np.errstate(invalid="raise"):
        cells = size_cells(AIRCRAFT, MISSION, pole, Objective.max_excess_time)
    assert cells.status[0] == SizingStatus.cross_checked
    assert np.isposinf(cells.excess_time_h[0])


def test_ranges_and_measured_aircraft_are_refused():
    with pytest.raises(ValueError, match="counts days or degrees"):
        size_cells(AIRCRAFT, MISSION, CELLS, Objective.longest_season)
    with pytest.raises(TypeError, match="measured aircraft"):
        size_cells(load_aircraft("atlantiksolar-as2"), MISSION, CELLS)


@pytest.mark.parametrize("climb", [[], ["climb={ceiling_m: 2500}"]])
@pytest.mark.parametrize(("worse", "checked"), [(0.0, True), (0.02, False)])
def test_a_span_that_neighbours_undercut_is_not_cross_checked(worse, checked, climb):
    aircraft, mission = load_aircraft("atlantiksolar-design"), load_mission("rafz-july", climb)
    day = solar_day(aircraft, mission)
    goal = Objective.min_wingspan, UNCORRECTED_CAM, day, 2.0
    cells = _Cells([SizingTask(aircraft, mission, *goal)], day)
    cells.run(seed=0)
    merits = np.array([cells.searches[0].merit * (1.0 + worse)])
    assert cells._checked(np.array([0]), merits, seed=0).tolist() == [checked]
