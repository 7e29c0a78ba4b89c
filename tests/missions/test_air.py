"""Standard atmosphere against an independent implementation and invariants."""

import ambiance
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from missions.air import (
    GAS_CONSTANT_AIR,
    MAXIMUM_ALTITUDE_M,
    MINIMUM_ALTITUDE_M,
    air_at,
    plate_convection_w_per_m2k,
    pressure_altitude_m,
    standard_air,
    thin_air_share,
)

ALTITUDES_M = np.linspace(MINIMUM_ALTITUDE_M, MAXIMUM_ALTITUDE_M, 326)

altitudes = st.floats(MINIMUM_ALTITUDE_M, MAXIMUM_ALTITUDE_M)
offsets = st.floats(-60.0, 60.0)


@pytest.mark.parametrize(
    ("field", "reference"),
    [
        ("temperature_k", "temperature"),
        ("pressure_pa", "pressure"),
        ("density_kg_per_m3", "density"),
        ("dynamic_viscosity_pa_s", "dynamic_viscosity"),
    ],
)
def test_standard_air_agrees_with_an_independent_implementation(field, reference):
    expected = getattr(ambiance.Atmosphere(ALTITUDES_M), reference)
    # The reference starts each layer from a pressure printed with six digits.
    assert getattr(standard_air(ALTITUDES_M), field) == pytest.approx(expected, rel=1e-5)


@given(altitudes, offsets)
def test_air_is_an_ideal_gas_and_a_hot_day_keeps_its_pressure(altitude, offset):
    standard, air = standard_air(altitude), standard_air(altitude, offset)
    assert all(np.isfinite(value) and value > 0.0 for value in air)
    assert air.pressure_pa == standard.pressure_pa
    assert air.temperature_k == pytest.approx(float(standard.temperature_k) + offset)
    expected = float(air.density_kg_per_m3 * GAS_CONSTANT_AIR * air.temperature_k)
    assert air.pressure_pa == pytest.approx(expected)


def test_air_of_given_temperature_and_pressure():
    air = air_at(273.15, 100000.0)
    # Standard temperature and pressure of IUPAC: 1.2754 kg/m3 of dry air; viscosity of air at 0 C
    # 1.716e-5 Pa s (White, Viscous Fluid Flow), Sutherland's constants to 0.2 %.
    assert air.density_kg_per_m3 == pytest.approx(1.2754, abs=5e-5)
    assert air.dynamic_viscosity_pa_s == pytest.approx(1.716e-5, rel=2e-3)
    assert air.temperature_c == 0.0


@pytest.mark.parametrize("altitude", [-501.0, 32001.0, float("nan"), float("inf"), [0.0, 40000.0]])
def test_altitudes_outside_the_model_are_refused(altitude):
    with pytest.raises(ValueError, match="altitude_m must be from -500 to 32000"):
        standard_air(altitude)


def test_convection_of_a_plate_is_that_of_a_textbook():
    """Incropera et al., 6th edition, example 7.1: air at 6 kN/m2 and 10 m/s over a plate of 0.5 m.

    At the film's temperature of 437 K the Reynolds number is 9597 and the Nusselt number 57.4, so
    that h = 4.18 W/(m2 K).
    """
    air = air_at(437.0, 6000.0)
    reynolds = air.density_kg_per_m3 * 10.0 * 0.5 / air.dynamic_viscosity_pa_s
    # Its table of air and the standard atmosphere differ by 2 % in viscosity.
    assert reynolds == pytest.approx(9597.0, rel=0.03)
    assert plate_convection_w_per_m2k(air, 10.0, 0.5) == pytest.approx(4.18, rel=0.02)


def test_convection_turns_turbulent_without_a_leap():
    air = standard_air(0.0)
    speed = 5e5 * air.dynamic_viscosity_pa_s / air.density_kg_per_m3
    below, above = (plate_convection_w_per_m2k(air, f * speed, 1.0) for f in (1 - 1e-9, 1 + 1e-9))
    assert above == pytest.approx(below, rel=1e-6)
    # Incropera, equation 7.38 with its A of 871: mixed flow.
    ten = float(plate_convection_w_per_m2k(air, 10.0 * speed, 1.0))
    prandtl, conductivity = 0.71, 0.0253
    expected = (0.037 * 5e6**0.8 - 871.0) * prandtl ** (1.0 / 3.0) * conductivity
    assert ten == pytest.approx(expected, rel=0.02)


def test_balances_of_thin_air_count_from_3_to_4_km():
    assert thin_air_share([0.0, 3000.0]).tolist() == [0.0, 0.0]
    assert thin_air_share([4000.0, 20000.0]).tolist() == [1.0, 1.0]
    heights = np.linspace(2900.0, 4100.0, 121)
    share = thin_air_share(heights)
    assert np.all(np.diff(share) >= 0.0)
    # Without a kink: no step of the slope beyond that of the cubic, 6 per 100 steps squared.
    assert np.max(np.abs(np.diff(share, 2))) <= 6.01e-4


def test_a_pressure_leads_back_to_its_altitude():
    altitude_m = np.linspace(-450.0, 31900.0, 401)
    found_m = pressure_altitude_m(standard_air(altitude_m).pressure_pa)
    assert np.max(np.abs(found_m - altitude_m)) < 0.1
    assert np.all(np.isinf(pressure_altitude_m([120000.0, 100.0])))
    # U.S. Standard Atmosphere 1976, table I: 226.32 hPa at 11 019 m, 11 000 m of geopotential.
    assert pressure_altitude_m(22632.1) == pytest.approx(11019.1, abs=0.5)
