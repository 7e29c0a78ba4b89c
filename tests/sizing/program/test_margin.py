"""Least margins: with a judge of whom all is known."""

import math

import pytest
from builders import DESIGN

from sizing.program.margin import Trial, best_of, least_margin
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult, SizingStatus, SolverReport

TOLERANCE = 1e-3


def design(span_m):
    return SizingResult(
        status=SizingStatus.optimal,
        objective=Objective.min_wingspan,
        required_excess_time_h=0.0,
        solver=SolverReport(),
        design=DESIGN,
        objective_value=span_m,
    )


def tried(surplus, most=12.0, shortfall=1.0, largest=math.inf):
    """Trials of designs that have the margin as their span and reach it, up to ``largest``."""

    def tried_with(margin):
        return Trial(design(margin), margin) if margin <= largest else None

    return least_margin(tried_with, surplus, (0.0, most), TOLERANCE, shortfall)


@pytest.mark.parametrize("least", [0.01, 0.3, 0.5, 1.7, 6.0, 11.9])
@pytest.mark.parametrize("curved", [1.0, 3.0])
def test_the_least_sufficient_margin_is_reached(least, curved):
    verdicts = tried(lambda reached: 1.0 if reached >= least else -1.0)
    assert 0.0 <= best_of(verdicts, least).reached - least <= TOLERANCE
    assert len(verdicts) <= 20  # by halves: 14 from 12 to a thousandth, and both ends
    amounts = tried(
        lambda reached: (reached**curved - least**curved) / least ** (curved - 1.0), 12.0, least
    )
    assert 0.0 <= best_of(amounts, least).reached - least <= TOLERANCE
    if curved == 1.0:  # a secant leads there at once
        assert len(amounts) <= 4


def test_a_margin_out_of_reach_gives_the_design_that_reaches_most():
    never = tried(lambda reached: reached - 20.0, shortfall=20.0)
    assert best_of(never, 20.0).reached == 12.0
    # Where no design has so large a margin, the largest that one has.
    without = tried(lambda reached: reached - 20.0, shortfall=20.0, largest=2.0)
    assert 2.0 - TOLERANCE <= best_of(without, 20.0).reached <= 2.0
    assert tried(lambda reached: reached, largest=-1.0) == []
