from dataclasses import replace

import numpy as np
import pytest
from weather_files import clear_record

from missions.library import load_mission
from missions.weather.files import load_weather
from missions.weather.site import mission_at_site
from sizing.altitude import climb_days
from sizing.altitude.climb_run import Stored
from sizing.library import load_aircraft
from sizing.mass_budget import design_of
from sizing.weather_run import WeatherDays, weather_performance

AS2 = load_aircraft("atlantiksolar-as2")
COLD = load_aircraft("atlantiksolar-as2", ["battery.temperature={}"])
TWIN = load_aircraft("twin-boom-design")
STEP_S = 1800.0


def mission_with(record, climb_m, strategy="surplus"):
    mission = load_mission("rafz-july")
    mission, _ = mission_at_site(mission, record, chosen=False)
    if climb_m is None:
        return mission
    climb = {"ceiling_m": mission.altitude_m + climb_m, "strategy": strategy}
    return load_mission(
        "rafz-july",
        {
            "latitude_deg": mission.latitude_deg,
            "longitude_deg": mission.longitude_deg,
            "altitude_m": mission.altitude_m,
            "climb": climb,
        },
    )


def changing(days=30, first="2001-03-10", seed=2):
    """Days of clouds and of cold, each with its own share of the light."""
    record = clear_record(days, first=first, interval_s=STEP_S)
    day = ((record.start_s - record.start_s[0]) // 86400.0).astype(int)
    drawn = np.random.default_rng(seed)
    share = (1.0 - 0.8 * drawn.random(days + 1) ** 2)[day]
    light = {name: share * getattr(record, name) for name in ("ghi", "dni", "dhi")}
    return replace(record, temperature_c=drawn.uniform(-10.0, 25.0, days + 1)[day], **light)


RECORD = changing()


@pytest.mark.parametrize(
    ("aircraft", "near"),
    # Tables of a propulsion at its operating point are known to 1e-4 of its power.
    [(AS2, 1e-9), (COLD, 1e-9), (TWIN, 1e-4)],
)
def test_with_the_ceiling_at_the_floor_it_is_the_flight_at_one_altitude(aircraft, near):
    mission = mission_with(RECORD, 0.0)
    done = weather_performance(aircraft, mission, RECORD, step_s=STEP_S)
    climbs, level = done.recorded, done.constant
    assert 5 < np.count_nonzero(level.closes) < 25
    assert climbs.closes.tolist() == level.closes.tolist()
    assert climbs.outlasts.tolist() == level.outlasts.tolist()
    assert climbs.state_of_charge() == pytest.approx(level.state_of_charge(), abs=near)
    assert climbs.dawn_h == pytest.approx(level.dawn_h, abs=10.0 * near)
    assert climbs.dawn_state_of_charge == pytest.approx(level.dawn_state_of_charge, abs=near)
    assert climbs.endurance_h == pytest.approx(level.endurance_h, rel=10.0 * near)
    assert climbs.solar_power_w == pytest.approx(level.solar_power_w, abs=1e-9)


def days_of(aircraft, climb_m, strategy="surplus"):
    mission = mission_with(RECORD, climb_m, strategy)
    days = WeatherDays.of(aircraft, mission, RECORD, step_s=STEP_S)
    design = design_of(aircraft, mission)
    store = days.store(design.battery_energy_wh)
    return days.climbing(days.climbers(design), store, days.aloft())


@pytest.mark.parametrize("strategy", ["surplus", "battery_full"])
@pytest.mark.parametrize("aircraft", [AS2, COLD])
def test_all_days_at_once_are_one_day_after_the_other(aircraft, strategy, monkeypatch):
    days = days_of(aircraft, 5000.0, strategy)
    march, full, start = days.march, days.march.store.battery_energy_wh, days.carried.start
    stored = Stored(full[:1], np.zeros(1))
    lacks = np.zeros((2, days.days), bool)
    for day in range(days.days):
        assert start.battery_wh[day] == pytest.approx(stored.battery_wh[0], abs=1e-7)
        assert start.potential_wh[day] == pytest.approx(stored.potential_wh[0], abs=1e-7)
        one = march.select(np.array([day]))
        run = one.empty_run()
        stored = one.end_of_day(stored, run)
        short = run.unserved[:, 0] > 1e-6
        early = one.time_h[:-1] < days.carried.dawn_h[day]
        lacks[:, day] = np.any(short & early), np.any(short & ~early)
        # A battery that is colder on the next day keeps its state of charge.
        ratio = full[min(day + 1, days.days - 1)] / full[day]
        stored = Stored(stored.battery_wh * ratio, stored.potential_wh)
    closed = ~(lacks[1] | np.append(lacks[0, 1:], False))
    assert 5 < np.count_nonzero(closed) < 28
    assert days.carried.closes.tolist() == closed.tolist()
    # However few are marched together.
    monkeypatch.setattr(climb_days, "_AT_ONCE", 3)
    again = replace(days).carried
    assert again.closes.tolist() == closed.tolist()
    for few, many in zip(again.start, start, strict=True):
        assert few == pytest.approx(many, abs=1e-7)


def test_launches_flown_day_by_day_are_each_flown_alone():
    days = days_of(AS2, 3000.0)
    march, full = days.march, days.march.store.battery_energy_wh
    hours, outlasts = days.flight_hours(days.carried.dawn_h)
    assert np.ptp(hours) > 24.0
    for launch in (0, 7, 16, 25):
        # From the node after dawn, full there: the surplus of a part of a step more or less.
        node = int(np.searchsorted(march.time_h, days.carried.dawn_h[launch]))
        stored, flown_h, first = Stored(full[:1], np.zeros(1)), None, np.array([node])
        for day in range(launch, days.days):
            one = march.select(np.array([day]))
            run = one.empty_run()
            stored = one.end_of_day(stored, run, first)
            short = run.unserved[:, 0] > 1e-6
            short[: int(first[0])] = False
            first = np.zeros(1, int)
            if short.any():
                flown_h = 24.0 * (day - launch) + one.time_h[np.argmax(short)]
                break
        if flown_h is None:
            assert outlasts[launch]
            continue
        expected = flown_h - days.carried.dawn_h[launch]
        assert not outlasts[launch]
        assert hours[launch] == pytest.approx(expected, abs=march.time_h[1] + 1e-6)


def test_no_energy_is_lost():
    days = days_of(AS2, 5000.0)
    march, start = days.march, days.carried.start
    run = march.empty_run()
    end = march.end_of_day(start, run)
    eta_charge, eta_discharge = march.store.charge_efficiency, march.store.discharge_efficiency
    spent = (
        24.0 * march.levels.constant_power_w
        + run.motor_wh.sum(axis=0)
        + run.charged.sum(axis=0) / eta_charge
        + (run.left_over - run.climb).sum(axis=0)
    )
    given = run.solar_wh + eta_discharge * run.drawn + run.unserved
    assert given.sum(axis=0) == pytest.approx(spent, rel=1e-9)
    charged = start.battery_wh + (run.charged - run.drawn).sum(axis=0)
    risen = start.potential_wh + (run.lifted - run.sunk).sum(axis=0)
    assert end.battery_wh == pytest.approx(charged, abs=1e-7)
    assert end.potential_wh == pytest.approx(risen, abs=1e-7)
    assert run.lifted.sum() > 100.0


def test_climbing_on_surplus_closes_every_day_of_a_year_that_level_flight_closes():
    weather = load_weather("colorado-2023")
    found = {}
    for strategy in ("surplus", "battery_full"):
        mission = mission_with(weather, 4000.0, strategy)
        found[strategy] = done = weather_performance(AS2, mission, weather, step_s=STEP_S)
        assert not np.any(done.constant.closes & ~done.recorded.closes)
        assert np.all(done.recorded.endurance_h > done.constant.endurance_h - 1e-6)
        highest_m = done.recorded.altitude_m.max(axis=1)
        assert highest_m.max() == pytest.approx(mission.climb.ceiling_m, abs=1e-6)
    surplus, full = (one.recorded.closes.sum() for one in found.values())
    assert surplus >= full > 0
    assert surplus > found["surplus"].constant.closes.sum()
