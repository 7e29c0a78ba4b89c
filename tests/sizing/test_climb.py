"""Climbs of given aircraft: against the rule marched plainly, arithmetic by hand, invariants."""

from functools import cache

import ambiance
import builders
import numpy as np
import pytest
from builders import AS2, DESIGN, UNLIMITED_AS2, climb_performance
from plain_climb import ETA, FLOOR_M, PlainClimb

from missions.air import standard_air
from missions.dates import date_code, day_of_year
from sizing.battery.battery import RuleChargeLimit
from sizing.day.battery import Store
from sizing.day.flight import Endurance
from sizing.day.heights import ClimbLimitError, check_climb_limits, climb_limits, flight_levels
from sizing.day.light import solar_day
from sizing.day.metrics import Status
from sizing.mass_budget import design_of
from sizing.performance import performance
from sizing.program.schedule import flown_along
from sizing.results.analysis import analyse

SOLSTICES = "06-21", "12-21"  # five days between them, 21 September and 5 November included
# What intervals of 40 a day leave of the best schedule, and corners that 5 min round off.
STEPS_H = 0.03
AS_COLD = {"module_temperature_c": float(standard_air(FLOOR_M).temperature_c)}  # as the air


def mission(ceiling_m, **changes):
    return builders.mission(
        **{"dates": {"on": "06-21"}, "climb": {"ceiling_m": ceiling_m}} | changes
    )


@cache
def climbs_of(aircraft, ceiling_m, dates="06-21"):
    first, last = (dates, None) if isinstance(dates, str) else dates
    days = {"from": first, "to": last, "count": 5} if last else {"on": first}
    return climb_performance(aircraft, mission(ceiling_m, dates=days))


@pytest.mark.parametrize("aircraft", [AS2, UNLIMITED_AS2, DESIGN])
def test_ceiling_at_the_floor_is_the_constant_altitude_simulator(aircraft):
    result = climbs_of(aircraft, FLOOR_M, SOLSTICES)
    ours, theirs = result.performance.cycle, result.constant.cycle
    np.testing.assert_array_equal(ours.status, theirs.status)
    assert ours.excess_time_h == pytest.approx(theirs.excess_time_h, abs=1e-9)
    assert ours.energy_wh == pytest.approx(theirs.energy_wh, abs=1e-6)
    assert np.all(result.altitude_m == FLOOR_M)
    assert np.all(result.gliding_h == 0.0)
    ours, theirs = result.performance, result.constant
    assert np.isfinite(ours.endurance_h[-1])
    assert ours.endurance_h == pytest.approx(np.asarray(theirs.endurance_h), abs=1e-9)
    # Days whose losses are alike to 1e-4 of the battery are skipped.
    hours, expected_h = (one.flight_time_h(3, np.array([2.0, 7.5, 17.3])) for one in (ours, theirs))
    assert hours == pytest.approx(expected_h, abs=0.01)


def by_a_rule(aircraft, ceiling_m, date, surplus):
    """Climbs by a rule: once the battery is full, or on any surplus."""
    limit = aircraft.battery.charge_limit
    limited = limit if isinstance(limit, RuleChargeLimit) else None
    return PlainClimb(day_of_year(date), ceiling_m, surplus=surplus, limit=limited, step_s=20.0)


def by_rule_h(plain):
    """Excess time with climbs by a rule."""
    energy, height, dawn = np.array([732.0]), np.array([FLOOR_M]), -1.0
    for k in range(round(48.0 / plain.step_h)):  # it is full by the first evening
        hour = k * plain.step_h
        before = float(energy[0])
        energy, height, net = plain.step(np.array([hour % 24.0]), energy, height)
        if dawn < 0.0 and hour > 26.0 and net[0] >= 0.0:
            dawn = before
    return dawn * 0.97 / (35.8 + 6.0)


@pytest.mark.slow
@pytest.mark.parametrize("aircraft", [AS2, UNLIMITED_AS2])
@pytest.mark.parametrize("ceiling_m", [1536.0, 3536.0, 9000.0])
@pytest.mark.parametrize("date", ["06-21", "09-10"])
def test_no_rule_has_more_excess_time(aircraft, ceiling_m, date):
    where = mission(ceiling_m, air=AS_COLD, dates={"on": date})
    ours_h = float(climb_performance(aircraft, where).performance.cycle.excess_time_h[0])
    rules = [by_rule_h(by_a_rule(aircraft, ceiling_m, date, surplus)) for surplus in (False, True)]
    assert ours_h >= max(rules) - STEPS_H
    # By constant efficiencies and with a slow charger little is left to win.
    assert ours_h <= max(rules) + 0.5


def test_load_is_that_of_level_flight_and_of_what_is_lifted():
    result = climbs_of(AS2, 6536.0)
    perf, height_m = result.performance, result.altitude_m[0]
    seconds = 3600.0 * np.diff(perf.day.time_h)
    rate = np.diff(height_m) / seconds
    middle = (height_m[1:] + height_m[:-1]) / 2.0
    density = ambiance.Atmosphere(middle).density
    by_hand = 35.8 * (density / 1.10) ** -0.5 + 6.92 * 9.80665 * rate / ETA + 6.0
    ours = (perf.load_w[0, 1:] + perf.load_w[0, :-1]) / 2.0
    steady = np.abs(np.diff(rate, prepend=rate[-1], append=rate[0])).reshape(-1)
    inside = np.maximum(steady[1:], steady[:-1]) < 1e-6  # corners are rounded
    assert inside.sum() > 150
    # Levels 500 m apart, and the air of the file at 1.10 kg/m3.
    assert ours[inside] == pytest.approx(by_hand[inside], rel=3e-3)
    # The mean of an interval keeps to the rated power; thin air at its end takes a little more
    # than at its begin.
    assert perf.load_w.max() <= 1.03 * (180.0 + 6.0)
    assert result.altitude_m.max() == pytest.approx(6536.0, abs=1.0)


@pytest.mark.parametrize("rise_m", [1000.0, 3000.0])
def test_gain_is_what_the_height_saves_the_battery(rise_m):
    result = climbs_of(AS2, FLOOR_M + rise_m)
    height_wh = float(result.stored_height_wh[0])
    # 6.92 kg x 9.81 m/s2 x 1000 m = 68 kJ = 18.9 Wh.
    assert height_wh == pytest.approx(6.92 * 9.80665 * rise_m / 3600.0, rel=1e-3)
    nominal_w = float(result.constant.nominal_load_w[0])
    # Height replaces motor power, W / eta of the electric kind, but sinks faster where it is high:
    # between the power at the ceiling and that at the floor. The light aloft, which the evening
    # and the morning have more of, adds some per cent.
    density = ambiance.Atmosphere(np.array([FLOOR_M, FLOOR_M + rise_m])).density
    at_best = height_wh / ETA / nominal_w
    at_worst = at_best * (density[1] / density[0]) ** 0.5
    assert at_worst - STEPS_H <= result.gain_in_excess_time_h[0] <= 1.1 * at_best


def test_scenarios_do_not_disturb_each_other():
    days = {"from": "05-01", "to": "09-01", "count": 3}
    together = climb_performance(AS2, mission(3536.0, dates=days)).performance
    for place, day in enumerate(together.day.scenarios.day_of_year):
        alone = climbs_of(AS2, 3536.0, date_code(int(day))).performance
        assert together.cycle.excess_time_h[place] == alone.cycle.excess_time_h[0]


def test_polar_day_has_no_end():
    where = mission(2000.0, latitude_deg=85.0, dates={"on": "06-21"})
    result = climb_performance(AS2, where)
    assert result.performance.cycle.status[0] == Status.always_lit
    assert np.isinf(result.performance.cycle.excess_time_h[0])
    assert result.gain_in_excess_time_h[0] == 0.0


def test_a_strategy_is_read_and_ignored():
    floor_mission = mission(1536.0, climb={"ceiling_m": 1536.0, "strategy": "surplus"})
    ours = analyse(AS2, floor_mission)
    assert "climb.strategy is ignored" in str(ours)
    assert any("climb.strategy" in note for note in ours.to_dict()["reading_notes"])
    assert ours.excess_time_h == climbs_of(AS2, 1536.0).performance.cycle.excess_time_h[0]


@pytest.mark.parametrize(
    ("aircraft", "ceiling_m", "date"),
    [(AS2, 3536.0, "06-21"), (AS2, 2000.0, "04-01"), (DESIGN, 9000.0, "06-21")],
)
def test_program_and_flights_in_steps_of_5_and_of_1_min_agree(aircraft, ceiling_m, date):
    analysis = analyse(aircraft, mission(ceiling_m, dates={"on": date}))
    assert analysis.climb_check_h is not None
    program_h, by_minute_h = analysis.climb_check_h
    # Corners that 5 min round off.
    assert program_h == pytest.approx(analysis.excess_time_h, abs=STEPS_H)
    assert by_minute_h == pytest.approx(analysis.excess_time_h, abs=0.01)
    record = analysis.to_dict()["climb"]
    assert record["program_excess_time_h"] == program_h
    assert record["one_minute_excess_time_h"] == by_minute_h
    (row,) = (line for line in str(analysis.at_level(2)).splitlines() if "by the minute" in line)
    assert f"{by_minute_h:.2f} h" in row


def test_random_days_along_random_heights_conserve_energy():
    # 1000 days of two aircraft along heights that nobody would fly, with batteries of any size.
    rng = np.random.default_rng(17)
    for aircraft in (AS2, DESIGN):
        where = mission(3536.0, dates={"from": "03-01", "to": "12-21", "count": 5})
        day, design = solar_day(aircraft, where), design_of(aircraft, where)
        levels = flight_levels(aircraft, where, design, day)
        many = levels.select(rng.integers(0, 5, 500))
        corners = rng.uniform(0.0, 3000.0, (500, 9)) * rng.integers(0, 2, (500, 1))
        corners[:, -1] = corners[:, 0]
        at_h = np.linspace(0.0, 24.0, 9)
        height_m = np.stack([np.interp(day.time_h, at_h, heights) for heights in corners])
        energy_wh = 10.0 ** rng.uniform(1.0, 3.5, 500)
        store = Store.of(aircraft.battery, energy_wh)
        flights = flown_along(day.time_h, many, store, height_m)
        spent = flights.cycle.energy_budget
        income = spent.solar_wh + spent.unserved_wh
        losses = spent.charge_loss_wh + spent.discharge_loss_wh + spent.curtailed_wh
        turnover = spent.solar_wh + np.abs(flights.load_w).max(axis=-1) * 24.0 + energy_wh
        # Rounding of sums over 288 steps.
        wrong = np.abs(income - spent.load_wh - spent.stored_wh - losses)
        assert np.max(wrong / turnover) < 1e-12
        # What heights take on their way up they give back on their way down, as flown backwards.
        backwards_w = many.powers_along(day.time_h, height_m[:, ::-1])[1][:, ::-1]
        lift_wh = np.trapezoid(flights.load_w - backwards_w, day.time_h, axis=-1)
        assert np.max(np.abs(lift_wh) / turnover) < 1e-12


@pytest.mark.parametrize(
    ("name", "key", "overrides"),
    [
        ("atlantiksolar-as2", f"airframe.level_flight.{key}", [f"airframe.level_flight.{key}=null"])
        for key in ("maximum_electric_power_w", "propulsion_efficiency")
    ]
    + [("sky-sailor", "airframe.propulsion.climb_power_ratio", [])],
)
def test_aircraft_that_cannot_climb_is_refused(name, key, overrides):
    with pytest.raises(ClimbLimitError, match=key):
        check_climb_limits(builders.aircraft(name, *overrides), mission(2000.0))


def test_rated_power_of_a_parametric_aircraft_is_its_ratio_to_level_flight():
    design = design_of(DESIGN, mission(2000.0))
    efficiency, maximum_w = climb_limits(DESIGN, design)
    assert maximum_w == pytest.approx(5.03 * float(design.propulsion_power_w))
    assert efficiency == pytest.approx(0.97 * 0.82 * 0.96 * 0.82)


# ---- the longest flight


def longest(perf):
    return Endurance(perf.endurances.endurance_h[0], perf.endurances.launch_h[0])


@pytest.fixture(scope="module")
def climbing():
    """AtlantikSolar with climbs to 3536 m in December."""
    return performance(AS2, mission(3536.0, dates={"on": "12-21"}))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("aircraft", "date", "ceiling_m"),
    [
        (UNLIMITED_AS2, "12-21", 3536.0),  # a day, then its night
        (AS2, "11-06", 3536.0),  # two nights; climbs as the charger is slow
        (AS2, "10-31", 1536.0),
    ],
)
def test_no_launch_by_a_rule_flies_longer(aircraft, date, ceiling_m):
    flight = longest(performance(aircraft, mission(ceiling_m, dates={"on": date}, air=AS_COLD)))
    best = 0.0
    for surplus in (False, True):
        plain = by_a_rule(aircraft, ceiling_m, date, surplus)
        hours = plain.flight_h(np.arange(0.0, 24.0, 1.0 / 6.0))
        assert not np.isnan(hours).any()
        best = max(best, float(hours.max()))
    # Launches 10 min apart, and intervals of half an hour: 0.2 h a day.
    assert flight.endurance_h > best - 0.2 * flight.endurance_h / 24.0
    # It is the climb that gives it: level flight is far off.
    level = longest(performance(aircraft, builders.mission(dates={"on": date})))
    assert flight.endurance_h > level.endurance_h + 0.1


def test_flight_that_is_drawn_ends_with_the_endurance(climbing):
    perf = climbing
    flight = longest(perf)
    course = perf.course(0, flight.launch_h, flight.endurance_h)
    clock_h, solar_w, load_w, charge, altitude_m = course
    assert clock_h[[0, -1]] == pytest.approx(
        [flight.launch_h, flight.launch_h + flight.endurance_h]
    )
    assert charge[0] == 1.0
    # The endurance is known to some seconds, of which each takes 3e-5 of the charge.
    assert charge[-1] == pytest.approx(0.0, abs=2e-3)
    assert np.all(charge[:-2] > 0.0)
    # It climbs, and glides: the load is above that of level flight, and far below it.
    assert load_w.max() > 1.3 * float(perf.nominal_load_w[0])
    assert load_w.min() < 0.5 * float(perf.nominal_load_w[0])
    assert solar_w.min() == 0.0
    assert altitude_m[[0, -1]] == pytest.approx(FLOOR_M)
    assert FLOOR_M + 500.0 < altitude_m.max() <= 3536.0 + 1e-6


def test_analysis_gives_the_flight_with_climbs(climbing):
    analysis = analyse(AS2, mission(3536.0, dates={"on": "12-21"}))
    expected = longest(climbing)
    assert analysis.endurance_h == pytest.approx(expected.endurance_h, rel=1e-12)
    assert analysis.to_dict()["endurance_h"] == pytest.approx(expected.endurance_h, rel=1e-12)
    limited = analysis.limited_flight
    assert limited.endurance_h == pytest.approx(expected.endurance_h)
    assert limited.from_noon_h < limited.endurance_h
    assert f"{expected.endurance_h:.2f} h" in str(analysis)
