"""Heights of a day: what other aircraft make of those that were chosen for one."""

from dataclasses import replace

import numpy as np
import pytest
from builders import AS2, mission

from sizing.day.battery import Store
from sizing.day.heights import flight_levels
from sizing.day.light import solar_day
from sizing.mass_budget import design_of
from sizing.program.schedule import flown_along


def test_heights_of_another_aircraft_are_reached_as_far_as_power_and_ceiling_allow():
    where = mission(climb={"ceiling_m": 3536.0}, dates={"on": "06-21"})
    day = solar_day(AS2, where)
    levels = flight_levels(AS2, where, design_of(AS2, where), day).select(np.zeros(4, int))
    level_w = float(levels.nominal_load_w[0] - levels.constant_power_w[0])
    climb_w = float(levels.weight_n[0] / levels.efficiency[0]) * 2800.0 / (3.0 * 3600.0)
    # Power for all of the climb, for a lower ceiling, for half of it, and not for level flight.
    rated_w = level_w + climb_w * np.array([9.0, 9.0, 0.5, -0.1])
    reach_m = np.array([3000.0, 1500.0, 3000.0, 3000.0])
    levels = replace(levels, maximum_power_w=rated_w, reach_m=reach_m)
    store = Store.of(AS2.battery, np.full(4, 700.0))
    chosen_m = np.interp(day.time_h, [9.0, 12.0, 18.0], [0.0, 2800.0, 0.0])
    flights = flown_along(day.time_h, levels, store, np.tile(chosen_m, (4, 1)), of_others=True)
    heights_m = flights.height_m
    np.testing.assert_array_equal(heights_m[0], chosen_m)
    np.testing.assert_array_equal(heights_m[1], np.minimum(chosen_m, 1500.0))
    np.testing.assert_array_equal(heights_m[3], 0.0)
    most_w = rated_w[2] + levels.constant_power_w[2]
    # Level flight takes less power at the lower heights than the share of the climb has it.
    assert 0.9 * most_w < flights.load_w[2].max() <= most_w
    assert heights_m[2] == pytest.approx(heights_m[2].max() / 2800.0 * chosen_m, abs=1e-9)
    _, alone_w = levels.powers_along(day.time_h, heights_m)
    np.testing.assert_array_equal(flights.load_w, alone_w)
