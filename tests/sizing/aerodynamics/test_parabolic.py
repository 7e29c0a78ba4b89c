"""Level flight and its power with a parabolic polar: definitions, limits and directions."""

import numpy as np
import pytest
from builders import aircraft, mission
from hypothesis import given
from hypothesis import strategies as st

from sizing.aerodynamics.parabolic import DragPolar, level_airspeed_m_per_s
from sizing.design import FlightConditions, variables_of
from sizing.mass_budget import level_flight

G = 9.80665
POLAR = DragPolar(
    lift_coefficient=1.0,
    maximum_lift_coefficient=1.4,
    profile_drag_coefficient=0.012,
    reference_reynolds=158000.0,
)


@given(loading=st.floats(0.5, 30.0), density=st.floats(0.05, 1.4), lift=st.floats(0.2, 2.0))
def test_lift_equals_weight(loading, density, lift):
    v = level_airspeed_m_per_s(lift, loading, density)
    # Definition of the lift coefficient; rounding.
    assert 0.5 * density * v**2 * lift == pytest.approx(loading * G, rel=1e-12)


@given(reynolds=st.floats(2e4, 1e6), aspect=st.floats(6.0, 35.0))
def test_drag_is_that_of_the_formula(reynolds, aspect):
    cd = 0.012 * (158000.0 / reynolds) ** 0.35 + 0.006 + 1.0 / (np.pi * 0.9 * aspect)
    assert POLAR.drag_coefficient(aspect, reynolds) == pytest.approx(cd, rel=1e-12)


def test_constant_polar_scales_as_measured_power_does():
    # As the power of a measured aircraft is scaled (sizing.mass_budget.measured_design): without
    # Reynolds dependence the parabolic polar obeys m^1.5 rho^-0.5 exactly.
    plane = aircraft("atlantiksolar-design", "airframe.aerodynamics.reynolds_exponent=0")
    air, variables = FlightConditions.of(mission(), plane), variables_of(plane)
    _, here, _ = level_flight(plane, air, variables, 6.0)
    thinner = air._replace(density_kg_per_m3=0.8 * air.density_kg_per_m3)
    _, there, _ = level_flight(plane, thinner, variables, 9.0)
    assert there == pytest.approx(here * 1.5**1.5 * 0.8**-0.5, rel=1e-12)
