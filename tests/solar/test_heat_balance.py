"""Temperature of modules in flight: energy is kept, limits are met, and measured numbers."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pvlib.temperature import faiman_rad

from missions.air import plate_convection_w_per_m2k, standard_air
from solar.heat_balance import (
    STEFAN_BOLTZMANN,
    ZERO_CELSIUS_K,
    Surroundings,
    balanced_temperature_c,
    long_wave_w_per_m2,
)
from solar.modules import ModuleHeat, SolarCell

CELL = SolarCell()


@given(
    light=st.floats(0.0, 1400.0),
    efficiency=st.floats(0.05, 0.35),
    ambient_c=st.floats(-80.0, 40.0),
    convection=st.floats(3.0, 200.0),
    pressure=st.floats(0.01, 1.0),
    underside=st.floats(0.0, 1.0),
    emissivity=st.floats(0.5, 1.0),
)
def test_what_comes_in_goes_out(
    light, efficiency, ambient_c, convection, pressure, underside, emissivity
):
    heat = ModuleHeat(underside_share=underside, emissivity=emissivity)
    cell = CELL.model_copy(update={"thermal": heat})
    around = Surroundings(ambient_c, convection, pressure)
    temperature_c = float(balanced_temperature_c(light, light, efficiency * light, cell, around))
    kelvin = temperature_c + ZERO_CELSIUS_K
    electric = efficiency * light * (1.0 - 0.003 * (temperature_c - 25.0))
    down, up = long_wave_w_per_m2(pressure)
    reflected = underside * heat.underside_absorptance * around.albedo * light
    brought = heat.absorptance * light - electric + reflected
    radiated = emissivity * (
        (1.0 + underside) * STEFAN_BOLTZMANN * kelvin**4 - down - underside * up
    )
    lost = radiated + (1.0 + underside) * convection * (temperature_c - ambient_c)
    # Two of Newton's steps: 0.006 K in the least flow with an insulated lower face.
    assert lost == pytest.approx(brought, abs=0.1)


def test_in_a_strong_wind_modules_are_as_cold_as_the_air():
    around = Surroundings(-56.5, 1e6, 0.05)
    temperature_c = balanced_temperature_c(1200.0, 1200.0, 280.0, CELL, around)
    assert temperature_c == pytest.approx(-56.5, abs=1e-3)


def test_without_air_and_light_the_plate_is_that_of_the_long_waves():
    temperature_c = balanced_temperature_c(0.0, 0.0, 0.0, CELL, Surroundings(-56.5, 1e-9, 0.0))
    # Both faces radiate what comes up from the earth: 239 W/m2. Two of Newton's steps, begun at a
    # module in common light, which is 80 K warmer.
    expected = (239.0 / (2.0 * STEFAN_BOLTZMANN)) ** 0.25 - ZERO_CELSIUS_K
    assert temperature_c == pytest.approx(expected, abs=0.2)


def test_what_was_measured_near_the_ground_lies_between_a_bare_and_an_insulated_wing():
    """12 K at 265 W of 1.35 m2 (the report on solar power models), at some 9.5 m/s and 0.305 m."""
    air = standard_air(536.0, 15.0)
    convection = float(plate_convection_w_per_m2k(air, 9.5, 0.305))
    light = 265.0 / 1.35 / (0.237 * 0.95)
    around = Surroundings(float(air.temperature_c), convection, 0.94)
    bare, insulated = (
        float(
            balanced_temperature_c(
                *(light, 0.91 * light, 0.237 * light),
                CELL.model_copy(update={"thermal": ModuleHeat(underside_share=share)}),
                around,
            )
        )
        - float(air.temperature_c)
        for share in (1.0, 0.0)
    )
    assert bare < 12.0 < insulated
    assert insulated < 24.0


@pytest.mark.parametrize("wind_m_per_s", [5.0, 8.0, 12.0, 15.0])
def test_a_bare_wing_is_as_warm_as_modules_in_the_wind(wind_m_per_s):
    """Faiman's model with its fitted numbers and the sky's radiation, by pvlib."""
    air = standard_air(0.0, 5.0)
    convection = float(plate_convection_w_per_m2k(air, wind_m_per_s, 0.3))
    around = Surroundings(20.0, convection, 1.0)
    ours = float(balanced_temperature_c(1000.0, 1000.0, 200.0, CELL, around))
    down, _ = long_wave_w_per_m2(1.0)
    theirs = faiman_rad(1000.0, 20.0, wind_m_per_s, ir_down=float(down))
    # Modules on racks, whose wind turns, are 9.7 to 15.6 K warmer than the air at these speeds.
    assert ours == pytest.approx(float(theirs), abs=3.0)
