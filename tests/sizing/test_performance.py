"""Performance of aircraft on missions: axes, scenarios, batches of designs, time step."""

import numpy as np
import pytest
from builders import AS2, DESIGN, aircraft, mission

from missions.dates import date_code
from missions.files.overrides import with_values
from missions.library import load_mission
from sizing.day.light import DEFAULT_STEP_H, SolarModel, day_axis_h, solar_day
from sizing.day.metrics import Status
from sizing.design import DesignVariables
from sizing.performance import performance, performance_of_designs, perpetual_days
from solar.clearsky import Irradiance, clear_sky
from solar.horizontal_models import horizontal_specific_power

SEASON = mission(
    latitude_deg={"from_deg": 0.0, "to_deg": 70.0, "count": 3},
    dates={"from": "01-15", "to": "07-15", "count": 4},
)


def test_scenarios_are_independent_of_each_other():
    season = performance(AS2, SEASON)
    scenarios = season.day.scenarios
    assert season.cycle.excess_time_h.shape == (12,)
    for i in range(len(scenarios)):
        day = int(scenarios.day_of_year[i])
        latitude = float(scenarios.latitude_deg[i])
        single = performance(AS2, mission(latitude_deg=latitude, dates={"on": date_code(day)}))
        # The same numbers in arrays of another length: rounding.
        expected = pytest.approx(single.cycle.excess_time_h[0], rel=1e-9, abs=1e-9)
        assert season.cycle.excess_time_h[i] == expected
    worst = season.worst_scenario()
    assert season.cycle.excess_time_h[worst] == season.cycle.excess_time_h.min()
    # In the polar night none of the hours has power: the northern one has less light.
    dark = mission(
        latitude_deg={"from_deg": 60.0, "to_deg": 66.0, "count": 2}, dates={"on": "12-21"}
    )
    north = performance(AS2, dark)
    assert north.cycle.excess_time_h.tolist() == [-24.0, -24.0]
    assert north.worst_scenario() == 1


def test_power_is_area_times_specific_power_and_correction_divides_it():
    time = day_axis_h()
    specific = horizontal_specific_power(
        47.6, 196.5, time, cell=AS2.modules, module_temperature_c=11.516, altitude_m=536.0
    )
    where = mission(air={"module_temperature_c": 11.516})
    exact = performance(AS2, where)
    np.testing.assert_allclose(exact.solar_power_w[0], 1.35 * specific, rtol=1e-12)
    corrected = performance(AS2, where, SolarModel("CAM", "report"))
    # CAM overestimates by 5.31 %, published.
    np.testing.assert_allclose(
        corrected.solar_power_w[0] * 1.0531, exact.solar_power_w[0], rtol=1e-12
    )
    assert corrected.cycle.excess_time_h < exact.cycle.excess_time_h
    assert SolarModel("CDM").rms_relative == 0.2003


def test_designs_in_a_batch_equal_single_designs():
    span = np.array([4.0, 5.65, 8.0])[:, np.newaxis]
    battery = np.array([0.5, 2.9, 9.0])
    batch = performance_of_designs(
        DESIGN, SEASON, DesignVariables(span, np.asarray(18.5), battery, np.asarray(0.7))
    )
    assert batch.cycle.excess_time_h.shape == (3, 3, 12)
    for i, j in np.ndindex(3, 3):
        single = performance_of_designs(
            DESIGN, SEASON, DesignVariables(float(span[i, 0]), 18.5, float(battery[j]), 0.7)
        )
        for name in ("excess_time_h", "minimum_state_of_charge", "charge_margin_h", "status"):
            # The masses are closed to 1e-13; the metrics follow in proportion.
            np.testing.assert_allclose(
                getattr(batch.cycle, name)[i, j], getattr(single.cycle, name), rtol=1e-8, atol=1e-8
            )


def test_endurance_of_the_dark_is_the_battery_and_of_perpetual_flight_has_no_end():
    polar = performance(AS2, mission(latitude_deg=80.0, dates={"on": "12-21"}))
    (endurance_h,) = polar.endurance_h
    load = float(polar.nominal_load_w.ravel()[0])
    # Energy over power; rounding of some hundred summed intervals.
    assert endurance_h == pytest.approx(2.918 * 251 * 0.97 / load, rel=1e-9)
    assert polar.cycle.status[0] == Status.never_lit
    assert np.isinf(performance(AS2, mission()).endurance_h).all()


def test_perpetual_days_are_those_whose_cycle_is_perpetual():
    some_days = np.arange(1, 366, 24)
    days_found = perpetual_days(AS2, mission(), 47.6, days=some_days).tolist()
    assert days_found == [
        day
        for day in some_days.tolist()
        if performance(AS2, mission(dates={"on": date_code(day)})).cycle.perpetual[0]
    ]
    assert 0 < len(days_found) < len(some_days)


STEPS = [
    (latitude, date, mass)
    for latitude, date in ((0.0, "03-21"), (47.6, "07-15"), (47.6, "03-10"), (65.0, "06-21"))
    for mass in (1.2, 2.918, 6.0)
]


@pytest.mark.parametrize(("latitude", "date", "battery_kg"), STEPS)
@pytest.mark.parametrize("name", ["atlantiksolar-as2", "atlantiksolar-design", "sky-sailor"])
def test_halving_the_time_step_moves_no_metric(name, latitude, date, battery_kg):
    plane = aircraft(name, f"battery.mass_kg={battery_kg}")
    place = mission(latitude_deg=latitude, dates={"on": date})
    coarse = performance(plane, place).cycle
    fine = performance(plane, place, step_h=DEFAULT_STEP_H / 2.0).cycle
    # Three digits; where hours are near zero 0.005 h (18 s, a sixteenth of the step), where a
    # state of charge is, 5e-4: there are no digits to keep.
    hours = ("excess_time_h", "charge_margin_h", "full_charge_h")
    hours += ("equal_power_morning_h", "equal_power_evening_h")
    for metric in (*hours, "minimum_state_of_charge"):
        near = {"rtol": 1e-3, "atol": 0.005 if metric in hours else 5e-4, "err_msg": metric}
        np.testing.assert_allclose(getattr(coarse, metric), getattr(fine, metric), **near)
    # Energies of the day relative to the sun's: the same three digits.
    for name in ("solar_wh", "curtailed_wh", "charge_loss_wh", "discharge_loss_wh", "unserved_wh"):
        difference = getattr(coarse.energy_budget, name) - getattr(fine.energy_budget, name)
        assert np.abs(difference) <= 1e-3 * fine.energy_budget.solar_wh, name


@pytest.mark.parametrize("model", ["CDM", "CAM", "VM", "FM"])
def test_sky_of_the_mission_lights_every_model(model, monkeypatch):
    def half(*where):
        return Irradiance(*(0.5 * part for part in clear_sky(*where)))

    monkeypatch.setattr("solar.clearsky.CLEAR_SKIES", {"ashrae": clear_sky, "half": half})
    plain = load_mission("rafz-loiter")
    plane = aircraft("atlantiksolar-as2")
    bright = solar_day(plane, plain, SolarModel(model))
    dim = solar_day(plane, with_values(plain, {"clear_sky": "half"}), SolarModel(model))
    cloudy = solar_day(plane, with_values(plain, {"clearness": 0.5}), SolarModel(model))
    # Half of the light by a mission's clearness or by the sky itself.
    np.testing.assert_allclose(
        dim.specific_power_w_per_m2, cloudy.specific_power_w_per_m2, rtol=1e-11, atol=1e-11
    )
    assert dim.specific_power_w_per_m2.max() < 0.6 * bright.specific_power_w_per_m2.max()
