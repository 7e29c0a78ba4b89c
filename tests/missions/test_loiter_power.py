import numpy as np
import pytest

from missions.flight_path import Circle, Level, StraightLegs, Wind
from missions.loiter_power import Daylight, PathModules, mean_power_on_path, module_power_on_path
from solar.geometry import ModuleGeometry, ModuleSurface
from solar.horizontal_models import horizontal_specific_power
from solar.modules import SolarCell

TIME_H = np.linspace(0.0, 24.0, 97)
DAY = Daylight(47.6, 182.5, TIME_H)
FLAT = ModuleGeometry(surfaces=(ModuleSurface(name="flat", area_m2=1.0, side="centre"),))
AFT = ModuleGeometry(surfaces=(ModuleSurface(name="aft", area_m2=1, side="centre", pitch_deg=10),))
CIRCLE = Circle(radius_m=100.0, airspeed_m_per_s=8.6)
CALM = Wind(speed_m_per_s=0.0, from_deg=0.0)


def mean(model, geometry, path, wind, samples=36):
    return mean_power_on_path(
        model,
        PathModules(geometry, SolarCell(), path, wind, samples=samples),
        DAY,
        ambient_temperature_c=20.0,
        module_temperature_c=20.0,
    )


def test_level_path_with_a_flat_wing_is_the_analysis_model():
    cam = horizontal_specific_power(
        47.6, 182.5, TIME_H, cell=SolarCell(), module_temperature_c=20.0, model="CAM"
    )
    assert mean("VM", FLAT, Level(), CALM) == pytest.approx(cam, rel=1e-12, abs=1e-9)
    with pytest.raises(ValueError, match="choose VM or FM"):
        mean("CAM", FLAT, CIRCLE, CALM)


def test_easterly_wind_takes_from_the_morning_what_it_gives_to_the_evening():
    # Modules face aft, the nose lingers into the wind: away from the morning sun.
    calm = mean("FM", AFT, CIRCLE, CALM)
    east, west = (
        mean("FM", AFT, CIRCLE, Wind(speed_m_per_s=3.0, from_deg=way)) for way in (90.0, 270.0)
    )
    morning = (TIME_H > 5.0) & (TIME_H < 10.0)
    evening = (TIME_H > 14.0) & (TIME_H < 19.0)
    assert np.all(east[morning] < calm[morning])
    assert np.all(east[evening] > calm[evening])
    assert east == pytest.approx(west[::-1], abs=2e-3)  # the samples do not mirror onto each other


@pytest.mark.parametrize("model", ["VM", "FM"])
def test_default_samples_have_converged(model):
    wind = Wind(speed_m_per_s=4.0, from_deg=60.0)
    coarse, fine = (mean(model, AFT, CIRCLE, wind, samples=n) for n in (36, 288))
    # The claim beside ORBIT_SAMPLES: 1e-4 of the day's energy.
    assert coarse.sum() == pytest.approx(fine.sum(), rel=1e-4)


def test_straight_legs_average_two_headings():
    path = StraightLegs(heading_deg=90.0, airspeed_m_per_s=10.0)
    both = mean("VM", AFT, path, CALM)
    # Without wind both legs take half the time: symmetric about noon, whatever the pitch.
    assert both == pytest.approx(both[::-1], rel=1e-9, abs=1e-9)


def test_components_multiply_to_the_power():
    daylight, orbit, power = module_power_on_path(
        PathModules(AFT, SolarCell(), CIRCLE, CALM), DAY, ambient_temperature_c=20.0
    )
    product = power.irradiance_w_per_m2 * power.module_efficiency * power.mppt_efficiency
    assert product == pytest.approx(power.specific_power_w_per_m2, rel=1e-12)
    assert power.specific_power_w_per_m2 @ orbit.weights == pytest.approx(
        mean("FM", AFT, CIRCLE, CALM)[daylight], rel=1e-12
    )
