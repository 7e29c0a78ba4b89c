"""The outcome of a sizing: sums of reports, and what is better."""

import math

import pytest

from sizing.program.objectives import Objective
from sizing.program.result import SizingResult, SizingStatus, SolverReport


def test_reports_of_a_row_of_searches_add_up():
    first, then = SolverReport(20, 1.5, 2, "first"), SolverReport(3, 0.25, 1, "then")
    assert first + then == SolverReport(23, 1.75, 3, "then")
    # A search that says nothing leaves what was said.
    assert then + SolverReport() == then


@pytest.mark.parametrize("objective", [it for it in Objective if it.of_design])
def test_the_better_value_has_more_merit(objective):
    def result(value):
        status = SizingStatus.optimal if value else SizingStatus.infeasible
        return SizingResult(
            status=status,
            objective=objective,
            required_excess_time_h=0.0,
            solver=SolverReport(),
            objective_value=value,
        )

    less, more = result(2.0).merit, result(3.0).merit
    assert (more > less) == objective.value.startswith("max")
    assert result(None).merit == -math.inf
