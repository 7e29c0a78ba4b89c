"""The one loop of all searches, with a program and a simulator that are told what to say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import pytest

from sizing.design import DesignVariables
from sizing.optimisation.loop import Search, Simulated, run
from sizing.optimisation.result import GOAL_CUSHION_H, ProblemInstance, Solution
from sizing.program.objectives import Objective
from sizing.program.result import SizingStatus


@dataclass(frozen=True)
class Found:
    """As much of a solution as the loop looks at: a wing that grows with the goal."""

    instance: ProblemInstance
    climbs: bool = False
    height: float = 1.0

    @property
    def design(self) -> DesignVariables:
        error = self.instance.height_errors.get(0, 0.0)
        return DesignVariables(3.0 + self.instance.goal_h, 15.0, 2.0, 1.0 + error)

    def held_back(self) -> dict[int, tuple[float, float]]:
        return {0: (self.height, 1.0)} if self.climbs else {}

    def cost(self, excess_time_h: float, margin: float = 0.0) -> float:
        return 0.02 * excess_time_h + margin


class Simulator:
    """Excess time of the design: the goal of its program less what the program flatters."""

    def __init__(self, flattered_h: Sequence[float]) -> None:
        self.flattered_h, self.goals_h = flattered_h, list[float]()

    def __call__(self, searches: Sequence[Search]) -> list[Simulated]:
        (search,) = searches
        goal_h = search.current.instance.goal_h
        self.goals_h.append(goal_h)
        excess_h = [goal_h - lost_h for lost_h in self.flattered_h]
        worst = excess_h.index(min(excess_h))
        return [Simulated(excess_h[worst], worst, -goal_h, sound=True)]


def solve(search: Search) -> Solution | None:
    return cast(Any, Found(search.instance))


def searched(
    flattered_h: Sequence[float], required_h: float = 2.0, rounds: int = 12
) -> tuple[Search, Simulator]:
    instance = ProblemInstance.of(Objective.min_wingspan, required_h)
    search = Search(instance, required_h, [0], solve, count=len(flattered_h))
    simulator = Simulator(flattered_h)
    run([search], simulator, rounds=rounds)
    return search, simulator


def test_goal_is_shifted_by_what_the_simulator_finds_otherwise() -> None:
    search, simulator = searched([0.5])
    assert simulator.goals_h == pytest.approx([2.0 + GOAL_CUSHION_H, 2.5 + GOAL_CUSHION_H])
    assert search.best is not None
    assert search.best.found.excess_time_h == pytest.approx(2.0 + GOAL_CUSHION_H)


def test_worse_scenario_joins_before_the_goal_is_shifted() -> None:
    search, simulator = searched([0.0, 0.3])
    assert search.scenarios == [0, 1]
    assert search.blocks == 2
    assert simulator.goals_h[0] == simulator.goals_h[1] < simulator.goals_h[2]


def test_design_that_wastes_excess_time_is_tried_smaller_and_the_best_is_kept() -> None:
    search, simulator = searched([-0.4])
    assert simulator.goals_h == pytest.approx([2.0 + GOAL_CUSHION_H, 1.6 + GOAL_CUSHION_H])
    assert search.best is not None
    assert search.best.found.merit == pytest.approx(-1.6 - GOAL_CUSHION_H)


def test_battery_that_runs_empty_asks_for_more_recharge() -> None:
    search, _ = searched([5.0], rounds=1)
    assert search.best is None
    assert search.instance.margin == pytest.approx(3.0 * ProblemInstance({}, 0.0).margin)


def test_night_that_takes_more_with_climbs_moves_the_goal_as_well() -> None:
    # The simulator's night takes half an hour more than the program's, and below zero it says so by
    # another scale.
    def simulate(searches: Sequence[Search]) -> list[Simulated]:
        excess_h = searches[0].current.instance.goal_h - 0.5
        seen.append(excess_h)
        return [Simulated(excess_h if excess_h > 0.0 else 1.6 * excess_h, 0, 0.0, sound=True)]

    seen = list[float]()
    instance = ProblemInstance.of(Objective.min_wingspan, 0.0)
    search = Search(instance, 0.0, [0], lambda s: cast(Any, Found(s.instance, True)), count=1)
    run([search], simulate)
    assert search.best is not None
    assert 0.0 < seen[-1] < 0.02
    assert len(seen) <= 6  # the first margin on the recharge, three larger ones, then the goal


def test_leap_of_the_excess_time_is_enclosed_and_no_more() -> None:
    # A day that returns a little less lets the battery run empty: no design lies in between.
    edge_h, seen = 0.0101, list[float]()

    def simulate(searches: Sequence[Search]) -> list[Simulated]:
        (search,) = searches
        goal_h = search.current.instance.goal_h
        seen.append(goal_h)
        excess_h = 0.5 + goal_h if goal_h > edge_h else goal_h - 0.5
        return [Simulated(excess_h, 0, -goal_h, sound=True)]

    search = Search(ProblemInstance({}, 0.006), 0.0, [0], solve, count=1)
    run([search], simulate)
    assert search.best is not None
    # Within a quarter of the thousandth of the objective that the loop may waste.
    assert -search.best.found.merit == pytest.approx(edge_h, abs=0.25e-3 / 0.02)
    assert -search.best.found.merit > edge_h
    assert len(seen) < 8


def test_loop_ends_where_the_program_has_no_solution() -> None:
    instance = ProblemInstance.of(Objective.min_wingspan, 2.0)
    search = Search(instance, 2.0, [0], lambda _: None, count=1)
    run([search], Simulator([0.0]))
    assert search.best is None
    assert search.solution is None


def test_status_has_the_numbers_of_gridded_files() -> None:
    assert {status.name: int(status) for status in SizingStatus} == {
        "failed": -1,
        "optimal": 0,
        "infeasible": 1,
        "not_converged": 2,
        "invalid": 3,
        "cross_checked": 4,
    }
    assert [status.name for status in SizingStatus if status.sized] == ["optimal", "cross_checked"]


def ended_low(error: float, height: float) -> dict[int, float]:
    """Height of climbs that end too low, day after day."""
    # What a day lacks comes four times, since the next one begins with less; so does the gain
    # below the ceiling.
    return {0: min(height - 4.0 * error, 1.0)}


def climbing(height: float, error: float, most: float = 1.0) -> tuple[Search, list[float]]:
    """Search with a program whose climbs end too high by an error, and the errors it tries.

    ``most``: error up to which the program has a solution.
    """
    tried: list[float] = []

    def simulator(searches: Sequence[Search]) -> list[Simulated]:
        (search,) = searches
        tried.append(search.current.instance.height_errors.get(0, 0.0))
        goal_h = search.current.instance.goal_h
        climbed = ended_low(error - tried[-1], height)
        return [Simulated(goal_h, 0, -tried[-1], True, climbed=climbed)]

    def solution(one: Search) -> Solution | None:
        solved = one.instance.height_errors.get(0, 0.0) <= most
        return cast(Any, Found(one.instance, True, height)) if solved else None

    instance = ProblemInstance.of(Objective.min_wingspan, 2.0)
    search = Search(instance, 2.0, [0], solution, count=1)
    run([search], simulator)
    return search, tried


def test_at_the_ceiling_the_height_of_climbs_is_bisected() -> None:
    search, tried = climbing(1.0, 0.006)
    assert tried[:3] == pytest.approx([0.0, 0.024, 0.012])
    # Ends on the side that reaches the ceiling, within a thousandth of the objective.
    assert 0.006 <= tried[-1] < 0.008
    assert search.instance.height_errors == {0: tried[-1]}


def test_from_the_ceiling_the_height_is_looked_for_downwards_too() -> None:
    # The program's climbs end 0.006 too low, which nobody sees who ends at the ceiling.
    _, tried = climbing(1.0, -0.006)
    assert tried[:3] == pytest.approx([0.0, -0.004, -0.012])
    assert -0.006 <= tried[-1] < -0.004


def test_below_the_ceiling_errors_do_not_go_to_and_fro() -> None:
    _, tried = climbing(0.6, 0.006)
    # Four times what is lacking; then the straight line between both.
    assert tried == pytest.approx([0.0, 0.024, 0.006])


def test_without_a_solution_at_the_corrected_height_the_goal_takes_the_rest() -> None:
    search, tried = climbing(1.0, 0.006, most=0.01)
    assert tried == [0.0, 0.0]
    assert search.best is not None


def test_a_height_that_costs_nothing_is_not_looked_for() -> None:
    _, tried = climbing(0.6, 0.0002)
    assert tried == [0.0]


def test_another_day_that_repeats_itself_is_no_error() -> None:
    _, tried = climbing(0.6, 0.1)
    assert tried == [0.0]


def test_heights_that_do_not_settle_leave_rounds_for_the_goal() -> None:
    tried: list[dict[int, float]] = []

    def simulator(searches: Sequence[Search]) -> list[Simulated]:
        (search,) = searches
        tried.append(dict(search.current.instance.height_errors))
        goal_h = search.current.instance.goal_h
        # Climbs end 0.02 too low whatever error the program takes.
        return [Simulated(goal_h - 0.5, 0, 0.0, True, climbed=ended_low(0.005, 0.6))]

    instance = ProblemInstance.of(Objective.min_wingspan, 2.0)
    search = Search(
        instance, 2.0, [0], lambda one: cast(Any, Found(one.instance, True, 0.6)), count=1
    )
    run([search], simulator)
    assert len(tried) == 8  # six corrections, then the goal
    assert search.best is not None
