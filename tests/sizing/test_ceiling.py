"""Highest altitude of perpetual flight: limits, invariants and independent arithmetic."""

from functools import partial

import ambiance
import builders
import numpy as np
import pytest
from builders import AS2, DESIGN

from sizing import ceiling as module
from sizing.ceiling import (
    AltitudeFlight,
    flight_at_altitude,
    highest_perpetual_altitude,
    scanned_altitudes_m,
)
from sizing.day.light import UNCORRECTED_CAM
from sizing.mass_budget import ImpossibleDesignError
from sizing.performance import performance

mission = partial(builders.mission, dates={"on": "06-21"})


@pytest.mark.parametrize("altitude_m", [0.0, 3000.0, 11000.0, 15000.0, 20000.0])
def test_power_and_reynolds_number_follow_from_an_independent_atmosphere(altitude_m):
    there = mission(altitude_m=altitude_m)
    air = ambiance.Atmosphere(altitude_m)
    density = float(air.density[0])
    polar = DESIGN.airframe.aerodynamics
    flight = flight_at_altitude(DESIGN, there, UNCORRECTED_CAM, altitude_m)
    mass = performance(DESIGN, there).design.total_mass_kg
    span, aspect = 5.65, 18.5
    area = span**2 / aspect
    speed = np.sqrt(2.0 * mass * 9.80665 / (density * area * 1.0))
    # The reference gives the kinematic viscosity directly: Re = V c / nu.
    reynolds = speed * (span / aspect) / float(air.kinematic_viscosity[0])
    drag = 0.5 * density * speed**2 * area * polar.drag_coefficient(aspect, reynolds)
    electric = drag * speed / (0.97 * 0.82 * 0.96 * 0.82)
    # The two atmospheres agree to 1e-5, and the drag varies more slowly than either.
    assert flight.airspeed_m_per_s == pytest.approx(speed, rel=1e-5)
    assert flight.propulsion_power_w == pytest.approx(electric, rel=3e-5)


@pytest.mark.parametrize(
    "air", [{"ambient_temperature_c": 31.3}, {"temperature_offset_k": 19.784}, {}]
)
def test_warm_air_stays_as_much_warmer_aloft(air):
    warm = mission(air=air)
    standard = ambiance.Atmosphere(536.0).temperature[0]
    offset = float(warm.air_state().temperature_k - standard)
    there = warm.at_altitude(15000.0)
    expected = ambiance.Atmosphere(15000.0).temperature[0] + offset
    # The same gradients of the standard: rounding.
    assert float(there.air_state().temperature_k) == pytest.approx(expected, abs=1e-9)
    assert there.module_temperature_c() == pytest.approx(expected - 273.15, abs=1e-9)
    assert float(there.air_state().pressure_pa) == pytest.approx(
        float(mission(altitude_m=15000.0).air_state().pressure_pa)
    )


@pytest.mark.long
@pytest.mark.parametrize("aircraft", [AS2, DESIGN])
@pytest.mark.parametrize("required_h", [0.0, 3.0])
def test_ceiling_lies_where_analyse_finds_the_required_excess_time(aircraft, required_h):
    where = mission(required_excess_time_h=required_h)
    ceiling = highest_perpetual_altitude(aircraft, where, step_m=1000.0)
    height = ceiling.highest.altitude_m

    def excess(altitude_m):
        cycle = performance(aircraft, mission(altitude_m=altitude_m)).cycle
        return float(cycle.excess_time_h[0])

    # The ceiling is found to 0.1 m; 1 m above it the aircraft must fail.
    assert excess(height) > required_h > excess(height + 1.0)
    assert not ceiling.at_search_limit


def test_worst_scenario_sets_the_ceiling():
    both = highest_perpetual_altitude(
        AS2, mission(dates={"from": "06-21", "to": "08-10", "count": 2}), step_m=1000.0
    )
    alone = highest_perpetual_altitude(AS2, mission(dates={"on": "08-10"}), step_m=1000.0)
    # Each search ends within a decimetre.
    assert both.highest.altitude_m == pytest.approx(alone.highest.altitude_m, abs=0.2)
    assert both.highest.worst_scenario == 1


def test_search_that_ends_too_low_says_so():
    ceiling = highest_perpetual_altitude(AS2, mission(), highest_m=3000.0)
    assert ceiling.at_search_limit
    assert ceiling.highest is ceiling.flights[-1]
    assert ceiling.highest.altitude_m == 3000.0


def simulated(monkeypatch, excess_h):
    """Let the excess time of the search be this function of the altitude."""

    def simulate(_, __, ___, altitude_m):
        return AltitudeFlight(
            altitude_m, float(excess_h(altitude_m)), 0.5, 40.0, 1.0, 1.0, 8.0, 1.0, 0.0, 0
        )

    monkeypatch.setattr(module, "flight_at_altitude", simulate)
    return highest_perpetual_altitude(AS2, mission(altitude_m=0.0))


def test_feasible_band_aloft_counts_though_lower_flight_fails(monkeypatch):
    # Two feasible bands: 4 to 12 km with the peak at 7.3 km, and a weaker one from 14 to 16 km.
    excess = {0.0: -2.0, 4000.0: 0.0, 7300.0: 3.0, 12000.0: 0.0, 13000.0: -1.0, 14000.0: 0.0}
    excess |= {15000.0: 1.0, 16000.0: 0.0, 20000.0: -5.0}
    ceiling = simulated(monkeypatch, lambda m: np.interp(m, list(excess), list(excess.values())))
    assert ceiling.highest.altitude_m == pytest.approx(16000.0, abs=0.2)
    assert ceiling.highest.excess_time_h > 0.0
    # The search for the peak ends within 1 m, where the excess time is 1 mm per hour short.
    assert ceiling.best.altitude_m == pytest.approx(7300.0, abs=2.0)


def test_jump_of_the_excess_time_is_found_on_its_feasible_side(monkeypatch):
    # Where a day's gain turns into a loss, excess time falls from hours to minus hours at once.
    ceiling = simulated(monkeypatch, lambda m: 5.0 if m <= 8123.4 else -3.0)
    assert ceiling.highest.altitude_m <= 8123.4
    # The search ends within a decimetre and steps back by another.
    assert ceiling.highest.altitude_m == pytest.approx(8123.4, abs=0.5)


def test_endless_sunlight_has_a_ceiling_too():
    # Polar summer: the modules carry the aircraft round the clock, so that excess time is infinite.
    where = mission(latitude_deg=85.0, dates={"on": "06-21"}, altitude_m=0.0)
    ceiling = highest_perpetual_altitude(AS2, where, step_m=1000.0, highest_m=32000.0)
    assert np.isinf(ceiling.best.excess_time_h)
    assert ceiling.highest is not None


def test_scan_has_both_ends_and_round_altitudes():
    assert scanned_altitudes_m(536.0, 2000.0, 500.0) == [536.0, 1000.0, 1500.0, 2000.0]
    assert scanned_altitudes_m(500.0, 1100.0, 500.0) == [500.0, 1000.0, 1100.0]
    assert scanned_altitudes_m(-100.0, 50.0, 500.0) == [-100.0, 0.0, 50.0]
    assert scanned_altitudes_m(0.0, 10.0, 500.0) == [0.0, 10.0]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"highest_m": 536.0}, "highest_m must be above"),
        ({"highest_m": float("nan")}, "highest_m must be above"),
        ({"step_m": 0.0}, "step_m must be above 0"),
    ],
)
def test_searches_without_extent_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        highest_perpetual_altitude(AS2, mission(), **options)


def test_aircraft_too_heavy_to_fly_at_any_altitude_is_said_to_be():
    whale = builders.aircraft(
        "atlantiksolar-design", "airframe.structure.calibration=60", "airframe.wingspan_m=12"
    )
    with pytest.raises(ImpossibleDesignError, match="at any altitude"):
        highest_perpetual_altitude(whale, mission(), step_m=5000.0)
