import json
from dataclasses import replace

import numpy as np
import pytest
from weather_files import clear_record

import sizing
from missions.files.errors import InputError
from missions.library import load_mission
from missions.weather.record import Site
from sizing.library import load_aircraft

AS2 = load_aircraft("atlantiksolar-as2")


@pytest.fixture(scope="module")
def analysis():
    record = clear_record(
        40,
        first="2001-07-14",
        wind_m_per_s=np.full(960, 3.0),
        temperature_c=np.full(960, 20.0),
        repairs=("2 rows filled between their neighbours",),
    )
    dim = np.where(np.arange(960) // 24 == 20, 0.1, 1.0)  # one dark day
    light = {name: getattr(record, name) * dim for name in ("ghi", "dni", "dhi")}
    return sizing.analyse_weather(AS2, load_mission("rafz-july"), replace(record, **light))


def test_the_record_is_json_and_agrees_with_the_frame(analysis):
    record = json.loads(json.dumps(analysis.to_dict(), allow_nan=False))
    frame = analysis.to_frame()
    assert record["days"] == len(frame) == 40
    assert record["days_that_close"] == frame["closes"].sum() == 39
    assert record["clear_sky_days_that_close"] == frame["clear_sky_closes"].sum() == 40
    assert record["longest_run_days"] == 20
    low, middle, high = np.percentile(frame["endurance_h"], [10, 50, 90])
    assert record["endurance_h"] == {"p90": low, "p50": middle, "p10": high}
    # Days of 8 to 17 h: whoever flies for so long from dawn sees the sunset, or does not.
    hours = frame["endurance_h"]
    assert (hours >= 17.0).mean() <= record["flown_to_sunset_share"] <= (hours >= 8.0).mean()
    assert record["site"]["latitude_deg"] == 46.8
    assert record["share_of_clear_sky_light"] == pytest.approx(1.0 - 0.9 / 40, abs=2e-3)
    assert record["wind_above_airspeed_share"] == 0.0
    assert {w["days"]: w["starts"] for w in record["windows"]}[7] == 14 + 13
    # From the dark day on: a full battery carries through it.
    assert record["launches_that_outlast_the_record"] == 20


def test_the_text_says_what_counts(analysis):
    text = str(analysis.at_level(2))
    assert "39 of 40 days close" in text.split("month by month")[0].replace("\n", " ")
    assert "2 rows filled between their neighbours" in text
    assert max(map(len, text.split("\n"))) <= 80
    assert repr(analysis).startswith("<WeatherAnalysis: atlantiksolar-as2 in the weather of Some")
    assert "<table>" in analysis._repr_html_()


def test_subjects_are_checked_at_the_call():
    mission = load_mission("rafz-july")
    with pytest.raises(TypeError, match=r"expected Weather \(got str\); missions.load_weather"):
        sizing.analyse_weather(AS2, mission, "file.epw")
    with pytest.raises(ValueError, match="unknown model 'XX'"):
        sizing.analyse_weather(AS2, mission, clear_record(2), model="XX")
    far = clear_record(2, site=Site("Far", -30.0, 150.0, 100.0, 10.0))
    with pytest.raises(InputError, match="km from the mission rafz-july"):
        sizing.analyse_weather(AS2, mission, far)


def test_a_missions_clearness_is_said_to_play_no_part():
    hazy = load_mission("rafz-july", {"clearness": 0.5})
    plain = load_mission("rafz-july")
    record = clear_record(3, first="2001-07-14")
    one, other = (sizing.analyse_weather(AS2, m, record) for m in (hazy, plain))
    assert any("clearness plays no part" in note for note in one.notes)
    assert np.array_equal(
        one.performance.recorded.solar_power_w, other.performance.recorded.solar_power_w
    )


def test_the_battery_and_what_is_outside_of_a_range_are_told_over_the_days():
    air_c = np.repeat([-30.0, 5.0, 30.0], 24)
    record = clear_record(3, first="2001-07-14", temperature_c=air_c)
    mission = load_mission("rafz-july")
    new = sizing.analyse_weather(AS2, mission, record).to_dict()
    assert new["battery_condition"] is None
    # A battery without temperature is told of the day that is colder than its shipped table.
    assert [one["quantity"] for one in new["extrapolations"]] == ["air_temperature_c"]
    keys = ["battery.temperature={ambient_offset_k: 1}", "battery.ageing={cycles: 100}"]
    craft = load_aircraft("atlantiksolar-as2", keys)
    analysis = sizing.analyse_weather(craft, mission, record, correction="report")
    told = analysis.to_dict()["battery_condition"]
    days_c = analysis.performance.days.mean_air_c
    capacity = [float(craft.battery.capacity_fraction(day)) for day in days_c]
    assert told["pack_temperature_c"]["lowest"] == pytest.approx(days_c.min() + 1.0)
    assert told["capacity_fraction"] == {
        "lowest": min(capacity),
        "mean": pytest.approx(np.mean(capacity)),
        "highest": max(capacity),
    }
    assert (told["cycles"], told["heater_power_w"]["highest"]) == (100.0, 0.0)
    found = {one.quantity: one for one in analysis.extrapolations}
    assert found["pack_temperature_c"].value == pytest.approx(days_c.min() + 1.0)
    assert (found["pack_temperature_c"].count, found["pack_temperature_c"].of) == (1, 3)
    text = " ".join(str(analysis.at_level(2)).split())
    assert "cycles 100 age in months 0" in text
    assert "(worst; 1 of 3 days)" in text
