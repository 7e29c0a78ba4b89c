"""Station keeping: how fast an aircraft flies perpetually, and the share of the time it stays."""

import numpy as np
import pytest
from builders import AS2, DESIGN, aircraft, mission
from plain_days import parabolic_power_w
from wind_tables import winds_file

from missions.air import standard_air
from missions.mission import Scenarios
from sizing import load_aircraft, operating_point, size
from sizing.day.light import UNCORRECTED_CAM, solar_day
from sizing.design import FlightConditions, variables_of
from sizing.mass_budget import design_of, parametric_design
from sizing.performance import fly, performance
from sizing.program.size import size_aircraft
from sizing.station import FASTEST, faster_flight, station_keeping

CELLS = Scenarios(np.array([20.0, 40.0, 50.0]), np.array([166, 166, 166]))


def in_winds(folder, median, strong):
    """Mission near the ground in a made-up wind, the same everywhere."""
    speeds = {50: median, 90: strong}
    path = winds_file(folder, lambda x, z, m, percentile: speeds[percentile], percentiles=speeds)
    return mission(wind={"percentile": 90.0, "file": path})


def test_share_goes_through_the_percentiles_of_a_table(tmp_path):
    table = in_winds(tmp_path, 6.0, 12.0).wind_statistics
    share = table.table().share_below([0.0, 6.0, 9.0, 12.0, 1e3], 47.0, 500.0, 6)
    assert share == pytest.approx([0.0, 0.5, 0.7, 0.9, 1.0])


def test_power_of_faster_flight_is_that_of_the_parabolic_polar():
    """Sky-Sailor's polar by hand, at 1.1 of the airspeed."""
    plane = aircraft("sky-sailor", "airframe.propulsion.climb_power_ratio=5")
    where = mission(altitude_m=500.0)
    design = design_of(plane, where)
    airspeeds, powers = faster_flight(plane, where, design)
    assert airspeeds[0] == pytest.approx(float(design.airspeed_m_per_s))
    assert airspeeds[-1] == pytest.approx(FASTEST * airspeeds[0])
    v = float(airspeeds[10])
    by_hand = parabolic_power_w(plane, design, standard_air(500.0), v)
    assert np.interp(v, airspeeds, powers) == pytest.approx(by_hand, rel=1e-6)


def test_an_aircraft_slower_than_that_of_least_power_may_fly_faster_for_less():
    polar = "airframe.aerodynamics"
    slow = [f"{polar}.lift_coefficient=1.5", f"{polar}.maximum_lift_coefficient=1.8"]
    broad = ["airframe.aspect_ratio=8", "airframe.propulsion.climb_power_ratio=5"]
    plane = aircraft("sky-sailor", *slow, *broad)
    where = mission(altitude_m=500.0)
    design = design_of(plane, where)
    _, powers = faster_flight(plane, where, design)
    assert powers[0] < float(design.propulsion_power_w)
    assert np.all(np.diff(powers) >= 0.0)


def test_the_simulator_confirms_the_fastest_airspeed(tmp_path):
    where = in_winds(tmp_path, 6.0, 12.0)
    result = station_keeping(DESIGN, where, scenarios=CELLS)
    design = design_of(DESIGN, where)
    airspeeds, powers = faster_flight(DESIGN, where, design)
    day = solar_day(DESIGN, where, scenarios=CELLS)
    assert np.all(result.airspeed_m_per_s > airspeeds[0])
    assert not result.at_end.any()
    for factor, perpetual in ((1.0, True), (1.002, False)):
        faster = design._replace(
            propulsion_power_w=np.interp(result.airspeed_m_per_s * factor, airspeeds, powers),
            airspeed_m_per_s=result.airspeed_m_per_s * factor,
            battery_energy_wh=np.full(3, design.battery_energy_wh),
        )
        perf = fly(DESIGN, where, UNCORRECTED_CAM, faster, day, paired=True)
        assert perf.cycle.perpetual.tolist() == [perpetual] * 3


def holding(where):
    update = {"wind_statistics": where.wind_statistics.model_copy(update={"hold_station": True})}
    return where.model_copy(update=update)


def test_only_a_wind_above_the_own_airspeed_takes_more_power(tmp_path):
    speed_m_per_s = float(design_of(DESIGN, mission()).airspeed_m_per_s)
    calm, windy = (in_winds(tmp_path, 1.0, speed_m_per_s * ratio) for ratio in (0.99, 1.15))
    held, free = (performance(DESIGN, where) for where in (holding(calm), calm))
    assert np.array_equal(held.load_w, free.load_w)
    airspeeds, powers = faster_flight(DESIGN, windy, design_of(DESIGN, windy))
    held, free = (performance(DESIGN, where) for where in (holding(windy), windy))
    extra = np.interp(1.15 * speed_m_per_s, airspeeds, powers) - powers[0]
    # Linear between airspeeds 1 % apart, of a power that grows with the cube.
    assert held.nominal_load_w - free.nominal_load_w == pytest.approx(extra, rel=1e-3)


def test_flight_as_fast_as_the_wind_has_the_load_of_the_moment(tmp_path):
    """The exact chain at the airspeed of the wind, the thermals and the voltage of the hour."""
    twin, where = load_aircraft("twin-boom-design"), holding(in_winds(tmp_path, 4.0, 11.0))
    wind = float(where.scenario_winds_m_per_s()[0])
    turbulence = where.turbulence.model_copy(update={"all_day": 0.05, "thermal": 0.3})
    where = where.model_copy(update={"turbulence": turbulence})
    flight = performance(twin, where)
    assert np.isfinite(flight.load_w).all()
    design = flight.design
    parts = getattr(twin.airframe, "propulsion", None)
    # At the same mass: the lift coefficient goes with the inverse square of the airspeed.
    speed = float(design.airspeed_m_per_s)
    polar = twin.airframe.aerodynamics  # type: ignore[union-attr]  # parametric
    slow = polar.flight_lift_coefficient * (speed / wind) ** 2
    variables = variables_of(twin)._replace(lift_coefficient=slow)
    faster = parametric_design(twin, where, variables, design.total_mass_kg)
    assert float(faster.airspeed_m_per_s) == pytest.approx(wind)
    thrust_w = float(faster.propulsion_power_w) * faster.chain.efficiency
    day = flight.day
    half = (day.sunset_h[0] - day.sunrise_h[0]) / 2.0
    load = 1.05 + 0.3 * np.maximum(1.0 - np.abs(day.time_h - 12.0) / half, 0.0)
    air = FlightConditions.of(where, twin).air
    hours = slice(0, None, 24)
    point = operating_point(
        *(parts.propulsor, (thrust_w * load / wind / parts.propulsors)[hours], wind, air),
        twin.battery.nominal_voltage_v,
    )
    power_w = flight.load_w[0, hours] - float(design.constant_power_w)
    assert power_w == pytest.approx(parts.propulsors * point.bus_power_w, rel=3e-5)


def test_what_is_sized_to_hold_its_place_does_so(tmp_path):
    """The fastest perpetual flight of the optimum, found without the program, is the wind."""
    where = holding(in_winds(tmp_path, 4.0, 12.0))
    result = size(DESIGN, where, with_cross_check=True)
    assert result.feasible
    assert result.cross_check.cross_checked
    sized = result.sized_aircraft()
    kept = station_keeping(sized, where)
    # Excess time has a cushion of some minutes; half a per cent of airspeed is one and a half of
    # power.
    assert kept.airspeed_m_per_s.min() == pytest.approx(12.0, rel=5e-3)
    assert kept.share.min() >= 0.9 - 1e-6
    slow = size_aircraft(DESIGN, where.in_wind(12.0), explain=False)
    # An aircraft that is always as fast as the wind is heavier, if there is one at all.
    assert slow.design is None or slow.design.total_mass_kg > design_of(sized, where).total_mass_kg


def test_the_rated_power_ends_the_airspeed(tmp_path):
    where = holding(in_winds(tmp_path, 4.0, 200.0))
    assert float(performance(DESIGN, where).cycle.excess_time_h.max()) <= 0.0
    study = size(DESIGN, where)
    assert not study.feasible
    missed = {violation.requirement for violation in study.result.violations}
    assert missed & {"power_against_wind", "energy_balance", "battery_capacity"}


def test_what_cannot_be_answered_is_refused(tmp_path):
    with pytest.raises(ValueError, match="is a measured aircraft, whose power is known at one"):
        station_keeping(AS2, in_winds(tmp_path, 6.0, 12.0))
    with pytest.raises(ValueError, match="lacks wind"):
        station_keeping(DESIGN, mission(wind_m_per_s=5.0))
