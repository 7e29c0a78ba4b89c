"""The longest flight with climbs: against plain marching, level flight, and bounds by hand."""

import builders
import numpy as np
import pytest
from builders import AS2, DESIGN, UNLIMITED_AS2, climb_performance
from plain_climb import FLOOR_M, PlainClimb

from missions.air import standard_air
from missions.dates import day_of_year
from sizing.battery.battery import RuleChargeLimit
from sizing.day.flight import Endurance
from sizing.performance import performance
from sizing.results.analysis import analyse


def mission(ceiling_m, **changes):
    climb = {"ceiling_m": ceiling_m}
    return builders.mission(**{"dates": {"on": "12-21"}, "climb": climb} | changes)


def longest(perf):
    return Endurance(perf.endurances.endurance_h[0], perf.endurances.launch_h[0])


@pytest.fixture(scope="module")
def climbing():
    """AtlantikSolar with climbs to 3536 m in December."""
    return performance(AS2, mission(3536.0))


AS_COLD = {"module_temperature_c": float(standard_air(FLOOR_M).temperature_c)}  # as the air


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
    limit = aircraft.battery.charge_limit
    limited = limit if isinstance(limit, RuleChargeLimit) else None
    best = 0.0
    for surplus in (False, True):
        options = {"surplus": surplus, "limit": limited, "step_s": 20.0}
        plain = PlainClimb(day_of_year(date), ceiling_m, **options)
        hours = plain.flight_h(np.arange(0.0, 24.0, 1.0 / 6.0))
        assert not np.isnan(hours).any()
        best = max(best, float(hours.max()))
    # Launches 10 min apart, and intervals of half an hour: 0.2 h a day.
    assert flight.endurance_h > best - 0.2 * flight.endurance_h / 24.0
    # It is the climb that gives it: level flight is far off.
    level = longest(performance(aircraft, builders.mission(dates={"on": date})))
    assert flight.endurance_h > level.endurance_h + 0.1


@pytest.mark.parametrize("aircraft", [AS2, UNLIMITED_AS2, DESIGN])
def test_ceiling_at_the_floor_is_level_flight(aircraft):
    dates = {"from": "10-15", "to": "12-21", "count": 3}
    climbs = climb_performance(aircraft, mission(FLOOR_M, dates=dates))
    ours, theirs = climbs.performance, climbs.constant
    assert np.isfinite(ours.endurance_h).all()
    assert ours.endurance_h == pytest.approx(np.asarray(theirs.endurance_h), abs=1e-9)
    launches = np.array([2.0, 7.5, 17.3])
    # Days whose losses are alike to 1e-4 of the battery are skipped.
    assert ours.flight_time_h(1, launches) == pytest.approx(
        theirs.flight_time_h(1, launches), abs=0.01
    )


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
    analysis = analyse(AS2, mission(3536.0))
    expected = longest(climbing)
    assert analysis.endurance_h == pytest.approx(expected.endurance_h, rel=1e-12)
    assert analysis.to_dict()["endurance_h"] == pytest.approx(expected.endurance_h, rel=1e-12)
    limited = analysis.limited_flight
    assert limited.endurance_h == pytest.approx(expected.endurance_h)
    assert limited.from_noon_h < limited.endurance_h
    assert f"{expected.endurance_h:.2f} h" in str(analysis)
