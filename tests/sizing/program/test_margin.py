"""Least margins: with a judge of whom all is known."""

import math

import pytest
from builders import DESIGN, mission

from sizing.day.light import UNCORRECTED_CAM
from sizing.program.margin import MarginSearch, Trial
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult, SizingStatus, SolverReport

TOLERANCE = 1e-3


class Known(MarginSearch):
    """Designs that have the margin as their span, up to ``largest``; of a known surplus."""

    def __init__(self, surplus, largest=math.inf):
        super().__init__(DESIGN, mission(), Objective.min_wingspan, UNCORRECTED_CAM)
        self.surplus, self.largest, self.count = surplus, largest, 0

    def sized(self, income, storage):
        self.count += 1
        span = {"design": DESIGN, "objective_value": income}
        report = SolverReport(iterations=1, solves=1)
        return SizingResult(
            status=SizingStatus.optimal,
            objective=self.objective,
            required_excess_time_h=0.0,
            solver=report,
            **(span if income <= self.largest else {}),
        )

    def judge(self, result):
        assert result.objective_value is not None
        return Trial(result, result.objective_value, self.surplus(result.objective_value))

    def found(self, ends, below=-math.inf):
        trial = self.least(lambda margin: (margin, 1.0), ends, 0.5, TOLERANCE, below)
        assert trial.result.solver.solves == trial.result.solver.iterations == self.count
        return trial


@pytest.mark.parametrize("least", [0.01, 0.3, 0.5, 1.7, 6.0, 11.9])
@pytest.mark.parametrize("curved", [1.0, 3.0])
def test_the_least_sufficient_margin_is_reached(least, curved):
    verdicts = Known(lambda margin: math.inf if margin >= least else -math.inf)
    assert 0.0 <= verdicts.found((0.0, 12.0)).reached - least <= TOLERANCE
    amounts = Known(lambda margin: (margin**curved - least**curved) / least ** (curved - 1.0))
    trial = amounts.found((0.0, 12.0), -least)
    assert trial.surplus >= 0.0
    assert 0.0 <= trial.reached - least <= TOLERANCE
    if curved == 1.0:  # steps that double, then a secant that leads there at once
        assert amounts.count <= 6


def test_a_margin_out_of_reach_gives_the_design_that_reaches_most():
    never = Known(lambda margin: margin - 20.0)
    assert never.found((0.0, 12.0), -20.0).reached == 12.0
    # Where no design has so large a margin, the largest that one has.
    without = Known(lambda margin: margin - 20.0, largest=2.0)
    trial = without.found((0.0, 12.0), -20.0)
    assert trial.surplus < 0.0
    assert 2.0 - TOLERANCE <= trial.reached <= 2.0
    none = Known(lambda margin: margin, largest=-1.0)
    assert none.least(lambda margin: (margin, 1.0), (0.0, 2.0), 0.5, TOLERANCE) is None
