"""Level flight and its power with a parabolic polar: definitions, limits and directions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from sizing.aerodynamics.parabolic import DragPolar, level_airspeed_m_per_s, level_flight_power_w

G = 9.80665
POLAR = DragPolar(
    lift_coefficient=1.0,
    maximum_lift_coefficient=1.4,
    profile_drag_coefficient=0.012,
    reference_reynolds=158000.0,
)
AIR = {"density_kg_per_m3": 1.1, "dynamic_viscosity": 1.8e-5}

spans = st.floats(1.0, 30.0)
aspects = st.floats(6.0, 35.0)
masses = st.floats(0.5, 300.0)


@given(span=spans, aspect=aspects, mass=masses, density=st.floats(0.05, 1.4))
def test_lift_equals_weight(span, aspect, mass, density):
    area = span**2 / aspect
    v = level_airspeed_m_per_s(POLAR, mass_kg=mass, wing_area_m2=area, density_kg_per_m3=density)
    # Definition of the lift coefficient; rounding.
    assert 0.5 * density * v**2 * area * 1.0 == pytest.approx(mass * G, rel=1e-12)


@given(span=spans, aspect=aspects, mass=masses)
def test_power_is_sink_rate_times_weight(span, aspect, mass):
    area = span**2 / aspect
    v = level_airspeed_m_per_s(POLAR, mass_kg=mass, wing_area_m2=area, density_kg_per_m3=1.1)
    reynolds = 1.1 * v * span / aspect / 1.8e-5
    cd = 0.012 * (158000.0 / reynolds) ** 0.35 + 0.006 + 1.0 / (np.pi * 0.9 * aspect)
    shape = {"airspeed_m_per_s": v, "wingspan_m": span, "aspect_ratio": aspect}
    power_w = level_flight_power_w(POLAR, **shape, **AIR)
    # P = m g v / (L/D): another way to the same number, so rounding.
    assert power_w == pytest.approx(mass * G * v * cd / 1.0, rel=1e-9)


def test_constant_polar_scales_as_measured_power_does():
    # As the power of a measured aircraft is scaled (sizing.mass_budget.measured_design): without
    # Reynolds dependence the parabolic polar obeys m^1.5 rho^-0.5 exactly.
    polar = POLAR.model_copy(update={"reynolds_exponent": 0.0})
    mass, air = np.array([6.0, 9.0]), AIR | {"density_kg_per_m3": np.array([1.1, 0.8])}
    v = level_airspeed_m_per_s(
        polar, mass_kg=mass, wing_area_m2=5.0 / 3.0, density_kg_per_m3=air["density_kg_per_m3"]
    )
    shape = {"airspeed_m_per_s": v, "wingspan_m": 5.0, "aspect_ratio": 15.0}
    here, there = level_flight_power_w(polar, **shape, **air)
    assert there == pytest.approx(here * 1.5**1.5 * (0.8 / 1.1) ** -0.5, rel=1e-12)


def test_lift_coefficient_at_stall_is_refused():
    with pytest.raises(ValidationError, match="must be above lift_coefficient"):
        DragPolar(
            lift_coefficient=1.4,
            maximum_lift_coefficient=1.4,
            profile_drag_coefficient=0.01,
            reference_reynolds=1e5,
        )
