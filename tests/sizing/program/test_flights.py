"""Flights from a launch to a landing: the march, the sizing, the longest one, wrong files."""

import math

import numpy as np
import pytest
from builders import AS2, DESIGN, aircraft, mission, shipped_mission

from missions.mission import Scenarios
from missions.mission.mission import Payload
from sizing.day.light import FINE_STEP_H, solar_day
from sizing.day.metrics import Status
from sizing.design import DesignVariables
from sizing.limits import meets_requirements
from sizing.performance import performance, performance_of_designs
from sizing.program.cells import size_cells
from sizing.program.cross_check import cross_check
from sizing.program.endurance import longest_flight_of_all
from sizing.program.objectives import Objective
from sizing.program.result import SizingStatus
from sizing.program.size import size_aircraft
from sizing.results.sizing import size
from sizing.results.uncertainty import analyse_uncertainty

# The loop over minutes knows no charge limit.
LARGE_BATTERY = aircraft("atlantiksolar-as2", "battery.charge_limit={kind: none}")
SMALL_BATTERY = aircraft(
    "atlantiksolar-as2", "battery.charge_limit={kind: none}", "battery.mass_kg=1.2"
)
DAYLIGHT = {"launch": "sunrise", "land": "sunset", "reserve_h": 0.5}


def flying(flight, **changes):
    return mission(flight=flight, **changes)


def hand_flown(flown, one):
    """Excess time, least state of charge and missing hours of a loop over minutes."""
    assert one.flight is not None
    repeated = one.model_copy(update={"flight": None})
    level = performance(flown, repeated, step_h=FINE_STEP_H)
    window = one.flight_window_h(one.scenarios())
    launch_h, land_h = float(window[0][0]), float(window[1][0])
    battery, store = flown.battery, level.store
    into, out_of = battery.mean_charge_efficiency, battery.mean_discharge_efficiency
    full_wh = float(np.ravel(store.battery_energy_wh)[0])
    count = round((land_h - launch_h) * 60.0)
    step_h = (land_h - launch_h) / count
    middle_h = launch_h + (np.arange(count) + 0.5) * step_h
    solar_w = np.interp(middle_h % 24.0, level.day.time_h, level.solar_power_w[0])
    load_w = float(level.nominal_load_w[0])
    stored_wh, least_wh, missing_h = full_wh, full_wh, 0.0
    for net_w in solar_w - load_w:
        stored_wh += (into * net_w if net_w > 0.0 else net_w / out_of) * step_h
        missing_h += step_h if stored_wh < 0.0 else 0.0
        stored_wh = min(max(stored_wh, 0.0), full_wh)
        least_wh = min(least_wh, stored_wh)
    left_h = stored_wh * out_of / load_w
    return (-missing_h if missing_h else left_h), least_wh / full_wh, missing_h


@pytest.mark.parametrize(
    ("flown", "flight"),
    [
        (LARGE_BATTERY, {"land": "sunset"}),
        (LARGE_BATTERY, {"launch": "16:00", "hours": 20.0}),
        (LARGE_BATTERY, {"launch": "07:30", "hours": 60.0}),
        (SMALL_BATTERY, {"launch": "22:00", "land": "sunset"}),
        (SMALL_BATTERY, {"launch": "sunrise", "hours": 27.0}),
    ],
)
def test_a_flight_is_that_of_a_loop_over_minutes(flown, flight):
    one = flying(flight)
    found = performance(flown, one).cycle
    excess_h, least, missing_h = hand_flown(flown, one)
    # A minute of the loop, and a sun of 5 min that is straight between its nodes.
    assert found.excess_time_h[0] == pytest.approx(excess_h, abs=0.03)
    assert found.minimum_state_of_charge[0] == pytest.approx(least, abs=0.002)
    assert found.missing_h[0] == pytest.approx(missing_h, abs=0.03)
    assert found.status[0] == (Status.limited if missing_h else Status.lands)


def test_a_flight_by_the_clock_is_that_by_the_sun_it_stands_for():
    """At 15 degrees east the clock of UTC+1 is off by the equation of time alone: 6 min in July."""
    local = flying(
        {"launch": "07:30", "hours": 10.0, "utc_offset_h": 1.0}, longitude_deg=15.0
    ).flight_window_h(mission().scenarios())
    assert local[0][0] == pytest.approx(7.5 - 6.0 / 60.0, abs=0.02)
    # No flight begins with a sunrise that there is not.
    dark = flying({"land": "sunset"}, latitude_deg=80.0, dates={"on": "12-21"})
    found = performance(AS2, dark).cycle
    assert (found.status[0], found.excess_time_h[0]) == (Status.limited, 0.0)
    # The reserve is the required excess time by another name.
    by_either = flying(DAYLIGHT), flying({"land": "sunset"}, required_excess_time_h=0.5)
    assert [one.required_excess_time_h for one in by_either] == [0.5, 0.5]


def searched(one, score, points, rounds):
    """Best of a grid of designs that closes in on its best, again and again; by the simulator."""
    space, day = DESIGN.design_space, solar_day(DESIGN, one)
    ranges = (space.wingspan_m, space.battery_mass_kg, space.module_area_m2)
    least = np.array([r.minimum for r in ranges])
    most = np.array([r.maximum for r in ranges])
    low, high, best, kept = least, most, -math.inf, np.zeros(3)
    for _ in range(rounds):
        axes = [np.geomspace(a, b, points) for a, b in zip(low, high, strict=True)]
        span, battery, area = (v.ravel() for v in np.meshgrid(*axes, indexing="ij"))
        aspect = np.full(len(span), DESIGN.airframe.aspect_ratio)
        with np.errstate(all="ignore"):
            perf = flown_batch(one, DesignVariables(span, aspect, battery, area), day)
            met = np.ravel(meets_requirements(DESIGN, perf.design))
            scores = np.where(met, np.nan_to_num(score(perf), nan=-np.inf), -np.inf)
        i = int(np.argmax(scores))
        if scores[i] > best:
            best, kept = float(scores[i]), np.array([span[i], battery[i], area[i]])
        near = (high / low) ** 0.3
        low, high = np.maximum(kept / near, least), np.minimum(kept * near, most)
    return best, perf


def flown_batch(one, variables, day):
    return performance_of_designs(DESIGN, one, variables, day=day)


@pytest.mark.long
@pytest.mark.parametrize(
    "flight",
    [DAYLIGHT, {"launch": "12:00", "hours": 14.0}, {"hours": 14.0}, {"hours": 30.0}],
)
def test_the_lightest_aircraft_of_a_flight_is_that_of_a_search(flight):
    one = flying(flight)

    def lightest(perf):
        excess_h = perf.cycle.excess_time_h[:, 0]
        lands = (excess_h > 0.0) & (excess_h >= one.required_excess_time_h)
        return np.where(lands, -np.asarray(perf.design.total_mass_kg), -np.inf)

    found = size_aircraft(DESIGN, one, Objective.min_mass)
    assert found.simulated.cycle.excess_time_h.min() >= one.required_excess_time_h
    best, _ = searched(one, lightest, points=9, rounds=11)
    # The least mass that is known: the program may be 0.5 % above, and the search as much.
    assert found.objective_value == pytest.approx(-best, rel=5e-3)


def test_a_flight_that_no_design_makes_is_told_with_what_the_nearest_lacks():
    found = size_aircraft(DESIGN, flying({"hours": 70.0}, dates={"on": "12-21"}))
    assert found.status is SizingStatus.infeasible
    assert [one.requirement for one in found.violations] == ["excess_time"]
    assert "the nearest one lacks power for" in found.violations[0].text


@pytest.mark.slow
def test_the_longest_flight_of_all_designs_is_longer_than_that_of_a_search():
    one = mission(dates={"on": "12-21"})
    found = longest_flight_of_all(DESIGN, one)
    assert found.simulated.cycle.status[0] == Status.lands
    best, _ = searched(one, lambda perf: perf.worst_endurance_h, points=5, rounds=7)
    assert found.objective_value > best
    assert found.objective_value == pytest.approx(best, rel=0.1)  # of a coarse search


def test_where_an_aircraft_flies_perpetually_the_longest_flight_is_unlimited():
    assert longest_flight_of_all(DESIGN, mission()).objective_value == math.inf


def test_no_neighbour_of_a_flight_with_two_mornings_is_better():
    # Light wings with few modules are as good as those with many: steps led to and fro.
    there = shipped_mission(flight={"launch": "sunrise", "hours": 30.0})
    found = size_aircraft(DESIGN, there, Objective.min_mass, required_excess_time_h=0.0)
    assert cross_check(DESIGN, there, found).advantage <= 0.005 * found.objective_value


def test_whatever_is_asked_of_a_cycle_is_answered_for_a_flight():
    there = shipped_mission(flight={"launch": "sunrise", "land": "sunset"})
    asked = size(DESIGN, there, "min_mass", with_sensitivities=True, with_cross_check=True)
    assert asked.cross_check.cross_checked
    by_motor = {row.parameter: row.per_percent for row in asked.sensitivities}
    motor = DESIGN.airframe.propulsion.motor_efficiency
    better, worse = (
        size(
            aircraft(DESIGN.name, f"airframe.propulsion.motor_efficiency={by * motor}"), there
        ).total_mass_kg
        for by in (1.05, 0.95)
    )
    # Either sizing is known to 0.03 %, a tenth of their difference.
    expected = pytest.approx((better - worse) / 10.0, rel=0.1)
    assert by_motor["airframe.propulsion.motor_efficiency"] == expected
    heavy = size(DESIGN, there.model_copy(update={"payload": Payload(mass_kg=400.0)}))
    assert {row.parameter for row in heavy.relaxations} == {"mission.payload.mass_kg"}


@pytest.mark.slow
def test_a_reliable_flight_has_its_probability_in_an_analysis():
    there = shipped_mission(flight={"launch": "sunrise", "land": "sunset"})
    plain, reliable = (size(DESIGN, there, reliability=share) for share in (None, 0.9))
    assert reliable.total_mass_kg > 1.01 * plain.total_mass_kg
    drawn = analyse_uncertainty(reliable.sized_aircraft(), there, samples=4096, seed=5)
    assert drawn.probability_required.value == pytest.approx(0.9, abs=0.02)


def test_where_the_sun_does_not_rise_no_flight_begins_at_sunrise():
    there = shipped_mission(flight={"launch": "sunrise", "land": "sunset"})
    places = Scenarios(np.array([40.0, 80.0]), np.array([355, 355]))
    cells = size_cells(DESIGN, there, places, Objective.min_mass)
    assert cells.status.tolist() == [SizingStatus.cross_checked, SizingStatus.infeasible]
    assert cells.requirement[1] == "sun"


def test_a_range_of_flights_has_a_design():
    there = shipped_mission(flight={"launch": "sunrise", "land": "sunset"})
    band = size(DESIGN, there, "widest_latitude_band").coverage
    assert band.first < -60.0
    assert band.last > 70.0
