"""The optimiser against searches through the simulator, and its verdicts."""

from typing import NamedTuple

import casadi as ca
import numpy as np
import pytest
from builders import AS2, DESIGN, SKY_SAILOR, aircraft, mission, shipped_mission

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.battery.battery import RuleChargeLimit, charge_rate_per_h
from sizing.day.light import SolarModel, solar_day
from sizing.design import variables_of
from sizing.limits import ROW_TOLERANCE
from sizing.performance import performance_of_designs
from sizing.program.cells import size_cells
from sizing.program.cross_check import cross_check
from sizing.program.objectives import SINGLE_OBJECTIVES, Objective
from sizing.program.result import SizingStatus
from sizing.program.size import size_aircraft
from sizing.program.transcription import charge_clock

MAX_EXCESS, MIN_SPAN, MIN_MASS = (
    Objective.max_excess_time,
    Objective.min_wingspan,
    Objective.min_mass,
)


TABLE = {"charge_limit": AS2.battery.charge_limit}
TABLE_LIMITED = DESIGN.model_copy(update={"battery": DESIGN.battery.model_copy(update=TABLE)})


class Case(NamedTuple):
    plane: Aircraft
    mission: Mission
    objective: Objective
    required_h: float | None = None
    solar: SolarModel = SolarModel()


RANGE = mission(
    latitude_deg={"from_deg": 42.0, "to_deg": 50.0, "count": 3},
    dates={"from": "05-01", "to": "08-15", "count": 2},
)
CASES = {
    "rule, one day, excess": Case(DESIGN, mission(), MAX_EXCESS),
    "rule, range, span": Case(DESIGN, RANGE, MIN_SPAN, 6.0),
    "table, payload, mass": Case(
        TABLE_LIMITED, mission(payload={"mass_kg": 0.4, "power_w": 3.0}), MIN_MASS, 6.0
    ),
    "rule, wind, mass": Case(DESIGN, mission(wind_m_per_s=9.0), MIN_MASS, 5.0),
    "no limit, free ratio, excess": Case(SKY_SAILOR, mission(), MAX_EXCESS),
    "no limit, free ratio, span": Case(SKY_SAILOR, mission(dates={"on": "06-10"}), MIN_SPAN, 2.0),
    "table, range, excess": Case(TABLE_LIMITED, RANGE, MAX_EXCESS),
    "rule, thermals, corrected, span": Case(
        DESIGN,
        mission(turbulence={"all_day": 0.05, "thermal": 0.3}),
        MIN_SPAN,
        4.0,
        SolarModel("CDM", "report"),
    ),
}


def size(case):
    return size_aircraft(
        case.plane, case.mission, case.objective, case.solar, required_excess_time_h=case.required_h
    )


@pytest.mark.parametrize("name", CASES)
def test_optimum_is_confirmed_by_the_simulator_and_keeps_its_bounds(name):
    case = CASES[name]
    result = size(case)
    assert result.status is SizingStatus.optimal
    assert cross_check(case.plane, case.mission, result, case.solar).cross_checked
    assert result.objective_value is not None
    chosen = result.design.variables.mapped(float)
    again = performance_of_designs(case.plane, case.mission, chosen, case.solar)
    worst = float(again.cycle.excess_time_h.min())
    mass = float(again.design.total_mass_kg)
    # The result's own simulation is this one.
    assert float(result.simulated.cycle.excess_time_h.min()) == pytest.approx(worst, abs=1e-9)
    assert result.design.total_mass_kg == pytest.approx(mass, rel=1e-9)
    if case.objective is MAX_EXCESS:
        # Half a percent or 0.01 h: the program's nodes are 15 min apart, the simulator's 5.
        assert result.objective_value == pytest.approx(worst, rel=5e-3, abs=0.01)
    else:
        value = chosen.wingspan_m if case.objective is MIN_SPAN else mass
        assert result.objective_value == pytest.approx(value, rel=1e-9)
    assert worst > 0.0
    # The requirement is met as the simulator sees it.
    assert worst >= (case.required_h or 0.0) - 1e-9
    space, airframe = case.plane.design_space, case.plane.airframe
    # The solver relaxes bounds by 1e-8 of their size.
    near = 1.0 + 1e-6
    for value, bound in (
        (chosen.wingspan_m, space.wingspan_m),
        (chosen.battery_mass_kg, space.battery_mass_kg),
        (chosen.module_area_m2, space.module_area_m2),
        (chosen.aspect_ratio, space.aspect_ratio),
    ):
        if bound is not None:
            assert bound.minimum / near <= value <= bound.maximum * near
    wing = chosen.wingspan_m**2 / chosen.aspect_ratio
    assert chosen.module_area_m2 <= airframe.maximum_module_coverage * wing * near
    assert float(result.design.airspeed_m_per_s) * near >= case.mission.wind_m_per_s


@pytest.mark.parametrize("objective", SINGLE_OBJECTIVES)
def test_result_does_not_depend_on_the_starting_design(objective):
    starts = ((5.65, 2.918, 1.35), (2.1, 0.3, 0.12), (9.0, 0.5, 0.2))
    found = []
    for span, battery, area in starts:
        plane = aircraft(
            "atlantiksolar-design",
            f"airframe.wingspan_m={span}",
            f"battery.mass_kg={battery}",
            f"modules.area_m2={area}",
        )
        result = size(Case(plane, mission(), objective, 5.0))
        assert result.status is SizingStatus.optimal
        found.append(result.objective_value)
    # The solver's tolerance is 1e-8, its acceptable one 1e-6; cushions of 0.01 h that are added
    # in rounds may differ by one: 0.1 %.
    np.testing.assert_allclose(found, found[0], rtol=1e-3)


@pytest.mark.parametrize(
    ("changes", "objective", "required_h", "blamed"),
    [
        ({"payload": {"mass_kg": 200.0}}, MAX_EXCESS, None, None),
        ({}, MIN_MASS, 60.0, "excess_time"),
        # Designs near the least miss fly perpetually, yet none outflies this wind.
        ({"wind_m_per_s": 60.0}, MIN_MASS, 2.0, "airspeed_above_wind"),
        (
            {"latitude_deg": 60.0, "dates": {"from": "12-01", "to": "12-31"}},
            MAX_EXCESS,
            None,
            "energy_balance",
        ),
        ({"latitude_deg": 80.0, "dates": {"on": "12-21"}}, MIN_SPAN, 1.0, "sun"),
    ],
    ids=["payload", "60 h", "wind", "winter", "polar night"],
)
def test_infeasible_is_said_with_what_is_missed(changes, objective, required_h, blamed):
    result = size(Case(DESIGN, mission(**changes), objective, required_h))
    assert result.status is SizingStatus.infeasible
    assert not result.feasible
    assert result.objective is objective
    assert result.required_excess_time_h == (required_h or 0.0)
    assert result.design is None
    assert result.objective_value is None
    assert result.simulated is None
    assert len(result.violations) > 0
    assert all(v.shortfall > 0.0 and v.text for v in result.violations)
    if blamed is not None:
        assert blamed in {v.requirement for v in result.violations}
    assert result.nearest is not None


@pytest.mark.parametrize("beyond_h", [0.4, 90.0])
def test_shortfall_of_the_excess_time_is_in_hours(beyond_h):
    plane = DESIGN
    best = size(Case(plane, mission(), MAX_EXCESS)).objective_value
    result = size(Case(plane, mission(), MIN_MASS, best + beyond_h))
    shortfall = {v.requirement: v.shortfall for v in result.violations}
    # What is missed is the distance to the best there is; 5 % for the nearest design being chosen
    # by a penalty on all requirements.
    assert shortfall["excess_time"] == pytest.approx(beyond_h, rel=0.05)


def test_span_below_what_the_mission_needs_is_infeasible_and_above_it_is_not():
    case = CASES["rule, range, span"]
    least = size(case).objective_value
    # One percent to each side of the optimum, which is known to half a percent.
    for factor, status in ((0.99, SizingStatus.infeasible), (1.01, SizingStatus.optimal)):
        plane = aircraft(
            "atlantiksolar-design",
            f"design_space.wingspan_m.maximum={least * factor}",
            "airframe.wingspan_m=4.0",
            "modules.area_m2=0.5",
        )
        assert size(case._replace(plane=plane)).status == status


def test_solver_prints_nothing(capfd):
    size(CASES["rule, one day, excess"])
    size(Case(DESIGN, mission(), MIN_MASS, 60.0))
    captured = capfd.readouterr()
    assert captured.out == ""
    assert captured.err == ""


def test_measured_aircraft_is_not_sized():
    with pytest.raises(TypeError, match="measured aircraft"):
        size_aircraft(AS2, mission())


def test_scenarios_that_join_late_do_not_end_a_search_far_from_its_start():
    """Short steps were kept when a scenario joined, and what they missed was called infeasible."""
    here, solar = shipped_mission("stratosphere-mission"), SolarModel()
    plane = aircraft("stratosphere-design")
    light = solar_day(plane, here, solar)
    start = size_aircraft(plane, here, MIN_MASS, solar, day=light).design.variables
    margins = here.uncertainty_margins.model_copy(update={"battery_capacity": 0.93})
    margined = here.model_copy(update={"uncertainty_margins": margins})
    case, dim = (plane, margined, MIN_MASS, solar), light.scaled(0.82)
    from_far = size_aircraft(*case, day=dim, start=start, explain=False)
    assert from_far.design is not None
    assert from_far.merit == pytest.approx(size_aircraft(*case, day=dim).merit, rel=1e-3)


def test_designs_of_cells_are_faster_than_the_wind_of_their_own_cell():
    """Of two places the second is windier than the first: its lighter neighbour is none for it."""
    here, plane = shipped_mission("stratosphere-mission"), aircraft("stratosphere-design")
    places = Scenarios(np.array([0.0, 20.0, 40.0]), np.array([41, 201, 201]))
    cells = size_cells(plane, here, places, MIN_MASS)
    winds = here.scenario_winds_m_per_s(places)
    assert winds[1] > 1.1 * max(winds[0], winds[2])
    assert np.all(cells.airspeed_m_per_s >= winds * (1.0 - ROW_TOLERANCE))
    light = solar_day(plane, here, SolarModel(), scenarios=places).at([1])
    alone = size_aircraft(plane, here.in_wind(float(winds[1])), MIN_MASS, day=light)
    assert cells.objective_value[1] == pytest.approx(alone.objective_value, rel=1e-3)


def test_a_start_may_hold_arrays():
    """As the optimum of a search with margins does, from which the next one starts."""
    start = variables_of(DESIGN)
    found = [
        size_aircraft(DESIGN, mission(), Objective.min_mass, start=one)
        for one in (start, start.mapped(np.asarray))
    ]
    assert found[0].objective_value == found[1].objective_value is not None


@pytest.mark.parametrize("limit", [RuleChargeLimit(), AS2.battery.charge_limit])
def test_charge_limit_goes_on_beyond_full(limit):
    """The solver tries charges above full, many times as much with next to no battery."""
    soc = np.array([0.99, 1.0, 1.01, 2.0, 1e4])
    hours = np.asarray(charge_clock(limit, ca.DM(soc))).ravel()
    at_full_h = 1.0 / charge_rate_per_h(limit, 1.0)
    assert float(charge_clock(limit, ca.DM(0.0))) == pytest.approx(0.0, abs=1e-12)
    assert np.diff(hours)[1:] / np.diff(soc)[1:] == pytest.approx(at_full_h, rel=1e-9)
    assert 0.0 < hours[1] - hours[0] <= 0.01 * at_full_h * (1.0 + 1e-9)


def test_a_given_light_is_that_of_search_and_simulation():
    day = solar_day(DESIGN, mission()).scaled(0.8)
    result, bright = (
        size_aircraft(DESIGN, mission(), MIN_MASS, day=light, required_excess_time_h=4.0)
        for light in (day, None)
    )
    chosen = result.design.variables.mapped(float)
    again = performance_of_designs(DESIGN, mission(), chosen, day=day)
    excess_h = float(result.simulated.cycle.excess_time_h.min())
    assert excess_h == pytest.approx(float(again.cycle.excess_time_h.min()), abs=1e-9)
    assert excess_h == pytest.approx(4.0, abs=0.012)
    assert result.design.total_mass_kg > 1.02 * bright.design.total_mass_kg


def test_a_search_that_may_end_early_ends_with_as_much_in_every_scenario():
    far = mission(latitude_deg={"from_deg": 30.0, "to_deg": 60.0, "count": 3})
    best = size_aircraft(DESIGN, far, MAX_EXCESS)
    each_h = best.simulated.cycle.excess_time_h
    assert each_h.max() > 1.05 * each_h.min()
    for share in (0.9, 0.96, 0.99):
        early = size_aircraft(DESIGN, far, MAX_EXCESS, stop_at_merit=share * best.objective_value)
        assert early.objective_value >= share * best.objective_value
        assert early.solver.solves <= best.solver.solves
