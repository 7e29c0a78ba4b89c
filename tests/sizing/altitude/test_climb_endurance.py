"""The longest flight with climbs: against plain marching, level flight, and bounds by hand."""

from __future__ import annotations

from typing import Any

import builders
import numpy as np
import pytest
from builders import AS2, DESIGN, UNLIMITED_AS2
from plain_climb import DISCHARGE, FLOOR_M, FULL_WH, PlainClimb

from missions.air import standard_air
from missions.dates import day_of_year
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.altitude.climb_cycle import climb_performance
from sizing.energy.battery import RuleChargeLimit
from sizing.energy.endurance import Endurance
from sizing.performance import Performance, performance
from sizing.results.analysis import analyse
from sizing.sunlight import UNCORRECTED_CAM
from sizing.uncertainty.propagation import Propagation
from studies.maps.feasibility import feasibility_map


def mission(ceiling_m: float, strategy: str, **changes: Any) -> Mission:
    climb = {"ceiling_m": ceiling_m, "strategy": strategy}
    return builders.mission(**{"dates": {"on": "12-21"}, "climb": climb} | changes)


def longest(flown: Performance) -> Endurance:
    (flight,) = flown.endurances()
    assert flight is not None
    return flight


# ---- Against plain marching

AS_COLD = {"module_temperature_c": float(standard_air(FLOOR_M).temperature_c)}  # as the air


@pytest.mark.slow
@pytest.mark.parametrize(
    ("aircraft", "date", "ceiling_m", "strategy"),
    [
        (UNLIMITED_AS2, "12-21", 3536.0, "battery_full"),  # a day, then its night
        (AS2, "11-06", 3536.0, "surplus"),  # two nights; climbs as the charger is slow
        (AS2, "10-31", 1536.0, "surplus"),
    ],
)
def test_longest_flight_agrees_with_plain_marching_of_all_launches(
    aircraft: Aircraft, date: str, ceiling_m: float, strategy: str
) -> None:
    where = mission(ceiling_m, strategy, dates={"on": date}, air=AS_COLD)
    found = longest(performance(aircraft, where))
    limit = aircraft.battery.charge_limit
    plain = PlainClimb(
        day_of_year(date),
        ceiling_m,
        surplus=strategy == "surplus",
        limit=limit if isinstance(limit, RuleChargeLimit) else None,
        step_s=20.0,
    )
    # Each 10 min, and by the minute around the launch that was found.
    every = np.arange(0.0, 24.0, 1.0 / 6.0)
    near = (found.launch_h + np.arange(-15, 16) / 60.0) % 24.0
    flown = plain.flight_h(np.concatenate([every, near]))
    best = float(np.nanmax(flown))
    assert not np.isnan(flown).any()
    # Steps of 5 min against 20 s: 0.02 h a day, as for the excess time.
    days = found.endurance_h / 24.0
    assert found.endurance_h == pytest.approx(best, abs=0.02 * days + 0.01)
    # It is the climb that gives it: level flight is far off.
    level = longest(performance(aircraft, builders.mission(dates={"on": date})))
    assert found.endurance_h > level.endurance_h + 0.1


def test_flight_times_from_given_launches_agree_with_plain_marching() -> None:
    flown = performance(UNLIMITED_AS2, mission(3536.0, "battery_full", air=AS_COLD))
    launches = np.array([3.21, 8.02, 12.0, 14.97, 22.4])  # in the night, by surplus, by deficit
    plain = PlainClimb(day_of_year("12-21"), 3536.0, step_s=20.0).flight_h(launches)
    # A launch by surplus begins at a node of the day, 2.5 min off at the most.
    assert flown.flight_time_h(0, launches) == pytest.approx(plain, abs=0.06)


# ---- Limits


@pytest.mark.parametrize("strategy", ["battery_full", "surplus"])
@pytest.mark.parametrize("aircraft", [AS2, UNLIMITED_AS2, DESIGN])
def test_ceiling_at_the_floor_is_level_flight(aircraft: Aircraft, strategy: str) -> None:
    dates = {"from": "10-15", "to": "12-21", "count": 3}
    flown = climb_performance(aircraft, mission(FLOOR_M, strategy, dates=dates))
    ours, theirs = flown.performance, flown.constant
    assert np.isfinite(ours.endurance_h).all()
    # Several days of 5 min steps; only the charger's switch within a step depends on them.
    assert ours.endurance_h == pytest.approx(np.asarray(theirs.endurance_h), abs=1e-3)
    launches = np.array([2.0, 7.5, 17.3])
    assert ours.flight_time_h(1, launches) == pytest.approx(
        theirs.flight_time_h(1, launches), abs=1e-3
    )


def test_propulsion_that_cannot_climb_gives_level_flight() -> None:
    data = AS2.model_dump(by_alias=True)
    data["airframe"]["level_flight"] |= {"maximum_electric_power_w": 35.8}
    weak = Aircraft.model_validate(data)
    # At 1500 m level flight takes 36.5 W already.
    high: dict[str, Any] = {"altitude_m": 1500.0, "air": {}, "dates": {"on": "12-21"}}
    ours = longest(performance(weak, mission(3536.0, "surplus", **high)))
    theirs = longest(performance(weak, builders.mission(**high)))
    assert ours.endurance_h == pytest.approx(theirs.endurance_h, abs=1e-3)


def test_voltages_of_the_moment_reduce_to_level_flight_too() -> None:
    twin = builders.aircraft("twin-boom-design")
    ours = longest(performance(twin, mission(FLOOR_M, "battery_full")))
    theirs = longest(performance(twin, builders.mission(dates={"on": "12-21"})))
    # The tables of the chain are within 8e-5 of the exact one; voltages settle within 1e-4.
    assert ours.endurance_h == pytest.approx(theirs.endurance_h, rel=5e-4)


def test_without_any_sun_it_is_the_battery_over_the_load() -> None:
    night = {"latitude_deg": 80.0, "dates": {"on": "12-21"}}
    flown = performance(AS2, mission(3536.0, "surplus", **night))
    by_hand = FULL_WH * DISCHARGE / float(flown.nominal_load_w[0])
    assert longest(flown).endurance_h == pytest.approx(by_hand, rel=1e-3)


# ---- Wherever it is given


def test_flight_that_is_drawn_ends_with_the_endurance() -> None:
    flown = performance(AS2, mission(3536.0, "surplus"))
    flight = longest(flown)
    course = flown.course(0, flight.launch_h, flight.endurance_h)
    clock_h, solar_w, load_w, charge, altitude_m = course
    assert clock_h[[0, -1]] == pytest.approx(
        [flight.launch_h, flight.launch_h + flight.endurance_h]
    )
    assert charge[0] == 1.0
    # The endurance is known to some seconds, of which each takes 3e-5 of the charge.
    assert charge[-1] == pytest.approx(0.0, abs=2e-3)
    assert np.all(charge[:-2] > 0.0)
    # It climbs: the load is above that of level flight, and that of the glide is the avionics'.
    assert load_w.max() > 1.5 * float(flown.nominal_load_w[0])
    assert load_w.min() == pytest.approx(float(flown.design.constant_power_w), rel=1e-6)
    assert solar_w.min() == 0.0
    assert altitude_m[[0, -1]] == pytest.approx(FLOOR_M)
    assert FLOOR_M + 500.0 < altitude_m.max() <= 3536.0


def test_analysis_gives_the_flight_with_climbs() -> None:
    where = mission(3536.0, "surplus")
    analysis = analyse(AS2, where)
    expected = longest(performance(AS2, where))
    assert analysis.endurance_h == pytest.approx(expected.endurance_h, rel=1e-12)
    assert analysis.to_dict()["endurance_h"] == pytest.approx(expected.endurance_h, rel=1e-12)
    limited = analysis.limited_flight
    assert limited is not None
    assert limited.endurance_h == pytest.approx(expected.endurance_h)
    assert limited.from_noon_h < limited.endurance_h
    assert f"{expected.endurance_h:.2f} h" in str(analysis)


def test_map_and_draws_give_the_flight_with_climbs_too() -> None:
    where = mission(3536.0, "surplus")
    expected = float(longest(performance(DESIGN, where)).endurance_h)
    data = feasibility_map(DESIGN, where, latitudes=[47.6], days=[355], endurance=True)
    assert float(data["endurance"].to_numpy()[0, 0]) == pytest.approx(expected, rel=1e-9)
    draws = Propagation(DESIGN, where, UNCORRECTED_CAM)
    mass = np.array([float(DESIGN.battery.mass_kg)])
    found = draws.endurance_h({"battery.mass_kg": mass})
    # Of the same design in light by another sum: its last digits differ.
    assert found == pytest.approx([expected], rel=1e-5)
