import numpy as np
import pytest
from weather_files import clear_record

from missions.library import load_mission
from missions.weather.files import mission_at_site
from missions.weather.record import Site
from sizing.day.record import weather_performance
from sizing.library import load_aircraft
from sizing.results.weather import WeatherAnalysis

AS2 = load_aircraft("atlantiksolar-as2")
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
