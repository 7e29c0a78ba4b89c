import numpy as np
import pytest

from sizing.library import load_aircraft
from solar.attitude_models import full_model, verification_model
from solar.clearsky import Irradiance
from solar.geometry import ModuleGeometry, ModuleSurface, direction_cosines
from solar.horizontal_models import conceptual_analysis_model
from solar.modules import IncidenceTable, LowLightTable, MpptTable, SolarCell
from solar.shading import Shading, proportional_losses
from solar.sun import sun_vector_ned

FLAT = ModuleGeometry(surfaces=(ModuleSurface(name="flat", area_m2=1.0, side="centre"),))
V_WING = ModuleGeometry(
    surfaces=tuple(
        ModuleSurface(name=side, area_m2=0.5, side=side, dihedral_deg=20.0)
        for side in ("left", "right")
    )
)
LEVEL = direction_cosines(0.0, 0.0, 0.0)
UP = np.array([0.0, 0.0, -1.0])
NOON = Irradiance(np.asarray(900.0), np.asarray(100.0))
# A cell without low-light loss and with a constant tracker: what CAM assumes.
CONSTANT = SolarCell(
    low_light=LowLightTable(irradiance_w_per_m2=(0.0, 1000.0), relative_efficiency=(1.0, 1.0)),
    mppt=MpptTable(relative_load=(0.0, 1.0), mppt_efficiency=(0.95, 0.95)),
    temperature_rise_k=0.0,
)


def test_models_without_their_effects_on_a_level_wing_are_the_analysis_model():
    sun = sun_vector_ned(47.6, 0.4, 0.7)
    full = full_model(NOON, sun, LEVEL, FLAT, CONSTANT, 20.0).specific_power_w_per_m2
    vm = verification_model(NOON, sun, LEVEL, FLAT, SolarCell(), 20.0)
    for power, cell in ((full, CONSTANT), (vm, SolarCell())):
        simple = conceptual_analysis_model(NOON, -sun[2], cell, 20.0)
        assert power == pytest.approx(simple, rel=1e-12)  # same arithmetic


def test_power_temperature_and_tracker_agree():
    cell = SolarCell()
    result = full_model(NOON, UP, LEVEL, FLAT, cell, 30.0)
    p = float(result.specific_power_w_per_m2)
    # Eq. 10: the temperature that belongs to the power found.
    temperature = 30.0 + 12.0 * p / cell.full_load_w_per_m2
    assert float(result.module_temperature_c) == pytest.approx(temperature, abs=1e-9)
    light = 900.0 * 0.97 + 100.0 * 0.83
    before = 0.237 * light * (1.0 - 0.003 * (temperature - 25.0))
    eta = float(cell.mppt_efficiency_at(before / cell.full_load_w_per_m2))
    assert p == pytest.approx(before * eta, rel=1e-10)  # the solver's own tolerance is 1e-12
    assert float(result.mppt_efficiency) == pytest.approx(eta, rel=1e-9)


def test_sun_in_the_wing_plane_or_behind_it_leaves_diffuse_light():
    upside_down = direction_cosines(np.pi, 0.0, 0.0)
    for sun, attitude in ((np.array([1.0, 0.0, 0.0]), LEVEL), (UP, upside_down)):
        result = full_model(NOON, sun, attitude, FLAT, CONSTANT, 25.0)
        assert float(result.specific_power_w_per_m2) == pytest.approx(100.0 * 0.83 * 0.237 * 0.95)
        assert result.incidence_efficiency_by_surface == 0.0


def test_user_table_that_ends_early_knows_no_light_from_behind():
    cell = SolarCell(incidence=IncidenceTable(aoi_deg=(0.0, 60.0), relative_efficiency=(1.0, 0.9)))
    assert cell.incidence_efficiency([-0.5, 0.0, 0.2]) == pytest.approx([0.0, 0.0, 0.9])


def test_dihedral_averages_two_sides():
    sun = np.array([0.0, np.sin(0.6), -np.cos(0.6)])
    result = full_model(NOON, sun, LEVEL, V_WING, CONSTANT, 25.0)
    cosines = np.cos(0.6 + np.radians([-20.0, 20.0]))
    expected = conceptual_analysis_model(NOON, cosines, CONSTANT, 25.0).mean()
    assert float(result.specific_power_w_per_m2) == pytest.approx(expected, rel=1e-12)


def test_arrays_equal_single_calls():
    rolls = np.array([-0.3, 0.0, 0.4])
    sun = sun_vector_ned(47.6, 0.4, np.array([-1.0, 0.2]))[:, np.newaxis, :]
    light = Irradiance(np.array([[500.0], [800.0]]), np.array([[80.0], [120.0]]))
    whole = full_model(light, sun, direction_cosines(rolls, 0.1, 1.0), V_WING, SolarCell(), 20.0)
    assert whole.specific_power_w_per_m2.shape == (2, 3)
    for i, j in np.ndindex(2, 3):
        there = Irradiance(light.dni[i, 0], light.dhi[i, 0]), sun[i, 0]
        turned = direction_cosines(rolls[j], 0.1, 1.0)
        single = full_model(*there, turned, V_WING, SolarCell(), 20.0).specific_power_w_per_m2
        # The iteration stops for the whole batch at once: 1e-12 of the rated power.
        assert whole.specific_power_w_per_m2[i, j] == pytest.approx(float(single), rel=1e-9)


def test_shading_by_the_tail_takes_direct_light_alone():
    modules = load_aircraft("atlantiksolar-as2").modules
    # The sun behind the T-tail at 14 degrees: the horizontal tail shades the central modules.
    sun = np.array([-np.cos(0.24), 0.0, -np.sin(0.24)])
    plain, none, lost = (
        full_model(NOON, sun, LEVEL, modules.geometry, modules, 20.0, shading=shading)
        for shading in (None, Shading(modules.tail), Shading(modules.tail, proportional_losses))
    )
    assert none.specific_power_w_per_m2 == plain.specific_power_w_per_m2
    assert lost.specific_power_w_per_m2 < plain.specific_power_w_per_m2
    assert np.all(lost.irradiance_by_surface_w_per_m2 >= 100.0)  # the diffuse light stays


def test_light_from_below_reaches_what_faces_down():
    """Above clouds of albedo 0.6 a level lower face gets 0.6 of the light on a level plain."""
    light, sun = Irradiance(np.array(1200.0), np.array(5.0)), np.array([0.0, 0.0, -1.0])
    cell, level = SolarCell(), np.eye(3)

    def of(facing, albedo):
        surface = ModuleSurface(name="one", area_m2=1.0, side="centre", facing=facing)
        return full_model(
            *(light, sun, level, ModuleGeometry(surfaces=(surface,)), cell, -50.0), albedo=albedo
        )

    assert of("down", 0.0).irradiance_w_per_m2 == 0.0
    assert of("down", 0.6).irradiance_w_per_m2 == pytest.approx(0.6 * 1205.0)
    # What lies level and faces up sees no earth.
    assert of("up", 0.6).irradiance_w_per_m2 == of("up", 0.0).irradiance_w_per_m2 == 1205.0


def test_a_tilted_wing_sees_the_earth_as_far_as_it_is_tilted():
    light, sun = Irradiance(np.array(0.0), np.array(100.0)), np.array([0.0, 0.0, -1.0])
    surface = ModuleSurface(name="one", area_m2=1.0, side="centre", pitch_deg=60.0)
    geometry, cell = ModuleGeometry(surfaces=(surface,)), SolarCell()
    plain, bright = (
        full_model(light, sun, np.eye(3), geometry, cell, 20.0, albedo=a).irradiance_w_per_m2
        for a in (0.0, 0.5)
    )
    # Half of 100 W/m2, by (1 - cos 60 deg) / 2.
    assert bright - plain == pytest.approx(0.5 * 100.0 * 0.25)
    flat = [
        verification_model(light, sun, np.eye(3), geometry, cell, 25.0, albedo=a) for a in (0, 0.5)
    ]
    assert flat[1] / flat[0] == pytest.approx(1.0 + 0.5 * 0.25)
