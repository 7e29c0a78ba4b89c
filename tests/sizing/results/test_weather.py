import json
from dataclasses import replace

import numpy as np
import pytest
from weather_files import clear_record

import sizing
from missions.files.errors import InputError
from missions.library import load_mission
from missions.weather.files import mission_at_site
from missions.weather.record import Site
from sizing.day.record import weather_performance
from sizing.library import load_aircraft
from sizing.results.weather import WeatherAnalysis

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


# ---- years of a record


STEP_S = 10800.0
ROWS = 8


def years_record(first, last, latitude_deg=46.8):
    """Clear days from a date up to a date, evenly dimmed by a share of their own each."""
    site = Site("Somewhere", latitude_deg, 6.9, 491.0, 0.0)
    year = clear_record(365, first="2001-01-01", interval_s=STEP_S, site=site)
    dates = np.arange(np.datetime64(first), np.datetime64(last))
    of_year = (dates - dates.astype("datetime64[Y]")).astype(int)
    days = of_year - ((of_year >= 59) & _leap(dates))
    random = np.random.default_rng(int(dates[0].astype(int)))
    share = np.repeat(random.uniform(0.4, 1.0, len(dates)), ROWS)
    rows = (days[:, None] * ROWS + np.arange(ROWS)).reshape(-1)
    start_s = dates.astype("datetime64[s]").astype(float)[:, None] + STEP_S * np.arange(ROWS)
    return clear_record(
        1,
        interval_s=STEP_S,
        site=site,
        start_s=start_s.reshape(-1),
        **{name: getattr(year, name)[rows] * share for name in ("ghi", "dni", "dhi")},
    )


def _leap(dates):
    year = dates.astype("datetime64[Y]").astype(int) + 1970
    return ((year % 4 == 0) & (year % 100 != 0)) | (year % 400 == 0)


def analysed(record):
    mission, notes = mission_at_site(load_mission("rafz-july"), record, chosen=False)
    done = weather_performance(AS2, mission, record, step_s=STEP_S)
    return WeatherAnalysis(AS2, done, notes)


def test_years_of_a_record_are_those_of_its_days():
    analysis = analysed(years_record("2002-01-01", "2012-01-01"))
    record, frame = analysis.to_dict(), analysis.to_frame()
    assert len(frame) == 3652
    assert [one["year"] for one in record["years"]] == list(range(2002, 2012))
    assert [one["days"] for one in record["years"]] == [365, 365, 366, 365] * 2 + [365, 365]
    assert frame["date"].tolist().count("02-29") == 2
    for one in record["years"]:
        of_year = frame[frame["year"] == one["year"]]
        assert one["whole"]
        assert one["days_that_close"] == of_year["closes"].sum()
        assert one["clear_sky_days_that_close"] == of_year["clear_sky_closes"].sum()
        runs = "".join("x" if closes else " " for closes in of_year["closes"]).split()
        assert one["longest_run_days"] == max(map(len, runs))
        found = np.percentile(of_year["endurance_h"], [10, 50, 90])
        assert list(one["endurance_h"].values()) == pytest.approx(found)
    closing = sorted(one["days_that_close"] for one in record["years"])
    spread = record["year_to_year"]
    assert spread["whole_years"] == 10
    assert spread["days_that_close"] == {"p90": closing[0], "p50": closing[4], "p10": closing[8]}
    shares = {one["year"]: one["share_of_days_that_close"] for one in record["years"]}
    assert shares[spread["worst_year"]] == min(shares.values()) < max(shares.values())
    assert shares[spread["best_year"]] == max(shares.values())
    assert sum(one["days_that_close"] for one in record["years"]) == record["days_that_close"]
    table = analysis.to_years_frame()
    assert table["endurance_p50_h"].tolist() == [y["endurance_h"]["p50"] for y in record["years"]]
    text = str(analysis.at_level(2))
    assert f"worst year {spread['worst_year']}" in " ".join(text.split())
    assert "year by year" in text
    assert max(map(len, text.split("\n"))) <= 80


def test_parts_of_years_are_told_and_do_not_count():
    analysis = analysed(years_record("2003-07-14", "2006-06-10"))
    record = analysis.to_dict()
    years = {one["year"]: one for one in record["years"]}
    assert {year: (one["days"], one["whole"]) for year, one in years.items()} == {
        2003: (171, False),
        2004: (366, True),
        2005: (365, True),
        2006: (160, False),
    }
    assert record["year_to_year"]["whole_years"] == 2
    assert {record["year_to_year"][name] for name in ("worst_year", "best_year")} <= {2004, 2005}
    assert "2003 (part)" in str(analysis.at_level(2))


def test_a_single_year_has_no_spread():
    analysis = analysed(years_record("2005-03-01", "2006-03-01"))
    assert analysis.to_dict()["year_to_year"] is None
    assert "year by year" not in str(analysis.at_level(2))
    # Whole but for a week at its beginning.
    other = analysed(years_record("2005-01-08", "2006-01-01")).to_dict()["years"]
    assert [(one["days"], one["whole"]) for one in other] == [(358, True)]
