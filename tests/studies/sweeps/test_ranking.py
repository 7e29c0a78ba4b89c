"""Tables of trade studies: the best points first, Pareto fronts with named points."""

from itertools import islice

import numpy as np
import pytest

import missions
import sizing
from studies.sweeps.results import SweepResult, best_first, pareto_table, point_names, sorted_by
from studies.sweeps.study import sweep

MISSION = missions.load_mission("rafz-july")
DESIGN = sizing.load_aircraft("atlantiksolar-design")


@pytest.fixture(scope="module")
def data():
    """Of nine designs some do not fly perpetually."""
    varied = {"battery_mass_kg": [0.5, 2.0, 4.0], "wingspan_m": [3.0, 4.0, 5.0]}
    return sweep(DESIGN, MISSION, varied, workers=1)


def test_perpetual_flight_comes_first_then_the_largest_excess_time(data):
    table, order = best_first(data)
    assert order == "perpetual flight first, then the largest excess time"
    status = table["status"].tolist()
    assert set(status) == {"limited", "perpetual"}
    assert status == sorted(status, reverse=True)
    for _, rows in table.groupby("status"):
        assert (np.diff(rows["excess_time"]) <= 0.0).all()


def test_sized_points_are_ordered_by_their_objective():
    sized = sweep(DESIGN, MISSION, {"wingspan_m": [2.0, 5.0, 4.0, 6.0]}, resize="min_mass")
    table, order = best_first(sized)
    assert order == "points with a design first, then the least total mass"
    assert table["status"].tolist() == ["optimal"] * 3 + ["infeasible"]
    assert table["total_mass"].head(3).is_monotonic_increasing
    assert "endurance" not in str(SweepResult(sized))


def test_a_key_sorts_upwards_and_with_a_minus_downwards(data):
    up, order = sorted_by(data, "total_mass")
    assert (up["total_mass"].is_monotonic_increasing, order) == (True, "least total_mass")
    assert sorted_by(data, "-total_mass")[0]["total_mass"].is_monotonic_decreasing
    with pytest.raises(ValueError, match="'mass' is not one of battery_mass_kg"):
        sorted_by(data, "mass")


def test_rows_that_are_not_shown_are_counted(data):
    text = str(SweepResult(data, top=2))
    assert "7 more not shown" in text
    every = SweepResult(data.isel(wingspan_m=[0, 1, 2] * 3)).at_level(2).to_text()
    assert "not shown" not in every
    assert "not shown" not in str(SweepResult(data))


def test_points_of_a_front_have_names_in_the_order_of_the_first_column(data):
    table = pareto_table(data, "total_mass", "excess_time")
    front = table[table["pareto_front"]]
    assert front["point"].tolist() == list("ABCDEFGHI"[: len(front)])
    assert front["total_mass"].is_monotonic_increasing
    assert front["excess_time"].is_monotonic_increasing
    assert set(table["point"][~table["pareto_front"]]) <= {""}
    record = SweepResult(data, front=("wingspan_m", "excess_time")).to_dict()["pareto_front"]
    assert [point["point"] for point in record["points"]] == list("ABC"[: len(record["points"])])
    text = str(SweepResult(data, front=("total_mass", "excess_time")))
    assert "Pareto front of less total mass and more excess time" in text
    assert text.count("perpetual") == len(front) + 1  # and in the heading
    # A varied key is shown once; names do not run out.
    heads = str(SweepResult(data, front=("wingspan", "excess_time"))).split("───")[0]
    assert heads.count("[m]") == 1
    names = list(islice(point_names(), 1000))
    assert names[25:28] == ["Z", "AA", "AB"]
    assert len(set(names)) == 1000
