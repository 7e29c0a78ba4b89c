"""Tests of climbs with the efficiency of the moment, against the exact chain point by point."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

import sizing
from missions.library import load_mission
from missions.mission import Mission
from sizing.altitude.climb_chain import ClimbChain
from sizing.altitude.climb_cycle import ClimbPerformance, climb_performance
from sizing.altitude.climb_levels import flight_levels
from sizing.design import FlightConditions, parametric_design
from sizing.mass_budget import design_of
from sizing.performance import cycle_of_variants, performance, performance_of_designs
from sizing.propulsion.chain import OperatingPointPropulsion
from sizing.smooth_propulsion import smooth_at
from sizing.sunlight import solar_day
from sizing.varying_load import DesignLoads
from solar.types import FloatArray

TWIN = sizing.load_aircraft("twin-boom-design")


def mission(ceiling_m: float, all_day: float = 0.0, thermal: float = 0.0, **climb: Any) -> Mission:
    one = load_mission("rafz-july", {"air": {}, "climb": {"ceiling_m": ceiling_m, **climb}})
    turbulence = one.turbulence.model_copy(update={"all_day": all_day, "thermal": thermal})
    return one.model_copy(update={"turbulence": turbulence})


HIGH = mission(3536.0, 0.05, 0.2)


@pytest.fixture(scope="module")
def flown() -> ClimbPerformance:
    return climb_performance(TWIN, HIGH)


BUS_V = TWIN.battery.bus_voltage_v(np.array(0.5))  # that days are flown by


def exact_w(altitude_m: float, thrust_w: FloatArray, bus_v: FloatArray) -> FloatArray:
    """Electric power by the public function; NaN where the parts cannot do it."""
    parts = getattr(TWIN.airframe, "propulsion", None)
    assert isinstance(parts, OperatingPointPropulsion)
    there = HIGH.at_altitude(altitude_m)
    speed, air = level(altitude_m)[1], FlightConditions.of(there, TWIN).air
    thrust_n = thrust_w / speed / parts.propulsors
    point = sizing.operating_point(parts.propulsor, thrust_n, speed, air, bus_v)
    return np.asarray(parts.propulsors * point.bus_power_w)


@cache
def level(altitude_m: float) -> tuple[float, float]:
    """Drag times airspeed [W], and airspeed of level flight."""
    design, there = design_of(TWIN, HIGH), HIGH.at_altitude(altitude_m)
    flying = parametric_design(TWIN, there, design.variables, design.total_mass_kg)
    assert flying.chain is not None
    return float(flying.propulsion_power_w) * flying.chain.efficiency, flying.airspeed_m_per_s


def chain_of(where: Mission) -> ClimbChain:
    levels = flight_levels(TWIN, where, design_of(TWIN, where), solar_day(TWIN, where))
    assert levels.chain is not None
    return levels.chain


# 7 and 13 levels; the exact propeller is evaluated at six of them.
@pytest.mark.parametrize("ceiling_m", [3536.0, 6536.0])
def test_the_table_is_the_exact_chain(ceiling_m: float) -> None:
    where, rng = mission(ceiling_m), np.random.default_rng(3)
    chain = chain_of(where)
    for number, altitude_m in enumerate(where.climb_levels_m):
        load = rng.uniform(0.3, 3.0, 8)
        exact = exact_w(altitude_m, level(altitude_m)[0] * load, BUS_V)
        ours = chain.power_w(np.full(8, number), load)
        able = np.isfinite(exact)
        assert able.sum() > 3
        # Where the blades begin to stall the cubics are 1e-4 off.
        assert ours[able] == pytest.approx(exact[able], rel=2e-4)
        back = chain.load(np.full(8, number), ours)
        assert back == pytest.approx(load, rel=2e-4)


def test_level_flight_is_exact_in_the_table() -> None:
    chain = chain_of(mission(2536.0))
    ours = chain.power_w(np.zeros(1, int), np.ones(1))
    exact = exact_w(536.0, np.full(1, level(536.0)[0]), BUS_V)
    assert ours == pytest.approx(exact, rel=1e-8)  # its rotation is found to 1e-9


def test_every_step_has_the_power_of_the_exact_chain(flown: ClimbPerformance) -> None:
    day, design = flown.climb, flown.performance.design
    hours = np.diff(day.time_h)
    gains_w = np.diff(day.potential_energy_wh[0]) / hours
    motor_w = day.load_w[0][:-1] - float(design.constant_power_w)
    middle_h = (day.time_h[1:] + day.time_h[:-1]) / 2.0
    sun = flown.performance.day
    half = (sun.sunset_h[0] - sun.sunrise_h[0]) / 2.0
    factor = 1.05 + 0.2 * np.maximum(1.0 - np.abs(middle_h - 12.0) / half, 0.0)
    height = (day.altitude_m[0][1:] + day.altitude_m[0][:-1]) / 2.0
    climbs, sinks = gains_w > 1.0, gains_w < -1.0
    kinds = {"climb": climbs, "glide": sinks, "level": ~climbs & ~sinks & (gains_w == 0.0)}
    for name, marks in kinds.items():
        some = np.flatnonzero(marks)[3:-3:12]
        assert len(some) > 2, name
        for step in some:
            level_w = level(float(height[step]))[0]
            thrust_w = level_w * factor[step] + gains_w[step]
            if thrust_w < 0.3 * level_w:
                # The motor is off, or runs for a part of the time.
                assert motor_w[step] < 0.5 * exact_w(height[step], np.array(25.0), BUS_V)
                continue
            exact = exact_w(float(height[step]), np.array(thrust_w), BUS_V)
            # Between levels 500 m apart the march is linear, and so is a step over a minute.
            assert motor_w[step] == pytest.approx(float(exact), rel=2e-3), (name, step)


def test_what_goes_in_comes_out(flown: ClimbPerformance) -> None:
    one = flown.climb.energy_budget
    used = one.constant_load_wh + one.level_flight_wh + one.propulsion_loss_wh + one.stored_wh
    lost = one.charge_loss_wh + one.discharge_loss_wh + one.curtailed_wh
    assert one.solar_wh + one.unserved_wh == pytest.approx(
        used + one.stored_potential_wh + lost, rel=1e-9
    )
    # A day that repeats itself lifts what it sinks.
    lifted = np.diff(flown.climb.potential_energy_wh[0])
    assert one.glide_potential_wh[0] == pytest.approx(-lifted[lifted < 0.0].sum(), rel=1e-3)
    efficiency = one.level_flight_wh / (one.level_flight_wh + one.propulsion_loss_wh)
    assert 0.55 < efficiency[0] < 0.62


@pytest.mark.parametrize("thermal", [0.0, 0.3])
def test_without_height_it_is_the_day_of_level_flight(thermal: float) -> None:
    found = climb_performance(TWIN, mission(536.0, 0.1, thermal))
    ours, theirs = found.performance.cycle, found.constant.cycle
    # Steps of a minute against those of the day's axis, and 1e-4 of the table in thermals.
    assert ours.excess_time_h == pytest.approx(theirs.excess_time_h, abs=2e-3)
    assert ours.minimum_state_of_charge == pytest.approx(theirs.minimum_state_of_charge, abs=2e-4)
    # The means of a minute stand half a minute later.
    assert found.climb.load_w[0, ::5] == pytest.approx(found.constant.load_w[0], rel=5e-4)


def test_no_more_is_climbed_with_than_the_parts_can_do() -> None:
    weak = sizing.load_aircraft("twin-boom-design", {"airframe.propulsion.maximum_tip_mach": 0.115})
    found = climb_performance(weak, mission(1536.0))
    strong = climb_performance(TWIN, mission(1536.0))
    assert found.climb.load_w.max() < strong.climb.load_w.max() - 1.0
    assert found.limits.maximum_power_w == strong.limits.maximum_power_w


def test_studies_agree_with_the_day_of_a_minute(flown: ClimbPerformance) -> None:
    found = performance(TWIN, HIGH)
    assert found.cycle.excess_time_h == pytest.approx(
        flown.performance.cycle.excess_time_h, abs=0.02
    )


def test_a_design_does_not_depend_on_its_batch() -> None:
    own = smooth_at(TWIN, HIGH)
    spans, day = np.array([4.6, 5.0, 5.4]), solar_day(own, HIGH)

    def excess(span: FloatArray) -> FloatArray:
        variables = sizing.DesignVariables(span, 15.0, 2.6, 1.0)
        return performance_of_designs(own, HIGH, variables, day=day).cycle.excess_time_h

    batch = excess(spans)
    for place, span in enumerate(spans):
        assert excess(np.array([span]))[0] == pytest.approx(batch[place], abs=1e-7)


def test_variants_flown_together_are_those_flown_alone() -> None:
    lossy = sizing.load_aircraft(
        "twin-boom-design", {"airframe.propulsion.wiring_resistance_ohm": 0.2}
    )
    day, both = solar_day(TWIN, HIGH), (TWIN, lossy)
    loads = [(one, DesignLoads.of(one, HIGH, design_of(one, HIGH), day)) for one in both]
    together = cycle_of_variants(loads).excess_time_h[:, 0]
    alone = [float(performance(one, HIGH).cycle.excess_time_h[0]) for one in both]
    assert together == pytest.approx(alone, abs=1e-7)
    assert alone[0] > alone[1] + 0.02
