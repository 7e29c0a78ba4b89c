"""One formula in three arithmetics: floats, arrays and symbols."""

import casadi as ca
import numpy as np


def assert_alike(formulas, *values):
    """Compare what the formulas give for floats with what they give for arrays and symbols."""
    x = ca.SX.sym("x", len(values))
    floats = formulas(*values)
    symbols = ca.Function("f", [x], [ca.vertcat(*formulas(*ca.vertsplit(x)))])
    arrays = formulas(*(np.full(2, value) for value in values))
    # Rounding of powers.
    np.testing.assert_allclose(np.asarray(symbols(list(values))).ravel(), floats, rtol=1e-12)
    np.testing.assert_allclose([array[1] for array in arrays], floats, rtol=1e-12)
