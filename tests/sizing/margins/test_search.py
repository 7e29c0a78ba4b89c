"""Parts of the searches for a probability and for a season, each by itself: they run every time."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from missions.library import load_mission
from sizing.library import load_aircraft
from sizing.margins.probability import _next_index, _ReliableSizing
from sizing.margins.search import fitted, least_income, least_step
from sizing.margins.season_flights import Powers, SeasonDays, _near, days_of_season
from sizing.margins.season_search import SeasonSearch, Steps
from sizing.margins.survival import _SurvivalSizing, check_survival, in_the_record
from sizing.optimisation.objectives import Objective
from sizing.relaxed_flight import Relaxation


def hyperbola(income, storage):
    """Days that close: more of both closes more, none below an income of one."""
    return np.floor(10.0 * np.exp(income) * (1.0 - np.exp(-np.exp(storage)))).astype(int)


@pytest.mark.parametrize("at_once", [1, 3])
def test_least_income_is_the_edge_of_what_closes(at_once):
    storage = np.log([0.5, 1.0, 2.0])
    found = least_income(hyperbola, storage, (0.0, 4.0), 20, at_once=at_once)
    # Twenty days need an income of 2/(1 - exp(-storage)); to a five-hundredth of the ends.
    exact = np.log(2.0 / (1.0 - np.exp(-np.exp(storage))))
    assert np.all((found >= exact) & (found <= exact + 4.0 / 500.0))
    assert np.isnan(least_income(hyperbola, storage, (0.0, 4.0), 10_000)).all()


def test_least_step_is_that_of_both_alike():
    found = least_step(hyperbola, (-1.0, 1.0), 10)
    # exp(s) (1 - exp(-exp(s))) = 1 where exp(s) = 1.3499765 (bisected by hand).
    assert found == pytest.approx(math.log(1.3499765), abs=2.0 / 4000.0)
    assert math.isnan(least_step(hyperbola, (-1.0, 1.0), 10_000))


def test_days_of_a_season_may_cross_the_new_year():
    across = load_mission("rafz-july", {"dates": {"from": "12-30", "to": "01-02"}, "launch": None})
    axis = np.array([363, 364, 365, 1, 2, 3])
    assert days_of_season(axis, across).tolist() == [False, True, True, True, True, False]
    season = np.array([False, False, False, True, True, False, False])
    # Two days ahead, and the morning on which the last night ends.
    assert _near(season, 2).tolist() == [False, True, True, True, True, True, False]


def test_scaled_powers_keep_the_load():
    one = Powers(np.array([2.0]), np.array([[30.0, 50.0]]), np.array([10.0]), np.array([500.0]))
    scaled = one.scaled(np.array([1.0, 3.0]), np.array([2.0, 1.0]))
    assert scaled.area_m2.tolist() == [2.0, 6.0]
    assert scaled.battery_wh.tolist() == [1000.0, 500.0]
    # Over a mean load of 50 W.
    assert np.exp(scaled.place) == pytest.approx(np.array([[0.04, 0.12], [20.0, 10.0]]))


def test_steps_are_told_up_to_all_of_them():
    told = []
    steps = Steps(lambda done, total: told.append((done, total)))
    for count, made in ((3, 2), (2, 2)):
        with steps.of(count):
            for _ in range(made):
                steps.next()
    assert told == [(0, 3), (1, 3), (2, 3), (3, 3), (3, 5), (4, 5), (5, 5), (5, 5)]


def test_a_season_is_sized_for_a_share_of_the_days_of_the_record():
    for share in (0.0, 1.1, math.nan):
        with pytest.raises(ValueError, match="above 0 and at most 1"):
            check_survival(Objective.min_mass, share)
    with pytest.raises(ValueError, match="that of a repeated clear day"):
        check_survival(Objective.max_excess_time, 0.9)
    asked = {"clearness": 0.8, "required_excess_time_h": 3.0}
    there = in_the_record(load_mission("rafz-july", asked))
    assert (there.clearness, there.required_excess_time_h) == (1.0, 0.0)


def test_margins_fail_as_often_as_the_index_says():
    spread = ((0.02, 0.1), (-0.01, 0.2))
    found = _ReliableSizing._margins(SimpleNamespace(_margin_spread=spread), 0.25, 1.2815515655)
    # An index of 1.28155 fails in a tenth of the draws, a quarter of them by income: the normal
    # quantiles of 0.025 and 0.075 are -1.959964 and -1.439531 (Abramowitz and Stegun, table 26.5).
    assert found == pytest.approx([0.02 - 0.1959964, -0.01 - 0.2879062], abs=1e-6)


def test_next_index_stays_between_what_was_tried():
    tried = [(1.0, 0.8), (2.0, 1.9)]
    assert 1.0 < _next_index(tried, 1.3) < 2.0
    assert _next_index(tried[:1], 1.3) == pytest.approx(1.5)
    assert np.isfinite(_next_index([(1.0, 3.0), (1.0, 3.0)], 1.3))
    # By hand: 1 of the 2.5 from 2 to 4, though the last trial, above both, is no neighbour.
    assert _next_index([(2.0, 1.0), (4.0, 3.5), (5.0, 5.0)], 2.0) == pytest.approx(2.8)
    # Away from both neighbours by a tenth of their distance.
    assert _next_index([(2.0, 0.0), (4.0, 1.06)], 1.05) == pytest.approx(3.8)
    assert _next_index([(2.0, 0.0), (4.0, 1.06)], 0.01) == pytest.approx(2.2)


def test_days_of_each_year_are_counted():
    closes = np.array([True, False, True, True, False])
    days = SeasonDays(
        np.array([2001, 2001, 2003, 2003, 2003]), np.array([1, 2, 1, 2, 3]), closes, 1
    )
    assert [list(one.values()) for one in days.by_year()] == [
        [2001, 2, 1, 0.5],
        [2003, 3, 2, pytest.approx(2.0 / 3.0)],
    ]
    assert days.share == 0.6


def test_days_that_the_whole_record_takes_away_are_asked_for_on_top():
    """The search flies parts of the record: of its days two fewer close in all of it."""
    asked = []

    def best(days):
        asked.append(days)
        return days

    found = SimpleNamespace(
        needed=27,
        search=SimpleNamespace(best=best, found=[]),
        record=range(30),
        _days_of=lambda days: days - 2,
    )
    assert _SurvivalSizing._best(found) == 29
    assert asked == [27, 29]


@pytest.mark.parametrize(("present", "edge"), [(200.0, 300.0), (50.0, 20.0)])
def test_value_that_helps_in_the_record_is_told_to_one_per_cent(present, edge):
    """The program's day wants a tenth of what the record does: further is tried, then bisected."""
    upwards = edge > present
    fake = SimpleNamespace(
        _closes_enough=lambda _key, value, _factors: value >= edge if upwards else value <= edge
    )
    direction = "at least" if upwards else "at most"
    found = present + 0.1 * (edge - present)
    one = Relaxation("battery.mass_kg", "kg", present, direction, found, 1.0)
    value = _SurvivalSizing._flown(fake, one, None).value
    # Bisected to one per cent; three digits on the safe side.
    assert 0.0 <= (value - edge if upwards else edge - value) <= 0.011 * edge


def test_limits_on_the_battery_hold_for_the_battery_that_is_carried():
    """The program counts it e^s times as large: its energy is larger and its rate smaller by so."""
    keys = ("battery_energy_wh.maximum", "cruise_discharge_rate_per_h.maximum")
    values = dict(zip((f"design_space.limits.{key}" for key in keys), (900.0, 0.2), strict=True))
    search = SimpleNamespace(
        aircraft=load_aircraft("atlantiksolar-design", values),
        limited=["battery_energy_wh", "cruise_discharge_rate_per_h"],
    )
    seen = SeasonSearch.with_limits(search, np.log([1.0, 2.0])).design_space.all_limits()
    assert seen["battery_energy_wh"].maximum == pytest.approx(1800.0)
    assert seen["cruise_discharge_rate_per_h"].maximum == pytest.approx(0.1)


def test_fitted_cost_of_a_quadratic_function_is_that_function():
    places = np.random.default_rng(3).uniform(-0.3, 0.3, (40, 2))

    def exact(at):
        x, y = at[..., 0], at[..., 1]
        return 2.0 + 3.0 * x - y + 0.5 * x * x - 2.0 * x * y + 4.0 * y * y

    cost = fitted(places, exact(places), here=7)
    # Exact but for the ridge of 1e-4 on forty weighted rows, which takes some per cent of the
    # curvature of 4 over steps of 0.3.
    for at in (places[7], places, places.reshape(5, 8, 2)):
        assert cost(at).shape == at.shape[:-1]
        assert cost(at) == pytest.approx(exact(at), abs=0.02)
    assert cost(places[7]) == pytest.approx(exact(places[7]), rel=1e-12)
