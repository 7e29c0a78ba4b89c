"""The longest season and the widest band: what one design keeps up, and that no other does more."""

from functools import cache, partial

import builders
import numpy as np
import pytest
from builders import SMALL_WINGS

from missions.mission import Scenarios
from sizing.day.light import solar_day
from sizing.performance import performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.ranges import DAYS, widest_range
from sizing.program.result import SizingStatus
from sizing.program.size import size_aircraft

pytestmark = pytest.mark.slow

aircraft = partial(builders.aircraft, "atlantiksolar-design")
mission = builders.mission


@cache
def range_of_span(span_m, objective):
    plane = aircraft(f"design_space.wingspan_m.maximum={span_m}", *SMALL_WINGS[1:])
    return widest_range(plane, mission(), objective, required_excess_time_h=2.0)


def test_longest_season_is_kept_up_and_its_neighbours_are_not_by_any_design():
    plane = aircraft(*SMALL_WINGS)
    found = range_of_span(4.0, Objective.longest_season)
    assert found.first is not None
    days = found.members.astype(int)
    # Around the longest day, and every day of it is judged by the simulator.
    assert 172 in days
    assert found.extent == len(days)
    assert set(found.sizing.simulated.day.scenarios.day_of_year) == set(days)
    ranged = mission(dates={"from": "01-01", "to": "12-31", "count": 365})
    perf = performance_of_designs(plane, ranged, found.sizing.design.variables)
    kept = perf.day.scenarios.day_of_year[perf.cycle.excess_time_h >= 2.0]
    assert set(days) <= set(kept.tolist())
    # One day more on both sides is beyond every design: sized for exactly those two days.
    both = solar_day(plane, ranged).at([days[0] - 2, days[-1]])
    longer = size_aircraft(
        plane, ranged, Objective.max_excess_time, required_excess_time_h=0.0, day=both
    )
    assert longer.objective_value is None or longer.objective_value < 2.0


# In the tropics both ends of a season are about as hard, and which comes first is hardly told.
@pytest.mark.parametrize(
    ("name", "span_m", "latitude_deg", "altitude_m", "required_h"),
    [("atlantiksolar-design", 4.0, 20.5, 0.0, 2.0), ("sky-sailor", 6.0, -8.5, 3000.0, 1.9)],
)
def test_no_run_one_day_longer_is_kept_up(name, span_m, latitude_deg, altitude_m, required_h):
    small = "airframe.wingspan_m=3", "modules.area_m2=0.4"
    bound = f"design_space.wingspan_m.maximum={span_m}"
    plane = builders.aircraft(name, bound, *small)
    place = mission(latitude_deg=latitude_deg, altitude_m=altitude_m, air={})
    found = widest_range(plane, place, Objective.longest_season, required_excess_time_h=required_h)
    days = found.members.astype(int)
    every = solar_day(plane, place, scenarios=Scenarios(np.full(365, latitude_deg), DAYS))
    for shift in range(-3, 4):
        first = days[0] - 1 + shift
        longer = np.arange(first - 1, first + len(days)) % 365
        sized = size_aircraft(
            plane, place, Objective.max_excess_time, day=every.at(longer), explain=False
        )
        assert sized.objective_value is None or sized.objective_value < required_h


def test_season_near_the_equator_spans_both_of_its_peaks():
    # The sun stands in the zenith twice a year, in April and in September: days sized each on its
    # own have 3.17 h and 3.11 h then, and 2.99 h early in June. A run of both is kept up together.
    bound = "design_space.wingspan_m.maximum=5"
    plane = builders.aircraft("sky-sailor", bound, "airframe.wingspan_m=3", "modules.area_m2=0.4")
    place = mission(latitude_deg=6.0, air={})
    found = widest_range(plane, place, Objective.longest_season, required_excess_time_h=2.5)
    assert found.extent >= 270


def test_band_is_found_where_the_solver_fails_at_its_easiest_latitude():
    small = "airframe.wingspan_m=3", "modules.area_m2=0.4", "design_space.wingspan_m.maximum=12"
    plane = builders.aircraft("sky-sailor", *small)
    june = mission(dates={"on": "06-21"}, altitude_m=0.0, air={})
    found = widest_range(plane, june, Objective.widest_latitude_band, required_excess_time_h=6.0)
    assert found.sizing.status is SizingStatus.optimal
    # At 50° N alone a design has 6.36 h.
    assert found.first < 55.0
    assert found.last == 90.0


def test_season_wraps_the_years_end_in_the_south():
    plane = aircraft(*SMALL_WINGS)
    found = widest_range(plane, mission(latitude_deg=-47.6), Objective.longest_season)
    assert found.last < found.first
    assert {355, 1} <= set(found.members.astype(int))


def test_wider_span_means_a_longer_season_and_a_wider_band():
    for objective in (Objective.longest_season, Objective.widest_latitude_band):
        extents = [range_of_span(span_m, objective).extent for span_m in (4.0, 5.0)]
        assert 0.0 < extents[0] < extents[1]


def test_range_that_is_empty_is_infeasible():
    found = widest_range(
        aircraft(*SMALL_WINGS), mission(), Objective.longest_season, required_excess_time_h=40.0
    )
    assert found.sizing.status is SizingStatus.infeasible
    assert found.extent == 0.0
    assert found.sizing.violations
