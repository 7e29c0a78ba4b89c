"""Variables and rows of the program: what they stand for."""

import math

import pytest
from builders import DESIGN

from sizing.program.variables import WIND, Role, chosen_variables, eased_row, scales_of


@pytest.mark.parametrize("factor", [0.5, 1.0, 3.0])
def test_a_limit_that_is_eased_is_the_row_of_the_limit_times_the_factor(factor):
    quantity, limit = 7.0, 4.0
    eased = factor * limit
    assert eased_row(quantity / limit - 1.0, "minimum", factor) == pytest.approx(
        quantity / eased - 1.0
    )
    assert eased_row(1.0 - quantity / limit, "maximum", factor) == pytest.approx(
        1.0 - quantity / eased
    )


def test_values_return_from_the_program_and_bounds_without_end_are_kept():
    variables = chosen_variables(DESIGN, eased=True)
    values = {variable.name: 0.7 for variable in variables}
    scales = scales_of(variables, values)
    for variable, scale in zip(variables, scales.tolist(), strict=True):
        assert scale == max(0.7, variable.least)
        there = variable.to_program(0.7, scale)
        assert float(variable.from_program(there, scale)) == pytest.approx(0.7, rel=1e-12)
        assert variable.to_program(2.0 * scale, scale) > variable.to_program(scale, scale)
        assert variable.to_program(math.inf, scale) == math.inf
        nothing = variable.to_program(0.0, scale)
        assert nothing == (0.0 if variable.linear else -math.inf)
    roles = {variable.name: variable.role for variable in variables}
    assert roles[WIND] is Role.wind
    assert roles["battery_mass_kg"] is Role.design
