"""The best course of climbs and glides against rules, limits and other courses."""

from __future__ import annotations

import numpy as np
import pytest
from builders import AS2, DESIGN, mission

from missions.files.overrides import with_values
from missions.mission import Mission
from sizing.altitude import best_climb as module
from sizing.altitude.best_climb import best_climb
from sizing.altitude.climb_cycle import climb_performance
from sizing.altitude.climb_levels import flight_levels
from sizing.energy.battery import Store
from sizing.mass_budget import design_of
from sizing.sunlight import UNCORRECTED_CAM, solar_day

# Steps of 5 min and polynomials over the altitude: what is flown differs by so much [h].
NEAR_H = 0.03


def climbing(ceiling_m: float, **changes: object) -> Mission:
    return mission(climb={"ceiling_m": ceiling_m}, launch=None, **changes)


@pytest.mark.parametrize(("latitude", "ceiling_m"), [(47.6, 2000.0), (20.0, 4000.0)])
def test_no_rule_is_better(latitude: float, ceiling_m: float) -> None:
    best = best_climb(AS2, climbing(ceiling_m, latitude_deg=latitude))
    assert best.gain_h > -NEAR_H
    # The rules keep the battery first, which is nearly the best that there is.
    assert best.gain_h < 0.03 * best.excess_time_h
    assert best.altitude_m.max() <= ceiling_m + 1e-6
    assert best.state_of_charge.max() <= 1.0 + 1e-9


def test_a_ceiling_next_to_the_floor_gives_level_flight() -> None:
    where = mission()
    best = best_climb(DESIGN, climbing(where.altitude_m + 20.0))
    # 20 m of a 7 kg aircraft are 0.4 Wh, less than a minute of its load.
    assert best.excess_time_h == pytest.approx(best.level_h, abs=NEAR_H + 0.01)


def test_the_airspeed_of_least_power_is_the_best() -> None:
    power_w, excess_h = [], []
    # 1.0 is one of several from which IPOPT ended in its restoration phase, 1.4 h below the rule.
    for lift in (0.8, 1.0, 1.2):
        aircraft = with_values(DESIGN, {"airframe.aerodynamics.lift_coefficient": lift})
        best = best_climb(aircraft, climbing(4000.0))
        assert best.gain_h > -0.01  # the rule is flown as well
        power_w.append(float(design_of(aircraft, mission()).propulsion_power_w))
        excess_h.append(best.excess_time_h)
    assert np.argsort(power_w).tolist() == np.argsort(excess_h)[::-1].tolist()


def test_no_other_course_nearby_is_better() -> None:
    where = climbing(3000.0)
    day = solar_day(AS2, where, UNCORRECTED_CAM)
    design = design_of(AS2, where)
    levels = flight_levels(AS2, where, design, day)
    store = Store.of(AS2.battery, np.atleast_1d(np.asarray(design.battery_energy_wh, float)))
    task = module._Day(np.asarray(day.time_h), levels, store, AS2.battery)
    course = task.solved(module._rule_day(climb_performance(AS2, where).climb, 0))
    own = task.flown(course)
    rng = np.random.default_rng(4)
    for spread in (0.01, 0.05, 0.2):
        for _ in range(3):
            moved = course.copy()
            smooth = np.convolve(rng.standard_normal(len(moved)), np.ones(12) / 12.0, "same")
            moved[:-2] += spread * task.most_w * smooth[:-2]
            other = task.flown(moved)
            # Its day need not end as it began: the second of two is judged.
            assert other.battery_wh.min() <= own.battery_wh.min() + NEAR_H * task.nominal_w


def test_a_winter_night_is_too_long_for_any_course() -> None:
    best = best_climb(AS2, climbing(3000.0, dates={"on": "12-21"}))
    assert best.excess_time_h < 0.0
    assert max(best.by_rule_h.values()) < 0.0


def test_a_mission_without_climbs_is_refused() -> None:
    with pytest.raises(ValueError, match="has no climb"):
        best_climb(AS2, mission())


def test_a_ceiling_at_the_floor_is_level_flight() -> None:
    best = best_climb(DESIGN, climbing(mission().altitude_m))
    assert best.excess_time_h == pytest.approx(best.level_h, abs=NEAR_H)
    assert set(best.altitude_m) == {mission().altitude_m}


def test_a_polar_day_is_unlimited_by_every_course() -> None:
    best = best_climb(AS2, climbing(2000.0, latitude_deg=85.0, dates={"on": "06-21"}))
    assert best.excess_time_h == np.inf
    assert best.gain_h == 0.0
