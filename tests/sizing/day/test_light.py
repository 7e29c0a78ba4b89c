"""Sunlight on an aircraft: time axis, models evaluated once, correction on a loiter, margins."""

import numpy as np
import pytest

from missions.library import load_mission
from missions.mission.mission import UncertaintyMargins
from sizing.day.light import (
    DEFAULT_STEP_H,
    SolarModel,
    Sunlight,
    day_axis_h,
    power_at_instants,
    solar_day,
)
from sizing.day.module_power import clear_daylight
from sizing.library import load_aircraft
from solar.names import CORRECTION_NAMES, MODEL_NAMES, MODELS

AS2 = load_aircraft("atlantiksolar-as2")
RAFZ = load_mission("rafz-july")
LOITER = load_mission("rafz-loiter")
SUMMER = load_mission("central-europe-summer").scenarios()


def test_axis_spans_the_day_in_steps_no_longer_than_asked():
    for step in (1.0, 0.7, DEFAULT_STEP_H, 1.0 / 60.0, 1.0 / 3600.0):
        time = day_axis_h(step)
        assert (time[0], time[-1]) == (0.0, 24.0)
        # Rounding of differences of times up to 24 h.
        assert np.diff(time).max() <= step * (1.0 + 1e-6) + 1e-12
    assert len(day_axis_h()) == 289
    for step in (0.0, -1.0, 1.0 / 3601.0, 1.01):
        with pytest.raises(ValueError, match="step_h must be from"):
            day_axis_h(step)


@pytest.mark.parametrize("model", MODEL_NAMES)
def test_correction_on_the_loiter_gives_the_daily_energy_of_the_corrected_full_model(model):
    sun = Sunlight(AS2, LOITER, SUMMER)
    ours = sun.day(SolarModel(model, "loiter"))
    full = sun.day(SolarModel("FM", "none"))
    energy, expected = (
        np.trapezoid(day.specific_power_w_per_m2, day.time_h, axis=-1) for day in (ours, full)
    )
    # The Full Model's own error in flight is what the correction takes off besides; rounding.
    np.testing.assert_allclose(energy, expected / (1.0 + MODELS["FM"].average), rtol=1e-12)


def test_margin_takes_errors_of_the_model_off_its_power():
    wary = RAFZ.model_copy(
        update={"uncertainty_margins": UncertaintyMargins(solar_model_sigmas=1.5)}
    )
    model = SolarModel("CAM", "report")
    plain, less = (solar_day(AS2, m, model).specific_power_w_per_m2 for m in (RAFZ, wary))
    np.testing.assert_allclose(less, (1.0 - 1.5 * model.rms_relative) * plain, rtol=1e-12)


@pytest.mark.parametrize("correction", CORRECTION_NAMES)
def test_a_day_on_the_calendar_is_the_day_of_the_cycle(correction):
    solar = SolarModel("CAM", correction)
    day = solar_day(AS2, LOITER, solar)
    noon = np.full(len(day.time_h), day.scenarios.noon_day[0])
    light = clear_daylight(LOITER, LOITER.latitudes()[0], noon, day.time_h)
    found = power_at_instants(AS2, LOITER, solar, light)
    np.testing.assert_allclose(found, day.specific_power_w_per_m2[0], rtol=1e-12)
