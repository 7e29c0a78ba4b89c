"""Tests of climbs with the efficiency of the moment, against the exact chain point by point."""

from functools import cache

import numpy as np
import pytest
from builders import climb_performance

import sizing
from missions.air import GRAVITY_M_PER_S2
from missions.library import load_mission
from sizing.day.heights import flight_levels
from sizing.day.light import solar_day
from sizing.design import FlightConditions
from sizing.mass_budget import design_of, parametric_design

TWIN = sizing.load_aircraft("twin-boom-design")


def mission(ceiling_m, all_day=0.0, thermal=0.0, **climb):
    one = load_mission("rafz-july", {"air": {}, "climb": {"ceiling_m": ceiling_m, **climb}})
    turbulence = one.turbulence.model_copy(update={"all_day": all_day, "thermal": thermal})
    return one.model_copy(update={"turbulence": turbulence})


HIGH = mission(3536.0, 0.05, 0.2)


@pytest.fixture(scope="module")
def flown():
    return climb_performance(TWIN, HIGH)


BUS_V = TWIN.battery.bus_voltage_v(np.array(0.5))  # that days are flown by


def exact_w(altitude_m, thrust_w, bus_v):
    """Electric power by the public function; NaN where the parts cannot do it."""
    parts = getattr(TWIN.airframe, "propulsion", None)
    there = HIGH.at_altitude(altitude_m)
    speed, air = level(altitude_m)[1], FlightConditions.of(there, TWIN).air
    thrust_n = thrust_w / speed / parts.propulsors
    point = sizing.operating_point(parts.propulsor, thrust_n, speed, air, bus_v)
    return np.asarray(parts.propulsors * point.bus_power_w)


@cache
def level(altitude_m):
    """Drag times airspeed [W], and airspeed of level flight."""
    design, there = design_of(TWIN, HIGH), HIGH.at_altitude(altitude_m)
    flying = parametric_design(TWIN, there, design.variables, design.total_mass_kg)
    return float(flying.propulsion_power_w) * flying.chain.efficiency, flying.airspeed_m_per_s


def chain_of(where):
    levels = flight_levels(TWIN, where, design_of(TWIN, where), solar_day(TWIN, where))
    assert levels.chain is not None
    return levels.chain


# 7 and 13 levels; the exact propeller is evaluated at six of them.
@pytest.mark.parametrize("ceiling_m", [3536.0, 6536.0])
def test_the_table_is_the_exact_chain(ceiling_m):
    where, rng = mission(ceiling_m), np.random.default_rng(3)
    chain = chain_of(where)
    for number, altitude_m in enumerate(where.climb_levels_m):
        load = rng.uniform(0.3, 3.0, 8)
        exact = exact_w(altitude_m, level(altitude_m)[0] * load, BUS_V)
        ours = chain.power_w(np.full(8, number), np.array(0), load)
        able = np.isfinite(exact)
        assert able.sum() > 3
        # Where the blades begin to stall the cubics are 1e-4 off.
        assert ours[able] == pytest.approx(exact[able], rel=2e-4)
    exact = exact_w(536.0, np.full(1, level(536.0)[0]), BUS_V)
    level_w = chain.power_w(np.zeros(1, int), np.array(0), np.ones(1))
    assert level_w == pytest.approx(exact, rel=1e-8)  # its rotation is found to 1e-9


def test_every_node_has_the_power_of_the_exact_chain(flown):
    day, design = flown.performance, flown.performance.design
    time_h, height_m = day.day.time_h, flown.altitude_m[0]
    weight_n = float(design.total_mass_kg) * GRAVITY_M_PER_S2
    rate = np.diff(height_m) / (3600.0 * np.diff(time_h))
    rate = (np.append(rate, rate[0]) + np.insert(rate, 0, rate[-1])) / 2.0
    half = (day.day.sunset_h[0] - day.day.sunrise_h[0]) / 2.0
    factor = 1.05 + 0.2 * np.maximum(1.0 - np.abs(time_h - 12.0) / half, 0.0)
    motor_w = day.load_w[0] - float(design.constant_power_w)
    some = np.flatnonzero(np.abs(rate) > 0.02)[::5]
    assert len(some) > 10
    for node in some:
        level_w = level(float(height_m[node]))[0]
        thrust_w = level_w * factor[node] + weight_n * rate[node]
        if thrust_w < 0.3 * level_w:
            # The motor is off, or runs for a part of the time.
            assert motor_w[node] < 0.5 * exact_w(height_m[node], np.array(25.0), BUS_V)
            continue
        exact = exact_w(float(height_m[node]), np.array(thrust_w), BUS_V)
        # Between levels 500 m apart it is linear.
        assert motor_w[node] == pytest.approx(float(exact), rel=3e-3)


@pytest.mark.parametrize("thermal", [0.0, 0.3])
def test_without_height_it_is_the_day_of_level_flight(thermal):
    found = climb_performance(TWIN, mission(536.0, 0.1, thermal))
    ours, theirs = found.performance.cycle, found.constant.cycle
    # 1e-4 of the table in thermals.
    assert ours.excess_time_h == pytest.approx(theirs.excess_time_h, abs=2e-3)
    assert found.performance.load_w == pytest.approx(found.constant.load_w, rel=5e-4)
