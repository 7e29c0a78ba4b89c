"""Calendar days against the standard library's calendar of a common year."""

import datetime
from datetime import date, timedelta
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import missions
import sizing
import studies
from missions import dates
from missions.dates import date_code, date_label, day_of_year, days_in_range, month_and_day

NEW_YEAR = date(2015, 1, 1)  # of a year of 365 days
ALL_DAYS = range(1, 366)

whole_days = st.integers(1, 365)


def test_all_days_agree_with_the_calendar():
    for day in ALL_DAYS:
        calendar = NEW_YEAR + timedelta(days=day - 1)
        assert day_of_year(f"{calendar:%m-%d}") == day
        assert month_and_day(day) == (calendar.month, calendar.day)
        assert date_code(day) == f"{calendar:%m-%d}"
        assert date_label(day) == f"{calendar.day} {calendar:%b}"


@pytest.mark.parametrize(
    ("texts", "day"),
    [
        (["7-1", "07-1", " 07-01 "], 182),
        (["12-31"], 365),
        (["2026-06-21", "21 Jun", "21 june", "21. June", "Jun 21", "21-Jun", "21Jun"], 172),
    ],
)
def test_dates_may_be_written_as_people_and_the_program_do(texts, day):
    assert [day_of_year(text) for text in texts] == [day] * len(texts)


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        (["02-29", "02-30", "2024-02-29"], "has days 01 to 28"),
        (["04-31", "31 Jun"], "has days 01 to 30"),
        (["01-00"], "has days 01 to 31"),
        (["13-01", "00-10", "31-12"], "month must be 01 to 12"),
        (["abc", "", "07", "07/01", "15-07-01", "21 Ju", "21 Juno", "Jun"], "MM-DD"),
        (["07-01-2015", "07-001", "-7-1", "07--1"], "MM-DD"),
        (["13-01"], "'13-01'"),
    ],
)
def test_other_texts_are_refused(texts, message):
    for text in texts:
        with pytest.raises(ValueError, match=message):
            day_of_year(text)


@given(whole_days, st.integers(-3, 3))
def test_days_beyond_the_year_wrap(day, years):
    assert date_code(day + 365 * years) == date_code(day)


@given(whole_days, whole_days)
def test_range_holds_consecutive_days_from_first_to_last(first, last):
    days = days_in_range(first, last)
    assert (days[0], days[-1]) == (first, last)
    assert len(set(days)) == len(days) <= 365
    for previous, following in pairwise(days):
        assert following == (1 if previous == 365 else previous + 1)
    assert days_in_range(first, first) == [first]
    assert sorted(days_in_range(first, (first - 2) % 365 + 1)) == list(ALL_DAYS)


def test_days_are_read_however_they_are_given():
    for days in (
        ["06-21", "21 Dec", "2026-12-31"],
        pd.DatetimeIndex(["2024-06-21", "2024-12-21 08:00", "2023-12-31"]),
        pd.to_datetime(["2024-06-21", "2024-12-21", "2023-12-31"]).tz_localize("UTC"),
        np.array(["2024-06-21", "2024-12-21", "2023-12-31"], "datetime64[D]"),
        [datetime.date(2024, 6, 21), datetime.datetime(2024, 12, 21, 8), "12-31"],
        [172, 355, 365],
    ):
        assert dates.days_of_year(days).tolist() == [172, 355, 365]
    assert dates.days_of_year("03-01").tolist() == [60]
    assert dates.days_of_year(pd.Timestamp("2024-03-01")).tolist() == [60]  # of a leap year
    with pytest.raises(ValueError, match="month 02 has days 01 to 28"):
        dates.days_of_year(pd.DatetimeIndex(["2024-02-29"]))


def test_days_of_maps_seasons_and_scenarios_may_be_dates():
    aircraft = sizing.load_aircraft("atlantiksolar-as2")
    mission = missions.load_mission("rafz-july")
    index = pd.DatetimeIndex(["2026-06-21", "2026-09-21"])
    by_date, by_number = (
        studies.feasibility_map(aircraft, mission, latitudes=[40, 50], days=days)
        for days in (index, [172, 264])
    )
    xr.testing.assert_identical(by_date.drop_attrs(), by_number.drop_attrs())
    assert sizing.perpetual_days(aircraft, mission, 47.6, days=["06-21", "12-21"]).tolist() == [172]
    scenarios = missions.Scenarios(np.array([40.0, 50.0]), index)
    assert scenarios.label(1) == "50° N, 21 Sep"
    assert scenarios.day_of_year.tolist() == [172, 264]
