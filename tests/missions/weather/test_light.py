import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from weather_files import SITE, clear_record

from missions.files.errors import InputError
from missions.library import load_mission
from missions.weather.files import mission_at_site
from missions.weather.light import light_at_altitude, wind_ratio
from missions.weather.record import Site
from solar.clearsky import clear_sky


@given(
    shares=st.lists(st.floats(0.0, 1.0), min_size=48, max_size=48),
    latitude=st.floats(-65.0, 65.0),
    step_s=st.sampled_from([300.0, 600.0, 3600.0]),
)
def test_the_mean_of_every_interval_is_kept(shares, latitude, step_s):
    record = clear_record(2, site=Site("", latitude, 0.0, 100.0, 0.0))
    factor = np.array(shares)
    dimmed = clear_record(2, site=record.site, dni=record.dni * factor, dhi=record.dhi * factor)
    light = light_at_altitude(dimmed, 100.0, step_s=step_s)
    parts = len(light.time_s) // len(dimmed)
    for values, mean in ((light.recorded.dni, dimmed.dni), (light.recorded.dhi, dimmed.dhi)):
        means = values.reshape(-1, parts).mean(axis=1)
        daylight = (light.cos_zenith.reshape(-1, parts) > 0.0).any(axis=1)
        # Less only where it would exceed the light outside the atmosphere, next to the horizon.
        low = light.cos_zenith.reshape(-1, parts).max(axis=1) < 0.1
        assert means[daylight & ~low] == pytest.approx(mean[daylight & ~low], rel=1e-9, abs=1e-9)
        assert np.all(means[daylight] <= mean[daylight] * (1 + 1e-9) + 1e-9)


def test_a_clear_record_is_the_clear_sky_at_any_altitude():
    record = clear_record(2, interval_s=300.0)
    for altitude in (SITE.altitude_m, 3000.0):
        light = light_at_altitude(record, altitude)
        sky = clear_sky(light.day_of_year, SITE.latitude_deg, light.cos_zenith, altitude)
        # The record has means of five minutes, the nodes their middles; low over the horizon the
        # light curves within them.
        high = light.cos_zenith > 0.05
        assert light.recorded.dni[high] == pytest.approx(sky.dni[high], rel=1e-2)
        assert light.recorded.dhi[high] == pytest.approx(sky.dhi[high], rel=1e-2)
        assert np.all(light.recorded.dni[light.cos_zenith <= 0.0] == 0.0)


def test_minutes_are_averaged_over_whole_steps():
    record = clear_record(1, interval_s=60.0)
    light = light_at_altitude(record, SITE.altitude_m)
    assert light.step_h == pytest.approx(1 / 12)
    assert light.recorded.dni.sum() * 5.0 == pytest.approx(record.dni.sum(), rel=1e-4)


# An hour parted into steps of 40 minutes at most has two of half an hour, not one. Minutes averaged
# over 64 of them would be 22.5 intervals a day: each is parted into two.
@pytest.mark.parametrize(
    ("interval_s", "step_s", "minutes"),
    [(3600.0, 3600.0, 60), (3600.0, 2400.0, 30), (3600.0, 1800.0, 30), (60.0, 3840.0, 32)],
)
def test_steps_are_no_longer_than_allowed_and_whole_days(interval_s, step_s, minutes):
    record = clear_record(1, interval_s=interval_s)
    light = light_at_altitude(record, SITE.altitude_m, step_s=step_s)
    assert light.step_h * 60.0 == pytest.approx(minutes)
    if interval_s == 3600.0:
        assert len(light.time_s) == 24 * 60 // minutes
    with pytest.raises(ValueError, match="step_s must be from 1 to 10800"):
        light_at_altitude(record, 500.0, step_s=0.1)


def test_a_temperature_that_rises_evenly_does_so_between_the_rows():
    # A degree an hour, as means of hours: what it is in their middle.
    record = clear_record(1, temperature_c=np.arange(24) + 0.5)
    light = light_at_altitude(record, SITE.altitude_m)
    hour = (light.time_s - record.start_s[0]) / 3600.0
    assert light.temperature_c == pytest.approx(np.clip(hour, 0.5, 23.5), abs=1e-6)


def test_temperature_and_wind_change_with_height_by_their_laws():
    record = clear_record(1, temperature_c=np.full(24, 20.0), wind_m_per_s=np.full(24, 4.0))
    light = light_at_altitude(record, SITE.altitude_m + 100.0)
    assert light.temperature_c == pytest.approx(20.0 - 0.65)
    assert light.wind_m_per_s == pytest.approx(4.0 * 10.0 ** (1 / 7))
    assert wind_ratio(10.0) == 1.0 == wind_ratio(0.0)
    assert wind_ratio(5000.0) == wind_ratio(300.0) > wind_ratio(299.0)


def test_a_default_mission_follows_the_record_and_a_chosen_one_must_be_near():
    mission = load_mission("rafz-july")
    there = clear_record(1, site=Site("Far", -30.0, 150.0, 1500.0, 10.0))
    moved, notes = mission_at_site(mission, there, chosen=False)
    assert moved.latitudes() == [-30.0]
    assert moved.altitude_m == 1620.0
    assert len(notes) == 2
    with pytest.raises(InputError, match=r"16\d{3} km from the mission rafz-july; allowed: up to"):
        mission_at_site(mission, there)
    here = clear_record(1, site=Site("Near", 47.5, 8.5, 900.0, 1.0))
    with pytest.raises(InputError, match=r"altitude_m of 536 is below it; 120 m above .*=1020$"):
        mission_at_site(mission, here)


def test_distances_are_told_of_missions_with_a_longitude_alone():
    there = clear_record(1, site=Site("East", 40.5, 60.0, 100.0, 4.0))
    plain = load_mission("rafz-july").model_copy(update={"longitude_deg": None})
    assert mission_at_site(plain, there)[1] == (
        "the mission has no longitude: its site is at 40.5° N instead of 47.6° N",
    )
    (note,) = mission_at_site(load_mission("rafz-july"), there, chosen=False)[1]
    assert note.endswith("km from the mission's site")


def test_a_moved_mission_keeps_the_weather_of_its_air():
    mission = load_mission("rafz-july")
    there = clear_record(1, site=Site("", 47.0, 8.0, 400.0, 1.0))
    moved, notes = mission_at_site(mission, there)
    assert (moved.altitude_m, notes) == (mission.altitude_m, ())
    assert moved.module_temperature_c() == mission.module_temperature_c()
