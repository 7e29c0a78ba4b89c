"""Variables and rows of the program: what they stand for."""

import math

import pytest
from builders import DESIGN

from sizing.program.variables import chosen_variables, scales_of


def test_values_return_from_the_program_and_bounds_without_end_are_kept():
    variables = chosen_variables(DESIGN)
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
