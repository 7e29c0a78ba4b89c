from dataclasses import replace

import numpy as np
import pytest
from weather_files import SITE, clear_record
from wind_tables import winds_file

from missions.air import air_at
from missions.library import load_mission
from missions.weather.files import mission_at_site
from missions.weather.light import DayAxis, light_at_altitude
from missions.weather.record import Site, longest_run
from sizing.day.light import SolarModel
from sizing.day.record import weather_performance
from sizing.day.record_conditions import WeatherDays, load_of_days
from sizing.day.replay import calendar_run
from sizing.design import FlightConditions
from sizing.held_station import held_flight
from sizing.library import load_aircraft
from sizing.mass_budget import level_flight
from sizing.performance import performance, perpetual_days
from sizing.results.weather import wait_for_window

AS2 = load_aircraft("atlantiksolar-as2")
# Profile drag whatever the Reynolds number.
NO_VISCOSITY = {"airframe.aerodynamics.reynolds_exponent": 0.0}


def mission_at(record, **overrides):
    mission = load_mission("rafz-july", overrides)
    return mission_at_site(mission, record, chosen=False)[0]


def test_a_clear_record_is_the_flight_on_the_calendar():
    record = clear_record(5, first="2001-07-14", interval_s=300.0)
    mission = mission_at(record)
    flown = weather_performance(AS2, mission, record).recorded
    launch = {"date": "07-14", "time_local": "00:00", "utc_offset_h": SITE.utc_offset_h}
    launch |= {"state_of_charge": 1.0, "duration_h": 119.0}
    calendar = load_mission("rafz-july", {"launch": launch, "longitude_deg": SITE.longitude_deg})
    calendar = calendar.model_copy(
        update={"latitude_deg": SITE.latitude_deg, "altitude_m": mission.altitude_m}
    )
    replayed = calendar_run(AS2, calendar)
    clock_h = (
        np.concatenate([24.0 * day + flown.axis.time_h[:-1] for day in range(len(flown.axis))])
        + 2.5 / 60.0
    )
    charge = flown.state_of_charge()[:, :-1].reshape(-1)
    # Launched two and a half minutes apart, they are the same from the first full charge on.
    inside = (clock_h > 20.0) & (clock_h < 119.0)
    there = np.interp(clock_h[inside], replayed.clock_h, replayed.state_of_charge)
    # Nodes of five minutes against one: the largest difference is at the corners of full charge.
    assert charge[inside] == pytest.approx(there, abs=2e-3)


@pytest.fixture
def windy_file(tmp_path):
    """Table of winds of 11 m/s, 1.3 times the airspeed of the shipped design."""
    return winds_file(tmp_path, lambda *_: 11)


def test_a_held_place_is_flown_as_fast_as_the_wind_in_the_air_of_each_day(windy_file):
    design = load_aircraft("atlantiksolar-design", NO_VISCOSITY)
    wind = {"percentile": 95.0, "hold_station": True, "file": windy_file}
    record = clear_record(5, first="2001-07-14", interval_s=300.0)
    mission = mission_at(record, wind=wind)
    day = replace(record, temperature_c=None)
    flown = weather_performance(design, mission, day).recorded
    assert np.allclose(flown.load_w, performance(design, mission).load_w[0, 0], rtol=1e-12)
    for warm_c in (-10.0, 40.0):
        other = replace(record, temperature_c=np.full(len(record.start_s), warm_c))
        done = weather_performance(design, mission, other)
        air_c = float(done.days.mean_air_c[0])
        air = mission.model_copy(update={"air": type(mission.air)(ambient_temperature_c=air_c)})
        there = performance(design, air).load_w[0, 0]
        # The structure that is sized in the other air is up to 0.1 % heavier or lighter.
        assert np.allclose(done.recorded.load_w, there, rtol=2e-3)
        assert abs(there / flown.load_w[0, 0] - 1.0) > 0.005


def test_a_held_place_is_flown_with_the_efficiency_of_the_moment(windy_file):
    # The exact chain at the thrust of the moment, point by point; 11 m/s against 8.4 of its own.
    twin = load_aircraft("twin-boom-design")
    record = replace(clear_record(2, first="2001-07-14", interval_s=3600.0), temperature_c=None)
    air_c = np.linspace(10.0, 30.0, len(record.start_s))
    changes = {"wind": {"percentile": 95.0, "hold_station": True, "file": windy_file}}
    mission = mission_at(record, **changes, turbulence={"all_day": 0.1, "thermal": 0.3})
    flown = weather_performance(twin, mission, replace(record, temperature_c=air_c))
    design, own_air = flown.design, mission.air_state()
    chain = twin.airframe.propulsion.sized(*design.variables.of_propulsion)
    run, warm_k = flown.recorded, flown.days.light.temperature_c[flown.recorded.axis.nodes] + 273.15
    assert np.ptp(warm_k) > 15.0
    volts = twin.battery.nominal_voltage_v
    for day, node in ((0, 10), (0, 150), (0, 280), (1, 0), (1, 144), (1, 200)):
        # The lift coefficient of the wind in the day's mean air, in that of the hour.
        mean_k = float(np.mean(warm_k[day]))
        ratio = 11.0 / design.airspeed_m_per_s / np.sqrt(mean_k / own_air.temperature_k)
        own = twin.airframe.aerodynamics.flight_lift_coefficient
        variables = design.variables._replace(lift_coefficient=own / ratio**2)
        conditions = FlightConditions.of(mission, twin)
        level, level_w, speed = level_flight(twin, conditions, variables, design.total_mass_kg)
        faster = np.sqrt(warm_k[day, node] / own_air.temperature_k)
        assert speed * np.sqrt(mean_k / own_air.temperature_k) == pytest.approx(11.0, rel=1e-9)
        there = air_at(warm_k[day, node], own_air.pressure_pa)
        load = load_of_days(mission, run.axis)[day, node]
        thrust_w = level_w * level.efficiency * faster * load
        exact_w = chain.bus_power_w(chain.shaft(thrust_w, speed * faster, there), volts)
        # Polynomials of load and temperature: 1e-4.
        expected = float(exact_w) + float(design.constant_power_w)
        assert run.load_w[day, node] == pytest.approx(expected, rel=2e-4)
    # With the efficiency of each airspeed alone it would be up to 3 % off.
    days = WeatherDays.of(twin, mission, replace(record, temperature_c=air_c))
    held_w = held_flight(twin, mission, design, days.wind_m_per_s).propulsion_power_w
    ratio = load_of_days(mission, run.axis) * np.sqrt(warm_k / own_air.temperature_k)
    constant_w = held_w[:, np.newaxis] * ratio + design.constant_power_w
    assert np.abs(constant_w / run.load_w - 1.0).max() > 0.02


def test_a_wind_too_strong_for_the_propulsion_closes_no_day(tmp_path):
    record = clear_record(4, first="2001-07-30", interval_s=3600.0)
    strong_in_july = winds_file(tmp_path, lambda x, z, month, p: 18 if month == 7 else 5)
    wind = {"percentile": 95.0, "hold_station": True, "file": strong_in_july}
    run = weather_performance(
        load_aircraft("twin-boom-design"), mission_at(record, wind=wind), record
    )
    load_w = run.recorded.load_w
    assert np.all(load_w[:2] > 1e9)
    assert np.all(load_w[2:] < 100.0)
    assert not run.recorded.closes[:2].any()


def test_a_clear_year_closes_on_the_days_of_the_season():
    record = clear_record(365, first="2001-01-01")
    mission = mission_at(record)
    done = weather_performance(AS2, mission, record)
    season = set(perpetual_days(AS2, mission, SITE.latitude_deg).tolist())
    for run in (done.recorded, done.clear):
        found = set(run.axis.day_of_year[run.closes].tolist())
        # At the season's ends a day is kept up, or let down, by the charge of the days before.
        assert len(found ^ season) <= 4
    assert np.array_equal(done.recorded.axis.day_of_year, np.arange(1, 366))
    assert done.recorded.longest_run_days == len(done.recorded.closes.nonzero()[0])


@pytest.mark.long
@pytest.mark.parametrize(
    ("longitude_deg", "offset_h"),
    [
        *[(77.2, 5.5), (85.3, 5.75), (174.0, 12.0), (180.0, 12.0), (-180.0, -12.0), (179.9, 12.0)],
        *[(-176.5, 12.75), (-157.4, 14.0), (-171.8, 13.0), (76.0, 8.0), (-109.0, -7.0), (0.0, 0.0)],
    ],
)
def test_every_day_has_the_date_of_its_place(longitude_deg, offset_h):
    site = Site("", -20.0, longitude_deg, 100.0, offset_h)
    # From mid-year, over a leap day.
    record = clear_record(366, first="2003-07-14", site=site, interval_s=10800.0)
    axis = DayAxis.of(light_at_altitude(record, 500.0, step_s=10800.0))
    assert len(axis) in (365, 366)
    assert np.all(np.diff(axis.date).astype(int) == 1)
    # Independent: the clock of the place at the day's noon.
    noon = axis.time_s + 3600.0 * (12.0 - axis.midnight_h + offset_h)
    assert np.array_equal(axis.date, noon.astype("datetime64[s]").astype("datetime64[D]"))
    assert axis.date[0] == np.datetime64("2003-07-14")
    assert np.abs(axis.midnight_h).max() <= 3.3  # nodes and the equation of time
    leap = axis.date == np.datetime64("2004-02-29")
    assert axis.day_of_year[leap].tolist() == [59]
    assert axis.day_of_year[0] == 195


@pytest.mark.parametrize(
    ("longitude_deg", "first"), [(-105.0, "2001-01-01"), (120.0, "2001-01-02"), (-180.0, None)]
)
def test_records_in_universal_time_have_the_days_of_their_longitude(longitude_deg, first):
    site = Site("", 40.0, longitude_deg, 100.0, 0.0)
    record = clear_record(365, first="2001-01-01", site=site, interval_s=10800.0)
    axis = DayAxis.of(light_at_altitude(record, 500.0, step_s=10800.0))
    assert len(axis) == 364
    assert np.abs(axis.midnight_h).max() < 1.8
    if first is not None:
        assert axis.date[0] == np.datetime64(first)


def test_cold_air_carries_better_and_keeps_the_modules_cool():
    runs = []
    for temperature_c in (-10.0, 30.0):
        record = clear_record(3, first="2001-07-14", temperature_c=np.full(72, temperature_c))
        runs.append(weather_performance(AS2, mission_at(record), record).recorded)
    cold, hot = runs
    assert cold.load_w.mean() < hot.load_w.mean()
    # Level power goes with the root of the absolute temperature, avionics do not.
    lapse = 0.0065 * (536.0 - SITE.altitude_m)
    ratio = np.sqrt((273.15 - 10.0 - lapse) / (273.15 + 30.0 - lapse))
    fixed = AS2.power.avionics_w
    powers = [run.load_w[0, 0] - fixed for run in runs]
    assert powers[0] / powers[1] == pytest.approx(ratio, rel=0.02)
    # 0.3 % per kelvin, of which radiation takes back a sixth.
    assert cold.solar_power_w.max() / hot.solar_power_w.max() == pytest.approx(1.10, abs=0.01)


@pytest.mark.parametrize("model", ["VM", "FM"])
def test_attitude_models_fly_through_records(model):
    record = clear_record(2, first="2001-07-14")
    mission = mission_at_site(load_mission("rafz-loiter"), record, chosen=False)[0]
    done = weather_performance(AS2, mission, record, SolarModel(model), step_s=1800.0)
    horizontal = weather_performance(AS2, mission, record, step_s=1800.0)
    sums = [run.recorded.solar_power_w.sum() for run in (done, horizontal)]
    # The report: CAM is 5 % above the flight, VM and FM 2 % below.
    assert 0.85 < sums[0] / sums[1] < 1.0
    # Of a clear record they are what they are under the clear sky.
    assert done.recorded.solar_power_w.sum() == pytest.approx(
        done.clear.solar_power_w.sum(), rel=5e-3
    )


def test_runs_and_windows():
    closes = np.array([0, 1, 1, 0, 1, 1, 1, 0], bool)
    assert longest_run(closes) == 3
    assert longest_run(np.zeros(3, bool)) == 0
    assert wait_for_window(closes, 1).tolist() == [1, 0, 0, 1, 0, 0, 0, np.inf]
    assert wait_for_window(closes, 3).tolist() == [4, 3, 2, 1, 0, np.inf, np.inf, np.inf]
    assert np.isinf(wait_for_window(closes, 20)).all()
    with pytest.raises(ValueError, match="at least one day"):
        wait_for_window(closes, 0)
    record = clear_record(1, site=Site("", 40.0, 179.0, 0.0, 0.0))
    with pytest.raises(ValueError, match="shorter than a day"):
        weather_performance(AS2, mission_at(record), record)


def test_a_battery_in_a_record_has_the_temperature_of_each_day():
    record = clear_record(4, first="2001-07-14", interval_s=3600.0)
    air_c = np.repeat([25.0, 0.0, -10.0, 25.0], 24)
    record = replace(record, temperature_c=air_c)
    craft = load_aircraft("atlantiksolar-as2", ["battery.temperature={}"])
    mission = mission_at(record, air={"ambient_temperature_c": 25.0})
    new = weather_performance(AS2, mission, record, step_s=1800.0).recorded
    run = weather_performance(craft, mission, record, step_s=1800.0).recorded
    full_wh = run.store.battery_energy_wh / new.store.battery_energy_wh
    # Days are cut at solar midnight, at most an hour from that of the clock.
    assert full_wh == pytest.approx([1.0, 0.8, 0.75, 1.0], abs=0.02)
    assert np.all(full_wh <= 1.0)
    charge = run.state_of_charge()
    # The last node of a day is the first of the next.
    assert charge[1:, 0] == pytest.approx(charge[:-1, -1], abs=1e-12)
    assert np.all((charge >= 0.0) & (charge <= 1.0 + 1e-12))
    assert np.all(charge[1:3].min(axis=1) < new.state_of_charge()[1:3].min(axis=1))
    assert np.array_equal(new.load_w, run.load_w)


def test_the_heater_of_a_cold_day_is_load():
    record = clear_record(3, first="2001-07-14")
    record = replace(record, temperature_c=np.full(72, -10.0))
    heater = "battery.temperature={held_c: 10, heat_loss_w_per_k: 0.4}"
    mission = mission_at(record, air={"ambient_temperature_c": 5.0})
    done = [
        weather_performance(craft, mission, record, step_s=1800.0)
        for craft in (AS2, load_aircraft("atlantiksolar-as2", [heater]))
    ]
    heater_w = done[1].recorded.load_w - done[0].recorded.load_w
    # A little colder than at the site, 45 m below.
    lacking_k = 10.0 - float(done[0].days.light.temperature_c.mean())
    assert 20.0 < lacking_k < 20.5
    assert heater_w == pytest.approx(np.full((3, 49), 0.4 * lacking_k))
