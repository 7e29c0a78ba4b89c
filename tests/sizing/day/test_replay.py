"""Flights on the calendar: an independent march."""

import builders
import numpy as np
import pytest
from builders import AS2, UNLIMITED_AS2

from sizing.day.replay import calendar_run
from solar.horizontal_models import horizontal_specific_power
from solar.sun import equation_of_time_h


def mission(launch, **changes):
    return builders.mission(longitude_deg=8.53, launch=launch, **changes)


def launch(**changes):
    return {
        "date": "07-14",
        "time_local": "09:30",
        "utc_offset_h": 2.0,
        "state_of_charge": 0.5,
        "duration_h": 60.0,
        **changes,
    }


def test_run_equals_an_euler_march_with_its_own_sun():
    flown = mission(launch(), air={"module_temperature_c": 20.0})
    found = calendar_run(UNLIMITED_AS2, flown)
    # Clock to sun by hand: 2 h to UTC, 4 min per degree of longitude, equation of time.
    step = 1.0 / 240.0
    clock = 9.5 + (np.arange(round(60.0 / step)) + 0.5) * step
    day = 195.0 + (clock - 2.0) / 24.0
    sun_h = clock - 2.0 + 8.53 / 15.0 + equation_of_time_h(day)
    power = 1.35 * horizontal_specific_power(
        47.6,
        day,
        sun_h,
        cell=AS2.modules,
        module_temperature_c=flown.module_temperature_c(),
        altitude_m=536.0,
    )
    density = float(flown.air_state().density_kg_per_m3)
    load_w = 35.8 * (density / 1.10) ** -0.5 + 6.0
    full = 2.918 * 251.0
    energy, trajectory = 0.5 * full, [0.5 * full]
    for net in (power - load_w).tolist():
        energy += step * (0.95 * net if net > 0.0 else net / 0.97)
        energy = min(max(energy, 0.0), full)
        trajectory.append(energy)
    nodes = np.append(clock - step / 2.0, clock[-1] + step / 2.0)
    euler = np.interp(found.clock_h, nodes, np.asarray(trajectory) / full)
    # Midpoint sums of 15 s and trapezoids of 60 s of the same curve; sunrise and full charge fall
    # between nodes: a minute at the largest net power, 300 W, is 0.7 % of the battery, and its
    # share of curvature a hundredth of that.
    np.testing.assert_allclose(found.state_of_charge, euler, atol=2e-4)
    assert found.empty_clock_h is None
    np.testing.assert_allclose(found.load_w, load_w, rtol=1e-9)


def test_time_axes_are_consistent():
    found = calendar_run(AS2, mission(launch()))
    assert found.clock_h[0] == 9.5
    # Rounding of the axis.
    assert found.clock_h[-1] == pytest.approx(69.5, abs=1e-9)
    assert np.diff(found.clock_h).max() <= 1.0 / 60.0 + 1e-9
    # 14 July is day 195; 09:30 CEST is 07:30 UTC.
    assert found.day_of_year[0] == pytest.approx(195.0 + 7.5 / 24.0, abs=1e-9)
    assert np.all((found.time_solar_h >= 0.0) & (found.time_solar_h < 24.0))
    # Solar noon at 8.53 E in mid July: 12:00 UTC - 34 min + 6 min = 13:32 CEST, to the minute.
    first_day = found.clock_h < 24.0
    noon = found.clock_h[first_day][np.argmax(found.solar_power_w[first_day])]
    assert noon == pytest.approx(13.0 + 32.0 / 60.0, abs=2.0 / 60.0)


def test_battery_that_runs_empty_ends_the_run():
    small = builders.aircraft("atlantiksolar-as2", "battery.mass_kg=0.8")
    run = calendar_run(small, mission(launch(time_local="20:00", state_of_charge=0.9)))
    energy = 0.9 * 0.8 * 251.0
    # After 20:00 CEST the sun gives a little for another hour; without it the flight lasts:
    alone = energy * 0.97 / float(run.load_w[0])
    assert 20.0 + alone < run.empty_clock_h < 20.0 + alone + 1.0
    assert run.energy_wh[-1] == 0.0
    assert run.clock_h[-1] >= run.empty_clock_h > run.clock_h[-2]
    axes = (run.load_w, run.energy_wh, run.time_solar_h, run.solar_power_w, run.day_of_year)
    assert {len(values) for values in axes} == {len(run.clock_h)}


def test_full_charge_is_noted_once_a_day():
    run = calendar_run(AS2, mission(launch(duration_h=81.0)))
    assert [int(h // 24.0) for h in run.full_charge_clock_h] == [0, 1, 2, 3]
    for instant in run.full_charge_clock_h:
        # The instant lies within a step of one minute: full at its end, not full at its start.
        minute_before, minute_after = (
            float(np.interp(instant + shift, run.clock_h, run.state_of_charge))
            for shift in (-1.0 / 60.0, 1.0 / 60.0)
        )
        assert minute_after == pytest.approx(1.0, abs=1e-9)
        assert minute_before < 1.0


def test_launch_at_the_turn_of_the_year():
    run = calendar_run(AS2, mission(launch(date="12-31", duration_h=12.0), latitude_deg=-30.0))
    again = calendar_run(AS2, mission(launch(date="12-30", duration_h=12.0), latitude_deg=-30.0))
    # The sun of two midsummer days differs by less than 0.3 % of a day's energy.
    assert run.solar_power_w.sum() == pytest.approx(again.solar_power_w.sum(), rel=3e-3)
    assert run.day_of_year[-1] > 365.0


def test_mission_without_launch_cannot_be_flown_on_the_calendar():
    with pytest.raises(ValueError, match="no launch date and time"):
        calendar_run(AS2, mission(None))
